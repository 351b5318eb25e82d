//! Factors and solutions for the Jacobian of long chains. Short chains are compared with nalgebra's dense elimination; for long ones the solution
//! has to satisfy the equations. `cargo test --lib long_chains -- --nocapture` shows the times.

use std::fmt::Write;
use std::time::Instant;

use nalgebra::{DMatrix, DVector};

use crate::linear::{Lu, Matrix, minimum_degree};
use crate::model::Model;
use crate::system::{Scratch, System};
use admire_syntax::Dataset;
use admire_syntax::text::Source;

/// Bound of the entries of the factors per entry of the Jacobian.
const FILL: f64 = 2.0;

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
            writeln!(deck, "JOINT/{id}, REVOLUTE, I={id}1, J={before}2")
                .expect("a matrix that has factors");
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
        .expect("text is written");
    matrix.finish();
    matrix
}

fn seconds<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let done = work();
    (start.elapsed().as_secs_f64(), done)
}

#[test]
fn long_chains() {
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
            "{links} links, {n} unknowns, {} entries\n  first {first:.4} s, again {again:.5} s, solve {solve:.5} s, {} in the factors",
            matrix.values().len(),
            lu.places()
        );
        let mut searched = Lu::new(n);
        let search = |lu: &mut Lu| lu.factor_in_order(&matrix.view(), |_| Vec::new());
        let (first, ()) = seconds(|| search(&mut searched));
        let (again, ()) = seconds(|| searched.factor(&matrix));
        println!(
            "  pivots searched for: first {first:.4} s, again {again:.5} s, {} in the factors",
            searched.places()
        );
        let (order, _) = seconds(|| minimum_degree(&matrix.view()));
        println!("  minimum degree alone: {order:.4} s");
        assert_eq!(lu.deficiency(), 0, "{links} links");
        // A chain fills in little: every link is eliminated next to its neighbours.
        let filled = lu.places() as f64 / matrix.values().len() as f64;
        assert!(filled < FILL, "{links} links: {filled}");
        // Sums of magnitudes per equation; a backward error is the share of its sum that an equation is off.
        let (mut off, mut sums): (Vec<f64>, Vec<f64>) = b.iter().map(|b| (-b, b.abs())).unzip();
        for (row, column, value) in matrix.entries() {
            off[row] += value * x[column];
            sums[row] += (value * x[column]).abs();
        }
        for (off, sum) in off.iter().zip(&sums) {
            let error = off.abs() / sum;
            assert!(error < 1e-9, "{links} links: {error:e}");
        }
        if n < 1_000 {
            let mut dense = DMatrix::<f64>::zeros(n, n);
            for (row, column, value) in matrix.entries() {
                dense[(row, column)] += value;
            }
            let y = dense.lu().solve(&DVector::from_vec(b)).expect("regular");
            let apart = (DVector::from_vec(x) - &y).amax() / y.amax();
            assert!(apart < 1e-9, "{links} links: {apart:e}");
        }
    }
}
