//! `grimace config explain`: each setting, its value, and what set it.

use super::names::{SETTINGS, Setting};
use super::{Found, Layer, Settings};
use crate::arguments::ConfigExplain;
use crate::exit::{Exit, Trouble};
use crate::output;
use graph_core::document::did_you_mean;
use serde::Serialize;
use std::fmt::Write;

/// A setting as JSON.
#[derive(Serialize)]
struct Line<'a> {
    name: &'a str,
    value: Option<&'a str>,
    layer: Layer,
    place: Option<&'a str>,
    default: &'a str,
    /// What counts less, from that which would count next.
    hidden: Vec<&'a Found>,
}

/// Explains all settings, or one.
pub fn explain(arguments: &ConfigExplain, settings: &Settings) -> Result<Exit, Trouble> {
    let shown: Vec<&Setting> = match &arguments.key {
        None => SETTINGS.iter().collect(),
        Some(key) => {
            let plain = key.replace('-', "_");
            let found = SETTINGS.iter().find(|setting| setting.name == plain);
            vec![found.ok_or_else(|| unknown(key))?]
        }
    };
    let none = Vec::new();
    let mut out = String::new();
    for setting in shown {
        let found = settings.0.get(setting.name).unwrap_or(&none);
        let counts = found.last();
        let hidden: Vec<&Found> = found.iter().rev().skip(1).collect();
        if arguments.json {
            output::print_json(&Line {
                name: setting.name,
                value: counts.map(|found| found.value.as_str()),
                layer: counts.map_or(Layer::Default, |found| found.layer),
                place: counts.map(|found| found.place.as_str()),
                default: setting.default,
                hidden,
            })?;
            continue;
        }
        let (value, place) =
            counts.map_or((setting.default, "default"), |found| (found.value.as_str(), found.place.as_str()));
        let _ = writeln!(out, "{:<9} {value:<28} {place}", setting.name);
        for Found { value, place, .. } in hidden {
            let _ = writeln!(out, "{:<9} {value:<28} {place}, which counts less", "");
        }
    }
    output::print(&out)?;
    Ok(Exit::Fine)
}

fn unknown(key: &str) -> Trouble {
    let names = SETTINGS.iter().map(|setting| setting.name);
    let help = did_you_mean(key, names.clone()).map_or_else(
        || format!("settings: {}", names.collect::<Vec<_>>().join(", ")),
        |near| format!("did you mean `{near}`?"),
    );
    Trouble::command_line(format!("there is no setting `{key}`"), Some(help))
}
