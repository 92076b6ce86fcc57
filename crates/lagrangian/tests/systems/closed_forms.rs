//! Periods, frequencies, exact motions and actions against numbers of 32 digits or against quadrature.

use crate::fixture::{Fixture, distance, number, numbers, size};
use lagrangian::systems::elliptic::{arithmetic_geometric_mean, complete_first_kind};
use lagrangian::systems::*;
use lagrangian::{EulerLagrange, Lagrangian, System};
use std::f64::consts::{PI, SQRT_2, TAU};

fn close(found: f64, exact: f64, tolerance: f64) {
    let error = ((found - exact) / exact).abs();
    assert!(error <= tolerance, "{found:e} instead of {exact:e}: off by {error:e}");
}

/// Gauss's constant 1/agm(1, √2) = 0.83462684167407318628…, and K(1/√2) = Γ(¼)²/(4√π) = 1.85407467730137191843….
#[test]
fn arithmetic_geometric_means() {
    close(1.0 / arithmetic_geometric_mean(1.0, SQRT_2), 0.834_626_841_674_073_186_28, 4e-16);
    close(complete_first_kind(0.5f64.sqrt()), 1.854_074_677_301_371_918_43, 4e-16);
    close(complete_first_kind(1.0), 0.5 * PI, 1e-16);
    // K → ln(4/k′) as k′ → 0.
    close(complete_first_kind(1e-150), 4.0f64.ln() + 150.0 * 10.0f64.ln(), 4e-16);
    assert_eq!(arithmetic_geometric_mean(3.0, 0.0), 0.0);
    assert_eq!(complete_first_kind(0.0), f64::INFINITY);
    assert!(arithmetic_geometric_mean(-1.0, 1.0).is_nan());
    // Homogeneous, also where a product of the arguments would leave the range of f64.
    for scale in [1e-300, 1e300] {
        close(arithmetic_geometric_mean(scale, 2.0 * scale) / scale, 1.456_791_031_046_907, 4e-16);
    }
}

#[test]
fn periods_of_the_pendulum() {
    let fixture = Fixture::read("pendulum_periods");
    let pendulum = Pendulum::new(1.0, fixture.number("l"), fixture.number("g")).unwrap();
    for row in fixture.content()["periods"].as_array().unwrap() {
        let amplitude = number(&row["theta0"]);
        // Near π the period depends on cos ½θ₀, whose argument is rounded.
        let tolerance = 4e-16 + 1e-16 / (0.5 * amplitude).cos();
        close(pendulum.swing_period(amplitude), number(&row["period_s"]), tolerance);
    }
}

/// The integrand of the time of a turn is smooth and periodic: the trapezoidal rule converges exponentially.
#[test]
fn the_time_of_a_full_turn() {
    let pendulum = Pendulum::new(1.0, 2.0, 9.81).unwrap();
    for rate in [5.0, 7.0, -7.0, 40.0] {
        let speed =
            |angle: f64| (rate * rate - (2.0 * pendulum.frequency() * (0.5 * angle).sin()).powi(2)).sqrt();
        let n = 400;
        let sum: f64 = (0..n).map(|i| TAU / f64::from(n) / speed(TAU * f64::from(i) / f64::from(n))).sum();
        close(pendulum.turn_period(rate), sum, 2e-14);
    }
    assert!(pendulum.turn_period(4.0).is_nan());
}

