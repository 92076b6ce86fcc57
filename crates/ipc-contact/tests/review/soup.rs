//! Sheets, chains and clouds of points, pushed about at random.

use crate::random::Random;
use crate::{along, begin_step, freeze};
use ipc_contact::ccd::{self, Detection, Impact, Settings};
use ipc_contact::collision_mesh::{CollisionMesh, CollisionMeshBuilder, CollisionObject, HalfSpace};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::contact_set::Weighting;
use ipc_contact::intersection::check;
use ipc_contact::stiffness::{Scale, Stiffness};
use mechanics_core::parallel::with_threads;
use mechanics_core::potential::Potential;
use mechanics_core::stage::Moment;
use mechanics_core::tensor::Vec3;

const SOUPS: u64 = 40;

/// Twelve objects in cells of half a metre, and a floor below them.
fn soup(random: &mut Random) -> CollisionMesh {
    let (mut rest, mut objects): (Vec<Vec3>, Vec<CollisionObject>) = Default::default();
    for cell in 0..12_u32 {
        let corner = Vec3::new(f64::from(cell % 3), f64::from(cell / 3 % 2), f64::from(cell / 6)) * 0.5;
        let first = rest.len() as u32;
        let object = match random.integer(0, 3) {
            0 | 1 => {
                for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                    let height = 0.1 + 0.25 * random.unit();
                    rest.push(corner + Vec3::new(0.15 * f64::from(i), 0.15 * f64::from(j), height));
                }
                let quads = [0, 1, 3, 4].map(|q| q + first);
                let split = |q: u32| [[q, q + 1, q + 4], [q, q + 4, q + 3]];
                CollisionObject::new(quads.into_iter().flat_map(split).collect())
            }
            2 => {
                for i in 0..6 {
                    rest.push(corner + Vec3::new(0.07 * f64::from(i), 0.3 * random.unit(), 0.3 * random.unit()));
                }
                let segments = (first..first + 5).map(|p| [p, p + 1]).collect();
                CollisionObject { segments, ..Default::default() }.with_thickness(0.01)
            }
            _ => {
                for i in 0..5 {
                    rest.push(corner + Vec3::new(0.08 * f64::from(i), 0.3 * random.unit(), 0.3 * random.unit()));
                }
                let points = (first..first + 5).collect();
                CollisionObject { points, ..Default::default() }.with_thickness(0.01)
            }
        };
        objects.push(object);
    }
    let mut builder = CollisionMeshBuilder::new(&rest);
    objects.into_iter().for_each(|object| {
        builder.add_object(object);
    });
    let normal = Vec3::new(0.1, -0.2, 1.0);
    builder.add_half_space(HalfSpace::through(&Vec3::new(0.0, 0.0, -0.5), &normal));
    builder.build().unwrap()
}

/// A displacement of one of several kinds.
fn displacement(random: &mut Random, mesh: &CollisionMesh, x: &[Vec3]) -> Vec<Vec3> {
    let power = |random: &mut Random, low: f64, high: f64| 10.0_f64.powf(low + (high - low) * random.unit());
    let kind = random.integer(0, 5);
    let size = power(random, -6.0, 4.0);
    let common = random.point() * power(random, -3.0, 9.0);
    let centre: Vec3 = x.iter().sum::<Vec3>() / x.len() as f64;
    let shift = random.integer(1, x.len() as i64 - 1) as usize;
    (0..x.len())
        .map(|i| match kind {
            0 => random.point() * size,
            1 => (centre - x[i]) * (0.5 + random.unit()) + random.point() * 0.05,
            2 => common + random.point() * size.min(1.0),
            3 => random.point() * power(random, -12.0, 8.0),
            4 => x[(i + shift) % x.len()] - x[i],
            _ => {
                let object = mesh.object_of(i as u32);
                let mut own = Random(u64::from(object) + (size * 1e6) as u64);
                let target = centre + own.point() * 0.3;
                (target - x[i]) * 0.5 + own.point()
            }
        })
        .collect()
}

/// Asks `query(points of the pair, number of points of the first)` about all pairs that a mesh holds.
fn all_pairs(mesh: &CollisionMesh, mut query: impl FnMut(&[u32], usize)) {
    for &p in mesh.vertices() {
        for t in mesh.triangles() {
            if mesh.features_may_touch(&[p], t) {
                query(&[p, t[0], t[1], t[2]], 1);
            }
        }
    }
    for (n, e) in mesh.edges().iter().enumerate() {
        for f in &mesh.edges()[..n] {
            if mesh.features_may_touch(e, f) {
                query(&[e[0], e[1], f[0], f[1]], 2);
            }
        }
    }
    for (n, &p) in mesh.loose_points().iter().enumerate() {
        for &e in mesh.loose_edges() {
            let e = mesh.edges()[e as usize];
            if mesh.features_may_touch(&[p], &e) {
                query(&[p, e[0], e[1]], 1);
            }
        }
        for &q in &mesh.loose_points()[..n] {
            if mesh.features_may_touch(&[p], &[q]) {
                query(&[p, q], 1);
            }
        }
    }
}

