//! One blind study: planned, measured and diagnosed.

use std::path::Path;

use admire_diagnosis::{Diagnosis, GainCheck, Progress, diagnose_watched, held_out};
use admire_identify::LoadedStudy;
use admire_rig::effect::EffectSpec;
use admire_rig::{RigOptions, RigRun, Tolerances, virtual_rig};
use admire_session::backend::{Backend, Load, NativeBackend, SweepRequest};
use admire_solver::mechanics::{Pose, RelativeMotion, Vec3};
use admire_solver::model::{MarkerIx, Model};

use nalgebra::DVector;

use super::axle::{Truth, truth};
use super::detect::{Span, left_by_a_fit};
use super::draw::{Kind, Plan, Ranges, plants};
use super::sized::Plant;
use super::usual_errors::usual_errors;

/// Maximum number of attempts to draw a location.
const ATTEMPTS: u64 = 6;

/// A planted effect, revealed after the diagnosis.
#[derive(Clone, Debug)]
pub struct Planted {
    /// Planted effect, see [`Plant`].
    pub plant: Plant,
    /// Specification given to the rig.
    pub spec: String,
    /// Chi-square of the shift against noise and usual errors, outside of the span of stiffnesses and nuisances.
    pub seen: f64,
    /// Root mean square of the shift outside of this span per reading, in units of the noise.
    pub rms: f64,
}

/// A study with its diagnosis and its truth.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Plan of the seed.
    pub plan: Plan,
    /// Planted effects.
    pub planted: Vec<Planted>,
    /// The diagnosis; `None` if there was none.
    pub diagnosis: Option<Diagnosis>,
    /// True if the check of the readings rejected them before any fit, because they fit no rigid parts.
    pub spoilt: bool,
    /// Number of hypotheses tried.
    pub places: usize,
    /// Duration of the diagnosis, in seconds.
    pub seconds: f64,
}

/// Draws, measures and diagnoses the study of a plan. If `KEEP_STUDIES` is set, the study folder is kept below it for inspection.
pub fn run(plan: Plan) -> Trial {
    let truth = truth(
        plan.axle,
        plan.seed,
        plan.sigma,
        plan.programme,
        plan.instruments,
    );
    let mut trial = Trial {
        plan,
        planted: Vec::new(),
        diagnosis: None,
        spoilt: false,
        places: 0,
        seconds: 0.0,
    };
    plant(&mut trial, &truth);
    let folder = tempfile::tempdir().expect("a folder for the study");
    hand_over(&trial, &truth, folder.path());
    if let Some(kept) = std::env::var_os("KEEP_STUDIES") {
        let name = format!("{:?}-{}", trial.plan.kind, trial.plan.seed).to_lowercase();
        let kept = Path::new(&kept).join(name);
        std::fs::create_dir_all(&kept).expect("a folder to keep the study in");
        hand_over(&trial, &truth, &kept);
    }
    let loaded = LoadedStudy::read(folder.path());
    trial.spoilt = loaded
        .diagnostics
        .iter()
        .any(|d| d.code.as_str() == "inconsistent-marks");
    let Some(loaded) = loaded.value else {
        return trial;
    };
    // If the check of the readings already shows exchanged marks, no diagnosis of the model follows.
    if trial.spoilt && trial.plan.kind == Kind::Outside {
        return trial;
    }
    let problem = loaded.problem();
    let started = std::time::Instant::now();
    let held = held_out(&loaded.study, &loaded.measurement);
    let found = diagnose_watched(&problem, held, GainCheck::Quick, &Progress::default());
    if let Ok(outcome) = found {
        trial.places = outcome.places;
        trial.diagnosis = Some(outcome.diagnosis);
    }
    trial.seconds = started.elapsed().as_secs_f64();
    trial
}

/// Writes the study folder of a trial: the output of the rig, with the user's deck.
pub fn hand_over(trial: &Trial, truth: &Truth, to: &Path) {
    let specs: Vec<&str> = trial.planted.iter().map(|p| p.spec.as_str()).collect();
    let run = measure(truth, &trial.plan, &specs, None).expect("measured before");
    write(&run, to);
    std::fs::write(to.join("model.adm"), &truth.nominal).expect("written");
}

