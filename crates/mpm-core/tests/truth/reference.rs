//! Step for step with another solver, in single and in double precision. See `fixtures/README.md`.

use mechanics_core::lanes::Element;
use mechanics_core::law::Lame;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{Matrix3, determinant, multiple_of_identity};
use mpm_constitutive::elastic::FixedCorotated;
use mpm_constitutive::{PointLaw, StiffnessBound, Stress, TotalDeformation};
use mpm_core::{Boundary, Kernel, Samples, Shape, Simulation, SimulationOptions, Surface, Transfer};

const PARTICLES: usize = 4096;
const EVERY: usize = 8;
const SHOWN: usize = PARTICLES / EVERY;

/// τ = −K J (J^−1.1 − 1) I with J = det F: the library's Tait with γ = 1.1 and K′ = 1.1 K, but F is carried whole, as in the reference.
#[derive(Clone, Copy, Debug)]
struct WholeFluid {
    bulk: f64,
}

impl PointLaw for WholeFluid {
    type Strain<S: Scalar> = Matrix3<S>;
    type History<S: Scalar> = ();
    const TOTAL_DEFORMATION: TotalDeformation = TotalDeformation::IsTheStrain;

    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>, _history: &()) -> S {
        let j = determinant(f);
        (j.powf(-0.1).offset(-1.0).scale(10.0) + j.offset(-1.0)).scale(self.bulk)
    }

    #[inline(always)]
    fn stress<S: Scalar>(&self, f: &Matrix3<S>, _history: &()) -> Stress<S> {
        let j = determinant(f);
        let tau = (j * (j.ln().scale(-1.1).exp_m1())).scale(-self.bulk);
        let stiffness = StiffnessBound { lambda: j.powf(-0.1).scale(1.1 * self.bulk), mu: S::constant(0.0) };
        Stress { kirchhoff: multiple_of_identity(tau), stiffness }
    }
}

struct Fixture {
    numbers: Vec<f32>,
    next: usize,
}

impl Fixture {
    fn open() -> Self {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/reference.f32");
        let bytes = std::fs::read(path).unwrap();
        let numbers = bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        Self { numbers, next: 0 }
    }

    fn take(&mut self, count: usize) -> Vec<f64> {
        let part = &self.numbers[self.next..self.next + count];
        self.next += count;
        part.iter().map(|x| f64::from(*x)).collect()
    }

    fn vectors(&mut self, count: usize) -> Vec<[f64; 3]> {
        self.take(3 * count).chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect()
    }
}

/// The record of one case after some steps.
struct Record {
    x: Vec<[f64; 3]>,
    v: Vec<[f64; 3]>,
    c: Vec<f64>,
    f: Vec<f64>,
}

/// Largest differences of x \[m\], v [m/s], C [1/s] and J.
#[derive(Debug, Default)]
struct Difference {
    x: f64,
    v: f64,
    c: f64,
    j: f64,
}

fn compare<E: Element>(simulation: &Simulation<E, 3>, record: &Record, affine: bool) -> Difference {
    let (x, v) = (simulation.positions(0), simulation.velocities(0));
    let (c, states) = (simulation.velocity_gradients(0), simulation.states(0));
    let mut d = Difference::default();
    for k in 0..SHOWN {
        let p = k * EVERY;
        for a in 0..3 {
            d.x = d.x.max((x[p][a] - record.x[k][a]).abs());
            d.v = d.v.max((v[p][a] - record.v[k][a]).abs());
            for b in 0..3 {
                if affine {
                    d.c = d.c.max((c[p][a][b] - record.c[9 * k + 3 * a + b]).abs());
                }
            }
        }
        let f = Matrix3::from_row_slice(&record.f[9 * k..9 * k + 9]);
        d.j = d.j.max((states[p].volume_ratio - determinant(&f)).abs());
    }
    d
}

struct Start {
    x: Vec<[f64; 3]>,
    v: Vec<[f64; 3]>,
    volumes: Vec<f64>,
}

