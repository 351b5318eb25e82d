use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// The time of day in UTC as output files print it, `2026-11-20 10:00:00`. The environment variable `SOURCE_DATE_EPOCH`
/// (seconds since 1970) fixes it, so that two runs can write the same bytes.
pub fn utc_now() -> String {
    let fixed = std::env::var("SOURCE_DATE_EPOCH")
        .ok()
        .and_then(|text| text.trim().parse().ok());
    let seconds = fixed.unwrap_or_else(|| {
        SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or(Duration::ZERO)
            .as_secs()
    });
    calendar(seconds)
}

/// Date and time of a count of seconds since 1970 in the proleptic Gregorian calendar: the year is taken to begin in March, so
/// that the leap day is its last (H. Hinnant, "chrono-compatible low-level date algorithms").
fn calendar(seconds: u64) -> String {
    let (days, second) = (seconds / 86400, seconds % 86400);
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 {
        month_from_march + 3
    } else {
        month_from_march - 9
    };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!(
        "{year:04}-{month:02}-{day:02} {:02}:{:02}:{:02}",
        second / 3600,
        second / 60 % 60,
        second % 60
    )
}

#[cfg(test)]
mod tests {
    use super::calendar;

    #[test]
    fn known_instants() {
        // `date -u -d @N`.
        assert_eq!(calendar(0), "1970-01-01 00:00:00");
        assert_eq!(calendar(951_782_400), "2000-02-29 00:00:00");
        assert_eq!(calendar(1_735_689_599), "2024-12-31 23:59:59");
        assert_eq!(calendar(4_107_542_400), "2100-03-01 00:00:00");
    }
}
