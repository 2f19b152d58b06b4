//! JSON as Python writes it, in which numbers may be `NaN`, `Infinity` or `-Infinity`.
//!
//! In a [`Value`] such a number is a text that no other text is mistaken for.

use serde_json::Value;

/// The numbers that JSON does not have.
const NOT_FINITE: [(&str, f64); 3] =
    [("NaN", f64::NAN), ("-Infinity", f64::NEG_INFINITY), ("Infinity", f64::INFINITY)];

/// Before the word of a number that is not finite, in a text.
const MARK: &str = "\u{0}number ";

/// A number, finite or not.
pub(super) fn of_number(number: f64) -> Value {
    let word = NOT_FINITE
        .iter()
        .find(|(_, value)| value.to_bits() == number.to_bits() || (value.is_nan() && number.is_nan()));
    word.map_or_else(|| Value::from(number), |(word, _)| Value::from(format!("{MARK}{word}")))
}

/// The number that a value is.
pub(super) fn number(value: &Value) -> Option<f64> {
    let word =
        |text: &str| NOT_FINITE.iter().find(|(word, _)| text.strip_prefix(MARK) == Some(word)).map(|n| n.1);
    value.as_f64().or_else(|| value.as_str().and_then(word))
}

/// As text.
pub(super) fn write(value: &Value) -> String {
    let mut text = value.to_string();
    for (word, _) in NOT_FINITE {
        // The mark as JSON escapes it.
        text = text.replace(&format!("\"\\u0000number {word}\""), word);
    }
    text
}

/// From text.
pub(super) fn read(text: &str) -> serde_json::Result<Value> {
    let mut marked = String::with_capacity(text.len());
    let (mut rest, mut quoted) = (text, false);
    while let Some(c) = rest.chars().next() {
        let word = NOT_FINITE.iter().map(|n| n.0).find(|word| !quoted && rest.starts_with(word));
        if let Some(word) = word {
            marked.extend(["\"\\u0000number ", word, "\""]);
            rest = &rest[word.len()..];
            continue;
        }
        let length = if quoted && c == '\\' {
            1 + rest.chars().nth(1).map_or(0, char::len_utf8)
        } else {
            c.len_utf8()
        };
        quoted ^= c == '"';
        marked.push_str(&rest[..length]);
        rest = &rest[length..];
    }
    serde_json::from_str(&marked)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_json_does_not_have() {
        let text = r#"{"a": [NaN, -Infinity, 1.5, Infinity], "b": "NaN \" Infinity", "c": "\\"}"#;
        let value = read(text).unwrap();
        let numbers: Vec<f64> = value["a"].as_array().unwrap().iter().map(|v| number(v).unwrap()).collect();
        assert!(numbers[0].is_nan());
        assert_eq!(numbers[1..], [f64::NEG_INFINITY, 1.5, f64::INFINITY]);
        assert_eq!((value["b"].as_str(), value["c"].as_str()), (Some("NaN \" Infinity"), Some("\\")));
        assert_eq!(number(&value["b"]), None);
        assert_eq!(read(&write(&value)).unwrap(), value);
        assert!(write(&value).contains("[NaN,-Infinity,1.5,Infinity]"), "{}", write(&value));
        for number_of in [0.1, -0.0, 1e-300, f64::INFINITY] {
            assert_eq!(
                number(&read(&write(&of_number(number_of))).unwrap()).unwrap().to_bits(),
                number_of.to_bits()
            );
        }
        assert!(read("{NaN}").is_err());
    }
}
