//! Candidate effect as data: the cause and its site, its first-order effect on the readings, and its parametrisation in a fit.

use super::cause::Cause;
use crate::priors::PROGRESSIVE_IN_OTHER_AXIS;
use crate::settings::ABSENT_COMPLIANCE;
use admire_identify::global::{Evolution, Row};
use admire_solver::mechanics::Vec6;
use admire_solver::model::MarkerIx;
use admire_syntax::{Address, NewStatement};

/// First-order effect of one parameter of a candidate, per unit of the parameter.
#[derive(Clone, PartialEq, Debug)]
pub enum Sensitivity {
    /// No column of its own: the parameter belongs to a random effect, or only a nonlinear fit can determine it.
    None,
    /// Changes of deck parameters that are the same in every load case.
    Always(Vec<(Address, f64)>),
    /// Changes of deck parameters, one value per load case.
    PerCase(Vec<(Address, Vec<f64>)>),
    /// Wrench on marker I and its opposite on the part of J, in the axes of J; one per load case.
    Wrench((MarkerIx, MarkerIx), Vec<Vec6>),
    /// Changes of residual rows, as pairs of row index and value.
    Rows(Vec<(usize, f64)>),
}

/// Representation of a parameter as an unknown of a fit.
#[derive(Clone, PartialEq, Debug)]
pub enum Parametrisation {
    /// Linear effect as given by the column, valid for any size.
    Linear,
    /// Relative gain error: the readings of these rows are `1 + parameter` times the truth. Each pair holds a row index and the reading in
    /// units of its noise.
    Gain(Vec<(usize, f64)>),
    /// Random effect with this index. Its prior variance grows by the square of the parameter's standard deviation, so that it may exceed its
    /// tolerance group.
    Member(usize),
    /// Changes of parameters of the extended deck per unit of the parameter.
    Extended(Vec<(Address, f64)>),
    /// Compliance. Its inverse is the value of each of these stiffnesses of the extended deck.
    Compliance(Vec<Address>),
    /// Logarithm of a stiffness of the extended deck.
    Rate {
        /// Address of the stiffness.
        address: Address,
        /// First guess, and median of the prior.
        usual: f64,
    },
    /// Displacement between the two sides of a bushing along one of its components. The preload follows as stiffness times displacement.
    Offset {
        /// Address of the K or KT component.
        stiffness: Address,
        /// Address of the FORCE or TORQUE component.
        preload: Address,
    },
    /// Logarithm of the slip length, which is the stretch of a friction spring at which the slider moves. Reported as a stiffness: the first
    /// parameter of the effect, a force, divided by this length.
    SlipLength {
        /// Address of the slip length.
        address: Address,
        /// First guess.
        start: f64,
        /// Median of the prior.
        usual: f64,
    },
}

/// Parameter of a candidate effect.
#[derive(Clone, PartialEq, Debug)]
pub struct EffectParameter {
    /// Name in `diagnosis.json`.
    pub name: String,
    /// Prior mean, and start of the fit. Zero for effects that are absent from a correct model.
    pub mean: f64,
    /// Prior standard deviation: a plausible size of the effect.
    pub sd: f64,
    /// Factor that converts the parameter to the units of `diagnosis.json`.
    pub unit: f64,
    /// First-order effect on the model or on the readings.
    pub column: Sensitivity,
    /// Representation as an unknown of a fit.
    pub unknown: Parametrisation,
}

/// Change of the deck's structure.
#[derive(Clone, PartialEq, Debug)]
pub enum Change {
    /// New statement.
    Add(NewStatement),
    /// New part split off the part with this id. Its initial pose is the pose of that part.
    Piece(NewStatement, u32),
    /// New text of an argument.
    Text(Address, String),
}

