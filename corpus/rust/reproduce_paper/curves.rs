use std::ops::ControlFlow;

use super::{Curve, ReproductionError};
use admire_identify::global::{GlobalFit, Options, Prepared, fit_study};
use admire_identify::marker_pose;
use admire_identify::{Fit, IdentifyError, LoadedStudy, regression};
use admire_session::backend::{
    Backend, BackendError, LoadCase, LoadProgramme, NativeBackend, Sweep, SweepRequest,
};
use admire_solver::mechanics::Pose;
use admire_solver::model::{MarkerIx, Model};
use admire_study::noise::Noise;
use admire_study::settings::SpinAxis;
use admire_study::wheel::SpinDirection;

/// Replaces the mark readings of a study by predictions of its reference deck, with added Gaussian noise. (Marks are measured points on
/// parts.)
pub(super) fn read_reference(
    study: &mut LoadedStudy,
    sigma: f64,
    seed: u64,
) -> Result<(), ReproductionError> {
    let sweep = {
        let (model, dataset) = reference(study)?;
        let request = SweepRequest {
            dataset,
            model: &model,
            theta: &[],
            programme: &study.programme,
        };
        NativeBackend::new()
            .sweep(&request)
            .map_err(IdentifyError::from)?
    };
    let mut noise = Noise::new(seed, "marks");
    let measurement = &mut study.measurement;
    for (at, case) in measurement.cases.iter_mut().enumerate() {
        let Some(equilibrium) = sweep.equilibrium(at) else {
            continue;
        };
        for reading in &mut case.marks {
            let marked = &measurement.parts[reading.part];
            let x = equilibrium.poses[marked.part.0].point(&marked.marks[reading.mark].p);
            reading.x = x + noise.vector(sigma);
        }
    }
    measurement.sigma = sigma;
    Ok(())
}

/// Returns the model of a study's reference deck.
pub(super) fn reference(
    study: &LoadedStudy,
) -> Result<(Model, &admire_syntax::Dataset), ReproductionError> {
    let dataset = study.reference.as_ref().ok_or(ReproductionError::Lacks {
        folder: study.study.source.name().to_string(),
        needs: "reference deck",
    })?;
    Ok((Model::lower(dataset).value, dataset))
}

/// Identifies the stiffnesses by the iteration of the paper, with the study's settings.
pub(super) fn by_loop(study: &LoadedStudy) -> Result<Fit, IdentifyError> {
    let mut quiet = |_: usize, _: &[f64], _: f64| ControlFlow::Continue(());
    regression::identify(&study.problem(), &mut NativeBackend::new(), &mut quiet)
}

/// Identifies the stiffnesses by the global fit, with the study's settings. Returns the fit and the number of sweeps that it needed.
pub(super) fn by_fit(study: &LoadedStudy) -> Result<(Fit, usize), IdentifyError> {
    let problem = study.problem();
    let prepared = Prepared::new(&problem)?;
    let GlobalFit { fit, problem, .. } = fit_study(&problem, &prepared, None, Options::default())?;
    let sweeps = problem.predictor.sweeps();
    Ok((fit, sweeps))
}

/// Wheel of a study. It is the wheel in the study's settings if there is one, or else the marker WC with the spin axis y.
pub(super) struct Wheel {
    marker: MarkerIx,
    spin: SpinDirection,
}

impl Wheel {
    pub(super) fn of(study: &LoadedStudy) -> Result<Self, ReproductionError> {
        if let Some(wheel) = &study.measurement.wheel {
            return Ok(Self {
                marker: wheel.marker,
                spin: wheel.spin,
            });
        }
        let model = &study.model;
        let named = |header: &admire_solver::model::Header| header.name.eq_ignore_ascii_case("WC");
        let marker = model.markers.iter().position(|m| named(&m.header));
        let marker = marker.map(MarkerIx).ok_or(ReproductionError::Lacks {
            folder: study.study.source.name().to_string(),
            needs: "[wheel] and no marker WC",
        })?;
        let design: Vec<Pose> = model.parts.iter().map(|part| part.pose).collect();
        let y = SpinAxis {
            axis: 1,
            sign: None,
        };
        let spin = SpinDirection::at_design(&marker_pose(model, &design, marker), y);
        Ok(Self { marker, spin })
    }

    /// Returns camber and steer of the wheel in degrees.
    fn angles(&self, model: &Model, poses: &[Pose]) -> [f64; 2] {
        let reading = self.spin.reading(&marker_pose(model, poses, self.marker));
        [reading.camber_deg, reading.steer_deg]
    }
}

/// Returns the curves of camber and steer over one load of a programme (sequence of load cases), with the unknowns set to `values`.
pub(super) fn wheel_curves(
    (study, wheel): (&LoadedStudy, &Wheel),
    values: &[f64],
    (programme, load): (&LoadProgramme, usize),
    name: &str,
) -> Result<[Curve; 2], ReproductionError> {
    let request = SweepRequest {
        dataset: &study.dataset,
        model: &study.model,
        theta: &study.problem().theta(values),
        programme,
    };
    let sweep: Result<Sweep, BackendError> = NativeBackend::new().sweep(&request);
    let sweep = sweep.map_err(IdentifyError::from)?;
    let mut curves = [0, 1].map(|_| Curve {
        name: name.to_string(),
        points: Vec::new(),
    });
    for (at, case) in programme.cases.iter().enumerate() {
        let angles = sweep.equilibrium(at);
        let angles = angles.map_or([f64::NAN; 2], |e| wheel.angles(&study.model, &e.poses));
        for (curve, angle) in curves.iter_mut().zip(angles) {
            curve.points.push((case.values[load], angle));
        }
    }
    Ok(curves.map(Curve::since_zero))
}

/// Returns a programme of load cases in which the load `name` takes the given values. The vertical load is fixed at `vertical`; all other
/// loads are zero.
pub(super) fn ramp(
    study: &LoadedStudy,
    name: &'static str,
    values: impl Iterator<Item = f64>,
    vertical: f64,
) -> Result<(LoadProgramme, usize), ReproductionError> {
    let loads = study.programme.loads.clone();
    let column = |name: &str| loads.iter().position(|load| load.name == name);
    let (Some(varied), Some(up)) = (column(name), column("vertical")) else {
        return Err(ReproductionError::Lacks {
            folder: study.study.source.name().to_string(),
            needs: "loads named vertical, lateral and longitudinal",
        });
    };
    let case = |value: f64| {
        let mut all = vec![0.0; loads.len()];
        all[up] = vertical;
        all[varied] = value;
        LoadCase {
            label: format!("{value}"),
            values: all,
        }
    };
    let cases = values.map(case).collect();
    Ok((LoadProgramme { loads, cases }, varied))
}
