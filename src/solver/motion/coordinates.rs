//! Coordinates of small motions: displacements and rotations of the parts relative to ground or to a marker, or VARIABLEs of a PSTATE.

use nalgebra::DMatrix;

use super::error::MotionFailure;
use crate::linear::Levels;
use crate::mechanics::{Mat3, skew};
use crate::system::{Parameters, Scratch, State, System};

/// Limit of linear dependence. The row of a candidate coordinate depends on the rows chosen earlier if less than this share of it remains after
/// its components along these rows are removed.
const DESCRIBED: f64 = 1e-6;
/// Relative difference below which the sizes of the rows of two candidate coordinates count as equal.
const EQUAL: f64 = 1e-9;

/// Choice of the coordinates that, together with their rates, are the states of the LINEAR command.
///
/// ADAMS takes the VARIABLEs of a PSTATE first, then global displacements and rotations of parts. The total number of coordinates equals the
/// number of degrees of freedom (`state_pstate`: "the system will fill in"). Dependent coordinates are discarded.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Coordinates {
    /// Indices in the model of the VARIABLEs to choose first.
    pub variables: Vec<usize>,
    /// Index in the model of the marker relative to which the parts are described, in axes of this marker; `None` for ground.
    pub seen_from: Option<usize>,
}

impl Coordinates {
    /// Returns true if the coordinates are the displacements and rotations of the parts relative to ground.
    pub(super) fn are_plain(&self) -> bool {
        self.variables.is_empty() && self.seen_from.is_none()
    }

    /// Returns the index after the last row of each kind of candidate coordinate. The kinds are VARIABLEs, parts relative to a marker, and parts
    /// relative to ground.
    fn ends(&self, system: &System) -> [usize; 3] {
        let first = self.variables.len();
        let n = system.first_equation;
        let seen = first + if self.seen_from.is_some() { n } else { 0 };
        [first, seen, seen + n]
    }

    /// Returns the name of the candidate coordinate that has the given row index.
    pub(super) fn name(&self, system: &System, row: usize) -> String {
        let [first, seen, _] = self.ends(system);
        if row < first {
            system.variables[self.variables[row]].name.to_string()
        } else if row < seen {
            let name = system.freedom_name(row - first);
            format!("{name}, relative to the RM")
        } else {
            system.freedom_name(row - seen)
        }
    }

