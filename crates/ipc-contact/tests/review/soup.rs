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

const SOUPS: u64 = 16;

/// Where and how large a soup is.
#[derive(Clone, Copy)]
struct Place {
    scale: f64,
    offset: f64,
    /// Every how many points one is scripted; none for zero.
    scripted: u32,
}

const HERE: Place = Place { scale: 1.0, offset: 0.0, scripted: 0 };

/// Twelve objects in cells of half a metre, and a floor below them.
fn soup(random: &mut Random, place: Place) -> CollisionMesh {
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
                    rest.push(
                        corner + Vec3::new(0.07 * f64::from(i), 0.3 * random.unit(), 0.3 * random.unit()),
                    );
                }
                let segments = (first..first + 5).map(|p| [p, p + 1]).collect();
                CollisionObject { segments, ..Default::default() }.with_thickness(0.01)
            }
            _ => {
                for i in 0..5 {
                    rest.push(
                        corner + Vec3::new(0.08 * f64::from(i), 0.3 * random.unit(), 0.3 * random.unit()),
                    );
                }
                let points = (first..first + 5).collect();
                CollisionObject { points, ..Default::default() }.with_thickness(0.01)
            }
        };
        objects.push(object);
    }
    rest.iter_mut().for_each(|x| *x = *x * place.scale + Vec3::new(1.0, -0.7, 0.4) * place.offset);
    let mut builder = CollisionMeshBuilder::new(&rest);
    objects.into_iter().for_each(|object| {
        builder.add_object(object);
    });
    let normal = Vec3::new(0.1, -0.2, 1.0);
    let floor = Vec3::new(0.0, 0.0, -0.5) * place.scale + Vec3::new(1.0, -0.7, 0.4) * place.offset;
    builder.add_half_space(HalfSpace::through(&floor, &normal));
    builder.script_points((0..rest.len() as u32).filter(|p| place.scripted != 0 && p % place.scripted == 0));
    builder.build().unwrap()
}

