use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;

use super::Program;
use super::build::Build;
use super::curves::{CurveForm, Curves};
use crate::model::{ArrayKind, Model, Spline, VectorForceKind};
use admire_syntax::Expression;
use admire_syntax::diagnostic::Diagnostic;

/// Compiler of expressions for the objects of one model. It indexes ids for fast lookup and prepares each spline only once.
#[derive(Debug)]
pub struct ExpressionCompiler<'m> {
    pub(super) model: &'m Model,
    ids: [OnceCell<BTreeMap<u32, usize>>; Space::COUNT],
    pair_forces: OnceCell<BTreeMap<(&'static str, u32), usize>>,
    curves: RefCell<Curves>,
}

/// Group of model objects whose ids are unique within the group.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Space {
    Marker,
    Variable,
    Diff,
    Array,
    PlantInput,
    PlantOutput,
    Sensor,
    Spline,
    Bushing,
    SpringDamper,
    Sforce,
    Gforce,
    Vforce,
    Vtorque,
    Nforce,
    Joint,
    Primitive,
    Motion,
    Friction,
}

impl Space {
    const COUNT: usize = Self::Friction as usize + 1;

    pub(super) fn keyword(self) -> &'static str {
        match self {
            Self::Marker => "MARKER",
            Self::Variable => "VARIABLE",
            Self::Diff => "DIFF",
            Self::Array => "ARRAY",
            Self::PlantInput => "PINPUT",
            Self::PlantOutput => "POUTPUT",
            Self::Sensor => "SENSOR",
            Self::Spline => "SPLINE",
            Self::Bushing => "BUSHING",
            Self::SpringDamper => "SPRINGDAMPER",
            Self::Sforce => "SFORCE",
            Self::Gforce => "GFORCE",
            Self::Vforce => "VFORCE",
            Self::Vtorque => "VTORQUE",
            Self::Nforce => "NFORCE",
            Self::Joint => "JOINT",
            Self::Primitive => "JPRIM",
            Self::Motion => "MOTION",
            Self::Friction => "FRICTION",
        }
    }

    fn index(self, model: &Model) -> BTreeMap<u32, usize> {
        macro_rules! ids {
            ($list:ident) => {
                model
                    .$list
                    .iter()
                    .enumerate()
                    .map(|(index, object)| (object.header.id, index))
                    .collect()
            };
        }
        let vector = |kind: VectorForceKind| {
            model
                .vector_forces
                .iter()
                .enumerate()
                .filter(|(_, force)| force.kind == kind)
                .map(|(index, force)| (force.header.id, index))
                .collect()
        };
        let plant = |kind: &str| {
            model
                .plant_ports
                .iter()
                .enumerate()
                .filter(|(_, list)| list.kind == kind)
                .map(|(index, list)| (list.header.id, index))
                .collect()
        };
        match self {
            Self::Marker => ids!(markers),
            Self::Variable => ids!(variables),
            Self::Diff => ids!(diffs),
            Self::Array => ids!(arrays),
            Self::PlantInput => plant("PINPUT"),
            Self::PlantOutput => plant("POUTPUT"),
            Self::Sensor => ids!(sensors),
            Self::Spline => ids!(splines),
            Self::Bushing => ids!(bushings),
            Self::SpringDamper => ids!(springdampers),
            Self::Sforce => ids!(sforces),
            Self::Gforce => vector(VectorForceKind::Gforce),
            Self::Vforce => vector(VectorForceKind::Vforce),
            Self::Vtorque => vector(VectorForceKind::Vtorque),
            Self::Nforce => ids!(nforces),
            Self::Joint => ids!(joints),
            Self::Primitive => ids!(primitives),
            Self::Motion => ids!(motions),
            Self::Friction => ids!(frictions),
        }
    }
}

impl<'m> ExpressionCompiler<'m> {
    /// Creates a compiler for the objects of `model`.
    pub fn new(model: &'m Model) -> Self {
        Self {
            model,
            ids: std::array::from_fn(|_| OnceCell::new()),
            pair_forces: OnceCell::new(),
            curves: RefCell::default(),
        }
    }

    /// Compiles one expression.
    ///
    /// # Errors
    /// Returns a diagnostic without a source position in three cases: the model does not define an id, an argument is not an id or a code
    /// as required, or only real ADAMS evaluates a function.
    pub fn compile(&self, expression: &Expression) -> Result<Program, Diagnostic> {
        Build::new(self, expression).whole()
    }

    pub(super) fn find(&self, space: Space, id: u32) -> Option<usize> {
        self.ids[space as usize]
            .get_or_init(|| space.index(self.model))
            .get(&id)
            .copied()
    }

    /// Returns the index of a pair force in the model, given its statement and id.
    pub(super) fn find_pair_force(&self, kind: &str, id: u32) -> Option<usize> {
        let all = || self.model.pair_forces.iter().enumerate();
        self.pair_forces
            .get_or_init(|| {
                all()
                    .map(|(at, force)| ((force.def.name, force.header.id), at))
                    .collect()
            })
            .get(&(kind, id))
            .copied()
    }

    /// Returns the numbers of an ARRAY, or `None` if there are none.
    pub(crate) fn numbers(&self, array: u32) -> Option<&'m [f64]> {
        match &self.model.arrays[self.find(Space::Array, array)?].kind {
            ArrayKind::Numbers(numbers) => Some(numbers),
            _ => None,
        }
    }

    /// Returns a SPLINE of the model.
    pub(crate) fn spline(&self, id: u32) -> Option<&'m Spline> {
        Some(&self.model.splines[self.find(Space::Spline, id)?])
    }

    /// Returns the index in [`Self::curves`] of a SPLINE in the given form. Returns `None` if its data define no curve.
    pub(super) fn curve(&self, spline: usize, form: CurveForm) -> Option<usize> {
        let mut curves = self.curves.borrow_mut();
        curves.enter((spline, &self.model.splines[spline]), form)
    }

    /// Returns the index in [`Self::curves`] of a SPLINE that a bushing of Adams/Car reads. Returns `None` if there is no such curve.
    pub(crate) fn bushing_curve(&self, id: u32) -> Option<usize> {
        self.curve(self.find(Space::Spline, id)?, CurveForm::AkimaLine)
    }

    /// Returns the curves of the SPLINEs that the compiled expressions read, with the y values of the model.
    pub fn curves(&self) -> Curves {
        self.curves.borrow().clone()
    }
}
