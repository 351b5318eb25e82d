//! Independence of part frames: the same linkage with part frames at the origin, at the centres of mass, and at random positions.

use std::fmt::Write;

use admire_solver::mechanics::{Pose, Vec3, exp};
use admire_solver::statics::{Report, Softest, SolveError, Solver, StaticSettings};
use admire_solver::system::System;

use crate::common::shared;
use crate::deck;

/// Generator of reproducible numbers between 0 and 1.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn vector(&mut self, size: f64) -> Vec3 {
        Vec3::from_fn(|_, _| self.between(-size, size))
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vector(1.0);
            if (0.1..1.0).contains(&v.norm()) {
                return v.normalize();
            }
        }
    }

    /// Returns a direction perpendicular to another one.
    fn across(&mut self, other: &Vec3) -> Vec3 {
        loop {
            let v = self.direction().cross(other);
            if v.norm() > 0.2 {
                return v.normalize();
            }
        }
    }
}

/// A linkage, with all positions in ground.
#[derive(Default)]
struct Linkage {
    /// Parts: mass, centre of mass, and moments of inertia. A massless part has no CM.
    parts: Vec<Option<(f64, Vec3, [f64; 3])>>,
    /// Markers: part, position, and direction of z; part 0 is ground.
    markers: Vec<(usize, Vec3, Vec3)>,
    /// Statements, in which `{0}` stands for the first marker of the statement, and so on.
    statements: String,
}

impl Linkage {
    /// Adds a part, with or without mass.
    fn part(&mut self, mass: Option<(f64, Vec3, [f64; 3])>) -> usize {
        self.parts.push(mass);
        self.parts.len()
    }

    fn marker(&mut self, part: usize, place: Vec3, z: Vec3) -> usize {
        self.markers.push((part, place, z));
        100 + self.markers.len()
    }

    /// Adds a joint or an element between two parts at one position.
    fn between(&mut self, (i, j): (usize, usize), place: Vec3, z: (Vec3, Vec3), what: &str) {
        let (i, j) = (self.marker(i, place, z.0), self.marker(j, place, z.1));
        let id = j;
        let (kind, rest) = what.split_once(',').unwrap();
        writeln!(self.statements, "{kind}/{id},{rest}, I={i}, J={j}").unwrap();
    }

    fn spring(&mut self, (i, at): (usize, Vec3), (j, to): (usize, Vec3), k: f64, length: f64) {
        let z = Vec3::z();
        let (i, j) = (self.marker(i, at, z), self.marker(j, to, z));
        writeln!(
            self.statements,
            "SPRINGDAMPER/{i}, TRANSLATION, I={i}, J={j}, K={k}, LENGTH={length}"
        )
        .unwrap();
    }

    /// Returns the deck with the parts in these frames.
    fn written(&self, frames: &[Pose], gravity: Vec3) -> String {
        let mut out = String::from(
            "frames\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\n",
        );
        let three = |v: Vec3| format!("{},{},{}", v.x, v.y, v.z);
        let local = |part: usize, place: &Vec3| {
            let frame = frames.get(part.wrapping_sub(1));
            frame.map_or(*place, |frame| frame.R.transpose() * (place - frame.p))
        };
        for (k, mass) in self.parts.iter().enumerate() {
            let id = k + 2;
            write!(out, "PART/{id}, QG={}", three(frames[k].p)).unwrap();
            let R = frames[k].R;
            write!(
                out,
                ", ZG={}, XG={}",
                three(frames[k].p + R.column(2) * 100.0),
                three(frames[k].p + R.column(0) * 100.0)
            )
            .unwrap();
            let Some((mass, cm, [x, y, z])) = mass else {
                out.push('\n');
                continue;
            };
            writeln!(out, ", MASS={mass}, CM={id}, IP={x},{y},{z}").unwrap();
            // The axes of the CM marker are those of ground.
            let at = |v: Vec3| three(local(k + 1, &v));
            writeln!(
                out,
                "MARKER/{id}, PART={id}, QP={}, ZP={}, XP={}",
                at(*cm),
                at(cm + Vec3::z() * 100.0),
                at(cm + Vec3::x() * 100.0)
            )
            .unwrap();
        }
        for (k, (part, place, z)) in self.markers.iter().enumerate() {
            let z_point = local(*part, &(place + z * 100.0));
            let across = z.cross(&Vec3::new(0.36, -0.48, 0.8)).normalize();
            let x_point = local(*part, &(place + across * 100.0));
            writeln!(
                out,
                "MARKER/{}, PART={}, QP={}, ZP={}, XP={}",
                101 + k,
                part + 1,
                three(local(*part, place)),
                three(z_point),
                three(x_point)
            )
            .unwrap();
        }
        let [x, y, z] = gravity.into();
        write!(
            out,
            "{}ACCGRAV/IGRAV={x}, JGRAV={y}, KGRAV={z}\nEQUILIBRIUM/ERROR=1E-10, IMBALANCE=1E-7, MAXIT=60\nEND\n",
            self.statements
        )
        .unwrap();
        out
    }

