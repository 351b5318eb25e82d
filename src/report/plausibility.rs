//! Overview of a study before any fit: its contents, its units and their plausibility.

use nalgebra::DMatrix;

use super::agreement::agreement;
use super::check::{Check, Verdict};
use super::frame_place::odd_frame;
use super::load_table::odd_loads;
use super::mark_scatter::{repeats, rigidity};
use super::number::counted;
use super::short_unit;
use admire_identify::LoadedStudy;
use admire_identify::global::gauss_newton::LeastSquares;
use admire_identify::global::{Observations, Prepared, fit_unknowns, global_problem};
use admire_identify::settings::UNIDENTIFIABLE_LN_SD;
use admire_solver::mechanics::Vec3;
use admire_solver::model::PartKind;
use admire_solver::model::lint::implausible_units;
use admire_study::settings::BackendChoice;

/// Plausibility table of a study.
#[derive(Clone, Default, PartialEq, Debug)]
pub struct Plausibility {
    /// Lines of the table.
    pub checks: Vec<Check>,
}

/// Ratio of observed to declared noise of the marks above which the study is certainly wrong. It then declares the noise in another unit, or
/// the noise of another sensor.
const NOISE_IMPOSSIBLE: f64 = 20.0;
/// Ratio of observed to declared noise of the marks above which the declared noise is doubtful. Declared noise is also doubtful below the
/// reciprocal of this ratio.
const NOISE_DOUBTFUL: f64 = 2.0;
/// Plausible size of a mechanism on a test rig, in metres.
const SIZE: (f64, f64) = (0.02, 50.0);
/// Plausible total mass of the moving parts, in kilograms.
const MASS: (f64, f64) = (1e-3, 1e5);
/// Plausible stiffness of rubber, joints and links, in newtons per metre.
const STIFFNESS: (f64, f64) = (1.0, 1e11);
/// Smallest motion of a mark, in units of its noise, that carries information about the model.
const MOVED: f64 = 3.0;

impl Plausibility {
    /// Checks a study. The forecast solves all load cases once at the start values. The search for slips (single mistaken numbers) runs
    /// short fits.
    pub fn of(loaded: &LoadedStudy) -> Self {
        let mut table = Self::default();
        table.loads(loaded);
        table.readings(loaded);
        table.summaries(loaded);
        table.units(loaded);
        table.sizes(loaded);
        let is_mirrored = table.mirror(loaded);
        if !is_mirrored {
            table.noise(loaded);
        }
        table.movement(loaded);
        table.free_motions(loaded);
        let is_settled = table.assembly(loaded) || is_mirrored || table.slip(loaded);
        table.forecast(loaded, is_settled);
        table
    }

    /// Returns the reason why this study is refused unless a fit is forced. Returns `None` if the study is acceptable.
    pub fn refusal(&self) -> Option<String> {
        let wrong = self.checks.iter();
        let wrong = wrong.filter(|check| check.verdict == Verdict::Impossible);
        let why: Vec<&str> = wrong.map(|check| check.why.as_str()).collect();
        (!why.is_empty()).then(|| format!("the study is implausible: {}", why.join("; ")))
    }

    /// Returns true if no check forbids a fit.
    pub fn allows_a_fit(&self) -> bool {
        self.checks
            .iter()
            .all(|check| check.verdict != Verdict::Impossible)
    }

    /// Adds a line to the table. The reason `why` is dropped if the verdict is plausible.
    pub(super) fn add(
        &mut self,
        what: &'static str,
        found: String,
        verdict: Verdict,
        why: impl Into<String>,
    ) {
        let why = if verdict == Verdict::Plausible {
            String::new()
        } else {
            why.into()
        };
        self.checks.push(Check {
            what,
            found,
            verdict,
            why,
        });
    }

