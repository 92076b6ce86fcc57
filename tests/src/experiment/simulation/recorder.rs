//! What a run leaves in its folder: frames, a film, and a table of its load steps.

use super::picture::{self, Frame};
use super::{Bodies, LoadStep};
use crate::experiment::ExperimentError;
use crate::picture::Film;
use crate::report::write_file;
use crate::scene::physics::Format;
use mechanics_core::mesh::io::ply::{ByteOrder, PlyEncoding};
use mechanics_core::mesh::io::vtk::{
    Field, FieldValues, Fields, PvdEntry, VtkEncoding, write_pvd_file, write_vtu_file,
};
use mechanics_core::mesh::io::{MeshFileError, obj, ply};
use mechanics_core::mesh::{MeshError, TetMesh, TriMesh};
use mechanics_core::tensor::Vec3;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// How long a frame of a film stands [s].
const SECONDS_A_FRAME: f64 = 0.25;

/// Writes frames as they come, pictures and tables at the end.
pub(crate) struct Recorder {
    folder: PathBuf,
    formats: Vec<Format>,
    series: Vec<PvdEntry>,
    /// States that will be drawn: number, load factor, positions.
    states: Vec<(usize, f64, Vec<Vec3>)>,
    table: String,
}

/// The names in the output folder, so that an earlier run's folder can be told from any other.
pub(crate) const FILES: [&str; 5] = ["diagnostics.csv", "summary.txt", "frames", "frames.pvd", "film.gif"];

const HEAD: &str = "load_step,load_factor,energy_j,newton_iterations,halvings,factorisations,linear_iterations,\
    residual_n,smallest_det_f,largest_displacement_m,seconds\n";

impl Recorder {
    /// A recorder that writes into `folder`, which is there.
    pub(crate) fn new(folder: &Path, formats: &[Format]) -> Self {
        let (folder, formats) = (folder.to_owned(), formats.to_vec());
        Self { folder, formats, series: Vec::new(), states: Vec::new(), table: HEAD.to_owned() }
    }

    /// Adds a row to the table.
    pub(crate) fn add_row(&mut self, step: &LoadStep) {
        let LoadStep { number, load_factor, energy, residual, report, .. } = step;
        let (volume, far) = (step.smallest_volume_ratio, step.largest_displacement);
        // Writing to a string does not fail. `{:?}` of a number reads back to the same bits.
        let _ = writeln!(
            self.table,
            "{number},{load_factor:?},{energy:?},{},{},{},{},{residual:?},{volume:?},{far:?},{:.6}",
            report.iterations,
            report.halvings,
            report.factorisations,
            report.linear_iterations,
            step.time.as_secs_f64()
        );
    }

    /// Writes a frame of the state `x` after `step` load steps.
    pub(crate) fn add_frame(
        &mut self,
        bodies: &Bodies,
        step: usize,
        load_factor: f64,
        x: &[Vec3],
    ) -> Result<(), ExperimentError> {
        let frames = self.folder.join("frames");
        std::fs::create_dir_all(&frames)
            .map_err(|source| ExperimentError::Write { path: frames.clone(), source })?;
        let stem = format!("frame_{step:05}");
        for format in self.formats.clone() {
            match format {
                Format::Vtu => {
                    let name = format!("{stem}.vtu");
                    write_vtu(bodies, x, &frames.join(&name))?;
                    self.series.push(PvdEntry { time: load_factor, file: format!("frames/{name}") });
                }
                Format::Ply => {
                    let surface = deformed_surface(bodies, x).map_err(ExperimentError::stopped)?;
                    let path = frames.join(format!("{stem}.ply"));
                    ply::write_file(&surface, PlyEncoding::Binary(ByteOrder::LittleEndian), path)
                        .map_err(ExperimentError::stopped)?;
                }
                Format::Obj => {
                    let surface = deformed_surface(bodies, x).map_err(ExperimentError::stopped)?;
                    obj::write_file(&surface, frames.join(format!("{stem}.obj")))
                        .map_err(ExperimentError::stopped)?;
                }
                Format::Png | Format::Gif => {}
            }
        }
        if self.formats.contains(&Format::Png) || self.formats.contains(&Format::Gif) {
            self.states.push((step, load_factor, x.to_vec()));
        }
        Ok(())
    }

    /// Writes what needs all frames, and the table.
    pub(crate) fn finish(self, bodies: &Bodies) -> Result<(), ExperimentError> {
        if !self.series.is_empty() {
            write_pvd_file(&self.series, self.folder.join("frames.pvd")).map_err(ExperimentError::stopped)?;
        }
        let frame = Frame::of(bodies, self.states.iter().map(|(_, _, x)| x.as_slice()));
        let mut film = Film::new(SECONDS_A_FRAME);
        for (step, load_factor, x) in &self.states {
            let image = picture::draw(bodies, x, frame, format!("load {:.0} %", 100.0 * load_factor));
            if self.formats.contains(&Format::Png) {
                image
                    .save_png(&self.folder.join(format!("frames/frame_{step:05}.png")))
                    .map_err(ExperimentError::stopped)?;
            }
            film.push(image).map_err(ExperimentError::stopped)?;
        }
        if self.formats.contains(&Format::Gif) {
            film.save_gif(&self.folder.join("film.gif")).map_err(ExperimentError::stopped)?;
        }
        write_file(&self.folder.join("diagnostics.csv"), self.table.as_bytes())
            .map_err(ExperimentError::stopped)
    }
}

fn write_vtu(bodies: &Bodies, x: &[Vec3], path: &Path) -> Result<(), ExperimentError> {
    let displacement: Vec<Vec3> = x.iter().zip(bodies.mesh().points()).map(|(x, rest)| x - rest).collect();
    let cells = bodies.cell_fields(x);
    let fields = Fields {
        points: &[Field::vectors("displacement", &displacement)],
        cells: &[
            Field::scalars("det F", &cells.volume_ratio),
            Field::scalars("von Mises stress", &cells.von_mises),
            Field { name: "mesh", values: FieldValues::Integers(&cells.body) },
        ],
    };
    let write = || -> Result<(), FrameError> {
        let mesh = TetMesh::new(x.to_vec(), bodies.mesh().cells().to_vec())?;
        Ok(write_vtu_file(&mesh, &fields, VtkEncoding::Base64, path)?)
    };
    write().map_err(ExperimentError::stopped)
}

fn deformed_surface(bodies: &Bodies, x: &[Vec3]) -> Result<TriMesh, MeshError> {
    let surface = bodies.surface();
    let points = surface.source_points().iter().map(|&point| x[point as usize]).collect();
    TriMesh::new(points, surface.triangles().to_vec())
}

/// A frame that cannot be written.
#[derive(Debug, thiserror::Error)]
enum FrameError {
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error(transparent)]
    File(#[from] MeshFileError),
}
