//! Tests of splines against the examples of their papers and of the manual.

use super::{Case, EvaluationMemory, compile, model, near, refused, value};
use admire_syntax::diagnostic::Code;

#[test]
fn akima_goes_through_the_example_of_the_paper() {
    near("AKISPL(4.5,0,1)", 10.0);
    // Slopes by hand: 0 at 5, 17.5/31 at 6, 252.5/29 at 7, 19.375 at 9, 32.5 at 10; the middle is the mean of y plus (t0 - t1)/8.
    near("AKISPL(5.5,0,1)", 10.25 - 17.5 / 31.0 / 8.0);
    near(
        "AKISPL(6.5,0,1)",
        12.75 + (17.5 / 31.0 - 252.5 / 29.0) / 8.0,
    );
    near("AKISPL(9.5,0,1)", 72.5 + (19.375 - 32.5) / 8.0);
    near("AKISPL(9,0,1,1)", 19.375);
    // Beyond the end: the parabola through (8, 50), (9, 60), (10, 85).
    near("AKISPL(11,0,1)", 125.0);
    near("AKISPL(11,0,1,1)", 47.5);
    near("AKISPL(11,0,1,2)", 15.0);
    near("AKISPL(-3,0,1)", 10.0);
}

#[test]
fn cubic_and_linear_interpolation_and_straight_extrapolation() {
    // The natural spline through (0,0), (1,1), (2,0): second derivative -3 at the middle.
    near("CUBSPL(0.5,0,3)", 0.6875);
    near("CUBSPL(0,0,3,1)", 1.5);
    near("CUBSPL(1,0,3,2)", -3.0);
    near("CUBSPL(0,0,3,2)", 0.0);
    near("INTERP(0.5,3,3)", 0.6875);
    near("INTERP(2,1,4)", 0.5);
    near("INTERP(2,1,4,1)", -0.5);
    for method in ["AKISPL(6,0,4)", "CUBSPL(6,0,4)", "INTERP(6,1,4)"] {
        near(method, 6.0);
    }
    near("AKISPL(-2,0,4)", -2.0);
}

/// The worked examples of AKIMA_SPLINE (`adams_view_fn/akima.html`) and of SPLINE with CSPLINE (`spline.html`). For the spline through four
/// points with y = 0, 2, 1, 3, the manual prints ten values to three decimals.
#[test]
fn splines_reproduce_the_examples_of_the_manual() {
    let akima = [0.0, 1.0, 1.667, 2.0, 1.778, 1.222, 1.0, 1.333, 2.0, 3.0];
    let cubic = [0.0, 0.963, 1.704, 2.0, 1.741, 1.259, 1.0, 1.296, 2.037, 3.0];
    for (function, printed) in [("AKISPL", akima), ("CUBSPL", cubic)] {
        for (k, printed) in printed.into_iter().enumerate() {
            let found = value(&format!("{function}(1+{k}/3,0,6)"));
            assert!(
                (found - printed).abs() <= 5.01e-4,
                "{function} {k}: {found}"
            );
        }
    }
}

#[test]
fn surfaces_are_linear_between_their_curves() {
    near("AKISPL(1.5,-1,2)", 2.25);
    near("AKISPL(1.5,1,2)", 0.75);
    near("AKISPL(1.5,0.5,2)", 0.25 * 2.25 + 0.75 * 0.75);
    near("AKISPL(1.5,3,2)", 2.25 + 2.0 * (0.75 - 2.25));
    near("AKISPL(5,-1,2)", 25.0);
    assert_eq!(refused("AKISPL(1,0,2,1)").0, Code::BadExpression);
    assert_eq!(refused("AKISPL(1,0,5)").0, Code::BadExpression);
}

/// Returns the value of a function of VARIABLE/1, and its derivative with respect to a point of a SPLINE.
fn with_knot(case: &Case, x: f64, point: (usize, usize)) -> (f64, f64) {
    let inputs = case.inputs([x, 0.0, 0.0, 0.0]);
    let mut memory = EvaluationMemory::default();
    let (mut by, mut by_literal) = (vec![0.0; inputs.len()], vec![0.0; case.literals.len()]);
    let value = case.program.eval_with_derivatives(
        &inputs,
        case.numbers(),
        &mut memory,
        &mut by,
        &mut by_literal,
    );
    let by_knot = case.program.by_knot(&case.curves, point, &memory);
    (value.expect("a value"), by_knot)
}

/// Compares the derivatives with differences for every method and order, inside a curve and beyond its ends, and for several uses of one
/// SPLINE in a function.
#[test]
fn derivatives_by_the_points_agree_with_differences() {
    let splines = model().splines;
    let mut compared = 0;
    for id in [1, 3, 4, 6] {
        let at = splines.iter().position(|spline| spline.header.id == id);
        let at = at.expect("a spline of the test");
        let knots = splines[at].y[0].clone();
        for text in [
            format!("AKISPL(VARVAL(1),0,{id})"),
            format!("CUBSPL(VARVAL(1),0,{id})"),
            format!("INTERP(VARVAL(1),1,{id})"),
            format!("AKISPL(VARVAL(1),0,{id},1)+2*CUBSPL(VARVAL(1),0,{id},2)"),
            format!("AKISPL(CUBSPL(VARVAL(1),0,{id}),0,{id})**2"),
            format!("IF(VARVAL(1)-2:AKISPL(VARVAL(1),0,{id}),0,CUBSPL(VARVAL(1),0,{id}))"),
        ] {
            let mut case = compile(&text);
            for x in [-0.7, 0.3, 1.6, 2.4, 3.7, 12.5] {
                for (knot, &y) in knots.iter().enumerate() {
                    let (value, exact) = with_knot(&case, x, (at, knot));
                    let mut moved = |h: f64| {
                        case.curves.set(at, knot, y + h);
                        let moved = with_knot(&case, x, (at, knot));
                        case.curves.set(at, knot, y);
                        moved
                    };
                    let h = 1e-5;
                    let (above, below) = (moved(h), moved(-h));
                    let difference = (above.0 - below.0) / (2.0 * h);
                    let scale = 1.0 + exact.abs() + value.abs();
                    // The weights of Akima's rule have kinks.
                    let is_smooth = |side: f64| (side - exact).abs() < 1e-3 * (1.0 + exact.abs());
                    if is_smooth(above.1) && is_smooth(below.1) {
                        compared += 1;
                        assert!(
                            (difference - exact).abs() < 1e-5 * scale,
                            "{text} at {x} by {knot}: {exact}, by differences {difference}"
                        );
                    }
                }
            }
        }
    }
    assert!(compared > 500, "{compared}");
}

/// If all points are multiplied by a common factor, so is the curve. The derivative along the points thus equals the value, even where
/// Akima's weights vanish.
#[test]
fn a_common_factor_of_all_points_scales_the_curve() {
    for text in ["AKISPL(VARVAL(1),0,4)", "AKISPL(VARVAL(1),0,1)"] {
        let case = compile(text);
        let id = if text.contains('4') { 4 } else { 1 };
        let splines = model().splines;
        let at = splines.iter().position(|spline| spline.header.id == id);
        let at = at.expect("a spline of the test");
        for x in [0.2, 1.0, 2.5, 5.5] {
            let along = splines[at].y[0].iter().enumerate();
            let sum: f64 = along
                .map(|(knot, y)| y * with_knot(&case, x, (at, knot)).1)
                .sum();
            let value = with_knot(&case, x, (at, 0)).0;
            assert!(
                (sum - value).abs() < 1e-12 * (1.0 + value.abs()),
                "{text}: {sum} {value}"
            );
        }
    }
}