#[test]
fn small_frequencies_of_multiple_pendulums() {
    // Two equal pendulums: ω² = (2 ± √2) g/l.
    let [slow, fast] = DoublePendulum::new([1.0; 2], [1.0; 2], 9.81).unwrap().frequencies();
    close(slow, (9.81 * (2.0 - SQRT_2)).sqrt(), 4e-16);
    close(fast, (9.81 * (2.0 + SQRT_2)).sqrt(), 4e-16);

    // The linearised equations have an eigenvector with that eigenvalue: q̈ = −ω² q to first order.
    let pendulum = DoublePendulum::new([2.0, 1.0], [1.0, 0.5], 9.81).unwrap();
    let system = EulerLagrange::new(pendulum);
    for omega in pendulum.frequencies() {
        // The first linearised equation, (m₁ + m₂)(g − l₁ ω²) q₁ = m₂ l₂ ω² q₂.
        let ratio = 3.0 * (9.81 - omega * omega) / (omega * omega * 0.5);
        let q = [1e-6, 1e-6 * ratio];
        let mut a = [0.0; 2];
        system.acceleration(0.0, &q, &[0.0; 2], &mut a).unwrap();
        assert!(distance(&a, &q.map(|x| -omega * omega * x)) <= 1e-9 * size(&a), "{a:?}");
    }
}

#[test]
fn tops() {
    let top = HeavyTop::new(0.25, 0.125, 1.0, 0.5, 9.81).unwrap();
    let exact = Fixture::read("heavy_top_exact");
    let mut compared = 0;
    for row in exact.content().as_array().unwrap() {
        close(top.critical_spin(), number(&row["critical_spin"]), 4e-16);
        let name = row["name"].as_str().unwrap();
        if name == "top_looping" {
            continue; // No initial state is given for it.
        }
        let start = Fixture::read(name).start::<3>();
        let nutation = top.nutation(start.q[0], start.v[1], start.v[2]);
        close(nutation.least_angle, number(&row["theta_min"]), 1e-15);
        close(nutation.largest_angle, number(&row["theta_max"]), 1e-14);
        close(nutation.period, number(&row["nutation_period"]), 1e-14);
        // Released from the other turning point the top nods as before.
        let (a, b) = (nutation.least_angle, nutation.largest_angle);
        let p_psi = top.axial_inertia * start.v[2];
        let p_phi = p_psi * a.cos();
        let precession = (p_phi - p_psi * b.cos()) / (top.transverse_inertia * b.sin().powi(2));
        // Near the vertical two of the cubic's roots nearly meet, and the lower end says little about the upper.
        let tolerance = if a > 0.1 { 1e-12 } else { 1e-7 };
        let back = top.nutation(b, precession, start.v[2] - precession * b.cos());
        close(back.least_angle, a, tolerance);
        close(back.largest_angle, b, 1e-15);
        close(back.period, nutation.period, tolerance);
        compared += 1;
    }
    assert_eq!(compared, 3);
}

#[test]
fn the_flipping_body() {
    let fixture = Fixture::read("dzhanibekov");
    let body = FreeBody::new(numbers(&fixture.content()["I"]).try_into().unwrap()).unwrap();
    for sample in fixture.raw_samples() {
        let omega = numbers(&sample["omega_body"]).try_into().unwrap();
        // Away from the start the separatrix's distance is a difference of large squares.
        close(body.spin_period(&omega), fixture.number("sn_period"), 1e-9);
    }
    let start = numbers(&fixture.content()["omega0"]).try_into().unwrap();
    close(body.spin_period(&start), fixture.number("sn_period"), 1e-15);
    // The order of the axes does not matter. A ball's ω stays, so it has no period.
    let turned = FreeBody::new([3.0, 1.0, 2.0]).unwrap();
    close(turned.spin_period(&[0.001, 0.001, 2.0]), fixture.number("sn_period"), 1e-15);
    assert_eq!(FreeBody::new([2.0; 3]).unwrap().spin_period(&start), f64::INFINITY);
    // A symmetric top's ω turns about the axis at the rate ω₃ (I₃ − I₁)/I₁.
    let symmetric = FreeBody::new([1.0, 1.0, 3.0]).unwrap();
    close(symmetric.spin_period(&[0.3, 0.4, 2.0]), TAU / 4.0, 1e-15);
}

