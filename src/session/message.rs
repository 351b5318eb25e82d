use std::fmt::Write as _;
use std::fs::{File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use admire_results::Timestamp;
use admire_solver::model::lint::MarkerGap;
use admire_solver::model::{IntegratorSettings, KinematicsSettings};
use admire_solver::system::{EquationName, Name};
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::text::printable;

use super::located::{Sources, located};
use super::outputs::emptied;
use super::record::Sink;
use super::simulate::{OutputTimes, Phases};

/// Longest time to wait for another run that writes the same files.
const PATIENCE: Duration = Duration::from_secs(10);

/// Messages of a run, written to the console and to the message file `.msg`.
///
/// The first FILE/MODEL command determines the name of the file; messages before that command are kept in memory and written then. Lines
/// for which scripts search have the form in guide/formats.md 6.5. If the message file cannot be written, the run continues.
pub(crate) struct Messages<'a> {
    console: Box<dyn Write + 'a>,
    file: Option<Sink>,
    path: Option<PathBuf>,
    pending: Vec<u8>,
    /// First error in writing the message file.
    error: Option<String>,
    /// Warnings and errors reported so far; `None` if they are not recorded.
    told: Option<Vec<Diagnostic>>,
    /// Message files that this run has locked until its end, with their paths.
    owned: Vec<(PathBuf, File)>,
}

/// Maximum number of warnings and errors that are recorded as data.
const MOST_TOLD: usize = 1000;

impl<'a> Messages<'a> {
    /// Creates the messages of a run and prints the banner. Messages go to `console`, and also to a file once it is opened.
    pub(crate) fn new(console: Box<dyn Write + 'a>, directory: &Path) -> Self {
        let mut messages = Self {
            console,
            file: None,
            path: None,
            pending: Vec::new(),
            error: None,
            told: None,
            owned: Vec::new(),
        };
        messages.banner(directory);
        messages
    }

    /// Starts recording warnings and errors as data.
    pub(super) fn record(&mut self) {
        self.told = Some(Vec::new());
    }

    /// Takes the whole text and the recorded warnings and errors out of messages that are not written to a file.
    pub(super) fn take(&mut self) -> (Vec<u8>, Vec<Diagnostic>) {
        let said = std::mem::take(&mut self.pending);
        (said, self.told.take().unwrap_or_default())
    }

