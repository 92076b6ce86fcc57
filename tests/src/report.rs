//! Reports of a run: what a person reads and what programs read, all from one [`Report`].
//!
//! [`write_report`] makes the folder: `report.json`, `rows.csv`, `junit.xml`, `env.json`, `index.html` and `plots/*.svg`.
//! [`table`] is what the terminal shows; [`merge`] makes one report of several shards; [`guide`] writes
//! `docs/VALIDATION.md`. Nothing here prints.
//!
//! Conventions that the runner keeps: the rows of a line go from coarse to fine, so that the last completed one is the
//! finest; where a ladder point ran with several numbers of threads, plots and tables compare the fewest.

mod answers;
mod digest;
mod files;
mod gallery;
mod guide;
mod html;
mod json;
mod junit;
mod merge;
pub mod plot;
mod rows;
mod table;
pub mod text;

pub use answers::{Answer, Clause, answers, asked_scenes};
pub use digest::{Tally, Trouble, TroubleKind, sentences, troubles};
pub use files::{WriteError, write_file, write_file_with};
pub use gallery::{GalleryError, gallery, take_pictures};
pub use guide::guide;
pub use html::page;
pub use json::{ReadError, environment_json, read_report, report_json, report_schema};
pub use junit::junit;
pub use merge::{MergeError, MergeWarning, Merged, merge};
pub use rows::rows_csv;
pub use table::{WIDTH, table};

use crate::record::Report;
use std::io;
use std::path::Path;

/// Whether plots are also written as files of their own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlotFiles {
    /// One SVG a plot in `plots/`.
    #[default]
    Write,
    /// Only those inside the page.
    Omit,
}

/// Writes the report's files into `folder`, each whole or not at all. Pictures that `report` names are read from there.
///
/// # Errors
/// [`WriteError`] for the first file that cannot be written; those before it are there.
pub fn write_report(report: &Report, folder: &Path, plots: PlotFiles) -> Result<(), WriteError> {
    let json = |name: &str, made: Result<String, serde_json::Error>| {
        let path = folder.join(name);
        let text = made.map_err(|error| WriteError { path: path.clone(), source: io::Error::from(error) })?;
        write_file(&path, text.as_bytes())
    };
    json("report.json", report_json(report))?;
    json("env.json", environment_json(report))?;
    write_file(&folder.join("rows.csv"), rows_csv(report).as_bytes())?;
    write_file(&folder.join("junit.xml"), junit(report).as_bytes())?;
    if plots == PlotFiles::Write {
        write_plots(report, &folder.join("plots"))?;
    }
    write_file(&folder.join("index.html"), page(report, folder).as_bytes())
}

fn write_plots(report: &Report, folder: &Path) -> Result<(), WriteError> {
    for scene in &report.scenes {
        let stem = text::slug(&scene.name);
        if let Some(plot) = plot::work_precision(scene) {
            write_file(&folder.join(format!("{stem}.work.svg")), plot.svg_file().as_bytes())?;
        }
        for measure in &scene.measures {
            if let Some(plot) = plot::convergence(scene, measure) {
                let name = format!("{stem}.{}.ladder.svg", text::slug(&measure.name));
                write_file(&folder.join(name), plot.svg_file().as_bytes())?;
            }
        }
    }
    Ok(())
}
