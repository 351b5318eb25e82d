use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Shard of a sweep: a contiguous part of its cases.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Shard {
    /// Number of the shard, from 1.
    pub number: u64,
    /// Total number of shards.
    pub of: u64,
}

impl Shard {
    /// Single shard that covers the whole sweep.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// Returns the case numbers of the shard, out of `all` cases. They are contiguous, so that merging is concatenation.
    pub fn cases(self, all: u64) -> Range<u64> {
        let before = |n: u64| (u128::from(all) * u128::from(n) / u128::from(self.of)) as u64;
        before(self.number - 1)..before(self.number)
    }

    /// Returns the stem of the shard's file names, such as `0003-of-0008`.
    pub(crate) fn stem(self) -> String {
        format!("{:04}-of-{:04}", self.number, self.of)
    }

    /// Parses the stem of a shard's file name; `None` if it is not such a stem.
    pub(crate) fn of_stem(stem: &str) -> Option<Self> {
        let (number, of) = stem.split_once("-of-")?;
        let shard: Self = format!(
            "{}/{}",
            number.parse::<u64>().ok()?,
            of.parse::<u64>().ok()?
        )
        .parse()
        .ok()?;
        (shard.stem() == stem).then_some(shard)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

/// Largest number of shards. With more shards, files and jobs would cost more than the cases.
pub const MOST_SHARDS: u64 = 9999;

impl FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        let (number, of) = text.split_once('/').ok_or(ShardError)?;
        let (Ok(number), Ok(of)) = (number.parse::<u64>(), of.parse::<u64>()) else {
            return Err(ShardError);
        };
        if number == 0 || number > of || of > MOST_SHARDS {
            return Err(ShardError);
        }
        Ok(Self { number, of })
    }
}

/// Error for a text that does not name a shard.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("a shard is written as I/N, for example 3/8: I from 1 to N, and N at most {MOST_SHARDS}")]
pub struct ShardError;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_cover_every_case_once() {
        for (all, of) in [(10, 3), (2, 8), (1_000_000_007, 9999), (0, 2)] {
            let mut next = 0;
            for number in 1..=of {
                let cases = Shard { number, of }.cases(all);
                assert_eq!(cases.start, next);
                assert!(cases.end - cases.start <= all / of + 1);
                next = cases.end;
            }
            assert_eq!(next, all);
        }
    }

    #[test]
    fn stems_and_words_come_back() {
        let shard: Shard = "3/8".parse().unwrap();
        assert_eq!(shard.stem(), "0003-of-0008");
        assert_eq!(Shard::of_stem("0003-of-0008"), Some(shard));
        for bad in ["0/8", "9/8", "3", "a/b", "1/10000", "-1/2"] {
            assert!(bad.parse::<Shard>().is_err(), "{bad}");
        }
        assert_eq!(Shard::of_stem("3-of-8"), None);
    }
}
