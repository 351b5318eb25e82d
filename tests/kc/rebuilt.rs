//! All columns of a real lateral test, computed from the deck that `admire rebuild` makes of the results.

use std::collections::BTreeMap;

use admire_kc::{Compliance, Drive, Inputs, Side, Variant, given};
use admire_rebuild::{Rebuilt, rebuild};

use crate::axles::{Axle, corpus};
use crate::real::{Run, runs};

const HELD: Variant = Variant {
    height_held: true,
    steering_locked: true,
};

/// Returns the index of the body whose name ends with these letters.
fn body(rebuilt: &Rebuilt, name: &str) -> usize {
    let bodies = &rebuilt.record.bodies;
    bodies
        .iter()
        .position(|body| body.name.ends_with(name))
        .expect(name)
}

/// Returns the deck with markers at both wheel centres and on the spin axes, and its `kc.toml`.
fn on_rig(rebuilt: &Rebuilt, run: &Run) -> (String, String) {
    let deck = &rebuilt.deck;
    let mut text = deck.text.replace("\nEND\n", "\n");
    let design = run.steps[0].1;
    let mut sides = String::new();
    for side in Side::BOTH {
        let k = side.index();
        let letter = &side.word()[..1];
        let wheel = body(rebuilt, &format!("wh{letter}_wheel"));
        let part = deck.parts[wheel];
        let at = &design.wheels[k].unwrap().design;
        let frame = rebuilt.record.bodies[wheel].design;
        let ids = [9001 + 10 * k, 9002 + 10 * k];
        for (id, place) in ids
            .into_iter()
            .zip([at.centre, at.centre + at.spin * 100.0])
        {
            let local = frame.R.transpose() * (place - frame.p);
            text += &format!(
                "MARKER/{id}, PART = {part}, QP = {:?}, {:?}, {:?}\n",
                local.x, local.y, local.z
            );
        }
        // The lower end of the strut on its arm.
        let arm = body(rebuilt, &format!("ge{letter}_arm"));
        let lock = rebuilt.mechanism.members.iter().find_map(|member| {
            let name = &rebuilt.record.elements[member.connection.element].name;
            let end = match (member.connection.i == arm, member.connection.j == arm) {
                (true, _) => "i",
                (_, true) => "j",
                _ => return None,
            };
            name.ends_with(&format!("bg{letter}_strut_lower.field"))
                .then(|| format!("{name}_{end}"))
        });
        let lock = lock.expect("the lower end of the strut");
        sides += &format!(
            "[wheels.{}]\ncentre = 'MARKER/{}'\nspin = 'MARKER/{}'\ntravel_lock = '{lock}'\n",
            side.word(),
            ids[0],
            ids[1]
        );
    }
    text += "END\n";
    let tyres: Vec<String> = deck
        .addresses
        .iter()
        .filter(|(element, _)| {
            let name = &rebuilt.record.elements[*element].name;
            name.ends_with("til_wheel.force") || name.ends_with("tir_wheel.force")
        })
        .map(|(_, address)| format!("'{address}'"))
        .collect();
    assert_eq!(tyres.len(), 2);
    let toml = format!(
        "[deck]\nwithout = [{}]\n{sides}[tyre]\nradius = 317.25\nstiffness = 202.0\n[vehicle]\nwheelbase = 2700.0\ncg_height = 500.0\nsprung_mass = 1600.0\nfront_brake = 0.45\nfront_drive = 0.0\naxle = 'rear'\n[choices]\nsteer_axis = 'instant-moment'\n",
        tyres.join(", ")
    );
    (text, toml)
}

/// Columns of the steer axis and of steering by forces, travel and roll. They are small differences of compliances.
const STEERING: [&str; 14] = [
    "alt_camber_compliance",
    "alt_steer_compliance",
    "caster_angle",
    "caster_moment_arm",
    "hub_lead",
    "kingpin_incl_angle",
    "kingpin_location",
    "lat_force_camber_compliance",
    "lat_force_defl_compliance",
    "lat_force_steer_compliance",
    "ride_steer",
    "roll_steer",
    "scrub_radius",
    "steer_axis_road_plane_intersection",
];

