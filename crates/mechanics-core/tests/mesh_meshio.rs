//! What our writers write is read by programs that are not ours: `meshio` (PyPI) and, where installed, `vtk`, the reader
//! inside ParaView, and `gmsh`. `MESHIO_PYTHON` names a Python interpreter that has them; without it these tests say SKIPPED:
//!
//! ```text
//! python3 -m venv /tmp/venv && /tmp/venv/bin/pip install meshio numpy vtk gmsh
//! MESHIO_PYTHON=/tmp/venv/bin/python cargo test -p mechanics-core --test mesh_meshio -- --nocapture
//! ```
#![cfg(feature = "mesh-files")]
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use mechanics_core::mesh::io::ply::{ByteOrder, PlyEncoding};
use mechanics_core::mesh::io::stl::StlEncoding;
use mechanics_core::mesh::io::vtk::{
    Field, FieldValues, Fields, PvdEntry, VtkEncoding, write_pvd_file, write_vtp_file, write_vtu_file,
};
use mechanics_core::mesh::io::{msh, obj, ply, stl};
use mechanics_core::mesh::{Surface, TriMesh, ball};
use mechanics_core::tensor::{Mat3, Vec3};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A line for each file: its name, the numbers of points and cells of each kind, the sums of coordinates and fields.
const MESHIO: &str = r"
import sys, glob, os, meshio, numpy as np
np.seterr(all='ignore')
for path in sorted(glob.glob(os.path.join(sys.argv[1], '*'))):
    if path.endswith(('.vtp', '.pvd')):
        continue
    m = meshio.read(path)
    cells = {'tetra': 0, 'triangle': 0, 'line': 0, 'vertex': 0}
    for block in m.cells:
        cells[block.type] += len(block.data)
    sums = list(m.points.sum(axis=0)) + [float(sum((b.data * (np.arange(b.data.shape[1]) + 1)).sum() for b in m.cells))]
    for name in ('mass', 'velocity', 'region', 'stress'):
        for data in (m.point_data, m.cell_data):
            if name in data:
                a = np.asarray(data[name]); a = a.reshape(-1, a.shape[-1]) if a.ndim == 3 else a
                a = a.reshape(a.shape[0], -1)
                sums += list((a * (np.arange(a.shape[0]) + 1)[:, None]).sum(axis=0))
    print(os.path.basename(path), len(m.points), *cells.values(), *(repr(float(s)) for s in sums))
";

/// The same for `vtk`, which reads VTP too.
const VTK: &str = r"
import sys, glob, os, numpy as np
try:
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy as array
except ImportError:
    print('no vtk'); sys.exit()
for path in sorted(glob.glob(os.path.join(sys.argv[1], '*.vt[up]'))):
    reader = vtk.vtkXMLUnstructuredGridReader() if path.endswith('u') else vtk.vtkXMLPolyDataReader()
    reader.SetFileName(path); reader.Update(); m = reader.GetOutput()
    kinds = [m.GetCellType(i) for i in range(m.GetNumberOfCells())]
    counts = [kinds.count(k) for k in (10, 5, 3, 1)]
    corners = sum((m.GetCell(i).GetPointId(k)) * (k + 1) for i in range(len(kinds)) for k in range(m.GetCell(i).GetNumberOfPoints()))
    sums = list(array(m.GetPoints().GetData()).sum(axis=0)) + [float(corners)]
    for name in ('mass', 'velocity', 'region', 'stress'):
        for data in (m.GetPointData(), m.GetCellData()):
            if data.HasArray(name):
                a = array(data.GetArray(name)); a = a.reshape(a.shape[0], -1)
                sums += list((a * (np.arange(a.shape[0]) + 1)[:, None]).sum(axis=0))
    print(os.path.basename(path), m.GetNumberOfPoints(), *counts, *(repr(float(s)) for s in sums))
";

/// Gmsh itself, which also checks entities and groups.
const GMSH: &str = r"
import sys, glob, os
try:
    import gmsh
except (ImportError, OSError):
    print('no gmsh'); sys.exit()
