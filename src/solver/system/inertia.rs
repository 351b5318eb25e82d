//! Inertia of the parts about their reference points, in ground axes.

use super::chain::{BodyColumns, add_block, add33};
use super::{Configuration, Parameters, State, System};
use crate::linear::Sink;
use crate::mechanics::{Mat3, Mat6, Pose, Vec3, eigen::symmetric_eigen, skew};
use crate::model::PartIx;
use nalgebra::DMatrix;

/// Ratio of a principal moment of inertia to the largest entry of the inertia matrix. Below this ratio, the moment counts as zero.
const WITHOUT_INERTIA: f64 = 1e-12;

impl Configuration<'_> {
    /// Subtracts the inertia forces of the moving parts from the balances, `-(M A + h)`, with the derivatives with respect to positions,
    /// velocities and accelerations.
    ///
    /// With c the vector from the origin to the centre of mass, J the inertia about the origin, V = (v, w) and A = (a, b): `h = 1/ucf (m w
    /// x (w x c), w x (J w))`. A rotation dphi gives `dc = dphi x c` and `dJ = dphi~ J - J dphi~`, hence `dF = m (b x dc + w x (w x dc))`
    /// and `dT = m dc x a + dJ b + w x dJ w`. A change of w gives `dF = m (dw x (w x c) + w x (dw x c))` and `dT = dw x J w + w x J dw`.
    /// All these terms are divided by ucf.
    pub(super) fn add_inertia<S: Sink>(&mut self, g: &mut [f64], sink: &mut S) {
        let system = self.system;
        let n = system.moving_unknowns;
        for (part, body) in system.bodies.iter().enumerate() {
            if body.freedoms == 0 {
                continue;
            }
            let place = system.place(part);
            let M = system.mass_matrix(self.parameters, self.state, PartIx(part));
            let (velocity, acceleration) = (
                &self.state.velocities[part],
                &self.state.accelerations[part],
            );
            let (a, b, w) = (acceleration.linear, acceleration.angular, velocity.angular);
            let m = M[(0, 0)];
            let mc = Vec3::new(M[(5, 1)], M[(3, 2)], M[(4, 0)]);
            let J: Mat3 = M.fixed_view::<3, 3>(3, 3).into();
            let whole = body.freedoms == 6;
            let (F, T) = if whole {
                (
                    a * m + b.cross(&mc) + w.cross(&w.cross(&mc)),
                    mc.cross(&a) + J * b + w.cross(&(J * w)),
                )
            } else {
                (a * m, Vec3::zeros())
            };
            for k in 0..3 {
                g[place.first + k] -= F[k];
                if whole {
                    g[place.first + 3 + k] -= T[k];
                }
            }
            let size = F.amax().max(T.amax() / system.length);
            self.scratch.largest = self.scratch.largest.max(size);
            if !S::NEEDS_ENTRIES {
                continue;
            }
            let (mut K, mut C) = (Mat6::zeros(), Mat6::zeros());
            if whole {
                let (w_, b_) = (skew(&w), skew(&b));
                // dc = -c~ dphi.
                let dc = -skew(&mc);
                add33(&mut K, 0, 3, &((b_ + w_ * w_) * dc));
                // dJ x = dphi x (J x) - J (dphi x x) = (-(J x)~ + J x~) dphi.
                let turned = |x: &Vec3| J * skew(x) - skew(&(J * x));
                let by_turn = -(skew(&a) * dc) + turned(&b) + w_ * turned(&w);
                add33(&mut K, 3, 3, &by_turn);
                add33(&mut C, 0, 3, &-(skew(&w.cross(&mc)) + w_ * skew(&mc)));
                add33(&mut C, 3, 3, &(w_ * J - skew(&(J * w))));
            }
            for (level, block) in [K, C, M].iter().enumerate() {
                let column = BodyColumns {
                    first: place.first + level * n,
                    ..place
                };
                add_block(sink, place, column, &-block);
            }
        }
    }
}

