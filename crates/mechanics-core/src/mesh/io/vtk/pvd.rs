use super::super::atomic;
use super::escaped;
use crate::mesh::io::error::MeshFileError;
use std::io::Write;
use std::path::Path;

/// One file of a time series.
#[derive(Clone, Debug, PartialEq)]
pub struct PvdEntry {
    /// The time that ParaView shows \[s\].
    pub time: f64,
    /// The file, relative to the PVD file.
    pub file: String,
}

/// Writes the list of a time series' files as PVD.
///
/// # Errors
/// Those of the writer.
pub fn write_pvd(entries: &[PvdEntry], sink: &mut impl Write) -> Result<(), MeshFileError> {
    let attributes = "type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\"";
    writeln!(sink, "<?xml version=\"1.0\"?>\n<VTKFile {attributes}>\n<Collection>")?;
    for entry in entries {
        let (time, file) = (entry.time, escaped(&entry.file));
        writeln!(sink, "<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{file}\"/>")?;
    }
    writeln!(sink, "</Collection>\n</VTKFile>")?;
    Ok(())
}

/// Writes the list of a time series' files to a PVD file. Writing it anew after every frame lets ParaView open a
/// series that is still growing.
///
/// # Errors
/// [`MeshFileError::System`]; the file is then as before.
pub fn write_pvd_file(entries: &[PvdEntry], path: impl AsRef<Path>) -> Result<(), MeshFileError> {
    atomic::write_file(path.as_ref(), |sink| write_pvd(entries, sink))
}