    fn loads(&mut self, loaded: &LoadedStudy) {
        let cases = &loaded.measurement.cases;
        let mut constant = Vec::new();
        let mut ranges = Vec::new();
        for (at, load) in loaded.programme.loads.iter().enumerate() {
            let values = || cases.iter().map(|case| case.loads[at]);
            let (least, most) = (
                values().fold(f64::INFINITY, f64::min),
                values().fold(f64::NEG_INFINITY, f64::max),
            );
            ranges.push(format!("{} {least} to {most}", load.name));
            if least == most {
                constant.push(load.name.clone());
            }
        }
        let verdict = if constant.len() == ranges.len() && cases.len() > 1 {
            Verdict::Doubtful
        } else {
            Verdict::Plausible
        };
        self.add(
            "load cases",
            format!("{}: {}", cases.len(), ranges.join(", ")),
            verdict,
            "all cases have the same loads",
        );
    }

    fn readings(&mut self, loaded: &LoadedStudy) {
        let to = &loaded.measurement;
        let marks: usize = to.parts.iter().map(|part| part.marks.len()).sum();
        if marks > 0 {
            let read: usize = to.cases.iter().map(|case| case.marks.len()).sum();
            self.counted(
                "marks",
                format!("{marks} on {}", counted(to.parts.len(), "part")),
                read,
                marks * to.cases.len(),
            );
        }
        if to.wheel.is_some()
            && loaded
                .study
                .wheel
                .as_ref()
                .is_some_and(|(_, table)| table.is_some())
        {
            let read = to.cases.iter().filter(|case| case.wheel.is_some()).count();
            self.counted("wheel", String::new(), read, to.cases.len());
        }
        let by_case = |(_, c): &(usize, &admire_study::Channel)| c.is_read_by_case();
        let channels = to.channels.iter().enumerate().filter(by_case);
        let channels: Vec<usize> = channels.map(|(k, _)| k).collect();
        if !channels.is_empty() {
            let read: usize = to
                .cases
                .iter()
                .map(|case| {
                    channels
                        .iter()
                        .filter(|k| case.channels[**k].is_some())
                        .count()
                })
                .sum();
            self.counted(
                "channels",
                format!("{}", channels.len()),
                read,
                channels.len() * to.cases.len(),
            );
        }
    }

    /// Checks summary channels (gradients and loop widths). Each of them has a single reading, derived from several cases.
    fn summaries(&mut self, loaded: &LoadedStudy) {
        let to = &loaded.measurement;
        let (mut told, mut missing) = (Vec::new(), 0);
        for (k, channel) in to.channels.iter().enumerate() {
            if channel.summary.is_none() {
                continue;
            }
            let value = to.cases.iter().find_map(|case| case.channels[k]);
            missing += usize::from(value.is_none());
            let value = value.map_or_else(|| "no value".to_string(), short);
            let (unit, sigma) = (channel.behind(), short(channel.sigma));
            told.push(format!("{} {value}{unit} (sd {sigma})", channel.name));
        }
        if told.is_empty() {
            return;
        }
        let verdict = if missing > 0 {
            Verdict::Doubtful
        } else {
            Verdict::Plausible
        };
        self.add(
            "gradients, widths",
            told.join("; "),
            verdict,
            "rows without a value are not used",
        );
    }

    /// Adds a line with the number of readings, compared with the number of possible readings.
    fn counted(&mut self, what: &'static str, of: String, read: usize, full: usize) {
        let verdict = if 2 * read < full {
            Verdict::Doubtful
        } else {
            Verdict::Plausible
        };
        let of = if of.is_empty() { of } else { format!("{of}, ") };
        let text = if read == full {
            format!("{of}{read} readings, none missing")
        } else {
            format!("{of}{read} readings, {} missing", full - read)
        };
        self.add(
            what,
            text,
            verdict,
            "more than half of the readings are missing",
        );
    }

