use crate::model::IntegratorSettings;

/// How a motion is integrated.
#[derive(Clone, PartialEq, Debug)]
pub struct MotionSettings {
    /// ERROR: what a step may err by, relative to the larger of one and the largest value of a kind.
    pub error: f64,
    /// HINIT: the first step.
    pub hinit: f64,
    /// HMAX: the largest step.
    pub hmax: f64,
    /// HMIN: a step below ends the simulation.
    pub hmin: f64,
    /// DTOUT: how far apart outputs are.
    pub output: f64,
    /// MAXIT: iterations of a step.
    pub maxit: usize,
    /// What the tolerance of the iterations is multiplied by: CORRECTOR, and ADAPTIVITY over the step.
    pub corrector: f64,
    /// ADAPTIVITY.
    pub adaptivity: f64,
}

/// The tolerance of the method inside of ERROR: what is left of the error stays below it.
pub(super) const INSIDE: f64 = 0.1;

impl MotionSettings {
    /// INTEGRATOR for output steps of this length: HMAX is the output step, HINIT HMAX/20, HMIN 1e-6 HMAX where nothing is given.
    pub fn of(given: &IntegratorSettings, output: f64) -> Self {
        let hmax = given.hmax.filter(|h| *h > 0.0).unwrap_or(output);
        Self {
            error: given.error(),
            hinit: given.hinit.filter(|h| *h > 0.0).unwrap_or(hmax / 20.0),
            hmax,
            hmin: given.hmin.filter(|h| *h > 0.0).unwrap_or(1e-6 * hmax),
            output,
            maxit: given.maxit.map_or(10, |n| n.clamp(2, 100)),
            corrector: if given.corrector == "MODIFIED" {
                10.0
            } else {
                1.0
            },
            adaptivity: given.adaptivity,
        }
    }
}
