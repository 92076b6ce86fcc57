//! The energy, its derivatives and its forces at fixed positions.

use crate::Random;
use crate::scene::{cube, join};
use ipc_contact::ContactError;
use ipc_contact::ccd::Detection;
use ipc_contact::collision_mesh::{CollisionMesh, CollisionMeshBuilder, CollisionObject, HalfSpace};
use ipc_contact::contact::{BarrierContact, BarrierForm, ContactOptions};
use ipc_contact::contact_set::Weighting;
use ipc_contact::intersection::check;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::element::Attachments;
use mechanics_core::derivatives::{check_gradient, check_hessian};
use mechanics_core::parallel;
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::tensor::Vec3;

const FORMS: [BarrierForm; 3] = [BarrierForm::SquaredDistance, BarrierForm::Distance, BarrierForm::Physical];

fn options(activation_distance: f64) -> ContactOptions {
    ContactOptions::new(activation_distance, Stiffness::fixed(Scale::Load(2.0)))
}

/// A turned cube on another, above a floor, a net segment across its top, and loose points beside: every kind of pair.
fn heap() -> (CollisionMesh, Vec<Vec3>) {
    let lower = cube(2, Vec3::new(0.0, 0.0, 0.004));
    let mut upper = cube(2, Vec3::new(0.031, 0.017, 0.11));
    upper.rotate(&nalgebra::Rotation3::from_axis_angle(&Vec3::z_axis(), 0.3)).unwrap();
    let mut all = lower.clone();
    let second = all.append(&upper).unwrap();
    let mut rest = all.points().to_vec();
    let loose = rest.len() as u32;
    rest.extend([
        Vec3::new(-0.05, 0.04, 0.215),
        Vec3::new(0.15, 0.09, 0.216),
        Vec3::new(0.03, 0.13, 0.2115),
        Vec3::new(0.05, -0.05, 0.218),
        Vec3::new(0.02, 0.06, 0.221),
        Vec3::new(0.021, 0.061, 0.225),
    ]);
    let mut builder = CollisionMeshBuilder::new(&rest);
    builder.add_object(CollisionObject::of_tets(&lower, 0).unwrap());
    builder.add_object(CollisionObject::of_tets(&upper, second).unwrap());
    let net = CollisionObject {
        segments: vec![[loose, loose + 1], [loose + 2, loose + 3]],
        points: vec![loose + 4, loose + 5],
        ..Default::default()
    };
    builder.add_object(net.with_thickness(1e-3));
    builder.add_half_space(HalfSpace::through(&Vec3::zeros(), &Vec3::new(0.01, 0.0, 1.0)));
    let mesh = builder.build().unwrap();
    let mut random = Random(7);
    let x = rest.iter().map(|x| x + random.vector() * 5e-4).collect();
    (mesh, x)
}

#[test]
fn derivatives_of_the_whole_energy_agree_with_finite_differences() {
    let (mesh, x) = heap();
    let cases = [
        (BarrierForm::SquaredDistance, 0.0, Weighting::Unit),
        (BarrierForm::Distance, 2e-4, Weighting::Area),
        (BarrierForm::Physical, 0.0, Weighting::Area),
    ];
    for (form, minimum_separation, weighting) in cases {
        let options = ContactOptions { form, minimum_separation, weighting, ..options(8e-3) };
        let mut contact = BarrierContact::new(mesh.clone(), options).unwrap();
        // Candidates are known from here on, so that not every difference searches for its own.
        assert_eq!(contact.limit_step(&x, &vec![Vec3::zeros(); x.len()]).unwrap().fraction, 1.0);
        let counts = contact.contact_counts(&x);
        assert!(counts.half_spaces > 0 && counts.point_triangles > 0 && counts.edge_edges > 0, "{counts:?}");
        assert!(counts.point_edges > 0 && counts.point_points > 0, "{counts:?}");
        check_derivatives(&contact, &x);
    }
}

