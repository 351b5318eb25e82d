use nalgebra::{DMatrix, DVector};

use super::SolveError;
use super::krylov::ShiftInvert;
use super::path::add_damping;
use super::rank::{motion_of, soft_motion};
use crate::linear::{Lu, Matrix};
use crate::mechanics::eigen::{eigenvalues, symmetric_eigen};
use crate::system::{Parameters, Scratch, State, System};

/// Largest number of part unknowns for which all eigenvalues are computed. The work grows with the cube of this number.
const DENSE: usize = 150;

/// A stiffness below this share of the largest possible stiffness is round-off.
const ROUND_OFF: f64 = 1e-12;
/// Number of inverse iterations. The shift is so close to the eigenvalue that two or three suffice.
const ITERATIONS: usize = 6;
/// Number of Newton steps by which the error of an eigenvalue is estimated. The first step may be too long for the linearisation; the second
/// corrects for that.
const STEPS: usize = 2;

/// Returns the smallest eigenvalue (real part) of the tangent stiffness over the motions that the constraints allow, as a force per length.
/// Rotations are multiplied by the model's length. The eigenvalue is negative at an unstable equilibrium. Returns `None` if no part can move.
///
/// The eigenvalues are those of `Z' S Z`. Z is an orthonormal basis of the motions that the constraints allow. S is the stiffness after
/// elimination of VARIABLEs and states; in general it is unsymmetric. In small systems, all eigenvalues are computed. In large systems, only
/// the eigenvalues next to a series of shifts are computed. Arnoldi's method is used for this, with the factors of the shifted equations (Golub
/// and Van Loan, Matrix Computations, 10.5).
///
/// # Errors
/// Returns [`SolveError::NoValue`] if an element has no value in this state.
pub fn smallest_eigenvalue(
    system: &System,
    parameters: &Parameters,
    state: &State,
) -> Result<Option<f64>, SolveError> {
    let found = smallest(system, parameters, state, &mut Scratch::new(system))?;
    Ok(found.map(|(stiffness, ..)| stiffness))
}

/// Returns the smallest eigenvalue, not rounded to zero, its eigenvector with rotations multiplied by the model's length, and an upper bound of
/// all eigenvalues.
fn smallest(
    system: &System,
    parameters: &Parameters,
    state: &State,
    scratch: &mut Scratch,
) -> Result<Option<(f64, Vec<f64>, f64)>, SolveError> {
    let n = system.first_equation;
    if n == 0 {
        return Ok(None);
    }
    let tangent = assembled(system, parameters, state, scratch)?;
    let lengths = lengths(system);
    let bound = bound(system, &tangent, &lengths);
    let found = if n <= DENSE {
        dense(system, &tangent, &lengths)
    } else {
        ShiftInvert::new(system, parameters, state, lengths).smallest(bound)?
    };
    Ok(found.map(|(stiffness, motion)| (stiffness, motion, bound)))
}

/// The softest motion that the constraints allow.
#[derive(Clone, PartialEq, Debug)]
pub struct Softest {
    /// Smallest eigenvalue, as a force per length. It is set to zero if it is round-off.
    pub stiffness: f64,
    /// Error bound of the eigenvalue. It covers round-off and, at an equilibrium, the effect of the remaining imbalance.
    pub error: f64,
    /// Eigenvector: changes of the part unknowns, in ground axes. The largest motion of any part is one length unit.
    pub motion: Vec<f64>,
}

impl Softest {
    /// Returns the softest motion at any state. The error bound covers round-off only. Returns `None` if no part can move or no eigenvalue is
    /// found.
    ///
    /// # Errors
    /// Returns [`SolveError::NoValue`] if an element has no value in this state.
    pub fn of(
        system: &System,
        parameters: &Parameters,
        state: &State,
    ) -> Result<Option<Self>, SolveError> {
        Self::with(system, parameters, state, &mut Scratch::new(system))
    }

