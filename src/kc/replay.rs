//! Wheels followed through the body motions of a results file.

use super::axle::WheelState;
use super::{AxleState, Frame, Side, SteerAxis, Tyre, Wheel, contact};
use admire_results::{Catalogue, Entity, ResultsError, Step};
use admire_solver::mechanics::{Mat3, Vec3, euler313};

/// Assumed road surface under the wheels.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum Road {
    /// Level road in the axes of the vehicle.
    #[default]
    Level,
    /// Plane parallel to X through both contact points, as on a rig that rolls the axle.
    Patches,
    /// Road of the rig of Adams/Car. In states where the rig rolls (`suspension_exerciser_requests.Roll` is nonzero), the road is tilted by the
    /// file's own `roll_angle.at_contact_patches`. In all other states, it is level.
    Rig,
}

/// Roll angle in radians up to which the rig counts as level.
const LEAST_ROLL: f64 = 1e-9;

/// Options for following the wheels in a results file.
#[derive(Clone, PartialEq, Debug)]
pub struct ReplayOptions {
    /// Column (0 to 2) of the wheel part's orientation matrix that is the spin axis. `None` selects the most lateral column. The sign of the
    /// axis is chosen so that it points outboard.
    pub spin: Option<usize>,
    /// Wheel centre in the frame of the wheel part.
    pub centre: Vec3,
    /// Axes of the results file.
    pub frame: Frame,
    /// Tyre data, for contact points.
    pub tyre: Option<Tyre>,
    /// Assumed road.
    pub road: Road,
}

/// Point fixed to a body.
#[derive(Clone, PartialEq, Debug)]
pub struct BodyPoint {
    /// Name of the body.
    pub body: String,
    /// Position in the frame of the body.
    pub local: Vec3,
}

/// Reason why wheels cannot be followed.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum ReplayError {
    /// The file has no body of this name.
    #[error("the file has no body `{name}`")]
    NoBody {
        /// Requested name.
        name: String,
        /// Names of the bodies in the file.
        bodies: Vec<String>,
    },
    /// The body has no position and orientation.
    #[error("`{name}` has no columns X, Y, Z, PSI, THETA, PHI")]
    NoPose {
        /// Name of the body.
        name: String,
    },
    /// Two wheels are on the same side.
    #[error("`{name}` is on the {side} side, like the previous wheel")]
    SameSide {
        /// Name of the second body.
        name: String,
        /// Side of the vehicle.
        side: &'static str,
    },
    /// No axis of the part is lateral at design.
    #[error(
        "no axis of `{name}` lies across the vehicle at design: the nearest is {degrees:.0} degrees off"
    )]
    NoSpin {
        /// Name of the body.
        name: String,
        /// Angle between the most lateral axis and the lateral direction, in degrees.
        degrees: f64,
    },
}

/// Column ids of a body's X, Y, Z, PSI, THETA, PHI.
#[derive(Clone, Copy, Debug)]
struct Body([usize; 6]);

impl Body {
    /// Returns the position of a point of the body, and the body's orientation, in the axes of Adams/Car.
    fn at(
        &self,
        local: &Vec3,
        (options, angle): (&ReplayOptions, f64),
        read: &dyn Fn(usize) -> f64,
    ) -> (Vec3, Mat3) {
        let [x, y, z, psi, theta, phi] = self.0.map(read);
        let R = euler313(psi * angle, theta * angle, phi * angle);
        let p = Vec3::new(x, y, z) + R * local;
        (options.frame.vector(&p), options.frame.from_deck * R)
    }
}

/// Wheel that is followed through the file.
#[derive(Clone, Debug)]
struct Followed {
    name: String,
    body: Body,
    /// Lower and upper point of the geometric steer axis.
    axis: Option<[(Body, Vec3); 2]>,
    /// Design data, set at the first step.
    known: Option<Known>,
}

#[derive(Clone, Debug)]
struct Known {
    /// Column of the orientation matrix that is the spin axis, and the sign that makes it point outboard.
    axis: (usize, f64),
    design: Wheel,
    design_R: Mat3,
    /// Column id of the tyre's normal force.
    normal_force: Option<usize>,
    design_radius: f64,
}

