//! Output of a run: curves and gradients as CSV, everything as JSON, and each test as a results file with the request names of Adams/Car.

use std::io;

use serde_json::{Value, json};

use super::config::Config;
use super::sample::Sample;
use super::shown::{driven_unit, head, shown, slope};
use super::sweep::{KcRun, TestRun};
use super::test_settings::{LoadPoint, TestSettings};
use super::{Convention, Side};
use admire_results::{Catalogue, Component, Entity, Header, StepKind, Style, Timestamp, XrfWriter};
use admire_syntax::units::Units;

/// Version of the definitions in the guide, page `kc`.
pub const DEFINITIONS: u32 = 2;

/// Conditions stated in every row of an output.
#[derive(Clone, Debug)]
pub struct Statement {
    rows: Vec<(&'static str, String)>,
}

impl Statement {
    /// Creates the statement for a test, or for ride height if `test` is `None`.
    pub(crate) fn new(
        config: &Config,
        test: Option<&TestSettings>,
        convention: Convention,
    ) -> Self {
        let tyre = config.tyre.map_or_else(
            || "none".to_string(),
            |tyre| match tyre.stiffness {
                Some(k) => format!("R0 {} Kt {k}", tyre.radius),
                None => format!("R0 {} rigid", tyre.radius),
            },
        );
        let point = test.map_or("patch", |test| test.point.word());
        let point = if config.tyre.is_none() {
            LoadPoint::Centre.word()
        } else {
            point
        };
        let steering = match (&config.steering_lock, test) {
            (_, Some(test)) if !test.steering_locked => "free",
            (None, _) => "as in the deck",
            _ => "locked",
        };
        Self {
            rows: vec![
                ("load_point", point.to_string()),
                (
                    "held",
                    test.map_or("height", |test| test.hold.word()).to_string(),
                ),
                ("steering", steering.to_string()),
                ("anti_roll_bar", config.anti_roll_bar.clone()),
                ("tyre", tyre),
                (
                    "window",
                    test.map_or_else(String::new, |test| test.window.to_string()),
                ),
                ("axes", convention.word().to_string()),
                ("definitions", DEFINITIONS.to_string()),
            ],
        }
    }

    fn json(&self) -> Value {
        self.rows
            .iter()
            .map(|(name, value)| ((*name).to_string(), json!(value)))
            .collect::<serde_json::Map<_, _>>()
            .into()
    }
}

/// Returns the conditions under which a request is computed: load point, tyre radius, and whether the tyre's compliance is included (`in`
/// or `out`).
pub fn background(entity: &str) -> (&'static str, &'static str, &'static str) {
    let none = "none";
    match entity {
        "ride_rate"
        | "ride_frequency"
        | "total_roll_rate"
        | "roll_camber_coefficient"
        | "roll_caster_coefficient"
        | "tramp_rate"
        | "lift_acceleration"
        | "squat_acceleration" => ("wheel centre", none, "in"),
        "roll_steer" => ("patch", "loaded", "in"),
        "roll_center_location" => ("patch", "loaded", "out"),
        "dive_braking" | "lift_braking" => ("patch", "unloaded", "in"),
        "anti_dive_braking"
        | "anti_lift_braking"
        | "long_force_steer_patch"
        | "long_force_caster_patch" => ("patch", "unloaded", "out"),
        _ if entity.starts_with("lat_force") => ("patch", "unloaded", "out"),
        _ if entity.starts_with("alt_")
            || entity.starts_with("long_force")
            || entity.starts_with("fore_aft")
            || entity.starts_with("anti_") =>
        {
            ("wheel centre", none, "out")
        }
        "wheel_rate"
        | "ride_steer"
        | "ride_camber"
        | "ride_caster"
        | "susp_roll_rate"
        | "fr_view_swing_arm_angle"
        | "fr_view_swing_arm_length"
        | "side_view_swing_arm_angle"
        | "side_view_swing_arm_length" => ("wheel centre", none, "out"),
        "left_tire_contact_point"
        | "right_tire_contact_point"
        | "total_track"
        | "scrub_radius"
        | "caster_moment_arm"
        | "hub_lead"
        | "wheel_load_lever_arm"
        | "steer_axis_road_plane_intersection" => ("as the test", "loaded", "out"),
        _ => ("as the test", none, "out"),
    }
}

fn finished(csv: csv::Writer<Vec<u8>>) -> Vec<u8> {
    csv.into_inner().expect("writing to memory does not fail")
}

/// Formats a number for CSV; an undefined value becomes an empty cell.
fn cell(value: f64) -> String {
    if value.is_finite() {
        value.to_string()
    } else {
        String::new()
    }
}

/// Returns the stick-slip state of the joints with friction, in one word.
fn friction(sample: &Sample) -> &'static str {
    sample
        .seen
        .friction
        .map_or("none", admire_solver::system::StickSlipState::word)
}

