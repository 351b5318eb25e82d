//! The compliance matrix and quantities computed from it, compared with finite differences and with sweeps, and checked for symmetry.

use admire_kc::{
    BenchError, Compliance, Drive, Hold, Inputs, Observation, Side, Unit, Variant, given, run,
    swing_arm,
};
use admire_solver::mechanics::{Vec3, Vec6, exp, log};

use crate::axles::{
    Axle, DOUBLE_WISHBONE, MCPHERSON, MULTILINK, corpus, double_wishbone, heading, largest,
    sprung_wishbone,
};

fn axles() -> Vec<(&'static str, Axle)> {
    vec![
        (
            "mcpherson",
            Axle::new(&corpus("pseudo-mcpherson/model.adm"), MCPHERSON),
        ),
        (
            "multilink",
            Axle::new(&corpus("multilink/reference.adm"), MULTILINK),
        ),
        ("wishbone", Axle::new(&double_wishbone(), DOUBLE_WISHBONE)),
    ]
}

const LOADED: Variant = Variant {
    height_held: false,
    steering_locked: true,
};
const HELD: Variant = Variant {
    height_held: true,
    steering_locked: true,
};

/// Returns inputs with these loads on both wheels.
fn loads(fx: f64, fy: f64, fz: f64, mz: f64) -> Inputs {
    Inputs {
        loads: [[fx, fy, fz, mz]; 2],
        ..Inputs::default()
    }
}

/// Returns the translation and the rotation of a wheel between two states. The rotation vector refers to the orientation halfway between them.
fn moved(from: &Observation, to: &Observation, side: Side) -> Vec6 {
    let wheel = |seen: &Observation| seen.axle.wheels[side.index()].unwrap().wheel;
    let (a, b) = (wheel(from), wheel(to));
    let shift = b.centre - a.centre;
    let turn = log(&(b.turn * a.turn.transpose()));
    // The rotation is expressed at half the angle.
    let turn = exp(&(turn * -0.5)) * turn;
    Vec6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
}

/// Computes a fourth-order central difference.
fn difference(mut at: impl FnMut(f64) -> Observation, step: f64, side: Side) -> Vec6 {
    let mut one = |h: f64| {
        let (minus, plus) = (at(-h), at(h));
        moved(&minus, &plus, side) / (2.0 * h)
    };
    let (coarse, fine) = (one(step), one(0.5 * step));
    (fine * 4.0 - coarse) / 3.0
}

