//! Position-based dynamics: classic and compliant.

#![cfg(feature = "bodies")]
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use lagrangian::element::hinge::dihedral_angle;
use lagrangian::position_based::{
    Bends, ConstraintGroup, ConstraintKind, Constraints, Distances, Ground, Particles, PositionBased,
    PositionConstraint, PositionError, Response, Volumes,
};
use mechanics_core::mesh::{BoxSplit, Diagonals, TetMesh, TriMesh, block, sheet, tet_volume};
use mechanics_core::tensor::Vec3;
use std::sync::atomic::{AtomicU64, Ordering};

const REST: Vec3 = Vec3::new(0.0, 0.0, 0.0);

fn springs(points: &[Vec3], edges: &[[u32; 2]], response: Response) -> ConstraintGroup<Distances, 2> {
    let distances = Distances::new(points, edges).unwrap();
    ConstraintGroup::new("springs", distances, edges.to_vec(), response).unwrap()
}

fn compliant(compliance: f64, count: usize) -> Response {
    Response::Compliant { compliance: vec![compliance; count] }
}

/// SplitMix64 (Steele, Lea, Flood 2014), in [−1, 1).
struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }
}

/// x_{n+1} = (x_n + h v_n)/(1 + h² k/m): implicit Euler on a linear spring, over many steps, with a held end far away so that
/// the spring does not change sides.
#[test]
fn one_iteration_on_one_spring_is_implicit_euler() {
    for (k, m, h) in [(3.0, 0.7, 0.1), (1e6, 0.01, 0.05), (1e-3, 5.0, 1.0)] {
        let rest = vec![REST, Vec3::x() * 100.0];
        let mut group = springs(&rest, &[[0, 1]], compliant(1.0 / k, 1));
        let mut particles = Particles::new(rest, vec![0.0, 1.0 / m]).unwrap();
        particles.positions[1].x += 1.0;
        let method = PositionBased { iterations: 1, acceleration: Vec3::zeros() };
        let (mut u, mut v) = (1.0, 0.0);
        for _ in 0..50 {
            let report = method.step(&mut particles, &mut [&mut group], h).unwrap();
            let next = (u + h * v) / (1.0 + h * h * k / m);
            (u, v) = (next, (next - u) / h);
            let found = particles.positions[1].x - 100.0;
            let energy = 0.5 * k * found * found;
            let reported = report.groups[0].energy;
            assert!((reported - energy).abs() < 1e-10 * (energy + k), "{reported} J of {energy}");
            assert!((found - u).abs() < 1e-11, "k = {k}: {found} {u}");
        }
    }
}

/// In space, with two free ends: the equations of implicit Euler hold to rounding.
#[test]
fn one_iteration_solves_implicit_euler_for_a_spring_in_space() {
    let mut random = Random(1);
    for _ in 0..50 {
        let rest = vec![random.vector(), random.vector() + Vec3::x() * 3.0];
        let (k, h) = (10.0_f64.powf(4.0 * random.number()), 10.0_f64.powf(2.0 * random.number()));
        let masses = [1.5 + random.number(), 1.5 + random.number()];
        let mut group = springs(&rest, &[[0, 1]], compliant(1.0 / k, 1));
        let length = (rest[1] - rest[0]).norm();
        let mut particles = Particles::new(rest, masses.map(|m| 1.0 / m).to_vec()).unwrap();
        particles.velocities = vec![random.vector() * (0.3 / h), random.vector() * (0.3 / h)];
        let before = particles.clone();
        let gravity = random.vector() * (0.1 / (h * h));
        PositionBased { iterations: 1, acceleration: gravity }
            .step(&mut particles, &mut [&mut group], h)
            .unwrap();
        let edge = particles.positions[1] - particles.positions[0];
        let force = edge.normalize() * (k * (edge.norm() - length));
        for (i, force) in [force, -force].into_iter().enumerate() {
            let inertia = (particles.velocities[i] - before.velocities[i]) * (masses[i] / h);
            let weight = gravity * masses[i];
            let size = inertia.norm() + force.norm() + weight.norm();
            assert!((inertia - force - weight).norm() < 1e-12 * size + 1e-12 * k);
        }
    }
}

