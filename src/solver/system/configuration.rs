use super::chain::BodyColumns;
use super::contribution::{WrenchEnds, halves};
use super::{NoValue, Parameters, Scratch, State, System};
use crate::function::MovingFrame;
use crate::mechanics::{Mat3, Pose, RelativeMotion, Vec3, Vec6};
use crate::model::PartIx;

/// View of a system with its parameters in one state, and the working memory for evaluations in this state.
///
/// [`System::evaluate`] returns an evaluated configuration, ready to be read. [`System::at`] returns a configuration whose memory still
/// holds the results of an earlier evaluation.
#[derive(Debug)]
pub struct Configuration<'a> {
    pub(crate) system: &'a System,
    pub(crate) parameters: &'a Parameters,
    pub(crate) state: &'a State,
    pub(crate) scratch: &'a mut Scratch,
}

impl System {
    /// Returns a configuration without evaluating it. `scratch` still holds the results of the last call of [`Configuration::evaluate`].
    pub fn at<'a>(
        &'a self,
        parameters: &'a Parameters,
        state: &'a State,
        scratch: &'a mut Scratch,
    ) -> Configuration<'a> {
        Configuration {
            system: self,
            parameters,
            state,
            scratch,
        }
    }

    /// Returns a configuration with marker poses and function values evaluated, ready to be read.
    ///
    /// # Errors
    /// Returns [`NoValue`] if a function, or an element that a function measures, is undefined in this configuration.
    pub fn evaluate<'a>(
        &'a self,
        parameters: &'a Parameters,
        state: &'a State,
        scratch: &'a mut Scratch,
    ) -> Result<Configuration<'a>, NoValue> {
        let mut here = self.at(parameters, state, scratch);
        here.evaluate()?;
        Ok(here)
    }

    /// Returns an evaluated configuration in which functions may be undefined. For example, functions of reactions are undefined before the
    /// reactions are known. Undefined functions count as zero with zero slope; the number of undefined functions is also returned.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element that a function measures is undefined in this configuration.
    pub fn evaluate_leniently<'a>(
        &'a self,
        parameters: &'a Parameters,
        state: &'a State,
        scratch: &'a mut Scratch,
    ) -> Result<(Configuration<'a>, usize), NoValue> {
        scratch.lacking = Some(0);
        let mut here = self.at(parameters, state, scratch);
        let done = here.evaluate();
        let lacking = here.scratch.lacking.take().unwrap_or(0);
        done?;
        Ok((here, lacking))
    }

    pub(crate) fn place(&self, part: usize) -> BodyColumns {
        BodyColumns {
            first: self.bodies[part].first,
            freedoms: self.bodies[part].freedoms,
        }
    }

    /// Returns gravity divided by the units consistency factor: the weight per unit mass.
    pub(crate) fn gravity_vector(&self, theta: &[f64]) -> Vec3 {
        Vec3::from_column_slice(&theta[self.gravity..self.gravity + 3]) / self.ucf
    }
}