    fn mass(draw: &mut Draw, at: Vec3) -> Option<(f64, Vec3, [f64; 3])> {
        let mass = draw.between(0.5, 5.0);
        let moments = [0.0; 3].map(|_: f64| draw.between(1.0, 1.5) * mass * 900.0);
        Some((mass, at, moments))
    }

    fn drawn(draw: &mut Draw, kind: usize) -> Self {
        let mut new = Self::default();
        let reach = 250.0;
        match kind % 5 {
            // A hanging chain of one to three links, rotated away from equilibrium.
            0 => {
                let mut at = draw.vector(1000.0);
                let mut before = 0;
                for k in 0..=(kind / 5 % 3) {
                    let z = draw.across(&Vec3::z());
                    let turn = exp(&(z * draw.between(-0.7, 0.7)));
                    let end = at + turn * (-Vec3::z() * draw.between(100.0, reach));
                    let middle = at + (end - at) * draw.between(0.4, 1.0);
                    let mass = Self::mass(draw, middle);
                    let link = new.part(mass);
                    let joint = if k == 1 {
                        "JOINT,UNIVERSAL"
                    } else {
                        "JOINT,REVOLUTE"
                    };
                    let other = if k == 1 {
                        z.cross(&(end - at)).normalize()
                    } else {
                        z
                    };
                    new.between((link, before), at, (z, other), joint);
                    (before, at) = (link, end);
                }
            }
            // An arm on a spring.
            1 => {
                let at = draw.vector(1000.0);
                let z = draw.direction();
                let arm = draw.across(&z) * draw.between(100.0, reach);
                let middle = at + arm * draw.between(0.3, 0.8);
                let mass = Self::mass(draw, middle);
                let link = new.part(mass);
                new.between((link, 0), at, (z, z), "JOINT,REVOLUTE");
                let to = at + arm * 0.6 + draw.direction() * 200.0;
                let k = draw.between(1.0, 20.0);
                new.spring((link, at + arm), (0, to), k, draw.between(150.0, 250.0));
            }
            // A spatial four-bar linkage: hinge, ball, universal joint, hinge.
            2 => {
                let a = draw.vector(1000.0);
                let (x, z) = (draw.across(&Vec3::z()), Vec3::z());
                let b = a + z * draw.between(80.0, 120.0) + x * draw.between(-30.0, 30.0);
                let c = b + x * draw.between(200.0, 250.0) + draw.vector(20.0);
                let d = a + x * draw.between(200.0, 250.0) + draw.vector(20.0);
                let y = z.cross(&x);
                let [one, two, three] = [(a, b), (b, c), (c, d)].map(|(from, to)| {
                    let mass = Self::mass(draw, (from + to) * 0.5);
                    new.part(mass)
                });
                new.between((one, 0), a, (y, y), "JOINT,REVOLUTE");
                new.between((two, one), b, (y, y), "JOINT,SPHERICAL");
                new.between(
                    (two, three),
                    c,
                    (y, y.cross(&(c - b)).normalize()),
                    "JOINT,UNIVERSAL",
                );
                new.between((three, 0), d, (y, y), "JOINT,REVOLUTE");
                let to = b + x * draw.between(-150.0, -80.0);
                new.spring((one, b), (0, to), draw.between(2.0, 20.0), 100.0);
            }
            // A body on bushings, with or without mass, and an arm on it.
            3 => {
                let at = draw.vector(1000.0);
                let mass = if draw.next() < 0.5 {
                    Self::mass(draw, at)
                } else {
                    None
                };
                let body = new.part(mass);
                for _ in 0..3 {
                    let place = at + draw.vector(200.0);
                    let z = draw.direction();
                    let k = draw.between(50.0, 500.0);
                    let what = format!("BUSHING,K={k},{},{k}, KT=1E5,2E5,1E5", 0.5 * k);
                    new.between((body, 0), place, (z, z), &what);
                }
                let end = at + draw.direction() * reach;
                let mass = Self::mass(draw, end);
                let arm = new.part(mass);
                let z = draw.across(&(end - at));
                new.between((arm, body), at, (z, z), "JOINT,REVOLUTE");
                new.between((arm, body), at, (z, z), "BUSHING,K=1,1,1, KT=1E6,1E6,1E6");
            }
            // A slider on a rotating arm.
            _ => {
                let at = draw.vector(1000.0);
                let z = draw.across(&Vec3::z());
                let along = draw.across(&z);
                let mass = Self::mass(draw, at + along * 50.0);
                let arm = new.part(mass);
                let mass = Self::mass(draw, at + along * 200.0);
                let slider = new.part(mass);
                new.between((arm, 0), at, (z, z), "JOINT,REVOLUTE");
                let place = at + along * 150.0;
                new.between((slider, arm), place, (along, along), "JOINT,TRANSLATIONAL");
                let k = draw.between(2.0, 10.0);
                new.spring((slider, place), (arm, at), k, 150.0);
                let to = place + draw.vector(100.0);
                new.spring((arm, at + along * 100.0), (0, to), k, 100.0);
            }
        }
        new
    }

