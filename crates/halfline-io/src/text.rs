//! Numbers and words in text files.

/// A word of a file for an error message: short, on one line, and printable.
pub fn excerpt(word: &[u8]) -> String {
    const MOST_CHARACTERS: usize = 40;
    let shown = &word[..word.len().min(4 * MOST_CHARACTERS)];
    let text = String::from_utf8_lossy(shown);
    let mut characters = text.chars().flat_map(char::escape_debug);
    let mut result: String = characters.by_ref().take(MOST_CHARACTERS).collect();
    if characters.next().is_some() {
        result.push_str("...");
    }
    result
}

/// The number that `word` is, rounded to the nearest of double precision. NaN and the infinities
/// are numbers in all the spellings that C libraries print.
pub fn parse_f64(word: &[u8]) -> Option<f64> {
    fast_float2::parse(word).ok().or_else(|| parse_microsoft(word))
}

/// [`parse_f64`], rounded once to single precision.
pub fn parse_f32(word: &[u8]) -> Option<f32> {
    fast_float2::parse(word).ok().or_else(|| parse_microsoft(word).map(|value| value as f32))
}

/// What Microsoft's C library prints for values that are not finite: `-1.#IND`, `1.#INF`,
/// `-nan(ind)`.
#[cold]
fn parse_microsoft(word: &[u8]) -> Option<f64> {
    let (negative, magnitude) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    let lower = magnitude.to_ascii_lowercase();
    if lower.starts_with(b"1.#inf") {
        return Some(if negative { f64::NEG_INFINITY } else { f64::INFINITY });
    }
    let is_nan = [&b"1.#ind"[..], b"1.#qnan", b"1.#snan"].iter().any(|s| lower.starts_with(s))
        || (lower.starts_with(b"nan(") && lower.ends_with(b")"));
    is_nan.then_some(f64::NAN)
}

/// The whole number that `word` is.
#[inline]
pub fn parse_integer(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    // Eighteen digits cannot overflow, and nothing that can be stored needs more.
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0_i64;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value * 10 + i64::from(digit - b'0');
    }
    Some(if negative { -value } else { value })
}

/// True if single precision reproduces every digit of the decimal number `word`, whose value is
/// `value`: if the nearest `f32` is no further off than half a unit of the last digit. Numbers
/// that were printed from single precision pass, whatever the number of their digits.
pub fn single_precision_reproduces(word: &[u8], value: f64) -> bool {
    if !value.is_finite() {
        return true;
    }
    let error = (f64::from(value as f32) - value).abs();
    if error == 0.0 {
        return true;
    }
    let mantissa_end = word.iter().position(|b| matches!(b, b'e' | b'E')).unwrap_or(word.len());
    let (mantissa, exponent) = word.split_at(mantissa_end);
    let exponent = exponent.get(1..).and_then(parse_integer).unwrap_or(0);
    let decimals =
        mantissa.iter().position(|&b| b == b'.').map_or(0, |dot| mantissa.len() - dot - 1);
    let last_digit = exponent.clamp(-400, 400) as i32 - i32::try_from(decimals).unwrap_or(400);
    error <= 0.5 * 10_f64.powi(last_digit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_all_spellings() {
        for (word, value) in [
            ("1", 1.0),
            ("+1.5", 1.5),
            ("-.5e-3", -0.0005),
            ("1.", 1.0),
            ("1E3", 1000.0),
            ("inf", f64::INFINITY),
            ("-Infinity", f64::NEG_INFINITY),
            ("-1.#INF00", f64::NEG_INFINITY),
        ] {
            assert_eq!(parse_f64(word.as_bytes()), Some(value), "{word}");
            assert_eq!(parse_f32(word.as_bytes()), Some(value as f32), "{word}");
        }
        for word in ["nan", "-nan", "NaN", "-nan(ind)", "1.#QNAN", "-1.#IND"] {
            assert!(parse_f64(word.as_bytes()).is_some_and(f64::is_nan), "{word}");
            assert!(parse_f32(word.as_bytes()).is_some_and(f32::is_nan), "{word}");
        }
        for word in ["", "-", "x", "1x", "1,5", "0x10", "--1", "1e", "nanx", "1.#", "e5", "."] {
            assert_eq!(parse_f64(word.as_bytes()), None, "{word}");
        }
    }

    #[test]
    fn whole_numbers() {
        assert_eq!(parse_integer(b"0042"), Some(42));
        assert_eq!(parse_integer(b"-1"), Some(-1));
        assert_eq!(parse_integer(b"+7"), Some(7));
        for word in ["", "-", "1.0", "1e2", "9999999999999999999", "a"] {
            assert_eq!(parse_integer(word.as_bytes()), None, "{word}");
        }
    }

    #[test]
    fn digits_beyond_single_precision_are_noticed() {
        for (word, single) in [
            ("0.1", true),
            ("0.100000001490116", true),
            ("1.0000001", true),
            ("16777217", false),
            ("412345.678", false),
            ("412345.67", false),
            ("412345.69", true),
            ("4.12345678e5", false),
            ("4.1234569e+05", true),
            ("1e39", false),
            ("nan", true),
        ] {
            let value = parse_f64(word.as_bytes()).unwrap();
            assert_eq!(single_precision_reproduces(word.as_bytes(), value), single, "{word}");
        }
    }

    #[test]
    fn excerpts_are_short_and_printable() {
        assert_eq!(excerpt(b"a\n\xffb"), "a\\n\u{fffd}b");
        assert_eq!(excerpt(&[b'x'; 1000]), format!("{}...", "x".repeat(40)));
    }
}
