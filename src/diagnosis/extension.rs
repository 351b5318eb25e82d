//! Extended model as files: the user's deck with edits, and a command file that replays the measured loads.

use std::fmt::Write as _;

use super::deck_only::DeckOnlyPrediction;
use super::diagnose::Outcome;
use super::diagnosis_problem::DiagnosisProblem;
use super::fit::FittedModel;
use admire_identify::global::UnknownTarget;
use admire_solver::mechanics::Vec3;
use admire_solver::model::{MarkerIx, Model};
use admire_solver::system::{Parameters, Slot};
use admire_syntax::text::Edit;
use admire_syntax::{Address, Dataset};

impl Outcome<'_> {
    /// Returns the text of the deck with the found causes and the fitted stiffnesses. Random effects are not written into it.
    pub fn extended_deck(&self) -> Vec<u8> {
        deck(
            &self.extended,
            &self.plain,
            &driven(&self.subject, &self.extended),
        )
    }

    /// Returns an ADAMS command file that replays the load cases in order on the extended deck.
    pub fn extended_commands(&self) -> String {
        let programme = &self.subject.problem.programme;
        let fitted = &self.extended;
        let catalogue = fitted.deck.prepared.system.catalogue();
        let mut targets: Vec<(Address, Slot)> = Vec::new();
        let loads = programme.loads.iter().map(|load| load.target.clone());
        let others = per_case(fitted)
            .into_iter()
            .map(|slot| catalogue.info(slot).address);
        for address in loads.chain(others) {
            let Some(slot) = catalogue.slot(&address) else {
                continue;
            };
            // A redefinition command replaces the whole list of values.
            let same_list = |(known, at): &(Address, Slot)| {
                let whole = |address: &Address| Address {
                    index: None,
                    ..address.clone()
                };
                *at == slot || (known.index.is_some() && whole(known) == whole(&address))
            };
            if !targets.iter().any(same_list) {
                targets.push((address, slot));
            }
        }
        let mut text = String::from("extended.adm\nextended\n");
        text.push_str("EQUILIBRIUM/ERROR=1.0E-09, IMBALANCE=1.0E-05, MAXIT=100\n");
        if !fitted.effects.is_empty() {
            let names: Vec<String> = fitted
                .effects
                .iter()
                .map(|h| format!("{} at {}", h.cause, h.address))
                .collect();
            let _ = writeln!(text, "! {}", names.join(", "));
        }
        if fitted.effects.iter().any(|h| h.memory.is_some()) {
            text.push_str(
                "! Friction and creep depend on the load history: the rest positions of their springs apply only to this sequence of loads.\n",
            );
        }
        for (case, load) in programme.cases.iter().enumerate() {
            let _ = writeln!(text, "! case {}", load.label);
            for (address, slot) in &targets {
                let value = self.plain.thetas[case].get(*slot);
                if let Some(command) = redefine(address, value, |other| {
                    catalogue
                        .slot(other)
                        .map(|slot| self.plain.thetas[case].get(slot))
                }) {
                    text.push_str(&command);
                }
            }
            text.push_str("SIMULATE/STATICS\n");
        }
        text.push_str("STOP\n");
        text
    }
}

/// Returns the slots of the deck parameters that change from case to case, loads first.
pub(super) fn driven(subject: &DiagnosisProblem<'_>, fitted: &FittedModel) -> Vec<Slot> {
    let catalogue = fitted.deck.prepared.system.catalogue();
    let loads = &subject.problem.programme.loads;
    let mut slots: Vec<Slot> = loads
        .iter()
        .filter_map(|load| catalogue.slot(&load.target))
        .collect();
    for slot in per_case(fitted) {
        if !slots.contains(&slot) {
            slots.push(slot);
        }
    }
    slots
}

/// Returns the slots of deck parameters, other than loads, that change from case to case in a fit.
fn per_case(fitted: &FittedModel) -> Vec<Slot> {
    let mut out: Vec<Slot> = fitted.memories.iter().map(|memory| memory.anchor).collect();
    for (k, unknown) in fitted.unknowns.list().iter().enumerate() {
        if let (UnknownTarget::PerCase(slots), true) = (&unknown.target, fitted.is_of_the_model(k))
        {
            out.extend(slots.iter().map(|(slot, _)| *slot));
        }
    }
    out
}

