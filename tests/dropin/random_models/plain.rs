//! The laws of the manual, implemented again as directly as possible and independent of the solver.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

pub type V = Vector3<f64>;
pub type M = Matrix3<f64>;

/// Position and axes; the columns of R are the axes.
#[derive(Clone, Copy)]
pub struct Frame {
    pub p: V,
    pub R: M,
}

impl Frame {
    /// Returns in global axes a frame that is given relative to this one.
    pub fn then(&self, other: &Self) -> Self {
        Self {
            p: self.p + self.R * other.p,
            R: self.R * other.R,
        }
    }

    /// Returns this frame relative to another one.
    pub fn seen_from(&self, other: &Self) -> Self {
        Self {
            p: other.R.transpose() * (self.p - other.p),
            R: other.R.transpose() * self.R,
        }
    }
}

pub fn about_x(a: f64) -> M {
    M::new(1.0, 0.0, 0.0, 0.0, a.cos(), -a.sin(), 0.0, a.sin(), a.cos())
}

pub fn about_y(a: f64) -> M {
    M::new(a.cos(), 0.0, a.sin(), 0.0, 1.0, 0.0, -a.sin(), 0.0, a.cos())
}

pub fn about_z(a: f64) -> M {
    M::new(a.cos(), -a.sin(), 0.0, a.sin(), a.cos(), 0.0, 0.0, 0.0, 1.0)
}

/// Returns the rotation matrix of body-fixed 3-1-3 angles.
pub fn euler(angles: [f64; 3]) -> M {
    about_z(angles[0]) * about_x(angles[1]) * about_z(angles[2])
}

/// Returns x, y, z and the projected angles of a relative frame.
pub fn six(seen: &Frame) -> [f64; 6] {
    let (p, R) = (seen.p, seen.R);
    [
        p.x,
        p.y,
        p.z,
        (-R[(1, 2)]).atan2(R[(2, 2)]),
        R[(0, 2)].atan2(R[(2, 2)]),
        R[(1, 0)].atan2(R[(0, 0)]),
    ]
}

/// Current frames of all markers, and their earlier frames at the design position and in the solutions since, for counting turns.
pub struct At {
    pub now: Vec<Frame>,
    pub before: Vec<Vec<Frame>>,
}

impl std::ops::Index<usize> for At {
    type Output = Frame;
    fn index(&self, marker: usize) -> &Frame {
        &self.now[marker]
    }
}

/// A measure of two markers in the axes of a third one: `DX(i, j, k)`. Angles have no third marker.
#[derive(Clone, Copy)]
pub struct Measure {
    pub name: &'static str,
    pub i: usize,
    pub j: usize,
    pub k: usize,
}

impl Measure {
    pub fn text(&self) -> String {
        let (i, j, k) = (self.i + 1, self.j + 1, self.k + 1);
        match self.name {
            "DM" | "AX" | "AY" | "AZ" => format!("{}({i},{j})", self.name),
            name => format!("{name}({i},{j},{k})"),
        }
    }

    pub fn value(&self, at: &At) -> f64 {
        let d = at[self.i].p - at[self.j].p;
        let angle = |k: usize| {
            let of = |at: &[Frame]| six(&at[self.i].seen_from(&at[self.j]))[k];
            let turn = std::f64::consts::TAU;
            let next = |before: f64, now: f64| now + turn * ((before - now) / turn).round();
            let along = at.before.iter().map(|at| of(at)).reduce(next);
            let now = of(&at.now);
            along.map_or(now, |before| next(before, now))
        };
        match self.name {
            "DX" => d.dot(&at[self.k].R.column(0)),
            "DY" => d.dot(&at[self.k].R.column(1)),
            "DZ" => d.dot(&at[self.k].R.column(2)),
            "DM" => d.norm(),
            "AX" => angle(3),
            "AY" => angle(4),
            "AZ" => angle(5),
            other => panic!("{other}"),
        }
    }
}

/// A function of the model. `x` is its argument, `q` holds its parameters.
#[derive(Clone)]
pub struct Function {
    pub form: usize,
    pub x: Measure,
    pub q: Vec<f64>,
}

/// Number of forms of functions.
pub const FORMS: usize = 12;

impl Function {
    pub fn constant(value: f64, x: Measure) -> Self {
        Self {
            form: 0,
            x,
            q: vec![value],
        }
    }

