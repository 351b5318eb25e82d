//! Section 4.3: an axle with twelve bushings and an additional camber mobility, with noise on the marks (measured points).

use super::curves::{Wheel, by_fit, by_loop, ramp, read_reference, wheel_curves};
use super::{
    Comparison, Curve, ReproducedCurves, ReproductionError, Section, iterations, median_error,
    range, ratios, texts, truth, unidentified,
};
use admire_identify::{Fit, LoadedStudy};
use admire_study::settings::{Slope, Weights};

/// Number of iterations printed in the paper, to a step test of 0.05.
const PAPER_ITERATIONS: usize = 50;
/// Number of stiffnesses, out of 48, that kept their initial value according to the paper.
const PAPER_UNIDENTIFIABLE: usize = 17;

/// Number of progress stages: five runs of the iteration, two fits, and the curves. The iteration has three variants with and without
/// noise, one of which is left out.
pub(super) const STAGES: usize = 8;

pub(super) fn section(
    study: &LoadedStudy,
    progress: &mut dyn FnMut(&str),
) -> Result<Section, ReproductionError> {
    let truth = truth(study)?;
    let wheel = Wheel::of(study)?;
    let mut noisy = study.clone();
    let mut exact = study.clone();
    read_reference(&mut exact, 0.0, 0)?;
    let mut table = Comparison {
        title: "identification of all stiffnesses".to_string(),
        head: texts([
            "by",
            "noise mm",
            "iterations",
            "unidentifiable",
            "range of Ki/Kr, identified",
            "median |ln Ki/Kr|, identified",
        ]),
        rows: vec![vec![
            "the paper".to_string(),
            "0.05".to_string(),
            PAPER_ITERATIONS.to_string(),
            format!("{PAPER_UNIDENTIFIABLE} of 48"),
            "not printed".to_string(),
            "not printed".to_string(),
        ]],
    };
    let mut add = |name: &str, noise: f64, fit: &Fit, count: String| {
        let ratios = ratios(fit, &truth);
        table.rows.push(vec![
            name.to_string(),
            noise.to_string(),
            count,
            format!("{} of {}", unidentified(fit), truth.len()),
            range(&ratios),
            format!("{:.3}", median_error(&ratios)),
        ]);
    };
    let mut remarks = Vec::new();
    let mut loops: Vec<(&str, Vec<f64>)> = Vec::new();
    let noise = noisy.measurement.sigma;
    for (weights, slope, name) in [
        (Weights::Printed, Slope::Printed, "our loop, as printed"),
        (
            Weights::Corrected,
            Slope::Printed,
            "our loop, weights of (16) turned round",
        ),
        (
            Weights::Corrected,
            Slope::Inverse,
            "and the inverse regression",
        ),
    ] {
        for (study, sigma, what) in [
            (&mut exact, 0.0, "without noise"),
            (&mut noisy, noise, "with noise"),
        ] {
            study.study.regression.weights = weights;
            study.study.regression.slope = slope;
            if sigma == 0.0 && slope == Slope::Inverse {
                continue;
            }
            progress(&format!("4.3 {name}, {what}"));
            let fit = by_loop(study)?;
            add(name, sigma, &fit, iterations(&fit));
            if (weights, slope) == (Weights::Corrected, Slope::Printed) {
                loops.push((what, fit.values()));
                remarks.extend(fit.remarks.into_iter().take(1));
            }
        }
    }
    let mut fits: Vec<(&str, Vec<f64>)> = Vec::new();
    for (study, sigma, what) in [
        (&exact, 0.0, "without noise"),
        (&noisy, noise, "with noise"),
    ] {
        progress(&format!("4.3 the global fit, {what}"));
        let (fit, sweeps) = by_fit(study)?;
        add("our fit", sigma, &fit, format!("{sweeps} sweeps"));
        fits.push((what, fit.values()));
    }

    progress("4.3 wheel curves");
    let (programme, lateral) = ramp(
        study,
        "lateral",
        (-8..=8).map(|k| 500.0 * f64::from(k)),
        4500.0,
    )?;
    let mut shown: Vec<(String, Vec<f64>)> = vec![
        ("initial".to_string(), study.problem().initial()),
        ("reference".to_string(), truth.clone()),
    ];
    for (of, who) in [(loops, "loop"), (fits, "fit")] {
        shown.extend(
            of.into_iter()
                .map(|(what, values)| (format!("{who} {what}"), values)),
        );
    }
    let mut figures = [("a", "camber"), ("b", "steer")].map(|(letter, angle)| ReproducedCurves {
        title: format!("figure 9-{letter}: {angle} under cornering force"),
        x: "lateral force, N".to_string(),
        y: format!("change of {angle}, degrees"),
        curves: Vec::new(),
    });
    for (name, values) in &shown {
        let curves = wheel_curves((study, &wheel), values, (&programme, lateral), name)?;
        for (figure, curve) in figures.iter_mut().zip(curves) {
            figure.curves.push(curve);
        }
    }
    let distances = Comparison {
        title: "figure 9: rms difference from the reference over lateral force, degrees"
            .to_string(),
        head: texts(["model", "camber", "steer"]),
        rows: figures[0]
            .curves
            .iter()
            .enumerate()
            .filter(|(k, _)| *k != 1)
            .map(|(k, curve)| {
                let of = |figure: &ReproducedCurves| {
                    format!("{:.4}", figure.curves[k].distance(&figure.curves[1]))
                };
                vec![curve.name.clone(), of(&figures[0]), of(&figures[1])]
            })
            .collect(),
    };
    let mut findings = remarks;
    for (figure, angle) in figures.iter().zip(["camber", "steer"]) {
        findings.push(ordering(&figure.curves, angle));
    }
    Ok(Section {
        title: "4.3 Multilink with camber mobility, 48 stiffnesses, marks with noise of 0.05 mm".to_string(),
        tables: vec![table, distances],
        figures: figures.to_vec(),
        findings,
        limits: vec![
            "The paper's axle is Michelin's OCP, whose geometry and stiffnesses it does not print; ours has as many bushings and an \
             additional camber mobility. Its figure 9 has no numbers: only the order of its curves can be compared."
                .to_string(),
            "The paper does not say which weights it used. As printed (16) does not converge here, so the curves of the loop are \
             those with its weights turned round, as its own text asks for."
                .to_string(),
        ],
    })
}

