//! Generator of random models with an equilibrium: every joint is closed at the design position, and every part is held by an element with
//! stiffness in all directions.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::plain::{
    At, FORMS, Force, Frame, Function, Joint, M, Measure, Multi, Part, Plain, Train, V, about_x,
    about_y, about_z, euler, number, numbers,
};

/// Units of force: keyword and size in newtons.
const FORCES: [(&str, f64); 5] = [
    ("NEWTON", 1.0),
    ("KNEWTON", 1000.0),
    ("POUND_FORCE", 4.448_221_615_260_5),
    ("KILOGRAM_FORCE", 9.806_65),
    ("DYNE", 1e-5),
];
const MASSES: [(&str, f64); 4] = [
    ("KILOGRAM", 1.0),
    ("GRAM", 1e-3),
    ("POUND_MASS", 0.453_592_37),
    ("TONNE", 1e3),
];
const LENGTHS: [(&str, f64); 5] = [
    ("MILLIMETER", 1e-3),
    ("CENTIMETER", 1e-2),
    ("METER", 1.0),
    ("INCH", 0.0254),
    ("FOOT", 0.3048),
];
const TIMES: [(&str, f64); 3] = [("SECOND", 1.0), ("MILLISECOND", 1e-3), ("MINUTE", 60.0)];

/// A random deck, the commands that solve it, and the expected model in each solution.
pub struct Drawn {
    pub deck: String,
    pub commands: String,
    pub solutions: Vec<Plain>,
    /// Length of 100 mm in the unit of the deck.
    pub length: f64,
    /// Force of 1000 N in the unit of the deck.
    pub force: f64,
}

pub(super) struct Draw {
    pub(super) random: Pcg64,
    pub(super) length: f64,
    pub(super) force: f64,
    /// Frames of the parts at the design position.
    pub(super) places: Vec<Frame>,
    pub(super) markers: Vec<(usize, Frame)>,
    pub(super) marker_text: String,
    pub(super) joints: Vec<Joint>,
    pub(super) forces: Vec<Force>,
    pub(super) trains: Vec<Train>,
    pub(super) multis: Vec<Multi>,
    pub(super) statements: String,
    /// Statements of forces that a command redefines, with the new forces.
    pub(super) redefined: Vec<(String, Force)>,
    /// Marker pairs of joints that rotate about z.
    pub(super) hinges: Vec<(usize, usize)>,
    /// Floating markers, which have no position of their own.
    pub(super) floating: Vec<usize>,
    pub(super) count: [usize; 20],
}

/// Joints that a GEAR or COUPLER may connect.
pub(super) const GEARED: [&str; 3] = ["REVOLUTE", "TRANSLATIONAL", "CYLINDRICAL"];

pub(super) fn one<T: Copy>(random: &mut Pcg64, all: &[T]) -> T {
    all[random.random_range(0..all.len())]
}

impl Draw {
    /// Returns a random number from -1 to 1.
    pub(super) fn u(&mut self) -> f64 {
        self.random.random_range(-1.0..1.0)
    }

    pub(super) fn chance(&mut self, one_in: usize) -> bool {
        self.random.random_range(0..one_in) == 0
    }

    pub(super) fn vector(&mut self, size: f64) -> V {
        V::new(self.u(), self.u(), self.u()) * size
    }

    pub(super) fn turn(&mut self, size: f64) -> M {
        euler([self.u() * size, self.u() * size, self.u() * size])
    }

    pub(super) fn id(&mut self, kind: usize) -> usize {
        self.count[kind] += 1;
        self.count[kind]
    }

    /// Adds a marker to a part at a frame given in ground; its orientation is written in one of four forms.
    pub(super) fn marker(&mut self, part: usize, place: &Frame) -> usize {
        let local = place.seen_from(&self.places[part]);
        self.markers.push((part, local));
        let id = self.markers.len();
        let qp = numbers(local.p.as_slice());
        let orientation = self.orientation("P", &local);
        self.marker_text += &format!("MARKER/{id}, PART={}, QP={qp}{orientation}\n", part + 1);
        id - 1
    }