    /// Locks the message file of a run, so that no other run writes files with the same prefix.
    ///
    /// If another run holds the lock, waits until the lock is free. File systems without locks are tolerated. On Windows, the file is not
    /// locked, because a lock would prevent other programs from reading it.
    ///
    /// # Errors
    /// Returns `cannot-write` if another run holds the lock for more than ten seconds.
    pub(crate) fn own(&mut self, path: &Path) -> Result<(), Diagnostic> {
        if cfg!(windows) || self.owned.iter().any(|(own, _)| own == path) {
            return Ok(());
        }
        let mut options = File::options();
        let Ok(file) = options.write(true).create(true).truncate(false).open(path) else {
            // Opening the file for writing will fail as well, and then the error is reported.
            return Ok(());
        };
        let begin = Instant::now();
        while let Err(TryLockError::WouldBlock) = file.try_lock() {
            if begin.elapsed() > PATIENCE {
                let message = format!("another run is writing `{}`", path.display());
                return Err(Diagnostic::error(Code::CannotWrite, message).help(
                    "wait for it to end, or give one of the two runs another output_prefix",
                ));
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        self.owned.push((path.to_path_buf(), file));
        Ok(())
    }

    /// Opens `path` as the message file, discards its old content, and writes all earlier messages to it. If this file is already open, it
    /// stays open unchanged.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub(crate) fn open(&mut self, path: &Path) -> io::Result<()> {
        if self.path.as_deref() == Some(path) {
            return Ok(());
        }
        let mut file = Sink::file(emptied(path)?);
        file.write_all(&self.pending)?;
        self.pending.clear();
        if let Some(mut before) = self.file.replace(file) {
            before.flush()?;
        }
        self.path = Some(path.to_path_buf());
        Ok(())
    }

    /// Returns true once a message file was opened.
    pub(crate) fn is_open(&self) -> bool {
        self.file.is_some()
    }

    /// Writes text to the console and to the file.
    pub(crate) fn say(&mut self, text: &str) {
        // If the console is a closed pipe, the run continues.
        let _ = self.console.write_all(printable(text).as_bytes());
        match &mut self.file {
            Some(file) => {
                let written = file.write_all(text.as_bytes());
                self.note(written);
            }
            None => self.pending.extend_from_slice(text.as_bytes()),
        }
    }

    /// Flushes the console and the file, so that other programs can read the messages.
    pub(crate) fn flush(&mut self) {
        let _ = self.console.flush();
        if let Some(file) = &mut self.file {
            let flushed = file.flush();
            self.note(flushed);
        }
    }

    fn note(&mut self, written: io::Result<()>) {
        if let (Err(error), Some(path)) = (written, &self.path) {
            self.error
                .get_or_insert_with(|| format!("`{}` cannot be written: {error}", path.display()));
        }
    }

    /// Returns the first error in writing the message file, if there was one.
    pub(crate) fn unwritten(&self) -> Option<String> {
        self.error.clone()
    }

    /// Writes the last line of the run.
    pub(crate) fn last(&mut self, text: &str) {
        self.say(&format!("{text}\n"));
        self.flush();
    }

    fn banner(&mut self, directory: &Path) {
        let rule = "-".repeat(79);
        let mut text = format!("\n{rule}\n");
        let here = if directory.as_os_str().is_empty() {
            std::env::current_dir().unwrap_or_default()
        } else {
            std::path::absolute(directory).unwrap_or_default()
        };
        let lines = [
            String::new(),
            format!("{:^75}", concat!("admire ", env!("CARGO_PKG_VERSION"))),
            format!("{:^75}", "statics and motion of ADAMS datasets"),
            // Programs that read message files recognise their form by this line.
            format!(
                "{:^75}",
                "messages in the form of the A d a m s   C++   S o l v e r"
            ),
            String::new(),
            format!("  Local Time: {} UTC", Timestamp::now().date_time()),
            format!(" Current dir: {}", here.display()),
            format!("  Process ID: {}", std::process::id()),
            String::new(),
        ];
        for line in lines {
            _ = writeln!(text, "| {line:<75} |");
        }
        _ = write!(text, "{rule}\n\n");
        self.say(&text);
    }

    /// Echoes a line of commands before it is executed.
    pub(crate) fn command(&mut self, line: &str) {
        self.say(&format!(" command: {line}\n"));
    }

    /// Writes the title of a model.
    pub(crate) fn title(&mut self, title: &str) {
        let rule = "-".repeat(79);
        let empty = format!("|{:77}|", "");
        self.say(&format!(
            "\n{rule}\n|{:^77}|\n|{}|\n{empty}\n|{:^77}|\n{empty}\n{rule}\n\n",
            "Model Title",
            "=".repeat(77),
            title.trim()
        ));
    }

    /// Writes a warning about a constraint whose markers do not coincide, in the wording of ADAMS.
    pub(crate) fn apart(&mut self, apart: &MarkerGap) {
        let (name, d) = (&apart.name, apart.distance);
        let text = match apart.counts {
            [false, false, true] => format!(
                "The I marker of model.{name} is not in the\nx-y plane of the J marker. The relative displacement along\n\
                 the z-axis of the J marker is: Delta Z = {:>8.4}.\n",
                d.z
            ),
            [true, true, false] => format!(
                "The I marker of model.{name} is not on the\nz-axis of the J marker. The relative displacement,\n\
                 expressed in the J marker coordinate frame is:\nDelta X = {:>8.4}   Delta Y = {:>8.4}.\n",
                d.x, d.y
            ),
            _ => format!(
                "The markers for model.{name} are not initially coincident.\n\
                 The relative displacement between the markers, expressed in the\nJ marker coordinate frame is:\n\
                 Delta X = {:>8.4}   Delta Y = {:>8.4}  Delta Z = {:>8.4}.\n",
                d.x, d.y, d.z
            ),
        };
        self.say(&format!(
            "\n---- START: WARNING ----\n{text}\n---- END: WARNING ----\n"
        ));
    }

    /// Writes the names of the redundant constraint equations, in the form of ADAMS.
    pub(crate) fn redundant(&mut self, time: f64, equations: &[String]) {
        let mut text = format!(
            "  Time T={}.\n  Degree-of-freedom analysis identified redundant constraints in the model:\n  {}\n",
            exponent(time, 9),
            "-".repeat(73)
        );
        for equation in equations {
            _ = writeln!(text, "   -  deactivating constraint equation  {equation}");
        }
        self.say(&(text + "\n"));
    }

    /// Writes a diagnostic: a warning or error in a frame, a note without a frame.
    pub(crate) fn diagnostic(&mut self, diagnostic: &Diagnostic, sources: &Sources) {
        let text = located(diagnostic, sources);
        if let Some(told) = &mut self.told
            && told.len() < MOST_TOLD
        {
            told.push(diagnostic.clone());
        }
        match diagnostic.severity {
            Severity::Note => self.say(&text),
            Severity::Warning => self.frame("WARNING", &text),
            Severity::Error => self.frame("ERROR", &text),
        }
    }

    /// Writes text in a frame of the kind `WARNING` or `ERROR`.
    pub(crate) fn frame(&mut self, kind: &str, text: &str) {
        self.say(&format!(
            "\n---- START: {kind} ----\n{}\n---- END: {kind} ----\n\n",
            text.trim_end()
        ));
    }

    /// Writes the head of a single static solution.
    pub(crate) fn begin_static(&mut self) {
        self.say(
            "\n\n  Begin Static Solution\n\n\n STATICS: Original static solver will be used with the built-in linear solver.\n\n",
        );
    }

    /// Writes the end of a static solution that converged, with the recomputed force balance (`balance`).
    pub(crate) fn converged(&mut self, iterations: usize, imbalance: f64, balance: &str) {
        self.say(&format!(
            "  Static Solution converged in {iterations} iterations\n  Residual imbalance is less than {}\n{balance}\n  End Static \
             Solution\n",
            exponent(imbalance, 5)
        ));
    }

    /// Writes the head of a quasi-static or kinematic simulation; `what` is the word for its kind.
    pub(crate) fn begin_simulation(&mut self, what: &str) {
        self.say(&format!(
            "\n\n  Begin Simulation\n\n  ****** Performing {what} Simulation ******\n\n   Simulation   Iterations   Residual\n   \
             Time                      Imbalance\n   ___________  ___________  ___________\n"
        ));
    }

    /// Writes one output step of a quasi-static simulation.
    pub(crate) fn simulation_step(&mut self, time: f64, iterations: usize, imbalance: f64) {
        self.say(&format!(
            "   {}  {iterations:>11}  {}\n",
            exponent(time, 5),
            exponent(imbalance, 5)
        ));
    }

    /// Writes the head of a simulation over time.
    pub(crate) fn begin_motion(&mut self) {
        self.say("\n\n  Begin Simulation\n");
    }

    /// Writes the phases of an initial-conditions analysis, up to the last phase that a command requests.
    pub(super) fn initial_conditions(&mut self, phases: Phases) {
        let all = ["Displacement", "Velocity", "Acceleration"];
        let count = match phases {
            Phases::Displacement => 1,
            Phases::Velocity => 2,
            Phases::All => 3,
        };
        for phase in &all[..count] {
            self.say(&format!(
                "\n\n  Begin {phase} Initial Conditions\n\n\n  End {phase} Initial Conditions\n"
            ));
        }
    }

    /// Writes the settings of a dynamic simulation and the head of its table of steps.
    ///
    /// `redundant` contains the time and the deactivated constraint equations, if these have changed. If `determined` is true, warns that
    /// the model has no degrees of freedom.
    pub(super) fn dynamic_head(
        &mut self,
        settings: &IntegratorSettings,
        redundant: Option<&(f64, Vec<String>)>,
        determined: bool,
    ) {
        let asked = match settings.method {
            "HHT" | "ABAM" | "RKF45" | "CONSTANT_BDF" => settings.method.to_string(),
            other => format!("{}{}", &other[..1], other[1..].to_ascii_lowercase()),
        };
        self.say(&format!(
            "\n  ****** Performing Dynamic Simulation using {asked} {} Integrator ******\n   ADMIRE: Radau IIA order 5, stabilised index 2 (deck asks for {} {})\n",
            settings.formulation, settings.method, settings.formulation
        ));
        self.without_effect("INTEGRATOR", &settings.without_effect);
        if let Some((time, equations)) = redundant {
            self.redundant(*time, equations);
        }
        if determined {
            self.frame(
                "WARNING",
                "The data set is kinematically determinate.  However, a dynamic analysis\nhas been requested.  A kinematic analysis with the SIMULATE/KINEMATICS\ncommand would be more efficient and possibly more accurate for some of\nthe computed quantities.\n\nAs requested, the simulation will continue with a dynamic analysis.",
            );
        }
        self.say(&format!(
            "   The system is modelled with INDEX-2 DAEs.\n   The integrator is RADAU IIA, CORRECTOR = {}\n   Integration error = {:>15}\n",
            settings.corrector.to_ascii_lowercase(),
            exponent(settings.error(), 6)
        ));
        self.table_head();
    }

    /// Writes the given arguments of a statement that have no effect on the built-in methods.
    pub(super) fn without_effect(&mut self, statement: &str, given: &[&str]) {
        if !given.is_empty() {
            let given = given.join(", ");
            self.say(&format!(
                "   ADMIRE: options without effect in {statement}: {given}\n"
            ));
        }
    }

    /// Writes the settings of a kinematic simulation and the head of its table of steps.
    pub(super) fn kinematic_head(
        &mut self,
        settings: &KinematicsSettings,
        redundant: Option<&(f64, Vec<String>)>,
    ) {
        self.say("\n  ****** Performing Kinematic Simulation ******\n");
        self.without_effect("KINEMATICS", &settings.without_effect);
        if let Some((time, equations)) = redundant {
            self.redundant(*time, equations);
        }
        self.table_head();
    }

    fn table_head(&mut self) {
        self.say(
            "\n   Simulation   Step          Function     Cumulative    Integration   CPU     \n   Time         Size          Evaluations  Steps Taken   Order         Time    \n   ___________  ___________   ___________  ___________   ___________   ________\n",
        );
    }

    /// Writes a row of the table of steps, if this row is due.
    pub(super) fn progress(&mut self, progress: &mut Progress, row: Row) {
        let Some(elapsed) = progress.shown() else {
            return;
        };
        let order = if row.steps == 0 { 1 } else { 5 };
        self.say(&format!(
            "   {}  {}  {:>11}  {:>11}  {order:>12}  {:>9} \n",
            exponent(row.time, 5),
            exponent(row.step, 5),
            row.evaluations,
            row.steps,
            clock(elapsed.as_secs_f64())
        ));
    }

    /// Writes the end of a simulation.
    pub(crate) fn end_simulation(&mut self) {
        self.say("\n  End Simulation\n");
    }

    /// Writes the last lines of a run in the form of ADAMS.
    pub(crate) fn finished(&mut self, elapsed: std::time::Duration) {
        let cpu = cpu_time::ProcessTime::try_now().map_or(elapsed, |now| now.as_duration());
        let (elapsed, cpu) = (elapsed.as_secs_f64(), cpu.as_secs_f64());
        // For an elapsed time of zero, the load is undefined and 100 % is written.
        let load = if elapsed > 0.0 {
            100.0 * cpu / elapsed
        } else {
            100.0
        };
        self.say(&format!(
            "\n\nFinished -----\nElapsed time = {elapsed:.2}s,  CPU time = {cpu:.2}s,  {load:.2}%\n"
        ));
        self.flush();
    }
}

/// One row in the table of steps of a simulation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub time: f64,
    pub step: f64,
    pub evaluations: usize,
    pub steps: usize,
}

