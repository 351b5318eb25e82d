use std::time::{SystemTime, UNIX_EPOCH};

/// A moment in UTC, with the spellings that results files use.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Timestamp {
    seconds: i64,
}

impl Timestamp {
    /// Returns the current time. If the environment variable `SOURCE_DATE_EPOCH` is set, returns the time that it gives in seconds since
    /// 1970-01-01 00:00:00 UTC (<https://reproducible-builds.org/specs/source-date-epoch/>).
    ///
    /// With this variable, two equal runs write exactly the same bytes.
    pub fn now() -> Self {
        if let Some(seconds) = std::env::var("SOURCE_DATE_EPOCH")
            .ok()
            .and_then(|text| text.trim().parse::<u32>().ok())
        {
            return Self {
                seconds: seconds.into(),
            };
        }
        let seconds = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .map_or(0, |elapsed| elapsed.as_secs() as i64);
        Self { seconds }
    }

    /// Creates a moment from the number of seconds since 1970-01-01 00:00:00 UTC.
    pub const fn from_unix(seconds: i64) -> Self {
        Self { seconds }
    }

    /// Formats the moment as `YYYY-MM-DD HH:MM:SS`.
    pub fn date_time(self) -> String {
        let (year, month, day) = civil(self.seconds.div_euclid(86_400));
        let of_day = self.seconds.rem_euclid(86_400);
        format!(
            "{year:04}-{month:02}-{day:02} {:02}:{:02}:{:02}",
            of_day / 3600,
            of_day / 60 % 60,
            of_day % 60
        )
    }

    /// Formats the moment as `YYYY-MM-DD HH:MM:SS+00:00`.
    pub(crate) fn with_offset(self) -> String {
        format!("{}+00:00", self.date_time())
    }
}

/// Converts a number of days since 1970-01-01 to year, month and day of the Gregorian calendar.
///
/// The algorithm counts in eras of 400 years, and its years begin in March.
fn civil(days: i64) -> (i64, i64, i64) {
    let shifted = days + 719_468;
    let era = shifted.div_euclid(146_097);
    let of_era = shifted.rem_euclid(146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 {
        month_from_march + 3
    } else {
        month_from_march - 9
    };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    (year, month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_follow_the_calendar() {
        // The expected texts were printed by `date -u -d @N`.
        assert_eq!(Timestamp::from_unix(0).date_time(), "1970-01-01 00:00:00");
        assert_eq!(
            Timestamp::from_unix(951_827_696).with_offset(),
            "2000-02-29 12:34:56+00:00"
        );
        assert_eq!(
            Timestamp::from_unix(1_735_689_599).date_time(),
            "2024-12-31 23:59:59"
        );
    }
}
