use super::Random;
use gaussian_deform::SplatError;
use gaussian_deform::bind::{Moved, SampleBinding, TetBinding, TetGradients};
use mechanics_core::mesh::{BoxSplit, TetMesh, block};
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::{Mat3, Vec3};

const BOTH: [TetGradients; 2] = [TetGradients::Constant, TetGradients::Smooth];

fn cube(cells: u32) -> TetMesh {
    block(&Vec3::zeros(), &Vec3::repeat(1.0), [cells; 3], BoxSplit::Six).unwrap()
}

/// Points of the unit cube and, where `beyond` is positive, around it.
fn points(count: usize, beyond: f64) -> Vec<Vec3> {
    let mut random = Random(8);
    (0..count).map(|_| random.vector() * (0.5 + beyond) + Vec3::repeat(0.5)).collect()
}

fn affine() -> (Mat3, Vec3) {
    (Mat3::new(1.2, 0.3, -0.1, 0.0, 0.8, 0.4, -0.2, 0.1, 1.1), Vec3::new(1.0, -2.0, 3.0))
}

#[test]
fn affine_motions_of_tetrahedra_are_exact_inside_and_outside() {
    let (mesh, means) = (cube(5), points(400, 0.3));
    let (f, c) = affine();
    let vertices: Vec<Vec3> = mesh.points().iter().map(|x| f * x + c).collect();
    for gradients in BOTH {
        let binding = TetBinding::new(&mesh, &means, gradients).unwrap();
        let mut moved = Moved::new();
        binding.move_into(&vertices, &mut moved).unwrap();
        for (k, mean) in means.iter().enumerate() {
            assert!((moved.samples().positions()[k] - (f * mean + c)).norm() < 1e-13);
            assert!((moved.samples().gradients()[k] - f).norm() < 1e-13);
        }
    }
}

/// The distance to a cube is known; the tetrahedron found must be that near.
#[test]
fn means_belong_to_the_tetrahedron_around_them_or_to_the_nearest() {
    let (mesh, means) = (cube(6), points(1_000, 0.4));
    let binding = TetBinding::new(&mesh, &means, TetGradients::Constant).unwrap();
    let outside = |x: &Vec3| (x - x.sup(&Vec3::zeros()).inf(&Vec3::repeat(1.0))).norm();
    let mut farthest: f64 = 0.0;
    for (k, mean) in means.iter().enumerate() {
        let (tet, weights) = binding.place(k);
        let corners = mesh.corners(tet as usize);
        let sum: Vec3 = (0..4).map(|j| corners[j] * weights[j]).sum();
        assert!((sum - mean).norm() < 1e-13 && (weights.iter().sum::<f64>() - 1.0).abs() < 1e-13);
        // Alone, that tetrahedron is as near as the whole cube.
        let alone = TetMesh::new(corners.to_vec(), vec![[0, 1, 2, 3]]).unwrap();
        let near = TetBinding::new(&alone, &[*mean], TetGradients::Constant).unwrap();
        assert!((near.farthest() - outside(mean)).abs() < 1e-13, "{mean:?}");
        farthest = farthest.max(outside(mean));
    }
    assert!((binding.farthest() - farthest).abs() < 1e-13);
    assert_eq!(binding.outside(), means.iter().filter(|x| outside(x) > 0.0).count());
}

/// A smooth motion that is not affine, and its gradient.
fn bend(x: &Vec3) -> (Vec3, Mat3) {
    let position = Vec3::new(x.x + 0.3 * x.y * x.y, x.y + 0.2 * x.x * x.z, x.z - 0.25 * x.x * x.x);
    let gradient = Mat3::new(1.0, 0.6 * x.y, 0.0, 0.2 * x.z, 1.0, 0.2 * x.x, -0.5 * x.x, 0.0, 1.0);
    (position, gradient)
}

/// Errors of positions and of gradients, root mean squares over points well inside.
fn errors(moved: &Moved, means: &[Vec3]) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (k, mean) in means.iter().enumerate() {
        let (x, f) = bend(mean);
        sums[0] += (moved.samples().positions()[k] - x).norm_squared();
        sums[1] += (moved.samples().gradients()[k] - f).norm_squared();
    }
    sums.map(|sum| (sum / means.len() as f64).sqrt())
}

#[test]
fn finer_tetrahedra_follow_a_bend_to_second_order() {
    let means = points(500, -0.2);
    for gradients in BOTH {
        let [coarse, fine] = [4, 8].map(|cells| {
            let mesh = cube(cells);
            let vertices: Vec<Vec3> = mesh.points().iter().map(|x| bend(x).0).collect();
            let mut moved = Moved::new();
            TetBinding::new(&mesh, &means, gradients).unwrap().move_into(&vertices, &mut moved).unwrap();
            errors(&moved, &means)
        });
        assert!((coarse[0] / fine[0]).log2() > 1.8, "{coarse:?} {fine:?}");
        // Piecewise constant gradients are of first order; averages of a quadratic motion on a regular mesh of second.
        let order = if gradients == TetGradients::Constant { 0.85 } else { 1.6 };
        assert!((coarse[1] / fine[1]).log2() > order, "{gradients:?} {coarse:?} {fine:?}");
    }
}

