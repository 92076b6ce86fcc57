//! Mesh files: OBJ, STL, PLY and MSH are read and written, VTU, VTP and PVD written.
//!
//! | module | format | reads | writes |
//! |---|---|---|---|
//! | [`obj`] | Wavefront OBJ | triangles, polygons, lines, points | the same |
//! | [`stl`] | STL, ASCII and binary | triangles, welded | triangles |
//! | [`ply`] | PLY, ASCII and binary of both byte orders | vertices, polygons, edges by property name | the same |
//! | [`msh`] | Gmsh MSH 2.2 and 4.1, ASCII and binary | tetrahedra, triangles, lines, points with their groups | the same |
//! | [`vtk`] | VTU, VTP and PVD for ParaView | – | cells with point and cell fields, time series |
//!
//! **Input is not trusted.** Readers take bytes; for no bytes do they panic. Memory and time are bounded by a
//! multiple of the number of bytes, because nothing is allocated for what a header claims before the bytes for it
//! have been seen. An error names the format, the line (text) or byte offset (binary), what was found and what was
//! expected. Nothing is repaired in silence: what a reader leaves out is in its answer.
//!
//! **Output appears whole or not at all**: files are written under a temporary name, synced, then renamed.
//!
//! **Why no libraries.** Looked at were tobj 4.0, stl_io 0.11, ply-rs-bw 4.0, serde-ply 0.2 and mshio. tobj's errors
//! say neither line nor value, and it reads f32 by default; stl_io holds f32 only, where ASCII files have more digits;
//! ply-rs-bw brings a parser generator, serde-ply serde; mshio has had no release since 2020 and does not read MSH 2.2.
//! The readers here are a few hundred lines in all over shared cursors, with one kind of error, and are fuzzed.

mod atomic;
mod bytes;
mod error;
pub mod msh;
pub mod obj;
pub mod ply;
pub mod stl;
mod text;
pub mod vtk;

pub use error::{MeshFileError, MeshFormat, Place};
