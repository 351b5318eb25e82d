use admire_solver::mechanics::Vec6;

/// Motion and load of a wheel per unit of the driven variable.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct WheelRate {
    /// Translation of the wheel centre and rotation of the carrier, per unit of the variable.
    pub motion: Vec6,
    /// Vertical load per unit of the variable.
    pub load: f64,
}

impl WheelRate {
    /// Returns the mean of the rates; `None` if the slice is empty.
    pub(super) fn mean(all: &[Self]) -> Option<Self> {
        let share = 1.0 / all.len() as f64;
        (!all.is_empty()).then(|| Self {
            motion: all.iter().map(|rate| rate.motion).sum::<Vec6>() * share,
            load: all.iter().map(|rate| rate.load).sum::<f64>() * share,
        })
    }

    pub(super) fn mirrored(self) -> Self {
        let m = &self.motion;
        Self {
            motion: Vec6::new(m[0], -m[1], m[2], -m[3], m[4], -m[5]),
            load: self.load,
        }
    }
}
