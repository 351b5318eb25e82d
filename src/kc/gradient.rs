//! Slopes of test readings at ride height: the exact tangent, and a line fitted over a window as on physical rigs.

use super::axle::WheelState;
use super::bench::Observation;
use super::sample::{Branch, Sample};
use super::wheel::angle_rates;
use super::wheel_rate::WheelRate;
use super::{Sense, Side, Unit};
use admire_solver::mechanics::Vec3;

/// Slope of one reading with respect to the test's variable.
#[derive(Clone, PartialEq, Debug)]
pub struct Gradient {
    /// Request name of the reading.
    pub entity: &'static str,
    /// Name of the request's component.
    pub component: &'static str,
    /// Unit of the reading; the slope is in this unit per unit of the test's variable.
    pub unit: Unit,
    /// Meaning of the reading's sign.
    pub sense: Sense,
    /// Side of the wheel.
    pub side: Side,
    /// Exact derivative at ride height.
    pub tangent: f64,
    /// Slope of the least-squares line within the window, averaged over both branches if the test has two. NaN with fewer than two points.
    pub fitted: f64,
    /// Half the height of the hysteresis loop at ride height; zero without a second branch.
    pub hysteresis: f64,
    /// Values of the variable, `[below, above]` ride height, up to which the reading follows its tangent. The tolerance is 5 percent of the
    /// whole change or 10 percent of the local change, whichever is larger.
    pub linear_range: [f64; 2],
}

impl Gradient {
    /// Returns the excess of this wheel's slope over the other wheel's slope, relative to their mean. It is zero for a symmetric axle in a
    /// symmetric or antisymmetric test, and NaN for a single wheel.
    pub fn asymmetry(&self, all: &[Self]) -> f64 {
        let mut others = all.iter();
        let other = others.find(|g| g.entity == self.entity && g.side != self.side);
        other.map_or(f64::NAN, |other| {
            let (a, b) = (self.tangent.abs(), other.tangent.abs());
            if a + b > 0.0 {
                2.0 * (a - b) / (a + b)
            } else {
                0.0
            }
        })
    }
}

/// Returns half the height of a measured hysteresis loop at zero of its variable. The points (variable, reading) are in the order driven.
/// NaN if the loop crosses zero fewer than twice.
pub fn loop_half_width(points: &[(f64, f64)]) -> f64 {
    let mut low = f64::INFINITY;
    let mut high = f64::NEG_INFINITY;
    let mut count = 0;
    let mut seen = |value: f64| {
        (low, high) = (low.min(value), high.max(value));
        count += 1;
    };
    for (k, (x, y)) in points.iter().enumerate() {
        if *x == 0.0 {
            seen(*y);
        } else if let Some((next, after)) = points.get(k + 1)
            && x * next < 0.0
        {
            seen(y + (after - y) * x / (x - next));
        }
    }
    if count < 2 {
        f64::NAN
    } else {
        0.5 * (high - low)
    }
}

