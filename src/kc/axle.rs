//! All characteristics of an axle in one state, named as in Adams/Car.

use super::reading::Readings;
use super::{
    Anti, Compliance, Pairing, Reading, Sense, Side, SteerAxis, Steering, Tyre, Unit, Vehicle,
    VerticalLoad, Wheel, contact, force_compliance, ride, roll, roll_centre, swing_arm, wheel,
};
use admire_solver::mechanics::Vec3;

/// State of one wheel of an axle.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct WheelState {
    /// Position and orientation of the wheel in this state.
    pub wheel: Wheel,
    /// Position and orientation of the wheel at design.
    pub design: Wheel,
    /// Loaded tyre radius in this state and at design; `None` if no radius is known.
    pub radius: Option<[f64; 2]>,
    /// Steer axis, if known.
    pub axis: Option<SteerAxis>,
}

/// Data that no deck contains, such as tyre and vehicle, and the user's choices.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub struct Given {
    /// Tyre data.
    pub tyre: Option<Tyre>,
    /// Wheelbase, centre of mass, brake and drive fractions.
    pub vehicle: Option<Vehicle>,
    /// Weight of the sprung mass, in force units.
    pub weight: f64,
    /// Sprung mass of one corner divided by UCF, the unit consistency factor. A rate divided by this mass is in 1/s^2.
    pub corner_mass: f64,
    /// Vertical load case used for swing arms and roll centre.
    pub vertical_load: VerticalLoad,
    /// Turn radius of the last evaluated state of the test. It is reported for states without a turn radius of their own.
    pub last_turn_radius: Option<f64>,
}

/// Axle in one state.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct AxleState {
    /// Left and right wheel; `None` if the wheel is missing.
    pub wheels: [Option<WheelState>; 2],
    /// Unit normal of the road, pointing up.
    pub normal: Vec3,
    /// Compliance of the wheel centres, if known.
    pub compliance: Option<Compliance>,
}

impl WheelState {
    /// Returns the mirror image about Y = 0: the other wheel of a symmetric axle.
    #[must_use]
    pub(crate) fn mirrored(&self) -> Self {
        Self {
            wheel: self.wheel.mirrored(),
            design: self.design.mirrored(),
            radius: self.radius,
            axis: self.axis.map(|axis| axis.mirrored()),
        }
    }

    /// Returns the contact point in this state and at design. The design road is level.
    fn contact(&self, normal: &Vec3) -> Option<(Vec3, Vec3)> {
        let [now, then] = self.radius?;
        let at = |w: &Wheel, n: &Vec3, r| contact::contact_point(&w.centre, &w.spin, n, r);
        Some((
            at(&self.wheel, normal, now),
            at(&self.design, &Vec3::z(), then),
        ))
    }
}

/// Returns the lateral distance between the wheel centres at design, as listed in the tables of the rig.
fn design_track(left: &WheelState, right: &WheelState) -> f64 {
    right.design.centre.y - left.design.centre.y
}

/// Returns the argument that belongs to the side: `left` or `right`.
fn of(side: Side, left: &'static str, right: &'static str) -> &'static str {
    match side {
        Side::Left => left,
        Side::Right => right,
    }
}

