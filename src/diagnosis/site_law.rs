//! Scan of the parameters of a hysteresis law at one site. All unknowns of the fit are marginalised, so the evidence of any history of forces at
//! the site costs one product with a small matrix. A force at the site also changes the displacement on which the law depends.
//!
//! Let `u` be the displacement without the force, and `c` the compliance. The law is a spring in series with a slider: the spring force is
//! `f = -k (v - a)` with `v = u + c f`. The slider moves when `|f|` reaches the limit `F`. The anchor `a` then follows.
//!
//! Sources: Prandtl, ZAMM 8 (1928) 85; Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), section 2.7.

use nalgebra::DVector;

use super::site::SiteModel;
use crate::settings::{
    LAW_GRID, LAW_GRID_DECADES, LAW_MAX_LIMIT_SD, LAW_REFINEMENTS, START_SLIP_LENGTH,
};

/// Priors of a friction law: half-normal scale of the limit, then median and log standard deviation of the slip length.
#[derive(Clone, Copy, Debug)]
pub(super) struct SliderPriors {
    pub limit: f64,
    pub slip_length: f64,
    pub slip_length_ln_sd: f64,
}

/// Parameters of a slider, and the force it starts with.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Slider {
    /// Largest force.
    pub limit: f64,
    /// Stretch of the spring at which the slider moves.
    pub slip_length: f64,
    /// Spring force in the first case, as a fraction of the limit, from -1 to 1.
    pub first: f64,
}

/// Result of a scan.
#[derive(Clone, Debug)]
pub(super) struct Scanned {
    /// Force in each case per unit of the limit, at the most probable parameters.
    pub pattern: Vec<f64>,
    /// Log Bayes factor of the law against no force at the site.
    #[cfg(test)]
    pub ln_bayes_factor: f64,
    /// Log Bayes factor of the law, minus the log Bayes factor of a force with this fixed pattern and a normal prior of its limit.
    pub correction: f64,
    /// Parameters with which fits start: first those with a long slip length, because the objective is smooth there, then the most probable ones.
    pub starts: [SliderStart; 2],
}

/// Parameters with which a fit starts.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct SliderStart {
    pub slider: Slider,
    /// Displacement at which the spring is unstretched before the first case.
    pub anchor: f64,
}

/// Displacements and compliance of one site in all cases.
#[derive(Clone, Copy)]
pub(super) struct SiteMotion<'a> {
    /// Displacement in each case, without the force.
    pub displacement: &'a [f64],
    /// Change of the displacement per unit force, in each case.
    pub compliance: &'a [f64],
}

impl SiteMotion<'_> {
    fn range(&self) -> f64 {
        let each = self.displacement.iter().copied();
        each.clone().fold(f64::NEG_INFINITY, f64::max) - each.fold(f64::INFINITY, f64::min)
    }

    /// Returns the force in each case, and the anchor before the first case.
    pub(super) fn forces(&self, slider: &Slider) -> (Vec<f64>, f64) {
        let Slider {
            limit,
            slip_length,
            first,
        } = *slider;
        let k = limit / slip_length;
        let at_first = first * limit;
        let first_displacement = self.displacement[0] + self.compliance[0] * at_first;
        let start = first_displacement + at_first / k;
        let mut anchor = start;
        let each = self.displacement.iter().zip(self.compliance);
        let forces = each.map(|(u, c)| {
            let held = -k * (u - anchor) / (1.0 + k * c.max(0.0));
            let force = held.clamp(-limit, limit);
            anchor = u + c.max(0.0) * force + force / k;
            force
        });
        (forces.collect(), start)
    }

    /// Scans the parameters of a slider. Returns `None` if the log Bayes factor is not finite.
    pub(super) fn scanned(&self, site: &SiteModel, priors: &SliderPriors) -> Option<Scanned> {
        let range = self.range();
        let mean_compliance =
            self.compliance.iter().map(|c| c.max(0.0)).sum::<f64>() / self.compliance.len() as f64;
        // A larger limit would hold the site still in all cases.
        let holding = range / mean_compliance.max(f64::MIN_POSITIVE);
        let largest = holding.min(LAW_MAX_LIMIT_SD * priors.limit);
        let ln_likelihood =
            |slider: &Slider| site.ln_likelihood(&DVector::from_vec(self.forces(slider).0));
        let ln_prior = |slider: &Slider| {
            let [limit, length] = [
                slider.limit / priors.limit,
                libm::log(slider.slip_length / priors.slip_length) / priors.slip_length_ln_sd,
            ];
            // Densities of ln F, of ln L and of the first force. The constant of a half-normal density is sqrt(2/pi).
            let half = 0.5 * libm::log(std::f64::consts::FRAC_2_PI);
            let normal = -0.5 * libm::log(2.0 * std::f64::consts::PI);
            half + libm::log(limit) - 0.5 * limit * limit + normal
                - libm::log(priors.slip_length_ln_sd)
                - 0.5 * length * length
                - std::f64::consts::LN_2
        };
        let value = |slider: &Slider| ln_likelihood(slider) + ln_prior(slider);
        let grid = Grid::new(largest, range);
        let mut best: Option<(f64, Slider)> = None;
        let mut smooth: Option<(f64, Slider)> = None;
        for slider in grid.all() {
            let ln_likelihood = ln_likelihood(&slider);
            let here = ln_likelihood + ln_prior(&slider);
            if best.is_none_or(|(most, _)| here > most) {
                best = Some((here, slider));
            }
            let is_smooth = slider.slip_length == START_SLIP_LENGTH * range;
            if is_smooth && smooth.is_none_or(|(most, _)| ln_likelihood > most) {
                smooth = Some((ln_likelihood, slider));
            }
        }
        let (_, slider) = best?;
        let (peak, slider, curvature) = refined(&value, slider, grid.steps);
        // Laplace approximation in each parameter. Each width is limited to the extent of the grid, which is 2 for the first force.
        let width = |(curvature, span): (&f64, &f64)| {
            let width = (2.0 * std::f64::consts::PI / curvature).sqrt();
            libm::log(width.min(*span))
        };
        let widths = curvature.iter().zip(&grid.spans).map(width);
        let ln_bayes_factor = peak + widths.sum::<f64>();
        let (forces, _) = self.forces(&slider);
        let pattern: Vec<f64> = forces.iter().map(|f| f / slider.limit).collect();
        let column = DVector::from_vec(pattern.iter().map(|p| p * priors.limit).collect());
        let information = 1.0 + site.information_of(&column);
        let linear =
            0.5 * column.dot(&site.gradient).powi(2) / information - 0.5 * libm::log(information);
        let smooth = smooth.map_or(slider, |(_, at)| {
            refined_at_length(&ln_likelihood, at, grid.steps).1
        });
        let start = |slider: Slider| SliderStart {
            slider,
            anchor: self.forces(&slider).1,
        };
        ln_bayes_factor.is_finite().then_some(Scanned {
            pattern,
            #[cfg(test)]
            ln_bayes_factor,
            correction: ln_bayes_factor - linear,
            starts: [start(smooth), start(slider)],
        })
    }
}