/// Reading that has a gradient.
struct Channel {
    entity: &'static str,
    component: [&'static str; 2],
    unit: Unit,
    sense: Sense,
    /// Computes the reading's rate from the wheel's motion and load rates.
    rate: fn(&Rate) -> f64,
}

struct Rate {
    side: Side,
    spin: Vec3,
    shift: Vec3,
    turn: Vec3,
    load: f64,
}

/// Returns true if [`reading_change`] has the derivatives of this characteristic, given as its path, such as `toe_angle.left`.
pub fn has_reading_change(path: &str) -> bool {
    channel(path).is_some()
}

/// Returns the derivative of a characteristic in a sample along change `direction` of [`Bench::differentiate`](super::Bench::differentiate).
///
/// The derivative is exact: the chain rule over the motion of the wheel and its vertical load. `path` is the path of the characteristic, such as
/// `toe_angle.left`. The result is in the unit of the characteristic, with angles in radians. `None` for a characteristic that depends on more than
/// the wheel's position and load, and for a missing wheel or direction.
pub fn reading_change(sample: &Sample, direction: usize, path: &str) -> Option<f64> {
    let (channel, side) = channel(path)?;
    let state = sample.seen.axle.wheels[side.index()]?;
    let rate = sample.changes.get(direction)?[side.index()]?;
    Some((channel.rate)(&Rate::of(side, &state, channel, &rate)))
}

/// Returns the channel of a characteristic, and the side of the wheel.
fn channel(path: &str) -> Option<(&'static Channel, Side)> {
    let (entity, component) = path.split_once('.')?;
    let channel = CHANNELS.iter().find(|channel| channel.entity == entity)?;
    let side = channel.component.iter().position(|own| *own == component)?;
    Some((channel, Side::BOTH[side]))
}

impl Rate {
    fn of(side: Side, state: &WheelState, channel: &Channel, rate: &WheelRate) -> Self {
        let mut turn = rate.motion.fixed_rows::<3>(3).into_owned();
        if channel.entity == "side_view_angle" {
            turn.y = side_view_rate(&state.wheel.turn, &turn);
        }
        Self {
            side,
            spin: state.wheel.spin,
            shift: rate.motion.fixed_rows::<3>(0).into(),
            turn,
            load: rate.load,
        }
    }
}

const CHANNELS: [Channel; 8] = [
    Channel {
        entity: "toe_angle",
        component: ["left", "right"],
        unit: Unit::Angle,
        sense: Sense::Own,
        rate: |r| angle_rates(r.side, &r.spin, &r.turn).toe,
    },
    Channel {
        entity: "camber_angle",
        component: ["left", "right"],
        unit: Unit::Angle,
        sense: Sense::Own,
        rate: |r| angle_rates(r.side, &r.spin, &r.turn).camber,
    },
    Channel {
        entity: "steer_angle",
        component: ["left", "right"],
        unit: Unit::Angle,
        sense: Sense::ToTheRight,
        rate: |r| angle_rates(r.side, &r.spin, &r.turn).steer,
    },
    Channel {
        entity: "side_view_angle",
        component: ["left", "right"],
        unit: Unit::Angle,
        sense: Sense::Own,
        // At design this rate is the rotation about Y itself. In other states, `side_view_rate` corrects it for the rotation since design.
        rate: |r| r.turn.y,
    },
    Channel {
        entity: "wheel_travel",
        component: ["vertical_left", "vertical_right"],
        unit: Unit::Length,
        sense: Sense::Own,
        rate: |r| r.shift.z,
    },
    Channel {
        entity: "wheel_travel_base",
        component: ["base_left", "base_right"],
        unit: Unit::Length,
        sense: Sense::X,
        rate: |r| r.shift.x,
    },
    Channel {
        entity: "wheel_travel_track",
        component: ["track_left", "track_right"],
        unit: Unit::Length,
        sense: Sense::Y,
        rate: |r| r.shift.y,
    },
    Channel {
        entity: "wheel_load_vertical_force",
        component: ["vertical_left_force", "vertical_right_force"],
        unit: Unit::Force,
        sense: Sense::Own,
        rate: |r| r.load,
    },
];

/// Computes the gradients of a test from its tangent at ride height and its samples.
pub(crate) fn gradients(centre: &Observation, samples: &[Sample], window: f64) -> Vec<Gradient> {
    let mut out = Vec::new();
    for channel in &CHANNELS {
        for side in Side::BOTH {
            let k = side.index();
            let (Some(state), Some(rate)) = (centre.axle.wheels[k], centre.rates[k]) else {
                continue;
            };
            let rate = Rate::of(side, &state, channel, &rate);
            let tangent = (channel.rate)(&rate);
            let component = channel.component[k];
            let points = |branch: Branch| -> Vec<(f64, f64)> {
                samples
                    .iter()
                    .filter(|sample| sample.branch == branch)
                    .filter_map(|sample| {
                        let mut all = sample.readings.iter();
                        let found =
                            all.find(|r| r.entity == channel.entity && r.component == component)?;
                        Some((sample.value, found.value))
                    })
                    .collect()
            };
            let (up, down) = (points(Branch::Up), points(Branch::Down));
            let slopes = [&up, &down].map(|points| fitted_slope(points, window));
            let fitted = if slopes[1].is_finite() {
                0.5 * (slopes[0] + slopes[1])
            } else {
                slopes[0]
            };
            let hysteresis = match (at_zero(&up), at_zero(&down)) {
                (Some(a), Some(b)) => 0.5 * (b - a).abs(),
                _ => 0.0,
            };
            out.push(Gradient {
                entity: channel.entity,
                component,
                unit: channel.unit,
                sense: channel.sense,
                side,
                tangent,
                fitted,
                hysteresis,
                linear_range: linear_range(&up, tangent),
            });
        }
    }
    out
}

/// Returns the rate of the side-view angle `-atan(A31 / A11)` for a rotation rate `w` of the carrier, from `dA = [w]x A`.
fn side_view_rate(A: &admire_solver::mechanics::Mat3, w: &Vec3) -> f64 {
    let column: Vec3 = A.column(0).into();
    let d = w.cross(&column);
    let (z, x) = (column.z, column.x);
    -(d.z * x - z * d.x) / (x * x + z * z)
}

/// Returns the slope of the least-squares line through the points within the window; NaN with fewer than two points.
pub fn fitted_slope(points: &[(f64, f64)], window: f64) -> f64 {
    let inside: Vec<_> = points
        .iter()
        .filter(|p| p.0.abs() <= window * (1.0 + 1e-9))
        .collect();
    if inside.len() < 2 {
        return f64::NAN;
    }
    let n = inside.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| inside.iter().map(|p| f(p)).sum::<f64>() / n;
    let (mx, my) = (mean(|p| p.0), mean(|p| p.1));
    let (mut xy, mut xx) = (0.0, 0.0);
    for (x, y) in inside {
        xy += (x - mx) * (y - my);
        xx += (x - mx) * (x - mx);
    }
    xy / xx
}

/// Interpolates the reading at zero of the variable, linearly between the neighbouring points.
fn at_zero(points: &[(f64, f64)]) -> Option<f64> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    sorted.windows(2).find_map(|pair| {
        let [(a, ya), (b, yb)] = pair else {
            return None;
        };
        (*a <= 0.0 && *b >= 0.0 && b > a).then(|| ya + (yb - ya) * (0.0 - a) / (b - a))
    })
}

