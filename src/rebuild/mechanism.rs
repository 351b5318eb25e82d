use admire_solver::mechanics::{Mat3, Pose, Vec3};

use super::assignment::{Known, assign, down};
use super::balance::Forces;
use super::bushing::{self, Motion};
use super::connection::{Connection, Connections, connect};
use super::joint::{Joint, frame_along, joint};
use super::law::Law;
use super::linear_law::point_by_law;
use super::moments::{Balanced, Point, Term, Whole, spread};
use super::record::Record;
use super::relation::{Clusters, Relation, Relations, size};
use super::requests::markers;
use super::settings::{CLOSURE_RELATIVE, LEVER_RELATIVE};
use super::spring::{Spring, spring};

/// A mechanism found in results: bodies with masses, and the elements that connect them.
#[derive(Clone, Debug)]
pub struct Mechanism {
    /// Bodies of the record with their masses, in the same order.
    pub bodies: Vec<Mass>,
    /// Elements with their bodies and laws.
    pub members: Vec<Member>,
    /// Bodies that are held together although no element connects them, as pairs of indices.
    pub rigid: Vec<(usize, usize)>,
    /// Elements whose bodies were not found.
    pub lost: Vec<usize>,
    /// Elements without force in all states.
    pub idle: Vec<usize>,
    /// Moving bodies without any force in the results.
    pub bare: Vec<usize>,
    /// Direction of gravity; zero if no part has a weight.
    pub down: Vec3,
    /// Size of the mechanism: largest distance between two parts.
    pub size: f64,
    /// Largest residual moment on a body divided by the largest force, which is a lever.
    pub lever_left: f64,
}

/// Weight and mass centre of one body.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Mass {
    /// Mass in the units of the results; zero if the results show no weight.
    pub mass: f64,
    /// Mass centre in the axes of the body.
    pub centre: Vec3,
    /// Indeterminacy of the centre: 0 determined by the moments, 1 undetermined.
    pub open: f64,
}

/// One element of the mechanism.
#[derive(Clone, Debug)]
pub struct Member {
    /// The element and its bodies.
    pub connection: Connection,
    /// Role of the element.
    pub role: Role,
    /// Indeterminacy of the points of the element: 0 determined by the results, 1 undetermined.
    pub open: f64,
}

/// Role of an element.
#[derive(Clone, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "a mechanism has tens of elements"
)]
pub enum Role {
    /// A joint.
    Joint(Joint),
    /// A motion: a prescribed distance along the z axis of J, or a prescribed angle about it, with one value per state.
    Motion {
        /// Frame on the I body.
        i: Pose,
        /// Frame on the J body.
        j: Pose,
        /// True for an angle in radians, false for a distance.
        turns: bool,
        /// Value in every state.
        values: Vec<f64>,
    },
    /// A bushing between two frames.
    Bushing {
        /// Frame on the I body.
        i: Pose,
        /// Frame on the J body.
        j: Pose,
        /// Forces and torques in J axes.
        law: Law,
        /// Deflections and angles in the states.
        motion: Motion,
    },
    /// A force along a line.
    Spring(Spring),
    /// A further constraint between parts that a FIXED joint already connects. The FIXED joint carries the force of this constraint.
    Carried,
    /// A force with one given value per state, in ground axes, at a point of the I body.
    Load(Vec3),
}

/// Finds the mechanism that has the equilibria of a record.
///
/// # Errors
/// Returns a message if the record contains no forces, or if the forces balance on no part.
pub fn mechanism(record: &Record) -> Result<Mechanism, String> {
    let size = size(record);
    let forces = Forces::sort(record);
    let clusters = Clusters::find(record, size);
    let relations = Relations::find(record, &clusters, size);
    let gravity = down(record, &forces);
    let known = Known {
        record,
        clusters: &clusters,
        relations: &relations,
        forces: &forces,
        size,
        down: gravity.unwrap_or_else(|| -Vec3::z()),
    };
    if forces.largest == 0.0 {
        let why = "the results contain no forces, and connections cannot be found without forces";
        return Err(why.to_string());
    }
    let assignment = assign(&known).ok_or(
        "the forces in the results do not balance on any part: the file lacks the forces of some elements",
    )?;
    let connections = connect(&known, &assignment);
    let mut builder = Builder {
        record,
        known: &known,
        connections: &connections,
        points: Vec::new(),
        frames: vec![None; record.elements.len()],
    };
    builder.first_points();
    let mut balanced = builder.balance();
    if builder.points_by_laws(&balanced) {
        balanced = builder.balance();
    }
    let members = builder.members(&balanced);
    let mut bodies = vec![
        Mass {
            mass: 0.0,
            centre: Vec3::zeros(),
            open: 1.0
        };
        record.bodies.len()
    ];
    for (k, (body, _)) in builder.forces_on_bodies().iter().enumerate() {
        let weight = builder.weight(*body).dot(&known.down);
        bodies[*body] = Mass {
            mass: known.mass(weight.max(0.0)),
            centre: balanced.centres[k],
            open: balanced.centres_open[k],
        };
    }
    let mut mechanism = Mechanism {
        bodies,
        members,
        rigid: connections.rigid.clone(),
        lost: connections.lost.clone(),
        idle: forces.idle.clone(),
        bare: connections.bare.clone(),
        down: gravity.unwrap_or_else(Vec3::zeros),
        size,
        lever_left: balanced.left / forces.largest,
    };
    mechanism.hold_rods(record);
    mechanism.fasten(&clusters, record);
    mechanism.prescribe(&clusters, record);
    Ok(mechanism)
}

