//! Real Adams/Car results: readouts from body motions, the loads of the rig, and identities between their own columns.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;
use std::process::Command;

use admire_kc::{
    AxleState, Compliance, Frame, Given, Replay, ReplayOptions, Road, Side, SteerAxis, Steering,
    Tyre, ride, wheel,
};
use admire_results::{StepKind, XrfReader};
use admire_solver::mechanics::Vec3;

use crate::axles::heading;
use crate::common::{files_below, shared};

const ANGLE: f64 = 1e-12;
const LENGTH: f64 = 1e-9;
const IDENTITY: f64 = 1e-11;
/// Known data of these files: unloaded radius and stiffness of the tyre, wheelbase, height of the centre of mass, sprung mass.
const TYRE: f64 = 202.0;
const RADIUS: f64 = 317.25;
const WHEELBASE: f64 = 2700.0;
const CG_HEIGHT: f64 = 500.0;
const WEIGHT: f64 = 1600.0 * 9.80665;

const WITH_TYRE: Tyre = Tyre {
    radius: RADIUS,
    stiffness: Some(TYRE),
};

/// Results of a file: for each step, the values of its requests and of the forces of its tyres by name, and the wheels from the poses of their
/// parts. The tyre radii follow from the normal forces of the file by the law of the tyre.
pub struct Run {
    pub path: PathBuf,
    pub columns: BTreeMap<String, usize>,
    pub steps: Vec<(Vec<f64>, AxleState)>,
    /// True if the road is rolled.
    pub rolls: bool,
}

pub fn runs() -> Vec<Run> {
    let Some(folder) = shared("real-decks/kinbench-kc") else {
        return Vec::new();
    };
    let files = files_below(&folder, "res");
    assert!(!files.is_empty());
    files.into_iter().map(run).collect()
}

fn run(path: PathBuf) -> Run {
    let input = BufReader::new(File::open(&path).unwrap());
    let mut reader = XrfReader::open("run.res", input).unwrap();
    let mut columns = BTreeMap::new();
    for entity in &reader.catalogue().entities {
        let name = match entity.ent_type.as_deref() {
            Some("Request") => &entity.name,
            Some("General_Force") => entity.entity.as_ref().unwrap_or(&entity.name),
            _ => continue,
        };
        for component in &entity.components {
            let name = format!("{name}.{}", component.name);
            columns.entry(name).or_insert(component.id);
        }
    }
    let options = ReplayOptions {
        spin: None,
        centre: Vec3::zeros(),
        frame: Frame::default(),
        tyre: Some(WITH_TYRE),
        road: Road::Rig,
    };
    let names = ["whl_wheel", "whr_wheel"].map(str::to_string);
    let mut replay = Replay::new(reader.catalogue(), &names, &[], false, options).unwrap();
    let mut steps = Vec::new();
    let mut rolls = false;
    while let Some(step) = reader.next_step().unwrap() {
        let kind = step.kind;
        let mut values = Vec::new();
        let state = replay.state(&step, &mut values).unwrap().unwrap();
        if kind == StepKind::Input {
            continue;
        }
        let of = |name: &str| values[columns[name] - 1];
        let roll = of("suspension_exerciser_requests.Roll");
        if roll.abs() > 1e-9 {
            rolls = true;
            let turned = of("roll_angle.at_contact_patches").sin();
            assert!((state.normal.y - turned).abs() < 1e-15);
        }
        steps.push((values, state));
    }
    assert!(steps.len() > 50);
    Run {
        path,
        columns,
        steps,
        rolls,
    }
}

fn contact(of: &dyn Fn(&str) -> f64, side: Side) -> Vec3 {
    let word = side.word();
    let at = |axis: &str| of(&format!("{word}_tire_contact_point.{axis}_{word}"));
    Vec3::new(at("x"), at("y"), at("z"))
}

impl Run {
    pub fn each(&self, mut check: impl FnMut(&dyn Fn(&str) -> f64, &AxleState)) {
        for (values, state) in &self.steps {
            check(&|name| values[self.columns[name] - 1], state);
        }
    }
}

