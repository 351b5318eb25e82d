//! Equilibrium equations linearised at the measured poses, one set per load case.

use nalgebra::{DMatrix, DVector};

use admire_solver::linear::Sink;
use admire_solver::mechanics::eigen::{pseudo_inverse, symmetric_eigen};
use admire_solver::mechanics::{Mat6, Pose, log, skew};
use admire_solver::model::{Model, PartIx};
use admire_solver::system::{NoValue, Parameters, Scratch, Slot, State, System};
use admire_study::Measurement;
use admire_study::orientation::absolute_orientation;

/// Measured poses of all moving parts in one load case, with the current estimate of the true poses.
#[derive(Clone)]
pub(super) struct CaseState {
    /// Index of the load case.
    pub case: usize,
    measured: Vec<(PartIx, Pose)>,
    /// Covariance of the measured poses, over the unknowns of all parts.
    covariance: DMatrix<f64>,
    state: State,
}

/// Linearised equations `residual + columns * dtheta + (noise) = 0` of one load case. They contain the force balance without joint reactions,
/// and the constraints.
pub(super) struct Linearised {
    /// Residual at the measured poses and the current parameter values, extrapolated to first order from the current poses.
    pub residual: DVector<f64>,
    /// Derivatives with respect to each parameter.
    pub columns: DMatrix<f64>,
    /// Covariance of the residual that the noise of the measured poses causes.
    pub covariance: DMatrix<f64>,
    /// Covariance of the poses times the transposed derivative of the equations with respect to the poses.
    pub gain: DMatrix<f64>,
    /// Measured minus current poses, as a change of the part unknowns.
    pub misfit: DVector<f64>,
}

struct Entries(DMatrix<f64>);

impl Sink for Entries {
    fn add(&mut self, row: usize, column: usize, value: f64) {
        self.0[(row, column)] += value;
    }
}

impl CaseState {
    /// Creates the state of a load case at the measured poses. Returns `None` if the pose of a moving part is not measured in this case.
    pub(crate) fn new(
        system: &System,
        model: &Model,
        measurement: &Measurement,
        case: usize,
        sigma: f64,
    ) -> Option<Self> {
        let parts = system.equations_start();
        let mut covariance = DMatrix::zeros(parts, parts);
        let mut measured = Vec::new();
        let mut state = system.state();
        for part in (0..model.parts.len()).map(PartIx) {
            let unknowns = system.part_unknowns(part);
            if unknowns.is_empty() {
                continue;
            }
            let marked = measurement
                .parts
                .iter()
                .position(|marked| marked.part == part)?;
            let (on_part, read) = measurement.pairs(case, marked);
            let fit = absolute_orientation(&on_part, &read, sigma).ok()?;
            if unknowns.len() != 6 {
                return None;
            }
            state.poses[part.0] = fit.pose;
            // The covariance refers to the part's origin. It is converted to the part's reference point by dp + dphi x arm.
            let mut moved = Mat6::identity();
            let by_turn = -skew(&system.reference_arm(&state, part.0));
            moved.fixed_view_mut::<3, 3>(0, 3).copy_from(&by_turn);
            covariance
                .view_mut((unknowns.start, unknowns.start), (6, 6))
                .copy_from(&(moved * fit.covariance * moved.transpose()));
            measured.push((part, fit.pose));
        }
        Some(Self {
            case,
            measured,
            covariance,
            state,
        })
    }