/// A straight chain, where gradients do not turn: implicit Euler by a tridiagonal solve.
fn chain_implicit_euler(n: usize, k: f64, h: f64, u: &mut [f64], v: &mut [f64]) {
    // Unit masses; u are displacements of particles 1..=n, particle 0 held, the last end free.
    let (diagonal, off) = (|i: usize| 1.0 + h * h * k * if i + 1 == n { 1.0 } else { 2.0 }, -h * h * k);
    let right: Vec<f64> = (0..n).map(|i| u[i] + h * v[i]).collect();
    let (mut c, mut d) = (vec![0.0; n], vec![0.0; n]);
    for i in 0..n {
        let below = if i > 0 { off } else { 0.0 };
        let (c_last, d_last) = if i > 0 { (c[i - 1], d[i - 1]) } else { (0.0, 0.0) };
        let pivot = diagonal(i) - below * c_last;
        (c[i], d[i]) = (off / pivot, (right[i] - below * d_last) / pivot);
    }
    let mut next = 0.0;
    for i in (0..n).rev() {
        next = d[i] - if i + 1 < n { c[i] * next } else { 0.0 };
        (u[i], v[i]) = (next, (next - u[i]) / h);
    }
}

#[test]
fn a_straight_chain_converges_to_implicit_euler_with_iterations() {
    let (n, k, h) = (8, 200.0, 0.1);
    let rest: Vec<Vec3> = (0..=n).map(|i| Vec3::x() * i as f64).collect();
    let edges: Vec<[u32; 2]> = (0..n as u32).map(|i| [i, i + 1]).collect();
    let after = |iterations: u32| {
        let mut group = springs(&rest, &edges, compliant(1.0 / k, n));
        let mut w = vec![1.0; n + 1];
        w[0] = 0.0;
        let mut particles = Particles::new(rest.clone(), w).unwrap();
        particles.velocities[n].x = 0.5;
        let (mut u, mut v) = (vec![0.0; n], vec![0.0; n]);
        v[n - 1] = 0.5;
        let method = PositionBased { iterations, acceleration: Vec3::zeros() };
        let mut residual = 0.0;
        for _ in 0..5 {
            residual = method.step(&mut particles, &mut [&mut group], h).unwrap().groups[0].residual;
            chain_implicit_euler(n, k, h, &mut u, &mut v);
        }
        let error =
            (0..n).map(|i| (particles.positions[i + 1].x - i as f64 - 1.0 - u[i]).abs()).fold(0.0, f64::max);
        [error, residual]
    };
    let results: Vec<[f64; 2]> = [1, 10, 40, 160, 640].into_iter().map(after).collect();
    println!("{results:?}");
    assert!(results[0][0] > 1e-2);
    assert!(results.windows(2).all(|pair| pair[1][0] < 0.6 * pair[0][0] + 1e-13));
    assert!(results[4][0] < 1e-13 && results[4][1] < 1e-13);
}

/// With turning gradients the limit of many iterations is off implicit Euler's equations by what vanishes with h.
#[test]
fn a_swinging_chain_meets_implicit_euler_as_the_step_shrinks() {
    let n = 4;
    // A zigzag, so that links turn at once.
    let rest: Vec<Vec3> = (0..=n).map(|i| Vec3::new(0.8 * i as f64, 0.0, 0.6 * (i % 2) as f64)).collect();
    let edges: Vec<[u32; 2]> = (0..n as u32).map(|i| [i, i + 1]).collect();
    let k = 50.0;
    let imbalance = |h: f64| {
        let mut group = springs(&rest, &edges, compliant(1.0 / k, n));
        let mut w = vec![1.0; n + 1];
        w[0] = 0.0;
        let mut particles = Particles::new(rest.clone(), w).unwrap();
        particles.velocities[n].z = 1.0;
        particles.velocities[n - 1].z = -1.0;
        let before = particles.clone();
        let method = PositionBased { iterations: 5000, acceleration: -Vec3::z() };
        let report = method.step(&mut particles, &mut [&mut group], h).unwrap();
        assert!(report.groups[0].residual < 1e-13);
        let mut worst = 0.0_f64;
        for i in 1..=n {
            let pull = |a: usize, b: usize| {
                let edge = particles.positions[b] - particles.positions[a];
                edge.normalize() * (k * (edge.norm() - 1.0))
            };
            let force = if i < n { pull(i, i + 1) } else { Vec3::zeros() } - pull(i - 1, i) - Vec3::z();
            worst = worst.max(((particles.velocities[i] - before.velocities[i]) / h - force).norm());
        }
        worst
    };
    let errors: Vec<f64> = [0.1, 0.05, 0.025, 0.0125].into_iter().map(imbalance).collect();
    let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    println!("{errors:?} {orders:?}");
    assert!(orders.iter().all(|&order| order > 1.8));
}

