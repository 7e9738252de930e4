//! A view of JSON schemas as schemars writes them: references followed, and what they expect put in words.

use serde_json::{Map, Value};

/// A bound of a number, and whether the bound itself is left out.
pub(crate) type Bound = (f64, bool);

/// A schema within the schema of a kind.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Schema<'a> {
    root: &'a Value,
    here: &'a Value,
}

impl<'a> Schema<'a> {
    /// The schema of a kind.
    pub fn root(root: &'a Value) -> Self {
        Self { root, here: root }
    }

    /// Another schema within the same kind's, with its references followed.
    pub fn at(self, here: &'a Value) -> Self {
        let mut here = here;
        // Definitions refer to definitions in chains that are short; the bound is against circles.
        for _ in 0..32 {
            let Some(reference) = here.get("$ref").and_then(Value::as_str) else { break };
            let Some(target) = reference.strip_prefix('#').and_then(|pointer| self.root.pointer(pointer)) else {
                break;
            };
            here = target;
        }
        Self { here, ..self }
    }

    /// What stands under `key`.
    pub fn get(self, key: &str) -> Option<&'a Value> {
        self.here.get(key)
    }

    /// The schema under `key`.
    pub fn inner(self, key: &str) -> Option<Self> {
        self.get(key).map(|schema| self.at(schema))
    }

    /// The schemas listed under `key`.
    pub fn list(self, key: &str) -> Vec<Self> {
        self.get(key).and_then(Value::as_array).into_iter().flatten().map(|schema| self.at(schema)).collect()
    }

    /// The properties with their names.
    pub fn properties(self) -> Vec<(&'a str, Self)> {
        let properties = self.get("properties").and_then(Value::as_object);
        properties.into_iter().flatten().map(|(name, schema)| (name.as_str(), self.at(schema))).collect()
    }

    /// The names of the properties that must be given.
    pub fn required(self) -> impl Iterator<Item = &'a str> {
        self.get("required").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str)
    }

    /// Whether the schema says nothing: every value fits.
    pub fn is_open(self) -> bool {
        const SAY_NOTHING: [&str; 6] = ["description", "title", "default", "examples", "deprecated", "$schema"];
        let says_nothing = |keys: &Map<String, Value>| keys.keys().all(|key| SAY_NOTHING.contains(&key.as_str()));
        self.here.as_bool() == Some(true) || self.here.as_object().is_some_and(says_nothing)
    }

    /// The types named under `type`.
    pub fn types(self) -> Vec<&'a str> {
        match self.get("type") {
            Some(Value::String(one)) => vec![one],
            Some(Value::Array(several)) => several.iter().filter_map(Value::as_str).collect(),
            _ => Vec::new(),
        }
    }

    /// The alternatives of a choice, those of choices within it included; empty where this is no choice.
    pub fn alternatives(self) -> Vec<Self> {
        let direct = [self.list("oneOf"), self.list("anyOf")].concat();
        direct
            .into_iter()
            .flat_map(|schema| match schema.alternatives() {
                inner if inner.is_empty() => vec![schema],
                inner => inner,
            })
            .collect()
    }

    /// The plain variants of an enum that this schema names: `const`, or `enum`.
    pub fn names(self) -> Vec<&'a str> {
        let listed = self.get("enum").and_then(Value::as_array).into_iter().flatten();
        self.get("const").into_iter().chain(listed).filter_map(Value::as_str).collect()
    }

    /// An enum's variant with content: its name, and the schema of the content.
    pub fn variant(self) -> Option<(&'a str, Self)> {
        let closed = self.get("additionalProperties").and_then(Value::as_bool) == Some(false);
        let mut properties = self.properties().into_iter();
        match (properties.next(), properties.next()) {
            (Some((name, content)), None) if closed && self.required().eq([name]) => Some((name, content)),
            _ => None,
        }
    }

    /// Whether a value of the JSON type `name` may fit.
    pub fn allows(self, name: &str) -> bool {
        let alternatives = self.alternatives();
        if !alternatives.is_empty() {
            return alternatives.into_iter().any(|schema| schema.allows(name));
        }
        let types = self.types();
        if types.is_empty() {
            let names = !self.names().is_empty();
            return if names { name == "string" } else { true };
        }
        types.contains(&name)
    }

    /// The least and the most that a number may be.
    pub fn bounds(self) -> (Option<Bound>, Option<Bound>) {
        let number = |key: &str| self.get(key).and_then(Value::as_f64);
        let of_format = match self.get("format").and_then(Value::as_str) {
            Some("int8") => (f64::from(i8::MIN), f64::from(i8::MAX)),
            Some("uint8") => (0.0, f64::from(u8::MAX)),
            Some("int16") => (f64::from(i16::MIN), f64::from(i16::MAX)),
            Some("uint16") => (0.0, f64::from(u16::MAX)),
            Some("int32") => (f64::from(i32::MIN), f64::from(i32::MAX)),
            Some("uint32") => (0.0, f64::from(u32::MAX)),
            Some("float") => (f64::from(f32::MIN), f64::from(f32::MAX)),
            Some("uint" | "uint64" | "uint128") => (0.0, f64::INFINITY),
            _ => (f64::NEG_INFINITY, f64::INFINITY),
        };
        let least = match (number("minimum"), number("exclusiveMinimum")) {
            (minimum, Some(open)) if minimum.is_none_or(|minimum| open >= minimum) => (open, true),
            (minimum, _) => (minimum.unwrap_or(f64::NEG_INFINITY).max(of_format.0), false),
        };
        let most = match (number("maximum"), number("exclusiveMaximum")) {
            (maximum, Some(open)) if maximum.is_none_or(|maximum| open <= maximum) => (open, true),
            (maximum, _) => (maximum.unwrap_or(f64::INFINITY).min(of_format.1), false),
        };
        (Some(least).filter(|(least, _)| least.is_finite()), Some(most).filter(|(most, _)| most.is_finite()))
    }

    /// What the schema expects, in words: `a number from 0.1 to 120 Hz`. The unit is that of the parameter's name.
    pub fn expected(self, parameter: &str) -> String {
        let alternatives = self.alternatives();
        if !alternatives.is_empty() {
            return expected_choice(&alternatives, parameter);
        }
        let names = self.names();
        if !names.is_empty() {
            return one_of(&names);
        }
        let (nothing, types): (Vec<&str>, Vec<&str>) = self.types().into_iter().partition(|name| *name == "null");
        let mut words: Vec<String> = types.iter().map(|name| self.expected_type(name, parameter)).collect();
        if !nothing.is_empty() {
            words.push("None".to_owned());
        }
        if words.is_empty() { "a value".to_owned() } else { words.join(" or ") }
    }

    fn expected_type(self, name: &str, parameter: &str) -> String {
        match name {
            "number" => self.expected_number("a number", parameter),
            "integer" => self.expected_number("a whole number", parameter),
            "string" => self.expected_text(),
            "boolean" => "true or false".to_owned(),
            "array" => self.expected_list(),
            "object" => match self.properties() {
                properties if properties.is_empty() => "a map".to_owned(),
                properties => {
                    let names: Vec<_> = properties.iter().take(4).map(|(name, _)| format!("{name}: …")).collect();
                    let more = if properties.len() > 4 { ", …" } else { "" };
                    format!("({}{more})", names.join(", "))
                }
            },
            other => other.to_owned(),
        }
    }

    fn expected_text(self) -> String {
        let count = |key: &str| self.get(key).and_then(Value::as_u64);
        match (count("minLength"), count("maxLength")) {
            (Some(1), Some(1)) => "one character".to_owned(),
            (None | Some(0), None) => "a string".to_owned(),
            (Some(1), None) => "a string that is not empty".to_owned(),
            (Some(least), None) => format!("a string of at least {least} characters"),
            (least, Some(most)) => format!("a string of {} to {most} characters", least.unwrap_or(0)),
        }
    }

    fn expected_number(self, what: &str, parameter: &str) -> String {
        let unit = unit(parameter).map_or(String::new(), |unit| format!(" {unit}"));
        let (least, most) = self.bounds();
        // The bounds of 32-bit floats go without saying.
        let told = |bound: &Bound| bound.0.abs() < f64::from(f32::MAX);
        match (least.filter(told), most.filter(told)) {
            (None, None) => format!("{what}{}", if unit.is_empty() { unit } else { format!(" in{unit}") }),
            (Some((least, false)), Some((most, false))) => {
                format!("{what} between {least} and {most}{unit}")
            }
            (least, most) => {
                let least = least.map(|(at, open)| format!("{} {at}", if open { "above" } else { "of at least" }));
                let most = most.map(|(at, open)| format!("{} {at}", if open { "below" } else { "of at most" }));
                let bounds: Vec<_> = least.into_iter().chain(most).collect();
                format!("{what} {}{unit}", bounds.join(" and "))
            }
        }
    }

    fn expected_list(self) -> String {
        let count = |key: &str| self.get(key).and_then(Value::as_u64);
        let items = self.inner("items").filter(|items| !items.is_open());
        let of = items.map_or(String::new(), |items| format!(", each {}", items.expected("")));
        match (count("minItems"), count("maxItems")) {
            (Some(least), Some(most)) if least == most => format!("a list of {least}{of}"),
            (Some(least), Some(most)) => format!("a list of {least} to {most}{of}"),
            (Some(least), None) if least > 0 => format!("a list of at least {least}{of}"),
            (_, Some(most)) => format!("a list of at most {most}{of}"),
            _ => format!("a list{of}"),
        }
    }
}

