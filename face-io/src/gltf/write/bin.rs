//! The binary chunk of a GLB file, with the views and accessors into it, and the container around both.

use crate::WriteError;
use glam::Vec3;
use serde_json::{Value, json};

const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;
const U8: u32 = 5121;
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;

/// Bytes of JSON that a sparse accessor costs more than a dense one, roughly.
const SPARSE_JSON: usize = 350;

/// Collects arrays. Each method answers with the index of an accessor.
#[derive(Default)]
pub(super) struct Bin {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    /// View of zeros, and for how many points it has room.
    zeros: Option<(usize, usize)>,
}

impl Bin {
    fn view(&mut self, bytes: impl IntoIterator<Item = u8>, target: Option<u32>) -> usize {
        let begin = self.bytes.len();
        self.bytes.extend(bytes);
        let mut view = json!({ "buffer": 0, "byteOffset": begin, "byteLength": self.bytes.len() - begin });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> Result<usize, WriteError> {
        // One number bounds all others of the file: GLB counts its bytes in 32 bits.
        let limit = u32::MAX / 2;
        if self.bytes.len() > limit as usize {
            return Err(WriteError::Range {
                format: super::FORMAT,
                what: "size of the file in bytes".into(),
                value: self.bytes.len() as f64,
                low: 0.0,
                high: limit.into(),
            });
        }
        self.accessors.push(accessor);
        Ok(self.accessors.len() - 1)
    }

    fn dense(&mut self, floats: &[f32], kind: &str, count: usize, target: Option<u32>) -> Result<usize, WriteError> {
        let view = self.view(floats.iter().flat_map(|float| float.to_le_bytes()), target);
        self.accessor(json!({ "bufferView": view, "componentType": F32, "count": count, "type": kind }))
    }

    /// Positions of vertices, with their bounds.
    pub fn positions(&mut self, points: &[Vec3]) -> Result<usize, WriteError> {
        let floats: Vec<f32> = points.iter().flat_map(Vec3::to_array).collect();
        let index = self.dense(&floats, "VEC3", points.len(), Some(ARRAY_BUFFER))?;
        self.bound(index, points.iter().copied());
        Ok(index)
    }

    fn bound(&mut self, accessor: usize, points: impl Iterator<Item = Vec3>) {
        let (low, high) =
            points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)));
        self.accessors[accessor]["min"] = json!(low.to_array());
        self.accessors[accessor]["max"] = json!(high.to_array());
    }

    /// Normals of vertices.
    pub fn normals(&mut self, normals: &[Vec3]) -> Result<usize, WriteError> {
        let floats: Vec<f32> = normals.iter().flat_map(Vec3::to_array).collect();
        self.dense(&floats, "VEC3", normals.len(), Some(ARRAY_BUFFER))
    }

    /// Texture coordinates of vertices.
    pub fn uvs(&mut self, uvs: &[[f32; 2]]) -> Result<usize, WriteError> {
        self.dense(uvs.as_flattened(), "VEC2", uvs.len(), Some(ARRAY_BUFFER))
    }

    /// Weights of four joints a vertex.
    pub fn joint_weights(&mut self, weights: &[[f32; 4]]) -> Result<usize, WriteError> {
        self.dense(weights.as_flattened(), "VEC4", weights.len(), Some(ARRAY_BUFFER))
    }

    /// Numbers of four joints a vertex.
    pub fn joints(&mut self, joints: &[[u8; 4]]) -> Result<usize, WriteError> {
        let view = self.view(joints.as_flattened().iter().copied(), Some(ARRAY_BUFFER));
        self.accessor(json!({ "bufferView": view, "componentType": U8, "count": joints.len(), "type": "VEC4" }))
    }

    /// Corners of triangles among `vertices` vertices.
    pub fn corners(&mut self, corners: &[u32], vertices: usize) -> Result<usize, WriteError> {
        let (view, component) = self.indices(corners, vertices, Some(ELEMENT_ARRAY_BUFFER));
        let count = corners.len();
        self.accessor(json!({ "bufferView": view, "componentType": component, "count": count, "type": "SCALAR" }))
    }

    /// Indices below `limit`, in 16 bits where they fit (65,535 itself is reserved).
    fn indices(&mut self, indices: &[u32], limit: usize, target: Option<u32>) -> (usize, u32) {
        if limit <= 65_535 {
            (self.view(indices.iter().flat_map(|index| (*index as u16).to_le_bytes()), target), U16)
        } else {
            (self.view(indices.iter().flat_map(|index| index.to_le_bytes()), target), U32)
        }
    }

    /// Displacements of some of `count` vertices: all of them, or only those, whichever is smaller.
    pub fn displacements(&mut self, count: usize, moved: &[u32], by: &[Vec3]) -> Result<usize, WriteError> {
        let index = if moved.is_empty() {
            let view = self.zeros(count);
            self.accessor(json!({ "bufferView": view, "componentType": F32, "count": count, "type": "VEC3" }))?
        } else if moved.len() * 16 + SPARSE_JSON < count * 12 {
            let (indices, component) = self.indices(moved, count, None);
            let values = self.view(by.iter().flat_map(Vec3::to_array).flat_map(f32::to_le_bytes), None);
            self.accessor(json!({
                "componentType": F32,
                "count": count,
                "type": "VEC3",
                "sparse": {
                    "count": moved.len(),
                    "indices": { "bufferView": indices, "componentType": component },
                    "values": { "bufferView": values },
                },
            }))?
        } else {
            let mut dense = vec![Vec3::ZERO; count];
            moved.iter().zip(by).for_each(|(vertex, delta)| dense[*vertex as usize] = *delta);
            let floats: Vec<f32> = dense.iter().flat_map(Vec3::to_array).collect();
            self.dense(&floats, "VEC3", count, Some(ARRAY_BUFFER))?
        };
        let still = (moved.len() < count).then_some(Vec3::ZERO);
        self.bound(index, by.iter().copied().chain(still));
        Ok(index)
    }

    /// A view of zeros for `count` points. Some readers refuse accessors without a view, which would be zeros too.
    fn zeros(&mut self, count: usize) -> usize {
        match self.zeros {
            Some((view, room)) if room >= count => view,
            _ => {
                let view = self.view(std::iter::repeat_n(0, count * 12), Some(ARRAY_BUFFER));
                // Several accessors use it, and then the distance between elements must be said.
                self.views[view]["byteStride"] = json!(12);
                self.zeros = Some((view, count));
                view
            }
        }
    }

    /// Inverse bind matrices that only translate.
    pub fn matrices(&mut self, translations: &[Vec3]) -> Result<usize, WriteError> {
        let floats: Vec<f32> =
            translations.iter().flat_map(|by| glam::Mat4::from_translation(*by).to_cols_array()).collect();
        self.dense(&floats, "MAT4", translations.len(), None)
    }

    /// Times of keys in seconds, ascending.
    pub fn times(&mut self, times_s: &[f32]) -> Result<usize, WriteError> {
        let index = self.dense(times_s, "SCALAR", times_s.len(), None)?;
        self.accessors[index]["min"] = json!([times_s.first()]);
        self.accessors[index]["max"] = json!([times_s.last()]);
        Ok(index)
    }

    /// Plain numbers.
    pub fn scalars(&mut self, numbers: &[f32]) -> Result<usize, WriteError> {
        self.dense(numbers, "SCALAR", numbers.len(), None)
    }

    /// Keys of a translation.
    pub fn points(&mut self, points: &[Vec3]) -> Result<usize, WriteError> {
        let floats: Vec<f32> = points.iter().flat_map(Vec3::to_array).collect();
        self.dense(&floats, "VEC3", points.len(), None)
    }

    /// Keys of a rotation.
    pub fn quaternions(&mut self, rotations: &[[f32; 4]]) -> Result<usize, WriteError> {
        self.dense(rotations.as_flattened(), "VEC4", rotations.len(), None)
    }

    /// The whole file: header, `json` with views and accessors filled in, and the bytes.
    pub fn finish(self, mut json: Value) -> Result<Vec<u8>, WriteError> {
        json["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        json["bufferViews"] = Value::Array(self.views);
        json["accessors"] = Value::Array(self.accessors);
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + text.len() + 8 + self.bytes.len();
        let word = |number: usize| {
            u32::try_from(number).map(u32::to_le_bytes).map_err(|_| WriteError::Range {
                format: super::FORMAT,
                what: "size of the file in bytes".into(),
                value: number as f64,
                low: 0.0,
                high: u32::MAX.into(),
            })
        };
        let mut out = Vec::with_capacity(length);
        out.extend(b"glTF");
        out.extend(2_u32.to_le_bytes());
        out.extend(word(length)?);
        out.extend(word(text.len())?);
        out.extend(b"JSON");
        out.extend(&text);
        out.extend(word(self.bytes.len())?);
        out.extend(b"BIN\0");
        out.extend(&self.bytes);
        Ok(out)
    }
}
