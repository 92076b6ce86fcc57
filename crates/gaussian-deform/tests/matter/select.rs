use super::Random;
use gaussian_deform::select::{Criteria, Region, bulk, divide, means, select};
use gaussian_deform::{Degree, Splat, SplatError, Splats, shape};
use mechanics_core::mesh::BoundingBox;
use mechanics_core::tensor::{Mat3, Vec3};

fn scene(points: &[(Vec3, f64)]) -> Splats<f64> {
    let mut splats = Splats::new(Degree::Zero);
    for &(mean, opacity) in points {
        splats.push(Splat { mean, axes: Mat3::identity(), opacity, harmonics: &[0.0; 3] });
    }
    splats
}

#[test]
fn opacity_and_boxes_select() {
    let at = |x: f64, opacity: f64| (Vec3::new(x, 0.0, 0.0), opacity);
    let splats = scene(&[at(0.0, 0.5), at(1.0, 0.01), at(2.0, 0.02), at(3.0, 1.0), at(f64::NAN, 1.0)]);
    assert_eq!(select(&splats, &Criteria::default()).unwrap(), [0, 2, 3, 4]);
    let bounds = BoundingBox { min: Vec3::new(1.0, -1.0, 0.0), max: Vec3::new(2.0, 1.0, 0.0) };
    let region = Region::Box(bounds);
    assert_eq!(select(&splats, &Criteria { region, opacity: 0.0 }).unwrap(), [1, 2]);
    let error = select(&splats, &Criteria { region, opacity: 0.5 }).unwrap_err();
    assert_eq!(error, SplatError::EmptySelection { count: 2, opacity: 0.5, most: 0.02 });
    let nothing = select(&scene(&[]), &Criteria::default()).unwrap_err();
    assert!(matches!(nothing, SplatError::EmptySelection { count: 0, .. }));
}

/// The complaint says where the scene is instead.
#[test]
fn regions_beside_the_scene_are_refused() {
    let splats = scene(&[(Vec3::new(1.0, -2.0, 3.0), 0.5), (Vec3::new(-1.0, 5.0, 3.5), 0.5)]);
    let far = BoundingBox { min: Vec3::repeat(10.0), max: Vec3::repeat(11.0) };
    let inside_out = BoundingBox { min: Vec3::repeat(9.0), max: Vec3::repeat(-9.0) };
    let undefined = BoundingBox { min: Vec3::repeat(f64::NAN), max: Vec3::repeat(9.0) };
    for bounds in [far, inside_out, undefined] {
        let error = select(&splats, &Criteria { region: Region::Box(bounds), opacity: 0.0 }).unwrap_err();
        let (low, high) = ([-1.0, -2.0, 3.0], [1.0, 5.0, 3.5]);
        assert_eq!(error, SplatError::RegionOutside { count: 2, low, high });
        assert!(error.to_string().contains("between [-1.000, -2.000, 3.000] and"), "{error}");
    }
    let slanted = |rotation| {
        let region = Region::OrientedBox { centre: Vec3::zeros(), half_sides: Vec3::repeat(9.0), rotation };
        select(&splats, &Criteria { region, opacity: 0.0 })
    };
    assert_eq!(slanted(Mat3::identity()), Ok(vec![0, 1]));
    for rotation in [Mat3::identity() * 1.1, -Mat3::identity(), Mat3::repeat(f64::NAN)] {
        assert!(matches!(slanted(rotation), Err(SplatError::BadSimilarity { .. })));
    }
}

#[test]
fn oriented_boxes_are_boxes_in_turned_coordinates() {
    let mut random = Random(1);
    let rotation = shape::axes([1.0; 3], [0.3, -0.5, 0.2, 0.7]).unwrap();
    let (centre, half_sides) = (Vec3::new(0.1, 0.2, -0.1), Vec3::new(0.5, 0.3, 0.2));
    let oriented = Region::OrientedBox { centre, half_sides, rotation };
    let upright = Region::Box(BoundingBox { min: -half_sides, max: half_sides });
    let mut inside = 0;
    for _ in 0..2_000 {
        let local = random.vector();
        assert_eq!(oriented.contains(&(rotation * local + centre)), upright.contains(&local));
        inside += usize::from(upright.contains(&local));
    }
    assert!(inside > 20);
}

#[test]
fn floaters_do_not_move_the_bulk() {
    let mut random = Random(2);
    let mut points: Vec<(Vec3, f64)> = (0..5_000).map(|_| (random.vector(), 0.9)).collect();
    let clean = bulk(&scene(&points), 0.1, 0.01).unwrap();
    for k in 0..20 {
        points.push((Vec3::repeat(1e6 * f64::from(k - 7)), 0.9));
        points.push((random.vector() * 1e3, 0.05));
    }
    let dirty = bulk(&scene(&points), 0.1, 0.01).unwrap();
    // The cube from −1 to 1, 1 % off at each end, a tenth of 1.96 on.
    for bounds in [clean, dirty] {
        assert!((bounds.max - Vec3::repeat(1.176)).amax() < 0.03, "{bounds:?}");
        assert!((bounds.min + Vec3::repeat(1.176)).amax() < 0.03, "{bounds:?}");
    }
}

#[test]
fn regions_divide_a_selection_into_materials() {
    let mut random = Random(3);
    let points: Vec<(Vec3, f64)> = (0..500).map(|_| (random.vector(), 1.0)).collect();
    let splats = scene(&points);
    let half = |axis: usize| {
        let mut min = Vec3::repeat(-1.0);
        min[axis] = 0.0;
        Region::Box(BoundingBox { min, max: Vec3::repeat(1.0) })
    };
    let selection: Vec<u32> = (0..500).step_by(2).collect();
    let sets = divide(&splats, &selection, &[half(0), half(1)]);
    assert_eq!(sets.len(), 3);
    let belongs = |x: &Vec3| if x.x >= 0.0 { 0 } else { usize::from(x.y < 0.0) + 1 };
    for (k, set) in sets.iter().enumerate() {
        assert!(!set.is_empty() && set.is_sorted());
        assert!(means(&splats, set).iter().all(|x| belongs(x) == k));
    }
    assert_eq!(sets.concat().len(), selection.len());
}