    fn units(&mut self, loaded: &LoadedStudy) {
        let units = &loaded.model.units;
        let mut found = format!(
            "{}, {}, {}, {}",
            short_unit(units.force.word),
            units.mass.word,
            units.length.word,
            units.time.word
        );
        let mut verdict = Verdict::Plausible;
        let mut why = String::new();
        if !units.stated {
            found += " (not stated)";
            verdict = Verdict::Doubtful;
            why = "the deck has no UNITS statement; these units are assumed".to_string();
        }
        if let Some(complaint) = implausible_units(&loaded.dataset, &loaded.model) {
            verdict = Verdict::Doubtful;
            why = complaint.message;
        }
        self.add("units", found, verdict, why);
    }

    fn sizes(&mut self, loaded: &LoadedStudy) {
        let (model, units) = (&loaded.model, &loaded.model.units);
        let design: Vec<Vec3> = model
            .markers
            .iter()
            .filter(|marker| !marker.floating)
            .filter(|marker| model.parts[marker.part.0].kind != PartKind::Ground)
            .map(|marker| model.parts[marker.part.0].pose.point(&marker.qp))
            .collect();
        let size = diagonal(&design);
        let factor = if units.stated { units.length.si } else { 1e-3 };
        let judge = |value: f64, (least, most): (f64, f64)| {
            if value < least || value > most {
                Verdict::Doubtful
            } else {
                Verdict::Plausible
            }
        };
        self.add(
            "mechanism",
            format!("{} {} across", short(size), units.length.word),
            judge(size * factor, SIZE),
            "no axle has this size: is the length unit right?",
        );
        let mass: f64 = model
            .parts
            .iter()
            .filter(|part| part.kind != PartKind::Ground)
            .map(|part| part.mass)
            .sum();
        if mass > 0.0 {
            let kilograms = mass * if units.stated { units.mass.si } else { 1.0 };
            self.add(
                "moving mass",
                format!("{} {}", short(mass), units.mass.word),
                judge(kilograms, MASS),
                "no axle has this mass: is the mass unit right?",
            );
        }
        let of_deck: Vec<f64> = model
            .bushings
            .iter()
            .flat_map(|bushing| bushing.k)
            .filter(|k| *k > 0.0)
            .collect();
        if let (Some(least), Some(most)) = (least(&of_deck), most(&of_deck)) {
            let si = if units.stated {
                units.force.si / units.length.si
            } else {
                1e3
            };
            let verdict = judge(least * si, STIFFNESS).max(judge(most * si, STIFFNESS));
            self.add(
                "bushings",
                format!(
                    "{} to {} {}/{}",
                    short(least),
                    short(most),
                    short_unit(units.force.word),
                    units.length.word
                ),
                verdict,
                "no rubber bushing is so soft or so stiff: are force and length in these units?",
            );
        }
    }

    fn noise(&mut self, loaded: &LoadedStudy) {
        let to = &loaded.measurement;
        let length = loaded.model.units.length.word;
        if to.parts.is_empty() {
            return;
        }
        let shown = rigidity(loaded);
        let repeats = repeats(loaded);
        let stated = if to.sigma_estimated {
            format!("{} {length}, estimated from the marks", short(to.sigma))
        } else {
            format!("{} {length} stated", short(to.sigma))
        };
        let mut found = stated;
        if let Some(shown) = shown {
            found += &format!("; on rigid parts {} {length}", short(shown));
        }
        if let Some((repeats, count)) = repeats {
            let pairs = if count == 1 { "pair" } else { "pairs" };
            found += &format!(
                "; in repeated cases {} {length} ({count} {pairs})",
                short(repeats)
            );
        }
        let ratio = shown
            .filter(|_| !to.sigma_estimated && to.sigma > 0.0)
            .map_or(1.0, |shown| shown / to.sigma);
        let (verdict, why) = if ratio > NOISE_IMPOSSIBLE {
            (
                Verdict::Impossible,
                format!(
                    "the marks scatter {ratio:.0} times as much as marks.sigma states: correct the key or remove it"
                ),
            )
        } else if ratio > NOISE_DOUBTFUL {
            (
                Verdict::Doubtful,
                format!(
                    "the marks scatter {ratio:.1} times as much as marks.sigma states: correct the key or remove it"
                ),
            )
        } else if ratio < 1.0 / NOISE_DOUBTFUL && to.sigma > 1e-3 {
            (
                Verdict::Doubtful,
                "the marks scatter less than half as much as marks.sigma states: correct the key or remove it".to_string(),
            )
        } else {
            (Verdict::Plausible, String::new())
        };
        self.add("noise of a mark", found, verdict, why);
    }

