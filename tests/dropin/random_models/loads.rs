//! Elements of a random model: the holders and loads of parts.

use rand::RngExt;

use super::draw::{Draw, one};
use super::plain::{Force, Frame, Function, Law, V, number, numbers};

impl Draw {
    /// Adds a BUSHING, FIELD or BEAM with stiffness in all six directions between two parts.
    pub(super) fn holder(&mut self, a: usize, b: usize) {
        let k0 = self.force / self.length;
        let j = self.near(a);
        let slightly = Frame {
            p: self.vector(0.02 * self.length),
            R: self.turn(0.03),
        };
        let mut sizes = [0.0; 6];
        for (n, size) in sizes.iter_mut().enumerate() {
            let arm = if n < 3 {
                1.0
            } else {
                self.length * self.length
            };
            *size = 50.0 * k0 * arm * (1.5 + self.u());
        }
        let preload = [0, 1, 2, 3, 4, 5]
            .map(|n| self.u() * 0.2 * self.force * if n < 3 { 1.0 } else { self.length });
        let mut k = Box::new([[0.0; 6]; 6]);
        for n in 0..6 {
            k[n][n] = sizes[n];
        }
        let mut rest = [0.0; 6];
        let mut seen = slightly;
        let kind = self.random.random_range(0..4);
        let text = match kind {
            0 => {
                for row in 0..6 {
                    for column in 0..row {
                        let mean = (sizes[row] * sizes[column]).sqrt();
                        k[row][column] = 0.1 * mean * self.u();
                        k[column][row] = k[row][column] * (1.0 + 0.1 * self.u());
                    }
                }
                rest = [0, 1, 2, 3, 4, 5]
                    .map(|n| 0.02 * self.u() * if n < 3 { self.length } else { 1.0 });
                let columns: Vec<f64> = (0..36).map(|n| k[n % 6][n / 6]).collect();
                let angles = rest.map(number);
                let lines: Vec<String> = columns.chunks(6).map(numbers).collect();
                format!(
                    ", KMATRIX={}\n, LENGTH={}\n, FORCE={}",
                    lines.join("\n, "),
                    angles.join(", "),
                    numbers(&preload)
                )
            }
            1 => {
                // Steel would be too stiff; E and G are chosen from the size.
                let (length, l2) = (self.length, self.length * self.length);
                let (e, area) = (200.0 * k0 / length, 0.4 * l2);
                let (iy, iz, ix) = (0.05 * l2 * l2, 0.07 * l2 * l2, 0.06 * l2 * l2);
                let (g, asy, asz) = (0.4 * e, 1.1, 1.2);
                let (py, pz) = (
                    12.0 * e * iz * asy / (g * area * l2),
                    12.0 * e * iy * asz / (g * area * l2),
                );
                *k = [[0.0; 6]; 6];
                k[0][0] = e * area / length;
                k[1][1] = 12.0 * e * iz / (length * l2 * (1.0 + py));
                k[2][2] = 12.0 * e * iy / (length * l2 * (1.0 + pz));
                k[3][3] = g * ix / length;
                k[4][4] = (4.0 + pz) * e * iy / (length * (1.0 + pz));
                k[5][5] = (4.0 + py) * e * iz / (length * (1.0 + py));
                k[1][5] = -6.0 * e * iz / (l2 * (1.0 + py));
                k[5][1] = k[1][5];
                k[2][4] = 6.0 * e * iy / (l2 * (1.0 + pz));
                k[4][2] = k[2][4];
                rest[0] = length;
                seen.p += V::x() * length;
                format!(
                    ", LENGTH={}, AREA={}\n, IXX={}, IYY={}, IZZ={}\n, EMODULUS={}, GMODULUS={}, ASY={asy:?}, ASZ={asz:?}",
                    number(length),
                    number(area),
                    number(ix),
                    number(iy),
                    number(iz),
                    number(e),
                    number(g)
                )
            }
            _ => bushing(&sizes, &preload),
        };
        let i = j.then(&seen);
        let (mi, mj) = (self.marker(a, &i), self.marker(b, &j));
        let word = ["FIELD", "BEAM", "BUSHING", "BUSHING"][kind];
        let id = self.id(4 + kind.min(2));
        self.statements += &format!("{word}/{id}, I={}, J={}{text}\n", mi + 1, mj + 1);
        let preload = if kind == 1 { [0.0; 6] } else { preload };
        let force = Force {
            name: format!("{word}_{id}"),
            i: mi,
            j: mj,
            law: Law::Linear { k, rest, preload },
        };
        if kind > 1 && self.chance(2) {
            let sizes = sizes.map(|size| 1.3 * size);
            let preload = preload.map(|load| -load);
            let mut k = Box::new([[0.0; 6]; 6]);
            for n in 0..6 {
                k[n][n] = sizes[n];
            }
            let law = Law::Linear { k, rest, preload };
            let said = bushing(&sizes, &preload);
            self.redefined.push((
                format!("BUSHING/{id}{said}"),
                Force {
                    law,
                    ..force.clone()
                },
            ));
        }
        self.forces.push(force);
    }