    /// Returns the derivatives of all candidate coordinates with respect to the motions of the parts. Each coordinate has one row.
    ///
    /// For a part with origin p, seen from a marker with axes R on a part with origin p_r, the rows are `R' (dp - dp_r + (p - p_r) x dphi_r)`
    /// and `R' (dphi - dphi_r)`.
    ///
    /// # Errors
    /// Returns [`MotionFailure`] if a VARIABLE has no value or is not a function of positions alone.
    pub(super) fn rows(
        &self,
        system: &System,
        parameters: &Parameters,
        state: &State,
    ) -> Result<DMatrix<f64>, MotionFailure> {
        let n = system.first_equation;
        let [first, seen, all] = self.ends(system);
        let mut P = DMatrix::zeros(all, n);
        if first > 0 {
            self.of_variables((system, parameters, state), &mut P)?;
        }
        if let Some(marker) = self.seen_from {
            let base = system.owners[marker];
            let R = state.poses[base].R * parameters.markers()[marker].R;
            for (part, body) in system.bodies.iter().enumerate() {
                let arm = state.poses[part].p - state.poses[base].p;
                let at = first + body.first;
                let turned = R.transpose();
                let by_turn = turned * skew(&arm);
                let of_base = &system.bodies[base];
                let mut put = |row: usize, column: usize, block: Mat3| {
                    for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
                        P[(row + i, column + j)] += block[(i, j)];
                    }
                };
                for half in 0..body.freedoms / 3 {
                    put(at + 3 * half, body.first + 3 * half, turned);
                    if half < of_base.freedoms / 3 {
                        put(at + 3 * half, of_base.first + 3 * half, -turned);
                    }
                }
                if body.freedoms > 0 && of_base.freedoms == 6 {
                    put(at, of_base.first + 3, by_turn);
                }
            }
        }
        for k in 0..n {
            P[(seen + k, k)] = 1.0;
        }
        Ok(P)
    }

    /// Writes the derivatives of the candidate VARIABLEs with respect to the motions of the parts into the first rows of `P`. VARIABLEs that are
    /// unknowns are eliminated: `dv = -J_vv^-1 J_vq d`.
    fn of_variables(
        &self,
        (system, parameters, state): (&System, &Parameters, &State),
        P: &mut DMatrix<f64>,
    ) -> Result<(), MotionFailure> {
        let (n, m) = (system.first_equation, system.moving_unknowns);
        let (first, count) = (system.first_variable, system.implicit.len());
        let mut scratch = Scratch::new(system);
        let (mut levels, mut g) = (Levels::new(m), vec![0.0; m]);
        system.assemble(parameters, state, &mut scratch, &mut g, &mut levels)?;
        levels.finish();
        // Derivatives with respect to positions and to unknown VARIABLEs, and whether a row depends on any other unknown.
        let mut own: DMatrix<f64> = DMatrix::zeros(count, count);
        let mut by_place: DMatrix<f64> = DMatrix::zeros(count, n);
        let mut reads_others = vec![false; count];
        for (row, column, values) in levels.entries() {
            let Some(row) = row.checked_sub(first).filter(|row| *row < count) else {
                continue;
            };
            reads_others[row] |= values[1] != 0.0 || values[2] != 0.0;
            if column < n {
                by_place[(row, column)] += values[0];
            } else if (first..first + count).contains(&column) {
                own[(row, column - first)] += values[0];
            } else {
                reads_others[row] |= values[0] != 0.0;
            }
        }
        let follow = own.clone().try_inverse();
        let follow = follow.unwrap_or_else(|| DMatrix::identity(count, count));
        let followed: DMatrix<f64> = -(&follow * by_place);
        let mut here = system.evaluate(parameters, state, &mut scratch)?;
        for (row, &variable) in self.variables.iter().enumerate() {
            let mut by = nalgebra::RowDVector::zeros(n);
            let mut others = false;
            for (column, value) in here.variable_gradient(variable)? {
                if column < n {
                    by[column] += value;
                } else if (first..first + count).contains(&column) {
                    let at = column - first;
                    by += followed.row(at) * value;
                    others |= (0..count).any(|k| reads_others[k] && follow[(at, k)] != 0.0);
                } else {
                    // A dependence on time is allowed.
                    others |= value != 0.0 && column < 3 * m;
                }
            }
            if others || by.amax() == 0.0 {
                return Err(MotionFailure::NoCoordinate {
                    what: system.variables[variable].name.to_string(),
                });
            }
            P.row_mut(row).copy_from(&by);
        }
        Ok(())
    }

    /// Chooses as many rows as Z has columns, so that together they describe every free motion, and returns their indices. VARIABLEs are taken
    /// in the given order. Among the other kinds, the row that is most independent of the chosen rows is taken next.
    pub(super) fn chosen(
        &self,
        system: &System,
        P: &DMatrix<f64>,
        Z: &DMatrix<f64>,
        lengths: &nalgebra::DVector<f64>,
    ) -> Vec<usize> {
        let mut left = P * Z;
        let ends = self.ends(system);
        for (row, mut values) in left.row_iter_mut().enumerate() {
            if row >= ends[0] {
                values *= lengths[(row - ends[0]) % lengths.len().max(1)];
            }
        }
        let sizes: Vec<f64> = left.row_iter().map(|row| row.norm()).collect();
        let mut chosen = Vec::new();
        let mut start = 0;
        for (kind, end) in ends.into_iter().enumerate() {
            let widest = (start..end).fold(0.0_f64, |a, k| a.max(sizes[k]));
            while chosen.len() < Z.ncols() {
                let norms: Vec<f64> = (start..end).map(|k| left.row(k).norm()).collect();
                let at = if kind == 0 {
                    // VARIABLEs are taken in the order given by the user.
                    (0..norms.len()).find(|k| norms[*k] > DESCRIBED * sizes[start + *k])
                } else {
                    // The first of all rows that are largest up to round-off is taken.
                    let most = norms.iter().fold(0.0_f64, |a, b| a.max(*b));
                    let at = norms.iter().position(|s| *s >= most * (1.0 - EQUAL));
                    let last = kind == 2;
                    at.filter(|_| last || most > DESCRIBED * widest)
                };
                let Some(at) = at else { break };
                chosen.push(start + at);
                let direction = left.row(start + at) / norms[at].max(f64::MIN_POSITIVE);
                for mut row in left.row_iter_mut() {
                    let along = row.dot(&direction);
                    row -= &direction * along;
                }
            }
            start = end;
        }
        chosen.sort_unstable();
        chosen
    }
}
