//! Sheets: nothing passes, nothing is felt through them, momentum goes into them.

use crate::solids::{KINDS, simulation, slides_as_coulomb_says};
use mechanics_core::law::Lame;
use mechanics_core::mesh::{Diagonals, TriMesh, height_field, sheet};
use mechanics_core::parallel::with_threads;
use mechanics_core::tensor::Vec3;
use mpm_constitutive::elastic::FixedCorotated;
use mpm_core::collider::Side;
use mpm_core::sampling::{Pattern, sample_shape};
use mpm_core::{
    Boundary, Collider, Kernel, MpmError, RigidMotion, Samples, Shape, SheetMesh, Simulation,
    SimulationOptions, Surface, Transfer,
};

const SPACING: f64 = 0.1;

fn flat(size: f64, cells: u32) -> TriMesh {
    let mut mesh = sheet([size; 2], [cells; 2], Diagonals::Alternating).unwrap();
    mesh.translate(&Vec3::new(-0.5 * size, -0.5 * size, 0.0)).unwrap();
    mesh
}

/// A wavy sheet without a flat place.
fn wavy(size: f64) -> TriMesh {
    let wave = |x: f64, y: f64| 0.08 * (3.0 * x).sin() * (2.0 * y + 0.5).cos();
    let mut mesh = height_field([size; 2], [14; 2], Diagonals::Crossed, wave).unwrap();
    mesh.translate(&Vec3::new(-0.5 * size, -0.5 * size, 0.0)).unwrap();
    mesh
}

fn block(centre: [f64; 3]) -> Vec<[f64; 3]> {
    let shape = Shape::Cuboid { centre, half: [0.15, 0.15, 0.1] };
    sample_shape(&shape, Pattern::per_cell(SPACING, 2), 5).unwrap().positions
}

/// On which side of a flat or wavy sheet each particle is.
fn sides(simulation: &Simulation<f64, 3>, mesh: &SheetMesh) -> Vec<bool> {
    let placement = simulation.collider_placement(0);
    let side = |x: &[f64; 3]| mesh.signed_distance(placement.point_at(&Vec3::from(*x)).into()).distance > 0.0;
    simulation.positions(0).iter().map(side).collect()
}

/// Two blocks hit a sheet from both sides at half a cell a step, the most that is stable.
#[test]
fn blocks_that_hit_a_sheet_from_both_sides_do_not_pass() {
    for (mesh, name) in [(flat(1.6, 5), "flat"), (wavy(1.6), "wavy")] {
        for (surface, transfer) in
            KINDS.into_iter().zip([Transfer::MlsApic, Transfer::FLIP, Transfer::Pic, Transfer::APIC])
        {
            let sheet = SheetMesh::new(&mesh).unwrap();
            let (above, below) = (block([0.05, 0.0, 0.25]), block([-0.1, 0.03, -0.25]));
            let speed = 5.0;
            let velocities =
                [vec![[1.0, 0.0, -speed]; above.len()], vec![[0.0, 2.0, speed]; below.len()]].concat();
            let mut simulation = simulation(transfer, &[above, below].concat(), &velocities);
            simulation.add_collider(Collider::at_rest(sheet.clone(), surface)).unwrap();
            let (before, start) = (sides(&simulation, &sheet), simulation.totals(0));
            let mut longest = 0.0_f64;
            let mut steps = 0;
            while simulation.time() < 0.15 {
                let step = simulation.stable_step();
                longest = longest.max(step * speed / SPACING);
                simulation.step(step).unwrap();
                steps += 1;
                assert_eq!(sides(&simulation, &sheet), before, "{name}, {surface:?}, step {steps}");
            }
            let (totals, load) = (simulation.totals(0), simulation.collider_load(0).total);
            let lost = start.momentum - totals.momentum - load.linear;
            println!(
                "{name}, {surface:?}: {steps} steps up to {longest:.2} cells, lost {:.1e} N s",
                lost.norm()
            );
            assert!(lost.norm() < 1e-9 * start.mass * speed, "{name}, {surface:?}: {lost}");
            assert!(longest > 0.4 && totals.kinetic_energy < start.kinetic_energy);
        }
    }
}