    /// Returns the function as written in a deck.
    pub fn text(&self) -> String {
        let (x, q) = (self.x.text(), &self.q);
        let n = |k: usize| number(q[k]);
        match self.form {
            0 => n(0),
            1 => format!("{}+{}*({x}-{})", n(0), bracketed(q[1]), bracketed(q[2])),
            2 => format!("STEP({x},{},{},{},{})", n(2), n(3), n(4), n(5)),
            3 => format!("STEP5({x},{},{},{},{})", n(2), n(3), n(4), n(5)),
            4 => format!("HAVSIN({x},{},{},{},{})", n(2), n(3), n(4), n(5)),
            5 => format!("POLY({x},{},{},{},{})", n(2), n(0), n(1), n(6)),
            6 => format!("IMPACT({x},0,{},{},1.7,{},0.1)", n(4), n(6), n(6)),
            7 => format!("BISTOP({x},0,{},{},{},1.3,{},0.1)", n(2), n(7), n(6), n(6)),
            8 => format!(
                "IF({x}-{}: {}*({x}-{}), 0, {}*({x}-{}))",
                bracketed(q[2]),
                n(1),
                bracketed(q[2]),
                bracketed(q[6] / 1000.0),
                bracketed(q[2])
            ),
            9 => format!(
                "{}*SIN(({x}-{})/{})+{}*EXP(-(({x}-{})/{})**2)",
                n(0),
                bracketed(q[2]),
                n(8),
                bracketed(q[3]),
                bracketed(q[2]),
                n(8)
            ),
            10 => format!(
                "MAX({},MIN({},{}*({x}-{})))-{}*TANH(({x}-{})/{})",
                n(3),
                n(5),
                n(1),
                bracketed(q[2]),
                bracketed(q[0]),
                bracketed(q[2]),
                n(8)
            ),
            _ => format!(
                "SQRT({}**2+({}*({x}-{}))**2)-ABS({})*ATAN2({x}-{},{})",
                bracketed(q[0]),
                n(1),
                bracketed(q[2]),
                n(3),
                bracketed(q[2]),
                n(8)
            ),
        }
    }

    pub fn value(&self, at: &At) -> f64 {
        let (x, q) = (self.x.value(at), &self.q);
        let step = |curve: fn(f64) -> f64| {
            let u = ((x - q[2]) / (q[4] - q[2])).clamp(0.0, 1.0);
            q[3] + (q[5] - q[3]) * curve(u)
        };
        let d = if self.form == 0 { 0.0 } else { x - q[2] };
        match self.form {
            0 => q[0],
            1 => q[0] + q[1] * d,
            2 => step(|u| u * u * (3.0 - 2.0 * u)),
            3 => step(|u| u.powi(3) * (10.0 + u * (6.0 * u - 15.0))),
            4 => step(|u| 0.5 * (1.0 - (std::f64::consts::PI * u).cos())),
            5 => q[0] + q[1] * d + q[6] * d * d,
            6 => q[6] * (q[4] - x).max(0.0).powf(1.7),
            7 => q[6] * ((q[2] - x).max(0.0).powf(1.3) - (x - q[7]).max(0.0).powf(1.3)),
            8 => (if d < 0.0 { q[1] } else { q[6] / 1000.0 }) * d,
            9 => q[0] * (d / q[8]).sin() + q[3] * (-(d / q[8]).powi(2)).exp(),
            10 => (q[1] * d).min(q[5]).max(q[3]) - q[0] * (d / q[8]).tanh(),
            _ => q[0].hypot(q[1] * d) - q[3].abs() * d.atan2(q[8]),
        }
    }
}

/// Formats a number with all its digits.
pub fn number(value: f64) -> String {
    format!("{value:?}").replace('e', "E")
}

fn bracketed(value: f64) -> String {
    format!("({})", number(value))
}

pub fn numbers(values: &[f64]) -> String {
    let all: Vec<String> = values.iter().map(|value| number(*value)).collect();
    all.join(", ")
}

/// Force law of an element on its markers.
#[derive(Clone)]
pub enum Law {
    /// Wrench -K q + F in axes of J, including the moment of the force about the deflected J; K by rows.
    Linear {
        k: Box<[[f64; 6]; 6]>,
        rest: [f64; 6],
        preload: [f64; 6],
    },
    /// Translational spring: k, length, preload.
    Spring([f64; 3]),
    /// Torsion spring: kt, angle, preload.
    Torsion([f64; 3]),
    Along(Function),
    /// Force along z of J, on I alone.
    Follower(Function),
    /// Torque about z of J; the flag says whether it also acts on J.
    Twist(Function, bool),
    /// Force and torque components in axes of a marker; the reaction acts on J's part at the position of I.
    Vector(usize, Box<[Option<Function>; 6]>),
}

#[derive(Clone)]
pub struct Force {
    /// Name in the results, such as `BUSHING_3`.
    pub name: String,
    pub i: usize,
    pub j: usize,
    pub law: Law,
}

