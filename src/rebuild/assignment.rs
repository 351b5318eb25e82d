use std::collections::HashSet;

use admire_solver::mechanics::Vec3;

use super::balance::Forces;
use super::moments::{Term, fit_body, spread};
use super::names::{affinity, joint_code};
use super::record::Record;
use super::relation::{Clusters, Relation, Relations};
use super::settings::{
    BALANCE_RELATIVE, BARE_PENALTY, GROUND_I_PENALTY, GROUND_PENALTY, LEVER_RELATIVE,
    MOST_ASSIGNMENTS, MOST_CANDIDATES, MOST_PARTNERS, NOWHERE_PENALTY, SEARCH_STATES,
};

/// Set of forces that may be all the forces on one cluster of bodies.
#[derive(Clone, Debug)]
struct Candidate {
    terms: Vec<Term>,
    /// Cluster that contains the I part of each term with negative sign (force on the J part). `None` for terms with positive sign, and for forces
    /// along a line.
    partners: Vec<Option<usize>>,
    /// Largest residual moment divided by the largest force, in length units.
    lever: f64,
    /// Score from the residual moment and from the agreement of names. Smaller is better.
    score: f64,
}

/// Properties of a mechanism that are known before its connections.
pub(crate) struct Known<'a> {
    /// Record with the states.
    pub(crate) record: &'a Record,
    /// Bodies that never move against each other.
    pub(crate) clusters: &'a Clusters,
    /// Relative motion of each pair of clusters.
    pub(crate) relations: &'a Relations,
    /// Elements, grouped by the variation of their forces over the states.
    pub(crate) forces: &'a Forces,
    /// Size of the mechanism.
    pub(crate) size: f64,
    /// Direction of weights.
    pub(crate) down: Vec3,
}

/// Forces on every cluster, one list each; the list of ground is empty.
pub(crate) type Assignment = Vec<Vec<Term>>;

/// Returns the direction of gravity as a unit vector. Signed sums of forces that are constant over all states equal weights; the largest of them
/// gives the direction. `None` if all of them are round-off.
pub(crate) fn down(record: &Record, forces: &Forces) -> Option<Vec3> {
    let mut best = Vec3::zeros();
    let mut consider = |v: Vec3| {
        if v.norm() > best.norm() {
            best = v;
        }
    };
    for class in &forces.classes {
        for (k, (a, s)) in class.members.iter().enumerate() {
            for (b, t) in &class.members[..k] {
                let (a, b) = (&record.elements[*a].force, &record.elements[*b].force);
                consider(a[0] * *s - b[0] * *t);
            }
        }
    }
    for balance in forces.balances() {
        let sum = balance.iter().fold(Vec3::zeros(), |sum, (class, sign)| {
            let (member, _) = forces.classes[*class].members[0];
            sum + record.elements[member].force[0] * *sign
        });
        consider(sum);
    }
    for element in &forces.constant {
        consider(record.elements[*element].force[0]);
    }
    if best.norm() <= BALANCE_RELATIVE * forces.largest {
        return None;
    }
    // Heights are positive upwards in all decks, so weights point in the negative direction of their axis.
    let axis = best.normalize();
    Some(if axis[axis.iamax()] > 0.0 {
        -axis
    } else {
        axis
    })
}

/// Assigns forces to clusters. Returns the best assignment found, or `None` if no cluster has a candidate.
pub(crate) fn assign(known: &Known<'_>) -> Option<Assignment> {
    let states = spread(known.record.states(), SEARCH_STATES);
    let count = known.clusters.members.len();
    let sets = term_sets(known);
    let mut candidates = known.all_candidates(&sets, &states);
    candidates.retain(|(_, found)| !found.is_empty());
    if candidates.is_empty() {
        return None;
    }
    // Clusters with the fewest good candidates come first.
    let good = |found: &[Candidate]| {
        found
            .iter()
            .filter(|c| c.score < found[0].score + 3.0)
            .count()
    };
    candidates.sort_by_key(|(_, found)| good(found));
    // For each position, the smallest score that the clusters from there on can add.
    let mut least = vec![0.0; candidates.len() + 1];
    for (k, (_, found)) in candidates.iter().enumerate().rev() {
        let best = found
            .iter()
            .map(|candidate| candidate.score)
            .fold(BARE_PENALTY, f64::min);
        least[k] = least[k + 1] + best;
    }
    let mut search = Search {
        least: &least,
        known,
        candidates: &candidates,
        chosen: Vec::new(),
        on: vec![[None; 2]; known.record.elements.len()],
        expected: vec![None; known.record.elements.len()],
        best: None,
        tries: 0,
    };
    search.descend(0.0);
    let (_, chosen) = search.best?;
    let mut assignment = vec![Vec::new(); count];
    for (k, (cluster, found)) in candidates.iter().enumerate() {
        if let Some(Some(at)) = chosen.get(k) {
            assignment[*cluster].clone_from(&found[*at].terms);
        }
    }
    Some(assignment)
}

