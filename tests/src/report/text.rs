//! Numbers and names as people read them, and as markup carries them.

/// `x` with three significant digits: `0.0123`, `1.23e-5`, `0`.
pub fn significant(x: f64) -> String {
    if x == 0.0 {
        return "0".into();
    }
    if !x.is_finite() {
        return format!("{x}");
    }
    let scientific = format!("{x:.2e}");
    let exponent = exponent_of(&scientific);
    if (-3..4).contains(&exponent) { format!("{x:.*}", (2 - exponent).max(0) as usize) } else { scientific }
}

/// `x` with three significant digits and a typeset power of ten: `1.23·10⁻⁵`.
pub fn typeset(x: f64) -> String {
    let plain = significant(x);
    match plain.split_once('e') {
        Some((digits, exponent)) => format!("{digits}·10{}", superscript(exponent)),
        None => plain.replace('-', "−"),
    }
}

/// `x` as a person would have written it in a scene file: `0.002`, `1e-8`.
pub fn shortest(x: f64) -> String {
    let (plain, scientific) = (format!("{x}"), format!("{x:e}"));
    if plain.len() <= scientific.len() + 2 { plain } else { scientific }
}

/// The digits of `text` raised; a minus sign too.
pub fn superscript(text: &str) -> String {
    const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    text.chars()
        .map(|c| match c.to_digit(10) {
            Some(digit) => RAISED[digit as usize],
            None if c == '-' => '⁻',
            None => c,
        })
        .collect()
}

/// A time span with a fitting unit: `350 ns`, `12.3 ms`, `2.50 min`.
pub fn duration(seconds: f64) -> String {
    const UNITS: [(f64, &str); 5] = [(3600.0, "h"), (60.0, "min"), (1.0, "s"), (1e-3, "ms"), (1e-6, "µs")];
    for (size, unit) in UNITS {
        // A shade early, so that 999.9 µs is not printed as "1000 µs"; minutes and hours begin at two.
        let begins = if size > 1.0 { 2.0 * size } else { 0.9995 * size };
        if seconds >= begins {
            return format!("{} {unit}", significant(seconds / size));
        }
    }
    if seconds > 0.0 { format!("{} ns", significant(seconds * 1e9)) } else { "0 s".into() }
}

/// A number of bytes with a binary unit: `1.50 MiB`.
pub fn bytes(count: u64) -> String {
    const UNITS: [&str; 5] = ["B", "KiB", "MiB", "GiB", "TiB"];
    let mut size = count as f64;
    let mut unit = 0;
    while size >= 1024.0 && unit + 1 < UNITS.len() {
        size /= 1024.0;
        unit += 1;
    }
    if unit == 0 { format!("{count} B") } else { format!("{} {}", significant(size), UNITS[unit]) }
}

/// A unit to stand behind a number: `\[m\]`, or nothing where the unit is `1`.
pub fn bracketed(unit: &str) -> String {
    if unit == "1" || unit.is_empty() { String::new() } else { format!(" [{unit}]") }
}

/// A number with its noun: `1 scene`, `2 scenes`.
pub fn counted(count: usize, noun: &str) -> String {
    if count == 1 { format!("1 {noun}") } else { format!("{count} {noun}s") }
}

/// `text` on one line, without control characters, so that a name cannot command a terminal.
pub fn one_line(text: &str) -> String {
    let shown: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    shown.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// `text` cut to `width` characters, the cut marked by `…`.
pub fn cut(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.into();
    }
    text.chars().take(width.saturating_sub(1)).chain(['…']).collect()
}

/// The last `width` characters of `text`, a cut marked by `…`.
pub fn cut_front(text: &str, width: usize) -> String {
    let excess = text.chars().count().saturating_sub(width);
    if excess == 0 {
        return text.into();
    }
    text.chars().skip(excess + 1).fold(String::from("…"), |kept, c| kept + c.encode_utf8(&mut [0; 4]))
}

/// `text` in lines of at most `width` characters; longer words are split.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let width = width.max(1);
    let mut lines = Vec::new();
    let mut line = String::new();
    let mut used = 0;
    for word in one_line(text).split(' ') {
        let letters: Vec<char> = word.chars().collect();
        for (part, piece) in letters.chunks(width).enumerate() {
            let gap = usize::from(used > 0);
            if used + gap + piece.len() > width || part > 0 {
                lines.push(std::mem::take(&mut line));
                used = 0;
            }
            if used > 0 {
                line.push(' ');
                used += 1;
            }
            line.extend(piece);
            used += piece.len();
        }
    }
    lines.push(line);
    lines
}

/// `text` for the inside of an XML or HTML element or quoted attribute. Characters that XML 1.0 forbids become `�`.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\t' | '\n' | '\r' => out.push(c),
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// A name that is safe as a file name and as an anchor: letters, digits, `-` and `_`. Distinct names stay distinct,
/// because whatever is replaced is written as its number.
pub fn slug(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        match c {
            c if c.is_ascii_alphanumeric() || c == '-' || c == '_' => out.push(c),
            '/' => out.push_str("~_"),
            c => out.push_str(&format!("~{:x}", u32::from(c))),
        }
    }
    out.replace('~', ".")
}

fn exponent_of(scientific: &str) -> i32 {
    scientific.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_three_digits_over_all_magnitudes() {
        for exponent in -300..300 {
            let x = 1.234_567 * 10f64.powi(exponent);
            let back: f64 = significant(x).parse().unwrap();
            assert!((back / x - 1.0).abs() < 5e-3, "{x} became {back}");
            assert!(significant(x).len() <= 9);
        }
        assert_eq!(significant(9999.6), "1.00e4");
        assert_eq!(significant(0.0), "0");
        assert_eq!(typeset(-1.5e-7), "-1.50·10⁻⁷");
    }

    #[test]
    fn durations_choose_their_unit() {
        assert_eq!(duration(0.0), "0 s");
        assert_eq!(duration(3.5e-7), "350 ns");
        assert_eq!(duration(9.999e-4), "1.00 ms");
        assert_eq!(duration(75.0), "75.0 s");
        assert_eq!(duration(150.0), "2.50 min");
        assert_eq!(duration(7200.0), "2.00 h");
    }

    #[test]
    fn wrapping_keeps_every_letter_and_the_width() {
        let text = "a sentence with a_very_long_word_that_cannot_fit and   gaps\tand\nbreaks";
        for width in 1..30 {
            let lines = wrapped(text, width);
            assert!(lines.iter().all(|line| line.chars().count() <= width && !line.is_empty()), "{lines:?}");
            let letters = |s: &str| s.chars().filter(|c| !c.is_whitespace()).collect::<String>();
            assert_eq!(letters(&lines.concat()), letters(text));
        }
    }

    #[test]
    fn slugs_of_distinct_names_are_distinct_and_safe() {
        let names = ["a/b", "a--b", "a_b", "a.-b", "a b", "a<b", "a&b", "a\"b", "a.b", "a~b", "aβb", "../b"];
        let slugs: std::collections::BTreeSet<String> = names.iter().map(|name| slug(name)).collect();
        assert_eq!(slugs.len(), names.len());
        for slug in &slugs {
            assert!(slug.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c)), "{slug}");
            assert!(!slug.contains(".."), "{slug}");
        }
    }

    #[test]
    fn a_name_cannot_command_the_terminal() {
        assert_eq!(one_line("\u{1b}[31mred\r\nnext\u{7}"), "[31mred next");
    }
}
