//! Registry of the force laws. The module contains no formulas and no values; arguments, dimensions and bounds are in the grammar.

use super::{FILES, Law};

/// Force law with its name.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LawEntry {
    /// Name used in the `law` lines of the grammar. Laws whose only parameter is a FUNCTION have no such line.
    pub name: &'static str,
    /// Implementation of the law.
    pub law: &'static dyn Law,
}

/// Returns all force laws.
pub(crate) fn laws() -> impl Iterator<Item = &'static LawEntry> {
    FILES.iter().copied().flatten()
}

/// Returns the law with a given name in the grammar.
pub(crate) fn law(name: &str) -> Option<&'static dyn Law> {
    laws()
        .find(|entry| entry.name == name)
        .map(|entry| entry.law)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::bushing::BushingLaw;
    use crate::element::springdamper::{RotationalSpring, TranslationalSpring};
    use crate::element::{Degenerate, ScalarForce, Wrench};
    use crate::mechanics::testing::{
        advanced, direction, displaced, general_pair, in_ground, moment, number,
    };
    use crate::mechanics::{Mat3, Mat6, Pose, RelativeMotion, Vec3, Vec6, exp};
    use admire_syntax::grammar::STATEMENTS;

    /// Returns generic parameters, all of order one.
    fn theta(entry: &LawEntry) -> Vec<f64> {
        (0..entry.law.parameter_count()).map(number).collect()
    }

    fn motions() -> Vec<RelativeMotion> {
        [0.0, 0.1, 0.9]
            .into_iter()
            .map(|tilt| {
                let (i, j) = general_pair(tilt);
                RelativeMotion::between(&i, &j, &Vec3::zeros())
            })
            .collect()
    }

    fn evaluate(entry: &LawEntry, motion: &RelativeMotion, theta: &[f64]) -> Wrench {
        let mut out = Wrench::default();
        entry
            .law
            .evaluate(motion, theta, true, &mut out)
            .expect("regular motion");
        out
    }

    #[test]
    fn the_grammar_has_an_argument_for_every_number_of_a_law() {
        let mut seen = 0;
        for def in STATEMENTS {
            for wanted in def.laws {
                let law = law(wanted.name).unwrap_or_else(|| panic!("no law {}", wanted.name));
                let arguments = wanted.arguments.iter();
                let count: usize = arguments
                    .map(|name| def.argument(name).and_then(|a| a.count.max).unwrap_or(0))
                    .sum();
                assert_eq!(count, law.parameter_count(), "{}", wanted.name);
                seen += 1;
            }
        }
        assert!(seen >= 5);
    }

    #[test]
    fn derivatives_by_motion_agree_with_central_differences() {
        let h = 1e-5;
        for entry in laws() {
            let theta = theta(entry);
            for motion in motions() {
                let exact = evaluate(entry, &motion, &theta).by_motion;
                let mut difference = Mat6::zeros();
                for k in 0..6 {
                    let at = |h: f64| {
                        evaluate(entry, &advanced(&motion, &Vec6::ith(k, h)), &theta).value
                    };
                    difference.set_column(k, &((at(h) - at(-h)) / (2.0 * h)));
                }
                let scale = exact.norm().max(1.0);
                assert!(
                    (exact - difference).norm() < 1e-9 * scale,
                    "{}: {exact} {difference}",
                    entry.name
                );
                // Constant laws have a zero derivative. The exact derivative of every other law differs from the difference quotient.
                let constant = matches!(entry.name, "axial_force" | "axial_torque");
                assert_eq!(exact == Mat6::zeros(), constant, "{}", entry.name);
                assert!(constant || exact != difference, "{}", entry.name);
            }
        }
    }

    #[test]
    fn derivatives_by_parameters_agree_with_central_differences() {
        let h = 1e-5;
        for entry in laws() {
            let theta = theta(entry);
            for motion in motions() {
                let exact = evaluate(entry, &motion, &theta).by_parameter;
                assert_eq!(exact.len(), theta.len(), "{}", entry.name);
                for (n, column) in exact.iter().enumerate() {
                    let at = |h: f64| {
                        let mut theta = theta.clone();
                        theta[n] += h;
                        evaluate(entry, &motion, &theta).value
                    };
                    let difference = (at(h) - at(-h)) / (2.0 * h);
                    // The central difference of a beam's 1/L^3 has an error of h^2 times a large third derivative.
                    assert!(
                        (column - difference).norm() < 2e-8 * column.norm().max(1.0),
                        "{} {n}: {column} {difference}",
                        entry.name
                    );
                }
                assert!(exact.iter().any(|column| column.norm() > 0.0));
            }
        }
    }

    #[test]
    fn laws_are_objective_and_action_equals_reaction() {
        let turn = Pose {
            p: Vec3::new(-40.0, 5.0, 9.0),
            R: exp(&Vec3::new(-0.3, 2.0, 0.8)),
        };
        let about = Vec3::new(3.0, -11.0, 8.0);
        for entry in laws() {
            let theta = theta(entry);
            let (i, j) = general_pair(0.3);
            let world = |i: &Pose, j: &Pose| {
                let motion = RelativeMotion::between(i, j, &Vec3::zeros());
                in_ground(&evaluate(entry, &motion, &theta).value, i, j)
            };
            let (on_i, on_j) = world(&i, &j);
            let (turned_i, _) = world(&turn.compose(&i), &turn.compose(&j));
            for half in [0, 3] {
                let before = turn.R * on_i.fixed_rows::<3>(half);
                let after = turned_i.fixed_rows::<3>(half);
                assert!(
                    (before - after).norm() < 1e-12 * on_i.norm(),
                    "{}",
                    entry.name
                );
            }
            assert!((on_i + on_j).fixed_rows::<3>(0).norm() < 1e-14 * on_i.norm());
            let sum = moment(&on_i, &i.p, &about) + moment(&on_j, &j.p, &about);
            assert!(
                sum.norm() < 1e-12 * on_i.norm().max(1.0),
                "{}: {sum}",
                entry.name
            );
        }
    }

    /// In the reference configuration, only the preload acts.
    #[test]
    fn the_preload_acts_alone_at_zero_deformation() {
        for entry in laws() {
            let theta = theta(entry);
            let n = Vec3::new(2.0, -1.0, 2.0) / 3.0;
            let place = |p_ij_j: Vec3, rotation: Mat3, angles: Vec3| RelativeMotion {
                p_ij_j,
                R_ji: rotation,
                angles,
            };
            let unturned = |p| place(p, Mat3::identity(), Vec3::zeros());
            let (motion, preload) = match entry.name {
                "bushing" => (
                    unturned(Vec3::zeros()),
                    Vec6::from_column_slice(&theta[6..12]),
                ),
                "field" => (
                    // The law reads positions and angles only; consistency of these angles with the rotation does not matter here.
                    place(
                        Vec3::from_column_slice(&theta[36..39]),
                        Mat3::identity(),
                        Vec3::from_column_slice(&theta[39..42]),
                    ),
                    Vec6::from_column_slice(&theta[42..48]),
                ),
                "beam" => (unturned(Vec3::new(theta[0], 0.0, 0.0)), Vec6::zeros()),
                "translational_spring_damper" => (
                    unturned(n * theta[1]),
                    Vec6::new(n.x, n.y, n.z, 0.0, 0.0, 0.0) * theta[2],
                ),
                "rotational_spring_damper" => (
                    place(
                        Vec3::zeros(),
                        exp(&Vec3::new(0.0, 0.0, theta[1])),
                        Vec3::new(0.0, 0.0, theta[1]),
                    ),
                    Vec6::ith(5, theta[2]),
                ),
                "line_force" => (
                    unturned(n * 7.0),
                    Vec6::new(n.x, n.y, n.z, 0.0, 0.0, 0.0) * theta[0],
                ),
                "axial_force" => (unturned(n), Vec6::ith(2, theta[0])),
                "axial_torque" => (unturned(n), Vec6::ith(5, theta[0])),
                // The other laws have no preload.
                _ => continue,
            };
            let value = evaluate(entry, &motion, &theta).value;
            assert!(
                (value - preload).norm() < 1e-14,
                "{}: {value} {preload}",
                entry.name
            );
        }
    }

    /// Where a law has a potential, the work of its two wrenches equals the loss of potential for any motion of both parts.
    #[test]
    fn work_is_what_the_potential_loses() {
        let mut seen = 0;
        for entry in laws() {
            let mut theta = theta(entry);
            // Only translational stiffness is used: finite projected angles have no potential.
            match entry.name {
                "bushing" => {
                    theta[3..6].fill(0.0);
                    theta[9..12].fill(0.0);
                }
                "field" => {
                    for n in 0..36 {
                        let (a, b) = (n % 6, n / 6);
                        theta[n] = if a.max(b) < 3 { number(a + b) } else { 0.0 };
                    }
                    theta[45..48].fill(0.0);
                }
                _ => {}
            }
            let (i, j) = general_pair(0.4);
            let (di, dj) = (direction(1), direction(2));
            let at = |s: f64| {
                RelativeMotion::between(
                    &displaced(&i, &(di * s)),
                    &displaced(&j, &(dj * s)),
                    &Vec3::zeros(),
                )
            };
            let h = 1e-5;
            let (Some(above), Some(below)) = (
                entry.law.energy(&at(h), &theta),
                entry.law.energy(&at(-h), &theta),
            ) else {
                continue;
            };
            seen += 1;
            let (on_i, on_j) = in_ground(&evaluate(entry, &at(0.0), &theta).value, &i, &j);
            let work = on_i.dot(&di) + on_j.dot(&dj);
            let lost = (below - above) / (2.0 * h);
            assert!((work - lost).abs() < 1e-8, "{}: {work} {lost}", entry.name);
        }
        assert_eq!(seen, 3);
    }

    #[test]
    fn laws_without_a_value_say_so() {
        let coincident = RelativeMotion {
            p_ij_j: Vec3::zeros(),
            R_ji: exp(&Vec3::new(std::f64::consts::FRAC_PI_2, 0.0, 0.0)),
            angles: Vec3::zeros(),
        };
        let mut out = Wrench::default();
        let cases: [(&dyn Law, Degenerate); 3] = [
            (&TranslationalSpring, Degenerate::ZeroLengthLine),
            (&ScalarForce::Line, Degenerate::ZeroLengthLine),
            (&BushingLaw, Degenerate::UndefinedAngle { axis: 1 }),
        ];
        for (law, expected) in cases {
            let theta = vec![1.0; law.parameter_count()];
            assert_eq!(
                law.evaluate(&coincident, &theta, false, &mut out),
                Err(expected)
            );
        }
    }

    /// AZ counts full turns: a torsion spring two turns past its reference returns the torque of two turns.
    #[test]
    fn a_torsion_spring_counts_turns() {
        let turns = 2.0 * std::f64::consts::TAU;
        let motion = RelativeMotion {
            p_ij_j: Vec3::zeros(),
            R_ji: exp(&Vec3::new(0.0, 0.0, 0.3)),
            angles: Vec3::new(0.0, 0.0, 0.3 + turns),
        };
        let mut out = Wrench::default();
        RotationalSpring
            .evaluate(&motion, &[5.0, 0.3, 0.0], false, &mut out)
            .expect("regular");
        assert!((out.value[5] + 5.0 * turns).abs() < 1e-12);
    }
}
