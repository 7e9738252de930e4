//! The container of a glTF file: GLB or plain JSON, its buffers from inside, from data URIs or from companion files.
//!
//! The JSON is read with the types of `gltf-json`. Its own validation is left aside, because it panics on a POSITION
//! accessor that is not there; what this crate uses is checked where it is used.

use super::GltfError;
use crate::Sibling;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf_json::Root;

const MAGIC: &[u8; 4] = b"glTF";
const JSON_CHUNK: u32 = 0x4e4f_534a;
const BIN_CHUNK: u32 = 0x004e_4942;

/// Extensions that change nothing of what is read here, or that are understood.
const UNDERSTOOD: [&str; 2] = ["KHR_mesh_quantization", "KHR_texture_transform"];

/// A glTF file with its buffers at hand.
pub(super) struct File {
    pub root: Root,
    pub buffers: Vec<Vec<u8>>,
    /// Whether it was a GLB container.
    pub binary: bool,
}

impl File {
    pub fn read(bytes: &[u8], sibling: &mut Sibling<'_>) -> Result<Self, GltfError> {
        let (json, mut binary_chunk) = split(bytes)?;
        let root: Root = serde_json::from_slice(json).map_err(|error| {
            let text = error.to_string();
            let problem = text.rsplit_once(" at line ").map_or(text.as_str(), |(problem, _)| problem).to_owned();
            GltfError::Json { line: error.line(), column: error.column(), problem }
        })?;
        if !root.asset.version.starts_with("2.") {
            return Err(GltfError::Version { found: root.asset.version });
        }
        let foreign = |name: &&String| !UNDERSTOOD.contains(&name.as_str()) && !name.starts_with("KHR_materials_");
        if let Some(name) = root.extensions_required.iter().find(foreign) {
            return Err(GltfError::Extension { name: name.clone() });
        }
        let mut buffers = Vec::with_capacity(root.buffers.len());
        for (index, buffer) in root.buffers.iter().enumerate() {
            let wrong = |problem: String| GltfError::Buffer { index, problem };
            let data = match (&buffer.uri, index) {
                (Some(uri), _) => resolve(uri, sibling).map_err(wrong)?,
                (None, 0) => binary_chunk.take().map(<[u8]>::to_vec).ok_or_else(|| {
                    wrong("it has no uri, and the file has no binary chunk; export it as .glb, or with its .bin".into())
                })?,
                (None, _) => return Err(wrong("it has no uri; only the first buffer may lie in the file".into())),
            };
            if (data.len() as u64) < buffer.byte_length.0 {
                let (have, need) = (data.len(), buffer.byte_length.0);
                return Err(wrong(format!("it holds {have} bytes where {need} are announced; the file was cut short")));
            }
            buffers.push(data);
        }
        Ok(Self { root, buffers, binary: bytes.starts_with(MAGIC) })
    }

    /// All bytes of all buffers.
    pub fn byte_count(&self) -> usize {
        self.buffers.iter().map(Vec::len).sum()
    }
}

/// Whether bytes look like a glTF file of either kind.
pub fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
        || serde_json::from_slice::<serde_json::Value>(bytes)
            .is_ok_and(|value| value.get("asset").and_then(|asset| asset.get("version")).is_some())
}

/// The JSON and the binary chunk of a file.
fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), GltfError> {
    let bytes_of_text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    match bytes_of_text.iter().find(|byte| !byte.is_ascii_whitespace()) {
        None => return Err(GltfError::Empty),
        Some(b'{') => return Ok((bytes_of_text, None)),
        Some(_) if bytes.starts_with(MAGIC) => {}
        Some(_) => return Err(GltfError::NoGltf),
    }
    let version = word(bytes, 4, "the GLB header")?;
    if version != 2 {
        return Err(GltfError::Version { found: version.to_string() });
    }
    let length = word(bytes, 8, "the GLB header")? as usize;
    if length > bytes.len() {
        return Err(GltfError::Short { what: "the whole file".into(), begins: 0, length, have: bytes.len() });
    }
    let (mut json, mut binary, mut at) = (None, None, 12);
    while at < length {
        let size = word(bytes, at, "a chunk's head")? as usize;
        let kind = word(bytes, at + 4, "a chunk's head")?;
        let what = match kind {
            JSON_CHUNK => "the JSON chunk",
            BIN_CHUNK => "the BIN chunk",
            _ => "a chunk of another kind",
        };
        let chunk = slice(bytes, at + 8, size, what)?;
        match kind {
            JSON_CHUNK if json.is_none() => json = Some(chunk),
            BIN_CHUNK if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        at += 8 + size;
    }
    let json = json.ok_or(GltfError::Short { what: "the JSON chunk".into(), begins: 12, length: 8, have: length })?;
    Ok((json, binary))
}

fn slice<'a>(bytes: &'a [u8], at: usize, length: usize, what: &str) -> Result<&'a [u8], GltfError> {
    let short = || GltfError::Short { what: what.to_owned(), begins: at, length, have: bytes.len() };
    bytes.get(at..at.checked_add(length).ok_or_else(short)?).ok_or_else(short)
}

fn word(bytes: &[u8], at: usize, what: &str) -> Result<u32, GltfError> {
    let mut word = [0; 4];
    word.copy_from_slice(slice(bytes, at, 4, what)?);
    Ok(u32::from_le_bytes(word))
}

fn resolve(uri: &str, sibling: &mut Sibling<'_>) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
        let encoded = encoded.ok_or("its data URI is not base64")?;
        return STANDARD.decode(encoded).map_err(|error| format!("its data URI is damaged: {error}"));
    }
    let scheme = uri.split_once(':').map(|(scheme, _)| scheme);
    if scheme.is_some_and(|scheme| scheme.len() > 1 && scheme.bytes().all(|byte| byte.is_ascii_alphanumeric())) {
        return Err(format!("`{uri}` is no file beside this one; nothing is fetched from elsewhere"));
    }
    let path = percent_decoded(uri);
    sibling(&path).map_err(|error| format!("the file `{path}` beside it cannot be read: {error}"))
}

/// `%20` and its like as the characters they stand for.
fn percent_decoded(uri: &str) -> String {
    let bytes = uri.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let code = bytes.get(at + 1..at + 3).and_then(|digits| std::str::from_utf8(digits).ok());
        match code.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) if bytes[at] == b'%' => {
                out.push(byte);
                at += 3;
            }
            _ => {
                out.push(bytes[at]);
                at += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}