#[test]
fn readouts_of_real_results() {
    for run in runs() {
        let mut seen = 0;
        run.each(|of, state| {
            for reading in state.readings(&Given::default()) {
                let path = reading.path();
                if !run.columns.contains_key(&path) {
                    continue;
                }
                let bar = match &*path {
                    _ if path.ends_with("_angle.left") || path.ends_with("_angle.right") => ANGLE,
                    "roll_angle.at_wheel_centers" | "roll_angle.at_contact_patches" => ANGLE,
                    "total_track.track" if run.rolls => 0.1,
                    _ => LENGTH,
                };
                let apart = (reading.value - of(&path)).abs();
                assert!(apart <= bar, "{}: {path} {apart:e}", run.path.display());
                seen += 1;
            }
        });
        assert_eq!(seen, run.steps.len() * 41, "columns compared");
    }
}

/// Checks the force and the moment of each tyre on its wheel. The normal force follows from the distance to the road. The lateral force acts
/// along the wheel's heading in the road plane. Both act at the contact point.
#[test]
fn loads_of_real_results() {
    for run in runs() {
        run.each(|of, state| {
            for side in Side::BOTH {
                let w = side.word();
                let WheelPose { spin, centre } = pose(state, side);
                let lever = contact(of, side) - centre;
                let r = lever.norm();
                let tilt = (1.0 - spin.dot(&state.normal).powi(2)).sqrt();
                let normal = TYRE * (RADIUS - r) * tilt;
                let told = of(&format!("{w}_tire_forces.normal"));
                assert!((normal - told).abs() < 1e-9, "{normal} {told}");
                if run.rolls {
                    continue;
                }
                let [rearward, right] = heading(&state.wheels[side.index()].unwrap().wheel);
                let load = |entity: &str, name: &str| of(&format!("{entity}.{name}_{w}"));
                let lateral = right * -load("wheel_load_lateral", "lateral");
                let braking = rearward * load("wheel_load_longitudinal", "braking");
                let driving = rearward * -load("wheel_load_longitudinal", "driving");
                let at_patch = state.normal * normal + lateral + braking;
                let moment = (lever * (RADIUS / r).min(1.0)).cross(&at_patch);
                let tyre = format!("testrig.ti{}_wheel.force", &w[..1]);
                let vector = |letter: &str| {
                    Vec3::from(["X", "Y", "Z"].map(|k| of(&format!("{tyre}.{letter}{k}"))))
                };
                let force = at_patch + driving;
                assert!((force - vector("F")).norm() < 1e-8, "{force}");
                assert!((moment - vector("T")).norm() < 1e-6, "{moment}");
            }
        });
    }
}

struct WheelPose {
    centre: Vec3,
    spin: Vec3,
}

fn pose(state: &AxleState, side: Side) -> WheelPose {
    let wheel = state.wheels[side.index()].unwrap().wheel;
    WheelPose {
        centre: wheel.centre,
        spin: wheel.spin,
    }
}

/// Returns the compliance of the wheel centres, derived from other columns. The columns of a vertical load follow from wheel rate, swing arms
/// and ride steer. The columns of a moment about X follow from the compliances to lateral forces and aligning torques. C24 is the value at
/// design; C42, C34 and C64 are set equal to C24, C43 and C46. They enter the compliance at the patch only with the lateral lever arm of a few
/// millimetres.
fn of_columns(of: &dyn Fn(&str) -> f64, state: &AxleState) -> Compliance {
    const C24: f64 = 6.4273e-7;
    let mut all = Compliance {
        matrix: nalgebra::SMatrix::zeros(),
        present: [true; 2],
    };
    for side in Side::BOTH {
        let of = |name: &str| of(&format!("{name}.{}", side.word()));
        let (out, first) = (side.outboard_sign(), 6 * side.index());
        let mut set = |i: usize, j: usize, value: f64| {
            all.matrix[(first + i - 1, first + j - 1)] = value;
        };
        let c33 = 1.0 / of("wheel_rate");
        let arm = |view: &str| {
            let angle = of(&format!("{view}_swing_arm_angle"));
            let length = of(&format!("{view}_swing_arm_length"));
            (angle.tan() * c33, c33 / (length * angle.cos()))
        };
        let ((c23, c43), (c13, c53)) = (arm("fr_view"), arm("side_view"));
        let (c23, c43, c13, c53) = (out * c23, out * c43, -c13, -c53);
        // The steer angle changes by o.y do.x - o.x do.y, with do = th x o.
        let o = pose(state, side).spin;
        let across = o.x * o.x + o.y * o.y;
        let steer = of("ride_steer") * c33 * across;
        let c63 = (o.y * c53 * o.z + o.x * c43 * o.z - steer) / across;
        for (row, value) in [(1, c13), (2, c23), (3, c33), (4, c43), (5, c53), (6, c63)] {
            set(row, 3, value);
        }
        let c44 = (-out * of("lat_force_camber_compliance") - C24) / RADIUS;
        let c64 = -out * of("alt_camber_compliance");
        for (row, value) in [(2, C24), (3, c43), (4, c44), (6, c64)] {
            set(row, 4, value);
        }
    }
    all
}

