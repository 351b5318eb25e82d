/// Elementary effects of one parameter on a result (Morris 1991). An effect is the change of the result over the parameter's whole range of
/// probability, extrapolated from a step over half the range.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Effect {
    /// Mean of the effects.
    pub mean: f64,
    /// Mean of the absolute effects (Campolongo et al. 2007), which measures the importance of the parameter.
    pub size: f64,
    /// Standard error of the mean of the absolute effects.
    pub size_error: f64,
    /// Standard deviation of the effects. It is large relative to the mean if the parameter acts nonlinearly or interacts with other
    /// parameters.
    pub spread: f64,
    /// Number of valid steps, whose two cases both have a result.
    pub count: usize,
}

/// Computes the effects of every parameter from the results of the plan `morris`, in the order of its cases. `numbers` contains the values of
/// each parameter, case by case. These values show which parameter changed in a step.
pub(crate) fn effects(answers: &[f64], numbers: &[Vec<f64>]) -> Vec<Effect> {
    let block = numbers.len() + 1;
    let mut all: Vec<Vec<f64>> = vec![Vec::new(); numbers.len()];
    for start in (0..answers.len()).step_by(block) {
        for case in start..(start + block - 1).min(answers.len().saturating_sub(1)) {
            let change = answers[case + 1] - answers[case];
            let mut changed = numbers
                .iter()
                .enumerate()
                .filter(|(_, values)| values[case + 1] != values[case]);
            if let (Some((k, values)), None, true) =
                (changed.next(), changed.next(), change.is_finite())
            {
                let sign = (values[case + 1] - values[case]).signum();
                all[k].push(2.0 * sign * change);
            }
        }
    }
    all.iter().map(|steps| effect(steps)).collect()
}

fn effect(steps: &[f64]) -> Effect {
    let count = steps.len();
    let n = count as f64;
    let mean_of = |value: &dyn Fn(f64) -> f64| steps.iter().map(|s| value(*s)).sum::<f64>() / n;
    let spread_of = |value: &dyn Fn(f64) -> f64| {
        let mean = mean_of(value);
        (steps
            .iter()
            .map(|s| (value(*s) - mean).powi(2))
            .sum::<f64>()
            / (n - 1.0))
            .sqrt()
    };
    Effect {
        mean: mean_of(&|s| s),
        size: mean_of(&f64::abs),
        size_error: spread_of(&f64::abs) / n.sqrt(),
        spread: spread_of(&|s| s),
        count,
    }
}

#[cfg(test)]
mod tests {
    use super::super::design::{Design, Plan, Point};
    use super::*;

    #[test]
    fn effects_of_a_plane_are_its_slopes_and_a_product_spreads() {
        // y = 10 u1 - 4 u2 + 8 u3 u4 on the unit cube.
        let names = ["u1", "u2", "u3", "u4", "nothing"];
        let design = Design::new(Plan::Morris { levels: 4 }, 50, 2, &names);
        let mut numbers = vec![Vec::new(); 5];
        let mut answers = Vec::new();
        for case in 0..design.cases() {
            let Point::Unit(u) = design.point(case) else {
                panic!("a point of the cube");
            };
            answers.push(10.0 * u[0] - 4.0 * u[1] + 8.0 * u[2] * u[3]);
            for (values, u) in numbers.iter_mut().zip(u) {
                values.push(u);
            }
        }
        let found = effects(&answers, &numbers);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(found.iter().all(|e| e.count == 50));
        assert!(near(found[0].mean, 10.0) && near(found[0].spread, 0.0));
        assert!(near(found[1].mean, -4.0) && near(found[1].size, 4.0));
        // 8 u with u uniform on four levels: mean 4, standard deviation 8 * 0.2795.
        for e in &found[2..4] {
            assert!((e.mean - 4.0).abs() < 4.0 * e.size_error, "{e:?}");
            assert!((e.spread - 8.0 * 0.279_508).abs() < 0.5, "{e:?}");
        }
        assert!(near(found[4].size, 0.0));
        answers[7] = f64::NAN;
        let lost: usize = effects(&answers, &numbers)
            .iter()
            .map(|e| 50 - e.count)
            .sum();
        assert_eq!(lost, 2);
    }
}
