//! The reader against the `ron` crate: what that accepts we accept, with equal content; and recovery from mistakes.

use super::parse;
use crate::document::Literal;
use proptest::prelude::*;
use ron::Value;
use ron::value::Number;

/// Whether the two hold the same. `ron` keeps neither the names of variants nor the signs around fields.
#[allow(clippy::float_cmp, reason = "the same text must give the same number")]
fn agree(ours: &Literal, theirs: &Value) -> bool {
    match (ours, theirs) {
        (Literal::Nothing, Value::Unit | Value::Option(None)) | (Literal::Text(_), Value::Unit) => true,
        (Literal::Nothing, Value::Seq(theirs)) => theirs.is_empty(),
        (ours, Value::Option(Some(theirs))) => agree(ours, theirs),
        (Literal::Bool(ours), Value::Bool(theirs)) => ours == theirs,
        (Literal::Text(ours), Value::String(theirs)) => ours == theirs,
        (Literal::Text(ours), Value::Char(theirs)) => *ours == theirs.to_string(),
        (Literal::Integer(ours), Value::Number(theirs)) => !is_float(*theirs) && *ours as f64 == theirs.into_f64(),
        (Literal::Number(ours), Value::Number(theirs)) => same_number(*ours, theirs.into_f64()),
        (Literal::List(ours), Value::Seq(theirs)) => {
            ours.len() == theirs.len() && ours.iter().zip(theirs).all(|(ours, theirs)| agree(&ours.value, theirs))
        }
        (Literal::Map(ours), Value::Map(theirs)) => {
            let value_of = |key: &Value| {
                let name = match key {
                    Value::String(name) => name.clone(),
                    Value::Char(name) => name.to_string(),
                    Value::Bool(value) => value.to_string(),
                    Value::Number(number) if is_float(*number) => number.into_f64().to_string(),
                    Value::Number(number) => format!("{}", number.into_f64() as i64),
                    _ => return None,
                };
                ours.iter().rev().find(|(key, _)| key.value == name).map(|(_, value)| &value.value)
            };
            theirs.iter().all(|(key, theirs)| value_of(key).is_some_and(|ours| agree(ours, theirs)))
        }
        (Literal::Variant(_, ours), Value::Seq(theirs)) => match &ours.value {
            Literal::List(items) if items.len() == theirs.len() && theirs.len() != 1 => {
                agree(&ours.value, &Value::Seq(theirs.clone()))
            }
            Literal::Nothing if theirs.is_empty() => true,
            ours => theirs.len() == 1 && agree(ours, &theirs[0]),
        },
        (Literal::Variant(_, ours), theirs) => agree(&ours.value, theirs),
        _ => false,
    }
}

fn is_float(number: Number) -> bool {
    matches!(number, Number::F32(_) | Number::F64(_))
}

/// `ron::Value` keeps a float in 32 bits where it is the same there.
#[allow(clippy::float_cmp, reason = "the same text must give the same number")]
fn same_number(ours: f64, theirs: f64) -> bool {
    ours == theirs || (ours.is_nan() && theirs.is_nan())
}

/// What means nothing in a graph, and is told so.
fn is_left_out(messages: &[String]) -> bool {
    let known = ["byte strings", "ranges have no", "too large", "a key must be", "keys in { } stand"];
    messages.iter().any(|message| known.iter().any(|part| message.contains(part)))
}

fn compare(text: &str) -> Result<(), String> {
    let ours = parse(text);
    let Ok(theirs) = ron::from_str::<Value>(text) else { return Ok(()) };
    let messages: Vec<String> = ours.errors.iter().map(|error| error.message.clone()).collect();
    match &ours.value {
        _ if is_left_out(&messages) => Ok(()),
        Some(value) if messages.is_empty() && agree(&value.value, &theirs) => Ok(()),
        value => Err(format!("{text:?}\n  ron:  {theirs:?}\n  ours: {value:?}\n  {messages:?}")),
    }
}