impl Force {
    /// Returns force and torque on I at I, and on J at J or, for vector forces, at the position of I.
    pub fn wrenches(&self, at: &At) -> [(V, V); 2] {
        let (i, j) = (&at[self.i], &at[self.j]);
        let d = i.p - j.p;
        let none = (V::zeros(), V::zeros());
        match &self.law {
            Law::Linear { k, rest, preload } => {
                let q = six(&i.seen_from(j));
                let mut w = *preload;
                for row in 0..6 {
                    for column in 0..6 {
                        w[row] -= k[row][column] * (q[column] - rest[column]);
                    }
                }
                let F = j.R * V::new(w[0], w[1], w[2]);
                let T = j.R * V::new(w[3], w[4], w[5]);
                [(F, T), (-F, -T - d.cross(&F))]
            }
            Law::Spring([k, length, preload]) => {
                let F = d.normalize() * (-k * (d.norm() - length) + preload);
                [(F, V::zeros()), (-F, V::zeros())]
            }
            Law::Torsion([k, angle, preload]) => {
                let turned = six(&i.seen_from(j))[5];
                let T = j.R.column(2) * (-k * (turned - angle) + preload);
                [(V::zeros(), T), (V::zeros(), -T)]
            }
            Law::Along(function) => {
                let F = d.normalize() * function.value(at);
                [(F, V::zeros()), (-F, V::zeros())]
            }
            Law::Follower(function) => [(j.R.column(2) * function.value(at), V::zeros()), none],
            Law::Twist(function, reaction) => {
                let T = j.R.column(2) * function.value(at);
                let on_j = if *reaction { -T } else { V::zeros() };
                [(V::zeros(), T), (V::zeros(), on_j)]
            }
            Law::Vector(axes, functions) => {
                let value = |k: usize| functions[k].as_ref().map_or(0.0, |f| f.value(at));
                let R = at[*axes].R;
                let F = R * V::new(value(0), value(1), value(2));
                let T = R * V::new(value(3), value(4), value(5));
                [(F, T), (-F, -T)]
            }
        }
    }
}

/// A joint or another constraint.
#[derive(Clone)]
pub struct Joint {
    /// Name in the results, such as `JOINT_3`.
    pub name: String,
    pub kind: &'static str,
    pub i: usize,
    pub j: usize,
    /// PITCH, PD, or the value of a motion or distance.
    pub value: f64,
}

impl Joint {
    /// Returns the constraint equations for I relative to J (table of joints in the manual).
    pub fn equations(&self, seen: &Frame) -> Vec<f64> {
        let (d, R) = (seen.p, seen.R);
        let turned = R[(1, 0)].atan2(R[(0, 0)]);
        let (zx, zy) = (R[(0, 2)], R[(1, 2)]);
        match self.kind {
            "FIXED" => vec![d.x, d.y, d.z, zx, zy, R[(1, 0)]],
            "REVOLUTE" => vec![d.x, d.y, d.z, zx, zy],
            "SPHERICAL" | "ATPOINT" => vec![d.x, d.y, d.z],
            "TRANSLATIONAL" => vec![d.x, d.y, zx, zy, R[(1, 0)]],
            "CYLINDRICAL" => vec![d.x, d.y, zx, zy],
            "PLANAR" => vec![d.z, zx, zy],
            "HOOKE" => vec![d.x, d.y, d.z, R[(1, 0)]],
            "UNIVERSAL" => vec![d.x, d.y, d.z, R[(2, 2)]],
            "CONVEL" => vec![d.x, d.y, d.z, R[(1, 0)] - R[(0, 1)]],
            "SCREW" => vec![d.z - self.value * turned / std::f64::consts::TAU],
            "INLINE" => vec![d.x, d.y],
            "INPLANE" => vec![d.z],
            "ORIENTATION" => vec![zx, zy, R[(1, 0)]],
            "PARALLEL_AXES" => vec![zx, zy],
            "PERPENDICULAR" => vec![R[(2, 2)]],
            // I rolls on J: the direction of zj in axes of I gives the rotation; relative to I, the rack moves the opposite way.
            "RACKPIN" => {
                let zj = R.transpose() * V::z();
                vec![-d.z + 0.5 * self.value * zj.y.atan2(zj.x)]
            }
            "ROTATION" => vec![turned - self.value],
            "SHIFT" => vec![d.z - self.value],
            "DISTANCE" => vec![d.norm() - self.value],
            other => panic!("{other}"),
        }
    }