/// A single classic constraint keeps the part (1 − s)ⁿ of its violation; a compliant one does not change with n.
#[test]
fn classic_stiffness_depends_on_the_number_of_iterations_and_compliance_does_not() {
    let rest = vec![REST, Vec3::x()];
    let run = |response: Response, iterations: u32| {
        let mut group = springs(&rest, &[[0, 1]], response);
        let mut particles = Particles::new(rest.clone(), vec![1.0, 1.0]).unwrap();
        particles.positions[1].x = 1.5;
        let method = PositionBased { iterations, acceleration: Vec3::zeros() };
        method.step(&mut particles, &mut [&mut group], 0.1).unwrap();
        (particles.positions[1] - particles.positions[0]).norm() - 1.0
    };
    for iterations in [1, 2, 5, 20] {
        let left = run(Response::Classic { stiffness: 0.3 }, iterations);
        assert!((left - 0.5 * 0.7_f64.powi(iterations as i32)).abs() < 1e-15);
        let first = run(compliant(0.02, 1), 1);
        assert!((run(compliant(0.02, 1), iterations) - first).abs() < 1e-15);
    }
}

/// A stretched strip under its weight, with all its constraints: its length after many steps depends on the number of
/// iterations in the classic way, and hardly at all when compliant and converged.
#[test]
fn a_hanging_strip_is_as_long_as_its_compliance_says() {
    let n = 6;
    let rest: Vec<Vec3> = (0..=n).map(|i| Vec3::z() * -(i as f64)).collect();
    let edges: Vec<[u32; 2]> = (0..n as u32).map(|i| [i, i + 1]).collect();
    let stretch = |response: Response, iterations: u32| {
        let mut group = springs(&rest, &edges, response);
        let mut w = vec![1.0; n + 1];
        w[0] = 0.0;
        let mut particles = Particles::new(rest.clone(), w).unwrap();
        let method = PositionBased { iterations, acceleration: Vec3::z() * -1.0 };
        for _ in 0..400 {
            // Implicit Euler damps, but slowly: halve velocities to come to rest.
            method.step(&mut particles, &mut [&mut group], 0.1).unwrap();
            particles.velocities.iter_mut().for_each(|v| *v *= 0.9);
        }
        -particles.positions[n].z - n as f64
    };
    // Σ over springs of the weight below, over k = 50: N(N + 1)/2k.
    let exact = (n * (n + 1)) as f64 / 100.0;
    let found = [100, 200].map(|iterations| stretch(compliant(0.02, n), iterations));
    assert!(found.iter().all(|found| (found - exact).abs() < 1e-6), "{found:?} {exact}");
    let classic = [2, 8].map(|iterations| stretch(Response::Classic { stiffness: 0.5 }, iterations));
    println!("{found:?} {exact} {classic:?}");
    assert!(classic[0] > 2.0 * classic[1]);
}

fn net() -> (TriMesh, Particles) {
    let mesh = sheet([1.0, 1.0], [6, 6], Diagonals::Alternating).unwrap();
    let mut random = Random(5);
    let masses: Vec<f64> = mesh.points().iter().map(|_| 1.0 / (1.5 + random.number())).collect();
    let mut particles = Particles::new(mesh.points().to_vec(), masses).unwrap();
    particles.velocities.iter_mut().for_each(|v| *v = random.vector());
    (mesh, particles)
}

