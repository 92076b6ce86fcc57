//! A strict reader of markup: tags must nest, attributes must be quoted, and `<`, `&` must be escaped.

/// An element with its attributes, its text (that of its children included), and its depth.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    pub(crate) name: String,
    pub(crate) attributes: Vec<(String, String)>,
    pub(crate) text: String,
}

impl Element {
    pub(crate) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    pub(crate) fn number(&self, name: &str) -> f64 {
        self.attribute(name)
            .unwrap_or_else(|| panic!("{} has no {name}", self.name))
            .parse()
            .expect("a number")
    }
}

const VOID: [&str; 5] = ["meta", "link", "img", "br", "hr"];

/// Reads XML, or HTML as this crate writes it (void elements are not closed, scripts and styles are not markup).
///
/// # Panics
/// When it is not well formed.
pub(crate) fn elements(markup: &str) -> Vec<Element> {
    let mut found: Vec<Element> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    let mut rest = markup;
    while let Some(start) = rest.find('<') {
        let text = unescaped(&rest[..start]);
        open.iter().for_each(|&index| found[index].text += &text);
        assert!(!open.is_empty() || text.trim().is_empty(), "text outside the root: {text:?}");
        rest = &rest[start + 1..];
        let end = tag_end(rest);
        let tag = &rest[..end];
        rest = &rest[end + 1..];
        if tag.starts_with('?') || tag.to_lowercase().starts_with("!doctype") {
            continue;
        }
        if let Some(name) = tag.strip_prefix('/') {
            let last = open.pop().unwrap_or_else(|| panic!("</{name}> closes nothing"));
            assert_eq!(
                found[last].name,
                name.trim(),
                "wrong nesting before {:?}",
                &rest[..rest.len().min(80)]
            );
            continue;
        }
        let element = element(tag.trim_end_matches('/'));
        let name = element.name.clone();
        found.push(element);
        if tag.ends_with('/') || VOID.contains(&name.as_str()) {
            continue;
        }
        open.push(found.len() - 1);
        let html = markup.starts_with("<!doctype html>");
        if html && (name == "script" || name == "style") {
            rest = &rest[rest.find(&format!("</{name}>")).expect("script without end")..];
        }
    }
    assert!(open.is_empty(), "{} is not closed", found[open[0]].name);
    assert!(rest.trim().is_empty(), "text after the end: {rest:?}");
    found
}

fn tag_end(rest: &str) -> usize {
    let mut quoted = false;
    rest.char_indices()
        .find(|(_, c)| {
            quoted ^= *c == '"';
            *c == '>' && !quoted
        })
        .expect("a tag without end")
        .0
}

fn element(tag: &str) -> Element {
    let (name, mut rest) = tag.split_once(char::is_whitespace).unwrap_or((tag, ""));
    assert!(name.chars().all(|c| c.is_ascii_alphanumeric()) && !name.is_empty(), "tag name {name:?}");
    let mut attributes: Vec<(String, String)> = Vec::new();
    loop {
        rest = rest.trim_start();
        if rest.is_empty() {
            return Element { name: name.into(), attributes, text: String::new() };
        }
        let length =
            rest.find(|c: char| !(c.is_ascii_alphanumeric() || "-_:".contains(c))).unwrap_or(rest.len());
        let key = &rest[..length];
        assert!(!key.is_empty(), "attribute in {tag:?}");
        assert!(attributes.iter().all(|(known, _)| known != key), "{key} twice in {tag:?}");
        rest = &rest[length..];
        let mut value = String::new();
        if let Some(quoted) = rest.strip_prefix("=\"") {
            let end = quoted.find('"').expect("a quote without end");
            value = unescaped(&quoted[..end]);
            rest = &quoted[end + 1..];
        }
        attributes.push((key.into(), value));
    }
}

fn unescaped(text: &str) -> String {
    assert!(!text.contains('<'), "unescaped < in {text:?}");
    let allowed = |c: char| !c.is_control() || "\t\n\r".contains(c);
    assert!(text.chars().all(allowed), "control character in {text:?}");
    let mut out = String::new();
    let mut parts = text.split('&');
    out += parts.next().unwrap_or("");
    for part in parts {
        let (name, after) = part.split_once(';').unwrap_or_else(|| panic!("unescaped & in {text:?}"));
        out.push(match name {
            "amp" => '&',
            "lt" => '<',
            "gt" => '>',
            "quot" => '"',
            "#39" => '\'',
            other => panic!("unknown entity {other:?}"),
        });
        out += after;
    }
    out
}
