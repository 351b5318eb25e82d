//! Random models checked against independent laws.
//!
//! From the poses and reactions in the results file alone: every joint is closed, every element follows its law, no reaction does work, and
//! the forces on every part cancel. `RANDOM_MODELS=2000 cargo test --test dropin random_models` sets the number of models; `RANDOM_FROM=N`
//! sets the first seed.

mod draw;
mod loads;
#[allow(non_snake_case, reason = "matrices, forces and torques")]
mod moving;
#[allow(non_snake_case, reason = "rotation matrices")]
mod plain;
#[allow(non_snake_case, reason = "rotation matrices")]
mod trains;

use rayon::prelude::*;

use crate::run::{Results, folder, mdi};
use draw::{Drawn, drawn};
use plain::{At, Frame, Plain, V, euler};

/// Relative tolerance of a balance, a law or a closed joint.
const EXACT: f64 = 1e-7;
/// Relative tolerance of a reaction, which is compared with finite differences of the joint equations.
const BY_DIFFERENCES: f64 = 1e-6;

/// Outcome of a seed.
enum Went {
    /// Largest relative residual.
    Right(f64),
    /// Exit code, and the line of the message with the reason.
    Refused(String),
    Wrong(String),
}

fn vector(results: &Results, entity: &str, names: [&str; 3], step: usize) -> V {
    V::from(names.map(|name| results.column(entity, name)[step]))
}

/// Returns the frames of the parts in one solution.
fn places(plain: &Plain, results: &Results, step: usize) -> Vec<Frame> {
    let mut places = vec![Frame {
        p: V::zeros(),
        R: plain::M::identity(),
    }];
    for part in 1..plain.parts.len() {
        let entity = format!("PART_{}_XFORM", part + 1);
        let angles: [f64; 3] = vector(results, &entity, ["PSI", "THETA", "PHI"], step).into();
        places.push(Frame {
            p: vector(results, &entity, ["X", "Y", "Z"], step),
            R: euler(angles),
        });
    }
    places
}

/// Checks one solution; returns the largest relative residual, or an error text.
fn judged(plain: &Plain, results: &Results, step: usize, drawn: &Drawn) -> Result<f64, String> {
    let places = places(plain, results, step);
    let frames = |places: &[Frame]| -> Vec<Frame> {
        let frame = |(part, frame): &(usize, Frame)| places[*part].then(frame);
        plain.markers.iter().map(frame).collect()
    };
    let mut before = vec![frames(&plain.design)];
    before.extend((0..step).map(|before| frames(&self::places(plain, results, before))));
    let at = At {
        now: frames(&places),
        before,
    };
    let mut worst = 0.0_f64;
    let mut sums = vec![(V::zeros(), V::zeros()); places.len()];
    let mut sizes = vec![(0.0, 0.0); places.len()];
    let mut add = |part: usize, point: V, F: V, T: V| {
        let T = T + (point - places[part].p).cross(&F);
        sums[part].0 += F;
        sums[part].1 += T;
        sizes[part].0 += F.norm();
        sizes[part].1 += T.norm();
    };
    let read = |name: &str| {
        (
            vector(results, name, ["FX", "FY", "FZ"], step),
            vector(results, name, ["TX", "TY", "TZ"], step),
        )
    };
    for force in &plain.forces {
        let [(F, T), (Fj, Tj)] = force.wrenches(&at);
        let told = read(&force.name);
        let size = F.norm() + T.norm() / drawn.length + 1e-3 * drawn.force;
        let apart = ((told.0 - F).norm() + (told.1 - T).norm() / drawn.length) / size;
        if !(apart <= EXACT) {
            return Err(format!(
                "{}: {told:?} told, {F:?} {T:?} by its law",
                force.name
            ));
        }
        worst = worst.max(apart);
        let (i, j) = (&at[force.i], &at[force.j]);
        let point = match force.law {
            plain::Law::Vector(..) => i.p,
            _ => j.p,
        };
        add(plain.markers[force.i].0, i.p, F, T);
        add(plain.markers[force.j].0, point, Fj, Tj);
    }
    for joint in &plain.joints {
        let (i, j) = (&at[joint.i], &at[joint.j]);
        for violation in joint.equations(&i.seen_from(j)) {
            let apart = violation.abs() / drawn.length.min(1.0);
            if !(apart <= EXACT) {
                return Err(format!(
                    "{}, {}: open by {violation:e}",
                    joint.name, joint.kind
                ));
            }
        }
        let (F, T) = read(&joint.name);
        if F.norm() * drawn.length + T.norm() > 1e-3 * drawn.force * drawn.length {
            let works = joint.works(&at, (F, T), drawn.length);
            if !(works <= BY_DIFFERENCES) {
                let kind = joint.kind;
                return Err(format!(
                    "{}, {kind}: {works:e} of its reaction does work",
                    joint.name
                ));
            }
        }
        add(plain.markers[joint.i].0, i.p, F, T);
        // The reaction on J acts at I, so its torque about J follows.
        add(plain.markers[joint.j].0, i.p, -F, -T);
    }
    for train in &plain.trains {
        let sum: f64 = train.terms.iter().map(|term| term.value(&at.now)).sum();
        let scale = train
            .terms
            .iter()
            .map(|term| term.scale.abs())
            .fold(0.0, f64::max);
        let apart = (sum - train.value).abs() / (scale * drawn.length.min(1.0));
        if !(apart <= EXACT) {
            return Err(format!("{}: {sum:e} for {:e}", train.name, train.value));
        }
        let told = read(&train.name);
        let (on, (F, T)) = train.wrenches(&at.now, told);
        let size = told.0.norm() + told.1.norm() / drawn.length + 1e-3 * drawn.force;
        let apart = (F.norm() + T.norm() / drawn.length) / size;
        if !(apart <= EXACT) {
            return Err(format!(
                "{}: {told:?} told, {F:?} {T:?} beside its joint",
                train.name
            ));
        }
        for (term, (F, T)) in train.terms.iter().zip(on) {
            let point = at[term.i].p;
            add(plain.markers[term.i].0, point, F, T);
            add(plain.markers[term.j].0, point, -F, -T);
        }
    }
    for multi in &plain.multis {
        for (n, (F, T)) in multi.wrenches(&at.now).into_iter().enumerate() {
            let own = |names: [&str; 3]| {
                let columns = names.map(|name| match n {
                    0 => name.to_string(),
                    n => format!("{name}_{}", n + 1),
                });
                let [x, y, z] = columns
                    .each_ref()
                    .map(|name| results.column(&multi.name, name)[step]);
                V::new(x, y, z)
            };
            let told = (own(["FX", "FY", "FZ"]), own(["TX", "TY", "TZ"]));
            let size = F.norm() + T.norm() / drawn.length + 1e-3 * drawn.force;
            let apart = ((told.0 - F).norm() + (told.1 - T).norm() / drawn.length) / size;
            if !(apart <= EXACT) {
                let name = &multi.name;
                return Err(format!("{name}: {told:?} told, {F:?} {T:?} by its law"));
            }
            worst = worst.max(apart);
            let point = at[multi.i[n]].p;
            add(plain.markers[multi.i[n]].0, point, F, T);
            // J receives the opposite of each force, at the position of that marker.
            add(plain.markers[multi.j].0, point, -F, -T);
        }
    }
    for (part, of) in plain.parts.iter().enumerate().skip(1) {
        let point = at[of.cm].p;
        add(part, point, plain.gravity * of.mass, V::zeros());
    }
    for part in 1..places.len() {
        let ((F, T), (f, t)) = (sums[part], sizes[part]);
        let left = (F.norm() / f).max(T.norm() / t);
        if !(left <= EXACT) {
            return Err(format!(
                "PART/{}: {F:?} of {f:e}, {T:?} of {t:e} is left",
                part + 1
            ));
        }
        worst = worst.max(left);
    }
    Ok(worst)
}

