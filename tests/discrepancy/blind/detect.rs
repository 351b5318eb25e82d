//! How much of an effect no stiffness and no nuisance can follow.

use admire_identify::LoadedStudy;
use admire_identify::global::gauss_newton::LeastSquares;
use admire_identify::global::{
    Observations, Options, Prepared, Row, Start, StartValues, Target, fit_study, fit_unknowns,
    global_problem,
};
use admire_study::Measurement;
use nalgebra::{DMatrix, DVector};

/// Directions a fit can follow anyway, at the truth.
pub struct Span {
    /// Whitened sensitivities, one column per unknown.
    jacobian: DMatrix<f64>,
    /// For columns that are an assembly offset, the bushing's id.
    offset_of: Vec<Option<u32>>,
    rows: Vec<Row>,
}

impl Span {
    /// Of a study whose deck is the true one, at the true stiffnesses.
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
                Target::Offset(component) => catalogue.info(component.stiffness).address.id,
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

    /// How many readings there are.
    pub fn rows(&self) -> usize {
        self.rows.len()
    }

    /// A change of all readings, in the order of the rows, in units of their noise.
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

    /// Sum of squares of what of a shift lies outside of the span. Offsets of the bushing `own` and further directions count as
    /// told: where the offset is what was planted, it is no nuisance; where a second effect is, it is one more.
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

/// What a fit of stiffnesses and nuisances leaves of readings without noise, as a sum of squares over the noise they would have: an
/// effect so large that stiffnesses follow it along a curve leaves less than the straight span says.
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
