//! The virtual test rig. It produces a study folder with the readings that a rig would take on the deck with planted effects.

use std::path::{Path, PathBuf};

use super::effect::{GroundTruth, HistoryState, Marked, plant};
use super::readings::Readings;
use super::rest::{Rest, place};
use super::rig_options::RigOptions;
use super::spin::spun;
use super::study_folder;
use admire_session::backend::{CaseSweeper, FreeMotions, Loads, compile, slot, tight_settings};
use admire_solver::mechanics::{Pose, RelativeMotion, Vec3};
use admire_solver::model::Model;
use admire_solver::system::Scratch;
use admire_study::{Measurement, Noise, Study, Table, programme, resolve, with_channels};
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::text::Source;
use admire_syntax::{Address, Dataset};

/// Result of a virtual rig run.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct RigRun {
    /// Files of the new study folder, as pairs of path relative to the folder and contents.
    pub files: Vec<(PathBuf, Vec<u8>)>,
    /// Text that lists the planted effects, one per line. It is not part of the study folder.
    pub truth: String,
}

/// Simulates the measurement of the deck of a study with the given options. The files of readings that the study names need not exist.
///
/// # Errors
/// Returns the errors of the study and of the effects, and errors for load cases in which the changed deck has no equilibrium.
pub fn virtual_rig(folder: &Path, options: &RigOptions) -> Result<RigRun, Vec<Diagnostic>> {
    virtual_rig_watched(folder, options, &mut |_, _| {})
}

