use admire_solver::mechanics::Vec3;

use super::record::Record;
use super::settings::{BALANCE_RELATIVE, MOST_SUMS, NO_FORCE_RELATIVE};

/// Elements whose forces differ only by a constant and a sign. They belong to a chain of parts, each of which adds its weight.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Class {
    /// Elements, each with its sign relative to the first.
    pub(crate) members: Vec<(usize, f64)>,
    /// Deviation of the first member's force from its mean, state by state.
    change: Vec<Vec3>,
}

/// Elements of a record, grouped by the variation of their forces over the states.
#[derive(Clone, Debug)]
pub(crate) struct Forces {
    /// Largest force.
    pub(crate) largest: f64,
    /// Classes of forces that change.
    pub(crate) classes: Vec<Class>,
    /// Elements with a force that is the same in all states.
    pub(crate) constant: Vec<usize>,
    /// Elements with torques only.
    pub(crate) torques: Vec<usize>,
    /// Elements without any action.
    pub(crate) idle: Vec<usize>,
}

/// A signed sum of classes that stays constant over all states.
pub(crate) type Balance = Vec<(usize, f64)>;

impl Forces {
    /// Sorts the elements of a record by their forces.
    pub(crate) fn sort(record: &Record) -> Self {
        let most = |values: &[Vec3]| values.iter().map(Vec3::norm).fold(0.0, f64::max);
        let elements = record.elements.iter();
        let largest = elements.map(|e| most(&e.force)).fold(0.0, f64::max);
        let elements = record.elements.iter();
        let twist = elements.map(|e| most(&e.torque)).fold(0.0, f64::max);
        let mut forces = Self {
            largest,
            classes: Vec::new(),
            constant: Vec::new(),
            torques: Vec::new(),
            idle: Vec::new(),
        };
        for (k, element) in record.elements.iter().enumerate() {
            if most(&element.force) <= NO_FORCE_RELATIVE * largest {
                let turns = most(&element.torque) > NO_FORCE_RELATIVE * twist;
                let list = if turns {
                    &mut forces.torques
                } else {
                    &mut forces.idle
                };
                list.push(k);
                continue;
            }
            let count = element.force.len() as f64;
            let mean = element.force.iter().fold(Vec3::zeros(), |sum, f| sum + f) / count;
            let change: Vec<Vec3> = element.force.iter().map(|f| f - mean).collect();
            if most(&change) <= BALANCE_RELATIVE * largest {
                forces.constant.push(k);
                continue;
            }
            let apart = |class: &Class, sign: f64| {
                let pairs = class.change.iter().zip(&change);
                pairs
                    .map(|(a, b)| (a - b * sign).norm())
                    .fold(0.0, f64::max)
            };
            let near = |class: &Class| {
                let mut signs = [1.0, -1.0].into_iter();
                signs.find(|sign| apart(class, *sign) <= BALANCE_RELATIVE * largest)
            };
            let found = forces
                .classes
                .iter()
                .position(|class| near(class).is_some());
            match found {
                Some(at) => {
                    let sign = near(&forces.classes[at]).unwrap_or(1.0);
                    forces.classes[at].members.push((k, sign));
                }
                None => forces.classes.push(Class {
                    members: vec![(k, 1.0)],
                    change,
                }),
            }
        }
        forces
    }