/// The gradient against the energy and the Hessian against the gradient, in unknowns u with x = x₀ + 1e-4 u: no difference reaches
/// as far as contact, where energies are infinite.
fn check_derivatives(contact: &BarrierContact, x: &[Vec3]) {
    const UNIT: f64 = 1e-4;
    let at = |u: &[f64]| -> Vec<Vec3> {
        x.iter().zip(u.as_chunks::<3>().0).map(|(x, u)| x + Vec3::from(*u) * UNIT).collect()
    };
    let gradient = |u: &[f64], g: &mut [f64]| {
        let mut gradient = vec![Vec3::zeros(); x.len()];
        contact.add_gradient(&at(u), &mut gradient);
        g.iter_mut().zip(gradient.iter().flatten()).for_each(|(g, entry)| *g = entry * UNIT);
    };
    let zero = vec![0.0; 3 * x.len()];
    check_gradient(&zero, |u| contact.value(&at(u)), gradient).require(1e-7).unwrap();

    let map = PointMap::identity(x.len());
    let mut assembly = Assembly::new(&map);
    let mut assembler = assembly.begin(&map);
    contact.add_hessian(x, Projection::None, &mut assembler);
    let matrix = assembler.finish();
    let entry = |row: usize, column: usize| {
        let (i, j) = (row / 3, column / 3);
        let block = |i: usize, j: usize| matrix.pattern().slot(i, j).map(|slot| &matrix.blocks()[slot]);
        let entry = if i >= j {
            block(i, j).map_or(0.0, |b| b[(row % 3, column % 3)])
        } else {
            block(j, i).map_or(0.0, |b| b[(column % 3, row % 3)])
        };
        entry * UNIT * UNIT
    };
    check_hessian(&zero, gradient, entry).require(1e-7).unwrap();
}

#[test]
fn internal_forces_have_no_resultant_and_no_torque() {
    let (lower, upper) = (cube(3, Vec3::zeros()), cube(3, Vec3::new(0.02, 0.03, 0.103)));
    let (all, mesh) = join(&[lower, upper], None);
    for form in FORMS {
        let contact = BarrierContact::new(mesh.clone(), ContactOptions { form, ..options(6e-3) }).unwrap();
        let x = all.points();
        let forces = contact.forces(x);
        let size: f64 = forces.iter().map(Vec3::norm).sum();
        let resultant: Vec3 = forces.iter().sum();
        let torque: Vec3 = x.iter().zip(&forces).map(|(x, f)| x.cross(f)).sum();
        assert!(size > 1.0);
        assert!(resultant.norm() < 1e-14 * size, "{resultant}");
        assert!(torque.norm() < 1e-14 * size * 0.2, "{torque}");
    }
}

#[test]
fn normal_forces_add_up_to_the_forces() {
    let (mesh, x) = heap();
    let contact = BarrierContact::new(mesh, options(8e-3)).unwrap();
    let mut sum = vec![Vec3::zeros(); x.len()];
    let normal_forces = contact.normal_forces(&x);
    for normal_force in &normal_forces {
        let moment: Vec3 =
            normal_force.points().iter().zip(normal_force.weights()).map(|(&p, w)| x[p as usize] * *w).sum();
        if normal_force.points().len() > 1 {
            assert!((moment - normal_force.normal * normal_force.distance).norm() < 1e-15);
        }
        normal_force.forces().for_each(|(point, force)| sum[point as usize] += force);
    }
    // No edges of the heap are nearly parallel, so that no mollifier acts.
    let forces = contact.forces(&x);
    let size: f64 = forces.iter().map(Vec3::norm).sum();
    for (sum, force) in sum.iter().zip(&forces) {
        assert!((sum - force).norm() < 1e-13 * size, "{sum} {force}");
    }
    assert!(
        normal_forces.iter().all(|force| force.magnitude > 0.0 && (force.normal.norm() - 1.0).abs() < 1e-15)
    );
}

/// Everything that the minimiser asks for.
fn bits(contact: &BarrierContact, x: &[Vec3]) -> Vec<u64> {
    let map = PointMap::identity(x.len());
    let mut gradient = vec![Vec3::zeros(); x.len()];
    contact.add_gradient(x, &mut gradient);
    let mut assembly = Assembly::new(&map);
    let mut assembler = assembly.begin(&map);
    contact.add_hessian(x, Projection::Clamp, &mut assembler);
    let matrix = assembler.finish();
    let numbers = gradient.iter().flatten().chain(matrix.blocks().iter().flatten()).copied();
    numbers.chain([contact.value(x)]).map(f64::to_bits).collect()
}

