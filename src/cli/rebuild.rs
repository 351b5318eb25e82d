use std::path::{Path, PathBuf};

use admire_rebuild::rebuild as rebuild_deck;
use admire_syntax::diagnostic::Severity;

use super::Outcome;
use super::counted::counted;
use super::output_folder::{Replacing, folder_beside, output_folder, write_folder};
use super::shell::{Exit, Shell};

/// Make a deck and a study from results files that contain poses and forces.
///
/// Parts, joints, hardpoints, bushings, springs and masses are found in the static equilibria of the results. All files must be tests of the same
/// mechanism; more varied tests determine more of it. `rebuild.md` states what was found and what the results do not determine. The folder is a
/// study: every state is a load case, and the poses are its readings.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// Results files (.res) of one mechanism.
    #[arg(required = true)]
    results: Vec<PathBuf>,
    /// Folder to write; by default, `out-rebuild` beside the first file.
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Results of other tests. They are not used for the deck; the report states how well the deck predicts them.
    #[arg(long, value_name = "FILE")]
    test: Vec<PathBuf>,
    #[command(flatten)]
    replacing: Replacing,
}

const EXAMPLES: &str = "Examples:
  admire rebuild lateral.res --out axle
  admire rebuild lateral.res roll.res parallel.res --out axle
  admire rebuild lateral.res --test roll.res --out axle   # how well lateral.res predicts roll.res
  admire check axle                                       # the folder is a study";

/// Rebuilds the deck and writes the study folder.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let paths: Vec<&Path> = arguments.results.iter().map(PathBuf::as_path).collect();
    let tests: Vec<&Path> = arguments.test.iter().map(PathBuf::as_path).collect();
    let out = output_folder(
        arguments.out.as_deref(),
        &folder_beside(paths[0]),
        "rebuild",
    );
    let answer = rebuild_deck(&paths, &tests);
    shell.complain(&answer.diagnostics);
    let Some(rebuilt) = answer.value else {
        return Err(Exit::Findings);
    };
    let files: Vec<(PathBuf, Vec<u8>)> = rebuilt
        .files
        .iter()
        .map(|(name, text)| (PathBuf::from(name), text.clone().into_bytes()))
        .collect();
    write_folder(&out, &files, arguments.replacing, shell)?;
    let length = rebuilt.record.units.length.word;
    let mut text = String::new();
    for run in &rebuilt.record.runs {
        let largest = rebuilt.repeat.largest(run.states.clone());
        text += &match largest {
            Some(place) => format!(
                "{}: {}; largest position error of the parts {place:.1e} {length}\n",
                run.name,
                counted(run.states.len(), "state")
            ),
            None => format!(
                "{}: {}; the deck has no equilibrium in at least one of them\n",
                run.name,
                counted(run.states.len(), "state")
            ),
        };
    }
    let folder = out.display();
    text += &format!("deck, study and rebuild.md: {folder}\n");
    shell.print(&text);
    let solved = rebuilt.repeat.largest(0..rebuilt.record.states()).is_some();
    let warned = answer
        .diagnostics
        .iter()
        .any(|d| d.severity == Severity::Error);
    Ok(match (solved, warned) {
        (false, _) => Exit::NoAnswer,
        (true, true) => Exit::Findings,
        (true, false) => Exit::Fine,
    })
}