/// Selects the rows to be printed in the table of steps: the start, one row after each tenth of the outputs, and the last output.
pub(super) struct Progress {
    every: usize,
    count: usize,
    seen: usize,
    start: Instant,
}

impl Progress {
    pub(crate) fn new(times: &OutputTimes) -> Self {
        Self {
            every: (times.count / 10).max(1),
            count: times.count,
            seen: 0,
            start: Instant::now(),
        }
    }

    /// Returns the time elapsed since the start if the next row is to be printed, `None` otherwise.
    pub(crate) fn shown(&mut self) -> Option<Duration> {
        let at = self.seen;
        self.seen += 1;
        (at.is_multiple_of(self.every) || at == self.count).then(|| self.start.elapsed())
    }
}

/// Formats a constraint equation as ADAMS prints it: `Zi.Xj in model.crank_pin`.
pub(super) fn equation_as_adams(equation: &EquationName) -> String {
    let object = object_as_adams(&equation.object);
    match equation.what {
        Some(what) => format!("{what} in {object}"),
        None => object,
    }
}

/// Formats the name of an object as ADAMS prints it: `model.crank_pin`, or `model.JOINT_2` if it has no ADAMS/View name.
pub(super) fn object_as_adams(object: &Name) -> String {
    match object.view.as_str() {
        "" => format!("model.{}_{}", object.kind, object.id),
        view => format!("model.{view}"),
    }
}