#[test]
fn energy_and_derivatives_have_the_same_bits_for_any_number_of_threads() {
    let (lower, upper) = (cube(18, Vec3::zeros()), cube(18, Vec3::new(0.001, 0.002, 0.1005)));
    let (all, mesh) = join(&[lower, upper], None);
    let x = all.points();
    let run = |threads: usize| {
        parallel::with_threads(threads, || {
            bits(&BarrierContact::new(mesh.clone(), options(5e-3)).unwrap(), x)
        })
    };
    // More than one batch of pairs.
    let counts = BarrierContact::new(mesh.clone(), options(5e-3)).unwrap().contact_counts(x);
    assert!(counts.edge_edges > 8192, "{counts:?}");
    let one = run(1);
    for threads in [2, 3, 8] {
        assert!(run(threads) == one, "{threads} threads");
    }
}

#[test]
fn what_was_asked_before_changes_no_bit() {
    let (mesh, x) = heap();
    let fresh = bits(&BarrierContact::new(mesh.clone(), options(8e-3)).unwrap(), &x);
    let mut contact = BarrierContact::new(mesh, options(8e-3)).unwrap();
    let p: Vec<Vec3> = x.iter().map(|x| Vec3::new(0.3 * x.z, 0.1, 0.5)).collect();
    let limit = contact.limit_step(&x, &p).unwrap();
    let moved: Vec<Vec3> = x.iter().zip(&p).map(|(x, p)| x + p * (0.5 * limit.fraction)).collect();
    assert!(contact.value(&moved).is_finite());
    assert!(bits(&contact, &x) == fresh);
    // The limit of a step does not depend on what was known before either.
    let short: Vec<Vec3> = p.iter().map(|p| p * 0.01).collect();
    let again = contact.limit_step(&x, &short).unwrap();
    let (mesh, _) = heap();
    let mut other = BarrierContact::new(mesh, options(8e-3)).unwrap();
    assert_eq!(other.limit_step(&x, &short).unwrap().fraction.to_bits(), again.fraction.to_bits());
}

#[test]
fn a_patch_under_even_pressure_feels_it() {
    // The bottom of a cube of 6³ cells at one gap above the floor.
    let body = cube(6, Vec3::new(0.0, 0.0, 1e-3));
    let floor = HalfSpace::through(&Vec3::zeros(), &Vec3::z());
    let (all, mesh) = join(&[body], Some(floor));
    let bottom: Vec<u32> = (0..mesh.triangles().len() as u32)
        .filter(|&t| mesh.triangles()[t as usize].iter().all(|&p| all.points()[p as usize].z == 1e-3))
        .collect();
    assert_eq!(bottom.len(), 72);
    let contact = BarrierContact::new(mesh, options(2e-3)).unwrap();
    let patch = contact.patch_force(all.points(), &bottom);
    // 49 points, each with the load that is carried at half of the activation distance.
    let whole: Vec3 = contact.forces(all.points()).iter().sum();
    assert!((whole.z - 49.0 * 2.0).abs() < 1e-10, "{whole}");
    assert!((patch.area_vector - Vec3::new(0.0, 0.0, -0.01)).norm() < 1e-15);
    assert!(
        patch.force.z < whole.z && patch.force.z > 0.7 * whole.z,
        "the rim's points share with the sides"
    );
    assert!((patch.pressure - patch.force.z / 0.01).abs() < 1e-9);
}

#[test]
fn either_way_of_detection_limits_a_step_and_leaves_room() {
    let (mesh, x) = heap();
    let p: Vec<Vec3> = x.iter().map(|x| Vec3::new(0.1 - x.y, x.z, -2.0 * x.z)).collect();
    let limits = [Detection::Additive, Detection::Interval].map(|detection| {
        let options = ContactOptions { detection, ..options(8e-3) };
        let mut contact = BarrierContact::new(mesh.clone(), options).unwrap();
        let limit = contact.limit_step(&x, &p).unwrap();
        let end: Vec<Vec3> = x.iter().zip(&p).map(|(x, p)| x + p * limit.fraction).collect();
        assert!(contact.value(&end).is_finite() && check(&mesh, &end).unwrap().is_empty());
        assert!(contact.report().limiting_pair.is_some());
        limit.fraction
    });
    // Both stop where the gap is between a half and all of what is kept, a tenth.
    assert!(limits[0] < 1.0 && (limits[1] / limits[0] - 1.0).abs() < 0.1, "{limits:?}");
}

