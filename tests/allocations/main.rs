//! Checks that the allocations of a solve depend on its results and not on its iterations.
//!
//! The test has its own process, because every allocation of the process is counted.

#![allow(non_snake_case)]

use std::alloc::System as Memory;
use std::path::Path;

use admire_solver::model::Model;
use admire_solver::statics::{Solver, StaticSettings};
use admire_solver::system::System;
use admire_syntax::text::Source;
use admire_syntax::{Address, Dataset};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static COUNTED: &StatsAlloc<Memory> = &INSTRUMENTED_SYSTEM;

/// Returns (iterations, allocations) of each load case of an axle of the corpus, for a solver that has already solved them once.
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
        // Allocations of the test harness's own thread are counted too; the minimum of several runs belongs to the solver.
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
        // A few allocations, whatever the number of iterations: the history in the report, and the names of the two parts with the largest
        // remaining force and torque, also for the state with the smallest remaining imbalance.
        assert!(counts.iter().all(|c| c.1 <= 5), "{counts:?}");
    }
}
