//! `save_plot`: curves over their frames, or scores over a number, as a plot; what a study is looked at by.

use crate::patterns::Patterns;
use crate::values::Scores;
use face_math::data::Curves;
use graph_core::cook::{Artifact, FILES};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use plot::{Ink, Line, Plot, draw};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

const CURVES: Port<Curves> =
    Port::new("curves", "curves over frames: a line for each channel of each; gaps (NaN) stay gaps");
const SCORES: Port<Scores> = Port::new(
    "scores",
    "scores over the numbers that `x` gives them: a point each, and a line through those of one item (`score/ITEM`)",
);

/// Draws lines into a plot and writes it as SVG, which browsers and word processors show.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SavePlot {
    /// The file to write, such as `out/error.svg`.
    path: String,
    /// What stands above the plot.
    title: String,
    /// What stands below, with its unit. `frame` where empty and curves are drawn.
    x_label: String,
    /// What stands beside, with its unit.
    y_label: String,
    /// Channels of the curves to draw, as patterns. All where empty.
    channels: Vec<String>,
    /// Where each score stands on the horizontal axis, by its name or a pattern of it: `{"half.*": 0.5}`.
    x: BTreeMap<String, f64>,
    /// What lines are called, by their names or patterns of them: `{"raw.*": "raw solve"}`.
    names: BTreeMap<String, String>,
    /// Whether the vertical axis begins at 0.
    from_zero: bool,
    /// Width of the picture.
    #[schemars(range(min = 200, max = 10_000))]
    width_px: u32,
    /// Height of the picture.
    #[schemars(range(min = 150, max = 10_000))]
    height_px: u32,
}

impl Default for SavePlot {
    fn default() -> Self {
        Self {
            path: String::new(),
            title: String::new(),
            x_label: String::new(),
            y_label: String::new(),
            channels: Vec::new(),
            x: BTreeMap::new(),
            names: BTreeMap::new(),
            from_zero: true,
            width_px: 960,
            height_px: 480,
        }
    }
}

graph_core::register!(SavePlot);

#[typetag::serde(name = "save_plot")]
impl Node for SavePlot {
    fn card(&self) -> Card {
        Card::new("save").may_gather(&CURVES).may_gather(&SCORES).writes("path").version(2)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let curves = inputs.items(&CURVES)?;
        let mut lines = self.of_curves(&curves)?;
        lines.extend(self.of_scores(&inputs.items(&SCORES)?)?);
        if !lines.iter().any(|line| line.points.iter().any(|(_, y)| y.is_finite())) {
            return Err(NodeError::failed("there is nothing to draw; connect `curves` or `scores`"));
        }
        let x_label = if self.x_label.is_empty() && !curves.is_empty() { "frame" } else { &self.x_label };
        let plot = Plot {
            title: self.title.clone(),
            x_label: x_label.to_owned(),
            y_label: self.y_label.clone(),
            from_zero: self.from_zero,
            width_px: f64::from(self.width_px),
            height_px: f64::from(self.height_px),
            lines,
        };
        Ok(Outputs::default().with(&FILES, Artifact { bytes: draw(&plot, &Ink::PAPER).into_bytes() }))
    }
}

impl SavePlot {
    fn of_curves(&self, all: &[(&str, &Curves)]) -> Result<Vec<Line>, NodeError> {
        let mut found = Vec::new();
        for (item, curves) in all {
            let patterns = Patterns { parameter: "channels", what: "channel", names: curves.channels() };
            let chosen = patterns.chosen(&self.channels)?;
            for channel in &chosen {
                let Some(column) = curves.index(channel) else { continue };
                let name = if all.len() > 1 && chosen.len() == 1 {
                    (*item).to_owned()
                } else {
                    [*item, channel.as_str()].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
                };
                let point = |t: usize| {
                    let number = crate::rig::frame_number(curves.frame_axis(), t);
                    (number as f64, f64::from(curves.frame(t)[column]))
                };
                found.push(Line { name, points: (0..curves.frames()).map(point).collect(), dots: false });
            }
        }
        self.named(found)
    }

