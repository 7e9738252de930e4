//! PNG pictures: 8-bit RGB out; RGB, grey, palette and alpha in.

use crate::{ReadError, WriteError};
use face_math::data::{DataError, Image};
use png::{BitDepth, ColorType, Decoder, Encoder, Transformations};
use std::io::Cursor;

/// Deflate stores at most this many bytes in one, so that larger pictures cannot be in a file.
const DENSEST: usize = 1032;

/// Why bytes are not a PNG picture that can be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PngError {
    /// The file is damaged or no PNG.
    #[error("{problem} (the file has {have} bytes); save the picture again")]
    Damaged {
        /// What is wrong.
        problem: String,
        /// How long the file is.
        have: usize,
    },
    /// The header announces more pixels than the file can hold.
    #[error("the header announces {width_px} x {height_px} px, more than {have} bytes can hold; the file is damaged")]
    Size {
        /// Width that is announced.
        width_px: u32,
        /// Height that is announced.
        height_px: u32,
        /// How long the file is.
        have: usize,
    },
}

/// Whether bytes begin as a PNG file.
pub fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89PNG\r\n\x1a\n")
}

/// Reads a PNG picture as 8-bit RGB. Grey becomes RGB, 16 bits become 8, alpha is left out.
///
/// # Errors
/// See [`PngError`].
pub fn read(bytes: &[u8]) -> Result<Image, ReadError> {
    let have = bytes.len();
    let damaged = |error: png::DecodingError| PngError::Damaged { problem: error.to_string(), have };
    let mut decoder = Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(Transformations::normalize_to_color8());
    let (width_px, height_px) = {
        let info = decoder.read_header_info().map_err(damaged)?;
        (info.width, info.height)
    };
    let too_large = || PngError::Size { width_px, height_px, have };
    // A pixel may take as little as one bit.
    let pixels = (width_px as usize).checked_mul(height_px as usize).ok_or_else(too_large)?;
    if pixels / 8 > have.saturating_mul(DENSEST) {
        return Err(too_large().into());
    }
    let mut reader = decoder.read_info().map_err(damaged)?;
    let mut buffer = vec![0; reader.output_buffer_size().ok_or_else(too_large)?];
    let frame = reader.next_frame(&mut buffer).map_err(damaged)?;
    let buffer = &buffer[..frame.buffer_size()];
    let rgb: Vec<u8> = match frame.color_type {
        ColorType::Rgb => buffer.to_vec(),
        ColorType::Rgba => buffer.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect(),
        ColorType::Grayscale => buffer.iter().flat_map(|grey| [*grey; 3]).collect(),
        ColorType::GrayscaleAlpha => buffer.chunks_exact(2).flat_map(|p| [p[0]; 3]).collect(),
        ColorType::Indexed => {
            let problem = "its palette could not be resolved".to_owned();
            return Err(PngError::Damaged { problem, have }.into());
        }
    };
    Ok(Image::new(frame.width as usize, frame.height as usize, rgb)?)
}

/// Writes a picture as 8-bit RGB PNG, tagged as sRGB.
///
/// # Errors
/// Where a side is 0 or beyond what the format holds.
pub fn write(image: &Image) -> Result<Vec<u8>, WriteError> {
    let side = |what: &str, length: usize| {
        let high = i32::MAX as usize;
        if (1..=high).contains(&length) {
            Ok(length as u32)
        } else {
            let (value, high) = (length as f64, high as f64);
            Err(WriteError::Range { format: "PNG", what: what.to_owned(), value, low: 1.0, high })
        }
    };
    let (width, height) = (side("width in pixels", image.width_px())?, side("height in pixels", image.height_px())?);
    let mut out = Vec::new();
    let mut encoder = Encoder::new(&mut out, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    // Into memory, with sizes checked above, the encoder has nothing left to refuse but a wrong number of bytes.
    let wrong = |_| DataError::Size {
        what: "image bytes",
        expected: image.width_px() * image.height_px() * 3,
        found: image.pixels().len(),
    };
    let mut writer = encoder.write_header().map_err(wrong)?;
    writer.write_image_data(image.pixels()).map_err(wrong)?;
    writer.finish().map_err(wrong)?;
    Ok(out)
}
