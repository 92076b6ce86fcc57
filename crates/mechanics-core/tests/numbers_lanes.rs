//! Lanes against the same formula on single numbers.

use mechanics_core::lanes::{
    Element, LaneKernel, Packet, Pair, dispatch, dispatch_portable, load_matrices, store_matrices,
};
use mechanics_core::scalar::{Mask, Scalar};
use mechanics_core::tensor::{self, Matrix3};

/// Everything a [`Scalar`] can do with two numbers, with a name for each.
fn all_operations<S: Scalar>(a: S, b: S) -> Vec<(&'static str, S)> {
    let flag = |mask: S::Mask| S::select(mask, S::constant(1.0), S::constant(0.0));
    let mut assigned = [a; 4];
    assigned[0] += b;
    assigned[1] -= b;
    assigned[2] *= b;
    assigned[3] /= b;
    vec![
        ("a + b", a + b),
        ("a - b", a - b),
        ("a * b", a * b),
        ("a / b", a / b),
        ("-a", -a),
        ("a += b", assigned[0]),
        ("a -= b", assigned[1]),
        ("a *= b", assigned[2]),
        ("a /= b", assigned[3]),
        ("scale", a.scale(0.7)),
        ("offset", a.offset(0.7)),
        ("square", a.square()),
        ("recip", a.recip()),
        ("sqrt", a.sqrt()),
        ("exp", a.exp()),
        ("exp_m1", a.exp_m1()),
        ("ln", a.ln()),
        ("ln_1p", a.ln_1p()),
        ("sin", a.sin()),
        ("cos", a.cos()),
        ("tan", a.tan()),
        ("atan2", a.atan2(b)),
        ("asin", a.asin()),
        ("acos", a.acos()),
        ("sinh", a.sinh()),
        ("cosh", a.cosh()),
        ("tanh", a.tanh()),
        ("powf", a.powf(1.7)),
        ("reciprocal_power_of_two", a.reciprocal_power_of_two()),
        ("abs", a.abs()),
        ("copysign", a.copysign(b)),
        ("min", a.min(b)),
        ("max", a.max(b)),
        ("less", flag(a.less(b))),
        ("less_equal", flag(a.less_equal(b))),
        ("is_finite", flag(a.is_finite())),
        ("and", flag(a.less(b).and(a.is_finite()))),
        ("or", flag(a.less(b).or(b.is_finite()))),
        ("not", flag(a.less(b).not())),
        ("any", S::constant(f64::from(u8::from(a.less(a).any())))),
        ("all", S::constant(f64::from(u8::from(a.less(a).not().all())))),
    ]
}

/// Runs [`all_operations`] and gives lanes of every result.
struct Operations<'a, E>(&'a [E], &'a [E]);

impl<E: Element> LaneKernel<E> for Operations<'_, E> {
    type Output = Vec<(&'static str, Vec<E>)>;
    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) -> Self::Output {
        let mut all: Vec<(&'static str, Vec<E>)> = Vec::new();
        let chunks = self.0.chunks(P::LANES).zip(self.1.chunks(P::LANES));
        for (a, b) in chunks {
            let (a, b) = (P::load(a), P::load(b));
            let single = all_operations(a, b);
            let pairs = all_operations(Pair(a, b), Pair(b, a));
            for (k, ((name, value), (_, pair))) in single.into_iter().zip(pairs).enumerate() {
                if k == all.len() {
                    all.push((name, Vec::new()));
                }
                let lanes = value.to_lanes();
                for (one, two) in lanes.as_ref().iter().zip(pair.0.to_lanes().as_ref()) {
                    assert!(same(*one, *two), "{name} in a pair");
                }
                all[k].1.extend_from_slice(lanes.as_ref());
            }
        }
        all
    }
}