/// Builder of the numerical values of a mechanism with known connections.
struct Builder<'b> {
    record: &'b Record,
    known: &'b Known<'b>,
    connections: &'b Connections,
    /// Point of every placed element on its I body.
    points: Vec<(usize, usize, Point)>,
    /// Frames of the markers of bushings, by element.
    frames: Vec<Option<(Pose, Pose)>>,
}

impl Builder<'_> {
    /// Sets the point of every element. Relative motions, requests and floating markers determine some of the points; the other points get an initial
    /// guess.
    fn first_points(&mut self) {
        for connection in &self.connections.placed {
            let point = self.first_point(*connection);
            self.points.push((connection.element, connection.i, point));
        }
    }

    fn first_point(&mut self, connection: Connection) -> Point {
        let Connection { element, i, j } = connection;
        let object = &self.record.elements[element];
        match object.ent_type.as_str() {
            "Joint" => match self.known.motion(i, j) {
                Relation::Spherical { point_a, .. } => Point::Known(point_a),
                Relation::Revolute { point_a, .. } | Relation::Cylindrical { point_a, .. } => {
                    Point::Near(point_a)
                }
                _ => Point::Near(Vec3::zeros()),
            },
            _ if object.angles.is_some() => {
                let Some(found) = markers(self.record, object, i, j, self.known.size) else {
                    return Point::Near(self.near(i, j));
                };
                let axes_i = self.axes(connection).map_or_else(
                    || {
                        let (a, b) = (&self.record.bodies[i].design, &self.record.bodies[j].design);
                        a.R.transpose() * b.R * found.axes_j
                    },
                    |axes| axes.i,
                );
                self.frames[element] = Some((
                    Pose {
                        p: found.point_i,
                        R: axes_i,
                    },
                    Pose {
                        p: found.point_j,
                        R: found.axes_j,
                    },
                ));
                Point::Known(found.point_i)
            }
            "General_Force" | "Force_Vector" => self
                .floating(element, i)
                .map_or_else(|| Point::Near(self.near(i, j)), Point::Known),
            _ => Point::Near(self.near(i, j)),
        }
    }

    /// Sets the points of linear bushings that follow from their laws but not from the moments. Returns true if there are any.
    fn points_by_laws(&mut self, balanced: &Balanced) -> bool {
        let mut any = false;
        for (k, connection) in self.connections.placed.iter().enumerate() {
            let element = &self.record.elements[connection.element];
            if element.angles.is_none() || matches!(self.points[k].2, Point::Known(_)) {
                continue;
            }
            let Some(axes) = self.axes(*connection).filter(|axes| axes.left_rad < 1e-6) else {
                continue;
            };
            let bodies = (connection.i, connection.j);
            let near = &balanced.points[k];
            let found = point_by_law(self.record, element, bodies, &axes.j, near);
            if let Some(found) = found.filter(|found| found.open < 1e-6) {
                self.points[k].2 = Point::Known(found.point);
                any = true;
            }
        }
        any
    }

    /// Returns an initial guess of the point of an element, in the frame of its I body: the design position of the J body if I is ground, otherwise
    /// the origin.
    fn near(&self, i: usize, j: usize) -> Vec3 {
        if i == 0 {
            self.record.bodies[j].design.p
        } else {
            Vec3::zeros()
        }
    }

    fn axes(&self, connection: Connection) -> Option<bushing::Axes> {
        let angles = self.record.elements[connection.element].angles.as_ref()?;
        let bodies = &self.record.bodies;
        Some(bushing::axes(
            angles,
            &bodies[connection.i].poses,
            &bodies[connection.j].poses,
        ))
    }

    /// Returns the point of a body at which a vector force acts: the position of the floating marker that is fixed on the body. Among several such
    /// markers, the name closest to the name of the force is chosen. `None` if there is no such marker.
    fn floating(&self, element: usize, body: usize) -> Option<Vec3> {
        let name = &self.record.elements[element].name;
        let poses = &self.record.bodies[body].poses;
        let point = |places: &[Vec3]| {
            let local: Vec<Vec3> = places
                .iter()
                .zip(poses)
                .map(|(x, pose)| pose.inverse().point(x))
                .collect();
            let apart = local
                .iter()
                .map(|x| (x - local[0]).norm())
                .fold(0.0, f64::max);
            (apart <= CLOSURE_RELATIVE * self.known.size).then_some(local[0])
        };
        let markers = self.record.floating.iter();
        let resting = markers.filter_map(|marker| Some((&marker.name, point(&marker.places)?)));
        let best = resting.max_by(|a, b| {
            let close = |other: &str| super::names::affinity(name, other);
            close(a.0).total_cmp(&close(b.0))
        });
        best.map(|(_, point)| point)
    }

    /// Returns the forces on each body other than ground on which forces act. Each entry holds the index of the body and its terms, as indices into
    /// `points` with signs.
    fn forces_on_bodies(&self) -> Vec<(usize, Vec<Term>)> {
        let mut bodies: Vec<(usize, Vec<Term>)> = Vec::new();
        let mut add = |body: usize, point: usize, sign: f64| {
            if body == 0 {
                return;
            }
            match bodies.iter_mut().find(|(b, _)| *b == body) {
                Some((_, terms)) => terms.push((point, sign)),
                None => bodies.push((body, vec![(point, sign)])),
            }
        };
        for (point, connection) in self.connections.placed.iter().enumerate() {
            add(connection.i, point, 1.0);
            add(connection.j, point, -1.0);
        }
        bodies
    }

    /// Returns the weight of a body: the mean over all states of the force that balances its other forces.
    fn weight(&self, body: usize) -> Vec3 {
        let states = self.record.states();
        let mut sum = Vec3::zeros();
        for connection in &self.connections.placed {
            let on = |end: usize| f64::from(u8::from(end == body));
            let sign = on(connection.i) - on(connection.j);
            for force in &self.record.elements[connection.element].force {
                sum -= force * sign;
            }
        }
        sum / states as f64
    }

    fn balance(&self) -> Balanced {
        let bodies = self.forces_on_bodies();
        let weights: Vec<(Vec3, Vec3)> = bodies
            .iter()
            .map(|(body, _)| (self.weight(*body), Vec3::zeros()))
            .collect();
        let whole = Whole {
            record: self.record,
            points: &self.points,
            bodies: &bodies,
            weights: &weights,
        };
        whole.balance(&spread(self.record.states(), 400))
    }

    fn members(&self, balanced: &Balanced) -> Vec<Member> {
        let mut held: Vec<(usize, usize)> = Vec::new();
        let each = self.connections.placed.iter().enumerate();
        each.map(|(k, connection)| {
            let (point, open) = (balanced.points[k], balanced.points_open[k]);
            let (i, j) = (connection.i, connection.j);
            let pair = (i.min(j), i.max(j));
            let kind = self.record.elements[connection.element].ent_type.as_str();
            let constraint = matches!(kind, "Joint" | "Primitive_Joint" | "Motion");
            let rigid = constraint && self.known.motion(i, j) == Relation::Fixed;
            let (role, open) = if rigid && held.contains(&pair) {
                (Role::Carried, 0.0)
            } else {
                if rigid {
                    held.push(pair);
                }
                self.role(*connection, point, open)
            };
            Member {
                connection: *connection,
                role,
                open,
            }
        })
        .collect()
    }

    fn role(&self, connection: Connection, point: Vec3, open: f64) -> (Role, f64) {
        let Connection { element, i, j } = connection;
        let object = &self.record.elements[element];
        match object.ent_type.as_str() {
            "Joint" | "Primitive_Joint" => {
                let relation = self.known.motion(i, j);
                let found = joint(self.record, object, i, j, &relation);
                if let Some(mut found) = found {
                    if found.kind == "CYLINDRICAL"
                        && !matches!(relation, Relation::Cylindrical { .. })
                    {
                        // Without rotation, the axis of the joint passes through the point at which the joint acts.
                        let at = self.record.bodies[i].poses[0].point(&point);
                        found.i.p = point;
                        found.j.p = self.record.bodies[j].poses[0].inverse().point(&at);
                        return (Role::Joint(found), open);
                    }
                    return (Role::Joint(found), 0.0);
                }
                (Role::Load(point), open)
            }
            "Motion" if self.known.motion(i, j) == Relation::Fixed => {
                let found = joint(self.record, object, i, j, &Relation::Fixed);
                (found.map_or(Role::Carried, Role::Joint), 0.0)
            }
            "Motion" => match self.motion(connection, &point) {
                Some(role) => (role, 0.0),
                None => (Role::Load(point), open),
            },
            _ if object.angles.is_some() => self.bushing(connection, point, open),
            "Single_Component_Force" | "Translational_Spring_Damper" => {
                let found = spring(self.record, object, i, j, (&point, open), self.known.size);
                match found {
                    Some(found) => {
                        let open = if found.open { open } else { 0.0 };
                        (Role::Spring(found), open)
                    }
                    None => (Role::Load(point), open),
                }
            }
            _ => (Role::Load(point), open),
        }
    }

    fn bushing(&self, connection: Connection, point: Vec3, open: f64) -> (Role, f64) {
        let Connection { element, i, j } = connection;
        let object = &self.record.elements[element];
        let (frame_i, frame_j, open) = if let Some((frame_i, frame_j)) = self.frames[element] {
            (frame_i, frame_j, 0.0)
        } else {
            let bodies = &self.record.bodies;
            let at = bodies[j]
                .design
                .inverse()
                .point(&bodies[i].design.point(&point));
            let axes = self
                .axes(connection)
                .filter(|axes| axes.left_rad < 1e-6 && !axes.open);
            let (axes_i, axes_j) = axes.map_or_else(
                || {
                    let axes_j = bushing::stiffness_axes(self.record, object, i, j, &point);
                    (
                        bodies[i].design.R.transpose() * bodies[j].design.R * axes_j,
                        axes_j,
                    )
                },
                |axes| (axes.i, axes.j),
            );
            (
                Pose {
                    p: point,
                    R: axes_i,
                },
                Pose { p: at, R: axes_j },
                open,
            )
        };
        let motion = Motion::of(self.record, object, (i, &frame_i), (j, &frame_j));
        let law = bushing::law(&motion, self.known.size);
        let role = Role::Bushing {
            i: frame_i,
            j: frame_j,
            law,
            motion,
        };
        (role, open)
    }

    /// Finds the frames and values of a motion from its force or torque, whose direction is constant on the J body.
    fn motion(&self, connection: Connection, point: &Vec3) -> Option<Role> {
        let Connection { element, i, j } = connection;
        let object = &self.record.elements[element];
        let most = |values: &[Vec3]| values.iter().map(Vec3::norm).fold(0.0, f64::max);
        let turns = most(&object.force) <= 1e-9 * most(&object.torque) / self.known.size;
        let action = if turns { &object.torque } else { &object.force };
        let (a, b) = (&self.record.bodies[i].poses, &self.record.bodies[j].poses);
        let in_j: Vec<Vec3> = action
            .iter()
            .zip(b)
            .map(|(f, b)| b.R.transpose() * f)
            .collect();
        let axis = in_j
            .iter()
            .max_by(|x, y| x.norm().total_cmp(&y.norm()))?
            .normalize();
        if in_j
            .iter()
            .any(|f| (f - axis * axis.dot(f)).norm() > 1e-8 * most(&in_j))
        {
            return None;
        }
        let R_j = frame_along(&axis);
        let origin = b[0].inverse().point(&a[0].point(point));
        let j_frame = Pose { p: origin, R: R_j };
        let R_i: Mat3 = a[0].R.transpose() * b[0].R * R_j;
        let i_frame = Pose { p: *point, R: R_i };
        let values = motion_values(self.record, (i, &i_frame), (j, &j_frame), turns);
        Some(Role::Motion {
            i: i_frame,
            j: j_frame,
            turns,
            values,
        })
    }
}