/// Candidate effect: a cause at a site of the deck.
#[derive(Clone, PartialEq, Debug)]
pub struct CandidateEffect {
    /// Cause.
    pub cause: Cause,
    /// Address of the site in the deck.
    pub address: String,
    /// Addresses of all members if the site has several.
    pub members: Vec<String>,
    /// `point` if all parts that meet there move together, `part` if only one side moves. Empty where the distinction does not apply.
    pub side: &'static str,
    /// Name that distinguishes forms of the same cause at the same site.
    pub form: &'static str,
    /// Parameters.
    pub numbers: Vec<EffectParameter>,
    /// Log prior odds.
    pub ln_prior: f64,
    /// True if the first parameter must not be negative.
    pub one_sided: bool,
    /// Changes of the deck's structure. They have no effect while the parameters are zero.
    pub changes: Vec<Change>,
    /// History variable carried from case to case.
    pub memory: Option<MemoryPlan>,
    /// Term of the law of the cause.
    pub term: Term,
    /// Further term that enters the model together with the main term. Its parameters and changes are the last in this candidate; a fit
    /// separates the two.
    pub joint_with: Option<Box<CandidateEffect>>,
}

/// Term of the law of a cause. Terms other than the main term are reported together with it. Later terms are larger.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Term {
    /// Main term, a cause of its own.
    Main,
    /// Further term of the same law, counted from 1: a further slider of a friction, or the growth of a coupling.
    Further(usize),
    /// Dependence of a friction limit on the direction.
    Asymmetry,
    /// Misfit of the law: a force at its site that differs from case to case.
    LawMisfit,
}

/// History variable of a contact or of flowing rubber, and the function that measures its displacement.
#[derive(Clone, PartialEq, Debug)]
pub struct MemoryPlan {
    /// Parameter of the extended deck: displacement at which the spring is unstretched before the first case.
    pub anchor: Address,
    /// Rule by which the anchor moves from case to case.
    pub carries: Evolution,
    /// Parameter of the extended deck: slip length of a slider, or fraction of the displacement that flows in one case.
    pub by: Address,
    /// Function expression in the extended deck that measures the displacement.
    pub measure: String,
}

impl std::fmt::Display for CandidateEffect {
    /// Writes `cause address`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.cause, self.address)
    }
}

impl CandidateEffect {
    /// Creates a candidate that needs no change of the deck's structure.
    pub fn plain(
        cause: Cause,
        address: String,
        form: &'static str,
        numbers: Vec<EffectParameter>,
    ) -> Self {
        Self {
            cause,
            address,
            members: Vec::new(),
            side: "",
            form,
            numbers,
            ln_prior: 0.0,
            one_sided: false,
            changes: Vec::new(),
            memory: None,
            term: Term::Main,
            joint_with: None,
        }
    }

    /// Combines the main term with a further term of its law into one candidate.
    #[must_use]
    pub fn joined(mut self, further: Self) -> Self {
        self.numbers.extend(further.numbers.iter().cloned());
        self.changes.extend(further.changes.iter().cloned());
        self.ln_prior += further.ln_prior;
        self.joint_with = Some(Box::new(further));
        self
    }

    /// Splits a combined candidate into the main term and the further term.
    pub fn split(&self) -> Vec<Self> {
        let mut own = self.clone();
        let Some(further) = own.joint_with.take() else {
            return vec![own];
        };
        own.numbers
            .truncate(own.numbers.len() - further.numbers.len());
        own.changes
            .truncate(own.changes.len() - further.changes.len());
        own.ln_prior -= further.ln_prior;
        vec![own, *further]
    }

    /// Creates a candidate that lets random effects exceed their tolerance groups, by standard deviation `sd`.
    pub fn outstanding(
        cause: Cause,
        address: String,
        form: &'static str,
        members: impl IntoIterator<Item = (usize, String)>,
        sd: f64,
    ) -> Self {
        let numbers = members.into_iter().map(|(member, name)| EffectParameter {
            name,
            mean: 0.0,
            sd,
            unit: 1.0,
            column: Sensitivity::None,
            unknown: Parametrisation::Member(member),
        });
        Self::plain(cause, address, form, numbers.collect())
    }