/// Equal bits, or both NaN.
fn same<E: Element>(a: E, b: E) -> bool {
    let (a, b): (f64, f64) = (a.into(), b.into());
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

fn operations_match<E: Element>(extremes: [f64; 4]) {
    let mut numbers: Vec<E> = [0.0, -0.0, 1.0, -1.0, 0.5, 2.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN]
        .iter()
        .chain(&extremes)
        .map(|&x| E::constant(x))
        .collect();
    numbers.extend((0..19).map(|i| E::constant((f64::from(i) - 9.3) * 0.37)));
    let count = numbers.len();
    let (a, b): (Vec<E>, Vec<E>) =
        (0..count * count).map(|k| (numbers[k / count], numbers[k % count])).unzip();
    let (portable, best) = (dispatch_portable(Operations(&a, &b)), dispatch(Operations(&a, &b)));
    for (i, (&a, &b)) in a.iter().zip(&b).enumerate() {
        for (k, (name, expected)) in all_operations(a, b).into_iter().enumerate() {
            for results in [&portable, &best] {
                let lane = results[k].1[i];
                assert!(same(lane, expected), "{name}({a:?}, {b:?}) = {expected:?}, in lanes {lane:?}");
            }
        }
    }
}

#[test]
fn every_operation_gives_the_bits_of_the_single_number() {
    operations_match::<f64>([1e-310, 1e300, -1e-300, f64::MIN_POSITIVE]);
    operations_match::<f32>([1e-40, 1e38, -1e-38, f64::from(f32::MIN_POSITIVE)]);
}

/// Powers, and a·b + c, where lanes may round otherwise.
struct Powers<E>(Vec<E>);

impl<E: Element> LaneKernel<E> for Powers<E> {
    type Output = Vec<[f64; 2]>;
    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) -> Self::Output {
        let mut results = Vec::new();
        for chunk in self.0.chunks(P::LANES) {
            let a = P::load(chunk);
            for exponent in [-5, -1, 0, 1, 2, 3, 12] {
                let (power, sum) = (a.powi(exponent).to_lanes(), a.mul_add(a, P::constant(-1.0)).to_lanes());
                for lane in 0..P::LANES {
                    let x: f64 = chunk[lane].into();
                    let error = power.as_ref()[lane].into() / x.powi(exponent) - 1.0;
                    results.push([error, sum.as_ref()[lane].into() - (x * x - 1.0)]);
                }
            }
        }
        results
    }
}

#[test]
fn powers_and_fused_sums_are_right_to_rounding() {
    let numbers = |count: u32| (0..count).map(|i| 0.4 + 0.1 * f64::from(i));
    for [power, sum] in dispatch(Powers(numbers(16).collect())) {
        assert!(power.abs() < 12.0 * f64::EPSILON && sum.abs() < 3.0 * f64::EPSILON);
    }
    for [power, sum] in dispatch(Powers(numbers(16).map(|x| x as f32).collect())) {
        assert!(power.abs() < 12.0 * <f32 as Scalar>::EPSILON);
        assert!(sum.abs() < 3.0 * <f32 as Scalar>::EPSILON);
    }
}

#[test]
fn reciprocal_powers_of_two_bring_every_normal_number_between_one_and_two() {
    for exponent in -1022..1023 {
        let x = 2.0_f64.powi(exponent) * 1.7;
        assert_eq!(x * x.reciprocal_power_of_two(), 1.7);
        assert_eq!(-x * (-x).reciprocal_power_of_two(), -1.7);
    }
    for exponent in -126..127 {
        let x = 2.0_f32.powi(exponent) * 1.7;
        assert_eq!(x * x.reciprocal_power_of_two(), 1.7);
    }
    for x in [f64::MAX, f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
        let factor = x.reciprocal_power_of_two();
        assert!(factor <= 0.0 || factor.is_nan(), "{x} gives {factor}");
    }
    assert_eq!(0.0_f64.reciprocal_power_of_two(), 2.0_f64.powi(1023));
}

/// Short chunks, transposition, matrices to lanes and back.
struct Movement<E>(Vec<E>);

