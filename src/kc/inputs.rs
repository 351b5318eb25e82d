/// What the rig does to the axle, in the axes of Adams/Car.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Inputs {
    /// Heights of the wheel centres over their design position, where heights are held.
    pub height: [f64; 2],
    /// Forces along X, Y, Z and torque about Z on each wheel; the vertical one where loads are held.
    pub loads: [[f64; 4]; 2],
    /// The vertical load acts at the contact patch.
    pub vertical_at_patch: bool,
    /// The loads in the road plane do.
    pub plane_at_patch: bool,
    /// The steering input, where it is driven.
    pub steer: Option<f64>,
}

impl Inputs {
    /// What the other wheel of a mirrored axle sees.
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

/// What a test drives: the same, as a direction.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Drive {
    /// Per unit of the variable.
    pub height: [f64; 2],
    /// Per unit of the variable.
    pub loads: [[f64; 4]; 2],
    /// Per unit of the variable.
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