    /// Returns an orientation as REULER in radians or degrees, or as two points, one of them exact.
    fn orientation(&mut self, letter: &str, frame: &Frame) -> String {
        let R = frame.R;
        let angles = [
            R[(0, 2)].atan2(-R[(1, 2)]),
            R[(0, 2)].hypot(R[(1, 2)]).atan2(R[(2, 2)]),
            R[(2, 0)].atan2(R[(2, 1)]),
        ];
        let regular = R[(0, 2)].hypot(R[(1, 2)]) > 1e-3;
        let (x, z) = (R.column(0), R.column(2));
        let far = self.length;
        let points = |z: V, x: V| {
            format!(
                "\n, Z{letter}={}, X{letter}={}",
                numbers((frame.p + z).as_slice()),
                numbers((frame.p + x).as_slice())
            )
        };
        match self.random.random_range(0..4) {
            0 if regular => format!("\n, REULER={}", numbers(&angles)),
            1 if regular => {
                let degrees = angles.map(|angle| format!("{}D", number(angle.to_degrees())));
                format!("\n, REULER={}", degrees.join(", "))
            }
            2 if letter == "P" => points(z * far + x * (0.3 * far), x * (0.7 * far)) + ", USEXP",
            _ => points(z * far, x * far + z * (0.4 * far)),
        }
    }

    pub(super) fn any_marker(&mut self) -> usize {
        loop {
            let marker = self.random.random_range(0..self.markers.len());
            if !self.floating.contains(&marker) {
                return marker;
            }
        }
    }

    fn anywhere(&mut self) -> Frame {
        Frame {
            p: self.vector(2.0 * self.length),
            R: self.turn(3.0),
        }
    }

    /// Returns a random frame near a part, so that lever arms are short.
    pub(super) fn near(&mut self, part: usize) -> Frame {
        Frame {
            p: self.places[part].p + self.vector(self.length),
            R: self.turn(3.0),
        }
    }

    fn joint(&mut self, a: usize, b: usize) {
        let kinds = [
            "FIXED",
            "REVOLUTE",
            "REVOLUTE",
            "SPHERICAL",
            "SPHERICAL",
            "TRANSLATIONAL",
            "CYLINDRICAL",
            "PLANAR",
            "HOOKE",
            "UNIVERSAL",
            "CONVEL",
            "ATPOINT",
            "INLINE",
            "INPLANE",
            "ORIENTATION",
            "PARALLEL_AXES",
            "PERPENDICULAR",
            "SCREW",
            "DISTANCE",
            "RACKPIN",
        ];
        // Joints for gears and couplers are drawn more often.
        let kind = if self.chance(3) {
            one(&mut self.random, &GEARED)
        } else {
            one(&mut self.random, &kinds)
        };
        let j = self.near(b);
        let (s, t) = (self.u() * self.length, self.u());
        let pitch = 0.2 * self.length;
        let seen = match kind {
            "FIXED" => (V::zeros(), M::identity()),
            "REVOLUTE" => (V::zeros(), about_z(t)),
            "TRANSLATIONAL" => (V::z() * s, M::identity()),
            "CYLINDRICAL" => (V::z() * s, about_z(t)),
            "SCREW" => (V::z() * (pitch * t / std::f64::consts::TAU), about_z(t)),
            "PLANAR" => (V::new(s, 0.5 * s, 0.0), about_z(t)),
            "HOOKE" => (V::zeros(), about_y(t) * about_x(0.7 * t)),
            "UNIVERSAL" => (
                V::zeros(),
                about_z(t) * about_x(std::f64::consts::FRAC_PI_2) * about_z(2.0 * t),
            ),
            "PERPENDICULAR" => (
                self.vector(self.length),
                about_z(t) * about_x(std::f64::consts::FRAC_PI_2) * about_z(2.0 * t),
            ),
            "CONVEL" => {
                let axis = nalgebra::Unit::new_normalize(V::new(1.0, t, 0.0));
                let R = nalgebra::Rotation3::from_axis_angle(&axis, 0.8 * t);
                (V::zeros(), *R.matrix())
            }
            "SPHERICAL" | "ATPOINT" => (V::zeros(), self.turn(1.0)),
            "INLINE" => (V::z() * s, self.turn(1.0)),
            "INPLANE" => (V::new(s, 0.5 * s, 0.0), self.turn(1.0)),
            "ORIENTATION" => (self.vector(self.length), M::identity()),
            "PARALLEL_AXES" => (self.vector(self.length), about_z(t)),
            // xi points along zj if the pinion is not turned; its axis is across, to the precision of the deck.
            "RACKPIN" => {
                let across = about_z(3.0 * s / self.length) * V::x();
                let rest = M::from_columns(&[V::z(), across.cross(&V::z()), across]);
                let place = V::new(s, 0.5 * s, -0.5 * pitch * t);
                (place, rest * about_z(t))
            }
            _ => (V::new(1.0, 0.4 * t, t) * self.length, self.turn(1.0)),
        };
        let i = j.then(&Frame {
            p: seen.0,
            R: seen.1,
        });
        let value = match kind {
            "SCREW" | "RACKPIN" => pitch,
            "DISTANCE" => seen.0.norm(),
            _ => 0.0,
        };
        let (mi, mj) = (self.marker(a, &i), self.marker(b, &j));
        let markers = format!("I={}, J={}", mi + 1, mj + 1);
        let primitive = matches!(
            kind,
            "ATPOINT" | "INLINE" | "INPLANE" | "ORIENTATION" | "PARALLEL_AXES" | "PERPENDICULAR"
        );
        let (name, text) = match kind {
            "DISTANCE" => {
                let id = self.id(2);
                let distance = number(value);
                (
                    format!("GCON_{id}"),
                    format!(
                        "GCON/{id}, I={}, FUNCTION=DM({},{})-{distance}",
                        mi + 1,
                        mi + 1,
                        mj + 1
                    ),
                )
            }
            _ if primitive => {
                let id = self.id(1);
                (
                    format!("JPRIM_{id}"),
                    format!("JPRIM/{id}, {kind}, {markers}"),
                )
            }
            _ => {
                let id = self.id(0);
                let pitch = match kind {
                    "SCREW" => format!(", PITCH={}", number(pitch)),
                    "RACKPIN" => format!(", PD={}", number(pitch)),
                    _ => String::new(),
                };
                (
                    format!("JOINT_{id}"),
                    format!("JOINT/{id}, {kind}, {markers}{pitch}"),
                )
            }
        };
        self.statements += &(text + "\n");
        if matches!(kind, "REVOLUTE" | "CYLINDRICAL") {
            self.hinges.push((mi, mj));
        }
        self.joints.push(Joint {
            name,
            kind,
            i: mi,
            j: mj,
            value,
        });
    }

