//! Lines in a frame with axes.

use crate::escaped;
use std::fmt::Write;

/// A line.
#[derive(Debug, Clone)]
pub struct Line {
    /// What the legend calls it.
    pub name: String,
    /// x and y, in the order of x; where y is NaN, the line has a gap.
    pub points: Vec<(f64, f64)>,
    /// Whether each point has a dot.
    pub dots: bool,
}

/// A plot.
#[derive(Debug, Clone)]
pub struct Plot {
    /// What stands above it.
    pub title: String,
    /// What stands below.
    pub x_label: String,
    /// What stands beside.
    pub y_label: String,
    /// Whether the vertical axis begins at 0.
    pub from_zero: bool,
    /// Width of the picture.
    pub width_px: f64,
    /// Height of the picture.
    pub height_px: f64,
    /// The lines.
    pub lines: Vec<Line>,
}

/// What a plot is drawn with, beside the colours of its lines.
#[derive(Debug, Clone, Copy)]
pub struct Ink {
    /// What it is drawn on; nothing where that is a page of its own colour.
    pub ground: Option<&'static str>,
    /// Text, frame and ticks.
    pub text: &'static str,
    /// How strong the lines of ticks are.
    pub grid_opacity: f64,
}

impl Ink {
    /// For a file of its own: on white.
    pub const PAPER: Self = Self { ground: Some("#ffffff"), text: "#222222", grid_opacity: 0.15 };
    /// For a page that may be light or dark: in the colour of its text.
    pub const PAGE: Self = Self { ground: None, text: "currentColor", grid_opacity: 0.2 };

    /// The beginning of a picture, which says what it is to those who do not see it.
    pub(crate) fn open(&self, title: &str, width_px: f64, height_px: f64) -> String {
        let title = escaped(title);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width_px}\" height=\"{height_px}\" \
             viewBox=\"0 0 {width_px} {height_px}\" role=\"img\" aria-label=\"{title}\" font-family=\"sans-serif\" \
             font-size=\"13\">\n"
        );
        if let Some(ground) = self.ground {
            let _ = writeln!(svg, "<rect width=\"{width_px}\" height=\"{height_px}\" fill=\"{ground}\"/>");
        }
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"22\" text-anchor=\"middle\" font-weight=\"bold\" font-size=\"15\" fill=\"{}\">{title}</text>",
            width_px / 2.0,
            self.text
        );
        svg
    }
}

/// Colours that people of any colour vision tell apart (Okabe and Ito 2008); yellow is left out as too pale on white, black as too
/// dark on black.
const COLOURS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"];

/// Pixels between the frame and the edges of the picture: left, right, top, bottom.
const MARGINS: [f64; 4] = [72.0, 20.0, 44.0, 56.0];

/// Height of a line of the legend.
const LEGEND_LINE_PX: f64 = 18.0;

/// An axis: the range that it shows, and where its ticks are.
struct Axis {
    low: f64,
    high: f64,
    step: f64,
}

impl Axis {
    /// About `count` ticks at 1, 2 or 5 times a power of ten, at least `least` apart; the range ends at ticks where `whole`.
    fn new(low: f64, high: f64, count: f64, least: f64, whole: bool) -> Self {
        let span = if high > low { high - low } else { low.abs().max(1.0) };
        let rough = (span / count).max(least);
        let power = 10.0_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|step| *step >= rough * 0.999);
        let step = step.unwrap_or(10.0 * power);
        let high = if high > low { high } else { low + span };
        if whole {
            Self { low: (low / step).floor() * step, high: (high / step - 1e-9).ceil() * step, step }
        } else {
            Self { low, high, step }
        }
    }

    fn ticks(&self) -> impl Iterator<Item = f64> + '_ {
        let first = (self.low / self.step - 1e-9).ceil() as i64;
        let last = (self.high / self.step + 1e-9).floor() as i64;
        (first..=last).map(|tick| tick as f64 * self.step)
    }

    /// Where `value` lies, 0 at the low end and 1 at the high one.
    fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    fn text(&self, value: f64) -> String {
        let decimals = (-(self.step.log10() + 1e-9).floor()).clamp(0.0, 9.0) as usize;
        format!("{value:.decimals$}")
    }
}

