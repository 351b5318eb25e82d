use std::path::PathBuf;

/// Why a run ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug, serde::Serialize, serde::Deserialize)]
pub enum Stop {
    /// STOP, or the end of the commands.
    Finished,
    /// A command file or a dataset cannot be read, or an output file cannot be written.
    File,
    /// The dataset has errors.
    Model,
    /// PREFERENCES/SIMFAIL=STOPCF and a simulation failed.
    Simulation,
    /// Whoever watches the run asked it to stop.
    Interrupted,
}

/// What came of a run.
#[derive(Clone, PartialEq, Eq, Debug, serde::Serialize, serde::Deserialize)]
pub struct Ending {
    /// Why it ended.
    pub stop: Stop,
    /// Commands that could not be understood.
    pub misunderstood: usize,
    /// Commands and simulations that ADAMS executes and this solver does not.
    pub refused: usize,
    /// Simulations without an answer.
    pub failed: usize,
    /// The results of the last model that has any.
    pub results: Option<PathBuf>,
}

/// What `mdi` ends with, for `mdi --help`; the page `drop_in` of the guide has the same table.
pub(crate) const EXIT_CODES: &str = "\
  what happened                                                            code  MDI_STRICT=1  runStatus in .res
  all commands executed, equilibrium found                                   0        0        Successful
  harmless and ignored (SHOW, EXIT, an id that is not in the dataset)        0        0        Successful
  no equilibrium was found; the commands went on                             0        3        Failed
  the same, and PREFERENCES/SIMFAIL=STOPCF ended them                        3        3        Failed
  this solver lacks it: an active CONTACT, tyre, user subroutine             1        1        Failed
  a command cannot be understood                                             1        1        as the simulations
  the dataset has errors                                                     1        1        no results
  the command line is wrong; a file cannot be read or written                2        2        none, or cut short
";

impl Ending {
    /// The exit code of the process.
    ///
    /// As ADAMS does, 0 when the end was reached, even if a static solution failed on the way: funnels of static solutions
    /// count on it; with `strict` that is 3. What ADAMS would have solved or understood and this solver did not is 1 with and
    /// without: ADAMS would not have failed. See `EXIT_CODES`.
    pub fn exit_code(&self, strict: bool) -> u8 {
        match self.stop {
            Stop::File => 2,
            Stop::Model => 1,
            Stop::Simulation | Stop::Interrupted => 3,
            Stop::Finished if self.misunderstood > 0 || self.refused > 0 => 1,
            Stop::Finished if strict && self.failed > 0 => 3,
            Stop::Finished => 0,
        }
    }
}
