//! Reads the Stanford bunny, as a surface and as tetrahedra, and prints its volume and its worst tetrahedra:
//!
//! ```text
//! cargo run -p mechanics-core --example bunny_quality [folder]
//! ```
//!
//! With a folder it also writes `bunny.vtu` there, for ParaView, with the mean ratio of every tetrahedron.
#![allow(clippy::print_stdout)]

use mechanics_core::mesh::io::vtk::{Field, Fields, VtkEncoding, write_vtu_file};
use mechanics_core::mesh::io::{msh, obj};
use mechanics_core::mesh::{QualitySummary, Surface};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/assets/meshes");
    let surface = Surface::of_triangles(&obj::read_file(assets.join("bunny.obj"))?);
    surface.check_closed()?;
    let genus = 1 - surface.euler_characteristic() / 2;
    println!(
        "surface: {} triangles, genus {genus}, volume {:.4}",
        surface.triangles().len(),
        surface.volume()
    );

    let bunny = msh::read_file(assets.join("bunny_tet.msh"))?.tet_mesh()?;
    bunny.check_orientation()?;
    println!("tets:    {} cells, all positive, volume {:.4}", bunny.cells().len(), bunny.volume());
    if let Some(worst) = bunny.quality_summary() {
        print_worst(&worst);
    }
    if let Some(folder) = std::env::args_os().nth(1) {
        let path = Path::new(&folder).join("bunny.vtu");
        let ratios: Vec<f64> = bunny.qualities().iter().map(|q| q.mean_ratio).collect();
        let cells = [Field::scalars("mean ratio", &ratios)];
        write_vtu_file(&bunny, &Fields { points: &[], cells: &cells }, VtkEncoding::Base64, &path)?;
        println!("wrote {}", path.display());
    }
    Ok(())
}

fn print_worst(worst: &QualitySummary) {
    let degrees = |angle: f64| angle.to_degrees();
    let (low, high) = (worst.min_dihedral_angle, worst.max_dihedral_angle);
    println!("smallest dihedral angle {:6.2}° in tetrahedron {}", degrees(low.value), low.cell);
    println!("largest dihedral angle  {:6.2}° in tetrahedron {}", degrees(high.value), high.cell);
    println!(
        "smallest mean ratio     {:6.3}  in tetrahedron {}",
        worst.mean_ratio.value, worst.mean_ratio.cell
    );
}