/// Grid of the parameters of a slider: logarithms of limit and slip length, and the first force.
struct Grid {
    limits: Vec<f64>,
    lengths: Vec<f64>,
    firsts: Vec<f64>,
    /// Distances between neighbouring grid points, for each parameter.
    steps: [f64; 3],
    /// Extents of the grid, for each parameter.
    spans: [f64; 3],
}

impl Grid {
    fn new(largest: f64, range: f64) -> Self {
        let [limits, lengths, firsts] = LAW_GRID;
        let span = LAW_GRID_DECADES * std::f64::consts::LN_10;
        let below = |top: f64, count: usize| -> (Vec<f64>, f64) {
            let step = span / (count - 1) as f64;
            let each = (0..count).map(|k| top * libm::exp(-step * k as f64));
            (each.collect(), step)
        };
        let (limits, limit_step) = below(largest, limits);
        // The grid point nearest to the slip length with which fits start is replaced by that slip length.
        let (mut lengths, length_step) = below(range, lengths);
        let near = |a: f64| libm::log(a / (START_SLIP_LENGTH * range)).abs();
        if let Some(nearest) = lengths
            .iter_mut()
            .min_by(|a, b| near(**a).total_cmp(&near(**b)))
        {
            *nearest = START_SLIP_LENGTH * range;
        }
        let first_step = 2.0 / (firsts - 1) as f64;
        Self {
            limits,
            lengths,
            firsts: (0..firsts).map(|k| -1.0 + first_step * k as f64).collect(),
            steps: [limit_step, length_step, first_step],
            spans: [span, span, 2.0],
        }
    }

    fn all(&self) -> impl Iterator<Item = Slider> + '_ {
        self.limits.iter().flat_map(move |limit| {
            self.lengths.iter().flat_map(move |slip_length| {
                self.firsts.iter().map(move |first| Slider {
                    limit: *limit,
                    slip_length: *slip_length,
                    first: *first,
                })
            })
        })
    }
}

/// Returns a slider with one parameter changed by `step`: the logarithm of the limit (0) or of the slip length (1), or the first force (2).
fn moved(slider: &Slider, parameter: usize, step: f64) -> Slider {
    let mut out = *slider;
    match parameter {
        0 => out.limit *= libm::exp(step),
        1 => out.slip_length *= libm::exp(step),
        _ => out.first = (out.first + step).clamp(-1.0, 1.0),
    }
    out
}

