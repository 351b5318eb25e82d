//! Standard tests: sweeps of equilibria on the rig.

use super::Side;
use super::axle::Given;
use super::bench::{Bench, Observation, Observed, WarmStart, WheelChanges};
use super::bench_error::BenchError;
use super::config::Config;
use super::gradient::{Gradient, gradients};
use super::inputs::{Drive, Inputs};
use super::rig::Variant;
use super::sample::{Branch, Sample};
use super::test_kind::{Driven, TestKind};
use super::test_settings::{Branches, Hold, LoadPoint, TestSettings};
use super::wheel_rate::WheelRate;
use admire_solver::statics::Balance;
use admire_syntax::units::Units;

/// Results of one test.
#[derive(Clone, PartialEq, Debug)]
pub struct TestRun {
    /// Kind of test.
    pub kind: TestKind,
    /// Settings of the test.
    pub settings: TestSettings,
    /// Samples in the order driven.
    pub samples: Vec<Sample>,
    /// Slopes at ride height.
    pub gradients: Vec<Gradient>,
}

/// Results of all tests of a deck.
#[derive(Clone, PartialEq, Debug)]
pub struct KcRun {
    /// Sample at ride height without driven input.
    pub ride: Sample,
    /// Results of the tests.
    pub tests: Vec<TestRun>,
    /// Relative asymmetry of the compliance matrix at ride height.
    pub asymmetry: f64,
    /// Worst imbalance of forces and torques on a part over all states of the axle. The loads on each part are summed independently of the
    /// solver.
    pub balance: Balance,
}

/// Collects the data of the configuration that the characteristics need.
pub fn given(config: &Config, units: &Units) -> Given {
    // One g in units of the deck.
    let g = 9.80665 / units.length.si * units.time.si * units.time.si;
    let mass = config.vehicle.map_or(0.0, |v| v.sprung_mass);
    Given {
        tyre: config.tyre,
        vehicle: config.vehicle,
        weight: mass * g / units.ucf,
        corner_mass: config.ride_load.map_or(0.0, |load| load / g),
        vertical_load: config.vertical_load,
        last_turn_radius: None,
    }
}

/// Ride height: heights of the wheel centres above design, and the vertical loads there.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Ride {
    height: [f64; 2],
    load: [f64; 2],
}

/// Runs every test of the configuration.
///
/// # Errors
/// [`BenchError`] with the test and the point where it occurred.
pub fn run(bench: &mut Bench<'_>, units: &Units) -> Result<KcRun, BenchError> {
    run_watched(bench, units, &mut |_, _| {})
}

