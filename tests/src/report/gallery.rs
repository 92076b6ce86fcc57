//! `docs/GALLERY.md`: a picture of every scene.
//!
//! Pictures are small copies of those of a report, committed beside the page; of a scene that draws nothing it is the plot of its
//! work against its error. What a report does not have stays as it is, so that a page of all scenes can be made of several runs.

use super::files::{WriteError, write_file};
use super::guide::markdown;
use super::text::slug;
use crate::picture::{Size, ThumbnailError, description, thumbnail};
use crate::record::{Picture, Report, SceneRecord};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The largest size of a picture.
const SIZE: Size = Size { width: 320, height: 220 };

/// What is seen of a scene that draws nothing.
const PLOT: &str = "time against error";

/// Pictures in a row of the page.
const COLUMNS: usize = 3;

/// A gallery could not be made.
#[derive(Debug, thiserror::Error)]
pub enum GalleryError {
    /// A picture of a report cannot be copied.
    #[error("{} {source}", path.display())]
    Picture {
        /// The picture.
        path: PathBuf,
        /// Why.
        source: ThumbnailError,
    },
    /// A plot of a report cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Plot {
        /// The plot.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Puts a small copy of one picture of every scene of `report`, which is in `folder`, into `docs`/gallery.
///
/// # Errors
/// [`GalleryError`] for a picture that the report names and that cannot be copied.
pub fn take_pictures(report: &Report, folder: &Path, docs: &Path) -> Result<(), GalleryError> {
    for scene in &report.scenes {
        let Some((kind, bytes)) = picture(scene, folder)? else { continue };
        for other in ["png", "svg"].into_iter().filter(|other| *other != kind) {
            // A picture takes the place of a plot; usually there is nothing to remove.
            let _ = std::fs::remove_file(docs.join(place(&scene.name, other)));
        }
        write_file(&docs.join(place(&scene.name, kind)), &bytes)?;
    }
    Ok(())
}

/// The largest picture file, which shows most; else the last frame of the largest film; else the plot.
fn picture(scene: &SceneRecord, folder: &Path) -> Result<Option<(&'static str, Vec<u8>)>, GalleryError> {
    let largest = |kind: &str| {
        let size =
            |picture: &&Picture| std::fs::metadata(folder.join(&picture.path)).map_or(0, |data| data.len());
        let pictures = scene.pictures.iter();
        pictures
            .filter(|picture| Path::new(&picture.path).extension().is_some_and(|found| found == kind))
            .max_by_key(|picture| (size(picture), std::cmp::Reverse(&picture.path)))
    };
    if let Some(Picture { path, caption }) = largest("png").or_else(|| largest("gif")) {
        let path = folder.join(path);
        let copy =
            thumbnail(&path, SIZE, caption).map_err(|source| GalleryError::Picture { path, source })?;
        return Ok(Some(("png", copy)));
    }
    let path = folder.join("plots").join(format!("{}.work.svg", slug(&scene.name)));
    if !path.exists() {
        return Ok(None);
    }
    let bytes = std::fs::read(&path).map_err(|source| GalleryError::Plot { path, source })?;
    Ok(Some(("svg", bytes)))
}

fn place(scene: &str, kind: &str) -> String {
    format!("gallery/{scene}.{kind}")
}

/// The page of `scenes`, with the pictures that are in `docs`/gallery.
pub fn gallery(scenes: &[SceneRecord], docs: &Path) -> String {
    let mut crates: BTreeMap<&str, Vec<&SceneRecord>> = BTreeMap::new();
    for scene in scenes {
        crates.entry(&scene.crate_name).or_default().push(scene);
    }
    let mut out = String::from(HEAD);
    for (name, scenes) in &crates {
        let drawn = scenes.iter().filter(|scene| docs.join(place(&scene.name, "png")).exists()).count();
        let plotted = scenes.iter().filter(|scene| docs.join(place(&scene.name, "svg")).exists()).count();
        out +=
            &format!("- [{name}](#{name}): {drawn} scenes by a picture, {plotted} by time against error\n");
    }
    for (name, scenes) in crates {
        out +=
            &format!("\n## {}\n\n|{}\n|{}\n", markdown(name), " |".repeat(COLUMNS), "---|".repeat(COLUMNS));
        for row in scenes.chunks(COLUMNS) {
            let cells: Vec<String> = row.iter().map(|scene| cell(scene, docs)).collect();
            out += &format!("| {} |{}\n", cells.join(" | "), " |".repeat(COLUMNS - row.len()));
        }
    }
    out
}

const HEAD: &str = "# Gallery\n\n\
    <!-- Generated from the scene files and from reports. Do not edit: `cargo xtask gallery`. -->\n\n\
    A picture of every validation scene, with its title and what is seen; of a scene that draws nothing, its time against its error. A click opens the scene. All \
    pictures and films in full, and the figures to them, are in the report of `cargo xtask validate`; what the scenes claim is in [VALIDATION.md](VALIDATION.md).\n\n\
    The pictures here are small copies, made of the reports of runs by\n\n\
    ```sh\ncargo xtask gallery target/validation …\n```\n\n";

fn cell(scene: &SceneRecord, docs: &Path) -> String {
    let title = markdown(&scene.title);
    let source = format!("../tests/scenes/{}.toml", scene.name);
    let found = ["png", "svg"].into_iter().map(|kind| place(&scene.name, kind));
    let picture = found.into_iter().find(|place| docs.join(place).exists());
    let Some(place) = picture else { return format!("[(no picture yet)]({source})<br>{title}") };
    let seen = if place.ends_with("svg") { Some(PLOT.to_owned()) } else { description(&docs.join(&place)) };
    let seen = seen.map_or_else(String::new, |text| format!("<br><sub>{}</sub>", markdown(&text)));
    let alt = title.replace('"', "'");
    format!("[<img src=\"{place}\" width=\"260\" alt=\"{alt}\">]({source})<br>{title}{seen}")
}
