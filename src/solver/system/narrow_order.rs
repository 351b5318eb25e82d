//! An order of the parts in which those that constraints tie to each other stand close.

use std::collections::VecDeque;

use super::System;

impl System {
    /// The place of every column of the parts in an order by breadth from the end of each mechanism: what a row has other than zero stands
    /// close together, along a chain of any numbering too.
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
        // When each was reached last.
        let mut reached = vec![0; self.bodies.len()];
        let mut order = vec![0; self.first_equation];
        let mut next = 0;
        for body in 0..self.bodies.len() {
            if reached[body] > 0 {
                continue;
            }
            // The one that is reached last from anywhere is at an end.
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

/// All that is tied to one, by their distance from it; `reached` tells of each in which round it was found.
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