impl Configuration<'_> {
    /// Evaluates the marker poses and all functions that the equations need.
    ///
    /// # Errors
    /// Returns [`NoValue`] if a function, or an element that a function measures, is undefined in this configuration.
    pub fn evaluate(&mut self) -> Result<(), NoValue> {
        self.place_markers();
        self.drive()?;
        self.evaluate_functions(&self.system.order)
    }

    /// Evaluates only the marker poses and the functions that MOTIONs and GCONs need. All other functions may be undefined.
    ///
    /// # Errors
    /// Returns [`NoValue`] if a function of a MOTION or GCON is undefined in this configuration.
    pub(crate) fn evaluate_constraints(&mut self) -> Result<(), NoValue> {
        self.place_markers();
        self.drive()?;
        self.evaluate_functions(&self.system.order_of_constraints)
    }

    /// Returns the pose of a marker in ground.
    pub fn marker(&self, marker: crate::model::MarkerIx) -> &Pose {
        &self.scratch.markers[marker.0]
    }

    /// Computes the poses of the used markers in ground, and the arms from the reference points of the parts to the markers.
    pub(crate) fn place_markers(&mut self) {
        for &marker in &self.system.used {
            self.place_marker(marker);
        }
        for (&floating, &at) in &self.system.floating {
            let pose = self.scratch.markers[at];
            let part = self.system.owners[floating];
            self.scratch.arms[floating] = pose.p - self.state.poses[part].p;
            self.scratch.markers[floating] = pose;
        }
    }

    pub(crate) fn place_marker(&mut self, marker: usize) {
        let owner = self.system.owners[marker];
        let part = &self.state.poses[owner];
        let local = &self.parameters.markers()[marker];
        let reference = self.system.local_reference(self.state, owner);
        self.scratch.arms[marker] = part.R * (local.p - reference);
        self.scratch.markers[marker] = Pose {
            p: part.p + part.R * local.p,
            R: part.R * local.R,
        };
    }

    /// Returns whether the state has velocities and accelerations (motion, not statics).
    pub(crate) fn moving(&self) -> bool {
        self.state.moves()
    }

    /// Returns the frame of a marker with its velocity and acceleration, which are zero in statics. `None` stands for ground.
    pub(crate) fn moving_frame(&self, marker: Option<usize>) -> MovingFrame {
        let Some(marker) = marker else {
            return MovingFrame::ground();
        };
        let marker = self.system.floating.get(&marker).copied().unwrap_or(marker);
        let pose = self.scratch.markers[marker];
        let mut frame = MovingFrame {
            pose,
            ..MovingFrame::ground()
        };
        let part = self.system.owners[marker];
        if self.moving() && self.system.bodies[part].freedoms > 0 {
            let r = self.scratch.arms[marker];
            let (velocity, acceleration) = (
                &self.state.velocities[part],
                &self.state.accelerations[part],
            );
            let (w, b) = (velocity.angular, acceleration.angular);
            frame.v = velocity.linear + w.cross(&r);
            frame.w = w;
            frame.a = acceleration.linear + b.cross(&r) + w.cross(&w.cross(&r));
            frame.b = b;
        }
        frame
    }

    /// Returns the velocity of I relative to J: the rates of `p_ij_j` and of the rotation in J axes, `R_j'(v_i - v_j - w_j x d)` and
    /// `R_j'(w_i - w_j)`.
    pub(crate) fn relative_rates(&self, i: usize, j: usize) -> Vec6 {
        let (i, j) = (self.moving_frame(Some(i)), self.moving_frame(Some(j)));
        let R = j.pose.R.transpose();
        let d = i.pose.p - j.pose.p;
        let u = R * (i.v - j.v - j.w.cross(&d));
        let t = R * (i.w - j.w);
        Vec6::new(u.x, u.y, u.z, t.x, t.y, t.z)
    }

    /// Returns the vector from the reference point of a part to the origin of a marker, which may be on another part.
    pub(crate) fn arm_to(&self, marker: usize, part: usize) -> Vec3 {
        if self.system.owners[marker] == part {
            self.scratch.arms[marker]
        } else {
            self.scratch.markers[marker].p - self.system.reference_point(self.state, PartIx(part))
        }
    }

    /// Returns the motion of I relative to J. The angles are computed only if `angles` is set.
    pub(crate) fn motion(&self, i: usize, j: usize, pair: usize, angles: bool) -> RelativeMotion {
        let (i, j) = (&self.scratch.markers[i], &self.scratch.markers[j]);
        if angles {
            return RelativeMotion::between(i, j, &self.state.pair_angles[pair]);
        }
        let R_jg = j.R.transpose();
        RelativeMotion {
            p_ij_j: R_jg * (i.p - j.p),
            R_ji: R_jg * i.R,
            angles: Vec3::zeros(),
        }
    }

    /// Initialises `scratch.contribution` with the wrench `w`, given in the axes of the frame, without derivatives.
    pub(super) fn init_contribution(&mut self, ends: WrenchEnds, w: Vec6) {
        let system = self.system;
        let a = (
            system.place(system.owners[ends.i]),
            self.scratch.arms[ends.i],
        );
        let b = ends
            .reaction
            .map(|b| (system.place(b), self.arm_to(ends.i, b)));
        let c = ends.frame.map(|frame| {
            let c = system.owners[frame];
            (system.place(c), self.arm_to(ends.i, c))
        });
        let R = ends
            .frame
            .map_or_else(Mat3::identity, |m| self.scratch.markers[m].R);
        let out = &mut self.scratch.contribution;
        (out.i, out.j, out.pair, out.frame) = (ends.i, ends.j, ends.pair, ends.frame);
        (out.a, out.b, out.c) = (a, b, c);
        out.R = R;
        out.w = w;
        (out.F, out.T) = halves(&R, &w);
        out.D = None;
        out.rate = None;
        out.cross.clear();
        out.scalars.clear();
    }
}