/// The plot as SVG.
pub fn draw(plot: &Plot, ink: &Ink) -> String {
    let drawn = || plot.lines.iter().flat_map(|line| &line.points).filter(|(x, y)| x.is_finite() && y.is_finite());
    let range = |of: fn(&(f64, f64)) -> f64| {
        drawn().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
    };
    let [left, right, top, bottom] = MARGINS;
    let legend = if plot.lines.len() > 1 {
        LEGEND_LINE_PX * plot.lines.len().div_ceil(legend_columns(plot)) as f64
    } else {
        0.0
    };
    let top = top + legend;
    let (width, height) = ((plot.width_px - left - right).max(1.0), (plot.height_px - top - bottom).max(1.0));
    let ((x_low, x_high), (y_low, y_high)) = (range(|point| point.0), range(|point| point.1));
    // Between frames there is nothing to mark.
    let least = if drawn().all(|(x, _)| x.fract() == 0.0) { 1.0 } else { 0.0 };
    let x_axis = Axis::new(x_low, x_high, (width / 90.0).max(2.0), least, false);
    let y_axis =
        Axis::new(if plot.from_zero { y_low.min(0.0) } else { y_low }, y_high, (height / 50.0).max(2.0), 0.0, true);
    let x_at = |x: f64| left + width * x_axis.share(x);
    let y_at = |y: f64| top + height * (1.0 - y_axis.share(y));

    let mut svg = ink.open(&plot.title, plot.width_px, plot.height_px);
    let (ink_text, grid) = (ink.text, ink.grid_opacity);
    for tick in y_axis.ticks() {
        let y = y_at(tick);
        let end = left + width;
        let _ =
            writeln!(svg, "<path d=\"M{left:.1} {y:.1}H{end:.1}\" stroke=\"{ink_text}\" stroke-opacity=\"{grid}\"/>");
        text((&mut svg, ink), (left - 8.0, y + 4.5), "end", &y_axis.text(tick));
    }
    for tick in x_axis.ticks() {
        let (x, base) = (x_at(tick), top + height);
        let _ = writeln!(svg, "<path d=\"M{x:.1} {base:.1}v5\" stroke=\"{ink_text}\"/>");
        text((&mut svg, ink), (x, base + 20.0), "middle", &x_axis.text(tick));
    }
    let _ = writeln!(
        svg,
        "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"none\" stroke=\"{ink_text}\"/>"
    );
    for (index, line) in plot.lines.iter().enumerate() {
        let colour = COLOURS[index % COLOURS.len()];
        let dash = if index < COLOURS.len() { "" } else { " stroke-dasharray=\"6 4\"" };
        for run in line.points.split(|(x, y)| !(x.is_finite() && y.is_finite())).filter(|run| !run.is_empty()) {
            let points: Vec<String> = run.iter().map(|(x, y)| format!("{:.1},{:.1}", x_at(*x), y_at(*y))).collect();
            let points = points.join(" ");
            let _ = writeln!(
                svg,
                "<polyline points=\"{points}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\" \
                 stroke-linejoin=\"round\"{dash}/>"
            );
            for (x, y) in run.iter().filter(|_| line.dots) {
                let _ =
                    writeln!(svg, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"{colour}\"/>", x_at(*x), y_at(*y));
            }
        }
        if plot.lines.len() > 1 {
            let columns = legend_columns(plot);
            let x = left + width / columns as f64 * (index % columns) as f64;
            let y = MARGINS[2] + LEGEND_LINE_PX * (index / columns) as f64;
            let _ = writeln!(svg, "<path d=\"M{x:.1} {y:.1}h22\" stroke=\"{colour}\" stroke-width=\"3\"{dash}/>");
            text((&mut svg, ink), (x + 28.0, y + 4.5), "start", &line.name);
        }
    }
    let middle = left + width / 2.0;
    text((&mut svg, ink), (middle, plot.height_px - 12.0), "middle", &plot.x_label);
    let beside = top + height / 2.0;
    let _ = write!(svg, "<g transform=\"translate(18 {beside:.1}) rotate(-90)\">");
    text((&mut svg, ink), (0.0, 0.0), "middle", &plot.y_label);
    svg += "</g>\n</svg>\n";
    svg
}

/// How many names of the legend stand beside each other.
fn legend_columns(plot: &Plot) -> usize {
    let longest = plot.lines.iter().map(|line| line.name.chars().count()).max().unwrap_or(0);
    let each = 48.0 + 7.5 * longest as f64;
    (((plot.width_px - MARGINS[0] - MARGINS[1]) / each) as usize).clamp(1, plot.lines.len().max(1))
}

/// Text at a place, with what SVG reads as its own replaced.
fn text((svg, ink): (&mut String, &Ink), (x, y): (f64, f64), anchor: &str, text: &str) {
    let _ = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{}\">{}</text>",
        ink.text,
        escaped(text)
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        for (low, high, count, expected) in [
            (0.0, 0.37, 5.0, vec!["0.0", "0.1", "0.2", "0.3", "0.4"]),
            (0.0, 1846.0, 9.0, vec!["0", "500", "1000", "1500", "2000"]),
            (3.0, 3.0, 4.0, vec!["3", "4", "5", "6"]),
        ] {
            let axis = Axis::new(low, high, count, 0.0, true);
            assert_eq!(axis.ticks().map(|tick| axis.text(tick)).collect::<Vec<_>>(), expected, "{low} to {high}");
        }
        let axis = Axis::new(101.0, 190.0, 5.0, 0.0, false);
        assert_eq!(axis.ticks().collect::<Vec<_>>(), [120.0, 140.0, 160.0, 180.0]);
    }
}