pub(super) fn expected_choice(alternatives: &[Schema<'_>], parameter: &str) -> String {
    let mut names = Vec::new();
    let mut others = Vec::new();
    let mut nothing = false;
    for schema in alternatives {
        match schema.variant() {
            Some((name, _)) => names.push(format!("{name}(…)")),
            None if schema.types() == ["null"] => nothing = true,
            None if schema.names().is_empty() => others.push(schema.expected(parameter)),
            None => names.extend(schema.names().into_iter().map(str::to_owned)),
        }
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut words = if names.is_empty() { Vec::new() } else { vec![one_of(&names)] };
    words.append(&mut others);
    if nothing {
        words.push("None".to_owned());
    }
    words.join(" or ")
}

fn one_of(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.as_slice() {
        [one] => one.clone(),
        [one, other] => format!("{one} or {other}"),
        several => format!("one of {}", several.join(", ")),
    }
}

/// The unit that the last word of a parameter's name gives.
fn unit(parameter: &str) -> Option<&'static str> {
    Some(match parameter.rsplit(['.', ']']).next()?.rsplit_once('_')?.1 {
        "hz" => "Hz",
        "mm" => "mm",
        "cm" => "cm",
        "m" => "m",
        "px" => "px",
        "s" => "s",
        "ms" => "ms",
        "deg" => "degrees",
        "rad" => "radians",
        "frames" => "frames",
        "percent" => "%",
        _ => return None,
    })
}