/// Writes all samples of all tests as CSV, one line per sample, ride height first.
pub fn curves_csv(run: &KcRun, config: &Config, units: &Units, convention: Convention) -> Vec<u8> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    let mut write = |record: Vec<String>| {
        csv.write_record(record)
            .expect("writing to memory does not fail");
    };
    let statement = Statement::new(config, None, convention);
    let first = ["test", "branch", "value", "value_unit", "friction"].map(str::to_string);
    let said = statement.rows.iter().map(|row| row.0.to_string());
    let names = run.ride.readings.iter().map(|reading| head(reading, units));
    write(first.into_iter().chain(said).chain(names).collect());
    let mut row = |(name, unit): (&str, String), statement: &Statement, sample: &Sample| {
        let first = [
            name.to_string(),
            sample.branch.word().to_string(),
            sample.value.to_string(),
            unit,
            friction(sample).to_string(),
        ];
        let said = statement.rows.iter().map(|row| row.1.clone());
        let values = run.ride.readings.iter().map(|wanted| {
            let found = sample
                .readings
                .iter()
                .find(|r| r.entity == wanted.entity && r.component == wanted.component);
            cell(found.map_or(f64::NAN, |r| shown(r.value_in(convention), r.unit, units).0))
        });
        write(first.into_iter().chain(said).chain(values).collect());
    };
    row(("ride_height", String::new()), &statement, &run.ride);
    for test in &run.tests {
        let statement = Statement::new(config, Some(&test.settings), convention);
        let unit = driven_unit(test.kind.driven(), units);
        for sample in &test.samples {
            row((test.kind.name(), unit.clone()), &statement, sample);
        }
    }
    finished(csv)
}

/// Writes all gradients as CSV, one line per gradient.
pub fn gradients_csv(
    run: &KcRun,
    config: &Config,
    units: &Units,
    convention: Convention,
) -> Vec<u8> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    let mut write = |record: Vec<String>| {
        csv.write_record(record)
            .expect("writing to memory does not fail");
    };
    let names = [
        "test",
        "quantity",
        "unit",
        "per",
        "tangent",
        "fitted",
        "hysteresis",
        "hysteresis_unit",
        "linear_from",
        "linear_to",
        "linear_unit",
        "left_right_asymmetry",
        "radius",
        "tyre_stiffness",
    ];
    let statement = Statement::new(config, None, convention);
    let said = statement.rows.iter().map(|row| row.0.to_string());
    write(names.map(str::to_string).into_iter().chain(said).collect());
    for test in &run.tests {
        let statement = Statement::new(config, Some(&test.settings), convention);
        for gradient in &test.gradients {
            let factor = convention.factor(gradient.sense);
            let (_, radius, tyre) = background(gradient.entity);
            let driven = test.kind.driven();
            let per = |value: f64| slope(factor * value, gradient.unit, driven, units);
            let (tangent, unit) = per(gradient.tangent);
            let (hysteresis, of_reading) = shown(gradient.hysteresis, gradient.unit, units);
            let first = [
                test.kind.name().to_string(),
                format!("{}.{}", gradient.entity, gradient.component),
                unit,
                test.kind.variable().to_string(),
                cell(tangent),
                cell(per(gradient.fitted).0),
                cell(hysteresis),
                of_reading,
                cell(gradient.linear_range[0]),
                cell(gradient.linear_range[1]),
                driven_unit(driven, units),
                cell(gradient.asymmetry(&test.gradients)),
                radius.to_string(),
                tyre.to_string(),
            ];
            let said = statement.rows.iter().map(|row| row.1.clone());
            write(first.into_iter().chain(said).collect());
        }
    }
    finished(csv)
}