/// Columns that follow from the positions of the wheels, without any compliance.
const PLACES: [&str; 19] = [
    "ackerman",
    "ackerman_angle",
    "ackerman_error",
    "camber_angle",
    "ideal_steer_angle",
    "inclination_angle",
    "left_tire_contact_point",
    "outside_turn_diameter",
    "percent_ackerman",
    "right_tire_contact_point",
    "roll_angle",
    "side_view_angle",
    "steer_angle",
    "toe_angle",
    "total_track",
    "turn_radius",
    "wheel_travel_base",
    "wheel_travel_track",
    "wheelenv_output",
];

/// Returns the largest allowed error of a column, relative to its largest value: at design, in the states 10 to 90, and in all 101 states.
///
/// The errors are due to the slopes of the rebuilt curves; forces and positions agree.
/// - At design, the deflections of the left wheel's rubber lie on the straight part of its curves. On the right, some states are so close to
///   zero that errors of 3e-4 N in the preloads of the radial curves change the slope.
/// - Between the states, a curve has the slope of its neighbouring points, whereas the true curve bends.
/// - At the ends of the visited range, the slope is known from one side only. The radial deflection of an outer bushing ends at 3.88 mm, in
///   state 0 on the left and in state 100 on the right.
fn bars(path: &str, entity: &str) -> [f64; 3] {
    let bars = match entity {
        _ if PLACES.contains(&entity) => [5e-6; 3],
        // Its longitudinal part is 15 mm; the axis is 90 mm away.
        "steer_axis_offset" => [2e-3, 2e-2, 0.2],
        _ if STEERING.contains(&entity) => [5e-4, 5e-3, 5e-2],
        _ => [2e-5, 1e-3, 2e-3],
    };
    let component = path.split_once('.').map_or("", |(_, component)| component);
    let is_left = component == "left" || component.starts_with("left_");
    [if is_left { 2e-6 } else { bars[0] }, bars[1], bars[2]]
}

/// Errors of one column: the largest value in the file, and the largest errors at design, in the states 10 to 90, and in all states.
#[derive(Default)]
struct Errors {
    size: f64,
    apart: [f64; 3],
}

/// Checks every column in every state. The rig gets the heights of the wheels and the lateral forces of the file; the wheel loads are computed.
#[test]
fn columns_of_a_rebuilt_deck() {
    for run in runs().iter().filter(|run| !run.rolls) {
        let rebuilt = rebuild(&[&run.path], &[]).value.expect("a deck");
        let (deck, toml) = on_rig(&rebuilt, run);
        let axle = Axle::new(&deck, &toml);
        let mut bench = axle.bench();
        let mut chain = bench.chain(HELD).unwrap();
        let mut given = given(&axle.config, &axle.model.units);
        let mut columns: BTreeMap<(String, &str), Errors> = BTreeMap::new();
        let mut number = 0;
        run.each(|of, state| {
            let mut inputs = Inputs {
                vertical_at_patch: true,
                plane_at_patch: true,
                ..Inputs::default()
            };
            for side in Side::BOTH {
                let wheel = state.wheels[side.index()].unwrap();
                inputs.height[side.index()] = wheel.wheel.centre.z - wheel.design.centre.z;
                let lateral = of(&format!("wheel_load_lateral.lateral_{}", side.word()));
                inputs.loads[side.index()] = [0.0, -lateral, 0.0, 0.0];
            }
            let seen = bench
                .observe(
                    HELD,
                    &mut chain,
                    &inputs,
                    Some(&Drive::default()),
                    "rebuilt",
                )
                .unwrap();
            for side in Side::BOTH {
                let normal = of(&format!("{}_tire_forces.normal", side.word()));
                let apart = (seen.load[side.index()] - normal).abs();
                assert!(apart < 1e-3, "{number}: {apart:e} N");
            }
            if number == 50 {
                matrix_at_design(&seen.axle.compliance.unwrap());
            }
            for reading in seen.axle.readings(&given) {
                let path = reading.path();
                if !run.columns.contains_key(&path) {
                    continue;
                }
                if reading.entity == "turn_radius" {
                    given.last_turn_radius = Some(reading.value);
                }
                let real = of(&path);
                let errors = columns.entry((path, reading.entity)).or_default();
                errors.size = errors.size.max(real.abs());
                let within = [number == 50, (10..=90).contains(&number), true];
                for (most, _) in errors.apart.iter_mut().zip(within).filter(|(_, is)| *is) {
                    *most = most.max((reading.value - real).abs());
                }
            }
            number += 1;
        });
        assert_eq!((number, columns.len()), (101, 137));
        for ((path, entity), errors) in &columns {
            // Heights are inputs, both wheels are at the same height, and the steer axis is intersected with the road.
            let zero = [
                "wheel_travel.vertical",
                "roll_angle.at_wheel",
                "intersection.left_Z",
                "intersection.right_Z",
            ];
            if zero.iter().any(|zero| path.contains(zero)) {
                assert!(errors.apart[2] < 1e-9, "{path}");
                continue;
            }
            let shares = errors.apart.map(|apart| apart / errors.size);
            println!(
                "{path:50} {:8.1e} {:8.1e} {:8.1e}",
                shares[0], shares[1], shares[2]
            );
            for (share, bar) in shares.into_iter().zip(bars(path, entity)) {
                assert!(share < bar, "{path}: {shares:?}");
            }
        }
    }
}

