//! What a load case leaves to the next: where the spring of a slider, or rubber that flows, is unstretched.
//!
//! The force law itself is an ordinary FUNCTION of the deck; only where its spring is unstretched is carried along here, with its
//! derivatives, so that a fit of a whole load sequence has exact sensitivities.

use nalgebra::DMatrix;

use super::unknown::Direction;
use admire_solver::element::Slip;
use admire_solver::system::{Parameters, Slot};

/// How the place moves on after a case in which the displacement was `u`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Evolution {
    /// By the return map of [`Slip`]; the number is the length the spring stretches before the slider moves.
    Slider,
    /// `c + r (u - c)`; the number is `r`, a part of the way between zero and one.
    Flow,
}

/// A spring of the deck that remembers.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct HysteresisState {
    /// The displacement at which its spring is unstretched; what the deck says holds before the first case.
    pub anchor: Slot,
    /// How that moves on.
    pub carries: Evolution,
    /// The number it moves on by.
    pub by: Slot,
    /// The channel that measures the displacement.
    pub channel: usize,
}

/// Where the anchors stand before a case, and how that depends on the unknowns.
#[derive(Clone, Debug)]
pub(super) struct Carried<'a> {
    memories: &'a [HysteresisState],
    anchors: Vec<f64>,
    /// Per memory one derivative per direction.
    by: Vec<Vec<f64>>,
}

impl<'a> Carried<'a> {
    /// Before the first case.
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

    /// Puts the anchors into the numbers of a case.
    pub(super) fn apply(&self, theta: &mut Parameters) {
        for (memory, anchor) in self.memories.iter().zip(&self.anchors) {
            theta.set(memory.anchor, *anchor);
        }
    }

    /// The directions of one case with the anchors' share, made in `room`.
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

    /// Moves the anchors on after a case: `channels` are its values, the columns of `changes` their change along each of the case's
    /// `directions`; empty if nobody asked.
    pub(super) fn advance(
        &mut self,
        theta: &Parameters,
        channels: &[f64],
        (directions, changes): (&[Direction], &DMatrix<f64>),
    ) {
        for (k, memory) in self.memories.iter().enumerate() {
            let (u, number) = (channels[memory.channel], theta.get(memory.by));
            let before = self.anchors[k];
            // What the anchor becomes, and its derivatives by itself before, by u and by the number.
            let (after, by_anchor, by_u, by_number) = match memory.carries {
                Evolution::Slider => {
                    // A spring of unit stiffness slides at a force that is its length.
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
