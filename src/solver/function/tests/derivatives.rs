//! Derivatives of numeric functions against central differences.

use super::{Curves, EvaluationMemory, ProgramNumbers, compile};

/// Small linear congruential generator, which makes the test points reproducible on every machine.
struct Points(u64);

impl Points {
    fn next(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }
}

fn with<'a>(curves: &'a Curves, literals: &'a [f64]) -> ProgramNumbers<'a> {
    ProgramNumbers { literals, curves }
}

/// Checks derivatives with respect to inputs and literals against central differences at random points.
fn check_derivatives(text: &str) {
    let case = compile(text);
    let program = &case.program;
    let mut points = Points(text.len() as u64 + 17);
    let mut scratch = EvaluationMemory::default();
    let (n, m) = (program.inputs.len(), case.literals.len());
    for _ in 0..25 {
        let inputs: Vec<f64> = (0..n).map(|_| points.next(0.2, 1.8)).collect();
        let literals: Vec<f64> = case
            .literals
            .iter()
            .enumerate()
            .map(|(k, &v)| {
                if program.parameters.contains(&k) {
                    v * points.next(0.98, 1.02)
                } else {
                    v
                }
            })
            .collect();
        let (mut by_input, mut by_literal) = (vec![0.0; n], vec![0.0; m]);
        let value = program
            .eval_with_derivatives(
                &inputs,
                with(&case.curves, &literals),
                &mut scratch,
                &mut by_input,
                &mut by_literal,
            )
            .expect("it has a value here");
        let again = program.eval(&inputs, with(&case.curves, &literals), &mut scratch);
        assert_eq!(Ok(value), again);
        let mut compare = |all: Vec<f64>, k: usize, exact: f64| {
            let at = |h: f64, scratch: &mut EvaluationMemory| {
                let mut moved = all.clone();
                moved[k] += h;
                program
                    .eval(&moved[..n], with(&case.curves, &moved[n..]), scratch)
                    .expect("it has a value here")
            };
            let h = 1e-5;
            let difference = (at(h, &mut scratch) - at(-h, &mut scratch)) / (2.0 * h);
            // A second difference with half the step shows whether a kink lies within the step.
            let finer = (at(h / 2.0, &mut scratch) - at(-h / 2.0, &mut scratch)) / h;
            let scale = 1.0 + exact.abs() + value.abs();
            if (difference - finer).abs() < 1e-6 * scale {
                assert!(
                    (difference - exact).abs() < 1e-5 * scale,
                    "{text}: by {k} {exact}, by differences {difference}"
                );
            }
        };
        let all: Vec<f64> = inputs.iter().chain(&literals).copied().collect();
        for k in 0..n {
            compare(all.clone(), k, by_input[k]);
        }
        for &k in &program.parameters {
            compare(all.clone(), n + k, by_literal[k]);
        }
    }
}

