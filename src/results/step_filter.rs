use super::StepKind;

/// Which steps of a file are taken.
#[derive(Clone, PartialEq, Debug)]
pub struct StepFilter {
    /// Positions from 1, first and last of each range; all if there are none.
    pub ranges: Vec<(usize, usize)>,
    /// Steps at this time or later.
    pub from: f64,
    /// Steps at this time or earlier.
    pub to: f64,
    /// Steps of these kinds; of all if there are none.
    pub kinds: Vec<StepKind>,
    /// Of all these only the last one.
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
    /// Reads positions: `3`, `2-5`, `7-`, several with commas, `last`.
    ///
    /// # Errors
    /// The word that is none of these.
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

    /// True if a step at a position from 0, of a kind and at a time is taken. A step without a time is taken at any.
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