impl AxleState {
    /// Iterates over the wheels present, each with its side.
    fn each(&self) -> impl Iterator<Item = (Side, WheelState)> + '_ {
        Side::BOTH
            .into_iter()
            .filter_map(|side| Some((side, self.wheels[side.index()]?)))
    }

    /// Returns both contact points; `None` unless both wheels are present and their radii are known.
    pub fn contacts(&self) -> Option<[Vec3; 2]> {
        let [left, right] = &self.wheels;
        let at = |wheel: &Option<WheelState>| Some(wheel.as_ref()?.contact(&self.normal)?.0);
        Some([at(left)?, at(right)?])
    }

    /// Returns the roll angle, in radians, of the line through the contact points. Returns `None` if [`Self::contacts`] is `None`.
    pub(crate) fn patch_roll(&self) -> Option<f64> {
        let ([l, r], [left, right]) = (self.contacts()?, &self.wheels);
        let track = design_track(left.as_ref()?, right.as_ref()?);
        Some(contact::roll_angle(l.z, r.z, track))
    }

    /// Returns the levers from both wheel centres to the points where road forces act.
    fn levers(&self, tyre: &Tyre) -> Option<[Vec3; 2]> {
        let [left, right] = &self.wheels;
        let of = |state: &WheelState| -> Option<Vec3> {
            let [radius, _] = state.radius?;
            Some(contact::lever(
                &state.wheel.spin,
                &self.normal,
                radius,
                tyre,
            ))
        };
        Some([of(left.as_ref()?)?, of(right.as_ref()?)?])
    }

    /// Returns the steering geometry; `None` unless both wheels, their radii and the vehicle are known.
    pub(crate) fn steering(&self, given: &Given) -> Option<Steering> {
        let ([l, r], [left, right]) = (self.contacts()?, &self.wheels);
        let steer = |state: &WheelState| wheel::steer(&state.wheel.spin, &self.normal);
        Some(Steering {
            steer: [steer(left.as_ref()?), steer(right.as_ref()?)],
            y: [l.y, r.y],
            wheelbase: given.vehicle?.wheelbase,
            last_radius: given.last_turn_radius,
        })
    }

    /// Computes every characteristic that follows from this state and the given data.
    pub fn readings(&self, given: &Given) -> Vec<Reading> {
        let mut out = Readings::default();
        self.geometry(&mut out);
        self.contact_geometry(given, &mut out);
        self.steer_axis(&mut out);
        if let Some(c) = &self.compliance {
            self.ride(c, given, &mut out);
            self.forces(c, given, &mut out);
            self.axle(c, given, &mut out);
        }
        out.all
    }

    fn geometry(&self, out: &mut Readings) {
        use Sense::{AboutX, Own, ToTheRight, X, Y, Z};
        for (side, state) in self.each() {
            let Wheel {
                centre: p, spin: o, ..
            } = state.wheel;
            let word = side.word();
            let moved = p - state.design.centre;
            out.push("toe_angle", word, Unit::Angle, Own, wheel::toe(&o));
            out.push("camber_angle", word, Unit::Angle, Own, wheel::camber(&o));
            let lean = wheel::inclination(side, &o, &self.normal);
            out.push("inclination_angle", word, Unit::Angle, AboutX, lean);
            let steer = wheel::steer(&o, &self.normal);
            out.push("steer_angle", word, Unit::Angle, ToTheRight, steer);
            let pitch = wheel::side_view_angle(&state.wheel.turn);
            out.push("side_view_angle", word, Unit::Angle, Own, pitch);
            let name = of(side, "vertical_left", "vertical_right");
            out.push("wheel_travel", name, Unit::Length, Own, moved.z);
            let name = of(side, "base_left", "base_right");
            out.push("wheel_travel_base", name, Unit::Length, X, moved.x);
            let name = of(side, "track_left", "track_right");
            out.push("wheel_travel_track", name, Unit::Length, Y, moved.y);
            let axis = wheel::axis_point(&state.wheel);
            let names = [
                of(side, "wheel_ctr_x_left", "wheel_ctr_x_right"),
                of(side, "wheel_ctr_y_left", "wheel_ctr_y_right"),
                of(side, "wheel_ctr_z_left", "wheel_ctr_z_right"),
                of(side, "wheel_axis_x_left", "wheel_axis_x_right"),
                of(side, "wheel_axis_y_left", "wheel_axis_y_right"),
                of(side, "wheel_axis_z_left", "wheel_axis_z_right"),
            ];
            for (k, name) in names.into_iter().enumerate() {
                let value = if k < 3 { p[k] } else { axis[k - 3] };
                out.push(
                    "wheelenv_output",
                    name,
                    Unit::Length,
                    [X, Y, Z][k % 3],
                    value,
                );
            }
        }
        if let [Some(left), Some(right)] = &self.wheels {
            let (l, r) = (&left.wheel.centre, &right.wheel.centre);
            let roll = contact::roll_angle(l.z, r.z, r.y - l.y);
            out.push("roll_angle", "at_wheel_centers", Unit::Angle, AboutX, roll);
        }
    }

    fn contact_geometry(&self, given: &Given, out: &mut Readings) {
        use Sense::{AboutX, Own, ToTheRight, X, Y, Z};
        for (side, state) in self.each() {
            let Some((now, then)) = state.contact(&self.normal) else {
                continue;
            };
            let entity = of(side, "left_tire_contact_point", "right_tire_contact_point");
            for (name, sense, value) in [
                (
                    of(side, "base_change_left", "base_change_right"),
                    X,
                    now.x - then.x,
                ),
                (
                    of(side, "track_change_left", "track_change_right"),
                    Y,
                    now.y - then.y,
                ),
                (of(side, "x_left", "x_right"), X, now.x),
                (of(side, "y_left", "y_right"), Y, now.y),
                (of(side, "z_left", "z_right"), Z, now.z),
            ] {
                out.push(entity, name, Unit::Length, sense, value);
            }
        }
        let (Some([l, r]), Some(roll)) = (self.contacts(), self.patch_roll()) else {
            return;
        };
        out.push(
            "roll_angle",
            "at_contact_patches",
            Unit::Angle,
            AboutX,
            roll,
        );
        let track = contact::total_track(&l, &r);
        out.push("total_track", "track", Unit::Length, Own, track);
        let Some(all) = self.steering(given) else {
            return;
        };
        for side in Side::BOTH {
            let word = side.word();
            let mut angle = |name, value| out.push(name, word, Unit::Angle, ToTheRight, value);
            angle("ackerman_angle", all.ackerman_angle());
            angle("ackerman", all.ackerman());
            angle("ideal_steer_angle", all.ideal(side));
            angle("ackerman_error", all.error(side));
            out.push("percent_ackerman", word, Unit::Percent, Own, all.percent());
            let diameter = all.outside_diameter(track);
            out.push("outside_turn_diameter", word, Unit::Length, Own, diameter);
            let radius = all.kept_radius();
            out.push("turn_radius", word, Unit::Length, ToTheRight, radius);
        }
    }

    fn steer_axis(&self, out: &mut Readings) {
        use Sense::{Own, X, Y, Z};
        for (side, state) in self.each() {
            let Some(axis) = &state.axis else { continue };
            let word = side.word();
            let centre = &state.wheel.centre;
            out.push("caster_angle", word, Unit::Angle, Own, axis.caster());
            let kingpin = axis.kingpin_inclination(side);
            out.push("kingpin_incl_angle", word, Unit::Angle, Own, kingpin);
            let k = axis.location(centre);
            let names = [
                of(side, "left_X", "right_X"),
                of(side, "left_Y", "right_Y"),
                of(side, "left_Z", "right_Z"),
            ];
            for (at, name) in names.into_iter().enumerate() {
                out.push("kingpin_location", name, Unit::Length, [X, Y, Z][at], k[at]);
            }
            let name = of(side, "off_left", "off_right");
            out.push(
                "steer_axis_offset",
                name,
                Unit::Length,
                Own,
                axis.offset(centre),
            );
            let (lateral, along) = axis.offset_parts(side, centre, &state.wheel.spin);
            let name = of(side, "lat_left", "lat_right");
            out.push("steer_axis_offset", name, Unit::Length, Own, lateral);
            let name = of(side, "lon_left", "lon_right");
            out.push("steer_axis_offset", name, Unit::Length, Own, along);
            out.push("steer_axis_pitch", word, Unit::Length, Own, axis.pitch);
            let Some((contact, _)) = state.contact(&self.normal) else {
                continue;
            };
            let steer = wheel::steer(&state.wheel.spin, &self.normal);
            let (scrub, trail) = axis.scrub_and_trail(side, &contact, &self.normal, steer);
            out.push("scrub_radius", word, Unit::Length, Own, scrub);
            out.push("caster_moment_arm", word, Unit::Length, Own, trail);
            let lead = axis.hub_lead(side, scrub, trail);
            out.push("hub_lead", word, Unit::Length, Own, lead);
            let lever = axis.load_lever(side, scrub, trail);
            out.push("wheel_load_lever_arm", word, Unit::Length, Own, lever);
            let at = axis.road_point(&contact, &self.normal);
            // This request holds x relative to the wheel centre at design, y in global axes, and z above the road.
            let shown = [at.x - state.design.centre.x, at.y, at.z - contact.z];
            for (at, name) in names.into_iter().enumerate() {
                let entity = "steer_axis_road_plane_intersection";
                out.push(entity, name, Unit::Length, [X, Y, Z][at], shown[at]);
            }
        }
    }

    fn ride(&self, c: &Compliance, given: &Given, out: &mut Readings) {
        use Sense::{Own, ToTheRight};
        let load = given.vertical_load;
        for (side, state) in self.each() {
            let word = side.word();
            let rate = ride::wheel_rate(c, side);
            out.push("wheel_rate", word, Unit::Rate, Own, rate);
            if let Some(tyre) = given.tyre.and_then(|tyre| tyre.stiffness) {
                let ride_rate = ride::ride_rate(rate, tyre);
                out.push("ride_rate", word, Unit::Rate, Own, ride_rate);
                if given.corner_mass > 0.0 {
                    let frequency = ride::ride_frequency(ride_rate, given.corner_mass, 1.0);
                    out.push("ride_frequency", word, Unit::Frequency, Own, frequency);
                }
            }
            let mut per_length =
                |name, sense, value| out.push(name, word, Unit::AnglePerLength, sense, value);
            let steer = ride::ride_steer(c, side, &state.wheel.spin);
            per_length("ride_steer", ToTheRight, steer);
            per_length("ride_camber", Own, ride::ride_camber(c, side));
            per_length("ride_caster", Own, ride::ride_caster(c, side));
            let angle = swing_arm::front_view_angle(c, side, load);
            out.push("fr_view_swing_arm_angle", word, Unit::Angle, Own, angle);
            let length = swing_arm::front_view_length(c, side, load);
            out.push("fr_view_swing_arm_length", word, Unit::Length, Own, length);
            let angle = swing_arm::side_view_angle(c, side, load);
            out.push("side_view_swing_arm_angle", word, Unit::Angle, Own, angle);
            let length = swing_arm::side_view_length(c, side, load);
            out.push(
                "side_view_swing_arm_length",
                word,
                Unit::Length,
                Own,
                length,
            );
        }
    }

    fn forces(&self, c: &Compliance, given: &Given, out: &mut Readings) {
        use Sense::{AboutZ, Own};
        for (side, _) in self.each() {
            let word = side.word();
            for (pairing, names) in [
                (
                    Pairing::Parallel,
                    [
                        "alt_steer_compliance",
                        "alt_camber_compliance",
                        "fore_aft_wheel_center_stiffness",
                        "lat_force_defl_compliance",
                        "lat_force_steer_compliance",
                        "lat_force_camber_compliance",
                    ],
                ),
                (
                    Pairing::Opposed,
                    [
                        "alt_steer_opposed",
                        "alt_camber_opposed",
                        "fore_aft_opposed_stiffness",
                        "lat_force_defl_opposed",
                        "lat_force_steer_opposed",
                        "lat_force_camber_opposed",
                    ],
                ),
            ] {
                if pairing == Pairing::Opposed && c.present != [true; 2] {
                    continue;
                }
                // Steer and aligning torque are both about Z, so their ratio keeps its sign in all axes. The sign of camber is independent
                // of the axes, so camber per aligning torque changes sign with the torque.
                let steer = force_compliance::aligning_steer(c, side, pairing);
                out.push(names[0], word, Unit::AnglePerTorque, Own, steer);
                let camber = force_compliance::aligning_camber(c, side, pairing);
                out.push(names[1], word, Unit::AnglePerTorque, AboutZ, camber);
                let rate = force_compliance::fore_aft_stiffness(c, side, pairing);
                out.push(names[2], word, Unit::Rate, Own, rate);
                let Some(Tyre { radius: r0, .. }) = given.tyre else {
                    continue;
                };
                let value = force_compliance::lateral_deflection(c, side, r0, pairing);
                out.push(names[3], word, Unit::LengthPerForce, Own, value);
                let value = force_compliance::lateral_steer(c, side, r0, pairing);
                // The ratio of a rotation about Z to a force along Y changes sign as X does, because the axes are right-handed.
                out.push(names[4], word, Unit::AnglePerForce, Sense::X, value);
                let value = force_compliance::lateral_camber(c, side, r0, pairing);
                out.push(names[5], word, Unit::AnglePerForce, Sense::Y, value);
            }
            let levers = given.tyre.map(|tyre| tyre.radius);
            for (names, lever) in [
                (
                    ["long_force_steer_center", "long_force_caster_center"],
                    Some(0.0),
                ),
                (
                    ["long_force_steer_patch", "long_force_caster_patch"],
                    levers,
                ),
            ] {
                let Some(lever) = lever else { continue };
                let value =
                    |i| force_compliance::longitudinal(c, side, i, lever, Pairing::Parallel);
                // The ratio of a rotation about Z to a force along X changes sign as Y does.
                out.push(names[0], word, Unit::AnglePerForce, Sense::Y, value(6));
                out.push(names[1], word, Unit::AnglePerForce, Sense::X, value(5));
            }
            let (Some(tyre), Some(vehicle)) = (given.tyre, &given.vehicle) else {
                continue;
            };
            let track = self.contacts().map(|[l, r]| contact::total_track(&l, &r));
            for anti in Anti::of_axle(vehicle.axle) {
                let share = anti.percent(c, side, vehicle, tyre.radius, track);
                let change = anti.height_per_g(c, side, vehicle, &tyre, track, given.weight);
                for (percent, height) in anti.names() {
                    out.push(percent, word, Unit::Percent, Own, share);
                    out.push(height, word, Unit::LengthPerG, Own, change);
                }
            }
        }
    }

    fn axle(&self, c: &Compliance, given: &Given, out: &mut Readings) {
        use Sense::{Own, Y};
        let (Some(contacts), [Some(left), Some(right)]) = (self.contacts(), &self.wheels) else {
            return;
        };
        if c.present != [true; 2] {
            return;
        }
        let track = contact::total_track(&contacts[0], &contacts[1]);
        let Some(levers) = given.tyre.and_then(|tyre| self.levers(&tyre)) else {
            return;
        };
        let tyre = given.tyre.and_then(|tyre| tyre.stiffness);
        let rate = roll::suspension_roll_rate(c, track);
        out.push(
            "susp_roll_rate",
            "suspension_roll_rate",
            Unit::RollRate,
            Own,
            rate,
        );
        let rate = roll::total_roll_rate(c, track, tyre);
        out.push(
            "total_roll_rate",
            "total_roll_rate",
            Unit::RollRate,
            Own,
            rate,
        );
        if let Some(tyre) = tyre {
            let rate = roll::tramp_rate(c, track, tyre);
            out.push("tramp_rate", "tramp_rate", Unit::RollRate, Own, rate);
        }
        let at_patch = c.at(levers);
        for (side, state) in Side::BOTH.into_iter().zip([left, right]) {
            let word = side.word();
            let spin = &state.wheel.spin;
            // Roll steer is a rotation about Z per rotation about X, so it changes sign exactly when the Y axis is reversed.
            let value = roll::roll_steer(&at_patch, side, spin, track, tyre);
            out.push("roll_steer", word, Unit::One, Y, value);
            let value = roll::roll_camber(c, side, track, tyre);
            out.push("roll_camber_coefficient", word, Unit::One, Own, value);
            let value = roll::roll_caster(c, side, track, tyre);
            out.push("roll_caster_coefficient", word, Unit::One, Sense::X, value);
        }
        let centre = roll_centre(&at_patch, &contacts, given.vertical_load);
        let name = "roll_center_location";
        for (component, sense, value) in [
            ("lateral_from_half_track", Y, centre.lateral),
            ("vertical", Own, centre.vertical),
            ("lateral_to_left_patch", Y, centre.to_patch[0]),
            ("lateral_to_right_patch", Y, centre.to_patch[1]),
        ] {
            out.push(name, component, Unit::Length, sense, value);
        }
    }
}