/// Formats a time in seconds: with two decimals below one minute, as m:ss below one hour, and as h:mm:ss from there on.
fn clock(seconds: f64) -> String {
    let whole = seconds as u64;
    match whole {
        0..60 => format!("{seconds:.2}"),
        60..3600 => format!("{}:{:02}", whole / 60, whole % 60),
        _ => format!("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60),
    }
}

/// Formats a number like C's `%.{digits}E`, with an exponent of at least two digits: `4.64042E-01`.
pub fn exponent(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    let text = format!("{value:.digits$E}");
    let (mantissa, power) = text.split_once('E').expect("the format has an exponent");
    let (sign, power) = match power.strip_prefix('-') {
        Some(power) => ('-', power),
        None => ('+', power),
    };
    format!("{mantissa}E{sign}{power:0>2}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_have_two_digits() {
        assert_eq!(exponent(0.464042, 5), "4.64042E-01");
        assert_eq!(exponent(0.0, 5), "0.00000E+00");
        assert_eq!(exponent(-1.5e123, 2), "-1.50E+123");
    }

    #[test]
    fn the_file_holds_what_was_said_before_it_had_a_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.msg");
        std::fs::write(&path, "the run before").unwrap();
        let mut console = Vec::new();
        {
            let mut messages = Messages::new(Box::new(&mut console), folder.path());
            messages.command("FILE/MODEL=run");
            messages.open(&path).unwrap();
            messages.title("A title");
            messages.converged(63, 0.464042, "");
            messages.flush();
        }
        let file = std::fs::read_to_string(&path).unwrap();
        assert_eq!(file.contains("\r\n"), cfg!(windows));
        let file = file.replace("\r\n", "\n");
        assert_eq!(file, String::from_utf8(console).unwrap());
        assert!(file.contains("\n command: FILE/MODEL=run\n\n-----"));
        assert!(file.contains(&format!("|{:35}A title{:35}|\n", "", "")));
        // These lines are listed in guide/formats.md 6.5.
        assert!(file.contains("  Static Solution converged in 63 iterations\n  Residual imbalance is less than 4.64042E-01\n"));
    }
}
