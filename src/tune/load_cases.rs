//! Equilibria of the deck in load cases of the study, with their derivatives.

use crate::answers::CaseAnswer;
use crate::settings::FREE_CHANGE;
use admire_kc::{BenchError, DeckChange, Probed};
use admire_session::backend::{
    BackendError, CaseSweeper, LoadProgramme, Loads, compile, slot, tight_settings,
};
use admire_solver::mechanics::Vec3;
use admire_solver::model::{MarkerIx, Model};
use admire_solver::statics::{Direction, Probe, Probes, SolveError, Tangent};
use admire_solver::system::{Parameters, Scratch, State, System};
use admire_syntax::Address;
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Load cases that goals name, with the probes that are read there.
#[derive(Clone, Debug, Default)]
pub(crate) struct LoadCases {
    /// Loads and load cases that goals name, in the order of the study.
    pub programme: LoadProgramme,
    /// Probes that are read in each load case.
    pub probes: Vec<Probe>,
}

/// Derivatives and marker rotations that a solution of the load cases must include.
pub(crate) struct Asked<'a> {
    /// Changes along which the equilibria are differentiated.
    pub directions: &'a [DeckChange],
    /// Markers that are rotated on their parts. Each rotation vector is in radians and in the axes of the marker.
    pub turned: &'a [(MarkerIx, Vec3)],
}

/// Deck compiled with its probes and loads.
struct CompiledCases {
    system: System,
    probes: Probes,
    loads: Loads,
}

impl CompiledCases {
    fn new(cases: &LoadCases, model: &Model) -> Result<Self, BackendError> {
        let mut model = model.clone();
        let requests = model.requests.len();
        Probes::extend(&mut model, &cases.probes)
            .map_err(|wrong| BackendError::NotSolvable(vec![wrong]))?;
        let system = compile(&model)?;
        Ok(Self {
            probes: Probes::new(&cases.probes, &system, requests),
            loads: Loads::of(&system, &cases.programme)?,
            system,
        })
    }

    /// Returns a change of the deck as a direction of the compiled system. Numbers that the loads set are left out.
    fn direction(&self, change: &DeckChange) -> Direction {
        let mut direction = change.direction(&self.system);
        direction
            .slots
            .retain(|(slot, _)| !self.loads.slots.contains(slot));
        direction
    }

    /// Solves the load cases in order. `visit` receives the index of each case and its equilibrium.
    fn solve(
        &self,
        cases: &LoadCases,
        turned: &[(MarkerIx, Vec3)],
        visit: &mut dyn FnMut(usize, &Solved<'_>) -> Result<(), SolveError>,
    ) -> Result<(), BenchError> {
        let system = &self.system;
        let mut sweeper = CaseSweeper::new(system, self.loads.clone(), tight_settings(system));
        let mut parameters = system.parameters();
        for (marker, turn) in turned {
            parameters.turn(*marker, turn, 1.0);
        }
        for (case, own) in cases.programme.cases.iter().enumerate() {
            sweeper.load(case, &mut parameters);
            let solved = sweeper
                .solve(system, &parameters, case, None)
                .and_then(|state| {
                    visit(
                        case,
                        &Solved {
                            system,
                            parameters: &parameters,
                            state: &state,
                        },
                    )?;
                    Ok(state)
                });
            let state = solved.map_err(|why| BenchError::NoEquilibrium {
                at: format!("load case {}", own.label),
                why: Box::new(why),
            })?;
            sweeper.keep(case, state);
        }
        Ok(())
    }
}

/// Equilibrium of one load case.
struct Solved<'a> {
    system: &'a System,
    parameters: &'a Parameters,
    state: &'a State,
}

impl<'a> Solved<'a> {
    fn here(&self) -> (&'a System, &'a Parameters, &'a State) {
        (self.system, self.parameters, self.state)
    }
}

