use std::fmt::Write as _;

use admire_solver::mechanics::{Mat3, Pose, Vec3, psi_theta_phi};

use super::deck_text::{both_sides, broken, identifier, list, named, number, signed};
use super::joint::Joint;
use super::law::{AxisLaw, Law};
use super::mechanism::{Mechanism, Role};
use super::record::Record;
use super::settings::{
    DEFAULT_INERTIA_KG_M2, DEFAULT_STIFFNESS_N_PER_MM, DEFAULT_TORSION_NM_PER_RAD, LEAST_MASS_KG,
};

/// A deck made from a mechanism. Its loads are functions of time: the state with index k is at time k.
#[derive(Clone, Debug)]
pub struct Deck {
    /// Text of the dataset.
    pub text: String,
    /// Commands that solve all states.
    pub commands: String,
    /// Functions that differ from state to state: loads and prescribed motions.
    pub drives: Vec<Drive>,
    /// For each body of the record, its id in the deck.
    pub parts: Vec<u32>,
    /// Index of each element of the record that the deck contains, and its address in the deck, for example `BUSHING/3`.
    pub addresses: Vec<(usize, String)>,
}

/// A function of the deck with one value per state.
#[derive(Clone, PartialEq, Debug)]
pub struct Drive {
    /// Name of the load column, for example `til_wheel_fx`.
    pub name: String,
    /// Address of the function, for example `GFORCE/1.FX`.
    pub address: String,
    /// Value in every state.
    pub values: Vec<f64>,
}

/// Writes the deck of a mechanism.
pub fn deck(record: &Record, mechanism: &Mechanism) -> Deck {
    let mut writer = Writer {
        record,
        mechanism,
        text: String::new(),
        splines: String::new(),
        next: Next::default(),
        drives: Vec::new(),
        addresses: Vec::new(),
        connectors: String::new(),
        markers: vec![String::new(); record.bodies.len()],
    };
    writer.elements();
    writer.finish()
}

/// Last id used for each kind of statement.
#[derive(Clone, Copy, Default, Debug)]
struct Next {
    marker: u32,
    spline: u32,
    joint: u32,
    motion: u32,
    bushing: u32,
    spring: u32,
    line_force: u32,
    vector_force: u32,
}

struct Writer<'w> {
    record: &'w Record,
    mechanism: &'w Mechanism,
    text: String,
    splines: String,
    connectors: String,
    /// Markers of each body.
    markers: Vec<String>,
    next: Next,
    drives: Vec<Drive>,
    addresses: Vec<(usize, String)>,
}

