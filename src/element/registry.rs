//! The list of force laws. Knows no values: those are in `Parameters` and in the dataset.

use super::parameter::{
    AREA, COORDINATES, FIELD_STIFFNESS, MODULUS, ParameterGroup, SECOND_MOMENT, STIFFNESS, TORSION,
    WRENCH,
};
use super::{
    Beam, Bushing, ElastoSlip, Field, ForceLaw, RotationalSpring, ScalarForce, TranslationalSpring,
};
use crate::units::Dimension;

/// What is known of a force law besides its formula.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct LawEntry {
    /// The law's name in the grammar's `element` lines.
    pub name: &'static str,
    /// The statement it comes from, or `None` for laws that ADAMS does not have.
    pub statement: Option<&'static str>,
    /// The law itself.
    pub law: ForceLaw,
    /// Its parameters in the order of `theta`.
    pub parameters: &'static [ParameterGroup],
    /// One line for people.
    pub doc: &'static str,
    /// Where the formula comes from.
    pub source: &'static str,
}

impl LawEntry {
    /// Catalogue names and dimensions in the order of `theta`: `K.1`, `K.2`, ...
    pub fn catalogue(&self) -> impl Iterator<Item = (String, Dimension)> + '_ {
        self.parameters.iter().flat_map(|group| {
            group
                .dimensions
                .iter()
                .enumerate()
                .map(|(k, &dimension)| (group.name(k), dimension))
        })
    }

    /// The entry of a law; both friction components share theirs by kind of coordinate.
    pub fn of(law: &ForceLaw) -> &'static Self {
        let same = |entry: &&Self| match (entry.law, law) {
            (ForceLaw::ElastoSlip(a), ForceLaw::ElastoSlip(b)) => {
                (a.component < 3) == (b.component < 3)
            }
            (a, b) => a == *b,
        };
        LAWS.iter()
            .find(same)
            .expect("every law has its line in LAWS")
    }
}

const fn group(argument: &'static str, dimensions: &'static [Dimension]) -> ParameterGroup {
    ParameterGroup {
        argument,
        dimensions,
    }
}

