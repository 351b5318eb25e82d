use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use admire_report::VERSION;
use admire_session::own_program;
use admire_study::Study;
use admire_study::settings::BackendChoice;

use admire_study::{permission::NamedProgram, solver::found_on_path};

use super::Outcome;
use super::permission::Permission;
use super::shell::{Exit, Shell};

/// Check the installation: which `mdi` a script would find, whether a study's program starts, Octave, and write permissions.
///
/// Nothing is solved and no licence is taken. Programs are started only to read the first line that they print.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire doctor\n  admire doctor my-axle            # the program of its study.toml, too"
)]
pub(super) struct Arguments {
    /// Folder of a study whose external program is started, too.
    study: Option<PathBuf>,
    #[command(flatten)]
    permission: Permission,
}

/// Time after which a program without output counts as unresponsive.
const PATIENCE: Duration = Duration::from_secs(10);

/// Prints the findings; the exit code is 1 if something is broken.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let mut report = Report::default();
    programs(&mut report);
    if let Some(folder) = &arguments.study {
        of_study(folder, arguments.permission, &mut report, shell)?;
    }
    let octave = ["octave-cli", "octave"].into_iter().find_map(found_on_path);
    match octave {
        Some(path) => {
            let words = first_words(&path, &["--version"]);
            report.fine(
                "Octave",
                &words.unwrap_or_else(|| {
                    format!("{}, which does not report its version", path.display())
                }),
            );
        }
        None => report.look(
            "Octave",
            "not on the PATH; needed only to run MATLAB scripts without MATLAB",
        ),
    }
    for (what, folder) in [
        (
            "working directory",
            std::env::current_dir().unwrap_or_default(),
        ),
        ("temporary files", std::env::temp_dir()),
    ] {
        match tempfile::NamedTempFile::new_in(&folder) {
            Ok(_) => report.fine(what, &format!("{}, writable", folder.display())),
            Err(error) => report.broken(
                what,
                &format!("{} is not writable: {error}", folder.display()),
            ),
        }
    }
    shell.tell(&report.text);
    if report.is_broken {
        return Err(Exit::Findings);
    }
    Ok(Exit::Fine)
}

#[derive(Default)]
struct Report {
    text: String,
    is_broken: bool,
}

impl Report {
    fn fine(&mut self, what: &str, found: &str) {
        self.line("ok", what, found);
    }

    fn look(&mut self, what: &str, found: &str) {
        self.line("warn", what, found);
    }

    fn broken(&mut self, what: &str, found: &str) {
        self.is_broken = true;
        self.line("fail", what, found);
    }

    fn line(&mut self, word: &str, what: &str, found: &str) {
        self.text += &format!("{word:4}  {what:18}  {found}\n");
    }
}

/// Reports this program, the solver beside it in its folder, and the solver that a script would find.
fn programs(report: &mut Report) {
    let own = own_program().and_then(dunce::canonicalize);
    let shown = own
        .as_ref()
        .map_or_else(ToString::to_string, |path| path.display().to_string());
    report.fine("admire", &format!("{VERSION}, {shown}"));
    let beside = own
        .ok()
        .map(|path| path.with_file_name(format!("mdi{}", std::env::consts::EXE_SUFFIX)))
        .filter(|path| path.is_file());
    match &beside {
        Some(path) => report.fine("mdi of admire", &path.display().to_string()),
        None => report.broken(
            "mdi of admire",
            "not in the folder of admire; `cargo install --locked --path .` installs both",
        ),
    }
    let Some(found) = found_on_path("mdi") else {
        return report.look(
            "mdi on the PATH",
            "not found; `admire install-shims FOLDER` creates it for scripts that call ADAMS",
        );
    };
    let whose = if is_ours(&found, beside.as_deref()) {
        "the mdi of admire"
    } else {
        "not the mdi of admire, possibly ADAMS"
    };
    report.fine("mdi on the PATH", &format!("{} ({whose})", found.display()));
}

/// Returns true if `found` is the solver beside this program, or a shim that starts this solver.
fn is_ours(found: &Path, beside: Option<&Path>) -> bool {
    let Some(beside) = beside else { return false };
    let same = dunce::canonicalize(found).ok().as_deref() == Some(beside);
    let mut head = Vec::new();
    let file = std::fs::File::open(found).map(|file| file.take(4096).read_to_end(&mut head));
    let starts =
        file.is_ok() && String::from_utf8_lossy(&head).contains(&*beside.to_string_lossy());
    same || starts
}

/// Reports the program that a study names in `[solver]`.
fn of_study(
    folder: &Path,
    permission: Permission,
    report: &mut Report,
    shell: &Shell,
) -> Result<(), Exit> {
    let Some(study) = Study::read(folder).value else {
        let folder = folder.display();
        let why = format!("`{folder}` cannot be read; `admire check {folder}` shows the reason");
        report.broken("study", &why);
        return Ok(());
    };
    if study.solver.backend == BackendChoice::Native {
        report.fine("study", "solved by the built-in solver");
        return Ok(());
    }
    let Some(program) = study.solver.command.first() else {
        report.broken("study", "`solver.command` in study.toml is empty");
        return Ok(());
    };
    let beside = study.folder.join(program);
    let found = if Path::new(program).components().count() > 1 {
        beside.is_file().then_some(beside)
    } else {
        found_on_path(program)
    };
    let Some(found) = found else {
        report.broken("program of study", &format!("`{program}` was not found"));
        return Ok(());
    };
    let named = NamedProgram::named_in(&study.folder.join("study.toml"), &study.solver.command);
    permission.ask(named.as_ref(), shell)?;
    // The command `exit` leaves the command menu of ADAMS before the menu starts a product and takes a licence.
    match first_words(&found, &["-c", "exit"]) {
        Some(words) => report.fine(
            "program of study",
            &format!("{} prints: {words}", found.display()),
        ),
        None => report.look(
            "program of study",
            &format!(
                "{} did not start, or printed nothing within {} s",
                found.display(),
                PATIENCE.as_secs()
            ),
        ),
    }
    Ok(())
}

/// Returns the first line with words in a program's output. `None` if the program prints no words or does not end in time.
fn first_words(program: &Path, arguments: &[&str]) -> Option<String> {
    let folder = tempfile::tempdir().ok()?;
    let mut child = Command::new(program)
        .args(arguments)
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .ok()?;
    let mut out = child.stdout.take()?;
    let reader = std::thread::spawn(move || {
        let mut text = Vec::new();
        // If reading fails, the output read before the error is sufficient.
        let _ = out.by_ref().take(65_536).read_to_end(&mut text);
        text
    });
    let began = Instant::now();
    while child.try_wait().ok()?.is_none() {
        if began.elapsed() > PATIENCE {
            let _ = child.kill();
            let _ = child.wait();
            return None;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let text = reader.join().ok()?;
    let text = String::from_utf8_lossy(&text).into_owned();
    let words = |line: &&str| line.chars().filter(|c| c.is_alphabetic()).count() > 3;
    let line = text
        .lines()
        .map(|line| line.trim_matches(|c: char| c == '|' || c.is_whitespace()))
        .find(words)?;
    Some(line.to_string())
}
