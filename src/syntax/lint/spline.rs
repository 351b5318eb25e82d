use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};

/// Reports splines whose x values do not increase, and splines that do not have one y value for each x value.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for spline in context.of_kind("SPLINE") {
        let title = context.title(spline);
        let x = spline.numbers("X");
        for pair in x.windows(2) {
            if pair[1].value <= pair[0].value {
                let message = format!("the x values of {title} do not increase here");
                found.push(
                    context
                        .error(Code::SplineNotIncreasing, pair[1].span, message)
                        .help("sort the points by x, and keep only one point for each x"),
                );
                break;
            }
        }
        let rows: Vec<_> = spline.all("Y").collect();
        // If the spline is a surface, each row of values begins with its z value.
        let wanted = x.len() + usize::from(rows.len() > 1);
        let mut before = f64::NEG_INFINITY;
        for row in &rows {
            let y = row.numbers();
            if !x.is_empty() && !y.is_empty() && y.len() != wanted {
                let message = format!("{title} needs {wanted} values here, not {}", y.len());
                let help = if rows.len() > 1 {
                    "each Y of a surface begins with its z, followed by one value for each x"
                } else {
                    "write one value for each x"
                };
                found.push(
                    context
                        .error(Code::WrongCount, row.value_span(), message)
                        .help(help),
                );
            }
            if let (Some(z), true) = (y.first(), rows.len() > 1) {
                if z.value <= before {
                    let message = format!("the z values of {title} do not increase here");
                    found.push(
                        context
                            .error(Code::SplineNotIncreasing, z.span, message)
                            .help("sort the Y arguments by z, their first value"),
                    );
                }
                before = z.value;
            }
        }
    }
}
