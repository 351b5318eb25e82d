use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};

/// Largest accepted relative excess of the largest principal moment over the sum of the other two; it allows for the rounding of printed
/// moments.
const ROUNDING: f64 = 1e-3;

/// Two moments smaller than this fraction of the third moment count as not specified.
const NOT_STATED: f64 = 1e-3;

/// Reports physically impossible inertias: a principal moment is negative or exceeds the sum of the other two.
///
/// For a body that rotates about one axis only, a deck may specify just the moment about this axis and leave the others at or near zero.
/// This is not reported.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for part in context.of_kind("PART") {
        let values: Vec<f64> = part.numbers("IP").iter().map(|ip| ip.value).collect();
        let (Some(argument), [xx, yy, zz, products @ ..]) = (part.argument("IP"), &values[..])
        else {
            continue;
        };
        // IP contains the products of inertia as positive integrals (`state_part`), so their sign is reversed here.
        let product = |k: usize| -products.get(k).copied().unwrap_or(0.0);
        let (xy, xz, yz) = (product(0), product(1), product(2));
        let tensor = [[*xx, xy, xz], [xy, *yy, yz], [xz, yz, *zz]];
        if [xx, yy, zz].iter().any(|moment| !(**moment > 0.0)) {
            continue;
        }
        let [small, middle, large] = principal_moments(tensor);
        if middle < NOT_STATED * large && small > -NOT_STATED * large {
            continue;
        }
        let title = context.title(part);
        let shown = |value: f64| format!("{value:.4e}").parse::<f64>().unwrap_or(value);
        let fault = if small < -ROUNDING * large {
            format!(
                "the principal moment of inertia {} of {title} is negative",
                shown(small)
            )
        } else if large > (small.max(0.0) + middle) * (1.0 + ROUNDING) {
            format!(
                "no rigid body can have the moments of inertia of {title}: the largest principal moment {} exceeds the sum of the others, {} and {}",
                shown(large),
                shown(middle),
                shown(small)
            )
        } else {
            continue;
        };
        found.push(
            context
                .warning(Code::ImpossibleInertia, argument.value_span(), fault)
                .help("IP is Ixx, Iyy, Izz, Ixy, Ixz, Iyz, with Ixy the integral of +x*y dm"),
        );
    }
}

/// Computes the eigenvalues of a symmetric tensor in increasing order by Jacobi rotations (Golub and Van Loan, Matrix Computations, section
/// 8.5).
fn principal_moments(mut a: [[f64; 3]; 3]) -> [f64; 3] {
    let size = a.iter().flatten().map(|x| x.abs()).sum::<f64>();
    // The off-diagonal elements converge quadratically, so five sweeps suffice. The limit of 60 ends the loop for values that are not
    // finite.
    for _ in 0..60 {
        let beside = a[0][1].abs() + a[0][2].abs() + a[1][2].abs();
        if !(beside > 1e-3 * f64::EPSILON * size) {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = tau.signum() / (tau.abs() + (1.0 + tau * tau).sqrt());
            let c = 1.0 / (1.0 + t * t).sqrt();
            let s = t * c;
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            for k in 0..3 {
                (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
            }
        }
    }
    let mut moments = [a[0][0], a[1][1], a[2][2]];
    moments.sort_by(f64::total_cmp);
    moments
}

#[cfg(test)]
mod tests {
    use super::principal_moments;

    #[test]
    fn principal_moments_are_those_of_a_turned_body() {
        // Moments 1, 2 and 4, rotated about z by 30 degrees and then about x by 45 degrees.
        let (c, s, h) = (0.75_f64.sqrt(), 0.5, 0.5_f64.sqrt());
        let R = [[c, -s, 0.0], [h * s, h * c, -h], [h * s, h * c, h]];
        let mut tensor = [[0.0; 3]; 3];
        for (i, row) in tensor.iter_mut().enumerate() {
            for (j, x) in row.iter_mut().enumerate() {
                *x = (0..3).map(|k| R[i][k] * [1.0, 2.0, 4.0][k] * R[j][k]).sum();
            }
        }
        let found = principal_moments(tensor);
        for (found, wanted) in found.iter().zip([1.0, 2.0, 4.0]) {
            assert!((found - wanted).abs() < 1e-14, "{found}");
        }
    }

    #[test]
    fn moments_of_a_diagonal_tensor_are_its_own() {
        let tensor = [[3.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 2.0]];
        assert_eq!(principal_moments(tensor), [-1.0, 2.0, 3.0]);
    }
}