/// Runs every test of the configuration. `progress` is called with the number of states found so far and the total.
///
/// # Errors
/// As [`run`].
pub fn run_watched(
    bench: &mut Bench<'_>,
    units: &Units,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<KcRun, BenchError> {
    let config = bench.config;
    let most = config
        .tests
        .iter()
        .map(|(_, settings)| states(config, settings))
        .sum();
    let mut found = 0;
    let mut each = || {
        found += 1;
        progress(found, most);
    };
    let given = given(bench.config, units);
    let (ride, base, along) = ride(bench)?;
    let inputs = Inputs {
        height: ride.height,
        ..Inputs::default()
    };
    let held = Variant::of(Hold::Height, true);
    let ride_inputs = Inputs {
        vertical_at_patch: bench.config.tyre.is_some(),
        ..inputs
    };
    let mut chain = base.clone();
    let at_height: Vec<Drive> = along.iter().map(RideChange::heights).collect();
    let found = bench.observe_along(
        held,
        &mut chain,
        &ride_inputs,
        (None, &at_height),
        "ride height",
    )?;
    let length = 0.1 / units.length.si;
    let asymmetry = found
        .seen
        .axle
        .compliance
        .map_or(0.0, |compliance| compliance.asymmetry(length));
    let at_ride = Sample::of(Branch::Up, 0.0, (ride_inputs, found), &mut { given });
    let mut tests = Vec::new();
    for (kind, settings) in bench.config.tests.clone() {
        tests.push(test(
            bench,
            (kind, settings),
            (&ride, &along, &chain),
            &given,
            &mut each,
        )?);
    }
    Ok(KcRun {
        ride: at_ride,
        tests,
        asymmetry,
        balance: bench.balance(),
    })
}

/// Derivative of ride height with respect to one of the changes along which states are differentiated.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
struct RideChange {
    height: [f64; 2],
    load: [f64; 2],
}

impl RideChange {
    /// Returns the change of the inputs at ride height, where the rig holds the heights.
    fn heights(&self) -> Drive {
        Drive {
            height: self.height,
            ..Drive::default()
        }
    }
}

/// Finds ride height and its derivatives. The height follows from the load if the configuration gives a load.
fn ride(bench: &mut Bench<'_>) -> Result<(Ride, WarmStart, Vec<RideChange>), BenchError> {
    let none = vec![Drive::default(); bench.directions()];
    let each = |of: fn(&WheelRate) -> f64| {
        move |change: &WheelChanges| change.map(|rate| rate.map_or(0.0, |rate| of(&rate)))
    };
    let config = bench.config;
    let at = "ride height";
    let vertical_at_patch = config.tyre.is_some();
    let held = Variant::of(Hold::Height, true);
    let mut height = [config.ride_height; 2];
    if let Some(load) = config.ride_load {
        let loaded = Variant::of(Hold::Load, true);
        let mut chain = bench.chain(loaded)?;
        let inputs = Inputs {
            loads: [[0.0, 0.0, load, 0.0]; 2],
            vertical_at_patch,
            ..Inputs::default()
        };
        let Observed { seen, changes, .. } =
            bench.observe_along(loaded, &mut chain, &inputs, (None, &none), at)?;
        let rises = changes.iter().map(each(|rate| rate.motion[2]));
        let along = rises.map(|height| RideChange {
            height,
            load: [0.0; 2],
        });
        let along = along.collect();
        for side in Side::BOTH {
            if let Some(state) = &seen.axle.wheels[side.index()] {
                height[side.index()] = state.wheel.centre.z - state.design.centre.z;
            }
        }
        let mut held_chain = bench.chain(held)?;
        held_chain.start_at(&chain);
        let ride = Ride {
            height,
            load: [load; 2],
        };
        return Ok((ride, held_chain, along));
    }
    let mut chain = bench.chain(held)?;
    let inputs = Inputs {
        height,
        vertical_at_patch,
        ..Inputs::default()
    };
    let Observed { seen, changes, .. } =
        bench.observe_along(held, &mut chain, &inputs, (None, &none), at)?;
    let load = seen.load;
    let loads = changes.iter().map(each(|rate| rate.load));
    let along = loads.map(|load| RideChange {
        height: [0.0; 2],
        load,
    });
    Ok((Ride { height, load }, chain, along.collect()))
}

/// Returns the change of the inputs per unit of the test's variable. `wheels` are the wheels in the deck.
fn drive(kind: TestKind, wheels: &[Side], mirror: bool) -> Drive {
    let mut drive = Drive::default();
    let mut on_loads = |k: usize, both: [f64; 2]| {
        for side in Side::BOTH {
            drive.loads[side.index()][k] = both[side.index()];
        }
    };
    match kind.driven() {
        Driven::Height(both) => drive.height = both,
        Driven::Steering => drive.steer = 1.0,
        Driven::Fx(both) => on_loads(0, both),
        Driven::Fy(both) => {
            // The single loaded wheel is the left wheel, or the only wheel of the deck.
            let lone = kind == TestKind::LateralSingle && !mirror && wheels == [Side::Right];
            on_loads(1, if lone { [0.0, 1.0] } else { both });
        }
        Driven::Mz(both) => on_loads(3, both),
    }
    drive
}

/// Returns the values of a test's variable in ascending order.
fn grid(settings: &TestSettings) -> Vec<f64> {
    let [low, high] = settings.range;
    let steps = settings.points - 1;
    (0..=steps)
        .map(|k| low + (high - low) * k as f64 / steps as f64)
        .map(|value| {
            if value.abs() < 1e-12 * high.abs().max(low.abs()) {
                0.0
            } else {
                value
            }
        })
        .collect()
}

/// Returns the values on the way from ride height down to the lowest value, both excluded.
fn way_down(settings: &TestSettings, grid: &[f64]) -> Vec<f64> {
    let below = |v: &f64| *v < 0.0 && *v > settings.range[0];
    grid.iter().copied().filter(below).rev().collect()
}

/// Counts the states that a test solves: ride height, the way down, the way up, and the way down again.
fn states(config: &Config, settings: &TestSettings) -> usize {
    let grid = grid(settings);
    let branches = if config.branches == Branches::Both {
        2
    } else {
        1
    };
    1 + way_down(settings, &grid).len() + branches * grid.len()
}

/// State of a test while it runs.
struct Course<'a> {
    config: &'a Config,
    kind: TestKind,
    settings: TestSettings,
    variant: Variant,
    drive: Drive,
    ride: &'a Ride,
    /// Derivatives of ride height.
    along: &'a [RideChange],
    /// Common rise of both wheels that keeps the axle's load constant.
    rise: f64,
}

