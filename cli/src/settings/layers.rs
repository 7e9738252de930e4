//! The layers in which settings are looked up: files, the environment, the command line.

use super::names::{OTHER_VARIABLES, SETTINGS, Setting};
use super::{Found, Layer};
use crate::exit::Trouble;
use graph_core::document::{Diagnostic, Diagnostics, NamedField, Place, Resolved, Source, did_you_mean, named_fields};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The name of a file of settings.
const FILE: &str = "grimace.ron";

/// What each setting was set to, by name; what counts least comes first.
pub type Layers = BTreeMap<&'static str, Vec<Found>>;

/// The files of settings for a graph in `folder`, those that count least first: the user's own, then all above the graph from
/// the outermost to the nearest.
pub fn files(folder: &Path, environment: impl Fn(&str) -> Option<OsString>) -> Vec<(Layer, PathBuf)> {
    let set = |name: &str| environment(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let config = set("XDG_CONFIG_HOME").or_else(|| set("HOME").map(|home| home.join(".config")));
    let user = config.map(|config| config.join("grimace").join(FILE));
    let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    let mut above: Vec<PathBuf> = absolute.ancestors().map(|folder| folder.join(FILE)).collect();
    above.retain(|file| Some(file) != user.as_ref());
    above.reverse();
    let user = user.into_iter().map(|file| (Layer::User, file));
    user.chain(above.into_iter().map(|file| (Layer::Project, file))).filter(|(_, file)| file.is_file()).collect()
}

/// Reads one file into `layers`.
///
/// # Errors
/// Every mistake in it.
pub fn read_file(layer: Layer, path: &Path, layers: &mut Layers) -> Result<(), Diagnostics> {
    let source = Arc::new(Source::load(path).map_err(|mistake| Diagnostics(vec![mistake]))?);
    let names = SETTINGS.map(|setting| setting.name);
    let mut mistakes = Vec::new();
    for field in named_fields(&source, "a file of settings", &names)? {
        let Some(setting) = SETTINGS.iter().find(|setting| setting.name == field.name) else { continue };
        match text_of(setting, &field) {
            Ok(None) => {}
            Ok(Some(value)) => {
                let place = Place { source: Arc::clone(&source), span: field.name_span }.text();
                layers.entry(setting.name).or_default().push(Found { value, layer, place });
            }
            Err(expected) => {
                let message = format!("`{}` must be {expected}", setting.name);
                mistakes.push(Diagnostic::at("wrong-value", &source, field.span, message));
            }
        }
    }
    if mistakes.is_empty() { Ok(()) } else { Err(Diagnostics(mistakes)) }
}

/// The value of a field as text; `None` where it is left open, or what is expected.
fn text_of(setting: &Setting, field: &NamedField) -> Result<Option<String>, String> {
    let value = match &field.value {
        Resolved::Nothing => return Ok(None),
        Resolved::Text { text, .. } if setting.is_path && text.is_empty() => return Err("a path".to_owned()),
        Resolved::Text { .. } if setting.is_path => {
            field.value.path().map(|path| path.display().to_string()).unwrap_or_default()
        }
        _ if setting.is_path => return Err("a path, written as a string".to_owned()),
        Resolved::Text { text, .. } if setting.name != "jobs" => text.clone(),
        Resolved::Integer(number) => number.to_string(),
        _ => String::new(),
    };
    (setting.check)(&value)?;
    Ok(Some(value))
}

/// Reads the variables of the environment into `layers`. One that is empty counts as not set.
///
/// # Errors
/// Where a value is wrong, or a name is nearly that of a setting.
pub fn read_environment(
    variables: impl IntoIterator<Item = (OsString, OsString)>,
    layers: &mut Layers,
) -> Result<(), Trouble> {
    let known = SETTINGS.map(|setting| setting.variable);
    for (name, value) in variables {
        let Some(name) = name.to_str().filter(|name| name.starts_with("GRIMACE_")) else { continue };
        if value.is_empty() || OTHER_VARIABLES.contains(&name) {
            continue;
        }
        let Some(setting) = SETTINGS.iter().find(|setting| setting.variable == name) else {
            let plain = |name: &'static str| name.trim_start_matches("GRIMACE_");
            let near = did_you_mean(name.trim_start_matches("GRIMACE_"), known.map(plain));
            // Others may have variables of their own.
            let Some(near) = near else { continue };
            let help = Some(format!("did you mean `GRIMACE_{near}`?"));
            return Err(Trouble::command_line(format!("the variable {name} of the environment sets nothing"), help));
        };
        let checked = value.to_str().ok_or_else(|| "UTF-8 text".to_owned());
        let checked = checked.and_then(|text| (setting.check)(text).map(|()| text));
        match checked {
            Ok(text) => {
                let found = Found { value: text.to_owned(), layer: Layer::Environment, place: name.to_owned() };
                layers.entry(setting.name).or_default().push(found);
            }
            Err(expected) => {
                let message = format!("{name} is `{}`, and must be {expected}", value.display());
                return Err(Trouble::command_line(message, Some(format!("set it anew, or unset {name}"))));
            }
        }
    }
    Ok(())
}
