use admire_solver::mechanics::Vec3;

use super::assignment::{Assignment, Known};
use super::constant::Constants;
use super::moments::{Term, fit_body, spread};
use super::names::{affinity, digits};
use super::relation::Relation;
use super::settings::{BALANCE_RELATIVE, LEVER_RELATIVE, SEARCH_STATES};

/// An element, with the bodies that it connects.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Connection {
    /// Index of the element in the record.
    pub element: usize,
    /// Index of the body on which the element acts.
    pub i: usize,
    /// Index of the body on which its reaction acts.
    pub j: usize,
}

/// All connections of a mechanism.
#[derive(Clone, Debug, Default)]
pub(crate) struct Connections {
    /// Elements with a force or torque, with their bodies.
    pub(crate) placed: Vec<Connection>,
    /// Bodies without relative motion that no element connects.
    pub(crate) rigid: Vec<(usize, usize)>,
    /// Elements with a force or torque whose bodies were not found.
    pub(crate) lost: Vec<usize>,
    /// Moving bodies on which no force was found.
    pub(crate) bare: Vec<usize>,
}

/// Clusters of the I and J part of each element.
type Ends = Vec<[Option<usize>; 2]>;

/// Forces on one body of a cluster, before the body is known.
#[derive(Clone, Debug, Default)]
struct Place {
    terms: Vec<Term>,
}

/// Finds the bodies of every element from the forces on the clusters.
pub(crate) fn connect(known: &Known<'_>, assignment: &Assignment) -> Connections {
    let mut ends: Ends = vec![[None; 2]; known.record.elements.len()];
    for (cluster, terms) in assignment.iter().enumerate() {
        for (element, sign) in terms {
            ends[*element][usize::from(*sign < 0.0)] = Some(cluster);
        }
    }
    let mut connections = Connections::default();
    known.close(&mut ends);
    let inner = known.inner(assignment, &ends);
    let mut bodies: Vec<[Option<usize>; 2]> = vec![[None; 2]; ends.len()];
    for (cluster, members) in known.clusters.members.iter().enumerate() {
        let terms = terms_on(cluster, &ends);
        if cluster == 0 {
            known.on_ground(&terms, &inner, &mut bodies);
            continue;
        }
        if terms.is_empty() {
            connections.bare.push(members[0]);
        }
        let (places, loose) = known.places(&terms, &inner[cluster], members.len());
        let (seats, loose) = known.seat(members, places, loose);
        for (body, place) in &seats {
            for (element, sign) in place
                .terms
                .iter()
                .chain(loose.get(body).into_iter().flatten())
            {
                bodies[*element][usize::from(*sign < 0.0)] = Some(*body);
            }
        }
        let core = seats.last().map_or(members[0], |(body, _)| *body);
        for member in members {
            if seats.iter().all(|(body, _)| body != member) {
                connections.rigid.push((*member, core));
            }
        }
    }
    known.place_torques(&mut bodies);
    for (element, pair) in bodies.iter().enumerate() {
        let acts = !known.forces.idle.contains(&element);
        match pair {
            [None, None] if acts && known.repeats(element, &bodies) => {}
            [None, None] if acts => connections.lost.push(element),
            [None, None] => {}
            [i, j] => connections.placed.push(Connection {
                element,
                i: i.unwrap_or(0),
                j: j.unwrap_or(0),
            }),
        }
    }
    connections
}

fn terms_on(cluster: usize, ends: &Ends) -> Vec<Term> {
    let signs = |pair: &[Option<usize>; 2]| {
        let on = pair.map(|end| end == Some(cluster));
        [(on[0], 1.0), (on[1], -1.0)]
    };
    let each = ends.iter().enumerate();
    each.flat_map(|(e, pair)| {
        signs(pair)
            .into_iter()
            .filter(|(on, _)| *on)
            .map(move |(_, s)| (e, s))
    })
    .collect()
}

/// Returns all permutations of the numbers below `count`.
fn orders(count: usize) -> Vec<Vec<usize>> {
    if count == 0 {
        return vec![Vec::new()];
    }
    let shorter = orders(count - 1);
    let all = shorter.iter().flat_map(|order| {
        (0..count).map(move |at| {
            let mut order = order.clone();
            order.insert(at, count - 1);
            order
        })
    });
    all.collect()
}

