//! What a diagnosis says of tolerances, in sentences.

use super::diagnose::Outcome;
use super::diagnosis::ToleranceFound;
use crate::tolerance::Group;

/// A size whose logarithm moves by less says nothing.
const SEEN: f64 = 0.05;

impl Outcome<'_> {
    /// Sizes of tolerances that the readings tell.
    pub(super) fn tolerances_in_words(&self) -> Vec<String> {
        let mut out = Vec::new();
        // Where the readings do not see points their size stays where it was.
        let seen = |size: &&ToleranceFound| libm::log(size.sd / size.usual).abs() > SEEN;
        if let Some(points) = self.diagnosis.tolerances.get("hardpoints").filter(seen) {
            let word = match points.sd / points.usual {
                ratio if ratio < 2.0 => "usual for a production axle",
                ratio if ratio < 4.0 => "much for a production axle",
                _ => "more than a production axle has",
            };
            out.push(format!(
                "The readings look as if hardpoints were {:.2} {} off, {word}.",
                points.sd, points.unit
            ));
        }
        if let Some(pose) = self.diagnosis.tolerances.get("pose-noise") {
            let sigma = self.subject.mark_sigma() / self.subject.millimetre();
            if pose.sd > sigma {
                out.push(format!(
                    "Whole parts are read {:.3} {} off in each case, {:.1} times the noise of a mark.",
                    pose.sd,
                    pose.unit,
                    pose.sd / sigma
                ));
            }
        }
        let loads = Group::LoadRepeatability.as_str();
        if let Some(loads) = self.diagnosis.tolerances.get(loads) {
            out.push(format!(
                "Loads scatter from case to case, by {:.2} percent of the largest value of each. The loads that acted are not quite those of the table.",
                100.0 * loads.sd
            ));
        }
        out
    }
}
