//! Small errors that every axle and every rig has, in addition to the planted effects.

use super::effect::{EffectSpec, GroundTruth, direction_of, held, points};
use admire_session::backend::{Load, LoadProgramme};
use admire_solver::mechanics::Vec3;
use admire_study::Noise;
use admire_syntax::Address;
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Standard deviations of small errors in many places at once. Errors of the deck, of load gains and of load directions are drawn as effects
/// and planted like effects, so the list of planted effects contains them. The new study folder does not mention them.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Tolerances {
    /// Standard deviation of each coordinate of each hardpoint, in the deck's length unit. All parts that meet at a hardpoint have the same
    /// error.
    pub hardpoints: f64,
    /// Standard deviation of each coordinate of each marker at which a joint or spring holds a part, in the deck's length unit. Unlike `hardpoints`,
    /// this error displaces the marker of one part only.
    pub parts: f64,
    /// Standard deviation of each coordinate of the assembly offset of each bushing and FIELD, in the deck's length unit.
    pub assembly_offset: f64,
    /// Standard deviation of the rotation of each bushing and FIELD about each axis, in degrees.
    pub bushing_axis_deg: f64,
    /// Standard deviation of the preload of each spring, relative to its value in the deck.
    pub preload: f64,
    /// Standard deviation of the gain of each load, relative to its stated value.
    pub load_gain: f64,
    /// Standard deviation of the error of each load in each case, relative to the largest value of that load.
    pub load_repeatability: f64,
    /// Standard deviation of the rotation of the direction of each load, about each axis, in degrees.
    pub load_direction_deg: f64,
    /// Standard deviation of the position error of each mark on its part, per coordinate, in the deck's length unit. The error is constant over
    /// the cases.
    pub marks_on_parts: f64,
    /// Standard deviation of a common translation of all marks of a part in each case, per coordinate, in the deck's length unit.
    pub pose: f64,
    /// Standard deviation of a common rotation of all marks of a part in each case, about each axis through the mean of the marks, in degrees.
    pub pose_deg: f64,
    /// Standard deviation of the displacement of the measuring frame, per coordinate, in the deck's length unit. The displacement is constant
    /// over the cases.
    pub alignment: f64,
    /// Standard deviation of the rotation of the measuring frame about each axis through the mean of all marks of the first case, in degrees.
    /// The rotation is constant over the cases.
    pub alignment_deg: f64,
    /// Standard deviation of the displacement of the mount at the largest value of each load, per coordinate, in the deck's length unit.
    pub mount: f64,
    /// Standard deviation of the rotation of the mount at the largest value of each load, in degrees. The rotation is about each axis through
    /// the mean of all marks of the first case.
    pub mount_deg: f64,
    /// Standard deviation of the shift of the measuring frame in each case, per coordinate, in the deck's length unit. The shift is common to
    /// all marks.
    pub frame: f64,
    /// Standard deviation of the rotation of the measuring frame in each case, about each axis through the mean of all marks, in degrees.
    pub frame_deg: f64,
}

impl Tolerances {
    /// Parses a text such as `hardpoints=0.3,load_gain=0.005`. Standard deviations that are not given are zero.
    ///
    /// # Errors
    /// Returns a `bad-effect` diagnostic if the text does not have this form.
    pub fn parse(text: &str) -> Result<Self, Diagnostic> {
        let mut tolerances = Self::default();
        for item in text.split(',').filter(|item| !item.trim().is_empty()) {
            let (name, value) = item.split_once('=').unwrap_or((item, ""));
            let size = value.trim().parse::<f64>().ok();
            let size = size.filter(|size| size.is_finite() && *size >= 0.0);
            let mut named = tolerances.named();
            let place = named.iter_mut().find(|(own, _)| *own == name.trim());
            let (Some((_, place)), Some(size)) = (place, size) else {
                return Err(refuse(item));
            };
            **place = size;
        }
        Ok(tolerances)
    }