/// Expressions that together contain every numeric function, evaluated inside its domain.
const SMOOTH: [&str; 25] = [
    "VARVAL(1)*VARVAL(2)/VARVAL(3)-VARVAL(1)**VARVAL(2)",
    "VARVAL(1)**2+VARVAL(2)**3-2**VARVAL(3)+(-VARVAL(1))**INT(2.5)",
    "ABS(VARVAL(1)-1)+AINT(VARVAL(2)*3)+SIGN(VARVAL(1),VARVAL(2)-1)",
    "ANINT(VARVAL(1)*3)*VARVAL(2)+NINT(VARVAL(3)*3)",
    "ACOS(VARVAL(1)/2)+ASIN(VARVAL(2)/2)+ATAN(VARVAL(3))",
    "ATAN2(VARVAL(1),VARVAL(2)-1)+DIM(VARVAL(1),VARVAL(2))+MOD(VARVAL(3)*5,VARVAL(1))",
    "COS(VARVAL(1))*COSH(VARVAL(2))+SIN(VARVAL(1))*SINH(VARVAL(2))+TAN(VARVAL(3)/2)+TANH(VARVAL(3))",
    "EXP(VARVAL(1))*LOG(VARVAL(2))+LOG10(VARVAL(3))-SQRT(VARVAL(1))",
    "MAX(VARVAL(1),VARVAL(2),VARVAL(3))*MIN(VARVAL(1),VARVAL(2))",
    "STEP(VARVAL(1),0.3,VARVAL(2),1.5,VARVAL(3))+STEP(VARVAL(2),1.5,1,0.2,7)",
    "STEP5(VARVAL(1),VARVAL(2)*0.1,1,1+VARVAL(3),5)",
    "HAVSIN(VARVAL(1),VARVAL(2)*0.1,1,1+VARVAL(3),5)",
    "IMPACT(VARVAL(1),VARVAL(2)-1,1.2,50,1.7,3,0.4)",
    "BISTOP(VARVAL(1),VARVAL(2)-1,0.7,1.2,50,1.7,3,0.4)",
    "POLY(VARVAL(1),0.3,1,VARVAL(2),3,4)",
    "CHEBY(VARVAL(1),0.3,1,VARVAL(2),3,4,5)",
    "SHF(VARVAL(1),0.3,VARVAL(2),3,40D,5)+SHF(VARVAL(3),0.1,2,3,4)",
    "FORCOS(VARVAL(1),0.3,VARVAL(2),1,2,3)",
    "FORSIN(VARVAL(1),0.3,VARVAL(2),1,2,3)",
    "SWEEP(VARVAL(1),VARVAL(2),0.4,0.5,1.3,1.1,0.5)",
    "AKISPL(VARVAL(1)*5,0,1)+CUBSPL(VARVAL(2)*5,0,1)+INTERP(VARVAL(3)*5,1,1)",
    "AKISPL(VARVAL(1)*5,0,1,1)+CUBSPL(VARVAL(2)*6,0,4,1)+CUBSPL(VARVAL(2)*6,0,4,2)",
    "AKISPL(VARVAL(1)*2.5-0.3,VARVAL(2)*2-2,2)+CUBSPL(VARVAL(3)*2.5-0.3,VARVAL(2),2)",
    "IF(VARVAL(1)-1:VARVAL(2)**2,0,IF(VARVAL(3)-1:SIN(VARVAL(1)),1,VARVAL(2)*VARVAL(1)))*VARVAL(1)",
    "VARVAL(1)*(VARVAL(2)+VARVAL(1)*(VARVAL(3)-VARVAL(1)))",
];

#[test]
fn derivatives_are_those_of_central_differences() {
    for text in SMOOTH {
        check_derivatives(text);
    }
}

/// `SMOOTH` covers all numeric functions. Functions that measure the state are checked in whole decks (tests/solver/functions.rs).
#[test]
fn every_function_of_numbers_is_among_them() {
    use admire_syntax::grammar::{FUNCTIONS, Solved};
    for def in FUNCTIONS {
        let Solved::Native(kind) = def.solved else {
            continue;
        };
        if matches!(kind, "arithmetic" | "series" | "control") {
            let call = format!("{}(", def.name);
            assert!(SMOOTH.iter().any(|text| text.contains(&call)), "{call}");
        }
    }
}

