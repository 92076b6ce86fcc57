use super::Random;
use gaussian_deform::elongation::{MOST_PIECES, elongation, limit_elongation, split_elongated};
use gaussian_deform::{Degree, Splat, Splats, shape};
use mechanics_core::tensor::{Mat3, Vec3};

fn needle(length: f64) -> Splats<f64> {
    let rotation: Mat3 = shape::axes([1.0; 3], [0.3, -0.5, 0.2, 0.7]).unwrap();
    let mixed: Mat3 = shape::axes([1.0; 3], [0.1, 0.5, -0.2, 0.3]).unwrap();
    let mut splats = Splats::new(Degree::Zero);
    let axes = rotation * Mat3::from_diagonal(&Vec3::new(1.0, length, 0.1)) * mixed;
    splats.push(Splat { mean: Vec3::new(1.0, 2.0, 3.0), axes, opacity: 0.6, harmonics: &[1.0, 2.0, 3.0] });
    splats
}

/// Σ α exp(−½ dᵀ A⁻¹ d).
fn density(splats: &Splats<f64>, x: &Vec3) -> f64 {
    (0..splats.count())
        .map(|i| {
            let d = splats.axes()[i].lu().solve(&(x - splats.means()[i])).unwrap();
            splats.opacities()[i] * (-0.5 * d.norm_squared()).exp()
        })
        .sum()
}

#[test]
fn pieces_add_up_to_the_whole() {
    let mut random = Random(13);
    for length in [2.1, 3.0, 10.0, 40.0, 1e4] {
        let whole = needle(length);
        let mut pieces = whole.clone();
        assert_eq!(split_elongated(&mut pieces, 2.0), 1);
        assert!((3..=MOST_PIECES).contains(&pieces.count()), "{}", pieces.count());
        pieces.check().unwrap();
        for _ in 0..200 {
            let x = whole.means()[0] + whole.axes()[0] * (random.vector() * 3.0);
            let (a, b) = (density(&pieces, &x), density(&whole, &x));
            assert!((a - b).abs() < 1e-3, "{length}: {a} {b}");
        }
        if length < 20.0 {
            assert!(pieces.axes().iter().all(|b| elongation(b) <= 2.0 + 1e-12));
        }
        assert!((0..pieces.count()).all(|i| pieces.harmonics_of(i) == whole.harmonics_of(0)));
        assert_eq!(pieces.means()[0], whole.means()[0]);
    }
}

/// Pieces show the colours of the whole, also where those are turned.
#[test]
fn pieces_keep_the_orientation_of_the_whole() {
    let mut splats = needle(10.0);
    splats.push(Splat { axes: Mat3::identity(), ..needle(1.0).splat(0) });
    let turns: Vec<Mat3> = [[0.3, -0.5, 0.2, 0.7], [0.1, 0.5, -0.2, 0.3]]
        .into_iter()
        .map(|quaternion| shape::axes([1.0; 3], quaternion).unwrap())
        .collect();
    splats.set_orientations(Some(turns.clone()));
    assert_eq!(split_elongated(&mut splats, 2.0), 1);
    let orientations = splats.orientations().unwrap();
    assert!(splats.count() > 4 && orientations.len() == splats.count());
    assert!(orientations.iter().enumerate().all(|(i, r)| *r == turns[usize::from(i == 1)]));
}

#[test]
fn what_is_short_enough_stays() {
    let mut disc = Splats::<f32>::new(Degree::Zero);
    let axes = Mat3::from_diagonal(&Vec3::new(1.0, 0.6, 1e-6)).cast::<f32>();
    disc.push(Splat { mean: Default::default(), axes, opacity: 1.0, harmonics: &[0.0; 3] });
    let before = disc.clone();
    assert_eq!((limit_elongation(&mut disc, 2.0), split_elongated(&mut disc, 2.0)), (0, 0));
    assert_eq!(disc, before);
}

#[test]
fn limits_shorten_only_the_longest() {
    let mut splats = needle(7.0);
    assert_eq!(limit_elongation(&mut splats, 3.0), 1);
    let mut sigma: [f64; 3] = splats.axes()[0].singular_values().into();
    sigma.sort_by(f64::total_cmp);
    assert!((0..3).all(|k| (sigma[k] - [0.1, 1.0, 3.0][k]).abs() < 1e-14), "{sigma:?}");
    // Points, needles without width.
    for axes in [Mat3::zeros(), Mat3::from_diagonal(&Vec3::new(1.0, 0.0, 0.0))] {
        splats.axes_mut()[0] = axes;
        split_elongated(&mut splats, 2.0);
        limit_elongation(&mut splats, 2.0);
        splats.check().unwrap();
    }
}
