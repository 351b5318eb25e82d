use std::path::PathBuf;

use clap_complete::ArgValueCompleter;

use crate::front::kind_with_ids;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::renumber::{Renumbering, in_order, renumber};
use admire_syntax::text::{Edit, Source, apply_edits};
use admire_syntax::{CommandFile, Dataset};

use super::Outcome;
use super::addresses::complete;
use super::fix::diff;
use super::get::parse;
use super::output_folder::{Replacing, write_folder};
use super::shell::{Exit, Shell};

/// Give objects new ids, and update every reference in arguments, in functions and in commands.
///
/// Shows the change as a diff; with --in-place or --out, also applies it.
#[derive(clap::Args, Debug)]
#[command(after_help = "Examples:\n  admire renumber front.adm MARKER=1000 --out renumbered.adm")]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// `MARKER=1000` numbers all markers from 1000 on in their order, `MARKER=1000,10` in steps of ten. `MARKER/7=12`, or a view name in
    /// place of `MARKER/7`, gives one object its new id.
    #[arg(required = true, value_name = "KIND=FIRST[,STEP]", add = ArgValueCompleter::new(complete))]
    ids: Vec<String>,
    /// Command files (.acf) that belong to the dataset; their references are updated, too.
    #[arg(long, short, value_name = "FILE")]
    commands: Vec<PathBuf>,
    /// File for the deck. With command files, or if a folder of this name exists: folder for all files under their own names.
    #[arg(long, short, value_name = "FILE|FOLDER", conflicts_with = "in_place")]
    out: Option<PathBuf>,
    /// Replace the input files.
    #[arg(long)]
    in_place: bool,
    #[command(flatten)]
    replacing: Replacing,
}

/// Shows the change, or applies it if requested.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = shell.read_for(&arguments.deck, arguments.in_place)?;
    let dataset = Dataset::parse(source.clone()).value;
    let mut renumbering = Renumbering::new();
    for text in &arguments.ids {
        renumbering.extend(ids(text, &dataset, shell)?);
    }
    let mut commands = Vec::new();
    for path in &arguments.commands {
        commands.push(CommandFile::parse(shell.read_for(path, arguments.in_place)?).value);
    }
    let all: Vec<&CommandFile> = commands.iter().collect();
    let done = renumber(&dataset, &all, &renumbering).map_err(|refused| shell.fail(refused))?;
    shell.complain(&done.diagnostics);
    let mut changed = vec![(
        &arguments.deck,
        source.clone(),
        edited(&source, &done.value.dataset, shell)?,
    )];
    for ((path, file), edits) in arguments
        .commands
        .iter()
        .zip(&commands)
        .zip(&done.value.commands)
    {
        changed.push((
            path,
            file.source().clone(),
            edited(file.source(), edits, shell)?,
        ));
    }
    if arguments.out.is_none() && !arguments.in_place {
        for (_, source, bytes) in &changed {
            shell.print(&diff(source, bytes));
        }
        return Ok(Exit::Fine);
    }
    let several = changed.len() > 1;
    if let Some(out) = arguments.out.as_ref().filter(|out| several || out.is_dir()) {
        let named = changed
            .into_iter()
            .filter_map(|(path, _, bytes)| Some((PathBuf::from(path.file_name()?), bytes)));
        write_folder(out, &named.collect::<Vec<_>>(), arguments.replacing, shell)?;
        return Ok(Exit::Fine);
    }
    for (path, _, bytes) in &changed {
        shell.write(arguments.out.as_ref().unwrap_or(path), bytes)?;
    }
    Ok(Exit::Fine)
}

/// Parses one renumbering, such as `MARKER=1000,10`, from the command line.
fn ids(text: &str, dataset: &Dataset, shell: &Shell) -> Result<Renumbering, Exit> {
    let wrong = |message: String| {
        shell.usage(
            Diagnostic::error(Code::BadNumber, message)
                .help("write KIND=FIRST, KIND=FIRST,STEP or KIND/ID=NEW"),
        )
    };
    let Some((what, numbers)) = text.split_once('=') else {
        return Err(wrong(format!("`{text}` has no `=`")));
    };
    let (first, step) = numbers.split_once(',').unwrap_or((numbers, "1"));
    let number = |word: &str| {
        word.trim()
            .parse::<u32>()
            .ok()
            .filter(|number| *number > 0)
            .ok_or_else(|| wrong(format!("`{word}` is not a whole number above zero")))
    };
    let (first, step) = (number(first)?, number(step)?);
    let what = what.trim();
    if let Some(kind) = kind_with_ids(what) {
        let found = in_order(dataset, kind, first, step);
        let too_many = found.len() as u64 * u64::from(step) + u64::from(first);
        if too_many > u64::from(u32::MAX) {
            return Err(wrong(format!(
                "`{text}`: the last id would exceed {}",
                u32::MAX
            )));
        }
        return Ok(found);
    }
    let address = parse(what, dataset, shell)?;
    let statement = dataset.find(&address);
    let space = statement.and_then(|statement| statement.def?.id);
    match (space, address.id, &address.argument) {
        (Some(space), Some(id), None) => Ok(Renumbering::from([((space, id), first)])),
        _ => Err(wrong(format!(
            "`{what}` is neither a kind of statement nor an object with an id"
        ))),
    }
}

fn edited(source: &Source, edits: &[Edit], shell: &Shell) -> Result<Vec<u8>, Exit> {
    apply_edits(source.bytes(), edits)
        .map_err(|conflict| shell.fail(Diagnostic::error(Code::CannotWrite, conflict.to_string())))
}