    /// Returns all signed sums of up to twelve classes that are constant over all states and contain no smaller such sum.
    ///
    /// The forces on one part form such a sum, because they balance its weight. The search pairs sums of at most six classes. Pairs are first
    /// compared by one number per sum, a fixed linear combination of all force components in all states. Pairs with equal numbers are compared in
    /// full.
    pub(crate) fn balances(&self) -> Vec<Balance> {
        let count = self.classes.len();
        let half = (1..=6).rev().find(|half| sums(count, *half) <= MOST_SUMS);
        let mixed: Vec<f64> = self
            .classes
            .iter()
            .map(|class| mix(&class.change))
            .collect();
        let mut all: Vec<Half> = Vec::new();
        let mut picked = Vec::new();
        collect(&mixed, half.unwrap_or(1), 0, 0.0, &mut picked, &mut all);
        all.sort_by(|a, b| a.value.total_cmp(&b.value));
        let room = BALANCE_RELATIVE * self.largest * 10.0;
        let mut found: Vec<Balance> = Vec::new();
        for (k, a) in all.iter().enumerate() {
            // Half sums with equal values cancel if the signs of one of them are reversed.
            for b in all[k + 1..]
                .iter()
                .take_while(|b| b.value - a.value <= room)
            {
                if let Some(balance) = joined(a, b)
                    && self.stays(&balance)
                    && !found.contains(&balance)
                {
                    found.push(balance);
                }
            }
        }
        found.sort_by_key(Vec::len);
        let mut least: Vec<Balance> = Vec::new();
        for balance in found {
            let within = |small: &Balance| {
                let held = |sign: f64| small.iter().all(|(c, s)| balance.contains(&(*c, s * sign)));
                held(1.0) || held(-1.0)
            };
            if !least.iter().any(within) {
                least.push(balance);
            }
        }
        least
    }

    fn stays(&self, balance: &Balance) -> bool {
        let states = self.classes[balance[0].0].change.len();
        (0..states).all(|state| {
            let terms = balance.iter();
            let sum = terms.fold(Vec3::zeros(), |sum, (c, s)| {
                sum + self.classes[*c].change[state] * *s
            });
            sum.norm() <= BALANCE_RELATIVE * self.largest
        })
    }
}

/// A signed sum of a few classes, reduced to one number.
struct Half {
    value: f64,
    terms: Vec<(u16, i8)>,
}

/// Returns the number of signed sums of at most `half` out of `count` classes.
fn sums(count: usize, half: usize) -> usize {
    let (mut total, mut of_size) = (0_usize, 1_usize);
    for k in 0..half.min(count) {
        of_size = of_size.saturating_mul(2 * (count - k)) / (k + 1);
        total = total.saturating_add(of_size);
    }
    total
}

/// Reduces the forces of all states to one number, with fixed weights between -1 and 1 that are unrelated to any load pattern.
fn mix(change: &[Vec3]) -> f64 {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut sum = 0.0;
    for force in change {
        for value in force.iter() {
            // Source: Steele, Lea and Flood, Fast splittable pseudorandom number generators: mixing function of splitmix64.
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            z ^= z >> 31;
            sum += value * ((z >> 11) as f64 / (1_u64 << 52) as f64 - 1.0);
        }
    }
    sum / (change.len() as f64).sqrt()
}

fn collect(
    mixed: &[f64],
    half: usize,
    from: usize,
    value: f64,
    picked: &mut Vec<(u16, i8)>,
    all: &mut Vec<Half>,
) {
    for class in from..mixed.len() {
        for sign in [1_i8, -1] {
            picked.push((class as u16, sign));
            let value = value + f64::from(sign) * mixed[class];
            all.push(Half {
                value,
                terms: picked.clone(),
            });
            if picked.len() < half {
                collect(mixed, half, class + 1, value, picked, all);
            }
            picked.pop();
        }
    }
}

/// Joins two half sums of equal value to a sum of zero; `None` if they share a class. The first sign is positive.
fn joined(a: &Half, b: &Half) -> Option<Balance> {
    if a.terms
        .iter()
        .any(|(class, _)| b.terms.iter().any(|(other, _)| class == other))
    {
        return None;
    }
    let mut terms: Balance = a
        .terms
        .iter()
        .map(|(c, s)| (usize::from(*c), f64::from(*s)))
        .collect();
    terms.extend(
        b.terms
            .iter()
            .map(|(c, s)| (usize::from(*c), -f64::from(*s))),
    );
    terms.sort_by_key(|(class, _)| *class);
    let sign = terms[0].1;
    for term in &mut terms {
        term.1 *= sign;
    }
    Some(terms)
}
