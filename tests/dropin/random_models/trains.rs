//! Elements of a random model that act on more than two parts: COUPLER, GEAR, NFORCE.

use rand::RngExt;

use super::draw::{Draw, GEARED, one};
use super::plain::{Frame, Joint, Multi, Term, Train, V, number, numbers, six};

impl Draw {
    /// Returns the joints that may be geared, in random order.
    fn geared(&mut self) -> Vec<Joint> {
        let all = self.joints.iter();
        let mut left: Vec<Joint> = all
            .filter(|joint| GEARED.contains(&joint.kind))
            .cloned()
            .collect();
        let mut out = Vec::new();
        while !left.is_empty() {
            out.push(left.swap_remove(self.random.random_range(0..left.len())));
        }
        out
    }

    /// Adds a GEAR between two joints of one carrier, if there are any; its CV marker is where both parts have the same velocity along z.
    pub(super) fn gear(&mut self) {
        let joints = self.geared();
        let carrier = |joint: &Joint| self.markers[joint.j].0;
        let pair = joints.iter().enumerate().find_map(|(n, a)| {
            let mut others = joints[n + 1..].iter();
            let b = others.find(|b| carrier(b) == carrier(a))?;
            Some((a.clone(), b.clone()))
        });
        let Some((a, b)) = pair else { return };
        let part = carrier(&a);
        let place = self.near(part);
        let cv = self.marker(part, &place);
        let at = self.frames();
        let along = V::from(at[cv].R.column(2));
        let mut terms = Vec::new();
        for (joint, sign) in [(&a, 1.0), (&b, -1.0)] {
            let axis = V::from(at[joint.j].R.column(2));
            let mut push = |turns, scale: f64| {
                terms.push(Term {
                    i: joint.i,
                    j: joint.j,
                    turns,
                    scale: sign * scale,
                });
            };
            if joint.kind != "TRANSLATIONAL" {
                push(true, axis.cross(&(at[cv].p - at[joint.j].p)).dot(&along));
            }
            if joint.kind != "REVOLUTE" {
                push(false, axis.dot(&along));
            }
        }
        let id = self.id(12);
        self.statements += &format!(
            "GEAR/{id}, JOINTS={},{}, CV={}\n",
            a.name.replace("JOINT_", ""),
            b.name.replace("JOINT_", ""),
            cv + 1
        );
        let value = terms.iter().map(|term| term.value(&at)).sum();
        self.trains.push(Train {
            name: format!("GEAR_{id}"),
            terms,
            value,
        });
    }

    /// Adds a COUPLER of two or three joints, with scales that are satisfied at the design position.
    pub(super) fn coupler(&mut self) {
        let mut joints = self.geared();
        joints.truncate(if self.chance(2) { 3 } else { 2 });
        if joints.len() < 2 || self.chance(3) {
            return;
        }
        let at = self.frames();
        let mut terms: Vec<Term> = Vec::new();
        for joint in &joints {
            let turns = match joint.kind {
                "REVOLUTE" => true,
                "TRANSLATIONAL" => false,
                _ => self.chance(2),
            };
            let unit = if turns { self.length } else { 1.0 };
            terms.push(Term {
                i: joint.i,
                j: joint.j,
                turns,
                scale: unit * (1.0 + 0.5 * self.u()),
            });
        }
        let (last, others) = terms.split_last_mut().expect("at least two");
        let sum: f64 = others.iter().map(|term| term.value(&at)).sum();
        last.scale *= -sum / last.value(&at);
        // A very small or very large ratio would couple nothing.
        let unit = if last.turns { self.length } else { 1.0 };
        if !(0.05..20.0).contains(&(last.scale / unit).abs()) {
            return;
        }
        let id = self.id(13);
        let words = |each: &dyn Fn(usize) -> String, by: &str| {
            (0..terms.len()).map(each).collect::<Vec<_>>().join(by)
        };
        self.statements += &format!(
            "COUPLER/{id}, JOINTS={}, TYPE={}\n, SCALES={}\n",
            words(&|n| joints[n].name.replace("JOINT_", ""), ", "),
            words(&|n| if terms[n].turns { "R" } else { "T" }.to_string(), ":"),
            words(&|n| number(terms[n].scale), ", ")
        );
        self.trains.push(Train {
            name: format!("COUPLER_{id}"),
            terms,
            value: 0.0,
        });
    }

    /// Adds an NFORCE between two or three parts and another one, with an unsymmetric stiffness matrix.
    pub(super) fn multi_point(&mut self, parts: usize) {
        let j_part = self.random.random_range(0..=parts);
        let others: Vec<usize> = (0..=parts).filter(|part| *part != j_part).collect();
        let place = self.near(j_part);
        let j = self.marker(j_part, &place);
        let count = self.random.random_range(2..4);
        let mut i = Vec::new();
        for _ in 0..count {
            let part = one(&mut self.random, &others);
            // Projected angles are kept away from their singularity.
            let at = Frame {
                p: self.places[part].p + self.vector(self.length),
                R: place.R * self.turn(0.4),
            };
            i.push(self.marker(part, &at));
        }
        let at = self.frames();
        let n = 6 * count;
        let (force, length) = (self.force, self.length);
        let arm = |k: usize| if k % 6 < 3 { 1.0 } else { length };
        let mut k = vec![vec![0.0; n]; n];
        for row in 0..n {
            for column in 0..n {
                let own = if row == column {
                    3.0 + self.u()
                } else {
                    0.2 * self.u()
                };
                k[row][column] = own * force / length * arm(row) * arm(column);
            }
        }
        let q = i.iter().flat_map(|i| six(&at[*i].seen_from(&at[j])));
        let rest: Vec<f64> = q
            .enumerate()
            .map(|(n, q)| q + 0.02 * self.u() * if n % 6 < 3 { length } else { 1.0 })
            .collect();
        let preload: Vec<f64> = (0..n).map(|n| 0.2 * self.u() * force * arm(n)).collect();
        let id = self.id(14);
        let mut matrix = |rows: usize, columns: usize, values: &[f64]| {
            let id = self.id(15);
            let lines: Vec<String> = values.chunks(6).map(numbers).collect();
            self.statements += &format!(
                "MATRIX/{id}, FULL=RORDER, ROWS={rows}, COLUMNS={columns}\n, VALUES={}\n",
                lines.join("\n, ")
            );
            id
        };
        let ids = [
            matrix(n, n, &k.concat()),
            matrix(n, 1, &rest),
            matrix(n, 1, &preload),
        ];
        let markers: Vec<String> = i.iter().map(|i| (i + 1).to_string()).collect();
        self.statements += &format!(
            "NFORCE/{id}, I={}, J={}, KMATRIX={}, LENGTH={}, FORCE={}\n",
            markers.join(", "),
            j + 1,
            ids[0],
            ids[1],
            ids[2]
        );
        self.multis.push(Multi {
            name: format!("NFORCE_{id}"),
            i,
            j,
            k,
            rest,
            preload,
        });
    }
}
