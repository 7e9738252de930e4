//! Parts of a rig that a parameter names: what the savers of heads have in common.

use face_math::data::{Part, Rig, nearest_name};
use graph_core::node::NodeError;

/// The parts of `rig` called `names`, which the parameter `parameter` holds.
///
/// # Errors
/// Where the rig has no such part.
pub(super) fn named<'r>(rig: &'r Rig, parameter: &str, names: &[String]) -> Result<Vec<&'r Part>, NodeError> {
    let find = |name: &String| {
        rig.part(name).ok_or_else(|| {
            let own = || rig.parts.iter().map(|part| part.name.as_str());
            let near = match nearest_name(name, own()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("it has {}", own().map(|own| format!("`{own}`")).collect::<Vec<_>>().join(", ")),
            };
            NodeError::parameter(parameter, format!("rig `{}` has no part `{name}`; {near}", rig.name))
        })
    };
    names.iter().map(find).collect()
}

/// `rig` without the parts called `names`; its vertices stay as they are.
///
/// # Errors
/// Where the rig has no such part, or no part is left.
pub(super) fn without(rig: &Rig, parameter: &str, names: &[String]) -> Result<Rig, NodeError> {
    named(rig, parameter, names)?;
    let mut rest = rig.clone();
    rest.parts.retain(|part| !names.contains(&part.name));
    if rest.parts.is_empty() {
        return Err(NodeError::parameter(parameter, format!("no part of rig `{}` is left", rig.name)));
    }
    Ok(rest)
}
