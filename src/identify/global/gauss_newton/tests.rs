use super::*;

/// Rosenbrock's function as a least-squares problem: its minimum is 0 at (1, 1).
struct Valley;

impl LeastSquares for Valley {
    fn evaluate(&mut self, x: &[f64], _with_jacobian: bool) -> Option<Evaluation> {
        Some(Evaluation {
            residual: DVector::from_vec(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]),
            jacobian: DMatrix::from_row_slice(2, 2, &[-20.0 * x[0], 10.0, -1.0, 0.0]),
            free: Vec::new(),
        })
    }
}

const NO_PRIOR: Prior = Prior {
    mean: 0.0,
    sd: f64::INFINITY,
};

#[test]
fn a_curved_valley_is_followed_to_its_end() {
    let found = minimise(
        &mut Valley,
        &[-1.2, 1.0],
        &[NO_PRIOR; 2],
        &[1.0; 2],
        &[false; 2],
        Tolerances::default(),
    )
    .unwrap();
    assert_eq!(found.ending, Ending::Converged);
    assert!(
        (found.x[0] - 1.0).abs() < 1e-4 && (found.x[1] - 1.0).abs() < 1e-4,
        "{:?}",
        found.x
    );
}

/// Deflections of two springs in series under unit loads, read at five points. The second spring contributes a fraction of its deflection,
/// which varies from point to point. The readings contain a systematic error that resembles a negative compliance of the second spring. The
/// noise is 0.001.
struct Springs;

impl LeastSquares for Springs {
    fn evaluate(&mut self, x: &[f64], _with_jacobian: bool) -> Option<Evaluation> {
        let (soft, other) = ((-x[0]).exp(), (-x[1]).exp());
        let shares: Vec<f64> = (0..5).map(|k| 0.1 * f64::from(k)).collect();
        let read = |share: f64| (-1.0_f64).exp() - 0.5 * share;
        Some(Evaluation {
            residual: DVector::from_fn(5, |k, _| {
                1e3 * (soft + shares[k] * other - read(shares[k]))
            }),
            jacobian: DMatrix::from_fn(5, 2, |k, j| {
                -1e3 * if j == 0 { soft } else { shares[k] * other }
            }),
            free: Vec::new(),
        })
    }
}

#[test]
fn what_is_hardly_seen_does_not_run_off_on_the_way() {
    let (start, scale, held) = ([0.0; 2], [1.0; 2], [false; 2]);
    let prior = Prior { mean: 0.0, sd: 3.0 };
    let straight = minimise(
        &mut Springs,
        &start,
        &[prior; 2],
        &scale,
        &held,
        Tolerances::default(),
    )
    .unwrap();
    assert!(straight.x[1] > 6.0, "{:?}", straight.x);
    let led = homotopy_start(&mut Springs, &start, &scale, &held);
    assert!(led[1] < 3.0 && (led[0] - 1.2).abs() < 0.5, "{led:?}");
}

#[test]
fn a_held_unknown_stays_and_a_prior_pulls() {
    let held = minimise(
        &mut Valley,
        &[0.5, 1.0],
        &[NO_PRIOR; 2],
        &[1.0; 2],
        &[true, false],
        Tolerances::default(),
    )
    .unwrap();
    assert_eq!(held.x[0], 0.5);
    assert!((held.x[1] - 0.25).abs() < 1e-6);
    // With x0 held at 0.5, the residuals give x1 = 0.25 with information 100. A prior with mean 1 and information 100 moves x1 half-way to 1.
    let priors = [NO_PRIOR, Prior { mean: 1.0, sd: 0.1 }];
    let pulled = minimise(
        &mut Valley,
        &[0.5, 1.0],
        &priors,
        &[1.0; 2],
        &[true, false],
        Tolerances::default(),
    )
    .unwrap();
    assert!((pulled.x[1] - 0.625).abs() < 1e-6);
}

/// An arctangent with a second branch. A full step from 1.45 overshoots. An evaluation beyond 1.5 switches to the second branch, and later
/// evaluations stay on it until `rollback`.
struct Snapping {
    there: bool,
    kept: bool,
}

impl LeastSquares for Snapping {
    fn evaluate(&mut self, x: &[f64], _with_jacobian: bool) -> Option<Evaluation> {
        self.there |= x[0].abs() > 1.5;
        let far = if self.there { 3.0 } else { 0.0 };
        Some(Evaluation {
            residual: DVector::from_element(1, 10.0 * (x[0].atan() + far)),
            jacobian: DMatrix::from_element(1, 1, 10.0 / (1.0 + x[0] * x[0])),
            free: Vec::new(),
        })
    }

    fn checkpoint(&mut self) {
        self.kept = self.there;
    }

    fn rollback(&mut self) {
        self.there = self.kept;
    }
}

#[test]
fn a_refused_trial_does_not_lead_the_next_one_astray() {
    let mut problem = Snapping {
        there: false,
        kept: false,
    };
    let found = minimise(
        &mut problem,
        &[1.45],
        &[NO_PRIOR],
        &[10.0],
        &[false],
        Tolerances::default(),
    )
    .unwrap();
    assert!(found.objective < 1e-4 && !problem.there, "{found:?}");
    assert_eq!(found.ending, Ending::Converged);
}
