//! Figures as people read them.

use crate::number;

/// `1234567` as `1,234,567`.
pub fn count(value: usize) -> String {
    number::count(value as u64)
}

/// Three significant digits, as many before the point as there are: `0.123`, `12.3`, `1,230`.
pub fn figure(value: f64) -> String {
    match value {
        v if !v.is_finite() => "–".into(),
        v if v >= 99.95 => count(rounded(v) as usize),
        v if v >= 9.995 => format!("{v:.1}"),
        v if v >= 0.9995 => format!("{v:.2}"),
        v => format!("{v:.3}"),
    }
}

/// To three significant digits.
fn rounded(value: f64) -> f64 {
    let unit = 10f64.powi((value.log10().floor() as i32 - 2).max(0));
    (value / unit).round() * unit
}

/// Nanoseconds with a unit that suits: `254 ns`, `2.38 ms`.
pub fn nanoseconds(value: f64) -> String {
    match value {
        v if v < 999.5 => format!("{} ns", figure(v)),
        v if v < 999.5e3 => format!("{} µs", figure(v / 1e3)),
        v if v < 999.5e6 => format!("{} ms", figure(v / 1e6)),
        v => format!("{} s", figure(v / 1e9)),
    }
}

/// Bytes in powers of 1024, as caches are told: `32 MB` is 2^25.
pub fn bytes(value: f64) -> String {
    const KILO: f64 = 1024.0;
    let (scaled, unit) = match value {
        v if v < KILO => (v, "bytes"),
        v if v < KILO * KILO => (v / KILO, "kB"),
        v if v < KILO * KILO * KILO => (v / KILO / KILO, "MB"),
        v => (v / KILO / KILO / KILO, "GB"),
    };
    match scaled < 9.95 && scaled.fract() > 0.04 {
        true => format!("{scaled:.1} {unit}"),
        false => format!("{scaled:.0} {unit}"),
    }
}

/// A guess at seconds.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.0} h", s / 3600.0),
    }
}

/// A guess at bytes.
pub fn gigabytes(bytes: f64) -> String {
    match bytes / 1e9 {
        b if b < 10.0 => format!("{b:.1} GB"),
        b if b < 2000.0 => format!("{b:.0} GB"),
        b => format!("{:.0} TB", b / 1000.0),
    }
}

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
    fn figures_have_three_digits() {
        let texts = [0.0123, 1.0, 12.34, 99.97, 123.4, 9996.0, 1_234_567.0, f64::NAN].map(figure);
        assert_eq!(texts, ["0.012", "1.00", "12.3", "100", "123", "10,000", "1,230,000", "–"]);
        let texts = [254.4, 2540.0, 2.38e6, 7.2e9].map(nanoseconds);
        assert_eq!(texts, ["254 ns", "2.54 µs", "2.38 ms", "7.20 s"]);
    }

    #[test]
    fn bytes_are_those_of_caches() {
        let texts = [512.0, 32768.0, 1536.0, 33554432.0, 1.8e6, 6.4e9].map(bytes);
        assert_eq!(texts, ["512 bytes", "32 kB", "1.5 kB", "32 MB", "1.7 MB", "6.0 GB"]);
    }

    #[test]
    fn dates_know_leap_years() {
        let texts = [0, 951_782_400, 1_709_251_199, 1_795_716_846].map(utc);
        let expected =
            ["1970-01-01 00:00", "2000-02-29 00:00", "2024-02-29 23:59", "2026-11-26 18:14"];
        assert_eq!(texts.map(|text| text.replace(" UTC", "")), expected);
    }
}