/// Simulates the measurement of the deck of a study as [`virtual_rig`] does. After each load case, calls `progress` with the number of cases
/// solved so far and the total number.
///
/// # Errors
/// See [`virtual_rig`].
pub fn virtual_rig_watched(
    folder: &Path,
    options: &RigOptions,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<RigRun, Vec<Diagnostic>> {
    let mut checked = Study::read(folder);
    // The rig produces the readings, so missing readings in the study are no error.
    let matters = |diagnostic: &Diagnostic| {
        diagnostic.severity == Severity::Error
            && !matches!(
                diagnostic.code,
                Code::CannotRead | Code::MissingColumn | Code::MissingMarks
            )
    };
    // The study must list the positions of the marks on the parts, because the rig cannot produce them.
    let complete = |study: &mut Study| study.marks.is_some() || !says_marks(study);
    let Some(mut study) = checked.value.take_if(complete) else {
        return Err(checked.diagnostics);
    };
    let mut out: Vec<Diagnostic> = checked.diagnostics;
    if let Some(table) = options.programme {
        let source = Source::new(
            study.loads.source.name().to_string(),
            table.csv().into_bytes(),
        );
        study.loads = Table::read(source, &mut out);
    }
    let dataset = Dataset::parse(study.deck.clone()).value;
    let lowered = Model::lower(&dataset);
    out.extend(lowered.diagnostics);
    let mut measured = resolve::measurement(&study, &lowered.value, &mut out);
    let programme = programme(&study, &dataset, &measured, &mut out);
    if out.iter().any(matters) {
        out.retain(matters);
        return Err(out);
    }
    if let Some(sigma) = options.sigma {
        measured.sigma = sigma;
    } else if measured.sigma_estimated {
        measured.sigma = 0.05;
    }
    // Channels without a declared noise get the noise of a typical rig: 0.005 deg for angles, 0.05 mm for lengths.
    for channel in measured.channels.iter_mut().filter(|c| c.sigma_estimated) {
        match channel.unit.as_deref() {
            Some("deg") => channel.sigma = 0.005,
            Some(unit) if unit == lowered.value.units.length.word => {
                channel.sigma = 5e-5 / lowered.value.units.length.si;
            }
            _ => {}
        }
    }
    if let Some(sigma) = options.sigma_on_parts {
        measured.sigma_on_parts = sigma;
    }
    let mut reality = GroundTruth {
        dataset,
        programme,
        memories: Vec::new(),
        faults: Vec::new(),
        marks: measured
            .parts
            .iter()
            .map(|part| Marked {
                name: part.name.clone(),
                id: part.id,
                labels: part.marks.iter().map(|mark| mark.label.clone()).collect(),
                places: part.marks.iter().map(|mark| mark.p).collect(),
                carriers: vec![part.id; part.marks.len()],
            })
            .collect(),
        channels: measured
            .channels
            .iter()
            .map(|channel| channel.name.clone())
            .collect(),
    };
    // The free motions are those of the unchanged deck, whatever effects are planted.
    let free = compile(&lowered.value).ok().and_then(|system| {
        let loads = Loads::of(&system, &reality.programme).ok()?;
        Some(FreeMotions::new(
            &reality.dataset,
            &lowered.value,
            &system,
            loads,
        ))
    });
    let free = free.unwrap_or_default();
    // Tolerances and outliers are drawn for the unchanged deck, so they do not depend on the planted effects.
    let tolerances = options.tolerances.drawn(options.seed, &reality);
    let tolerances = tolerances.map_err(|why| vec![why])?;
    let outliers = options.scatter.drawn(options.seed, &reality);
    let outliers = outliers.map_err(|why| vec![why])?;
    for spec in tolerances.iter().chain(&options.effects).chain(&outliers) {
        plant(spec, &mut reality).map_err(|why| vec![why])?;
    }
    // Repeatability errors are added after the planted errors of the loads.
    options
        .tolerances
        .scatter(options.seed, &mut reality.programme);
    let rest = at_rest(&reality, &measured, (&free, options.seed), progress)?;
    let exact = options.sigma == Some(0.0);
    let read = Readings::new(&measured, &reality, &rest, options, exact);
    let mut truth = String::new();
    for spec in options.effects.iter().chain(&outliers) {
        truth += &spec.text;
        truth.push('\n');
    }
    let told = options.tolerances.to_text();
    if !told.is_empty() {
        truth += &format!("# tolerances: {told}\n");
        for spec in &tolerances {
            truth += &format!("{}\n", spec.text);
        }
    }
    Ok(RigRun {
        files: study_folder::files(&study, &measured, &read, options),
        truth,
    })
}

/// Solves the equilibria of all load cases in order. After each case, the states of history-dependent effects are updated.
fn at_rest(
    reality: &GroundTruth,
    measured: &Measurement,
    (free, seed): (&FreeMotions, u64),
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Vec<Rest>, Vec<Diagnostic>> {
    let (model, channels) =
        with_channels(&reality.model(), measured, &[]).map_err(|why| vec![why])?;
    let refuse =
        |code, error: &dyn std::fmt::Display| vec![Diagnostic::error(code, error.to_string())];
    let system = compile(&model).map_err(|error| refuse(Code::BadEffect, &error))?;
    let unknown = |error| refuse(Code::UnknownTarget, &error);
    let loads = Loads::of(&system, &reality.programme).map_err(unknown)?;
    let mut sweeper = CaseSweeper::new(&system, loads, tight_settings(&system));
    let mut parameters = system.parameters();
    for weight in free.held_weights(&system) {
        weight.hold(&mut parameters);
    }
    let mut memories = Vec::new();
    for memory in &reality.memories {
        let held = memory
            .law
            .before(displacement(&model, &system.state().poses, memory));
        let mut slots = Vec::new();
        for id in &memory.variables {
            let address = Address {
                kind: "VARIABLE".to_string(),
                id: Some(*id),
                argument: None,
                index: None,
            };
            slots.push(slot(&system, &address).map_err(unknown)?);
        }
        memories.push((memory, slots, held));
    }
    let mut scratch = Scratch::new(&system);
    let mut spins = Noise::new(seed, "spins");
    let metre = 1.0 / model.units.length.si;
    let mut out = Vec::new();
    for (number, case) in reality.programme.cases.iter().enumerate() {
        sweeper.load(number, &mut parameters);
        for (_, slots, held) in &memories {
            for (slot, value) in slots.iter().zip(held) {
                parameters.set(*slot, *value);
            }
        }
        let solved = sweeper.solve(&system, &parameters, number, None);
        let state = solved.map_err(|error| {
            let message = format!(
                "the virtual rig finds no equilibrium in load case {}: {error}",
                case.label
            );
            vec![Diagnostic::error(Code::UnreachableCase, message)]
        })?;
        let equilibrium = state;
        let state = spun(
            &system,
            &parameters,
            &mut sweeper,
            number,
            &equilibrium,
            metre,
            &mut spins,
        );
        for (memory, _, held) in &mut memories {
            *held = memory
                .law
                .after(held, displacement(&model, &state.poses, memory));
        }
        let values = channels.values(&system, &parameters, &state, &mut scratch);
        out.push(Rest {
            poses: state.poses.clone(),
            channels: values.map_err(|error| refuse(Code::UnreachableCase, &error))?,
        });
        sweeper.keep(number, equilibrium);
        progress(out.len(), reality.programme.cases.len());
    }
    Ok(out)
}

fn displacement(model: &Model, poses: &[Pose], memory: &HistoryState) -> f64 {
    let [i, j] = memory.markers.map(|id| {
        let marker = model
            .marker(id)
            .expect("an effect remembers markers of the deck");
        place(model, poses, marker)
    });
    let motion = RelativeMotion::between(&i, &j, &Vec3::zeros());
    match memory.component {
        k @ 0..3 => motion.p_ij_j[k],
        k => motion.angles[k - 3],
    }
}

/// Returns true if `study.toml` contains a `[marks]` section, even if its files cannot be read.
fn says_marks(study: &Study) -> bool {
    String::from_utf8_lossy(study.source.bytes())
        .lines()
        .any(|line| line.trim_start().starts_with("[marks]"))
}
