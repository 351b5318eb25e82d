//! Design of a sweep: a point of the unit cube for every case.

use sobol::Sobol;
use sobol::params::JoeKuoD6;

use super::random::{Stream, to_unit};

/// Largest number of dimensions of the Sobol sequence, for which direction numbers (Joe and Kuo 2008) are used.
pub(crate) const MOST_SOBOL: usize = 1000;

/// Kind of sampling plan.
#[derive(Clone, PartialEq, Debug)]
pub enum Plan {
    /// Independent random points.
    Random,
    /// Latin hypercube: the range of each parameter is divided into as many slices as there are cases, with one point in each slice.
    LatinHypercube,
    /// Sobol sequence with a random digital shift.
    Sobol,
    /// Full factorial: all combinations of levels. Contains the number of levels of each varied parameter.
    FullFactorial(Vec<u64>),
    /// Points for Sobol indices (Saltelli et al. 2010). Each block consists of point A, point B, and for each parameter a copy of A with
    /// this parameter taken from B.
    SobolIndices,
    /// Trajectories on a grid, in which each step changes one parameter (Morris 1991).
    Morris {
        /// Number of grid levels, even.
        levels: u64,
    },
    /// Cases from a table, one case per row.
    Table(Vec<Vec<f64>>),
}

impl Plan {
    /// Returns the name of the plan in SWEEP.toml.
    pub(crate) const fn word(&self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::LatinHypercube => "latin-hypercube",
            Self::Sobol => "sobol",
            Self::FullFactorial(_) => "full-factorial",
            Self::SobolIndices => "sobol-indices",
            Self::Morris { .. } => "morris",
            Self::Table(_) => "table",
        }
    }
}

/// Sampling point of a case.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum Point {
    /// Probability of each parameter, 0 < u < 1.
    Unit(Vec<f64>),
    /// Level of each parameter, paired with the number of levels.
    Levels(Vec<(u64, u64)>),
    /// Values of the parameters themselves.
    Values(Vec<f64>),
}

/// Design of a sweep. Case i depends only on the plan, the seed and i.
#[derive(Clone, Debug)]
pub struct Design {
    /// Kind of plan.
    pub plan: Plan,
    /// Size of the plan: number of cases, of base points for Sobol indices, or of Morris trajectories.
    size: u64,
    /// Number of varied parameters.
    dimensions: usize,
    streams: Vec<Stream>,
    /// Random stream for the order of the steps in trajectories.
    order: Stream,
    /// Digital shift of each dimension of the Sobol sequence.
    shifts: Vec<u64>,
    /// Direction numbers of the Sobol sequence for each dimension, most significant bit first.
    directions: Vec<Vec<u64>>,
}

impl Design {
    /// Creates a plan of `size` for parameters with these names.
    pub(crate) fn new(plan: Plan, size: u64, seed: u64, names: &[&str]) -> Self {
        let dimensions = names.len();
        let streams: Vec<Stream> = names.iter().map(|name| Stream::named(seed, name)).collect();
        let needed = match plan {
            Plan::Sobol => dimensions,
            Plan::SobolIndices => 2 * dimensions,
            _ => 0,
        };
        let shift = Stream::named(seed, "digital shift");
        let shifts = (0..needed as u64).map(|k| shift.bits(k)).collect();
        let directions = if needed == 0 {
            Vec::new()
        } else {
            let table = if needed > 100 {
                JoeKuoD6::standard()
            } else {
                JoeKuoD6::minimal()
            };
            Sobol::<f64>::init_direction_vals(needed, 64, &table)
        };
        Self {
            plan,
            size,
            dimensions,
            streams,
            order: Stream::named(seed, "order of the steps"),
            shifts,
            directions,
        }
    }

    /// Returns the number of cases in one block of the plan. The cases of a block are evaluated together.
    pub(crate) fn block(&self) -> u64 {
        match self.plan {
            Plan::SobolIndices => self.dimensions as u64 + 2,
            Plan::Morris { .. } => self.dimensions as u64 + 1,
            _ => 1,
        }
    }

    /// Returns the number of cases.
    pub(crate) fn cases(&self) -> u64 {
        match &self.plan {
            Plan::FullFactorial(levels) => levels.iter().product(),
            Plan::Table(rows) => rows.len() as u64,
            _ => self.size * self.block(),
        }
    }

    /// Returns the sampling point of a case.
    pub(crate) fn point(&self, case: u64) -> Point {
        let numbers = 0..self.dimensions;
        match &self.plan {
            Plan::Random => Point::Unit(self.streams.iter().map(|s| s.uniform(case)).collect()),
            Plan::LatinHypercube => {
                let place = |stream: &Stream| {
                    let slice = stream.shuffled(case, self.size);
                    (slice as f64 + stream.uniform(case)) / self.size as f64
                };
                Point::Unit(self.streams.iter().map(place).collect())
            }
            Plan::Sobol => Point::Unit(numbers.map(|k| self.sobol(case, k)).collect()),
            Plan::FullFactorial(levels) => {
                let mut rest = case;
                let mut out = vec![(0, 1); self.dimensions];
                // The last parameter changes fastest.
                for (out, count) in out.iter_mut().zip(levels).rev() {
                    *out = (rest % count, *count);
                    rest /= count;
                }
                Point::Levels(out)
            }
            Plan::SobolIndices => {
                let (base, k) = (case / self.block(), (case % self.block()) as usize);
                let of_b = |number: usize| k == 1 || k == number + 2;
                let d = self.dimensions;
                Point::Unit(
                    numbers
                        .map(|n| self.sobol(base, if of_b(n) { d + n } else { n }))
                        .collect(),
                )
            }
            Plan::Morris { levels } => {
                let (trajectory, step) = (case / self.block(), case % self.block());
                let place = |n: usize| {
                    let (from, to) = self.morris_step(trajectory, n, *levels);
                    let level = if self.morris_turn(trajectory, n) < step {
                        to
                    } else {
                        from
                    };
                    (level as f64 + 0.5) / *levels as f64
                };
                Point::Unit(numbers.map(place).collect())
            }
            Plan::Table(rows) => Point::Values(rows[case as usize].clone()),
        }
    }