/// Checks the order of the curves in figure 9 of the paper. There the fit without noise is closest to the reference, then the fit with
/// noise; the initial model is farthest away.
fn ordering(curves: &[Curve], angle: &str) -> String {
    let reference = &curves[1];
    let mut order: Vec<(f64, &str)> = curves
        .iter()
        .enumerate()
        .filter(|(k, _)| *k != 1)
        .map(|(_, curve)| (curve.distance(reference), curve.name.as_str()))
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let of = |name: &str| {
        order
            .iter()
            .find(|(_, n)| *n == name)
            .map_or(f64::NAN, |(d, _)| *d)
    };
    let as_printed = |who: &str| {
        let (without, with) = (
            of(&format!("{who} without noise")),
            of(&format!("{who} with noise")),
        );
        without < with && with < of("initial")
    };
    let names: Vec<&str> = order.iter().map(|(_, name)| *name).collect();
    let verdict = match (as_printed("loop"), as_printed("fit")) {
        (true, true) => "The loop and the fit have the paper's order",
        (true, false) => "The loop has the paper's order, the fit has not",
        (false, true) => "The fit has the paper's order, the loop has not",
        (false, false) => "Neither has the paper's order",
    };
    format!(
        "The {angle} of figure 9 is closest to the reference by {}. {verdict}: without noise, with noise, initial.",
        names.join(", then ")
    )
}
