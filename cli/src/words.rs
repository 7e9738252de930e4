//! Numbers as people read them.

/// A time: `0.04 s`, `3.2 s`, `2m13s`, `1h02m`.
pub fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match seconds {
        s if s < 0.0095 => format!("{:.1} ms", s.max(0.0) * 1000.0),
        s if s < 0.995 => format!("{s:.2} s"),
        s if s < 59.95 => format!("{s:.1} s"),
        _ if whole < 3600 => format!("{}m{:02}s", whole / 60, whole % 60),
        _ => format!("{}h{:02}m", whole / 3600, whole % 3600 / 60),
    }
}

/// A size: `87 B`, `12.3 KB`, `1.20 GB`, in steps of a thousand.
pub fn size(bytes: u64) -> String {
    const UNITS: [&str; 5] = ["KB", "MB", "GB", "TB", "PB"];
    if bytes < 1000 {
        return format!("{bytes} B");
    }
    let mut amount = bytes as f64 / 1000.0;
    let mut unit = 0;
    // 999.95 would be shown as 1000.
    while amount >= 999.95 && unit + 1 < UNITS.len() {
        amount /= 1000.0;
        unit += 1;
    }
    let digits = if amount < 9.995 { 2 } else { 1 };
    format!("{amount:.digits$} {}", UNITS[unit])
}

/// A size as people write it: `20GB`, `1.5 TiB`, `500M`, `0`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size(pub u64);

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&size(self.0))
    }
}

impl std::str::FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("`{text}` is no size; write a number and a unit, such as 20GB, 500MB, 1.5TiB or 0");
        let split = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
        let (number, unit) = text.split_at(split);
        let number: f64 = number.parse().map_err(|_| wrong())?;
        let bytes = match unit.trim().to_ascii_uppercase().as_str() {
            "" if number == 0.0 => 1.0,
            "B" => 1.0,
            "K" | "KB" => 1e3,
            "M" | "MB" => 1e6,
            "G" | "GB" => 1e9,
            "T" | "TB" => 1e12,
            "KIB" => 1024.0,
            "MIB" => 1024.0 * 1024.0,
            "GIB" => 1024.0 * 1024.0 * 1024.0,
            "TIB" => 1024.0 * 1024.0 * 1024.0 * 1024.0,
            _ => return Err(wrong()),
        };
        let bytes = number * bytes;
        if bytes < 1e18 { Ok(Self(bytes.round() as u64)) } else { Err(wrong()) }
    }
}

/// A number such as a loss, with four digits that count: `0.01230`, `3.142e-5`, `1200`.
pub fn number(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    if !(1e-3..1e6).contains(&magnitude) {
        return format!("{value:.3e}");
    }
    if value.fract() == 0.0 {
        return value.to_string();
    }
    let before = magnitude.log10().floor() as i32 + 1;
    format!("{value:.digits$}", digits = (4 - before).clamp(0, 6) as usize)
}

/// `1 node`, `2 nodes`.
pub fn count(number: usize, what: &str) -> String {
    if number == 1 { format!("1 {what}") } else { format!("{number} {what}s") }
}

/// `text` without control characters, cut to `width` columns of a terminal.
pub fn one_line(text: &str, width: usize) -> String {
    let plain: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    console::truncate_str(&plain, width, "…").into_owned()
}

/// Lines of `text`, each with `indent` before it.
pub fn indented(text: &str, indent: &str) -> String {
    text.lines()
        .map(|line| if line.is_empty() { String::new() } else { format!("{indent}{line}") })
        .collect::<Vec<_>>()
        .join("\n")
}

/// Words of `text` in lines of at most `width` columns; blank lines part paragraphs and stay.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = Vec::new();
    for (number, paragraph) in text.split("\n\n").enumerate() {
        if number > 0 {
            lines.push(String::new());
        }
        let mut line = String::new();
        for word in paragraph.split_whitespace() {
            let long = console::measure_text_width(&line) + 1 + console::measure_text_width(word);
            if !line.is_empty() && long > width {
                lines.push(std::mem::take(&mut line));
            }
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
        lines.push(line);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::{Size, count, duration, number, one_line, size, wrapped};

    #[test]
    fn times() {
        let shown = [0.000_21, 0.0421, 0.9949, 0.999, 3.24, 59.96, 133.0, 3599.6, 3720.0].map(duration);
        assert_eq!(shown, ["0.2 ms", "0.04 s", "0.99 s", "1.0 s", "3.2 s", "1m00s", "2m13s", "1h00m", "1h02m"]);
    }

    #[test]
    fn sizes() {
        let shown = [0, 999, 1000, 12_345, 999_949, 999_950, 1_200_000_000].map(size);
        assert_eq!(shown, ["0 B", "999 B", "1.00 KB", "12.3 KB", "999.9 KB", "1.00 MB", "1.20 GB"]);
    }

    #[test]
    fn sizes_are_read() {
        let read = |text: &str| text.parse::<Size>().ok().map(|size| size.0);
        assert_eq!(read("20GB"), Some(20_000_000_000));
        assert_eq!(read("1.5 TiB"), Some(1_649_267_441_664));
        assert_eq!(
            (read("500m"), read("12B"), read("0"), read("0.5k")),
            (Some(500_000_000), Some(12), Some(0), Some(500))
        );
        for wrong in ["", "GB", "20", "-1GB", "2 apples", "1.2.3MB", "1e3KB", "9999999TB"] {
            assert_eq!(read(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn numbers() {
        let shown = [0.0, 0.0123, 3.1416e-5, 1200.0, -12.3456, 99.999_99, f64::NAN].map(number);
        assert_eq!(shown, ["0", "0.01230", "3.142e-5", "1200", "-12.35", "100.00", "NaN"]);
        assert_eq!([count(0, "file"), count(1, "file"), count(2, "file")], ["0 files", "1 file", "2 files"]);
    }

    #[test]
    fn lines_keep_to_their_width() {
        assert_eq!(one_line("a\nlong line", 6), "a lon…");
        assert_eq!(wrapped("one two three\nfour\n\nfive", 9), ["one two", "three", "four", "", "five"]);
    }
}
