//! The virtual test rig: a study folder whose readings are what a rig would read on the deck, with effects planted.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::effect::{EffectSpec, Memory, Reality, ReadingFault, plant};
use super::load::programme;
use super::measurement::Measurement;
use super::noise::Noise;
use super::study::Study;
use super::wheel::WheelReading;
use super::{resolve, section};
use crate::backend::{compile, slot, tight_settings};
use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::mechanics::{Pose, RelativeMotion, Vec3};
use crate::model::{Function, Header, MarkerIx, Model, Request, RequestKind};
use crate::statics::Solver;
use crate::syntax::{Address, Dataset, Expression};
use crate::system::{Parameters, Scratch, State, System};

/// What the rig is asked to do.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct RigOptions {
    /// Seed of the noise.
    pub seed: u64,
    /// Sd of a mark coordinate instead of the study's; zero makes every reading exact.
    pub sigma: Option<f64>,
    /// Effects to plant.
    pub effects: Vec<EffectSpec>,
}

/// What the rig hands over.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct RigRun {
    /// Files of the new study folder, relative to it.
    pub files: Vec<(PathBuf, Vec<u8>)>,
    /// What was planted, one effect per line: for `--truth` only.
    pub truth: String,
}

/// Measures the deck of a study. The study's own readings need not exist.
///
/// # Errors
/// Whatever stands in the way: of the study, of an effect, or a load case the reality has no equilibrium for.
pub fn virtual_rig(folder: &Path, options: &RigOptions) -> Result<RigRun, Vec<Diagnostic>> {
    let checked = Study::read(folder);
    // Readings are what the rig makes: those that are missing do not matter.
    let matters = |diagnostic: &Diagnostic| {
        diagnostic.severity == Severity::Error
            && !matches!(diagnostic.code, Code::CannotRead | Code::MissingColumn | Code::MissingMarks)
    };
    let Some(study) = checked.value else {
        return Err(checked.diagnostics);
    };
    let mut out: Vec<Diagnostic> = checked.diagnostics;
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
    let mut reality = Reality {
        dataset,
        programme,
        memories: Vec::new(),
        faults: Vec::new(),
        marks: measured
            .parts
            .iter()
            .map(|part| {
                let labels = part.marks.iter().map(|mark| mark.label.clone());
                (part.name.clone(), part.id, labels.collect())
            })
            .collect(),
        channels: measured.channels.iter().map(|channel| channel.name.clone()).collect(),
    };
    for spec in &options.effects {
        plant(spec, &mut reality).map_err(|why| vec![why])?;
    }
    let rest = at_rest(&reality, &measured)?;
    let exact = options.sigma == Some(0.0);
    let read = Readings::new(&measured, &reality, &rest, options.seed, exact);
    let mut truth = String::new();
    for spec in &options.effects {
        truth += &spec.text;
        truth.push('\n');
    }
    Ok(RigRun {
        files: files(&study, &measured, &read, options),
        truth,
    })
}

/// Part poses and channel values of one case.
struct Rest {
    poses: Vec<Pose>,
    channels: Vec<f64>,
}

/// Applies the loads one after the other and lets what remembers the path remember it.
fn at_rest(reality: &Reality, measured: &Measurement) -> Result<Vec<Rest>, Vec<Diagnostic>> {
    let model = with_requests(reality.model(), measured).map_err(|why| vec![why])?;
    let refuse = |code, error: &dyn std::fmt::Display| vec![Diagnostic::error(code, error.to_string())];
    let system = compile(&model).map_err(|error| refuse(Code::BadEffect, &error))?;
    let slot_of = |address: &Address| slot(&system, address).map_err(|error| refuse(Code::UnknownTarget, &error));
    let mut loads = Vec::new();
    for load in &reality.programme.loads {
        loads.push(slot_of(&load.target)?);
    }
    let mut state = system.state();
    let mut parameters = system.parameters();
    let mut memories = Vec::new();
    for memory in &reality.memories {
        let start = displacement(&model, &state.poses, memory);
        let mut held = vec![start, 0.0];
        held.truncate(memory.variables.len());
        let mut slots = Vec::new();
        for id in &memory.variables {
            let address = Address {
                kind: "VARIABLE".to_string(),
                id: Some(*id),
                argument: None,
                index: None,
            };
            slots.push(slot_of(&address)?);
        }
        memories.push((memory, slots, held));
    }
    let settings = tight_settings(&system);
    let mut solver = Solver::new(&system);
    let mut scratch = Scratch::new(&system);
    let mut out = Vec::new();
    for case in &reality.programme.cases {
        for (slot, value) in loads.iter().zip(&case.values) {
            parameters.set(*slot, *value);
        }
        for (_, slots, held) in &memories {
            for (slot, value) in slots.iter().zip(held) {
                parameters.set(*slot, *value);
            }
        }
        let mut solved = solver.solve(&system, &parameters, &mut state, &settings);
        if solved.is_err() {
            state = system.state();
            solved = solver.solve(&system, &parameters, &mut state, &settings);
        }
        solved.map_err(|error| {
            let message = format!("the rig finds no equilibrium in load case {}: {error}", case.label);
            vec![Diagnostic::error(Code::UnreachableCase, message)]
        })?;
        for (memory, _, held) in &mut memories {
            *held = memory.after(held, displacement(&model, &state.poses, memory));
        }
        let channels = channel_values(&system, &model, &parameters, &state, &mut scratch, measured);
        out.push(Rest {
            poses: state.poses.clone(),
            channels: channels.map_err(|error| refuse(Code::UnreachableCase, &error))?,
        });
    }
    Ok(out)
}

