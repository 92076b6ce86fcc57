//! Pictures as data, so that the page is one file.

use crate::record::Picture;
use crate::report::text::{escaped, one_line};
use std::path::{Component, Path, PathBuf};

/// Larger pictures are linked instead of embedded: a page of many megabytes does not open on a phone.
const LARGEST_EMBEDDED: u64 = 6 << 20;

/// The folder that pictures are read from.
pub(super) struct Pictures {
    folder: PathBuf,
}

impl Pictures {
    pub(super) fn of(folder: &Path) -> Self {
        Self { folder: folder.to_owned() }
    }

    /// A figure of `picture`, or a note why there is none.
    pub(super) fn figure(&self, picture: &Picture) -> String {
        let caption = escaped(&picture.caption);
        match self.source(&picture.path) {
            Ok(source) => format!(
                "<figure><img loading=\"lazy\" src=\"{source}\" alt=\"{caption}\"><figcaption>{caption}</figcaption></figure>\n"
            ),
            Err(reason) => {
                let name = escaped(&one_line(&picture.path));
                format!("<p class=\"quiet\">Picture {name} ({caption}) is not shown: {reason}.</p>\n")
            }
        }
    }

    /// The one with the largest file, which shows most; the first of equals, so that a missing file is named too.
    pub(super) fn fullest<'a>(&self, pictures: impl Iterator<Item = &'a Picture>) -> Option<&'a Picture> {
        let size =
            |picture: &Picture| std::fs::metadata(self.folder.join(&picture.path)).map_or(0, |f| f.len());
        pictures.min_by_key(|picture| std::cmp::Reverse(size(picture)))
    }

    fn source(&self, path: &str) -> Result<String, &'static str> {
        let inside =
            Path::new(path).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        if !inside || path.is_empty() {
            return Err("its path leaves the report's folder");
        }
        let kind = media_type(path).ok_or("it is neither PNG nor GIF")?;
        let file = self.folder.join(path);
        let size = std::fs::metadata(&file).map_err(|_| "the file is missing")?.len();
        if size > LARGEST_EMBEDDED {
            return Ok(escaped(&percent_encoded(path)));
        }
        let data = std::fs::read(&file).map_err(|_| "the file is not readable")?;
        Ok(format!("data:{kind};base64,{}", base64(&data)))
    }
}

fn media_type(path: &str) -> Option<&'static str> {
    match Path::new(path).extension()?.to_str()? {
        "png" => Some("image/png"),
        "gif" => Some("image/gif"),
        _ => None,
    }
}

fn percent_encoded(path: &str) -> String {
    let kept = |b: u8| b.is_ascii_alphanumeric() || b"-_./~".contains(&b);
    path.bytes().map(|b| if kept(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}

/// Base64 with padding (RFC 4648, section 4).
fn base64(data: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(data.len().div_ceil(3) * 4);
    for group in data.chunks(3) {
        let byte = |i: usize| u32::from(group.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            let kept = digit <= group.len();
            out.push(if kept { char::from(DIGITS[(bits >> (18 - 6 * digit) & 63) as usize]) } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The test vectors of RFC 4648, section 10.
    #[test]
    fn base64_agrees_with_its_standard() {
        let vectors = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ];
        for (plain, coded) in vectors {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
        assert_eq!(base64(&[0xff, 0xfb, 0xef]), "//vv");
    }

    #[test]
    fn a_picture_outside_the_folder_is_not_read() {
        let pictures = Pictures::of(Path::new("/"));
        for path in ["../etc/passwd.png", "/etc/x.png", "a/../../b.png", ""] {
            assert_eq!(pictures.source(path), Err("its path leaves the report's folder"), "{path}");
        }
        assert_eq!(pictures.source("frames/none.png"), Err("the file is missing"));
        assert_eq!(pictures.source("frames/none.svg"), Err("it is neither PNG nor GIF"));
    }
}
