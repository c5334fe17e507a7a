//! Numbers as people read them, with their units.

/// Six significant digits, as much as a person compares by eye, and no more than are needed.
pub fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return if value.is_nan() {
            "NaN"
        } else if value > 0.0 {
            "∞"
        } else {
            "-∞"
        }
        .into();
    }
    let scientific = format!("{value:.5e}");
    let (digits, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let trim = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    match exponent.parse::<i32>() {
        Ok(exponent @ -4..9) => {
            trim(&format!("{value:.decimals$}", decimals = (5 - exponent).max(0) as usize))
        }
        _ => format!("{}e{exponent}", trim(digits)),
    }
}

/// A whole number with its thousands apart.
pub fn count(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A count and what is counted, in the singular for one.
pub fn counted(value: u64, noun: &str) -> String {
    let plural = match noun.strip_suffix('f') {
        Some(stem) if noun == "leaf" => format!("{}ves", stem),
        _ => format!("{noun}s"),
    };
    format!("{} {}", count(value), if value == 1 { noun } else { &plural })
}

/// A number with three significant digits, or as many as there are before the point: `0.123`, `12.3`,
/// `1,230`.
pub fn figure(value: f64) -> String {
    match value {
        v if !v.is_finite() => "–".into(),
        v if v >= 99.95 => {
            let unit = 10f64.powi((v.log10().floor() as i32 - 2).max(0));
            count(((v / unit).round() * unit) as u64)
        }
        v if v >= 9.995 => format!("{v:.1}"),
        v if v >= 0.9995 => format!("{v:.2}"),
        v => format!("{v:.3}"),
    }
}

/// A number with three significant digits and a metric prefix, to be followed by its unit:
/// `12_400_000.0` as `12.4 M`, `870.0` as `870 `.
pub fn metric(value: f64) -> String {
    let (scaled, prefix) = match value {
        v if v >= 999.5e6 => (v / 1e9, "G"),
        v if v >= 999.5e3 => (v / 1e6, "M"),
        v if v >= 999.5 => (v / 1e3, "k"),
        v => (v, ""),
    };
    format!("{} {prefix}", three_digits(scaled))
}

/// Bytes in powers of 1024, as memory and caches have them, with up to three significant digits:
/// `1536` as `1.5 KiB`, 2^25 as `32 MiB`.
pub fn bytes(value: u64) -> String {
    let (mut scaled, mut unit) = (value as f64, "bytes");
    for larger in ["KiB", "MiB", "GiB", "TiB"] {
        if scaled < 999.5 {
            break;
        }
        (scaled, unit) = (scaled / 1024.0, larger);
    }
    let digits = three_digits(scaled);
    match digits.contains('.') {
        true => format!("{} {unit}", digits.trim_end_matches('0').trim_end_matches('.')),
        false => format!("{digits} {unit}"),
    }
}

/// A duration with three significant digits or, from two minutes on, in minutes and seconds.
pub fn seconds(value: f64) -> String {
    if value >= 119.5 {
        let whole = value.round() as u64;
        format!("{} min {:02} s", count(whole / 60), whole % 60)
    } else if value >= 0.9995 {
        format!("{} s", three_digits(value))
    } else {
        format!("{} ms", three_digits(value * 1e3))
    }
}

/// A duration as a guess deserves it: whole seconds, minutes or hours.
pub fn rough_seconds(value: f64) -> String {
    let whole = value.max(0.0).round() as u64;
    match whole {
        0..120 => format!("{whole} s"),
        120..7200 => format!("{} min", (whole + 30) / 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
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

fn three_digits(value: f64) -> String {
    match value {
        v if v >= 99.95 => format!("{v:.0}"),
        v if v >= 9.995 => format!("{v:.1}"),
        v => format!("{v:.2}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_six_digits_at_most() {
        let cases = [
            (0.0, "0"),
            (-0.5, "-0.5"),
            (1.0 / 3.0, "0.333333"),
            (123_456.7, "123457"),
            (12_345_678.0, "12345678"),
            (999_999.96, "1000000"),
            (1e9, "1e9"),
            (1.5e-7, "1.5e-7"),
            (0.000_123_456_789, "0.000123457"),
            (f64::INFINITY, "∞"),
            (f64::NEG_INFINITY, "-∞"),
            (f64::NAN, "NaN"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn counts_are_counts_of_something() {
        assert_eq!(counted(1, "leaf"), "1 leaf");
        assert_eq!(counted(2, "leaf"), "2 leaves");
        assert_eq!(counted(1_234_567, "triangle"), "1,234,567 triangles");
        assert_eq!(counted(0, "cell"), "0 cells");
    }

    #[test]
    fn figures_have_three_digits() {
        let texts = [0.0123, 1.0, 12.34, 99.97, 123.4, 9996.0, 1_234_567.0, f64::NAN].map(figure);
        assert_eq!(texts, ["0.012", "1.00", "12.3", "100", "123", "10,000", "1,230,000", "–"]);
        let texts = [254.4, 2540.0, 2.38e6, 7.2e9].map(nanoseconds);
        assert_eq!(texts, ["254 ns", "2.54 µs", "2.38 ms", "7.20 s"]);
    }

    #[test]
    fn thousands_are_apart() {
        let texts = [0, 7, 999, 1000, 871_414, 1_000_000].map(count);
        assert_eq!(texts, ["0", "7", "999", "1,000", "871,414", "1,000,000"]);
    }

    #[test]
    fn metric_prefixes_change_where_rounding_does() {
        let texts = [0.0, 870.0, 999.6, 12_400_000.0, 999_600.0, 3.2e9].map(metric);
        assert_eq!(texts, ["0.00 ", "870 ", "1.00 k", "12.4 M", "1.00 M", "3.20 G"]);
    }

    #[test]
    fn bytes_are_told_in_powers_of_1024() {
        let texts = [0, 512, 999, 1000, 1536, 32_768, 1 << 20, 1 << 25, 5_400_000].map(bytes);
        let expected = [
            "0 bytes",
            "512 bytes",
            "999 bytes",
            "0.98 KiB",
            "1.5 KiB",
            "32 KiB",
            "1 MiB",
            "32 MiB",
            "5.15 MiB",
        ];
        assert_eq!(texts, expected);
        assert_eq!([100 << 20, 485_000_000, 3 << 40].map(bytes), ["100 MiB", "463 MiB", "3 TiB"]);
    }

    #[test]
    fn guesses_are_rough() {
        let texts = [0.4, 119.0, 150.0, 7199.0, 7260.0].map(rough_seconds);
        assert_eq!(texts, ["0 s", "119 s", "3 min", "120 min", "2 h 01 min"]);
    }

    #[test]
    fn durations_choose_their_unit() {
        let texts = [0.0123, 0.9999, 1.234, 42.0, 119.0, 119.9, 3725.0].map(seconds);
        assert_eq!(
            texts,
            ["12.3 ms", "1.00 s", "1.23 s", "42.0 s", "119 s", "2 min 00 s", "62 min 05 s"]
        );
    }
}
