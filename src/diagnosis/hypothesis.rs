//! A hypothesis as data: what would be wrong, what that does to first order, and how a fit takes it in.

use super::cause::Cause;
use admire_identify::global::{Evolution, Row};
use admire_solver::mechanics::Vec6;
use admire_solver::model::MarkerIx;
use admire_syntax::{Address, NewStatement};

/// The effect of one number of a hypothesis to first order, per unit of the number.
#[derive(Clone, PartialEq, Debug)]
pub enum Sensitivity {
    /// None of its own: it is a member of the tolerance layer, or is found by fitting alone.
    None,
    /// Numbers of the deck change by these amounts in every load case.
    Always(Vec<(Address, f64)>),
    /// Numbers of the deck change by these amounts, one per load case.
    PerCase(Vec<(Address, Vec<f64>)>),
    /// A wrench in J axes acts on marker I, its opposite on the part of J; one per load case.
    Wrench((MarkerIx, MarkerIx), Vec<Vec6>),
    /// Rows of the residual change.
    Rows(Vec<(usize, f64)>),
}

/// How the number becomes an unknown of a fit.
#[derive(Clone, PartialEq, Debug)]
pub enum Parametrisation {
    /// As the column says, which holds for any size.
    Linear,
    /// The readings of these rows are 1 plus the number times the truth. With each row stands its reading in units of its noise.
    Gain(Vec<(usize, f64)>),
    /// This member of the tolerance layer: it may be larger than others of its group by the number's standard deviation.
    Member(usize),
    /// Numbers of the extended deck.
    Extended(Vec<(Address, f64)>),
    /// The number is a compliance: its inverse is each of these stiffnesses of the extended deck.
    Compliance(Vec<Address>),
    /// The logarithm of a stiffness of the extended deck.
    Rate {
        /// Where the stiffness stands.
        address: Address,
        /// First guess, and median of its prior.
        usual: f64,
    },
    /// A displacement of the two sides of a bushing along one of its components: the preload follows the stiffness.
    Offset {
        /// K or KT.
        stiffness: Address,
        /// FORCE or TORQUE.
        preload: Address,
    },
    /// The logarithm of the length a friction spring stretches before it slips, with its first guess and its usual size; the first
    /// number of the hypothesis over this length is what is reported, as a stiffness.
    SlipLength {
        /// Where the length stands.
        address: Address,
        /// First guess.
        start: f64,
        /// Median of its prior.
        usual: f64,
    },
}

/// One number of a hypothesis.
#[derive(Clone, PartialEq, Debug)]
pub struct EffectParameter {
    /// Its name in `diagnosis.json`.
    pub name: String,
    /// Prior mean, where the fit starts; zero for everything that is not there in a sound model.
    pub mean: f64,
    /// Prior standard deviation: the size such an effect may well have.
    pub sd: f64,
    /// What one unit of it is in the units of `diagnosis.json`.
    pub unit: f64,
    /// First-order effect.
    pub column: Sensitivity,
    /// How a fit sets it.
    pub unknown: Parametrisation,
}

/// A change of the deck's structure.
#[derive(Clone, PartialEq, Debug)]
pub enum Change {
    /// A new statement.
    Add(NewStatement),
    /// A new part that was a piece of the part with this id, and begins where that is.
    Piece(NewStatement, u32),
    /// The text of an argument.
    Text(Address, String),
}

/// A cause at a place.
#[derive(Clone, PartialEq, Debug)]
pub struct Hypothesis {
    /// What.
    pub cause: Cause,
    /// Where.
    pub address: String,
    /// All addresses of the same thing, if there are several.
    pub members: Vec<String>,
    /// `point` if all parts that meet there go together, `part` if one side does; empty where that says nothing.
    pub side: &'static str,
    /// Distinguishes several forms of the same cause at the same place.
    pub form: &'static str,
    /// Its numbers.
    pub numbers: Vec<EffectParameter>,
    /// Logarithm of its prior odds.
    pub ln_prior: f64,
    /// True if the first number can only be positive.
    pub one_sided: bool,
    /// What it adds to the deck before its numbers exist; they are zero there in effect.
    pub changes: Vec<Change>,
    /// What it carries from case to case.
    pub memory: Option<MemoryPlan>,
    /// Zero for a cause of its own; else the number of a further part of the law of one that is there already, told with that.
    /// [`BY_DIRECTION`] for a limit that differs by direction, [`LEFT_BY_LAW`] for what the law leaves.
    pub part: usize,
    /// A further part of its law that is tried together with it. Its numbers and changes are the last ones here; a fit takes the two apart.
    pub joint_with: Option<Box<Hypothesis>>,
}

