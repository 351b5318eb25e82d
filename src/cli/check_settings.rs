//! Settings of `admire check`: the settings in `admire.toml`, overridden by the flags of the command line.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use admire_session::check::{Settings, Solver, code_named, table_above};
use admire_syntax::diagnostic::Code;

use super::shell::{Exit, Shell};

/// Solver for which a deck is intended.
#[derive(Clone, Copy, PartialEq, Eq, Debug, clap::ValueEnum)]
enum SolverChoice {
    /// ADAMS. Limits of the built-in solver are not reported, and neither are missing files that only graphics read.
    Adams,
    /// The built-in solver. Statements that it does not solve are reported; missing files that only graphics read are not.
    Admire,
}

impl From<SolverChoice> for Solver {
    fn from(choice: SolverChoice) -> Self {
        match choice {
            SolverChoice::Adams => Self::Adams,
            SolverChoice::Admire => Self::Admire,
        }
    }
}

/// Flags that select the complaints shown, and the complaints that make the check fail.
#[derive(clap::Args, Clone, Debug, Default)]
pub(super) struct Flags {
    /// Solver for which the decks are intended. Without it, all messages are shown.
    #[arg(long = "for", value_enum, value_name = "SOLVER")]
    solver: Option<SolverChoice>,
    /// Show only messages with these codes: `--select undefined-id,tab`.
    #[arg(long, value_delimiter = ',', value_name = "CODE")]
    select: Vec<String>,
    /// Hide messages with these codes.
    #[arg(long, value_delimiter = ',', value_name = "CODE")]
    ignore: Vec<String>,
    /// Exit with code 1 for warnings, too.
    #[arg(long)]
    strict: bool,
    /// Also report lines that the FORTRAN solver of ADAMS would cut off.
    #[arg(long)]
    fortran: bool,
    /// Settings file to read instead of the `admire.toml` in the folder of a file or above it.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

/// Cache of the settings of all folders visited so far.
pub(super) struct AllSettings<'a> {
    flags: &'a Flags,
    known: BTreeMap<PathBuf, Settings>,
}

impl<'a> AllSettings<'a> {
    pub(super) fn new(flags: &'a Flags) -> Self {
        Self {
            flags,
            known: BTreeMap::new(),
        }
    }

    /// Returns the settings for a file: the settings in the nearest `admire.toml` above it, overridden by the flags.
    pub(super) fn of(&mut self, file: &Path, shell: &mut Shell) -> Result<Settings, Exit> {
        let table = match &self.flags.config {
            Some(path) => Some(path.clone()),
            None => table_above(file),
        };
        let key = table.clone().unwrap_or_default();
        if let Some(known) = self.known.get(&key) {
            return Ok(known.clone());
        }
        let mut settings = match table {
            Some(path) => Settings::parse(&shell.read(&path)?).map_err(|wrong| {
                shell.complain(&wrong);
                Exit::Findings
            })?,
            None => Settings::default(),
        };
        let flags = self.flags;
        let codes = |words: &[String]| -> Result<Vec<Code>, Exit> {
            words
                .iter()
                .map(|word| code_named(word).map_err(|refused| shell.usage(refused)))
                .collect()
        };
        let (select, ignore) = (codes(&flags.select)?, codes(&flags.ignore)?);
        if !select.is_empty() {
            settings.ignore.retain(|code| !select.contains(code));
            settings.select = select;
        }
        settings.ignore.extend(ignore);
        settings.solver = flags.solver.map(Solver::from).or(settings.solver);
        settings.quiet |= shell.is_quiet();
        settings.strict |= flags.strict;
        settings.fortran |= flags.fortran;
        self.known.insert(key, settings.clone());
        Ok(settings)
    }
}
