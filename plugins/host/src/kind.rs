//! Kinds of the engine made of a plugin's schemas: JSON schemas of parameters, and nodes from parameters.

use crate::component::Plugin;
use crate::node::{PluginNode, Shared};
use crate::schema::{ParameterSchema, Setting};
use graph_core::node::{Kind, Maker, Node};
use serde_json::{Map, Value, json};
use std::sync::Arc;

/// The kinds of `plugin`, in the order of their names.
pub(crate) fn kinds(plugin: &Arc<Plugin>) -> Vec<Kind> {
    let brought = |node| Kind::brought(Box::new(Brought(Arc::new(Shared::of(plugin, node)))));
    (0..plugin.nodes.len()).map(brought).collect()
}

struct Brought(Arc<Shared>);

impl Brought {
    fn make(&self, given: &Map<String, Value>) -> Result<PluginNode, String> {
        let schema = self.0.schema();
        let mut node = PluginNode { shared: Arc::clone(&self.0), settings: std::collections::BTreeMap::new() };
        for parameter in &schema.parameters {
            let setting = match given.get(&parameter.name) {
                Some(value) => setting(parameter, value)
                    .ok_or_else(|| format!("`{}` is {value}, which is not of its type", parameter.name))?,
                None => parameter.default.clone(),
            };
            node.settings.insert(parameter.name.clone(), setting);
        }
        match given.keys().find(|name| !schema.parameters.iter().any(|parameter| parameter.name == **name)) {
            Some(name) => Err(format!("`{}` has no parameter `{name}`", self.0.tag)),
            None => Ok(node),
        }
    }
}

impl Maker for Brought {
    fn name(&self) -> &'static str {
        self.0.tag
    }

    fn schema(&self) -> Value {
        let schema = self.0.schema();
        let properties: Map<String, Value> =
            schema.parameters.iter().map(|parameter| (parameter.name.clone(), property(parameter))).collect();
        json!({
            "type": "object",
            "description": schema.doc,
            "properties": properties,
            "additionalProperties": false,
        })
    }

    fn node(&self, parameters: &Map<String, Value>) -> Result<Box<dyn Node>, String> {
        Ok(Box::new(self.make(parameters)?))
    }

    fn default_node(&self) -> Box<dyn Node> {
        let settings = self.0.schema().parameters.iter();
        let settings = settings.map(|parameter| (parameter.name.clone(), parameter.default.clone())).collect();
        Box::new(PluginNode { shared: Arc::clone(&self.0), settings })
    }
}

/// A parameter as JSON schema says it.
fn property(parameter: &ParameterSchema) -> Value {
    let mut number = Map::new();
    for (key, bound) in [("minimum", parameter.least), ("maximum", parameter.most)] {
        if let Some(bound) = bound {
            number.insert(key.to_owned(), json!(bound));
        }
    }
    let mut property = match &parameter.default {
        Setting::Flag(_) => json!({ "type": "boolean" }),
        Setting::Integer(_) => with(number, json!({ "type": "integer", "format": "int64" })),
        Setting::Number(_) => with(number, json!({ "type": "number", "format": "double" })),
        Setting::Numbers(_) => {
            json!({ "type": "array", "items": with(number, json!({ "type": "number", "format": "double" })) })
        }
        Setting::Text(_) if parameter.choices.is_empty() => json!({ "type": "string" }),
        Setting::Text(_) => {
            let choice =
                |(name, doc): &(String, String)| json!({ "const": name, "type": "string", "description": doc });
            json!({ "oneOf": parameter.choices.iter().map(choice).collect::<Vec<_>>() })
        }
    };
    property["description"] = json!(parameter.doc);
    property["default"] = json!(parameter.default);
    property
}

fn with(mut bounds: Map<String, Value>, kind: Value) -> Value {
    if let Value::Object(kind) = kind {
        bounds.extend(kind);
    }
    Value::Object(bounds)
}

/// A value as the parameter's type has it.
fn setting(parameter: &ParameterSchema, value: &Value) -> Option<Setting> {
    Some(match &parameter.default {
        Setting::Flag(_) => Setting::Flag(value.as_bool()?),
        Setting::Integer(_) => Setting::Integer(value.as_i64()?),
        Setting::Number(_) => Setting::Number(value.as_f64()?),
        Setting::Text(_) => Setting::Text(value.as_str()?.to_owned()),
        Setting::Numbers(_) => {
            Setting::Numbers(value.as_array()?.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>()?)
        }
    })
}