#[test]
fn hoop() {
    let fixture = Fixture::read("hoop_exact");
    for case in fixture.content()["cases"].as_array().unwrap() {
        let hoop =
            BeadOnHoop::new(1.0, fixture.number("R"), fixture.number("g"), number(&case["Omega"])).unwrap();
        close(hoop.critical_rate(), fixture.number("critical_Omega"), 4e-16);
        assert!((hoop.equilibrium() - number(&case["equilibrium"])).abs() <= 4e-16);
        close(hoop.frequency(), number(&case["omega_small"]), 4e-16);
        let growth = case.get("growth_rate_at_0").map_or(0.0, number);
        assert!((hoop.growth_rate_at_bottom() - growth).abs() <= 1e-15);
    }
}

#[test]
fn actions_between_two_points() {
    let fixture = Fixture::read("action_bvp");
    let spring = MassOnSpring::new(1.0, 2.25).unwrap();
    let stone = Projectile::new(1.0, 9.81).unwrap();
    for row in fixture.content().as_array().unwrap() {
        let [start, end, duration] = ["q0", "q1", "T"].map(|key| number(&row[key]));
        let found = if row["system"].as_str().unwrap().starts_with("harmonic") {
            spring.action_between(start, end, duration)
        } else {
            stone.action_between([0.0, start], [0.0, end], duration)
        };
        close(found, number(&row["action"]), 2e-15);
    }
}

/// Kepler's equation holds, and the solution is the right one of the two signs, for all eccentricities and anomalies.
#[test]
fn keplers_equation() {
    for e in [0.0, 1e-12, 0.1, 0.6, 0.9, 0.999, 1.0 - 1e-12] {
        for i in -400..=400 {
            let m = f64::from(i) * PI / 400.0 + if i % 7 == 0 { 1e-9 } else { 0.0 };
            let found = eccentric_anomaly(m, e);
            let reduced = (m + PI).rem_euclid(TAU) - PI;
            let residual = found - e * found.sin() - reduced;
            assert!(residual.abs() <= 2e-15, "e = {e}, M = {m}: {residual:e}");
        }
    }
    assert!(eccentric_anomaly(f64::NAN, 0.5).is_nan());
    assert!((eccentric_anomaly(100.0 * TAU + 1.0, 0.5) - eccentric_anomaly(1.0, 0.5)).abs() < 1e-12);
}

/// The exact orbit: against every sample, up to a hundred thousand turns.
#[test]
fn keplers_orbits() {
    let kepler = Kepler::new(1.0, 1.0).unwrap();
    for (name, e) in [("kepler_e06", 0.6), ("kepler_e09", 0.9)] {
        let start = Fixture::read(name).start::<2>();
        let long = Fixture::read(&format!("{name}_long"));
        close(kepler.period(&start.q, &start.v), long.number("period"), 2e-15);
        close(kepler.half_axis(&start.q, &start.v), long.number("a"), 1e-15);
        for sample in Fixture::read(name).samples().iter().chain(&long.samples()) {
            let [q, v] = kepler.motion(&start.q, &start.v, sample.t);
            let tolerance = 1e-15 * (4.0 + sample.t) / (1.0f64 - e).powi(2);
            let error = distance(&q, &sample.q).max(distance(&v, &sample.v) / size(&sample.v).max(1.0));
            assert!(error <= tolerance, "{name} at t = {}: {error:e}", sample.t);
        }
    }
}