/// Drive that raises both wheels equally.
const HEAVE: Drive = Drive {
    height: [1.0; 2],
    loads: [[0.0; 4]; 2],
    steer: 0.0,
};

impl Course<'_> {
    /// Describes the test and the value of its variable in words, for error messages.
    fn at(&self, value: f64, units: &Units) -> String {
        let unit = match self.kind.driven() {
            Driven::Steering => String::new(),
            _ => format!(" {}", self.kind.unit(units)),
        };
        format!(
            "test {}, {} {value}{unit}",
            self.kind.name(),
            self.kind.variable()
        )
    }

    /// Returns true for a roll test that holds the axle's load constant.
    fn keeps_axle_load(&self) -> bool {
        self.kind == TestKind::Roll && self.settings.hold == Hold::Load
    }

    /// Returns the inputs of the rig at a value of the test's variable.
    fn inputs(&self, value: f64) -> Inputs {
        let (settings, patch) = (&self.settings, self.config.tyre.is_some());
        let drives_heights = matches!(self.kind.driven(), Driven::Height(_) | Driven::Steering);
        let mut inputs = Inputs {
            height: self.ride.height,
            vertical_at_patch: if drives_heights {
                settings.point == LoadPoint::Patch
            } else {
                patch
            },
            plane_at_patch: settings.point == LoadPoint::Patch,
            ..Inputs::default()
        };
        if self.kind == TestKind::Steering {
            inputs.steer = Some(value);
        }
        for k in 0..2 {
            inputs.height[k] += self.drive.height[k] * value + self.rise;
            for (load, per_unit) in inputs.loads[k].iter_mut().zip(self.drive.loads[k]) {
                *load = per_unit * value;
            }
            if !self.variant.height_held {
                inputs.loads[k][2] += self.ride.load[k];
            }
        }
        inputs
    }

    /// Returns the inputs at a value of the test's variable, including the common rise that keeps the axle's load constant. The states
    /// stored in the chain are not changed.
    fn placed(
        &mut self,
        bench: &mut Bench<'_>,
        chain: &WarmStart,
        value: f64,
    ) -> Result<Inputs, BenchError> {
        /// Largest number of Newton steps.
        const ROUNDS: usize = 20;
        /// Height change that counts as zero, relative to the tyre radius, or to 100 length units without tyre data.
        const NONE: f64 = 1e-8;
        if !self.keeps_axle_load() {
            return Ok(self.inputs(value));
        }
        let least = NONE * self.config.tyre.map_or(100.0, |tyre| tyre.radius);
        let at = self.at(value, bench.units());
        for _ in 0..ROUNDS {
            let mut trial = chain.clone();
            let inputs = self.inputs(value);
            let seen = bench.observe(self.variant, &mut trial, &inputs, Some(&HEAVE), &at)?;
            let sum = |of: [f64; 2]| of[0] + of[1];
            let rate = sum(seen.rates.map(|rate| rate.map_or(0.0, |rate| rate.load)));
            let step = (sum(self.ride.load) - sum(seen.load)) / rate;
            if !step.is_finite() {
                break;
            }
            self.rise += step;
            if step.abs() <= least {
                return Ok(self.inputs(value));
            }
        }
        Err(BenchError::NoAxleLoad { at })
    }

    /// Returns the change of the inputs per unit of the variable at `inputs`, including the common rise that keeps the axle's load constant.
    fn direction(
        &self,
        bench: &mut Bench<'_>,
        chain: &WarmStart,
        inputs: &Inputs,
        at: &str,
    ) -> Result<Drive, BenchError> {
        let mut drive = self.drive;
        if self.keeps_axle_load() {
            let mut load = |drive: &Drive| -> Result<f64, BenchError> {
                let seen =
                    bench.observe(self.variant, &mut chain.clone(), inputs, Some(drive), at)?;
                Ok(seen.rates.iter().flatten().map(|rate| rate.load).sum())
            };
            let rise = -load(&self.drive)? / load(&HEAVE)?;
            drive.height.iter_mut().for_each(|height| *height += rise);
        }
        Ok(drive)
    }

    /// Returns the change of the inputs per unit of each change of the deck along which states are differentiated.
    fn changing_inputs(
        &self,
        bench: &mut Bench<'_>,
        chain: &WarmStart,
        inputs: &Inputs,
        at: &str,
    ) -> Result<Vec<Drive>, BenchError> {
        let mut drives: Vec<Drive> = self.along.iter().map(RideChange::heights).collect();
        if !self.variant.height_held {
            for (drive, ride) in drives.iter_mut().zip(self.along) {
                for k in 0..2 {
                    drive.loads[k][2] = ride.load[k];
                }
            }
        }
        if self.keeps_axle_load() && !drives.is_empty() {
            // The common rise keeps the load of the axle equal to its load at ride height.
            let sum = |of: &WheelChanges| of.iter().flatten().map(|rate| rate.load).sum::<f64>();
            let mut chain = chain.clone();
            let Observed { seen, changes, .. } = bench.observe_along(
                self.variant,
                &mut chain,
                inputs,
                (Some(&HEAVE), &drives),
                at,
            )?;
            let rate = sum(&seen.rates);
            for ((drive, ride), change) in drives.iter_mut().zip(self.along).zip(&changes) {
                let rise = (ride.load[0] + ride.load[1] - sum(change)) / rate;
                drive.height.iter_mut().for_each(|height| *height += rise);
            }
        }
        Ok(drives)
    }

    /// Solves and evaluates the state at a value of the test's variable, with its derivatives along the changes of the bench. Also computes
    /// tangents if `tangents` is true.
    fn observe(
        &mut self,
        bench: &mut Bench<'_>,
        chain: &mut WarmStart,
        (value, tangents): (f64, bool),
    ) -> Result<(Inputs, Observed), BenchError> {
        let at = self.at(value, bench.units());
        let inputs = self.placed(bench, chain, value)?;
        let drive = if tangents {
            Some(self.direction(bench, chain, &inputs, &at)?)
        } else {
            None
        };
        let along = self.changing_inputs(bench, chain, &inputs, &at)?;
        let drives = (drive.as_ref(), along.as_slice());
        let found = bench.observe_along(self.variant, chain, &inputs, drives, &at)?;
        Ok((inputs, found))
    }
}