/// Reader that follows wheels through the steps of a results file. The first step is the design position.
#[derive(Clone, Debug)]
pub struct Replay {
    wheels: Vec<Followed>,
    options: ReplayOptions,
    /// Size of the file's angle unit in radians.
    angle: f64,
    /// Column ids of the normal forces, left and right.
    normal_force: [Option<usize>; 2],
    /// Column ids of the rig's roll input and of the roll angle at the contact points.
    roll: Option<[usize; 2]>,
}

impl Replay {
    /// Prepares to follow the bodies `names`. `axes` contains the lower and upper points of their steer axes and may be shorter than
    /// `names`. `degrees` states that the file's angles are in degrees.
    ///
    /// # Errors
    /// [`ReplayError`] if a body is missing or has no pose.
    pub fn new(
        catalogue: &Catalogue,
        names: &[String],
        axes: &[[BodyPoint; 2]],
        degrees: bool,
        options: ReplayOptions,
    ) -> Result<Self, ReplayError> {
        let wheels = names
            .iter()
            .enumerate()
            .map(|(k, name)| {
                let point = |at: &BodyPoint| Ok((body(catalogue, &at.body)?, at.local));
                Ok(Followed {
                    name: name.clone(),
                    body: body(catalogue, name)?,
                    axis: match axes.get(k) {
                        Some([lower, upper]) => Some([point(lower)?, point(upper)?]),
                        None => None,
                    },
                    known: None,
                })
            })
            .collect::<Result<_, _>>()?;
        let column = |entity: &str, component: &str| {
            let entity = catalogue.entities_called(entity).next()?;
            Some(entity.component(component)?.id)
        };
        let force = |name: &str| column(name, "normal");
        let rolls = column("suspension_exerciser_requests", "Roll");
        let at_patches = column("roll_angle", "at_contact_patches");
        Ok(Self {
            wheels,
            options,
            angle: if degrees { 1f64.to_radians() } else { 1.0 },
            normal_force: [force("left_tire_forces"), force("right_tire_forces")],
            roll: rolls.zip(at_patches).map(Into::into),
        })
    }

    /// Returns the state of the axle at a step. The first step passed in becomes the design position.
    ///
    /// # Errors
    /// [`ResultsError`] if the step cannot be read. The inner error is a [`ReplayError`] if a body has no lateral axis or two wheels are on
    /// one side.
    pub fn state(
        &mut self,
        step: &Step<'_>,
        values: &mut Vec<f64>,
    ) -> Result<Result<AxleState, ReplayError>, ResultsError> {
        step.values(values)?;
        let read = |id: usize| values.get(id - 1).copied().unwrap_or(f64::NAN);
        Ok(self.of_values(&read))
    }

    fn of_values(&mut self, read: &dyn Fn(usize) -> f64) -> Result<AxleState, ReplayError> {
        let (mut wheels, mut force, mut design_radius) = ([None; 2], [0.0; 2], [0.0; 2]);
        let (options, angle) = (&self.options, self.angle);
        for followed in &mut self.wheels {
            let how = (options, angle);
            let (p, R) = followed.body.at(&options.centre, how, read);
            let point = |(body, local): &(Body, Vec3)| body.at(local, how, read).0;
            let axis = followed
                .axis
                .as_ref()
                .and_then(|[lower, upper]| SteerAxis::through(&point(lower), &point(upper)));
            if followed.known.is_none() {
                let forces = (self.normal_force, read);
                followed.known = Some(Known::at(&followed.name, &p, &R, options, forces)?);
            }
            let Some(known) = &followed.known else {
                continue;
            };
            let side = known.design.side;
            let (column, sense) = known.axis;
            let wheel = Wheel {
                side,
                centre: p,
                spin: R.column(column) * sense,
                turn: R * known.design_R.transpose(),
            };
            if wheels[side.index()].is_some() {
                return Err(ReplayError::SameSide {
                    name: followed.name.clone(),
                    side: side.word(),
                });
            }
            wheels[side.index()] = Some(WheelState {
                wheel,
                design: known.design,
                radius: None,
                axis,
            });
            design_radius[side.index()] = known.design_radius;
            force[side.index()] = known.normal_force.map_or(0.0, read);
        }
        let mut state = AxleState {
            wheels,
            normal: Vec3::z(),
            compliance: None,
        };
        if let (Road::Rig, Some([rolls, at_patches])) = (options.road, self.roll)
            && read(rolls).abs() > LEAST_ROLL
        {
            let (sin, cos) = libm::sincos(read(at_patches) * angle);
            state.normal = Vec3::new(0.0, sin, cos);
        }
        let set_radii = |state: &mut AxleState| {
            let Some(tyre) = options.tyre else { return };
            for (k, wheel) in state.wheels.iter_mut().enumerate() {
                let Some(wheel) = wheel else { continue };
                let o = &wheel.wheel.spin;
                let now = contact::loaded_radius(&tyre, force[k], o, &state.normal);
                wheel.radius = Some([now, design_radius[k]]);
            }
        };
        set_radii(&mut state);
        if options.road == Road::Patches {
            lay_through_patches(&mut state, &set_radii);
        }
        Ok(state)
    }
}

