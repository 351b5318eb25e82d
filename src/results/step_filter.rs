use super::StepKind;

/// Criteria that select output steps of a results file.
#[derive(Clone, PartialEq, Debug)]
pub struct StepFilter {
    /// Ranges of accepted positions, as pairs (first, last) counted from 1. An empty list accepts all positions.
    pub ranges: Vec<(usize, usize)>,
    /// Earliest accepted time.
    pub from: f64,
    /// Latest accepted time.
    pub to: f64,
    /// Accepted kinds of steps; an empty list accepts all kinds.
    pub kinds: Vec<StepKind>,
    /// True if only the last of the accepted steps is selected.
    pub last: bool,
}

impl Default for StepFilter {
    fn default() -> Self {
        Self {
            ranges: Vec::new(),
            from: f64::NEG_INFINITY,
            to: f64::INFINITY,
            kinds: Vec::new(),
            last: false,
        }
    }
}

impl StepFilter {
    /// Parses positions such as `3`, `2-5`, `7-` or `last`, separated by commas, and adds them to the filter.
    ///
    /// # Errors
    /// Returns the first word that is not a position or a range.
    pub fn positions(&mut self, text: &str) -> Result<(), String> {
        for word in text
            .split(',')
            .map(str::trim)
            .filter(|word| !word.is_empty())
        {
            if word.eq_ignore_ascii_case("last") {
                self.last = true;
                continue;
            }
            let (first, last) = word.split_once('-').unwrap_or((word, word));
            let number = |text: &str, open: usize| match text.trim() {
                "" => Some(open),
                digits => digits.parse::<usize>().ok().filter(|n| *n > 0),
            };
            match (number(first, 1), number(last, usize::MAX)) {
                (Some(first), Some(last)) if first <= last && word != "-" => {
                    self.ranges.push((first, last));
                }
                _ => return Err(word.to_string()),
            }
        }
        Ok(())
    }

    /// Returns true if the filter accepts an output step, given its position (from 0), kind and time. A step without a time is accepted
    /// whatever the time limits are.
    pub fn takes(&self, position: usize, kind: StepKind, time: Option<f64>) -> bool {
        let place = position + 1;
        let within = |(first, last): &(usize, usize)| (*first..=*last).contains(&place);
        (self.ranges.is_empty() || self.ranges.iter().any(within))
            && (self.kinds.is_empty() || self.kinds.contains(&kind))
            && time.is_none_or(|time| self.from <= time && time <= self.to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_times_and_kinds() {
        let mut filter = StepFilter::default();
        filter.positions("2, 4-5,9-").unwrap();
        let taken: Vec<usize> = (0..12)
            .filter(|at| filter.takes(*at, StepKind::Static, None))
            .map(|at| at + 1)
            .collect();
        assert_eq!(taken, [2, 4, 5, 9, 10, 11, 12]);
        for wrong in ["0", "5-4", "x", "-"] {
            assert!(StepFilter::default().positions(wrong).is_err(), "{wrong}");
        }
        let filter = StepFilter {
            from: 0.5,
            kinds: vec![StepKind::Dynamic],
            ..StepFilter::default()
        };
        assert!(filter.takes(0, StepKind::Dynamic, Some(0.5)));
        assert!(!filter.takes(0, StepKind::Dynamic, Some(0.4)));
        assert!(!filter.takes(0, StepKind::Static, Some(0.5)));
    }
}
