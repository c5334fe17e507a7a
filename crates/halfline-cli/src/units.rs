//! Figures as people read them.

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

/// Six significant digits, as much as a person compares by eye, and no more than are needed.
pub fn coordinate(value: f64) -> String {
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

/// Bytes with three significant digits: `5_400_000` as `5.40 MB`.
pub fn bytes(value: u64) -> String {
    format!("{}B", metric(value as f64))
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

/// A bar as long as `share`, 1 being 20 characters, to an eighth of a character.
pub fn bar(share: f64) -> String {
    const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
    let eighths = (share * 160.0).ceil() as usize;
    "█".repeat(eighths / 8) + EIGHTHS[eighths % 8]
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
    fn counts_have_commas() {
        let texts = [0, 7, 999, 1000, 871_414, 1_000_000].map(count);
        assert_eq!(texts, ["0", "7", "999", "1,000", "871,414", "1,000,000"]);
    }

    #[test]
    fn metric_prefixes_change_where_rounding_does() {
        let texts = [0.0, 870.0, 999.6, 12_400_000.0, 999_600.0, 3.2e9].map(metric);
        assert_eq!(texts, ["0.00 ", "870 ", "1.00 k", "12.4 M", "1.00 M", "3.20 G"]);
        assert_eq!(bytes(5_400_000), "5.40 MB");
    }

    #[test]
    fn coordinates_are_short() {
        let texts = [0.0, -0.061, 1234.56789, 4_512_345.678, 2.5e-7, 1e12, -3.0].map(coordinate);
        assert_eq!(texts, ["0", "-0.061", "1234.57", "4512346", "2.5e-7", "1e12", "-3"]);
    }

    #[test]
    fn bars_grow_by_eighths() {
        assert_eq!(bar(1.0), "█".repeat(20));
        assert_eq!((bar(0.0).as_str(), bar(1e-9).as_str(), bar(0.075).as_str()), ("", "▏", "█▌"));
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