    /// Returns the frames of all parts: at the origin as in Adams/View, at the centres of mass, or at random positions.
    fn frames(&self, draw: &mut Draw, which: usize) -> Vec<Pose> {
        let frames = self.parts.iter().map(|mass| match which {
            0 => Pose::identity(),
            1 => Pose {
                p: mass.map_or_else(Vec3::zeros, |mass| mass.1),
                ..Pose::identity()
            },
            _ => Pose {
                p: draw.vector(2500.0),
                R: exp(&draw.vector(2.0)),
            },
        });
        frames.collect()
    }
}

fn inverse(pose: &Pose) -> Pose {
    let R = pose.R.transpose();
    Pose {
        p: -(R * pose.p),
        R,
    }
}

/// Solves a deck with the settings of its EQUILIBRIUM.
fn solved(
    deck: &str,
) -> (
    System,
    Result<(Report, admire_solver::system::State), SolveError>,
) {
    let model = deck::read(deck);
    let system = System::compile(&model).value;
    let mut state = system.state();
    let settings = StaticSettings::from(system.settings());
    let result = Solver::new(&system).solve(&system, &system.parameters(), &mut state, &settings);
    (system, result.map(|report| (report, state)))
}

const GRAVITY: Vec3 = Vec3::new(0.0, 0.0, -9806.65);

#[test]
fn two_hundred_linkages_do_not_depend_on_the_frames_of_their_parts() {
    let mut draw = Draw(7);
    let (mut failed, mut most_apart, mut shown) = (0, 0.0_f64, String::new());
    for kind in 0..200 {
        let linkage = Linkage::drawn(&mut draw, kind);
        let mut first: Option<Option<(usize, Vec<Pose>)>> = None;
        for which in 0..4 {
            let frames = linkage.frames(&mut draw, which);
            let deck = linkage.written(&frames, GRAVITY);
            let (_, result) = solved(&deck);
            let found = match &result {
                Ok((report, state)) => {
                    assert!(report.iterations <= 60, "{kind}: {}", report.iterations);
                    // Displacement of the linkage: pose of ground, then the motion of each part relative to its initial frame.
                    let now = frames.iter().zip(&state.poses[1..]);
                    let now = now.map(|(frame, pose)| pose.compose(&inverse(frame)));
                    Some((report.iterations, now.collect()))
                }
                Err(SolveError::NotConverged { history, .. }) => {
                    assert!(history.len() <= 60, "{kind}: {}", history.len());
                    None
                }
                Err(other) => panic!("{kind}: {other}\n{deck}"),
            };
            match (&first, &found) {
                (None, _) => {
                    failed += usize::from(found.is_none());
                    first = Some(found);
                }
                (Some(Some((fewest, expected))), Some((iterations, now))) => {
                    let (few, many) = (fewest.min(iterations), fewest.max(iterations));
                    _ = writeln!(shown, "{kind} {which}: {fewest} {iterations}");
                    assert!(
                        many <= &(2 * few),
                        "{kind} {which}: {few} and {many} iterations"
                    );
                    let at = |poses: &[Pose], part: usize| {
                        let centre = linkage.parts[part].map_or_else(Vec3::zeros, |mass| mass.1);
                        poses[part].point(&centre)
                    };
                    for part in 0..now.len() {
                        let shift = (at(now, part) - at(expected, part)).norm();
                        let turn = (now[part].R - expected[part].R).amax();
                        most_apart = most_apart.max(shift / 1000.0).max(turn);
                        assert!(
                            shift / 1000.0 < 1e-9 && turn < 1e-9,
                            "{kind} {which}: {shift:e} {turn:e}\n{deck}"
                        );
                    }
                }
                (Some(None), None) => {}
                (Some(before), now) => panic!(
                    "{kind} {which}: {:?} and {:?}\n{deck}",
                    before.as_ref().map(|b| b.0),
                    now.as_ref().map(|b| b.0)
                ),
            }
        }
    }
    println!("{shown}{failed} without an equilibrium, at most {most_apart:e} apart");
    assert!(failed <= 10, "{failed}");
}