#[test]
fn internal_constraints_conserve_momentum_and_angular_momentum_in_the_limit() {
    let drift = |h: f64| {
        let (mesh, mut particles) = net();
        let edges = mesh.edges();
        let mut stretch = springs(mesh.points(), &edges, compliant(1e-3, edges.len()));
        let (bends, hinges) = Bends::new(&mesh).unwrap();
        let response = compliant(10.0, hinges.len());
        let mut bend = ConstraintGroup::new("bends", bends, hinges, response).unwrap();
        let (momentum, angular) = (particles.momentum(), particles.angular_momentum());
        let method = PositionBased { iterations: 10, acceleration: Vec3::zeros() };
        for _ in 0..(0.1 / h) as usize {
            method.step(&mut particles, &mut [&mut stretch, &mut bend], h).unwrap();
        }
        assert!((particles.momentum() - momentum).norm() < 1e-11);
        (particles.angular_momentum() - angular).norm()
    };
    let drifts: Vec<f64> = [0.02, 0.01, 0.005, 0.0025].into_iter().map(drift).collect();
    println!("angular momentum drifts {drifts:?}");
    assert!(drifts.windows(2).all(|pair| pair[1] < 0.75 * pair[0]));
}

#[test]
fn the_volume_constraint_keeps_volumes() {
    let mesh = block(&Vec3::zeros(), &Vec3::new(1.0, 1.0, 1.0), [1, 1, 1], BoxSplit::Six).unwrap();
    let cells = mesh.cells().to_vec();
    let volumes = Volumes::new(&mesh).unwrap();
    let mut group =
        ConstraintGroup::new("volumes", volumes, cells.clone(), Response::rigid(cells.len())).unwrap();
    let mut random = Random(3);
    let particles = mesh.points().iter().map(|_| 1.0).collect();
    let mut particles = Particles::new(mesh.points().to_vec(), particles).unwrap();
    particles.velocities.iter_mut().for_each(|v| *v = random.vector());
    let method = PositionBased { iterations: 2000, acceleration: Vec3::zeros() };
    let report = method.step(&mut particles, &mut [&mut group], 0.1).unwrap();
    let moved =
        particles.positions.iter().zip(mesh.points()).map(|(x, p)| (x - p).norm()).fold(0.0, f64::max);
    assert!(moved > 0.02, "{moved}");
    for cell in &cells {
        let volume = tet_volume(&cell.map(|i| particles.positions[i as usize]));
        assert!((volume * 6.0 - 1.0).abs() < 1e-8, "{}", volume * 6.0);
    }
    assert!(report.groups[0].residual < 1e-9);
}

#[test]
fn the_ground_pushes_and_does_not_pull() {
    let mut particles =
        Particles::new(vec![Vec3::z() * 0.5, Vec3::z() * 2.0 + Vec3::x()], vec![1.0, 1.0]).unwrap();
    for response in [Response::rigid(2), Response::Classic { stiffness: 1.0 }] {
        let ground = Ground::new(&Vec3::zeros(), &(Vec3::z() * 7.0)).unwrap();
        let mut group = ConstraintGroup::new("ground", ground, vec![[0], [1]], response).unwrap();
        let method = PositionBased { iterations: 3, acceleration: Vec3::z() * -10.0 };
        for _ in 0..200 {
            method.step(&mut particles, &mut [&mut group], 0.01).unwrap();
            assert!(particles.positions.iter().all(|x| x.z >= -1e-15));
        }
        assert!(particles.positions.iter().all(|x| x.z.abs() < 1e-15));
        particles.velocities[0].z = 3.0;
        method.step(&mut particles, &mut [&mut group], 0.01).unwrap();
        assert!((particles.positions[0].z - 0.029).abs() < 1e-12, "it does not hold back");
    }
}

