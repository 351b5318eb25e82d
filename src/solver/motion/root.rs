/// Largest number of function evaluations; even bisection alone needs fewer.
const MOST: usize = 100;

/// Narrows a bracket around a sign change to the width `exact`, or to round-off if that is larger, and returns its ends. The function is at
/// most zero at the start of the bracket and above zero at its end. The narrowed bracket has the same signs.
///
/// Chandrupatla's method: inverse quadratic interpolation where it is safe, otherwise bisection (T. R. Chandrupatla, A new hybrid
/// quadratic/bisection algorithm, Advances in Engineering Software 28, 1997).
pub(super) fn narrow_bracket(
    mut f: impl FnMut(f64) -> f64,
    (start, at_start): (f64, f64),
    (end, at_end): (f64, f64),
    exact: f64,
) -> (f64, f64) {
    let (mut x1, mut f1) = (end, at_end);
    let (mut x2, mut f2) = (start, at_start);
    let mut share = 0.5;
    for _ in 0..MOST {
        let x = x1 + share * (x2 - x1);
        if x == x1 || x == x2 {
            break;
        }
        let fx = f(x);
        let (x3, f3);
        if (fx > 0.0) == (f1 > 0.0) {
            (x3, f3) = (x1, f1);
        } else {
            (x3, f3) = (x2, f2);
            (x2, f2) = (x1, f1);
        }
        (x1, f1) = (x, fx);
        let width = (x2 - x1).abs();
        let least = 0.5 * exact.max(2.0 * f64::EPSILON * x1.abs().max(x2.abs()));
        if width <= 2.0 * least {
            break;
        }
        let xi = (x1 - x2) / (x3 - x2);
        let phi = (f1 - f2) / (f3 - f2);
        share = if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
            f1 / (f2 - f1) * f3 / (f2 - f3)
                + (x3 - x1) / (x2 - x1) * (f1 / (f3 - f1)) * (f2 / (f3 - f2))
        } else {
            0.5
        };
        let margin = (least / width).min(0.5);
        share = share.clamp(margin, 1.0 - margin);
    }
    if f1 > 0.0 { (x2, x1) } else { (x1, x2) }
}

#[cfg(test)]
mod tests {
    use super::narrow_bracket;

    #[test]
    fn roots_are_found_to_the_last_digit_and_kept_between_the_ends() {
        let cases: [(fn(f64) -> f64, f64, f64, f64); 5] = [
            (|x| x * x - 2.0, 0.0, 3.0, 2.0_f64.sqrt()),
            (|x| 1.0 - (-x).exp() * 3.0, 0.0, 9.0, 3.0_f64.ln()),
            (|x| (x - 1.0).powi(9), -4.0, 3.0, 1.0),
            (|x| if x < 0.7 { -1.0 } else { 1.0 }, 0.0, 1.0, 0.7),
            (|x| x - 1e-9, 0.0, 1.0, 1e-9),
        ];
        for (f, start, end, root) in cases {
            let mut count = 0;
            let counted = |x: f64| {
                count += 1;
                f(x)
            };
            let (before, after) = narrow_bracket(counted, (start, f(start)), (end, f(end)), 0.0);
            assert!(f(before) <= 0.0 && f(after) > 0.0);
            assert!(
                after - before <= 4.0 * f64::EPSILON * root.max(1e-8),
                "{before} {after}"
            );
            assert!(
                (before - root).abs() < 1e-12 || root == 1.0,
                "{before} {root}"
            );
            assert!(count <= 100, "{count}");
        }
    }

    #[test]
    fn smooth_functions_take_few_evaluations() {
        let mut count = 0;
        let f = |x: f64| {
            count += 1;
            x.exp() - 2.0
        };
        let (before, after) = narrow_bracket(f, (0.0, -1.0), (3.0, 18.0), 1e-14);
        assert!(before <= 2.0_f64.ln() && 2.0_f64.ln() <= after);
        assert!(count < 16, "{count}");
    }
}
