//! Names of shapes and what they mean: channels, combination correctives and in-betweens. Every reader of rigs asks here.

use crate::data::{Driver, nearest_name};

/// A shape's name that makes no sense among the other names of its rig.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("shape `{name}`: {problem}")]
pub struct ShapeNameError {
    /// The name.
    pub name: String,
    /// What is wrong with it, and the nearest name that would be right.
    pub problem: String,
}

/// The channels among shape names, in order, and what drives each shape.
///
/// `a+b` is the combination of the channels a and b, `a@0.5` an in-between of the channel a; any other name is a
/// channel. A name whose parts are no channels at all is a channel too; one where only some are is an error, since it
/// is nearly always a misspelt channel.
///
/// # Errors
/// Where a part of a name is no channel while others are, a channel is combined with itself, or an in-between does not
/// peak between 0 and 1.
pub fn shape_drivers(names: &[String]) -> Result<(Vec<String>, Vec<Driver>), ShapeNameError> {
    let plain: Vec<&String> = names.iter().filter(|name| !name.contains(['+', '@'])).collect();
    let mut channels: Vec<String> = Vec::new();
    for name in names {
        if is_channel(name, &plain) {
            channels.push(name.clone());
        }
    }
    let drivers = names.iter().map(|name| driver(name, &channels)).collect::<Result<_, _>>()?;
    Ok((channels, drivers))
}

fn is_channel(name: &str, plain: &[&String]) -> bool {
    let known = |part: &str| plain.iter().any(|channel| *channel == part);
    if name.contains('+') {
        !name.split('+').any(known)
    } else {
        name.split_once('@').is_none_or(|(channel, peak)| !known(channel) && peak.parse::<f32>().is_err())
    }
}

fn driver(name: &str, channels: &[String]) -> Result<Driver, ShapeNameError> {
    let wrong = |problem: String| ShapeNameError { name: name.to_owned(), problem };
    let find = |part: &str| {
        channels.iter().position(|channel| channel == part).map(|index| index as u32).ok_or_else(|| {
            let near = nearest_name(part, channels.iter().map(String::as_str));
            let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
            wrong(format!("`{part}` is no channel of this rig{near}"))
        })
    };
    if let Ok(channel) = find(name) {
        return Ok(Driver::Channel(channel));
    }
    if name.contains('+') {
        let parts = name.split('+').map(find).collect::<Result<Vec<_>, _>>()?;
        if let Some((_, twice)) = parts.iter().enumerate().find(|(at, part)| parts[..*at].contains(part)) {
            return Err(wrong(format!("it combines `{}` with itself", channels[*twice as usize])));
        }
        return Ok(Driver::Combination(parts));
    }
    let (channel, peak) = name.split_once('@').unwrap_or((name, ""));
    let channel = find(channel)?;
    match peak.parse::<f32>() {
        Ok(peak) if peak > 0.0 && peak < 1.0 => Ok(Driver::InBetween { channel, peak }),
        _ => Err(wrong(format!("`{peak}` is no place between 0 and 1 where an in-between could peak"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(names: &[&str]) -> Result<(Vec<String>, Vec<Driver>), ShapeNameError> {
        shape_drivers(&names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn names_are_read_as_the_convention_says() {
        let (channels, drivers) = of(&["b@0.5", "a", "a+b", "b", "Key 1 + home", "x@home"]).unwrap();
        assert_eq!(channels, ["a", "b", "Key 1 + home", "x@home"]);
        assert_eq!(
            drivers,
            [
                Driver::InBetween { channel: 1, peak: 0.5 },
                Driver::Channel(0),
                Driver::Combination(vec![0, 1]),
                Driver::Channel(1),
                Driver::Channel(2),
                Driver::Channel(3),
            ]
        );
    }

    #[test]
    fn slips_of_the_pen_are_named() {
        let error = of(&["jawOpen", "mouthSmile_L", "jawOpen+mouthSmle_L"]).unwrap_err().to_string();
        assert!(error.contains("did you mean `mouthSmile_L`?"), "{error}");
        assert!(of(&["a", "a@1.5"]).unwrap_err().to_string().contains("between 0 and 1"));
        assert!(of(&["a", "a+a"]).unwrap_err().to_string().contains("with itself"));
        assert!(of(&["a", "b@0.5"]).unwrap_err().to_string().contains("`b` is no channel"));
    }
}