/// Builds the complete run as JSON. Undefined numbers are null.
pub fn json(run: &KcRun, config: &Config, units: &Units, convention: Convention) -> Value {
    let columns: Vec<Value> = run
        .ride
        .readings
        .iter()
        .map(|reading| {
            let (load, radius, tyre) = background(reading.entity);
            json!({
                "path": reading.path(),
                "units": reading.unit.word(units),
                "load_at": load,
                "radius": radius,
                "tyre": tyre,
            })
        })
        .collect();
    let sample = |sample: &Sample| {
        let values: Vec<f64> = run
            .ride
            .readings
            .iter()
            .map(|wanted| {
                let mut all = sample.readings.iter();
                let found =
                    all.find(|r| r.entity == wanted.entity && r.component == wanted.component);
                found.map_or(f64::NAN, |r| r.value_in(convention))
            })
            .collect();
        json!({
            "branch": sample.branch.word(),
            "value": sample.value,
            "friction": friction(sample),
            "values": values,
        })
    };
    let matrix = |sample: &Sample| -> Value {
        let Some(compliance) = sample.seen.axle.compliance else {
            return Value::Null;
        };
        // Translations and rotations change sign alike with the axes.
        let axes = [super::Sense::X, super::Sense::Y, super::Sense::Z];
        let sign = |k: usize| convention.factor(axes[k % 3]);
        (0..12)
            .map(|i| {
                (0..12)
                    .map(|j| json!(sign(i) * sign(j) * compliance.matrix[(i, j)]))
                    .collect::<Value>()
            })
            .collect()
    };
    let tests: Vec<Value> = run
        .tests
        .iter()
        .map(|test| {
            let gradients: Vec<Value> = test
                .gradients
                .iter()
                .map(|gradient| {
                    let factor = convention.factor(gradient.sense);
                    json!({
                        "quantity": format!("{}.{}", gradient.entity, gradient.component),
                        "units": gradient.unit.word(units),
                        "per": test.kind.variable(),
                        "tangent": factor * gradient.tangent,
                        "fitted": factor * gradient.fitted,
                        "hysteresis": gradient.hysteresis,
                        "linear_range": gradient.linear_range,
                    })
                })
                .collect();
            json!({
                "test": test.kind.name(),
                "variable": test.kind.variable(),
                "stated": Statement::new(config, Some(&test.settings), convention).json(),
                "range": test.settings.range,
                "samples": test.samples.iter().map(sample).collect::<Vec<_>>(),
                "gradients": gradients,
            })
        })
        .collect();
    json!({
        "definitions": DEFINITIONS,
        "axes": convention.word(),
        "deck_axes": config.axes,
        "choices": {
            "axle": config.vehicle.map(|vehicle| vehicle.axle.word()),
            "vertical_load": config.vertical_load,
            "friction": config.sliding_with.word(),
            "mirrored": config.mirror,
            "road": "level",
        },
        "columns": columns,
        "ride_height": sample(&run.ride),
        "stated": Statement::new(config, None, convention).json(),
        "compliance": matrix(&run.ride),
        "compliance_asymmetry": run.asymmetry,
        "balance": run.balance,
        "tests": tests,
    })
}

/// Writes one test as a results file with the requests of Adams/Car. Each sample is a quasi-static step, and TIME is the sample's number,
/// counted from 1. Columns with undefined values are left out; their names are returned with the bytes of the file.
///
/// # Errors
/// None in practice: the file is written to memory.
pub fn results(
    test: &TestRun,
    title: &str,
    units: &Units,
    convention: Convention,
) -> io::Result<(Vec<u8>, Vec<String>)> {
    let Some(first) = test.samples.first() else {
        return Ok((Vec::new(), Vec::new()));
    };
    let defined = |k: usize| {
        test.samples
            .iter()
            .all(|s| s.readings.get(k).is_some_and(|r| r.value.is_finite()))
    };
    let (kept, lost): (Vec<usize>, Vec<usize>) =
        (0..first.readings.len()).partition(|&k| defined(k));
    let mut entities = vec![Entity {
        name: "time".to_string(),
        components: vec![Component {
            name: "TIME".to_string(),
            units: Some(units.time.word.to_string()),
            plot_label: None,
            id: 1,
        }],
        ..Entity::default()
    }];
    // Components of one request are adjacent, and values follow the order of their ids.
    let mut order: Vec<usize> = Vec::new();
    let mut names: Vec<&str> = Vec::new();
    for &k in &kept {
        if !names.contains(&first.readings[k].entity) {
            names.push(first.readings[k].entity);
        }
    }
    for (number, name) in names.into_iter().enumerate() {
        let mut components = Vec::new();
        for &k in kept.iter().filter(|&&k| first.readings[k].entity == name) {
            order.push(k);
            let reading = &first.readings[k];
            let unit = reading.unit.word(units);
            components.push(Component {
                name: reading.component.to_string(),
                units: (!unit.is_empty()).then_some(unit),
                plot_label: None,
                id: order.len() + 1,
            });
        }
        entities.push(Entity {
            name: name.to_string(),
            entity: Some(name.to_string()),
            ent_type: Some("Request".to_string()),
            object_id: Some(number as i64 + 1),
            comment: None,
            components,
        });
    }
    let catalogue = Catalogue::new(entities);
    let path = format!("{}.res", test.kind.name());
    let header = Header::new(&path, title, units, Timestamp::now());
    let mut writer = XrfWriter::create(Vec::new(), &header, &catalogue, Style::default())?;
    for (at, sample) in test.samples.iter().enumerate() {
        let mut values = vec![at as f64 + 1.0];
        values.extend(
            order
                .iter()
                .map(|&k| sample.readings[k].value_in(convention)),
        );
        writer.step(StepKind::QuasiStatic, &values)?;
    }
    let lost = lost.into_iter().map(|k| first.readings[k].path()).collect();
    Ok((writer.finish("Successful")?, lost))
}

/// Returns the wheels present in a run.
pub fn sides(run: &KcRun) -> Vec<Side> {
    let there = |side: &Side| run.ride.seen.axle.wheels[side.index()].is_some();
    Side::BOTH.into_iter().filter(there).collect()
}
