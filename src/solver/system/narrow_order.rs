//! Order of the parts in which parts coupled by constraints are close together.

use std::collections::VecDeque;

use super::System;

impl System {
    /// Returns the position of every part column in a bandwidth-reducing order.
    ///
    /// The parts of each mechanism are ordered breadth-first from one end of the mechanism (as in Cuthill-McKee). The nonzero entries of a
    /// row are then close together, for example along a chain, for any numbering of the parts.
    pub(super) fn bandwidth_reducing_order(&self, rows: &[Vec<(usize, f64)>]) -> Vec<usize> {
        let mut owner = vec![0; self.first_equation];
        for (number, body) in self.bodies.iter().enumerate() {
            owner[body.first..body.first + body.freedoms].fill(number);
        }
        let mut tied = vec![Vec::new(); self.bodies.len()];
        for row in rows {
            let mut last = None;
            for &(column, _) in row.iter().filter(|(_, value)| *value != 0.0) {
                let body = owner[column];
                if let Some(before) = last.replace(body)
                    && before != body
                {
                    tied[before].push(body);
                    tied[body].push(before);
                }
            }
        }
        for others in &mut tied {
            others.sort_unstable();
            others.dedup();
        }
        // Search round (1 or 2) in which each body was last reached.
        let mut reached = vec![0; self.bodies.len()];
        let mut order = vec![0; self.first_equation];
        let mut next = 0;
        for body in 0..self.bodies.len() {
            if reached[body] > 0 {
                continue;
            }
            // The body that is reached last from an arbitrary start lies at an end of the mechanism.
            let from_anywhere = breadth_first_order(&tied, body, (&mut reached, 1));
            let end = *from_anywhere.last().unwrap_or(&body);
            for body in breadth_first_order(&tied, end, (&mut reached, 2)) {
                let body = &self.bodies[body];
                for column in body.first..body.first + body.freedoms {
                    order[column] = next;
                    next += 1;
                }
            }
        }
        order
    }
}

/// Returns all bodies connected to body `from`, ordered by distance from it. `reached` records the round in which each body was found.
fn breadth_first_order(
    tied: &[Vec<usize>],
    from: usize,
    (reached, round): (&mut [u8], u8),
) -> Vec<usize> {
    reached[from] = round;
    let mut open = VecDeque::from([from]);
    let mut out = Vec::new();
    while let Some(body) = open.pop_front() {
        out.push(body);
        for &other in &tied[body] {
            if std::mem::replace(&mut reached[other], round) != round {
                open.push_back(other);
            }
        }
    }
    out
}