/// Repeats the loop of the test until it closes. The recorded samples then do not depend on the path by which the axle reached ride height.
fn settle_loop(
    course: &mut Course<'_>,
    bench: &mut Bench<'_>,
    chain: &mut WarmStart,
    grid: &[f64],
) -> Result<(), BenchError> {
    /// Largest number of loops; convergence is slow if joints slide in only part of the loop.
    const LOOPS: usize = 60;
    /// Largest change of a unit spin axis between two loops at which the loop counts as closed. For a wheel centre, the limit is 100 times this
    /// number, in length units.
    const NONE: f64 = 1e-10;
    let back = grid.iter().rev().skip(1);
    let way: Vec<f64> = grid.iter().skip(1).chain(back).copied().collect();
    let mut before: Option<Observation> = None;
    for _ in 0..LOOPS {
        for &value in &way[..way.len() - 1] {
            let inputs = course.placed(bench, chain, value)?;
            bench.settle(
                course.variant,
                chain,
                &inputs,
                &course.at(value, bench.units()),
            )?;
        }
        let (_, Observed { seen, .. }) = course.observe(bench, chain, (grid[0], false))?;
        let closes = before.is_some_and(|before| {
            let wheels = before.axle.wheels.iter().zip(&seen.axle.wheels);
            wheels
                .filter_map(|(a, b)| a.as_ref().zip(b.as_ref()))
                .all(|(a, b)| {
                    let (a, b) = (&a.wheel, &b.wheel);
                    let moved = (a.centre - b.centre).norm() <= 100.0 * NONE;
                    moved && (a.spin - b.spin).norm() <= NONE
                })
        });
        if closes {
            break;
        }
        before = Some(seen);
    }
    Ok(())
}

