//! The [`Value`] trait itself, and [`ValueKind`], the facts of a value type that travel without a value.

use crate::{DecodeError, Decoder, Digest, Encoder, FrameAxis, Table};
use std::any::Any;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

/// Something immutable that flows on a wire.
pub trait Value: Any + Debug + Send + Sync {
    /// The facts of this value's type.
    fn kind(&self) -> ValueKind;

    /// Writes the stable encoding. Equal values write equal bytes on every machine.
    fn encode(&self, out: &mut Encoder);

    /// One line for people: shape, range, units.
    fn summary(&self) -> String;

    /// Bytes it occupies in memory, roughly.
    fn size(&self) -> usize;

    /// The frame axis of a time-varying value.
    fn axis(&self) -> Option<FrameAxis> {
        None
    }

    /// The frames at positions `frames` of a time-varying value; `None` for all others.
    fn slice(&self, frames: Range<usize>) -> Option<Arc<dyn Value>> {
        let _ = frames;
        None
    }

    /// Its numbers by names and with units, for snapshots: what two machines may differ in, and by how much. A type without
    /// tables has one meaning an encoding, and is compared by its digest.
    fn tables(&self) -> Vec<Table<'_>> {
        Vec::new()
    }
}

impl dyn Value {
    /// The encoding as one run of bytes.
    pub fn encoded(&self) -> Vec<u8> {
        let mut encoder = Encoder::default();
        self.encode(&mut encoder);
        encoder.finish()
    }

    /// The value as the concrete type `T`.
    pub fn downcast_ref<T: Value>(&self) -> Option<&T> {
        (self as &dyn Any).downcast_ref()
    }

    /// The shared value as the concrete type `T`.
    pub fn downcast_arc<T: Value>(self: Arc<Self>) -> Option<Arc<T>> {
        let any: Arc<dyn Any + Send + Sync> = self;
        any.downcast().ok()
    }
}

/// Why slices could not be joined into one value.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum JoinError {
    /// The type does not vary over time.
    #[error("{0} has no frames to join")]
    NotFramed(&'static str),
    /// Two slices disagree about what every frame holds (names, channels …).
    #[error("slice {index} of {kind} differs from the first in its {what}")]
    Differs {
        /// Type of the value.
        kind: &'static str,
        /// Position of the slice that differs.
        index: usize,
        /// What differs.
        what: &'static str,
    },
    /// No slice was given.
    #[error("no slices of {0} to join")]
    Empty(&'static str),
}

/// A concrete value type: [`Value`] plus what is known of the type without a value in hand.
pub trait Data: Value + Sized {
    /// Name of the type in graphs and messages, for example `Markers`.
    const NAME: &'static str;
    /// Version of the encoding; raise it whenever [`Value::encode`] changes.
    const VERSION: u32;
    /// Whether the type varies over time (has an axis, can be sliced and joined).
    const FRAMED: bool;

    /// Reads the encoding back.
    ///
    /// # Errors
    /// Where the bytes are not what [`Value::encode`] of this version writes.
    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError>;

    /// Joins consecutive slices.
    ///
    /// # Errors
    /// Where the slices do not belong together, or the type does not vary over time.
    fn join(slices: &[&Self]) -> Result<Self, JoinError> {
        let _ = slices;
        Err(JoinError::NotFramed(Self::NAME))
    }
}

/// Reads one value back from a whole run of bytes.
type DecodeValue = fn(&[u8]) -> Result<Arc<dyn Value>, DecodeError>;

/// Joins consecutive slices of one value.
type JoinValues = fn(&[Arc<dyn Value>]) -> Result<Arc<dyn Value>, JoinError>;

/// The facts of a value type, as plain data and function pointers.
#[derive(Clone, Copy)]
pub struct ValueKind {
    /// [`Data::NAME`].
    pub name: &'static str,
    /// [`Data::VERSION`].
    pub version: u32,
    /// [`Data::FRAMED`].
    pub framed: bool,
    /// [`Data::decode`] over a whole run of bytes.
    pub decode: DecodeValue,
    /// [`Data::join`] over slices of this type.
    pub join: JoinValues,
}

impl ValueKind {
    /// The facts of `T`.
    pub const fn of<T: Data>() -> Self {
        Self { name: T::NAME, version: T::VERSION, framed: T::FRAMED, decode: decode::<T>, join: join::<T> }
    }

    /// The digest of an encoding of this type.
    pub fn digest(&self, encoding: &[u8]) -> Digest {
        Self::digest_named(self.name, self.version, encoding)
    }

    /// The same for a type of which only name and version are known.
    pub fn digest_named(name: &str, version: u32, encoding: &[u8]) -> Digest {
        crate::Hasher::new(name).number(u64::from(version)).bytes(encoding).finish()
    }
}

impl Debug for ValueKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} v{}", self.name, self.version)
    }
}

impl PartialEq for ValueKind {
    fn eq(&self, other: &Self) -> bool {
        (std::ptr::eq(self.name, other.name) || self.name == other.name) && self.version == other.version
    }
}

impl Eq for ValueKind {}

fn decode<T: Data>(bytes: &[u8]) -> Result<Arc<dyn Value>, DecodeError> {
    let mut decoder = Decoder::new(bytes);
    let value = T::decode(&mut decoder)?;
    decoder.finish(T::NAME)?;
    Ok(Arc::new(value))
}

fn join<T: Data>(slices: &[Arc<dyn Value>]) -> Result<Arc<dyn Value>, JoinError> {
    let mut typed = Vec::with_capacity(slices.len());
    for (index, slice) in slices.iter().enumerate() {
        let slice = slice.downcast_ref::<T>().ok_or(JoinError::Differs { kind: T::NAME, index, what: "type" })?;
        typed.push(slice);
    }
    if typed.is_empty() {
        return Err(JoinError::Empty(T::NAME));
    }
    Ok(Arc::new(T::join(&typed)?))
}