fn simulation<E: Element, L: PointLaw + 'static>(start: &Start, law: L, transfer: Transfer) -> Simulation<E, 3> {
    let options = SimulationOptions { spacing: 1.0 / 32.0, kernel: Kernel::Quadratic, transfer };
    let mut simulation = Simulation::<E, 3>::new(options).unwrap();
    simulation.set_gravity([0.0, 0.0, -9.8]).unwrap();
    let floor = Shape::HalfSpace { point: [0.0, 0.0, 0.36], normal: [0.0, 0.0, 1.0] };
    simulation.add_boundary(Boundary::at_rest(floor, Surface::Sticky)).unwrap();
    let samples = Samples { positions: &start.x, velocities: &start.v, volumes: &start.volumes };
    simulation.add_body(law, 1000.0, samples).unwrap();
    simulation
}

const STEPS: [usize; 3] = [1, 10, 50];

/// Differences after 1, 10 and 50 steps.
fn run<E: Element, L: PointLaw + 'static>(
    start: &Start,
    law: L,
    transfer: Transfer,
    records: &[Record; 3],
) -> [Difference; 3] {
    let mut simulation = simulation::<E, L>(start, law, transfer);
    let mut taken = 0;
    std::array::from_fn(|k| {
        while taken < STEPS[k] {
            simulation.step(2e-4).unwrap();
            taken += 1;
        }
        compare(&simulation, &records[k], transfer != Transfer::Pic)
    })
}

#[test]
fn every_step_is_that_of_another_solver() {
    let mut fixture = Fixture::open();
    let start = Start { x: fixture.vectors(PARTICLES), v: fixture.vectors(PARTICLES), volumes: fixture.take(PARTICLES) };
    let jelly = FixedCorotated::new(Lame::from_young_poisson(1e5, 0.3).unwrap());
    let fluid = WholeFluid { bulk: 1e5 };
    for case in ["jelly", "jelly_pic", "fluid"] {
        let records: [Record; 3] = std::array::from_fn(|_| Record {
            x: fixture.vectors(SHOWN),
            v: fixture.vectors(SHOWN),
            c: fixture.take(9 * SHOWN),
            f: fixture.take(9 * SHOWN),
        });
        let (double, single) = match case {
            "jelly" => (
                run::<f64, _>(&start, jelly, Transfer::APIC, &records),
                run::<f32, _>(&start, jelly, Transfer::APIC, &records),
            ),
            "jelly_pic" => (
                run::<f64, _>(&start, jelly, Transfer::Pic, &records),
                run::<f32, _>(&start, jelly, Transfer::Pic, &records),
            ),
            _ => (
                run::<f64, _>(&start, fluid, Transfer::APIC, &records),
                run::<f32, _>(&start, fluid, Transfer::APIC, &records),
            ),
        };
        for (precision, differences) in [("f64", &double), ("f32", &single)] {
            for (steps, d) in STEPS.iter().zip(differences) {
                println!("{case} {precision} after {steps}: x {:.1e} v {:.1e} C {:.1e} J {:.1e}", d.x, d.v, d.c, d.j);
            }
            for (k, d) in differences.iter().enumerate() {
                // Of x, 1e-6 m as the reference's page says; the rest in proportion to its size (v 3 m/s, C 100/s).
                let room = [1.0, 1.0, 3.0][k];
                assert!(d.x < 1e-6 * room, "{case} {precision}, x after {}: {d:?}", STEPS[k]);
                assert!(d.v < 1e-5 * room, "{case} {precision}, v after {}: {d:?}", STEPS[k]);
                assert!(d.c < 2e-3 * room, "{case} {precision}, C after {}: {d:?}", STEPS[k]);
                assert!(d.j < 1e-5 * room, "{case} {precision}, J after {}: {d:?}", STEPS[k]);
            }
        }
    }
    assert_eq!(fixture.next, fixture.numbers.len());
}
