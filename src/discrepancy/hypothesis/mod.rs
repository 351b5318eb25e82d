//! One file per cause: where in this deck it can occur, what it does to first order, and how the deck is extended by it.
//!
//! Knows the deck, the measurement and the state of every load case at the fit; not how hypotheses are compared.

mod assembly_offset;
mod body_compliance;
mod bushing_coupling;
mod bushing_orientation;
mod channel_fault;
mod dry_friction;
mod element_parameter;
mod frame_drift;
mod hardpoint_error;
mod link_compliance;
mod load_crosstalk;
mod load_gain;
mod load_point_error;
mod mark_outlier;
mod progressive_stiffness;
mod stop_contact;

use super::cause::Cause;
use super::survey::Survey;
use crate::mechanics::Vec6;
use crate::model::MarkerIx;
use crate::syntax::{Address, NewStatement};

pub use assembly_offset::of_bushing as assembly_offset;
pub use bushing_orientation::SD as TURN_SD;
pub use link_compliance::RIGID;

/// The effect of one number of a hypothesis to first order, per unit of the number.
#[derive(Clone, PartialEq, Debug)]
pub enum Column {
    /// Numbers of the deck change by these amounts in every load case.
    Always(Vec<(Address, f64)>),
    /// Numbers of the deck change by these amounts, one per load case.
    PerCase(Vec<(Address, Vec<f64>)>),
    /// A wrench in J axes acts on marker I, its opposite on the part of J; one per load case.
    Wrench((MarkerIx, MarkerIx), Vec<Vec6>),
    /// Rows of the whitened residual change.
    Rows(Vec<(usize, f64)>),
}

/// How the number becomes an unknown of a fit.
#[derive(Clone, PartialEq, Debug)]
pub enum Unknown {
    /// As the column says, which holds for any size.
    Linear,
    /// Numbers of the extended deck.
    Extended(Vec<(Address, f64)>),
    /// The number is a compliance: its inverse is each of these stiffnesses of the extended deck.
    Compliance(Vec<Address>),
    /// A displacement of the two sides of a bushing along one of its components: the preload follows the stiffness.
    Offset {
        /// K or KT.
        stiffness: Address,
        /// FORCE or TORQUE.
        preload: Address,
    },
    /// Markers turn together about this axis of the J marker.
    Turn(Turn),
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

/// Markers that turn on their parts about an axis given in their own axes.
#[derive(Clone, PartialEq, Debug)]
pub struct Turn {
    /// The markers, whose axes coincide at design.
    pub markers: [(MarkerIx, u32); 2],
    /// 0, 1 or 2.
    pub axis: usize,
}

/// One number of a hypothesis.
#[derive(Clone, PartialEq, Debug)]
pub struct Number {
    /// Its name in `diagnosis.json`.
    pub name: String,
    /// Prior mean, where the fit starts; zero for everything that is not there in a sound model.
    pub mean: f64,
    /// Prior standard deviation: the size such an effect may well have.
    pub sd: f64,
    /// First-order effect.
    pub column: Column,
    /// How a fit sets it.
    pub unknown: Unknown,
}

/// A change of the deck's structure.
#[derive(Clone, PartialEq, Debug)]
pub enum Change {
    /// A new statement.
    Add(NewStatement),
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
    /// Distinguishes several forms of the same cause at the same place.
    pub form: &'static str,
    /// Its numbers.
    pub numbers: Vec<Number>,
    /// True if the first number can only be positive.
    pub one_sided: bool,
    /// What it adds to the deck before its numbers exist; they are zero there in effect.
    pub changes: Vec<Change>,
    /// What it carries from case to case.
    pub memory: Option<MemoryPlan>,
}

/// A slider: its anchor before the first case, the length of its spring, and the function that measures its displacement.
#[derive(Clone, PartialEq, Debug)]
pub struct MemoryPlan {
    /// A number of the extended deck.
    pub anchor: Address,
    /// A number of the extended deck.
    pub length: Address,
    /// A function of the extended deck.
    pub measure: String,
}

impl Hypothesis {
    /// One that needs no change of the deck's structure.
    fn plain(cause: Cause, address: String, form: &'static str, numbers: Vec<Number>) -> Self {
        Self {
            cause,
            address,
            form,
            numbers,
            one_sided: false,
            changes: Vec::new(),
            memory: None,
        }
    }

