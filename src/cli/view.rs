use std::io::Read;
use std::path::{Path, PathBuf};

use admire_report::scene::{bodies, motion};
use admire_report::{Page, Scene};
use admire_results::{ResultsReader, Timestamp};
use admire_solver::model::Model;
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::text::open_to_read;

use super::Outcome;
use super::counted::counted;
use super::opening::Opening;
use super::results_file::{open, refused};
use super::shell::{Exit, Shell, exit_of};

/// Write a page that shows a mechanism in three dimensions, moving through the steps of a results file.
///
/// Parts are drawn through the markers of their joints and forces, and with the shapes of GRAPHICS statements that need no other file. The
/// page is one file, needs no network, and can enlarge displacements up to a thousand times. For a results file alone, the bodies are shown
/// as axes.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire view model.adm\n  admire view model.adm run.res --out view.html\n  \
                        admire view model.adm run.res --highlight BUSHING/2 --highlight JOINT/5"
)]
pub(super) struct Arguments {
    /// Dataset; or results file, if there is no dataset.
    deck: PathBuf,
    /// Results to move through: XRF (.res) or formatted results.
    run: Option<PathBuf>,
    /// Page to write. Without it, the page has the name of the deck with `.html`, and must not exist yet.
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    opening: Opening,
    /// Object to highlight, such as `BUSHING/2` or `PART/4`.
    #[arg(long, value_name = "ADDRESS")]
    highlight: Vec<String>,
}

/// Writes the page.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let target = target(arguments, shell)?;
    let alone = is_results(&arguments.deck);
    let mut exit = Exit::Fine;
    let mut scene = if alone {
        if arguments.run.is_some() {
            let message = format!(
                "`{}` is a results file, not a deck",
                arguments.deck.display()
            );
            return Err(shell.usage(
                Diagnostic::error(Code::UnsupportedResults, message)
                    .help("name the deck first, and its results second"),
            ));
        }
        let mut reader = open(&arguments.deck, shell)?;
        let mut scene = bodies(&name(&arguments.deck), reader.as_ref());
        moved(&mut scene, reader.as_mut(), shell)?;
        scene.notes.push(
            "Without its deck, a results file contains only the positions of the body frames."
                .to_string(),
        );
        scene
    } else {
        let parsed = Dataset::parse(shell.read(&arguments.deck)?);
        let files = shell.read_files(&parsed.value);
        let lowered = Model::lower_with(&parsed.value, &files.value);
        let mut complaints = parsed.diagnostics;
        complaints.extend(lowered.diagnostics);
        // A deck with errors is shown as far as its model can be built.
        exit = exit_of(&complaints);
        complaints.retain(|d| d.severity == Severity::Error);
        shell.complain(&complaints);
        let mut scene = Scene::of(&lowered.value, Some(&parsed.value));
        if let Some(run) = &arguments.run {
            let mut reader = open(run, shell)?;
            moved(&mut scene, reader.as_mut(), shell)?;
        }
        scene
    };
    if scene.title.is_empty() {
        scene.title = name(&arguments.deck);
    }
    for address in &arguments.highlight {
        if !scene.highlight(address, address) {
            let message = format!("the view contains no part, joint or force `{address}`");
            return Err(shell.fail(Diagnostic::error(Code::UndefinedId, message)));
        }
    }
    let html = Page::of_scene(&scene, &lead(&scene), &footer(arguments));
    shell.write(&target, html.as_bytes())?;
    shell.print(&format!("view: {}\n", target.display()));
    arguments.opening.open(&target, shell);
    Ok(exit)
}

/// Returns true if a file is a results file. Only its first bytes are read, because results may be too large to read whole.
fn is_results(path: &Path) -> bool {
    let mut head = Vec::new();
    let read = open_to_read(path).and_then(|file| file.take(64).read_to_end(&mut head));
    let begins = head.trim_ascii_start();
    read.is_ok() && (begins.starts_with(b"<?xml") || begins.starts_with(b"FILE TYPE AND SOURCE"))
}

/// Returns the path of the page. An existing file is replaced only if the user names it with --out.
fn target(arguments: &Arguments, shell: &Shell) -> Result<PathBuf, Exit> {
    if let Some(out) = &arguments.out {
        return Ok(out.clone());
    }
    if arguments.deck == Path::new("-") {
        let message = "the page has no name, because the deck comes from standard input";
        return Err(shell.usage(
            Diagnostic::error(Code::CannotWrite, message).help("name the page: --out view.html"),
        ));
    }
    let target = PathBuf::from(name(&arguments.deck)).with_extension("html");
    if target.exists() {
        let message = format!("`{}` already exists", target.display());
        let help = format!("--out {} replaces the file", target.display());
        return Err(shell.fail(Diagnostic::error(Code::CannotWrite, message).help(help)));
    }
    Ok(target)
}

fn name(path: &Path) -> String {
    path.file_name().map_or_else(
        || "deck".to_string(),
        |name| name.to_string_lossy().into_owned(),
    )
}

/// Adds the steps of a results file to the scene, as motion of its parts.
fn moved(scene: &mut Scene, reader: &mut dyn ResultsReader, shell: &Shell) -> Result<(), Exit> {
    let found = motion(scene, reader).map_err(|error| refused(error, shell))?;
    shell.complain(reader.diagnostics());
    let bodies = scene.parts.iter().filter(|part| !part.ground).count();
    if bodies > 0 && found.missing.len() == bodies {
        let message = "the results contain no position of any part of the deck";
        return Err(shell.fail(Diagnostic::error(Code::UndefinedId, message)));
    }
    if !found.missing.is_empty() {
        scene.notes.push(format!(
            "Shown in the design position, because the results contain no position: {}.",
            found.missing.join(", ")
        ));
    }
    if found.others {
        scene
            .notes
            .push("The results contain parts that the deck does not have.".to_string());
    }
    if found.frames.len() < found.steps {
        scene.notes.push(format!(
            "Steps shown: {} of {}, evenly spaced.",
            found.frames.len(),
            found.steps
        ));
    }
    scene.frames = found.frames;
    Ok(())
}

fn lead(scene: &Scene) -> String {
    let parts = scene.parts.iter().filter(|part| !part.ground).count();
    let parts = counted(parts, "part");
    let mut text = format!("{parts}, {} joints and forces", scene.objects.len());
    if !scene.frames.is_empty() {
        text += &format!(", {}", counted(scene.frames.len(), "step"));
    }
    text + &format!("; lengths in {}", scene.length)
}

fn footer(arguments: &Arguments) -> String {
    let run = arguments
        .run
        .as_ref()
        .map_or_else(String::new, |run| format!(" with {}", run.display()));
    format!(
        "{}{run} · admire {} · {} UTC",
        arguments.deck.display(),
        admire_report::VERSION,
        Timestamp::now().date_time()
    )
}
