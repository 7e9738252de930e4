//! Accessors: typed arrays in buffers, dense or sparse, plain or normalised, with their bounds checked.

use super::GltfError;
use super::container::File;
use gltf_json::accessor::{Accessor, ComponentType, Type};
use gltf_json::buffer::View;
use gltf_json::validation::Checked;
use gltf_json::{Index, accessor};

/// One accessor of a file, and who uses it.
pub(super) struct Array<'a> {
    file: &'a File,
    accessor: &'a Accessor,
    index: usize,
    place: &'a str,
    component: ComponentType,
}

impl<'a> Array<'a> {
    /// Finds an accessor for the user `place` (for example ``mesh `head`, primitive 0, POSITION``).
    pub fn open(file: &'a File, index: Index<Accessor>, place: &'a str) -> Result<Self, GltfError> {
        let count = file.root.accessors.len();
        let index = index.value();
        let from = || place.to_owned();
        let accessor = file.root.accessors.get(index).ok_or_else(|| GltfError::Reference {
            from: from(),
            kind: "accessor",
            index,
            count,
        })?;
        let Checked::Valid(accessor::GenericComponentType(component)) = accessor.component_type else {
            return Err(GltfError::Accessor {
                place: from(),
                accessor: index,
                problem: "unknown componentType".into(),
            });
        };
        Ok(Self { file, accessor, index, place, component })
    }

    /// How many elements there are.
    pub fn count(&self) -> Result<usize, GltfError> {
        let count = self.accessor.count.0;
        // What no buffer backs cannot be checked against one; a mesh always has other bytes for each of its vertices.
        if self.accessor.buffer_view.is_none() && count > self.file.byte_count() as u64 {
            return Err(self.wrong(format!("{count} elements are more than the file has bytes")));
        }
        usize::try_from(count).map_err(|_| self.wrong(format!("{count} elements are more than memory holds")))
    }

    /// An error about this accessor.
    pub fn wrong(&self, problem: String) -> GltfError {
        GltfError::Accessor { place: self.place.to_owned(), accessor: self.index, problem }
    }

    /// All elements as vectors of `N` finite floats.
    pub fn floats<const N: usize>(&self) -> Result<Vec<[f32; N]>, GltfError> {
        self.check_type(N)?;
        let width = component_size(self.component) * N;
        let read = |bytes: &[u8]| {
            std::array::from_fn(|axis| {
                float(&bytes[axis * component_size(self.component)..], self.component, self.accessor.normalized)
            })
        };
        let elements = self.elements(width, [0.0; N], read)?;
        if let Some(at) = elements.iter().position(|element: &[f32; N]| !element.iter().all(|x| x.is_finite())) {
            return Err(self.wrong(format!("element {at} is not finite")));
        }
        Ok(elements)
    }

