//! Inertia of the parts about their origins, ground axes.

use super::{Parameters, State, System};
use crate::mechanics::{Mat6, Pose, skew};
use crate::model::PartIx;

impl System {
    /// The mass matrix of a part about its origin, ground axes, over the units consistency factor.
    ///
    /// With `c` from the origin to the centre of mass, `R` the axes of the CM marker in ground and `J = R I_cm R' - m c~ c~`:
    /// `M = 1/ucf [ m 1, -m c~ ; m c~, J ]`. A point mass has its first three rows and columns only.
    pub fn mass_matrix(&self, parameters: &Parameters, state: &State, part: PartIx) -> Mat6 {
        let (body, pose) = (&self.bodies[part.0], &state.poses[part.0]);
        let mut M = Mat6::zeros();
        if body.freedoms == 0 {
            return M;
        }
        let mass = parameters.theta()[body.mass];
        // IP is about the origin and in the axes of the CM marker; without one about and in the part's own.
        let cm = body
            .cm
            .map_or_else(Pose::identity, |cm| parameters.markers()[cm]);
        let (c, R) = (pose.R * cm.p, pose.R * cm.R);
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
}

#[cfg(test)]
mod tests {
    use crate::mechanics::{Mat3, Vec3, Vec6, euler313};
    use crate::model::{Model, PartIx};
    use crate::syntax::Dataset;
    use crate::system::System;
    use crate::text::Source;

    /// A part made of points: its kinetic energy is theirs, whatever the axes of its CM marker and its pose.
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
        let V = Vec6::new(0.3, -1.2, 0.8, 0.5, 2.0, -0.9);
        let (v, w) = (Vec3::new(V[0], V[1], V[2]), Vec3::new(V[3], V[4], V[5]));
        let twice: f64 = points
            .iter()
            .map(|(m, x)| m * (v + w.cross(&(state.poses[1].R * x))).norm_squared())
            .sum();
        assert!((V.dot(&(M * V)) * ucf - twice).abs() < 1e-12 * twice);
        assert!((M - M.transpose()).norm() < 1e-14 * M.norm());
    }
}
