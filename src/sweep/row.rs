/// Status of a finished case.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Status {
    /// Success.
    Ok,
    /// A simulation found no equilibrium or no motion, or a fit of a study failed.
    NoAnswer,
    /// A command was not executed.
    Refused,
    /// The deck has errors with the parameter values of this case.
    Invalid,
    /// The external program returned no usable result.
    RunFailed,
}

impl Status {
    /// All statuses.
    pub(crate) const ALL: [Self; 5] = [
        Self::Ok,
        Self::NoAnswer,
        Self::Refused,
        Self::Invalid,
        Self::RunFailed,
    ];

    /// Returns the word in the column `status`.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::NoAnswer => "no-answer",
            Self::Refused => "refused",
            Self::Invalid => "invalid",
            Self::RunFailed => "run-failed",
        }
    }

    /// Returns the status for a word of the column `status`.
    pub(crate) fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|status| status.word() == word)
    }
}

/// Result of a case.
#[derive(Clone, PartialEq, Debug)]
pub struct Row {
    /// Case number.
    pub case: u64,
    /// Status of the case.
    pub status: Status,
    /// Reason why there is no result; empty on success.
    pub reason: String,
    /// Wall time in seconds.
    pub seconds: f64,
    /// Recorded outputs, empty if the case failed. A missing value is stored as a non-finite number.
    pub outputs: Vec<f64>,
}

impl Row {
    /// Creates the row of a case that started at `start` and ends now, from its outputs or the reason of its failure.
    pub(crate) fn ended(
        case: u64,
        start: std::time::Instant,
        outcome: Result<Vec<f64>, (Status, String)>,
    ) -> Self {
        let (status, reason, outputs) = match outcome {
            Ok(outputs) => (Status::Ok, String::new(), outputs),
            Err((status, reason)) => (status, reason, Vec::new()),
        };
        Self {
            case,
            status,
            reason,
            seconds: start.elapsed().as_secs_f64(),
            outputs,
        }
    }
}
