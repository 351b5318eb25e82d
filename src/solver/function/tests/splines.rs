//! Tests of splines against the examples of their papers and of the manual.

use super::{near, refused, value};
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