    /// Numbers that are looked at together only for what they do to the readings.
    pub fn of_numbers(numbers: Vec<Number>) -> Self {
        Self::plain(Cause::HardpointError, String::new(), "", numbers)
    }

    /// True if both say the same of the same place, in whatever form.
    pub fn same_place(&self, other: &Self) -> bool {
        self.cause == other.cause && self.address == other.address
    }

    /// The case in which alone it acts, if it is a fault of readings of one case.
    pub fn only_case(&self, rows: &[crate::identify::global::Row]) -> Option<usize> {
        let mut cases = self
            .numbers
            .iter()
            .flat_map(|number| match &number.column {
                Column::Rows(column) if self.cause.of_the_measurement() => column.as_slice(),
                _ => &[],
            })
            .map(|(row, _)| rows[*row].case());
        let first = cases.next()?;
        cases.all(|case| case == first).then_some(first)
    }

    /// True if both are the same in the same form.
    pub fn same(&self, other: &Self) -> bool {
        self.same_place(other) && self.form == other.form
    }
}

impl Number {
    /// A number whose column holds for any size.
    fn linear(name: impl Into<String>, sd: f64, column: Column) -> Self {
        Self {
            column,
            ..Self::new(name, sd, Unknown::Linear)
        }
    }

    /// A number without any first-order effect of its own, which is found by fitting alone.
    fn new(name: impl Into<String>, sd: f64, unknown: Unknown) -> Self {
        Self {
            name: name.into(),
            mean: 0.0,
            sd,
            column: Column::Rows(Vec::new()),
            unknown,
        }
    }
}

/// Every hypothesis at every place of the deck, in a fixed order.
pub fn all(survey: &Survey<'_>) -> Vec<Hypothesis> {
    let mut out = Vec::new();
    progressive_stiffness::hypotheses(survey, &mut out);
    dry_friction::hypotheses(survey, &mut out);
    link_compliance::hypotheses(survey, &mut out);
    body_compliance::hypotheses(survey, &mut out);
    assembly_offset::hypotheses(survey, &mut out);
    hardpoint_error::hypotheses(survey, &mut out);
    bushing_orientation::hypotheses(survey, &mut out);
    bushing_coupling::hypotheses(survey, &mut out);
    element_parameter::hypotheses(survey, &mut out);
    stop_contact::hypotheses(survey, &mut out);
    load_gain::hypotheses(survey, &mut out);
    load_crosstalk::hypotheses(survey, &mut out);
    load_point_error::hypotheses(survey, &mut out);
    frame_drift::hypotheses(survey, &mut out);
    mark_outlier::hypotheses(survey, &mut out);
    channel_fault::hypotheses(survey, &mut out);
    out
}

/// Errors that every deck and rig has, with their usual sizes: hardpoints by a tenth of a millimetre, loads by a third of a percent.
pub fn background(survey: &Survey<'_>) -> Vec<Number> {
    let (mut points, mut gains) = (Vec::new(), Vec::new());
    hardpoint_error::hypotheses(survey, &mut points);
    load_gain::hypotheses(survey, &mut gains);
    // The three directions hold the one along a line.
    points.retain(|point: &Hypothesis| point.form.is_empty());
    let of = |hypotheses: Vec<Hypothesis>, sd: f64| {
        let numbers = hypotheses.into_iter().flat_map(|h| h.numbers);
        numbers.map(move |number| Number { sd, ..number })
    };
    of(points, BACKGROUND.0 * survey.millimetre())
        .chain(of(gains, BACKGROUND.1))
        .collect()
}

/// Millimetres and parts of a load.
pub const BACKGROUND: (f64, f64) = (0.1, 0.003);

/// The address of one number.
pub fn number(kind: &str, id: u32, argument: &str, index: Option<usize>) -> Address {
    Address {
        kind: kind.to_string(),
        id: Some(id),
        argument: Some(argument.to_string()),
        index,
    }
}

/// Names of six components.
const SIX: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Components of a vector force.
const FORCES: [&str; 6] = ["FX", "FY", "FZ", "TX", "TY", "TZ"];

/// How the address of a bushing's component ends.
fn component(axis: usize) -> String {
    format!("{}.{}", ["K", "KT"][axis / 3], axis % 3 + 1)
}
