/// Loads and heights that the rig imposes on the axle, in the axes of Adams/Car.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Inputs {
    /// Heights of the wheel centres above their design position, where heights are held.
    pub height: [f64; 2],
    /// Force rearward, force to the right, vertical force and torque about Z on each wheel. The first two lie in the road plane and follow
    /// the heading of the wheel; the vertical force is used where loads are held.
    pub loads: [[f64; 4]; 2],
    /// True if the vertical load acts at the contact patch, otherwise at the wheel centre.
    pub vertical_at_patch: bool,
    /// True if the loads in the road plane act at the contact patch.
    pub plane_at_patch: bool,
    /// Steering input, where the steering is driven.
    pub steer: Option<f64>,
}

impl Inputs {
    /// Returns the inputs of the mirrored axle, in which left and right are exchanged.
    pub(super) fn mirrored(&self) -> Self {
        let swap = |[a, b]: [f64; 2]| [b, a];
        let [l, r] = self.loads;
        let turned = |[x, y, z, m]: [f64; 4]| [x, -y, z, -m];
        Self {
            height: swap(self.height),
            loads: [turned(r), turned(l)],
            steer: self.steer.map(|value| -value),
            ..*self
        }
    }
}

/// Direction of a test: change of the inputs per unit of the test's variable.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Drive {
    /// Change of the heights per unit of the variable.
    pub height: [f64; 2],
    /// Change of the loads per unit of the variable.
    pub loads: [[f64; 4]; 2],
    /// Change of the steering input per unit of the variable.
    pub steer: f64,
}

impl Drive {
    pub(super) fn mirrored(&self) -> Self {
        let inputs = Inputs {
            height: self.height,
            loads: self.loads,
            steer: Some(self.steer),
            ..Inputs::default()
        };
        let inputs = inputs.mirrored();
        Self {
            height: inputs.height,
            loads: inputs.loads,
            steer: inputs.steer.unwrap_or(0.0),
        }
    }
}
