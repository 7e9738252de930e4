//! What may not stand in a schema.

use super::*;

fn port(name: &str, type_name: &str) -> PortSchema {
    PortSchema {
        name: name.to_owned(),
        type_name: type_name.to_owned(),
        doc: "a port".to_owned(),
        optional: false,
        many: false,
        still: false,
    }
}

fn node() -> NodeSchema {
    NodeSchema {
        name: "calm".to_owned(),
        doc: "Calms.".to_owned(),
        version: 1,
        time: TimeUse::PerFrameBy("reach".to_owned()),
        inputs: vec![port("curves", "Curves")],
        outputs: vec![port("curves", "Curves")],
        parameters: vec![ParameterSchema {
            name: "reach".to_owned(),
            doc: "How far it looks.".to_owned(),
            default: Setting::Integer(2),
            least: Some(0.0),
            most: Some(50.0),
            choices: Vec::new(),
        }],
    }
}

type Lie = (fn(&mut NodeSchema), &'static str);

#[test]
fn each_lie_is_told_with_its_place() {
    assert_eq!(check(&[node()]), Ok(()));
    let lies: [Lie; 12] = [
        (|node| node.name = "Calm!".to_owned(), "must be small letters"),
        (|node| node.doc = String::new(), "its description is empty"),
        (|node| node.outputs.clear(), "no outputs"),
        (|node| node.inputs[0].type_name = "Curvse".to_owned(), "did you mean `Curves`?"),
        (|node| node.inputs.push(port("curves", "Curves")), "two inputs are called `curves`"),
        (|node| node.outputs[0].optional = true, "only inputs may be"),
        (|node| node.outputs[0].type_name = "Number".to_owned(), "does not vary over time"),
        (|node| node.inputs[0].still = true, "no input of it varies over time"),
        (|node| node.parameters[0].most = None, "its halo is said to be"),
        (|node| node.parameters[0].most = Some(1.0), "a default that is none of the values"),
        (|node| node.parameters[0].least = Some(f64::NAN), "not finite"),
        (|node| node.parameters[0].choices.push(("a".to_owned(), String::new())), "is no text"),
    ];
    for (lie, told) in lies {
        let mut lying = node();
        lie(&mut lying);
        let error = check(&[lying]).unwrap_err().to_string();
        assert!(error.contains(told), "{error}");
    }
    assert!(check(&[node(), node()]).unwrap_err().to_string().contains("two nodes"));
    assert!(check(&[]).is_err());
}