#[test]
fn free_fall_is_that_of_symplectic_euler() {
    let mut particles = Particles::new(vec![Vec3::zeros()], vec![2.0]).unwrap();
    particles.velocities[0] = Vec3::new(1.0, 0.0, 3.0);
    let method = PositionBased { iterations: 1, acceleration: Vec3::z() * -10.0 };
    let h = 1.0 / 64.0;
    for _ in 0..64 {
        method.step(&mut particles, &mut [], h).unwrap();
    }
    // y = y₀ + v₀ t − g t²/2 − g h t/2
    assert!((particles.positions[0] - Vec3::new(1.0, 0.0, 3.0 - 5.0 - 5.0 * h)).norm() < 1e-13);
}

#[test]
fn bends_return_to_their_rest_angle() {
    let fold = |angle: f64| {
        let (c, s) = (angle.cos(), angle.sin());
        vec![Vec3::zeros(), Vec3::x(), Vec3::new(0.5, c, s), Vec3::new(0.5, -1.0, 0.0)]
    };
    let mesh = TriMesh::new(fold(0.8), vec![[0, 1, 2], [1, 0, 3]]).unwrap();
    let (bends, hinges) = Bends::new(&mesh).unwrap();
    let mut group = ConstraintGroup::new("bends", bends, hinges.clone(), Response::rigid(1)).unwrap();
    for start in [0.0, -1.0, 2.0, 3.0] {
        let mut particles = Particles::new(fold(start), vec![1.0; 4]).unwrap();
        let method = PositionBased { iterations: 30, acceleration: Vec3::zeros() };
        method.step(&mut particles, &mut [&mut group], 0.1).unwrap();
        let angle = dihedral_angle(&hinges[0].map(|i| particles.positions[i as usize]));
        assert!((angle - 0.8).abs() < 1e-12, "from {start}: {angle}");
    }
}

#[test]
fn the_same_input_gives_the_same_bits_and_errors_leave_the_particles_as_they_were() {
    let run = || {
        let (mesh, mut particles) = net();
        let edges = mesh.edges();
        let mut group = springs(mesh.points(), &edges, compliant(1e-4, edges.len()));
        let method = PositionBased { iterations: 7, acceleration: Vec3::z() };
        for _ in 0..10 {
            method.step(&mut particles, &mut [&mut group], 0.01).unwrap();
        }
        particles
    };
    assert_eq!(run(), run());
    let mut particles = run();
    let before = particles.clone();
    let (mesh, _) = net();
    let edges = mesh.edges();
    let mut group = springs(mesh.points(), &edges, compliant(1e-4, edges.len()));
    let good = PositionBased { iterations: 7, acceleration: Vec3::zeros() };
    for h in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = good.step(&mut particles, &mut [&mut group], h).unwrap_err();
        assert!(matches!(error, PositionError::Step { .. }), "{error}");
    }
    let none = PositionBased { iterations: 0, ..good };
    assert_eq!(none.step(&mut particles, &mut [&mut group], 0.1), Err(PositionError::NoIterations));
    let huge = PositionBased { acceleration: Vec3::x() * 1e308, ..good };
    let error = huge.step(&mut particles, &mut [&mut group], 1e10).unwrap_err();
    assert!(matches!(error, PositionError::NonFinite { .. }), "{error}");
    assert_eq!(particles, before);
    let mut few = Particles::new(vec![REST; 3], vec![1.0; 3]).unwrap();
    let error = good.step(&mut few, &mut [&mut group], 0.1).unwrap_err();
    assert!(matches!(error, PositionError::ParticleOutOfRange { particles: 3, .. }), "{error}");
    few.positions[1].y = f64::NAN;
    let error = good.step(&mut few, &mut [], 0.1).unwrap_err();
    assert!(matches!(error, PositionError::NonFinite { particle: 1, .. }), "{error}");
}

/// Multipliers begin anew with every step: positions and velocities are all that a run goes on from.
#[test]
fn runs_resumed_at_every_tenth_step_end_in_the_same_bits() {
    let (mesh, start) = net();
    let edges = mesh.edges();
    let method = PositionBased { iterations: 7, acceleration: Vec3::z() };
    let run = |mut particles: Particles, steps: usize| {
        let mut stretch = springs(mesh.points(), &edges, compliant(1e-4, edges.len()));
        let (bends, hinges) = Bends::new(&mesh).unwrap();
        let response = compliant(10.0, hinges.len());
        let mut bend = ConstraintGroup::new("bends", bends, hinges, response).unwrap();
        let mut snapshots = Vec::new();
        for step in 1..=steps {
            method.step(&mut particles, &mut [&mut stretch, &mut bend], 0.01).unwrap();
            if step % 10 == 0 {
                snapshots.push((step, particles.clone()));
            }
        }
        (particles, snapshots)
    };
    let (end, snapshots) = run(start, 50);
    for (step, snapshot) in snapshots {
        assert_eq!(run(snapshot, 50 - step).0, end, "from step {step}");
    }
}

