//! `admire results RUN.res --kc`: characteristics that follow from the positions of wheels alone.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{BufWriter, Write};
use std::path::Path;

use serde_json::json;

use admire_kc::{
    BodyPoint, Convention, Frame, Given, Reading, Replay, ReplayError, ReplayOptions, Road, Tyre,
};
use admire_results::{ResultsError, ResultsReader, Selection, StepFilter, StepKind};
use admire_solver::mechanics::Vec3;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::units::{LENGTH_UNITS, Units};

use super::Outcome;
use super::format::Format;
use super::results_file::{open, refused};
use super::shell::{Exit, Shell, exit_of};

/// Options for the characteristics of wheels.
#[derive(clap::Args, Debug)]
pub(super) struct KcArguments {
    /// Print toe, camber, steer, travel and the other characteristics that follow from the positions of the wheels, under the names of
    /// Adams/Car; see `admire guide kc`. The first step of the file is the design position.
    #[arg(long, requires = "wheel", conflicts_with_all = ["get", "list", "set"])]
    kc: bool,
    /// Wheel part, or part that carries the wheel: at most one for each side.
    #[arg(long, value_name = "PART", requires = "kc", num_args = 1..=2)]
    wheel: Vec<String>,
    /// Axis of the part about which the wheel spins; by default, the axis that lies across the vehicle.
    #[arg(long, value_enum, requires = "kc")]
    spin: Option<Spin>,
    /// Wheel centre in the frame of the part; by default, the part's origin.
    #[arg(long, value_name = "X,Y,Z", requires = "kc", value_parser = place, allow_hyphen_values = true)]
    centre: Option<Vec3>,
    /// Geometric steer axis of each wheel, for caster, kingpin, scrub and trail: its lower and its upper point. Each point is a part and a
    /// position in the frame of the part; without a position, it is the part's origin.
    #[arg(long, value_name = "PART[@X,Y,Z]", requires = "kc", num_args = 2..=4, value_parser = body_point)]
    steer_axis: Vec<BodyPoint>,
    /// Unloaded tyre radius, in the length unit of the file; needed for the contact points.
    #[arg(long, value_name = "LENGTH", requires = "kc", value_parser = positive)]
    radius: Option<f64>,
    /// Vertical tyre stiffness, in the units of the file. The loaded radius follows from the columns `left_tire_forces.normal` and
    /// `right_tire_forces.normal`.
    #[arg(long, value_name = "RATE", requires = "radius", value_parser = positive)]
    tyre_rate: Option<f64>,
    /// Road: `level`; `patches`, the plane through both contact points; or `rig`, level unless the file's own columns show that the rig rolls.
    #[arg(long, value_enum, requires = "kc", default_value_t = RoadChoice::Rig)]
    road: RoadChoice,
    /// Axes of the file.
    #[arg(long, value_enum, requires = "kc", default_value_t = Axes::AdamsCar)]
    axes: Axes,
    /// Axes in which the results are given.
    #[arg(long, value_enum, requires = "kc", default_value_t = Axes::AdamsCar)]
    convention: Axes,
    /// Instead of values, print the largest difference of each characteristic from the file's own column of the same name.
    #[arg(long, requires = "kc")]
    against_file: bool,
}

/// Axis of a part.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Spin {
    X,
    Y,
    Z,
}

/// Named axes of a vehicle.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(super) enum Axes {
    /// X rearward, Y right, Z up.
    AdamsCar,
    /// ISO 8855: X forward, Y left, Z up.
    Iso,
    /// SAE J670: X forward, Y right, Z down.
    Sae,
}

impl From<Axes> for Convention {
    fn from(axes: Axes) -> Self {
        match axes {
            Axes::AdamsCar => Self::AdamsCar,
            Axes::Iso => Self::Iso,
            Axes::Sae => Self::Sae,
        }
    }
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum RoadChoice {
    Level,
    Patches,
    Rig,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("the value is a number above zero".to_string()),
    }
}

fn place(text: &str) -> Result<Vec3, String> {
    let numbers: Option<Vec<f64>> = text
        .split(',')
        .map(|word| word.trim().parse().ok())
        .collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if x.is_finite() && y.is_finite() && z.is_finite() => {
            Ok(Vec3::new(x, y, z))
        }
        _ => Err("write three numbers: X,Y,Z".to_string()),
    }
}

fn body_point(text: &str) -> Result<BodyPoint, String> {
    let (body, local) = match text.split_once('@') {
        Some((body, at)) => (body, place(at)?),
        None => (text, Vec3::zeros()),
    };
    Ok(BodyPoint {
        body: body.to_string(),
        local,
    })
}

impl KcArguments {
    pub(super) fn asked(&self) -> bool {
        self.kc
    }

