use std::path::Path;

use serde_json::json;

use admire_kc::{Bench, Config, Convention, KcRun, output};
use admire_report::{DrawingError, KcReport, MeasuredCurve, Scene};
use admire_results::Timestamp;
use admire_solver::model::Model;
use admire_study::digest;
use admire_syntax::Dataset;
use admire_syntax::files::Files;

/// Deck of a report of K&C tests.
pub(crate) struct KcDeck<'a> {
    /// Path of the dataset.
    pub path: &'a Path,
    /// The dataset.
    pub dataset: &'a Dataset,
    /// Files that the dataset names.
    pub files: &'a Files,
    /// Model of the dataset.
    pub model: &'a Model,
}

/// Returns the three-dimensional view of the axle with its wheels. `None` if the wheels of the configuration are not in the deck.
fn scene(deck: &KcDeck<'_>, config: &Config) -> Option<Scene> {
    let bench = Bench::new(config, deck.dataset, deck.files, deck.model).ok()?;
    let mut scene = Scene::of(deck.model, Some(deck.dataset));
    // The front view looks rearward, which is X of Adams/Car.
    scene.along = config.frame.from_deck.row(0).transpose().into();
    let radius = config.tyre.map(|tyre| tyre.radius);
    for wheel in &bench.wheels {
        let metre = 1.0 / deck.model.units.length.si;
        scene.add_wheel(wheel.part, &wheel.local, radius, metre);
    }
    Some(scene)
}

/// Creates the report of K&C tests, including other decks and measured curves for comparison.
pub(crate) fn kc_page(
    deck: &KcDeck<'_>,
    config: &Config,
    found: &KcRun,
    others: &[(String, KcRun)],
    curves: &[MeasuredCurve],
    convention: Convention,
) -> Result<String, DrawingError> {
    let units = &deck.model.units;
    let name = deck
        .path
        .file_name()
        .map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let (force, length) = (
        admire_report::short_unit(units.force.word),
        units.length.word,
    );
    let given = |value: Option<String>| value.unwrap_or_else(|| "not given".to_string());
    let facts = [
        (
            "Deck",
            format!("{}, axes {}", deck.path.display(), config.axes),
        ),
        (
            "Axle",
            if config.mirror {
                "one wheel, mirrored; without coupling of the two wheels".to_string()
            } else {
                format!(
                    "wheels: {}, anti-roll bar: {}",
                    config.sides().len(),
                    config.anti_roll_bar
                )
            },
        ),
        (
            "Tyre",
            given(config.tyre.map(|tyre| match tyre.stiffness {
                Some(k) => format!(
                    "unloaded radius {} {length}, stiffness {k} {force}/{length}",
                    tyre.radius
                ),
                None => format!("unloaded radius {} {length}, rigid", tyre.radius),
            })),
        ),
        (
            "Vehicle",
            given(config.vehicle.map(|v| {
                format!(
                    "{} axle, wheelbase {} {length}, height of the centre of mass {} {length}, sprung mass {} {}, share of the front axle: brake {}, drive {}",
                    v.axle.word(),
                    v.wheelbase,
                    v.cg_height,
                    v.sprung_mass,
                    units.mass.word,
                    v.front_brake,
                    v.front_drive
                )
            })),
        ),
        (
            "Ride height",
            match config.ride_load {
                Some(load) => format!("vertical load {load} {force} on each wheel"),
                None => format!("{} {length} above the design height", config.ride_height),
            },
        ),
        (
            "Steering",
            config.steering_lock.as_ref().map_or_else(
                || "as in the deck".to_string(),
                |at| format!("locked by {}", at.text),
            ),
        ),
        (
            "Friction",
            match found.ride.seen.friction {
                Some(_) => format!(
                    "joints slide with the friction coefficient MU_{}",
                    config.sliding_with.word().to_uppercase()
                ),
                None => "no joint has friction".to_string(),
            },
        ),
        ("Axes of the results", convention.word().to_string()),
        (
            "Swing arms and roll centre",
            format!(
                "computed with the vertical load case {}",
                json!(config.vertical_load).as_str().unwrap_or_default()
            ),
        ),
        (
            "Compliance matrix",
            match found.ride.seen.axle.compliance {
                Some(_) => format!("relative asymmetry {:.1e}", found.asymmetry),
                None => "not defined, because only the rig supports the wheels".to_string(),
            },
        ),
        ("Definitions", format!("version {}", output::DEFINITIONS)),
        ("Date", format!("{} UTC", Timestamp::now().date_time())),
        ("Made by", format!("admire {}", admire_report::VERSION)),
        (
            "Inputs",
            format!("SHA-256 {}", digest([deck.dataset.bytes(), config.source.bytes()])),
        ),
    ];
    let scene = scene(deck, config);
    let title = match deck.model.title.trim() {
        "" => name.as_str(),
        title => title,
    };
    let report = KcReport {
        title,
        scene: scene.as_ref(),
        run: found,
        others,
        measured: curves,
        units,
        convention,
        facts: &facts,
    };
    let footer = format!("admire {}", admire_report::VERSION);
    report.page(&footer)
}
