use super::assignment::Known;
use super::names::{affinity, digits};
use crate::settings::{MOST_PLACEMENTS, UNPLACED_PENALTY};

/// Placement of joints with constant forces, such as the joints of half shafts, which are only suspended from other parts.
///
/// Constant forces fit any balance. The relative motions restrict the clusters that a joint may connect, and masses must not be negative. The choice
/// among the rest depends on names and round masses.
pub(crate) struct Constants<'c, 'k> {
    known: &'c Known<'k>,
    /// Joints, each with the pairs of clusters (I, J) that it may connect.
    options: Vec<(usize, Vec<(usize, usize)>)>,
    /// Upward force on each cluster by the elements whose clusters are known; `None` for ground, and for clusters without such elements.
    carried: Vec<Option<f64>>,
    /// Pairs of clusters that have a joint.
    joined: Vec<(usize, usize)>,
    chosen: Vec<Option<(usize, usize)>>,
    best: Option<(f64, Vec<Option<(usize, usize)>>)>,
    /// Placement with the best agreement of names, regardless of masses.
    first: Vec<Option<(usize, usize)>>,
    tries: usize,
}

impl<'c, 'k> Constants<'c, 'k> {
    /// Finds the clusters of all joints with constant forces. The result has one entry for each joint that was placed.
    pub(crate) fn place(
        known: &'c Known<'k>,
        ends: &[[Option<usize>; 2]],
    ) -> Vec<(usize, (usize, usize))> {
        let count = known.clusters.members.len();
        let mut carried = vec![None; count];
        let mut joined = Vec::new();
        for (element, pair) in ends.iter().enumerate() {
            for (end, sign) in pair.iter().zip([1.0, -1.0]) {
                if let Some(cluster) = end
                    && *cluster != 0
                {
                    *carried[*cluster].get_or_insert(0.0) += known.upward(&[(element, sign)]);
                }
            }
            if let [Some(a), Some(b)] = pair
                && known.record.elements[element].ent_type == "Joint"
            {
                joined.push((*a, *b));
            }
        }
        let joints = known
            .forces
            .constant
            .iter()
            .copied()
            .filter(|e| known.record.elements[*e].ent_type == "Joint");
        let options = joints
            .map(|element| {
                let pairs = (0..count).flat_map(|a| (0..count).map(move |b| (a, b)));
                let fits = |(a, b): &(usize, usize)| {
                    a != b
                        && known.allows(element, *a, *b)
                        && !joined.contains(&(*a, *b))
                        && !joined.contains(&(*b, *a))
                };
                let mut pairs: Vec<(usize, usize)> = pairs.filter(fits).collect();
                let score = |pair: &(usize, usize)| {
                    speaks(known, element, pair.0) + speaks(known, element, pair.1)
                };
                pairs.sort_by(|a, b| score(b).total_cmp(&score(a)));
                (element, pairs)
            })
            .collect();
        let mut search = Self {
            known,
            options,
            carried,
            joined,
            chosen: Vec::new(),
            best: None,
            first: Vec::new(),
            tries: 0,
        };
        search.descend(0.0);
        let best = search
            .best
            .take()
            .map(|(_, chosen)| chosen)
            .unwrap_or_default();
        let first = std::mem::take(&mut search.first);
        let starts = [best, first].map(|start| search.improved(start));
        let [best, first] = starts;
        let chosen = if search.total(&first) > search.total(&best) {
            first
        } else {
            best
        };
        let placed = search.options.iter().zip(chosen);
        placed
            .filter_map(|((element, _), pair)| Some((*element, pair?)))
            .collect()
    }

