//! q̈, energy and momenta at every sample of every trajectory.

use crate::fixture::{Fixture, Sample, distance, number, numbers, size};
use lagrangian::systems::*;
use lagrangian::{EulerLagrange, Expansion, Lagrangian, SlicedEulerLagrange, System};

/// Compares q̈ and the energy of `system` with all samples, relative to the largest in the trajectory. Positions of the samples are
/// rounded to `f64`, which alone is an error of some ε; `tolerance` allows for the conditioning of the system.
fn check<const N: usize>(fixture: &Fixture, system: &impl System<Coordinates = [f64; N]>, tolerance: f64) {
    let samples = fixture.samples();
    let largest = samples.iter().map(|s| size(&s.a)).fold(0.0, f64::max);
    let scale = samples.iter().filter_map(|s| s.energy).map(f64::abs).fold(1e-300, f64::max);
    for Sample { t, q, v, a, energy } in samples {
        let (q, v) = (q.try_into().unwrap(), v.try_into().unwrap());
        let mut found = [0.0; N];
        system.acceleration(t, &q, &v, &mut found).unwrap();
        let error = distance(&found, &a) / largest;
        assert!(error <= tolerance, "{} at t = {t}: q̈ is off by {error:e}", fixture.name());
        if let Some(energy) = energy {
            let error = (system.energy(t, &q, &v) - energy).abs() / scale;
            assert!(error <= tolerance, "{} at t = {t}: energy is off by {error:e}", fixture.name());
        }
    }
}

fn check_lagrangian<const N: usize>(name: &str, lagrangian: impl Lagrangian<N>, tolerance: f64) {
    check(&Fixture::read(name), &EulerLagrange::new(lagrangian), tolerance);
}

/// The momentum of coordinate `index` is the conserved number `key` at every sample.
fn check_momentum<const N: usize>(
    name: &str,
    lagrangian: impl Lagrangian<N>,
    index: usize,
    key: &str,
    tolerance: f64,
) {
    let (fixture, system) = (Fixture::read(name), EulerLagrange::new(lagrangian));
    let mut at = Expansion::zeros(N);
    for (i, Sample { t, q, v, .. }) in fixture.samples().into_iter().enumerate() {
        system.expand(t, &q.try_into().unwrap(), &v.try_into().unwrap(), &mut at);
        let exact = fixture.conserved(i, key);
        let error = (at.momentum[index] - exact).abs() / exact.abs();
        assert!(error <= tolerance, "{name} at t = {t}: {key} is off by {error:e}");
    }
}

#[test]
fn pendulums() {
    for name in ["pendulum_large", "pendulum_1rad", "pendulum_rotating"] {
        // At 97 rad the rounding of the angle is 1e-14.
        check_lagrangian(name, Pendulum::new(1.0, 1.0, 9.81).unwrap(), 2e-14);
    }
    check_lagrangian("double_pendulum", DoublePendulum::new([1.0; 2], [1.0; 2], 9.81).unwrap(), 1e-14);
    let regular = DoublePendulum::new([2.0, 1.0], [1.0, 0.5], 9.81).unwrap();
    check_lagrangian("double_pendulum_regular", regular, 1e-14);
    check_lagrangian("triple_pendulum", TriplePendulum::new([1.0; 3], [1.0; 3], 9.81).unwrap(), 1e-14);
    check_lagrangian("spring_pendulum", SpringPendulum::new(1.0, 40.0, 1.0, 9.81).unwrap(), 1e-14);
    let spherical = SphericalPendulum::new(1.0, 1.0, 9.81).unwrap();
    check_lagrangian("spherical_pendulum", spherical, 1e-14);
    check_momentum("spherical_pendulum", spherical, 1, "p_phi", 1e-14);
}

#[test]
fn orbits() {
    let kepler = Kepler::new(1.0, 1.0).unwrap();
    for name in ["kepler_e06", "kepler_e09"] {
        check_lagrangian(name, kepler, 1e-14);
        let fixture = Fixture::read(name);
        for (i, Sample { q, v, .. }) in fixture.samples().into_iter().enumerate() {
            let (q, v) = (q.try_into().unwrap(), v.try_into().unwrap());
            let momentum = kepler.angular_momentum(&q, &v);
            assert!((momentum - fixture.conserved(i, "l_z")).abs() <= 1e-15);
            let exact = [fixture.conserved(i, "A_x"), fixture.conserved(i, "A_y")];
            assert!(distance(&kepler.runge_lenz(&q, &v), &exact) <= 2e-15, "{name}, sample {i}");
        }
    }
    // Without perturbation the perturbed problem is Kepler's.
    check_lagrangian("kepler_e06", PerturbedKepler::new(1.0, 1.0, 0.0).unwrap(), 1e-14);
    check_lagrangian("henon_heiles_regular", HenonHeiles, 1e-14);
}