impl LoadCases {
    /// Returns the numbers with respect to which the solver can differentiate the equilibria.
    ///
    /// # Errors
    /// [`BenchError::Deck`] if the deck cannot be solved.
    pub(crate) fn differentiable(&self, model: &Model) -> Result<Differentiable, BenchError> {
        if self.programme.cases.is_empty() {
            return Ok(Differentiable(None));
        }
        let compiled = CompiledCases::new(self, model).map_err(refused)?;
        Ok(Differentiable(Some(compiled.system)))
    }

    /// Solves the load cases on a deck and reads the probes.
    ///
    /// # Errors
    /// [`BenchError`] with the load case that has no equilibrium, or with the errors of the deck.
    pub(crate) fn solve(
        &self,
        model: &Model,
        asked: &Asked<'_>,
    ) -> Result<Vec<CaseAnswer>, BenchError> {
        if self.programme.cases.is_empty() {
            return Ok(Vec::new());
        }
        let compiled = CompiledCases::new(self, model).map_err(refused)?;
        let each = asked.directions.iter();
        let directions: Vec<Direction> = each.map(|own| compiled.direction(own)).collect();
        let mut scratch = Scratch::new(&compiled.system);
        let mut found = Vec::with_capacity(self.programme.cases.len());
        compiled.solve(self, asked.turned, &mut |case, solved| {
            let here = solved.here();
            let mut probed = Probed {
                values: compiled.probes.values(here, &mut scratch)?,
                changes: Vec::new(),
            };
            if !directions.is_empty() {
                let mut tangent = Tangent::new(here.0, here.1, here.2)?;
                let dx = tangent.along(here, &mut scratch, &directions)?;
                let each = dx.chunks(here.0.unknowns().max(1)).zip(&directions);
                for (dx, direction) in each {
                    let changes = compiled.probes.changes(here, &mut scratch, dx, direction)?;
                    probed.changes.push(changes);
                }
            }
            found.push(CaseAnswer {
                label: self.programme.cases[case].label.clone(),
                probed,
            });
            Ok(())
        })?;
        Ok(found)
    }

    /// Returns the undetermined readings as pairs (load case, probe). Such a probe changes along a motion without stiffness, so the
    /// equilibrium does not determine its value.
    ///
    /// # Errors
    /// As [`Self::solve`].
    pub(crate) fn undetermined(&self, model: &Model) -> Result<Vec<(usize, usize)>, BenchError> {
        let mut found = Vec::new();
        if self.programme.cases.is_empty() {
            return Ok(found);
        }
        let compiled = CompiledCases::new(self, model).map_err(refused)?;
        let mut scratch = Scratch::new(&compiled.system);
        compiled.solve(self, &[], &mut |case, solved| {
            let here = solved.here();
            let tangent = Tangent::new(here.0, here.1, here.2)?;
            let values = compiled.probes.values(here, &mut scratch)?;
            for motion in tangent.free_motions(here.0) {
                let still = Direction::default();
                let changes = compiled
                    .probes
                    .changes(here, &mut scratch, &motion, &still)?;
                for (k, (change, value)) in changes.iter().zip(&values).enumerate() {
                    if change.abs() > FREE_CHANGE * value.abs().max(1.0) {
                        found.push((case, k));
                    }
                }
            }
            Ok(())
        })?;
        Ok(found)
    }
}

/// Numbers with respect to which the load cases can be differentiated. Without load cases, these are all numbers.
#[derive(Debug)]
pub(crate) struct Differentiable(Option<System>);

impl Differentiable {
    /// Returns true if the solver can differentiate with respect to all these numbers.
    pub(crate) fn has_all<'n>(&self, numbers: impl IntoIterator<Item = &'n Address>) -> bool {
        let mut numbers = numbers.into_iter();
        match &self.0 {
            Some(system) => numbers.all(|address| slot(system, address).is_ok()),
            None => true,
        }
    }
}

/// Converts the reason why a deck cannot be solved.
fn refused(why: BackendError) -> BenchError {
    match why {
        BackendError::NotSolvable(wrong) => BenchError::Deck(wrong),
        other => BenchError::Deck(vec![Diagnostic::error(
            Code::NotSolvedNatively,
            other.to_string(),
        )]),
    }
}