    fn descend(&mut self, score: f64) {
        self.tries += 1;
        let depth = self.chosen.len();
        // Upper bound of the score that the names of the remaining joints can add.
        let left = self.options[depth..].iter();
        let most: f64 = left
            .map(|(element, pairs)| self.named(*element, pairs.first()))
            .sum();
        if self.tries > MOST_PLACEMENTS
            || self
                .best
                .as_ref()
                .is_some_and(|(best, _)| score + most <= *best)
        {
            return;
        }
        if depth == self.options.len() {
            if self.first.is_empty() {
                self.first.clone_from(&self.chosen);
            }
            let total = score + self.masses();
            if self.best.as_ref().is_none_or(|(best, _)| total > *best) {
                self.best = Some((total, self.chosen.clone()));
            }
            return;
        }
        let (element, pairs) = self.options[depth].clone();
        for (a, b) in pairs {
            if self.joined.contains(&(a, b)) || self.joined.contains(&(b, a)) {
                continue;
            }
            self.joined.push((a, b));
            self.chosen.push(Some((a, b)));
            self.descend(score + self.named(element, Some(&(a, b))));
            self.chosen.pop();
            self.joined.pop();
        }
        self.chosen.push(None);
        self.descend(score - UNPLACED_PENALTY);
        self.chosen.pop();
    }

    /// Improves a placement step by step. Each step assigns another pair of clusters to one joint, or exchanges the pairs of two joints. The search
    /// ends if no step improves the score.
    fn improved(&mut self, mut chosen: Vec<Option<(usize, usize)>>) -> Vec<Option<(usize, usize)>> {
        let same = |a: &(usize, usize), b: &(usize, usize)| a == b || (a.0 == b.1 && a.1 == b.0);
        let mut best = self.total(&chosen);
        loop {
            let mut better: Option<Vec<Option<(usize, usize)>>> = None;
            for k in 0..chosen.len() {
                for option in self.options[k].1.clone() {
                    let mut other = chosen.clone();
                    // If another joint has this pair, that joint gets the previous pair of this joint.
                    let holder = (0..other.len())
                        .find(|l| *l != k && other[*l].is_some_and(|pair| same(&pair, &option)));
                    if let Some(holder) = holder {
                        other[holder] =
                            other[k].filter(|pair| self.options[holder].1.contains(pair));
                    }
                    other[k] = Some(option);
                    let total = self.total(&other);
                    if total > best + 1e-9 {
                        best = total;
                        better = Some(other);
                    }
                }
            }
            match better {
                Some(other) => chosen = other,
                None => return chosen,
            }
        }
    }

    /// Scores a whole placement.
    fn total(&mut self, chosen: &[Option<(usize, usize)>]) -> f64 {
        let each = self.options.iter().zip(chosen);
        let names: f64 = each
            .map(|((element, _), pair)| self.named(*element, pair.as_ref()))
            .sum();
        self.chosen = chosen.to_vec();
        names + self.masses()
    }

    /// Returns the agreement between the name of an element and a pair of clusters.
    fn named(&self, element: usize, pair: Option<&(usize, usize)>) -> f64 {
        pair.map_or(-UNPLACED_PENALTY, |(a, b)| {
            speaks(self.known, element, *a) + speaks(self.known, element, *b)
        })
    }

    /// Scores the masses. Negative masses are penalised, and round masses are preferred.
    fn masses(&self) -> f64 {
        let mut carried = self.carried.clone();
        for ((element, _), pair) in self.options.iter().zip(&self.chosen) {
            let Some((a, b)) = pair else { continue };
            for (cluster, sign) in [(*a, 1.0), (*b, -1.0)] {
                if cluster != 0 {
                    *carried[cluster].get_or_insert(0.0) += self.known.upward(&[(*element, sign)]);
                }
            }
        }
        let mut score = 0.0;
        for weight in carried.iter().flatten() {
            if *weight < -1e-6 * self.known.forces.largest {
                score -= UNPLACED_PENALTY;
            }
            score -= 0.2 * f64::from(digits(self.known.mass(*weight)));
        }
        score
    }
}

/// Returns the largest agreement between the name of an element and the name of a body in a cluster, at most 3. The result for ground is 0.5.
fn speaks(known: &Known<'_>, element: usize, cluster: usize) -> f64 {
    if cluster == 0 {
        return 0.5;
    }
    let name = &known.record.elements[element].name;
    let bodies = known.clusters.members[cluster].iter();
    let all = bodies.map(|body| affinity(name, &known.record.bodies[*body].name));
    all.fold(f64::MIN, f64::max).min(3.0)
}
