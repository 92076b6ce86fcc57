//! Splats follow a formula, simple shear: no solver is there at all.

use gaussian_deform::mechanics_core::samples::DeformationSamples;
use gaussian_deform::mechanics_core::tensor::{Mat3, Vec3};
use gaussian_deform::select::{Criteria, select};
use gaussian_deform::shape;
use gaussian_deform::transport::{Colours, Transport};
use gaussian_deform::{Degree, Splat, Splats};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let axes = shape::axes([0.05, 0.03, 0.01], [1.0, 0.0, 0.0, 0.0]).ok_or("a quaternion of zero")?;
    let mut scene = Splats::<f64>::new(Degree::Zero);
    for i in 0..10 {
        let mean = Vec3::new(0.1 * f64::from(i), 0.0, 0.0);
        scene.push(Splat { mean, axes, opacity: 0.9, harmonics: &[0.2, 0.1, 0.0] });
    }
    let rest = scene.means().to_vec();
    let matter = select(&scene, &Criteria::default())?;
    let mut transport = Transport::new(scene, matter, Colours::RotateCoefficients)?;

    // Simple shear of one half: x' = x + ½ y, with F the same everywhere.
    let mut shear = Mat3::identity();
    shear[(0, 1)] = 0.5;
    let moved: Vec<Vec3> = rest.iter().map(|x| shear * x).collect();
    transport.deform(DeformationSamples::new(&moved, &vec![shear; moved.len()]))?;

    // F A Fᵀ of A = diag(a², b², c²): xx = a² + b²/4, xy = b²/2.
    let [xx, xy, ..] = transport.frame().covariance(0);
    println!("covariance {xx:.6} m² along x, {xy:.6} m² between x and y");
    assert!((xx - (0.0025 + 0.25 * 0.0009)).abs() < 1e-15 && (xy - 0.5 * 0.0009).abs() < 1e-15);
    Ok(())
}
