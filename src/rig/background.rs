//! Small errors every rig has besides the one that is looked for.

use super::noise::Noise;
use crate::backend::LoadProgramme;
use crate::diagnostic::{Code, Diagnostic};
use crate::model::Model;
use crate::syntax::{Address, Dataset};

/// Standard deviations of small errors in many places at once.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Background {
    /// Of each coordinate of each marker at which a joint or a spring holds a part, in the deck's length unit.
    pub hardpoints: f64,
    /// Of the gain of each load, relative.
    pub load_gain: f64,
    /// Of one coordinate of the first CMM session instead of the study's; the folder tells it, as the data sheet would.
    pub marks_on_parts: f64,
}

impl Background {
    /// What an ordinary rig has: 0.1 mm at hardpoints, 0.3 percent of load gain, 0.02 mm in the first session.
    pub const ORDINARY: Self = Self {
        hardpoints: 0.1,
        load_gain: 0.003,
        marks_on_parts: 0.02,
    };

    /// Reads `hardpoints=0.1,load_gain=0.003,marks_on_parts=0.02`; what is not given is zero.
    ///
    /// # Errors
    /// `bad-effect` when it is something else.
    pub fn parse(text: &str) -> Result<Self, Diagnostic> {
        let mut background = Self::default();
        for item in text.split(',').filter(|item| !item.trim().is_empty()) {
            let (name, value) = item.split_once('=').unwrap_or((item, ""));
            let size = value.trim().parse::<f64>().ok();
            let size = size.filter(|size| size.is_finite() && *size >= 0.0);
            let place = match name.trim() {
                "hardpoints" => &mut background.hardpoints,
                "load_gain" => &mut background.load_gain,
                "marks_on_parts" => &mut background.marks_on_parts,
                _ => return Err(refuse(item)),
            };
            *place = size.ok_or_else(|| refuse(item))?;
        }
        Ok(background)
    }

    /// Draws the errors of the deck and of the loads.
    ///
    /// # Errors
    /// A marker whose place cannot be edited.
    pub(super) fn apply(
        &self,
        seed: u64,
        dataset: &mut Dataset,
        programme: &mut LoadProgramme,
    ) -> Result<(), Diagnostic> {
        if self.hardpoints > 0.0 {
            let mut noise = Noise::new(seed, "hardpoints");
            for (id, place) in connections(&Model::lower(dataset).value) {
                let moved = place + noise.vector(self.hardpoints);
                for k in 0..3 {
                    let address = Address {
                        kind: "MARKER".to_string(),
                        id: Some(id),
                        argument: Some("QP".to_string()),
                        index: Some(k + 1),
                    };
                    let edits = dataset.set(&address, moved[k])?;
                    let edited = dataset.edited(&edits);
                    *dataset = edited.expect("edits of one number do not overlap").value;
                }
            }
        }
        let mut noise = Noise::new(seed, "load gain");
        for load in 0..programme.loads.len() {
            let gain = 1.0 + self.load_gain * noise.normal();
            for case in &mut programme.cases {
                case.values[load] *= gain;
            }
        }
        Ok(())
    }
}

fn refuse(item: &str) -> Diagnostic {
    Diagnostic::error(
        Code::BadEffect,
        format!("`{item}` is no background error of a rig"),
    )
    .help("for example hardpoints=0.1,load_gain=0.003,marks_on_parts=0.02")
}

/// Markers of joints and springs with their places; for a bushing the same is an assembly offset.
fn connections(model: &Model) -> Vec<(u32, crate::mechanics::Vec3)> {
    let joints = model.joints.iter().map(|o| [o.i, o.j]);
    let primitives = model.primitives.iter().map(|o| [o.i, o.j]);
    let springs = model.springdampers.iter().map(|o| [o.i, o.j]);
    let mut found: Vec<_> = joints
        .chain(primitives)
        .chain(springs)
        .flatten()
        .map(|marker| {
            let marker = &model.markers[marker.0];
            (marker.header.id, marker.qp)
        })
        .collect();
    found.sort_by_key(|(id, _)| *id);
    found.dedup_by_key(|(id, _)| *id);
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_given_is_zero_and_what_is_unknown_is_refused() {
        let background = Background::parse("hardpoints=0.1, load_gain=0.003").unwrap();
        assert_eq!((background.hardpoints, background.load_gain), (0.1, 0.003));
        assert_eq!(background.marks_on_parts, 0.0);
        for text in ["hardpoints", "rust=1", "load_gain=-1", "hardpoints=NaN"] {
            assert_eq!(
                Background::parse(text).unwrap_err().code,
                Code::BadEffect,
                "{text}"
            );
        }
    }
}