/// A compliance of this part of its usual size is none.
const ABSENT: f64 = 1e-3;

/// Rubber that grows stiffer in one translation of a bushing does so in another with this probability, by each law.
const PROGRESSIVE_IN_OTHER_AXIS: f64 = 0.15;

/// The part of a friction by which its limit differs by direction.
pub(super) const BY_DIRECTION: usize = usize::MAX - 1;
/// The part of a cause that is not its law but what that leaves at its place: a force that differs from case to case.
pub(super) const LEFT_BY_LAW: usize = usize::MAX;

/// What a contact or rubber carries from case to case, and the function that measures its displacement.
#[derive(Clone, PartialEq, Debug)]
pub struct MemoryPlan {
    /// A number of the extended deck: where its spring is unstretched before the first case.
    pub anchor: Address,
    /// How that moves on.
    pub carries: Evolution,
    /// A number of the extended deck: the length of a slider's spring, or the part of the way that rubber flows in a case.
    pub by: Address,
    /// A function of the extended deck.
    pub measure: String,
}

impl std::fmt::Display for Hypothesis {
    /// `cause address`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.cause, self.address)
    }
}

impl Hypothesis {
    /// One that needs no change of the deck's structure.
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
            part: 0,
            joint_with: None,
        }
    }

    /// A cause and a further part of its law at once.
    #[must_use]
    pub fn joined(mut self, further: Self) -> Self {
        self.numbers.extend(further.numbers.iter().cloned());
        self.changes.extend(further.changes.iter().cloned());
        self.ln_prior += further.ln_prior;
        self.joint_with = Some(Box::new(further));
        self
    }

    /// The cause and the further part that comes in with it, each for itself.
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

    /// Members of the tolerance layer that stand out of their groups.
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

    /// Those that are causes of their own.
    pub fn causes(all: &[Self]) -> impl DoubleEndedIterator<Item = &Self> {
        all.iter().filter(|h| h.part == 0)
    }

    /// True if another one of these is a further part of its law.
    pub fn is_refined(&self, all: &[Self]) -> bool {
        all.iter().any(|h| h.part > self.part && h.same_site(self))
    }

    /// True for what the law of a cause leaves at its place.
    pub fn is_left_by_law(&self) -> bool {
        self.part == LEFT_BY_LAW
    }

    /// True if both say the same of the same place, in whatever form.
    pub fn same_site(&self, other: &Self) -> bool {
        self.cause == other.cause && self.address == other.address && self.side == other.side
    }

    /// Logarithm of its prior odds beside these causes: rubber that grows stiffer in one translation of a bushing mostly does so in others.
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

    /// Logarithm of the prior odds of all of these together, in whatever order.
    pub fn ln_prior_of(all: &[Self]) -> f64 {
        let own = all.iter().enumerate();
        own.map(|(k, h)| h.ln_prior_given(&all[..k])).sum()
    }

    /// True for a law that is known in kind but not in shape.
    pub fn is_poorly_linearised(&self) -> bool {
        self.cause.has_rough_law() && self.part != BY_DIRECTION
    }

    /// True if both are the same part of the same cause at the same place, with or without a further part, in whatever form.
    pub fn same_term(&self, other: &Self) -> bool {
        self.same_site(other)
            && self.part == other.part
            && self.joint_with.is_some() == other.joint_with.is_some()
    }

    /// The case in which alone it acts, if it is a fault of readings of one case.
    pub fn only_case(&self, rows: &[Row]) -> Option<usize> {
        let mut cases = self
            .numbers
            .iter()
            .flat_map(|number| match &number.column {
                Sensitivity::Rows(column) if self.cause.of_the_measurement() => column.as_slice(),
                _ => &[],
            })
            .map(|(row, _)| rows[*row].case());
        let first = cases.next()?;
        cases.all(|case| case == first).then_some(first)
    }

    /// False for what stands in for an effect that no cause of the catalogue has.
    pub fn is_in_catalogue(&self) -> bool {
        self.cause != Cause::UnmodelledForce
    }

    /// False for forces of unknown laws, alone or beside a law that was met badly.
    pub fn has_no_gp_term(&self) -> bool {
        self.is_in_catalogue() && !self.is_left_by_law()
    }

    /// True if both are the same in the same form.
    pub fn same_form(&self, other: &Self) -> bool {
        self.same_site(other)
            && self.form == other.form
            && self.part == other.part
            && self.numbers.len() == other.numbers.len()
    }

    /// True if both are the same law at the same place: the same in the same form, or contacts that remember, whose forms say where
    /// their numbers begin. Beside other causes the statements of a law have other ids.
    pub fn same_law(&self, other: &Self) -> bool {
        let remembers = self.memory.is_some()
            && other.memory.is_some()
            && self.part == other.part
            && self.numbers.len() == other.numbers.len();
        self.same_form(other) || (self.same_site(other) && remembers)
    }

    /// The members of the tolerance layer it lets stand out, with how far they may.
    pub fn slab(&self) -> Vec<(usize, f64)> {
        let member = |number: &EffectParameter| match number.unknown {
            Parametrisation::Member(at) => Some((at, number.sd)),
            _ => None,
        };
        self.numbers.iter().filter_map(member).collect()
    }

    /// True if all it says is that members of the tolerance layer stand out.
    pub fn is_slab(&self) -> bool {
        self.numbers
            .iter()
            .all(|number| matches!(number.unknown, Parametrisation::Member(_)))
    }
}

