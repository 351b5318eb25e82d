//! Contents of `kc.toml`: the wheels of a deck, data that no deck contains, and the tests.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

use super::test_kind::TestKind;
use super::test_settings::{Branches, Hold, LoadPoint, TestSettings};
use super::{AxlePlace, Convention, Direction, Frame, Side, Tyre, Vehicle, VerticalLoad};
use admire_session::read_toml;
use admire_solver::system::SlidingWith;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::text::{Source, Span};

/// Text from `kc.toml` with its position in the file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Spelled {
    /// Text as written.
    pub text: String,
    /// Position in the file.
    pub span: Span,
}

impl From<Spanned<String>> for Spelled {
    fn from(spanned: Spanned<String>) -> Self {
        let span = Span::from(spanned.span());
        Self {
            text: spanned.into_inner(),
            span,
        }
    }
}

/// One wheel of a deck.
#[derive(Clone, PartialEq, Debug)]
pub struct WheelConfig {
    /// Marker at the wheel centre, on the part that carries the wheel and does not spin.
    pub centre: Spelled,
    /// Spin axis: `x`, `y` or `z` of the centre marker, or a second marker on the axis.
    pub spin: Spelled,
    /// Lower and upper marker of the geometric steer axis.
    pub steer_axis: Option<[Spelled; 2]>,
    /// Marker whose height is held while the instant steer axis is computed; `None` means the wheel centre.
    pub travel_lock: Option<Spelled>,
}

/// Method that determines the reported steer axis.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AxisMethod {
    /// Line through two markers.
    Geometric,
    /// Screw axis of the carrier's motion under the steering input.
    Instant,
    /// Screw axis of the carrier's motion under a unit moment about the vertical at the wheel centre, with the travel locked. Adams/Car reports this
    /// axis for an axle without steering.
    InstantMoment,
    /// Geometric axis if its markers are named; otherwise the instant axis if there is a steering input; otherwise no axis.
    #[default]
    Any,
}

