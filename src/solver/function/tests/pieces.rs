//! Functions held on a piece: their formula continues beyond the end of the piece, and the excess of the arguments is reported.

use super::{EvaluationMemory, Fault, compile};

/// Returns the value, the derivatives with respect to VARIABLE/1 and VARIABLE/2, the piece to which the arguments belong, and the excess.
fn on(text: &str, at: [f64; 2], held: Option<i64>) -> (f64, [f64; 2], i64, f64) {
    let case = compile(text);
    assert_eq!(case.program.switches().len(), 1, "{text}");
    let mut scratch = EvaluationMemory::default();
    let inputs = case.inputs([at[0], at[1], 0.0, 0.0]);
    let (mut by, mut by_literal) = (vec![0.0; inputs.len()], vec![0.0; case.literals.len()]);
    let value = case.program.eval_on_pieces(
        &inputs,
        case.numbers(),
        &[held],
        &mut scratch,
        &mut by,
        &mut by_literal,
    );
    let seen = scratch.seen()[0];
    by.resize(2, 0.0);
    (
        value.expect("a value"),
        [by[0], by[1]],
        seen.piece.expect("a piece"),
        seen.excess,
    )
}

/// Tests points on either side of a switch. Held on its own piece, a function has its usual value and a non-positive excess. Held on the
/// piece of the other point, it follows the formula of that piece.
#[test]
fn held_functions_follow_the_formula_of_their_piece() {
    type Formula = fn(f64, f64) -> (f64, [f64; 2]);
    let cases: [(&str, [f64; 2], [f64; 2], Formula, f64); 13] = [
        (
            "ABS(VARVAL(1))",
            [2.0, 0.0],
            [-3.0, 0.0],
            |x, _| (x, [1.0, 0.0]),
            3.0,
        ),
        (
            "ABS(VARVAL(1))",
            [-2.0, 0.0],
            [3.0, 0.0],
            |x, _| (-x, [-1.0, 0.0]),
            3.0,
        ),
        (
            "DIM(VARVAL(1),VARVAL(2))",
            [2.0, 1.0],
            [1.0, 5.0],
            |a, b| (a - b, [1.0, -1.0]),
            4.0,
        ),
        (
            "DIM(VARVAL(1),VARVAL(2))",
            [1.0, 2.0],
            [7.0, 5.0],
            |_, _| (0.0, [0.0, 0.0]),
            2.0,
        ),
        (
            "SIGN(VARVAL(1),VARVAL(2))",
            [2.0, -1.0],
            [3.0, 4.0],
            |a, _| (-a, [-1.0, 0.0]),
            4.0,
        ),
        (
            "SIGN(VARVAL(1),VARVAL(2))",
            [2.0, -1.0],
            [-3.0, -4.0],
            |a, _| (-a, [-1.0, 0.0]),
            3.0,
        ),
        (
            "MAX(VARVAL(1),0,VARVAL(2))",
            [1.0, 2.0],
            [5.0, 3.0],
            |_, b| (b, [0.0, 1.0]),
            2.0,
        ),
        (
            "MIN(VARVAL(1),VARVAL(2))",
            [1.0, 2.0],
            [5.0, 3.0],
            |a, _| (a, [1.0, 0.0]),
            2.0,
        ),
        (
            "AINT(VARVAL(1))",
            [2.25, 0.0],
            [-1.5, 0.0],
            |_, _| (2.0, [0.0, 0.0]),
            3.5,
        ),
        (
            "INT(VARVAL(1))",
            [-0.75, 0.0],
            [1.5, 0.0],
            |_, _| (0.0, [0.0, 0.0]),
            0.5,
        ),
        (
            "ANINT(VARVAL(1))",
            [-2.25, 0.0],
            [-2.75, 0.0],
            |_, _| (-2.0, [0.0, 0.0]),
            0.25,
        ),
        (
            "MOD(VARVAL(1),VARVAL(2))",
            [5.5, 2.0],
            [7.0, 2.0],
            |a, b| (a - 2.0 * b, [1.0, -2.0]),
            0.5,
        ),
        (
            "MOD(VARVAL(1),VARVAL(2))",
            [-5.5, 2.0],
            [-3.0, 2.0],
            |a, b| (a + 2.0 * b, [1.0, 2.0]),
            0.5,
        ),
    ];
    for (text, here, beyond, formula, excess) in cases {
        let free = compile(text)
            .at([here[0], here[1], 0.0, 0.0])
            .expect("a value");
        let (value, _, piece, unheld) = on(text, here, None);
        assert_eq!((value, unheld), (free, f64::NEG_INFINITY), "{text}");
        let (value, by, same, inside) = on(text, here, Some(piece));
        assert_eq!((value, by), formula(here[0], here[1]), "{text}");
        assert_eq!((value, same), (free, piece), "{text}");
        assert!(inside < 0.0, "{text}: {inside}");
        let (value, by, other, outside) = on(text, beyond, Some(piece));
        assert_eq!((value, by), formula(beyond[0], beyond[1]), "{text}");
        assert_ne!(other, piece, "{text}");
        assert!((outside - excess).abs() < 1e-12, "{text}: {outside}");
    }
}

