//! State carried from one load case to the next: the anchor of a friction or creep element. The anchor is the displacement at which the spring
//! of the element is unstretched.
//!
//! The force law itself is an ordinary FUNCTION of the deck. This module advances only the anchor and its derivatives, so a fit of a whole load
//! sequence has exact sensitivities.

use nalgebra::DMatrix;

use super::unknown::Direction;
use admire_solver::element::Slip;
use admire_solver::system::{Parameters, Slot};

/// Rule by which a load case changes the anchor of a spring. `u` is the displacement of the spring in that load case.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Evolution {
    /// Return map of a slider, see [`Slip`]. The parameter is the stretch of the spring at which the slider moves.
    Slider,
    /// Relaxation: the anchor `c` moves to `c + r (u - c)`. The parameter `r` is a fraction between zero and one.
    Flow,
}

/// A spring of the deck whose anchor depends on the load history.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct HysteresisState {
    /// Slot of the anchor, the displacement at which the spring is unstretched. Its value in the deck is the anchor before the first case.
    pub anchor: Slot,
    /// Evolution law of the anchor.
    pub carries: Evolution,
    /// Slot of the parameter of the evolution law.
    pub by: Slot,
    /// Index of the channel that measures the displacement of the spring.
    pub channel: usize,
}

/// Anchors before a load case and their derivatives with respect to the unknowns.
#[derive(Clone, Debug)]
pub(super) struct Carried<'a> {
    memories: &'a [HysteresisState],
    anchors: Vec<f64>,
    /// Derivatives of each anchor, as `[anchor][direction]`.
    by: Vec<Vec<f64>>,
}

impl<'a> Carried<'a> {
    /// Returns the anchors and their derivatives before the first case. `theta` holds the parameter values of the deck.
    pub(super) fn new(
        memories: &'a [HysteresisState],
        theta: &Parameters,
        directions: Option<&[Direction]>,
    ) -> Self {
        let weight = |direction: &Direction, slot: Slot| -> f64 {
            let own = direction.always.iter().filter(|(of, _)| *of == slot);
            own.map(|(_, weight)| weight).sum()
        };
        Self {
            memories,
            anchors: memories.iter().map(|m| theta.get(m.anchor)).collect(),
            by: memories
                .iter()
                .map(|m| {
                    let directions = directions.unwrap_or_default();
                    directions.iter().map(|d| weight(d, m.anchor)).collect()
                })
                .collect(),
        }
    }

    /// Writes the anchors into the parameter values `theta` of a case.
    pub(super) fn apply(&self, theta: &mut Parameters) {
        for (memory, anchor) in self.memories.iter().zip(&self.anchors) {
            theta.set(memory.anchor, *anchor);
        }
    }

    /// Returns the directions of one case, with the derivatives of the anchors included. `room` is reused storage.
    pub(super) fn directions<'d>(
        &self,
        directions: &'d [Direction],
        case: usize,
        room: &'d mut Vec<Direction>,
    ) -> &'d [Direction] {
        if self.memories.is_empty() {
            return directions;
        }
        let is_anchor = |slot: Slot| self.memories.iter().any(|m| m.anchor == slot);
        room.resize_with(directions.len(), Direction::default);
        for (k, (direction, out)) in directions.iter().zip(&mut *room).enumerate() {
            out.unknown = direction.unknown;
            out.turns.clone_from(&direction.turns);
            let own = direction.in_case(case);
            let memories = self.memories.iter().zip(&self.by);
            let carried = memories.map(|(memory, by)| (memory.anchor, by[k]));
            out.always.clear();
            out.always.extend(own.filter(|(slot, _)| !is_anchor(*slot)));
            out.always.extend(carried.filter(|(_, by)| *by != 0.0));
        }
        room
    }

    /// Advances the anchors and their derivatives after a case. `channels` holds the channel values; `changes` holds one column of channel
    /// derivatives per entry of `directions`. Both `directions` and `changes` are empty if no derivatives are needed.
    pub(super) fn advance(
        &mut self,
        theta: &Parameters,
        channels: &[f64],
        directions: &[Direction],
        changes: &DMatrix<f64>,
    ) {
        for (k, memory) in self.memories.iter().enumerate() {
            let (u, number) = (channels[memory.channel], theta.get(memory.by));
            let before = self.anchors[k];
            // New anchor, and its derivatives with respect to the old anchor, the displacement u and the parameter.
            let (after, by_anchor, by_u, by_number) = match memory.carries {
                Evolution::Slider => {
                    // With a stiffness of 1, the slip force equals the stretch at which the slider moves.
                    let slip = Slip::at(u, &[1.0, number.abs(), before]);
                    if !slip.slides(before) {
                        continue;
                    }
                    (slip.anchor_after, 0.0, 1.0, -slip.force.signum())
                }
                Evolution::Flow => {
                    let rate = number.clamp(0.0, 1.0);
                    let inside = if rate == number { u - before } else { 0.0 };
                    (before + rate * (u - before), 1.0 - rate, rate, inside)
                }
            };
            self.anchors[k] = after;
            let changes = changes.column_iter();
            for ((by, direction), change) in self.by[k].iter_mut().zip(directions).zip(changes) {
                let own = direction.always.iter();
                let of_number: f64 = own
                    .filter(|(slot, _)| *slot == memory.by)
                    .map(|(_, weight)| weight)
                    .sum();
                *by = by_anchor * *by + by_u * change[memory.channel] + by_number * of_number;
            }
        }
    }
}
