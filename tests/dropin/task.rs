//! A small deck for the command backend, and programs to run it.

use std::time::Duration;

use admire_session::backend::{
    Backend, CommandBackend, Load, LoadCase, LoadProgramme, Sweep, SweepRequest,
};
use admire_solver::model::Model;
use admire_syntax::text::Source;
use admire_syntax::{Address, Dataset};

/// A block on a bushing whose J marker is rotated by a quarter turn about z, so that ground axes and J axes differ.
pub const DECK: &str = "\
A block on a bushing
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1, REULER=90D,0D,0D
PART/2, MASS=2, CM=20, IP=100, 100, 100
MARKER/20, PART=2, REULER=90D,0D,0D
MARKER/3, PART=1
MARKER/4, PART=1, REULER=90D,90D,0D
BUSHING/1, I=20, J=1, K=100, 200, 400, KT=1E5, 1E5, 1E5
SFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=3
, FUNCTION = 0
SFORCE/2, TRANSLATIONAL, ACTIONONLY, I=20, J=4
, FUNCTION = 0
EQUILIBRIUM/ERROR=1E-10, IMBALANCE=1E-8
RESULTS/XRF
END
";

/// A deck, its load cases, and the values that change between runs.
pub struct Task {
    pub dataset: Dataset,
    pub model: Model,
    pub programme: LoadProgramme,
    pub theta: Vec<(Address, f64)>,
}

impl Task {
    pub fn new() -> Self {
        let dataset = Dataset::parse(Source::new("block.adm", DECK.as_bytes())).value;
        let model = Model::lower(&dataset).value;
        let load = |id: u32| Load {
            name: format!("load {id}"),
            target: Address::parse(&format!("SFORCE/{id}"), &dataset).unwrap(),
        };
        let case = |label: &str, values: [f64; 2]| LoadCase {
            label: label.to_string(),
            values: values.to_vec(),
        };
        let loads = vec![load(1), load(2)];
        Self {
            dataset,
            model,
            programme: LoadProgramme {
                loads,
                cases: vec![case("a", [100.0, 30.0]), case("b", [200.0, -20.0])],
            },
            theta: Vec::new(),
        }
    }

    pub fn at(&self, address: &str) -> Address {
        Address::parse(address, &self.dataset).unwrap()
    }

    pub fn request(&self) -> SweepRequest<'_> {
        SweepRequest {
            dataset: &self.dataset,
            model: &self.model,
            theta: &self.theta,
            programme: &self.programme,
        }
    }

    pub fn sweep(&self, backend: &mut CommandBackend) -> Result<Sweep, String> {
        backend
            .sweep(&self.request())
            .map_err(|error| error.to_string())
    }
}

pub fn words(list: &[&str]) -> Vec<String> {
    list.iter().map(ToString::to_string).collect()
}

pub fn mdi() -> Vec<String> {
    words(&[
        env!("CARGO_BIN_EXE_mdi"),
        "-c",
        "ru-standard",
        "i",
        "{acf}",
        "exit",
    ])
}

/// Returns a command that runs `mdi` and then a piece of shell script.
pub fn after(script: &str) -> Vec<String> {
    let mdi = env!("CARGO_BIN_EXE_mdi");
    words(&[
        "sh",
        "-c",
        &format!("'{mdi}' -c ru-standard i run.acf exit >/dev/null; {script}"),
    ])
}

pub fn backend(command: Vec<String>) -> CommandBackend {
    CommandBackend::new(command, Duration::from_secs(30))
}