impl EffectParameter {
    /// The unknown of a fit where the cause is absent; what alone does nothing, such as the slip length of friction, is where it is.
    pub fn absent(&self, x: f64) -> f64 {
        match self.unknown {
            Parametrisation::Compliance(_) => x.max(-libm::log(ABSENT * self.sd)),
            Parametrisation::Rate { .. } | Parametrisation::SlipLength { .. } => x,
            _ => self.mean / self.sd,
        }
    }

    /// A number whose column holds for any size.
    pub fn linear(name: impl Into<String>, sd: f64, column: Sensitivity) -> Self {
        Self {
            column,
            ..Self::new(name, sd, Parametrisation::Linear)
        }
    }

    /// A number without any first-order effect of its own, which is found by fitting alone.
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

/// The address of one number.
pub(super) fn number(kind: &str, id: u32, argument: &str, index: Option<usize>) -> Address {
    Address {
        kind: kind.to_string(),
        id: Some(id),
        argument: Some(argument.to_string()),
        index,
    }
}

/// How the address of a bushing's component ends: `K.1` to `KT.3`.
pub(super) fn component(axis: usize) -> String {
    format!("{}.{}", ["K", "KT"][axis / 3], axis % 3 + 1)
}

/// Names of six components.
pub(super) const SIX: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];
/// Components of a vector force.
pub(super) const FORCES: [&str; 6] = ["FX", "FY", "FZ", "TX", "TY", "TZ"];
/// Stiffness of the directions in which a split part does not yield, in newtons per millimetre and newton millimetres per radian.
pub(super) const RIGID: [f64; 2] = [1e7, 1e11];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn translations_of_one_bushing_share_their_prior_in_any_order() {
        let at = |cause, address: &str| {
            let mut h = Hypothesis::plain(cause, address.to_string(), "", Vec::new());
            h.ln_prior = -7.0;
            h
        };
        let of = |addresses: &[&str]| -> f64 {
            let all = addresses.iter().map(|a| at(Cause::ProgressiveStiffness, a));
            Hypothesis::ln_prior_of(&all.collect::<Vec<_>>())
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
        assert_eq!(Hypothesis::ln_prior_of(&friction), -14.0);
    }
}