    /// Selects the main terms, which are causes of their own.
    pub fn causes(all: &[Self]) -> impl DoubleEndedIterator<Item = &Self> {
        all.iter().filter(|h| h.term == Term::Main)
    }

    /// Returns true if `all` contains a higher term of the same law.
    pub fn is_refined(&self, all: &[Self]) -> bool {
        all.iter().any(|h| h.term > self.term && h.same_site(self))
    }

    /// Returns true if this term is the misfit of a law.
    pub fn is_left_by_law(&self) -> bool {
        self.term == Term::LawMisfit
    }

    /// Returns true if both have the same cause and the same site, in any form.
    pub fn same_site(&self, other: &Self) -> bool {
        self.cause == other.cause && self.address == other.address && self.side == other.side
    }

    /// Returns the log prior odds given the other effects of a model. Rubber that is progressive in one translation of a bushing usually is
    /// so in the others.
    pub fn ln_prior_given(&self, others: &[Self]) -> f64 {
        let translations = |h: &Self| h.address.rsplit_once(".K.").map(|(of, _)| of.to_string());
        let is_alike = |other: &Self| {
            other.cause == self.cause
                && !other.same_site(self)
                && translations(self).is_some_and(|own| translations(other) == Some(own))
        };
        if self.cause == Cause::ProgressiveStiffness && others.iter().any(is_alike) {
            libm::log(PROGRESSIVE_IN_OTHER_AXIS)
        } else {
            self.ln_prior
        }
    }

    /// Returns the joint log prior odds of all these effects, independent of their order.
    pub fn ln_prior_of(all: &[Self]) -> f64 {
        let own = all.iter().enumerate();
        own.map(|(k, h)| h.ln_prior_given(&all[..k])).sum()
    }

    /// Returns true for a force law that is known in kind but not in shape.
    pub fn is_poorly_linearised(&self) -> bool {
        self.cause.has_rough_law() && self.term != Term::Asymmetry
    }

    /// Returns true if both are the same term of the same cause at the same site, in any form. Both or neither must include a further term.
    pub fn same_term(&self, other: &Self) -> bool {
        self.same_site(other)
            && self.term == other.term
            && self.joint_with.is_some() == other.joint_with.is_some()
    }

    /// Returns the only load case in which the effect acts, if it is a fault of readings of one case.
    pub fn only_case(&self, rows: &[Row]) -> Option<usize> {
        let mut cases = self
            .numbers
            .iter()
            .flat_map(|number| match &number.column {
                Sensitivity::Rows(column) if self.cause.is_reading_fault() => column.as_slice(),
                _ => &[],
            })
            .map(|(row, _)| rows[*row].case());
        let first = cases.next()?;
        cases.all(|case| case == first).then_some(first)
    }

    /// Returns false for a force that represents an effect outside the catalogue of causes.
    pub fn is_in_catalogue(&self) -> bool {
        self.cause != Cause::UnmodelledForce
    }

    /// Returns false for forces of unknown law: unmodelled forces and misfits of a law.
    pub fn has_no_gp_term(&self) -> bool {
        self.is_in_catalogue() && !self.is_left_by_law()
    }

    /// Returns true if both have the same cause, site, term and form.
    pub fn same_form(&self, other: &Self) -> bool {
        self.same_site(other)
            && self.form == other.form
            && self.term == other.term
            && self.numbers.len() == other.numbers.len()
    }

    /// Returns true if both are the same law at the same site. Forms of a law with memory count as the same law, because they differ only in
    /// their first guesses. Statement ids are ignored: they depend on the other causes in the deck.
    pub fn same_law(&self, other: &Self) -> bool {
        let remembers = self.memory.is_some()
            && other.memory.is_some()
            && self.term == other.term
            && self.numbers.len() == other.numbers.len();
        self.same_form(other) || (self.same_site(other) && remembers)
    }

