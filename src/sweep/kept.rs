use super::answer_path::AnswerPath;

/// Reduction of a results column over all steps to one value.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Reduction {
    /// Value of the last step.
    Last,
    /// Value of the first step.
    First,
    /// Largest value over all steps.
    Max,
    /// Smallest value over all steps.
    Min,
    /// Mean over all steps with equal weights.
    Mean,
    /// Largest minus smallest value over all steps.
    Range,
    /// Root mean square over all steps.
    Rms,
    /// Value at the step of this number, counted from 1.
    Step(usize),
    /// Value at this time, by linear interpolation between two steps.
    Time(f64),
}

impl Reduction {
    /// Parses the word used in SWEEP.toml; `None` for an unknown word.
    pub(crate) fn of_word(word: &str) -> Option<Self> {
        Some(match word {
            "last" => Self::Last,
            "first" => Self::First,
            "max" => Self::Max,
            "min" => Self::Min,
            "mean" => Self::Mean,
            "range" => Self::Range,
            "rms" => Self::Rms,
            _ => return None,
        })
    }

    /// Returns the suffix of the column's name; empty for the last step.
    pub(crate) fn suffix(self) -> String {
        match self {
            Self::Last => String::new(),
            Self::First => ":first".to_string(),
            Self::Max => ":max".to_string(),
            Self::Min => ":min".to_string(),
            Self::Mean => ":mean".to_string(),
            Self::Range => ":range".to_string(),
            Self::Rms => ":rms".to_string(),
            Self::Step(step) => format!(":step={step}"),
            Self::Time(time) => format!(":time={time}"),
        }
    }

    /// Reduces the values of a column in all output steps to one value. `steps` holds the time and the values of each step. Returns `None`
    /// without steps, or if the requested step or time lies outside of them.
    pub(crate) fn of(self, steps: &[(f64, Vec<f64>)], column: usize) -> Option<f64> {
        let values = || steps.iter().map(|(_, row)| row[column]);
        let count = steps.len();
        if count == 0 {
            return None;
        }
        let most = || values().fold(f64::NEG_INFINITY, f64::max);
        let least = || values().fold(f64::INFINITY, f64::min);
        Some(match self {
            Self::Last => steps[count - 1].1[column],
            Self::First => steps[0].1[column],
            Self::Max => most(),
            Self::Min => least(),
            Self::Mean => values().sum::<f64>() / count as f64,
            Self::Range => most() - least(),
            Self::Rms => (values().map(|v| v * v).sum::<f64>() / count as f64).sqrt(),
            Self::Step(step) => steps.get(step.checked_sub(1)?)?.1[column],
            Self::Time(time) => {
                let after = steps.iter().position(|(at, _)| *at >= time)?;
                let (t1, row) = &steps[after];
                if *t1 == time || after == 0 {
                    return (*t1 == time).then_some(row[column]);
                }
                let (t0, before) = &steps[after - 1];
                let share = (time - t0) / (t1 - t0);
                before[column] + share * (row[column] - before[column])
            }
        })
    }
}

/// Output to be recorded for every case, as specified in SWEEP.toml.
#[derive(Clone, PartialEq, Debug)]
pub enum OutputSpec {
    /// Columns of the results that match a pattern.
    Column {
        /// Pattern, as in `admire results --get`.
        pattern: String,
        /// Reduction over the steps.
        at: Reduction,
    },
    /// Frequency and damping ratio of the eigenvalue with this number, counted from 1, in the last LINEAR/EIGENSOL.
    Mode(usize),
    /// Number in the result file of a study.
    Answer(AnswerPath),
    /// K&C characteristic: its value at ride height, or its gradient in a test.
    Characteristic {
        /// Path, such as `toe_angle.left`.
        path: String,
        /// Test whose gradient is recorded; `None` means the value at ride height.
        test: Option<String>,
    },
}

/// Source of the values in an output column of the table.
#[derive(Clone, PartialEq, Debug)]
pub enum OutputSource {
    /// Position among the selected columns of the results file, and reduction over the steps.
    Column(usize, Reduction),
    /// Frequency of the mode with this number, counted from 0.
    Frequency(usize),
    /// Damping ratio of the mode with this number, counted from 0.
    Damping(usize),
    /// Number in the result file of a study.
    Answer(AnswerPath),
    /// Path of a K&C characteristic, and the test if its gradient is recorded.
    Characteristic(String, Option<String>),
}

/// Output column of the table.
#[derive(Clone, PartialEq, Debug)]
pub struct Output {
    /// Name of the column.
    pub name: String,
    /// Unit, if known.
    pub unit: Option<String>,
    /// Source of its values.
    pub origin: OutputSource,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_become_one_value() {
        let steps: Vec<(f64, Vec<f64>)> =
            vec![(0.0, vec![1.0]), (1.0, vec![5.0]), (3.0, vec![-3.0])];
        let of = |at: Reduction| at.of(&steps, 0);
        assert_eq!(of(Reduction::Last), Some(-3.0));
        assert_eq!(of(Reduction::First), Some(1.0));
        assert_eq!(of(Reduction::Max), Some(5.0));
        assert_eq!(of(Reduction::Min), Some(-3.0));
        assert_eq!(of(Reduction::Mean), Some(1.0));
        assert_eq!(of(Reduction::Range), Some(8.0));
        assert_eq!(of(Reduction::Rms), Some((35.0_f64 / 3.0).sqrt()));
        assert_eq!(of(Reduction::Step(2)), Some(5.0));
        assert_eq!(of(Reduction::Step(4)), None);
        assert_eq!(of(Reduction::Time(2.0)), Some(1.0));
        assert_eq!(of(Reduction::Time(3.0)), Some(-3.0));
        assert_eq!(of(Reduction::Time(3.5)), None);
        assert_eq!(Reduction::Last.of(&[], 0), None);
    }
}
