//! What a run leaves in its folder: frames, a film, and a table of its steps.

use super::Bodies;
use super::course::{Course, Step};
use super::picture::{self, Frame, Snapshot};
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
use std::path::{Path, PathBuf};

/// Writes frames as they come, pictures and tables at the end.
pub(crate) struct Recorder {
    folder: PathBuf,
    formats: Vec<Format>,
    series: Vec<PvdEntry>,
    /// States that will be drawn, by the number of steps before them.
    states: Vec<(usize, Snapshot)>,
    /// How long a frame of the film stands [s].
    seconds_a_frame: f64,
    table: String,
}

/// The names in the output folder, so that an earlier run's folder can be told from any other.
pub(crate) const FILES: [&str; 6] =
    ["diagnostics.csv", "summary.txt", "frames", "frames.pvd", "film.gif", "film.mp4"];

impl Recorder {
    /// A recorder of `course`, every so many steps of it, that writes into `folder`, which is there.
    pub(crate) fn new(folder: &Path, formats: &[Format], course: &Course, frame_every: usize) -> Self {
        Self {
            folder: folder.to_owned(),
            formats: formats.to_vec(),
            series: Vec::new(),
            states: Vec::new(),
            seconds_a_frame: course.seconds_a_frame(frame_every),
            table: format!("{}\n", course.head()),
        }
    }

    /// Adds a row to the table.
    pub(crate) fn add_row(&mut self, step: &Step) {
        self.table.push_str(&step.row());
        self.table.push('\n');
    }

    /// Writes a frame of the state of `course` now.
    pub(crate) fn add_frame(&mut self, course: &Course) -> Result<(), ExperimentError> {
        let (bodies, x) = (course.bodies(), course.positions());
        let frames = self.folder.join("frames");
        std::fs::create_dir_all(&frames)
            .map_err(|source| ExperimentError::Write { path: frames.clone(), source })?;
        let stem = format!("frame_{:05}", course.done());
        for format in self.formats.clone() {
            match format {
                Format::Vtu => {
                    let name = format!("{stem}.vtu");
                    write_vtu(course, &frames.join(&name))?;
                    self.series.push(PvdEntry { time: course.progress(), file: format!("frames/{name}") });
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
                Format::Png | Format::Gif | Format::Mp4 => {}
            }
        }
        if self.formats.iter().any(|format| matches!(format, Format::Png | Format::Gif | Format::Mp4)) {
            self.states.push((course.done(), Snapshot::of(course)));
        }
        Ok(())
    }

    /// Writes what needs all frames, and the table.
    pub(crate) fn finish(self, bodies: &Bodies) -> Result<(), ExperimentError> {
        if !self.series.is_empty() {
            write_pvd_file(&self.series, self.folder.join("frames.pvd")).map_err(ExperimentError::stopped)?;
        }
        let frame = Frame::of(bodies, self.states.iter().map(|(_, snapshot)| snapshot));
        let mut film = Film::new(self.seconds_a_frame);
        for (step, snapshot) in &self.states {
            let image = picture::draw(bodies, snapshot, frame);
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
        if self.formats.contains(&Format::Mp4) {
            film.save_mp4(&self.folder.join("film.mp4")).map_err(ExperimentError::stopped)?;
        }
        write_file(&self.folder.join("diagnostics.csv"), self.table.as_bytes())
            .map_err(ExperimentError::stopped)
    }
}

fn write_vtu(course: &Course, path: &Path) -> Result<(), ExperimentError> {
    let (bodies, x) = (course.bodies(), course.positions());
    let displacement: Vec<Vec3> = x.iter().zip(bodies.mesh().points()).map(|(x, rest)| x - rest).collect();
    let cells = bodies.cell_fields(x);
    let mut points = vec![Field::vectors("displacement", &displacement)];
    points.extend(course.velocities().map(|v| Field::vectors("velocity", v)));
    let fields = Fields {
        points: &points,
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
