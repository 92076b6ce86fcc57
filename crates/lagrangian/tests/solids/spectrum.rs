//! Frequencies of bars.

use crate::{number, reference};
use lagrangian::element::{Mass, MassDistribution, Springs, Tetrahedra};
use mechanics_core::law::{Lame, Linear};
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::tensor::Vec3;
use nalgebra::{DMatrix, SymmetricEigen};

/// The stiffness of a term over the unknowns of a map, whole.
fn stiffness(term: &dyn Potential, map: &PointMap, x: &[Vec3]) -> DMatrix<f64> {
    let mut assembly = Assembly::new(map);
    let mut assembler = assembly.begin(map);
    term.add_hessian(x, Projection::None, &mut assembler);
    let matrix = assembler.finish();
    let mut whole = DMatrix::zeros(matrix.dimension(), matrix.dimension());
    for column in 0..matrix.pattern().columns() {
        for slot in matrix.pattern().column(column) {
            let row = matrix.pattern().rows()[slot] as usize;
            whole.fixed_view_mut::<3, 3>(3 * row, 3 * column).copy_from(&matrix.blocks()[slot]);
            let transposed = matrix.blocks()[slot].transpose();
            whole.fixed_view_mut::<3, 3>(3 * column, 3 * row).copy_from(&transposed);
        }
    }
    whole
}

/// The mass over the same unknowns, by its action on unit vectors.
fn mass_matrix(mass: &Mass, map: &PointMap) -> DMatrix<f64> {
    let n = 3 * map.unknowns();
    let mut whole = DMatrix::zeros(n, n);
    let mut unit = vec![0.0; n];
    let (mut v, mut column) = (vec![Vec3::zeros(); map.points()], vec![0.0; n]);
    for k in 0..n {
        unit[k] = 1.0;
        map.displacements_into(&unit, &mut v);
        map.gradient_into(&mass.momenta(&v), &mut column);
        whole.column_mut(k).copy_from_slice(&column);
        unit[k] = 0.0;
    }
    whole
}

/// ω² of K q = ω² M q with the modes as columns q, ascending.
fn modes(k: &DMatrix<f64>, m: &DMatrix<f64>) -> Vec<(f64, nalgebra::DVector<f64>)> {
    let l = m.clone().cholesky().unwrap().l();
    let inverse = l.clone().try_inverse().unwrap();
    let SymmetricEigen { eigenvalues, eigenvectors } =
        SymmetricEigen::new(&inverse * k * inverse.transpose());
    let mut order: Vec<usize> = (0..eigenvalues.len()).collect();
    order.sort_by(|&a, &b| eigenvalues[a].total_cmp(&eigenvalues[b]));
    order.into_iter().map(|i| (eigenvalues[i], inverse.transpose() * eigenvectors.column(i))).collect()
}

/// A fixed–free bar of ten springs with wave speed 1 and length 1: the frequencies of the fixture, which are above the
/// exact (2n − 1)π/2 with consistent mass and below with lumped.
#[test]
fn a_bar_of_springs_has_the_frequencies_of_the_discrete_bar() {
    let n = 10;
    let h = 1.0 / f64::from(n);
    let points: Vec<Vec3> = (0..=n).map(|i| Vec3::new(f64::from(i) * h, 0.0, 0.0)).collect();
    let edges: Vec<[u32; 2]> = (0..n as u32).map(|i| [i, i + 1]).collect();
    let springs = Springs::term("bar", 1.0 / h, &points, edges.clone()).unwrap();
    let map = PointMap::with_fixed(points.len(), &[(0, points[0])]).unwrap();
    let k = stiffness(&springs, &map, &points);
    let axial: Vec<usize> = (0..n as usize).map(|i| 3 * i).collect();
    let part = |whole: &DMatrix<f64>| whole.select_rows(&axial).select_columns(&axial);
    for (distribution, key) in
        [(MassDistribution::Consistent, "consistent"), (MassDistribution::Lumped, "lumped")]
    {
        let mut mass = Mass::zeros(points.len());
        mass.add_elements(&edges, distribution, |_| [[h / 3.0, h / 6.0], [h / 6.0, h / 3.0]]).unwrap();
        let modes = modes(&part(&k), &part(&mass_matrix(&mass, &map)));
        let fixture = reference();
        let rows = fixture["rod_fixed_free_c1_L1_N10"].as_array().unwrap();
        assert!(rows.len() >= 4);
        for (row, (squared, _)) in rows.iter().zip(&modes) {
            let (omega, exact) = (squared.sqrt(), number(&row["exact"]));
            let expected = number(&row[key]);
            assert!((omega - expected).abs() < 1e-12 * expected, "{key} {omega} {expected}");
            assert_eq!(omega > exact, distribution == MassDistribution::Consistent);
        }
    }
}

/// A bar of tetrahedra with ν = 0, held at one end: its axial modes are sin((2n − 1)πx/2L). Consistent mass is a Ritz method, so its
/// frequencies are above the exact ones; the lumped ones are below, and both errors fall as the square of the element length.
#[test]
fn a_bar_of_tetrahedra_vibrates_between_its_two_masses() {
    let lowest_axial = |cells: u32, distribution| {
        let size = Vec3::new(1.0, 0.1, 0.1);
        let mesh = block(&Vec3::zeros(), &size, [cells, 1, 1], BoxSplit::Six).unwrap();
        let law = Linear::new(Lame::from_young_poisson(1.0, 0.0).unwrap());
        let term = Tetrahedra::term("bar", law, &mesh).unwrap();
        let held: Vec<(u32, Vec3)> =
            mesh.points().iter().zip(0..).filter(|(x, _)| x.x == 0.0).map(|(x, i)| (i, *x)).collect();
        let map = PointMap::with_fixed(mesh.points().len(), &held).unwrap();
        let mut mass = Mass::zeros(mesh.points().len());
        mass.add_tetrahedra(mesh.points(), mesh.cells(), 1.0, distribution).unwrap();
        let modes = modes(&stiffness(&term, &map, mesh.points()), &mass_matrix(&mass, &map));
        let axial_part =
            |q: &nalgebra::DVector<f64>| q.iter().step_by(3).map(|x| x * x).sum::<f64>() / q.norm_squared();
        modes.into_iter().find(|(_, q)| axial_part(q) > 0.9).unwrap().0.sqrt()
    };
    let exact = 0.5 * std::f64::consts::PI;
    let error = |cells, distribution| lowest_axial(cells, distribution) / exact - 1.0;
    let [above, above2] = [16, 32].map(|cells| error(cells, MassDistribution::Consistent));
    let [below, below2] = [16, 32].map(|cells| error(cells, MassDistribution::Lumped));
    assert!(above > above2 && above2 > 0.0, "{above:e} {above2:e}");
    assert!(below < below2 && below2 < 0.0, "{below:e} {below2:e}");
    let orders = [(above / above2).log2(), (below / below2).log2()];
    assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.15), "{orders:?}");
}
