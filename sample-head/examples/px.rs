//! throw-away
use face_math::render::*;
use face_math::rig::*;
use glam::Vec3;
use sample_head::*;
fn main() {
    let h = build(&Options { identity: 5, ..Default::default() }).unwrap();
    let all = Camera::framing(&h.rig.neutral);
    let rig = skin_jaw(&h.rig, &SkinJawOptions::default()).unwrap().rig;
    let mut w = [0.0; 53];
    w[26] = 0.5;
    let pos = Puppet::new(&rig).unwrap().vertices(&w).unwrap();
    let cam = all.at(Vec3::new(0.06, -0.06, 0.03)).turned(0.65, 0.05).closer(5.5);
    let mut sheet = Sheet::new(4);
    let mut r2 = rig.clone();
    let cols = [[0.8, 0.2, 0.2], [0.2, 0.8, 0.2], [0.2, 0.2, 0.8], [0.8, 0.8, 0.1], [0.8, 0.1, 0.8], [0.1, 0.8, 0.8]];
    for (i, p) in r2.parts.iter_mut().enumerate() {
        p.colour = cols[i % 6];
        println!("{i} {} {:?}", p.name, p.colour);
    }
    sheet.add("colours", render_rig(&r2, &pos, &cam, &Style::sized(480, 480)).unwrap());
    sheet.add(
        "noface",
        render_rig(&r2, &pos, &cam, &Style { hidden: vec!["face".into()], ..Style::sized(480, 480) }).unwrap(),
    );
    sheet.add(
        "only face",
        render_rig(&r2, &pos, &cam, &Style { hidden: vec!["head_neck".into()], ..Style::sized(480, 480) }).unwrap(),
    );
    let i = sheet.compose();
    let mut e =
        png::Encoder::new(std::fs::File::create("/tmp/px.png").unwrap(), i.width_px() as u32, i.height_px() as u32);
    e.set_color(png::ColorType::Rgb);
    e.write_header().unwrap().write_image_data(i.pixels()).unwrap();
}
