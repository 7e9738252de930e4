//! Images: 8-bit RGB pictures, as the rasteriser draws and PNG files hold them.

use super::{DataError, check_size};
use wire::{Data, DecodeError, Decoder, Encoder, Table, Value, ValueKind};

/// An 8-bit sRGB picture, rows from the top, three bytes a pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    width_px: usize,
    height_px: usize,
    pixels: Vec<u8>,
}

impl Image {
    /// Makes a picture from `width × height × 3` bytes.
    ///
    /// # Errors
    /// Where the number of bytes does not fit.
    pub fn new(width_px: usize, height_px: usize, pixels: Vec<u8>) -> Result<Self, DataError> {
        check_size("image bytes", width_px * height_px * 3, pixels.len())?;
        Ok(Self { width_px, height_px, pixels })
    }

    /// A picture of one colour.
    pub fn filled(width_px: usize, height_px: usize, colour: [u8; 3]) -> Self {
        Self { width_px, height_px, pixels: colour.repeat(width_px * height_px) }
    }

    /// Width in pixels.
    pub fn width_px(&self) -> usize {
        self.width_px
    }

    /// Height in pixels.
    pub fn height_px(&self) -> usize {
        self.height_px
    }

    /// The bytes, rows from the top.
    pub fn pixels(&self) -> &[u8] {
        &self.pixels
    }

    /// The bytes, to draw on.
    pub fn pixels_mut(&mut self) -> &mut [u8] {
        &mut self.pixels
    }
}

impl Value for Image {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.count(self.width_px);
        out.count(self.height_px);
        out.blob(&self.pixels);
    }

    fn summary(&self) -> String {
        format!("{} x {} px, 8-bit RGB", self.width_px, self.height_px)
    }

    fn size(&self) -> usize {
        self.pixels.len()
    }

    fn tables(&self) -> Vec<Table<'_>> {
        super::tables::image(self)
    }
}

impl Data for Image {
    const NAME: &'static str = "Image";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        let (width_px, height_px) = (input.count()?, input.count()?);
        let pixels = input.blob()?.to_vec();
        Self::new(width_px, height_px, pixels).map_err(|error| DecodeError::Invalid { what: error.to_string() })
    }
}