/// Expressions whose second time derivatives always exist if only VARVAL(1) varies. They exclude IMPACT and BISTOP, which have no second
/// derivatives.
const BENT: [&str; 10] = [
    "SWEEP(VARVAL(1),2,0.4,0.5,1.3,1.1,0.5)*VARVAL(1)",
    "SWEEP(VARVAL(1),2,0.4,0.5,1.3,1.1,0)+SWEEP(VARVAL(1),2,0.9,5,1.3,1.1,0.6)",
    "CUBSPL(VARVAL(1)*5,0,1)*AKISPL(VARVAL(1)*5,0,1)",
    "STEP(VARVAL(1),0.3,1,1.5,SIN(9*VARVAL(1)))*STEP5(VARVAL(1),0.1,1,2,5)+HAVSIN(VARVAL(1),0.1,1,2,5)",
    "POLY(VARVAL(1),0.3,1,2,3,4,5)+CHEBY(VARVAL(1),0.3,1,2,3,4,5)",
    "FORCOS(VARVAL(1),0.3,2,1,2,3)/FORSIN(VARVAL(1)+4,0.3,2,9,2,3)+SHF(VARVAL(1),0.3,2,3,40D,5)",
    "ATAN2(VARVAL(1)**2,VARVAL(1)-1)*ACOS(VARVAL(1)/2)+ASIN(VARVAL(1)/2)*ATAN(VARVAL(1))",
    "COSH(VARVAL(1))*SINH(VARVAL(1))/TAN(VARVAL(1)/2)+TANH(VARVAL(1))*EXP(VARVAL(1))",
    "LOG(VARVAL(1))*LOG10(VARVAL(1))+SQRT(VARVAL(1))-(1/VARVAL(1))**VARVAL(1)+2**VARVAL(1)",
    "IF(VARVAL(1)-1:COS(VARVAL(1)),0,VARVAL(1)**3)*VARVAL(1)",
];

/// Second time derivatives along `x + x' t + x'' t^2 / 2` agree with differences of the first time derivatives.
#[test]
fn second_rates_are_those_of_differences() {
    let mut points = Points(5);
    let mut scratch = EvaluationMemory::default();
    let mut found = 0;
    for (text, sure) in BENT
        .iter()
        .map(|text| (text, true))
        .chain(SMOOTH.iter().map(|text| (text, false)))
    {
        let case = compile(text);
        let program = &case.program;
        for _ in 0..25 {
            let along: Vec<[f64; 3]> = (0..program.inputs.len())
                .map(|_| {
                    [
                        points.next(0.2, 1.8),
                        points.next(0.5, 2.0),
                        points.next(-1.0, 1.0),
                    ]
                })
                .collect();
            let mut at = |t: f64| {
                let inputs: Vec<f64> = along
                    .iter()
                    .map(|[x, v, a]| x + t * (v + 0.5 * t * a))
                    .collect();
                let rates: Vec<[f64; 2]> = along.iter().map(|[_, v, a]| [v + t * a, *a]).collect();
                let value = program.eval_with_derivatives(
                    &inputs,
                    case.numbers(),
                    &mut scratch,
                    &mut vec![0.0; inputs.len()],
                    &mut vec![0.0; case.literals.len()],
                );
                value.expect("it has a value here");
                program.rates_along(&rates, &case.curves, &mut scratch)
            };
            let h = 1e-5;
            let Some([_, exact]) = at(0.0) else {
                assert!(!sure, "{text}");
                continue;
            };
            let mut slope = |h: f64| Some((at(h)?[0] - at(-h)?[0]) / (2.0 * h));
            let (Some(difference), Some(finer)) = (slope(h), slope(0.5 * h)) else {
                continue;
            };
            let scale = 1.0 + exact.abs();
            if (difference - finer).abs() < 1e-6 * scale {
                found += 1;
                assert!(
                    (difference - exact).abs() < 1e-5 * scale,
                    "{text}: {exact}, by differences {difference}"
                );
            }
        }
    }
    assert!(found > 500, "{found}");
}

