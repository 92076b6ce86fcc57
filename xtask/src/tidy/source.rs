//! Rust source split into code and comments.

/// One file of Rust, with views in which every other part is blank: the lines and columns stay the same.
pub(crate) struct Source {
    /// Only code: comments and the content of literals are blank.
    pub(crate) code: String,
    /// Only comments.
    pub(crate) comments: String,
}

impl Source {
    /// Splits the text of a file.
    pub(crate) fn new(text: &str) -> Self {
        let mut views = Views { text, code: blank(text), comments: blank(text) };
        let mut position = 0;
        while position < text.len() {
            position = views.advance(position);
        }
        let string = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        Self { code: string(views.code), comments: string(views.comments) }
    }

    /// The code without items marked `#[cfg(test)]`.
    pub(crate) fn code_without_tests(&self) -> String {
        const MARK: &str = "#[cfg(test)]";
        let mut code = self.code.clone().into_bytes();
        let mut from = 0;
        while let Some(found) = self.code[from..].find(MARK) {
            let start = from + found;
            let end = item_end(&self.code, start + MARK.len());
            blank_out(&mut code[start..end]);
            from = end;
        }
        String::from_utf8_lossy(&code).into_owned()
    }
}

struct Views<'a> {
    text: &'a str,
    code: Vec<u8>,
    comments: Vec<u8>,
}

impl Views<'_> {
    /// Takes the next comment, literal or character, and returns where it ends.
    fn advance(&mut self, start: usize) -> usize {
        let rest = &self.text[start..];
        let bytes = rest.as_bytes();
        if rest.starts_with("//") {
            let end = start + rest.find('\n').unwrap_or(rest.len());
            self.keep_comment(start, end)
        } else if rest.starts_with("/*") {
            self.keep_comment(start, start + block_comment_length(bytes))
        } else if bytes[0] == b'"' {
            start + string_length(bytes)
        } else if let Some(length) = raw_string_length(self.text, start) {
            start + length
        } else if let Some(length) = character_length(rest) {
            start + length
        } else {
            if bytes[0].is_ascii() {
                self.code[start] = bytes[0];
            }
            start + rest.chars().next().map_or(1, char::len_utf8)
        }
    }

    fn keep_comment(&mut self, start: usize, end: usize) -> usize {
        self.comments[start..end].copy_from_slice(&self.text.as_bytes()[start..end]);
        end
    }
}

fn blank(text: &str) -> Vec<u8> {
    text.bytes().map(|byte| if byte == b'\n' { b'\n' } else { b' ' }).collect()
}

fn blank_out(bytes: &mut [u8]) {
    bytes.iter_mut().filter(|byte| **byte != b'\n').for_each(|byte| *byte = b' ');
}

fn block_comment_length(bytes: &[u8]) -> usize {
    let (mut depth, mut i) = (0, 0);
    while i < bytes.len() {
        match bytes.get(i..i + 2) {
            Some(b"/*") => {
                depth += 1;
                i += 2;
            }
            Some(b"*/") => {
                depth -= 1;
                i += 2;
                if depth == 0 {
                    return i;
                }
            }
            _ => i += 1,
        }
    }
    bytes.len()
}

/// The length of the string literal that `bytes` begin with, quotes included.
fn string_length(bytes: &[u8]) -> usize {
    let mut i = 1;
    while i < bytes.len() {
        match bytes[i] {
            b'\\' => i += 2,
            b'"' => return i + 1,
            _ => i += 1,
        }
    }
    bytes.len()
}

/// The length of the raw string literal at `start`, from its `r` on.
fn raw_string_length(text: &str, start: usize) -> Option<usize> {
    let bytes = &text.as_bytes()[start..];
    let after_prefix = bytes.strip_prefix(b"r")?;
    let hashes = after_prefix.iter().take_while(|byte| **byte == b'#').count();
    if after_prefix.get(hashes) != Some(&b'"') || continues_word(text, start) {
        return None;
    }
    let closing = format!("\"{}", "#".repeat(hashes));
    let content = start + 1 + hashes + 1;
    let end = text[content..].find(&closing).map_or(text.len(), |found| content + found + closing.len());
    Some(end - start)
}

/// Whether the `r` at `start` belongs to a longer word: `br"…"` and `cr"…"` are raw strings, `for"` is none.
fn continues_word(text: &str, start: usize) -> bool {
    let before = &text.as_bytes()[..start];
    let word = before.iter().rev().take_while(|byte| is_word(**byte)).count();
    !matches!(&before[start - word..], b"" | b"b" | b"c")
}

/// The length of the character literal that `rest` begins with; a lifetime is none.
fn character_length(rest: &str) -> Option<usize> {
    let after = rest.strip_prefix('\'')?;
    if after.starts_with('\\') {
        let end = after.get(2..)?.find('\'')?;
        return Some(1 + 2 + end + 1);
    }
    let character = after.chars().next()?;
    let closed = after[character.len_utf8()..].starts_with('\'');
    closed.then(|| character.len_utf8() + 2)
}

pub(super) fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// The identifiers and keywords of `code`, with their positions.
pub(super) fn words(code: &str) -> impl Iterator<Item = (usize, &str)> {
    let bytes = code.as_bytes();
    let mut position = 0;
    std::iter::from_fn(move || {
        while position < bytes.len() && !is_word(bytes[position]) {
            position += 1;
        }
        let start = position;
        while position < bytes.len() && is_word(bytes[position]) {
            position += 1;
        }
        (start < position).then(|| (start, &code[start..position]))
    })
}

/// The line that `position` is on, counted from one.
pub(super) fn line_of(text: &str, position: usize) -> usize {
    1 + text.as_bytes()[..position].iter().filter(|byte| **byte == b'\n').count()
}

/// One past the bracket that closes the one at `open`; the end of the code if none does.
pub(super) fn closing(code: &str, open: usize) -> usize {
    let mut depth = 0;
    for (i, byte) in code.bytes().enumerate().skip(open) {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => {
                depth -= 1;
                if depth == 0 {
                    return i + 1;
                }
            }
            _ => {}
        }
    }
    code.len()
}

/// Where the item that starts at `start` ends: after its first `;` outside brackets, or after its braces.
pub(super) fn item_end(code: &str, start: usize) -> usize {
    let bytes = code.as_bytes();
    let mut i = start;
    while i < bytes.len() {
        match bytes[i] {
            b';' => return i + 1,
            b'{' => return closing(code, i),
            b'(' | b'[' => i = closing(code, i),
            _ => i += 1,
        }
    }
    bytes.len()
}
