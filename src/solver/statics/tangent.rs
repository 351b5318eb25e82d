use super::SolveError;
use super::minimum_norm::FreeMotionSpace;
use super::rank::{UNDETERMINED, motion_of};
use crate::linear::{Lu, Matrix};
use crate::mechanics::{Vec3, Vec6};
use crate::model::{MarkerIx, PartIx};
use crate::system::{Parameters, Scratch, Slot, State, System};

/// In a free motion of unit size, rotations below this (in radians) and translations below this share of the model's length are round-off.
const ROUND_OFF: f64 = 1e-9;
/// If the rotations in a motion are below this share of the motion, they are neglected, and the motion counts as a pure translation.
const ONLY_SHIFTS: f64 = 1e-6;

/// Equations linearised at an equilibrium, with their factors: `J dx = -dg`.
///
/// Vectors of unknowns are laid out as described at [`System`]; the unknowns of a part are at [`System::part_unknowns`].
#[derive(Clone, Debug)]
pub struct Tangent {
    factors: Lu,
    free_space: FreeMotionSpace,
    scratch: Scratch,
    residual: Vec<f64>,
}

impl Tangent {
    /// Linearises the equations at an equilibrium. Directly after a solution, [`Solver::tangent`](super::Solver::tangent) is cheaper.
    ///
    /// # Errors
    /// Returns [`SolveError::NoValue`] if an element has no value in this state.
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

    /// Allocates the work space for a system. The factors may already contain an elimination order.
    pub(super) fn with(system: &System, factors: Lu) -> Self {
        Self {
            factors,
            free_space: FreeMotionSpace::default(),
            scratch: Scratch::new(system),
            residual: vec![0.0; system.unknowns()],
        }
    }

    /// Linearises the equations at a state. `matrix` is work space, which may already contain the pattern.
    ///
    /// # Errors
    /// Returns [`SolveError::NoValue`] if an element has no value in this state.
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

    /// Returns the number of motions without stiffness, which is the rank deficiency of the Jacobian.
    pub fn deficiency(&self) -> usize {
        self.factors.deficiency()
    }

    /// Returns the motions without stiffness, as changes of the part unknowns; the entries of reactions are zero. Each motion is scaled so that
    /// the largest rotation of a part is one radian. A pure translation is scaled so that the largest displacement is the model's length.
    pub fn free_motions(&self, system: &System) -> Vec<Vec<f64>> {
        let each = (0..self.deficiency()).map(|m| self.factors.null_vector(m));
        each.filter_map(|z| motion_of_parts(system, z)).collect()
    }

    /// Replaces a change `dg` of the residual by the change of the unknowns that it causes: `-J^-1 dg`, of minimum norm if there are free
    /// motions.
    pub fn respond(&mut self, dg: &mut [f64]) {
        for value in dg.iter_mut() {
            *value = -*value;
        }
        self.factors.solve(dg);
        self.free_space.project(dg);
    }

    /// Does the same as [`respond`](Self::respond) for many changes of the residual, which are stored one after another.
    pub fn respond_to_all(&self, changes: &mut [f64]) {
        for value in changes.iter_mut() {
            *value = -*value;
        }
        self.factors.solve_many(changes);
        for change in changes.chunks_mut(self.residual.len()) {
            self.free_space.project(change);
        }
    }

    /// Replaces weights w of the unknowns by `a = -J^-T w`. Then `d(w . x) = a . dg` for every change of the residual.
    pub(crate) fn adjoint(&mut self, weights: &mut [f64]) {
        self.free_space.project_transposed(weights);
        for value in weights.iter_mut() {
            *value = -*value;
        }
        self.factors.solve_transposed(weights);
    }

    /// Returns the derivatives of the unknowns with respect to one parameter of the model.
    ///
    /// # Errors
    /// Returns [`SolveError::NoValue`] if an element has no value in this state.
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

    /// Returns the change of the unknowns caused by a wrench on marker I, in J axes. The opposite wrench acts at the same point on the part of
    /// J.
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

/// Returns a null vector without its reactions, scaled as in [`Tangent::free_motions`]; `None` if no part moves in it.
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

/// Returns the velocity of the origin of a part and the angular velocity of the part in a free motion, in ground axes.
pub fn twist(system: &System, state: &State, part: PartIx, motion: &[f64]) -> (Vec3, Vec3) {
    let [x, y, z, rx, ry, rz] = system.pose_change(state, part, motion);
    let (v, w) = (Vec3::new(x, y, z), Vec3::new(rx, ry, rz));
    // The origin lies on the axis of rotation and does not move.
    let stays = v.amax() < ROUND_OFF * system.length;
    (if stays { Vec3::zeros() } else { v }, w)
}

/// Displaces the parts of a state by `amount` times a free motion. Each part moves in a steady screw motion of its own.
pub fn displace(system: &System, state: &mut State, motion: &[f64], amount: f64) {
    for part in 0..system.bodies.len() {
        let (v, w) = twist(system, state, PartIx(part), motion);
        let pose = &mut state.poses[part];
        *pose = pose.displaced(&(amount * v), &(amount * w));
    }
}

/// Returns the displacement of a point of a part caused by a change `dx` of the unknowns, in ground axes. `local` is the point in part axes.
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

/// Tangents at successive states. The elimination order of the first tangent is reused as long as its pivots are acceptable.
#[derive(Clone, Debug)]
pub struct Tangents {
    tangent: Tangent,
    matrix: Matrix,
}

impl Tangents {
    /// Allocates the work space for a system.
    pub fn new(system: &System) -> Self {
        let n = system.unknowns();
        Self {
            tangent: Tangent::with(system, Lu::new(n)),
            matrix: Matrix::new(n),
        }
    }

    /// Linearises the equations at a state and returns the tangent.
    ///
    /// # Errors
    /// Returns [`SolveError::NoValue`] if an element has no value in this state.
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