fn impact(points: &[u32], first: usize, x: &[Vec3], y: &[Vec3], d_min: f64, settings: &Settings) -> Impact {
    let at = |k: usize, x: &[Vec3]| x[points[k] as usize];
    let four = |x: &[Vec3]| [at(0, x), at(1, x), at(2, x), at(3, x)];
    match (points.len(), first) {
        (4, 1) => ccd::point_triangle(&four(x), &four(y), d_min, settings),
        (4, _) => ccd::edge_edge(&four(x), &four(y), d_min, settings),
        (3, _) => {
            let three = |x: &[Vec3]| [at(0, x), at(1, x), at(2, x)];
            ccd::point_edge(&three(x), &three(y), d_min, settings)
        }
        _ => ccd::point_point(&[at(0, x), at(1, x)], &[at(0, y), at(1, y)], d_min, settings),
    }
}

/// Every pair is free on the way from `x` to `y`.
fn assert_free(mesh: &CollisionMesh, x: &[Vec3], y: &[Vec3], options: &ContactOptions, what: &str) {
    let d_min = options.minimum_separation;
    let largest_kept_gap = 0.1 * options.activation_distance;
    let settings = Settings { kept_gap: 1e-3, largest_kept_gap, ..Settings::default() };
    let thorough = Settings { detection: Detection::Interval, max_boxes: 1_000_000, ..settings };
    all_pairs(mesh, |points, first| {
        let found = impact(points, first, x, y, d_min, &settings);
        if found != Impact::Free && impact(points, first, x, y, d_min, &thorough) != Impact::Free {
            panic!("{what}: {points:?} {found:?}");
        }
    });
}

fn bits(x: &[Vec3]) -> Vec<[u64; 3]> {
    x.iter().map(|x| [x.x.to_bits(), x.y.to_bits(), x.z.to_bits()]).collect()
}

/// Twenty random steps; the state at their end.
fn run(seed: u64, steps: u64, options: ContactOptions) {
    let mut random = Random(seed);
    let mesh = soup(&mut random);
    let mut contact = BarrierContact::new(mesh.clone(), options).unwrap();
    let mut x = mesh.rest().to_vec();
    for step in 0..steps {
        let what = format!("seed {seed}, step {step}");
        let p = displacement(&mut random, &mesh, &x);
        let fresh = || BarrierContact::new(mesh.clone(), options).unwrap();
        if step % 3 == 0 {
            begin_step(&mut contact, &x).unwrap_or_else(|e| panic!("{what}: {e}"));
        } else {
            freeze(&mut contact, &x, Moment::Iteration).unwrap_or_else(|e| panic!("{what}: {e}"));
        }
        let limit = contact.limit_step(&x, &p).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert!(limit.fraction > 0.0 && limit.fraction <= 1.0, "{what}: {limit:?}");
        // Nothing remembered has any influence, nor has the number of threads.
        let threads = 1 + (step % 3) as usize;
        let again = with_threads(threads, || fresh().limit_step(&x, &p)).unwrap();
        assert_eq!(again.fraction.to_bits(), limit.fraction.to_bits(), "{what}");
        assert_eq!(again.element, limit.element, "{what}");
        let part = if random.unit() < 0.5 { 1.0 } else { random.unit() };
        let y = along(&x, &p, limit.fraction * part);
        assert_eq!(check(&mesh, &y).unwrap(), [], "{what}");
        assert_free(&mesh, &x, &y, &options, &what);
        let value = contact.value(&y);
        assert!(value.is_finite(), "{what}: {value}");
        assert_eq!(value.to_bits(), fresh().value(&y).to_bits(), "{what}");
        let gradient = |contact: &BarrierContact| {
            let mut gradient = vec![Vec3::zeros(); y.len()];
            contact.add_gradient(&y, &mut gradient);
            bits(&gradient)
        };
        assert_eq!(gradient(&contact), with_threads(threads, || gradient(&fresh())), "{what}");
        if y.iter().all(|y| y.amax() < 1e3) {
            x = y;
        }
    }
}

fn options(d: f64) -> ContactOptions {
    ContactOptions::new(d, Stiffness::fixed(Scale::Load(1.0)))
}

#[test]
fn nothing_passes_in_a_soup() {
    for seed in 0..SOUPS {
        run(seed, 20, options([1e-2, 1e-3, 1e-5][seed as usize % 3]));
    }
}

#[test]
fn nothing_passes_in_a_soup_with_area_weights_and_thickness() {
    for seed in 1000..1000 + SOUPS {
        let weighting = Weighting::Area;
        let minimum_separation = [0.0, 1e-3][seed as usize % 2];
        run(seed, 20, ContactOptions { weighting, minimum_separation, ..options(5e-3) });
    }
}

#[test]
fn nothing_passes_in_a_soup_by_intervals() {
    for seed in 2000..2000 + SOUPS / 8 {
        run(seed, 12, ContactOptions { detection: Detection::Interval, ..options(1e-2) });
    }
}
