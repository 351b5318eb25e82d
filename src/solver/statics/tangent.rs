use super::SolveError;
use super::minimum_norm::FreeMotionSpace;
use super::rank::{UNDETERMINED, motion_of};
use crate::linear::{Lu, Matrix};
use crate::mechanics::{Vec3, Vec6};
use crate::model::{MarkerIx, PartIx};
use crate::system::{Parameters, Scratch, Slot, State, System};

/// Rotations below this in radians, and shifts below this of the size of the model, are round-off of a motion as large as that.
const ROUND_OFF: f64 = 1e-9;
/// A motion whose rotations are below this share of it shifts only.
const ONLY_SHIFTS: f64 = 1e-6;

/// The linearised equations at an equilibrium, factored: `J dx = -dg`.
///
/// Vectors of unknowns are laid out as [`System`] says; a part's share is at [`System::part_unknowns`].
#[derive(Clone, Debug)]
pub struct Tangent {
    factors: Lu,
    free_space: FreeMotionSpace,
    scratch: Scratch,
    residual: Vec<f64>,
}

impl Tangent {
    /// At an equilibrium. Those who have just solved take [`Solver::tangent`](super::Solver::tangent), which is cheaper.
    ///
    /// # Errors
    /// [`SolveError::NoValue`] if an element has no value there.
    pub fn new(
        system: &System,
        parameters: &Parameters,
        state: &State,
    ) -> Result<Self, SolveError> {
        let n = system.unknowns();
        let mut new = Self::with(system, Lu::new(n));
        new.linearise(system, parameters, state, &mut Matrix::new(n))?;
        Ok(new)
    }

    /// Memory for a system, with factors that may know the order of elimination already.
    pub(super) fn with(system: &System, factors: Lu) -> Self {
        Self {
            factors,
            free_space: FreeMotionSpace::default(),
            scratch: Scratch::new(system),
            residual: vec![0.0; system.unknowns()],
        }
    }

    /// Linearises the equations anew, at this state. The matrix is memory; it may know the pattern.
    ///
    /// # Errors
    /// [`SolveError::NoValue`] if an element has no value there.
    pub(super) fn linearise(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
        matrix: &mut Matrix,
    ) -> Result<(), SolveError> {
        matrix.clear();
        let (scratch, g) = (&mut self.scratch, &mut self.residual);
        system.assemble(parameters, state, scratch, g, matrix)?;
        matrix.finish();
        self.factors.factor(matrix);
        self.free_space = FreeMotionSpace::of(system, &self.factors);
        Ok(())
    }

    /// How many motions nothing resists; they are held where they are.
    pub fn deficiency(&self) -> usize {
        self.factors.deficiency()
    }

    /// The motions that nothing resists: changes of the unknowns of parts, reactions left out. The largest rotation of a part is one radian; in
    /// one that only shifts, the largest shift is the size of the model.
    pub fn free_motions(&self, system: &System) -> Vec<Vec<f64>> {
        let each = (0..self.deficiency()).map(|m| self.factors.null_vector(m));
        each.filter_map(|z| motion_of_parts(system, z)).collect()
    }

    /// The change of the unknowns under a change `dg` of the residual, of minimum norm where there are free motions: replaces `dg` by `-J^-1 dg`.
    pub fn respond(&mut self, dg: &mut [f64]) {
        for value in dg.iter_mut() {
            *value = -*value;
        }
        self.factors.solve(dg);
        self.free_space.take_off(dg);
    }

    /// The same for many changes that follow one another.
    pub fn respond_to_all(&self, changes: &mut [f64]) {
        for value in changes.iter_mut() {
            *value = -*value;
        }
        self.factors.solve_many(changes);
        for change in changes.chunks_mut(self.residual.len()) {
            self.free_space.take_off(change);
        }
    }

    /// Replaces the weights w of the unknowns by `a = -J^-T w`: then `d(w . x) = a . dg` for every change of the residual.
    pub(crate) fn adjoint(&mut self, weights: &mut [f64]) {
        self.free_space.ignore(weights);
        for value in weights.iter_mut() {
            *value = -*value;
        }
        self.factors.solve_transposed(weights);
    }

