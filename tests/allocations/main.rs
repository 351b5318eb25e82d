//! A solve allocates for what it hands back, not for its iterations. Alone in its process: every allocation is counted.

#![allow(non_snake_case)]

use std::alloc::System as Memory;
use std::path::Path;

use admire_solver::model::Model;
use admire_solver::statics::{StaticSettings, Solver};
use admire_solver::system::System;
use admire_syntax::text::Source;
use admire_syntax::{Address, Dataset};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static COUNTED: &StatsAlloc<Memory> = &INSTRUMENTED_SYSTEM;

/// (iterations, allocations) of the load cases of an axle of the corpus, the solver having solved it before.
fn counts(axle: &str) -> Vec<(usize, usize)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("corpus/{axle}/reference.adm"));
    let dataset = Dataset::parse(Source::new("axle", std::fs::read(path).unwrap())).value;
    let system = System::compile(&Model::lower(&dataset).value).value;
    let (mut parameters, mut state) = (system.parameters(), system.state());
    let mut solver = Solver::new(&system);
    let settings = StaticSettings::tight();
    let slots = [1, 2, 3].map(|id| {
        let address = Address {
            kind: "SFORCE".to_string(),
            id: Some(id),
            argument: None,
            index: None,
        };
        system.catalogue().slot(&address).unwrap()
    });
    let loads = [
        [0.0, 0.0, 3000.0],
        [0.0, 0.0, 3001.0],
        [900.0, -1500.0, 6000.0],
        [900.0, -1500.0, 6000.0],
        [-2000.0, 2500.0, 1500.0],
        [0.0, 0.0, 1500.0],
    ];
    let mut out = Vec::new();
    for warm in [false, true] {
        for load in loads {
            for (slot, value) in slots.iter().zip(load) {
                parameters.set(*slot, value);
            }
            let region = Region::new(COUNTED);
            let report = solver
                .solve(&system, &parameters, &mut state, &settings)
                .unwrap();
            let change = region.change();
            if warm {
                out.push((report.iterations, change.allocations + change.reallocations));
            }
        }
    }
    out
}

#[test]
fn iterations_allocate_nothing() {
    for axle in ["pseudo-mcpherson", "multilink"] {
        // What the thread of the test harness allocates meanwhile is counted, too: the least of some turns is the solver's.
        let least = |a: Vec<(usize, usize)>, b: Vec<(usize, usize)>| {
            let pairs = a.into_iter().zip(b);
            pairs.map(|(a, b)| (a.0, a.1.min(b.1))).collect()
        };
        let turns = (0..3).map(|_| counts(axle));
        let counts = turns.reduce(least).unwrap();
        println!("{axle}: (iterations, allocations) {counts:?}");
        let iterations = counts.iter().map(|c| c.0);
        let (least, most) = (iterations.clone().min(), iterations.max());
        assert!(most > least.map(|l| l + 2), "{counts:?}");
        // The same few for one iteration and for many: the history that the report hands back, the names of the two parts where most force
        // and torque is left, and these again where no solve has left more.
        assert!(counts.iter().all(|c| c.1 <= 5), "{counts:?}");
    }
}