    /// Adds a motion to a joint that closes no loop.
    fn motion(&mut self) {
        let free: Vec<_> = self
            .joints
            .iter()
            .filter(|joint| matches!(joint.kind, "REVOLUTE" | "TRANSLATIONAL"))
            .cloned()
            .collect();
        if free.is_empty() {
            return;
        }
        let joint = &free[self.random.random_range(0..free.len())];
        let at = |m: usize| self.places[self.markers[m].0].then(&self.markers[m].1);
        let seen = at(joint.i).seen_from(&at(joint.j));
        let (kind, before, by) = match joint.kind {
            "REVOLUTE" => ("ROTATION", seen.R[(1, 0)].atan2(seen.R[(0, 0)]), 0.2),
            _ => ("SHIFT", seen.p.z, 0.1 * self.length),
        };
        let value = before + by * self.u();
        let id = self.id(3);
        let of = joint.name.replace("JOINT_", "");
        self.statements += &format!("MOTION/{id}, JOINT={of}, FUNCTION={}+TIME\n", number(value));
        let (i, j) = (joint.i, joint.j);
        self.joints.push(Joint {
            name: format!("MOTION_{id}"),
            kind,
            i,
            j,
            value,
        });
    }

    /// Returns a random function of a displacement or angle between two markers, with values of the order of `force`.
    pub(super) fn function(
        &mut self,
        i: usize,
        j: usize,
        force: f64,
        along_line: bool,
    ) -> Function {
        let names: &[_] = if along_line {
            &["DM"]
        } else {
            &["DX", "DY", "DZ", "AX", "AY", "AZ"]
        };
        let name = one(&mut self.random, names);
        let k = self.any_marker();
        let x = Measure { name, i, j, k };
        let at = At {
            now: self.frames(),
            before: Vec::new(),
        };
        let (here, scale) = match name {
            "AX" | "AY" | "AZ" => (x.value(&at), 1.0),
            _ => (x.value(&at), self.length),
        };
        let slope = 0.3 * force / scale;
        let x0 = here + 0.02 * scale * self.u();
        let q = vec![
            force * self.u(),
            -slope * (0.5 + 0.5 * self.u()),
            x0,
            force * self.u(),
            x0 + 0.3 * scale,
            force * self.u().abs() + force,
            slope / scale * (1.0 + 0.5 * self.u()),
            x0 + 0.05 * scale,
            0.5 * scale,
        ];
        let form = self.random.random_range(0..FORMS);
        Function { form, x, q }
    }

    pub(super) fn frames(&self) -> Vec<Frame> {
        let place = |(part, frame): &(usize, Frame)| self.places[*part].then(frame);
        self.markers.iter().map(place).collect()
    }
}

