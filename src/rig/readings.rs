//! What the instruments of a virtual rig read: poses become marks, wheel and channels, with noise and with faults.

use super::effect::{ReadingFault, Reality};
use super::measurement::{MarkedPart, Measurement};
use super::noise::Noise;
use super::virtual_rig::{Rest, place};
use super::wheel::WheelReading;
use crate::mechanics::Vec3;
use crate::model::Model;

/// What is read in every case: marks by part and mark, the wheel, the channels; and the marks as the first session lists them.
pub(super) struct Readings {
    /// By part and mark, in the part's frame.
    pub listed: Vec<Vec<Vec3>>,
    /// By case, part and mark, in ground.
    pub marks: Vec<Vec<Vec<Vec3>>>,
    /// By case.
    pub wheel: Vec<Option<WheelReading>>,
    /// By case and channel.
    pub channels: Vec<Vec<f64>>,
}

impl Readings {
    /// Reads every case once. Each kind of noise has its own stream, so that no effect changes the noise.
    pub fn new(
        measured: &Measurement,
        reality: &Reality,
        rest: &[Rest],
        seed: u64,
        exact: bool,
    ) -> Self {
        let on = if exact { 0.0 } else { 1.0 };
        let mut first_session = Noise::new(seed, "marks on parts");
        let mut second_session = Noise::new(seed, "marks measured");
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
        // The wheel marker is the deck's; the reality may hold more markers, never fewer.
        let model = reality.model();
        let (mut marks, mut wheel, mut channels) = (Vec::new(), Vec::new(), Vec::new());
        for (case, at) in rest.iter().enumerate() {
            let mut seen = true_marks(reality, &model, measured, at);
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
                        // Marks are read in the order of their list.
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
                *x += second_session.vector(measured.sigma);
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
                    .relative_to
                    .map_or(0.0, |case| rest[case].channels[k]);
                let mut value = at.channels[k] - before + sensors.normal() * channel.sigma * on;
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

/// Where the marks really are, each on the part it moves with.
fn true_marks(
    reality: &Reality,
    model: &Model,
    measured: &Measurement,
    at: &Rest,
) -> Vec<Vec<Vec3>> {
    let of_part = |(part, marked): (&MarkedPart, &super::effect::Marked)| {
        let carriers = part.marks.iter().zip(&marked.carriers);
        carriers
            .map(|(mark, id)| {
                let carrier = model.parts.iter().position(|part| part.header.id == *id);
                at.poses[carrier.unwrap_or(part.part.0)].point(&mark.p)
            })
            .collect()
    };
    let parts = measured.parts.iter().zip(&reality.marks);
    parts.map(of_part).collect()
}