    fn with(
        system: &System,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Result<Option<Self>, SolveError> {
        let found = smallest(system, parameters, state, scratch)?;
        Ok(found.map(|(smallest, motion, bound)| Self {
            stiffness: if smallest.abs() < ROUND_OFF * bound {
                0.0
            } else {
                smallest
            },
            error: ROUND_OFF * bound,
            motion: in_unknowns(system, &lengths(system), motion),
        }))
    }

    /// Returns the softest motion at an equilibrium. The error bound includes the effect of the tolerances ERROR and IMBALANCE on the
    /// equilibrium. Returns `None` if no part can move or no eigenvalue is found.
    ///
    /// Two Newton steps move the parts closer to the exact equilibrium. The eigenvalue is evaluated after these steps, and its error bound is
    /// the change that they caused. The damping of the steps exceeds the magnitude of the eigenvalue, so free motions stay in place.
    ///
    /// # Errors
    /// Returns [`SolveError::NoValue`] if an element has no value in this state.
    pub fn at_equilibrium(
        system: &System,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Result<Option<Self>, SolveError> {
        let Some(mut here) = Self::with(system, parameters, state, scratch)? else {
            return Ok(None);
        };
        let damping = here.error.max(2.0 * here.stiffness.abs());
        let mut near = state.clone();
        let (mut matrix, mut factors) =
            (Matrix::new(system.unknowns()), Lu::new(system.unknowns()));
        let mut step = vec![0.0; system.unknowns()];
        for _ in 0..STEPS {
            matrix.clear();
            system.assemble(parameters, &near, scratch, &mut step, &mut matrix)?;
            matrix.finish();
            add_damping(system, damping, &mut matrix);
            factors.factor(&matrix);
            for g in &mut step {
                *g = -*g;
            }
            factors.solve(&mut step);
            system.advance(&mut near, &step);
        }
        if let Some((nearer, ..)) = smallest(system, parameters, &near, scratch)? {
            here.error = here.error.max((nearer - here.stiffness).abs());
            here.stiffness = nearer;
        }
        Ok(Some(here))
    }

    /// Returns the softest motion at an unstable or neutral equilibrium, and `None` at a stable one. For small systems, this is cheaper than
    /// [`Softest::at_equilibrium`].
    ///
    /// # Errors
    /// Returns [`SolveError::NoValue`] if an element has no value in this state.
    pub fn doubtful(
        system: &System,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Result<Option<Self>, SolveError> {
        let n = system.first_equation;
        if n > 0 && n <= DENSE {
            let tangent = assembled(system, parameters, state, scratch)?;
            let lengths = lengths(system);
            if let Some((reduced, _)) = reduced(system, &tangent, &lengths) {
                // No eigenvalue has a real part below the smallest eigenvalue of the symmetric part.
                let symmetric = (&reduced + reduced.transpose()) * 0.5;
                if symmetric.cholesky().is_some() {
                    return Ok(None);
                }
            }
        }
        let softest = Self::at_equilibrium(system, parameters, state, scratch)?;
        Ok(softest.filter(|softest| softest.is_unstable() || softest.is_neutral()))
    }

    /// Returns true if the stability analysis costs no more than the solution of the equilibrium. In large systems, it needs several
    /// factorisations.
    pub fn is_cheap(system: &System) -> bool {
        system.first_equation <= DENSE
    }

    /// Returns true if the stiffness is negative by more than its error bound.
    pub fn is_unstable(&self) -> bool {
        self.stiffness < -self.error
    }

    /// Returns true if the magnitude of the stiffness is within its error bound. The sign of the stiffness is then uncertain.
    pub fn is_neutral(&self) -> bool {
        self.stiffness.abs() <= self.error
    }

    /// Returns the index of the part that moves most.
    pub fn part(&self, system: &System) -> usize {
        let size = |part: usize| {
            let (v, w) = motion_of(system, part, &self.motion);
            v.norm().max(w.norm() * system.length)
        };
        (0..system.bodies.len())
            .max_by(|a, b| size(*a).total_cmp(&size(*b)))
            .unwrap_or(0)
    }

    /// Describes the motion, for example `PART/4 'arm' turns about the line MARKER/13-MARKER/15, together with ...`.
    pub fn described(
        &self,
        system: &System,
        parameters: &Parameters,
        state: &State,
    ) -> Option<String> {
        let motion = soft_motion(system, parameters, state, &self.motion)?;
        Some(motion.to_string())
    }
}

/// Converts an eigenvector with rotations multiplied by the model's length to changes of the unknowns. The largest motion of a part is scaled
/// to one.
fn in_unknowns(system: &System, lengths: &[f64], mut motion: Vec<f64>) -> Vec<f64> {
    let largest = motion.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let first = motion.iter().find(|x| x.abs() > 0.5 * largest).copied();
    // Both signs are equivalent; this choice is reproducible.
    let scale = first.unwrap_or(1.0).signum() / largest.max(f64::MIN_POSITIVE);
    for (x, length) in motion.iter_mut().zip(lengths) {
        *x *= scale / length;
    }
    motion.truncate(system.first_equation);
    motion
}

fn assembled(
    system: &System,
    parameters: &Parameters,
    state: &State,
    scratch: &mut Scratch,
) -> Result<Matrix, SolveError> {
    let mut matrix = Matrix::new(system.unknowns());
    let mut g = vec![0.0; system.unknowns()];
    system.assemble(parameters, state, scratch, &mut g, &mut matrix)?;
    matrix.finish();
    Ok(matrix)
}

/// Returns the length factor of each part unknown: 1 for translations, the model's length for rotations.
fn lengths(system: &System) -> Vec<f64> {
    let mut out = vec![1.0; system.first_equation];
    for body in &system.bodies {
        for k in 3..body.freedoms.max(3) {
            out[body.first + k] = system.length;
        }
    }
    out
}

/// Returns an upper bound of all eigenvalues: the largest row sum of the stiffness, plus the contribution of VARIABLEs and states.
fn bound(system: &System, tangent: &Matrix, lengths: &[f64]) -> f64 {
    let n = system.first_equation;
    let mut rows = vec![0.0_f64; system.unknowns()];
    let mut by_variables = vec![0.0_f64; n];
    for (row, column, value) in tangent.entries() {
        let left = lengths.get(row).copied().unwrap_or(1.0);
        if column < n {
            rows[row] += (value / (left * lengths[column])).abs();
        } else if row < n && column >= system.first_variable {
            by_variables[row] += (value / left).abs();
        }
    }
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |a, b| a.max(*b));
    let variables = largest(&by_variables) * largest(&rows[system.first_variable..]);
    largest(&rows[..n]) + variables
}

/// Returns the stiffness over the motions that the constraints allow, and these motions as columns, with rotations multiplied by the model's
/// length. Returns `None` if the constraints allow no motion.
fn reduced(
    system: &System,
    tangent: &Matrix,
    lengths: &[f64],
) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let n = system.first_equation;
    let (m, v) = (system.equations, system.unknowns() - system.first_variable);
    let scale = |k: usize| lengths.get(k).copied().unwrap_or(1.0);
    let mut J: DMatrix<f64> = DMatrix::zeros(n + m + v, n + m + v);
    for (row, column, value) in tangent.entries() {
        J[(row, column)] += value / (scale(row) * scale(column));
    }
    // VARIABLEs and states are eliminated.
    if v > 0 {
        let own = J.view((n + m, n + m), (v, v)).clone_owned();
        let by_others = J.view((n + m, 0), (v, n + m)).clone_owned();
        if let Some(followed) = own.lu().solve(&by_others) {
            let effect = J.view((0, n + m), (n + m, v)) * followed;
            let mut bodies = J.view_mut((0, 0), (n + m, n + m));
            bodies -= effect;
        }
    }
    let K = -J.view((0, 0), (n, n));
    let mut G = J.view((n, 0), (m, n)).clone_owned();
    // Every constraint counts equally, whatever its unit.
    for mut row in G.row_iter_mut() {
        let length = row.norm();
        if length > 0.0 {
            row /= length;
        }
    }
    let eigen = symmetric_eigen(G.transpose() * G);
    let free: Vec<usize> = (0..n).filter(|&k| eigen.eigenvalues[k] < 1e-12).collect();
    if free.is_empty() {
        return None;
    }
    let Z: DMatrix<f64> = eigen.eigenvectors.select_columns(&free);
    Some((Z.transpose() * K * &Z, Z))
}

/// Computes all eigenvalues and returns the smallest, with its eigenvector. Rotations in the eigenvector are multiplied by the model's length.
fn dense(system: &System, tangent: &Matrix, lengths: &[f64]) -> Option<(f64, Vec<f64>)> {
    let (reduced, Z) = reduced(system, tangent, lengths)?;
    let values = eigenvalues(reduced.clone())?;
    let least = values.iter().map(|e| e.re).fold(f64::INFINITY, f64::min);
    let motion = Z * near(&reduced, least);
    Some((least, motion.iter().copied().collect()))
}

/// Returns the eigenvector of an eigenvalue by inverse iteration. For a complex pair, the result is a vector in its invariant plane.
fn near(matrix: &DMatrix<f64>, value: f64) -> DVector<f64> {
    let n = matrix.nrows();
    let beside = value - 1e-9 * matrix.amax().max(f64::MIN_POSITIVE);
    let factors = (matrix - DMatrix::identity(n, n) * beside).lu();
    let mut vector = DVector::from_fn(n, |k, _| 1.0 / (k as f64 + 1.7));
    for _ in 0..ITERATIONS {
        let Some(next) = factors
            .solve(&vector)
            .filter(|v| v.norm() > 0.0 && v.norm().is_finite())
        else {
            break;
        };
        vector = next.normalize();
    }
    vector
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use super::*;
    use crate::model::Model;
    use crate::statics::{StaticSettings, solve};
    use admire_syntax::Dataset;
    use admire_syntax::text::Source;

    /// Returns a chain of links on bushings, with a hinge at every seventh link. A VARIABLE gives a force that grows by `push` per unit of
    /// displacement of the end.
    fn chain(links: u32, push: f64) -> (System, State) {
        let mut deck = String::from(
            "chain\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\n\
             MARKER/1, PART=1\nMARKER/11, PART=1\n",
        );
        for id in 2..links + 2 {
            let x = 50 * (id - 2);
            writeln!(
                deck,
                "PART/{id}, QG={x},0,0, MASS=1, CM={id}0, IP=9,9,9\nMARKER/{id}0, PART={id}\n\
                 MARKER/{id}1, PART={id}, QP=50,0,0\nBUSHING/{id}, I={id}0, J={}1, K=3E3,2E3,1E3, KT=1E6,2E6,3E6",
                id - 1
            )
            .unwrap();
            if id % 7 == 0 {
                writeln!(deck, "JOINT/{id}, REVOLUTE, I={id}0, J={}1", id - 1).unwrap();
            }
        }
        let last = links + 1;
        writeln!(
            deck,
            "VARIABLE/1, FUNCTION={push}*DX({last}0,1)\nMARKER/5, PART=1, REULER=90D,90D,0D\n\
             SFORCE/1, I={last}0, J=5, TRANSLATIONAL, ACTIONONLY, FUNCTION=VARVAL(1)-{}\nEND",
            push * f64::from(50 * (links - 1))
        )
        .unwrap();
        solved(deck)
    }

    fn solved(deck: String) -> (System, State) {
        let dataset = Dataset::parse(Source::new("chain.adm", deck.into_bytes())).value;
        let system = System::compile(&Model::lower(&dataset).value);
        assert!(!system.has_errors(), "{:?}", system.diagnostics);
        let system = system.value;
        let mut state = system.state();
        let parameters = system.parameters();
        solve(&system, &parameters, &mut state, &StaticSettings::tight()).unwrap();
        (system, state)
    }

    /// Both methods agree for stable and unstable chains. In an unstable chain, the single unstable motion is stiffer in magnitude than many
    /// stable ones.
    #[test]
    fn both_ways_agree() {
        for push in [0.0, 1.0, 50.0, 1e4, 1e7] {
            let (system, state) = chain(20, push);
            let parameters = system.parameters();
            let mut scratch = Scratch::new(&system);
            let tangent = assembled(&system, &parameters, &state, &mut scratch).unwrap();
            let lengths = lengths(&system);
            let bound = bound(&system, &tangent, &lengths);
            let (all, _) = dense(&system, &tangent, &lengths).unwrap();
            let (near, _) = ShiftInvert::new(&system, &parameters, &state, lengths)
                .smallest(bound)
                .unwrap()
                .unwrap();
            println!("push {push}: {all} {near}, bound {bound}");
            assert!(
                (near - all).abs() < 1e-6 * all.abs(),
                "{push}: {all} {near}"
            );
            assert_eq!(all < 0.0, push > 1e2);
        }
    }

    /// A marker very close to the origin of its part makes products underflow. The eigenvalues are nevertheless found, and quickly.
    #[test]
    fn places_next_to_nothing_do_not_keep_it_from_ending() {
        let (system, state) = solved(
            "hair\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\n\
             MARKER/10, PART=1\nMARKER/11, PART=1, QP=100,0,0\nPART/2, MASS=2, CM=20, IP=1000,1000,1000\n\
             MARKER/20, PART=2\nMARKER/21, PART=2, QP=1E-154,0,0\nJOINT/1, SPHERICAL, I=21, J=11\n\
             BUSHING/1, I=20, J=10, K=5000,5000,5000, KT=4000D,4000D,4000D\nACCGRAV/KGRAV=-9806.65\nEND\n"
                .to_string(),
        );
        let parameters = system.parameters();
        let smallest = smallest_eigenvalue(&system, &parameters, &state).unwrap();
        let (length, kt) = (system.length, 4000.0_f64.to_radians());
        // The joint at the bushing's own I marker stretches the bushing to 100 mm. The bushing force has no lever arm, so only KT remains.
        let expected = kt / (length * length);
        let smallest = smallest.unwrap();
        assert!(
            (smallest - expected).abs() < 1e-6 * expected,
            "{smallest} {expected}"
        );
    }

    #[test]
    fn what_cannot_move_has_no_stiffness_to_tell() {
        let (system, state) = solved(
            "held\nPART/1, GROUND\nMARKER/1, PART=1\nPART/2, MASS=1, CM=20, IP=1,1,1\nMARKER/20, PART=2\n\
             JOINT/1, FIXED, I=20, J=1\nSPRINGDAMPER/1, ROTATIONAL, I=20, J=1, KT=100\nEND\n"
                .to_string(),
        );
        let parameters = system.parameters();
        assert_eq!(smallest_eigenvalue(&system, &parameters, &state), Ok(None));
        let near = ShiftInvert::new(&system, &parameters, &state, lengths(&system)).smallest(100.0);
        assert_eq!(near, Ok(None));
    }
}
