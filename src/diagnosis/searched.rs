//! The searches behind a diagnosis: of all cases, and of those that are not held out; with errors of the rig where the readings ask for
//! them.

use std::sync::Arc;

use super::candidate_effect::CandidateEffect;
use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::findings::without;
use super::fit::FittedModel;
use super::frame;
use super::hold_out::HoldOutSelection;
use super::lack_of_fit::{is_structured, lack_of_fit_tests};
use super::progress::Progress;
use super::rig_errors::{ASKED, GaveWay, RigErrors, SHORT};
use super::search::Search;
use super::sought::{Begun, Sought, as_it_is};
use admire_identify::LackOfFitTest;
use admire_identify::tolerance::ScalePrior;
use admire_study::settings::Selection;

/// A search with errors of the rig that was made and rejected, and the study with them.
type Rejected<'a> = (RigErrors, DiagnosisProblem<'a>, Searched<'a>);

/// A search of all cases, and one without those held out.
pub(super) struct Searched<'a> {
    /// The study, its readings weighed.
    pub subject: DiagnosisProblem<'a>,
    /// What the search of all cases ended with.
    pub sought: Sought,
    /// Tests of structure in what its leading model leaves.
    pub tested: Vec<LackOfFitTest>,
    /// What the other one chose and predicts.
    pub unseen: Option<HoldOutSelection>,
}

impl<'a> Searched<'a> {
    /// The study with the errors of the rig that its readings ask for, and what was found with them. `None` where the deck cannot be solved.
    pub(super) fn to_the_end(
        mut unfitted: DiagnosisProblem<'a>,
        is_blind: bool,
        progress: &Progress,
    ) -> Option<(DiagnosisProblem<'a>, Self)> {
        let mut open = RigErrors::ALL.to_vec();
        open.retain(|errors| !errors.open(&unfitted).is_empty());
        // Fits without the alignment go astray from so far away.
        if open.contains(&RigErrors::Alignment) && frame::is_another(&unfitted) {
            unfitted = unfitted.with_groups([ScalePrior::of_another_frame(unfitted.millimetre())]);
            open.retain(|errors| *errors != RigErrors::Alignment);
        }
        if unfitted.problem.selection == Selection::Closure {
            // Errors of the rig are always among the tolerances; their sizes become small where the readings do not need them.
            let groups: Vec<_> = open
                .drain(..)
                .flat_map(|errors| errors.open(&unfitted))
                .collect();
            unfitted = unfitted.with_groups(groups);
        }
        let (mut unfitted, mut searched, mut rejected) =
            Self::giving_way(unfitted, &mut open, is_blind, progress)?;
        while let Some(at) = searched.asked(&open) {
            let errors = open.remove(at);
            let again = match rejected.take_if(|(of, ..)| *of == errors) {
                Some((_, scattered, again)) => searched
                    .gives_way(errors, &again)
                    .then_some((scattered, again)),
                None => searched.with(errors, &unfitted, is_blind, progress),
            };
            if let Some(again) = again {
                (unfitted, searched) = again;
                rejected = None;
            }
        }
        Some((unfitted, searched))
    }

    /// With those in `open` that promise far more than any cause on the way to the end; they are taken out of it. A search with such errors
    /// that was rejected is returned, too.
    fn giving_way(
        unfitted: DiagnosisProblem<'a>,
        open: &mut Vec<RigErrors>,
        is_blind: bool,
        progress: &Progress,
    ) -> Option<(DiagnosisProblem<'a>, Self, Option<Rejected<'a>>)> {
        let searched = Self::new(&unfitted, open, is_blind, progress)?;
        let Some(gave_way) = searched.sought.found.gave_way else {
            return Some((unfitted, searched, None));
        };
        let mut rest = open.clone();
        rest.retain(|errors| *errors != gave_way.errors);
        progress.renew();
        let count = rest.len();
        let with_them = unfitted.with_groups(gave_way.errors.open(&unfitted));
        let mut rejected = None;
        let again = Self::giving_way(with_them, &mut rest, is_blind, progress);
        if let Some((with_them, again, further)) = again {
            if searched.is_kept_to(gave_way, &again) {
                *open = rest;
                return Some((with_them, again, further));
            }
            let is_alone = rest.len() == count;
            rejected = is_alone.then_some((gave_way.errors, with_them, again));
        }
        progress.renew();
        let searched = Self::new(&unfitted, &[], is_blind, progress)?;
        Some((unfitted, searched, rejected))
    }

