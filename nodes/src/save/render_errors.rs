//! `render_errors`: pictures of meshes beside the true ones, with the distance between both as colours on the skin.

use face_math::data::{Image, Meshes, Part, Rig};
use face_math::render::{Camera, Sheet, Style, render_rig};
use glam::Vec3;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const TRUTH: Port<Meshes> = Port::new("truth", "the meshes as they should be, in metres");
const MESHES: Port<Meshes> = Port::new("meshes", "the meshes that are looked at, of the same parts and frames");
const IMAGE: Port<Image> =
    Port::new("image", "a row a frame: the truth, the meshes, and the distance between them as colours");

/// Steps of the scale of colours.
const STEPS: usize = 24;

/// Draws the frames that are farthest off: the truth, the result, and where on the skin they differ.
///
/// Colours run from blue (no distance) over green and yellow to red (`full_mm` and beyond). Captions tell the frame, and the mean
/// and the greatest distance.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RenderErrors {
    /// How many frames are drawn: the one that is farthest off of each of so many equal parts of the take.
    #[schemars(range(min = 1, max = 100))]
    count: usize,
    /// The distance that is drawn in full red.
    #[schemars(range(min = 0.000_001, max = 1000.0))]
    full_mm: f64,
    /// Parts that are left out, such as `teeth_lower`.
    without_parts: Vec<String>,
    /// Width and height of one picture.
    #[schemars(range(min = 32, max = 2048))]
    size_px: usize,
    /// Turn of the camera around the head.
    #[schemars(range(min = -180.0, max = 180.0))]
    yaw_deg: f64,
}

impl Default for RenderErrors {
    fn default() -> Self {
        Self { count: 4, full_mm: 1.0, without_parts: Vec::new(), size_px: 320, yaw_deg: 20.0 }
    }
}

graph_core::register!(RenderErrors);

#[typetag::serde(name = "render_errors")]
impl Node for RenderErrors {
    fn card(&self) -> Card {
        Card::new("save").takes(&TRUTH).takes(&MESHES).gives(&IMAGE)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let (truth, meshes) = (inputs.get(&TRUTH)?, inputs.get(&MESHES)?);
        for (what, found, needed) in
            [("frames", meshes.frames(), truth.frames()), ("vertices", meshes.vertices(), truth.vertices())]
        {
            if found != needed || found == 0 {
                return Err(NodeError::input(MESHES.name(), format!("{found} {what} beside {needed} of the truth")));
            }
        }
        if let Some(name) = self.without_parts.iter().find(|name| truth.part(name).is_none()) {
            return Err(NodeError::parameter("without_parts", format!("the meshes have no part `{name}`")));
        }
        context.claim("size_px", 48 * self.count * self.size_px * self.size_px)?;
        let shown: Vec<&Part> = truth.parts().iter().filter(|part| !self.without_parts.contains(&part.name)).collect();
        let distance = |frame: usize| -> Vec<f64> {
            let own = meshes.frame(frame).iter().zip(truth.frame(frame));
            own.map(|(a, b)| 1000.0 * f64::from(a.distance(*b))).collect()
        };
        let seen: Vec<usize> =
            shown.iter().flat_map(|part| part.vertices.start as usize..part.vertices.end as usize).collect();
        let worst = |frame: usize| {
            let all = distance(frame);
            seen.iter().map(|vertex| all[*vertex]).fold(0.0, f64::max)
        };
        let plain = head(truth, shown.iter().map(|part| (*part).clone()).collect());
        let points: Vec<Vec3> = seen.iter().map(|vertex| truth.frame(0)[*vertex]).collect();
        let camera = Camera::framing(&points).turned(self.yaw_deg.to_radians() as f32, 0.0);
        let style = Style::sized(self.size_px, self.size_px);
        let mut sheet = Sheet::new(3);
        let rows = self.count.min(truth.frames());
        for row in 0..rows {
            context.go_on()?;
            let span = row * truth.frames() / rows..(row + 1) * truth.frames() / rows;
            let (_, frame) =
                span.map(|frame| (worst(frame), frame)).fold((-1.0, 0), |a, b| if b.0 > a.0 { b } else { a });
            let far = distance(frame);
            let mean = seen.iter().map(|vertex| far[*vertex]).sum::<f64>() / seen.len().max(1) as f64;
            let number = truth.frame_axis().slice(&(frame..frame + 1)).first;
            let mut draw = |caption: String, rig: &Rig, positions: &[Vec3]| -> Result<(), NodeError> {
                sheet.add(caption, render_rig(rig, positions, &camera, &style).map_err(NodeError::failed)?);
                Ok(())
            };
            draw(format!("{number} truth"), &plain, truth.frame(frame))?;
            draw("result".to_owned(), &plain, meshes.frame(frame))?;
            let coloured = head(truth, self.bands(&shown, &far));
            draw(format!("mean {mean:.3} max {:.2} mm", worst(frame)), &coloured, meshes.frame(frame))?;
            context.progress((row + 1) as f64 / rows as f64, &[]);
        }
        Ok(Outputs::default().with(&IMAGE, sheet.compose()))
    }
}

