//! Break times: times at which a function of time is not smooth, such as the ends of steps and sweeps and the zeros of IF conditions.

use admire_syntax::Expression;
use admire_syntax::expression::{BinaryOperator, Constant, Node};

/// Functions that compare their first argument with the arguments at the listed positions (counted from 0).
const ENDS: [(&str, &[usize]); 4] = [
    ("STEP", &[1, 3]),
    ("STEP5", &[1, 3]),
    ("HAVSIN", &[1, 3]),
    ("SWEEP", &[2, 4]),
];

/// Returns the break times of an expression, in no particular order. At a break time, an argument that is linear in TIME equals the value
/// that the function compares it with. Splines have no breaks, because their pieces join smoothly.
pub(crate) fn time_breaks(expression: &Expression) -> Vec<f64> {
    let mut found = Vec::new();
    for node in expression.root.walk() {
        match node {
            Node::If(parts) => {
                found.extend(meeting(expression, &parts[0], 0.0));
            }
            Node::Call {
                function,
                arguments,
                ..
            } => {
                let all = || arguments.iter().enumerate();
                match function.name {
                    "ABS" | "SIGN" => {
                        found.extend(all().filter_map(|(_, a)| meeting(expression, a, 0.0)));
                    }
                    "MAX" | "MIN" | "DIM" => {
                        let lines = arguments.iter().filter_map(|a| linear(expression, a));
                        let sign = if function.name == "MIN" { -1.0 } else { 1.0 };
                        found.extend(corners(lines.map(|(a, b)| (sign * a, sign * b))));
                    }
                    name => {
                        let known = ENDS.iter().find(|(of, _)| *of == name);
                        let (Some((_, ends)), Some(compared)) = (known, arguments.first()) else {
                            continue;
                        };
                        for end in ends.iter().filter_map(|at| arguments.get(*at)) {
                            if let Some((0.0, value)) = linear(expression, end) {
                                found.extend(meeting(expression, compared, value));
                            }
                        }
                    }
                }
            }
            _ => {}
        }
    }
    found
}

/// Returns the times at which another of the lines `a TIME + b` becomes the largest. These are the corners of the upper envelope of the
/// lines, found by sorting the slopes.
fn corners(lines: impl Iterator<Item = (f64, f64)>) -> Vec<f64> {
    let mut lines: Vec<(f64, f64)> = lines.filter(|(a, b)| (a * b).is_finite()).collect();
    lines.sort_by(|(a, b), (c, d)| a.total_cmp(c).then(b.total_cmp(d)));
    // Lines of the envelope, each with the time from which it is the largest line.
    let mut hull: Vec<((f64, f64), f64)> = Vec::new();
    for line in lines {
        let mut from = f64::NEG_INFINITY;
        while let Some(&((a, b), before)) = hull.last() {
            from = (b - line.1) / (line.0 - a);
            if a == line.0 || from <= before {
                // The earlier line is nowhere the largest: the new line has the same slope and is not lower, or overtakes it too soon.
                hull.pop();
                from = f64::NEG_INFINITY;
            } else {
                break;
            }
        }
        hull.push((line, from));
    }
    hull.into_iter().skip(1).map(|(_, from)| from).collect()
}

/// Returns the time at which a node that is linear in TIME reaches `value`.
fn meeting(expression: &Expression, node: &Node, value: f64) -> Option<f64> {
    let (slope, start) = linear(expression, node)?;
    zero((slope, start - value))
}

/// Returns the zero of `slope TIME + start`.
fn zero((slope, start): (f64, f64)) -> Option<f64> {
    let time = -start / slope;
    (slope != 0.0 && time.is_finite()).then_some(time)
}

/// Returns (a, b) if the node equals `a TIME + b`.
pub(super) fn linear(expression: &Expression, node: &Node) -> Option<(f64, f64)> {
    let of = |node: &Node| linear(expression, node);
    Some(match node {
        Node::Literal(k) => (0.0, expression.literals.get(*k)?.value),
        Node::Constant(Constant::Pi) => (0.0, std::f64::consts::PI),
        Node::Constant(Constant::Rtod) => (0.0, 1.0_f64.to_degrees()),
        Node::Constant(Constant::Dtor) => (0.0, 1.0_f64.to_radians()),
        Node::Name(function) if function.name == "TIME" => (1.0, 0.0),
        Node::Negate(inner) => {
            let (a, b) = of(inner)?;
            (-a, -b)
        }
        Node::Binary(operator, left, right) => {
            let ((a, b), (c, d)) = (of(left)?, of(right)?);
            match operator {
                BinaryOperator::Add => (a + c, b + d),
                BinaryOperator::Subtract => (a - c, b - d),
                BinaryOperator::Multiply if a == 0.0 => (b * c, b * d),
                BinaryOperator::Multiply if c == 0.0 => (a * d, b * d),
                BinaryOperator::Divide if c == 0.0 => (a / d, b / d),
                _ => return None,
            }
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn breaks_are_where_linear_arguments_meet_constants() {
        for (text, expected) in [
            ("STEP(TIME,0.1,0,0.2,1)", &[0.1, 0.2][..]),
            ("3*STEP5(2*(TIME-1),-1,0,PI/PI,1)+DX(1)", &[0.5, 1.5]),
            ("IF(TIME-0.3: 0, 1, IF(5-TIME/2: 1, 2, 3))", &[0.3, 10.0]),
            ("ABS(TIME-2)+HAVSIN(-TIME,-4,0,-3,1)", &[2.0, 3.0, 4.0]),
            ("SWEEP(TIME,1,0.5,2,8,3,0.1)", &[0.5, 8.0]),
            ("SIGN(TIME-3,1-TIME)", &[1.0, 3.0]),
            // At 2.5, the two other lines intersect below the largest.
            ("MAX(0,TIME-2,2*TIME-5)+MIN(1,1,DX(1))", &[2.0, 3.0]),
            ("MIN(3,TIME,4*TIME-3,DX(1),2)", &[1.0, 2.0]),
            ("DIM(1,0.25*TIME)+DIM(TIME,DX(1))", &[4.0]),
            ("STEP(DX(1),0,0,1,1)+SIN(TIME)+STEP(TIME**2,1,0,2,1)", &[]),
            ("STEP(TIME,TIME,0,VARVAL(1),1)", &[]),
        ] {
            let expression = Expression::parse_str(text).unwrap();
            let mut found = time_breaks(&expression);
            found.sort_by(f64::total_cmp);
            assert_eq!(found.len(), expected.len(), "{text}: {found:?}");
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12, "{text}: {found}");
            }
        }
    }
}