    /// Returns the fraction of a reaction on I (ground axes, at I) that does work in the motions allowed by the joint.
    ///
    /// Torques are weighted by `length`.
    pub fn works(&self, at: &At, (F, T): (V, V), length: f64) -> f64 {
        let (i, j) = (&at[self.i], &at[self.j]);
        let seen = i.seen_from(j);
        let count = self.equations(&seen).len();
        let step = 1e-5;
        let mut rows = DMatrix::zeros(6, count);
        for k in 0..6 {
            let near = |by: f64| {
                let mut moved = seen;
                if k < 3 {
                    moved.p[k] += by * length;
                } else {
                    moved.R = [about_x, about_y, about_z][k - 3](by) * moved.R;
                }
                DVector::from_vec(self.equations(&moved))
            };
            let by = (near(step) - near(-step)) / (2.0 * step);
            rows.set_row(k, &by.transpose());
        }
        let (f, t) = (j.R.transpose() * F, j.R.transpose() * T);
        let w = DVector::from_vec(vec![
            f.x * length,
            f.y * length,
            f.z * length,
            t.x,
            t.y,
            t.z,
        ]);
        let multipliers = rows
            .clone()
            .svd(true, true)
            .solve(&w, 1e-9)
            .expect("both factors");
        (&w - rows * multipliers).norm() / w.norm().max(f64::MIN_POSITIVE)
    }
}

/// Displacement of a joint in a COUPLER or GEAR, about or along z of J, times a scale.
#[derive(Clone, Copy)]
pub struct Term {
    pub i: usize,
    pub j: usize,
    pub turns: bool,
    pub scale: f64,
}

impl Term {
    pub fn value(&self, at: &[Frame]) -> f64 {
        let seen = six(&at[self.i].seen_from(&at[self.j]));
        self.scale * seen[if self.turns { 5 } else { 2 }]
    }
}

/// A COUPLER or GEAR: joint displacements with a constant sum.
#[derive(Clone)]
pub struct Train {
    /// Name in the results, such as `COUPLER_3`.
    pub name: String,
    pub terms: Vec<Term>,
    pub value: f64,
}

impl Train {
    /// Returns force and torque on the I of each term, and the part of the reported reaction that is not along or about the axis of the
    /// first joint.
    ///
    /// `(F, T)` is the reaction on the I of the first joint in the results. The reactions do no work in total, so they are proportional to
    /// the scales.
    pub fn wrenches(&self, at: &[Frame], (F, T): (V, V)) -> (Vec<(V, V)>, (V, V)) {
        let first = |term: &&Term| term.i == self.terms[0].i;
        let axis = |term: &Term| V::from(at[term.j].R.column(2));
        // Reaction per unit of scale.
        let of = |term: &Term| axis(term).dot(if term.turns { &T } else { &F }) / term.scale;
        let largest = self.terms.iter().filter(first);
        let largest = largest.max_by(|a, b| a.scale.abs().total_cmp(&b.scale.abs()));
        let multiplier = of(largest.expect("at least one"));
        let each = |term: &Term| {
            let along = axis(term) * (multiplier * term.scale);
            let (force, torque) = (
                along * f64::from(!term.turns),
                along * f64::from(term.turns),
            );
            (force, torque)
        };
        let all: Vec<_> = self.terms.iter().map(each).collect();
        let mut left = (F, T);
        for (term, on) in self.terms.iter().zip(&all) {
            if first(&term) {
                left = (left.0 - on.0, left.1 - on.1);
            }
        }
        (all, left)
    }
}

/// A linear force between several markers I and one J: -K q + F in axes of J; K by rows.
#[derive(Clone)]
pub struct Multi {
    /// Name in the results, such as `NFORCE_3`.
    pub name: String,
    pub i: Vec<usize>,
    pub j: usize,
    pub k: Vec<Vec<f64>>,
    pub rest: Vec<f64>,
    pub preload: Vec<f64>,
}

impl Multi {
    /// Returns force and torque on each I.
    pub fn wrenches(&self, at: &[Frame]) -> Vec<(V, V)> {
        let j = &at[self.j];
        let q: Vec<f64> = self
            .i
            .iter()
            .flat_map(|i| six(&at[*i].seen_from(j)))
            .collect();
        let row = |(row, preload): (&Vec<f64>, &f64)| {
            let each = row.iter().zip(q.iter().zip(&self.rest));
            preload - each.map(|(k, (q, rest))| k * (q - rest)).sum::<f64>()
        };
        let w: Vec<f64> = self.k.iter().zip(&self.preload).map(row).collect();
        let each = |w: &[f64]| {
            (
                j.R * V::new(w[0], w[1], w[2]),
                j.R * V::new(w[3], w[4], w[5]),
            )
        };
        w.chunks(6).map(each).collect()
    }
}

pub struct Part {
    pub mass: f64,
    pub cm: usize,
}

/// A model for the independent laws. Part 0 is ground.
pub struct Plain {
    pub parts: Vec<Part>,
    /// Part of each marker, and its frame relative to the part.
    pub markers: Vec<(usize, Frame)>,
    pub joints: Vec<Joint>,
    pub forces: Vec<Force>,
    pub trains: Vec<Train>,
    pub multis: Vec<Multi>,
    /// Frames of the parts in the dataset, from which turns are counted in the first solution.
    pub design: Vec<Frame>,
    /// Weight per unit of mass.
    pub gravity: V,
}