/// Returns all sets of forces that may balance the weight of one part, each with both signs. A set contains one element of each class of a balance,
/// or two elements of one class.
fn term_sets(known: &Known<'_>) -> Vec<Vec<Term>> {
    let classes = &known.forces.classes;
    let mut sets = Vec::new();
    for balance in known.forces.balances() {
        let mut partial: Vec<Vec<Term>> = vec![Vec::new()];
        for (class, sign) in &balance {
            let members = &classes[*class].members;
            let longer = partial.iter().flat_map(|set| {
                members.iter().map(|(element, own)| {
                    let mut set = set.clone();
                    set.push((*element, sign * own));
                    set
                })
            });
            partial = longer.collect();
        }
        sets.extend(partial);
    }
    for class in classes {
        for (k, (a, s)) in class.members.iter().enumerate() {
            for (b, t) in &class.members[..k] {
                if known.are_halves(*a, *b) {
                    continue;
                }
                sets.push(vec![(*a, *s), (*b, -t)]);
            }
        }
    }
    with_both_signs(sets)
}

fn with_both_signs(sets: Vec<Vec<Term>>) -> Vec<Vec<Term>> {
    let turned = |set: &Vec<Term>| set.iter().map(|(e, s)| (*e, -s)).collect::<Vec<Term>>();
    let negative: Vec<Vec<Term>> = sets.iter().map(turned).collect();
    sets.into_iter().chain(negative).collect()
}

