use super::answer_path::AnswerPath;

/// What one value of many steps is.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Reduction {
    /// The last step.
    Last,
    /// The first step.
    First,
    /// The largest value of all steps.
    Max,
    /// The smallest.
    Min,
    /// The mean of all steps, each counting alike.
    Mean,
    /// Largest less smallest.
    Range,
    /// Root of the mean square of all steps.
    Rms,
    /// Step number, from 1.
    Step(usize),
    /// At this time, on the line between two steps.
    Time(f64),
}

impl Reduction {
    /// The word of SWEEP.toml.
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

    /// What stands behind the name of the column; nothing for the last step.
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

    /// The value of a column of steps; `None` where there is no such step.
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

/// What is kept of every case, as SWEEP.toml asks.
#[derive(Clone, PartialEq, Debug)]
pub enum OutputSpec {
    /// Columns of the results that match a pattern.
    Column {
        /// As `admire results --get` has it.
        pattern: String,
        /// Of which steps.
        at: Reduction,
    },
    /// Frequency and damping ratio of an eigenvalue of the last LINEAR/EIGENSOL, from 1.
    Mode(usize),
    /// A number of the answer to a study.
    Answer(AnswerPath),
    /// A K&C characteristic: at ride height, or its slope in a test.
    Characteristic {
        /// `toe_angle.left`.
        path: String,
        /// The test whose slope is meant.
        test: Option<String>,
    },
}

/// Where a column of the answer comes from.
#[derive(Clone, PartialEq, Debug)]
pub enum OutputSource {
    /// Column of the picked ones.
    Column(usize, Reduction),
    /// Frequency of a mode, counted from 0.
    Frequency(usize),
    /// Damping ratio of a mode, counted from 0.
    Damping(usize),
    /// A number of the answer to a study.
    Answer(AnswerPath),
    /// K&C characteristic and the test whose slope it is.
    Characteristic(String, Option<String>),
}

/// A column of the answer.
#[derive(Clone, PartialEq, Debug)]
pub struct Output {
    /// Its name.
    pub name: String,
    /// Its unit, where one is known.
    pub unit: Option<String>,
    /// Where it comes from.
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