/// Returns, for every state, the position of I along the z axis of J, or the angle of I about this axis.
pub(crate) fn motion_values(
    record: &Record,
    i: (usize, &Pose),
    j: (usize, &Pose),
    turns: bool,
) -> Vec<f64> {
    let (a, b) = (&record.bodies[i.0].poses, &record.bodies[j.0].poses);
    let poses = a.iter().zip(b);
    poses
        .map(|(a, b)| {
            let relative = b.compose(j.1).inverse().compose(&a.compose(i.1));
            if turns {
                libm::atan2(relative.R[(1, 0)], relative.R[(0, 0)])
            } else {
                relative.p.z
            }
        })
        .collect()
}

impl Mechanism {
    /// Sets the prescribed motions from the poses of another record of the same mechanism.
    pub(crate) fn take_motions(&mut self, record: &Record) {
        for member in &mut self.members {
            let Connection {
                i: on_i, j: on_j, ..
            } = member.connection;
            if let Role::Motion {
                i,
                j,
                turns,
                values,
            } = &mut member.role
            {
                *values = motion_values(record, (on_i, i), (on_j, j), *turns);
            }
        }
    }

    /// Returns true if the moments of all bodies balance with the points that were found.
    pub fn is_balanced(&self) -> bool {
        self.lever_left <= LEVER_RELATIVE * self.size
    }
}
