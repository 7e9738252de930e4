//! throw-away
use face_math::render::*;
use face_math::rig::*;
use glam::Vec3;
use sample_head::*;
fn main() {
    let a: Vec<String> = std::env::args().skip(1).collect();
    let size: usize = a[1].parse().unwrap();
    let cols: usize = a[2].parse().unwrap();
    let mut sheet = Sheet::new(cols);
    let mut cache = std::collections::BTreeMap::new();
    for spec in &a[3..] {
        // view:identity:pose=..,pose=..
        let mut it = spec.split(':');
        let view = it.next().unwrap();
        let id: u64 = it.next().unwrap().parse().unwrap();
        let pose = it.next().unwrap_or("");
        let head = cache.entry(id).or_insert_with(|| {
            let t = std::time::Instant::now();
            let h = build(&Options { identity: id, ..Default::default() }).unwrap();
            eprintln!("build {:?}", t.elapsed());
            let r = skin_jaw(&h.rig, &SkinJawOptions::default()).unwrap().rig;
            (h, r)
        });
        let rig = &head.1;
        let mut w = vec![0.0; 53];
        for p in pose.split(',').filter(|p| !p.is_empty()) {
            let (n, v) = p.split_once('=').unwrap();
            for (i, c) in rig.channels.iter().enumerate() {
                if c == n || c.strip_suffix("_L") == Some(n) || c.strip_suffix("_R") == Some(n) {
                    w[i] = v.parse().unwrap();
                }
            }
        }
        let pos = Puppet::new(rig).unwrap().vertices(&w).unwrap();
        let fp = rig.part("face").unwrap();
        let front = Camera::framing(&rig.neutral[fp.vertices.start as usize..fp.vertices.end as usize]);
        let all = Camera::framing(&rig.neutral);
        let eye = front.at(Vec3::new(0.031, 0.036, 0.09)).closer(4.5);
        let eyes = front.at(Vec3::new(0.0, 0.036, 0.09)).closer(2.2);
        let mouth = front.at(Vec3::new(0.0, -0.035, 0.1)).closer(3.2);
        let nose = front.at(Vec3::new(0.0, 0.0, 0.1)).closer(3.2);
        let cam = match view {
            "front" => front,
            "turned" => front.turned(0.65, 0.05),
            "side" => all.turned(1.57, 0.0),
            "head" => all.turned(0.5, 0.05),
            "back" => all.turned(2.4, 0.1),
            "whole" => all,
            "eye" => eye,
            "eyet" => eye.turned(0.7, 0.0),
            "eyeb" => eye.turned(-0.6, 0.0),
            "eyes" => eyes,
            "mouth" => mouth,
            "moutht" => mouth.turned(0.7, 0.0),
            "mouthb" => mouth.turned(0.2, -0.5),
            "teeth" => front.at(Vec3::new(0.0, -0.036, 0.1)).closer(9.0),
            "mouthu" => mouth.turned(0.0, 0.5),
            "nose" => nose,
            "noset" => nose.turned(0.8, 0.0),
            "noseb" => nose.turned(0.3, -0.6),
            "jaw" => all.at(Vec3::new(0.06, -0.05, 0.02)).turned(0.65, 0.05).closer(3.5),
            "jawb" => all.at(Vec3::new(0.06, -0.04, 0.0)).turned(1.4, 0.0).closer(2.0),
            "ear" => all.at(Vec3::new(0.075, 0.0, 0.0)).turned(1.3, 0.0).closer(2.5),
            _ => panic!(),
        };
        let mut im = render_rig(rig, &pos, &cam, &Style::sized(size, size)).unwrap();
        if pose.is_empty() && a[0].contains("mark") {
            let pts: Vec<Vec3> = head.0.marker_vertices.iter().map(|v| pos[*v as usize]).collect();
            draw_marks(&mut im, &cam, &pts, &Mark::CAPTURED);
        }
        sheet.add(spec.as_str(), im);
    }
    let i = sheet.compose();
    let mut e = png::Encoder::new(std::fs::File::create(&a[0]).unwrap(), i.width_px() as u32, i.height_px() as u32);
    e.set_color(png::ColorType::Rgb);
    e.write_header().unwrap().write_image_data(i.pixels()).unwrap();
}
