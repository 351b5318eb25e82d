//! Invariances: the position of the model, its units and the order of its statements have no effect. Also checks the roles of I and J.

use std::f64::consts::FRAC_PI_6;

use admire_solver::mechanics::{Mat3, Pose, Vec3, exp};
use admire_solver::model::{Model, Orientation, PartKind, SpringKind};
use admire_solver::statics::{Solver, StaticSettings};
use admire_solver::system::System;
use admire_syntax::Dataset;
use admire_syntax::text::Source;

use crate::common::shared;
use crate::deck::{self, solve};
use crate::reference::load;

const DECKS: [&str; 2] = [
    "reference/pseudo-mcpherson/mcph_ref",
    "reference/multilink/ocp_ref",
];

/// Returns the pose of every part at equilibrium, by id.
fn equilibrium(model: &Model, settings: &StaticSettings) -> Vec<(u32, Pose)> {
    let system = System::compile(model).value;
    let mut state = system.state();
    Solver::new(&system)
        .solve(&system, &system.parameters(), &mut state, settings)
        .unwrap();
    let ids = model.parts.iter().map(|p| p.header.id);
    let mut all: Vec<_> = ids.zip(state.poses).collect();
    all.sort_by_key(|p| p.0);
    all
}

fn compare(a: &[(u32, Pose)], b: &[(u32, Pose)], length: f64) {
    for ((id, a), (other, b)) in a.iter().zip(b) {
        assert_eq!(id, other);
        let apart = ((a.p - b.p).amax(), (a.R - b.R).amax());
        assert!(apart.0 < length && apart.1 < 1e-10, "PART/{id}: {apart:?}");
    }
}

/// Checks a model that is rotated and displaced as a whole, with gravity and ground markers: the solution moves with it.
#[test]
fn a_model_carried_elsewhere() {
    let there = Pose {
        p: Vec3::new(700.0, -1200.0, 400.0),
        R: exp(&Vec3::new(0.9, -1.3, 2.1)),
    };
    for stem in DECKS {
        let Some((mut model, _)) = load(stem) else {
            return;
        };
        let mut here = equilibrium(&model, &StaticSettings::tight());
        for (id, pose) in &mut here {
            let part = model.parts.iter().find(|p| p.header.id == *id).unwrap();
            if part.kind != PartKind::Ground {
                *pose = there.compose(pose);
            }
        }
        let ground = model.ground().unwrap();
        for part in &mut model.parts {
            part.pose = there.compose(&part.pose);
        }
        model.parts[ground.0].pose = Pose::identity();
        for marker in model.markers.iter_mut().filter(|m| m.part == ground) {
            marker.qp = there.point(&marker.qp);
            marker.R = there.R * marker.R;
            marker.orientation = Orientation::Points;
        }
        model.gravity = there.R * model.gravity;
        compare(&equilibrium(&model, &StaticSettings::tight()), &here, 1e-7);
    }
}

/// Checks a model converted from millimetres to metres: only the numbers of lengths, stiffnesses and torques change.
#[test]
fn a_model_in_metres() {
    for stem in DECKS {
        let Some((mut model, _)) = load(stem) else {
            return;
        };
        let mut expected = equilibrium(&model, &StaticSettings::tight());
        for (_, pose) in &mut expected {
            pose.p /= 1000.0;
        }
        for part in &mut model.parts {
            part.pose.p /= 1000.0;
            part.ip = part.ip.map(|i| i / 1e6);
        }
        for marker in &mut model.markers {
            marker.qp /= 1000.0;
        }
        for b in &mut model.bushings {
            b.k = b.k.map(|k| k * 1000.0);
            b.kt = b.kt.map(|k| k / 1000.0);
            b.torque = b.torque.map(|t| t / 1000.0);
        }
        for s in &mut model.springdampers {
            if s.kind == SpringKind::Translational {
                s.stiffness *= 1000.0;
                s.reference /= 1000.0;
            } else {
                s.stiffness /= 1000.0;
                s.preload /= 1000.0;
            }
        }
        model.gravity /= 1000.0;
        model.units.ucf = 1.0;
        let settings = StaticSettings {
            tlimit: 0.02,
            imbalance: 1e-9,
            ..StaticSettings::tight()
        };
        compare(&equilibrium(&model, &settings), &expected, 1e-10);
    }
}