    fn options(&self) -> ReplayOptions {
        ReplayOptions {
            spin: self.spin.map(|spin| spin as usize),
            centre: self.centre.unwrap_or_else(Vec3::zeros),
            frame: Frame::new(Convention::from(self.axes).axes())
                .expect("named axes are right-handed"),
            tyre: self.radius.map(|radius| Tyre {
                radius,
                stiffness: self.tyre_rate,
            }),
            road: match self.road {
                RoadChoice::Level => Road::Level,
                RoadChoice::Patches => Road::Patches,
                RoadChoice::Rig => Road::Rig,
            },
        }
    }
}

/// Characteristics of one step of the output.
struct Row {
    kind: StepKind,
    time: f64,
    readings: Vec<Reading>,
    /// The file's own value of each reading; `None` if the file has no column of that name.
    own: Vec<Option<f64>>,
}

/// Prints the characteristics in the steps that pass a filter.
pub(super) fn run(
    path: &Path,
    arguments: &KcArguments,
    filter: &StepFilter,
    plain: bool,
    json: bool,
    shell: &Shell,
) -> Outcome {
    let mut reader = open(path, shell)?;
    if arguments.tyre_rate.is_some()
        && Selection::matching(reader.catalogue(), &["*_tire_forces.normal"])
            .0
            .columns
            .is_empty()
    {
        shell.complain(&[Diagnostic::warning(
            Code::UndefinedId,
            "the file has no columns left_tire_forces.normal and right_tire_forces.normal, so --tyre-rate has no effect",
        )]);
    }
    let rows = rows(reader.as_mut(), arguments, filter, shell)?;
    shell.complain(reader.diagnostics());
    let convention = Convention::from(arguments.convention);
    let units = units(reader.as_ref());
    let mut out = BufWriter::new(std::io::stdout().lock());
    let json = json || shell.format == Format::Json;
    let written = if arguments.against_file {
        write!(out, "{}", against(&rows, json, &units))
    } else if json {
        write_json(&mut out, &rows, (convention, &units))
    } else {
        write_csv(&mut out, &rows, (convention, &units), plain)
    };
    shell.printed(written.and_then(|()| out.flush()));
    Ok(exit_of(reader.diagnostics()))
}

/// Returns the units of the columns. Only the length unit is taken from the file, because these characteristics contain no forces.
fn units(reader: &dyn ResultsReader) -> Units {
    let word = &reader.header().units.length;
    let length = LENGTH_UNITS.iter().find(|unit| unit.word == word);
    let default = Units::default();
    Units {
        length: length.copied().unwrap_or(default.length),
        ..default
    }
}

fn rows(
    reader: &mut dyn ResultsReader,
    arguments: &KcArguments,
    filter: &StepFilter,
    shell: &Shell,
) -> Result<Vec<Row>, Exit> {
    let catalogue = reader.catalogue().clone();
    let degrees = reader.header().units.angle.eq_ignore_ascii_case("deg");
    let points = &arguments.steer_axis;
    if points.len() % 2 == 1 || points.len() / 2 > arguments.wheel.len() {
        let message = format!(
            "--steer-axis needs a lower and an upper point for each --wheel, but the number of points is {}",
            points.len()
        );
        return Err(shell.usage(Diagnostic::error(Code::BadSetting, message)));
    }
    let axes: Vec<[BodyPoint; 2]> = points
        .chunks_exact(2)
        .map(|pair| [pair[0].clone(), pair[1].clone()])
        .collect();
    let replay = Replay::new(
        &catalogue,
        &arguments.wheel,
        &axes,
        degrees,
        arguments.options(),
    );
    let mut replay = replay.map_err(|error| no_wheel(&error, shell))?;
    let time = catalogue
        .columns()
        .find(|column| column.component.name.eq_ignore_ascii_case("TIME"))
        .map(|column| column.component.id);
    let given = Given::default();
    let mut rows: Vec<Row> = Vec::new();
    let mut values = Vec::new();
    let mut ids: Vec<Option<usize>> = Vec::new();
    while let Some(step) = reader.next_step().map_err(|e| refused(e, shell))? {
        let (index, kind) = (step.index, step.kind);
        let read: Result<_, ResultsError> = replay.state(&step, &mut values);
        let state = read
            .map_err(|e| refused(e, shell))?
            .map_err(|error| no_wheel(&error, shell))?;
        let now = time.map(|id| values[id - 1]);
        // The model as read (step kind `input`) is the design position. It is not printed unless the user requests this kind.
        let wanted = filter.takes(index, kind, now)
            && (kind != StepKind::Input || filter.kinds.contains(&StepKind::Input));
        if !wanted {
            continue;
        }
        let readings = state.readings(&given);
        if ids.is_empty() {
            ids = readings
                .iter()
                .map(|reading| {
                    let entity = catalogue
                        .entities_called(reading.entity)
                        .find(|e| e.ent_type.as_deref() == Some("Request"))?;
                    Some(entity.component(reading.component)?.id)
                })
                .collect();
        }
        let own = ids.iter().map(|id| id.map(|id| values[id - 1])).collect();
        let row = Row {
            kind,
            time: now.unwrap_or(f64::NAN),
            readings,
            own,
        };
        if filter.last {
            rows.clear();
        }
        rows.push(row);
    }
    if rows.is_empty() {
        return Err(shell.fail(
            Diagnostic::error(
                Code::CannotRead,
                "no step of the file matches --steps, --from, --to and --kind",
            )
            .help("--kind input selects the design position"),
        ));
    }
    Ok(rows)
}