/// Checks roll centre and roll steer in every state, with the compliance from other columns. With patches at their own heights, the roll centre
/// would be wrong by 19 mm. With the rotation about Z alone, the roll steer would be wrong by 0.058.
#[test]
fn roll_centre_and_roll_steer_of_real_results() {
    let given = Given {
        tyre: Some(WITH_TYRE),
        ..Given::default()
    };
    for run in runs().iter().filter(|run| !run.rolls) {
        let mut worst = BTreeMap::new();
        run.each(|of, state| {
            let state = AxleState {
                compliance: Some(of_columns(of, state)),
                ..*state
            };
            for reading in state.readings(&given) {
                let path = reading.path();
                let bar = match reading.entity {
                    "roll_center_location" => 0.15,
                    "roll_steer" => 3e-4,
                    _ => continue,
                };
                let apart = (reading.value - of(&path)).abs();
                assert!(apart < bar, "{path}: {} {apart:e}", reading.value);
                let entry = worst.entry(path).or_insert(0.0);
                *entry = f64::max(*entry, apart);
            }
        });
        println!("{worst:?}");
        assert_eq!(worst.len(), 6);
    }
}

/// Checks steer axis columns against each other: the axis through K with the angles of the file gives I, offset, scrub and trail.
#[test]
fn steer_axes_of_real_results() {
    for run in runs().iter().filter(|run| !run.rolls) {
        run.each(|of, state| {
            for side in Side::BOTH {
                let w = side.word();
                let of = |name: &str| of(&name.replace('@', w));
                let (caster, kingpin) = (of("caster_angle.@"), of("kingpin_incl_angle.@"));
                let direction = Vec3::new(caster.tan(), -side.outboard_sign() * kingpin.tan(), 1.0);
                let vector =
                    |name: &str| Vec3::from(["X", "Y", "Z"].map(|c| of(&format!("{name}.@_{c}"))));
                let axis = SteerAxis {
                    point: vector("kingpin_location"),
                    direction: direction.normalize(),
                    pitch: 0.0,
                };
                let wheel = state.wheels[side.index()].unwrap();
                let moved = axis.location(&wheel.wheel.centre) - axis.point;
                assert!(moved.norm() < LENGTH, "{moved}");
                let offset = axis.offset(&wheel.wheel.centre);
                assert!((offset - of("steer_axis_offset.off_@")).abs() < LENGTH);
                let spin = &wheel.wheel.spin;
                let (lateral, along) = axis.offset_parts(side, &wheel.wheel.centre, spin);
                assert!((lateral - of("steer_axis_offset.lat_@")).abs() < LENGTH);
                assert!((along - of("steer_axis_offset.lon_@")).abs() < LENGTH);
                let contact = contact(&|name| of(name), side);
                let at = axis.road_point(&contact, &state.normal);
                let shown = Vec3::new(at.x - wheel.design.centre.x, at.y, at.z - contact.z);
                let told = vector("steer_axis_road_plane_intersection");
                // The column is relative to 3003, the hardpoint of the wheel centre.
                assert!((shown - told).norm() < 1e-6, "{shown} {told}");
                let steer = wheel::steer(&wheel.wheel.spin, &state.normal);
                let (scrub, trail) = axis.scrub_and_trail(side, &contact, &state.normal, steer);
                assert!((scrub - of("scrub_radius.@")).abs() < LENGTH);
                assert!((trail - of("caster_moment_arm.@")).abs() < LENGTH);
                let lead = axis.hub_lead(side, scrub, trail);
                assert!((lead - of("hub_lead.@")).abs() < LENGTH);
            }
        });
    }
}

#[track_caller]
fn same(a: f64, b: f64, what: &str) {
    assert!(
        (a - b).abs() <= IDENTITY * b.abs().max(1e-9),
        "{what}: {a} {b}"
    );
}

