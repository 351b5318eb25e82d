use std::collections::BTreeSet;
use std::path::PathBuf;

use clap_complete::ArgValueCompleter;

use crate::front::{Before, removal};
use admire_syntax::diagnostic::Checked;
use admire_syntax::{Address, Dataset};

use super::Outcome;
use super::addresses::complete;
use super::edited::{edited, refuse_faults};
use super::get::parse;
use super::shell::{Exit, Shell};
use super::target::Target;

/// Remove statements from a dataset, with the comments that name them, or arguments from statements.
///
/// Nothing else in the deck changes. Without -o or --in-place, the new deck goes to standard output.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// Addresses, such as `JOINT/3`, `front_arm_bushing`, `BUSHING/12.PRELOAD`.
    #[arg(required = true, value_name = "ADDRESS", add = ArgValueCompleter::new(complete))]
    addresses: Vec<String>,
    /// Also remove everything that cannot exist without the removed objects: markers on a part, joints and forces on markers, motions of
    /// joints. A body only loses the argument that names a removed object.
    #[arg(long)]
    cascade: bool,
    /// Write the deck even if it has new faults, such as references to removed objects.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    target: Target,
}

const EXAMPLES: &str = "Examples:
  admire remove deck.adm BUSHING/12.PRELOAD -o new.adm
  admire remove deck.adm 'REQUEST/*' --in-place
  admire remove deck.adm PART/7 --cascade -o without.adm";

/// Removes the statements and arguments, and writes the deck.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = arguments.target.read(&arguments.deck, shell)?;
    let original = Dataset::parse(source);
    let mut deck = original.clone();
    let mut whole = BTreeSet::new();
    for text in &arguments.addresses {
        // Addresses refer to the original deck, even after other statements have been removed.
        let addresses = if Address::is_pattern(text) {
            Address::matching(text, &original.value).map_err(|mut refused| {
                refused.labels.clear();
                shell.fail(refused)
            })?
        } else {
            vec![parse(text, &original.value, shell)?]
        };
        for address in addresses {
            if arguments.cascade && address.argument.is_none() {
                whole.extend(original.value.position(&address.kind, address.id));
                continue;
            }
            let edits = removal(&deck.value, &address, text);
            let edits = edits.map_err(|refused| shell.fail(refused))?;
            deck = edited(&deck.value, &edits, shell)?;
            shell.sources.add(deck.value.source().clone());
        }
    }
    if !whole.is_empty() {
        deck = cascaded(&original.value, &deck.value, whole, shell)?;
    }
    refuse_faults(&Before::of(&original), &deck, arguments.force, shell)?;
    arguments
        .target
        .deliver(&arguments.deck, deck.value.bytes(), shell)?;
    Ok(Exit::Fine)
}

/// Removes statements of the original deck together with all statements that depend on them, and reports the dependent statements.
fn cascaded(
    original: &Dataset,
    deck: &Dataset,
    places: BTreeSet<usize>,
    shell: &mut Shell,
) -> Result<Checked<Dataset>, Exit> {
    let named: Vec<Address> = places
        .iter()
        .filter_map(|at| Address::of(&original.statements()[*at]))
        .collect();
    let here = named
        .iter()
        .filter_map(|address| deck.position(&address.kind, address.id))
        .collect();
    let removal = deck.dependents(here);
    let mut with_it: Vec<String> = removal
        .statements
        .iter()
        .filter_map(|at| Address::of(&deck.statements()[*at]))
        .filter(|address| !named.contains(address))
        .map(|address| address.to_string())
        .collect();
    with_it.extend(removal.arguments.iter().filter_map(|(at, k)| {
        let statement = &deck.statements()[*at];
        let object = Address::of(statement)?;
        Some(format!("{object}.{}", statement.arguments[*k].kind()?))
    }));
    if !with_it.is_empty() {
        shell.say(&format!("also removed: {}\n", with_it.join(", ")));
    }
    let changed = edited(deck, &deck.removal_edits(&removal), shell)?;
    shell.sources.add(changed.value.source().clone());
    Ok(changed)
}
