//! Checks for slips (single mistaken numbers) in a study, as lines of the plausibility table.

use super::check::Verdict;
use super::mirrored_marks::mirrored;
use super::plausibility::Plausibility;
use admire_identify::LoadedStudy;
use admire_identify::slips::{displaced, search};
use admire_study::settings::BackendChoice;

impl Plausibility {
    /// Checks for bushings and joints whose two sides are apart in the design position. Returns true if one change of the deck closes the gaps.
    pub(super) fn assembly(&mut self, loaded: &LoadedStudy) -> bool {
        let found = displaced(loaded);
        let Some(mended) = found.iter().map(|gap| gap.is_mended).max() else {
            return false;
        };
        let why: Vec<String> = found.into_iter().map(|gap| gap.why).collect();
        let what = "parts of the deck do not fit together".to_string();
        self.add("assembly", what, refused_if(mended), why.join("; "));
        mended
    }

    /// Checks whether the marks are a mirror image of the parts. Returns true if they are; the noise of the marks is then meaningless.
    pub(super) fn mirror(&mut self, loaded: &LoadedStudy) -> bool {
        let Some(why) = mirrored(loaded) else {
            return false;
        };
        let found = "marks do not fit their parts".to_string();
        self.add("mirror", found, Verdict::Impossible, why);
        true
    }

    /// Searches for one mistaken number, unless another check already forbids a fit. Returns true if a slip is certain, or if a fit explains
    /// the readings without a slip.
    pub(super) fn slip(&mut self, loaded: &LoadedStudy) -> bool {
        if !self.allows_a_fit() || loaded.study.solver.backend != BackendChoice::Native {
            return false;
        }
        let found = search(loaded);
        let Some(slip) = found.slip else {
            return found.is_explained;
        };
        let as_it_is = match slip.left.0 {
            Some(left) => format!("the residuals are {left:.1} times the noise"),
            None => "the residuals are not defined, because a case has no equilibrium".to_string(),
        };
        let what = "no stiffness and no tolerance explains the readings".to_string();
        let why = format!(
            "{as_it_is}; with {}, they are {:.1} times the noise",
            slip.remedies.join(", or "),
            slip.left.1
        );
        self.add("slip", what, refused_if(slip.is_sure), why);
        slip.is_sure || found.is_explained
    }
}

const fn refused_if(mended: bool) -> Verdict {
    if mended {
        Verdict::Impossible
    } else {
        Verdict::Doubtful
    }
}