const CORPUS: &[&str] = &[
    "1",
    "-1",
    "+1",
    "0x1F",
    "-0x1f",
    "0b1010",
    "0o17",
    "1_000",
    "1__0_",
    "0x_f",
    "300u8",
    "200u8",
    "-1i64",
    "5f32",
    "5f64",
    "1.",
    ".5",
    "-.5",
    "+.5",
    "1e3",
    "1e-3",
    "1E+3",
    "1_0.0_1",
    "1.5e3",
    "1e5_0",
    "._5",
    "_5",
    "-_5",
    "1._5",
    "0.1f32",
    "0.1f64",
    "inf",
    "-inf",
    "+inf",
    "NaN",
    "-NaN",
    "inff32",
    "NaNf64",
    "-inff64",
    "infinity",
    "1e400",
    "1-2",
    "--1",
    "1.2.3",
    "9223372036854775807",
    "-9223372036854775808",
    "9223372036854775808",
    "18446744073709551616",
    "1f",
    "1e",
    "0x",
    "0xg",
    "b'a'",
    "b'\\n'",
    "'a'",
    "'\\''",
    "'\\u{e9}'",
    "'é'",
    "'''",
    "''",
    "'ab'",
    "'\\x41'",
    "'\\xC3\\xA9'",
    "\"\"",
    "\"a\\tb\\\\\\\"\\n\\r\\0\\'\"",
    "\"\\x41\\u{1F600}\"",
    "\"\\xC3\\xA9\"",
    "\"\\xff\"",
    "\"a \\\n   b\"",
    "\"a\nb\"",
    "\"a\\q\"",
    "\"open",
    "r\"raw \\n\"",
    "r#\"a \" b\"#",
    "r##\"a \"# b\"##",
    "r#\"open\"",
    "b\"bytes\"",
    "br#\"bytes\"#",
    "true",
    "false",
    "True",
    "None",
    "Some(1)",
    "Some(None)",
    "Some((1, 2))",
    "Some()",
    "Some(1, 2)",
    "Some",
    "Some (1)",
    "()",
    "( )",
    "[]",
    "{}",
    "(1)",
    "(1,)",
    "(1, 2)",
    "[1, 2,]",
    "[1 2]",
    "[,]",
    "(,)",
    "{,}",
    "{\"a\": 1,}",
    "{\"a\": 1, \"b\": [2]}",
    "(a: 1)",
    "(a: 1, b: \"x\",)",
    "(a: 1, 2)",
    "(1, a: 2)",
    "(r#type: 1)",
    "(r#foo-bar: 1)",
    "r#type",
    "(\"a\": 1)",
    "{a: 1}",
    "{1: 2}",
    "{'a': 2}",
    "{true: 2}",
    "{(1, 2): 3}",
    "{1.5: 2}",
    "{\"a\": 1, \"a\": 2}",
    "variant",
    "variant(1)",
    "variant(1, 2)",
    "variant(a: 1)",
    "variant()",
    "variant(())",
    "variant((1, 2))",
    "variant([1])",
    "Name (a: 1)",
    "_x",
    "é",
    "x-y",
    "x.y",
    "#![enable(implicit_some)] (a: 1)",
    "#![enable(implicit_some, unwrap_newtypes,)]\n#![enable(unwrap_variant_newtypes)] 1",
    "# ! [ enable ( implicit_some ) ] 1",
    "#![enable(nonsense)] 1",
    "#![enable] 1",
    "#![enable()] 1",
    "// c\n1 // d",
    "/* a /* b */ c */ 1",
    "1 /* open",
    "/**/1",
    "1//",
    "(a/*x*/:/*y*/1)",
    "\u{feff}1",
    "\u{2028}1\u{85}",
    "1 2",
    "1)",
    "(1",
    "..",
    "1..2",
    "1..=2",
    "..=2",
    "[[[[]]]]",
    "((((1))))",
    "",
    "  ",
    "// nothing",
    "+",
    "-",
    ".",
    "e5",
];

