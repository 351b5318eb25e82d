//! Candidate effect as data: a cause at a site of the deck, its first-order effect on the readings, and its parameters as unknowns of a fit.

use super::cause::Cause;
use crate::priors::PROGRESSIVE_IN_OTHER_AXIS;
use crate::settings::ABSENT_COMPLIANCE;
use admire_identify::global::{Evolution, Row};
use admire_solver::mechanics::Vec6;
use admire_solver::model::MarkerIx;
use admire_syntax::{Address, NewStatement};

/// First-order effect of one parameter of a candidate on the model or on the readings, per unit of the parameter.
#[derive(Clone, PartialEq, Debug)]
pub enum Sensitivity {
    /// No separate first-order effect. The parameter belongs to a random effect, or only a nonlinear fit can determine it.
    None,
    /// Changes of deck parameters that are the same in every load case. Each pair holds an address and the change.
    Always(Vec<(Address, f64)>),
    /// Changes of deck parameters that differ between load cases. Each pair holds an address and one change per load case.
    PerCase(Vec<(Address, Vec<f64>)>),
    /// Wrench on the first marker (I), with the opposite wrench on the part of the second marker (J). The list holds one wrench per load
    /// case, in the axes of J.
    Wrench((MarkerIx, MarkerIx), Vec<Vec6>),
    /// Changes of residual rows (prediction minus reading, in units of the noise). Each pair holds a row index and the change.
    Rows(Vec<(usize, f64)>),
}

/// Representation of a candidate's parameter as an unknown of a fit.
#[derive(Clone, PartialEq, Debug)]
pub enum Parametrisation {
    /// Effect proportional to the parameter, whatever its size. The first-order effect in `column` is then exact.
    Linear,
    /// Relative gain error: each listed reading is `1 + parameter` times its true value. Each pair holds a row index and the reading in
    /// units of its noise.
    Gain(Vec<(usize, f64)>),
    /// Random effect with this index, freed from its tolerance group. The variance of the parameter is added to the prior variance of the
    /// random effect.
    Member(usize),
    /// Changes of parameters of the extended deck. Each pair holds an address and the change per unit of the parameter.
    Extended(Vec<(Address, f64)>),
    /// Compliance, fitted as the logarithm of its inverse. The inverse is the value of each of these stiffnesses of the extended deck.
    Compliance(Vec<Address>),
    /// Logarithm of a stiffness of the extended deck.
    Rate {
        /// Address of the stiffness.
        address: Address,
        /// First guess of the stiffness, and median of its prior.
        usual: f64,
    },
    /// Offset between the two sides of a bushing in one component (translation or rotation). The preload changes by stiffness times offset.
    Offset {
        /// Address of the component's stiffness, an element of K or KT.
        stiffness: Address,
        /// Address of the component's preload, an element of FORCE or TORQUE.
        preload: Address,
    },
    /// Logarithm of the slip length: the stretch of a friction spring at which its slider starts to move. The report states a stiffness
    /// instead: the first parameter of the effect, which is a force, divided by the slip length.
    SlipLength {
        /// Address of the slip length.
        address: Address,
        /// First guess of the slip length.
        start: f64,
        /// Median of the prior of the slip length.
        usual: f64,
    },
}

/// Parameter of a candidate effect.
#[derive(Clone, PartialEq, Debug)]
pub struct EffectParameter {
    /// Name of the parameter in `diagnosis.json`.
    pub name: String,
    /// Prior mean of the parameter. Guesses for a fit are deviations from this mean. Zero for a parameter that vanishes in a correct model.
    pub mean: f64,
    /// Prior standard deviation: a plausible size of the parameter.
    pub sd: f64,
    /// Factor that converts the parameter to its unit in `diagnosis.json`.
    pub unit: f64,
    /// First-order effect of the parameter on the model or on the readings.
    pub column: Sensitivity,
    /// Representation of the parameter as an unknown of a fit.
    pub unknown: Parametrisation,
}