/// Returns the random model of a seed.
pub fn drawn(seed: u64) -> Drawn {
    let mut random = Pcg64::seed_from_u64(seed);
    let units = (
        one(&mut random, &FORCES),
        one(&mut random, &MASSES),
        one(&mut random, &LENGTHS),
        one(&mut random, &TIMES),
    );
    let ((force_word, newton), (mass_word, kilogram), (length_word, metre), (time_word, second)) =
        units;
    let mut draw = Draw {
        random,
        length: 0.1 / metre,
        force: 1000.0 / newton,
        places: vec![Frame {
            p: V::zeros(),
            R: M::identity(),
        }],
        markers: Vec::new(),
        marker_text: String::new(),
        joints: Vec::new(),
        forces: Vec::new(),
        trains: Vec::new(),
        multis: Vec::new(),
        statements: String::new(),
        redefined: Vec::new(),
        hinges: Vec::new(),
        floating: Vec::new(),
        count: [0; 20],
    };
    let count = draw.random.random_range(1..7);
    let mut parts = vec![Part { mass: 0.0, cm: 0 }];
    draw.marker(
        0,
        &Frame {
            p: V::zeros(),
            R: M::identity(),
        },
    );
    let mut text = String::from("PART/1, GROUND\n");
    for part in 1..=count {
        let mut place = draw.anywhere();
        if draw.chance(4) {
            place.R = M::identity();
        }
        draw.places.push(place);
        let size = draw.length;
        let at = Frame {
            p: place.p + draw.vector(0.5 * size),
            R: draw.turn(3.0),
        };
        let cm = draw.marker(part, &at);
        let mass = (10.0 + 9.0 * draw.u()) / kilogram;
        let inertia = 0.01 * mass * size * size;
        text += &format!(
            "PART/{}, QG={}{}\n, MASS={}, CM={}, IP={}\n",
            part + 1,
            numbers(place.p.as_slice()),
            draw.orientation("G", &place),
            number(mass),
            cm + 1,
            numbers(&[inertia, 1.1 * inertia, 1.2 * inertia])
        );
        parts.push(Part { mass, cm });
    }
    for part in 1..=count {
        let before = draw.random.random_range(0..part);
        if !draw.chance(4) {
            draw.joint(part, before);
        }
        let to = if draw.chance(2) { 0 } else { before };
        draw.holder(part, to);
    }
    if draw.chance(2) {
        // Closed loops.
        for _ in 0..draw.random.random_range(1..3) {
            let a = draw.random.random_range(1..=count);
            let b = (a + draw.random.random_range(1..=count)) % (count + 1);
            draw.joint(a, b);
        }
    } else {
        draw.motion();
    }
    // A MOTION, a gear and a coupler together would move one joint in two ways.
    let driven = draw.count[3] > 0;
    if !driven || draw.chance(2) {
        draw.gear();
    }
    if draw.trains.is_empty() || !driven {
        draw.coupler();
    }
    if draw.chance(4) {
        draw.multi_point(count);
    }
    for _ in 0..draw.random.random_range(1..5) {
        let a = draw.random.random_range(1..=count);
        let b = (a + draw.random.random_range(1..=count)) % (count + 1);
        draw.load(a, b);
    }
    let g = draw.turn(3.0) * V::z() * (9.806_65 * second * second / metre);
    // Force times UCF equals mass times acceleration.
    let ucf = kilogram * metre / (second * second) / newton;
    let deck = format!(
        "Random model {seed}\nUNITS/FORCE={force_word}, MASS={mass_word}, LENGTH={length_word}, TIME={time_word}\n{text}{}{}\
         ACCGRAV/IGRAV={}, JGRAV={}, KGRAV={}\nEQUILIBRIUM/ERROR=1E-10, IMBALANCE={}, MAXIT=100, TLIMIT={}\nRESULTS/FORMATTED, XRF\nEND\n",
        draw.marker_text,
        draw.statements,
        number(g.x),
        number(g.y),
        number(g.z),
        number(1e-9 * draw.force * draw.length.min(1.0)),
        number(0.2 * draw.length)
    );
    let mut commands = String::from("\nfile/model=model\nSIM/STAT\n");
    let plain = |forces: Vec<Force>, draw: &Draw| Plain {
        parts: parts
            .iter()
            .map(|part| Part {
                mass: part.mass,
                cm: part.cm,
            })
            .collect(),
        markers: draw.markers.clone(),
        joints: draw.joints.clone(),
        forces,
        trains: draw.trains.clone(),
        multis: draw.multis.clone(),
        design: draw.places.clone(),
        gravity: g * ucf,
    };
    let mut solutions = vec![plain(draw.forces.clone(), &draw)];
    if !draw.redefined.is_empty() {
        let mut forces = draw.forces.clone();
        for (said, force) in &draw.redefined {
            commands += said;
            commands.push('\n');
            for old in &mut forces {
                if old.name == force.name {
                    old.clone_from(force);
                }
            }
        }
        commands += "SIM/STAT\n";
        solutions.push(plain(forces, &draw));
    }
    commands += "STOP\n";
    Drawn {
        deck,
        commands,
        solutions,
        length: draw.length,
        force: draw.force,
    }
}
