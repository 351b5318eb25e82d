//! Constraint equations that say nothing new.

use super::System;

/// A constraint row that keeps less than this of its length when its share in the rows before is taken off is redundant.
const REDUNDANT: f64 = 1e-8;

/// Beyond so many products the factorisation alone finds redundant equations.
const LARGE: usize = 1_000_000_000;

impl System {
    /// Which constraint equations depend on those before them, from the entries of their gradients by the parts: (equation, freedom,
    /// derivative), those of one equation in the order of the freedoms or not.
    pub(crate) fn redundant_rows(&self, entries: &[(u32, u32, f64)]) -> Vec<bool> {
        let columns = self.first_equation;
        if self.equations.pow(2).saturating_mul(columns) > LARGE {
            return vec![false; self.equations];
        }
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let scale = self.column_lengths();
        let mut out = vec![false; self.equations];
        let mut rows = vec![Vec::new(); self.equations];
        for &(row, column, value) in entries {
            rows[row as usize].push((column as usize, value / scale[column as usize]));
        }
        for (row, redundant) in rows.iter().zip(&mut out) {
            let mut v = vec![0.0; columns];
            for &(column, value) in row {
                v[column] += value;
            }
            let before = norm(&v);
            // An equation without any gradient cannot be held by anything: it is another's business.
            if before == 0.0 {
                *redundant = true;
                continue;
            }
            // Twice is enough (Kahan).
            for _ in 0..2 {
                for b in &basis {
                    let share: f64 = v.iter().zip(b).map(|(x, y)| x * y).sum();
                    for (x, y) in v.iter_mut().zip(b) {
                        *x -= share * y;
                    }
                }
            }
            let after = norm(&v);
            if after < REDUNDANT * before {
                *redundant = true;
            } else {
                for x in &mut v {
                    *x /= after;
                }
                basis.push(v);
            }
        }
        out
    }

    /// What one unit of each body unknown moves: 1 for translations, the length of the model for rotations.
    fn column_lengths(&self) -> Vec<f64> {
        let mut out = vec![1.0; self.first_equation];
        for body in &self.bodies {
            for k in 3..body.freedoms.max(3) {
                out[body.first + k] = self.length;
            }
        }
        out
    }
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
