//! Where a key of a scene file stands in its text.

use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The bytes of the value at a dotted key (`meshes.0.material`: the material of the first mesh), if it is there.
pub(crate) fn span_of(text: &str, key: &str) -> Option<Range<usize>> {
    let document = DeTable::parse(text).ok()?;
    let mut parts = key.split('.');
    let mut value: &Spanned<DeValue<'_>> = document.get_ref().get(parts.next()?)?;
    for part in parts {
        value = match value.get_ref() {
            DeValue::Table(table) => table.get(part)?,
            DeValue::Array(array) => array.get(part.parse::<usize>().ok()?)?,
            _ => return None,
        };
    }
    Some(value.span())
}

/// The text with the value at a dotted key replaced by another TOML value; `None` where there is no such key.
pub(crate) fn replace_value(text: &str, key: &str, value: &str) -> Option<String> {
    let span = span_of(text, key)?;
    Some(format!("{}{value}{}", &text[..span.start], &text[span.end..]))
}

/// Line and column, both from one, of a byte.
pub(crate) fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let boundary = (0..=byte.min(text.len())).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0);
    let before = &text[..boundary];
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    (line, column)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        "[[meshes]]\nname = 'a'\n[[meshes]]\nname = 'bä' # two\n[solver]\ntolerance_m = 1e-3\n";

    #[test]
    fn keys_are_found_through_tables_and_lists() {
        let found = |key| span_of(TEXT, key).map(|span| &TEXT[span]);
        assert_eq!(found("meshes.1.name"), Some("'bä'"));
        assert_eq!(found("solver.tolerance_m"), Some("1e-3"));
        for missing in ["meshes.2.name", "meshes.x", "solver.tolerance_m.deeper", "contact", ""] {
            assert_eq!(found(missing), None, "{missing}");
        }
    }

    #[test]
    fn lines_and_columns_count_characters_from_one() {
        assert_eq!(line_and_column(TEXT, 0), (1, 1));
        let hash = TEXT.find('#').expect("the text has a comment");
        assert_eq!(line_and_column(TEXT, hash), (4, 13));
        assert_eq!(line_and_column("", 0), (1, 1));
    }

    #[test]
    fn a_replaced_value_leaves_the_rest_alone() {
        let text = replace_value(TEXT, "solver.tolerance_m", "0.5").expect("the key is there");
        assert_eq!(text, TEXT.replace("1e-3", "0.5"));
        assert_eq!(replace_value(TEXT, "solver.nothing", "1"), None);
    }
}