impl Writer<'_> {
    fn marker(&mut self, body: usize, name: &str, frame: &Pose) -> u32 {
        self.next.marker += 1;
        let id = self.next.marker;
        let text = &mut self.markers[body];
        let angles = psi_theta_phi(&frame.R);
        *text += &named(name);
        let _ = writeln!(
            text,
            "MARKER/{id}\n, PART = {}\n, QP = {}\n, REULER = {}",
            body + 1,
            list(frame.p.iter().copied()),
            list(angles.into_iter()),
        );
        id
    }

    fn floating(&mut self, body: usize) -> u32 {
        self.next.marker += 1;
        let id = self.next.marker;
        let _ = writeln!(
            self.markers[body],
            "MARKER/{id}\n, PART = {}\n, FLOATING",
            body + 1
        );
        id
    }

    fn spline(&mut self, points: &[(f64, f64)]) -> u32 {
        self.next.spline += 1;
        let id = self.next.spline;
        let _ = writeln!(
            self.splines,
            "SPLINE/{id}\n, LINEAR_EXTRAPOLATE\n, X = {}\n, Y = {}",
            list(points.iter().map(|p| p.0)),
            list(points.iter().map(|p| p.1)),
        );
        id
    }

    /// Returns a function with these values at the times 0, 1, 2 ...
    fn over_time(&mut self, values: &[f64]) -> String {
        let same = values.iter().all(|v| *v == values[0]);
        if same {
            return number(values[0]);
        }
        let mut points: Vec<(f64, f64)> = values
            .iter()
            .enumerate()
            .map(|(k, v)| (k as f64, *v))
            .collect();
        while points.len() < 4 {
            let (time, value) = points[points.len() - 1];
            points.push((time + 1.0, value));
        }
        let id = self.spline(&points);
        format!("AKISPL(TIME,0,{id})")
    }

    fn elements(&mut self) {
        for member in &self.mechanism.members {
            let element = &self.record.elements[member.connection.element];
            let name = element.name.as_str();
            let (i, j) = (member.connection.i, member.connection.j);
            let address = match &member.role {
                Role::Joint(joint) => self.joint(name, joint, i, j),
                Role::Motion {
                    i: frame_i,
                    j: frame_j,
                    turns,
                    values,
                } => self.motion(name, (i, frame_i), (j, frame_j), *turns, values),
                Role::Bushing {
                    i: frame_i,
                    j: frame_j,
                    law,
                    ..
                } if law.is_linear() => self.bushing(name, (i, frame_i), (j, frame_j), law),
                Role::Bushing {
                    i: frame_i,
                    j: frame_j,
                    law,
                    ..
                } => self.curved(name, (i, frame_i), (j, frame_j), law),
                Role::Spring(spring) => {
                    let frame = |p: Vec3| Pose {
                        p,
                        R: Mat3::identity(),
                    };
                    self.spring(
                        name,
                        (i, &frame(spring.i)),
                        (j, &frame(spring.j)),
                        &spring.law,
                    )
                }
                Role::Carried => "-".to_string(),
                Role::Load(point) => self.load(member.connection.element, point, i, j),
            };
            self.addresses.push((member.connection.element, address));
        }
        for (a, b) in &self.mechanism.rigid {
            let (first, second) = (
                &self.record.bodies[*a].poses[0],
                &self.record.bodies[*b].poses[0],
            );
            let joint = Joint {
                kind: "FIXED",
                i: Pose::identity(),
                j: second.inverse().compose(first),
            };
            let name = format!("{}_held", self.record.bodies[*a].name);
            self.joint(&name, &joint, *a, *b);
        }
    }

    fn joint(&mut self, name: &str, joint: &Joint, i: usize, j: usize) -> String {
        let at_i = self.marker(i, &format!("{name}_i"), &joint.i);
        let at_j = self.marker(j, &format!("{name}_j"), &joint.j);
        self.next.joint += 1;
        let id = self.next.joint;
        self.connectors += &named(name);
        let _ = writeln!(
            self.connectors,
            "JOINT/{id}\n, {}\n, I = {at_i}\n, J = {at_j}",
            joint.kind
        );
        format!("JOINT/{id}")
    }

    fn motion(
        &mut self,
        name: &str,
        i: (usize, &Pose),
        j: (usize, &Pose),
        turns: bool,
        values: &[f64],
    ) -> String {
        let at_i = self.marker(i.0, &format!("{name}_motion_i"), i.1);
        let at_j = self.marker(j.0, &format!("{name}_motion_j"), j.1);
        let function = self.over_time(values);
        self.next.motion += 1;
        let id = self.next.motion;
        let word = if turns { "B3" } else { "Z" };
        self.connectors += &named(&format!("{name}_motion"));
        let _ = writeln!(
            self.connectors,
            "MOTION/{id}\n, I = {at_i}\n, J = {at_j}\n, {word}\n, FUNCTION = {function}"
        );
        let address = format!("MOTION/{id}");
        self.drives.push(Drive {
            name: format!("{}_motion", identifier(name)),
            address: address.clone(),
            values: values.to_vec(),
        });
        address
    }

    fn bushing(&mut self, name: &str, i: (usize, &Pose), j: (usize, &Pose), law: &Law) -> String {
        let at_i = self.marker(i.0, &format!("{name}_i"), i.1);
        let at_j = self.marker(j.0, &format!("{name}_j"), j.1);
        self.next.bushing += 1;
        let id = self.next.bushing;
        let (force, torque) = self.numbers(law);
        self.connectors += &named(name);
        let _ = writeln!(
            self.connectors,
            "BUSHING/{id}\n, I = {at_i}\n, J = {at_j}\n, K = {}\n, KT = {}\n, FORCE = {}\n, TORQUE = {}\
             \n, C = 0.0, 0.0, 0.0\n, CT = 0.0, 0.0, 0.0",
            list(force.iter().map(|n| n.1)),
            list(torque.iter().map(|n| n.1)),
            list(force.iter().map(|n| n.0)),
            list(torque.iter().map(|n| n.0)),
        );
        format!("BUSHING/{id}")
    }

    /// Returns preload and stiffness of every axis: first for the forces, then for the torques. An axis without a linear law gets the mean stiffness
    /// of the linear axes, or the default stiffness.
    fn numbers(&self, law: &Law) -> ([(f64, f64); 3], [(f64, f64); 3]) {
        let units = &self.record.units;
        let plain = DEFAULT_STIFFNESS_N_PER_MM * 1e3 * units.length.si / units.force.si;
        let plain_torsion = DEFAULT_TORSION_NM_PER_RAD / (units.force.si * units.length.si);
        let fill = |laws: &[AxisLaw; 3], plain: f64| {
            let seen: Vec<f64> = laws
                .iter()
                .filter_map(|law| match law {
                    AxisLaw::Linear { stiffness, .. } => Some(*stiffness),
                    _ => None,
                })
                .collect();
            let usual = if seen.is_empty() {
                plain
            } else {
                seen.iter().sum::<f64>() / seen.len() as f64
            };
            [0, 1, 2].map(|axis| match &laws[axis] {
                AxisLaw::Linear { preload, stiffness } => (*preload, *stiffness),
                AxisLaw::Unseen(preload) | AxisLaw::Odd { preload, .. } => (*preload, usual),
                AxisLaw::Curve(_) => (0.0, usual),
            })
        };
        (fill(&law.force, plain), fill(&law.torque, plain_torsion))
    }

    /// Writes a bushing with curves as a GFORCE in J axes, whose functions are the laws of the bushing.
    fn curved(&mut self, name: &str, i: (usize, &Pose), j: (usize, &Pose), law: &Law) -> String {
        let at_i = self.marker(i.0, &format!("{name}_i"), i.1);
        let at_j = self.marker(j.0, &format!("{name}_j"), j.1);
        let floating = self.floating(j.0);
        let (force, torque) = self.numbers(law);
        let measure = |letter: char, axis: usize| {
            let axis = ['X', 'Y', 'Z'][axis];
            if letter == 'D' {
                format!("D{axis}({at_i},{at_j},{at_j})")
            } else {
                format!("A{axis}({at_i},{at_j})")
            }
        };
        let mut functions = Vec::new();
        for axis in 0..3 {
            let d = measure('D', axis);
            functions.push(match (&law.force[axis], law.coupled) {
                (AxisLaw::Curve(points), _) => format!("AKISPL({d},0,{})", self.spline(points)),
                (AxisLaw::Odd { preload, points }, Some(pair)) => {
                    let [p, q] = pair.map(|axis| measure('D', axis));
                    let id = self.spline(&both_sides(points));
                    // The small number avoids a division by zero at r = 0. Elsewhere its effect is below round-off.
                    let r = format!("SQRT({p}**2+{q}**2+1.0E-18)");
                    format!("{}-AKISPL({r},0,{id})*{d}/{r}", number(*preload))
                }
                _ => format!("{}-{}*{d}", number(force[axis].0), signed(force[axis].1)),
            });
        }
        for axis in 0..3 {
            let a = measure('A', axis);
            functions.push(match &law.torque[axis] {
                AxisLaw::Curve(points) => format!("AKISPL({a},0,{})", self.spline(points)),
                _ => format!("{}-{}*{a}", number(torque[axis].0), signed(torque[axis].1)),
            });
        }
        self.next.vector_force += 1;
        let id = self.next.vector_force;
        self.connectors += &named(name);
        let _ = write!(
            self.connectors,
            "GFORCE/{id}\n, I = {at_i}\n, JFLOAT = {floating}\n, RM = {at_j}"
        );
        for (k, function) in functions.iter().enumerate() {
            let word = ["FX", "FY", "FZ", "TX", "TY", "TZ"][k];
            let end = if k < 5 { "\\" } else { "" };
            let _ = write!(self.connectors, "\n, {word} = {}{end}", broken(function));
        }
        self.connectors.push('\n');
        format!("GFORCE/{id}")
    }

    fn spring(
        &mut self,
        name: &str,
        i: (usize, &Pose),
        j: (usize, &Pose),
        law: &AxisLaw,
    ) -> String {
        let at_i = self.marker(i.0, &format!("{name}_i"), i.1);
        let at_j = self.marker(j.0, &format!("{name}_j"), j.1);
        self.connectors += &named(name);
        match law {
            AxisLaw::Linear { preload, stiffness } if *stiffness > 0.0 && *preload > 0.0 => {
                self.next.spring += 1;
                let id = self.next.spring;
                // F = preload - K length is zero at the free length.
                let _ = writeln!(
                    self.connectors,
                    "SPRINGDAMPER/{id}\n, TRANSLATION\n, I = {at_i}\n, J = {at_j}\n, C = 0.0\n, K = {}\n, LENGTH = {}\n, FORCE = 0.0",
                    number(*stiffness),
                    number(preload / stiffness),
                );
                format!("SPRINGDAMPER/{id}")
            }
            law => {
                let length = format!("DM({at_i},{at_j})");
                let function = match law {
                    AxisLaw::Linear { preload, stiffness } => {
                        format!("{}-{}*{length}", number(*preload), signed(*stiffness))
                    }
                    AxisLaw::Unseen(force) => number(*force),
                    AxisLaw::Curve(points) | AxisLaw::Odd { points, .. } => {
                        format!("AKISPL({length},0,{})", self.spline(points))
                    }
                };
                self.next.line_force += 1;
                let id = self.next.line_force;
                let _ = writeln!(
                    self.connectors,
                    "SFORCE/{id}\n, TRANSLATIONAL\n, I = {at_i}\n, J = {at_j}\n, FUNCTION = {}",
                    broken(&function)
                );
                format!("SFORCE/{id}")
            }
        }
    }

    fn load(&mut self, element: usize, point: &Vec3, i: usize, j: usize) -> String {
        let object = &self.record.elements[element];
        let name = object.name.clone();
        let frame = Pose {
            p: *point,
            R: Mat3::identity(),
        };
        let at_i = self.marker(i, &format!("{name}_i"), &frame);
        let floating = self.floating(j);
        let reference = self.marker(0, &format!("{name}_axes"), &Pose::identity());
        self.next.vector_force += 1;
        let id = self.next.vector_force;
        let mut functions = Vec::new();
        for k in 0..6 {
            let word = ["FX", "FY", "FZ", "TX", "TY", "TZ"][k];
            let values: Vec<f64> = if k < 3 {
                object.force.iter().map(|f| f[k]).collect()
            } else {
                object.torque.iter().map(|t| t[k - 3]).collect()
            };
            functions.push(self.over_time(&values));
            if values.iter().any(|v| *v != values[0]) {
                self.drives.push(Drive {
                    name: format!("{}_{}", identifier(&name), word.to_ascii_lowercase()),
                    address: format!("GFORCE/{id}.{word}"),
                    values,
                });
            }
        }
        self.connectors += &named(&name);
        let _ = write!(
            self.connectors,
            "GFORCE/{id}\n, I = {at_i}\n, JFLOAT = {floating}\n, RM = {reference}"
        );
        for (k, function) in functions.iter().enumerate() {
            let word = ["FX", "FY", "FZ", "TX", "TY", "TZ"][k];
            let end = if k < 5 { "\\" } else { "" };
            let _ = write!(self.connectors, "\n, {word} = {function}{end}");
        }
        self.connectors.push('\n');
        format!("GFORCE/{id}")
    }

    fn finish(mut self) -> Deck {
        let units = self.record.units;
        let title: String = self
            .record
            .title
            .chars()
            .filter(|c| !c.is_control())
            .collect();
        let _ = writeln!(self.text, "Rebuilt from results: {title}");
        let _ = writeln!(
            self.text,
            "!\n! The state with index k of the results is at TIME = k. Inertias and damping cannot be determined from equilibria.\n!\n\
             UNITS/FORCE = {}, MASS = {}\n, LENGTH = {}, TIME = {}",
            units.force.keyword, units.mass.keyword, units.length.keyword, units.time.keyword
        );
        let inertia = DEFAULT_INERTIA_KG_M2 / (units.mass.si * units.length.si * units.length.si);
        let least = LEAST_MASS_KG / units.mass.si;
        for k in 0..self.record.bodies.len() {
            if k == 0 {
                self.text += "!\nPART/1\n, GROUND\n";
            } else {
                let mass = self.mechanism.bodies[k];
                let centre = if mass.mass > least {
                    mass.centre
                } else {
                    Vec3::zeros()
                };
                let body = &self.record.bodies[k];
                let name = body.name.clone();
                let cm = self.marker(
                    k,
                    &format!("{name}_cm"),
                    &Pose {
                        p: centre,
                        R: Mat3::identity(),
                    },
                );
                self.text += &format!("!\n{}", named(&name));
                let _ = writeln!(
                    self.text,
                    "PART/{}\n, QG = {}\n, REULER = {}\n, MASS = {}\n, CM = {cm}\n, IP = {}",
                    k + 1,
                    list(body.design.p.iter().copied()),
                    list(psi_theta_phi(&body.design.R).into_iter()),
                    number(mass.mass.max(least)),
                    list([inertia; 3].into_iter()),
                );
            }
            self.text += &self.markers[k];
        }
        self.text += "!\n";
        self.text += &self.connectors;
        self.text += &self.splines;
        let g = self.mechanism.down * super::gravity(&units);
        let _ = writeln!(
            self.text,
            "ACCGRAV/IGRAV = {}, JGRAV = {}\n, KGRAV = {}\nEQUILIBRIUM/ERROR = 1.0E-10, IMBALANCE = 1.0E-7\n, MAXIT = 200\nRESULTS/XRF\nEND",
            number(g.x),
            number(g.y),
            number(g.z)
        );
        let states = self.record.states();
        // A quasi-static simulation begins with the equilibrium at its start time.
        let last = states - 1;
        let commands = format!(
            "file/model=model, output_prefix=states\nSIMULATE/STATIC, END = {last}, STEPS = {last}\nSTOP\n"
        );
        Deck {
            text: self.text,
            commands,
            drives: self.drives,
            parts: (0..self.record.bodies.len())
                .map(|k| k as u32 + 1)
                .collect(),
            addresses: self.addresses,
        }
    }
}
