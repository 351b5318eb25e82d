use super::SolveError;
use crate::linear::{Lu, Matrix};
use crate::mechanics::{Vec3, Vec6};
use crate::model::{MarkerIx, PartIx};
use crate::system::{Parameters, Scratch, Slot, State, System};

/// The linearised equations at an equilibrium, factored: `J dx = -dg`.
///
/// Vectors of unknowns are laid out as [`System`] says; a part's share is at [`System::part_unknowns`].
#[derive(Clone, Debug)]
pub struct Tangent {
    factors: Lu,
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
        Ok(())
    }

    /// How many motions nothing resists; they are held where they are.
    pub fn deficiency(&self) -> usize {
        self.factors.deficiency()
    }

    /// The change of the unknowns under a change `dg` of the residual: replaces `dg` by `-J^-1 dg`.
    pub fn respond(&mut self, dg: &mut [f64]) {
        for value in dg.iter_mut() {
            *value = -*value;
        }
        self.factors.solve(dg);
    }

    /// The same for many changes that follow one another.
    pub(crate) fn respond_to_all(&self, changes: &mut [f64]) {
        for value in changes.iter_mut() {
            *value = -*value;
        }
        self.factors.solve_many(changes);
    }

    /// Replaces the weights w of the unknowns by `a = -J^-T w`: then `d(w . x) = a . dg` for every change of the residual.
    pub(crate) fn adjoint(&mut self, weights: &mut [f64]) {
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
    pub(crate) fn by_wrench(
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

/// The change of a point of a part under a change of the unknowns, ground axes. `local` in part axes.
pub(crate) fn point_change(
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
pub(crate) struct Tangents {
    tangent: Tangent,
    matrix: Matrix,
}

impl Tangents {
    /// Memory for a system.
    pub(crate) fn new(system: &System) -> Self {
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
    pub(crate) fn at(
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
