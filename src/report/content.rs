//! Content of a document as JSON: its digest, by which a result that was changed afterwards is recognised, and
//! keys that are written twice.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{self, Write};

use serde::Serialize;
use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::Value;

use super::error::ReportError;
use numeric::digest::digest;

/// Key of the digest.
const KEY: &str = "content_sha256";

/// Returns the digest of a document.
///
/// # Errors  it has no JSON form (an error of the program).
pub fn digest_of<T: Serialize>(document: &T) -> Result<String, ReportError> {
    Ok(content_digest(&serde_json::to_value(document)?))
}

/// Checks a document of a kind that states its digest, that of all keys but its own, whatever their order and
/// layout. Returns the fault.
pub fn content_fault(document: &Value) -> Option<String> {
    match document.get(KEY).and_then(Value::as_str) {
        None => {
            Some(format!("lacks the digest of its content ({KEY}), which earlier versions did not write"))
        }
        Some(stated) if stated != content_digest(document) => {
            Some(format!("was changed after it was written: its content has another digest ({KEY})"))
        }
        Some(_) => None,
    }
}

fn content_digest(document: &Value) -> String {
    let mut text = String::new();
    let own = document.as_object().into_iter().flatten().filter(|(key, _)| *key != KEY);
    write_keys(own, &mut text);
    digest(text.as_bytes())
}

fn write_keys<'v>(keys: impl Iterator<Item = (&'v String, &'v Value)>, text: &mut String) {
    text.push('{');
    for (key, value) in keys.collect::<BTreeMap<_, _>>() {
        let _ = write!(text, "{}:", Value::from(key.as_str()));
        write_value(value, text);
    }
    text.push('}');
}

fn write_value(value: &Value, text: &mut String) {
    match value {
        Value::Object(map) => write_keys(map.iter(), text),
        Value::Array(list) => {
            text.push('[');
            list.iter().for_each(|value| write_value(value, text));
            text.push(']');
        }
        // 1 and 1.0 are one number. Larger ones, such as seeds, are exact as integers alone.
        Value::Number(number) => {
            let _ = match number.as_f64().filter(|x| x.abs() < 1e15) {
                Some(x) => write!(text, "{x:?},"),
                None => write!(text, "{number},"),
            };
        }
        other => {
            let _ = write!(text, "{other},");
        }
    }
}

/// JSON text in which no key is written twice.
pub struct UniqueKeys;

impl<'de> Deserialize<'de> for UniqueKeys {
    fn deserialize<D: Deserializer<'de>>(text: D) -> Result<Self, D::Error> {
        text.deserialize_any(UniqueKeys)
    }
}

impl<'de> Visitor<'de> for UniqueKeys {
    type Value = UniqueKeys;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_bool<E>(self, _: bool) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_i64<E>(self, _: i64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_u64<E>(self, _: u64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_f64<E>(self, _: f64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_str<E>(self, _: &str) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_unit<E>(self) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self, A::Error> {
        while list.next_element::<UniqueKeys>()?.is_some() {}
        Ok(self)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self, A::Error> {
        let mut keys = BTreeSet::new();
        while let Some(key) = map.next_key::<String>()? {
            map.next_value::<UniqueKeys>()?;
            if keys.contains(&key) {
                return Err(A::Error::custom(format!("key «{key}» is written twice")));
            }
            keys.insert(key);
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// Documents of unlike structure have unlike digests; order and layout do not count.
    #[test]
    fn limit_a_digest_is_that_of_one_content() {
        let all = [
            json!([[1], 2]),
            json!([1, [2]]),
            json!([[1, 2]]),
            json!([1, 2]),
            json!([{}, []]),
            json!([[], {}]),
            json!([{ "b": 2 }]),
            json!({ "a": 1, "b": {} }),
            json!({ "a": { "b": 1 } }),
            json!({ "a\u{301}": 1 }),
            json!({ "a\\u{301}": 1 }),
            json!(["1,2"]),
        ];
        let digests: BTreeSet<String> =
            all.iter().map(|value| content_digest(&json!({ "value": value }))).collect();
        assert_eq!(digests.len(), all.len());
        let digest = |text: &str| content_digest(&serde_json::from_str(text).unwrap());
        assert_eq!(digest(r#"{"a": 1, "b": [2.0]}"#), digest(r#"{"b":[2],"a":1.0,"content_sha256":"x"}"#));
    }
}