/// From any point of any orbit, either way round, forwards and back again.
#[test]
fn orbits_can_be_entered_anywhere() {
    let kepler = Kepler::new(2.0, 3.0).unwrap();
    for (q, v) in [([1.0, 0.3], [-0.2, 0.9]), ([-0.4, 1.1], [0.5, 0.6]), ([1.5, 0.0], [0.0, -1.0])] {
        assert!(distance(&kepler.motion(&q, &v, 0.0)[0], &q) <= 4e-15);
        assert!(distance(&kepler.motion(&q, &v, 0.0)[1], &v) <= 4e-15);
        let [there, speed] = kepler.motion(&q, &v, 2.7);
        let [back, _] = kepler.motion(&there, &speed, -2.7);
        assert!(distance(&back, &q) <= 2e-14, "{back:?}");
        let period = kepler.period(&q, &v);
        assert!(distance(&kepler.motion(&q, &v, period)[0], &q) <= 2e-14);
        // The motion obeys m q̈ = −k q/r³: a central difference of the velocity.
        let h = 1e-5;
        let [[_, before], [_, after]] = [kepler.motion(&q, &v, -h), kepler.motion(&q, &v, h)];
        let mut a = [0.0; 2];
        EulerLagrange::new(kepler).acceleration(0.0, &q, &v, &mut a).unwrap();
        let difference: [f64; 2] = std::array::from_fn(|i| (after[i] - before[i]) / (2.0 * h));
        assert!(distance(&a, &difference) <= 1e-8 * size(&a).max(1.0));
    }
    // A circle: no perihelion to count from.
    let [q, _] = kepler.motion(&[1.0, 0.0], &[0.0, 1.5f64.sqrt()], PI / 1.5f64.sqrt());
    assert!(distance(&q, &[-1.0, 0.0]) <= 4e-15);
    let start = kepler.perihelion(2.0, 0.7);
    close(kepler.half_axis(&start.q, &start.v), 2.0, 1e-14);
}

#[test]
fn chains() {
    let fixture = Fixture::read("chain20");
    let (m, k) = (fixture.number("m"), fixture.number("k"));
    let exact = numbers(&fixture.content()["frequencies"]);
    let found = SpringChain::uniform_frequencies(20, m, k);
    assert!(distance(&found, &exact) <= 1e-15);
    let start = Fixture::read("chain20").content().clone();
    let (q0, v0) = (numbers(&start["q0"]), numbers(&start["qdot0"]));
    for sample in fixture.samples() {
        let [q, v] = SpringChain::uniform_motion(m, k, &q0, &v0, sample.t);
        let tolerance = 1e-15 * (4.0 + sample.t);
        assert!(distance(&q, &sample.q) <= tolerance, "t = {}", sample.t);
        assert!(distance(&v, &sample.v) <= 4.0 * tolerance, "t = {}", sample.t);
    }
}

/// θ̈ = −(g/L) sin θ in both coordinate choices, at many states: the angle's equation straight, the Cartesian one with the multiplier
/// that keeps |r| = L. Both are within rounding of the textbook's formula.
#[test]
fn one_pendulum_in_two_coordinates() {
    let mut random = Random(1);
    for _ in 0..2000 {
        let [mass, length, gravity] = [0.1, 0.1, 1.0].map(|least| least + 10.0 * random.next());
        let (angle, rate) = (20.0 * random.next() - 10.0, 20.0 * random.next() - 10.0);
        let exact = -gravity / length * angle.sin();

        let mut a = [0.0];
        let pendulum = EulerLagrange::new(Pendulum::new(mass, length, gravity).unwrap());
        pendulum.acceleration(0.0, &[angle], &[rate], &mut a).unwrap();
        // Eight products and quotients, each within half a spacing.
        assert!((a[0] - exact).abs() <= 4.0 * f64::EPSILON * exact.abs(), "{a:?} {exact}");

        let cartesian = CartesianPendulum::new(mass, length, gravity).unwrap();
        let [q, v] = cartesian.from_angle(angle, rate);
        let mut free = [0.0; 2];
        EulerLagrange::new(cartesian).acceleration(0.0, &q, &v, &mut free).unwrap();
        // r·r̈ = −|ṙ|² fixes λ in m r̈ = m g + λ r; then θ̈ = (x ÿ − y ẍ)/L², x and y turned as θ is counted.
        let (square, speed) = (q[0] * q[0] + q[1] * q[1], v[0] * v[0] + v[1] * v[1]);
        let over_mass = -(speed + q[0] * free[0] + q[1] * free[1]) / square;
        let a: [f64; 2] = std::array::from_fn(|i| free[i] + over_mass * q[i]);
        let found = (q[0] * a[1] - q[1] * a[0]) / square;
        let scale = gravity / length + rate * rate;
        assert!((found - exact).abs() <= 1e-15 * scale, "{found} {exact}");
    }
}