#[test]
fn tops() {
    let top = HeavyTop::new(0.25, 0.125, 1.0, 0.5, 9.81).unwrap();
    check_lagrangian("top_nutating", top, 1e-14);
    // The rates of φ and ψ near the vertical are differences of numbers 1/θ² = 1e4 larger.
    check_lagrangian("top_sleeping_stable", top, 1e-12);
    check_lagrangian("top_sleeping_unstable", top, 1e-12);
    for name in ["top_nutating", "top_sleeping_stable", "top_sleeping_unstable"] {
        check_momentum(name, top, 1, "p_phi", 1e-14);
        check_momentum(name, top, 2, "p_psi", 1e-14);
    }
}

#[test]
fn guided_beads() {
    let hoop = |rate| BeadOnHoop::new(1.0, 1.0, 9.81, rate).unwrap();
    check_lagrangian("hoop_subcritical", hoop(2.5), 1e-14);
    check_lagrangian("hoop_supercritical", hoop(5.0), 1e-14);
    let wire = BeadOnWire::new(1.0, 9.81, Parabola { curvature: 1.0 }).unwrap();
    check_lagrangian("bead_parabola", wire, 1e-14);
}

#[test]
fn a_forced_and_damped_oscillator() {
    check_lagrangian("duffing", Duffing::new(-1.0, 1.0, 0.3, 0.5, 1.2).unwrap(), 1e-14);
}

/// A quaternion's acceleration follows from Euler's equations I ω̇ = I ω × ω: q̈ = ½ (q̇ ω + q ω̇).
#[test]
fn a_free_body_obeys_eulers_equations() {
    let fixture = Fixture::read("dzhanibekov");
    let body = FreeBody::new(numbers(&fixture.content()["I"]).try_into().unwrap()).unwrap();
    let [i1, i2, i3] = body.inertia;
    let system = EulerLagrange::new(body);
    for sample in fixture.raw_samples() {
        let q: [f64; 4] = numbers(&sample["quat_wxyz"]).try_into().unwrap();
        let omega: [f64; 3] = numbers(&sample["omega_body"]).try_into().unwrap();
        let v = FreeBody::rate(&q, &omega);
        let [a, b, c] = omega;
        let euler = [(i2 - i3) * b * c / i1, (i3 - i1) * c * a / i2, (i1 - i2) * a * b / i3];
        let (turning, turned) = (FreeBody::rate(&v, &omega), FreeBody::rate(&q, &euler));
        let exact: [f64; 4] = std::array::from_fn(|i| turning[i] + turned[i]);

        let mut found = [0.0; 4];
        system.acceleration(0.0, &q, &v, &mut found).unwrap();
        assert!(distance(&found, &exact) <= 1e-14, "{found:?} {exact:?}");
        assert!(distance(&FreeBody::angular_velocity(&q, &v), &omega) <= 1e-15);
        assert!((system.energy(0.0, &q, &v) - number(&sample["energy"])).abs() <= 4e-15);
        let space = numbers(&sample["L_space"]);
        assert!(distance(&body.angular_momentum(&q, &v), &space) <= 4e-15);
    }
}

/// The length of the quaternion has no say: scaled by 3 it accelerates three times as much, and its own inertia does not matter.
#[test]
fn the_length_of_a_quaternion_means_nothing() {
    let body = FreeBody::new([1.0, 2.0, 3.0]).unwrap();
    let q = [0.5, -0.1, 0.7, 0.2];
    let v = FreeBody::rate(&q, &[1.0, -2.0, 0.5]);
    let mut unit = [0.0; 4];
    EulerLagrange::new(body).acceleration(0.0, &q, &v, &mut unit).unwrap();
    for radial_inertia in [0.1, 1.0, 50.0] {
        let system = EulerLagrange::new(FreeBody { radial_inertia, ..body });
        let mut scaled = [0.0; 4];
        system.acceleration(0.0, &q.map(|x| 3.0 * x), &v.map(|x| 3.0 * x), &mut scaled).unwrap();
        assert!(distance(&scaled, &unit.map(|x| 3.0 * x)) <= 1e-13, "{scaled:?} {unit:?}");
    }
}