    /// Returns the random effects that this candidate frees, each with the standard deviation of its slab.
    pub fn slab(&self) -> Vec<(usize, f64)> {
        let member = |number: &EffectParameter| match number.unknown {
            Parametrisation::Member(at) => Some((at, number.sd)),
            _ => None,
        };
        self.numbers.iter().filter_map(member).collect()
    }

    /// Returns true if the candidate only frees random effects from their tolerance groups.
    pub fn is_slab(&self) -> bool {
        self.numbers
            .iter()
            .all(|number| matches!(number.unknown, Parametrisation::Member(_)))
    }
}

impl EffectParameter {
    /// Returns the value of the fit's unknown at which the effect is absent. A parameter that does nothing alone, such as the slip length of
    /// friction, keeps its value.
    pub fn absent(&self, x: f64) -> f64 {
        match self.unknown {
            Parametrisation::Compliance(_) => x.max(-libm::log(ABSENT_COMPLIANCE * self.sd)),
            Parametrisation::Rate { .. } | Parametrisation::SlipLength { .. } => x,
            _ => self.mean / self.sd,
        }
    }

    /// Creates a parameter whose column is valid for any size.
    pub fn linear(name: impl Into<String>, sd: f64, column: Sensitivity) -> Self {
        Self {
            column,
            ..Self::new(name, sd, Parametrisation::Linear)
        }
    }

    /// Creates a parameter without a first-order effect, to be determined by a nonlinear fit.
    pub fn new(name: impl Into<String>, sd: f64, unknown: Parametrisation) -> Self {
        Self {
            name: name.into(),
            mean: 0.0,
            sd,
            unit: 1.0,
            column: Sensitivity::None,
            unknown,
        }
    }
}

/// Returns the address of an argument, or of one of its components.
pub(super) fn number(kind: &str, id: u32, argument: &str, index: Option<usize>) -> Address {
    Address {
        kind: kind.to_string(),
        id: Some(id),
        argument: Some(argument.to_string()),
        index,
    }
}

/// Returns the last part of the address of a bushing component: `K.1` to `KT.3`.
pub(super) fn component(axis: usize) -> String {
    format!("{}.{}", ["K", "KT"][axis / 3], axis % 3 + 1)
}

/// Names of the six components: three translations, three rotations.
pub(super) const SIX: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];
/// Names of the components of a vector force.
pub(super) const FORCES: [&str; 6] = ["FX", "FY", "FZ", "TX", "TY", "TZ"];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn translations_of_one_bushing_share_their_prior_in_any_order() {
        let at = |cause, address: &str| {
            let mut h = CandidateEffect::plain(cause, address.to_string(), "", Vec::new());
            h.ln_prior = -7.0;
            h
        };
        let of = |addresses: &[&str]| -> f64 {
            let all = addresses.iter().map(|a| at(Cause::ProgressiveStiffness, a));
            CandidateEffect::ln_prior_of(&all.collect::<Vec<_>>())
        };
        let shared = libm::log(PROGRESSIVE_IN_OTHER_AXIS);
        assert_eq!(of(&["BUSHING/1.K.1"]), -7.0);
        assert_eq!(of(&["BUSHING/1.K.1", "BUSHING/2.K.1"]), -14.0);
        let three = ["BUSHING/1.K.1", "BUSHING/2.K.1", "BUSHING/1.K.2"];
        assert_eq!(of(&three), -14.0 + shared);
        assert_eq!(of(&[three[2], three[1], three[0]]), -14.0 + shared);
        assert_eq!(of(&["BUSHING/1.KT.1", "BUSHING/1.KT.2"]), -14.0);
        assert_eq!(of(&["BUSHING/1.K.1", "BUSHING/1.KT.2"]), -14.0);
        let friction = ["BUSHING/1.K.1", "BUSHING/1.K.2"].map(|a| at(Cause::DryFriction, a));
        assert_eq!(CandidateEffect::ln_prior_of(&friction), -14.0);
    }
}
