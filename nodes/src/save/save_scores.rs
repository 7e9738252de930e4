//! `save_scores`: measured errors side by side as a table; where a study of several set-ups ends.

use crate::values::Scores;
use face_io::csv_line;
use graph_core::cook::{Artifact, FILES};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const SCORES: Port<Scores> =
    Port::new("scores", "what was measured: one line each, under the name of where it comes from");

/// Writes scores as a table (CSV): a line for each, with its name, the overall number, and what it is.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SaveScores {
    /// The file to write, such as `out/scores.csv`.
    path: String,
    /// Whether a column for each channel or marker follows. All scores must then be of the same ones.
    by_name: bool,
}

graph_core::register!(SaveScores);

#[typetag::serde(name = "save_scores")]
impl Node for SaveScores {
    fn card(&self) -> Card {
        Card::new("save").gathers(&SCORES).writes("path")
    }

    fn compute(&self, _: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let scores = inputs.items(&SCORES)?;
        let names: Vec<&String> = match scores.first() {
            Some((_, first)) if self.by_name => first.by_name.iter().map(|(name, _)| name).collect(),
            _ => Vec::new(),
        };
        let head = ["name", "overall", "what"].into_iter().chain(names.iter().map(|name| name.as_str()));
        let mut table = csv_line(head);
        for (item, score) in &scores {
            if self.by_name && !score.by_name.iter().map(|(name, _)| name).eq(names.iter().copied()) {
                let problem =
                    format!("`{item}` was measured by other names than `{}`; set `by_name` to false", scores[0].0);
                return Err(NodeError::input(SCORES.name(), problem));
            }
            let mut line = vec![(*item).to_string(), score.overall.to_string(), score.what.clone()];
            line.extend(score.by_name.iter().take(names.len()).map(|(_, number)| number.to_string()));
            table += &csv_line(line.iter().map(String::as_str));
        }
        Ok(Outputs::default().with(&FILES, Artifact { bytes: table.into_bytes() }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{compute, made};
    use serde_json::json;

    fn table(parameters: serde_json::Value, second: &str) -> Result<String, String> {
        let node: SaveScores = made(parameters);
        let scores = |name: &str, overall: f64| Scores {
            what: "rms, in mm".to_owned(),
            overall,
            by_name: vec![(name.to_owned(), overall * 2.0)],
        };
        let list = [("day_1".to_owned(), scores("jaw", 0.25)), ("day_2".to_owned(), scores(second, 0.5))];
        let outputs = compute(&node, &Inputs::default().with_list(&SCORES, list)).map_err(|error| error.to_string())?;
        Ok(String::from_utf8(outputs.get(&FILES).unwrap().bytes.clone()).unwrap())
    }

    #[test]
    fn each_score_is_a_line() {
        let plain = table(json!({}), "lips").unwrap();
        assert_eq!(plain, "name,overall,what\nday_1,0.25,\"rms, in mm\"\nday_2,0.5,\"rms, in mm\"\n");
        let wide = table(json!({"by_name": true}), "jaw").unwrap();
        assert_eq!(wide, "name,overall,what,jaw\nday_1,0.25,\"rms, in mm\",0.5\nday_2,0.5,\"rms, in mm\",1\n");
    }

    #[test]
    fn scores_of_different_names_do_not_share_columns() {
        let error = table(json!({"by_name": true}), "lips").unwrap_err();
        assert!(error.contains("`day_2`") && error.contains("`by_name`"), "{error}");
    }
}
