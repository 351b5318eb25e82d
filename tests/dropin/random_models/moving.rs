//! A part on a BEAM and a FIELD with full damping matrices, driven by a VFORCE, a VTORQUE and a GFORCE that depend on its rates.
//!
//! At every output each element must follow its law, and the sum must satisfy the Newton-Euler equations.

use nalgebra::{Matrix6, Vector6};

use super::plain::{Frame, M, V, euler, number, numbers, six};
use crate::run::{Results, folder, mdi};

type V6 = Vector6<f64>;
type M6 = Matrix6<f64>;

/// Newton and kilogram with millimetres: force times this factor is mass times acceleration.
const UCF: f64 = 1000.0;
const LENGTH: f64 = 100.0;
const MASS: f64 = 4.0;
/// Moments of inertia about CM in its axes; the products are positive integrals.
const IP: [f64; 6] = [3e4, 4e4, 5e4, 1e3, -2e3, 1.5e3];

/// A moving frame: pose, velocity, angular velocity, acceleration and angular acceleration.
#[derive(Clone, Copy)]
struct Moving {
    at: Frame,
    v: V,
    w: V,
    a: V,
    b: V,
}

impl Moving {
    /// Returns a frame that is fixed in this one.
    fn then(&self, local: &Frame) -> Self {
        let r = self.at.R * local.p;
        Self {
            at: self.at.then(local),
            v: self.v + self.w.cross(&r),
            a: self.a + self.b.cross(&r) + self.w.cross(&self.w.cross(&r)),
            ..*self
        }
    }
}

/// Returns the wrench `-K (q - rest) - C q'` on I relative to a fixed J, as force and torque in ground axes.
fn linear(i: &Moving, j: &Frame, K: &M6, C: &M6, rest: &V6) -> (V, V) {
    let q = V6::from(six(&i.at.seen_from(j)));
    let (v, w) = (j.R.transpose() * i.v, j.R.transpose() * i.w);
    let rate = V6::new(v.x, v.y, v.z, w.x, w.y, w.z);
    let f = -(K * (q - rest)) - C * rate;
    (
        j.R * V::new(f[0], f[1], f[2]),
        j.R * V::new(f[3], f[4], f[5]),
    )
}

/// Returns a full matrix with a given diagonal.
fn full(diagonal: [f64; 6], mirrored: bool) -> M6 {
    M6::from_fn(|r, c| {
        let mean = (diagonal[r] * diagonal[c]).sqrt();
        let (low, high) = if mirrored {
            (r.min(c), r.max(c))
        } else {
            (r, c)
        };
        let share = 0.02 * (1.0 + low as f64) - 0.015 * high as f64;
        if r == c { mean } else { share * mean }
    })
}

/// Returns the stiffness matrix of a linear Timoshenko beam.
fn beam(area: f64, [ix, iy, iz]: [f64; 3], [e, g]: [f64; 2], [asy, asz]: [f64; 2]) -> M6 {
    let l = LENGTH;
    let (py, pz) = (
        12.0 * e * iz * asy / (g * area * l * l),
        12.0 * e * iy * asz / (g * area * l * l),
    );
    let mut K = M6::zeros();
    K[(0, 0)] = e * area / l;
    K[(1, 1)] = 12.0 * e * iz / (l.powi(3) * (1.0 + py));
    K[(2, 2)] = 12.0 * e * iy / (l.powi(3) * (1.0 + pz));
    K[(3, 3)] = g * ix / l;
    K[(4, 4)] = (4.0 + pz) * e * iy / (l * (1.0 + pz));
    K[(5, 5)] = (4.0 + py) * e * iz / (l * (1.0 + py));
    for (r, c, value) in [
        (1, 5, -6.0 * e * iz / (l * l * (1.0 + py))),
        (2, 4, 6.0 * e * iy / (l * l * (1.0 + pz))),
    ] {
        K[(r, c)] = value;
        K[(c, r)] = value;
    }
    K
}