    /// Linearises the equations at the current poses. The Lagrange multipliers are set to the values that balance the parts best.
    pub(crate) fn linearise(
        &mut self,
        system: &System,
        parameters: &Parameters,
        scratch: &mut Scratch,
        slots: &[Vec<Slot>],
    ) -> Result<Linearised, NoValue> {
        let unknowns = system.unknowns();
        let parts = system.equations_start();
        let equations = self.state.multipliers.len();
        let mut g = vec![0.0; unknowns];
        let mut jacobian = Entries(DMatrix::zeros(unknowns, unknowns));
        system.assemble(parameters, &self.state, scratch, &mut g, &mut jacobian)?;
        // The reactions enter linearly as G^T lambda. This gives a basis of their orthogonal complement, and the pseudo-inverse that yields the
        // multipliers.
        let reactions = jacobian.0.view((0, parts), (parts, equations)).into_owned();
        let (basis, free) = split(&reactions);
        let balance = DVector::from_column_slice(&g[..parts]);
        let correction = free * balance;
        for (multiplier, change) in self.state.multipliers.iter_mut().zip(correction.iter()) {
            *multiplier -= change;
        }
        jacobian.0.fill(0.0);
        system.assemble(parameters, &self.state, scratch, &mut g, &mut jacobian)?;
        let balance = DVector::from_column_slice(&g[..parts]);
        let constraints = DVector::from_column_slice(&g[parts..parts + equations]);
        let tangent = jacobian.0.view((0, 0), (parts, parts));
        let constraint_rows = jacobian.0.view((parts, 0), (equations, parts));
        let rows = basis.ncols() + equations;
        let mut residual = DVector::zeros(rows);
        let mut h = DMatrix::zeros(rows, parts);
        residual
            .rows_mut(0, basis.ncols())
            .copy_from(&(basis.transpose() * &balance));
        residual
            .rows_mut(basis.ncols(), equations)
            .copy_from(&constraints);
        h.rows_mut(0, basis.ncols())
            .copy_from(&(basis.transpose() * tangent));
        h.rows_mut(basis.ncols(), equations)
            .copy_from(&constraint_rows);
        let mut columns = DMatrix::zeros(rows, slots.len());
        let mut dg = vec![0.0; unknowns];
        for (k, tied) in slots.iter().enumerate() {
            for slot in tied {
                system.residual_by_slot(parameters, &self.state, scratch, *slot, &mut dg)?;
                let by = basis.transpose() * DVector::from_column_slice(&dg[..parts]);
                let mut column = columns.column_mut(k);
                let mut upper = column.rows_mut(0, basis.ncols());
                upper += by;
            }
        }
        let misfit = self.misfit(system);
        let gain = &self.covariance * h.transpose();
        Ok(Linearised {
            residual: residual + &h * &misfit,
            columns,
            covariance: &h * &gain,
            gain,
            misfit,
        })
    }

    /// Returns measured minus current poses, as a change of the part unknowns.
    fn misfit(&self, system: &System) -> DVector<f64> {
        let mut misfit = DVector::zeros(self.covariance.nrows());
        for (part, measured) in &self.measured {
            let now = &self.state.poses[part.0];
            let first = system.part_unknowns(*part).start;
            let point = system.local_reference(&self.state, part.0);
            misfit
                .fixed_rows_mut::<3>(first)
                .copy_from(&(measured.point(&point) - now.point(&point)));
            let turn = log(&(measured.R * now.R.transpose()));
            misfit.fixed_rows_mut::<3>(first + 3).copy_from(&turn);
        }
        misfit
    }

    /// Resets the current poses to the measured poses.
    pub(crate) fn as_measured(&mut self) {
        for (part, measured) in &self.measured {
            self.state.poses[part.0] = *measured;
        }
    }

    /// Moves the current poses by a change of the part unknowns.
    pub(crate) fn advance(&mut self, system: &System, change: &DVector<f64>) {
        for (part, _) in &self.measured {
            system.displace(&mut self.state, *part, change.as_slice());
        }
    }
}

/// Returns an orthonormal basis of the complement of the column space of `a`, and the pseudo-inverse of `a`.
fn split(a: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    let rows = a.nrows();
    if a.ncols() == 0 {
        return (DMatrix::identity(rows, rows), DMatrix::zeros(0, rows));
    }
    let eigen = symmetric_eigen(a * a.transpose());
    let largest = eigen.eigenvalues.max();
    let open: Vec<usize> = (0..rows)
        .filter(|&k| eigen.eigenvalues[k] <= 1e-12 * largest)
        .collect();
    let basis = eigen.eigenvectors.select_columns(&open);
    let pseudo = pseudo_inverse(a.clone(), 1e-9 * largest.sqrt());
    (
        basis,
        pseudo.unwrap_or_else(|| DMatrix::zeros(a.ncols(), rows)),
    )
}
