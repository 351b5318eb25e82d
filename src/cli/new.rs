use std::collections::BTreeSet;
use std::io::{BufRead, IsTerminal, Write};
use std::path::PathBuf;

use admire_solver::model::Model;
use admire_study::permission::trust_study;
use admire_study::{Kind, Starter};
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::text::Source;

use super::Outcome;
use super::output_folder::{Replacing, refuse_replacing, write_folder};
use super::shell::{Exit, Shell};

/// Begin a study of a deck: a commented study.toml, tables with the right headings, and a list of what to fill in.
///
/// Bushings, loads and a wheel are found in the deck, and the deck is copied into the study. On a terminal, two questions are asked; an
/// empty reply accepts the proposal. In a script, no question is asked.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// Folder of the study; it is created if missing.
    study: PathBuf,
    /// Deck that the study is about.
    #[arg(long, value_name = "DECK")]
    from: PathBuf,
    /// What was measured. By default, you are asked on a terminal; elsewhere, it is `marks`.
    #[arg(long, value_enum, value_delimiter = ',')]
    measured: Vec<Measured>,
    /// Bushings to identify, by id. By default, you are asked on a terminal; elsewhere, all are identified.
    #[arg(long, value_delimiter = ',', value_name = "ID")]
    bushings: Vec<String>,
    #[command(flatten)]
    replacing: Replacing,
}

const EXAMPLES: &str = "Examples:
  admire new my-axle --from front.adm
  admire new my-axle --from front.adm --measured marks,wheel --bushings 1,2
  admire new my-axle --from front.adm --measured curves      # from a K&C rig
  admire check my-axle                       # lists what is still missing";

/// Choice of the measured quantities on the command line.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, clap::ValueEnum)]
enum Measured {
    /// Marks (measured points) on parts, by a coordinate measuring machine or cameras.
    Marks,
    /// Position and angles of the wheel.
    Wheel,
    /// Toe, camber and other curves of a wheel, from a K&C rig.
    Curves,
    /// Readings of sensors: string pots, load cells, inclinometers.
    Readings,
}

impl From<Measured> for Kind {
    fn from(measured: Measured) -> Self {
        match measured {
            Measured::Marks => Self::Marks,
            Measured::Wheel => Self::Wheel,
            Measured::Curves => Self::Curves,
            Measured::Readings => Self::Readings,
        }
    }
}

