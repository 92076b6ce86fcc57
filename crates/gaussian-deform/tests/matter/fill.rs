use super::Random;
use gaussian_deform::SplatError;
use gaussian_deform::fill::{CellGrid, Direction, Filled, Parity, Rules, Source, fill};
use mechanics_core::mesh::{TriMesh, sphere, torus};
use mechanics_core::parallel;
use mechanics_core::tensor::{Mat3, Vec3};
use serde_json::Value;

fn numbers<T: serde::de::DeserializeOwned>(value: &Value) -> T {
    serde_json::from_value(value.clone()).unwrap()
}

/// B with B Bᵀ = A.
fn root([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> Mat3 {
    let eigen = Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).symmetric_eigen();
    eigen.eigenvectors * Mat3::from_diagonal(&eigen.eigenvalues.map(|v| v.max(0.0).sqrt()))
}

fn sorted_cells(grid: &CellGrid, cells: &[u32]) -> Vec<[usize; 3]> {
    cells.iter().map(|&c| grid.indices(c as usize)).collect()
}

#[test]
fn five_cases_of_the_published_rules() {
    let fixture: Value = serde_json::from_str(include_str!("../fixtures/filling.json")).unwrap();
    let cases = fixture["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 5);
    for (number, case) in cases.iter().enumerate() {
        let direction = |key: &str| Direction::ALL.get(case[key].as_i64().unwrap() as usize).copied();
        let rules = Rules {
            density_threshold: case["density_threshold"].as_f64().unwrap(),
            search_threshold: case["search_threshold"].as_f64().unwrap(),
            particles_per_cell: numbers(&case["max_particles_per_cell"]),
            excluded: direction("search_exclude_direction"),
            parity: direction("ray_cast_direction").map_or(Parity::Unchecked, Parity::Along),
            ..Rules::default()
        };
        let counts = [numbers::<usize>(&case["n_grid"]); 3];
        let grid = CellGrid { origin: Vec3::zeros(), cell: case["dx"].as_f64().unwrap(), counts };
        // Twelve digits are given of positions, some of which are on the border of two cells; they were computed as in the upper one.
        let unrounded = |x: f64| {
            let border = (x / grid.cell).round() * grid.cell;
            if (x - border).abs() < 1e-11 { border * (1.0 + 1e-15) } else { x }
        };
        let positions: Vec<[f64; 3]> = numbers(&case["positions"]);
        let positions: Vec<[f64; 3]> = positions.iter().map(|x| x.map(unrounded)).collect();
        let covariances: Vec<[f64; 6]> = numbers(&case["cov_upper6"]);
        let opacity = case["opacity"].as_f64().unwrap();
        let sources: Vec<Source> = positions
            .iter()
            .zip(&covariances)
            .map(|(&mean, &covariance)| Source { mean: mean.into(), axes: root(covariance), opacity })
            .collect();
        let filled = fill(&sources, &grid, &rules).unwrap();
        assert!(filled.clamped.is_empty() && filled.outside.is_empty());
        let sum: f64 = filled.density.iter().sum();
        assert!((sum / case["density_sum"].as_f64().unwrap() - 1.0).abs() < 1e-12, "case {number}: {sum}");
        for sample in numbers::<Vec<[f64; 4]>>(&case["density_samples"]) {
            let [i, j, k] = [0, 1, 2].map(|axis| sample[axis] as usize);
            let found = filled.density[(i * counts[1] + j) * counts[2] + k];
            assert!((found - sample[3]).abs() < 2e-11, "case {number}: {found} {sample:?}");
        }
        let expected: Vec<[usize; 3]> = numbers(&case["dense_cells_topped_up"]);
        assert_eq!(sorted_cells(&grid, &filled.topped_up), expected, "case {number}");
        let expected: Vec<[usize; 3]> = numbers(&case["internal_cells"]);
        assert_eq!(sorted_cells(&grid, &filled.inner), expected, "case {number}");
        assert_eq!(filled.positions.len(), numbers::<usize>(&case["new_particles"]), "case {number}");
        // The volumes given are those of the Gaussians alone, before anything is filled.
        let nothing = Rules { density_threshold: f64::INFINITY, search_threshold: f64::INFINITY, ..rules };
        let alone = fill(&sources, &grid, &nothing).unwrap();
        assert!(alone.positions.is_empty());
        for (found, expected) in
            alone.volumes.iter().zip(numbers::<Vec<f64>>(&case["particle_volume_first20"]))
        {
            assert!((found / expected - 1.0).abs() < 1e-13, "case {number}: {found} {expected}");
        }
    }
}

/// Discs on a closed surface, as many as make it dense on a grid of cells h.
fn shell(mesh: &TriMesh, h: f64) -> Vec<Source> {
    let mut random = Random(12);
    let mut sources = Vec::new();
    for (triangle, area) in mesh.areas().into_iter().enumerate() {
        let [a, b, c] = mesh.corners(triangle);
        let normal = (b - a).cross(&(c - a)).normalize();
        let first = (b - a).normalize();
        let axes =
            Mat3::from_columns(&[first * (0.7 * h), normal.cross(&first) * (0.7 * h), normal * (0.4 * h)]);
        // Three discs for the area of a side of a cell, the fraction by chance.
        let wanted = 3.0 * area / (h * h);
        let count = wanted.floor() as usize + usize::from(0.5 * (random.next() + 1.0) < wanted.fract());
        for _ in 0..count {
            let [mut u, mut v] = [0.5 * (random.next() + 1.0), 0.5 * (random.next() + 1.0)];
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            sources.push(Source { mean: a + (b - a) * u + (c - a) * v, axes, opacity: 0.9 });
        }
    }
    sources
}

/// A grid of n³ cells over the cube of side 1.2 around the origin, and its filling.
fn filled_shell(mesh: &TriMesh, n: usize, rules: &Rules) -> (CellGrid, Vec<Source>, Filled) {
    let cell = 1.2 / n as f64;
    let grid = CellGrid { origin: Vec3::repeat(-0.6), cell, counts: [n; 3] };
    let sources = shell(mesh, cell);
    let filled = fill(&sources, &grid, rules).unwrap();
    (grid, sources, filled)
}

fn centre(grid: &CellGrid, cell: u32) -> Vec3 {
    grid.origin + Vec3::from(grid.indices(cell as usize).map(|i| i as f64 + 0.5)) * grid.cell
}

/// Cells outside that were filled, cells inside that are empty, cells inside; `depth` is how far a point is below the exact surface.
fn mistakes(filling: &(CellGrid, Vec<Source>, Filled), depth: impl Fn(&Vec3) -> f64) -> [usize; 3] {
    let (grid, sources, filled) = filling;
    let h = grid.cell;
    let mut occupied: Vec<u32> =
        sources.iter().filter_map(|s| grid.cell_of(&s.mean)).map(|c| c as u32).collect();
    occupied.extend(filled.inner.iter().chain(&filled.topped_up));
    occupied.sort_unstable();
    let outside = filled.inner.iter().filter(|&&cell| depth(&centre(grid, cell)) < -0.9 * h).count();
    let deep: Vec<u32> =
        (0..grid.cells() as u32).filter(|&cell| depth(&centre(grid, cell)) > 0.9 * h).collect();
    let empty = deep.iter().filter(|cell| occupied.binary_search(cell).is_err()).count();
    [outside, empty, deep.len()]
}

/// How far the volume of all particles is from the body's, relative to it.
fn excess(filled: &Filled, volume: f64) -> f64 {
    filled.volumes.iter().sum::<f64>() / volume - 1.0
}

/// The default rules make no mistake; the published ones may where rays graze the surface.
fn assert_is_filled_where_it_is_inside(mesh: &TriMesh, depth: impl Fn(&Vec3) -> f64 + Copy) {
    let volume = mesh.enclosed_volume();
    let mut excesses = Vec::new();
    for n in [32, 64] {
        let ours = filled_shell(mesh, n, &Rules::default());
        let [outside, empty, inside] = mistakes(&ours, depth);
        assert_eq!([outside, empty], [0, 0], "{n}: of {inside}");
        let published = Rules { parity: Parity::Along(Direction::PlusZ), ..Rules::default() };
        let [outside, empty, inside] = mistakes(&filled_shell(mesh, n, &published), depth);
        assert!(10 * (outside + empty) < inside, "{n}: {outside} and {empty} of {inside}");
        excesses.push(excess(&ours.2, volume));
    }
    // Cells that the surface passes count whole: too much by about half a cell all over, of first order.
    assert!(excesses[1] > 0.0 && excesses[1] < 0.62 * excesses[0], "{excesses:?}");
}

#[test]
fn a_sphere_is_filled_where_it_is_inside() {
    assert_is_filled_where_it_is_inside(&sphere(0.4, 24).unwrap(), |x| 0.4 - x.norm());
}

#[test]
fn the_hole_of_a_torus_stays_empty() {
    let (major, minor) = (0.36, 0.16);
    let mesh = torus(major, minor, 96, 48).unwrap();
    let bounds = mesh.bounding_box().unwrap().size();
    let axis = (0..3).find(|&k| bounds[k] < 0.5).unwrap();
    assert_is_filled_where_it_is_inside(&mesh, |x| {
        let across = (x.norm_squared() - x[axis] * x[axis]).sqrt() - major;
        minor - across.hypot(x[axis])
    });
}

/// A Gaussian too wide and one too flat cost what others cost, and are named.
#[test]
fn ill_conditioned_gaussians_are_clamped_and_reported() {
    let mesh = sphere(0.4, 24).unwrap();
    let (grid, mut sources, clean) = filled_shell(&mesh, 32, &Rules::default());
    let count = sources.len() as u32;
    let mean = Vec3::new(0.4, 0.0, 0.0);
    for axes in [
        Mat3::from_diagonal(&Vec3::new(1e300, 1.0, 1e-300)),
        Mat3::zeros(),
        Mat3::from_diagonal(&Vec3::new(0.02, 0.02, 1e-30)),
    ] {
        sources.push(Source { mean, axes, opacity: 1e-9 });
    }
    sources.push(Source { mean: Vec3::repeat(1e300), axes: Mat3::identity() * 0.02, opacity: 1.0 });
    let filled = fill(&sources, &grid, &Rules::default()).unwrap();
    assert_eq!(filled.clamped, [count, count + 1, count + 2]);
    assert_eq!(filled.outside, [count + 3]);
    assert_eq!(*filled.volumes.get(count as usize + 3).unwrap(), 0.0);
    assert!(filled.density.iter().all(|x| x.is_finite()));
    assert_eq!(filled.inner, clean.inner);
    sources[3].axes[(1, 1)] = f64::NAN;
    assert!(matches!(fill(&sources, &grid, &Rules::default()), Err(SplatError::BadPoint { point: 3, .. })));
    for grid in [
        CellGrid { cell: 0.0, ..grid },
        CellGrid { cell: f64::NAN, ..grid },
        CellGrid { counts: [0, 4, 4], ..grid },
        CellGrid { counts: [usize::MAX, 2, 2], ..grid },
        CellGrid { origin: Vec3::repeat(f64::INFINITY), ..grid },
    ] {
        assert!(matches!(fill(&sources, &grid, &Rules::default()), Err(SplatError::BadGrid { .. })));
    }
}

#[test]
fn new_particles_are_in_their_cells_and_the_same_for_any_number_of_threads() {
    let mesh = torus(0.36, 0.16, 48, 24).unwrap();
    let (grid, sources, one) = parallel::with_threads(1, || filled_shell(&mesh, 40, &Rules::default()));
    for threads in [2, 3, 8] {
        let (_, _, other) = parallel::with_threads(threads, || filled_shell(&mesh, 40, &Rules::default()));
        assert_eq!(other, one);
    }
    let inner: usize = one.inner.len() * 2;
    let of = |cells: &[u32]| {
        one.positions.iter().filter(|x| cells.contains(&(grid.cell_of(x).unwrap() as u32))).count()
    };
    assert_eq!(of(&one.inner), inner);
    assert_eq!(of(&one.topped_up), one.positions.len() - inner);
    assert!(!sources.is_empty());
}
