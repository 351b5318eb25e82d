use super::connection::Connection;
use super::joint::{frame_along, pins};
use super::mechanism::{Mechanism, Member, Role, motion_values};
use super::record::Record;
use super::relation::Clusters;

impl Mechanism {
    /// Replaces one of the two ball joints of a rod by a universal joint, which prevents the rod from spinning. This requires that the motion of the
    /// rod is consistent with a universal joint.
    ///
    /// A universal joint without torque appears only in the motion: its pins remain at right angles.
    pub(crate) fn hold_rods(&mut self, record: &Record) {
        for body in 1..record.bodies.len() {
            let touches =
                |member: &Member| member.connection.i == body || member.connection.j == body;
            let on: Vec<usize> = (0..self.members.len())
                .filter(|k| touches(&self.members[*k]))
                .collect();
            let ball = |k: &usize| matches!(&self.members[*k].role, Role::Joint(joint) if joint.kind == "SPHERICAL");
            if on.len() != 2 || !on.iter().all(ball) {
                continue;
            }
            let found = on.iter().filter_map(|k| {
                let Connection { i, j, .. } = self.members[*k].connection;
                Some((*k, pins(&record.bodies[i].poses, &record.bodies[j].poses)?))
            });
            let best = found.min_by(|a, b| a.1.2.total_cmp(&b.1.2));
            if let Some((k, (pin_i, pin_j, _))) = best
                && let Role::Joint(joint) = &mut self.members[k].role
            {
                joint.kind = "UNIVERSAL";
                joint.i.R = frame_along(&pin_i);
                joint.j.R = frame_along(&pin_j);
            }
        }
    }

    /// Fastens bodies that no element connects. Bodies at rest are fastened to ground.
    pub(crate) fn fasten(&mut self, clusters: &Clusters, record: &Record) {
        for body in &clusters.members[0][1..] {
            let held = self
                .members
                .iter()
                .any(|member| member.connection.i == *body || member.connection.j == *body);
            if !held && !self.rigid.iter().any(|(a, _)| a == body) {
                self.rigid.push((*body, 0));
            }
        }
        self.rigid
            .retain(|(a, b)| a != b && *a < record.bodies.len());
        self.rigid.sort_unstable();
        self.rigid.dedup();
    }

    /// Prescribes the motion of sliding parts that are held only by given loads. Their position is an input of the test, not a result.
    pub(crate) fn prescribe(&mut self, clusters: &Clusters, record: &Record) {
        let mut motions = Vec::new();
        for member in &self.members {
            let Role::Joint(joint) = &member.role else {
                continue;
            };
            let Connection { element, i, j } = member.connection;
            if joint.kind != "TRANSLATIONAL" || (i != 0 && j != 0) {
                continue;
            }
            let own = clusters.of[i.max(j)];
            let on_cluster = |other: &Member| {
                let ends = [other.connection.i, other.connection.j];
                ends.iter().any(|body| clusters.of[*body] == own)
            };
            let only_loads = self
                .members
                .iter()
                .filter(|other| on_cluster(other))
                .all(|other| {
                    let inside = clusters.of[other.connection.i] == clusters.of[other.connection.j];
                    let same = other.connection.element == element;
                    inside || same || matches!(other.role, Role::Load(_))
                });
            if !only_loads {
                continue;
            }
            let values = motion_values(record, (i, &joint.i), (j, &joint.j), false);
            motions.push(Member {
                connection: member.connection,
                role: Role::Motion {
                    i: joint.i,
                    j: joint.j,
                    turns: false,
                    values,
                },
                open: 0.0,
            });
        }
        self.members.extend(motions);
    }
}
