//! FIELDs of Adams/Car: closed forms, the same law as a GFORCE, derivatives of the equilibrium, and refusals.

use admire_solver::model::{Model, PartIx};
use admire_solver::statics::{Solver, Tangent};
use admire_solver::system::System;
use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::text::Source;
use admire_syntax::{Address, Dataset};

use crate::car_deck::{Axes, PARAMETERS, PLAIN, arrays, curve, field, gforce, part, splines};
use crate::deck::{HEAD, Solved, solve};
use crate::derivatives::{check_slot, check_tangent};

/// Scales, preloads, offsets and displacement scales that differ from axis to axis.
const GENERAL: Axes = [
    [1.5, 40.0, 0.2, 1.1],
    [0.8, -25.0, -0.3, 0.9],
    [1.2, 10.0, 0.4, 1.3],
    [1.1, 500.0, 0.01, 1.0],
    [0.9, -300.0, -0.02, 1.2],
    [1.3, 200.0, 0.03, 0.8],
];

const LOADS: [[f64; 6]; 4] = [
    [0.0; 6],
    [900.0, -700.0, 150.0, 2e3, -1e3, 3e3],
    [-4000.0, 200.0, -300.0, 0.0, 4e3, -2e3],
    // Load case beyond the last knots.
    [9000.0, 8000.0, 4000.0, 5e3, 0.0, 2e5],
];

fn car(axes: &Axes, load: [f64; 6]) -> String {
    [part(load), splines(), arrays(axes), field(PARAMETERS)].concat()
}

/// Checks the load that holds the part at a radial deflection at a knot: r = 4 and r = 6 are knots.
#[test]
fn a_radial_load_is_the_closed_form() {
    let mut axes = PLAIN;
    axes[0] = [1.5, 40.0, 0.0, 1.0];
    axes[1] = [1.0, -25.0, 0.0, 1.0];
    for (x, y, r) in [(2.4, 3.2, 4.0), (3.6, -4.8, 6.0), (-2.0, 0.0, 2.0)] {
        let z = 4.0;
        let load = [
            1.5 * curve(0, r) * x / r - 40.0,
            curve(1, r) * y / r + 25.0,
            curve(2, z),
            0.0,
            0.0,
            curve(5, 0.2),
        ];
        let solved = solve(&car(&axes, load));
        let pose = solved.pose(2);
        let turn = admire_solver::mechanics::log(&pose.R);
        let apart = [pose.p.x - x, pose.p.y - y, pose.p.z - z, turn.z - 0.2];
        assert!(apart.iter().all(|a| a.abs() < 1e-8), "{apart:?}");
    }
}

/// Checks offset and scale of the displacement: the curve is at a knot where the displacement is (knot + offset)/scale.
#[test]
fn offsets_are_subtracted_from_scaled_displacements() {
    let mut axes = PLAIN;
    axes[2] = [2.0, 7.0, 0.5, 1.25];
    let solved = solve(&car(
        &axes,
        [0.0, 0.0, 2.0 * curve(2, 4.0) - 7.0, 0.0, 0.0, 0.0],
    ));
    assert!((solved.pose(2).p.z - 4.5 / 1.25).abs() < 1e-8);
}

#[test]
fn the_same_law_as_a_gforce_has_the_same_equilibria() {
    for load in LOADS {
        let own = solve(&car(&GENERAL, load));
        let by_functions = solve(&[part(load), splines(), gforce(&GENERAL)].concat());
        let (a, b) = (own.pose(2), by_functions.pose(2));
        assert!((a.p - b.p).norm() < 1e-7, "{load:?}: {} {}", a.p, b.p);
        assert!((a.R - b.R).norm() < 1e-8, "{load:?}");
    }
}

#[test]
fn derivatives_of_the_equilibrium_agree_with_differences() {
    for load in LOADS {
        let Solved {
            system,
            parameters,
            state,
            told,
            ..
        } = solve(&car(&GENERAL, load));
        assert!(
            told.iter()
                .any(|t| t.contains("1 FIELD is read as a bushing of Adams/Car"))
        );
        check_tangent(&system, &parameters, &state, 1e-6);
        let mut tangent = Tangent::new(&system, &parameters, &state).unwrap();
        let mut solver = Solver::new(&system);
        for id in 31..=36 {
            for place in [3, 7, 8, 9] {
                let address = Address {
                    kind: "ARRAY".into(),
                    id: Some(id),
                    argument: Some("NUMBERS".into()),
                    index: Some(place),
                };
                let slot = system.catalogue().slot(&address).unwrap();
                let error = check_slot(
                    &system,
                    &mut solver,
                    &parameters,
                    &state,
                    slot,
                    &mut tangent,
                );
                assert!(error < 1e-5, "{address}: {error:e}");
            }
        }
    }
}