impl Known<'_> {
    /// Returns true if two single-component forces are opposite in every state. They are action and reaction, so they cannot both act on one part.
    fn are_halves(&self, a: usize, b: usize) -> bool {
        let elements = &self.record.elements;
        let single = |k: usize| elements[k].ent_type == "Single_Component_Force";
        let mut pairs = elements[a].force.iter().zip(&elements[b].force);
        let room = BALANCE_RELATIVE * self.forces.largest;
        single(a) && single(b) && pairs.all(|(a, b)| (a + b).norm() <= room)
    }

    /// Returns true if an element is a joint, which constrains the relative motion of its parts.
    fn is_joint(&self, element: usize) -> bool {
        self.record.elements[element].ent_type == "Joint"
    }

    /// Returns true if the relative motion of two clusters is consistent with a joint, and with the kind of joint in its name if there is one.
    pub(crate) fn allows(&self, element: usize, a: usize, b: usize) -> bool {
        let relation = self.relations.of(a, b);
        match joint_code(&self.record.elements[element].name) {
            Some("rev") => matches!(relation, Relation::Revolute { .. }),
            Some("tra") => matches!(relation, Relation::Translational { .. }),
            Some("cyl") => matches!(
                relation,
                Relation::Cylindrical { .. }
                    | Relation::Translational { .. }
                    | Relation::Revolute { .. }
            ),
            Some("sph" | "hoo" | "con" | "uni") => matches!(
                relation,
                Relation::Spherical { .. } | Relation::Revolute { .. }
            ),
            Some("fix") => false,
            _ => relation != Relation::Free,
        }
    }

    /// Returns the candidates of all clusters.
    ///
    /// A force on a J part acts at a point of its I part. The first pass uses only forces on I parts and forces in joints. Each later pass uses the I
    /// parts that the previous pass has found.
    fn all_candidates(&self, sets: &[Vec<Term>], states: &[usize]) -> Vec<(usize, Vec<Candidate>)> {
        let count = self.clusters.members.len();
        let floor = 1e-13 * self.size;
        let mut owners: Vec<Vec<usize>> = vec![Vec::new(); self.record.elements.len()];
        let mut all: Vec<(usize, Vec<Candidate>)> = Vec::new();
        for pass in 0..4 {
            let found: Vec<(usize, Vec<Candidate>)> = (1..count)
                .map(|cluster| {
                    (
                        cluster,
                        self.candidates(cluster, sets, states, &owners, pass == 3),
                    )
                })
                .collect();
            let mut next = owners.clone();
            for (element, own) in next.iter_mut().enumerate() {
                let holds = |candidate: &&Candidate| candidate.terms.contains(&(element, 1.0));
                let least = |list: &[Candidate]| {
                    let levers = list.iter().filter(holds).map(|candidate| candidate.lever);
                    levers.fold(f64::INFINITY, f64::min)
                };
                let best = found
                    .iter()
                    .map(|(_, list)| least(list))
                    .fold(f64::INFINITY, f64::min);
                let near = found
                    .iter()
                    .filter(|(_, list)| least(list) <= 100.0 * best + floor);
                *own = near.map(|(cluster, _)| *cluster).collect();
                if !best.is_finite() {
                    own.clear();
                }
            }
            all = found;
            if pass < 3 && next == owners && pass > 0 {
                break;
            }
            owners = next;
        }
        // The round-off of true balances is the reference. It is estimated by the median of the best levers of all clusters.
        let least = |list: &[Candidate]| {
            list.iter()
                .map(|candidate| candidate.lever)
                .fold(f64::INFINITY, f64::min)
        };
        let mut levers: Vec<f64> = all
            .iter()
            .map(|(_, list)| least(list))
            .filter(|lever| lever.is_finite())
            .collect();
        levers.sort_by(f64::total_cmp);
        let noise = levers
            .get(levers.len() / 2)
            .copied()
            .unwrap_or(0.0)
            .max(floor);
        for (cluster, list) in &mut all {
            for candidate in list.iter_mut() {
                candidate.score = libm::log10((candidate.lever + noise) / noise)
                    - 0.2 * self.names(*cluster, &candidate.terms);
            }
            list.sort_by(|a, b| a.score.total_cmp(&b.score));
            list.truncate(MOST_CANDIDATES);
        }
        all
    }

    fn candidates(
        &self,
        cluster: usize,
        sets: &[Vec<Term>],
        states: &[usize],
        owners: &[Vec<usize>],
        last: bool,
    ) -> Vec<Candidate> {
        let mut found = Vec::new();
        for terms in sets {
            let sum = terms.iter().fold(Vec3::zeros(), |sum, (e, s)| {
                sum + self.record.elements[*e].force[states[0]] * *s
            });
            let room = 10.0 * BALANCE_RELATIVE * self.forces.largest;
            let weight = -sum;
            let along = weight.dot(&self.down);
            if (weight - self.down * along).norm() > room || along < -room {
                continue;
            }
            for partners in self.partners(cluster, terms, owners, last) {
                let body = self.clusters.members[cluster][0];
                let on: Vec<usize> = partners
                    .iter()
                    .map(|partner| partner.map_or(body, |other| self.clusters.members[other][0]))
                    .collect();
                let lever = fit_body(self.record, body, terms, &on, states).lever;
                if lever > LEVER_RELATIVE * self.size {
                    continue;
                }
                found.push(Candidate {
                    terms: terms.clone(),
                    partners,
                    lever,
                    score: 0.0,
                });
            }
        }
        found
    }

    /// Returns the agreement between the names of forces and the names of the bodies in a cluster.
    fn names(&self, cluster: usize, terms: &[Term]) -> f64 {
        let own = &self.clusters.members[cluster];
        let names = terms.iter().map(|(e, _)| {
            let name = &self.record.elements[*e].name;
            let of = |body: &usize| affinity(name, &self.record.bodies[*body].name);
            own.iter().map(of).fold(f64::MIN, f64::max)
        });
        names.sum()
    }

    /// Returns all choices of `partners` (see [`Candidate`]) for a set of forces on a cluster. The list is empty if a joint fits no other cluster, or
    /// if there are more than [`MOST_PARTNERS`] choices.
    fn partners(
        &self,
        cluster: usize,
        terms: &[Term],
        owners: &[Vec<usize>],
        last: bool,
    ) -> Vec<Vec<Option<usize>>> {
        let count = self.clusters.members.len();
        let mut choices: Vec<Vec<Option<usize>>> = vec![Vec::new()];
        for (element, sign) in terms {
            let others = (0..count).filter(|other| *other != cluster);
            let object = &self.record.elements[*element];
            let fitting = others
                .filter(|other| !self.is_joint(*element) || self.allows(*element, cluster, *other));
            let fitting: Vec<usize> = fitting.collect();
            if fitting.is_empty() {
                return Vec::new();
            }
            let line = matches!(
                object.ent_type.as_str(),
                "Single_Component_Force" | "Translational_Spring_Damper"
            );
            let options: Vec<Option<usize>> = if *sign > 0.0 || line {
                vec![None]
            } else if self.is_joint(*element) || (last && owners[*element].is_empty()) {
                fitting.into_iter().map(Some).collect()
            } else {
                // The I part is in a cluster that was found, or it is ground, whose balance is unknown.
                let own = owners[*element].iter().filter(|other| **other != cluster);
                let ground = owners[*element].is_empty().then_some(Some(0));
                own.map(|other| Some(*other)).chain(ground).collect()
            };
            let longer = choices.iter().flat_map(|choice| {
                options.iter().map(|option| {
                    let mut choice = choice.clone();
                    choice.push(*option);
                    choice
                })
            });
            choices = longer.collect();
            if choices.len() > MOST_PARTNERS {
                return Vec::new();
            }
        }
        choices
    }
}

