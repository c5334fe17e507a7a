//! Numbers as people read them.

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
}
