//! A built-in font of 5 × 7 pixels, for captions on pictures.

use crate::data::Image;

/// Width of a letter, with the gap to the next, in pixels at scale 1.
pub const GLYPH_WIDTH_PX: usize = 6;
/// Height of a line, with the gap to the next, in pixels at scale 1.
pub const GLYPH_HEIGHT_PX: usize = 10;

/// The printable ASCII characters from space on: seven rows of five bits each, top row and left column highest.
const GLYPHS: [u64; 95] = [
    0x0_0000_0000,
    0x1_0842_1004,
    0x2_9400_0000,
    0x2_bea5_7d40,
    0x1_1f47_17c4,
    0x6_7442_2e60,
    0x3_24ca_c9a0,
    0x1_0800_0000,
    0x0_8842_1082,
    0x2_0842_1088,
    0x0_2aef_baa0,
    0x0_084f_9080,
    0x0_0000_1088,
    0x0_0007_0000,
    0x0_0000_00c6,
    0x0_4422_2110,
    0x3_a33a_e62e,
    0x1_1842_108e,
    0x3_a213_221f,
    0x7_8217_043e,
    0x0_8ca9_7c42,
    0x7_e1e0_862e,
    0x1_910f_462e,
    0x7_c222_1108,
    0x3_a317_462e,
    0x3_a317_844c,
    0x0_0840_1080,
    0x0_0840_1088,
    0x0_8888_2082,
    0x0_01f0_7c00,
    0x2_0820_8888,
    0x3_a211_1004,
    0x3_a37a_da0e,
    0x3_a31f_c631,
    0x7_a31f_463e,
    0x3_a308_422e,
    0x7_2518_c65c,
    0x7_e10f_421f,
    0x7_e10f_4210,
    0x3_a30b_c62e,
    0x4_631f_c631,
    0x3_8842_108e,
    0x1_c421_0a4c,
    0x4_654c_5251,
    0x4_2108_421f,
    0x4_775a_c631,
    0x4_735a_ce31,
    0x3_a318_c62e,
    0x7_a31f_4210,
    0x3_a318_d64d,
    0x7_a31f_5251,
    0x3_e107_043e,
    0x7_c842_1084,
    0x4_6318_c62e,
    0x4_6318_a944,
    0x4_631a_d771,
    0x4_62a2_2a31,
    0x4_62a2_1084,
    0x7_c222_221f,
    0x3_9084_210e,
    0x4_1082_0841,
    0x3_8421_084e,
    0x1_1510_0000,
    0x0_0000_001f,
    0x2_0800_0000,
    0x0_00e0_be2f,
    0x4_21e8_c63e,
    0x0_00e8_422e,
    0x0_42f8_c62f,
    0x0_00e8_fe0e,
    0x1_91e4_2108,
    0x0_00f8_bc2e,
    0x4_21e8_c631,
    0x1_00c2_108e,
    0x0_8061_0a4c,
    0x2_1095_3149,
    0x3_0842_108e,
    0x0_01aa_d6b1,
    0x0_01e8_c631,
    0x0_00e8_c62e,
    0x0_01e8_fa10,
    0x0_00f8_bc21,
    0x0_016c_c210,
    0x0_00f8_383e,
    0x2_11e4_2126,
    0x0_0118_c62f,
    0x0_0118_a944,
    0x0_011a_d6aa,
    0x0_0115_1151,
    0x0_0118_bc2e,
    0x0_01f1_111f,
    0x0_c844_1083,
    0x1_0842_1084,
    0x6_0841_1098,
    0x0_009b_0000,
];

/// Writes `text` with its top left corner at `(left_px, top_px)`; what falls outside the picture is cut off.
///
/// Characters outside printable ASCII show as `?`.
pub fn draw_text(image: &mut Image, left_px: usize, top_px: usize, scale: usize, colour: [u8; 3], text: &str) {
    let (width, height) = (image.width_px(), image.height_px());
    for (place, character) in text.chars().enumerate() {
        let code = if (' '..='~').contains(&character) { character } else { '?' };
        let glyph = GLYPHS[code as usize - ' ' as usize];
        for bit in (0..35usize).filter(|bit| glyph >> (34 - bit) & 1 == 1) {
            let x0 = left_px + (place * GLYPH_WIDTH_PX + bit % 5) * scale;
            let y0 = top_px + bit / 5 * scale;
            for (x, y) in (0..scale * scale).map(|i| (x0 + i % scale, y0 + i / scale)) {
                if x < width && y < height {
                    let start = (y * width + x) * 3;
                    image.pixels_mut()[start..start + 3].copy_from_slice(&colour);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_differ_and_stay_inside() {
        let mut seen = std::collections::BTreeSet::new();
        assert!(GLYPHS.iter().all(|glyph| *glyph < 1 << 35 && seen.insert(*glyph)));
        let mut image = Image::filled(9, 9, [0; 3]);
        draw_text(&mut image, 0, 0, 1, [255; 3], "I\u{e9}");
        assert_eq!(&image.pixels()[3..6], &[255; 3]);
    }
}