/// Potentials against textbook facts that the trajectories do not show.
#[test]
fn saddles_and_symmetries() {
    // The saddles of Hénon and Heiles, at the corners of a triangle.
    for corner in 0..3 {
        let angle = 0.5 * PI + TAU / 3.0 * f64::from(corner);
        let q = [angle.cos(), angle.sin()];
        let value: f64 = HenonHeiles.potential(&q, 0.0);
        close(value, HenonHeiles::ESCAPE_ENERGY, 1e-14);
        let mut a = [0.0; 2];
        EulerLagrange::new(HenonHeiles).acceleration(0.0, &q, &[0.0; 2], &mut a).unwrap();
        assert!(size(&a) <= 4e-15, "{a:?}");
    }
    // A conical pendulum does not nod; an elastic one hangs still; the bead rests on its hoop.
    let spherical = SphericalPendulum::new(2.0, 0.7, 9.81).unwrap();
    let mut a = [0.0; 2];
    let around = [0.0, spherical.conical_rate(0.8)];
    EulerLagrange::new(spherical).acceleration(0.0, &[0.8, 0.1], &around, &mut a).unwrap();
    assert!(size(&a) <= 1e-14, "{a:?}");
    let elastic = SpringPendulum::new(1.5, 40.0, 1.0, 9.81).unwrap();
    EulerLagrange::new(elastic).acceleration(0.0, &[elastic.rest_length(), 0.0], &[0.0; 2], &mut a).unwrap();
    assert!(size(&a) <= 1e-14, "{a:?}");
    let hoop = BeadOnHoop::new(1.0, 0.5, 9.81, 7.0).unwrap();
    let mut a = [0.0];
    EulerLagrange::new(hoop).acceleration(0.0, &[hoop.equilibrium()], &[0.0], &mut a).unwrap();
    assert!(size(&a) <= 2e-14, "{a:?}");
}

/// A damped, driven cart loses 2R and gains Q·q̇: dh/dt by the equations of motion, h = T + V by the formulas.
#[test]
fn the_power_of_damper_and_drive() {
    let cart = CartPendulum::new(3.0, 1.5, 0.8, 9.81)
        .and_then(|cart| cart.damped(0.4, 0.2))
        .and_then(|cart| cart.driven(Drive { amplitude: 2.0, frequency: 1.3 }))
        .unwrap();
    let system = EulerLagrange::new(cart);
    let (t, q, v) = (0.7, [0.3, 1.1], [-0.6, 2.0]);
    let mut a = [0.0; 2];
    system.acceleration(t, &q, &v, &mut a).unwrap();
    let h = 1e-5;
    let energy = |s: f64| {
        let at = |i: usize| (q[i] + s * v[i] + 0.5 * s * s * a[i], v[i] + s * a[i]);
        let ((x, vx), (y, vy)) = (at(0), at(1));
        system.energy(t + s, &[x, y], &[vx, vy])
    };
    let rate = (energy(h) - energy(-h)) / (2.0 * h);
    let lost = 0.4 * v[0] * v[0] + 0.2 * v[1] * v[1];
    let gained = 2.0 * (1.3f64 * t).cos() * v[0];
    close(rate, gained - lost, 1e-8);

    // Small swings without damping: θ̈ = −ω² θ with the cart free to roll.
    let free = CartPendulum::new(3.0, 1.5, 0.8, 9.81).unwrap();
    EulerLagrange::new(free).acceleration(0.0, &[0.0, 1e-6], &[0.0; 2], &mut a).unwrap();
    close(-a[1] / 1e-6, free.frequency().powi(2), 1e-9);
}

/// A small linear congruential generator (Knuth, MMIX): numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}
