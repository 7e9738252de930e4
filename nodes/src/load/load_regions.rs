//! `load_regions`: which markers and channels belong together, from a file: what networks are trained by.

use crate::selection::{Mapping, Selection};
use face_io::regions;
use face_math::data::Regions;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

const REGIONS: Port<Regions> =
    Port::new("regions", "regions of the face in the order of the file, each with its markers and its channels");

/// Loads regions from JSON or RON.
///
/// The file is a map from the name of each region to its markers and channels:
/// `{"lips": {"markers": ["lip_1", "chin"], "channels": ["mouthPucker"]}}`.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LoadRegions {
    /// The file, or a pattern of files, which gives one item for each file that it fits.
    path: String,
    /// Names of regions to keep, as patterns: `{jaw,lips}`. Keeps all where empty.
    only: Vec<String>,
    /// Names of regions to leave out, as patterns: `eye*`.
    without: Vec<String>,
}

graph_core::register!(LoadRegions);

#[typetag::serde(name = "load_regions")]
impl Node for LoadRegions {
    fn card(&self) -> Card {
        Card::new("load").reads("path").gives(&REGIONS)
    }

    fn compute(&self, context: &Context<'_>, _: &Inputs) -> Result<Outputs, NodeError> {
        let source = context.source()?;
        let file = source.name.as_str();
        let all = regions::read(&source.bytes).map_err(|error| NodeError::file(file, error))?.regions;
        let names: Vec<String> = all.iter().map(|region| region.name.clone()).collect();
        let rename = BTreeMap::new();
        let selection = Selection {
            what: "region",
            only: &self.only,
            without: &self.without,
            rename: &rename,
            mapping: Mapping::default(),
        };
        let regions: Vec<_> =
            selection.apply(file, &names)?.kept.into_iter().map(|(index, _)| all[index].clone()).collect();
        for region in &regions {
            let lacks = if region.markers.is_empty() { "markers" } else { "channels" };
            if region.markers.is_empty() || region.channels.is_empty() {
                let problem =
                    format!("region `{}` has no {lacks}; name some, or leave it out (`without`)", region.name);
                return Err(NodeError::file(file, problem));
            }
        }
        Ok(Outputs::default().with(&REGIONS, Regions { regions }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Bench, made, test_data};
    use serde_json::json;

    const FILE: &str = r#"{
        "lips": {"markers": ["lip_1"], "channels": ["mouthPucker"]},
        "jaw": {"markers": ["chin"], "channels": ["jawOpen"]},
        "bare": {"markers": ["chin"], "channels": []}
    }"#;

    fn load(parameters: serde_json::Value, bytes: &[u8]) -> Result<Vec<String>, String> {
        let node: LoadRegions = made(parameters);
        let outputs = Bench::default().with_source("regions.json", bytes).compute(&node, &Inputs::default());
        let names = |regions: &Regions| regions.regions.iter().map(|region| region.name.clone()).collect();
        outputs.map(|outputs| names(outputs.get(&REGIONS).unwrap())).map_err(|error| error.to_string())
    }

    #[test]
    fn regions_keep_the_order_of_the_file() {
        assert_eq!(load(json!({"without": ["b*"]}), FILE.as_bytes()).unwrap(), ["lips", "jaw"]);
        assert_eq!(load(json!({"only": ["jaw"]}), FILE.as_bytes()).unwrap(), ["jaw"]);
    }

    #[test]
    fn mistakes_name_the_file() {
        let error = load(json!({}), FILE.as_bytes()).unwrap_err();
        assert!(error.starts_with("regions.json: region `bare` has no channels"), "{error}");
        let error = load(json!({"only": ["lip"]}), FILE.as_bytes()).unwrap_err();
        assert!(error.contains("did you mean `lips`?"), "{error}");
        assert!(load(json!({}), b"{").unwrap_err().starts_with("regions.json: "));
    }

    #[test]
    fn a_real_file_is_read() {
        let Some(path) = test_data("actors/regions.json") else { return };
        assert_eq!(load(json!({}), &std::fs::read(path).unwrap()).unwrap().len(), 7);
    }
}