    /// Returns the levels of a parameter before and after its step in a trajectory. They differ by half the number of levels.
    fn morris_step(&self, trajectory: u64, number: usize, levels: u64) -> (u64, u64) {
        let stream = &self.streams[number];
        let low = stream.below(2 * trajectory, levels / 2);
        let up = stream.bits(2 * trajectory + 1) >> 63 == 0;
        let high = low + levels / 2;
        if up { (low, high) } else { (high, low) }
    }

    /// Returns the step of a trajectory that changes the given parameter. Each step changes one parameter.
    pub(crate) fn morris_turn(&self, trajectory: u64, number: usize) -> u64 {
        let own = Stream::named(self.order.bits(trajectory), "order of a trajectory");
        own.shuffled(number as u64, self.dimensions as u64)
    }

    /// Returns one coordinate of point `index` of the shifted Sobol sequence.
    fn sobol(&self, index: u64, dimension: usize) -> f64 {
        let mut bits = self.shifts[dimension];
        // Points are taken in Gray-code order, as is usual.
        let gray = index ^ (index >> 1);
        for (place, direction) in self.directions[dimension].iter().enumerate() {
            if gray >> place & 1 == 1 {
                bits ^= direction;
            }
        }
        to_unit(bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(design: &Design, case: u64) -> Vec<f64> {
        match design.point(case) {
            Point::Unit(values) => values,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_latin_hypercube_has_one_point_in_every_slice() {
        let design = Design::new(Plan::LatinHypercube, 37, 5, &["a", "b"]);
        for number in 0..2 {
            let mut slices: Vec<u64> = (0..37)
                .map(|case| (unit(&design, case)[number] * 37.0) as u64)
                .collect();
            slices.sort_unstable();
            assert!(slices.into_iter().eq(0..37));
        }
    }

    #[test]
    fn the_sobol_sequence_fills_every_box_of_its_nets() {
        // The first two dimensions form a (0, 2)-sequence: 16 points, one in each box of sides 2^-a and 2^-(4-a), shifted or not.
        let design = Design::new(Plan::Sobol, 16, 5, &["a", "b", "c"]);
        for a in 0..5 {
            let (wide, tall) = (f64::from(1 << a), f64::from(1 << (4 - a)));
            let mut boxes: Vec<u64> = (0..16)
                .map(|case| {
                    let p = unit(&design, case);
                    (p[0] * wide) as u64 * tall as u64 + (p[1] * tall) as u64
                })
                .collect();
            boxes.sort_unstable();
            assert!(boxes.into_iter().eq(0..16), "sides {wide} {tall}");
        }
    }

    #[test]
    fn the_sobol_sequence_is_that_of_joe_and_kuo() {
        // Points 1 to 4 of `new-joe-kuo-6.21201` in three dimensions, without shift.
        let mut design = Design::new(Plan::Sobol, 8, 0, &["a", "b", "c"]);
        design.shifts.fill(0);
        let expected = [
            [0.5, 0.5, 0.5],
            [0.75, 0.25, 0.25],
            [0.25, 0.75, 0.75],
            [0.375, 0.375, 0.625],
        ];
        for (case, point) in expected.iter().enumerate() {
            for (found, expected) in unit(&design, case as u64 + 1).iter().zip(point) {
                assert!(
                    (found - expected).abs() < 1e-15,
                    "{case}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn a_full_factorial_has_every_combination_once() {
        let design = Design::new(Plan::FullFactorial(vec![2, 3, 4]), 0, 1, &["a", "b", "c"]);
        assert_eq!(design.cases(), 24);
        let mut all: Vec<Vec<(u64, u64)>> = (0..24)
            .map(|case| match design.point(case) {
                Point::Levels(levels) => levels,
                other => panic!("{other:?}"),
            })
            .collect();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 24);
    }

    #[test]
    fn each_step_of_a_trajectory_changes_one_number_by_half_the_range() {
        let design = Design::new(Plan::Morris { levels: 4 }, 9, 3, &["a", "b", "c"]);
        assert_eq!(design.cases(), 36);
        for trajectory in 0..9 {
            let mut changed = Vec::new();
            for step in 0..3 {
                let (p, q) = (
                    unit(&design, trajectory * 4 + step),
                    unit(&design, trajectory * 4 + step + 1),
                );
                let moved: Vec<usize> = (0..3).filter(|&n| p[n] != q[n]).collect();
                assert_eq!(moved.len(), 1);
                assert_eq!((p[moved[0]] - q[moved[0]]).abs(), 0.5);
                assert_eq!(design.morris_turn(trajectory, moved[0]), step);
                changed.push(moved[0]);
            }
            changed.sort_unstable();
            assert_eq!(changed, [0, 1, 2]);
        }
    }

    #[test]
    fn points_of_indices_share_their_numbers() {
        let design = Design::new(Plan::SobolIndices, 4, 3, &["a", "b"]);
        let all: Vec<Vec<f64>> = (4..8).map(|case| unit(&design, case)).collect();
        let (a, b) = (&all[0], &all[1]);
        assert_eq!(all[2], [b[0], a[1]]);
        assert_eq!(all[3], [a[0], b[1]]);
    }
}