/// As many links as one likes give what is written out for one, two and three.
#[test]
fn chains_of_pendulums() {
    for (name, masses, lengths) in [
        ("pendulum_large", vec![1.0], vec![1.0]),
        ("double_pendulum", vec![1.0; 2], vec![1.0; 2]),
        ("double_pendulum_regular", vec![2.0, 1.0], vec![1.0, 0.5]),
        ("triple_pendulum", vec![1.0; 3], vec![1.0; 3]),
    ] {
        let fixture = Fixture::read(name);
        let system = SlicedEulerLagrange::new(PendulumChain::new(masses, lengths, 9.81).unwrap());
        let largest = fixture.samples().iter().map(|s| size(&s.a)).fold(0.0, f64::max);
        for Sample { t, q, v, a, energy } in fixture.samples() {
            let mut found = vec![0.0; q.len()];
            system.acceleration(t, &q, &v, &mut found).unwrap();
            assert!(distance(&found, &a) <= 2e-14 * largest, "{name} at t = {t}");
            assert!((system.energy(t, &q, &v) - energy.unwrap()).abs() <= 4e-14, "{name} at t = {t}");
        }
    }
}

/// The squares of the small frequencies are g/l times the zeros of Laguerre's polynomials (Abramowitz, Stegun 1964, table 25.9).
#[test]
fn small_frequencies_of_a_chain_of_pendulums() {
    for (count, zeros) in [
        (3, vec![0.415_774_556_783, 2.294_280_360_279, 6.289_945_082_937]),
        (
            5,
            vec![
                0.263_560_319_718,
                1.413_403_059_107,
                3.596_425_771_041,
                7.085_810_005_859,
                12.640_800_844_276,
            ],
        ),
    ] {
        let system = SlicedEulerLagrange::new(PendulumChain::uniform(count, 2.0, 0.5, 4.0).unwrap());
        // q̈ = −A q for small q. A's characteristic polynomial is checked through its traces of powers, Σ λᵏ.
        let column = |j: usize| {
            let (mut q, mut a) = (vec![0.0; count], vec![0.0; count]);
            q[j] = 1e-6;
            system.acceleration(0.0, &q, &vec![0.0; count], &mut a).unwrap();
            a.iter().map(|x| -x / 1e-6).collect::<Vec<_>>()
        };
        let matrix: Vec<Vec<f64>> = (0..count).map(column).collect();
        let mut power = matrix.clone();
        for k in 1..=count as i32 {
            let trace: f64 = (0..count).map(|i| power[i][i]).sum();
            let exact: f64 = zeros.iter().map(|zero| (zero * 4.0 / 0.5f64).powi(k)).sum();
            assert!((trace - exact).abs() <= 2e-9 * exact, "{count} links, power {k}: {trace} {exact}");
            power = (0..count)
                .map(|i| (0..count).map(|j| (0..count).map(|l| power[i][l] * matrix[l][j]).sum()).collect())
                .collect();
        }
    }
}

/// q̈ of masses and springs, by Newton's law for each of them.
#[test]
fn a_chain_of_springs_obeys_newton() {
    let chain = SpringChain::new(vec![1.0, 2.0, 0.5], vec![4.0, 3.0, 0.0, 7.0]).unwrap();
    let system = SlicedEulerLagrange::new(chain);
    let q = [0.3, -0.2, 0.9];
    let mut a = vec![0.0; 3];
    system.acceleration(0.0, &q.to_vec(), &vec![0.1; 3], &mut a).unwrap();
    let newton = [(-4.0 * 0.3 + 3.0 * -0.5) / 1.0, -3.0 * -0.5 / 2.0, -7.0 * 0.9 / 0.5];
    assert!(distance(&a, &newton) <= 4e-15, "{a:?} {newton:?}");

    let fixture = Fixture::read("chain20");
    let uniform = SpringChain::uniform(20, fixture.number("m"), fixture.number("k")).unwrap();
    let system = SlicedEulerLagrange::new(uniform);
    for sample in fixture.samples() {
        assert!((system.energy(0.0, &sample.q, &sample.v) - 4.125).abs() <= 4e-15, "t = {}", sample.t);
    }
}