/// What is on one side of a flat sheet meets a half-space, for every surface and whichever way the triangles are turned.
#[test]
fn a_flat_sheet_is_a_half_space_on_either_side() {
    let positions = block([0.02, -0.01, 0.14]);
    let velocities = vec![[0.7, -0.2, -1.0]; positions.len()];
    for surface in KINDS {
        let run = |add: &dyn Fn(&mut Simulation<f64, 3>)| {
            let mut simulation = simulation(Transfer::MlsApic, &positions, &velocities);
            add(&mut simulation);
            simulation.set_gravity([0.0, 0.0, -9.81]).unwrap();
            for _ in 0..80 {
                simulation.step(1e-3).unwrap();
            }
            simulation
        };
        let plane = Shape::HalfSpace { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
        let wanted = run(&|simulation| simulation.add_boundary(Boundary::at_rest(plane, surface)).unwrap());
        let bounced = wanted.totals(0).momentum.z / wanted.totals(0).mass + 1.0 + 9.81 * 0.08;
        assert!(bounced > 0.3, "{surface:?}: nothing happened, {bounced}");
        let mut mesh = flat(3.0, 4);
        for side in ["above", "behind"] {
            let sheet = SheetMesh::new(&mesh).unwrap();
            let found = run(&|simulation| {
                simulation.add_collider(Collider::at_rest(sheet.clone(), surface)).unwrap();
            });
            let apart = found.positions(0).iter().zip(wanted.positions(0)).fold(0.0_f64, |most, (a, b)| {
                most.max((0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max))
            });
            println!("{surface:?} {side}: {apart:.1e} m apart");
            assert!(apart < 1e-12, "{surface:?} {side}: {apart}");
            mesh.flip();
        }
    }
}

/// A block on a sheet moves in the same way whether something presses from behind or not.
#[test]
fn what_is_behind_a_sheet_is_not_felt() {
    for transfer in [Transfer::MlsApic, Transfer::FLIP] {
        let (above, below) = (block([0.0, 0.0, 0.12]), block([0.02, -0.03, -0.13]));
        let run = |both: bool| {
            let upper = vec![[0.2, 0.0, -2.0]; above.len()];
            let mut simulation = simulation(transfer, &above, &upper);
            if both {
                let law = FixedCorotated::new(Lame::from_young_poisson(3e4, 0.2).unwrap());
                let velocities = vec![[0.0, -0.5, 3.0]; below.len()];
                let volumes = vec![1e-4; below.len()];
                let samples = Samples { positions: &below, velocities: &velocities, volumes: &volumes };
                simulation.add_body(law, 2000.0, samples).unwrap();
            }
            let sheet = SheetMesh::new(&flat(1.2, 3)).unwrap();
            simulation.add_collider(Collider::at_rest(sheet, Surface::Friction(0.2))).unwrap();
            for _ in 0..60 {
                simulation.step(5e-4).unwrap();
            }
            simulation.positions(0)
        };
        let apart = run(false)
            .iter()
            .zip(run(true))
            .fold(0.0_f64, |most, (a, b)| most.max((0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max)));
        assert!(apart < 1e-12, "{transfer:?}: {apart}");
    }
}

#[test]
fn blocks_slide_on_a_sheet_as_coulomb_says() {
    let mut mesh = flat(3.0, 6);
    let above = SheetMesh::new(&mesh).unwrap();
    slides_as_coulomb_says("sheet", |surface| Collider::at_rest(above.clone(), surface));
    // The same from behind.
    mesh.flip();
    let behind = SheetMesh::new(&mesh).unwrap();
    slides_as_coulomb_says("sheet from behind", |surface| Collider::at_rest(behind.clone(), surface));
}

/// A sheet that turns about its middle and moves sweeps matter along on both sides; in `f32` and with cubic kernels too.
#[test]
fn nothing_passes_a_turning_sheet() {
    fn run<E: mechanics_core::lanes::Element>(kernel: Kernel, surface: Surface, threads: usize) -> u64
    where
        Simulation<E, 3>: Hash,
    {
        with_threads(threads, || {
            let sheet = SheetMesh::new(&flat(2.4, 4)).unwrap();
            let options = SimulationOptions { kernel, ..SimulationOptions::new(SPACING) };
            let mut simulation = Simulation::<E, 3>::new(options).unwrap();
            let positions = [block([0.3, 0.0, 0.13]), block([-0.2, 0.1, -0.13])].concat();
            let velocities = vec![[0.0; 3]; positions.len()];
            let volumes = vec![SPACING.powi(3) / 8.0; positions.len()];
            let law = FixedCorotated::new(Lame::from_young_poisson(1e4, 0.3).unwrap());
            let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
            simulation.add_body(law, 1000.0, samples).unwrap();
            let motion = RigidMotion {
                centre: [0.0; 3],
                velocity: [0.0, 0.0, 1.0],
                angular_velocity: [0.5, -6.0, 0.0],
            };
            simulation.add_collider(Collider::moving(sheet.clone(), surface, motion)).unwrap();
            let mut pushed = 0;
            while simulation.time() < 0.15 {
                let step = simulation.stable_step().min(5e-3);
                simulation.step(step).unwrap();
                let placement = simulation.collider_placement(0);
                for (x, start) in simulation.positions(0).iter().zip(&positions) {
                    let own = placement.point_at(&Vec3::from(*x));
                    assert!(own.z * start[2] > 0.0, "{kernel:?}, {surface:?}: from {start:?} to {own}");
                    let found = sheet.signed_distance(own.into());
                    pushed += usize::from(found.nearest == Side::Surface && found.distance.abs() < 0.05);
                }
            }
            let momentum = simulation.totals(0).momentum + simulation.collider_load(0).total.linear;
            let size = simulation.totals(0).momentum.norm();
            assert!(pushed > 100 && size > 1.0, "{pushed} near, {size} N s");
            assert!(momentum.norm() < 1e-5 * size, "{momentum}");
            simulation.hash()
        })
    }
    for surface in [Surface::Separating, Surface::Sticky] {
        let hash = run::<f64>(Kernel::Quadratic, surface, 1);
        assert_eq!(run::<f64>(Kernel::Quadratic, surface, 3), hash);
    }
    run::<f64>(Kernel::Cubic, Surface::Friction(0.5), 2);
    run::<f32>(Kernel::Quadratic, Surface::Slip, 2);
}

trait Hash {
    fn hash(&self) -> u64;
}

impl Hash for Simulation<f32, 3> {
    fn hash(&self) -> u64 {
        self.state_hash()
    }
}

impl Hash for Simulation<f64, 3> {
    fn hash(&self) -> u64 {
        self.state_hash()
    }
}

/// A block that falls beside a sheet is not held by it, and flies on as in free space.
#[test]
fn beyond_its_rim_a_sheet_is_not_there() {
    let mut mesh = flat(0.4, 2);
    mesh.translate(&Vec3::new(-0.6, 0.0, 0.0)).unwrap();
    let positions = block([0.1, 0.0, 0.2]);
    let mut simulation = simulation(Transfer::MlsApic, &positions, &vec![[0.0, 0.0, -4.0]; positions.len()]);
    simulation.add_collider(Collider::at_rest(SheetMesh::new(&mesh).unwrap(), Surface::Sticky)).unwrap();
    simulation.advance(0.1).unwrap();
    for (x, start) in simulation.positions(0).iter().zip(&positions) {
        assert!((0..3).all(|k| (x[k] - start[k] - [0.0, 0.0, -0.4][k]).abs() < 1e-10));
    }
    assert!(simulation.collider_load(0).total.linear.norm() < 1e-12);
}

/// A run over a checkpoint has the same bits, and a particle in the sheet is refused.
#[test]
fn sheets_resume_and_refuse() {
    let start = || {
        let positions = [block([0.0, 0.0, 0.15]), block([0.0, 0.0, -0.15])].concat();
        let velocities: Vec<[f64; 3]> = positions.iter().map(|x| [0.3, 0.0, -3.0 * x[2].signum()]).collect();
        let mut simulation = simulation(Transfer::MlsApic, &positions, &velocities);
        let sheet = SheetMesh::new(&wavy(1.2)).unwrap();
        simulation.add_collider(Collider::at_rest(sheet, Surface::Friction(0.3))).unwrap();
        simulation
    };
    let mut whole = start();
    let mut parts = start();
    for step in 0..50 {
        whole.step(1e-3).unwrap();
        if step % 7 == 0 {
            let checkpoint = parts.checkpoint();
            parts = start();
            parts.resume(checkpoint).unwrap();
        }
        parts.step(1e-3).unwrap();
    }
    assert_eq!(whole.state_hash(), parts.state_hash());
    assert_eq!(whole.collider_load(0), parts.collider_load(0));

    let mut simulation = simulation(Transfer::MlsApic, &[[0.0, 0.0, 0.3], [0.1, 0.1, 0.0]], &[[0.0; 3]; 2]);
    let sheet = Collider::at_rest(SheetMesh::new(&flat(1.0, 2)).unwrap(), Surface::Slip);
    let error = simulation.add_collider(sheet).unwrap_err();
    assert_eq!(error, MpmError::InCollider { body: 0, particle: 1, collider: 0, depth: 0.0 });
}