    /// Returns all standard deviations with their names in the text form.
    fn named(&mut self) -> [(&'static str, &mut f64); 17] {
        [
            ("hardpoints", &mut self.hardpoints),
            ("parts", &mut self.parts),
            ("assembly_offset", &mut self.assembly_offset),
            ("bushing_axis_deg", &mut self.bushing_axis_deg),
            ("preload", &mut self.preload),
            ("load_gain", &mut self.load_gain),
            ("load_repeatability", &mut self.load_repeatability),
            ("load_direction_deg", &mut self.load_direction_deg),
            ("marks_on_parts", &mut self.marks_on_parts),
            ("pose", &mut self.pose),
            ("pose_deg", &mut self.pose_deg),
            ("alignment", &mut self.alignment),
            ("alignment_deg", &mut self.alignment_deg),
            ("mount", &mut self.mount),
            ("mount_deg", &mut self.mount_deg),
            ("frame", &mut self.frame),
            ("frame_deg", &mut self.frame_deg),
        ]
    }

    /// Draws the errors of the deck, of load gains and of load directions as effects. Each group of errors has its own random stream, so it
    /// does not depend on the standard deviations of other groups.
    ///
    /// # Errors
    /// Returns a `bad-effect` diagnostic if the text of a drawn effect cannot be parsed, which indicates a programming error.
    pub(super) fn drawn(
        &self,
        seed: u64,
        reality: &GroundTruth,
    ) -> Result<Vec<EffectSpec>, Diagnostic> {
        let model = reality.model();
        let mut texts = Vec::new();
        if self.hardpoints > 0.0 {
            let mut noise = Noise::new(seed, "points");
            for point in points(&model) {
                let shift = shift(noise.vector(self.hardpoints));
                let id = point.id();
                texts.push(format!("hardpoint-error@MARKER/{id}:form=point,{shift}"));
            }
        }
        if self.parts > 0.0 {
            let mut noise = Noise::new(seed, "hardpoints");
            for (id, _) in held(&model) {
                let shift = shift(noise.vector(self.parts));
                texts.push(format!("hardpoint-error@MARKER/{id}:form=part,{shift}"));
            }
        }
        let mut offsets = Noise::new(seed, "assembly offsets");
        let mut axes = Noise::new(seed, "bushing axes");
        for bushing in model.elastic_pairs() {
            let (kind, id) = (bushing.kind, bushing.header.id);
            let offset = offsets.vector(self.assembly_offset);
            if self.assembly_offset > 0.0 {
                texts.push(format!("assembly-offset@{kind}/{id}:{}", shift(offset)));
            }
            let turn = axes.vector(self.bushing_axis_deg);
            if self.bushing_axis_deg > 0.0 {
                texts.push(format!("bushing-orientation@{kind}/{id}:{}", turned(turn)));
            }
        }
        let mut noise = Noise::new(seed, "preload");
        for spring in &model.springdampers {
            let factor = 1.0 + self.preload * noise.normal();
            if self.preload > 0.0 {
                let id = spring.header.id;
                texts.push(format!(
                    "element-parameter@SPRINGDAMPER/{id}.FORCE:factor={factor:e}"
                ));
            }
        }
        let mut gains = Noise::new(seed, "load gain");
        let mut directions = Noise::new(seed, "load direction");
        let mut turned_already: Vec<Address> = Vec::new();
        for load in &reality.programme.loads {
            let gain = 1.0 + self.load_gain * gains.normal();
            if self.load_gain > 0.0 {
                texts.push(format!("load-gain@{}:gain={gain:e}", load.target));
            }
            let turn = directions.vector(self.load_direction_deg);
            let object = Address {
                argument: None,
                index: None,
                ..load.target.clone()
            };
            let fresh = !turned_already.contains(&object);
            if self.load_direction_deg > 0.0 && fresh && direction_of(reality, &object).is_some() {
                // For an action-only force, the rotation about the line of the force has no effect.
                texts.push(format!("load-direction@{}:{}", load.target, turned(turn)));
                turned_already.push(object);
            }
        }
        texts.iter().map(|text| EffectSpec::parse(text)).collect()
    }

    /// Adds a random error to each force and torque in each load case. Prescribed displacements stay exact. A load that is zero in every case
    /// stays zero.
    pub(super) fn scatter(&self, seed: u64, programme: &mut LoadProgramme) {
        let mut noise = Noise::new(seed, "load repeatability");
        let is_force = |load: &Load| {
            let kind = load.target.kind.as_str();
            matches!(kind, "SFORCE" | "GFORCE" | "VFORCE" | "VTORQUE")
        };
        let forces: Vec<bool> = programme.loads.iter().map(is_force).collect();
        for load in (0..forces.len()).filter(|load| forces[*load]) {
            let values = programme.cases.iter().map(|case| case.values[load].abs());
            let largest = values.fold(0.0, f64::max);
            for case in &mut programme.cases {
                case.values[load] += self.load_repeatability * largest * noise.normal();
            }
        }
    }

    /// Formats the nonzero standard deviations as a text that [`Self::parse`] reads.
    pub(super) fn to_text(mut self) -> String {
        let asked = self.named().into_iter();
        let asked = asked.filter(|(_, size)| **size > 0.0);
        let items: Vec<String> = asked.map(|(name, size)| format!("{name}={size}")).collect();
        items.join(",")
    }
}

/// Formats a vector as the values `x`, `y` and `z` of an effect.
fn shift(v: Vec3) -> String {
    format!("x={:e},y={:e},z={:e}", v.x, v.y, v.z)
}

fn turned(v: Vec3) -> String {
    format!("ax_deg={:e},ay_deg={:e},az_deg={:e}", v.x, v.y, v.z)
}

fn refuse(item: &str) -> Diagnostic {
    let names: Vec<&str> = Tolerances::default()
        .named()
        .iter()
        .map(|(name, _)| *name)
        .collect();
    Diagnostic::error(Code::BadEffect, format!("`{item}` is not a tolerance")).help(format!(
        "for example hardpoints=0.3,load_gain=0.005; the tolerances are {}",
        names.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_session::backend::LoadCase;

    #[test]
    fn what_is_not_given_is_zero_and_what_is_unknown_is_refused() {
        let found = Tolerances::parse("hardpoints=0.1, load_gain=0.003").unwrap();
        assert_eq!((found.hardpoints, found.load_gain), (0.1, 0.003));
        assert_eq!(found.marks_on_parts, 0.0);
        assert_eq!(found.to_text(), "hardpoints=0.1,load_gain=0.003");
        for text in ["hardpoints", "rust=1", "load_gain=-1", "hardpoints=NaN"] {
            assert_eq!(
                Tolerances::parse(text).unwrap_err().code,
                Code::BadEffect,
                "{text}"
            );
        }
    }

    /// Forces must scatter by the stated fraction of their largest value, independently in each case. A prescribed displacement must stay
    /// exact.
    #[test]
    fn forces_scatter_by_their_largest_value() {
        let load = |kind: &str| Load {
            name: kind.to_string(),
            target: Address {
                kind: kind.to_string(),
                id: Some(1),
                argument: None,
                index: None,
            },
        };
        let cases: u16 = 400;
        let case = |k: u16| LoadCase {
            label: k.to_string(),
            values: vec![if k == 0 { -5000.0 } else { 1000.0 }, 20.0],
        };
        let stated = LoadProgramme {
            loads: vec![load("SFORCE"), load("MOTION")],
            cases: (0..cases).map(case).collect(),
        };
        let mut acting = stated.clone();
        let tolerances = Tolerances::parse("load_repeatability=0.002").unwrap();
        tolerances.scatter(4, &mut acting);
        let pairs = acting.cases.iter().zip(&stated.cases);
        let off: Vec<f64> = pairs.map(|(a, s)| a.values[0] - s.values[0]).collect();
        let rms = (off.iter().map(|x| x * x).sum::<f64>() / f64::from(cases)).sqrt();
        // The rms of 400 draws has a relative standard error of 3.5 percent.
        assert!((rms / 10.0 - 1.0).abs() < 0.12, "{rms}");
        assert!(off.windows(2).all(|pair| pair[0] != pair[1]));
        assert!(acting.cases.iter().all(|case| case.values[1] == 20.0));
    }
}
