//! `retarget_curves`: a solve of one rig for another: by the names of their channels, which may differ. After the solve,
//! before a character is animated by it.

use crate::selection::{Mapping, Selection};
use crate::values::Scores;
use face_math::data::{Curves, Rig};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

const CURVES: Port<Curves> = Port::new("curves", "a solve: weights of the channels of one rig");
const RIG: Port<Rig> = Port::new("rig", "the other rig");
const RETARGETED: Port<Curves> =
    Port::new("curves", "the same frames, for every channel of the other rig in its order; 0 where none drives it");
const UNMAPPED: Port<Scores> = Port::new(
    "unmapped",
    "channels without a partner: `curves: NAME` for those of the solve that go nowhere, with the largest weight that is \
     lost, and `rig: NAME` for those of the rig that nothing drives, with 0",
);

/// Puts a solve onto another rig: channels of the same name, or as `rename` maps them.
///
/// Names are mapped as files are loaded: a name goes before a pattern, a longer pattern before a shorter one. A channel of
/// the solve that the rig has in two halves (`browInnerUp` for `browInnerUp_L` and `browInnerUp_R`) drives both. What has no
/// partner is told both ways.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RetargetCurves {
    /// Channels of the rig by those of the solve: `{"jawOpen": "jaw_drop", "mouth*_L": "lf_mouth*"}`. Others keep their
    /// names.
    rename: BTreeMap<String, String>,
    /// Channels of the solve that are left out, as patterns: `eyeLook*`. They do not count as lost.
    without: Vec<String>,
    /// By what weights are multiplied, by channel of the rig: `{"jaw_drop": 0.8}`. 1 for those not named.
    scale: BTreeMap<String, f64>,
    /// Whether a channel of the solve without a partner is an error, if it ever leaves 0.
    all_mapped: bool,
    /// Whether a channel of the rig without a partner is an error.
    all_driven: bool,
}

graph_core::register!(RetargetCurves);

#[typetag::serde(name = "retarget_curves")]
impl Node for RetargetCurves {
    fn card(&self) -> Card {
        Card::new("rig").takes(&CURVES).takes(&RIG).gives(&RETARGETED).gives(&UNMAPPED)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let (curves, rig) = (inputs.get(&CURVES)?, inputs.get(&RIG)?);
        super::check_finite(CURVES.name(), curves)?;
        let (sources, lost) = self.partners(curves, rig)?;
        let open: Vec<&String> =
            rig.channels.iter().zip(&sources).filter(|(_, source)| source.is_none()).map(|(name, _)| name).collect();
        let used: Vec<&(&String, f32)> = lost.iter().filter(|(_, most)| *most > 0.0).collect();
        if self.all_mapped && !used.is_empty() {
            let names: Vec<&str> = used.iter().map(|(name, _)| name.as_str()).collect();
            let problem = format!("rig `{}` has nothing for {}; map them with `rename`", rig.name, told(&names));
            return Err(NodeError::parameter("all_mapped", problem));
        }
        if self.all_driven && !open.is_empty() {
            let names: Vec<&str> = open.iter().map(|name| name.as_str()).collect();
            let names = told(&names);
            let problem = format!("nothing in the curves drives {names} of rig `{}`; map them with `rename`", rig.name);
            return Err(NodeError::parameter("all_driven", problem));
        }
        let scales = self.scales(rig)?;
        let mut values = Vec::with_capacity(curves.frames() * sources.len());
        for frame in 0..curves.frames() {
            let own = curves.frame(frame);
            values.extend(sources.iter().zip(&scales).map(|(source, scale)| source.map_or(0.0, |at| scale * own[at])));
        }
        context.progress(1.0, &[("curves without a channel", lost.len() as f64), ("channels at 0", open.len() as f64)]);
        let lost_names = lost.iter().map(|(name, most)| (format!("curves: {name}"), f64::from(*most)));
        let open_names = open.iter().map(|name| (format!("rig: {name}"), 0.0));
        let unmapped = Scores {
            what: format!("{} curves without a channel, {} channels at 0; largest weight lost", lost.len(), open.len()),
            overall: lost.iter().map(|(_, most)| f64::from(*most)).fold(0.0, f64::max),
            by_name: lost_names.chain(open_names).collect(),
        };
        let retargeted = Curves::new(curves.frame_axis(), rig.channels.clone(), values).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&RETARGETED, retargeted).with(&UNMAPPED, unmapped))
    }
}

/// For each channel of the rig the column that drives it, and the channels of the solve that drive none, with their
/// largest weights.
type Partners<'a> = (Vec<Option<usize>>, Vec<(&'a String, f32)>);