    /// The change of the unknowns per unit of a number of theta.
    ///
    /// # Errors
    /// [`SolveError::NoValue`] if an element has no value there.
    pub fn by_slot(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
        slot: Slot,
    ) -> Result<Vec<f64>, SolveError> {
        let mut dg = vec![0.0; system.unknowns()];
        system.residual_by_slot(parameters, state, &mut self.scratch, slot, &mut dg)?;
        self.respond(&mut dg);
        Ok(dg)
    }

    /// The change of the unknowns under a wrench on marker I in J axes, with its opposite at the same point of the part of J.
    pub fn by_wrench(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
        (i, j): (MarkerIx, MarkerIx),
        wrench_j: &Vec6,
    ) -> Vec<f64> {
        let mut dg =
            system.unit_wrench_column(parameters, state, &mut self.scratch, (i, j), wrench_j);
        self.respond(&mut dg);
        dg
    }
}

/// A null vector without its reactions, in the unit of [`Tangent::free_motions`]; `None` if no part moves in it.
fn motion_of_parts(system: &System, mut z: Vec<f64>) -> Option<Vec<f64>> {
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let reactions = largest(&z[system.first_equation..]);
    z[system.first_equation..].fill(0.0);
    let (mut shift, mut turn) = (0.0_f64, 0.0_f64);
    for part in 0..system.bodies.len() {
        let (v, w) = motion_of(system, part, &z);
        shift = shift.max(v.norm());
        turn = turn.max(w.norm());
    }
    let size = shift.max(turn * system.length);
    if size == 0.0 || size < UNDETERMINED * reactions {
        return None;
    }
    let unit = if turn * system.length > ONLY_SHIFTS * size {
        turn
    } else {
        shift / system.length
    };
    for x in &mut z {
        *x /= unit;
    }
    for body in &system.bodies {
        for first in (0..body.freedoms).step_by(3) {
            let own = &mut z[body.first + first..body.first + first + 3];
            let scale = if first == 0 { system.length } else { 1.0 };
            if largest(own) < ROUND_OFF * scale {
                own.fill(0.0);
            }
        }
    }
    Some(z)
}

/// Velocity of the origin and angular velocity of a part in a free motion, ground axes.
pub fn twist(system: &System, state: &State, part: PartIx, motion: &[f64]) -> (Vec3, Vec3) {
    let [x, y, z, rx, ry, rz] = system.pose_change(state, part, motion);
    let (v, w) = (Vec3::new(x, y, z), Vec3::new(rx, ry, rz));
    // An origin on the axis of a rotation stays.
    let stays = v.amax() < ROUND_OFF * system.length;
    (if stays { Vec3::zeros() } else { v }, w)
}

/// Moves the parts of a state along a free motion, each steadily along its own screw, by `amount` of it.
pub fn displace(system: &System, state: &mut State, motion: &[f64], amount: f64) {
    for part in 0..system.bodies.len() {
        let (v, w) = twist(system, state, PartIx(part), motion);
        let pose = &mut state.poses[part];
        *pose = pose.displaced(&(amount * v), &(amount * w));
    }
}

/// The change of a point of a part under a change of the unknowns, ground axes. `local` in part axes.
pub fn point_change(
    system: &System,
    state: &State,
    part: PartIx,
    local: &Vec3,
    dx: &[f64],
) -> Vec3 {
    let [x, y, z, rx, ry, rz] = system.pose_change(state, part, dx);
    Vec3::new(x, y, z) + Vec3::new(rx, ry, rz).cross(&(state.poses[part.0].R * local))
}

/// Tangents at one state after another. The order of elimination is that of the first one, as long as its pivots serve.
#[derive(Clone, Debug)]
pub struct Tangents {
    tangent: Tangent,
    matrix: Matrix,
}

impl Tangents {
    /// Memory for a system.
    pub fn new(system: &System) -> Self {
        let n = system.unknowns();
        Self {
            tangent: Tangent::with(system, Lu::new(n)),
            matrix: Matrix::new(n),
        }
    }

    /// At this state.
    ///
    /// # Errors
    /// [`SolveError::NoValue`] if an element has no value there.
    pub fn at(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
    ) -> Result<&mut Tangent, SolveError> {
        self.tangent
            .linearise(system, parameters, state, &mut self.matrix)?;
        Ok(&mut self.tangent)
    }
}
