//! Checks of the readings that run before any fit. They find marks in wrong units, swapped, missing, collinear and inconsistent marks, and
//! copied cases.
//!
//! A fault that can be corrected safely is corrected with a warning. Outliers, and drifts that move all marks of a part together, are left to
//! the diagnosis.

use super::measurement::{Grouped, Measurement};
use super::orientation::{
    LEAST_SPREAD, Orientation, OrientationError, absolute_orientation, chi_square_p_value,
    estimate_noise, extents,
};
use super::resolve;
use super::study::{MarkFiles, Study};
use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::{Model, PartKind};
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};

/// Commonly mistaken length units: factor from the wrong unit to the deck's unit, and name of the wrong unit. The names assume a deck in
/// millimetres.
const FACTORS: &[(f64, &str)] = &[
    (1000.0, "metres"),
    (10.0, "centimetres"),
    (25.4, "inches"),
    (304.8, "feet"),
    (1e-3, "thousandths of the deck's unit"),
    (0.1, "tenths of the deck's unit"),
];

/// Minimum factor by which a change of unit must bring a part closer to its position in the deck, for a wrong unit to be assumed.
const NEARER: f64 = 3.0;

/// Ratio of the width to the length of a set of marks up to which the pose of the part is poorly determined.
const POOR_SPREAD: f64 = 0.05;

/// P-value of the chi-square test below which the marks of a part do not fit a rigid body.
const INCONSISTENT: f64 = 1e-6;

impl Measurement {
    /// Returns the measurement of a study with all names resolved in its model, and runs the checks of module `check`. Faults that can be corrected
    /// safely are corrected with a warning. If an error is reported, the results of a fit are not reliable.
    pub fn resolve(study: &Study, model: &Model) -> Checked<Self> {
        let mut out = Vec::new();
        let mut value = resolve::measurement(study, model, &mut out);
        check(&mut value, study, model, &mut out);
        Checked {
            value,
            diagnostics: out,
        }
    }
}

/// Runs all checks of a measurement, and corrects faults that can be corrected safely.
pub(super) fn check(to: &mut Measurement, study: &Study, model: &Model, out: &mut Vec<Diagnostic>) {
    if let Some(marks) = &study.marks {
        units(to, marks, model, out);
        layouts(to, marks, model.units.length.word, out);
        noise(to, marks, out);
        swapped(to, marks, model, out);
        missing(to, marks, model, out);
    }
    copied(to, study, out);
    let nothing = to.cases.iter().all(|case| {
        case.marks.is_empty() && case.wheel.is_none() && case.channels.iter().all(Option::is_none)
    });
    if nothing && !to.cases.is_empty() {
        out.push(
            Diagnostic::error(
                Code::MissingMarks,
                "the study contains no reading that can be used",
            )
            .help("add a section [marks], [kc] or [readings], or `measured` in [wheel]"),
        );
    }
}

/// Returns the entry of [`FACTORS`] that corrects readings which are too large by the factor `scale`, if there is one.
fn unit_factor(scale: f64) -> Option<(f64, &'static str)> {
    FACTORS
        .iter()
        .copied()
        .find(|(factor, _)| libm::log(scale * factor).abs() < 0.1)
}

/// Returns the median ratio of measured to listed distances between the marks of one part in one case.
fn scale(on_part: &[Vec3], measured: &[Vec3]) -> Option<f64> {
    let mut ratios = Vec::new();
    for a in 0..on_part.len() {
        for b in 0..a {
            let listed = (on_part[a] - on_part[b]).norm();
            if listed > 0.0 {
                ratios.push((measured[a] - measured[b]).norm() / listed);
            }
        }
    }
    median(&mut ratios).filter(|ratio| *ratio > 0.0)
}

fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    (!values.is_empty()).then(|| values[values.len() / 2])
}