    fn movement(&mut self, loaded: &LoadedStudy) {
        let to = &loaded.measurement;
        let mut largest: f64 = 0.0;
        for (part, marked) in to.parts.iter().enumerate() {
            for mark in 0..marked.marks.len() {
                let all: Vec<Vec3> = to
                    .cases
                    .iter()
                    .flat_map(|case| &case.marks)
                    .filter(|read| (read.part, read.mark) == (part, mark))
                    .map(|read| read.x)
                    .collect();
                largest = largest.max(diagonal(&all));
            }
        }
        if to.parts.is_empty() || to.cases.len() < 2 {
            return;
        }
        let times = if to.sigma > 0.0 {
            format!(", {:.0} times the noise", largest / to.sigma)
        } else {
            String::new()
        };
        let verdict = if largest < MOVED * to.sigma {
            Verdict::Doubtful
        } else {
            Verdict::Plausible
        };
        self.add(
            "largest movement",
            format!(
                "{} {}{times}",
                short(largest),
                loaded.model.units.length.word
            ),
            verdict,
            "no mark moves clearly more than its noise: do the readings belong to these load cases?",
        );
    }

    /// Lists the zero-stiffness motions of the deck, along which no reading is compared.
    fn free_motions(&mut self, loaded: &LoadedStudy) {
        let sentences = loaded.free.sentences();
        if !sentences.is_empty() {
            self.add("free motions", sentences.join("\n"), Verdict::Plausible, "");
        }
    }

    /// Forecasts how well each unknown will be determined if the start values are true, and reports discrepancies between the start values
    /// and the readings. If `is_settled` is set, a slip was found, or a fit explains the readings. The start values are then not used as
    /// evidence against the readings.
    fn forecast(&mut self, loaded: &LoadedStudy, is_settled: bool) {
        let count = loaded.unknowns.len();
        if loaded.study.solver.backend != BackendChoice::Native {
            return;
        }
        let Some(Forecast {
            sd,
            channels,
            odd_frame,
            odd_loads,
        }) = forecast(loaded, is_settled)
        else {
            self.add(
                "forecast",
                "at least one load case has no equilibrium with the start values".to_string(),
                Verdict::Doubtful,
                "set other start values in identify.initial",
            );
            return;
        };
        if let Some((verdict, why)) = odd_frame {
            let found = "marks are not given in the deck's frame".to_string();
            self.add("frame", found, verdict, why);
        }
        if let Some(verdict) = odd_loads.iter().map(|(verdict, _)| *verdict).max() {
            let found = "marks do not follow the table of loads".to_string();
            let why: Vec<String> = odd_loads.into_iter().map(|(_, why)| why).collect();
            self.add("loads", found, verdict, why.join("; "));
        }
        if let Some((alike, odd)) = channels {
            let verdict = if odd.is_empty() {
                Verdict::Plausible
            } else {
                Verdict::Doubtful
            };
            let found = format!(
                "channels that move as the model does: {alike} of {}",
                loaded.measurement.channels.len()
            );
            self.add("agreement", found, verdict, odd.join("; "));
        }
        if count == 0 {
            return;
        }
        let open: Vec<String> = sd
            .iter()
            .zip(&loaded.unknowns)
            .filter(|(sd, _)| **sd > UNIDENTIFIABLE_LN_SD)
            .map(|(_, unknown)| unknown.address.to_string())
            .collect();
        let mut found = format!(
            "{} of {count} parameters can be identified",
            count - open.len()
        );
        if !open.is_empty() {
            let shown = open[..open.len().min(6)].join(", ");
            let more = if open.len() > 6 {
                format!(" and {} more", open.len() - 6)
            } else {
                String::new()
            };
            found += &format!("; not identifiable: {shown}{more}");
        }
        let verdict = if open.len() == count {
            Verdict::Doubtful
        } else {
            Verdict::Plausible
        };
        self.add(
            "forecast",
            found,
            verdict,
            "at the start values, the readings determine none of the parameters",
        );
    }
}