fn write(run: &RigRun, to: &Path) {
    for (name, bytes) in &run.files {
        std::fs::write(to.join(name), bytes).expect("written");
    }
}

fn measure(truth: &Truth, plan: &Plan, specs: &[&str], sigma: Option<f64>) -> Option<RigRun> {
    let effects = specs.iter().map(|text| EffectSpec::parse(text));
    let options = RigOptions {
        seed: plan.seed,
        sigma,
        effects: effects.collect::<Result<_, _>>().expect("an effect"),
        sigma_on_parts: plan.background.then_some(0.02),
        tolerances: if plan.background {
            // Parts made to 0.1 mm and loads read to 0.3 percent.
            Tolerances {
                parts: 0.1,
                load_gain: 0.003,
                ..Tolerances::default()
            }
        } else {
            Tolerances::default()
        },
        ..RigOptions::default()
    };
    let unreachable = |why: &[admire_syntax::diagnostic::Diagnostic]| {
        let only = why.iter().all(|d| d.code.as_str() == "unreachable-case");
        assert!(only, "{specs:?} of seed {}: {why:#?}", plan.seed);
    };
    virtual_rig(truth.folder.path(), &options)
        .map_err(|why| unreachable(&why))
        .ok()
}

/// Returns the study without planted effects.
fn honest(truth: &Truth, plan: &Plan) -> LoadedStudy {
    let run = measure(truth, plan, &[], None).expect("in balance without any effect");
    let folder = tempfile::tempdir().expect("a folder");
    write(&run, folder.path());
    LoadedStudy::read(folder.path())
        .value
        .expect("a whole study")
}

/// Returns the exact readings with these effects, case by case: marks, wheel, channels.
///
/// They are read from the files, because a study without noise looks copied if the same loads occur twice.
fn exact(truth: &Truth, plan: &Plan, specs: &[&str]) -> Option<DVector<f64>> {
    let run = measure(truth, plan, specs, Some(0.0))?;
    let rows = |name: &str, first: usize| {
        let file = run.files.iter().find(|(path, _)| path == Path::new(name));
        let text = file.map_or("", |(_, bytes)| std::str::from_utf8(bytes).expect("text"));
        let row = move |line: &str| {
            let mut words = line.split(',');
            let case = words.next().unwrap_or_default().to_string();
            let numbers = words.skip(first - 1).map(|x| x.parse().expect("a number"));
            (case, numbers.collect::<Vec<f64>>())
        };
        text.lines().skip(1).map(row).collect::<Vec<_>>()
    };
    let files = [
        rows("marks_measured.csv", 3),
        rows("wheel.csv", 1),
        rows("readings.csv", 1),
    ];
    let mut cases: Vec<&String> = files[0].iter().map(|(case, _)| case).collect();
    cases.dedup();
    let mut out = Vec::new();
    for case in cases {
        for file in &files {
            let of_case = file.iter().filter(|(own, _)| own == case);
            out.extend(of_case.flat_map(|(_, numbers)| numbers));
        }
    }
    Some(DVector::from_vec(out))
}

/// Returns the residual of the best fit of the unmodified model with this effect alone, minus the residual without any effect.
fn left(truth: &Truth, plan: &Plan, spec: &str) -> Option<f64> {
    let calm = Plan {
        background: false,
        ..plan.clone()
    };
    let of = |specs: &[&str]| {
        let run = measure(truth, &calm, specs, Some(0.0))?;
        let folder = tempfile::tempdir().expect("a folder");
        write(&run, folder.path());
        let edit = |name: &str, change: &dyn Fn(&str) -> String| {
            let path = folder.path().join(name);
            let text = std::fs::read_to_string(&path).expect("written just now");
            std::fs::write(&path, change(&text)).expect("written");
        };
        edit("study.toml", &|toml| {
            toml.replace("\nsigma = 0.0001\n", &format!("\nsigma = {}\n", plan.sigma))
        });
        // Repeated loads give identical readings that would look copied; a digit of a millionth of a micrometre makes them differ.
        edit("marks_measured.csv", &|marks| {
            let told = marks
                .lines()
                .enumerate()
                .map(|(k, line)| match line.rsplit_once('.') {
                    Some((front, digits)) if k > 0 => {
                        format!("{front}.{}{:05}\n", &digits[..digits.len().min(7)], k)
                    }
                    _ => line.to_string() + "\n",
                });
            told.collect()
        });
        let study = LoadedStudy::read(folder.path()).value?;
        left_by_a_fit(&study, &truth.values)
    };
    Some((of(&[spec])? - of(&[])?).max(0.0))
}

