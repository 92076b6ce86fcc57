//! Torque, moments, writhe, Love's helix.

use crate::samples::{Random, SECTION, crooked, gradient, orders, twist};
use lagrangian::element::Mass;
use lagrangian::element::rod::{RodBending, RodStretching, RodTwist, TwistSection};
use lagrangian::stepper::{Stepper, StepperOptions};
use mechanics_core::mesh::{PolylineEnds, TriMesh, polyline, rod};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use std::f64::consts::{PI, TAU};

/// Edges of different lengths: the equilibrium between ends turned by Θ has the torque GJΘ/L in every joint, and there is no force.
#[test]
fn a_straight_rod_transmits_its_torque() {
    let at = [0.0, 0.1, 0.15, 0.4, 0.9, 1.0, 1.3];
    let points: Vec<Vec3> = at.iter().map(|&s| Vec3::new(1.0, 2.0, 2.0) * (s / 3.0)).collect();
    let mesh = polyline(points, PolylineEnds::Open).unwrap();
    let (mut term, mut x) = twist(&mesh, SECTION);
    // From the middle of the first edge to the middle of the last.
    let length = 1.15 - 0.05;
    let angle = 17.0;
    let (first, last) = (term.turns().start, term.turns().end - 1);
    let mut held: Vec<(u32, Vec3)> = (0..7).map(|i| (i, x[i as usize])).collect();
    held.extend([(first, Vec3::zeros()), (last, term.turn(angle))]);
    let map = PointMap::with_fixed(x.len(), &held).unwrap();
    let mut state = State::at_rest(x.clone());
    let newton = NewtonOptions { tolerance: 1e-12, ..NewtonOptions::default() };
    let options = StepperOptions { newton, ..StepperOptions::default() };
    let mut stepper = Stepper::new(Mass::zeros(x.len()), map, options);
    stepper.equilibrium(&mut state, &mut [&mut term], 1).unwrap();
    x = state.position;

    let exact = SECTION.torsional * angle / length;
    println!("torque {:?}, GJ θ/L = {exact}", term.moments(&x));
    assert!(term.moments(&x).iter().all(|moment| (moment / exact - 1.0).abs() < 1e-13));
    let forces = gradient(&term, &x);
    assert!((forces[last as usize].x * SECTION.gyration_radius / exact - 1.0).abs() < 1e-13);
    assert!(forces[..7].iter().all(|f| f.norm() < 1e-12 * exact));
}

/// Where frames have just been carried to: forces have no sum, and their moments and the torques none either.
#[test]
fn forces_and_torques_balance() {
    let mut random = Random(5);
    for ends in [PolylineEnds::Open, PolylineEnds::Joined] {
        let mesh = crooked(&mut random, 8, ends);
        let (mut term, mut x) = twist(&mesh, SECTION);
        for i in 0..x.len() {
            x[i] += if i < 8 { random.vector() * 0.1 } else { term.turn(random.number()) };
        }
        term.transport_to(&x).unwrap();
        let forces = gradient(&term, &x);
        let scale = forces.iter().map(Vec3::norm).fold(0.0, f64::max);
        assert!(forces[..8].iter().sum::<Vec3>().norm() < 1e-14 * scale);
        let orbital: Vec3 = x[..8].iter().zip(&forces).map(|(x, f)| x.cross(f)).sum();
        let tangent = |&[a, b]: &[u32; 2]| (x[b as usize] - x[a as usize]).normalize();
        let torques = forces[8..].iter().map(|f| f.x * SECTION.gyration_radius);
        let spin: Vec3 = mesh.free_edges().iter().zip(torques).map(|(edge, t)| tangent(edge) * t).sum();
        assert!(spin.norm() > 0.1 * scale, "torques that are there");
        assert!((orbital + spin).norm() < 1e-13 * scale, "{}", (orbital + spin).norm() / scale);
    }
}