impl System {
    /// Returns the mass matrix of a part about its reference point, in ground axes, divided by the units consistency factor.
    ///
    /// `c` points from the reference point to the centre of mass, `R` holds the axes of the CM marker in ground, and
    /// `J = R I_cm R' - m c~ c~`: `M = 1/ucf [ m 1, -m c~ ; m c~, J ]`. For a point mass, only the first three rows and columns apply.
    pub fn mass_matrix(&self, parameters: &Parameters, state: &State, part: PartIx) -> Mat6 {
        let (body, pose) = (&self.bodies[part.0], &state.poses[part.0]);
        let mut M = Mat6::zeros();
        if body.freedoms == 0 {
            return M;
        }
        let mass = parameters.theta()[body.mass];
        // IP refers to the origin and axes of the CM marker. Without a CM marker, IP refers to the part frame.
        let cm = body
            .cm
            .map_or_else(Pose::identity, |cm| parameters.markers()[cm]);
        let reference = self.local_reference(state, part.0);
        let (c, R) = (pose.R * (cm.p - reference), pose.R * cm.R);
        let mc = skew(&c) * mass;
        for k in 0..3 {
            M[(k, k)] = mass;
        }
        let J = R * body.inertia * R.transpose() - mc * skew(&c);
        M.fixed_view_mut::<3, 3>(0, 3).copy_from(&-mc);
        M.fixed_view_mut::<3, 3>(3, 0).copy_from(&mc);
        M.fixed_view_mut::<3, 3>(3, 3).copy_from(&J);
        M / self.ucf
    }

    /// Returns whether a movable part has zero mass, or a part with rotational freedoms has a zero principal moment of inertia.
    pub(crate) fn has_massless(&self, parameters: &Parameters, state: &State) -> bool {
        self.bodies.iter().enumerate().any(|(part, body)| {
            if body.freedoms == 0 {
                return false;
            }
            let M = self.mass_matrix(parameters, state, PartIx(part));
            let J = M.fixed_view::<3, 3>(3, 3).clone_owned();
            let turns = body.freedoms == 6 && {
                let largest = J.amax();
                let moments = symmetric_eigen(DMatrix::from_column_slice(3, 3, J.as_slice()));
                moments.eigenvalues.min() <= WITHOUT_INERTIA * largest
            };
            M[(0, 0)] == 0.0 || turns
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::mechanics::{Mat3, Vec3, Vec6, euler313};
    use crate::model::{Model, PartIx};
    use crate::system::System;
    use admire_syntax::Dataset;
    use admire_syntax::text::Source;

    /// For a part made of points, the kinetic energy equals the sum over the points, for any axes of the CM marker and any pose.
    #[test]
    fn the_kinetic_energy_is_that_of_the_points() {
        let points = [
            (2.0, Vec3::new(0.3, -0.2, 0.5)),
            (1.0, Vec3::new(-0.4, 0.9, 0.1)),
            (3.0, Vec3::new(0.7, 0.2, -0.6)),
            (0.5, Vec3::new(-0.1, -0.8, 0.4)),
        ];
        let mass: f64 = points.iter().map(|p| p.0).sum();
        let cm = points.iter().map(|p| p.1 * p.0).sum::<Vec3>() / mass;
        let R_cm = euler313(0.4, 0.8, -0.3);
        let mut J = Mat3::zeros();
        for (m, x) in points {
            let d = R_cm.transpose() * (x - cm);
            J += (Mat3::identity() * d.norm_squared() - d * d.transpose()) * m;
        }
        let deck = format!(
            "points\nUNITS/UCF=2\nPART/1, GROUND\nMARKER/1, PART=1\n\
             PART/2, MASS={mass}, CM=20, IP={},{},{},{},{},{}, QG=1,2,3, REULER=0.2,1.1,-0.7\n\
             MARKER/20, PART=2, QP={},{},{}, REULER=0.4,0.8,-0.3\nEND\n",
            J[(0, 0)],
            J[(1, 1)],
            J[(2, 2)],
            -J[(0, 1)],
            -J[(0, 2)],
            -J[(1, 2)],
            cm.x,
            cm.y,
            cm.z
        );
        let dataset = Dataset::parse(Source::new("points.adm", deck.into_bytes())).value;
        let model = Model::lower(&dataset).value;
        let ucf = model.units.ucf;
        let system = System::compile(&model).value;
        let state = system.state();
        let M = system.mass_matrix(&system.parameters(), &state, PartIx(1));
        // V is the velocity of the reference point.
        let centre = system.local_reference(&state, 1);
        assert!((centre - cm).norm() < 1e-14);
        let V = Vec6::new(0.3, -1.2, 0.8, 0.5, 2.0, -0.9);
        let (v, w) = (Vec3::new(V[0], V[1], V[2]), Vec3::new(V[3], V[4], V[5]));
        let twice: f64 = points
            .iter()
            .map(|(m, x)| m * (v + w.cross(&(state.poses[1].R * (x - centre)))).norm_squared())
            .sum();
        assert!((V.dot(&(M * V)) * ucf - twice).abs() < 1e-12 * twice);
        assert!((M - M.transpose()).norm() < 1e-14 * M.norm());
    }
}