impl RenderErrors {
    /// The shown triangles by their distance, each step of the scale a part of its own colour.
    fn bands(&self, shown: &[&Part], far_mm: &[f64]) -> Vec<Part> {
        let mut bands: Vec<Part> = (0..=STEPS)
            .map(|step| Part {
                name: format!("step_{step:02}"),
                vertices: 0..0,
                triangles: Vec::new(),
                uvs: Vec::new(),
                colour: colour(step as f32 / STEPS as f32),
            })
            .collect();
        for triangle in shown.iter().flat_map(|part| &part.triangles) {
            let mean = triangle.iter().map(|vertex| far_mm[*vertex as usize]).sum::<f64>() / 3.0;
            let step = (mean / self.full_mm * STEPS as f64).round().clamp(0.0, STEPS as f64);
            bands[step as usize].triangles.push(*triangle);
        }
        bands
    }
}

/// Blue, green, yellow, red.
fn colour(share: f32) -> [f32; 3] {
    let stops = [[0.02, 0.06, 0.5], [0.02, 0.45, 0.1], [0.8, 0.6, 0.02], [0.7, 0.02, 0.02]];
    let at = share.clamp(0.0, 1.0) * 3.0;
    let from = (at as usize).min(2);
    let part = at - from as f32;
    std::array::from_fn(|channel| stops[from][channel] * (1.0 - part) + stops[from + 1][channel] * part)
}

/// A head to draw with the given parts.
fn head(meshes: &Meshes, parts: Vec<Part>) -> Rig {
    Rig {
        name: "meshes".to_owned(),
        parts,
        neutral: meshes.frame(0).to_vec(),
        channels: Vec::new(),
        shapes: Vec::new(),
        skin: Vec::new(),
        jaw_pivot_m: None,
        jaw: None,
        joints: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{HEAD, compute, made};
    use serde_json::json;
    use wire::FrameAxis;

    fn still(shift: Vec3, frames: usize) -> Meshes {
        let head = &HEAD.rig;
        let positions = (0..frames).flat_map(|_| head.neutral.iter().map(|point| *point + shift)).collect();
        Meshes::new(FrameAxis::new(frames, 60.0), head.parts.clone(), head.neutral.len(), positions).unwrap()
    }

    #[test]
    fn far_skin_is_red_and_near_skin_blue() {
        let node: RenderErrors = made(json!({"count": 1, "size_px": 64, "full_mm": 2.0}));
        let picture = |shift: Vec3| {
            let inputs = Inputs::default().with(&TRUTH, still(Vec3::ZERO, 2)).with(&MESHES, still(shift, 2));
            let outputs = compute(&node, &inputs).unwrap();
            let image = outputs.get(&IMAGE).unwrap();
            let at = (36 * image.width_px() + 2 * 68 + 36) * 3;
            [0, 1, 2].map(|channel| image.pixels()[at + channel])
        };
        let [red, _, blue] = picture(Vec3::ZERO);
        assert!(blue > red, "{red} {blue}");
        let [red, _, blue] = picture(Vec3::new(0.0, 0.0, 4e-3));
        assert!(red > blue, "{red} {blue}");
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let node: RenderErrors = made(json!({}));
        let inputs = Inputs::default().with(&TRUTH, still(Vec3::ZERO, 2)).with(&MESHES, still(Vec3::ZERO, 3));
        assert!(compute(&node, &inputs).unwrap_err().to_string().contains("3 frames beside 2"));
        let wrong: RenderErrors = made(json!({"without_parts": ["hat"]}));
        let inputs = inputs.with(&MESHES, still(Vec3::ZERO, 2));
        assert!(compute(&wrong, &inputs).unwrap_err().to_string().contains("no part `hat`"));
    }
}
