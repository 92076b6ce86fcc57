//! scratch
#![allow(clippy::print_stdout, missing_docs, clippy::unwrap_used)]
use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::intersection::check;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::element::{Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::{Stepper, StepperOptions};
use mechanics_core::law::{Lame, NeoHookean};
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use std::time::{Duration, Instant};
fn main() {
    let arg = |k: usize, d: f64| std::env::args().nth(k).map_or(d, |n| n.parse().unwrap());
    let n = arg(1, 39.0) as u32;
    let steps = arg(2, 60.0) as usize;
    let load = arg(3, 0.1);
    let every = arg(4, 10.0) as usize;
    let mat = block(&Vec3::new(-0.5, -0.5, -0.01), &Vec3::new(0.5, 0.5, 0.01), [n, n, 1], BoxSplit::Six).unwrap();
    let law = NeoHookean::new(Lame::from_young_poisson(2e4, 0.4).unwrap());
    let mut elastic = Tetrahedra::term("elastic", law, &mat).unwrap();
    let points = mat.points().len();
    let mut mass = Mass::zeros(points);
    mass.add_tetrahedra(mat.points(), mat.cells(), 1000.0, MassDistribution::Lumped).unwrap();
    let ends: Vec<(u32, Vec3)> = mat.points().iter().zip(0..).filter(|(x, _)| x.x.abs() > 0.4999).map(|(x, i)| (i, *x)).collect();
    let mut surfaces = CollisionMeshBuilder::new(mat.points());
    surfaces.add_object(CollisionObject::of_tets(&mat, 0).unwrap());
    surfaces.script_points(ends.iter().map(|e| e.0));
    let diagonal = 2f64.sqrt();
    let mut contact = BarrierContact::new(surfaces.build().unwrap(), ContactOptions::new(1e-3 * diagonal, Stiffness::adaptive(Scale::Load(load)))).unwrap();
    let map = PointMap::with_fixed(points, &ends).unwrap();
    let newton = NewtonOptions { tolerance: 1e-2 * diagonal, ..Default::default() };
    let mut stepper = Stepper::new(mass, map, StepperOptions { newton, ..Default::default() });
    let mut state = State::at_rest(mat.points().to_vec());
    let (mut its, mut pulls) = (0, 0);
    let begin = Instant::now();
    let mut stage = [Duration::ZERO; 6];
    for step in 1..=steps {
        let angle = 72f64.to_radians() * 0.04 * step as f64;
        for &(point, x) in &ends {
            let (s, c) = (angle * x.x.signum()).sin_cos();
            stepper.set_target(point, Vec3::new(x.x, c * x.y - s * x.z, s * x.y + c * x.z)).unwrap();
        }
        let report = match stepper.step(&mut state, &mut [&mut elastic, &mut contact], 0.04) { Ok(r) => r, Err(e) => { println!("step {step}: {e}"); break } };
        assert!(check(contact.mesh(), &state.position).unwrap().is_empty());
        its += report.newton.iterations;
        pulls += report.pulls;
        let t = &report.newton.times;
        for (a, b) in stage.iter_mut().zip([t.value, t.gradient, t.assembly, t.solve, t.limit_step, t.freeze]) { *a += b; }
        if step % every == 0 {
            let r = contact.report();
            println!("step {step}: its {} halvings {} limited {} factorisations {} pulls {} | total its {its} pulls {pulls}, {:.3} s/it | contacts {} smallest {:?} kappa {:.3e} dbl {} cand {} searches {} queries {} sets {} | {stage:.1?}", report.newton.iterations, report.newton.halvings, report.newton.limited_steps, report.newton.factorisations, report.pulls, begin.elapsed().as_secs_f64() / its as f64, r.contacts.total(), r.smallest_distance, r.stiffness, r.doublings, r.candidates, r.searches, r.detection_queries, r.sets);
        }
    }
}