impl RetargetCurves {
    fn partners<'a>(&self, curves: &'a Curves, rig: &Rig) -> Result<Partners<'a>, NodeError> {
        let selection = Selection {
            what: "channel",
            only: &[],
            without: &self.without,
            rename: &self.rename,
            mapping: Mapping::default(),
        };
        let kept = selection.apply("the solve", curves.channels())?.kept;
        let own: BTreeSet<&String> = rig.channels.iter().collect();
        let named: BTreeMap<&str, usize> = kept.iter().map(|(column, name)| (name.as_str(), *column)).collect();
        let sources: Vec<Option<usize>> = rig
            .channels
            .iter()
            .map(|name| named.get(name.as_str()).or_else(|| named.get(whole(name, &own)?)).copied())
            .collect();
        let used: BTreeSet<usize> = sources.iter().flatten().copied().collect();
        let most = |column: usize| (0..curves.frames()).map(|t| curves.frame(t)[column].abs()).fold(0.0, f32::max);
        let lost = kept.iter().filter(|(column, _)| !used.contains(column));
        let lost = lost.map(|(column, _)| (&curves.channels()[*column], most(*column))).collect();
        if used.is_empty() {
            let problem =
                format!("no channel of rig `{}` is called as one of the solve; map them with `rename`", rig.name);
            return Err(NodeError::input(CURVES.name(), problem));
        }
        if let Some((_, new)) =
            kept.iter().find(|(column, new)| *new != curves.channels()[*column] && !used.contains(column))
        {
            let near = face_math::data::nearest_name(new, rig.channels.iter().map(String::as_str));
            let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
            let problem = format!("rig `{}` has no channel `{new}`{near}", rig.name);
            return Err(NodeError::parameter("rename", problem));
        }
        Ok((sources, lost))
    }

    /// The factor of each channel of the rig.
    fn scales(&self, rig: &Rig) -> Result<Vec<f32>, NodeError> {
        let patterns = crate::patterns::Patterns { parameter: "scale", what: "channel", names: &rig.channels };
        let found = patterns.numbers(&self.scale)?;
        if let Some(factor) = found.iter().flatten().find(|factor| !factor.is_finite()) {
            return Err(NodeError::parameter("scale", format!("{factor} is no factor; give a number")));
        }
        Ok(found.into_iter().map(|factor| factor.unwrap_or(1.0) as f32).collect())
    }
}

/// The whole that a channel is half of, where the rig's `own` channels hold both halves and no whole.
fn whole<'n>(name: &'n str, own: &BTreeSet<&String>) -> Option<&'n str> {
    let whole = name.strip_suffix("_L").or_else(|| name.strip_suffix("_R"))?;
    let has = |side: &str| own.contains(&format!("{whole}{side}"));
    (has("_L") && has("_R") && !has("")).then_some(whole)
}

/// Names for a message.
fn told(names: &[&str]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made};
    use serde_json::json;
    use wire::FrameAxis;

    fn solve(channels: &[&str]) -> Curves {
        let values = (0..2 * channels.len()).map(|place| 0.1 * (1.0 + place as f32)).collect();
        let axis = FrameAxis { first: 7, count: 2, rate_hz: 60.0 };
        Curves::new(axis, channels.iter().map(|channel| (*channel).to_owned()).collect(), values).unwrap()
    }

    fn retarget(parameters: serde_json::Value, curves: Curves) -> Result<(Curves, Scores), String> {
        let node: RetargetCurves = made(parameters);
        let outputs = compute(&node, &Inputs::default().with(&CURVES, curves).with(&RIG, toy::rig()));
        let outputs = outputs.map_err(|error| error.to_string())?;
        Ok((outputs.get(&RETARGETED).unwrap().clone(), outputs.get(&UNMAPPED).unwrap().clone()))
    }

    #[test]
    fn a_solve_of_the_same_rig_passes_unchanged() {
        let curves = toy::curves(4, 3);
        let (found, unmapped) = retarget(json!({"all_mapped": true, "all_driven": true}), curves.clone()).unwrap();
        assert_eq!(found, curves);
        assert!(unmapped.by_name.is_empty());
    }

    #[test]
    fn names_are_mapped_halves_driven_and_the_rest_told_both_ways() {
        let curves = solve(&["drop", "smile", "tongueOut"]);
        let (found, unmapped) =
            retarget(json!({"rename": {"drop": "jawOpen"}, "scale": {"smile_R": 0.5}}), curves).unwrap();
        assert_eq!((found.frame_axis().first, found.channels()), (7, &toy::rig().channels[..]));
        assert_eq!(found.frame(1), [0.4, 0.5, 0.25, 0.0]);
        let names: Vec<&str> = unmapped.by_name.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["curves: tongueOut", "rig: browUp"]);
        assert!((unmapped.overall - 0.6).abs() < 1e-6, "{unmapped:?}");
    }

    #[test]
    fn strictness_and_mistakes_are_named() {
        let fault = |parameters| retarget(parameters, solve(&["jawOpen", "tongueOut"])).unwrap_err();
        assert!(fault(json!({"all_mapped": true})).contains("`tongueOut`"));
        assert!(fault(json!({"all_driven": true})).contains("`browUp`"));
        assert!(fault(json!({"rename": {"jawOpn": "browUp"}})).contains("did you mean `jawOpen`?"));
        assert!(fault(json!({"rename": {"tongueOut": "browUpp"}})).contains("did you mean `browUp`?"));
        assert!(fault(json!({"rename": {"tongueOut": "jawOpen"}})).contains("two channels"));
        assert!(fault(json!({"scale": {"jaw": 1.0}})).contains("`scale`"));
        assert!(
            retarget(json!({"without": ["tongueOut"], "all_mapped": true}), solve(&["jawOpen", "tongueOut"])).is_ok()
        );
        assert!(retarget(json!({}), solve(&["a", "b"])).unwrap_err().contains("map them with `rename`"));
    }
}
