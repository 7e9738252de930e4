//! Pictures as sixels: six rows of pixels at a time, a colour after the other, as terminals since the VT340 draw them.

use crate::view::Pixels;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Steps of each colour: 6 x 6 x 6 colours in all.
const STEPS: u32 = 6;

/// Thresholds that spread a colour between two steps over four by four pixels (Bayer 1973).
const SPREAD: [[u32; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];

/// The number of the colour that a pixel has.
fn colour([r, g, b]: [u8; 3], x: usize, y: usize) -> u32 {
    let step = |part: u8| (u32::from(part) * (STEPS - 1) * 16 / 255 + SPREAD[y % 4][x % 4]) / 16;
    (step(r) * STEPS + step(g)) * STEPS + step(b)
}

/// The sequence that draws a picture at the cursor.
pub fn encoded(pixels: &Pixels) -> String {
    // No pixel is left as it was; the second 1 to 1 is the shape of a pixel.
    let mut out = format!("\x1bP0;0;0q\"1;1;{};{}", pixels.width, pixels.height);
    // The corner's colour, which is that of the ground, is kept as it is.
    let (ground, corner) = (STEPS.pow(3), pixels.colours.first().copied().unwrap_or_default());
    let [r, g, b] = corner.map(|part| u32::from(part) * 100 / 255);
    let _ = write!(out, "#{ground};2;{r};{g};{b}");
    for index in 0..ground {
        let part = |place: u32| index / STEPS.pow(place) % STEPS * 100 / (STEPS - 1);
        let _ = write!(out, "#{index};2;{};{};{}", part(2), part(1), part(0));
    }
    for top in (0..pixels.height).step_by(6) {
        let mut bands: BTreeMap<u32, Vec<u8>> = BTreeMap::new();
        for y in top..(top + 6).min(pixels.height) {
            for x in 0..pixels.width {
                let own = pixels.colours[y * pixels.width + x];
                let index = if own == corner { ground } else { colour(own, x, y) };
                bands.entry(index).or_insert_with(|| vec![0; pixels.width])[x] |= 1 << (y - top);
            }
        }
        for (index, band) in &bands {
            let _ = write!(out, "#{index}");
            for run in band.chunk_by(|a, b| a == b) {
                let sign = char::from(63 + run[0]);
                let _ = if run.len() > 3 {
                    write!(out, "!{}{sign}", run.len())
                } else {
                    write!(out, "{}", sign.to_string().repeat(run.len()))
                };
            }
            out.push('$');
        }
        out.push('-');
    }
    out + "\x1b\\"
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::layout::Rect;

    /// The colours that a terminal makes of a sequence, in hundredths.
    fn decoded(text: &str, width: usize, height: usize) -> Vec<[u32; 3]> {
        let body = text.strip_prefix("\x1bP0;0;0q").unwrap().strip_suffix("\x1b\\").unwrap();
        let (mut palette, mut out) = (BTreeMap::new(), vec![[999; 3]; width * height]);
        let (mut x, mut top, mut index, mut at) = (0, 0, 0, 0);
        let bytes = body.as_bytes();
        let number = |at: &mut usize| {
            let begin = *at;
            while bytes.get(*at).is_some_and(u8::is_ascii_digit) {
                *at += 1;
            }
            body[begin..*at].parse::<usize>().unwrap()
        };
        while at < bytes.len() {
            at += 1;
            match bytes[at - 1] {
                b'"' => {
                    while matches!(bytes[at], b'0'..=b'9' | b';') {
                        at += 1;
                    }
                }
                b'#' => {
                    index = number(&mut at);
                    if bytes[at] == b';' {
                        let mut parts = [0; 4];
                        for part in &mut parts {
                            at += 1;
                            *part = number(&mut at) as u32;
                        }
                        palette.insert(index, [parts[1], parts[2], parts[3]]);
                    }
                }
                b'$' => x = 0,
                b'-' => (x, top) = (0, top + 6),
                byte => {
                    let (count, byte) = if byte == b'!' {
                        let count = number(&mut at);
                        at += 1;
                        (count, bytes[at - 1])
                    } else {
                        (1, byte)
                    };
                    for _ in 0..count {
                        for row in (0..6).filter(|row| (byte - 63) >> row & 1 == 1) {
                            out[(top + row) * width + x] = palette[&index];
                        }
                        x += 1;
                    }
                }
            }
        }
        out
    }

    #[test]
    fn what_is_encoded_is_drawn_again_within_a_step_and_right_in_the_mean() {
        let (width, height) = (37, 20);
        let colours: Vec<[u8; 3]> =
            (0..width * height).map(|at| [(at % width * 6) as u8, (at / width * 12) as u8, 77]).collect();
        let pixels = Pixels { area: Rect::new(0, 0, 5, 2), width, height, colours };
        let drawn = decoded(&encoded(&pixels), width, height);
        for (drawn, wanted) in drawn.iter().zip(&pixels.colours) {
            for (a, b) in drawn.iter().zip(wanted) {
                assert!((f64::from(*a) - f64::from(*b) / 2.55).abs() <= 20.5, "{drawn:?} {wanted:?}");
            }
        }
        let blue = drawn.iter().map(|colour| f64::from(colour[2])).sum::<f64>() / drawn.len() as f64;
        assert!((blue - 77.0 / 2.55).abs() < 1.5, "{blue}");
    }
}
