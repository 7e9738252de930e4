//! The lines of an OBJ file.

use super::ObjError;
use crate::surface::{Corner, Polygons};
use glam::DVec3;
use std::collections::BTreeMap;

/// A polygon of more corners than this is no face that anyone modelled; cutting it up would take for ever.
const MOST_CORNERS: usize = 1024;

/// Statements that change nothing of a surface of polygons.
const PASSED_OVER: [&str; 36] = [
    "vn",
    "vp",
    "p",
    "l",
    "s",
    "mg",
    "mtllib",
    "usemap",
    "maplib",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "shadow_obj",
    "trace_obj",
    "ctech",
    "stech",
    "cstype",
    "deg",
    "bmat",
    "step",
    "curv",
    "curv2",
    "surf",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "call",
    "csh",
    "cdc",
    "cdp",
    "bzp",
];

/// A face in an OBJ file, as its lines say.
#[derive(Debug)]
pub struct Obj {
    /// Vertices in the unit of the file, in its order.
    pub(super) positions: Vec<DVec3>,
    /// Texture coordinates, origin at the top left.
    pub(super) uvs: Vec<[f32; 2]>,
    pub(super) polygons: Polygons,
    /// Names of the groups of polygons.
    pub(super) groups: Vec<String>,
}

impl Obj {
    /// Number of vertices, as the file counts them.
    pub fn vertices(&self) -> usize {
        self.positions.len()
    }

    /// Number of polygons.
    pub fn faces(&self) -> usize {
        self.polygons.faces.len()
    }
}

/// Whether bytes look like an OBJ file: the first statement that is no comment is one of those that OBJ files begin with.
pub fn detect(bytes: &[u8]) -> bool {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(65_536)]);
    let first = head.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    let mut words = first.unwrap_or_default().split_whitespace();
    match words.next() {
        Some("mtllib" | "o" | "g" | "usemtl" | "s") => words.next().is_some(),
        Some("v") => words.next().is_some_and(|number| number.parse::<f64>().is_ok()),
        _ => false,
    }
}

#[derive(Default)]
struct Reading {
    positions: Vec<DVec3>,
    uvs: Vec<[f32; 2]>,
    polygons: Polygons,
    /// Line of each polygon.
    lines: Vec<usize>,
    object: String,
    group: String,
    material: String,
    /// Groups met so far: object, group and material.
    groups: Vec<[String; 3]>,
    index: BTreeMap<[String; 3], usize>,
}

pub(super) fn parse(bytes: &[u8]) -> Result<Obj, ObjError> {
    let text = String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    let mut reading = Reading::default();
    let mut whole = String::new();
    for (index, line) in text.lines().enumerate() {
        // A name may hold a `#`; a comment follows a blank.
        let line = if line.trim_start().starts_with('#') { "" } else { line.split(" #").next().unwrap_or_default() };
        let line = line.trim_end();
        if let Some(begun) = line.strip_suffix('\\') {
            whole.push_str(begun);
            whole.push(' ');
            continue;
        }
        let read = if whole.is_empty() {
            reading.statement(line, index + 1)
        } else {
            whole.push_str(line);
            reading.statement(&std::mem::take(&mut whole), index + 1)
        };
        read.map_err(|problem| ObjError::Line { line: index + 1, problem })?;
    }
    reading.finish()
}

