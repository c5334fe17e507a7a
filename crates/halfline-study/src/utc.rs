//! Moments as dates.

/// Seconds since 1970 as a date and time, `2026-11-26 18:14 UTC`. The days are those of H. Hinnant,
/// "chrono-Compatible Low-Level Date Algorithms", 2013.
pub fn utc(seconds: u64) -> String {
    let (days, second) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    // The year begins in March here, so that the odd day is its last.
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    format!("{year}-{month:02}-{day:02} {:02}:{:02} UTC", second / 3600, second % 3600 / 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_know_leap_years() {
        let texts = [0, 951_782_400, 1_709_251_199, 1_795_716_846].map(utc);
        let expected =
            ["1970-01-01 00:00", "2000-02-29 00:00", "2024-02-29 23:59", "2026-11-26 18:14"];
        assert_eq!(texts.map(|text| text.replace(" UTC", "")), expected);
    }
}
