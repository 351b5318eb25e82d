//! Detectability of an effect: the part of its shift that neither stiffnesses nor nuisances can follow.

use admire_identify::LoadedStudy;
use admire_identify::global::gauss_newton::LeastSquares;
use admire_identify::global::{
    Observations, Options, Prepared, Row, Start, StartValues, UnknownTarget, fit_study,
    fit_unknowns, global_problem,
};
use admire_study::Measurement;
use nalgebra::{DMatrix, DVector};

/// Directions in reading space that a fit can follow, at the true values.
pub struct Span {
    /// Whitened sensitivities, one column per unknown.
    jacobian: DMatrix<f64>,
    /// Id of the bushing for each column that is an assembly offset.
    offset_of: Vec<Option<u32>>,
    rows: Vec<Row>,
}

impl Span {
    /// Computes the span of a study with the true deck at the true stiffnesses.
    pub fn new(study: &LoadedStudy, values: &[f64]) -> Self {
        let problem = study.problem();
        let prepared = Prepared::new(&problem).expect("a deck that can be solved");
        let cases: Vec<usize> = (0..study.measurement.cases.len()).collect();
        let observations = Observations::new(problem.measurement, problem.model, &cases);
        let rows = observations.rows.clone();
        let start = StartValues {
            values: values.to_vec(),
            offsets: Vec::new(),
        };
        let unknowns = fit_unknowns(&problem, &prepared.system, Some(&start));
        let catalogue = prepared.system.catalogue();
        let mut offset_of: Vec<Option<u32>> = unknowns
            .list()
            .iter()
            .map(|unknown| match unknown.target {
                UnknownTarget::Offset(component) => catalogue.info(component.stiffness).address.id,
                _ => None,
            })
            .collect();
        let predictor = prepared
            .native(&problem, observations.observed.clone())
            .expect("loads of the deck");
        let mut global = global_problem(&problem, observations, unknowns, Box::new(predictor));
        offset_of.resize(global.dimension(), None);
        let start = global.start();
        let evaluation = global
            .evaluate(&start, true)
            .expect("the truth is in balance");
        Self {
            jacobian: evaluation.jacobian,
            offset_of,
            rows,
        }
    }

    /// Returns for each load case the change of all readings by one unit of a load in that case alone. `change` holds the whitened change by one
    /// unit in all cases.
    ///
    /// The readings of a case depend on the loads of that case only.
    pub fn case_by_case(&self, change: &DVector<f64>) -> Vec<DVector<f64>> {
        let case_of = |row: &Row| match *row {
            Row::Mark { case, .. } | Row::Wheel { case, .. } | Row::Channel { case, .. } => case,
        };
        let mut cases: Vec<usize> = self.rows.iter().map(case_of).collect();
        cases.dedup();
        let own = |case: usize| {
            let of = |(x, row): (&f64, &Row)| if case_of(row) == case { *x } else { 0.0 };
            let each = change.iter().zip(&self.rows).map(of);
            DVector::from_iterator(change.len(), each)
        };
        cases.into_iter().map(own).collect()
    }

    /// Returns the chi-square of a shift against noise and usual errors, outside of the span. Each of `errors` is the whitened change of all
    /// readings by one standard deviation of a usual error.
    ///
    /// Each error is a further unknown with a reading of zero and a standard deviation of one.
    pub fn beside_errors(
        &self,
        shift: &DVector<f64>,
        own: Option<u32>,
        errors: &[DVector<f64>],
    ) -> f64 {
        let (rows, count) = (self.rows.len(), errors.len());
        let kept: Vec<usize> = (0..self.jacobian.ncols())
            .filter(|k| own.is_none() || self.offset_of[*k] != own)
            .collect();
        let mut columns = DMatrix::zeros(rows + count, kept.len() + count);
        for (at, k) in kept.iter().enumerate() {
            let norm = self.jacobian.column(*k).norm();
            if norm > 0.0 {
                let unit = self.jacobian.column(*k) / norm;
                columns.view_mut((0, at), (rows, 1)).copy_from(&unit);
            }
        }
        for (k, error) in errors.iter().enumerate() {
            let at = kept.len() + k;
            columns.view_mut((0, at), (rows, 1)).copy_from(error);
            columns[(rows + k, at)] = 1.0;
        }
        let mut wanted = DVector::zeros(rows + count);
        wanted.rows_mut(0, rows).copy_from(shift);
        let found = columns.clone().svd(true, true).solve(&wanted, 1e-9);
        let found = found.expect("both factors are computed");
        (wanted - columns * found).norm_squared()
    }

    /// Returns the number of readings.
    pub fn rows(&self) -> usize {
        self.rows.len()
    }

    /// Divides a change of all readings, in the order of the rows, by their noise.
    pub fn whitened(&self, change: &DVector<f64>, measurement: &Measurement) -> DVector<f64> {
        assert_eq!(change.len(), self.rows.len());
        let wheel = measurement.wheel.as_ref();
        let noise = |row: &Row| match *row {
            Row::Mark { .. } => measurement.sigma,
            Row::Wheel { component, .. } => wheel.map_or(1.0, |w| {
                if component < 3 {
                    w.sigma_position
                } else {
                    w.sigma_angle_deg
                }
            }),
            Row::Channel { channel, .. } => measurement.channels[channel].sigma,
        };
        let whitened = change.iter().zip(&self.rows).map(|(x, row)| x / noise(row));
        DVector::from_iterator(self.rows.len(), whitened)
    }

    /// Returns the sum of squares of the part of a shift outside of the span.
    ///
    /// Offsets of the bushing `own` are left out of the span, because there the offset is the planted effect. The `further` directions,
    /// such as the directions of a second effect, are added to the span.
    pub fn outside(&self, shift: &DVector<f64>, own: Option<u32>, further: &[DVector<f64>]) -> f64 {
        let kept: Vec<usize> = (0..self.jacobian.ncols())
            .filter(|k| own.is_none() || self.offset_of[*k] != own)
            .collect();
        let mut columns = self.jacobian.select_columns(&kept);
        for column in further {
            let at = columns.ncols();
            columns = columns.insert_column(at, 0.0);
            columns.set_column(at, column);
        }
        for mut column in columns.column_iter_mut() {
            let norm = column.norm();
            if norm > 0.0 {
                column /= norm;
            }
        }
        let eigen = (columns.tr_mul(&columns)).symmetric_eigen();
        let along = eigen.eigenvectors.tr_mul(&columns.tr_mul(shift));
        let inside: f64 = along
            .iter()
            .zip(eigen.eigenvalues.iter())
            .filter(|(_, value)| **value > 1e-9)
            .map(|(a, value)| a * a / value)
            .sum();
        (shift.norm_squared() - inside).max(0.0)
    }
}

/// Returns the residual sum of squares of a fit of stiffnesses and nuisances to readings without noise, in units of their nominal noise.
///
/// For a large effect the stiffnesses follow along a curve, and the residual is smaller than the linear span suggests.
pub fn left_by_a_fit(study: &LoadedStudy, values: &[f64]) -> Option<f64> {
    let problem = study.problem();
    let prepared = Prepared::new(&problem).ok()?;
    let options = Options {
        start: Start::At(StartValues {
            values: values.to_vec(),
            offsets: Vec::new(),
        }),
        profile: false,
        watch: None,
    };
    let fit = fit_study(&problem, &prepared, None, options).ok()?;
    Some(2.0 * fit.minimum.objective)
}
