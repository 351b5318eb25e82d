//! Registry of the pair constraints. The module contains no parameter values.

use super::{
    Convel, Drive, Locks, PairConstraint, RackPinion, RelativeCoordinate, Screw,
    joint::{CYLINDRICAL, FIXED, HOOKE, PLANAR, REVOLUTE, SPHERICAL, TRANSLATIONAL, UNIVERSAL},
    primitive::{AT_POINT, INLINE, INPLANE, ORIENTATION, PARALLEL_AXES, PERPENDICULAR},
};

/// A pair constraint together with its deck statement, its parameter argument and the source of its equations.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct ConstraintEntry {
    /// Name of the deck statement, such as `JOINT`.
    pub statement: &'static str,
    /// Type keyword within the statement, such as `REVOLUTE`.
    pub kind: &'static str,
    /// Equations of the constraint.
    pub constraint: PairConstraint,
    /// Argument that gives the constraint's parameter, if it has one. The grammar defines its dimension and bounds. For a MOTION, the
    /// parameter is the value of its FUNCTION.
    pub argument: Option<&'static str>,
    /// Adams help page that defines the equations.
    pub source: &'static str,
}

const fn locks(kind: &'static str, equations: Locks) -> ConstraintEntry {
    joint(kind, PairConstraint::Locks(equations), None)
}

const fn primitive(kind: &'static str, locks: Locks) -> ConstraintEntry {
    ConstraintEntry {
        statement: "JPRIM",
        kind,
        constraint: PairConstraint::Locks(locks),
        argument: None,
        source: "adams_solver/state_jprim.html",
    }
}

const fn joint(
    kind: &'static str,
    constraint: PairConstraint,
    argument: Option<&'static str>,
) -> ConstraintEntry {
    ConstraintEntry {
        statement: "JOINT",
        kind,
        constraint,
        argument,
        source: "adams_solver/state_joint.html",
    }
}

const fn drive(kind: &'static str, measure: RelativeCoordinate) -> ConstraintEntry {
    ConstraintEntry {
        statement: "MOTION",
        kind,
        constraint: PairConstraint::Drive(Drive { measure }),
        argument: Some("FUNCTION"),
        source: "adams_solver/state_motion.html",
    }
}

/// Returns the constraint of a statement and type keyword. CONVEL has two entries, and this function returns the first; the caller then
/// selects the variant from the design position.
pub(crate) fn constraint(statement: &str, kind: &str) -> Option<&'static ConstraintEntry> {
    CONSTRAINTS
        .iter()
        .find(|entry| entry.statement == statement && entry.kind == kind)
}