impl Known {
    fn at(
        name: &str,
        p: &Vec3,
        R: &Mat3,
        options: &ReplayOptions,
        (forces, read): ([Option<usize>; 2], &dyn Fn(usize) -> f64),
    ) -> Result<Self, ReplayError> {
        /// Smallest lateral component of a spin axis at design.
        const LEAST: f64 = 0.8;
        let across = |k: usize| R[(1, k)].abs();
        let axis = options.spin.unwrap_or_else(|| {
            let mut axes = [2, 1, 0];
            axes.sort_by(|a, b| across(*b).total_cmp(&across(*a)));
            axes[0]
        });
        if !(across(axis) >= LEAST) {
            return Err(ReplayError::NoSpin {
                name: name.to_string(),
                degrees: libm::acos(across(axis)).to_degrees(),
            });
        }
        let side = if p.y < 0.0 { Side::Left } else { Side::Right };
        let sense = side.outboard_sign() * R[(1, axis)].signum();
        let normal_force = forces[side.index()];
        let spin: Vec3 = R.column(axis) * sense;
        let design_radius = options.tyre.map_or(0.0, |tyre| {
            let force = normal_force.map_or(0.0, read);
            contact::loaded_radius(&tyre, force, &spin, &Vec3::z())
        });
        Ok(Self {
            axis: (axis, sense),
            design: Wheel {
                side,
                centre: *p,
                spin,
                turn: Mat3::identity(),
            },
            design_R: *R,
            normal_force,
            design_radius,
        })
    }
}

/// Sets the road to the plane along X through both contact points. The contact points depend on the road, so it is found by iteration;
/// `set_radii` computes the loaded radii on the present road.
fn lay_through_patches(state: &mut AxleState, set_radii: &dyn Fn(&mut AxleState)) {
    /// Largest number of iterations. Each iteration multiplies the correction by less than the ratio of tyre radius to track.
    const ROUNDS: usize = 60;
    for _ in 0..ROUNDS {
        let Some(roll) = state.patch_roll() else {
            break;
        };
        let (sin, cos) = libm::sincos(roll);
        let normal = Vec3::new(0.0, sin, cos);
        let done = (normal - state.normal).norm() < 1e-16;
        state.normal = normal;
        set_radii(state);
        if done {
            break;
        }
    }
}

fn body(catalogue: &Catalogue, name: &str) -> Result<Body, ReplayError> {
    let with_suffix = format!("{name}_XFORM");
    let plain = |entity: &Entity| {
        let object = entity.entity.as_deref().unwrap_or(&entity.name);
        object.rsplit('.').next().unwrap_or(object).to_string()
    };
    let has_pose = |entity: &&Entity| entity.component("PSI").is_some();
    let entity = catalogue
        .entities_called(name)
        .chain(catalogue.entities_called(&with_suffix))
        .find(has_pose)
        .or_else(|| {
            let mut all = catalogue.entities.iter().filter(has_pose);
            all.find(|entity| plain(entity).eq_ignore_ascii_case(name))
        });
    let Some(entity) = entity else {
        let any = catalogue.entities_called(name).next().is_some();
        return Err(if any {
            ReplayError::NoPose {
                name: name.to_string(),
            }
        } else {
            ReplayError::NoBody {
                name: name.to_string(),
                bodies: catalogue
                    .entities
                    .iter()
                    .filter(has_pose)
                    .map(plain)
                    .collect(),
            }
        });
    };
    let mut ids = [0; 6];
    for (id, component) in ids.iter_mut().zip(["X", "Y", "Z", "PSI", "THETA", "PHI"]) {
        let Some(found) = entity.component(component) else {
            return Err(ReplayError::NoPose {
                name: name.to_string(),
            });
        };
        *id = found.id;
    }
    Ok(Body(ids))
}