/// At the edges of domains and pieces, the derivative equals a one-sided derivative or lies between the two one-sided derivatives. It is
/// zero where a side is infinitely steep.
#[test]
fn derivatives_at_edges_are_those_of_a_side() {
    for (text, edge) in [
        ("ABS(VARVAL(1))", 0.0),
        ("DIM(VARVAL(1),1)", 1.0),
        ("MAX(VARVAL(1),1)", 1.0),
        ("MIN(VARVAL(1),1)", 1.0),
        ("SIGN(VARVAL(1),VARVAL(1))", 0.0),
        ("SQRT(VARVAL(1))", 0.0),
        ("ASIN(VARVAL(1))", 1.0),
        ("ASIN(VARVAL(1))", -1.0),
        ("ACOS(VARVAL(1))", 1.0),
        ("ACOS(VARVAL(1))", -1.0),
        ("ATAN2(VARVAL(1),1)", 0.0),
        ("VARVAL(1)**2", 0.0),
        ("VARVAL(1)**1.5", 0.0),
        ("VARVAL(1)**0.5", 0.0),
        ("STEP(VARVAL(1),0.3,2,1.5,5)", 0.3),
        ("STEP(VARVAL(1),0.3,2,1.5,5)", 1.5),
        ("STEP5(VARVAL(1),0.3,2,1.5,5)", 0.3),
        ("STEP5(VARVAL(1),0.3,2,1.5,5)", 1.5),
        ("HAVSIN(VARVAL(1),0.3,2,1.5,5)", 0.3),
        ("HAVSIN(VARVAL(1),0.3,2,1.5,5)", 1.5),
        ("IMPACT(VARVAL(1),0,1.2,50,1.7,3,0.4)", 1.2),
        ("IMPACT(VARVAL(1),0,1.2,50,1,3,0.4)", 1.2),
        ("IMPACT(VARVAL(1),0,1.2,50,1.7,3,0.4)", 0.8),
        ("BISTOP(VARVAL(1),0,0.7,1.2,50,1,3,0.4)", 0.7),
        ("BISTOP(VARVAL(1),0,0.7,1.2,50,1,3,0.4)", 1.2),
        ("SWEEP(VARVAL(1),2,0.4,0.5,1.3,1.1,0.5)", 0.4),
        ("SWEEP(VARVAL(1),2,0.4,0.5,1.3,1.1,0.5)", 1.3),
        ("AKISPL(VARVAL(1),0,1)", 0.0),
        ("AKISPL(VARVAL(1),0,1)", 3.0),
        ("AKISPL(VARVAL(1),0,1)", 10.0),
        ("CUBSPL(VARVAL(1),0,4)", 0.0),
        ("CUBSPL(VARVAL(1),0,4)", 4.0),
        ("INTERP(VARVAL(1),1,1)", 3.0),
        ("IF(VARVAL(1):2*VARVAL(1),3*VARVAL(1),5*VARVAL(1))", 0.0),
    ] {
        let case = compile(text);
        let mut scratch = EvaluationMemory::default();
        let (n, m) = (case.program.inputs.len(), case.literals.len());
        let (mut by, mut by_literal) = (vec![0.0; n], vec![0.0; m]);
        let value = case.program.eval_with_derivatives(
            &vec![edge; n],
            case.numbers(),
            &mut scratch,
            &mut by,
            &mut by_literal,
        );
        let (value, exact) = (value.expect("it has a value here"), by.iter().sum::<f64>());
        assert!(
            exact.is_finite() && by_literal.iter().all(|d| d.is_finite()),
            "{text}"
        );
        let mut slope = |h: f64| {
            let moved = vec![edge + h; n];
            let there = case.program.eval(&moved, case.numbers(), &mut scratch);
            there.ok().map(|there| (there - value) / h)
        };
        let sides: Vec<f64> = [1e-7, -1e-7].into_iter().filter_map(&mut slope).collect();
        let low = sides.iter().copied().fold(f64::INFINITY, f64::min) - 2e-3;
        let high = sides.iter().copied().fold(f64::NEG_INFINITY, f64::max) + 2e-3;
        let steep = sides.iter().any(|s| s.abs() > 1e3);
        assert!(
            (low..=high).contains(&exact) || (steep && exact == 0.0),
            "{text} at {edge}: {exact}, sides {sides:?}"
        );
    }
}

#[test]
fn infinite_slopes_are_taken_as_zero() {
    let case = compile("SQRT(VARVAL(1)**2+VARVAL(2)**2)");
    let mut by = [1.0; 2];
    let mut by_literal = [0.0; 2 * 3];
    let value = case.program.eval_with_derivatives(
        &[0.0, 0.0],
        case.numbers(),
        &mut EvaluationMemory::default(),
        &mut by,
        &mut by_literal[..case.literals.len()],
    );
    assert_eq!((value, by), (Ok(0.0), [0.0, 0.0]));
}