/// Returns the variable's values at the last points below and above zero that still follow the tangent.
fn linear_range(points: &[(f64, f64)], tangent: f64) -> [f64; 2] {
    let Some(zero) = at_zero(points) else {
        return [f64::NAN; 2];
    };
    let change = |y: f64| (y - zero).abs();
    let whole = points.iter().map(|p| change(p.1)).fold(0.0, f64::max);
    let straight = |&&(x, y): &&(f64, f64)| {
        let away = (y - zero - tangent * x).abs();
        away <= (0.05 * whole).max(0.1 * change(y))
    };
    let mut below: Vec<_> = points.iter().filter(|p| p.0 < 0.0).collect();
    below.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut above: Vec<_> = points.iter().filter(|p| p.0 > 0.0).collect();
    above.sort_by(|a, b| a.0.total_cmp(&b.0));
    [below, above].map(|side| {
        side.iter()
            .copied()
            .take_while(straight)
            .last()
            .map_or(0.0, |p| p.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A loop driven up one line and down a parallel line has the slope of these lines. Its half height is half the distance between them.
    #[test]
    fn a_loop_of_two_lines() {
        let up = (-4..=4).map(|k| (f64::from(k), 0.3 * f64::from(k) + 0.1));
        let down = (-4..=4)
            .rev()
            .map(|k| (f64::from(k) + 0.5, 0.3 * (f64::from(k) + 0.5) - 0.1));
        let points: Vec<(f64, f64)> = up.clone().chain(down).collect();
        assert!((loop_half_width(&points) - 0.1).abs() < 1e-12);
        let up: Vec<(f64, f64)> = up.collect();
        assert!((fitted_slope(&up, 2.0) - 0.3).abs() < 1e-12);
        assert!(loop_half_width(&up).is_nan());
        assert!(fitted_slope(&up, 0.5).is_nan());
    }

    #[test]
    fn the_linear_range_ends_where_a_stop_begins() {
        let stop = |x: f64| if x > 2.0 { x + 3.0 * (x - 2.0) } else { x };
        let points: Vec<(f64, f64)> = (-5..=5)
            .map(|k| (f64::from(k), stop(f64::from(k))))
            .collect();
        assert_eq!(linear_range(&points, 1.0), [-5.0, 2.0]);
    }
}
