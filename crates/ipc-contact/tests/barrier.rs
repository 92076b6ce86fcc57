//! The barrier against arithmetic with 700 bits: values by their formulas, derivatives by differences of those values.
#![allow(clippy::unwrap_used)]

use ipc_contact::ContactError;
use ipc_contact::barrier::{
    Barrier, DistanceBarrier, MinimumSeparation, PhysicalBarrier, SquaredDistanceBarrier,
};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

/// Bits behind the point of logarithms and roots.
const BITS: usize = 700;

fn exact(number: f64) -> BigRational {
    BigRational::from_float(number).unwrap()
}

fn fixed(numerator: BigInt) -> BigRational {
    BigRational::new(numerator, BigInt::one() << BITS)
}

/// ⌊number · 2^BITS⌋.
fn scaled(number: &BigRational) -> BigInt {
    (number.numer() << BITS) / number.denom()
}

/// Twice the series of artanh z.
fn twice_artanh(z: &BigRational) -> BigInt {
    let z = scaled(z);
    let square = (&z * &z) >> BITS;
    let (mut sum, mut power, mut odd) = (BigInt::zero(), z, 1);
    while !power.is_zero() && power != -BigInt::one() {
        sum += &power / odd;
        power = (&power * &square) >> BITS;
        odd += 2;
    }
    sum * 2
}

/// ln x, as k ln 2 + 2 artanh((m − 1)/(m + 1)) for x = m 2ᵏ with m between 2/3 and 4/3.
fn ln(x: &BigRational) -> BigRational {
    let two = BigRational::from_integer(2.into());
    let mut k = i64::try_from(x.numer().bits()).unwrap() - i64::try_from(x.denom().bits()).unwrap();
    let power = |k: i64| {
        let shifted = BigRational::from_integer(BigInt::one() << k.unsigned_abs());
        if k >= 0 { shifted } else { shifted.recip() }
    };
    let mut m = x / power(k);
    while m > BigRational::new(4.into(), 3.into()) {
        (m, k) = (m / &two, k + 1);
    }
    while m < BigRational::new(2.into(), 3.into()) {
        (m, k) = (m * &two, k - 1);
    }
    let one = BigRational::one();
    let ln_two = twice_artanh(&BigRational::new(1.into(), 3.into()));
    fixed(twice_artanh(&((&m - &one) / (&m + &one))) + ln_two * k)
}

fn sqrt(x: &BigRational) -> BigRational {
    fixed((scaled(x) << BITS).sqrt())
}

/// A form of the barrier by its published formula, of exact numbers s, ŝ and d̂.
type Formula = fn(&BigRational, &BigRational, &BigRational) -> BigRational;

fn squared(s: &BigRational, limit: &BigRational, _: &BigRational) -> BigRational {
    let below = s - limit;
    -(&below * &below) * ln(&(s / limit))
}

fn distance(s: &BigRational, limit: &BigRational, _: &BigRational) -> BigRational {
    let (d, limit) = (sqrt(s), sqrt(limit));
    let below = &d - &limit;
    -(&below * &below) * ln(&(d / limit))
}

fn physical(s: &BigRational, limit: &BigRational, activation: &BigRational) -> BigRational {
    let r = s / limit;
    let below = &r - BigRational::one();
    -(&below * &below) * ln(&r) * activation
}

/// b, b′ and b″ at s, by central differences whose step is 2⁻¹⁰⁰ of the way to the nearer end.
fn derivatives(
    formula: Formula,
    s: f64,
    shift: f64,
    limit: &BigRational,
    activation: f64,
) -> [BigRational; 3] {
    let (s, activation) = (exact(s) - exact(shift), exact(activation));
    let room = if &s + &s < *limit { s.clone() } else { limit - &s };
    let step = room / BigRational::from_integer(BigInt::one() << 100);
    let at = |s: &BigRational| formula(s, limit, &activation);
    let (before, here, after) = (at(&(&s - &step)), at(&s), at(&(&s + &step)));
    let second = (&after - &here - &here + &before) / (&step * &step);
    let first = (after - before) / (&step + &step);
    [here, first, second]
}

