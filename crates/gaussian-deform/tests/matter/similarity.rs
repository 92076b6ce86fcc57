use super::Random;
use gaussian_deform::bind::Moved;
use gaussian_deform::similarity::Similarity;
use gaussian_deform::transport::{Colours, Transport};
use gaussian_deform::{Degree, Splat, SplatError, Splats, shape};
use mechanics_core::mesh::BoundingBox;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::{Mat3, Vec3};

fn turned() -> Similarity {
    let rotation = shape::axes([1.0; 3], [0.3, -0.5, 0.2, 0.7]).unwrap();
    Similarity::new(0.37, rotation, Vec3::new(0.5, 1.5, -2.0)).unwrap()
}

fn scene() -> Splats<f64> {
    let mut random = Random(4);
    let mut splats = Splats::new(Degree::Three);
    for _ in 0..30 {
        let harmonics: Vec<f64> = (0..48).map(|_| random.next()).collect();
        let (mean, axes) = (random.vector(), random.matrix());
        splats.push(Splat { mean, axes, opacity: 0.5, harmonics: &harmonics });
    }
    splats
}

/// The scene moved in the simulation's coordinates and looked at there, and the scene moved in its own by what came back, are one.
#[test]
fn a_motion_there_is_the_motion_here() {
    let (similarity, rest) = (turned(), scene());
    let there = similarity.apply(&rest);
    let mut random = Random(5);
    let all: Vec<u32> = (0..30).collect();
    let positions: Vec<Vec3> = (0..30).map(|_| random.vector()).collect();
    let gradients: Vec<Mat3> = (0..30).map(|_| Mat3::identity() + random.matrix() * 0.5).collect();
    let samples = DeformationSamples::new(&positions, &gradients);
    let mut in_simulation = Transport::new(there, all.clone(), Colours::RotateCoefficients).unwrap();
    in_simulation.deform(samples).unwrap();
    let mut back = Moved::new();
    similarity.motion_back_into(samples, &mut back);
    let mut in_scene = Transport::new(rest, all, Colours::RotateCoefficients).unwrap();
    in_scene.deform(back.samples()).unwrap();
    let (found, expected) = (similarity.apply(in_scene.frame()), in_simulation.frame());
    for i in 0..30 {
        assert!((found.means()[i] - expected.means()[i]).norm() < 1e-14);
        assert!((found.axes()[i] - expected.axes()[i]).norm() < 1e-14);
        let pairs = found.harmonics_of(i).iter().zip(expected.harmonics_of(i));
        assert!(pairs.fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) < 5e-14);
    }
}

/// Turning colours by the rotation R that the simulation sees, and not by Qᵀ R Q, is an error that this scene shows.
#[test]
fn rotations_of_the_simulation_are_not_those_of_the_scene() {
    let (similarity, rest) = (turned(), scene());
    let r: Mat3 = shape::axes([1.0; 3], [0.8, 0.1, 0.5, -0.3]).unwrap();
    let q = similarity.rotation();
    assert!((similarity.gradient_back(&r) - q.transpose() * r * q).norm() < 1e-15);
    let all: Vec<u32> = (0..30).collect();
    let frame = |f: Mat3| {
        let gradients = [f; 30];
        let mut transport = Transport::new(rest.clone(), all.clone(), Colours::RotateCoefficients).unwrap();
        transport.deform(DeformationSamples::new(rest.means(), &gradients)).unwrap();
        similarity.apply(transport.frame())
    };
    let mut there =
        Transport::new(similarity.apply(&rest), all.clone(), Colours::RotateCoefficients).unwrap();
    let positions: Vec<Vec3> = rest.means().iter().map(|x| similarity.point(x)).collect();
    there.deform(DeformationSamples::new(&positions, &[r; 30])).unwrap();
    let distance = |other: &Splats<f64>| {
        let pairs = other.harmonics().iter().zip(there.frame().harmonics());
        pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
    };
    assert!(distance(&frame(similarity.gradient_back(&r))) < 5e-14);
    assert!(distance(&frame(r)) > 0.1);
}

#[test]
fn whole_scenes_go_there_and_back() {
    let (similarity, rest) = (turned(), scene());
    let back = similarity.inverse().unwrap().apply(&similarity.apply(&rest));
    for i in 0..30 {
        assert!((back.means()[i] - rest.means()[i]).norm() < 1e-14);
        assert!((back.axes()[i] - rest.axes()[i]).norm() < 1e-14);
        let pairs = back.harmonics_of(i).iter().zip(rest.harmonics_of(i));
        assert!(pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) < 5e-14);
    }
    let tiny = Similarity::new(1e-200, Mat3::identity(), Vec3::repeat(1e200)).unwrap();
    assert!(matches!(tiny.inverse(), Err(SplatError::BadSimilarity { .. })));
}

#[test]
fn points_go_there_and_back() {
    let similarity = turned();
    let mut random = Random(6);
    for _ in 0..100 {
        let x = random.vector() * 10.0;
        assert!((similarity.point_back(&similarity.point(&x)) - x).norm() < 4e-14);
    }
}

#[test]
fn boxes_are_fitted_as_large_as_they_go() {
    let from = BoundingBox { min: Vec3::new(-1.0, 2.0, 5.0), max: Vec3::new(3.0, 3.0, 7.0) };
    let to = BoundingBox { min: Vec3::repeat(0.2), max: Vec3::repeat(0.8) };
    let rotation = *turned().rotation();
    for rotation in [Mat3::identity(), rotation, rotation.transpose()] {
        let fitted = Similarity::fitting(&from, &to, rotation).unwrap();
        let mut around = BoundingBox { min: Vec3::repeat(f64::MAX), max: Vec3::repeat(-f64::MAX) };
        for corner in 0..8 {
            let pick = |k: usize| if corner >> k & 1 == 0 { from.min[k] } else { from.max[k] };
            let y = fitted.point(&Vec3::new(pick(0), pick(1), pick(2)));
            around = BoundingBox { min: around.min.inf(&y), max: around.max.sup(&y) };
        }
        assert!((around.size().max() - 0.6).abs() < 1e-14, "{around:?}");
        assert!((around.centre() - to.centre()).norm() < 1e-14);
    }
    let point = BoundingBox { min: from.min, max: from.min };
    assert!(matches!(Similarity::fitting(&point, &to, rotation), Err(SplatError::BadSimilarity { .. })));
    for (scale, rotation) in [(0.0, rotation), (-1.0, rotation), (1.0, -rotation), (1.0, rotation * 2.0)] {
        assert!(Similarity::new(scale, rotation, Vec3::zeros()).is_err());
    }
}