/// Arguments that are equal up to round-off cause no switch.
#[test]
fn arguments_that_are_equal_but_for_round_off_are_not_beyond() {
    let more = 3.0 * (1.0 + f64::EPSILON);
    for (text, at) in [
        ("MAX(VARVAL(1),VARVAL(2))", [3.0, more]),
        ("MIN(VARVAL(1),VARVAL(2))", [more, 3.0]),
        ("DIM(VARVAL(1),VARVAL(2))", [more, 3.0]),
    ] {
        let (_, _, _, excess) = on(text, at, Some(0));
        assert!(excess < 0.0, "{text}: {excess}");
    }
}

/// A function is not a switch if linear functions of time select its piece, because its switching times are then known in advance. Functions that
/// switch repeatedly, such as MOD, are switches nevertheless. The list states for each switch whether its piece depends on time alone.
#[test]
fn what_the_time_alone_chooses_is_known() {
    for (text, of_time) in [
        (
            "MAX(0,TIME-1)+ABS(2*TIME)+SIGN(1,TIME)+DIM(1,TIME)+MIN(1,2)",
            &[][..],
        ),
        ("MAX(0,VARVAL(1)-TIME)+ABS(SIN(TIME))", &[false, true]),
        ("MOD(TIME,3)+AINT(2*TIME)+ANINT(2)", &[true, true]),
        ("VARVAL(1)*MOD(TIME,VARVAL(1))+MOD(TIME,2)", &[false, true]),
        ("IF(SIN(TIME):1,AINT(VARVAL(1)),2)", &[true, false]),
    ] {
        assert_eq!(compile(text).program.switches(), of_time, "{text}");
    }
}

/// NaN has no integer part, regardless of the piece on which the function is held.
#[test]
fn no_number_has_no_whole_part() {
    for function in ["AINT", "ANINT", "INT", "NINT"] {
        for held in [None, Some(0), Some(2)] {
            let case = compile(&format!("{function}(VARVAL(1))"));
            let (mut by, mut scratch) = ([0.0], EvaluationMemory::default());
            let inputs = case.inputs([f64::NAN, 0.0, 0.0, 0.0]);
            let value = case.program.eval_on_pieces(
                &inputs,
                case.numbers(),
                &[held],
                &mut scratch,
                &mut by,
                &mut vec![0.0; case.literals.len()],
            );
            let error = value.expect_err("no value");
            assert_eq!(error.fault, Fault::NotDefined, "{function}");
        }
    }
}

#[test]
fn numbers_too_large_for_a_whole_number_keep_their_value() {
    for function in ["AINT", "ANINT"] {
        let text = format!("{function}(VARVAL(1))");
        for x in [1e20, -1e300] {
            assert_eq!(on(&text, [x, 0.0], None).0, x, "{text}");
        }
    }
}

/// A function held between its sides is linear from one side to the other over the half width. The excess is zero at this half width.
#[test]
fn held_between_its_sides_a_function_is_a_line() {
    use crate::function::{between, half_width};
    let piece = between(0.3);
    assert_eq!(half_width(Some(piece)), Some(0.25));
    // The line runs from -3 y at x = -0.25 to 5 y at x = 0.25.
    let line = |x: f64, y: f64| (y * (1.0 + 16.0 * x), [16.0 * y, 1.0 + 16.0 * x]);
    let text = "IF(VARVAL(1):-3*VARVAL(2),9,5*VARVAL(2))";
    for x in [-0.25, -0.1, 0.0, 0.2, 0.3] {
        let (value, by, _, excess) = on(text, [x, 2.0], Some(piece));
        let (known, by_known) = line(x, 2.0);
        assert!((value - known).abs() < 1e-14, "{x}: {value}");
        assert!((by[0] - by_known[0]).abs() < 1e-13 && (by[1] - by_known[1]).abs() < 1e-14);
        assert!((excess - (x.abs() - 0.25)).abs() < 1e-15);
        let (value, by, side, excess) = on("SIGN(VARVAL(2),VARVAL(1))", [x, -2.0], Some(piece));
        assert!((value - 8.0 * x).abs() < 1e-14);
        assert_eq!(by, [-4.0 * x, 8.0]);
        assert_eq!(side, if x < 0.0 { 3 } else { 1 });
        assert!((excess - (x.abs() - 0.25)).abs() < 1e-15);
    }
    // An IF nested in a part of another: the inner IF keeps its own side.
    let case = compile("IF(VARVAL(1):IF(VARVAL(2):1,2,3),0,7)+VARVAL(2)");
    let inputs = case.inputs([0.125, -1.0, 0.0, 0.0]);
    let (mut by, mut by_literal) = (vec![0.0; inputs.len()], vec![0.0; case.literals.len()]);
    let value = case.program.eval_on_pieces(
        &inputs,
        case.numbers(),
        &[Some(piece), None],
        &mut EvaluationMemory::default(),
        &mut by,
        &mut by_literal,
    );
    // A quarter of 1 plus three quarters of 7, minus 1.
    assert_eq!(value, Ok(4.5));
}