fn no_wheel(error: &ReplayError, shell: &Shell) -> Exit {
    let diagnostic = Diagnostic::error(Code::UndefinedId, error.to_string());
    shell.fail(match error {
        ReplayError::NoBody { bodies, .. } if bodies.is_empty() => {
            diagnostic.help("the file contains no positions of parts")
        }
        ReplayError::NoBody { bodies, .. } => {
            diagnostic.help(format!("the parts in the file are {}", bodies.join(", ")))
        }
        ReplayError::NoSpin { .. } => {
            diagnostic.help("give the spin axis by --spin, and the axes of the file by --axes")
        }
        ReplayError::SameSide { .. } => diagnostic.help("name at most one wheel for each side"),
        ReplayError::NoPose { .. } => diagnostic,
    })
}

fn write_csv(
    out: &mut impl Write,
    rows: &[Row],
    (convention, units): (Convention, &Units),
    plain: bool,
) -> std::io::Result<()> {
    let mut csv = csv::Writer::from_writer(out);
    let names = rows[0].readings.iter().map(|reading| {
        let unit = reading.unit.word(units);
        if plain || unit.is_empty() {
            reading.path()
        } else {
            format!("{} [{unit}]", reading.path())
        }
    });
    let first = (!plain).then(|| "step".to_string());
    let head = first.into_iter().chain(["TIME".to_string()]).chain(names);
    csv.write_record(head)?;
    for row in rows {
        let kind = (!plain).then(|| row.kind.step_type().to_string());
        let values = row
            .readings
            .iter()
            .map(|r| r.value_in(convention).to_string());
        csv.write_record(kind.into_iter().chain([row.time.to_string()]).chain(values))?;
    }
    csv.flush()
}

fn write_json(
    out: &mut impl Write,
    rows: &[Row],
    (convention, units): (Convention, &Units),
) -> std::io::Result<()> {
    let columns: Vec<_> = rows[0]
        .readings
        .iter()
        .map(|r| json!({ "path": r.path(), "units": r.unit.word(units) }))
        .collect();
    let steps: Vec<_> = rows
        .iter()
        .map(|row| {
            let values: Vec<f64> = row
                .readings
                .iter()
                .map(|r| r.value_in(convention))
                .collect();
            json!({ "kind": row.kind.step_type(), "time": row.time, "values": values })
        })
        .collect();
    let all = json!({ "convention": convention.word(), "columns": columns, "steps": steps });
    writeln!(
        out,
        "{}",
        serde_json::to_string_pretty(&all).expect("JSON values print")
    )
}

/// Finds the largest difference of each characteristic from the file's own column of the same name.
fn against(rows: &[Row], json: bool, units: &Units) -> String {
    let mut worst: BTreeMap<String, (f64, f64)> = BTreeMap::new();
    let mut order = Vec::new();
    for row in rows {
        for (reading, own) in row.readings.iter().zip(&row.own) {
            let Some(own) = own else { continue };
            let path = reading.path();
            let entry = worst.entry(path.clone()).or_insert_with(|| {
                order.push((path, reading.unit));
                (-1.0, f64::NAN)
            });
            let apart = (reading.value - own).abs();
            if !(apart <= entry.0) {
                *entry = (apart, row.time);
            }
        }
    }
    if json {
        let all: Vec<_> = order
            .iter()
            .map(|(path, _)| json!({ "column": path, "largest": worst[path].0, "time": worst[path].1 }))
            .collect();
        return serde_json::to_string_pretty(&all).expect("JSON values print") + "\n";
    }
    let mut out = String::new();
    for (path, unit) in &order {
        let (apart, time) = worst[path];
        let difference = format!("{apart:.3e} {}", unit.word(units));
        _ = writeln!(
            out,
            "{path:44} largest difference {} at time {time}",
            difference.trim_end()
        );
    }
    if order.is_empty() {
        out.push_str("the file has no column with the name of a characteristic\n");
    }
    out
}
