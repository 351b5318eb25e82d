//! Run time of derivatives and of a whole search, relative to a sweep of the tests measured at the same time.

use std::time::{Duration, Instant};

use crate::bench::{KC, POINTS, TOE_AND_CAMBER, corpus, search, study, wanted};
use crate::evaluation::Evaluator;
use admire_study::Noise;

/// Number of rounds. The fastest round counts, because other processes on the machine can only slow a round down.
const ROUNDS: usize = 12;

/// Derivatives with respect to 12 unknowns take at most 2.5 times as long as the sweep alone. A search takes at most as long as 60 sweeps.
#[test]
fn derivatives_and_searches_cost_few_sweeps() {
    let folder = tempfile::tempdir().expect("a folder");
    let original = corpus("double-wishbone/model.adm");
    let flat = "value,toe_angle.left [deg],camber_angle.left [deg]\n-80,0,0\n80,0,0\n";
    let target = format!("[target]\nrestarts = 0\nevaluations = 50\n{POINTS}{TOE_AND_CAMBER}");
    let first = study(folder.path(), &original, flat, &target, KC);
    let curves = wanted(&first, &["toe_angle.left", "camber_angle.left"]);
    let mut noise = Noise::new(1, "moved hardpoints");
    let moved: Vec<f64> = (0..12).map(|_| noise.within(10.0)).collect();
    let deck = first.deck(&moved).expect("a deck");
    let tuning = study(folder.path(), deck.bytes(), &curves, &target, KC);
    let mut evaluator = Evaluator::new(&tuning);
    let x = vec![0.1; 12];
    let mut least = [Duration::MAX; 3];
    for _ in 0..ROUNDS {
        let mut time = |k: usize, job: &mut dyn FnMut()| {
            let began = Instant::now();
            job();
            least[k] = least[k].min(began.elapsed());
        };
        for (k, derivatives) in [(0, false), (1, true)] {
            time(k, &mut || {
                let found = evaluator.evaluate(&x, derivatives);
                assert!(found.is_some());
            });
        }
        time(2, &mut || assert!(search(&tuning).met));
    }
    let [sweep, derivatives, whole] = least.map(|time| time.as_secs_f64());
    let (each, all) = (derivatives / sweep, whole / sweep);
    println!(
        "a sweep {:.2} ms, with derivatives {each:.2} sweeps, a search {all:.1} sweeps",
        1e3 * sweep
    );
    assert!(each <= 2.5, "derivatives take {each:.2} sweeps");
    assert!(all <= 60.0, "a search takes {all:.1} sweeps");
}
