//! Which version of glTF a JSON says that it is, where its types are not those of the second.
//!
//! Guaranteed: linear time, and no memory at all, whatever stands in the JSON and however deep. Not guaranteed: that it is
//! valid; only what the parser has found to be JSON, though of other types, is worth a look.

/// What a JSON object says of its version.
#[derive(Default)]
pub(super) struct Told<'a> {
    /// Whether there is an `asset`.
    pub(super) has_asset: bool,
    /// The `version` of the asset, if it is a text, with escapes as they stand.
    pub(super) version: Option<&'a [u8]>,
    /// Whether the nodes have names for numbers, as in the first version.
    pub(super) has_named_nodes: bool,
}

/// What a JSON says, up to where it cannot be followed; `None` if it is no object.
pub(super) fn told(json: &[u8]) -> Option<Told<'_>> {
    if json.trim_ascii_start().first() != Some(&b'{') {
        return None;
    }
    let mut told = Told::default();
    let mut depth = 0_u32;
    let mut is_in_asset = false;
    // The name before the colon, at the depths that matter.
    let mut key: &[u8] = b"";
    let mut at = 0;
    while let Some(&b) = json.get(at) {
        at += 1;
        match b {
            b'{' | b'[' => {
                depth = depth.saturating_add(1);
                if depth == 2 {
                    is_in_asset = b == b'{' && key == b"asset";
                    told.has_named_nodes |= b == b'{' && key == b"nodes";
                    key = b"";
                }
            }
            b'}' | b']' => {
                depth = depth.saturating_sub(1);
                is_in_asset &= depth > 1;
            }
            b'"' => {
                let start = at;
                while let Some(&b) = json.get(at)
                    && b != b'"'
                {
                    at += if b == b'\\' { 2 } else { 1 };
                }
                // The text of a file that ends in it is none.
                let Some(text) = json.get(start..at).filter(|_| at < json.len()) else { break };
                at += 1;
                let is_key = json[at..].trim_ascii_start().first() == Some(&b':');
                if is_key && depth <= 2 {
                    key = text;
                    told.has_asset |= depth == 1 && key == b"asset";
                } else if is_in_asset && depth == 2 && key == b"version" {
                    told.version = Some(text);
                }
            }
            // Another value has no more to do with the name before it.
            b',' if depth <= 2 => key = b"",
            _ => {}
        }
    }
    Some(told)
}

#[cfg(test)]
mod tests {
    use super::told;

    #[test]
    fn the_version_of_the_asset_is_found_and_no_other() {
        for (json, expected) in [
            (r#"{"asset":{"version":"1.0"}}"#, Some("1.0")),
            (
                r#" { "a" : [ { "asset" : { "version" : "3" } } ] , "asset" : { "version" : "1" } }"#,
                Some("1"),
            ),
            (
                r#"{"asset":{"generator":"version","extras":{"version":"9"},"version":"2.0"}}"#,
                Some("2.0"),
            ),
            (r#"{"asset":{"extras":{"x":1},"version":"1.1"},"version":"7"}"#, Some("1.1")),
            (r#"{"asset":{"version":1},"x":"y"}"#, None),
            (r#"{"asset":["version","1"],"x":{"version":"2"}}"#, None),
            (r#"{"\"asset":{"version":"1"},"asset":{"copyright":"\\","version":"4"}}"#, Some("4")),
            (r#"{"asset":{"version":"1"#, None),
            (r#"{"asset":{"version":"1\"#, None),
            ("{}}}}", None),
        ] {
            let version = told(json.as_bytes()).unwrap().version;
            assert_eq!(version, expected.map(str::as_bytes), "{json}");
        }
        for json in ["", "[]", "1", r#""asset""#] {
            assert!(told(json.as_bytes()).is_none());
        }
        assert!(!told(br#"{"a":{"asset":1}}"#).unwrap().has_asset);
        assert!(told(br#"{"nodes":{},"asset":1}"#).unwrap().has_asset);
        assert!(told(br#"{"nodes":{}}"#).unwrap().has_named_nodes);
        assert!(!told(br#"{"nodes":[{"nodes":{}}]}"#).unwrap().has_named_nodes);
    }
}
