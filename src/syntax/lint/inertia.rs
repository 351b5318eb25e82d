use nalgebra::Matrix3;

use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};

/// By so much, as a share, the largest moment may exceed the sum of the others: digits that were cut off when it was printed.
const ROUNDING: f64 = 1e-3;

/// Two moments below this share of the third stand for "not stated".
const NOT_STATED: f64 = 1e-3;

/// Inertias no body has: a principal moment below zero, or larger than the sum of the two others. A body that turns about one axis
/// only may state that moment alone and leave the others at zero or near it, which is not reported.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for part in context.of_kind("PART") {
        let values: Vec<f64> = part.numbers("IP").iter().map(|ip| ip.value).collect();
        let (Some(argument), [xx, yy, zz, products @ ..]) = (part.argument("IP"), &values[..])
        else {
            continue;
        };
        // IP gives the products as positive integrals (`state_part`).
        let product = |k: usize| -products.get(k).copied().unwrap_or(0.0);
        let (xy, xz, yz) = (product(0), product(1), product(2));
        let tensor = Matrix3::new(*xx, xy, xz, xy, *yy, yz, xz, yz, *zz);
        if [xx, yy, zz].iter().any(|moment| !(**moment > 0.0)) {
            continue;
        }
        let mut moments: Vec<f64> = tensor.symmetric_eigenvalues().iter().copied().collect();
        moments.sort_by(f64::total_cmp);
        let [small, middle, large] = moments[..] else {
            continue;
        };
        if middle < NOT_STATED * large && small > -NOT_STATED * large {
            continue;
        }
        let title = context.title(part);
        let shown = |value: f64| format!("{value:.4e}").parse::<f64>().unwrap_or(value);
        let fault = if small < -ROUNDING * large {
            format!(
                "{} is a principal moment of inertia of {title}, and none is below zero",
                shown(small)
            )
        } else if large > (small.max(0.0) + middle) * (1.0 + ROUNDING) {
            format!(
                "no body has the moments of inertia of {title}: the largest principal moment {} exceeds the sum of the others, {} and {}",
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
                .help("IP is Ixx, Iyy, Izz, Ixy, Ixz, Iyz, with products as positive integrals"),
        );
    }
}