    /// True if the search that this one gave way to came to what was promised, with nothing left over.
    fn is_kept_to(&self, gave_way: GaveWay, again: &Self) -> bool {
        let leading = &again.sought.leading;
        self.subject.tails == again.subject.tails
            && again.is_plain()
            && !is_structured(&again.tested)
            && leading.ln_posterior() > gave_way.least
            && gave_way.errors.carried(&self.subject, leading) >= ASKED
    }

    /// Searches that give way to errors of the rig in `open` where both do. `None` where the deck cannot be solved.
    fn new(
        unfitted: &DiagnosisProblem<'a>,
        open: &[RigErrors],
        is_blind: bool,
        progress: &Progress,
    ) -> Option<Self> {
        let mut subject = unfitted.clone();
        progress.begin("fitting the model as it is");
        // That without the held-out cases comes first: the fit to all of them begins where it ends, and it owes them nothing.
        let mut begun = Begun::without_held_out(unfitted);
        let known = begun.as_ref().map(|begun| &*begun.none);
        let none = as_it_is(&mut subject, known, Data::All)?;
        progress.begin("searching causes");
        let mut search = Search::new(&subject, Arc::new(none), Data::All);
        // The search without the held-out cases says what is gained. Where a cause acts for sure it comes first: this one begins where it ends.
        let mut unseen = (is_blind && search.is_sure())
            .then(|| HoldOutSelection::new(begun.take()?, open, progress))
            .flatten();
        let is_first = unseen.is_some();
        if is_first {
            progress.renew();
            progress.begin("searching causes");
        }
        // What only the cases held out ask for is not asked for.
        let asked = unseen.as_ref().map(HoldOutSelection::gave_way);
        let search = search.giving_way_to(match &asked {
            Some(errors) => errors.as_slice(),
            None => open,
        });
        // Beside a law that was met badly it would begin with what that law leaves.
        let is_plain = |unseen: &&HoldOutSelection| {
            unseen
                .chosen
                .effects
                .iter()
                .all(CandidateEffect::has_no_gp_term)
        };
        let start = unseen.as_ref().filter(is_plain);
        let is_second = start.is_none();
        let mut sought = Sought::new(match start {
            Some(start) => search.ended_from(&start.chosen, start.fits()),
            None => search.ended(),
        });
        let gave_way = sought.found.gave_way.map(|gave_way| gave_way.errors);
        progress.begin("testing what was found");
        let mut tested = lack_of_fit_tests(&subject, &sought.leading);
        let is_unsure = match gave_way {
            Some(_) => is_blind,
            None => is_structured(&tested) || (is_blind && !sought.leading.effects.is_empty()),
        };
        if !is_first && is_unsure {
            unseen =
                begun.and_then(|begun| HoldOutSelection::new(begun, gave_way.as_slice(), progress));
        }
        if unseen.as_ref().map_or(gave_way, HoldOutSelection::gave_way) != gave_way {
            progress.renew();
            return Self::new(unfitted, &[], is_blind, progress);
        }
        if gave_way.is_none() {
            // Where this search did not begin there, that one gives a second start.
            if is_second
                && let Some(unseen) = &unseen
                && sought.resume(&subject, unseen.models(), Data::All)
            {
                tested = lack_of_fit_tests(&subject, &sought.leading);
            }
            if is_structured(&tested) && sought.with_tails(&mut subject) {
                tested = lack_of_fit_tests(&subject, &sought.leading);
            }
        }
        Some(Self {
            subject,
            sought,
            tested,
            unseen,
        })
    }

    /// Which errors of the rig the search is to be made again with: those that promise most, if that is enough. A force of an unknown
    /// law may have taken those of loads up.
    fn asked(&self, open: &[RigErrors]) -> Option<usize> {
        let each = open.iter().map(|errors| self.promised(*errors)).enumerate();
        let best = each.max_by(|a, b| a.1.total_cmp(&b.1));
        let best = best.filter(|(_, promised)| *promised >= ASKED);
        let plain = |fit: &FittedModel| fit.effects.iter().all(CandidateEffect::has_no_gp_term);
        let is_hidden = || {
            let unseen = self.unseen.as_ref();
            let may_be = |unseen: &HoldOutSelection| {
                !plain(&unseen.chosen) || self.unseen_agrees(unseen, RigErrors::Loads)
            };
            !self.is_plain() && unseen.is_none_or(may_be)
        };
        match best {
            Some((at, _)) => Some(at),
            None if is_hidden() => open.iter().position(|errors| *errors == RigErrors::Loads),
            None => None,
        }
    }