/// Checks that a pendulum hangs from every start below 85 degrees, wherever its pivot and its frame are.
#[test]
fn hanging_pendulums_hang() {
    let mut draw = Draw(3);
    let mut wrong = Vec::new();
    for k in 0..400 {
        let start = f64::to_radians([10.0, 25.0, 45.0, 70.0, 84.9][k % 5]);
        let mut linkage = Linkage::default();
        let pivot = draw.vector(3000.0);
        let z = draw.across(&Vec3::z());
        let arm = exp(&(z * start)) * Vec3::new(0.0, 0.0, -draw.between(50.0, 2000.0));
        let mass = Linkage::mass(&mut draw, pivot + arm);
        let link = linkage.part(mass);
        linkage.between((link, 0), pivot, (z, z), "JOINT,REVOLUTE");
        let frames = linkage.frames(&mut draw, k / 5 % 3);
        // Long arms need more than the usual 25 iterations, because TLIMIT limits the steps. Without a stated MAXIT, more iterations are
        // allowed.
        let stated = ["", ", MAXIT=250"][k % 2];
        let deck = linkage
            .written(&frames, GRAVITY)
            .replace(", MAXIT=60", stated);
        let (system, result) = solved(&deck);
        let (report, state) = result.unwrap_or_else(|error| panic!("{k}: {error}\n{deck}"));
        let down = inverse(&frames[0]).point(&(pivot + arm));
        let now = state.poses[1].point(&down) - pivot;
        if (now.z + arm.norm()).abs() > 1e-6 * arm.norm() {
            wrong.push((k, start.to_degrees(), report.iterations, now.z / arm.norm()));
        }
        let softest = Softest::of(&system, &system.parameters(), &state).unwrap();
        assert_eq!(softest.unwrap().stiffness > 0.0, now.z < 0.0);
    }
    assert!(wrong.is_empty(), "{} of 400: {wrong:?}", wrong.len());
}

/// Checks an arm on a spring, with its frame at its pivot and 1 m above the pivot.
#[test]
fn an_arm_on_a_spring_is_where_it_is() {
    let mut turned = Vec::new();
    for name in ["t3-arm-frame-at-pivot", "t3-arm-frame-1m-above"] {
        let Some(path) = shared(&format!("reference/faults/{name}.adm.txt")) else {
            return;
        };
        let text = std::fs::read_to_string(path).unwrap();
        let (system, result) = solved(&text);
        let (report, state) = result.unwrap();
        let softest = Softest::of(&system, &system.parameters(), &state).unwrap();
        assert!(softest.unwrap().stiffness > 0.0, "{name}");
        let x = state.poses[1].R.column(0).into_owned();
        println!("{name}: {} iterations", report.iterations);
        turned.push(x.y.atan2(x.x).to_degrees());
    }
    // Equilibrium that is found with the frame at the pivot.
    assert!((turned[0] - 50.7).abs() < 0.05, "{turned:?}");
    assert!((turned[1] - turned[0]).abs() < 1e-3, "{turned:?}");
}

/// Checks a pendulum that starts 25 degrees from hanging. Its part frame is at the global origin, the default of models.
#[test]
fn a_pendulum_in_the_frame_of_ground_hangs() {
    let (system, result) = solved(
        "t\nUNITS/FORCE=NEWTON,MASS=KILOGRAM,LENGTH=METER,TIME=SECOND\nPART/1,GROUND\nMARKER/1,PART=1,QP=0,12,0\n\
         PART/2,MASS=1,CM=3,IP=1,1,1\nMARKER/2,PART=2,QP=0,12,0\nMARKER/3,PART=2,QP=4.1945,2.9222,0\n\
         JOINT/1,REVOLUTE,I=2,J=1\nACCGRAV/JGRAV=-9.80665\nEND\n",
    );
    let (report, state) = result.unwrap();
    let cm = state.poses[1].point(&Vec3::new(4.1945, 2.9222, 0.0));
    let arm = Vec3::new(4.1945, 2.9222 - 12.0, 0.0).norm();
    assert!(
        (cm - Vec3::new(0.0, 12.0 - arm, 0.0)).norm() < 1e-3 * arm,
        "{cm}"
    );
    assert!(report.iterations <= 12, "{}", report.iterations);
    let softest = Softest::of(&system, &system.parameters(), &state).unwrap();
    assert!(softest.unwrap().stiffness > 0.0);
}