#[test]
fn elements_with_rates_move_a_part_by_their_laws() {
    let turned = |p: [f64; 3], angles: [f64; 3]| Frame {
        p: V::from(p),
        R: euler(angles),
    };
    let part = turned([30.0, -20.0, 50.0], [0.4, 0.9, -0.3]);
    let cm = turned([10.0, -5.0, 8.0], [0.3, 0.4, 0.5]);
    let pushed = turned([-20.0, 30.0, 15.0], [1.1, 0.7, 0.2]);
    let (beam_j, field_j) = (
        turned([-60.0, 40.0, 20.0], [0.2, 0.3, 0.1]),
        turned([70.0, 10.0, -40.0], [-0.5, 1.2, 0.8]),
    );
    let rest = V6::new(LENGTH, 0.0, 0.0, 0.0, 0.0, 0.0);
    let field_rest = V6::new(1.0, -2.0, 0.5, 0.01, -0.02, 0.015);
    let (beam_i, field_i) = (
        beam_j.then(&turned([LENGTH + 1.0, 0.5, -0.7], [0.01, 0.02, -0.02])),
        field_j.then(&turned([0.6, -1.5, 0.4], [0.3, 0.01, -0.29])),
    );
    let (beam_i, field_i) = (beam_i.seen_from(&part), field_i.seen_from(&part));
    let K = beam(4e3, [6e6, 5e6, 7e6], [20.0, 8.0], [1.1, 1.2]);
    let C = full(std::array::from_fn(|k| 1e-3 * K[(k, k)]), true);
    let stiffness = [500.0, 700.0, 600.0, 5e6, 7e6, 6e6];
    let (field_K, field_C) = (
        full(stiffness, false),
        full(stiffness.map(|k| 8e-4 * k), false),
    );
    let upper: Vec<f64> = (0..6)
        .flat_map(|c| (0..=c).map(move |r| (r, c)))
        .map(|at| C[at])
        .collect();
    let marker = |id: usize, part: usize, frame: &Frame| {
        let (z, x) = (frame.R.column(2) * 50.0, frame.R.column(0) * 50.0);
        format!(
            "MARKER/{id}, PART={part}, QP={}\n, ZP={}\n, XP={}\n",
            numbers(frame.p.as_slice()),
            numbers((frame.p + z).as_slice()),
            numbers((frame.p + x).as_slice())
        )
    };
    let deck = format!(
        "moving\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n\
         PART/2, QG=30,-20,50, REULER=0.4,0.9,-0.3, MASS={MASS}, CM=20, IP={}\n\
         , VX=300, VY=-200, VZ=400, WX=2, WY=-3, WZ=4\n{}{}{}{}{}{}\
         BEAM/1, I=21, J=11, LENGTH={LENGTH}, AREA=4E3, IXX=6E6, IYY=5E6, IZZ=7E6, EMODULUS=20, GMODULUS=8, ASY=1.1, ASZ=1.2\n\
         , CMATRIX={}\n\
         FIELD/1, I=22, J=12, LENGTH={}\n, KMATRIX={}\n, CMATRIX={}\n\
         MARKER/31, PART=1, FLOATING\nMARKER/32, PART=1, FLOATING\nMARKER/33, PART=1, FLOATING\n\
         VFORCE/1, I=23, JFLOAT=31, RM=12, FX=-0.05*VX(23,1,11)\\FY=200*SIN(30*TIME)\\FZ=-0.04*VM(23,1)\n\
         VTORQUE/1, I=23, JFLOAT=32, RM=20, TX=-500*WX(23,1,12)\\TY=1E4*COS(20*TIME)\\TZ=-300*WM(23,1)\n\
         GFORCE/1, I=23, JFLOAT=33, RM=23, FX=2E-4*ACCY(23,1,11)\\FY=-0.03*VZ(23,1,20,23)\\FZ=0\\TX=0\\TY=0\\TZ=2*WDTZ(23,1,12)\n\
         ACCGRAV/KGRAV=-9806.65\nRESULTS/FORMATTED, XRF\nEND\n",
        numbers(&IP),
        marker(20, 2, &cm),
        marker(21, 2, &beam_i),
        marker(22, 2, &field_i),
        marker(23, 2, &pushed),
        marker(11, 1, &beam_j),
        marker(12, 1, &field_j),
        upper
            .iter()
            .map(|c| number(*c))
            .collect::<Vec<_>>()
            .join(",\n, "),
        numbers(field_rest.as_slice()),
        field_K
            .as_slice()
            .chunks(6)
            .map(numbers)
            .collect::<Vec<_>>()
            .join(",\n, "),
        field_C
            .as_slice()
            .chunks(6)
            .map(numbers)
            .collect::<Vec<_>>()
            .join(",\n, "),
    );
    let acf =
        "\nfile/model=moving\nINTEGRATOR/GSTIFF, ERROR=1E-8\nSIM/DYN, END=0.1, DTOUT=5E-4\nSTOP\n";
    let place = folder(&[("moving.adm", &deck), ("run.acf", acf)]);
    let ran = mdi(place.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{} {}", ran.stdout, ran.stderr);
    let results = Results::read_all(place.path(), "moving.res");
    let vector = |entity: &str, names: [&str; 3], k: usize| {
        V::from(names.map(|name| results.column(entity, name)[k]))
    };
    let times = results.column("time", "TIME");
    let steps: Vec<Moving> = (0..times.len())
        .map(|k| {
            let read = |names| vector("PART_2_XFORM", names, k);
            Moving {
                at: Frame {
                    p: read(["X", "Y", "Z"]),
                    R: euler(read(["PSI", "THETA", "PHI"]).into()),
                },
                v: read(["VX", "VY", "VZ"]),
                w: read(["WX", "WY", "WZ"]),
                a: read(["ACCX", "ACCY", "ACCZ"]),
                b: read(["WDX", "WDY", "WDZ"]),
            }
        })
        .collect();
    assert_eq!(steps.len(), 201);
    let tensor = M::new(
        IP[0], -IP[3], -IP[4], -IP[3], IP[1], -IP[5], -IP[4], -IP[5], IP[2],
    );
    let mut fastest = 0.0_f64;
    for (k, (time, body)) in times.iter().zip(&steps).enumerate() {
        let i = body.then(&pushed);
        let along = |frame: &Frame, k: usize, of: V| frame.R.column(k).dot(&of);
        let c = body.then(&cm);
        let zero = V::zeros();
        // Motion as seen from ground, which contains marker 23.
        let vforce = field_j.R
            * V::new(
                -0.05 * along(&beam_j, 0, i.v),
                200.0 * (30.0 * time).sin(),
                -0.04 * i.v.norm(),
            );
        let vtorque = c.at.R
            * V::new(
                -500.0 * along(&field_j, 0, i.w),
                1e4 * (20.0 * time).cos(),
                -300.0 * i.w.norm(),
            );
        // Velocity of I in the frame of its own part: the velocity relative to ground as carried along by the part.
        let seen = i.v - i.w.cross(&i.at.p);
        let gforce = i.at.R
            * V::new(
                2e-4 * along(&beam_j, 1, i.a),
                -0.03 * along(&c.at, 2, seen),
                0.0,
            );
        let gtorque = i.at.R * V::new(0.0, 0.0, 2.0 * along(&field_j, 2, i.b));
        let told = [
            (
                "BEAM_1",
                beam_i,
                linear(&body.then(&beam_i), &beam_j, &K, &C, &rest),
            ),
            (
                "FIELD_1",
                field_i,
                linear(
                    &body.then(&field_i),
                    &field_j,
                    &field_K,
                    &field_C,
                    &field_rest,
                ),
            ),
            ("VFORCE_1", pushed, (vforce, zero)),
            ("VTORQUE_1", pushed, (zero, vtorque)),
            ("GFORCE_1", pushed, (gforce, gtorque)),
        ];
        let weight = V::new(0.0, 0.0, -9806.65) * MASS / UCF;
        let (mut F, mut T) = (weight, zero);
        for (name, marker, (f, t)) in told {
            let off_f = (vector(name, ["FX", "FY", "FZ"], k) - f).norm();
            let off_t = (vector(name, ["TX", "TY", "TZ"], k) - t).norm();
            assert!(
                off_f < 1e-9 * (f.norm() + 100.0) && off_t < 1e-9 * (t.norm() + 1e4),
                "{name} at {time}: {off_f:e} of {f:?}, {off_t:e} of {t:?}"
            );
            F += f;
            T += t + (body.then(&marker).at.p - c.at.p).cross(&f);
        }
        let J = c.at.R * tensor * c.at.R.transpose();
        let spin = J * body.b + body.w.cross(&(J * body.w));
        let (off_f, off_t) = ((F - c.a * MASS / UCF).norm(), (T - spin / UCF).norm());
        assert!(
            off_f < 1e-8 * (F.norm() + 100.0),
            "{time}: {off_f:e} of {F:?}"
        );
        assert!(
            off_t < 1e-8 * (T.norm() + 1e4),
            "{time}: {off_t:e} of {T:?}"
        );
        fastest = fastest.max(body.w.norm());
    }
    // Velocities must be the slopes of positions, and accelerations the slopes of velocities, by Simpson's rule.
    let h = times[1] - times[0];
    for three in steps.windows(3) {
        let [a, b, c] = [three[0], three[1], three[2]];
        let moved = c.at.p - a.at.p - (a.v + 4.0 * b.v + c.v) * (h / 3.0);
        let sped = c.v - a.v - (a.a + 4.0 * b.a + c.a) * (h / 3.0);
        let spun = c.w - a.w - (a.b + 4.0 * b.b + c.b) * (h / 3.0);
        assert!(moved.norm() < 1e-4, "{moved:?}");
        assert!(sped.norm() < 0.2 && spun.norm() < 5e-3, "{sped:?} {spun:?}");
    }
    assert!(fastest > 5.0, "it hardly turns: {fastest}");
}