/// Checks statements in any order.
#[test]
fn shuffled_statements() {
    for stem in DECKS {
        let Some(path) = shared(&format!("{stem}.adm")) else {
            return;
        };
        let bytes = std::fs::read(path).unwrap();
        let dataset = Dataset::parse(Source::new("deck", bytes.clone())).value;
        let straight = deck::read(&String::from_utf8(bytes).unwrap());
        let expected = equilibrium(&straight, &StaticSettings::tight());
        let mut pieces: Vec<String> = dataset
            .statements()
            .iter()
            .filter(|s| s.kind() != Some("END"))
            .map(|s| dataset.source().text(s.span).trim_end().to_string())
            .collect();
        for seed in 1..4_usize {
            // The permutation is fixed for each seed.
            for k in (1..pieces.len()).rev() {
                pieces.swap(k, (k * 7919 + seed * 104_729) % (k + 1));
            }
            let model = deck::read(&format!("shuffled\n{}\nEND\n", pieces.join("\n")));
            let ids = |m: &Model| m.parts.iter().map(|p| p.header.id).collect::<Vec<_>>();
            assert_ne!(ids(&model), ids(&straight));
            compare(
                &equilibrium(&model, &StaticSettings::tight()),
                &expected,
                1e-7,
            );
        }
    }
}

/// Returns the solution of two parts held in place. The second is rotated by 30 degrees about z and has its J marker at its centre. I is on the
/// first part, 5, 3, 2 away.
fn held(element: &str) -> deck::Solved {
    solve(&format!(
        "PART/2, MASS=1, CM=20, IP=1,1,1, QG=15,-7,2\nMARKER/20, PART=2\n\
         PART/3, MASS=1, CM=30, IP=1,1,1, QG=10,-10,0, REULER=30D,0D,0D\nMARKER/30, PART=3\n\
         MARKER/2, PART=1, QP=15,-7,2\nMARKER/3, PART=1, QP=10,-10,0, REULER=30D,0D,0D\n\
         JOINT/1, FIXED, I=20, J=2\nJOINT/2, FIXED, I=30, J=3\nMARKER/31, PART=3, FLOATING\nMARKER/21, PART=2, FLOATING\n{element}"
    ))
}

const D: Vec3 = Vec3::new(5.0, 3.0, 2.0);

/// Checks that bushings, fields and beams act in the axes of J: the force on I is R_J (-K R_J' d), and J carries -T - d x F about its own
/// origin.
#[test]
fn connectors_work_in_the_axes_of_j() {
    let k = Vec3::new(100.0, 20.0, 3.0);
    let R: Mat3 = exp(&(Vec3::z() * FRAC_PI_6));
    let (p_i, p_j) = (Vec3::new(15.0, -7.0, 2.0), Vec3::new(10.0, -10.0, 0.0));
    let kt = 1e4;
    let by_j = held(&format!(
        "BUSHING/1, I=20, J=30, K={},{},{}, KT=0,0,{kt}",
        k.x, k.y, k.z
    ));
    let (F, T) = by_j.on(2, "BUSHING/1", &p_i);
    let expected = -(R * k.component_mul(&(R.transpose() * D)));
    assert!((F - expected).norm() < 1e-9, "{F} {expected}");
    // I is rotated by -30 degrees relative to J.
    assert!((T - Vec3::z() * kt * FRAC_PI_6).norm() < 1e-8, "{T}");
    let (F_j, T_j) = by_j.on(3, "BUSHING/1", &p_j);
    assert!((F_j + F).norm() < 1e-9 && (T_j + T + D.cross(&F)).norm() < 1e-8);
    // With I and J exchanged, the axes are those of the unrotated part, so the force differs.
    let by_i = held(&format!(
        "BUSHING/1, I=30, J=20, K={},{},{}, KT=0,0,{kt}",
        k.x, k.y, k.z
    ));
    let (F, _) = by_i.on(2, "BUSHING/1", &p_i);
    let swapped = -k.component_mul(&D);
    assert!((F - swapped).norm() < 1e-9 && (swapped - expected).norm() > 10.0);
    // A FIELD with the same diagonal is the same element.
    let mut matrix = vec!["0".to_string(); 36];
    for (n, k) in [k.x, k.y, k.z, 0.0, 0.0, kt].iter().enumerate() {
        matrix[7 * n] = k.to_string();
    }
    let field = held(&format!(
        "FIELD/1, I=20, J=30, LENGTH=0,0,0,0,0,0, KMATRIX={}",
        matrix.join("\n,")
    ));
    for (part, at) in [(2, p_i), (3, p_j)] {
        let (a, b) = (
            field.on(part, "FIELD/1", &at),
            by_j.on(part, "BUSHING/1", &at),
        );
        assert!((a.0 - b.0).norm() < 1e-9 && (a.1 - b.1).norm() < 1e-8);
    }
    // The axis of a beam is the x axis of J, with the force E A / L (x - L) along it.
    let beam =
        held("BEAM/1, I=20, J=30, LENGTH=4, AREA=2, IXX=0, IYY=0, IZZ=0, EMODULUS=50, GMODULUS=1");
    let x = (R.transpose() * D).x;
    let (F, _) = beam.on(2, "BEAM/1", &p_i);
    let expected = R.column(0) * (-50.0 * 2.0 / 4.0 * (x - 4.0));
    assert!((F - expected).norm() < 1e-9, "{F} {expected}");
}

