use crate::model::IntegratorSettings;

/// Settings of the integrator.
#[derive(Clone, PartialEq, Debug)]
pub struct MotionSettings {
    /// ERROR: error allowed per step. It is relative to the largest value so far of the same kind of unknown, but at least to one.
    pub error: f64,
    /// HINIT: size of the first time step.
    pub hinit: f64,
    /// HMAX: largest time step.
    pub hmax: f64,
    /// HMIN: time step below which the simulation ends with an error.
    pub hmin: f64,
    /// DTOUT: time between outputs.
    pub output: f64,
    /// MAXIT: largest number of Newton iterations per time step.
    pub maxit: usize,
    /// Factor on the convergence tolerance of the Newton iteration: 10 for CORRECTOR=MODIFIED, otherwise 1.
    pub corrector: f64,
    /// ADAPTIVITY: the convergence tolerance is multiplied by 1 + ADAPTIVITY / step size.
    pub adaptivity: f64,
}

/// Ratio of the internal tolerance to ERROR. It keeps the error of the solution below ERROR.
pub(super) const INSIDE: f64 = 0.1;

impl MotionSettings {
    /// Returns the settings of an INTEGRATOR statement for output steps of length `output`. By default, HMAX is the output step, HINIT is
    /// HMAX/20 and HMIN is 1e-6 HMAX.
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