/// Contents of `kc.toml`.
#[derive(Clone, Debug)]
pub struct Config {
    /// Source text of the file.
    pub source: Source,
    /// Axes of the deck.
    pub frame: Frame,
    /// Name of the axis convention of the deck as written in the outputs, such as `adams-car`, or the list of its three directions.
    pub axes: String,
    /// Statements that the rig removes from the deck, such as the deck's own loads.
    pub without: Vec<Spelled>,
    /// Left and right wheel; `None` for a wheel that is not in the deck.
    pub wheels: [Option<WheelConfig>; 2],
    /// True if the missing wheel is the mirror image of the wheel in the deck.
    pub mirror: bool,
    /// Tyre data.
    pub tyre: Option<Tyre>,
    /// Vehicle data.
    pub vehicle: Option<Vehicle>,
    /// Vertical load of a wheel at ride height. If `None`, `ride_height` defines ride height.
    pub ride_load: Option<f64>,
    /// Height of the wheel centres above their design position at ride height.
    pub ride_height: f64,
    /// Statement that locks the steering; it is removed in tests with free steering.
    pub steering_lock: Option<Spelled>,
    /// Address of the parameter or function in the deck that is the steering input.
    pub steering_drive: Option<Spelled>,
    /// Method that determines the steer axis.
    pub axis_method: AxisMethod,
    /// Vertical load case used for swing arms and roll centre.
    pub vertical_load: VerticalLoad,
    /// Friction coefficient used for sliding joints: static or dynamic.
    pub sliding_with: SlidingWith,
    /// User's remark on the anti-roll bar, copied to the outputs.
    pub anti_roll_bar: String,
    /// Directions in which tests are driven.
    pub branches: Branches,
    /// Tests to run, in standard order, with their settings.
    pub tests: Vec<(TestKind, TestSettings)>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    deck: DeckTable,
    wheels: WheelsTable,
    tyre: Option<Tyre>,
    vehicle: Option<VehicleTable>,
    #[serde(default)]
    ride: RideTable,
    #[serde(default)]
    steering: SteeringTable,
    #[serde(default)]
    choices: Choices,
    #[serde(default)]
    tests: BTreeMap<Spanned<String>, TestTable>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct DeckTable {
    axes: Option<Spanned<AxesWord>>,
    #[serde(default)]
    without: Vec<Spanned<String>>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(untagged)]
enum AxesWord {
    Named(Convention),
    Each([Direction; 3]),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WheelsTable {
    left: Option<WheelTable>,
    right: Option<WheelTable>,
    #[serde(default)]
    mirror: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WheelTable {
    centre: Spanned<String>,
    spin: Spanned<String>,
    steer_axis: Option<[Spanned<String>; 2]>,
    travel_lock: Option<Spanned<String>>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(deny_unknown_fields)]
struct VehicleTable {
    axle: Option<AxlePlace>,
    wheelbase: f64,
    cg_height: f64,
    sprung_mass: f64,
    front_brake: f64,
    front_drive: f64,
    axle_ratio: Option<f64>,
}

impl VehicleTable {
    /// Returns the vehicle. An axle whose place is not given is the front axle if it is steered.
    fn vehicle(self, steered: bool) -> Vehicle {
        let likely = if steered {
            AxlePlace::Front
        } else {
            AxlePlace::Rear
        };
        Vehicle {
            wheelbase: self.wheelbase,
            cg_height: self.cg_height,
            sprung_mass: self.sprung_mass,
            front_brake: self.front_brake,
            front_drive: self.front_drive,
            axle_ratio: self.axle_ratio,
            axle: self.axle.unwrap_or(likely),
        }
    }
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RideTable {
    load: Option<f64>,
    height: Option<f64>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct SteeringTable {
    lock: Option<Spanned<String>>,
    drive: Option<Spanned<String>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct Choices {
    #[serde(default)]
    steer_axis: AxisMethod,
    #[serde(default)]
    vertical_load: VerticalLoad,
    #[serde(default)]
    friction: FrictionWord,
    anti_roll_bar: Option<String>,
    #[serde(default)]
    branches: Branches,
}

#[derive(Deserialize, Clone, Copy, Default)]
#[serde(rename_all = "lowercase")]
enum FrictionWord {
    #[default]
    Dynamic,
    Static,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct TestTable {
    run: Option<bool>,
    range: Option<Spanned<[f64; 2]>>,
    points: Option<Spanned<usize>>,
    window: Option<Spanned<f64>>,
    point: Option<LoadPoint>,
    hold: Option<Hold>,
    steering: Option<SteeringWord>,
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
enum SteeringWord {
    Locked,
    Free,
}

/// Smallest and largest plausible tyre radius in mm, from table-top models to mining trucks.
const RADIUS: (f64, f64) = (10.0, 3e3);
/// Smallest and largest plausible wheelbase in mm.
const WHEELBASE: (f64, f64) = (50.0, 3e4);
/// Smallest and largest plausible height of the centre of mass above the road in mm.
const HEIGHT: (f64, f64) = (1.0, 1e4);

/// Lists the values in `kc.toml` that no vehicle can have, probably because they were given in a wrong unit. Each is returned as (byte
/// range in the file, message). `length` is one millimetre in the deck's length unit.
fn out_of_bounds(
    file: &File,
    source: &Source,
    length: f64,
) -> Vec<(std::ops::Range<usize>, String)> {
    let positive = (f64::MIN_POSITIVE, f64::MAX);
    let finite = (f64::MIN, f64::MAX);
    let share = (0.0, 1.0);
    let mm = |(least, most): (f64, f64)| (least * length, most * length);
    let (tyre, vehicle) = (&file.tyre, &file.vehicle);
    let all = [
        ("tyre.radius", tyre.map(|t| t.radius), mm(RADIUS)),
        ("tyre.stiffness", tyre.and_then(|t| t.stiffness), positive),
        (
            "vehicle.wheelbase",
            vehicle.map(|v| v.wheelbase),
            mm(WHEELBASE),
        ),
        (
            "vehicle.cg_height",
            vehicle.map(|v| v.cg_height),
            mm(HEIGHT),
        ),
        (
            "vehicle.sprung_mass",
            vehicle.map(|v| v.sprung_mass),
            positive,
        ),
        ("vehicle.front_brake", vehicle.map(|v| v.front_brake), share),
        ("vehicle.front_drive", vehicle.map(|v| v.front_drive), share),
        (
            "vehicle.axle_ratio",
            vehicle.and_then(|v| v.axle_ratio),
            positive,
        ),
        ("ride.height", file.ride.height, finite),
        ("ride.load", file.ride.load, finite),
    ];
    let mut wrong = Vec::new();
    for (name, value, (least, most)) in all {
        let Some(value) = value.filter(|value| !(least..=most).contains(value)) else {
            continue;
        };
        let must = if (least, most) == positive {
            "a number above 0".to_string()
        } else if (least, most) == finite {
            "a finite number".to_string()
        } else if (least, most) == share {
            "a share from 0 to 1".to_string()
        } else {
            format!("from {least} to {most} in the deck's length unit")
        };
        let message = format!("`{name}` must be {must}, not {value}");
        wrong.push((place_of(source, name), message));
    }
    wrong
}

/// Finds the byte range of a dotted key in the file: the first assignment to its last component. The range is empty if the key does not
/// occur.
pub(super) fn place_of(source: &Source, name: &str) -> std::ops::Range<usize> {
    let key = name.rsplit('.').next().unwrap_or(name);
    let text = source.utf8().unwrap_or_default();
    let is_key = |(at, _): &(usize, &str)| {
        let before = text[..*at].chars().next_back();
        let after = text[at + key.len()..].trim_start().starts_with('=');
        after && before.is_none_or(|c| !c.is_alphanumeric() && c != '_')
    };
    let found = text.match_indices(key).find(is_key);
    found.map_or(0..0, |(at, key)| at..at + key.len())
}

impl Config {
    /// Reads the file. The defaults are converted to units of the deck: `length` is one millimetre and `force` one newton in these units.
    pub fn read(source: &Source, length: f64, force: f64) -> Checked<Option<Self>> {
        let file: File = match read_toml(source, Code::BadSetting) {
            Ok(file) => file,
            Err(wrong) => {
                return Checked {
                    value: None,
                    diagnostics: vec![wrong.help("`admire guide kc` shows every key")],
                };
            }
        };
        let mut out = Vec::new();
        let mut wrong = |span: std::ops::Range<usize>, message: String| {
            out.push(Diagnostic::error(Code::BadSetting, message).label(
                source.name(),
                Span::from(span),
                "",
            ));
        };
        let (axes, frame) = match &file.deck.axes {
            None => ("adams-car".to_string(), Some(Frame::default())),
            Some(axes) => match axes.get_ref() {
                AxesWord::Named(name) => (name.word().to_string(), Frame::new(name.axes())),
                AxesWord::Each(each) => (format!("{each:?}").to_lowercase(), Frame::new(*each)),
            },
        };
        if let (None, Some(axes)) = (&frame, &file.deck.axes) {
            let message = "`deck.axes` must be a right-handed set of vehicle axes, such as [\"rearward\", \"right\", \"up\"]";
            wrong(axes.span(), message.to_string());
        }
        for (place, message) in out_of_bounds(&file, source, length) {
            wrong(place, message);
        }
        let wheel = |table: WheelTable| WheelConfig {
            centre: table.centre.into(),
            spin: table.spin.into(),
            steer_axis: table.steer_axis.map(|both| both.map(Spelled::from)),
            travel_lock: table.travel_lock.map(Spelled::from),
        };
        let wheels = [file.wheels.left.map(wheel), file.wheels.right.map(wheel)];
        let count = wheels.iter().flatten().count();
        if count == 0 || (count == 2 && file.wheels.mirror) {
            let message = if count == 0 {
                "`wheels.left` or `wheels.right` is missing"
            } else {
                "`wheels.mirror` applies only to a deck with one wheel"
            };
            wrong(0..0, message.to_string());
        }
        if file.ride.load.is_some() && file.ride.height.is_some() {
            wrong(
                0..0,
                "`ride.load` and `ride.height` both define ride height: give only one of them"
                    .to_string(),
            );
        }
        let axle = count == 2 || file.wheels.mirror;
        let mut tests = Vec::new();
        let mut tables = file.tests;
        for kind in TestKind::ALL {
            let key = tables.keys().find(|key| key.get_ref() == kind.name());
            let table = key.cloned().and_then(|key| tables.remove(&key));
            let asked = table.is_some();
            let table = table.unwrap_or_default();
            let possible = (axle || !kind.needs_two_wheels())
                && (kind != TestKind::Steering || file.steering.drive.is_some());
            if asked && table.run != Some(false) && !possible {
                wrong(
                    0..0,
                    format!("test `{}` needs {}", kind.name(), kind.needs()),
                );
            }
            let wanted = table.run.unwrap_or(asked || kind.is_standard());
            if !wanted || !possible {
                continue;
            }
            let default = kind.settings(length, force, file.tyre.is_some());
            let mut settings = default;
            if let Some(range) = table.range {
                settings.range = *range.get_ref();
                let reach = |range: [f64; 2]| range[0].abs().max(range[1].abs());
                let share = reach(settings.range) / reach(default.range);
                settings.window = default.window * share.min(1.0);
                let [low, high] = settings.range;
                if !(low < high && low <= 0.0 && high >= 0.0 && low.is_finite() && high.is_finite())
                {
                    wrong(
                        range.span(),
                        "`range` must be [low, high] with low below high, and must contain 0"
                            .to_string(),
                    );
                }
            }
            if let Some(points) = table.points {
                settings.points = *points.get_ref();
                if !(3..=2001).contains(&settings.points) {
                    wrong(points.span(), "`points` must be from 3 to 2001".to_string());
                }
            }
            if let Some(window) = table.window {
                settings.window = *window.get_ref();
                if !(settings.window > 0.0 && settings.window.is_finite()) {
                    wrong(
                        window.span(),
                        "`window` must be a number above 0".to_string(),
                    );
                }
            }
            settings.point = table.point.unwrap_or(settings.point);
            settings.hold = table.hold.unwrap_or(settings.hold);
            settings.steering_locked = table.steering != Some(SteeringWord::Free);
            if kind == TestKind::Bounce && settings.hold == Hold::Load {
                wrong(
                    0..0,
                    "test `bounce` drives the wheel heights, so hold = \"load\" is not possible"
                        .to_string(),
                );
            }
            if settings.point == LoadPoint::Patch && file.tyre.is_none() {
                wrong(
                    0..0,
                    format!(
                        "test `{}` loads the contact patch: give `tyre.radius`, or point = \"centre\"",
                        kind.name()
                    ),
                );
            }
            if !settings.steering_locked && file.steering.lock.is_none() {
                wrong(
                    0..0,
                    format!(
                        "test `{}` frees the steering: name the statement that locks it in `steering.lock`",
                        kind.name()
                    ),
                );
            }
            tests.push((kind, settings));
        }
        for (key, _) in tables {
            let names: Vec<&str> = TestKind::ALL.iter().map(|kind| kind.name()).collect();
            wrong(
                key.span(),
                format!(
                    "`{}` is not a test: the tests are {}",
                    key.get_ref(),
                    names.join(", ")
                ),
            );
        }
        let steered = file.steering.lock.is_some() || file.steering.drive.is_some();
        let value = frame.map(|frame| Self {
            source: source.clone(),
            frame,
            axes,
            without: file.deck.without.into_iter().map(Spelled::from).collect(),
            wheels,
            mirror: file.wheels.mirror,
            tyre: file.tyre,
            vehicle: file.vehicle.map(|table| table.vehicle(steered)),
            ride_load: file.ride.load,
            ride_height: file.ride.height.unwrap_or(0.0),
            steering_lock: file.steering.lock.map(Spelled::from),
            steering_drive: file.steering.drive.map(Spelled::from),
            axis_method: file.choices.steer_axis,
            vertical_load: file.choices.vertical_load,
            sliding_with: match file.choices.friction {
                FrictionWord::Dynamic => SlidingWith::Dynamic,
                FrictionWord::Static => SlidingWith::Static,
            },
            anti_roll_bar: file
                .choices
                .anti_roll_bar
                .unwrap_or_else(|| "as in the deck".to_string()),
            branches: file.choices.branches,
            tests,
        });
        Checked {
            value: if out.is_empty() { value } else { None },
            diagnostics: out,
        }
    }

    /// Returns this configuration with only the given tests. If `one_way` is true, the return sweep from the highest value is left out.
    #[must_use]
    pub fn with_tests(&self, tests: &[TestKind], one_way: bool) -> Self {
        let mut new = self.clone();
        new.tests.retain(|(kind, _)| tests.contains(kind));
        if one_way {
            new.branches = Branches::Up;
        }
        new
    }

    /// Returns the sides whose wheels are in the deck.
    pub fn sides(&self) -> Vec<Side> {
        let there = |side: &Side| self.wheels[side.index()].is_some();
        Side::BOTH.into_iter().filter(there).collect()
    }

    /// Creates an error diagnostic that points at a text in the file.
    pub(crate) fn complain(&self, at: &Spelled, code: Code, message: String) -> Diagnostic {
        Diagnostic::error(code, message).label(self.source.name(), at.span, "")
    }
}