fn units(to: &mut Measurement, marks: &MarkFiles, model: &Model, out: &mut Vec<Diagnostic>) {
    on_part_units(to, marks, model, out);
    // Any remaining mistake is in the file of measured marks: in the whole file, in whole cases, or in single parts of a case.
    let mut wrong: Vec<(usize, usize, f64, &'static str)> = Vec::new();
    let mut looked_at = 0;
    for case in 0..to.cases.len() {
        for part in 0..to.parts.len() {
            let (on_part, measured) = to.pairs(case, part);
            let Some(scale) = scale(&on_part, &measured) else {
                continue;
            };
            looked_at += 1;
            if let Some((factor, name)) = unit_factor(scale) {
                wrong.push((case, part, factor, name));
            }
        }
    }
    let everywhere = wrong.len() == looked_at && looked_at > 0;
    let mut grouped = Grouped::default();
    for &(case, part, factor, name) in &wrong {
        let mut place = admire_syntax::text::Span::at(0);
        for reading in to.cases[case].marks.iter_mut().filter(|r| r.part == part) {
            reading.x *= factor;
            place = reading.place;
        }
        let key = if everywhere {
            String::new()
        } else {
            to.cases[case].label.clone()
        };
        grouped.add(key, || {
            let which = if everywhere {
                "all measured marks".to_string()
            } else {
                format!(
                    "marks of {} in case {}",
                    to.parts[part].name, to.cases[case].label
                )
            };
            Diagnostic::warning(
                Code::WrongUnits,
                format!("{which} seem to be in {name}; they are multiplied by {factor}"),
            )
            .label(marks.measured.source.name(), place, "")
        });
    }
    grouped.finish(out);
}

/// Corrects the unit of the marks listed on the parts. The size of a part in the deck reveals a wrong unit. If both sessions use the same wrong
/// unit, the position of the part in the deck confirms it.
fn on_part_units(
    to: &mut Measurement,
    marks: &MarkFiles,
    model: &Model,
    out: &mut Vec<Diagnostic>,
) {
    let mut grouped = Grouped::default();
    let mut found: Vec<(usize, f64, &'static str)> = Vec::new();
    for (at, marked) in to.parts.iter().enumerate() {
        let listed: Vec<Vec3> = marked.marks.iter().map(|mark| mark.p).collect();
        let of_deck: Vec<Vec3> = model
            .markers
            .iter()
            .filter(|marker| marker.part == marked.part)
            .map(|marker| marker.qp)
            .collect();
        let pose = model.parts[marked.part.0].pose;
        let (size, deck_size) = (extents(&listed)[0], extents(&of_deck)[0]);
        if size <= 0.0 || deck_size <= 0.0 {
            continue;
        }
        // Marks may be closer together than the markers of the part, so only a gross mismatch counts. The readings must confirm it. Either they
        // contradict the listed marks by the same factor, or both files place the part far from its position in the deck.
        let ratio = size / deck_size;
        let mut scales: Vec<f64> = (0..to.cases.len())
            .filter_map(|case| {
                let (on_part, measured) = to.pairs(case, at);
                scale(&on_part, &measured)
            })
            .collect();
        let Some(scale) = median(&mut scales) else {
            continue;
        };
        let candidate = FACTORS.iter().copied().find(|(factor, _)| {
            let listed_fits =
                libm::log(ratio * factor).abs() < (libm::log(ratio).abs() / 3.0).max(0.7);
            let gross = libm::log(ratio).abs() > 1.5;
            let readings_right = libm::log(scale / factor).abs() < 0.1;
            let both_wrong = libm::log(scale).abs() < 0.1
                && NEARER * distance(to, at, &pose, *factor) < distance(to, at, &pose, 1.0);
            gross && listed_fits && (readings_right || both_wrong)
        });
        if let Some((factor, name)) = candidate {
            found.push((at, factor, name));
        }
    }
    for (at, factor, name) in found {
        for mark in &mut to.parts[at].marks {
            mark.p *= factor;
        }
        let part = &to.parts[at].name;
        grouped.add(name.to_string(), || {
            Diagnostic::warning(
                Code::WrongUnits,
                format!(
                    "the marks listed on {part} seem to be in {name}; they are multiplied by {factor}"
                ),
            )
            .label(
                marks.on_parts.source.name(),
                marks.on_parts.header_span(),
                "coordinates must be in the deck's length unit",
            )
        });
    }
    grouped.finish(out);
}

/// Returns the distance between the measured marks of a part and their position in the deck, with all coordinates multiplied by `factor`. It is
/// the median over the cases.
fn distance(to: &Measurement, part: usize, pose: &Pose, factor: f64) -> f64 {
    let mean = |points: &[Vec3]| points.iter().sum::<Vec3>() * factor / points.len() as f64;
    let of_case = |case: usize| {
        let (on_part, measured) = to.pairs(case, part);
        (!on_part.is_empty()).then(|| (mean(&measured) - pose.point(&mean(&on_part))).norm())
    };
    let mut distances: Vec<f64> = (0..to.cases.len()).filter_map(of_case).collect();
    median(&mut distances).unwrap_or(f64::INFINITY)
}

/// Warns of parts whose marks lie on one line. `unit` is the length unit of the deck.
fn layouts(to: &Measurement, marks: &MarkFiles, unit: &str, out: &mut Vec<Diagnostic>) {
    for marked in &to.parts {
        let points: Vec<Vec3> = marked.marks.iter().map(|mark| mark.p).collect();
        if points.len() < 3 {
            continue;
        }
        let [length, lateral, _] = extents(&points);
        let message = if lateral <= LEAST_SPREAD * length {
            format!(
                "the marks of {} lie on one line (rms width {lateral:.3} {unit}, rms length {length:.1} {unit}): the rotation about this line is \
                 not determined, and no pose is computed from these marks",
                marked.name
            )
        } else if lateral <= POOR_SPREAD * length {
            format!(
                "the marks of {} lie almost on one line (rms width {lateral:.2} {unit}, rms length {length:.1} {unit}): the rotation about this \
                 line is poorly determined",
                marked.name
            )
        } else {
            continue;
        };
        out.push(
            Diagnostic::warning(Code::CollinearMarks, message)
                .label(
                    marks.on_parts.source.name(),
                    marks.on_parts.header_span(),
                    "",
                )
                .help("spread the marks over the whole part"),
        );
    }
}

/// Estimates the noise of the marks from their misfit to rigid parts, if the study does not state it. Fits with unusually large residuals are
/// excluded.
fn noise(to: &mut Measurement, marks: &MarkFiles, out: &mut Vec<Diagnostic>) {
    if !to.sigma_estimated {
        return;
    }
    let mut fits: Vec<Vec<Orientation>> = (0..to.parts.len())
        .map(|part| {
            let all = 0..to.cases.len();
            all.filter_map(|case| to.orientation(case, part).ok())
                .filter(|fit| fit.residuals.len() == to.parts[part].marks.len() && fit.dof > 0)
                .collect()
        })
        .collect();
    let spread = |fit: &Orientation| {
        let squares: f64 = fit.residuals.iter().map(Vec3::norm_squared).sum();
        (squares / fit.dof as f64).sqrt()
    };
    let mut all: Vec<f64> = fits.iter().flatten().map(spread).collect();
    if let Some(typical) = median(&mut all) {
        for part in &mut fits {
            part.retain(|fit| spread(fit) <= 4.0 * typical + 1e-12);
        }
    }
    if let Some(estimate) = estimate_noise(&fits) {
        to.sigma = estimate.sigma;
    } else {
        to.sigma = 0.05;
        if marks.measured.rows().is_empty() {
            // Missing readings are reported elsewhere.
            return;
        }
        out.push(
            Diagnostic::warning(
                Code::MissingSetting,
                "the noise of the marks cannot be estimated from the readings; a standard deviation of 0.05 in the deck's length unit is assumed",
            )
            .label(
                marks.measured.source.name(),
                marks.measured.header_span(),
                "",
            )
            .help("state the standard deviation of a coordinate in `marks.sigma`"),
        );
    }
}

/// Returns true if the residuals of a rigid-body fit are too large for noise with this variance per coordinate.
fn inconsistent(fit: &Orientation, variance: f64) -> bool {
    let squares: f64 = fit.residuals.iter().map(Vec3::norm_squared).sum();
    fit.dof > 0 && chi_square_p_value(squares / variance, fit.dof) < INCONSISTENT
}

fn swapped(to: &mut Measurement, marks: &MarkFiles, model: &Model, out: &mut Vec<Diagnostic>) {
    let length = model.units.length.word;
    // Exact readings still contain the rounding of their file.
    let floor = 1e-3;
    let variance = (to.sigma * to.sigma + to.sigma_on_parts * to.sigma_on_parts).max(floor * floor);
    for part in 0..to.parts.len() {
        let mut bad: Vec<(usize, Option<Vec<usize>>)> = Vec::new();
        let mut fitted = 0;
        for case in 0..to.cases.len() {
            let (on_part, measured) = to.pairs(case, part);
            let Ok(fit) = absolute_orientation(&on_part, &measured, 1.0) else {
                continue;
            };
            fitted += 1;
            if inconsistent(&fit, variance) {
                bad.push((case, permutation(&on_part, &measured, &fit, variance)));
            }
        }
        if bad.is_empty() {
            continue;
        }
        let file = marks.measured.source.name();
        let everywhere = bad.len() == fitted
            && fitted > 1
            && bad.windows(2).all(|pair| pair[0].1 == pair[1].1)
            && bad[0].1.is_some();
        let mut grouped = Grouped::default();
        for (case, order) in bad {
            let rows: Vec<usize> = (0..to.cases[case].marks.len())
                .filter(|&at| to.cases[case].marks[at].part == part)
                .collect();
            let place = to.cases[case].marks[rows[0]].place;
            let part_name = to.parts[part].name.clone();
            let label = to.cases[case].label.clone();
            let Some(order) = order else {
                let fit = to.orientation(case, part);
                let rms = fit.map_or(0.0, |fit| rms(&fit.residuals));
                grouped.add(format!("inconsistent {part}"), || {
                    Diagnostic::warning(
                        Code::InconsistentMarks,
                        format!(
                            "the marks of {part_name} in case {label} do not fit a rigid part: the rms residual is {rms:.3} {length}, the noise {:.3} {length}",
                            variance.sqrt()
                        ),
                    )
                    .label(file, place, "")
                });
                continue;
            };
            let moved: Vec<usize> = (0..order.len()).filter(|&k| order[k] != k).collect();
            let names: Vec<&str> = moved
                .iter()
                .map(|&k| {
                    to.parts[part].marks[to.cases[case].marks[rows[k]].mark]
                        .label
                        .as_str()
                })
                .collect();
            let where_ = if everywhere {
                "every case".to_string()
            } else {
                format!("case {label}")
            };
            let message = format!(
                "marks {} of {part_name} are swapped in {where_}; this is corrected",
                names.join(" and ")
            );
            grouped.add(format!("swapped {where_}"), || {
                Diagnostic::warning(Code::SwappedMarks, message.clone()).label(
                    file,
                    to.cases[case].marks[rows[moved[0]]].place,
                    "",
                )
            });
            let read: Vec<Vec3> = rows.iter().map(|&at| to.cases[case].marks[at].x).collect();
            for (k, &at) in rows.iter().enumerate() {
                to.cases[case].marks[at].x = read[order[k]];
            }
        }
        grouped.finish(out);
    }
}

fn rms(residuals: &[Vec3]) -> f64 {
    let squares: f64 = residuals.iter().map(Vec3::norm_squared).sum();
    (squares / (3 * residuals.len().max(1)) as f64).sqrt()
}

/// Returns the permutation of the readings with which the marks fit a rigid part, if there is one. `as_read` is the fit in the order of the
/// file.
fn permutation(
    on_part: &[Vec3],
    measured: &[Vec3],
    as_read: &Orientation,
    variance: f64,
) -> Option<Vec<usize>> {
    let count = on_part.len();
    let mut best: Option<(f64, Vec<usize>)> = None;
    let mut try_order = |order: &[usize]| {
        let turned: Vec<Vec3> = order.iter().map(|&k| measured[k]).collect();
        if let Ok(fit) = absolute_orientation(on_part, &turned, 1.0) {
            let spread = rms(&fit.residuals);
            let better = best.as_ref().is_none_or(|(least, _)| spread < *least);
            if better && !inconsistent(&fit, variance) {
                best = Some((spread, order.to_vec()));
            }
        }
    };
    let mut order: Vec<usize> = (0..count).collect();
    if count <= 5 {
        permute(&mut order, 0, &mut try_order);
    } else {
        for a in 0..count {
            for b in 0..a {
                order.swap(a, b);
                try_order(&order);
                order.swap(a, b);
            }
        }
    }
    let (spread, order) = best?;
    (spread < rms(&as_read.residuals) / 5.0).then_some(order)
}

fn permute(order: &mut Vec<usize>, from: usize, visit: &mut impl FnMut(&[usize])) {
    if from == order.len() {
        visit(order);
        return;
    }
    for k in from..order.len() {
        order.swap(from, k);
        permute(order, from + 1, visit);
        order.swap(from, k);
    }
}

fn missing(to: &Measurement, marks: &MarkFiles, model: &Model, out: &mut Vec<Diagnostic>) {
    let file = marks.measured.source.name();
    let header = marks.measured.header_span();
    for (at, marked) in to.parts.iter().enumerate() {
        let mut poor = Vec::new();
        let mut partly = Vec::new();
        for case in 0..to.cases.len() {
            let (on_part, _) = to.pairs(case, at);
            let unusable = matches!(
                to.orientation(case, at),
                Err(OrientationError::TooFew(_) | OrientationError::NotFinite)
            );
            if unusable {
                poor.push(to.cases[case].label.as_str());
            } else if on_part.len() < marked.marks.len() {
                partly.push(to.cases[case].label.as_str());
            }
        }
        if !poor.is_empty() {
            let message = format!(
                "{} has fewer than three marks in {}: its pose there is unknown",
                marked.name,
                listed(&poor)
            );
            out.push(
                Diagnostic::warning(Code::MissingMarks, message)
                    .label(file, header, "")
                    .help("a fit still uses the marks that were read"),
            );
        }
        if !partly.is_empty() {
            let message = format!(
                "some marks of {} are missing in {}",
                marked.name,
                listed(&partly)
            );
            out.push(Diagnostic::note(Code::MissingMarks, message).label(file, header, ""));
        }
    }
    if to.parts.is_empty() {
        return;
    }
    for (at, part) in model.parts.iter().enumerate() {
        let marked = to.parts.iter().any(|marked| marked.part.0 == at);
        if part.kind == PartKind::Rigid && !marked {
            let message = format!(
                "{} carries no marks: its pose is not measured",
                part.header.name
            );
            out.push(Diagnostic::note(Code::MissingMarks, message).label(
                marks.on_parts.source.name(),
                marks.on_parts.header_span(),
                "",
            ));
        }
    }
}

/// Formats labels of cases as `case 7`, `cases 7, 8, 9` or `13 cases`.
fn listed(labels: &[&str]) -> String {
    match labels.len() {
        1 => format!("case {}", labels[0]),
        n if n <= 6 => format!("cases {}", labels.join(", ")),
        n => format!("{n} cases"),
    }
}

/// Removes the readings of copied cases. Noise never repeats, so readings of two cases that agree to the last digit are copies.
fn copied(to: &mut Measurement, study: &Study, out: &mut Vec<Diagnostic>) {
    let Some(marks) = &study.marks else { return };
    for second in 1..to.cases.len() {
        for first in 0..second {
            let (a, b) = (&to.cases[first], &to.cases[second]);
            let copies = a.marks.len() >= 3
                && a.marks.len() == b.marks.len()
                && a.marks
                    .iter()
                    .zip(&b.marks)
                    .all(|(a, b)| (a.part, a.mark, a.x) == (b.part, b.mark, b.x));
            if !copies {
                continue;
            }
            let same_loads = a.loads == b.loads;
            if same_loads && to.sigma == 0.0 {
                continue;
            }
            let (labels, places) = (
                [a.label.clone(), b.label.clone()],
                [a.marks[0].place, b.marks[0].place],
            );
            let what = if same_loads {
                to.cases[second].marks.clear();
                "the second is left out"
            } else {
                to.cases[first].marks.clear();
                to.cases[second].marks.clear();
                "their loads differ, so both are left out"
            };
            let message = format!(
                "the readings of cases {} and {} are copies of each other: {what}",
                labels[0], labels[1]
            );
            out.push(
                Diagnostic::warning(Code::DuplicateCase, message)
                    .label(marks.measured.source.name(), places[1], "the second one")
                    .label(marks.measured.source.name(), places[0], "the first one"),
            );
        }
    }
}