fn relative_error(found: f64, expected: &BigRational) -> f64 {
    ((exact(found) - expected) / expected).abs().to_f64().unwrap()
}

/// s/ŝ from 1e-30 to 1 − 1e-15: decades at both ends, and every twentieth between.
fn ratios() -> Vec<f64> {
    let low = (1..=30).map(|k| 10.0_f64.powi(-k) * 1.7);
    let middle = (1..20).map(|k| 0.05 * f64::from(k));
    let high = (1..=15).map(|k| 1.0 - 10.0_f64.powi(-k));
    low.chain(middle).chain(high).chain([0.5 - 1e-16, 0.5, 0.5 + 1e-16, 1.0 - f64::EPSILON / 2.0]).collect()
}

/// The worst relative errors of value, first and second derivative over all ratios.
fn worst(barrier: &impl Barrier, formula: Formula, activation: f64) -> [f64; 3] {
    let limit = barrier.activation_squared();
    let mut worst = [0.0_f64; 3];
    for ratio in ratios() {
        let s = ratio * limit;
        let expected = derivatives(formula, s, 0.0, &exact(limit), activation);
        let [first, second] = barrier.first_and_second(s);
        assert_eq!([first, second], [barrier.first(s), barrier.second(s)], "one call or two, at s = {s:e}");
        for (worst, (found, expected)) in
            worst.iter_mut().zip([barrier.value(s), first, second].into_iter().zip(&expected))
        {
            *worst = worst.max(relative_error(found, expected));
        }
    }
    worst
}

#[test]
fn every_form_is_accurate_to_the_last_places_from_contact_to_activation() {
    for activation in [1e-3, 0.3, 7.0, 1e-9, 1e5] {
        let errors = [
            worst(&SquaredDistanceBarrier::new(activation).unwrap(), squared, activation),
            worst(&DistanceBarrier::new(activation).unwrap(), distance, activation),
            worst(&PhysicalBarrier::new(activation).unwrap(), physical, activation),
        ];
        for error in errors.into_iter().flatten() {
            assert!(error < 8.0 * f64::EPSILON, "d̂ = {activation}: {errors:?}");
        }
    }
}

#[test]
fn a_minimum_separation_shifts_the_argument_and_widens_the_range() {
    let (activation, separation) = (1e-3, 4e-3);
    let limit = exact(activation) * (exact(2.0 * separation) + exact(activation));
    let shift = separation * separation;
    let barriers: [(Box<dyn Barrier>, Formula); 3] = [
        (
            Box::new(
                MinimumSeparation::new(SquaredDistanceBarrier::new(activation).unwrap(), separation).unwrap(),
            ),
            squared,
        ),
        (
            Box::new(MinimumSeparation::new(DistanceBarrier::new(activation).unwrap(), separation).unwrap()),
            distance,
        ),
        (
            Box::new(MinimumSeparation::new(PhysicalBarrier::new(activation).unwrap(), separation).unwrap()),
            physical,
        ),
    ];
    for (barrier, formula) in barriers {
        let reach = (activation + separation).powi(2);
        assert!((barrier.activation_squared() / reach - 1.0).abs() < 4.0 * f64::EPSILON);
        for gap in [1e-9, 1e-7, 1e-5, 1e-4, 5e-4, 9e-4, 9.99e-4] {
            let s = (separation + gap) * (separation + gap);
            let expected = derivatives(formula, s, shift, &limit, activation);
            let found = [barrier.value(s), barrier.first(s), barrier.second(s)];
            // Rounding of ŝ counts relative to the rest of the range, rounding of s relative to the gap.
            let allowed = 16.0 * f64::EPSILON * separation * (1.0 / gap + 1.0 / (activation - gap));
            for (found, expected) in found.into_iter().zip(&expected) {
                assert!(relative_error(found, expected) < allowed, "gap {gap:e}: {found:e}, {expected}");
            }
        }
        assert_eq!(barrier.value(shift), f64::INFINITY);
        assert_eq!(barrier.value(0.5 * shift), f64::INFINITY);
        assert_eq!(barrier.value(reach * 1.0001), 0.0);
    }
}