/// Draws the planted effects and determines their sizes.
fn plant(trial: &mut Trial, truth: &Truth) {
    let plan = &trial.plan;
    let honest = honest(truth, plan);
    let without = exact(truth, plan, &[]).expect("as above");
    let span = Span::new(&honest, &truth.values);
    let ranges = Displacements::new(&honest);
    let marks = honest.measurement.parts.iter().map(|part| {
        let labels = part.marks.iter().map(|mark| mark.label.clone());
        (part.name.clone(), labels.collect())
    });
    let identified = honest
        .problem()
        .bushings()
        .into_iter()
        .map(|b| honest.model.bushings[b].header.id);
    let ranges = Ranges {
        model: &honest.model,
        of: &|pair, axis| ranges.range(|i, j| displacement(i, j, axis), pair),
        length: &|pair| ranges.range(|i, j| (i.p - j.p).norm(), pair),
        marks: marks.collect(),
        identified: identified.collect(),
    };
    let cases: Vec<String> = honest
        .measurement
        .cases
        .iter()
        .map(|case| case.label.clone())
        .collect();
    // If the cause is hardly detectable at the drawn location, another one is drawn, a few times.
    let mut shifts = Vec::new();
    for attempt in 0..ATTEMPTS {
        trial.planted.clear();
        shifts.clear();
        let mut reached = f64::INFINITY;
        for plant in plants(plan, &ranges, &cases, attempt) {
            let own = own_offset(&plant);
            let shift_of = |size: f64| {
                let with = exact(truth, plan, &[&plant.spec(size)])?;
                Some(span.whitened(&(with - &without), &honest.measurement))
            };
            let rms =
                |shift: &DVector<f64>| (span.outside(shift, own, &[]) / span.rows() as f64).sqrt();
            let size = calibrated(plant.wanted, plant.most(), |size| {
                shift_of(size).map(|shift| rms(&shift))
            });
            let size = size.max(plant.least());
            let shift = shift_of(size);
            let found = shift.as_ref().map_or(f64::INFINITY, &rms);
            reached = reached.min(found / plant.wanted);
            trial.planted.push(Planted {
                spec: plant.spec(size),
                plant,
                seen: f64::INFINITY,
                rms: f64::INFINITY,
            });
            shifts.push((shift, own));
        }
        if reached > 0.5 {
            break;
        }
    }
    let mut errors: Option<Vec<DVector<f64>>> = None;
    for k in 0..shifts.len() {
        let others: Vec<_> = shifts
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != k)
            .filter_map(|(_, (shift, _))| shift.clone())
            .collect();
        if let (Some(shift), own) = &shifts[k] {
            let mut seen = span.outside(shift, *own, &others);
            if own.is_none() && seen > 40.0 {
                seen = seen.min(left(truth, plan, &trial.planted[k].spec).unwrap_or(seen));
            }
            trial.planted[k].rms = (seen / span.rows() as f64).sqrt();
            if seen > 40.0 {
                let errors = errors.get_or_insert_with(|| {
                    let shift_of = |spec: &str| {
                        let with = exact(truth, plan, &[spec])?;
                        Some(span.whitened(&(with - &without), &honest.measurement))
                    };
                    usual_errors(&honest.model, &loads(&honest), &span, &shift_of)
                });
                let mut known: Vec<DVector<f64>> = errors.clone();
                // A second effect of any size may explain the first.
                known.extend(others.into_iter().map(|other| other * 1e3));
                seen = seen.min(span.beside_errors(shift, *own, &known));
            }
            trial.planted[k].seen = seen;
        }
    }
}