/// Change of the deck's structure by a candidate effect.
#[derive(Clone, PartialEq, Debug)]
pub enum Change {
    /// Statement added to the deck.
    Add(NewStatement),
    /// Statement of a new part that is split off the part with this id. The new part starts at the pose of that part.
    Piece(NewStatement, u32),
    /// New text of the argument at this address.
    Text(Address, String),
}

/// Candidate effect: a cause at a site of the deck.
#[derive(Clone, PartialEq, Debug)]
pub struct CandidateEffect {
    /// Cause that produces the effect.
    pub cause: Cause,
    /// Address of the site in the deck.
    pub address: String,
    /// Addresses of all members of the site, such as the markers of one hardpoint. Empty for a site with a single address.
    pub members: Vec<String>,
    /// `point` if all parts that meet at the site move together, `part` if only one part moves. Empty for causes without this distinction.
    pub side: &'static str,
    /// Name that distinguishes forms of the same cause at the same site. Two forms have different laws, or one law with different first
    /// guesses.
    pub form: &'static str,
    /// Parameters of the effect.
    pub numbers: Vec<EffectParameter>,
    /// Logarithm of the prior odds that the effect acts.
    pub ln_prior: f64,
    /// True if the first parameter must not be negative.
    pub one_sided: bool,
    /// Changes of the deck's structure that the effect requires. They do not change the response while the effect is absent.
    pub changes: Vec<Change>,
    /// History variable that is carried from one load case to the next. `None` for a law without memory.
    pub memory: Option<MemoryPlan>,
    /// Term of the cause's force law that this effect represents.
    pub term: Term,
    /// Further term of the same law, which enters the model together with this main term. Its parameters and changes are the last entries of
    /// `numbers` and `changes`. A fit treats the two terms separately.
    pub joint_with: Option<Box<CandidateEffect>>,
}

/// Term of the force law of a cause. Only the main term is a separate cause; the other terms are reported with it. Terms are ordered: each
/// refines the terms before it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Term {
    /// Main term, which is a separate cause.
    Main,
    /// Further term of the same law, counted from 1: a further slider of a friction law, or the growth of a bushing coupling with the
    /// deflection.
    Further(usize),
    /// Dependence of a friction limit on the direction of motion.
    Asymmetry,
    /// Deviation of the true force law from the fitted law: an extra force at the same site that differs from case to case.
    LawMisfit,
}

/// History variable of a friction law or of creeping rubber, and the function that measures the displacement that drives it.
#[derive(Clone, PartialEq, Debug)]
pub struct MemoryPlan {
    /// Address of the history variable in the extended deck. Its value there is the displacement at which the spring is unstretched before
    /// the first case.
    pub anchor: Address,
    /// Rule by which the history variable changes from case to case.
    pub carries: Evolution,
    /// Address of the rule's parameter in the extended deck: the slip length of a slider, or the fraction of the remaining displacement by
    /// which rubber flows in one case.
    pub by: Address,
    /// ADAMS function expression in the extended deck that measures the displacement.
    pub measure: String,
}

impl std::fmt::Display for CandidateEffect {
    /// Writes the cause and its address, separated by a blank.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.cause, self.address)
    }
}

impl CandidateEffect {
    /// Creates a candidate that requires no change of the deck's structure.
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

    /// Combines this main term with a further term of the same law into one candidate.
    #[must_use]
    pub fn joined(mut self, further: Self) -> Self {
        self.numbers.extend(further.numbers.iter().cloned());
        self.changes.extend(further.changes.iter().cloned());
        self.ln_prior += further.ln_prior;
        self.joint_with = Some(Box::new(further));
        self
    }

    /// Splits a combined candidate into its main term and its further term.
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

    /// Creates a candidate that frees random effects from their tolerance groups, by widening their priors with the standard deviation `sd`.
    /// Each entry of `members` holds the index of a random effect and the name of its parameter.
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