fn all(activation: f64) -> [Box<dyn Barrier>; 4] {
    [
        Box::new(SquaredDistanceBarrier::new(activation).unwrap()),
        Box::new(DistanceBarrier::new(activation).unwrap()),
        Box::new(PhysicalBarrier::new(activation).unwrap()),
        Box::new(
            MinimumSeparation::new(DistanceBarrier::new(activation).unwrap(), 0.1 * activation).unwrap(),
        ),
    ]
}

#[test]
fn the_ends_of_the_range_are_infinite_and_zero() {
    for barrier in all(2e-3) {
        for s in [0.0, -0.0, -1e-300, -1.0, f64::NEG_INFINITY] {
            let found = [barrier.value(s), barrier.first(s), barrier.second(s)];
            assert_eq!(found, [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY], "s = {s:e}");
            assert_eq!(barrier.first_and_second(s), found[1..]);
        }
        let limit = barrier.activation_squared();
        for s in [limit, limit.next_up(), 1.0, f64::MAX, f64::INFINITY] {
            assert_eq!([barrier.value(s), barrier.first(s), barrier.second(s)], [0.0; 3], "s = {s:e}");
            assert_eq!(barrier.first_and_second(s), [0.0; 2]);
        }
        assert!(barrier.value(f64::NAN).is_nan());
        assert!(barrier.first_and_second(f64::NAN).iter().all(|b| b.is_nan()));
    }
}

#[test]
fn the_smallest_distances_overflow_to_infinity_and_never_to_nan() {
    for activation in [1e-60, 1e-20, 1e-3, 1.0, 1e20, 1e60] {
        for barrier in &all(activation)[..3] {
            let mut s = barrier.activation_squared();
            while s > 0.0 {
                s *= 0.5_f64.powi(5);
                let [first, second] = barrier.first_and_second(s);
                assert!(barrier.value(s) > 0.0, "b({s:e}) with d̂ = {activation:e}");
                assert!(
                    first < 0.0 && second > 0.0,
                    "b′, b″ at {s:e} with d̂ = {activation:e}: {first}, {second}"
                );
            }
        }
    }
}

#[test]
fn barriers_are_positive_decreasing_and_convex_in_the_squared_distance_and_in_the_distance() {
    for barrier in all(1.0) {
        let limit = barrier.activation_squared();
        for k in 1..2000 {
            let s = limit * f64::from(k) / 2000.0;
            let [first, second] = barrier.first_and_second(s);
            if barrier.value(s) < f64::INFINITY {
                assert!(barrier.value(s) > 0.0 && first < 0.0 && second > 0.0);
                // d²b/dd² = 4 s b″ + 2 b′: what the Gauss–Newton Hessian needs.
                assert!(4.0 * s * second + 2.0 * first > 0.0, "s = {s}");
            }
        }
    }
}

#[test]
fn bad_distances_are_refused_by_value() {
    for distance in [0.0, -1e-3, f64::INFINITY, 1e-100, 1e61] {
        let refused = Err(ContactError::ActivationDistance { distance });
        assert_eq!(SquaredDistanceBarrier::new(distance).map(|_| ()), refused);
        assert_eq!(DistanceBarrier::new(distance).map(|_| ()), refused);
        assert_eq!(PhysicalBarrier::new(distance).map(|_| ()), refused);
    }
    assert!(matches!(
        DistanceBarrier::new(f64::NAN),
        Err(ContactError::ActivationDistance { distance }) if distance.is_nan()
    ));
    let barrier = DistanceBarrier::new(1e-3).unwrap();
    for distance in [-1e-9, f64::INFINITY, 1e61] {
        assert_eq!(
            MinimumSeparation::new(barrier, distance),
            Err(ContactError::MinimumSeparation { distance })
        );
    }
    assert!(MinimumSeparation::new(barrier, f64::NAN).is_err());
    assert_eq!(MinimumSeparation::new(barrier, 0.0).unwrap().activation_squared(), 1e-6);
}
