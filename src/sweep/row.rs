/// How a case ended.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Status {
    /// All went well.
    Ok,
    /// A simulation found no equilibrium, or no motion.
    NoAnswer,
    /// A command was not executed.
    Refused,
    /// The deck has errors with these numbers.
    Invalid,
    /// The program that solves gave nothing that can be taken for an answer.
    RunFailed,
}

impl Status {
    /// All of them.
    pub(crate) const ALL: [Self; 5] = [
        Self::Ok,
        Self::NoAnswer,
        Self::Refused,
        Self::Invalid,
        Self::RunFailed,
    ];

    /// The word in the column `status`.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::NoAnswer => "no-answer",
            Self::Refused => "refused",
            Self::Invalid => "invalid",
            Self::RunFailed => "run-failed",
        }
    }

    /// The status of a word.
    pub(crate) fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|status| status.word() == word)
    }
}

/// What came of a case.
#[derive(Clone, PartialEq, Debug)]
pub struct Row {
    /// Which.
    pub case: u64,
    /// How it ended.
    pub status: Status,
    /// Why it has no answer; empty if it has one.
    pub reason: String,
    /// Wall time, seconds.
    pub seconds: f64,
    /// What is kept; not finite where there is no value. Empty without an answer.
    pub outputs: Vec<f64>,
}

impl Row {
    /// Of a case that began at `start` and ends now, with its numbers or why it has none.
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
