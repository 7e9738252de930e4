//! `measure_curves`: one number of each curve: its mean, its size, or how it goes with another one; for tables.

use crate::patterns::Patterns;
use crate::values::Scores;
use face_math::data::Curves;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const CURVES: Port<Curves> = Port::new("curves", "any curves; frames in which one is missing (NaN) are passed over");
const OTHER: Port<Curves> =
    Port::new("other", "what they are correlated with: the channel of the same name, or its only channel");
const SCORES: Port<Scores> = Port::new("scores", "one number of each chosen channel; overall, their mean");

/// Measures curves over all their frames.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MeasureCurves {
    /// What is measured.
    statistic: Statistic,
    /// The channels, as patterns. All where empty.
    channels: Vec<String>,
}

/// What is measured of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Statistic {
    /// The mean.
    #[default]
    Mean,
    /// The root mean square.
    RootMeanSquare,
    /// Pearson's correlation with `other`: 1 where the two rise and fall as one, −1 where against each other.
    Correlation,
}

graph_core::register!(MeasureCurves);

#[typetag::serde(name = "measure_curves")]
impl Node for MeasureCurves {
    fn card(&self) -> Card {
        Card::new("solve").takes(&CURVES).may_take(&OTHER).gives(&SCORES)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let curves = inputs.get(&CURVES)?;
        let chosen = Patterns { parameter: "channels", what: "channel", names: curves.channels() };
        let other = inputs.may_get(&OTHER)?;
        let mut by_name = Vec::new();
        for name in chosen.chosen(&self.channels)? {
            let own = column(curves, &name);
            let number = match self.statistic {
                Statistic::Mean => mean(&own, |value| value),
                Statistic::RootMeanSquare => mean(&own, |value| value * value).map(f64::sqrt),
                Statistic::Correlation => correlation(&own, &partner(curves, &name, other)?),
            };
            let number = number.ok_or_else(|| {
                let problem = format!("channel `{name}` has no value, or never changes; there is nothing to measure");
                NodeError::input(CURVES.name(), problem)
            })?;
            by_name.push((name, number));
        }
        let what = match self.statistic {
            Statistic::Mean => "mean",
            Statistic::RootMeanSquare => "root mean square",
            Statistic::Correlation => "correlation",
        };
        let overall = by_name.iter().map(|(_, number)| number).sum::<f64>() / by_name.len() as f64;
        Ok(Outputs::default().with(&SCORES, Scores { what: what.to_owned(), overall, by_name }))
    }
}

fn column(curves: &Curves, name: &str) -> Vec<f64> {
    let column = curves.index(name);
    column.map_or(Vec::new(), |column| (0..curves.frames()).map(|t| f64::from(curves.frame(t)[column])).collect())
}

/// What the channel `name` of `curves` is correlated with.
fn partner(curves: &Curves, name: &str, other: Option<&Curves>) -> Result<Vec<f64>, NodeError> {
    let refuse = |problem: String| Err(NodeError::input(OTHER.name(), problem));
    let Some(other) = other else {
        return refuse("a correlation is with other curves; connect them".to_owned());
    };
    curves.frame_axis().matches(&other.frame_axis()).map_err(|error| NodeError::input(OTHER.name(), error))?;
    match (other.index(name), other.channels()) {
        (Some(_), _) => Ok(column(other, name)),
        (None, [only]) => Ok(column(other, only)),
        (None, _) => refuse(format!("has no channel `{name}`, and more than one other; choose with `channels`")),
    }
}

/// The mean of what there is.
fn mean(values: &[f64], of: impl Fn(f64) -> f64) -> Option<f64> {
    let seen: Vec<f64> = values.iter().filter(|value| value.is_finite()).map(|value| of(*value)).collect();
    (!seen.is_empty()).then(|| seen.iter().sum::<f64>() / seen.len() as f64)
}

/// r = Σ (a − ā)(b − b̄) / √(Σ (a − ā)² Σ (b − b̄)²) over the frames in which both are there (Pearson 1895).
fn correlation(a: &[f64], b: &[f64]) -> Option<f64> {
    let pairs: Vec<(f64, f64)> =
        a.iter().zip(b).map(|(a, b)| (*a, *b)).filter(|(a, b)| a.is_finite() && b.is_finite()).collect();
    let count = pairs.len() as f64;
    let (mean_a, mean_b) =
        (pairs.iter().map(|(a, _)| a).sum::<f64>() / count, pairs.iter().map(|(_, b)| b).sum::<f64>() / count);
    let sum = |of: fn(f64, f64) -> f64| pairs.iter().map(|(a, b)| of(a - mean_a, b - mean_b)).sum::<f64>();
    let r = sum(|a, b| a * b) / (sum(|a, _| a * a) * sum(|_, b| b * b)).sqrt();
    r.is_finite().then_some(r)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{compute, made};
    use serde_json::json;
    use wire::FrameAxis;

    fn curves(channels: &[&str], values: Vec<f32>) -> Curves {
        let axis = FrameAxis::new(values.len() / channels.len(), 60.0);
        Curves::new(axis, channels.iter().map(|channel| (*channel).to_owned()).collect(), values).unwrap()
    }

    fn measure(parameters: serde_json::Value, own: Curves, other: Option<Curves>) -> Result<Scores, String> {
        let inputs = Inputs::default().with(&CURVES, own);
        let inputs = match other {
            Some(other) => inputs.with(&OTHER, other),
            None => inputs,
        };
        let outputs = compute(&made::<MeasureCurves>(parameters), &inputs).map_err(|error| error.to_string())?;
        Ok(outputs.get(&SCORES).unwrap().clone())
    }

    #[test]
    fn means_and_sizes_pass_over_what_is_missing() {
        let own = curves(&["a", "b"], vec![3.0, 1.0, f32::NAN, 1.0, -4.0, 1.0]);
        let mean = measure(json!({"channels": ["a"]}), own.clone(), None).unwrap();
        assert_eq!((mean.overall, mean.by_name.len()), (-0.5, 1));
        let size = measure(json!({"statistic": "root_mean_square", "channels": ["a"]}), own, None).unwrap();
        assert!((size.overall - 12.5_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_rises_together_correlates() {
        let own = curves(&["open", "wide"], vec![0.0, 1.0, 0.5, 0.5, 1.0, 0.0, 0.2, 0.8]);
        let distance = curves(&["distance_mm"], vec![20.0, 30.0, 40.0, 24.0]);
        let with = json!({"statistic": "correlation"});
        let found = measure(with.clone(), own.clone(), Some(distance)).unwrap();
        assert!((found.by_name[0].1 - 1.0).abs() < 1e-6 && (found.by_name[1].1 + 1.0).abs() < 1e-6, "{found:?}");
        assert!(measure(with.clone(), own.clone(), None).unwrap_err().contains("`other`"));
        let flat = curves(&["x"], vec![1.0; 4]);
        assert!(measure(with, own, Some(flat)).unwrap_err().contains("never changes"));
    }
}
