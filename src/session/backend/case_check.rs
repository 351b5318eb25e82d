//! Check that the output steps of a results file belong to the load cases in their order, by means of the loads that the file reports.

use super::{LoadProgramme, SweepRequest};
use admire_results::Catalogue;
use admire_solver::mechanics::Vec3;
use admire_solver::model::{Model, SforceKind};
use admire_syntax::Address;

/// Relative tolerance between the load of a load case and the load in the file.
const AGREES: f64 = 1e-6;

/// Checks that each output step of a results file belongs to the load case assigned to it. The steps are checked in order.
pub(super) struct CaseCheck<'a> {
    programme: &'a LoadProgramme,
    loads: Vec<Stated>,
    /// Load case and values (without the time) of each step checked so far.
    before: Vec<(usize, Vec<f64>)>,
}

/// Columns in which a results file reports a load.
struct Stated {
    /// Column of the load in the load programme.
    column: usize,
    /// Column ids of the components of the force, or of the torque if the load is rotational.
    vector: [usize; 3],
    /// Load case and load vector of the first step in which the load is not zero.
    first: Option<(usize, Vec3)>,
}

impl<'a> CaseCheck<'a> {
    /// Prepares the check for all loads that the file reports as single-component forces or torques.
    pub(crate) fn new(request: &SweepRequest<'a>, catalogue: &Catalogue) -> Self {
        let programme = request.programme;
        let stated = |(column, load): (usize, &super::Load)| {
            let names = vector(request.model, &load.target)?;
            let id = i64::from(load.target.id?);
            let entity = catalogue.entity_of("Single_Component_Force", id)?;
            let mut columns = [0; 3];
            for (place, name) in columns.iter_mut().zip(names) {
                *place = entity.component(name)?.id;
            }
            Some(Stated {
                column,
                vector: columns,
                first: None,
            })
        };
        Self {
            programme,
            loads: programme
                .loads
                .iter()
                .enumerate()
                .filter_map(stated)
                .collect(),
            before: Vec::new(),
        }
    }

    /// Checks one output step, which is assigned to load case `case`.
    ///
    /// # Errors
    /// Returns an error if the step belongs to another load case, repeats another step, or has a load of the wrong sign. The error names
    /// the cases.
    pub(crate) fn step(&mut self, case: usize, values: &[f64]) -> Result<(), String> {
        let cases = &self.programme.cases;
        let label = |case: usize| &cases[case].label;
        for load in &mut self.loads {
            let at = |case: usize| cases[case].values[load.column];
            let found = Vec3::from_iterator(load.vector.iter().map(|column| values[column - 1]));
            let near =
                |value: f64| (found.norm() - value.abs()).abs() <= AGREES * (1.0 + value.abs());
            let name = &self.programme.loads[load.column].name;
            if !near(at(case)) {
                if let Some(other) = (0..cases.len()).find(|other| near(at(*other))) {
                    return Err(format!(
                        "the step of load case `{}` holds the load `{name}` of case `{}`: cases are swapped or repeated",
                        label(case),
                        label(other)
                    ));
                }
                // The program may report forces in axes and units of its choice. A value that fits no load case is therefore no evidence of
                // a mistake.
                continue;
            }
            if at(case) == 0.0 {
                continue;
            }
            // The direction of the load vector is the same in all cases and reverses with the sign of the load.
            let (other, first) = *load.first.get_or_insert((case, found));
            let turned = found.dot(&first) < 0.0;
            if turned != (at(case) * at(other) < 0.0) {
                return Err(format!(
                    "the load `{name}` has the wrong sign in load case `{}` or `{}`: cases are swapped",
                    label(case),
                    label(other)
                ));
            }
        }
        let own = values.get(1..).unwrap_or_default();
        for (other, step) in &self.before {
            let mut loads = cases[case].values.iter().zip(&cases[*other].values);
            let same_loads = loads.all(|(a, b)| (a - b).abs() <= AGREES * (a.abs() + b.abs()));
            if !same_loads && step == own {
                return Err(format!(
                    "the steps of load cases `{}` and `{}` are the same, but their loads differ",
                    label(*other),
                    label(case)
                ));
            }
        }
        self.before.push((case, own.to_vec()));
        Ok(())
    }
}

/// Returns the names of the three columns in which a load is reported, if the load is the whole function of an SFORCE.
fn vector(model: &Model, target: &Address) -> Option<[&'static str; 3]> {
    let whole = target
        .argument
        .as_deref()
        .is_none_or(|name| name == "FUNCTION");
    if target.kind != "SFORCE" || !whole || target.index.is_some() {
        return None;
    }
    let force = model
        .sforces
        .iter()
        .find(|force| Some(force.header.id) == target.id)?;
    Some(if force.kind == SforceKind::Rotational {
        ["TX", "TY", "TZ"]
    } else {
        ["FX", "FY", "FZ"]
    })
}