/// Reads the deck, asks the questions and writes the study folder.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let parsed = Dataset::parse(shell.read(&arguments.from)?);
    let files = shell.read_files(&parsed.value);
    let lowered = Model::lower_with(&parsed.value, &files.value);
    let mut complaints = parsed.diagnostics;
    complaints.extend(files.diagnostics);
    complaints.extend(lowered.diagnostics);
    complaints.retain(|complaint| complaint.severity == Severity::Error);
    shell.complain(&complaints);
    if !complaints.is_empty() {
        return Err(Exit::Findings);
    }
    let named: Vec<&str> = files.value.sources().map(Source::name).collect();
    if !named.is_empty() {
        let message = format!(
            "the study also needs the files that the deck names: copy {} into the folder of the study",
            named.join(", ")
        );
        shell.complain(&[Diagnostic::note(Code::CannotRead, message)]);
    }
    let Some(deck) = arguments.from.file_name() else {
        let message = format!("`{}` is not a file", arguments.from.display());
        return Err(shell.usage(Diagnostic::error(Code::CannotRead, message)));
    };
    let deck = deck.to_string_lossy().into_owned();
    let starter = Starter::of(&lowered.value);
    for line in starter.found() {
        shell.say(&format!("{line}\n"));
    }
    let mut kinds: BTreeSet<Kind> = arguments
        .measured
        .iter()
        .map(|kind| (*kind).into())
        .collect();
    let all = starter.bushings();
    let wanted: Vec<&str> = arguments.bushings.iter().map(String::as_str).collect();
    let Some(mut bushings) = chosen(&wanted, &all) else {
        let is_missing = |word: &&&str| chosen(&[**word], &all).is_none();
        let missing: Vec<&str> = wanted.iter().filter(is_missing).copied().collect();
        let message = format!("the deck has no bushing {}", missing.join(", "));
        let help = match all.as_slice() {
            [] => "the deck has no bushings: leave out --bushings".to_string(),
            all => format!("its bushings are {}", all.join(", ")),
        };
        return Err(shell.usage(Diagnostic::error(Code::UndefinedId, message).help(help)));
    };
    if std::io::stdin().is_terminal() && std::io::stderr().is_terminal() {
        if kinds.is_empty() {
            kinds = ask_kinds(shell);
        }
        if bushings.is_empty() {
            bushings = ask_bushings(&all, shell);
        }
    }
    if kinds.is_empty() {
        kinds.insert(Kind::Marks);
    }
    let mut files: Vec<(PathBuf, Vec<u8>)> = starter
        .files(&deck, &kinds, &bushings)
        .into_iter()
        .map(|(name, text)| (PathBuf::from(name), text.into_bytes()))
        .collect();
    let here = arguments.study.join(&deck);
    let is_there = here
        .canonicalize()
        .ok()
        .is_some_and(|there| arguments.from.canonicalize().ok() == Some(there));
    if !is_there {
        files.push((PathBuf::from(&deck), parsed.value.bytes().to_vec()));
    }
    let names: Vec<&str> = files.iter().filter_map(|(name, _)| name.to_str()).collect();
    refuse_replacing(&arguments.study, &names, arguments.replacing, shell)?;
    write_folder(&arguments.study, &files, arguments.replacing, shell)?;
    if let Err(error) = trust_study(&arguments.study)
        && shell.is_verbose()
    {
        shell.say(&format!(
            "the permission to start programs of the study was not saved, so a later command will ask for it: {error}\n"
        ));
    }
    let study = arguments.study.display();
    let mut text = String::new();
    for (name, _) in &files {
        text += &format!("{}\n", arguments.study.join(name).display());
    }
    text += &format!(
        "next: check the settings in {}, and fill in the tables;\n`admire check {study}` lists what is still missing\n",
        arguments.study.join("study.toml").display()
    );
    shell.print(&text);
    Ok(Exit::Fine)
}

/// Asks a question on a line of its own and returns the reply, typed on the next line, in lower case. The reply is empty at the end of
/// input.
pub(super) fn answer(question: &str, shell: &Shell) -> String {
    shell.say(&format!("{}\n", question.trim_end()));
    let _ = std::io::stderr().flush();
    let mut line = String::new();
    // The end of input counts as an empty answer.
    let _ = std::io::stdin().lock().read_line(&mut line);
    line.trim().to_lowercase()
}

fn ask_kinds(shell: &Shell) -> BTreeSet<Kind> {
    loop {
        let line = answer(
            "what was measured (marks, wheel, curves, readings)? [marks]",
            shell,
        );
        let words: Vec<&str> = line
            .split([',', ' '])
            .filter(|word| !word.is_empty())
            .collect();
        let kinds: Option<BTreeSet<Kind>> = words
            .iter()
            .map(|word| match *word {
                "marks" | "m" => Some(Kind::Marks),
                "wheel" | "w" => Some(Kind::Wheel),
                "curves" | "c" => Some(Kind::Curves),
                "readings" | "r" => Some(Kind::Readings),
                _ => None,
            })
            .collect();
        match kinds {
            Some(kinds) => return kinds,
            None => shell.say("enter one or more of the words marks, wheel, curves, readings\n"),
        }
    }
}

fn ask_bushings(all: &[String], shell: &Shell) -> Vec<String> {
    if all.len() < 2 {
        return Vec::new();
    }
    loop {
        let line = answer(
            &format!("which bushings are identified ({})? [all]", all.join(", ")),
            shell,
        );
        let wanted: Vec<&str> = line
            .split([',', ' '])
            .filter(|word| !word.is_empty() && *word != "all")
            .collect();
        match chosen(&wanted, all) {
            Some(found) => return found,
            None => shell.say("enter the ids of bushings, separated by commas, such as 1, 2\n"),
        }
    }
}

/// Returns the bushings with these ids or addresses; `None` if any of them does not exist.
fn chosen(wanted: &[&str], all: &[String]) -> Option<Vec<String>> {
    let of = |word: &&str| {
        let id = word.trim().rsplit('/').next().unwrap_or(word);
        let same = |name: &&String| name.rsplit('/').next() == Some(id);
        all.iter().find(same).cloned()
    };
    wanted.iter().map(of).collect()
}