fn went(seed: u64) -> Went {
    let drawn = drawn(seed);
    let place = folder(&[("model.adm", &drawn.deck), ("run.acf", &drawn.commands)]);
    let ran = mdi(place.path(), &["ru-s", "run"]);
    if let Ok(keep) = std::env::var("RANDOM_KEEP") {
        let to = std::path::Path::new(&keep).join(seed.to_string());
        std::fs::create_dir_all(&to).expect("a folder for the models");
        for name in ["model.adm", "run.acf", "model.res", "model.msg"] {
            _ = std::fs::copy(place.path().join(name), to.join(name));
        }
    }
    let message = crate::run::text(place.path(), "model.msg");
    if message.contains("Recomputed force balance")
        && message.contains("than IMBALANCE and round-off")
    {
        return Went::Wrong("the product does not believe its own balance".to_string());
    }
    let complaint = ran.stdout.split("---- START: ERROR ----").nth(1);
    if let Some(complaint) = complaint {
        let line: Vec<&str> = complaint
            .lines()
            .filter(|l| !l.is_empty())
            .take(2)
            .collect();
        return match ran.code {
            3 | 0 if complaint.contains("failed to converge") => Went::Refused(line.join(" ")),
            code => Went::Wrong(format!("code {code}: {}", line.join(" "))),
        };
    }
    if ran.code != 0 {
        return Went::Wrong(format!("code {}: {}", ran.code, ran.stderr));
    }
    let results = Results::read(place.path(), "model.res");
    if results.steps.len() != drawn.solutions.len() {
        return Went::Wrong(format!("{} steps", results.steps.len()));
    }
    let mut worst = 0.0_f64;
    for (step, plain) in drawn.solutions.iter().enumerate() {
        match judged(plain, &results, step, &drawn) {
            Ok(left) => worst = worst.max(left),
            Err(why) => return Went::Wrong(format!("solution {}: {why}", step + 1)),
        }
    }
    Went::Right(worst)
}

#[test]
fn random_models_are_in_balance_by_the_plain_laws() {
    let number = |name: &str, usual: u64| {
        let text = std::env::var(name).ok();
        text.and_then(|text| text.parse().ok()).unwrap_or(usual)
    };
    let (from, count) = (number("RANDOM_FROM", 0), number("RANDOM_MODELS", 100));
    let all: Vec<(u64, Went)> = (from..from + count)
        .into_par_iter()
        .map(|seed| (seed, went(seed)))
        .collect();
    let (mut worst, mut refused, mut wrong) = (0.0_f64, Vec::new(), Vec::new());
    for (seed, went) in &all {
        match went {
            Went::Right(left) => worst = worst.max(*left),
            Went::Refused(why) => refused.push(format!("{seed}: {why}")),
            Went::Wrong(why) => wrong.push(format!("{seed}: {why}")),
        }
    }
    println!(
        "{count} models, {} without an equilibrium, {worst:.1e} left at most",
        refused.len()
    );
    println!("{}", refused.join("\n"));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // Models that are not solved prove nothing, so they must be rare.
    assert!(20 * refused.len() <= all.len(), "{}", refused.join("\n"));
}