    /// Adds another random force between two parts.
    pub(super) fn load(&mut self, a: usize, b: usize) {
        let (i, j) = (self.near(a), self.near(b));
        let (mi, mj) = (self.marker(a, &i), self.marker(b, &j));
        let (force, length) = (self.force, self.length);
        let markers = format!("I={}, J={}", mi + 1, mj + 1);
        let apart = (i.p - j.p).norm();
        let k0 = force / length;
        let (name, text, law, again) = match self.random.random_range(0..7) {
            0 => {
                let id = self.id(7);
                let q = [
                    2.0 * k0 * (1.5 + self.u()),
                    apart * (1.0 + 0.3 * self.u()),
                    0.2 * force * self.u(),
                ];
                let said = format!(
                    ", K={}, LENGTH={}, FORCE={}",
                    number(q[0]),
                    number(q[1]),
                    number(q[2])
                );
                let other = [q[0], 0.9 * q[1], q[2]];
                let again = (
                    format!("SPRINGDAMPER/{id}, LENGTH={}", number(other[1])),
                    Law::Spring(other),
                );
                (
                    format!("SPRINGDAMPER_{id}"),
                    format!("SPRINGDAMPER/{id}, TRANSLATIONAL, {markers}{said}"),
                    Law::Spring(q),
                    Some(again),
                )
            }
            1 if !self.hinges.is_empty() => {
                let (hi, hj) = one(&mut self.random, &self.hinges.clone());
                let id = self.id(7);
                let q = [
                    k0 * length * length * (1.5 + self.u()),
                    0.3 * self.u(),
                    0.1 * force * length * self.u(),
                ];
                let said = format!(
                    ", KT={}, ANGLE={}D, TORQUE={}",
                    number(q[0]),
                    number(q[1].to_degrees()),
                    number(q[2])
                );
                let name = format!("SPRINGDAMPER_{id}");
                let text = format!(
                    "SPRINGDAMPER/{id}, ROTATIONAL, I={}, J={}{said}",
                    hi + 1,
                    hj + 1
                );
                self.statements += &(text + "\n");
                self.forces.push(Force {
                    name,
                    i: hi,
                    j: hj,
                    law: Law::Torsion(q),
                });
                return;
            }
            2 => {
                let id = self.id(8);
                let f = self.function(mi, mj, 0.5 * force, true);
                let other = Function::constant(0.3 * force, f.x);
                let again = (
                    format!("SFORCE/{id}, FUNCTION={}", other.text()),
                    Law::Along(other),
                );
                (
                    format!("SFORCE_{id}"),
                    format!(
                        "SFORCE/{id}, TRANSLATIONAL, {markers}\n, FUNCTION={}",
                        f.text()
                    ),
                    Law::Along(f),
                    Some(again),
                )
            }
            3 => {
                let id = self.id(8);
                let f = self.function(mi, mj, 0.5 * force, false);
                let other = self.function(mi, mj, 0.5 * force, false);
                let again = (
                    format!("SFORCE/{id}, FUNCTION={}", other.text()),
                    Law::Follower(other),
                );
                (
                    format!("SFORCE_{id}"),
                    format!(
                        "SFORCE/{id}, TRANSLATIONAL, ACTIONONLY, {markers}\n, FUNCTION={}",
                        f.text()
                    ),
                    Law::Follower(f),
                    Some(again),
                )
            }
            4 => {
                let id = self.id(8);
                let f = self.function(mi, mj, 0.3 * force * length, false);
                (
                    format!("SFORCE_{id}"),
                    format!(
                        "SFORCE/{id}, ROTATIONAL, ACTIONONLY, {markers}\n, FUNCTION={}",
                        f.text()
                    ),
                    Law::Twist(f, false),
                    None,
                )
            }
            5 if !self.hinges.is_empty() => {
                let (hi, hj) = one(&mut self.random, &self.hinges.clone());
                let id = self.id(8);
                let mut f = self.function(hi, hj, 0.3 * force * length, false);
                f.form = if f.x.name == "AZ" { f.form } else { 0 };
                let name = format!("SFORCE_{id}");
                let text = format!(
                    "SFORCE/{id}, ROTATIONAL, I={}, J={}\n, FUNCTION={}",
                    hi + 1,
                    hj + 1,
                    f.text()
                );
                self.statements += &(text + "\n");
                self.forces.push(Force {
                    name,
                    i: hi,
                    j: hj,
                    law: Law::Twist(f, true),
                });
                return;
            }
            _ => {
                let kind = self.random.random_range(0..3);
                let word = ["GFORCE", "VFORCE", "VTORQUE"][kind];
                let id = self.id(9 + kind);
                let rm = self.any_marker();
                let mut functions: [Option<Function>; 6] = Default::default();
                let range = [0..6, 0..3, 3..6][kind].clone();
                let mut said = Vec::new();
                for k in range {
                    if self.chance(3) && !said.is_empty() {
                        continue;
                    }
                    let size = if k < 3 {
                        0.3 * force
                    } else {
                        0.1 * force * length
                    };
                    let f = self.function(mi, mj, size, false);
                    said.push(format!(
                        "{}={}",
                        ["FX", "FY", "FZ", "TX", "TY", "TZ"][k],
                        f.text()
                    ));
                    functions[k] = Some(f);
                }
                // The reaction acts on the part of J; nothing else uses the floating marker.
                self.markers.push(self.markers[mj]);
                let floating = self.markers.len();
                self.floating.push(floating - 1);
                self.marker_text += &format!("MARKER/{floating}, PART={}, FLOATING\n", b + 1);
                (
                    format!("{word}_{id}"),
                    format!(
                        "{word}/{id}, I={}, JFLOAT={floating}, RM={}\n, {}",
                        mi + 1,
                        rm + 1,
                        said.join("\\\n, ")
                    ),
                    Law::Vector(rm, Box::new(functions)),
                    None,
                )
            }
        };
        self.statements += &(text + "\n");
        let force = Force {
            name,
            i: mi,
            j: mj,
            law,
        };
        if let Some((said, law)) = again
            && self.chance(2)
        {
            self.redefined.push((
                said,
                Force {
                    law,
                    ..force.clone()
                },
            ));
        }
        self.forces.push(force);
    }
}

fn bushing(sizes: &[f64; 6], preload: &[f64; 6]) -> String {
    format!(
        ", K={}, KT={}\n, FORCE={}, TORQUE={}",
        numbers(&sizes[..3]),
        numbers(&sizes[3..]),
        numbers(&preload[..3]),
        numbers(&preload[3..])
    )
}
