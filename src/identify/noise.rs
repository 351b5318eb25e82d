//! Estimation of the noise of channels (scalar sensors) whose noise the study does not state, from the residuals of a fit.

use super::LoadedStudy;
use super::global::{GlobalFit, Observations, Options, Prepared, Row, effective_dof, fit_study};
use crate::IdentifyError;
use crate::settings::{CHANNEL_NOISE_MAX_FITS, CHANNEL_NOISE_TOLERANCE};
use admire_session::backend::Backend;

/// Estimates the noise of every channel whose noise is not stated. The variance is the sum of the channel's squared residuals over their
/// degrees of freedom. The fit is repeated with the new noise until the estimates converge.
///
/// The degrees of freedom used by the unknowns are distributed over all readings in equal shares. Model errors count as noise here.
///
/// # Errors
/// Fails if a fit fails, see [`fit_study`].
pub fn estimate_noise(
    loaded: &mut LoadedStudy,
    mut backend: Option<&mut (dyn Backend + '_)>,
) -> Result<(), IdentifyError> {
    let channels = loaded.measurement.channels.len();
    let stated = loaded
        .measurement
        .channels
        .iter()
        .all(|channel| !channel.sigma_estimated);
    if loaded.unknowns.is_empty() || stated {
        return Ok(());
    }
    for _ in 0..CHANNEL_NOISE_MAX_FITS {
        let sizes = {
            let problem = loaded.problem();
            let prepared = match backend {
                Some(_) => Prepared::external(&problem)?,
                None => Prepared::new(&problem)?,
            };
            let options = Options::default();
            let found = match &mut backend {
                Some(backend) => fit_study(&problem, &prepared, Some(&mut **backend), options)?,
                None => fit_study(&problem, &prepared, None, options)?,
            };
            sizes(&found, channels)
        };
        let mut moved: f64 = 0.0;
        for (channel, size) in loaded.measurement.channels.iter_mut().zip(sizes) {
            if let (true, Some(size)) = (channel.sigma_estimated, size) {
                moved = moved.max((size - 1.0).abs());
                channel.sigma *= size;
            }
        }
        if moved < CHANNEL_NOISE_TOLERANCE {
            break;
        }
    }
    Ok(())
}

/// Returns the standard deviation of the whitened residuals of each channel, or `None` where it cannot be estimated.
fn sizes(found: &GlobalFit<'_>, channels: usize) -> Vec<Option<f64>> {
    let observations = &found.problem.observations;
    let share = effective_dof(&found.problem, &found.minimum) / observations.rows.len() as f64;
    let residual = found.minimum.evaluation.residual.as_slice();
    (0..channels)
        .map(|k| spread(observations, residual, k, share))
        .collect()
}

/// Returns the standard deviation of the whitened residuals of channel `k`. `share` is the number of degrees of freedom per reading. Returns
/// `None` with less than one degree of freedom or if all residuals are zero.
fn spread(observations: &Observations<'_>, residual: &[f64], k: usize, share: f64) -> Option<f64> {
    let of = observations.rows.iter().zip(residual);
    let of = of.filter(|(row, _)| matches!(row, Row::Channel { channel, .. } if *channel == k));
    let (count, sum) = of.fold((0, 0.0), |(n, sum), (_, r)| (n + 1, sum + r * r));
    let dof = share * f64::from(count);
    (dof >= 1.0 && sum > 1e-24).then(|| (sum / dof).sqrt())
}
