//! Comparison of the elimination in `crate::linear` with faer's sparse LU (COLAMD, AMD) on the Jacobian of long chains. The test measures the
//! time to find the order and the time of each factorisation after that. Both methods must give the same solution.
//! `cargo test --lib compared_with_faer -- --nocapture` shows the times.

use std::fmt::Write;
use std::time::Instant;

use faer::sparse::linalg::solvers::{Lu as FaerLu, SymbolicLu};
use faer::sparse::{SparseColMat, Triplet};

use crate::linear::{Lu, Matrix, minimum_degree};
use crate::model::Model;
use crate::system::{Scratch, System};
use admire_syntax::Dataset;
use admire_syntax::text::Source;

/// Returns the Jacobian of a chain of links that are connected by bushings. Every tenth link also has a bushing to ground. Every seventh link
/// has a hinge in place of its bushing, except the last link, which would swing freely.
fn chain(links: u32) -> Matrix {
    let mut deck = String::from("chain\nPART/1, GROUND\nMARKER/1, PART=1\nMARKER/12, PART=1\n");
    for id in 2..links + 2 {
        let x = 100 * (id - 2);
        writeln!(
            deck,
            "PART/{id}, QG={x},0,0, MASS=1, CM={id}1, IP=9,9,9\nMARKER/{id}1, PART={id}\nMARKER/{id}2, PART={id}, QP=100,0,0"
        )
        .expect("text is written");
        let before = id - 1;
        if id % 7 == 0 && id <= links {
            writeln!(deck, "JOINT/{id}, REVOLUTE, I={id}1, J={before}2").expect("text is written");
        } else {
            writeln!(
                deck,
                "BUSHING/{id}, I={id}1, J={before}2, K=1E4,1E4,1E4, KT=1E6,1E6,1E6"
            )
            .expect("text is written");
        }
        if id % 10 == 0 {
            writeln!(
                deck,
                "MARKER/{id}3, PART=1, QP={},0,0\nBUSHING/{}, I={id}2, J={id}3, K=1E4,1E4,1E4, KT=1E6,1E6,1E6",
                x + 100,
                links + id
            )
            .expect("text is written");
        }
    }
    deck += "END\n";
    let dataset = Dataset::parse(Source::new("chain.adm", deck.into_bytes())).value;
    let system = System::compile(&Model::lower(&dataset).value).value;
    let mut matrix = Matrix::new(system.unknowns());
    let mut g = vec![0.0; system.unknowns()];
    let (mut scratch, state) = (Scratch::new(&system), system.state());
    system
        .assemble(
            &system.parameters(),
            &state,
            &mut scratch,
            &mut g,
            &mut matrix,
        )
        .expect("the functions have values");
    matrix.finish();
    matrix
}

fn seconds<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let done = work();
    (start.elapsed().as_secs_f64(), done)
}

#[test]
fn compared_with_faer() {
    for links in [10, 100, 1_000, 10_000] {
        let matrix = chain(links);
        let n = matrix.size();
        let mut lu = Lu::new(n);
        let (first, ()) = seconds(|| lu.factor(&matrix));
        let (again, ()) = seconds(|| lu.factor(&matrix));
        let b: Vec<f64> = (0..n).map(|k| libm::sin(k as f64)).collect();
        let mut x = b.clone();
        let (solve, ()) = seconds(|| lu.solve(&mut x));
        println!(
            "{links} links, {n} unknowns, {} entries\n  ours:  first {first:.4} s, again {again:.5} s, solve {solve:.5} s, {} in the factors",
            matrix.values().len(),
            lu.places()
        );
        let mut searched = Lu::new(n);
        let search = |lu: &mut Lu| lu.factor_in_order(&matrix.view(), |_| Vec::new());
        let (first, ()) = seconds(|| search(&mut searched));
        let (again, ()) = seconds(|| searched.factor(&matrix));
        println!(
            "  ours, pivots searched for: first {first:.4} s, again {again:.5} s, {} in the factors",
            searched.places()
        );
        let (order, _) = seconds(|| minimum_degree(&matrix.view()));
        println!("  faer's minimum degree alone: {order:.4} s");
        let entries = matrix.entries();
        let triplets: Vec<Triplet<usize, usize, f64>> = entries
            .map(|(row, column, value)| Triplet::new(row, column, value))
            .collect();
        let theirs = SparseColMat::try_new_from_triplets(n, n, &triplets)
            .expect("a matrix that has factors");
        let (order, symbolic) =
            seconds(|| SymbolicLu::try_new(theirs.symbolic()).expect("a matrix that has factors"));
        let numeric = || {
            FaerLu::try_new_with_symbolic(symbolic.clone(), theirs.as_ref())
                .expect("a matrix that has factors")
        };
        let (first, _) = seconds(numeric);
        let (again, factors) = seconds(numeric);
        let right = faer::Col::from_fn(n, |k| b[k]);
        let (solve, y) = seconds(|| faer::prelude::Solve::solve(&factors, &right));
        let apart = (0..n).map(|k| (x[k] - y[k]).abs()).fold(0.0, f64::max);
        let size = x.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        println!(
            "  faer:  order {order:.4} s, first {first:.4} s, again {again:.5} s, solve {solve:.5} s; answers {:.0e} apart",
            apart / size
        );
        // Unlike the largest difference, a sum of differences is NaN if one of them is NaN.
        let sum: f64 = (0..n).map(|k| (x[k] - y[k]).abs()).sum();
        assert!(sum.is_finite() && lu.deficiency() == 0, "{links} links");
        // Eliminations in different orders differ by round-off, and the condition number of the chain grows with its length.
        assert!(apart < 1e-8 * size, "{links} links: {apart:e} of {size:e}");
    }
}
