//! Readings of a virtual rig: conversion of equilibria to readings of marks (measured points), wheel and channels (scalar sensors), with noise
//! and faults.

use super::effect::{GroundTruth, ReadingFault};
use super::frame_motion::FrameMotion;
use super::rest::{Rest, place};
use super::rig_options::RigOptions;
use admire_solver::mechanics::{Vec3, exp};
use admire_solver::model::Model;
use admire_study::{MarkedPart, Measurement, Noise, WheelReading};

/// Readings of all load cases, and the positions of the marks on their parts that the first session lists.
pub(super) struct Readings {
    /// Listed position of each mark in the frame of its part, as `[part][mark]`.
    pub listed: Vec<Vec<Vec3>>,
    /// Measured position of each mark in ground, as `[case][part][mark]`.
    pub marks: Vec<Vec<Vec<Vec3>>>,
    /// Wheel reading of each case.
    pub wheel: Vec<Option<WheelReading>>,
    /// Channel readings, as `[case][channel]`.
    pub channels: Vec<Vec<f64>>,
}

impl Readings {
    /// Computes the readings of all load cases. Each kind of noise has its own random stream, so planted effects do not change the noise. If
    /// `exact` is true, no noise is added to the listed marks, the wheel and the channels.
    pub(crate) fn new(
        measured: &Measurement,
        reality: &GroundTruth,
        rest: &[Rest],
        options: &RigOptions,
        exact: bool,
    ) -> Self {
        let (seed, tolerances) = (options.seed, &options.tolerances);
        let on = if exact { 0.0 } else { 1.0 };
        let mut first_session = Noise::new(seed, "marks on parts");
        let mut second_session = Noise::new(seed, "marks measured");
        let mut of_poses = Noise::new(seed, "poses");
        let mut of_frames = Noise::new(seed, "frames");
        let motion = FrameMotion::new(tolerances, seed, &reality.programme);
        let mut centre: Option<Vec3> = None;
        let mut at_wheel = Noise::new(seed, "wheel");
        let mut sensors = Noise::new(seed, "readings");
        let on_parts = measured.sigma_on_parts * on;
        let listed = measured
            .parts
            .iter()
            .map(|part| {
                part.marks
                    .iter()
                    .map(|m| m.p + first_session.vector(on_parts))
                    .collect()
            })
            .collect();
        let places = places_on_parts(measured, seed, tolerances.marks_on_parts);
        // The index of the wheel marker in the original deck is valid in this model as well, because effects only append markers.
        let model = reality.model();
        let (mut marks, mut wheel, mut channels) = (Vec::new(), Vec::new(), Vec::new());
        for (case, at) in rest.iter().enumerate() {
            let mut seen = true_marks(reality, &model, measured, (&places, case, at));
            for part in &mut seen {
                moved(
                    part.iter_mut().collect(),
                    &mut of_poses,
                    (tolerances.pose, tolerances.pose_deg),
                );
            }
            if let Some(motion) = &motion {
                let (shift, turn) = motion.under(&reality.programme.cases[case].values);
                let count = seen.iter().flatten().count().max(1) as f64;
                let of_all = || seen.iter().flatten().sum::<Vec3>() / count;
                let centre = *centre.get_or_insert_with(of_all);
                for x in seen.iter_mut().flatten() {
                    *x = centre + shift + turn * (*x - centre);
                }
            }
            moved(
                seen.iter_mut().flatten().collect(),
                &mut of_frames,
                (tolerances.frame, tolerances.frame_deg),
            );
            for fault in &reality.faults {
                if let ReadingFault::Frame {
                    case: of,
                    pose,
                    creep,
                } = fault
                    && *of == case
                {
                    let last = (seen.iter().flatten().count() - 1).max(1) as f64;
                    for (k, x) in seen.iter_mut().flatten().enumerate() {
                        // The marks are measured one after the other in this order.
                        let share = 1.0 + creep * (k as f64 / last - 0.5);
                        *x += (pose.point(x) - *x) * share;
                    }
                }
            }
            for fault in &reality.faults {
                if let ReadingFault::Growth { growth } = fault {
                    let share = case as f64 / (rest.len() - 1).max(1) as f64;
                    for x in seen.iter_mut().flatten() {
                        *x *= 1.0 + growth * share;
                    }
                }
            }
            for x in seen.iter_mut().flatten() {
                *x += second_session.student_t_vector(options.scatter.tails, measured.sigma);
            }
            for fault in &reality.faults {
                if let ReadingFault::Mark {
                    case: of,
                    part,
                    mark,
                    shift,
                } = fault
                    && *of == case
                {
                    seen[*part][*mark] += shift;
                }
                if let ReadingFault::Exchanged {
                    first,
                    parts: [a, b],
                    pairs,
                } = fault
                    && case >= *first
                {
                    for (i, j) in pairs {
                        let kept = seen[*a][*i];
                        seen[*a][*i] = seen[*b][*j];
                        seen[*b][*j] = kept;
                    }
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
                let before = channel
                    .reference(case)
                    .map_or(0.0, |case| rest[case].channels[k]);
                let mut value = at.channels[k] - before + sensors.normal() * channel.sigma * on;
                if let Some(summary) = &channel.summary {
                    let of =
                        |k: usize| summary.cases.iter().map(|c| rest[*c].channels[k]).collect();
                    let curve: Vec<f64> = of(k);
                    let taken = summary.take(&curve, &of).value;
                    value += taken - (at.channels[k] - before);
                }
                for fault in &reality.faults {
                    if let ReadingFault::Channel {
                        channel,
                        gain,
                        offset,
                        case: of,
                    } = fault
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

/// Displaces points together as a rigid body, by a random shift and a random rotation about their mean. The standard deviations are `length`
/// and `angle_deg`.
fn moved(mut points: Vec<&mut Vec3>, noise: &mut Noise, (length, angle_deg): (f64, f64)) {
    let shift = noise.vector(length);
    let turn = exp(&noise.vector(angle_deg.to_radians()));
    let centre = points.iter().map(|x| **x).sum::<Vec3>() / points.len().max(1) as f64;
    if length > 0.0 || angle_deg > 0.0 {
        for x in &mut points {
            **x = centre + shift + turn * (**x - centre);
        }
    }
}

/// Returns the true positions of the marks in ground, as `[part][mark]`. Each mark moves with the part that actually carries it.
fn true_marks(
    reality: &GroundTruth,
    model: &Model,
    measured: &Measurement,
    (places, case, at): (&[Vec<Vec3>], usize, &Rest),
) -> Vec<Vec<Vec3>> {
    let moved = |own: (usize, usize)| {
        let faults = reality.faults.iter();
        let by = faults.filter_map(|fault| match fault {
            ReadingFault::Place {
                first,
                part,
                mark,
                shift,
            } if (*part, *mark) == own && case >= *first => Some(shift),
            _ => None,
        });
        by.sum::<Vec3>()
    };
    let of_part = |(k, part): (usize, &MarkedPart)| {
        let carriers = places[k].iter().zip(&reality.marks[k].carriers).enumerate();
        carriers
            .map(|(mark, (place, id))| {
                let carrier = model.parts.iter().position(|part| part.header.id == *id);
                let pose = &at.poses[carrier.unwrap_or(part.part.0)];
                pose.point(&(place + moved((k, mark))))
            })
            .collect()
    };
    measured.parts.iter().enumerate().map(of_part).collect()
}

/// Returns the true positions of the marks on their parts, as `[part][mark]`: the positions in the original study plus random errors.
fn places_on_parts(measured: &Measurement, seed: u64, sigma: f64) -> Vec<Vec<Vec3>> {
    let mut noise = Noise::new(seed, "places of marks");
    let mut of_part = |part: &MarkedPart| {
        let marks = part.marks.iter();
        marks.map(|mark| mark.p + noise.vector(sigma)).collect()
    };
    measured.parts.iter().map(&mut of_part).collect()
}