/// A displacement of one of several kinds.
fn displacement(random: &mut Random, mesh: &CollisionMesh, x: &[Vec3], scale: f64) -> Vec<Vec3> {
    let power = |random: &mut Random, low: f64, high: f64| 10.0_f64.powf(low + (high - low) * random.unit());
    let kind = random.integer(0, 5);
    let size = power(random, -6.0, 4.0);
    let common = random.point() * power(random, -3.0, 9.0);
    let centre: Vec3 = x.iter().sum::<Vec3>() / x.len() as f64;
    let shift = random.integer(1, x.len() as i64 - 1) as usize;
    (0..x.len())
        .map(|i| match kind {
            0 => random.point() * size * scale,
            1 => (centre - x[i]) * (0.5 + random.unit()) + random.point() * 0.05 * scale,
            2 => (common + random.point() * size.min(1.0)) * scale,
            3 => random.point() * power(random, -12.0, 8.0) * scale,
            4 => x[(i + shift) % x.len()] - x[i],
            _ => {
                let object = mesh.object_of(i as u32);
                let mut own = Random(u64::from(object) + (size * 1e6) as u64);
                let target = centre + own.point() * 0.3 * scale;
                (target - x[i]) * 0.5 + own.point() * scale
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
    let settings = Settings { kept_gap: 1e-3 * options.kept_gap, largest_kept_gap, ..Settings::default() };
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

/// Whether the smallest gap is comparable to the rounding of positions.
fn is_squeezed(contact: &BarrierContact, x: &[Vec3]) -> bool {
    let size = x.iter().fold(0.0_f64, |size, x| size.max(x.amax()));
    let gap = contact.smallest_distance(x).unwrap() - contact.options().minimum_separation;
    gap < 256.0 * f64::EPSILON * size
}

/// The gradient along a random direction is what the energy changes by.
fn assert_gradient(contact: &BarrierContact, x: &[Vec3], random: &mut Random, what: &str) {
    let size = x.iter().fold(0.0_f64, |size, x| size.max(x.amax()));
    let Some(distance) = contact.smallest_distance(x) else { return };
    let gap = distance - contact.options().minimum_separation;
    if gap < 1e-8 * size {
        return;
    }
    let p: Vec<Vec3> = x.iter().map(|_| random.point()).collect();
    let mut gradient = vec![Vec3::zeros(); x.len()];
    contact.add_gradient(x, &mut gradient);
    let slope: f64 = gradient.iter().zip(&p).map(|(g, p)| g.dot(p)).sum();
    let largest: f64 = gradient.iter().map(|g| g.norm()).sum();
    let error = |part: f64| {
        let h = part * gap.min((contact.options().activation_distance - gap).abs());
        (contact.value(&along(x, &p, h)) - contact.value(&along(x, &p, -h))) / (2.0 * h) - slope
    };
    let errors = [1e-2, 1e-3, 1e-4].map(|part| error(part).abs() / largest);
    if largest > 0.0 && !errors.iter().any(|error| *error < 1e-3) {
        panic!(
            "{what}: gradient {slope:e} of {largest:e}, errors {errors:?}, gap {gap:e}, counts {:?}",
            contact.contact_counts(x)
        );
    }
}

/// Twenty random steps; the state at their end.
fn run(seed: u64, steps: u64, place: Place, options: ContactOptions) {
    let mut random = Random(seed);
    let mesh = soup(&mut random, place);
    let mut contact = BarrierContact::new(mesh.clone(), options).unwrap();
    let mut x = mesh.rest().to_vec();
    for step in 0..steps {
        let what = format!("seed {seed}, step {step}");
        let p = displacement(&mut random, &mesh, &x, place.scale);
        let fresh = || BarrierContact::new(mesh.clone(), options).unwrap();
        if step % 3 == 0 {
            begin_step(&mut contact, &x).unwrap_or_else(|e| panic!("{what}: {e}"));
        } else {
            freeze(&mut contact, &x, Moment::Iteration).unwrap_or_else(|e| panic!("{what}: {e}"));
        }
        let limit = match contact.limit_step(&x, &p) {
            Ok(limit) => limit,
            // Nothing holds a gap open here: in the end rounding is all that is left.
            Err(_) if is_squeezed(&contact, &x) => break,
            Err(e) => panic!("{what}: {e}"),
        };
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
        assert!(value >= 0.0, "{what}: {value}");
        assert_eq!(value.to_bits(), fresh().value(&y).to_bits(), "{what}");
        assert_gradient(&contact, &y, &mut random, &what);
        let gradient = |contact: &BarrierContact| {
            let mut gradient = vec![Vec3::zeros(); y.len()];
            contact.add_gradient(&y, &mut gradient);
            bits(&gradient)
        };
        assert_eq!(gradient(&contact), with_threads(threads, || gradient(&fresh())), "{what}");
        if y.iter().all(|y| y.amax() < 1e3 * place.scale + 2.0 * place.offset) {
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
        run(seed, 20, HERE, options([1e-2, 1e-3, 1e-5][seed as usize % 3]));
    }
}

#[test]
fn nothing_passes_in_a_soup_with_area_weights_and_thickness() {
    for seed in 1000..1000 + SOUPS {
        let weighting = Weighting::Area;
        let minimum_separation = [0.0, 1e-3][seed as usize % 2];
        run(seed, 20, HERE, ContactOptions { weighting, minimum_separation, ..options(5e-3) });
    }
}

#[test]
fn nothing_passes_in_a_soup_by_intervals() {
    for seed in 2000..2000 + SOUPS / 8 {
        run(seed, 12, HERE, ContactOptions { detection: Detection::Interval, ..options(1e-2) });
    }
}

#[test]
fn nothing_passes_in_a_soup_of_any_size_and_place() {
    for seed in 3000..3000 + SOUPS {
        let scale = [1e-9, 1e-3, 1.0, 1e6][seed as usize % 4];
        let offset = scale * [0.0, 1e3, 1e6][seed as usize % 3];
        let kept_gap = [0.1, 1e-6, 0.999, 0.5][seed as usize / 12 % 4];
        let scripted = [0, 3, 2][seed as usize / 48 % 3];
        let options = ContactOptions { kept_gap, ..options(2e-3 * scale) };
        run(seed, 12, Place { scale, offset, scripted }, options);
    }
}