/// Checks the columns of X, Y, Z and RZ of both wheels against finite differences of the statics, loaded and unloaded, at the wheel centre.
/// Loads along X and Y follow the heading of the wheel.
#[test]
fn the_matrix_is_the_derivative_of_the_statics() {
    for (name, axle) in axles() {
        let mut bench = axle.bench();
        for base in [
            loads(0.0, 0.0, 4500.0, 0.0),
            loads(800.0, -700.0, 5200.0, 2e4),
        ] {
            let mut chain = bench.chain(LOADED).unwrap();
            let centre = bench
                .observe(LOADED, &mut chain, &base, None, name)
                .unwrap();
            let c = centre.axle.compliance.unwrap();
            for loaded in Side::BOTH {
                let wheel = centre.axle.wheels[loaded.index()].unwrap().wheel;
                let [rearward, right] = heading(&wheel);
                for (k, column) in [(0, 1), (1, 2), (2, 3), (3, 6)] {
                    // Column of a load of this kind.
                    let of_load = |row| match k {
                        0 => along(&c, row, loaded, &rearward),
                        1 => along(&c, row, loaded, &right),
                        _ => c.of(row, (loaded, column)),
                    };
                    let step = if k == 3 { 1e4 } else { 30.0 };
                    for seen in Side::BOTH {
                        let by = difference(
                            |h| {
                                let mut inputs = base;
                                inputs.loads[loaded.index()][k] += h;
                                let mut chain = chain.clone();
                                bench
                                    .observe(LOADED, &mut chain, &inputs, None, name)
                                    .unwrap()
                            },
                            step,
                            seen,
                        );
                        // Largest entry of the column in a block of rows: translations, then rotations.
                        for block in [0, 3] {
                            let largest = (0..12)
                                .flat_map(|i| [0, 6].map(|o| (i, o)))
                                .filter(|(i, _)| i % 6 / 3 == block / 3)
                                .map(|(i, o)| c.c(i + 1, o + column).abs())
                                .fold(0.0, f64::max);
                            for i in block..block + 3 {
                                let exact = of_load((seen, i + 1));
                                let apart = (by[i] - exact).abs();
                                assert!(
                                    apart <= 1e-7 * largest,
                                    "{name} C({i}, {column}) {seen:?} by {loaded:?}: {exact:e} {:e}",
                                    by[i]
                                );
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Returns the displacement per unit force at the wheel centre in this direction.
fn along(c: &Compliance, row: (Side, usize), loaded: Side, force: &Vec3) -> f64 {
    let parts = force.iter().enumerate();
    parts
        .map(|(j, part)| c.of(row, (loaded, j + 1)) * part)
        .sum()
}

/// Checks the columns of RX and RY: a load in the road plane at the patch is a load at the centre together with its moment.
#[test]
fn moments_come_with_loads_at_the_patch() {
    for (name, axle) in axles() {
        let mut bench = axle.bench();
        let mut chain = bench.chain(LOADED).unwrap();
        let mut base = loads(0.0, 0.0, 4500.0, 0.0);
        (base.vertical_at_patch, base.plane_at_patch) = (true, true);
        for k in [0, 1] {
            let mut drive = Drive::default();
            drive.loads[0][k] = 1.0;
            let seen = bench
                .observe(LOADED, &mut chain, &base, Some(&drive), name)
                .unwrap();
            let contacts = seen.axle.contacts().unwrap();
            let wheel = seen.axle.wheels[0].unwrap().wheel;
            let d = contacts[0] - wheel.centre;
            let force = heading(&wheel)[k];
            let moment = d.cross(&force);
            let c = seen.axle.compliance.unwrap();
            let rate = seen.rates[0].unwrap().motion;
            for i in 1..=6 {
                let expected: f64 = (0..3)
                    .map(|j| {
                        c.of((Side::Left, i), (Side::Left, j + 1)) * force[j]
                            + c.of((Side::Left, i), (Side::Left, j + 4)) * moment[j]
                    })
                    .sum();
                let size = rate.fixed_rows::<3>(if i > 3 { 3 } else { 0 }).norm();
                assert!(
                    (rate[i - 1] - expected).abs() < 1e-10 * size,
                    "{name} {k} {i}"
                );
            }
        }
    }
}

/// Returns the multilink with its spin axis rotated about the X axis of the vehicle. Without this rotation, the camber has the same sign under
/// all loads.
fn leaning_multilink(lean: f64) -> Axle {
    let deck = corpus("multilink/reference.adm");
    let plain = Axle::new(&deck, MULTILINK);
    let mut markers = plain.model.markers.iter();
    let wheel = markers.find(|m| m.header.name == "WC").unwrap();
    let part = &plain.model.parts[wheel.part.0];
    let across: Vec3 = (part.pose.R * wheel.R).column(1).into();
    let axis = exp(&(Vec3::x() * lean)) * across;
    let on_axis = wheel.qp + part.pose.R.transpose() * axis * 100.0;
    let end = deck.trim_end().strip_suffix("END").unwrap();
    let deck = format!(
        "{end}MARKER/9001, PART = {}, QP = {:e}, {:e}, {:e}\nEND\n",
        part.header.id, on_axis.x, on_axis.y, on_axis.z
    );
    Axle::new(
        &deck,
        &MULTILINK.replace("spin = 'y'", "spin = 'MARKER/9001'"),
    )
}

/// Checks the slopes of a load sweep at the contact patch, as on a rig. They must equal the columns of the wheel centre at zero camber, where
/// the patch is straight below the centre.
#[test]
fn a_sweep_of_the_load_at_the_patch_has_the_slopes_of_the_columns_at_zero_camber() {
    let mut compared = 0;
    let leaning = ("leaning multilink", leaning_multilink(0.0048));
    for (name, axle) in axles().into_iter().chain([leaning]) {
        let mut bench = axle.bench();
        let mut chain = bench.chain(LOADED).unwrap();
        let mut at = |load: f64| {
            let mut inputs = loads(0.0, 0.0, load, 0.0);
            inputs.vertical_at_patch = true;
            bench.observe(LOADED, &mut chain, &inputs, Some(&Drive::default()), name)
        };
        let camber = |seen: &Observation| -seen.axle.wheels[0].unwrap().wheel.spin.z.asin();
        let ends = [1500.0, 7500.0].map(|load| at(load).ok().map(|seen| camber(&seen)));
        let [Some(low), Some(high)] = ends else {
            continue;
        };
        if low * high > 0.0 {
            println!("{name}: camber {low:.4} to {high:.4} rad, never zero");
            continue;
        }
        let (mut a, mut b) = (1500.0, 7500.0);
        for _ in 0..60 {
            let middle = 0.5 * (a + b);
            if camber(&at(middle).unwrap()) * low > 0.0 {
                a = middle;
            } else {
                b = middle;
            }
        }
        let seen = at(a).unwrap();
        assert!(camber(&seen).abs() < 1e-9);
        let c = seen.axle.compliance.unwrap();
        let mut slope = |of: fn(&Vec3) -> f64| {
            let mut one = |h: f64| {
                let [down, up] = [a - h, a + h]
                    .map(|load| of(&at(load).unwrap().axle.wheels[0].unwrap().wheel.centre));
                (up - down) / (2.0 * h)
            };
            (4.0 * one(20.0) - one(40.0)) / 3.0
        };
        for (row, of) in [
            (3, (|p| p.z) as fn(&Vec3) -> f64),
            (2, |p| p.y),
            (1, |p| p.x),
        ] {
            let column = |side| c.of((Side::Left, row), (side, 3));
            let (found, expected) = (slope(of), column(Side::Left) + column(Side::Right));
            let size = c.of((Side::Left, 3), (Side::Left, 3));
            let apart = (found - expected).abs() / size;
            println!("{name} {row}: {apart:.1e}");
            assert!(apart < 1e-5, "{name} {row}: {found:e} {expected:e}");
            compared += 1;
        }
    }
    // Three rows are compared for each of the three axles.
    assert_eq!(compared, 9);
}

/// Checks that the matrix is the same if motions hold the heights, and that a load then gives the locked columns.
#[test]
fn locked_and_free() {
    for (name, axle) in axles() {
        let mut bench = axle.bench();
        for at_patch in [false, true] {
            let mut base = loads(500.0, 600.0, 4500.0, 1e4);
            (base.vertical_at_patch, base.plane_at_patch) = (at_patch, at_patch);
            let mut chain = bench.chain(LOADED).unwrap();
            let free = bench
                .observe(LOADED, &mut chain, &base, None, name)
                .unwrap();
            let mut held_inputs = base;
            for side in Side::BOTH {
                let state = free.axle.wheels[side.index()].unwrap();
                held_inputs.height[side.index()] = state.wheel.centre.z - state.design.centre.z;
                held_inputs.loads[side.index()][2] = 0.0;
            }
            let mut held_chain = bench.chain(HELD).unwrap();
            held_chain.start_at(&chain);
            for k in [0, 1, 3] {
                let mut drive = Drive::default();
                drive.loads[0][k] = 1.0;
                let held = bench
                    .observe(HELD, &mut held_chain, &held_inputs, Some(&drive), name)
                    .unwrap();
                let (a, b) = (free.axle.compliance.unwrap(), held.axle.compliance.unwrap());
                let apart = scaled(&Compliance {
                    matrix: a.matrix - b.matrix,
                    ..a
                });
                assert!(apart < 1e-10 * scaled(&a), "{name} {at_patch}: {apart:e}");
                if at_patch {
                    continue;
                }
                for side in Side::BOTH {
                    let load = held.load[side.index()];
                    assert!((load - 4500.0).abs() < 1e-6, "{name} {load}");
                }
                let locked = b.height_held().unwrap();
                let column = if k == 3 { 6 } else { k + 1 };
                let heading = heading(&held.axle.wheels[0].unwrap().wheel);
                for side in Side::BOTH {
                    // The two sides of a mirrored axle are not coupled, and the other side is driven in the same way.
                    let rate = held.rates[side.index()].unwrap();
                    for i in 1..=6 {
                        let expected = match heading.get(k) {
                            Some(force) => along(&locked, (side, i), Side::Left, force),
                            None => locked.of((side, i), (Side::Left, column)),
                        };
                        let whole = locked.matrix.column(column - 1).into_owned();
                        let size = whole.iter().enumerate();
                        let size = size
                            .filter(|(row, _)| row % 6 / 3 == (i - 1) / 3)
                            .fold(0.0, |m: f64, x| m.max(x.1.abs()));
                        let apart = (rate.motion[i - 1] - expected).abs();
                        assert!(apart < 1e-10 * size, "{name} {k} {side:?} {i}: {apart:e}");
                    }
                }
            }
        }
    }
}

/// Returns the norm of a matrix with lengths in units of 100 mm.
fn scaled(c: &Compliance) -> f64 {
    let mut sum = 0.0;
    for i in 0..12_i32 {
        for j in 0..12_i32 {
            let power = i32::from(i % 6 > 2) + i32::from(j % 6 > 2);
            let entry = c.matrix[(i as usize, j as usize)] * 100f64.powi(power);
            sum += entry * entry;
        }
    }
    sum.sqrt()
}

/// Checks columns from the matrix against slopes of a sweep in which both wheel centres are driven up and down.
#[test]
fn columns_are_slopes_of_wheel_centre_sweeps() {
    for (name, axle) in axles() {
        let mut bench = axle.bench();
        let given = given(&axle.config, &axle.model.units);
        let mut chain = bench.chain(HELD).unwrap();
        let base = Inputs::default();
        let drive = Drive {
            height: [1.0; 2],
            ..Drive::default()
        };
        let centre = bench
            .observe(HELD, &mut chain, &base, Some(&drive), name)
            .unwrap();
        let read = |seen: &Observation, path: &str| {
            let all = seen.axle.readings(&given);
            all.iter()
                .find(|r| r.path() == path)
                .unwrap_or_else(|| panic!("{path}"))
                .value
        };
        let slope = |bench: &mut admire_kc::Bench<'_>, of: &dyn Fn(&Observation) -> f64| {
            let mut one = |h: f64| {
                let mut at = |h: f64| {
                    let inputs = Inputs {
                        height: [h; 2],
                        ..base
                    };
                    of(&bench
                        .observe(HELD, &mut chain.clone(), &inputs, None, name)
                        .unwrap())
                };
                (at(h) - at(-h)) / (2.0 * h)
            };
            (4.0 * one(0.5) - one(1.0)) / 3.0
        };
        let near = |what: &str, a: f64, b: f64| {
            assert!(
                (a - b).abs() <= 1e-6 * b.abs().max(1e-9),
                "{name} {what}: {a:e} {b:e}"
            );
        };
        for side in Side::BOTH {
            let (k, w) = (side.index(), side.word());
            let rate = slope(&mut bench, &|seen| seen.load[k]);
            near(
                "wheel rate",
                read(&centre, &format!("wheel_rate.{w}")),
                rate,
            );
            near("load rate", centre.rates[k].unwrap().load, rate);
            // These rates are those of functions of the pose, at any camber.
            let wheel = centre.axle.wheels[k].unwrap().wheel;
            let turn: Vec3 = centre.rates[k].unwrap().motion.fixed_rows::<3>(3).into();
            let exact = admire_kc::wheel::angle_rates(side, &wheel.spin, &turn);
            let toe = slope(&mut bench, &|seen| read(seen, &format!("toe_angle.{w}")));
            near("toe", exact.toe, toe);
            let camber = slope(&mut bench, &|seen| read(seen, &format!("camber_angle.{w}")));
            near("camber", exact.camber, camber);
            // The column of ride steer is the slope of the steer angle.
            let steer = slope(&mut bench, &|seen| read(seen, &format!("steer_angle.{w}")));
            near(
                "ride steer",
                read(&centre, &format!("ride_steer.{w}")),
                steer,
            );
            // The vertical loads are in phase, as the wheels are driven.
            let y = slope(&mut bench, &|seen| {
                seen.axle.wheels[k].unwrap().wheel.centre.y
            });
            let load = swing_arm::VerticalLoad::InPhase;
            let c = centre.axle.compliance.unwrap();
            let angle = swing_arm::front_view_angle(&c, side, load);
            near("front view", angle.tan(), side.outboard_sign() * y);
            let x = slope(&mut bench, &|seen| {
                seen.axle.wheels[k].unwrap().wheel.centre.x
            });
            near(
                "side view",
                swing_arm::side_view_angle(&c, side, load).tan(),
                -x,
            );
        }
    }
}

/// Checks a symmetric axle at ride height: in every column, left and right agree up to the signs of the definitions, to 1e-12 of the terms from
/// which a column is computed. Relative to the column itself, only small differences of large numbers exceed 1e-12. The test prints them; they
/// are at most 3e-12. The base change of 0.085 mm has an error of 1e-13 mm, two units in the last place of coordinates of 267 mm. The anti
/// effects have an error of 2e-13 of 100 percent.
#[test]
fn a_mirrored_axle_has_mirrored_columns() {
    let axle = Axle::new(&double_wishbone(), DOUBLE_WISHBONE);
    let mut bench = axle.bench();
    let run = run(&mut bench, &axle.model.units).unwrap();
    let value = |path: &str| {
        let all = &run.ride.readings;
        all.iter().find(|r| r.path() == path).map(|r| r.value)
    };
    let [moves, turns, twists] = largest(&run.ride.seen.axle.compliance.unwrap());
    let (mut compared, mut worst) = (0, 0.0);
    for reading in &run.ride.readings {
        let path = reading.path();
        let Some(other) = value(&path.replace("left", "right")) else {
            continue;
        };
        if !path.contains("left") || path.contains("ackerman") || path.contains("turn") {
            continue;
        }
        use admire_kc::Sense::{AboutX, AboutZ, ToTheRight, Y};
        let odd = matches!(reading.sense, Y | AboutX | AboutZ | ToTheRight);
        // Derivatives by the roll angle, which is itself odd, change parity: caster is opposite on the two sides, steer is equal.
        let odd = odd != (path.contains("roll_steer") || path.contains("roll_caster"));
        let sign = if odd { -1.0 } else { 1.0 };
        // Values from entries of the matrix are compared with the largest entry of its block, because entries of sides that cancel are small.
        let (mut a, mut b) = (reading.value, sign * other);
        let floor = match reading.unit {
            Unit::Angle | Unit::Length => 1.0,
            Unit::Percent => 100.0,
            Unit::Rate => {
                (a, b) = (1.0 / a, 1.0 / b);
                moves
            }
            Unit::LengthPerForce => moves,
            Unit::AnglePerForce => turns,
            Unit::AnglePerTorque => twists,
            Unit::AnglePerLength => turns / moves,
            _ => 1e-9,
        };
        let apart = (a - b).abs() / a.abs().max(floor);
        worst = f64::max(worst, apart);
        let own = (a - b).abs() / a.abs();
        // A nearly vanishing travel is round-off of positions in the deck.
        let is_round_off = matches!(reading.unit, Unit::Length) && a.abs().max(b.abs()) < 1e-9;
        assert!(
            a == b || own <= 1e-11 || is_round_off,
            "{path}: {own:.1e} of itself"
        );
        if own > 1e-12 {
            println!("{path}: {:e} {other:e}, {own:.1e} of itself", reading.value);
        }
        assert!(
            apart <= 1e-12,
            "{path}: {} {other} {apart:e}",
            reading.value
        );
        compared += 1;
    }
    println!("{worst:.1e}");
    assert!(compared > 50, "{compared}");
}

/// Checks that springs alone are conservative. Bushings under load are not, and the run states the asymmetry.
#[test]
fn symmetry_shows_conservative_forces() {
    let axle = Axle::new(&sprung_wishbone(), DOUBLE_WISHBONE);
    let mut bench = axle.bench();
    let mut chain = bench.chain(HELD).unwrap();
    let inputs = Inputs {
        height: [25.0, -10.0],
        ..Inputs::default()
    };
    let seen = bench
        .observe(HELD, &mut chain, &inputs, None, "springs")
        .unwrap();
    let c = seen.axle.compliance.unwrap();
    assert!(c.c(3, 3) > 1e-3);
    assert!(c.asymmetry(100.0) < 1e-10, "{:e}", c.asymmetry(100.0));
    for (name, axle) in axles() {
        let mut bench = axle.bench();
        let run = run(&mut bench, &axle.model.units).unwrap();
        println!("{name}: asymmetry {:e}", run.asymmetry);
        assert!(run.asymmetry < 0.05);
    }
}

/// Checks that a freely spinning wheel and a steering without resistance are refused, with the name of the motion.
#[test]
fn what_is_free_is_named() {
    let refused = |deck: &str, toml: &str| {
        let axle = Axle::new(deck, toml);
        let mut bench = axle.bench();
        match run(&mut bench, &axle.model.units) {
            Err(BenchError::Free { motion, at }) => format!("{at}: {motion}"),
            other => panic!("{:?}", other.map(|_| ())),
        }
    };
    // The wheel on a bearing is given as the carrier.
    let deck = double_wishbone();
    let bearing =
        "MARKER/138, PART = 13, QP = -267, -760, 330, ZP = -267, -660, 330, XP = -167, -760, 330
!   adams_view_name='left_wheel'
PART/15, MASS = 15, CM = 153, IP = 1E5, 1E5, 2E5
MARKER/153, PART = 15, QP = -267, -760, 330, ZP = -267, -660, 330, XP = -167, -760, 330
JOINT/17, REVOLUTE, I = 153, J = 138
END";
    let deck = deck.trim_end().strip_suffix("END").unwrap().to_string() + bearing;
    let toml = DOUBLE_WISHBONE
        .replace("MARKER/130", "MARKER/153")
        .replace("'MARKER/134'", "'z'");
    let motion = refused(&deck, &toml);
    assert!(
        motion.contains("ride height: PART/15 'left_wheel' spins freely"),
        "{motion}"
    );
    // The rack slides freely: on rigid links without weight, load or spring, nothing returns the wheels.
    let kinematic = corpus("double-wishbone/model.adm");
    let toml = DOUBLE_WISHBONE.replace(
        "[tests.steering]\nrange",
        "[tests.bounce]\nsteering = 'free'\n[tests.steering]\nrun = false\nrange",
    );
    let motion = refused(&kinematic, &toml);
    assert!(
        motion.contains("test bounce") && motion.contains("rack"),
        "{motion}"
    );
}

/// Checks that both branches of every test are equal without friction.
#[test]
fn branches_close() {
    for (name, axle) in axles() {
        let mut bench = axle.bench();
        let run = run(&mut bench, &axle.model.units).unwrap();
        assert!(run.tests.len() >= 8);
        for test in &run.tests {
            let n = test.settings.points;
            assert_eq!(test.samples.len(), 2 * n);
            for k in 0..n {
                let (up, down) = (&test.samples[k], &test.samples[2 * n - 1 - k]);
                assert_eq!(up.value, down.value);
                for side in 0..2 {
                    let p = |s: &admire_kc::Sample| s.seen.axle.wheels[side].unwrap().wheel;
                    let apart = (p(up).centre - p(down).centre).norm();
                    assert!(apart < 1e-7, "{name} {}: {apart:e}", test.kind.name());
                }
            }
            for gradient in &test.gradients {
                let large = test
                    .samples
                    .iter()
                    .map(|s| s.value.abs())
                    .fold(0.0, f64::max);
                assert!(gradient.hysteresis < 1e-6 * (1.0 + gradient.tangent.abs() * large));
            }
            assert_eq!(
                test.settings.hold == Hold::Height,
                matches!(test.kind.name(), "bounce" | "roll" | "steering")
            );
        }
    }
}
