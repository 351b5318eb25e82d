use std::path::PathBuf;

/// Reason why a run ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug, serde::Serialize, serde::Deserialize)]
pub enum Stop {
    /// The run reached STOP or the end of the commands.
    Finished,
    /// A command file or dataset cannot be read, or an output file cannot be written.
    File,
    /// The dataset has errors.
    Model,
    /// A simulation failed, and PREFERENCES/SIMFAIL=STOPCF requires the run to stop then.
    Simulation,
    /// The callback that watches the run stopped the run.
    Interrupted,
}

/// Outcome of a run.
#[derive(Clone, PartialEq, Eq, Debug, serde::Serialize, serde::Deserialize)]
pub struct Ending {
    /// Reason why the run ended.
    pub stop: Stop,
    /// Number of commands with errors.
    pub misunderstood: usize,
    /// Number of commands and simulations that ADAMS executes but this solver does not.
    pub refused: usize,
    /// Number of simulations that failed to give a solution.
    pub failed: usize,
    /// Results file of the last model that has a results file.
    pub results: Option<PathBuf>,
}

/// Table of the exit codes of `mdi`, printed by `mdi --help`; the guide page `drop_in` contains the same table.
pub(crate) const EXIT_CODES: &str = "\
  what happened                                                            code  MDI_STRICT=1  runStatus in .res
  all commands executed, equilibrium found                                   0        0        Successful
  harmless and ignored (SHOW, EXIT, an id that is not in the dataset)        0        0        Successful
  no equilibrium was found; the commands continued                           0        3        Failed
  the same, and PREFERENCES/SIMFAIL=STOPCF ended them                        3        3        Failed
  not supported by this solver: active CONTACT, tyre, user subroutine        1        1        Failed
  a command cannot be understood                                             1        1        as for the simulations
  the dataset has errors                                                     1        1        no results
  the command line is wrong; a file cannot be read or written                2        2        none, or cut short
";

impl Ending {
    /// Returns the exit code of the process; [`EXIT_CODES`] lists all codes.
    ///
    /// As in ADAMS, 0 means that the run reached the end of the commands, even if a static solution failed. Command files that try several
    /// static solutions in turn rely on this. If `strict` is true, a failed simulation gives 3.
    ///
    /// If there were commands that this solver does not understand or does not execute, the code is 1, whatever `strict` is.
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