/// The points of a SPLINE change the equilibrium alike through the FIELD and through the FUNCTIONs of a GFORCE, and as differences say.
///
/// The chords on both sides of the middle of an odd curve are equal, so a weight of Akima's rule has a kink there. The deflections lie between the
/// last two knots, where that weight does not act.
#[test]
fn derivatives_by_the_points_of_curves_agree_with_differences() {
    let beyond: [f64; 6] = [3.5, 3.5, 5.0, 0.25, 0.25, 0.25];
    for sign in [1.0, -1.0] {
        let r = f64::hypot(beyond[0], beyond[1]);
        // The closed form of the load that holds these arguments of the curves.
        let load: [f64; 6] = std::array::from_fn(|axis| {
            let [scale, preload, ..] = GENERAL[axis];
            let force = match axis {
                0..2 => curve(axis, r) * beyond[axis] / r,
                _ => curve(axis, beyond[axis]),
            };
            sign * scale * force - preload
        });
        let own = solve(&car(&GENERAL, load));
        let by_functions = solve(&[part(load), splines(), gforce(&GENERAL)].concat());
        let column = |of: &Solved, spline: u32, point: usize| {
            let address = Address {
                kind: "SPLINE".into(),
                id: Some(spline),
                argument: Some("Y".into()),
                index: Some(point),
            };
            let (system, parameters, state) = (&of.system, &of.parameters, &of.state);
            let slot = system.catalogue().slot(&address).unwrap();
            let mut tangent = Tangent::new(system, parameters, state).unwrap();
            let mut solver = Solver::new(system);
            let error = check_slot(system, &mut solver, parameters, state, slot, &mut tangent);
            assert!(error < 1e-5, "{load:?} {address}: {error:e}");
            let column = tangent.by_slot(system, parameters, state, slot).unwrap();
            column[system.part_unknowns(PartIx(1))].to_vec()
        };
        let mut moved = 0;
        for spline in 31..=36 {
            for point in 1..=7 {
                let (a, b) = (
                    column(&own, spline, point),
                    column(&by_functions, spline, point),
                );
                // A radial curve is read relative to its value at zero.
                if point == 4 && spline <= 32 {
                    continue;
                }
                let size = a.iter().fold(0.0, |most: f64, a| most.max(a.abs()));
                moved += usize::from(size > 0.0);
                for (a, b) in a.iter().zip(&b) {
                    assert!(
                        (a - b).abs() <= 1e-5 * size + 1e-14,
                        "{spline} {point}: {a} {b}"
                    );
                }
            }
        }
        assert!(moved >= 15, "{moved}");
    }
}

/// Returns whether the compiler refuses a deck, and its diagnostics.
fn diagnostics(text: &str) -> (bool, Vec<Diagnostic>) {
    let text = format!("{HEAD}{text}END\n");
    let dataset = Dataset::parse(Source::new("car.adm", text.into_bytes())).value;
    let compiled = System::compile(&Model::lower(&dataset).value);
    (compiled.has_errors(), compiled.diagnostics)
}

/// Returns whether the compiler refuses a deck, and its messages.
fn compiled_messages(text: &str) -> (bool, Vec<String>) {
    let (refused, found) = diagnostics(text);
    (refused, found.into_iter().map(|d| d.message).collect())
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let whole = car(&PLAIN, [0.0; 6]);
    let (refused, messages) = compiled_messages(&whole);
    assert!(!refused, "{messages:?}");
    let changed = |from: &str, to: &str| {
        assert!(whole.contains(from), "{from}");
        compiled_messages(&whole.replacen(from, to, 1))
    };
    for (from, to, expected) in [
        (
            "33, 34, 35, 36)",
            "33, 34, 35)",
            "name no SPLINE `axle.bkl_arm_outer.rz_spline`",
        ),
        (
            "NUMBERS = 2.0, 0.0, 1.0,",
            "NUMBERS = 2.0, 1.0,",
            "array of `axle.bkl_arm_outer.fx` has 10 numbers",
        ),
        (
            "NUMBERS = 2.0, 0.0,",
            "NUMBERS = 2.0, 120.0,",
            "has both a stiffness of 120 and a curve",
        ),
        ("NUMBERS = 2.0,", "NUMBERS = 2.5,", "has type 2.5"),
        (
            "0.0, 1.0\n! adams_view_name='axle.bkl_arm_outer.ty_d",
            "0.3, 1.0\n! adams_view_name='axle.bkl_arm_outer.ty_d",
            "velocity offset of 0.3",
        ),
        (
            "X = -6.0",
            "X = -6.5",
            "curve of `axle.bkl_arm_outer.fx` is not an odd function",
        ),
        (
            "bkl_arm_outer.ry_spline",
            "bkr_arm_outer.ry_spline",
            "objects of `axle.bkl_arm_outer` and of `axle.bkr_arm_outer`",
        ),
        (
            "bkl_arm_outer.field",
            "bkr_arm_outer.field",
            "the FIELD is called `axle.bkr_arm_outer.field`",
        ),
    ] {
        let (refused, messages) = changed(from, to);
        assert!(refused, "{to}");
        assert!(
            messages.iter().any(|m| m.contains(expected)),
            "{expected}: {messages:?}"
        );
    }
    // A subroutine whose parameters name no bushing objects is refused, like any other subroutine.
    let (refused, messages) = compiled_messages(&[part([0.0; 6]), field("902, 7")].concat());
    assert!(refused);
    let plain = "its values come from a user subroutine; without it, a force is missing";
    assert!(messages.iter().any(|m| m.ends_with(plain)), "{messages:?}");
}

/// Checks that parameters which name no object are reported, because their meaning is unknown.
#[test]
fn parameters_without_a_name_are_reported() {
    let text = [
        part([0.0; 6]),
        splines(),
        arrays(&PLAIN),
        field("902, 31, 32, 33, 34, 35, 36, 7"),
    ]
    .concat();
    let (_, found) = diagnostics(&text);
    let help = found[0].help.clone().unwrap_or_default();
    assert!(
        help.contains("the parameters 902, 7 are not used"),
        "{help}"
    );
}