impl Reading {
    fn statement(&mut self, line: &str, number: usize) -> Result<(), String> {
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next() else { return Ok(()) };
        let rest = line.trim_start()[keyword.len()..].trim();
        match keyword {
            "v" => {
                let [x, y, z] = numbers(words, rest)?;
                self.positions.push(DVec3::new(x, y, z));
            }
            "vt" => {
                let [u, v] = match numbers(words.clone(), rest) {
                    Ok(pair) => pair,
                    Err(_) if words.clone().count() == 1 => [numbers::<1>(words, rest)?[0], 0.0],
                    Err(problem) => return Err(problem),
                };
                self.uvs.push([u as f32, (1.0 - v) as f32]);
            }
            "f" | "fo" => self.face(words, number)?,
            "o" => rest.clone_into(&mut self.object),
            "g" => rest.split_whitespace().next().unwrap_or_default().clone_into(&mut self.group),
            "usemtl" => rest.clone_into(&mut self.material),
            _ if PASSED_OVER.contains(&keyword) => {}
            _ => {
                let shown: String = keyword.chars().take(20).collect();
                return Err(format!(
                    "`{shown}` begins no statement of an OBJ file; the file is damaged, or no OBJ file"
                ));
            }
        }
        Ok(())
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a str>, number: usize) -> Result<(), String> {
        let begin = self.polygons.corners.len();
        for word in words {
            let mut indices = word.split('/');
            let vertex = indices.next().unwrap_or_default();
            let vertex = index(vertex, self.positions.len()).ok_or_else(|| {
                format!("`{word}` is no corner of a face; one is a number of a vertex, such as 7 or 7/3")
            })?;
            let uv = match indices.next() {
                None | Some("") => None,
                Some(uv) => Some(index(uv, self.uvs.len()).ok_or_else(|| {
                    format!("`{word}` is no corner of a face: `{uv}` is no number of texture coordinates")
                })?),
            };
            self.polygons.corners.push(Corner { vertex, uv });
        }
        let corners = begin..self.polygons.corners.len();
        match corners.len() {
            0..3 => return Err(format!("a face of {} corners; it must have at least 3", corners.len())),
            count if count > MOST_CORNERS => {
                return Err(format!("a face of {count} corners; more than {MOST_CORNERS} are not read"));
            }
            _ => {}
        }
        let key = [&self.object, &self.group, &self.material].map(String::clone);
        let groups = &mut self.groups;
        let group = *self.index.entry(key).or_insert_with_key(|key| {
            groups.push(key.clone());
            groups.len() - 1
        });
        self.polygons.faces.push((corners, group));
        self.lines.push(number);
        Ok(())
    }

    fn finish(self) -> Result<Obj, ObjError> {
        if self.polygons.faces.is_empty() {
            return Err(ObjError::NoFaces { vertices: self.positions.len() });
        }
        for ((corners, _), line) in self.polygons.faces.iter().zip(&self.lines) {
            for corner in &self.polygons.corners[corners.clone()] {
                let wrong = |what: &str, index: u32, count: usize| ObjError::Line {
                    line: *line,
                    problem: format!("the face names {what} {}, but there are {count}", u64::from(index) + 1),
                };
                if corner.vertex as usize >= self.positions.len() {
                    return Err(wrong("vertex", corner.vertex, self.positions.len()));
                }
                if let Some(uv) = corner.uv.filter(|uv| *uv as usize >= self.uvs.len()) {
                    return Err(wrong("texture coordinates", uv, self.uvs.len()));
                }
            }
        }
        let groups = names(&self.groups);
        Ok(Obj { positions: self.positions, uvs: self.uvs, polygons: self.polygons, groups })
    }
}

/// Names of parts: the group, or else the object; followed by the material where that name alone has several.
fn names(groups: &[[String; 3]]) -> Vec<String> {
    let base = |[object, group, _]: &[String; 3]| {
        if group.is_empty() || group == "default" { object.clone() } else { group.clone() }
    };
    let mut materials: BTreeMap<String, usize> = BTreeMap::new();
    for key in groups {
        *materials.entry(base(key)).or_default() += 1;
    }
    let same = |key: &[String; 3]| materials[&base(key)];
    let name = |key: &[String; 3]| match (base(key), key[2].as_str()) {
        (base, material) if base.is_empty() => if material.is_empty() { "mesh" } else { material }.to_owned(),
        (base, material) if same(key) > 1 && !material.is_empty() => format!("{base}/{material}"),
        (base, _) => base,
    };
    groups.iter().map(name).collect()
}

/// The first `N` numbers of a statement.
fn numbers<'a, const N: usize>(mut words: impl Iterator<Item = &'a str>, rest: &str) -> Result<[f64; N], String> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        let word = words.next().ok_or_else(|| format!("`{rest}` where {N} numbers are needed"))?;
        let parsed = word.parse::<f64>().ok().filter(|parsed| (*parsed as f32).is_finite());
        *number = parsed.ok_or_else(|| format!("`{word}` is not a finite number"))?;
    }
    Ok(numbers)
}

/// An index from 0 of what the file counts from 1, or, where negative, back from the last of the `count` read so far.
fn index(text: &str, count: usize) -> Option<u32> {
    let number: i64 = text.parse().ok()?;
    let index = if number > 0 { number - 1 } else { i64::try_from(count).ok()?.checked_add(number)? };
    u32::try_from(index).ok().filter(|_| number != 0)
}