    /// All elements as vectors of `N` unsigned integers.
    pub fn integers<const N: usize>(&self) -> Result<Vec<[u32; N]>, GltfError> {
        self.check_type(N)?;
        let component = self.component;
        if !matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
            return Err(self.wrong(format!("its components are {component:?}, unsigned integers are needed")));
        }
        let size = component_size(component);
        let read = |bytes: &[u8]| std::array::from_fn(|axis| unsigned(&bytes[axis * size..], component));
        self.elements(size * N, [0; N], read)
    }

    fn check_type(&self, components: usize) -> Result<(), GltfError> {
        let found = match self.accessor.type_ {
            Checked::Valid(Type::Scalar) => 1,
            Checked::Valid(Type::Vec2) => 2,
            Checked::Valid(Type::Vec3) => 3,
            Checked::Valid(Type::Vec4 | Type::Mat2) => 4,
            Checked::Valid(Type::Mat3) => 9,
            Checked::Valid(Type::Mat4) => 16,
            Checked::Invalid => return Err(self.wrong("unknown type".into())),
        };
        if found == components {
            Ok(())
        } else {
            Err(self.wrong(format!("its elements have {found} components, {components} are needed")))
        }
    }

    fn elements<T: Clone>(&self, width: usize, zero: T, read: impl Fn(&[u8]) -> T) -> Result<Vec<T>, GltfError> {
        let count = self.count()?;
        let mut elements = match self.accessor.buffer_view {
            None => vec![zero; count],
            Some(view) => {
                let offset = self.accessor.byte_offset.map_or(0, |offset| offset.0);
                self.run(view, offset, count, width, "its elements")?.map(&read).collect()
            }
        };
        if let Some(sparse) = &self.accessor.sparse {
            let overrides = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
            if overrides > count {
                return Err(self.wrong(format!("{overrides} sparse elements of {count}")));
            }
            let Checked::Valid(accessor::IndexComponentType(kind)) = sparse.indices.component_type else {
                return Err(self.wrong("its sparse indices have an unknown componentType".into()));
            };
            let indices = &sparse.indices;
            let indices = self.run(
                indices.buffer_view,
                indices.byte_offset.0,
                overrides,
                component_size(kind),
                "its sparse indices",
            )?;
            let values = &sparse.values;
            let values = self.run(values.buffer_view, values.byte_offset.0, overrides, width, "its sparse values")?;
            for (at, (index, value)) in indices.zip(values).enumerate() {
                let index = unsigned(index, kind) as usize;
                let slot = elements
                    .get_mut(index)
                    .ok_or_else(|| self.wrong(format!("sparse index {at} is {index} where there are {count}")))?;
                *slot = read(value);
            }
        }
        Ok(elements)
    }

    /// The bytes of `count` elements of `width` bytes in a buffer view.
    fn run(
        &self,
        view: Index<View>,
        offset: u64,
        count: usize,
        width: usize,
        what: &str,
    ) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, GltfError> {
        let root = &self.file.root;
        let missing = |kind, index, count| GltfError::Reference {
            from: format!("{}, accessor {}", self.place, self.index),
            kind,
            index,
            count,
        };
        let view_index = view.value();
        let view = root
            .buffer_views
            .get(view_index)
            .ok_or_else(|| missing("buffer view", view_index, root.buffer_views.len()))?;
        let buffer_index = view.buffer.value();
        let buffer = self
            .file
            .buffers
            .get(buffer_index)
            .ok_or_else(|| missing("buffer", buffer_index, self.file.buffers.len()))?;
        let number = |number: u64| usize::try_from(number).unwrap_or(usize::MAX);
        let begin = number(view.byte_offset.map_or(0, |offset| offset.0));
        let bytes = begin
            .checked_add(number(view.byte_length.0))
            .and_then(|end| buffer.get(begin..end))
            .ok_or_else(|| {
                let (length, have) = (view.byte_length.0, buffer.len());
                self.wrong(format!(
                    "buffer view {view_index} takes {length} bytes from {begin}, but buffer {buffer_index} ends at {have}"
                ))
            })?;
        let stride = view.byte_stride.map_or(width, |stride| stride.0);
        if stride < width {
            return Err(self.wrong(format!("buffer view {view_index} has a stride of {stride}, below {width}")));
        }
        let offset = number(offset);
        let need = match count {
            0 => Some(0),
            _ => (count - 1).checked_mul(stride).and_then(|n| n.checked_add(width)).and_then(|n| n.checked_add(offset)),
        };
        let bytes =
            need.filter(|need| *need <= bytes.len()).map(|need| &bytes[offset.min(need)..need]).ok_or_else(|| {
                let have = bytes.len();
                self.wrong(format!("{what} ({count} from byte {offset}) pass the {have} bytes of view {view_index}"))
            })?;
        Ok(bytes.chunks(stride.max(1)).take(count).map(move |chunk| &chunk[..width]))
    }
}

fn component_size(component: ComponentType) -> usize {
    match component {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    }
}

fn unsigned(bytes: &[u8], component: ComponentType) -> u32 {
    match component_size(component) {
        1 => u32::from(bytes[0]),
        2 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        _ => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    }
}

/// A component as a float; normalised integers as the specification's section 3.6.2.2 has it:
/// f = c / 255, c / 65535, max(c / 127, -1), max(c / 32767, -1).
fn float(bytes: &[u8], component: ComponentType, normalized: bool) -> f32 {
    let (value, full) = match component {
        ComponentType::I8 => (f32::from(bytes[0].cast_signed()), 127.0),
        ComponentType::U8 => (f32::from(bytes[0]), 255.0),
        ComponentType::I16 => (f32::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32_767.0),
        ComponentType::U16 => (f32::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65_535.0),
        ComponentType::U32 => return unsigned(bytes, component) as f32,
        ComponentType::F32 => return f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    };
    if normalized { (value / full).max(-1.0) } else { value }
}