/// Maximises `value` by steps along single parameters. Steps of one length are repeated as long as they increase the value. Then they are
/// halved. Returns the maximum, its location, and the curvature along each parameter. The curvature is computed from differences over the
/// shortest step by which the value falls by half a nat.
fn refined(
    value: &dyn Fn(&Slider) -> f64,
    mut at: Slider,
    mut steps: [f64; 3],
) -> (f64, Slider, [f64; 3]) {
    let mut best = value(&at);
    for _ in 0..LAW_REFINEMENTS {
        for step in &mut steps {
            *step *= 0.5;
        }
        loop {
            let before = best;
            for parameter in 0..3 {
                for sign in [-1.0, 1.0] {
                    let there = moved(&at, parameter, sign * steps[parameter]);
                    let found = value(&there);
                    if found > best {
                        (best, at) = (found, there);
                    }
                }
            }
            if best <= before {
                break;
            }
        }
    }
    let curvature = std::array::from_fn(|parameter| {
        let mut step = steps[parameter];
        loop {
            // A parameter at its bound can move to one side only.
            let sides = [-1.0, 1.0].map(|sign| moved(&at, parameter, sign * step));
            let falls = sides.iter().filter(|there| **there != at);
            let falls: Vec<f64> = falls.map(|there| best - value(there)).collect();
            let least = falls.iter().copied().fold(f64::INFINITY, f64::min);
            if least > 0.5 || step > 1.0 {
                let mean = falls.iter().sum::<f64>() / falls.len() as f64;
                return 2.0 * mean.max(0.0) / (step * step);
            }
            step *= 2.0;
        }
    });
    (best, at, curvature)
}

/// Maximises `value` as [`refined`] does, at a fixed slip length.
fn refined_at_length(
    value: &dyn Fn(&Slider) -> f64,
    at: Slider,
    steps: [f64; 3],
) -> (f64, Slider, [f64; 3]) {
    let held = at.slip_length;
    let at_length = |slider: &Slider| {
        value(&Slider {
            slip_length: held,
            ..*slider
        })
    };
    let (best, found, curvature) = refined(&at_length, at, steps);
    let found = Slider {
        slip_length: held,
        ..found
    };
    (best, found, curvature)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    /// Checks a slider at a compliant site: the forces must satisfy both the law and the compliance of the site.
    #[test]
    fn forces_and_displacements_satisfy_law_and_compliance() {
        let u: Vec<f64> = (0..40).map(|k| libm::sin(0.35 * f64::from(k))).collect();
        let c = vec![0.002; u.len()];
        let motion = SiteMotion {
            displacement: &u,
            compliance: &c,
        };
        let slider = Slider {
            limit: 100.0,
            slip_length: 0.1,
            first: 0.3,
        };
        let (forces, start) = motion.forces(&slider);
        assert!((forces[0] - 30.0).abs() < 1e-9);
        let (k, mut anchor, mut slips) = (1000.0, start, 0);
        for (u, f) in u.iter().zip(&forces) {
            let v = u + 0.002 * f;
            let stretch: f64 = v - anchor;
            // Force by the return map of the solver's own friction element, at the displacement that includes the effect of the force.
            let slip = admire_solver::element::Slip::at(v, &[k, 100.0, anchor]);
            assert!((slip.force - k * stretch.clamp(-0.1, 0.1)).abs() < 1e-9);
            assert!((f + slip.force).abs() < 1e-9, "{f} {}", slip.force);
            slips += i32::from(stretch.abs() > 0.1 + 1e-12);
            anchor = slip.anchor_after;
        }
        assert!(slips > 10, "{slips}");
    }

    /// Checks that the scan finds a planted slider whose forces are read with an error of 5 N each. Without a slider, it finds nothing.
    #[test]
    fn a_planted_slider_is_found() {
        let n = 40;
        let u: Vec<f64> = (0..n).map(|k| libm::sin(0.35 * f64::from(k))).collect();
        let c = vec![0.002; u.len()];
        let motion = SiteMotion {
            displacement: &u,
            compliance: &c,
        };
        let priors = SliderPriors {
            limit: 300.0,
            slip_length: 0.12,
            slip_length_ln_sd: 1.5,
        };
        let truth = Slider {
            limit: 130.0,
            slip_length: 0.03,
            first: 0.0,
        };
        let information = DMatrix::identity(u.len(), u.len()) / 25.0;
        let planted = DVector::from_vec(motion.forces(&truth).0);
        let with = |force: &DVector<f64>| {
            let site = SiteModel::of_readings(information.clone(), &information * force);
            motion.scanned(&site, &priors).expect("a finite value")
        };
        let found = with(&planted);
        let most = 0.5 * planted.dot(&(&information * &planted));
        assert!(found.ln_bayes_factor > most - 25.0 && found.ln_bayes_factor < most);
        let off = planted
            .iter()
            .zip(&found.pattern)
            .map(|(f, p)| (f - 130.0 * p).abs());
        assert!(off.fold(0.0, f64::max) < 10.0);
        assert_eq!(
            found.starts[0].slider.slip_length,
            START_SLIP_LENGTH * motion.range()
        );
        assert!(with(&DVector::zeros(u.len())).ln_bayes_factor < 0.0);
    }
}
