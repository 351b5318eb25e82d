use admire_solver::model::{Model, PartIx};
use admire_solver::statics::{Sensitivity, SolveError, StaticSettings, solve};
use admire_solver::system::{Quantity, Slot, System};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::units::Dimension;
use admire_syntax::{Address, Dataset};

/// Exact derivatives of an equilibrium with respect to parameters of a deck, in the deck's units (angles in radians). A change of QP moves
/// a marker without rotation. Markers that are defined in the frame of another marker (RM) move with that marker.
#[derive(Clone, PartialEq, Debug)]
pub struct SensitivityTable {
    /// Names of the results, which are the columns of the table, for example `PART/4 x`.
    pub of: Vec<String>,
    /// Units of the results; empty if unknown.
    pub units: Vec<String>,
    /// Rows of the table, one for each parameter.
    pub by: Vec<SensitivityRow>,
}

/// Derivatives of all results with respect to one parameter.
#[derive(Clone, PartialEq, Debug)]
pub struct SensitivityRow {
    /// Address of the parameter.
    pub address: String,
    /// Value of the parameter; NaN if it is a function.
    pub value: f64,
    /// Unit of the parameter; empty if dimensionless. A derivative is in the unit of its column divided by this unit.
    pub unit: String,
    /// Derivative of each column with respect to the parameter.
    pub derivatives: Vec<f64>,
}

/// Reason why there is no table.
#[derive(Debug)]
pub(crate) enum Unavailable {
    /// A name is invalid.
    Word(Diagnostic),
    /// There is no equilibrium.
    NoAnswer(SolveError),
}

impl SensitivityTable {
    /// Solves the equilibrium at a time and differentiates it. `of` names parts (their motion), forces and joints (their force on I), or
    /// request components such as `REQUEST/1.F2`. `by` names parameters; if it is empty, all parameters with an effect are used.
    pub(crate) fn new(
        dataset: &Dataset,
        model: &Model,
        system: &System,
        of: &[String],
        by: &[String],
        time: f64,
    ) -> Result<Self, Unavailable> {
        let mut columns = Vec::new();
        for text in of {
            let found = quantities(text, (dataset, model, system));
            columns.extend(found.map_err(Unavailable::Word)?);
        }
        let slots = slots(by, (dataset, system)).map_err(Unavailable::Word)?;
        let (parameters, mut state) = (system.parameters(), system.state());
        state.time = time;
        let settings = StaticSettings::from(system.settings());
        let rows = solve(system, &parameters, &mut state, &settings)
            .and_then(|_| {
                let quantities: Vec<Quantity> = columns.iter().map(|c| c.quantity).collect();
                Sensitivity::new(system, &parameters, &state)?.table(&quantities, &slots)
            })
            .map_err(Unavailable::NoAnswer)?;
        let named = slots
            .iter()
            .zip(rows)
            .map(|(&slot, derivatives)| SensitivityRow {
                address: system.catalogue().info(slot).address.to_string(),
                value: parameters.get(slot),
                unit: model.units.name(system.catalogue().info(slot).dimension),
                derivatives,
            });
        // Parameters that `by` names are listed even if all their derivatives are zero. Without names, only parameters with an effect are
        // listed.
        let all = !by.is_empty();
        let by = named.filter(|row| all || row.derivatives.iter().any(|d| *d != 0.0));
        Ok(Self {
            by: by.collect(),
            units: columns.iter().map(|c| c.unit.clone()).collect(),
            of: columns.into_iter().map(|column| column.head).collect(),
        })
    }
}

/// Result that is a column of the table.
struct Column {
    head: String,
    unit: String,
    quantity: Quantity,
}