#[test]
fn degenerate_input_is_refused_with_the_culprit_named() {
    let points = [REST, REST, Vec3::x()];
    let error = Distances::new(&points, &[[0, 2], [0, 1]]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "edge 1 (points [0, 1]) has the rest length 0e0 m; it must be positive and finite"
    );
    let flat = TetMesh::new(vec![REST, Vec3::x(), Vec3::y(), Vec3::new(0.3, 0.3, 0.0)], vec![[0, 1, 2, 3]]);
    let error = Volumes::new(&flat.unwrap()).unwrap_err();
    assert!(matches!(error, PositionError::RestVolume { element: 0, .. }), "{error}");
    assert!(matches!(Ground::new(&REST, &REST), Err(PositionError::Normal { .. })));
    assert!(matches!(
        Particles::new(vec![REST], vec![-1.0]),
        Err(PositionError::InverseMass { particle: 0, value: -1.0 })
    ));
    let distances = || Distances::new(&points, &[[0, 2]]).unwrap();
    let group =
        |elements: Vec<[u32; 2]>, response| ConstraintGroup::new("springs", distances(), elements, response);
    for stiffness in [0.0, 1.1, f64::NAN] {
        let error = group(vec![[0, 2]], Response::Classic { stiffness }).unwrap_err();
        assert!(matches!(error, PositionError::Stiffness { .. }), "{error}");
    }
    assert!(matches!(
        group(vec![[0, 2]], compliant(-1.0, 1)),
        Err(PositionError::Compliance { element: 0, .. })
    ));
    assert!(matches!(
        group(vec![[0, 2]], compliant(1.0, 2)),
        Err(PositionError::ComplianceCount { found: 2, .. })
    ));
    let twice = group(vec![[2, 2]], compliant(1.0, 1));
    assert!(matches!(twice, Err(PositionError::RepeatedParticle { particle: 2, .. })));
}

/// Coincident ends have no direction; a spring between held particles has nothing to move.
#[test]
fn constraints_without_a_gradient_are_passed_over_and_counted() {
    let rest = [REST, Vec3::x(), Vec3::x() * 2.0, Vec3::x() * 3.0];
    let mut group = springs(&rest, &[[0, 1], [2, 3]], Response::rigid(2));
    let mut particles =
        Particles::new(vec![REST, REST, Vec3::x(), Vec3::y()], vec![1.0, 1.0, 0.0, 0.0]).unwrap();
    let before = particles.positions.clone();
    let method = PositionBased { iterations: 3, acceleration: Vec3::zeros() };
    let report = method.step(&mut particles, &mut [&mut group], 0.1).unwrap();
    assert_eq!((report.projections, report.passed_over), (0, 6));
    assert_eq!(particles.positions, before);
}

