//! Sentences of a diagnosis about tolerances and marks.

use super::diagnosis_text::Text;
use admire_identify::ToleranceFound;
use admire_identify::priors::HARDPOINT_MEDIAN_MM;
use admire_identify::tolerance::{EffectGroup, Misplaced};
use admire_solver::mechanics::Vec3;

/// Smallest change of a standard deviation from its usual value for which a sentence is written, as the absolute logarithm of their ratio.
const SEEN_LN: f64 = 0.05;

impl Text<'_> {
    /// Returns sentences about the tolerances that the readings determine.
    pub(super) fn tolerances_in_words(&self) -> Vec<String> {
        let mut out = Vec::new();
        // If the readings are insensitive to hardpoints, the tolerance of the hardpoints stays at its median.
        let usual = HARDPOINT_MEDIAN_MM;
        let seen = |size: &&ToleranceFound| libm::log(size.sd / size.usual).abs() > SEEN_LN;
        if let Some(points) = self
            .outcome
            .diagnosis
            .tolerances
            .get("hardpoints")
            .filter(seen)
        {
            let word = match points.sd / usual {
                ratio if ratio < 2.0 => "usual for a production axle",
                ratio if ratio < 4.0 => "large for a production axle",
                _ => "too large for a production axle",
            };
            let stated = if libm::log(points.usual / usual).abs() < SEEN_LN {
                String::new()
            } else {
                format!("; the study states {:.2} {}", points.usual, points.unit)
            };
            out.push(format!(
                "The readings indicate hardpoint errors with a standard deviation of {:.2} {}, {word} (typical: {usual:.1} mm{stated}).",
                points.sd, points.unit
            ));
        }
        let sizes = &self.outcome.extended.sizes;
        let groups = sizes.groups.iter().map(|(group, _)| group.as_str());
        let names = groups.chain(sizes.scales.iter().map(|(scale, _)| scale.as_str()));
        for ((name, size), ln) in names.zip(sizes.each()).zip(&sizes.ln) {
            if *ln >= size.bounds.1 && self.outcome.diagnosis.tolerances.contains_key(name) {
                out.push(format!(
                    "The standard deviation of group {name} is at its upper limit and may include effects of another origin."
                ));
            }
        }
        if let Some(pose) = self.outcome.diagnosis.tolerances.get("pose-noise") {
            let sigma = self.outcome.subject.mark_sigma() / self.outcome.subject.millimetre();
            if pose.sd > sigma {
                out.push(format!(
                    "The measured positions of whole parts scatter by {:.3} {} from case to case, {:.1} times the noise of a mark.",
                    pose.sd,
                    pose.unit,
                    pose.sd / sigma
                ));
            }
        }
        let loads = EffectGroup::LoadRepeatability.as_str();
        if let Some(loads) = self.outcome.diagnosis.tolerances.get(loads) {
            out.push(format!(
                "The loads scatter from case to case by {:.2} % of the largest value of each load: the applied loads differ from the table.",
                100.0 * loads.sd
            ));
        }
        let of = |group: EffectGroup| self.outcome.diagnosis.tolerances.get(group.as_str());
        if let Some(found) = of(EffectGroup::FrameAlignment)
            && let Some(own) = &self.outcome.extended.layout.motions
        {
            let six = &self.outcome.extended.x[own.first..own.first + 6];
            let [shift, turn] = [0, 3].map(|k| Vec3::from_column_slice(&six[k..k + 3]).norm());
            out.push(format!(
                "The measuring frame is offset by {:.2} {} and rotated by {:.3} deg from the deck's frame, equally in all cases.",
                shift / self.outcome.subject.millimetre(),
                found.unit,
                (own.turn * turn).to_degrees()
            ));
        }
        if let Some(found) = of(EffectGroup::MountYield) {
            out.push(format!(
                "The mounting of the axle is compliant: all marks move together, by {:.3} {} at the largest value of each load.",
                found.sd, found.unit
            ));
        }
        let frame = [
            (EffectGroup::FrameShifts, "differs from case to case by", ""),
            (EffectGroup::FrameDrifts, "drifts by", " per case"),
        ];
        let frame = frame.into_iter().filter_map(|(group, what, per)| {
            of(group).map(|found| format!("{what} {:.3} {}{per}", found.sd, found.unit))
        });
        let frame: Vec<String> = frame.collect();
        if !frame.is_empty() {
            out.push(format!(
                "The measuring frame {}, equally for all marks.",
                frame.join(" and ")
            ));
        }
        out
    }

    /// Returns sentences about marks that are misplaced or loose on their parts.
    pub(super) fn misplaced_in_words(&self) -> Vec<String> {
        let measurement = self.outcome.subject.problem.measurement;
        let decimals = self.decimals().finer();
        let of = |misplaced: &Misplaced| {
            let part = &measurement.parts[misplaced.part];
            let label = &part.marks[misplaced.mark].label;
            let off = format!(
                "{} {}",
                decimals.format(misplaced.error.norm()),
                self.length()
            );
            let how = if misplaced.is_loose() {
                let case = &measurement.cases[misplaced.cases[0]].label;
                let (count, read) = (misplaced.cases.len(), misplaced.read);
                format!(
                    "is loose: in {count} of {read} cases, first in case {case}, its reading is {off} from"
                )
            } else {
                format!("is read {off} from")
            };
            format!(
                "Mark {label} of {} {how} its position in the list of marks on parts. The mark is left out.",
                part.name
            )
        };
        self.outcome
            .subject
            .noise
            .misplaced
            .iter()
            .map(of)
            .collect()
    }
}
