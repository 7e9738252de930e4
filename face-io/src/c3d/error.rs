//! What can be wrong with a C3D file, with the place where it is wrong.

use crate::units::LengthUnit;

/// Why bytes are not a C3D file that can be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum C3dError {
    /// Nothing at all.
    #[error("the file is empty; export the take again")]
    Empty,
    /// The first bytes are not those of a C3D file.
    #[error("byte 1 is {found:#04x} where a C3D file has 0x50; this is no C3D file")]
    NoC3d {
        /// The byte found.
        found: u8,
    },
    /// The processor byte is unknown.
    #[error(
        "byte {at}: processor {found} is unknown (84 Intel, 85 DEC, 86 SGI/MIPS); the parameters are damaged or stand \
         elsewhere than the header says"
    )]
    Processor {
        /// Where the byte stands.
        at: usize,
        /// The byte found.
        found: u8,
    },
    /// The file ends inside something.
    #[error(
        "the file ends at byte {have}, but {what} begins at byte {begins} and is {length} bytes long; the file was cut \
         short, copy or export it again"
    )]
    Short {
        /// What is cut.
        what: String,
        /// Where it begins.
        begins: usize,
        /// How long it is.
        length: usize,
        /// Where the file ends.
        have: usize,
    },
    /// The file ends before its last frame.
    #[error(
        "the file ends at byte {have}, but frame {frame} of {frames} begins at byte {begins} and is {length} bytes \
         long ({source_of_count} says {frames} frames); the file was cut short, copy or export it again"
    )]
    ShortFrames {
        /// The first frame that is cut, counted from 1.
        frame: u64,
        /// How many frames there should be.
        frames: u64,
        /// Which field says so.
        source_of_count: &'static str,
        /// Where that frame begins.
        begins: u64,
        /// How long a frame is.
        length: u64,
        /// Where the file ends.
        have: usize,
    },
    /// A parameter's record does not fit where it stands.
    #[error("byte {at}: parameter {name}: {what}")]
    Record {
        /// Where the record begins.
        at: usize,
        /// Name of the parameter, as far as known.
        name: String,
        /// What is wrong.
        what: String,
    },
    /// A parameter (or header field) has a value that cannot be.
    #[error("byte {at}: {name} is {value}: {what}")]
    Value {
        /// Where it stands: the record of the parameter, or the word of the header.
        at: usize,
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: String,
        /// What is wrong with it, and what would be right.
        what: &'static str,
    },
    /// A parameter and the header disagree about what a frame looks like, and the length of the file supports neither.
    #[error(
        "byte {at}: {name} says {value}, the header {header}, and neither explains how long the file is; it is damaged, \
         export it again"
    )]
    Contradiction {
        /// Where the parameter's record begins.
        at: usize,
        /// Name of the parameter.
        name: &'static str,
        /// What it says.
        value: String,
        /// What the header says.
        header: String,
    },
    /// The unit of length is unknown.
    #[error(
        "byte {at}: POINT:UNITS is `{unit}`, which is no length known here ({}); correct it in the file",
        LengthUnit::KNOWN
    )]
    Unit {
        /// Where the parameter's record begins.
        at: usize,
        /// The unit as it stands in the file.
        unit: String,
    },
}