    /// Iterates over the main terms in `all`, each of which is a separate cause.
    pub fn causes(all: &[Self]) -> impl DoubleEndedIterator<Item = &Self> {
        all.iter().filter(|h| h.term == Term::Main)
    }

    /// Returns true if `all` contains a higher term of this effect's law at the same site.
    pub fn is_refined(&self, all: &[Self]) -> bool {
        all.iter().any(|h| h.term > self.term && h.same_site(self))
    }

    /// Returns true if this effect is the misfit of a force law: an extra force that differs from case to case.
    pub fn is_left_by_law(&self) -> bool {
        self.term == Term::LawMisfit
    }

    /// Returns true if both effects have the same cause and the same site. Their forms may differ.
    pub fn same_site(&self, other: &Self) -> bool {
        self.cause == other.cause && self.address == other.address && self.side == other.side
    }

    /// Returns the log prior odds of this effect, given the other effects of a model. A progressive law in one translation of a bushing
    /// makes a progressive law in its other translations more probable.
    pub fn ln_prior_given(&self, others: &[Self]) -> f64 {
        let translations = |h: &Self| {
            let of = h.address.rsplit_once(".K.");
            let (of, _) = of.or_else(|| h.address.rsplit_once(".F"))?;
            Some(of.to_string())
        };
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

    /// Returns the joint log prior odds of all these effects. The result does not depend on their order.
    pub fn ln_prior_of(all: &[Self]) -> f64 {
        let own = all.iter().enumerate();
        own.map(|(k, h)| h.ln_prior_given(&all[..k])).sum()
    }

    /// Returns true if the law of the effect is known in kind but not in shape, so that linearisation approximates it poorly. The asymmetry
    /// of a friction is linear, and therefore excluded.
    pub fn is_poorly_linearised(&self) -> bool {
        self.memory.is_some() || self.cause.has_rough_law() && self.term != Term::Asymmetry
    }

    /// Returns true if parameter `number` keeps its fitted value in linear models. This applies to the slip length, the anchor and the rate of a
    /// law with memory. The readings depend on them through the history of the law, so a linear model holds only for small changes.
    pub fn is_held(&self, number: usize) -> bool {
        self.memory.is_some() && number > 0
    }

    /// Returns true if both effects are the same term of the same cause at the same site, in any form. Both or neither must be combined with
    /// a further term.
    pub fn same_term(&self, other: &Self) -> bool {
        self.same_site(other)
            && self.term == other.term
            && self.joint_with.is_some() == other.joint_with.is_some()
    }

    /// Returns the only load case in which the effect acts, if the cause is a fault of the readings. Returns `None` if it acts in several
    /// cases, or for other causes.
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

    /// Returns false for a force of unknown law, which represents an effect outside the catalogue of causes.
    pub fn is_in_catalogue(&self) -> bool {
        self.cause != Cause::UnmodelledForce
    }

    /// Returns true if the effect has a force law. Unmodelled forces and misfits of a law have no law; they are modelled as Gaussian
    /// processes.
    pub fn has_no_gp_term(&self) -> bool {
        self.is_in_catalogue() && !self.is_left_by_law()
    }

    /// Returns true if both effects have the same cause, site, term, form and parameters.
    pub fn same_form(&self, other: &Self) -> bool {
        self.same_site(other)
            && self.form == other.form
            && self.term == other.term
            && self.numbers.len() == other.numbers.len()
            && self
                .numbers
                .iter()
                .zip(&other.numbers)
                .all(|(own, other)| own.name == other.name)
    }

    /// Returns true if both effects represent the same law at the same site. Forms of a law with memory count as the same law, because they
    /// differ only in their first guesses. Statement ids are ignored: they depend on the other causes in the deck.
    pub fn same_law(&self, other: &Self) -> bool {
        let remembers = self.memory.is_some()
            && other.memory.is_some()
            && self.term == other.term
            && self.numbers.len() == other.numbers.len();
        self.same_form(other) || (self.same_site(other) && remembers)
    }

    /// Returns true if both effects are the same term of a progressive stiffness at the same site. Their functions may differ. A selection
    /// counts such effects as one effect, but fits each function.
    pub fn is_alternative(&self, other: &Self) -> bool {
        self.cause == Cause::ProgressiveStiffness
            && self.same_site(other)
            && self.term == other.term
    }

    /// Returns true if a selection counts both effects as one: the same law, or alternative functions of it.
    pub fn is_same_effect(&self, other: &Self) -> bool {
        self.same_law(other) || self.is_alternative(other)
    }

    /// Returns the random effects that this candidate frees. Each pair holds the index and the standard deviation of the slab, the wide
    /// component of the prior.
    pub fn slab(&self) -> Vec<(usize, f64)> {
        let member = |number: &EffectParameter| match number.unknown {
            Parametrisation::Member(at) => Some((at, number.sd)),
            _ => None,
        };
        self.numbers.iter().filter_map(member).collect()
    }

    /// Returns true if all parameters of the candidate only free random effects from their tolerance groups.
    pub fn is_slab(&self) -> bool {
        self.numbers
            .iter()
            .all(|number| matches!(number.unknown, Parametrisation::Member(_)))
    }
}

impl EffectParameter {
    /// Returns the value of the fit's unknown at which the effect is absent; `x` is its fitted value. A compliance gets a stiffness that counts
    /// as rigid. A parameter without a separate effect, such as the slip length of friction, keeps its value.
    pub fn absent(&self, x: f64) -> f64 {
        match self.unknown {
            Parametrisation::Compliance(_) => x.max(-libm::log(ABSENT_COMPLIANCE * self.sd)),
            Parametrisation::Rate { .. } | Parametrisation::SlipLength { .. } => x,
            _ => self.mean / self.sd,
        }
    }