/// Checks identities between columns.
#[test]
fn identities_of_columns() {
    for run in runs() {
        run.each(|of, state| {
            let track = of("total_track.track");
            let susp = of("susp_roll_rate.suspension_roll_rate");
            let total = of("total_roll_rate.total_roll_rate");
            // T^2 / D and T^2 / (D + 2 / Kt).
            let opposed = track * track / susp;
            let on_tyres = opposed + 2.0 / TYRE;
            same(track * track / on_tyres, total, "total roll rate");
            for side in Side::BOTH {
                let w = side.word();
                let of = |name: &str| of(&format!("{name}.{w}"));
                let rate = of("wheel_rate");
                same(ride::ride_rate(rate, TYRE), of("ride_rate"), "ride rate");
                for (anti, height) in [
                    ("anti_dive_braking", "dive_braking"),
                    ("anti_lift_braking", "lift_braking"),
                    ("anti_lift_acceleration", "lift_acceleration"),
                    ("anti_squat_acceleration", "squat_acceleration"),
                ] {
                    let give = (1.0 - of(anti) / 100.0) / rate + 1.0 / TYRE;
                    let expected = WEIGHT * CG_HEIGHT / (2.0 * WHEELBASE) * give;
                    same(expected, of(height), height);
                }
                if run.rolls {
                    continue;
                }
                // Swing arms and roll coefficients give the same C43 / C33 and C53 / C33 without an anti-roll bar.
                let c33 = 1.0 / rate;
                let arm = |name: &str| {
                    let angle = of(&format!("{name}_swing_arm_angle"));
                    -1.0 / (of(&format!("{name}_swing_arm_length")) * angle.cos())
                };
                let camber = 1.0 + arm("fr_view") * c33 * track / on_tyres;
                same(camber, of("roll_camber_coefficient"), "roll camber");
                let caster = -side.outboard_sign() * arm("side_view") * c33 * track / on_tyres;
                same(caster, of("roll_caster_coefficient"), "roll caster");
            }
            let [l, r] = state.wheels.map(|w| w.unwrap());
            assert!(l.wheel.centre.y < 0.0 && r.wheel.centre.y > 0.0);
        });
    }
}

/// Checks the Ackermann columns in every state of a file, in the order of its states. A turn radius that is not evaluated keeps its last value.
#[test]
fn steering_geometry_of_real_results() {
    for run in runs() {
        let (mut evaluated, mut last_radius) = (0, None);
        run.each(|of, _| {
            let track = of("total_track.track");
            let steer = ["left", "right"].map(|w| of(&format!("steer_angle.{w}")));
            let all = Steering {
                steer,
                y: Side::BOTH.map(|side| contact(of, side).y),
                wheelbase: WHEELBASE,
                last_radius,
            };
            let radius = all.turn_radius();
            evaluated += usize::from(radius.is_some());
            last_radius = radius.or(last_radius);
            for side in Side::BOTH {
                let of = |name: &str| of(&format!("{name}.{}", side.word()));
                same(all.ackerman(), of("ackerman"), "ackerman");
                assert_eq!(radius.is_some(), of("ackerman_angle") != 0.0, "{steer:?}");
                same(all.kept_radius(), of("turn_radius"), "turn radius");
                same(all.ackerman_angle(), of("ackerman_angle"), "ackerman angle");
                same(all.ideal(side), of("ideal_steer_angle"), "ideal steer");
                let error = all.error(side) - of("ackerman_error");
                assert!(error.abs() < 1e-12, "ackerman error {error:e}");
                let diameter = all.outside_diameter(track);
                same(diameter, of("outside_turn_diameter"), "diameter");
                assert_eq!(all.percent(), of("percent_ackerman"));
            }
        });
        println!("{}: {evaluated} states evaluated", run.path.display());
    }
}

/// Checks that the command finds the wheels, and that its results equal those of the file.
#[test]
fn the_command_agrees_with_the_file() {
    for run in runs() {
        let output = Command::new(env!("CARGO_BIN_EXE_admire"))
            .arg("results")
            .arg(&run.path)
            .args([
                "--kc",
                "--wheel",
                "testrig.whl_wheel",
                "whr_wheel_XFORM",
                "--against-file",
                "--json",
            ])
            .output()
            .unwrap();
        assert!(output.status.success());
        let all: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let all = all.as_array().unwrap();
        assert!(all.len() > 25);
        for column in all
            .iter()
            .filter(|c| c["column"].as_str().unwrap().contains("toe_angle"))
        {
            assert!(column["largest"].as_f64().unwrap() < ANGLE, "{column}");
        }
    }
}