/// All constraints between one marker pair, one per line. The tests below cover all of them.
#[rustfmt::skip]
pub(crate) const CONSTRAINTS: &[ConstraintEntry] = &[
    locks("SPHERICAL", SPHERICAL),
    locks("REVOLUTE", REVOLUTE),
    locks("TRANSLATIONAL", TRANSLATIONAL),
    locks("CYLINDRICAL", CYLINDRICAL),
    locks("PLANAR", PLANAR),
    locks("FIXED", FIXED),
    locks("HOOKE", HOOKE),
    locks("UNIVERSAL", UNIVERSAL),
    joint("CONVEL", PairConstraint::Convel(Convel::CoDirected), None),
    joint("CONVEL", PairConstraint::Convel(Convel::Opposed), None),
    joint("SCREW", PairConstraint::Screw(Screw), Some("PITCH")),
    joint("RACKPIN", PairConstraint::RackPinion(RackPinion), Some("PD")),
    primitive("ATPOINT", AT_POINT),
    primitive("INLINE", INLINE),
    primitive("INPLANE", INPLANE),
    primitive("ORIENTATION", ORIENTATION),
    primitive("PARALLEL_AXES", PARALLEL_AXES),
    primitive("PERPENDICULAR", PERPENDICULAR),
    drive("X", RelativeCoordinate::Translation(0)),
    drive("Y", RelativeCoordinate::Translation(1)),
    drive("Z", RelativeCoordinate::Translation(2)),
    drive("ROTATIONAL", RelativeCoordinate::Angle(2)),
    drive("B1", RelativeCoordinate::Body123(0)),
    drive("B2", RelativeCoordinate::Body123(1)),
    drive("B3", RelativeCoordinate::Body123(2)),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraint::{Constraint, Equations};
    use crate::mechanics::testing::{
        advanced, direction, displaced, general_pair, in_ground, moment, number,
    };
    use crate::mechanics::{Mat3, Pose, RelativeMotion, Vec3, Vec6, exp};

    /// Returns two markers near the arrangement that the constraint is designed for, but otherwise in general position.
    fn pair(entry: &ConstraintEntry, tilt: f64) -> (Pose, Pose) {
        let (mut i, j) = general_pair(tilt);
        if entry.kind == "RACKPIN" {
            // xi along zj, zi along yj.
            i.R *= Mat3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0);
        }
        (i, j)
    }

    fn motions(entry: &ConstraintEntry) -> Vec<RelativeMotion> {
        [0.02, 0.3, 0.9]
            .into_iter()
            .map(|tilt| {
                let (i, j) = pair(entry, tilt);
                RelativeMotion::between(&i, &j, &Vec3::zeros())
            })
            .collect()
    }

    fn multipliers() -> [f64; 6] {
        std::array::from_fn(|k| number(k) - if k % 2 == 0 { 0.3 } else { 2.0 })
    }

    fn evaluate(entry: &ConstraintEntry, motion: &RelativeMotion, theta: f64) -> Equations {
        let mut out = Equations::default();
        entry
            .constraint
            .evaluate(motion, &[theta], &multipliers(), &mut out);
        out
    }

    fn name(entry: &ConstraintEntry) -> String {
        format!("{} {}", entry.statement, entry.kind)
    }

    #[test]
    fn the_number_of_equations_is_the_manuals() {
        // Number of degrees of freedom removed, from the help pages of JOINT, JPRIM and MOTION, in the order of the registry.
        let removed = [
            3, 5, 5, 4, 3, 6, 4, 4, 4, 4, 1, 1, 3, 2, 1, 3, 2, 1, 1, 1, 1, 1, 1, 1, 1,
        ];
        assert_eq!(CONSTRAINTS.len(), removed.len());
        for (entry, count) in CONSTRAINTS.iter().zip(removed) {
            let c = &entry.constraint;
            assert_eq!(c.count(), count, "{}", name(entry));
            assert_eq!(evaluate(entry, &motions(entry)[0], 1.3).count, count);
            assert_eq!(c.parameter_count() > 0, entry.argument.is_some());
            let mut names: Vec<_> = (0..count).map(|k| c.equation_name(k)).collect();
            names.sort_unstable();
            names.dedup();
            assert_eq!(names.len(), count, "{}", name(entry));
        }
    }

    #[test]
    fn jacobians_and_curvatures_agree_with_central_differences() {
        let h = 1e-5;
        for entry in CONSTRAINTS {
            for motion in motions(entry) {
                let exact = evaluate(entry, &motion, 1.3);
                let mut curvature = Mat3::zeros();
                for a in 0..6 {
                    let above = evaluate(entry, &advanced(&motion, &Vec6::ith(a, h)), 1.3);
                    let below = evaluate(entry, &advanced(&motion, &Vec6::ith(a, -h)), 1.3);
                    let mut bent = Vec6::zeros();
                    for k in 0..exact.count {
                        let slope = (above.residual[k] - below.residual[k]) / (2.0 * h);
                        assert!(
                            (slope - exact.jacobian[k][a]).abs() < 1e-8,
                            "{} {k} {a}: {slope} {}",
                            name(entry),
                            exact.jacobian[k][a]
                        );
                        bent +=
                            (above.jacobian[k] - below.jacobian[k]) / (2.0 * h) * multipliers()[k];
                    }
                    // The blocks documented as zero are exactly zero.
                    let rotational = bent.fixed_rows::<3>(3).into_owned();
                    assert_eq!(bent.fixed_rows::<3>(0).norm(), 0.0);
                    if a < 3 {
                        assert_eq!(rotational.norm(), 0.0);
                    } else {
                        curvature.set_column(a - 3, &rotational);
                    }
                }
                assert!(
                    (curvature - exact.curvature).norm() < 1e-8,
                    "{}: {curvature} {}",
                    name(entry),
                    exact.curvature
                );
                assert!(exact.curvature == Mat3::zeros() || exact.curvature != curvature);
                assert!(
                    exact.jacobian[..exact.count]
                        .iter()
                        .all(|row| row.norm() > 0.0)
                );
            }
        }
    }

    #[test]
    fn derivatives_by_the_parameter_agree_with_central_differences() {
        let h = 1e-5;
        for entry in CONSTRAINTS {
            if entry.argument.is_none() {
                continue;
            }
            for motion in motions(entry) {
                let exact = evaluate(entry, &motion, 1.3);
                let (above, below) = (
                    evaluate(entry, &motion, 1.3 + h),
                    evaluate(entry, &motion, 1.3 - h),
                );
                let slope = (above.residual[0] - below.residual[0]) / (2.0 * h);
                let rows = (above.jacobian[0] - below.jacobian[0]) / (2.0 * h);
                assert!(
                    (slope - exact.residual_by_parameter).abs() < 1e-9,
                    "{}",
                    name(entry)
                );
                assert!(
                    (rows - exact.jacobian_by_parameter).norm() < 1e-9,
                    "{}",
                    name(entry)
                );
            }
        }
    }

    /// For any motion of both parts, the reactions do the work `-lambda . d(residual)`. This work is zero for motions that satisfy the
    /// constraint.
    #[test]
    fn reactions_do_the_work_of_the_residuals_and_balance() {
        let h = 1e-5;
        let about = Vec3::new(3.0, -11.0, 8.0);
        for entry in CONSTRAINTS {
            let (i, j) = pair(entry, 0.3);
            let (di, dj) = (direction(3), direction(4));
            let at = |s: f64| {
                let (i, j) = (displaced(&i, &(di * s)), displaced(&j, &(dj * s)));
                evaluate(entry, &RelativeMotion::between(&i, &j, &Vec3::zeros()), 1.3)
            };
            let here = at(0.0);
            let mut wrench = Vec6::zeros();
            let mut expected = 0.0;
            for k in 0..here.count {
                wrench -= here.jacobian[k] * multipliers()[k];
                let slope = (at(h).residual[k] - at(-h).residual[k]) / (2.0 * h);
                expected -= multipliers()[k] * slope;
            }
            let (on_i, on_j) = in_ground(&wrench, &i, &j);
            let work = on_i.dot(&di) + on_j.dot(&dj);
            assert!(
                (work - expected).abs() < 1e-7,
                "{}: {work} {expected}",
                name(entry)
            );
            let sum = moment(&on_i, &i.p, &about) + moment(&on_j, &j.p, &about);
            assert!(sum.norm() < 1e-12 && (on_i + on_j).fixed_rows::<3>(0).norm() < 1e-14);
        }
    }

    #[test]
    fn equations_do_not_see_a_motion_of_both_parts_together() {
        let turn = Pose {
            p: Vec3::new(-40.0, 5.0, 9.0),
            R: exp(&Vec3::new(-0.3, 2.0, 0.8)),
        };
        for entry in CONSTRAINTS {
            let (i, j) = pair(entry, 0.3);
            let here = RelativeMotion::between(&i, &j, &Vec3::zeros());
            let (i, j) = (turn.compose(&i), turn.compose(&j));
            let there = RelativeMotion::between(&i, &j, &Vec3::zeros());
            let (a, b) = (evaluate(entry, &here, 1.3), evaluate(entry, &there, 1.3));
            for k in 0..a.count {
                assert!(
                    (a.residual[k] - b.residual[k]).abs() < 1e-12,
                    "{}",
                    name(entry)
                );
            }
        }
    }

    /// Coincident markers satisfy every constraint except those that require zi perpendicular to zj.
    #[test]
    fn coincident_markers_satisfy_the_joints() {
        let coincident = RelativeMotion {
            p_ij_j: Vec3::zeros(),
            R_ji: Mat3::identity(),
            angles: Vec3::zeros(),
        };
        for entry in CONSTRAINTS.iter().filter(|entry| entry.kind != "RACKPIN") {
            let out = evaluate(entry, &coincident, 0.0);
            let worst = out.residual[..out.count]
                .iter()
                .fold(0.0_f64, |a, b| a.max(b.abs()));
            // These two require zi perpendicular to zj.
            let across = matches!(entry.kind, "UNIVERSAL" | "PERPENDICULAR");
            assert_eq!(worst, f64::from(across), "{}", name(entry));
        }
    }
}