/// Returns the address of each load of a study with its value in every case.
fn loads(study: &LoadedStudy) -> Vec<(String, Vec<f64>)> {
    let programme = &study.programme;
    let of = |(at, load): (usize, &Load)| {
        let address = &load.target;
        let id = address.id.map_or(String::new(), |id| format!("/{id}"));
        let values = programme.cases.iter().map(|case| case.values[at]);
        (format!("{}{id}", address.kind), values.collect())
    };
    programme.loads.iter().enumerate().map(of).collect()
}

/// Returns the bushing whose offset is the planted effect; all other offsets of identified bushings are nuisances.
fn own_offset(plant: &Plant) -> Option<u32> {
    let id = plant.address.strip_prefix("BUSHING/")?;
    (plant.cause == "assembly-offset")
        .then(|| id.parse().ok())
        .flatten()
}

/// Returns the size whose effect is the wanted one, found by a few secant steps because the effect is nearly proportional to the size.
///
/// If the effect cannot become that large, the largest possible size is returned.
fn calibrated(wanted: f64, most: f64, effect: impl Fn(f64) -> Option<f64>) -> f64 {
    let mut size = 1.0_f64.min(most);
    let mut most = most;
    for _ in 0..6 {
        let Some(reached) = effect(size) else {
            // There is no equilibrium with an effect of this size.
            most = size;
            size *= 0.4;
            continue;
        };
        if reached <= 0.0 {
            size = (size * 4.0).min(most);
            continue;
        }
        let next = (size * (wanted / reached).clamp(0.02, 20.0)).min(0.95 * most);
        if (next / size).ln().abs() < 0.1 {
            break;
        }
        size = next;
    }
    // The last size has not been tried yet.
    while effect(size).is_none() && size > 1e-6 {
        size *= 0.5;
    }
    size
}

/// Part poses of every load case.
struct Displacements {
    model: Model,
    poses: Vec<Vec<Pose>>,
}

impl Displacements {
    fn new(study: &LoadedStudy) -> Self {
        let request = SweepRequest {
            dataset: &study.dataset,
            model: &study.model,
            theta: &[],
            programme: &study.programme,
        };
        let swept = NativeBackend::new().sweep(&request).expect("a sweep");
        let cases = study.programme.cases.len();
        Self {
            model: study.model.clone(),
            poses: (0..cases)
                .filter_map(|case| Some(swept.equilibrium(case)?.poses.clone()))
                .collect(),
        }
    }

    fn range(&self, of: impl Fn(&Pose, &Pose) -> f64, (i, j): (MarkerIx, MarkerIx)) -> (f64, f64) {
        self.poses
            .iter()
            .map(|poses| {
                let place = |marker: MarkerIx| {
                    let frame = &self.model.markers[marker.0];
                    poses[frame.part.0].compose(&Pose {
                        p: frame.qp,
                        R: frame.R,
                    })
                };
                of(&place(i), &place(j))
            })
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), u| {
                (low.min(u), high.max(u))
            })
    }
}

fn displacement(i: &Pose, j: &Pose, axis: usize) -> f64 {
    let motion = RelativeMotion::between(i, j, &Vec3::zeros());
    match axis {
        0..3 => motion.p_ij_j[axis],
        _ => motion.angles[axis - 3],
    }
}

/// Returns the displacement along a joint, or the length of a spring, at the design position.
pub fn at_design(model: &Model, (i, j): (MarkerIx, MarkerIx), joint: bool) -> f64 {
    let place = |marker: MarkerIx| {
        let frame = &model.markers[marker.0];
        model.parts[frame.part.0].pose.compose(&Pose {
            p: frame.qp,
            R: frame.R,
        })
    };
    let (i, j) = (place(i), place(j));
    if joint {
        displacement(&i, &j, 2)
    } else {
        (i.p - j.p).norm()
    }
}