fn place(model: &Model, poses: &[Pose], marker: MarkerIx) -> Pose {
    let frame = &model.markers[marker.0];
    poses[frame.part.0].compose(&Pose {
        p: frame.qp,
        R: frame.R,
    })
}

fn displacement(model: &Model, poses: &[Pose], memory: &Memory) -> f64 {
    let [i, j] = memory.markers.map(|id| {
        let marker = model.marker(id).expect("an effect remembers markers of the deck");
        place(model, poses, marker)
    });
    let motion = RelativeMotion::between(&i, &j, &Vec3::zeros());
    match memory.component {
        k @ 0..3 => motion.p_ij_j[k],
        k => motion.angles[k - 3],
    }
}

/// One more REQUEST per channel, which evaluates its function.
fn with_requests(mut model: Model, measured: &Measurement) -> Result<Model, Diagnostic> {
    for channel in &measured.channels {
        let mut functions: [Option<Function>; 8] = Default::default();
        functions[1] = Some(Function::Expression(Expression::parse_str(&channel.function)?));
        model.requests.push(Request {
            header: Header {
                id: 0,
                name: channel.name.clone(),
                origin: usize::MAX,
                active: true,
            },
            kind: RequestKind::Functions(Box::new(functions)),
            comment: String::new(),
            component_names: None,
            component_units: Vec::new(),
            results_name: None,
        });
    }
    Ok(model)
}

fn channel_values(
    system: &System,
    model: &Model,
    parameters: &Parameters,
    state: &State,
    scratch: &mut Scratch,
    measured: &Measurement,
) -> Result<Vec<f64>, crate::system::NoValue> {
    let count = measured.channels.len();
    if count == 0 {
        return Ok(Vec::new());
    }
    system.look(parameters, state, scratch)?;
    let first = model.requests.len() - count;
    let mut values = Vec::with_capacity(count);
    for k in 0..count {
        let read = system.read_function((first + k, 1), parameters, state, scratch)?;
        values.push(read.map_or(f64::NAN, |(value, _)| value));
    }
    Ok(values)
}

/// What is read in every case: marks by part and mark, the wheel, the channels; and the marks as the first session lists them.
struct Readings {
    listed: Vec<Vec<Vec3>>,
    marks: Vec<Vec<Vec<Vec3>>>,
    wheel: Vec<Option<WheelReading>>,
    channels: Vec<Vec<f64>>,
}

impl Readings {
    fn new(
        measured: &Measurement,
        reality: &Reality,
        rest: &[Rest],
        seed: u64,
        exact: bool,
    ) -> Self {
        let on = if exact { 0.0 } else { 1.0 };
        let mut first_session = Noise::new(seed, "marks on parts");
        let mut second_session = Noise::new(seed, "marks measured");
        let mut at_wheel = Noise::new(seed, "wheel");
        let mut sensors = Noise::new(seed, "readings");
        let on_parts = measured.sigma_on_parts * on;
        let listed = measured
            .parts
            .iter()
            .map(|part| part.marks.iter().map(|m| m.p + first_session.vector(on_parts)).collect())
            .collect();
        // The wheel marker is the deck's; the reality may hold more markers, never fewer.
        let model = reality.model();
        let (mut marks, mut wheel, mut channels) = (Vec::new(), Vec::new(), Vec::new());
        for (case, at) in rest.iter().enumerate() {
            let mut frame = Pose::identity();
            for fault in &reality.faults {
                if let ReadingFault::Frame { case: of, pose } = fault
                    && *of == case
                {
                    frame = pose.compose(&frame);
                }
            }
            let of_part = |part: &super::MarkedPart| {
                let pose = &at.poses[part.part.0];
                part.marks.iter().map(|m| frame.point(&pose.point(&m.p))).collect::<Vec<_>>()
            };
            let mut seen: Vec<Vec<Vec3>> = measured.parts.iter().map(of_part).collect();
            for x in seen.iter_mut().flatten() {
                *x += second_session.vector(measured.sigma);
            }
            for fault in &reality.faults {
                if let ReadingFault::Mark { case: of, part, mark, shift } = fault
                    && *of == case
                {
                    seen[*part][*mark] += shift;
                }
            }
            marks.push(seen);
            wheel.push(measured.wheel.as_ref().map(|wheel| {
                let mut read = wheel.spin.reading(&place(&model, &at.poses, wheel.marker));
                read.position += at_wheel.vector(wheel.sigma_position * on);
                read.camber_deg += at_wheel.normal() * wheel.sigma_angle_deg * on;
                read.steer_deg += at_wheel.normal() * wheel.sigma_angle_deg * on;
                read
            }));
            let mut values = Vec::new();
            for (k, channel) in measured.channels.iter().enumerate() {
                let before = channel.relative_to.map_or(0.0, |case| rest[case].channels[k]);
                let mut value = at.channels[k] - before + sensors.normal() * channel.sigma * on;
                for fault in &reality.faults {
                    if let ReadingFault::Channel { channel, gain, offset, case: of } = fault
                        && *channel == k
                        && of.is_none_or(|of| of == case)
                    {
                        value = gain * value + offset;
                    }
                }
                values.push(value);
            }
            channels.push(values);
        }
        Self {
            listed,
            marks,
            wheel,
            channels,
        }
    }
}