#[test]
fn agrees_with_ron_on_a_corpus() {
    let differing: Vec<String> = CORPUS.iter().filter_map(|text| compare(text).err()).collect();
    assert!(differing.is_empty(), "{}", differing.join("\n"));
}

#[test]
fn refuses_what_ron_refuses() {
    let lenient = ["\u{feff}1", "#![enable()] 1"];
    let accepted: Vec<&&str> = CORPUS
        .iter()
        .filter(|text| {
            ron::from_str::<Value>(text).is_err() && parse(text).errors.is_empty() && !lenient.contains(text)
        })
        .collect();
    assert!(accepted.is_empty(), "{accepted:?}");
}

/// Blanks and comments between tokens.
fn gap() -> impl Strategy<Value = String> {
    prop_oneof![
        4 => Just(String::new()),
        2 => "[ \\t\\n]{1,3}",
        1 => " ?//[a-z(\"]{0,5}\n",
        1 => "/\\*[a-z(\"]{0,5}\\*/",
    ]
}

fn scalar() -> impl Strategy<Value = String> {
    prop_oneof![
        any::<i64>().prop_map(|number| number.to_string()),
        any::<u32>().prop_map(|number| format!("0x{number:X}")),
        any::<u16>().prop_map(|number| format!("0b{number:b}u16")),
        any::<f64>().prop_filter("finite", |number| number.is_finite()).prop_map(|number| format!("{number:?}")),
        "[+-]?[0-9]{1,3}_?[0-9]{0,2}(\\.[0-9]{0,3})?(e-?[0-9])?",
        any::<String>().prop_map(|text| format!("{text:?}")),
        "[^\"]{0,6}".prop_map(|text| format!("r#\"{text}\"#")),
        any::<char>().prop_map(|c| format!("{c:?}")),
        prop_oneof!["true", "false", "None", "()", "inf", "-NaN", "[a-z_][a-z0-9_]{0,5}"],
    ]
}

/// RON texts with all that graphs may hold.
fn ron_text() -> impl Strategy<Value = String> {
    scalar().prop_recursive(5, 64, 6, |inner| {
        let item = (gap(), inner.clone(), gap()).prop_map(|(before, value, after)| before + &value + &after).boxed();
        let items = (prop::collection::vec(item.clone(), 0..6), any::<bool>())
            .prop_map(|(items, comma)| items.join(",") + if comma && !items.is_empty() { "," } else { "" });
        let keyed = |key: &'static str| {
            let entry = (gap(), key, gap(), item.clone()).prop_map(|(a, key, b, value)| format!("{a}{key}{b}:{value}"));
            prop::collection::vec(entry, 1..5).prop_map(|entries| entries.join(","))
        };
        let name = "[a-z_]{1,6}";
        prop_oneof![
            items.clone().prop_map(|items| format!("[{items}]")),
            items.clone().prop_map(|items| format!("({items})")),
            keyed("[a-z_]{1,6}").prop_map(|fields| format!("({fields})")),
            keyed("\"[a-z. ]{0,6}\"").prop_map(|fields| format!("{{{fields}}}")),
            item.clone().prop_map(|value| format!("Some({value})")),
            (name, gap(), items).prop_map(|(name, gap, items)| format!("{name}{gap}({items})")),
            (name, gap(), keyed("[a-z_]{1,6}")).prop_map(|(name, gap, fields)| format!("{name}{gap}({fields})")),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(1000) })]

    #[test]
    fn agrees_with_ron_on_generated_texts(text in ron_text()) {
        compare(&text).map_err(TestCaseError::fail)?;
    }

    #[test]
    fn agrees_with_ron_on_fragments(text in "([(){}\\[\\]:,.\"'#!/*+=_\\\\ -]|Some|None|r#|0x|e1|[0-9a-fr]|\n){0,16}") {
        compare(&text).map_err(TestCaseError::fail)?;
    }
}