    fn of_scores(&self, all: &[(&str, &Scores)]) -> Result<Vec<Line>, NodeError> {
        let names: Vec<String> = all.iter().map(|(name, _)| (*name).to_owned()).collect();
        if names.is_empty() {
            return Ok(Vec::new());
        }
        let places = Patterns { parameter: "x", what: "score", names: &names }.numbers(&self.x)?;
        let mut lines: BTreeMap<String, Vec<(f64, f64)>> = BTreeMap::new();
        for ((name, score), place) in all.iter().zip(places) {
            let Some(place) = place else {
                let problem = format!("score `{name}` has no place on the horizontal axis; give it one");
                return Err(NodeError::parameter("x", problem));
            };
            let line = name.rsplit_once('/').map_or("", |(_, item)| item);
            lines.entry(line.to_owned()).or_default().push((place, score.overall));
        }
        for points in lines.values_mut() {
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        self.named(lines.into_iter().map(|(name, points)| Line { name, points, dots: true }).collect())
    }

    /// Lines under the names that `names` gives them.
    fn named(&self, mut lines: Vec<Line>) -> Result<Vec<Line>, NodeError> {
        for line in &mut lines {
            let own = line.name.clone();
            // The longest pattern that fits; of equally long ones the first.
            let mut longest = 0;
            for (pattern, new) in &self.names {
                let only = std::slice::from_ref(&own);
                let patterns = Patterns { parameter: "names", what: "line", names: only };
                let fits = patterns.may_fit(std::slice::from_ref(pattern))?.contains(&true);
                let length = if *pattern == own { usize::MAX } else { pattern.chars().count() };
                if fits && length > longest {
                    longest = length;
                    line.name.clone_from(new);
                }
            }
        }
        Ok(lines)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{compute, made};
    use serde_json::json;
    use wire::FrameAxis;

    fn curves(values: Vec<f32>) -> Curves {
        Curves::new(FrameAxis { first: 101, count: values.len(), rate_hz: 60.0 }, vec!["rms_mm".into()], values)
            .unwrap()
    }

    fn plot(parameters: serde_json::Value, inputs: &Inputs) -> Result<String, String> {
        let outputs = compute(&made::<SavePlot>(parameters), inputs).map_err(|error| error.to_string())?;
        Ok(String::from_utf8(outputs.get(&FILES).unwrap().bytes.clone()).unwrap())
    }

    #[test]
    fn each_curve_is_a_line_under_its_name() {
        let list = [("fine.error", vec![0.1, f32::NAN, 0.2]), ("raw.error", vec![0.3, 0.4, 0.5])];
        let list = list.map(|(name, values)| (name.to_owned(), curves(values)));
        let with = json!({"title": "a < b", "y_label": "mm", "names": {"raw*": "raw solve"}});
        let svg = plot(with, &Inputs::default().with_list(&CURVES, list)).unwrap();
        for part in ["a &lt; b", ">mm<", ">frame<", ">raw solve<", ">fine.error<", ">101<"] {
            assert!(svg.contains(part), "{part}: {svg}");
        }
        // The gap cuts the first line in two.
        assert_eq!(svg.matches("<polyline").count(), 3);
    }

    #[test]
    fn scores_stand_over_their_numbers() {
        let score = |overall| Scores { what: String::new(), overall, by_name: Vec::new() };
        let list = [("full.s/a", 0.2), ("half.s/a", 0.3), ("full.s/b", 0.4)];
        let inputs = Inputs::default().with_list(&SCORES, list.map(|(name, number)| (name.to_owned(), score(number))));
        let svg = plot(json!({"x": {"full.*": 1.0, "half.*": 0.5}}), &inputs).unwrap();
        assert_eq!((svg.matches("<circle").count(), svg.matches("<polyline").count()), (3, 2));
        assert!(plot(json!({"x": {"full.*": 1.0}}), &inputs).unwrap_err().contains("`half.s/a`"));
        assert!(plot(json!({}), &Inputs::default()).unwrap_err().contains("nothing to draw"));
    }
}