/// A rod turned as one piece, its turns by the spin ω·t: nothing happens, to the second order of the increments.
#[test]
fn a_rotation_of_everything_changes_no_energy() {
    let mut random = Random(6);
    let mesh = crooked(&mut random, 8, PolylineEnds::Open);
    let axis = random.vector().normalize();
    let (term, mut start) = twist(&mesh, SECTION);
    for (i, x) in start.iter_mut().enumerate() {
        *x += if i < 8 { random.vector() * 0.1 } else { term.turn(random.number()) };
    }
    let energy_after = |increments: u32| {
        let (mut term, mut x) = twist(&mesh, SECTION);
        term.transport_to(&start).unwrap();
        x.clone_from(&start);
        let energy = term.value(&x);
        let angle = 5.0 / f64::from(increments);
        let turn = |by: f64| *nalgebra::Rotation3::from_scaled_axis(axis * by).matrix();
        for _ in 0..increments {
            for (j, &[a, b]) in (8..).zip(mesh.free_edges()) {
                let middle = turn(0.5 * angle) * (x[b as usize] - x[a as usize]).normalize();
                x[j] += term.turn(angle * axis.dot(&middle));
            }
            x.iter_mut().take(8).for_each(|x| *x = turn(angle) * *x);
            term.transport_to(&x).unwrap();
        }
        (term.value(&x) / energy - 1.0).abs()
    };
    let errors = [50, 100, 200].map(energy_after);
    println!("rotation: errors {errors:?}, orders {:?}", orders(&errors));
    assert!(orders(&errors).iter().all(|order| (order - 2.0).abs() < 0.15) && errors[2] < 1e-3);
}

/// The writhe of a closed polygon: Gauss' integral over pairs of edges, each the area of a spherical quadrilateral (Klenin,
/// Langowski, Biopolymers 54, 2000, method 1a).
fn writhe(x: &[Vec3]) -> f64 {
    let n = x.len();
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..i {
            let [p1, p2, p3, p4] = [x[i], x[(i + 1) % n], x[j], x[(j + 1) % n]];
            let corners = [(p3 - p1, p4 - p1), (p4 - p1, p4 - p2), (p4 - p2, p3 - p2), (p3 - p2, p3 - p1)];
            let normals = corners.map(|(a, b)| a.cross(&b).try_normalize(1e-12).unwrap_or_default());
            let area: f64 =
                (0..4).map(|k| normals[k].dot(&normals[(k + 1) % 4]).clamp(-1.0, 1.0).asin()).sum();
            let side = (p4 - p3).cross(&(p2 - p1)).dot(&(p3 - p1));
            if side.abs() > 1e-12 {
                sum += area * side.signum();
            }
        }
    }
    sum / TAU
}

/// Călugăreanu's theorem: a closed rod that does not pass through itself keeps twist + writhe, so that with all turns at zero the
/// twist is the writhe lost.
#[test]
fn twist_and_writhe_exchange() {
    let mut random = Random(7);
    let mesh = crooked(&mut random, 16, PolylineEnds::Joined);
    let (mut term, mut x) = twist(&mesh, SECTION);
    let start = writhe(&x[..16]);
    // Out of the plane into something like a figure of eight, without passing through itself.
    let parts = 40;
    for part in 1..=parts {
        let amount = f64::from(part) / f64::from(parts);
        for i in 0..16 {
            let angle = TAU * i as f64 / 16.0;
            let lift = Vec3::new(0.0, -0.9 * angle.sin() + 0.8 * (2.0 * angle).sin(), 0.7 * angle.sin());
            x[i] = mesh.points()[i] + lift * amount;
        }
        term.transport_to(&x).unwrap();
    }
    let change = writhe(&x[..16]) - start;
    let twist: f64 = term.twists(&x).iter().sum::<f64>() / TAU;
    println!("writhe changed by {change}, twist by {twist}");
    assert!(change.abs() > 0.05, "{change}");
    assert!((twist + change).abs() < 1e-12, "{}", twist + change);
}