fn lattice(cells: usize) -> Vec<Vec3> {
    let h = 1.0 / cells as f64;
    let mut random = Random(9);
    let index = |n: usize| [n / cells / cells, n / cells % cells, n % cells];
    (0..cells.pow(3))
        .map(|n| Vec3::from(index(n).map(|i| (i as f64 + 0.5) * h)) + random.vector() * (0.3 * h))
        .collect()
}

#[test]
fn affine_motions_of_samples_are_exact() {
    let (samples, means) = (lattice(6), points(300, 0.3));
    let (f, c) = affine();
    let positions: Vec<Vec3> = samples.iter().map(|x| f * x + c).collect();
    let gradients = vec![f; samples.len()];
    for neighbours in [1, 4, 8, 1000] {
        let binding = SampleBinding::new(&samples, &means, neighbours).unwrap();
        let mut moved = Moved::new();
        binding.move_into(DeformationSamples::new(&positions, &gradients), &mut moved).unwrap();
        for (k, mean) in means.iter().enumerate() {
            assert!((moved.samples().positions()[k] - (f * mean + c)).norm() < 2e-13);
            assert!((moved.samples().gradients()[k] - f).norm() < 1e-13);
        }
    }
}

#[test]
fn neighbours_are_the_nearest() {
    let (samples, means) = (lattice(7), points(300, 0.5));
    let binding = SampleBinding::new(&samples, &means, 6).unwrap();
    for (k, mean) in means.iter().enumerate() {
        let mut all: Vec<(f64, u32)> =
            (0..).zip(&samples).map(|(i, x)| ((x - mean).norm_squared(), i)).collect();
        all.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let found: Vec<u32> = binding.weights(k).iter().map(|w| w.0).collect();
        assert_eq!(found, all[..6].iter().map(|x| x.1).collect::<Vec<_>>());
        let kernel = |d: f64| (1.0 - d / all[6].0).powi(2);
        let sum: f64 = all[..6].iter().map(|x| kernel(x.0)).sum();
        for (weight, (d, _)) in binding.weights(k).iter().zip(&all) {
            assert!((weight.1 - kernel(*d) / sum).abs() < 1e-12);
        }
    }
}

#[test]
fn finer_samples_follow_a_bend() {
    let means = points(500, -0.2);
    let [coarse, fine] = [8, 16].map(|cells| {
        let samples = lattice(cells);
        let (positions, gradients): (Vec<Vec3>, Vec<Mat3>) = samples.iter().map(bend).unzip();
        let mut moved = Moved::new();
        let binding = SampleBinding::new(&samples, &means, 8).unwrap();
        binding.move_into(DeformationSamples::new(&positions, &gradients), &mut moved).unwrap();
        errors(&moved, &means)
    });
    assert!((coarse[0] / fine[0]).log2() > 1.8, "{coarse:?} {fine:?}");
    assert!((coarse[1] / fine[1]).log2() > 0.85, "{coarse:?} {fine:?}");
}

#[test]
fn degenerate_bindings() {
    let means = points(5, 0.0);
    let coincident = vec![Vec3::repeat(0.25); 20];
    let binding = SampleBinding::new(&coincident, &[coincident[0], means[0]], 3).unwrap();
    for k in 0..2 {
        assert!((binding.weights(k).iter().map(|w| w.1).sum::<f64>() - 1.0).abs() < 1e-14);
    }
    assert_eq!(SampleBinding::new(&[], &means, 3).unwrap_err(), SplatError::NoSamples);
    let bad = [Vec3::zeros(), Vec3::new(0.0, f64::NAN, 0.0)];
    assert!(matches!(SampleBinding::new(&bad, &means, 3), Err(SplatError::BadSample { sample: 1, .. })));
    assert!(matches!(SampleBinding::new(&means, &bad, 3), Err(SplatError::BadPoint { point: 1, .. })));
    let flat =
        TetMesh::new(vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::x() + Vec3::y()], vec![[0, 1, 2, 3]]);
    let error = TetBinding::new(&flat.unwrap(), &means, TetGradients::Constant).unwrap_err();
    assert_eq!(error, SplatError::FlatTet { tet: 0 });
    let binding = TetBinding::new(&cube(1), &means, TetGradients::Smooth).unwrap();
    let error = binding.move_into(&[Vec3::zeros(); 3], &mut Moved::new()).unwrap_err();
    assert_eq!(error, SplatError::SampleCount { samples: 3, matter: 8 });
    let far = [Vec3::new(1e12, -1e9, 3.0)];
    let binding = TetBinding::new(&cube(3), &far, TetGradients::Constant).unwrap();
    assert!((binding.farthest() / 1e12 - 1.0).abs() < 1e-5);
}