/// Results of the forecast at the start values.
struct Forecast {
    /// Posterior standard deviation of ln K of each unknown, linearised at the start values.
    sd: Vec<f64>,
    /// Number of channels that follow the model, and sentences about the suspicious channels. `None` without channels.
    channels: Option<(usize, Vec<String>)>,
    /// Verdict and sentence, if all marks are offset by a common rigid motion.
    odd_frame: Option<(Verdict, String)>,
    /// Findings about the loads, derived from the motions of the marks.
    odd_loads: Vec<(Verdict, String)>,
}

/// Computes the forecast. Returns `None` if a load case has no equilibrium at the start values.
fn forecast(loaded: &LoadedStudy, is_settled: bool) -> Option<Forecast> {
    let problem = loaded.problem();
    let prepared = Prepared::new(&problem).ok()?;
    let cases: Vec<usize> = problem.measurement.fitted_cases().collect();
    let observations = Observations::new(problem.measurement, problem.model, &cases);
    let unknowns = fit_unknowns(&problem, &prepared.system, None);
    let predictor = prepared
        .native(&problem, observations.observed.clone())
        .ok()?;
    let mut global = global_problem(&problem, observations, unknowns, Box::new(predictor));
    let start = global.start();
    let there = global.evaluate(&start, !loaded.unknowns.is_empty())?;
    let rows = &global.observations.rows;
    let channels = agreement(loaded, rows, there.residual.as_slice());
    let predicted = global.observations.predicted(&there.residual);
    let odd_frame = odd_frame(loaded, &predicted).filter(|_| !is_settled);
    // Loads can be compared only if the marks are in the deck's frame.
    let odd_loads = if odd_frame.is_none() {
        let predicted = (!is_settled).then_some(predicted.as_slice());
        odd_loads(loaded, predicted)
    } else {
        Vec::new()
    };
    if loaded.unknowns.is_empty() {
        return Some(Forecast {
            sd: Vec::new(),
            channels,
            odd_frame,
            odd_loads,
        });
    }
    // In units of the prior standard deviations, the prior information is the identity.
    let sd: Vec<f64> = global
        .priors()
        .iter()
        .map(|prior| if prior.sd.is_finite() { prior.sd } else { 1e6 })
        .collect();
    let mut scaled = there.jacobian;
    for (mut column, sd) in scaled.column_iter_mut().zip(&sd) {
        column *= *sd;
    }
    let information = scaled.transpose() * &scaled + DMatrix::identity(sd.len(), sd.len());
    let covariance = nalgebra::Cholesky::new(information)?.inverse();
    let of = |k: usize| covariance[(k, k)].sqrt() * sd[k];
    Some(Forecast {
        sd: (0..loaded.unknowns.len()).map(of).collect(),
        channels,
        odd_frame,
        odd_loads,
    })
}

/// Returns the length of the diagonal of the points' bounding box.
fn diagonal(points: &[Vec3]) -> f64 {
    let Some(first) = points.first() else {
        return 0.0;
    };
    let (mut least, mut most) = (*first, *first);
    for point in points {
        least = least.inf(point);
        most = most.sup(point);
    }
    (most - least).norm()
}

fn least(values: &[f64]) -> Option<f64> {
    values.iter().copied().min_by(f64::total_cmp)
}

fn most(values: &[f64]) -> Option<f64> {
    values.iter().copied().max_by(f64::total_cmp)
}

/// Formats a number with three significant digits.
fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let digits = 2 - libm::log10(value.abs()).floor() as i32;
    if (-3..=6).contains(&digits) {
        format!("{value:.*}", digits.max(0) as usize)
    } else {
        format!("{value:.2e}")
    }
}