/// Gradients against differences of values.
#[test]
fn gradients_are_derivatives() {
    fn check<C: PositionConstraint<N>, const N: usize>(constraint: &C, x: [Vec3; N]) {
        let flat: Vec<f64> = x.iter().flatten().copied().collect();
        let at = |q: &[f64]| -> [Vec3; N] {
            std::array::from_fn(|i| Vec3::from_column_slice(&q[3 * i..3 * i + 3]))
        };
        mechanics_core::derivatives::check_gradient(
            &flat,
            |q| constraint.evaluate(0, &at(q)).unwrap().0,
            |q, g| {
                let gradient = constraint.evaluate(0, &at(q)).unwrap().1;
                g.iter_mut().zip(gradient.iter().flatten()).for_each(|(g, entry)| *g = *entry);
            },
        )
        .require(1e-8)
        .unwrap();
    }
    let mut random = Random(8);
    for _ in 0..10 {
        let corners = [REST, Vec3::x(), Vec3::y(), Vec3::z()].map(|x| x + random.vector() * 0.2);
        let tet = TetMesh::new(corners.to_vec(), vec![[0, 1, 2, 3]]).unwrap();
        let fold = TriMesh::new(corners.to_vec(), vec![[0, 1, 2], [1, 0, 3]]).unwrap();
        let moved = corners.map(|x| x + random.vector() * 0.1);
        check(&Volumes::new(&tet).unwrap(), moved);
        check(&Bends::new(&fold).unwrap().0, moved);
        check(&Distances::new(&corners, &[[0, 1]]).unwrap(), [moved[0], moved[1]]);
        check(&Ground::new(&corners[0], &corners[1]).unwrap(), [moved[2]]);
    }
}

#[test]
fn groups_are_objects_of_one_trait() {
    let rest = [REST, Vec3::x()];
    let group = springs(&rest, &[[0, 1]], Response::rigid(1));
    let boxed: Box<dyn Constraints> = Box::new(group);
    assert_eq!(boxed.report(&rest, 1.0).residual, 0.0);
}

/// A constraint that is no number at one evaluation, or has no number for a gradient.
struct Lying {
    truth: Distances,
    kind: ConstraintKind,
    spoilt: fn(&mut f64, &mut [Vec3; 2]),
    after: u64,
    asked: AtomicU64,
}

impl PositionConstraint<2> for Lying {
    fn evaluate(&self, element: usize, x: &[Vec3; 2]) -> Option<(f64, [Vec3; 2])> {
        let (mut value, mut gradient) = self.truth.evaluate(element, x)?;
        if self.asked.fetch_add(1, Ordering::Relaxed) == self.after {
            (self.spoilt)(&mut value, &mut gradient);
        }
        Some((value, gradient))
    }

    fn kind(&self) -> ConstraintKind {
        self.kind
    }
}

/// Found by fault injection: a gradient that is no number was passed over as if there were none, and a one-sided constraint took a value that is no number for one that
/// does not act. Neither was an error.
#[test]
fn constraints_that_are_no_number_at_any_evaluation_fail_the_step() {
    let rest = [REST, Vec3::x(), Vec3::x() * 2.0];
    let edges = [[0, 1], [1, 2]];
    let method = PositionBased { iterations: 3, acceleration: Vec3::z() };
    let spoil: [fn(&mut f64, &mut [Vec3; 2]); 5] = [
        |value, _| *value = f64::NAN,
        |_, gradient| gradient[1].y = f64::NAN,
        |_, gradient| gradient[0].x = f64::INFINITY,
        |_, gradient| gradient.fill(Vec3::repeat(f64::NEG_INFINITY)),
        |value, _| *value = f64::NEG_INFINITY,
    ];
    let responses = [compliant(1e-4, 2), Response::rigid(2), Response::Classic { stiffness: 0.5 }];
    let kinds = [ConstraintKind::Equality, ConstraintKind::AtLeastZero];
    for (kind, response) in kinds.into_iter().flat_map(|kind| responses.clone().map(|r| (kind, r))) {
        for spoilt in spoil {
            for after in 0..6 {
                let truth = Distances::new(&rest, &edges).unwrap();
                let lying = Lying { truth, kind, spoilt, after, asked: AtomicU64::new(0) };
                let mut group =
                    ConstraintGroup::new("lying", lying, edges.to_vec(), response.clone()).unwrap();
                let mut particles = Particles::new(rest.to_vec(), vec![1.0; 3]).unwrap();
                particles.positions[2].x = 1.7;
                let before = particles.clone();
                let error = method.step(&mut particles, &mut [&mut group], 0.01).unwrap_err();
                assert!(matches!(error, PositionError::NonFinite { .. }), "{error}");
                assert_eq!(particles, before, "{kind:?}, evaluation {after}");
                // The same group is true from now on.
                method.step(&mut particles, &mut [&mut group], 0.01).unwrap();
            }
        }
    }
}
