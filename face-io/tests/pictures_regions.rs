//! PNG pictures and files of regions: round trips, real ones, and damage.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod common;

use common::{bytes, data};
use face_io::{png, regions};
use face_math::data::Image;
use proptest::prelude::*;

fn picture(width: usize, height: usize) -> Image {
    let pixels = (0..width * height * 3).map(|i| (i * 37 % 251) as u8).collect();
    Image::new(width, height, pixels).unwrap()
}

/// A PNG of any colour type, made by the library.
fn encoded(colour: ::png::ColorType, depth: ::png::BitDepth, data: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut out, 2, 1);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    if colour == ::png::ColorType::Indexed {
        encoder.set_palette(vec![1, 2, 3, 4, 5, 6]);
    }
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    out
}

#[test]
fn pictures_of_all_colour_types_read() {
    use ::png::{BitDepth, ColorType};
    for (colour, depth, data, pixels) in [
        (ColorType::Rgb, BitDepth::Eight, vec![1, 2, 3, 4, 5, 6], [1, 2, 3, 4, 5, 6]),
        (ColorType::Rgba, BitDepth::Eight, vec![1, 2, 3, 0, 4, 5, 6, 255], [1, 2, 3, 4, 5, 6]),
        (ColorType::Grayscale, BitDepth::Eight, vec![7, 9], [7, 7, 7, 9, 9, 9]),
        (ColorType::GrayscaleAlpha, BitDepth::Eight, vec![7, 1, 9, 2], [7, 7, 7, 9, 9, 9]),
        (ColorType::Grayscale, BitDepth::One, vec![0b0100_0000], [0, 0, 0, 255, 255, 255]),
        (ColorType::Indexed, BitDepth::Eight, vec![1, 0], [4, 5, 6, 1, 2, 3]),
        (ColorType::Grayscale, BitDepth::Sixteen, vec![7, 200, 9, 1], [7, 7, 7, 9, 9, 9]),
    ] {
        let image = png::read(&encoded(colour, depth, &data)).unwrap();
        assert_eq!((image.width_px(), image.height_px(), image.pixels()), (2, 1, pixels.as_slice()), "{colour:?}");
    }
}

#[test]
fn pictures_without_pixels_and_lying_headers_are_refused() {
    assert!(png::write(&picture(0, 3)).unwrap_err().to_string().contains("width in pixels is 0"));
    let mut huge = png::write(&picture(4, 4)).unwrap();
    huge[16..20].copy_from_slice(&60_000_u32.to_be_bytes());
    huge[20..24].copy_from_slice(&60_000_u32.to_be_bytes());
    // The header's checksum is that of the small picture; the library may notice that first.
    assert!(png::read(&huge).is_err());
    assert!(png::read(b"").unwrap_err().to_string().contains("0 bytes"));
}

#[test]
fn regions_of_the_actor_keep_their_order() {
    let Some(data) = data() else { return };
    let file = bytes(data.join("actors/regions.json"));
    let read = regions::read(&file).unwrap();
    assert_eq!(read.regions.len(), 7);
    assert_eq!((read.regions[0].name.as_str(), read.regions[1].name.as_str()), ("upper-face", "lower-face"));
    assert_eq!(read.regions[0].channels.len(), 6);
    // JSON is a RON file too, once the reader knows both.
    let ron = format!("// the same\n{}", String::from_utf8(file).unwrap());
    assert_eq!(regions::read(ron.as_bytes()).unwrap(), read);
}

#[test]
fn regions_read_from_json_and_ron_alike() {
    let json = r#"{"z": {"markers": ["m"], "channels": ["c", "d"]}, "a": {"channels": [], "markers": []}}"#;
    let ron = "{\n    // brows first\n    \"z\": (markers: [\"m\"], channels: [\"c\", \"d\"]),\n    \
               \"a\": (channels: [], markers: []),\n}";
    let (json, ron) = (regions::read(json.as_bytes()).unwrap(), regions::read(ron.as_bytes()).unwrap());
    assert_eq!(json, ron);
    assert_eq!(json.regions.iter().map(|region| region.name.as_str()).collect::<Vec<_>>(), ["z", "a"]);
}

#[test]
fn mistakes_in_regions_are_named_with_their_place() {
    let error = |text: &str| regions::read(text.as_bytes()).unwrap_err().to_string();
    assert!(error("").contains("holds no regions"));
    assert!(error("{}").contains("holds no regions"));
    assert!(error("{\"a\": {\"markers\": [],\n \"chanels\": []}}").contains("2:10: unknown field `chanels`"));
    assert!(error("{\"a\": {\"markers\": []}}").contains("missing field `channels`"));
    assert!(error("{\"a\": (markers: [], channels: [1])}").contains("1:32"));
    assert!(error("{\"a\": (markers: [], chanels: [])}").contains("chanels"));
    let twice = error("{\"a\": {\"markers\": [], \"channels\": []},\n\"a\": {\"markers\": [], \"channels\": []}}");
    assert!(twice.contains("2:3: the region `a` stands twice"), "{twice}");
    assert!(error("{\"a\": {\"markers\": [\"m\", \"m\"], \"channels\": []}}").contains("the marker `m` stands twice"));
    assert!(error("{\"a\": {\"markers\": [\"m\"").contains("1:"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_picture_round_trips(width in 1_usize..30, height in 1_usize..30) {
        let image = picture(width, height);
        prop_assert_eq!(png::read(&png::write(&image).unwrap()).unwrap(), image);
    }

    #[test]
    fn no_damage_panics(at in 0_usize..2000, value: u8, end in 0_usize..2000) {
        let ron = "{ \"z\": (markers: [\"m\"], channels: [\"c\"]), \"a\": {\"markers\": [], \"channels\": []} }";
        for mut bytes in [png::write(&picture(9, 9)).unwrap(), ron.as_bytes().to_vec()] {
            let length = bytes.len();
            bytes[at % length] = value;
            for part in [&bytes[..], &bytes[..end % length]] {
                let _ = png::read(part);
                let _ = regions::read(part);
            }
        }
    }
}