fn files(
    study: &Study,
    measured: &Measurement,
    read: &Readings,
    options: &RigOptions,
) -> Vec<(PathBuf, Vec<u8>)> {
    let relative = |name: &str| {
        let path = Path::new(name);
        path.strip_prefix(&study.folder).unwrap_or(path).to_path_buf()
    };
    let mut files = vec![
        (relative(study.deck.name()), study.deck.bytes().to_vec()),
        (relative(study.loads.source.name()), study.loads.source.bytes().to_vec()),
    ];
    let mut toml = String::from_utf8_lossy(study.source.bytes()).into_owned();
    if let Some(marks) = &study.marks {
        let mut listed = String::from("part,mark,x,y,z\n");
        for (part, places) in measured.parts.iter().zip(&read.listed) {
            for (mark, p) in part.marks.iter().zip(places) {
                let _ = writeln!(listed, "{},{},{:.9},{:.9},{:.9}", part.name, mark.label, p.x, p.y, p.z);
            }
        }
        let mut seen = String::from("case,part,mark,x,y,z\n");
        for (case, places) in measured.cases.iter().zip(&read.marks) {
            for (part, places) in measured.parts.iter().zip(places) {
                for (mark, x) in part.marks.iter().zip(places) {
                    let _ = writeln!(
                        seen,
                        "{},{},{},{:.9},{:.9},{:.9}",
                        case.label, part.name, mark.label, x.x, x.y, x.z
                    );
                }
            }
        }
        let exact_list = measured.sigma_on_parts == 0.0 || options.sigma == Some(0.0);
        let listed = if exact_list { marks.on_parts.source.bytes().to_vec() } else { listed.into_bytes() };
        files.push((relative(marks.on_parts.source.name()), listed));
        files.push((relative(marks.measured.source.name()), seen.into_bytes()));
        if let (Some(sigma), Some(span)) = (options.sigma, section::number_span(&toml, "marks", "sigma")) {
            toml.replace_range(span.range(), &format!("{sigma:?}"));
        }
    }
    if let Some((_, table)) = &study.wheel {
        let mut seen = String::from("case,x,y,z,camber_deg,steer_deg\n");
        for (case, wheel) in measured.cases.iter().zip(&read.wheel) {
            if let Some(wheel) = wheel {
                let p = wheel.position;
                let _ = writeln!(
                    seen,
                    "{},{:.9},{:.9},{:.9},{:.9},{:.9}",
                    case.label, p.x, p.y, p.z, wheel.camber_deg, wheel.steer_deg
                );
            }
        }
        let name = table.as_ref().map(|table| relative(table.source.name()));
        if name.is_none() {
            toml = toml.replacen("[wheel]", "[wheel]\nmeasured = \"wheel.csv\"", 1);
        }
        files.push((name.unwrap_or_else(|| PathBuf::from("wheel.csv")), seen.into_bytes()));
    }
    if let Some((table, _)) = &study.readings {
        let mut seen = String::from("case");
        for channel in &measured.channels {
            let _ = write!(seen, ",{}", channel.name);
        }
        seen.push('\n');
        for (case, values) in measured.cases.iter().zip(&read.channels) {
            seen += &case.label;
            for value in values {
                let _ = write!(seen, ",{value:.9e}");
            }
            seen.push('\n');
        }
        files.push((relative(table.source.name()), seen.into_bytes()));
    }
    files.push((PathBuf::from("study.toml"), without_section(&toml, "reference").into_bytes()));
    files
}

/// A reference deck says what another reality was: the new study has none.
fn without_section(toml: &str, name: &str) -> String {
    let header = format!("[{name}]");
    let mut keep = true;
    let mut out = String::with_capacity(toml.len());
    for line in toml.split_inclusive('\n') {
        let start = line.trim_start();
        if start.starts_with('[') {
            keep = !start.starts_with(&header);
        }
        if keep {
            out += line;
        }
    }
    out
}