/// Checks the compliance of the left wheel centre at design, by the axle's own deck (mm, N, rad).
fn matrix_at_design(compliance: &Compliance) {
    const REAL: [[f64; 6]; 6] = include!("../../src/kc/golden_compliance.in");
    for (i, row) in REAL.iter().enumerate() {
        for (j, real) in row.iter().enumerate() {
            // Entries are scaled by the geometric mean of the diagonal, so that displacements and rotations are comparable.
            let size = (REAL[i][i] * REAL[j][j]).sqrt();
            let apart = (compliance.c(i + 1, j + 1) - real).abs() / size;
            assert!(apart < 1e-6, "C{}{}: {apart:e}", i + 1, j + 1);
        }
    }
}

/// Checks the shipped axle at its design position. Its bushings are linear there, like the real ones; the right wheel is the mirror image of the
/// left.
#[test]
fn the_shipped_axle_has_the_real_columns_at_design() {
    let axle = Axle::new(
        &corpus("adams-car-axle/model.adm"),
        &corpus("adams-car-axle/kc.toml"),
    );
    let mut bench = axle.bench();
    let mut chain = bench.chain(HELD).unwrap();
    let inputs = Inputs {
        vertical_at_patch: true,
        plane_at_patch: true,
        ..Inputs::default()
    };
    let seen = bench
        .observe(HELD, &mut chain, &inputs, None, "design")
        .unwrap();
    let readings = seen.axle.readings(&given(&axle.config, &axle.model.units));
    for (path, real) in [
        ("wheel_rate.left", 40.081291),
        ("ride_rate.left", 33.44505),
        ("lat_force_defl_compliance.left", 6.4794647e-4),
        ("lat_force_steer_compliance.left", -4.7432468e-7),
        ("lat_force_camber_compliance.left", 1.1595939e-5),
        ("alt_steer_compliance.left", 5.9443882e-9),
        ("alt_camber_compliance.left", -2.1004222e-9),
        ("fore_aft_wheel_center_stiffness.left", 2873.5307),
        ("ride_steer.left", 3.1819939e-5),
        ("roll_steer.left", -0.020424842),
        ("roll_camber_coefficient.left", 0.68420145),
        ("roll_caster_coefficient.left", -1.3862784),
        ("roll_center_location.vertical", 138.67375),
    ] {
        let reading = readings.iter().find(|reading| reading.path() == path);
        let value = reading.expect(path).value;
        let apart = (value / real - 1.0).abs();
        // The real wheels differ by 0.2 percent, which appears in columns of both wheels.
        let bar = if path.starts_with("roll") { 2e-3 } else { 1e-5 };
        assert!(apart < bar, "{path}: {value} {real} {apart:e}");
    }
}