/// Checks that springs and forces along a line do not depend on which end is I. About zj, the sign depends on it, and with ACTIONONLY there is
/// no reaction on J.
#[test]
fn line_elements_do_not_care() {
    let p = Vec3::new(15.0, -7.0, 2.0);
    let n = D.normalize();
    for element in [
        "SPRINGDAMPER/1, I=20, J=30, TRANSLATIONAL, K=10, LENGTH=4, FORCE=3",
        "SFORCE/1, I=20, J=30, TRANSLATIONAL, FUNCTION=3-10*(DM(20,30)-4)",
    ] {
        let name = &element[..element.find(',').unwrap()];
        let (F, _) = held(element).on(2, name, &p);
        let swapped = element
            .replace("I=20, J=30", "I=30, J=20")
            .replace("(20,30)", "(30,20)");
        let (G, _) = held(&swapped).on(2, name, &p);
        let expected = n * (3.0 - 10.0 * (D.norm() - 4.0));
        assert!(
            (F - expected).norm() < 1e-9 && (G - F).norm() < 1e-9,
            "{F} {G}"
        );
    }
    // The z axes are parallel here. The torque on I is e zj, so an exchange of the markers changes the sign.
    let (_, T) = held("SFORCE/1, I=20, J=30, ROTATIONAL, FUNCTION=70").on(2, "SFORCE/1", &p);
    let (_, U) = held("SFORCE/1, I=30, J=20, ROTATIONAL, FUNCTION=70").on(2, "SFORCE/1", &p);
    assert!((T - Vec3::z() * 70.0).norm() < 1e-10 && (U + T).norm() < 1e-10);
    let (_, T) = held("SPRINGDAMPER/1, I=20, J=30, ROTATIONAL, KT=100, ANGLE=10D").on(
        2,
        "SPRINGDAMPER/1",
        &p,
    );
    assert!(
        (T.z - 100.0 * (FRAC_PI_6 + 10_f64.to_radians())).abs() < 1e-9,
        "{T}"
    );
    let alone = held("SFORCE/1, I=20, J=30, TRANSLATIONAL, ACTIONONLY, FUNCTION=70");
    let (F, _) = alone.on(2, "SFORCE/1", &p);
    assert!((F - Vec3::z() * 70.0).norm() < 1e-10);
    assert_eq!(alone.on(3, "SFORCE/1", &p).0, Vec3::zeros());
}

/// Checks that vector forces act in the axes of RM, wherever RM is.
#[test]
fn vector_forces_work_in_the_axes_of_rm() {
    let p = Vec3::new(15.0, -7.0, 2.0);
    let R: Mat3 = exp(&(Vec3::z() * FRAC_PI_6));
    let solved = held("GFORCE/1, I=20, JFLOAT=31, RM=30, FX=10\\, FY=4\\, TX=6");
    let (F, T) = solved.on(2, "GFORCE/1", &p);
    assert!((F - R * Vec3::new(10.0, 4.0, 0.0)).norm() < 1e-10);
    assert!((T - R * Vec3::x() * 6.0).norm() < 1e-10);
    // The reaction acts at I as well.
    let (G, U) = solved.on(3, "GFORCE/1", &p);
    assert!((F + G).norm() < 1e-10 && (T + U).norm() < 1e-9);
}