fn test(
    bench: &mut Bench<'_>,
    (kind, settings): (TestKind, TestSettings),
    (ride, along, base): (&Ride, &[RideChange], &WarmStart),
    given: &Given,
    each: &mut dyn FnMut(),
) -> Result<TestRun, BenchError> {
    let config = bench.config;
    let sides: Vec<Side> = bench.wheels.iter().map(|wheel| wheel.side).collect();
    let mut course = Course {
        config,
        kind,
        settings,
        variant: Variant::of_test(kind, &settings),
        drive: drive(kind, &sides, config.mirror),
        ride,
        along,
        rise: 0.0,
    };
    let mut chain = bench.chain(course.variant)?;
    chain.start_at(base);
    bench.enable_friction(course.variant, &mut chain)?;
    // The order is: ride height with tangents, down to the lowest value, up to the highest, and down again.
    let (_, found) = course.observe(bench, &mut chain, (0.0, true))?;
    let mut centre = found.seen;
    each();
    let grid = grid(&settings);
    for value in way_down(&settings, &grid) {
        let inputs = course.placed(bench, &chain, value)?;
        bench.settle(
            course.variant,
            &mut chain,
            &inputs,
            &course.at(value, bench.units()),
        )?;
        each();
    }
    let rubs = centre.friction.is_some();
    if rubs {
        settle_loop(&mut course, bench, &mut chain, &grid)?;
    }
    // With friction, the tangent is the mean over both branches of the tangents at the grid point nearest to ride height.
    let nearest = grid
        .iter()
        .copied()
        .min_by(|a, b| a.abs().total_cmp(&b.abs()));
    let mut branches = Vec::new();
    let mut samples = Vec::new();
    let mut given = *given;
    let mut go = |bench: &mut Bench<'_>, branch, value: f64| -> Result<(), BenchError> {
        let tangents = rubs && nearest == Some(value);
        let (inputs, found) = course.observe(bench, &mut chain, (value, tangents))?;
        if tangents {
            branches.push(found.seen.rates);
        }
        samples.push(Sample::of(branch, value, (inputs, found), &mut given));
        each();
        Ok(())
    };
    for &value in &grid {
        go(bench, Branch::Up, value)?;
    }
    if config.branches == Branches::Both {
        for &value in grid.iter().rev() {
            go(bench, Branch::Down, value)?;
        }
    }
    if rubs {
        for k in 0..2 {
            let all: Vec<WheelRate> = branches.iter().filter_map(|rates| rates[k]).collect();
            centre.rates[k] = WheelRate::mean(&all);
        }
    }
    let gradients = gradients(&centre, &samples, settings.window);
    Ok(TestRun {
        kind,
        settings,
        samples,
        gradients,
    })
}