/// Search for the assignment with the best score.
struct Search<'s, 'k> {
    known: &'s Known<'k>,
    candidates: &'s [(usize, Vec<Candidate>)],
    least: &'s [f64],
    /// Candidate of each cluster so far; `None` for a cluster without forces.
    chosen: Vec<Option<usize>>,
    /// Clusters on which each element acts as I and as J part.
    on: Vec<[Option<usize>; 2]>,
    /// Cluster that must contain the I part of each element, according to the forces on the J part.
    expected: Vec<Option<usize>>,
    best: Option<(f64, Vec<Option<usize>>)>,
    tries: usize,
}

impl Search<'_, '_> {
    fn descend(&mut self, score: f64) {
        self.tries += 1;
        let depth = self.chosen.len();
        let hopeless = |(best, _): &(f64, _)| score + self.least[depth] >= *best;
        if self.tries > MOST_ASSIGNMENTS || self.best.as_ref().is_some_and(hopeless) {
            return;
        }
        let Some((cluster, candidates)) = self.candidates.get(depth) else {
            let total = score + self.loose_ends();
            if self.best.as_ref().is_none_or(|(best, _)| total < *best) {
                self.best = Some((total, self.chosen.clone()));
            }
            return;
        };
        for (at, candidate) in candidates.iter().enumerate() {
            if !self.fits(*cluster, candidate) {
                continue;
            }
            self.mark(candidate, Some(*cluster));
            self.chosen.push(Some(at));
            self.descend(score + candidate.score);
            self.chosen.pop();
            self.mark(candidate, None);
        }
        self.chosen.push(None);
        self.descend(score + BARE_PENALTY);
        self.chosen.pop();
    }

    fn mark(&mut self, candidate: &Candidate, cluster: Option<usize>) {
        for ((element, sign), partner) in candidate.terms.iter().zip(&candidate.partners) {
            self.on[*element][usize::from(*sign < 0.0)] = cluster;
            if *sign < 0.0 {
                self.expected[*element] = partner.filter(|_| cluster.is_some());
            }
        }
    }

    /// Returns true if a candidate agrees with the candidates chosen so far. Each of its forces must still be free, each of its joints must fit both
    /// clusters, and each I part must be in the expected cluster.
    fn fits(&self, cluster: usize, candidate: &Candidate) -> bool {
        let mut all = candidate.terms.iter().zip(&candidate.partners);
        all.all(|((element, sign), partner)| {
            let at = usize::from(*sign < 0.0);
            let other = self.on[*element][1 - at];
            let joined = |other: usize| {
                !self.known.is_joint(*element) || self.known.allows(*element, cluster, other)
            };
            let agrees = if *sign > 0.0 {
                self.expected[*element].is_none_or(|expected| expected == cluster)
            } else {
                partner.is_none() || other.is_none() || *partner == other
            };
            self.on[*element][at].is_none() && other.is_none_or(joined) && agrees
        })
    }

    /// Scores the elements that act on ground, or on no part.
    fn loose_ends(&self) -> f64 {
        let forces = self.known.forces;
        let mut used_classes = HashSet::new();
        let mut score = 0.0;
        for (k, class) in forces.classes.iter().enumerate() {
            for (element, _) in &class.members {
                match self.on[*element] {
                    [Some(_), Some(_)] => {
                        used_classes.insert(k);
                    }
                    [None, None] => {}
                    [None, Some(_)] if self.expected[*element].is_some_and(|on| on != 0) => {
                        score += NOWHERE_PENALTY;
                    }
                    [Some(cluster), None] | [None, Some(cluster)] => {
                        used_classes.insert(k);
                        let joint = self.known.is_joint(*element);
                        let bad = joint && !self.known.allows(*element, cluster, 0);
                        score += if bad { NOWHERE_PENALTY } else { GROUND_PENALTY };
                        // A force on a single part is written with that part as its I part.
                        score += if self.on[*element][0].is_none() && !joint {
                            GROUND_I_PENALTY
                        } else {
                            0.0
                        };
                    }
                }
            }
        }
        // An element inside a cluster belongs to the class of an element that acts on the cluster from outside.
        for (k, class) in forces.classes.iter().enumerate() {
            if !used_classes.contains(&k) {
                score += NOWHERE_PENALTY * class.members.len() as f64;
            }
        }
        score
    }
}