    /// Creates a parameter whose first-order effect `column` is exact at any size.
    pub fn linear(name: impl Into<String>, sd: f64, column: Sensitivity) -> Self {
        Self {
            column,
            ..Self::new(name, sd, Parametrisation::Linear)
        }
    }

    /// Creates a parameter without a first-order effect, which only a nonlinear fit can determine.
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

/// Returns the last part of the address of a bushing component: `K.1` to `K.3` for translations, `KT.1` to `KT.3` for rotations.
pub(super) fn component(axis: usize) -> String {
    format!("{}.{}", ["K", "KT"][axis / 3], axis % 3 + 1)
}

/// Names of the six components of a motion: three translations, then three rotations.
pub(super) const SIX: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];
/// Names of the six components of the vector force in a GFORCE statement.
pub(super) const FORCES: [&str; 6] = admire_syntax::FORCE_COMPONENTS;

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that each reading of a channel is a separate effect with its own prior. The functions of a progressive law are alternatives of
    /// each other; the forms of any other cause are not.
    #[test]
    fn readings_are_effects_of_their_own_and_functions_are_alternatives() {
        let at = |cause, address: &str, form, number: &str| {
            let number = EffectParameter::linear(number, 1.0, Sensitivity::None);
            CandidateEffect::plain(cause, address.to_string(), form, vec![number])
        };
        let reading = |case| at(Cause::ChannelFault, "roll", "value", case);
        assert!(!reading("case 1").is_same_effect(&reading("case 2")));
        assert!(reading("case 1").is_same_effect(&reading("case 1")));
        let law = |address, form| at(Cause::ProgressiveStiffness, address, form, form);
        assert!(law("BUSHING/1.K.1", "cubic").is_same_effect(&law("BUSHING/1.K.1", "quadratic")));
        assert!(!law("BUSHING/1.K.1", "cubic").is_same_effect(&law("BUSHING/1.K.2", "cubic")));
        let end = |form| at(Cause::FreePlay, "PART/6", form, "play");
        assert!(!end("first end").is_same_effect(&end("second end")));
    }

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