impl<E: Element> LaneKernel<E> for Movement<E> {
    type Output = ();
    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) {
        let data = &self.0;
        assert_eq!(P::LANES * size_of::<E>(), 32);
        for count in 0..=P::LANES {
            let packet = P::load_or(&data[..count], E::constant(-7.0));
            for (lane, &value) in packet.to_lanes().as_ref().iter().enumerate() {
                assert_eq!(value, if lane < count { data[lane] } else { E::constant(-7.0) });
            }
            let mut target = vec![E::constant(0.0); count];
            P::load(data).store_prefix(&mut target);
            assert_eq!(target, data[..count]);
        }
        let mut block: Vec<P> = (0..P::LANES).map(|i| P::load(&data[i * P::LANES..])).collect();
        P::transpose(&mut block);
        for (i, packet) in block.iter().enumerate() {
            for (j, &value) in packet.to_lanes().as_ref().iter().enumerate() {
                assert_eq!(value, data[j * P::LANES + i]);
            }
        }
        let (repeated, halves) =
            (P::load_repeated(&data[1..5]), P::halves(P::load(data), P::load(&data[30..])));
        for lane in 0..P::LANES {
            assert_eq!(repeated.to_lanes().as_ref()[lane], data[1 + lane % 4]);
            let from = if lane < P::LANES / 2 { lane } else { 30 + lane };
            assert_eq!(halves.to_lanes().as_ref()[lane], data[from]);
        }
        let matrices: Vec<Matrix3<E>> =
            (0..P::LANES).map(|k| tensor::from_entries(|i, j| data[9 * k + 3 * i + j])).collect();
        let packed = load_matrices::<P>(&matrices);
        for i in 0..3 {
            for j in 0..3 {
                for (k, &value) in packed[(i, j)].to_lanes().as_ref().iter().enumerate() {
                    assert_eq!(value, matrices[k][(i, j)]);
                }
            }
        }
        for count in 0..=P::LANES {
            let mut back = vec![tensor::zero::<E>(); count];
            store_matrices(&packed, back.iter_mut());
            assert_eq!(back, matrices[..count]);
        }
    }
}

#[test]
fn numbers_come_back_from_lanes_where_they_belong() {
    let numbers: Vec<f64> = (0..72).map(f64::from).collect();
    let singles: Vec<f32> = (0..72).map(|i: u16| f32::from(i)).collect();
    dispatch(Movement(numbers.clone()));
    dispatch_portable(Movement(numbers));
    dispatch(Movement(singles.clone()));
    dispatch_portable(Movement(singles));
}

/// Every pattern of true and false lanes, as bits and as what it keeps.
struct Masks<E>(Vec<E>);

impl<E: Element> LaneKernel<E> for Masks<E> {
    type Output = ();
    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) {
        let numbers = P::load(&self.0);
        for pattern in 0..1_u32 << P::LANES {
            let mut signs = E::Lanes::default();
            for (lane, sign) in signs.as_mut().iter_mut().enumerate() {
                *sign = E::constant(if pattern >> lane & 1 == 1 { -1.0 } else { 1.0 });
            }
            let mask = P::from_lanes(signs).less(P::constant(0.0));
            assert_eq!(P::bits(mask), pattern);
            let kept = numbers.keep(mask).to_lanes();
            for (lane, (kept, number)) in kept.as_ref().iter().zip(&self.0).enumerate() {
                let expected = if pattern >> lane & 1 == 1 { *number } else { E::constant(0.0) };
                assert!(same(*kept, expected), "{pattern:b}, lane {lane}: {kept:?}");
            }
        }
    }
}

#[test]
fn masks_are_bits_and_keep_what_is_theirs() {
    fn check<E: Element>() {
        let numbers: Vec<E> =
            [f64::NAN, f64::INFINITY, -0.0, 1.5, -2.5, 1e-40, 7.0, f64::NEG_INFINITY].map(E::constant).into();
        dispatch(Masks(numbers.clone()));
        dispatch_portable(Masks(numbers));
    }
    check::<f32>();
    check::<f64>();
}

#[test]
fn whole_numbers_are_their_indices() {
    for index in (0..=1_usize << 21).step_by(1237).chain([1, 2, (1 << 21) - 1, 1 << 21]) {
        assert_eq!((index as f32).to_index(), index);
        assert_eq!((index as f64).to_index(), index);
    }
    // Whatever they are, no panic.
    let _ = [f32::NAN.to_index(), f32::INFINITY.to_index(), (-1.5_f32).to_index(), 1e30_f32.to_index()];
}

/// A short slice must not be read past its end.
struct ShortLoad;

impl LaneKernel<f32> for ShortLoad {
    type Output = ();
    #[inline(always)]
    fn run<P: Packet<Element = f32>>(self) {
        let _ = P::load(&[1.0; 7]);
    }
}

#[test]
#[should_panic(expected = "range end index 8 out of range")]
fn loading_too_few_elements_panics() {
    dispatch(ShortLoad);
}