/// A helix of curvature κ and tortuosity τ with the twisting moment M is in equilibrium under the tension τ (M − EI τ): with the
/// moment m = EI κ b + M t of a rod and its force n, m' + t × n = 0 gives n = (M − EI τ)(κ b + τ t), which is constant, along the
/// axis (Love, Treatise on the Mathematical Theory of Elasticity, 1927, section 270).
#[test]
fn loves_helix_is_in_equilibrium() {
    let (curvature, tortuosity, moment, rigidity) = (1.0_f64, 0.5_f64, 3.0, 1.3);
    let out_of_balance = |sign: f64, step: f64| {
        let square = curvature.powi(2) + tortuosity.powi(2);
        let (radius, pitch) = (curvature / square, sign * tortuosity / square);
        let point = |i: i32| {
            let s = f64::from(i) * step * square.sqrt();
            Vec3::new(radius * s.cos(), radius * s.sin(), pitch * s)
        };
        let mesh = polyline((0..9).map(point).collect(), PolylineEnds::Open).unwrap();
        let (term, x) = twist(&mesh, SECTION);
        let term = term.with_natural_twist(-sign * moment / SECTION.torsional).unwrap();
        let bending = RodBending::new(&mesh, rigidity).unwrap().term("bending").unwrap();
        let edge = |i: usize| (x[i + 1] - x[i]).normalize();
        let tension = tortuosity * (moment - rigidity * tortuosity);
        let pull = (edge(4) - edge(3)) * tension;
        let residual = pull - gradient(&bending, &x)[4] - gradient(&term, &x)[4];
        residual.norm() / pull.norm()
    };
    for sign in [1.0, -1.0] {
        let errors = [0.1, 0.05, 0.025].map(|step| out_of_balance(sign, step));
        println!("helix, hand {sign}: out of balance {errors:?}, orders {:?}", orders(&errors));
        assert!(orders(&errors).iter().all(|order| (order - 2.0).abs() < 0.15) && errors[2] < 1e-5);
    }
}

/// Torsional vibrations of a rod, clamped at one end: ω = (π/2L) √(GJ/(ρI_p)) = (π/2L) √(G/ρ), with the turns' own mass.
#[test]
fn torsional_frequency() {
    let (shear, density, radius) = (2.0, 3.0, 0.05_f64);
    let area = PI * radius * radius;
    let section = TwistSection::circular(shear, radius).unwrap();
    let frequency = |n: u32| {
        // From the middle of the clamped edge to the free end the length is one.
        let h = 1.0 / (f64::from(n) - 0.5);
        let mesh = rod(&Vec3::zeros(), &Vec3::new(h * f64::from(n), 0.0, 0.0), n).unwrap();
        let (term, x) = twist(&mesh, section);
        let mut mass = Mass::zeros(x.len());
        term.add_mass(&mut mass, &mesh, density * area).unwrap();
        let fixed: Vec<u32> = (0..=n + 1).collect();
        let stiffness = crate::samples::hessian(&[&term], &x, &fixed);
        let along: Vec<usize> = (0..stiffness.nrows()).step_by(3).collect();
        let masses: Vec<f64> = mass.diagonal()[n as usize + 2..].to_vec();
        let scaled = nalgebra::DMatrix::from_fn(along.len(), along.len(), |i, j| {
            stiffness[(along[i], along[j])] / (masses[i] * masses[j]).sqrt()
        });
        scaled.symmetric_eigenvalues().min().sqrt()
    };
    let exact = 0.5 * PI * (shear / density).sqrt();
    let errors = [10, 20, 40].map(|n| frequency(n) / exact - 1.0);
    println!("torsional frequency: errors {errors:?}, orders {:?}", orders(&errors));
    assert!(orders(&errors).iter().all(|order| (order - 2.0).abs() < 0.15) && errors[2].abs() < 1e-3);
}

/// A rod without twist's other half, for the tests beside this one.
pub(crate) struct Body {
    pub(crate) stretching: mechanics_core::stencil::StencilTerm<RodStretching, 2>,
    pub(crate) bending: mechanics_core::stencil::StencilTerm<RodBending, 3>,
    pub(crate) twist: RodTwist,
    pub(crate) x: Vec<Vec3>,
}

impl Body {
    pub(crate) fn new(mesh: &TriMesh, axial: f64, flexural: f64, section: TwistSection) -> Self {
        let (twist, x) = twist(mesh, section);
        Self {
            stretching: RodStretching::term("stretching", mesh, axial).unwrap(),
            bending: RodBending::new(mesh, flexural).unwrap().term("bending").unwrap(),
            twist,
            x,
        }
    }

    pub(crate) fn value(&self, x: &[Vec3]) -> f64 {
        self.stretching.value(x) + self.bending.value(x) + self.twist.value(x)
    }
}