impl Known<'_> {
    /// Returns true if an element is a constraint rather than a force.
    fn is_constraint(&self, element: usize) -> bool {
        let kind = self.record.elements[element].ent_type.as_str();
        matches!(kind, "Joint" | "Primitive_Joint" | "Motion")
    }

    /// Returns true if another element with a known body has the opposite force in every state. Both elements must be constraints, or neither. The
    /// force of the element then repeats a known reaction.
    fn repeats(&self, element: usize, bodies: &[[Option<usize>; 2]]) -> bool {
        let force = &self.record.elements[element].force;
        let room = BALANCE_RELATIVE * self.forces.largest;
        (0..bodies.len()).any(|other| {
            let placed = other != element && bodies[other] != [None, None];
            let twin = &self.record.elements[other].force;
            let mut pairs = force.iter().zip(twin);
            placed
                && self.is_constraint(other) == self.is_constraint(element)
                && pairs.all(|(a, b)| (a + b).norm() <= room)
        })
    }

    /// Finds the bodies of elements that have torques but no forces. Such an element acts on a body if the moments on the body balance only with its
    /// torque.
    fn place_torques(&self, bodies: &mut [[Option<usize>; 2]]) {
        if self.forces.torques.is_empty() {
            return;
        }
        let states = spread(self.record.states(), SEARCH_STATES);
        let mut signed: Vec<Vec<Term>> = Vec::new();
        for (k, a) in self.forces.torques.iter().enumerate() {
            for s in [1.0, -1.0] {
                signed.push(vec![(*a, s)]);
                for b in &self.forces.torques[..k] {
                    signed.extend([1.0, -1.0].map(|t| vec![(*a, s), (*b, t)]));
                }
            }
        }
        signed.sort_by_key(Vec::len);
        for body in 1..self.record.bodies.len() {
            let on = |end: Option<usize>| end == Some(body);
            let each = bodies.iter().enumerate();
            let terms: Vec<Term> = each
                .flat_map(|(e, pair)| [(e, 1.0, pair[0]), (e, -1.0, pair[1])])
                .filter(|(.., end)| on(*end))
                .map(|(e, s, _)| (e, s))
                .collect();
            if terms.is_empty() {
                continue;
            }
            let lever = |extra: &[Term]| {
                let all: Vec<Term> = terms.iter().chain(extra).copied().collect();
                let ride = |(e, s): &Term| {
                    if *s > 0.0 {
                        body
                    } else {
                        bodies[*e][0].unwrap_or(0)
                    }
                };
                let on: Vec<usize> = all.iter().map(ride).collect();
                fit_body(self.record, body, &all, &on, &states).lever
            };
            let bare = lever(&[]);
            if bare <= LEVER_RELATIVE * self.size {
                continue;
            }
            // A torque belongs to the body if it removes nearly all of the residual moment.
            let mut best = (1e-3 * bare, Vec::new());
            for extra in &signed {
                let free = |(e, s): &Term| bodies[*e][usize::from(*s < 0.0)].is_none();
                if extra.iter().all(free) {
                    let left = lever(extra);
                    if left < 0.1 * best.0 {
                        best = (left, extra.clone());
                    }
                }
            }
            for (element, sign) in best.1 {
                bodies[element][usize::from(sign < 0.0)] = Some(body);
            }
        }
    }

    /// Sets the unknown cluster of each element to ground if its other cluster is known. Joints with constant forces are then assigned by the
    /// relative motions of the clusters.
    fn close(&self, ends: &mut Ends) {
        for pair in ends.iter_mut() {
            match pair {
                [Some(_), end @ None] | [end @ None, Some(_)] => *end = Some(0),
                _ => {}
            }
        }
        for (element, (a, b)) in Constants::place(self, ends) {
            ends[element] = [Some(a), Some(b)];
        }
    }

    /// Returns the upward component of the sum of the forces `terms` in the first state, which is the weight that they carry.
    pub(crate) fn upward(&self, terms: &[Term]) -> f64 {
        let sum = terms.iter().fold(Vec3::zeros(), |sum, (e, s)| {
            sum + self.record.elements[*e].force[0] * *s
        });
        -sum.dot(&self.down)
    }

    /// Finds the constraints between bodies of one cluster. For each cluster, returns pairs of an external force and an inner constraint force that
    /// balances it up to a weight.
    ///
    /// All forces of one class differ by weights. Each inner constraint is paired with the external force of its class that leaves the smallest
    /// nonnegative weight.
    fn inner(&self, assignment: &Assignment, ends: &Ends) -> Vec<Vec<(Term, Term)>> {
        let room = 10.0 * BALANCE_RELATIVE * self.forces.largest;
        let mut inner = vec![Vec::new(); self.clusters.members.len()];
        for class in &self.forces.classes {
            for (element, own) in &class.members {
                if ends[*element] != [None, None] || !self.is_constraint(*element) {
                    continue;
                }
                let mut best: Option<(f64, usize, Term, Term)> = None;
                for (cluster, terms) in assignment.iter().enumerate() {
                    if self.clusters.members[cluster].len() < 2 {
                        continue;
                    }
                    for (outer, sign) in terms {
                        let Some((_, other)) = class.members.iter().find(|(e, _)| e == outer)
                        else {
                            continue;
                        };
                        let term = (*element, -sign * other * own);
                        let carried = self.upward(&[(*outer, *sign), term]);
                        let better = best.as_ref().is_none_or(|(least, ..)| carried < *least);
                        if carried >= -room && better {
                            best = Some((carried, cluster, (*outer, *sign), term));
                        }
                    }
                }
                if let Some((_, cluster, outer, term)) = best {
                    inner[cluster].push((outer, term));
                }
            }
        }
        inner
    }

    /// Distributes the forces on a cluster over its bodies. The inner constraints behind each external force form a chain of bodies. All chains end
    /// at the same body, the core, which is the last place. Constant forces are returned separately, because the balance does not determine their
    /// body.
    fn places(
        &self,
        terms: &[Term],
        inner: &[(Term, Term)],
        most: usize,
    ) -> (Vec<Place>, Vec<Term>) {
        let mut places = Vec::new();
        let mut core = Place::default();
        let mut loose = Vec::new();
        for outer in terms {
            if self.forces.constant.contains(&outer.0) {
                loose.push(*outer);
                continue;
            }
            let mut behind: Vec<Term> = inner
                .iter()
                .filter(|(o, _)| o == outer)
                .map(|(_, t)| *t)
                .collect();
            let carried = |term: &Term| self.upward(&[*outer, *term]);
            behind.sort_by(|a, b| carried(a).total_cmp(&carried(b)));
            let mut entering = *outer;
            for term in behind {
                if places.len() + 1 >= most {
                    break;
                }
                places.push(Place {
                    terms: vec![entering, term],
                });
                entering = (term.0, -term.1);
            }
            core.terms.push(entering);
        }
        places.push(core);
        (places, loose)
    }

    /// Assigns the bodies of a cluster to its places, by the agreement of their names with the names of the forces. Constant forces are assigned so
    /// that the masses become round numbers.
    fn seat(
        &self,
        members: &[usize],
        places: Vec<Place>,
        loose: Vec<Term>,
    ) -> (
        Vec<(usize, Place)>,
        std::collections::HashMap<usize, Vec<Term>>,
    ) {
        let count = places.len();
        let most = 7;
        let all = if members.len() <= most {
            orders(members.len())
        } else {
            vec![(0..members.len()).collect()]
        };
        let choices = count.pow(loose.len().min(4) as u32);
        let mut best: Option<(f64, Vec<usize>, Vec<usize>)> = None;
        let name = |element: usize| self.record.elements[element].name.as_str();
        let speaks = |terms: &[Term], body: usize| -> f64 {
            let part = self.record.bodies[body].name.as_str();
            terms.iter().map(|(e, _)| affinity(name(*e), part)).sum()
        };
        for order in &all {
            for choice in 0..choices {
                let mut rest = choice;
                let at: Vec<usize> = loose
                    .iter()
                    .map(|_| {
                        let at = rest % count;
                        rest /= count;
                        at
                    })
                    .collect();
                let mut score = 0.0;
                for (k, place) in places.iter().enumerate() {
                    let body = members[order[k]];
                    let mut terms = place.terms.clone();
                    terms.extend(
                        loose
                            .iter()
                            .zip(&at)
                            .filter(|(_, at)| **at == k)
                            .map(|(t, _)| *t),
                    );
                    score += speaks(&terms, body);
                    let weight = self.upward(&terms);
                    if weight < -10.0 * BALANCE_RELATIVE * self.forces.largest {
                        score -= 10.0;
                    }
                    score -= 0.1 * f64::from(digits(self.mass(weight)));
                }
                if best.as_ref().is_none_or(|(most, ..)| score > *most + 1e-9) {
                    best = Some((score, order.clone(), at));
                }
            }
        }
        let Some((_, order, at)) = best else {
            return (Vec::new(), std::collections::HashMap::new());
        };
        let mut extra: std::collections::HashMap<usize, Vec<Term>> =
            std::collections::HashMap::new();
        for (term, at) in loose.iter().zip(at) {
            extra.entry(members[order[at]]).or_default().push(*term);
        }
        let seats = places.into_iter().enumerate();
        let seats = seats.map(|(k, place)| (members[order[k]], place)).collect();
        (seats, extra)
    }

    /// Returns the mass, in units of the results, that has this weight.
    pub(crate) fn mass(&self, weight: f64) -> f64 {
        super::mass(weight, &self.record.units)
    }

    /// Assigns all forces on the cluster of ground to ground itself, because the forces on bodies at rest do not distinguish these bodies.
    fn on_ground(
        &self,
        terms: &[Term],
        inner: &[Vec<(Term, Term)>],
        bodies: &mut [[Option<usize>; 2]],
    ) {
        for (element, sign) in terms.iter().chain(inner[0].iter().map(|(_, t)| t)) {
            bodies[*element][usize::from(*sign < 0.0)] = Some(0);
        }
    }

    /// Returns the motion of the J body of a connection relative to its I body.
    pub(crate) fn motion(&self, i: usize, j: usize) -> Relation {
        let (a, b) = (self.clusters.of[i], self.clusters.of[j]);
        if a == b {
            return Relation::Fixed;
        }
        super::relation::relation(
            &self.record.bodies[i].poses,
            &self.record.bodies[j].poses,
            self.size,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_members_have_six_orders() {
        assert_eq!(orders(3).len(), 6);
    }
}
