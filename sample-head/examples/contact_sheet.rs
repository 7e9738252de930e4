//! Writes a contact sheet of the sample head: `cargo run -p sample-head --example contact_sheet -- sheet.png [identity]
//! [view]`, where view is `front` (default), `turned`, `face`, `eyes`, `mouth` or `all` (every shape).

use face_math::data::Image;
use face_math::render::{Camera, Mark, Sheet, Style, draw_marks, render_rig};
use face_math::rig::{Puppet, SkinJawOptions, skin_jaw};
use glam::Vec3;
use sample_head::{Options, build};
use std::error::Error;
use std::fs::File;
use std::io::BufWriter;

const POSES: [(&str, &[(&str, f32)]); 18] = [
    ("neutral", &[]),
    ("smile", &[("mouthSmile", 1.0), ("cheekSquint", 0.4)]),
    ("blink", &[("eyeBlink", 1.0)]),
    ("jawOpen", &[("jawOpen", 1.0)]),
    ("pucker", &[("mouthPucker", 1.0)]),
    ("brow raise", &[("browInnerUp", 1.0), ("browOuterUp", 1.0)]),
    ("look left", &[("eyeLookOut_L", 1.0), ("eyeLookIn_R", 1.0)]),
    (
        "laugh",
        &[("mouthSmile", 0.9), ("jawOpen", 0.5), ("cheekSquint", 0.8), ("eyeSquint", 0.5), ("mouthUpperUp", 0.4)],
    ),
    ("anger", &[("browDown", 1.0), ("noseSneer", 0.7), ("mouthPress", 0.8), ("eyeSquint", 0.5)]),
    ("sad", &[("browInnerUp", 1.0), ("mouthFrown", 1.0), ("mouthShrugLower", 0.4), ("eyeLookDown", 0.3)]),
    ("surprise", &[("browInnerUp", 0.9), ("browOuterUp", 0.9), ("eyeWide", 1.0), ("jawOpen", 0.6)]),
    ("funnel", &[("mouthFunnel", 1.0), ("jawOpen", 0.2)]),
    ("stretch", &[("mouthStretch", 1.0), ("mouthLowerDown", 0.6)]),
    ("snarl", &[("noseSneer", 1.0), ("mouthUpperUp", 1.0)]),
    ("puff", &[("cheekPuff", 1.0)]),
    ("roll lips", &[("mouthRollLower", 1.0), ("mouthRollUpper", 1.0)]),
    ("mouth left", &[("mouthLeft", 1.0)]),
    ("jaw right", &[("jawRight", 1.0)]),
];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("say where to write the sheet: contact_sheet sheet.png [identity] [view]")?;
    let identity = arguments.next().map_or(Ok(0), |text| text.parse())?;
    let view = arguments.next().unwrap_or_else(|| "front".to_owned());

    let head = build(&Options { identity, ..Options::default() })?;
    let rig = skin_jaw(&head.rig, &SkinJawOptions::default())?.rig;
    let puppet = Puppet::new(&rig)?;
    let face = rig
        .part("face")
        .map_or(&rig.neutral[..], |part| &rig.neutral[part.vertices.start as usize..part.vertices.end as usize]);
    let front = Camera::framing(face).closer(1.05);
    let camera = match view.as_str() {
        "turned" => front.turned(0.65, 0.06),
        "side" => Camera::framing(&rig.neutral).turned(1.57, 0.0),
        "head" => Camera::framing(&rig.neutral).turned(0.5, 0.0),
        "eyes" => front.at(Vec3::new(0.0, 0.038, 0.09)).closer(2.4),
        "mouth" => front.at(Vec3::new(0.0, -0.03, 0.09)).closer(2.6).turned(0.35, 0.0),
        "below" => front.turned(0.3, -0.5),
        _ => front,
    };
    let size = if view == "all" { 200 } else { 300 };
    let style = Style::sized(size, size);
    let mut sheet = Sheet::new(if view == "all" { 9 } else { 6 });
    let mut show = |caption: &str, weights: &[f32], markers: bool| -> Result<(), Box<dyn Error>> {
        let positions = puppet.vertices(weights)?;
        let mut image = render_rig(&rig, &positions, &camera, &style)?;
        if markers {
            let points: Vec<Vec3> = head.marker_vertices.iter().map(|vertex| positions[*vertex as usize]).collect();
            draw_marks(&mut image, &camera, &points, &Mark::CAPTURED);
        }
        sheet.add(caption, image);
        Ok(())
    };
    if view == "all" {
        for (channel, name) in rig.channels.iter().enumerate() {
            let mut weights = vec![0.0; rig.channels.len()];
            weights[channel] = 1.0;
            show(name, &weights, false)?;
        }
    } else {
        for (caption, pose) in POSES {
            let mut weights = vec![0.0; rig.channels.len()];
            for (name, weight) in pose {
                for (channel, own) in rig.channels.iter().enumerate() {
                    if own == name || own.strip_suffix("_L") == Some(name) || own.strip_suffix("_R") == Some(name) {
                        weights[channel] = *weight;
                    }
                }
            }
            show(caption, &weights, view == "markers")?;
        }
    }
    write_png(&path, &sheet.compose())
}

fn write_png(path: &str, image: &Image) -> Result<(), Box<dyn Error>> {
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = png::Encoder::new(file, image.width_px() as u32, image.height_px() as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(image.pixels())?;
    Ok(())
}