gmsh.initialize(); gmsh.option.setNumber('General.Terminal', 0)
for path in sorted(glob.glob(os.path.join(sys.argv[1], '*.msh'))):
    gmsh.open(path)
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    counts = [sum(len(t) for t in gmsh.model.mesh.getElements(d)[1]) for d in (3, 2, 1, 0)]
    nodes = [int(n) - 1 for d in (3, 2, 1, 0) for list in gmsh.model.mesh.getElements(d)[2] for n in list]
    starts = [k % w + 1 for d, w in ((3, 4), (2, 3), (1, 2), (0, 1)) for list in gmsh.model.mesh.getElements(d)[2] for k in range(len(list))]
    corners = sum(n * k for n, k in zip(nodes, starts))
    groups = [len(gmsh.model.mesh.getElements(3, e)[1][0]) * g for d, g in gmsh.model.getPhysicalGroups(3)
              for e in gmsh.model.getEntitiesForPhysicalGroup(3, g)]
    print(os.path.basename(path), len(tags), *counts, sum(xyz[0::3]), sum(xyz[1::3]), sum(xyz[2::3]), float(corners), sum(groups))
";

struct Expected {
    name: String,
    counts: [usize; 5],
    sums: Vec<f64>,
}

/// The sums that the scripts form.
fn expected(name: &str, points: &[Vec3], cells: [&[u32]; 4], fields: &[Vec<f64>]) -> Expected {
    let widths = [4, 3, 2, 1];
    let counts: Vec<usize> = cells.iter().zip(widths).map(|(flat, width)| flat.len() / width).collect();
    let weighted = |(flat, width): (&&[u32], usize)| -> f64 {
        flat.iter().enumerate().map(|(k, &i)| f64::from(i) * (k % width + 1) as f64).sum()
    };
    let total: Vec3 = points.iter().sum();
    let corners: f64 = cells.iter().zip(widths).map(weighted).sum();
    let mut sums = vec![total.x, total.y, total.z, corners];
    sums.extend(fields.iter().flatten());
    Expected { name: name.into(), counts: [points.len(), counts[0], counts[1], counts[2], counts[3]], sums }
}

/// Σ (k + 1) aₖⱼ for each component j of a field.
fn weighted_sums<const C: usize>(rows: impl Iterator<Item = [f64; C]>) -> Vec<f64> {
    let mut sums = [0.0; C];
    for (k, row) in rows.enumerate() {
        (0..C).for_each(|j| sums[j] += (k + 1) as f64 * row[j]);
    }
    sums.to_vec()
}

fn python() -> Option<String> {
    let python = std::env::var("MESHIO_PYTHON").ok();
    if python.is_none() {
        println!("SKIPPED (MESHIO_PYTHON is not set; it names a Python interpreter with meshio)");
    }
    python
}

fn run(python: &str, script: &str, folder: &Path) -> String {
    let output = Command::new(python).args(["-c", script]).arg(folder).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    String::from_utf8(output.stdout).unwrap()
}

