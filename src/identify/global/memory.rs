//! Contacts that remember: a spring in series with a slider, whose anchor each load case leaves to the next.
//!
//! The force law itself is an ordinary FUNCTION of the deck; only where its spring is unstretched is carried along here, with its
//! derivatives, so that a fit of a whole load sequence has exact sensitivities.

use std::borrow::Cow;

use super::unknown::Direction;
use crate::element::Slip;
use crate::system::{Parameters, Slot};

/// A slider of the deck.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Memory {
    /// The displacement at which its spring is unstretched; what the deck says holds before the first case.
    pub anchor: Slot,
    /// How far the spring stretches before the slider moves.
    pub length: Slot,
    /// The channel that measures the displacement.
    pub channel: usize,
}

/// Where the anchors stand before a case, and how that depends on the unknowns.
#[derive(Clone, Debug)]
pub(super) struct Carried<'a> {
    memories: &'a [Memory],
    anchors: Vec<f64>,
    /// Per memory one derivative per direction.
    by: Vec<Vec<f64>>,
}

impl<'a> Carried<'a> {
    /// Before the first case.
    pub(super) fn new(
        memories: &'a [Memory],
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

    /// The directions of one case with the anchors' share.
    pub(super) fn directions<'d>(
        &self,
        directions: &'d [Direction],
        case: usize,
    ) -> Cow<'d, [Direction]> {
        if self.memories.is_empty() {
            return Cow::Borrowed(directions);
        }
        let is_anchor = |slot: Slot| self.memories.iter().any(|m| m.anchor == slot);
        let of = |(k, direction): (usize, &Direction)| {
            let own = direction
                .in_case(case)
                .filter(|(slot, _)| !is_anchor(*slot));
            let carried = self
                .memories
                .iter()
                .zip(&self.by)
                .map(|(memory, by)| (memory.anchor, by[k]))
                .filter(|(_, by)| *by != 0.0);
            Direction {
                always: own.chain(carried).collect(),
                turns: direction.turns.clone(),
                ..Direction::default()
            }
        };
        Cow::Owned(directions.iter().enumerate().map(of).collect())
    }

    /// Moves the anchors on after a case, by the return map of [`Slip`]: `channels` are its values, `changes` their change along
    /// each of the case's `directions`; empty if nobody asked.
    pub(super) fn advance(
        &mut self,
        theta: &Parameters,
        channels: &[f64],
        (directions, changes): (&[Direction], &[Vec<f64>]),
    ) {
        for (k, memory) in self.memories.iter().enumerate() {
            let length = theta.get(memory.length).abs();
            let u = channels[memory.channel];
            // A spring of unit stiffness slides at a force that is its length.
            let slip = Slip::at(u, &[1.0, length, self.anchors[k]]);
            if !slip.slides(self.anchors[k]) {
                continue;
            }
            self.anchors[k] = slip.anchor_after;
            let sign = slip.force.signum();
            for ((by, direction), change) in self.by[k].iter_mut().zip(directions).zip(changes) {
                let own = direction.always.iter();
                let by_length: f64 = own
                    .filter(|(slot, _)| *slot == memory.length)
                    .map(|(_, weight)| weight)
                    .sum();
                *by = change[memory.channel] - sign * by_length;
            }
        }
    }
}
