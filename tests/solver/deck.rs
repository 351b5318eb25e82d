//! Helpers that build models from small decks.

use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::Model;
use admire_solver::statics::{Report, Solver, StaticSettings};
use admire_solver::system::{Parameters, Scratch, State, System};
use admire_syntax::Dataset;
use admire_syntax::text::Source;

pub fn read(text: &str) -> Model {
    let dataset = Dataset::parse(Source::new("test.adm", text.as_bytes().to_vec()));
    assert!(!dataset.has_errors(), "{:#?}", dataset.diagnostics);
    let model = Model::lower(&dataset.value);
    assert!(!model.has_errors(), "{:#?}", model.diagnostics);
    model.value
}

/// Common beginning of small decks, without gravity. Ground has MARKER/1 at its origin.
pub const HEAD: &str = "small\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\n\
                        PART/1, GROUND\nMARKER/1, PART=1\n";

/// A small deck and its equilibrium.
pub struct Solved {
    pub model: Model,
    pub system: System,
    pub parameters: Parameters,
    pub state: State,
    pub report: Report,
    /// Messages of the compiler.
    pub told: Vec<String>,
}

/// Solves [`HEAD`] with these statements, with tight tolerances.
pub fn solve(statements: &str) -> Solved {
    solve_with(statements, &StaticSettings::tight())
}

pub fn solve_with(statements: &str, settings: &StaticSettings) -> Solved {
    let dataset = Dataset::parse(Source::new(
        "small.adm",
        format!("{HEAD}{statements}\nEND\n").into_bytes(),
    ));
    assert!(!dataset.has_errors(), "{:#?}", dataset.diagnostics);
    let lowered = Model::lower(&dataset.value);
    assert!(!lowered.has_errors(), "{:#?}", lowered.diagnostics);
    let compiled = System::compile(&lowered.value);
    assert!(!compiled.has_errors(), "{:#?}", compiled.diagnostics);
    let told = lowered.diagnostics.iter().chain(&compiled.diagnostics);
    let told = told.map(|d| d.message.clone()).collect();
    let (model, system) = (lowered.value, compiled.value);
    let (parameters, mut state) = (system.parameters(), system.state());
    let report = Solver::new(&system)
        .solve(&system, &parameters, &mut state, settings)
        .unwrap_or_else(|error| panic!("{error}: {error:#?}"));
    Solved {
        model,
        system,
        parameters,
        state,
        report,
        told,
    }
}

impl Solved {
    /// Returns the pose of a part.
    pub fn pose(&self, part: u32) -> Pose {
        let all = self.model.parts.iter();
        let at = all.clone().position(|p| p.header.id == part).unwrap();
        self.state.poses[at]
    }

    /// Returns the pose of a marker in ground.
    pub fn marker(&self, id: u32) -> Pose {
        let marker = &self.model.markers[self.model.marker(id).unwrap().0];
        let local = Pose {
            p: marker.qp,
            R: marker.R,
        };
        self.state.poses[marker.part.0].compose(&local)
    }

    /// Returns the force and the torque about a point that the elements and constraints with this name exert on the part.
    pub fn on(&self, part: u32, by: &str, about: &Vec3) -> (Vec3, Vec3) {
        let mut scratch = Scratch::new(&self.system);
        let (parameters, state) = (&self.parameters, &self.state);
        let mut here = self
            .system
            .evaluate(parameters, state, &mut scratch)
            .unwrap();
        let loads = here.loads().unwrap();
        let (mut F, mut T) = (Vec3::zeros(), Vec3::zeros());
        for load in loads {
            let name = load.by.as_ref().map(|n| format!("{}/{}", n.kind, n.id));
            let is_part = self.model.parts[load.part.0].header.id == part;
            if is_part && name.as_deref() == Some(by) {
                F += load.force;
                T += load.torque_about(about);
            }
        }
        (F, T)
    }

    /// Returns F2 of REQUEST number `index`, which shows a function.
    pub fn shown(&self, index: usize) -> f64 {
        let mut scratch = Scratch::new(&self.system);
        let (parameters, state) = (&self.parameters, &self.state);
        let mut here = self
            .system
            .evaluate(parameters, state, &mut scratch)
            .unwrap();
        let request = &self.model.requests[index];
        here.read_request(request, index).unwrap()[1]
    }
}
