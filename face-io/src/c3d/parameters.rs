//! The parameters of a C3D file: named values in named groups, in any order.

use super::C3dError;
use super::numbers::Source;
use std::collections::BTreeMap;

/// The values of one parameter.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Values {
    /// Texts of equal width, as raw bytes.
    Text { width: usize, bytes: Vec<u8> },
    /// Numbers, as stored in 1, 2 or 4 bytes. Integers stand for unsigned ones, as counts in C3D files are.
    Numbers(Vec<f64>),
}

/// One parameter and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Parameter {
    pub at: usize,
    pub values: Values,
}

/// All parameters by `GROUP:NAME`, upper case.
#[derive(Debug, Default)]
pub(super) struct Parameters(BTreeMap<String, Parameter>);

impl Parameters {
    /// Reads the records from byte `start` on; none of them may pass byte `end`.
    ///
    /// A record is: length of its name (negative where locked), number of its group (negative where it defines the
    /// group), name, distance to the next record, and for a parameter its type (-1 text, 1, 2 or 4 bytes), number of
    /// dimensions, dimensions and values. The list ends at a name of length 0 or a distance of 0.
    pub fn read(source: &Source<'_>, start: usize, end: usize) -> Result<Self, C3dError> {
        let mut groups: BTreeMap<u8, String> = BTreeMap::new();
        let mut ungrouped: Vec<(u8, String, Parameter)> = Vec::new();
        let mut at = start;
        while at < end {
            let name_length = usize::from(source.u8(at, "a parameter")?.cast_signed().unsigned_abs());
            if name_length == 0 {
                break;
            }
            let group = source.u8(at + 1, "the group number of a parameter")?.cast_signed();
            let name = text(source.slice(at + 2, name_length, "the name of a parameter")?).to_uppercase();
            let next_at = at + 2 + name_length;
            let distance = usize::from(source.u16(next_at, &format!("parameter {name}"))?);
            let end_of_record = if distance == 0 { source.bytes.len() } else { next_at + distance };
            match group.signum() {
                -1 => {
                    groups.insert(group.unsigned_abs(), name);
                }
                1 => {
                    let values = read_values(source, at, &name, next_at + 2, end_of_record)?;
                    ungrouped.push((group.unsigned_abs(), name, Parameter { at, values }));
                }
                _ => {
                    let what = "it belongs to group 0, which cannot be".into();
                    return Err(C3dError::Record { at, name, what });
                }
            }
            if distance == 0 {
                break;
            }
            at = end_of_record;
        }
        // A parameter may stand before its group.
        let named = ungrouped.into_iter().map(|(group, name, parameter)| {
            let group = groups.get(&group).cloned().unwrap_or_else(|| format!("#{group}"));
            (format!("{group}:{name}"), parameter)
        });
        Ok(Self(named.collect()))
    }

    pub fn has(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    /// Where the record of a parameter begins; `header`, a place in the header, where there is none.
    pub fn place(&self, name: &str, header: usize) -> usize {
        self.0.get(name).map_or(header, |parameter| parameter.at)
    }

    /// All numbers of a parameter; none where it is not there.
    ///
    /// Where the parameter is a text, that is an error.
    pub fn numbers(&self, name: &str) -> Result<&[f64], C3dError> {
        match self.0.get(name) {
            None => Ok(&[]),
            Some(Parameter { values: Values::Numbers(numbers), .. }) => Ok(numbers),
            Some(Parameter { at, .. }) => {
                Err(C3dError::Record { at: *at, name: name.to_owned(), what: "it holds text, not numbers".into() })
            }
        }
    }

    /// The first number of a parameter.
    pub fn number(&self, name: &str) -> Result<Option<f64>, C3dError> {
        Ok(self.numbers(name)?.first().copied())
    }

    /// All texts of a parameter, blanks trimmed; none where it is not there.
    pub fn texts(&self, name: &str) -> Result<Vec<String>, C3dError> {
        match self.0.get(name) {
            None | Some(Parameter { values: Values::Text { width: 0, .. }, .. }) => Ok(Vec::new()),
            Some(Parameter { values: Values::Text { width, bytes }, .. }) => {
                Ok(bytes.chunks(*width).map(text).collect())
            }
            Some(Parameter { at, .. }) => {
                Err(C3dError::Record { at: *at, name: name.to_owned(), what: "it holds numbers, not text".into() })
            }
        }
    }
}

fn read_values(
    source: &Source<'_>,
    record_at: usize,
    name: &str,
    at: usize,
    end_of_record: usize,
) -> Result<Values, C3dError> {
    let what = || format!("parameter {name}");
    let wrong = |what: String| C3dError::Record { at: record_at, name: name.to_owned(), what };
    let kind = source.u8(at, &what())?.cast_signed();
    let dimension_count = usize::from(source.u8(at + 1, &what())?);
    let dimensions = source.slice(at + 2, dimension_count, &what())?;
    let count = dimensions
        .iter()
        .try_fold(1_usize, |product, dimension| product.checked_mul(usize::from(*dimension)))
        .ok_or_else(|| wrong(format!("its {dimension_count} dimensions multiply to more than memory holds")))?;
    let at = at + 2 + dimension_count;
    let bytes = |width: usize| {
        let length = count.checked_mul(width).ok_or_else(|| wrong("it is larger than memory".into()))?;
        if at.saturating_add(length) > end_of_record {
            let room = end_of_record.saturating_sub(at);
            return Err(wrong(format!("its values take {length} bytes, its record has room for {room}")));
        }
        source.slice(at, length, &what())
    };
    Ok(match kind {
        -1 => Values::Text { width: dimensions.first().copied().map_or(1, usize::from), bytes: bytes(1)?.to_vec() },
        1 => Values::Numbers(bytes(1)?.iter().map(|byte| f64::from(*byte)).collect()),
        2 => Values::Numbers(
            bytes(2)?.chunks_exact(2).map(|pair| f64::from(source.processor.u16([pair[0], pair[1]]))).collect(),
        ),
        4 => Values::Numbers(
            bytes(4)?
                .chunks_exact(4)
                .map(|four| shortest_decimal(source.processor.f32([four[0], four[1], four[2], four[3]])))
                .collect(),
        ),
        _ => return Err(wrong(format!("its type is {kind}; types are -1 (text), 1, 2 and 4"))),
    })
}

/// The 64-bit number that people meant when they stored it in 32 bits: 59.94, not 59.939998626….
pub(super) fn shortest_decimal(number: f32) -> f64 {
    number.to_string().parse().unwrap_or_else(|_| f64::from(number))
}

/// Text of a C3D file: UTF-8 where it is valid as such, Latin-1 otherwise; blanks and zero bytes at the end cut.
fn text(bytes: &[u8]) -> String {
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect(),
    };
    text.split('\0').next().unwrap_or_default().trim().to_owned()
}
