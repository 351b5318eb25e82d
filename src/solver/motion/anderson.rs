//! Anderson acceleration of a fixed-point iteration; for a linear iteration it is a minimal-residual method.
//!
//! Let f be the correction at an iterate x. The plain iteration goes to x + f. The accelerated iteration goes to `x + f - sum c_j p_j` with
//! c_j = q_j . f. The q_j are the orthonormalised past changes of f, and the p_j are the matching changes of x + f. (D. G. Anderson, J. ACM
//! 12, 1965; H. F. Walker, P. Ni, SIAM J. Numer. Anal. 49, 2011.)

use super::newton::Unknowns;

/// A change of f is discarded if its component orthogonal to the earlier changes is below this share of the change.
const NEW: f64 = 1e-8;

/// History of an accelerated iteration.
#[derive(Debug, Default)]
pub(super) struct AndersonAcceleration {
    /// Weight of each unknown in scalar products. It is `None` before [`Self::begin`]; the iteration is then not accelerated.
    weights: Option<Unknowns>,
    /// Pairs (q, p): the orthonormalised changes of f and the matching changes of x + f.
    known: Vec<(Unknowns, Unknowns)>,
    /// Last correction, and the accelerated step that was returned for it.
    last: Option<(Unknowns, Unknowns)>,
}

impl AndersonAcceleration {
    /// Discards the history and sets the weights of the unknowns in scalar products.
    pub(crate) fn begin(&mut self, weights: Unknowns) {
        self.weights = Some(weights);
        self.known.clear();
        self.last = None;
    }

    /// Returns the accelerated step for a correction f.
    pub(crate) fn mixed(&mut self, correction: &Unknowns) -> Unknowns {
        let mut step = correction.clone();
        let Some(weights) = &self.weights else {
            return step;
        };
        if let Some((before, taken)) = self.last.take() {
            let mut q = correction.clone();
            q.add(-1.0, &before);
            let mut p = taken;
            p.add(1.0, &q);
            let whole = q.product(&q, weights).sqrt();
            for (known_q, known_p) in &self.known {
                let share = q.product(known_q, weights);
                q.add(-share, known_q);
                p.add(-share, known_p);
            }
            let size = q.product(&q, weights).sqrt();
            if size > NEW * whole {
                q.scale(1.0 / size);
                p.scale(1.0 / size);
                self.known.push((q, p));
            }
        }
        for (q, p) in &self.known {
            step.add(-q.product(correction, weights), p);
        }
        self.last = Some((correction.clone(), step.clone()));
        step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The plain iteration x = K x + b diverges, because two eigenvalues of K exceed one in magnitude. The accelerated iteration finds the
    /// solution with four corrections, one more than the number of unknowns.
    #[test]
    fn a_linear_iteration_that_grows_ends() {
        let one = |values: [f64; 3]| Unknowns {
            z: [values.to_vec(), Vec::new(), Vec::new()],
            w: Default::default(),
            mu: Default::default(),
        };
        let K = [[-8.0, 1.0, 0.0], [0.0, 0.4, 0.3], [0.5, 0.0, 3.0]];
        let solution = [1.0, -2.0, 0.5];
        let mut x = [0.0; 3];
        let mut mixing = AndersonAcceleration::default();
        mixing.begin(one([1.0, 10.0, 0.1]));
        for _ in 0..4 {
            // b = (1 - K) solution.
            let f = std::array::from_fn(|i| {
                let of = |j: usize| (K[i][j] - f64::from(u8::from(i == j))) * (x[j] - solution[j]);
                of(0) + of(1) + of(2)
            });
            let step = mixing.mixed(&one(f));
            for (x, step) in x.iter_mut().zip(&step.z[0]) {
                *x += step;
            }
        }
        for (x, known) in x.iter().zip(solution) {
            assert!((x - known).abs() < 1e-10, "{x} {known}");
        }
    }
}
