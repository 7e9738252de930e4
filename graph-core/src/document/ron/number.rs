//! Numbers of RON: `12`, `-1_000`, `0x1F`, `.5`, `1.`, `1e-3`, `2.5f64`, `inf`.

use crate::document::Literal;

/// Why a word is no number.
pub(super) struct Fault {
    pub message: String,
    pub help: Option<String>,
}

impl Fault {
    fn new(message: String) -> Self {
        Self { message, help: None }
    }
}

const INTEGER_SUFFIXES: [(&str, i128, i128); 10] = [
    ("i8", i8::MIN as i128, i8::MAX as i128),
    ("u8", 0, u8::MAX as i128),
    ("i16", i16::MIN as i128, i16::MAX as i128),
    ("u16", 0, u16::MAX as i128),
    ("i32", i32::MIN as i128, i32::MAX as i128),
    ("u32", 0, u32::MAX as i128),
    ("i64", i64::MIN as i128, i64::MAX as i128),
    ("u64", 0, u64::MAX as i128),
    ("i128", i128::MIN, i128::MAX),
    ("u128", 0, i128::MAX),
];

/// Whether `word` is meant as a number: it begins like one, or is `inf` or `NaN`.
pub(super) fn is_like(word: &str) -> bool {
    let unsigned = word.strip_prefix(['+', '-']).unwrap_or(word);
    let mut letters = unsigned.chars();
    let first = letters.next();
    first.is_some_and(|c| c.is_ascii_digit())
        || (first == Some('.') && letters.next().is_some_and(|c| c.is_ascii_digit()))
        || unsigned.starts_with("..")
        || is_special(without_float_suffix(unsigned))
}

fn is_special(unsigned: &str) -> bool {
    matches!(unsigned, "inf" | "NaN")
}

fn without_float_suffix(word: &str) -> &str {
    word.strip_suffix("f32").or_else(|| word.strip_suffix("f64")).unwrap_or(word)
}

/// The number that `word` writes.
pub(super) fn read(word: &str) -> Result<Literal, Fault> {
    if let Some(value) = integer(word) {
        return value.map(Literal::Integer);
    }
    if word.contains("..") {
        let fault = Fault::new(format!("`{word}`: ranges have no meaning in a graph"));
        return Err(Fault {
            help: Some("write a string, such as \"1001-1100x2\", or two numbers".to_owned()),
            ..fault
        });
    }
    float(word).map(Literal::Number).ok_or_else(|| {
        let help = Some(format!("if it is meant as text, write \"{word}\""));
        Fault { help, ..Fault::new(format!("`{word}` is not a number")) }
    })
}

/// `None` where `word` has not the form of an integer.
fn integer(word: &str) -> Option<Result<i64, Fault>> {
    let (negative, unsigned) = match word.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, word.strip_prefix('+').unwrap_or(word)),
    };
    let (radix, rest) = match unsigned.get(..2) {
        Some("0x") => (16, &unsigned[2..]),
        Some("0o") => (8, &unsigned[2..]),
        Some("0b") => (2, &unsigned[2..]),
        _ => (10, unsigned),
    };
    let suffix = INTEGER_SUFFIXES.iter().find(|(suffix, ..)| rest.ends_with(suffix));
    let digits = suffix.map_or(rest, |(suffix, ..)| &rest[..rest.len() - suffix.len()]);
    if digits.starts_with('_') || !digits.chars().any(|c| c.is_digit(radix)) {
        return None;
    }
    let digits: String = digits.chars().filter(|c| *c != '_').collect();
    if !digits.chars().all(|c| c.is_digit(radix)) {
        return None;
    }
    let magnitude = i128::from_str_radix(&digits, radix).ok();
    let value = magnitude.map(|magnitude| if negative { -magnitude } else { magnitude });
    let (_, least, most) = suffix.copied().unwrap_or(("", i128::MIN, i128::MAX));
    let too_large = || Fault::new(format!("`{word}` is too large: whole numbers go from {} to {}", i64::MIN, i64::MAX));
    Some(match value {
        Some(value) if !(least..=most).contains(&value) => {
            Err(Fault::new(format!("`{word}` does not fit its suffix, which allows {least} to {most}")))
        }
        Some(value) => i64::try_from(value).map_err(|_| too_large()),
        None => Err(too_large()),
    })
}

fn float(word: &str) -> Option<f64> {
    let number = without_float_suffix(word);
    if is_special(number.strip_prefix(['+', '-']).unwrap_or(number)) {
        return number.parse().ok();
    }
    if !number.chars().all(|c| c.is_ascii_digit() || matches!(c, 'e' | 'E' | '.' | '+' | '-' | '_')) {
        return None;
    }
    // An underscore may stand after a digit or an exponent sign, never first, nor after a point.
    let mut allowed = false;
    let mut plain = String::with_capacity(number.len());
    for c in number.chars() {
        match c {
            '_' if !allowed => return None,
            '_' => continue,
            '.' => allowed = false,
            '+' | '-' => {}
            _ => allowed = true,
        }
        plain.push(c);
    }
    if word.ends_with("f32") { plain.parse::<f32>().ok().map(f64::from) } else { plain.parse().ok() }
}