#[test]
fn balance_finds_the_stiffness_that_carries_the_load() {
    let (mesh, x) = heap();
    let mut contact = BarrierContact::new(mesh, options(8e-3)).unwrap();
    let before = contact.stiffness();
    // A load that contact carries exactly if it is three times as stiff.
    let load: Vec<Vec3> = contact.forces(&x).iter().map(|f| f * 3.0).collect();
    let stiffness = contact.balance(&x, &load).unwrap();
    assert!((stiffness / before / 3.0 - 1.0).abs() < 1e-14, "{stiffness} {before}");
    assert_eq!(contact.stiffness(), stiffness);
    // A load that pulls apart, and positions without contact, say nothing of κ.
    let pull: Vec<Vec3> = load.iter().map(|f| -f).collect();
    assert_eq!(contact.balance(&x, &pull), None);
    let apart: Vec<Vec3> = x.iter().map(|x| x * 100.0 + Vec3::new(0.0, 0.0, 10.0)).collect();
    assert_eq!(contact.balance(&apart, &load), None);
    assert_eq!(contact.stiffness(), stiffness);
}

#[test]
fn a_matched_barrier_is_as_stiff_as_what_it_holds() {
    // Points on springs of 700 N/m, one of them at half of the activation distance above the floor.
    let x = [Vec3::new(0.0, 0.0, 5e-4), Vec3::new(1.0, 0.0, 1.0)];
    let mut builder = CollisionMeshBuilder::new(&x);
    builder.add_object(CollisionObject { points: vec![0, 1], ..Default::default() }.with_thickness(1e-3));
    builder.add_half_space(HalfSpace::through(&Vec3::zeros(), &Vec3::z()));
    let mesh = builder.build().unwrap();
    let springs = Attachments::term("springs", 700.0, &[0, 1], x.to_vec()).unwrap();
    for form in FORMS {
        let mut contact =
            BarrierContact::new(mesh.clone(), ContactOptions { form, ..options(1e-3) }).unwrap();
        contact.match_stiffness(&x, &[&springs]).unwrap();
        let map = PointMap::identity(2);
        let mut assembly = Assembly::new(&map);
        let mut assembler = assembly.begin(&map);
        contact.add_hessian(&x, Projection::None, &mut assembler);
        let stiffness = assembler.finish().diagonal(0)[(2, 2)];
        assert!((stiffness / 700.0 - 1.0).abs() < 1e-12, "{form:?}: {stiffness}");
    }
}

#[test]
fn options_out_of_range_are_refused_by_name() {
    let (_, mesh) = join(&[cube(2, Vec3::zeros())], None);
    let refused = |options: ContactOptions| BarrierContact::new(mesh.clone(), options).err();
    for wrong in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(options(wrong)), Some(ContactError::ActivationDistance { .. })), "{wrong}");
        let scale = Stiffness::fixed(Scale::Kappa(wrong));
        assert!(matches!(refused(ContactOptions::new(1e-3, scale)), Some(ContactError::Stiffness { .. })));
        let wrong = ContactOptions { kept_gap: wrong, ..options(1e-3) };
        assert!(matches!(refused(wrong), Some(ContactError::KeptGap { .. })));
    }
    for wrong in [-1e-3, f64::NAN] {
        let wrong = ContactOptions { minimum_separation: wrong, ..options(1e-3) };
        assert!(matches!(refused(wrong), Some(ContactError::MinimumSeparation { .. })));
    }
    // Edges of the cube are 5 cm long.
    assert!(refused(options(0.049)).is_none());
    let message = refused(options(0.051)).unwrap().to_string();
    assert!(
        message.contains("0.051 m") && message.contains("edge") && message.contains("0.05 m"),
        "{message}"
    );
}