fn compare(report: &str, expected: &[Expected]) {
    for wanted in expected {
        let line = report.lines().find(|line| line.split(' ').next() == Some(&wanted.name));
        let line = line.unwrap_or_else(|| panic!("{} is missing in\n{report}", wanted.name));
        let numbers: Vec<f64> = line.split(' ').skip(1).map(|word| word.parse().unwrap()).collect();
        assert_eq!(numbers[..5], wanted.counts.map(|n| n as f64), "{line}");
        assert_eq!(numbers.len() - 5, wanted.sums.len(), "{line}");
        for (found, sum) in numbers[5..].iter().zip(&wanted.sums) {
            // Binary STL rounds to f32; the sums of the others differ by the order of summation.
            let tolerance = if wanted.name == "binary.stl" { 1e-5 } else { 1e-11 };
            assert!((found - sum).abs() <= tolerance * sum.abs().max(1.0), "{line}: {found} is not {sum}");
        }
    }
    println!("{} files agree", expected.len());
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("mechanics-core-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn fields_of(points: usize) -> (Vec<f64>, Vec<Vec3>) {
    let mass = (0..points).map(|k| 1.0 / (k as f64 + 3.0)).collect();
    let velocity = (0..points).map(|k| Vec3::new(k as f64, -0.5, 1e-3 * k as f64)).collect();
    (mass, velocity)
}

#[test]
fn meshio_and_vtk_read_vtu_and_vtp() {
    let Some(python) = python() else { return };
    let folder = folder("vtk");
    let mesh = ball(0.5, 3).unwrap();
    let (mass, velocity) = fields_of(mesh.points().len());
    let region: Vec<i32> = (0..mesh.cells().len() as i32).map(|k| k % 7 - 3).collect();
    let stress: Vec<Mat3> =
        (0..mesh.cells().len()).map(|k| Mat3::from_fn(|i, j| (k * (3 * i + j)) as f64)).collect();
    let point_fields = [Field::scalars("mass", &mass), Field::vectors("velocity", &velocity)];
    let cell_fields = [
        Field { name: "region", values: FieldValues::Integers(&region) },
        Field { name: "stress", values: FieldValues::Tensors(&stress) },
    ];
    let fields = Fields { points: &point_fields, cells: &cell_fields };
    let rows = |a: &Mat3| -> [f64; 9] { std::array::from_fn(|k| a[(k / 3, k % 3)]) };
    let sums = [
        weighted_sums(mass.iter().map(|&m| [m])),
        weighted_sums(velocity.iter().map(|&v| v.into())),
        weighted_sums(region.iter().map(|&r| [f64::from(r)])),
        weighted_sums(stress.iter().map(rows)),
    ];
    let skin = codimensional_ball();
    let (mass, _) = fields_of(skin.points().len());
    let skin_mass = [Field::scalars("mass", &mass)];
    let skin_fields = Fields { points: &skin_mass, cells: &[] };
    let mut in_vtu = Vec::new();
    let mut in_vtp = Vec::new();
    for (encoding, name) in [(VtkEncoding::Ascii, "ascii"), (VtkEncoding::Base64, "base64")] {
        let (vtu, vtp) = (format!("{name}.vtu"), format!("{name}.vtp"));
        write_vtu_file(&mesh, &fields, encoding, folder.join(&vtu)).unwrap();
        write_vtp_file(&skin, &skin_fields, encoding, folder.join(&vtp)).unwrap();
        in_vtu.push(expected(&vtu, mesh.points(), [mesh.cells().as_flattened(), &[], &[], &[]], &sums));
        let cells =
            [&[], skin.triangles().as_flattened(), skin.free_edges().as_flattened(), skin.free_points()];
        in_vtp.push(expected(&vtp, skin.points(), cells, &[weighted_sums(mass.iter().map(|&m| [m]))]));
    }
    let entry = |time: f64, file: &str| PvdEntry { time, file: file.into() };
    write_pvd_file(&[entry(0.0, "ascii.vtu"), entry(0.1, "base64.vtu")], folder.join("series.pvd")).unwrap();
    compare(&run(&python, MESHIO, &folder), &in_vtu);
    let report = run(&python, VTK, &folder);
    if report.starts_with("no vtk") {
        println!("SKIPPED (this Python has no vtk: VTP is not checked)");
    } else {
        in_vtp.extend(in_vtu);
        compare(&report, &in_vtp);
    }
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn meshio_reads_msh_stl_ply_and_obj() {
    let Some(python) = python() else { return };
    let folder = folder("meshio");
    let tets = ball(0.5, 3).unwrap();
    // meshio refuses 4.1 files in which only some cells have a group, which Gmsh does not.
    let mut all = write_msh(&grouped_ball(|k| 1 + i32::from(k >= 100)), &[], &folder);
    let skin = Surface::of_tets(&tets).unwrap().into_mesh();
    let triangles = skin.triangles().as_flattened();
    obj::write_file(&skin, folder.join("mesh.obj")).unwrap();
    all.push(expected("mesh.obj", skin.points(), [&[], triangles, &[], &[]], &[]));
    for (encoding, name) in [
        (PlyEncoding::Ascii, "ascii.ply"),
        (PlyEncoding::Binary(ByteOrder::LittleEndian), "little.ply"),
        (PlyEncoding::Binary(ByteOrder::BigEndian), "big.ply"),
    ] {
        ply::write_file(&skin, encoding, folder.join(name)).unwrap();
        all.push(expected(name, skin.points(), [&[], triangles, &[], &[]], &[]));
    }
    compare(&run(&python, MESHIO, &folder), &all);
    std::fs::remove_dir_all(&folder).unwrap();
    // meshio numbers the points of STL files anew, so only counts and sums of points are compared.
    std::fs::create_dir_all(&folder).unwrap();
    stl::write_file(&skin, StlEncoding::Ascii, folder.join("ascii.stl")).unwrap();
    stl::write_file(&skin, StlEncoding::Binary, folder.join("binary.stl")).unwrap();
    for line in run(&python, MESHIO, &folder).lines() {
        let numbers: Vec<f64> = line.split(' ').skip(1).map(|word| word.parse().unwrap()).collect();
        assert_eq!(
            (numbers[0], numbers[2]),
            (skin.points().len() as f64, skin.triangles().len() as f64),
            "{line}"
        );
        assert!(numbers[5..8].iter().all(|sum| sum.abs() < 1e-4), "a ball's points sum to zero: {line}");
    }
    std::fs::remove_dir_all(folder).unwrap();
}

fn write_msh(file: &msh::MshMesh, fields: &[Vec<f64>], folder: &Path) -> Vec<Expected> {
    let mut all = Vec::new();
    for (version, version_name) in [(msh::MshVersion::V2_2, "22"), (msh::MshVersion::V4_1, "41")] {
        for (encoding, name) in [(msh::MshEncoding::Ascii, "ascii"), (msh::MshEncoding::Binary, "binary")] {
            let name = format!("{name}{version_name}.msh");
            msh::write_file(file, version, encoding, folder.join(&name)).unwrap();
            let cells = [
                file.tets.vertices.as_flattened(),
                file.triangles.vertices.as_flattened(),
                file.edges.vertices.as_flattened(),
                file.vertices.vertices.as_flattened(),
            ];
            all.push(expected(&name, &file.points, cells, fields));
        }
    }
    all
}

fn grouped_ball(groups: impl Fn(i32) -> i32) -> msh::MshMesh {
    let mut file = msh::MshMesh::from(&ball(0.5, 3).unwrap());
    file.tets.groups = (0..file.tets.vertices.len() as i32).map(groups).collect();
    file
}

#[test]
fn gmsh_reads_msh() {
    let Some(python) = python() else { return };
    let folder = folder("gmsh");
    // All kinds of cells; tetrahedra without a group, in group 1 and in group 5.
    let mut file = grouped_ball(|k| [0, 1, 5][k as usize % 3]);
    let skin = Surface::of_tets(&file.tet_mesh().unwrap()).unwrap();
    let back = |i: u32| skin.source_points()[i as usize];
    file.triangles.vertices = skin.triangles().iter().map(|t| t.map(back)).collect();
    file.triangles.groups = vec![2; skin.triangles().len()];
    (file.edges.vertices, file.edges.groups) = (vec![[0, 1], [1, 2]], vec![0, 9]);
    (file.vertices.vertices, file.vertices.groups) = (vec![[3]], vec![0]);
    // 180 tetrahedra in each third.
    let all = write_msh(&file, &[vec![180.0 * (1.0 + 5.0)]], &folder);
    let report = run(&python, GMSH, &folder);
    if report.starts_with("no gmsh") {
        println!("SKIPPED (this Python has no gmsh)");
    } else {
        compare(&report, &all);
    }
    std::fs::remove_dir_all(folder).unwrap();
}

fn codimensional_ball() -> TriMesh {
    let skin = Surface::of_tets(&ball(0.5, 2).unwrap()).unwrap().into_mesh();
    let (mut points, triangles) = (skin.points().to_vec(), skin.triangles().to_vec());
    let n = points.len() as u32;
    points.extend([Vec3::new(1.0, 2.0, 3.0), Vec3::new(-1.0, 1.0 / 3.0, 3.0), Vec3::new(5.0, 5.0, 5.0)]);
    TriMesh::with_codimensional(points, triangles, vec![[0, n], [n, n + 1]], vec![n + 2]).unwrap()
}