    /// By how many nats they would make the readings more probable: beside the leading model, or, of steady ones and within twice what is
    /// asked, in the place of one of its causes. What the search without the held-out cases does not ask for promises nothing.
    fn promised(&self, errors: RigErrors) -> f64 {
        let (found, leading) = (&self.sought.found, &self.sought.leading);
        let beside = found.promises.of(errors, &self.subject, leading);
        let instead = |at: usize| {
            let rest = without(found, leading, at);
            let own = rest.ln_posterior() - leading.ln_posterior();
            own + errors.promised(&self.subject, &rest) + 2.0 * ASKED
        };
        let causes = if errors.is_steady() {
            leading.effects.len()
        } else {
            0
        };
        let most = (0..causes).map(instead).fold(beside, f64::max);
        let unseen = self.unseen.as_ref().filter(|_| most >= ASKED);
        if unseen.is_none_or(|unseen| self.unseen_agrees(unseen, errors)) {
            most
        } else {
            0.0
        }
    }

    /// True if the search without the held-out cases asks for them, too, so that those cases do not choose the tolerances that predict them.
    fn unseen_agrees(&self, unseen: &HoldOutSelection, errors: RigErrors) -> bool {
        let chosen = &unseen.chosen;
        let asks = |fit: &Arc<FittedModel>| {
            let behind = chosen.ln_posterior() - fit.ln_posterior();
            let within = if Arc::ptr_eq(fit, chosen) {
                0.0
            } else {
                2.0 * ASKED
            };
            errors.promised(&self.subject, fit) + within >= behind + ASKED
        };
        asks(chosen) || unseen.fits().iter().any(asks)
    }

    /// The same with errors of the rig among the tolerances, where that makes the readings more probable.
    fn with(
        &self,
        errors: RigErrors,
        unfitted: &DiagnosisProblem<'a>,
        is_blind: bool,
        progress: &Progress,
    ) -> Option<(DiagnosisProblem<'a>, Self)> {
        let scattered = unfitted.with_groups(errors.open(unfitted));
        progress.renew();
        if scattered.budget_exhausted() {
            return None;
        }
        // Without a promise beside the leading model they are seldom there: the search of all cases alone tells.
        let leading = &self.sought.leading;
        let promised = self
            .sought
            .found
            .promises
            .of(errors, &self.subject, leading);
        let is_promised = promised >= ASKED;
        if !is_promised && !self.gives_way(errors, &Self::of_all_cases(&scattered)?) {
            return None;
        }
        let again = Self::new(&scattered, &[], is_blind, progress)?;
        self.gives_way(errors, &again).then_some((scattered, again))
    }

    /// The search of all cases, nothing else. `None` where the deck cannot be solved.
    fn of_all_cases(unfitted: &DiagnosisProblem<'a>) -> Option<Self> {
        let mut subject = unfitted.clone();
        let none = as_it_is(&mut subject, None, Data::All)?;
        let search = Search::new(&subject, Arc::new(none), Data::All);
        let sought = Sought::new(search.ended());
        Some(Self {
            tested: lack_of_fit_tests(&subject, &sought.leading),
            subject,
            sought,
            unseen: None,
        })
    }

    /// True if what was found with errors of the rig makes the readings more probable, and would not without them.
    fn gives_way(&self, errors: RigErrors, again: &Self) -> bool {
        let (leading, other) = (&self.sought.leading, &again.sought.leading);
        if errors.carried(&self.subject, other) < ASKED {
            return false;
        }
        if self.subject.tails == again.subject.tails {
            let is_named = leading.effects.iter().all(CandidateEffect::is_in_catalogue);
            let least = if again.is_plain() && !is_named {
                -SHORT
            } else if other.effects.len() < leading.effects.len() {
                0.0
            } else {
                ASKED
            };
            other.ln_posterior() - leading.ln_posterior() > least
        } else {
            // Readings are weighed differently: evidence does not tell.
            again.is_plain()
                && !is_structured(&again.tested)
                && other.effects.len() <= leading.effects.len()
        }
    }

    /// True if no force of an unknown law is in the leading model.
    fn is_plain(&self) -> bool {
        self.sought
            .leading
            .effects
            .iter()
            .all(CandidateEffect::has_no_gp_term)
    }
}