/// Returns the quantities that a word of `of` names.
fn quantities(
    text: &str,
    (dataset, model, system): (&Dataset, &Model, &System),
) -> Result<Vec<Column>, Diagnostic> {
    const MOTION: [&str; 6] = ["x", "y", "z", "about x", "about y", "about z"];
    const WRENCH: [&str; 6] = admire_syntax::FORCE_COMPONENTS;
    const MOVED: [Dimension; 2] = [Dimension::LENGTH, Dimension::ANGLE];
    const ACTS: [Dimension; 2] = [Dimension::FORCE, Dimension::TORQUE];
    let address = super::value::address(text, dataset)?;
    let id = address.id.unwrap_or_default();
    let kind = address.kind.as_str();
    let six = |names: [&str; 6], kinds: [Dimension; 2], make: &dyn Fn(usize) -> Quantity| {
        (0..6)
            .map(|k| Column {
                head: format!("{text} {}", names[k]),
                unit: model.units.name(kinds[k / 3]),
                quantity: make(k),
            })
            .collect()
    };
    if matches!(kind, "PART" | "POINT_MASS") {
        let part = model.parts.iter().position(|p| p.header.id == id);
        if let Some(part) = part {
            return Ok(six(MOTION, MOVED, &|k| Quantity::Motion(PartIx(part), k)));
        }
    }
    if let Some(element) = system.element(kind, id) {
        return Ok(six(WRENCH, ACTS, &|k| Quantity::Element(element, k)));
    }
    if let Some(constraint) = system.constraint(kind, id) {
        return Ok(six(WRENCH, ACTS, &|k| Quantity::Constraint(constraint, k)));
    }
    let component = address
        .argument
        .as_deref()
        .and_then(|a| a.strip_prefix('F'))
        .and_then(|n| n.parse::<usize>().ok())
        .filter(|n| (1..=8).contains(n));
    let request = model.requests.iter().position(|r| r.header.id == id);
    if let ("REQUEST", Some(component), Some(index)) = (kind, component, request) {
        return Ok(vec![Column {
            head: text.to_string(),
            unit: String::new(),
            quantity: Quantity::Request(index, component - 1),
        }]);
    }
    let message = format!("`{text}` is not a part, force, joint or request component");
    let help = "name a result such as PART/4, BUSHING/1, JOINT/3 or REQUEST/1.F2";
    Err(Diagnostic::error(Code::WrongType, message).help(help))
}

/// Returns the parameters whose addresses begin with one of the words. Without words, returns all parameters except literals in functions
/// and the parameters of REQUEST and SENSOR.
fn slots(
    words: &[String],
    (dataset, system): (&Dataset, &System),
) -> Result<Vec<Slot>, Diagnostic> {
    let catalogue = system.catalogue();
    // Angles defined by points (ZP, XP) instead of REULER are not parameters that could be changed.
    let by_points = |address: &Address| {
        let marker = dataset.find(address).filter(|_| address.kind == "MARKER");
        address.argument.as_deref() == Some("REULER")
            && marker.is_some_and(|marker| marker.has("ZP") || marker.has("XP"))
    };
    let all: Vec<(Slot, String)> = catalogue
        .slots()
        .map(|slot| (slot, catalogue.info(slot).address))
        .filter(|(_, address)| !by_points(address))
        .map(|(slot, address)| (slot, address.to_string()))
        .collect();
    if words.is_empty() {
        let readings = ["REQUEST", "SENSOR"];
        let literal = |slot: Slot| {
            let address = catalogue.info(slot).address;
            let function = address.argument.as_deref().is_some_and(|a| a == "FUNCTION");
            readings.contains(&address.kind.as_str()) || (function && address.index.is_some())
        };
        return Ok(all
            .into_iter()
            .map(|a| a.0)
            .filter(|s| !literal(*s))
            .collect());
    }
    let mut out = Vec::new();
    for word in words {
        let wanted = super::value::address(word, dataset)?.to_string();
        let before = out.len();
        for (slot, address) in &all {
            let rest = address.strip_prefix(&wanted);
            if rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.')) {
                out.push(*slot);
            }
        }
        if out.len() == before {
            let message = format!("`{word}` is not a parameter of the equilibrium");
            return Err(Diagnostic::error(Code::UndefinedId, message));
        }
    }
    Ok(out)
}