/// Every force law: one line each. The tests below run over all of them.
#[rustfmt::skip]
pub const LAWS: &[LawEntry] = &[
    LawEntry { name: "bushing", statement: Some("BUSHING"), law: ForceLaw::Bushing(Bushing),
        parameters: &[group("K", &[STIFFNESS; 3]), group("KT", &[TORSION; 3]), group("FORCE", &[Dimension::FORCE; 3]), group("TORQUE", &[Dimension::TORQUE; 3])],
        doc: "six springs along and about the axes of J", source: "adams_solver/state_bushing.html" },
    LawEntry { name: "field", statement: Some("FIELD"), law: ForceLaw::Field(Field),
        parameters: &[group("KMATRIX", &FIELD_STIFFNESS), group("LENGTH", &COORDINATES), group("FORCE", &WRENCH)],
        doc: "a full 6 by 6 spring in the axes of J", source: "adams_solver/state_field.html" },
    LawEntry { name: "beam", statement: Some("BEAM"), law: ForceLaw::Beam(Beam),
        parameters: &[group("LENGTH", &[Dimension::LENGTH]), group("AREA", &[AREA]), group("IXX", &[SECOND_MOMENT]), group("IYY", &[SECOND_MOMENT]), group("IZZ", &[SECOND_MOMENT]), group("EMODULUS", &[MODULUS]), group("GMODULUS", &[MODULUS]), group("ASY", &[Dimension::NONE]), group("ASZ", &[Dimension::NONE])],
        doc: "a linear Timoshenko beam along the x axis of J", source: "adams_solver/state_beam.html" },
    LawEntry { name: "translational_spring", statement: Some("SPRINGDAMPER"), law: ForceLaw::TranslationalSpring(TranslationalSpring),
        parameters: &[group("K", &[STIFFNESS]), group("LENGTH", &[Dimension::LENGTH]), group("FORCE", &[Dimension::FORCE])],
        doc: "a spring along the line of the origins", source: "adams_solver/state_springdamper.html" },
    LawEntry { name: "rotational_spring", statement: Some("SPRINGDAMPER"), law: ForceLaw::RotationalSpring(RotationalSpring),
        parameters: &[group("KT", &[TORSION]), group("ANGLE", &[Dimension::ANGLE]), group("TORQUE", &[Dimension::TORQUE])],
        doc: "a torsion spring about the z axis of J", source: "adams_solver/state_springdamper.html" },
    LawEntry { name: "line_force", statement: Some("SFORCE"), law: ForceLaw::ScalarForce(ScalarForce::Line),
        parameters: &[group("FUNCTION", &[Dimension::FORCE])],
        doc: "a force along the line of the origins", source: "adams_solver/state_sforce.html" },
    LawEntry { name: "axial_force", statement: Some("SFORCE"), law: ForceLaw::ScalarForce(ScalarForce::AlongZj),
        parameters: &[group("FUNCTION", &[Dimension::FORCE])],
        doc: "a force on I along the z axis of J (ACTIONONLY)", source: "adams_solver/state_sforce.html" },
    LawEntry { name: "axial_torque", statement: Some("SFORCE"), law: ForceLaw::ScalarForce(ScalarForce::AboutZj),
        parameters: &[group("FUNCTION", &[Dimension::TORQUE])],
        doc: "a torque about the z axis of J", source: "adams_solver/state_sforce.html" },
    LawEntry { name: "friction", statement: None, law: ForceLaw::ElastoSlip(ElastoSlip { component: 0 }),
        parameters: &[group("K", &[STIFFNESS]), group("LIMIT", &[Dimension::FORCE]), group("ANCHOR", &[Dimension::LENGTH])],
        doc: "dry friction with memory along an axis of J", source: "Prandtl 1928" },
    LawEntry { name: "torsional_friction", statement: None, law: ForceLaw::ElastoSlip(ElastoSlip { component: 5 }),
        parameters: &[group("K", &[TORSION]), group("LIMIT", &[Dimension::TORQUE]), group("ANCHOR", &[Dimension::ANGLE])],
        doc: "dry friction with memory about an axis of J", source: "Prandtl 1928" },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::{Law, Wrench};
    use crate::mechanics::testing::{
        advanced, direction, displaced, general_pair, in_ground, moment, number,
    };
    use crate::mechanics::{Mat3, Mat6, Pose, RelativeMotion, Vec3, Vec6, exp};

    /// General parameters: all of size one, friction far from its limit so that it sticks.
    fn theta(entry: &LawEntry) -> Vec<f64> {
        entry
            .catalogue()
            .enumerate()
            .map(|(n, (name, _))| number(n) * if name == "LIMIT" { 100.0 } else { 1.0 })
            .collect()
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
    fn every_law_lists_its_parameters() {
        for entry in LAWS {
            assert_eq!(
                entry.catalogue().count(),
                entry.law.parameter_count(),
                "{}",
                entry.name
            );
            assert_eq!(LawEntry::of(&entry.law).name, entry.name);
        }
        let names: Vec<_> = LAWS[0].catalogue().map(|(name, _)| name).collect();
        assert_eq!(names[..4], ["K.1", "K.2", "K.3", "KT.1"]);
    }

    #[test]
    fn derivatives_by_motion_agree_with_central_differences() {
        let h = 1e-5;
        for entry in LAWS {
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
                // Constant laws have no derivative; all others have one that was not made by differences.
                let constant = matches!(
                    entry.law,
                    ForceLaw::ScalarForce(ScalarForce::AlongZj | ScalarForce::AboutZj)
                );
                assert_eq!(exact == Mat6::zeros(), constant, "{}", entry.name);
                assert!(constant || exact != difference, "{}", entry.name);
            }
        }
    }

    #[test]
    fn derivatives_by_parameters_agree_with_central_differences() {
        let h = 1e-5;
        for entry in LAWS {
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
                    // Central differences of a beam's 1/L^3 err by h^2 times a large third derivative.
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
    fn a_sliding_friction_has_the_tangent_of_its_branch() {
        let entry = LawEntry::of(&ForceLaw::ElastoSlip(ElastoSlip { component: 1 }));
        let law = ForceLaw::ElastoSlip(ElastoSlip { component: 1 });
        let mut out = Wrench::default();
        let motion = motions()[1];
        law.evaluate(&motion, &[100.0, 3.0, 0.2], true, &mut out)
            .expect("regular");
        // y = -0.7 lies beyond the anchor at 0.2 by more than 3 / 100: the slider drags I back with 3.
        assert_eq!(entry.name, "friction");
        assert_eq!(out.value, Vec6::ith(1, 3.0));
        assert_eq!(out.by_motion, Mat6::zeros());
        assert_eq!(out.by_parameter[1], Vec6::ith(1, 1.0));
    }

    #[test]
    fn laws_are_objective_and_action_equals_reaction() {
        let turn = Pose {
            p: Vec3::new(-40.0, 5.0, 9.0),
            R: exp(&Vec3::new(-0.3, 2.0, 0.8)),
        };
        let about = Vec3::new(3.0, -11.0, 8.0);
        for entry in LAWS {
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

    /// At the reference configuration only the preload acts.
    #[test]
    fn the_preload_acts_alone_at_zero_deformation() {
        for entry in LAWS {
            let theta = theta(entry);
            let n = Vec3::new(2.0, -1.0, 2.0) / 3.0;
            let place = |p_ij_j: Vec3, rotation: Mat3, angles: Vec3| RelativeMotion {
                p_ij_j,
                R_ji: rotation,
                angles,
            };
            let unturned = |p| place(p, Mat3::identity(), Vec3::zeros());
            let (motion, preload) = match entry.law {
                ForceLaw::Bushing(_) => (
                    unturned(Vec3::zeros()),
                    Vec6::from_column_slice(&theta[6..12]),
                ),
                ForceLaw::Field(_) => (
                    // The law reads positions and angles; that these angles fit the rotation does not matter here.
                    place(
                        Vec3::from_column_slice(&theta[36..39]),
                        Mat3::identity(),
                        Vec3::from_column_slice(&theta[39..42]),
                    ),
                    Vec6::from_column_slice(&theta[42..48]),
                ),
                ForceLaw::Beam(_) => (unturned(Vec3::new(theta[0], 0.0, 0.0)), Vec6::zeros()),
                ForceLaw::TranslationalSpring(_) => (
                    unturned(n * theta[1]),
                    Vec6::new(n.x, n.y, n.z, 0.0, 0.0, 0.0) * theta[2],
                ),
                ForceLaw::RotationalSpring(_) => (
                    place(
                        Vec3::zeros(),
                        exp(&Vec3::new(0.0, 0.0, theta[1])),
                        Vec3::new(0.0, 0.0, theta[1]),
                    ),
                    Vec6::ith(5, theta[2]),
                ),
                ForceLaw::ScalarForce(ScalarForce::Line) => (
                    unturned(n * 7.0),
                    Vec6::new(n.x, n.y, n.z, 0.0, 0.0, 0.0) * theta[0],
                ),
                ForceLaw::ScalarForce(ScalarForce::AlongZj) => {
                    (unturned(n), Vec6::ith(2, theta[0]))
                }
                ForceLaw::ScalarForce(ScalarForce::AboutZj) => {
                    (unturned(n), Vec6::ith(5, theta[0]))
                }
                ForceLaw::ElastoSlip(slip) => {
                    let at = if slip.component < 3 {
                        unturned(Vec3::ith(slip.component, theta[2]))
                    } else {
                        let angles = Vec3::ith(slip.component - 3, theta[2]);
                        place(Vec3::zeros(), exp(&angles), angles)
                    };
                    (at, Vec6::zeros())
                }
            };
            let value = evaluate(entry, &motion, &theta).value;
            assert!(
                (value - preload).norm() < 1e-14,
                "{}: {value} {preload}",
                entry.name
            );
        }
    }

    /// Where a law has a potential, the work of its two wrenches is what the potential loses, for any motion of both parts.
    #[test]
    fn work_is_what_the_potential_loses() {
        let mut seen = 0;
        for entry in LAWS {
            let mut theta = theta(entry);
            // Translational stiffness only: finite projected angles have no potential.
            match entry.law {
                ForceLaw::Bushing(_) => {
                    theta[3..6].fill(0.0);
                    theta[9..12].fill(0.0);
                }
                ForceLaw::Field(_) => {
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
        for (law, expected) in [
            (
                ForceLaw::TranslationalSpring(TranslationalSpring),
                super::super::Degenerate::ZeroLengthLine,
            ),
            (
                ForceLaw::ScalarForce(ScalarForce::Line),
                super::super::Degenerate::ZeroLengthLine,
            ),
            (
                ForceLaw::Bushing(Bushing),
                super::super::Degenerate::UndefinedAngle { axis: 1 },
            ),
        ] {
            let theta = vec![1.0; law.parameter_count()];
            assert_eq!(
                law.evaluate(&coincident, &theta, false, &mut out),
                Err(expected)
            );
        }
    }

    /// AZ counts turns: a torsion spring two turns past its reference pulls back with two turns' torque.
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
