//! Region files: which markers and channels belong together, in JSON or RON, in the order of the file.
//!
//! Both are a map from the region's name to its markers and channels:
//!
//! ```text
//! { "brows": { "markers": ["brow_L_0"], "channels": ["browDown_L"] } }      JSON
//! { "brows": (markers: ["brow_L_0"], channels: ["browDown_L"]) }            RON
//! ```

use crate::ReadError;
use face_math::data::{Region, Regions};
use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, Visitor};
use std::collections::BTreeSet;
use std::fmt;
use std::marker::PhantomData;

/// Why text is no file of regions.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RegionsError {
    /// Nothing at all.
    #[error("the file holds no regions; write a map from names to markers and channels")]
    Empty,
    /// Bytes that are no UTF-8 text.
    #[error("byte {at} is not UTF-8 text; save the file as UTF-8")]
    NotText {
        /// Position of the byte.
        at: usize,
    },
    /// A mistake at a place of the text.
    #[error("{line}:{column}: {problem}")]
    At {
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// What is wrong.
        problem: String,
    },
    /// A name that stands twice in one region.
    #[error("region `{region}`: {what} `{name}` stands twice")]
    Twice {
        /// The region.
        region: String,
        /// Marker or channel.
        what: &'static str,
        /// The name.
        name: String,
    },
}

/// A region as JSON writes it, and as RON does.
#[derive(Deserialize)]
#[serde(rename = "Region", deny_unknown_fields)]
struct Body {
    markers: Vec<String>,
    channels: Vec<String>,
}

/// A region in braces, as in JSON, inside a RON file.
struct Braces(Body);

impl<'de> Deserialize<'de> for Braces {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Lists;
        impl<'de> Visitor<'de> for Lists {
            type Value = Braces;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a map of `markers` and `channels`")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Braces, A::Error> {
                let (mut markers, mut channels) = (None, None);
                while let Some(key) = map.next_key::<String>()? {
                    let slot = match key.as_str() {
                        "markers" => &mut markers,
                        "channels" => &mut channels,
                        _ => return Err(A::Error::unknown_field(&key, &["markers", "channels"])),
                    };
                    *slot = Some(map.next_value()?);
                }
                Ok(Braces(Body {
                    markers: markers.ok_or_else(|| A::Error::missing_field("markers"))?,
                    channels: channels.ok_or_else(|| A::Error::missing_field("channels"))?,
                }))
            }
        }
        deserializer.deserialize_map(Lists)
    }
}

impl From<Braces> for Body {
    fn from(braces: Braces) -> Self {
        braces.0
    }
}

/// Collects the entries of a map in their order, each body read as `B`.
struct InOrder<B>(PhantomData<B>);

impl<'de, B: Deserialize<'de> + Into<Body>> DeserializeSeed<'de> for InOrder<B> {
    type Value = Vec<Region>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Vec<Region>, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de, B: Deserialize<'de> + Into<Body>> Visitor<'de> for InOrder<B> {
    type Value = Vec<Region>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a map from names of regions to their markers and channels")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Vec<Region>, A::Error> {
        let mut regions: Vec<Region> = Vec::new();
        while let Some(name) = map.next_key::<String>()? {
            if regions.iter().any(|region| region.name == name) {
                return Err(A::Error::custom(format!("the region `{name}` stands twice")));
            }
            let Body { markers, channels } = map.next_value::<B>()?.into();
            regions.push(Region { name, markers, channels });
        }
        Ok(regions)
    }
}

/// Reads a file of regions, JSON or RON.
///
/// # Errors
/// See [`RegionsError`].
pub fn read(bytes: &[u8]) -> Result<Regions, ReadError> {
    Ok(checked(parse(bytes)?)?)
}

/// Whether bytes are a file of regions.
pub(crate) fn detect(bytes: &[u8]) -> bool {
    parse(bytes).is_ok()
}

fn parse(bytes: &[u8]) -> Result<Vec<Region>, RegionsError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = std::str::from_utf8(bytes).map_err(|error| RegionsError::NotText { at: error.valid_up_to() })?;
    if text.trim().is_empty() {
        return Err(RegionsError::Empty);
    }
    let json = match from_json(text) {
        Ok(regions) => return Ok(regions),
        Err(error) => error,
    };
    let of_json = |error: &serde_json::Error| {
        // The library's own words for the place are cut off; it stands in front.
        let text = error.to_string();
        let problem = text.rsplit_once(" at line ").map_or(text.as_str(), |(problem, _)| problem).to_owned();
        RegionsError::At { line: error.line(), column: error.column(), problem }
    };
    if json.is_data() {
        return Err(of_json(&json));
    }
    // Whatever is no JSON is RON, with either kind of brackets around a region; the reading that comes farthest is the
    // one that was meant.
    let ron = match from_ron::<Body>(text) {
        Ok(regions) => return Ok(regions),
        Err(error) => error,
    };
    let braces = match from_ron::<Braces>(text) {
        Ok(regions) => return Ok(regions),
        Err(error) => error,
    };
    let place = |error: &ron::error::SpannedError| (error.span.end.line, error.span.end.col);
    let ron = if place(&braces) > place(&ron) { braces } else { ron };
    let (line, column) = place(&ron);
    if (json.line(), json.column()) > (line, column) {
        return Err(of_json(&json));
    }
    Err(RegionsError::At { line, column, problem: ron.code.to_string() })
}

fn from_json(text: &str) -> Result<Vec<Region>, serde_json::Error> {
    let mut deserializer = serde_json::Deserializer::from_str(text);
    let regions = InOrder::<Body>(PhantomData).deserialize(&mut deserializer)?;
    deserializer.end()?;
    Ok(regions)
}

fn from_ron<'de, B: Deserialize<'de> + Into<Body>>(text: &'de str) -> Result<Vec<Region>, ron::error::SpannedError> {
    ron::Options::default().from_str_seed(text, InOrder::<B>(PhantomData))
}

fn checked(regions: Vec<Region>) -> Result<Regions, RegionsError> {
    if regions.is_empty() {
        return Err(RegionsError::Empty);
    }
    for region in &regions {
        for (what, names) in [("the marker", &region.markers), ("the channel", &region.channels)] {
            let mut seen = BTreeSet::new();
            if let Some(name) = names.iter().find(|name| !seen.insert(*name)) {
                return Err(RegionsError::Twice { region: region.name.clone(), what, name: name.clone() });
            }
        }
    }
    Ok(Regions { regions })
}