/// Returns the command that sets the parameter at an address to `value`. The command redefines the whole FUNCTION, or an argument with all
/// its components; `of` returns their values.
fn redefine(address: &Address, value: f64, of: impl Fn(&Address) -> Option<f64>) -> Option<String> {
    let id = address.id?;
    let kind = &address.kind;
    let Some(argument) = &address.argument else {
        return Some(format!("{kind}/{id}, FUNCTION={value:.10E}\n"));
    };
    let Some(_) = address.index else {
        return Some(format!("{kind}/{id}, {argument}={value:.10E}\n"));
    };
    // The parameter is a literal number inside a function. The value replaces the whole function, which contains no other number.
    if matches!(kind.as_str(), "GFORCE" | "SFORCE" | "VARIABLE") {
        return Some(format!("{kind}/{id}, {argument}={value:.10E}\n"));
    }
    let values: Vec<String> = (1..=3)
        .map_while(|index| {
            let other = Address {
                index: Some(index),
                ..address.clone()
            };
            of(&other).map(|value| format!("{value:.10E}"))
        })
        .collect();
    Some(format!("{kind}/{id}, {argument}={}\n", values.join(",")))
}

/// Writes the fitted parameters into the extended deck. Parameters that change from case to case keep their deck values.
fn deck(fitted: &FittedModel, plain: &DeckOnlyPrediction, driven: &[Slot]) -> Vec<u8> {
    let system = &fitted.deck.prepared.system;
    let catalogue = system.catalogue();
    let (before, after) = (system.parameters(), &plain.thetas[0]);
    let mut dataset: Dataset = fitted.deck.dataset.clone();
    for slot in catalogue.slots() {
        let (old, new) = (before.get(slot), after.get(slot));
        if driven.contains(&slot) || old.to_bits() == new.to_bits() || !new.is_finite() {
            continue;
        }
        let address = catalogue.info(slot).address;
        let edits = dataset.set(&address, new).or_else(|refused| {
            // The sign of a number inside a function is an operator, so a negative number is written in parentheses.
            let number = dataset.number_at(&address).filter(|_| new < 0.0);
            let number = number.ok_or(refused)?;
            let text = format!("({})", admire_syntax::spell_like(new, b"1.0"));
            Ok::<_, admire_syntax::diagnostic::Diagnostic>(vec![Edit::new(number.span, text)])
        });
        if let Some(edited) = edits.ok().and_then(|edits| dataset.edited(&edits).ok()) {
            dataset = edited.value;
        }
    }
    turn_points(&mut dataset, &fitted.deck.prepared.model, (&before, after));
    dataset.bytes().to_vec()
}

/// Rotates the points ZP and XP about QP, for markers whose axes an effect rotates. A marker with only one of the two points gets the other
/// point as well.
fn turn_points(dataset: &mut Dataset, model: &Model, (before, after): (&Parameters, &Parameters)) {
    for (k, marker) in model.markers.iter().enumerate() {
        let (Some(old), Some(new)) = [before, after]
            .map(|all| all.axes_by_points(MarkerIx(k)))
            .into()
        else {
            continue;
        };
        if old == new {
            continue;
        }
        let address = |name: &str| Address {
            kind: "MARKER".to_string(),
            id: Some(marker.header.id),
            argument: Some(name.to_string()),
            index: None,
        };
        let place = |name: &str| {
            let component = |k| {
                dataset.number_at(&Address {
                    index: Some(k),
                    ..address(name)
                })
            };
            Some(Vec3::new(
                component(1)?.value,
                component(2)?.value,
                component(3)?.value,
            ))
        };
        let origin = place("QP").unwrap_or_default();
        let points = ["ZP", "XP"].map(place);
        let arms = points.map(|point| point.map(|point| point - origin));
        let length = arms.iter().flatten().map(Vec3::norm).fold(0.0, f64::max);
        let own = [Vec3::z(), Vec3::x()];
        let mut edits = Vec::new();
        for (name, (arm, own)) in ["ZP", "XP"].into_iter().zip(arms.into_iter().zip(own)) {
            let arm = arm.map_or(new * own * length, |arm| new * old.transpose() * arm);
            let texts = (origin + arm).map(|x| admire_syntax::spell_like(x, b"1.0"));
            let text = texts.as_slice().join(", ");
            edits.extend(dataset.set_text(&address(name), &text).unwrap_or_default());
        }
        if let Ok(edited) = dataset.edited(&edits) {
            *dataset = edited.value;
        }
    }
}
