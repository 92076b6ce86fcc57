//! Time for the derivatives of thin bodies an element, and for sweeps of position-based dynamics a constraint.
//!
//! `cargo bench -p lagrangian --bench thin`

#![allow(clippy::print_stdout, reason = "a benchmark prints")]

#[path = "../../mechanics-core/benches/timing/timing.rs"]
mod timing;

use lagrangian::element::hinge::{BendingHessian, Hinges, RestAngle};
use lagrangian::element::membrane::{
    Membranes, NeoHookeanSheet, OrthotropicSheet, SaintVenantKirchhoffSheet, SheetLaw,
};
use lagrangian::element::rod::RodBending;
use lagrangian::element::strain_limit::StrainLimits;
use lagrangian::position_based::{ConstraintGroup, Constraints, Distances, Response};
use mechanics_core::mesh::{Diagonals, PolylineEnds, polyline, sheet};
use mechanics_core::projection::{Projection, project_symmetric};
use mechanics_core::stencil::{LocalHessian, Stencil};
use mechanics_core::tensor::Vec3;
use nalgebra::SMatrix;
use std::hint::black_box;
use timing::{Case, Random, measure};

/// Interleaved repeats, of which the median counts.
const REPEATS: usize = 41;

/// Disturbed elements.
fn elements<const N: usize>(points: &[Vec3], elements: &[[u32; N]], size: f64) -> Vec<[Vec3; N]> {
    let mut random = Random(1);
    let moved: Vec<Vec3> = points.iter().map(|p| p + random.vector() * size).collect();
    elements.iter().map(|e| e.map(|i| moved[i as usize])).collect()
}

fn gradients<S: Stencil<N>, const N: usize>(stencil: &S, x: &[[Vec3; N]]) {
    for (e, x) in x.iter().enumerate() {
        black_box(stencil.gradient(e, x));
    }
}

fn hessians<S: Stencil<N>, const N: usize>(stencil: &S, x: &[[Vec3; N]], projection: Projection) {
    for (e, x) in x.iter().enumerate() {
        black_box(stencil.hessian(e, x, projection));
    }
}

fn flat<const N: usize, const M: usize>(h: &LocalHessian<N>) -> SMatrix<f64, M, M> {
    SMatrix::from_fn(|i, j| h[i / 3][j / 3][(i % 3, j % 3)])
}

/// Projection of the whole element's matrix by nalgebra's eigenvalues.
fn by_nalgebra<S: Stencil<N>, const N: usize, const M: usize>(stencil: &S, x: &[[Vec3; N]]) {
    for (e, x) in x.iter().enumerate() {
        let matrix = nalgebra::DMatrix::from_iterator(
            M,
            M,
            flat::<N, M>(&stencil.hessian(e, x, Projection::None)).iter().copied(),
        );
        let mut eigen = matrix.symmetric_eigen();
        eigen.eigenvalues.iter_mut().for_each(|value| *value = value.max(0.0));
        black_box(eigen.recompose());
    }
}

fn by_jacobi<S: Stencil<N>, const N: usize, const M: usize>(stencil: &S, x: &[[Vec3; N]]) {
    for (e, x) in x.iter().enumerate() {
        let matrix = flat::<N, M>(&stencil.hessian(e, x, Projection::None));
        black_box(project_symmetric(&matrix, Projection::Clamp));
    }
}

fn membranes<L: SheetLaw>(title: &str, law: L) -> Result<(), Box<dyn std::error::Error>> {
    let mesh = sheet([1.0, 1.0], [22, 22], Diagonals::Alternating)?;
    let sheet = Membranes::new(&mesh, law, 1e-3)?;
    let x = elements(mesh.points(), mesh.triangles(), 0.01);
    let n = x.len();
    measure(
        title,
        REPEATS,
        vec![
            Case::new("Hessian, clamped", n, || hessians(&sheet, &x, Projection::Clamp)),
            Case::new("gradient", n, || gradients(&sheet, &x)),
            Case::new("Hessian, not projected", n, || hessians(&sheet, &x, Projection::None)),
            Case::new("Hessian, 9×9 by core's Jacobi", n, || by_jacobi::<_, 3, 9>(&sheet, &x)),
            Case::new("Hessian, 9×9 by nalgebra", n, || by_nalgebra::<_, 3, 9>(&sheet, &x)),
        ],
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    membranes("neo-Hookean membrane", NeoHookeanSheet::new(1.0, 0.3)?)?;
    membranes("St. Venant–Kirchhoff membrane", SaintVenantKirchhoffSheet::new(1.0, 0.3)?)?;
    membranes("orthotropic membrane", OrthotropicSheet::new([2.0, 1.0], 0.2, 0.4)?)?;

    let mesh = sheet([1.0, 1.0], [18, 18], Diagonals::Alternating)?;
    let hinges = Hinges::new(&mesh, 1.0, RestAngle::OfMesh)?;
    let spectral = hinges.clone().with_hessian(BendingHessian::Spectral);
    let x = elements(mesh.points(), hinges.points(), 0.01);
    let n = x.len();
    measure(
        "hinge",
        REPEATS,
        vec![
            Case::new("Hessian, clamped (spectral)", n, || hessians(&spectral, &x, Projection::Clamp)),
            Case::new("gradient", n, || gradients(&hinges, &x)),
            Case::new("Hessian, not projected", n, || hessians(&hinges, &x, Projection::None)),
            Case::new("Hessian, Gauss–Newton", n, || hessians(&hinges, &x, Projection::Clamp)),
            Case::new("Hessian, 12×12 by core's Jacobi", n, || by_jacobi::<_, 4, 12>(&hinges, &x)),
            Case::new("Hessian, 12×12 by nalgebra", n, || by_nalgebra::<_, 4, 12>(&hinges, &x)),
        ],
    );

    let limits = StrainLimits::new(&mesh, [1.0, 3.0], 1.0, 1e-3)?;
    let triangles = elements(mesh.points(), mesh.triangles(), 0.01);
    let line: Vec<Vec3> = (0..=1000).map(|i| Vec3::x() * (f64::from(i) * 0.05)).collect();
    let rod = RodBending::new(&polyline(line.clone(), PolylineEnds::Open)?, 1.0)?;
    let joints = elements(&line, rod.points(), 0.01);
    let (t, j) = (triangles.len(), joints.len());
    measure(
        "strain limit and rod joint",
        REPEATS,
        vec![
            Case::new("strain limit, Hessian", t, || hessians(&limits, &triangles, Projection::Clamp)),
            Case::new("strain limit, gradient", t, || gradients(&limits, &triangles)),
            Case::new("rod joint, Hessian, clamped", j, || hessians(&rod, &joints, Projection::Clamp)),
            Case::new("rod joint, gradient", j, || gradients(&rod, &joints)),
        ],
    );

    let edges = mesh.edges();
    let distances = Distances::new(mesh.points(), &edges)?;
    let mut springs =
        ConstraintGroup::new("springs", distances, edges.clone(), Response::rigid(edges.len()))?;
    let (mut x, w) = (mesh.points().to_vec(), vec![1.0; mesh.points().len()]);
    measure(
        "position-based dynamics",
        REPEATS,
        vec![Case::new("sweep over distances", edges.len(), || {
            black_box(springs.sweep(&mut x, &w, 0.01));
        })],
    );
    Ok(())
}
