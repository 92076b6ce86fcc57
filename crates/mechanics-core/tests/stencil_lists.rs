//! Sums over borrowed lists: the bits of the plain loop, for any number of threads and any order of elements.
#![allow(clippy::unwrap_used)]

use mechanics_core::parallel::with_threads;
use mechanics_core::point_map::PointMap;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilLists};
use mechanics_core::tensor::{Mat3, Vec3};

/// ½ kₑ ‖Σ x‖² with a stiffness for each element.
struct Pull(Vec<f64>);

impl<const N: usize> Stencil<N> for Pull {
    fn value(&self, element: usize, x: &[Vec3; N]) -> f64 {
        0.5 * self.0[element] * x.iter().sum::<Vec3>().norm_squared()
    }

    fn gradient(&self, element: usize, x: &[Vec3; N]) -> [Vec3; N] {
        [x.iter().sum::<Vec3>() * self.0[element]; N]
    }

    fn hessian(&self, element: usize, _: &[Vec3; N], _: Projection) -> LocalHessian<N> {
        [[Mat3::identity() * self.0[element]; N]; N]
    }
}

fn number(k: usize, seed: u64) -> f64 {
    let mut z = seed.wrapping_add((k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

const POINTS: usize = 4000;

/// Three points near one another of the first half, and the one that lies on them of the second: contact of two sheets.
fn stacked(count: usize) -> Vec<[u32; 4]> {
    let element = |k: usize| {
        let a = k * (POINTS / 2 - 3) / count;
        [a, a + 1, a + 2, POINTS / 2 + a].map(|p| p as u32)
    };
    (0..count).map(element).collect()
}

/// Two points anywhere.
fn wild(count: usize) -> Vec<[u32; 2]> {
    let pair = |k: usize| {
        let a = (number(k, 5) * POINTS as f64) as u32;
        [a, (a + 1 + (number(k, 6) * (POINTS - 1) as f64) as u32) % POINTS as u32]
    };
    (0..count).map(pair).collect()
}

fn stiffness(count: usize) -> Pull {
    Pull((0..count).map(|k| number(k, 9) - 0.3).collect())
}

/// Bits of the energy, the gradient and the Hessian.
fn sums(stacked: &[[u32; 4]], wild: &[[u32; 2]], x: &[Vec3]) -> (u64, Vec<[u64; 3]>, Vec<u64>) {
    let lists = StencilLists::new()
        .with(stiffness(stacked.len()), stacked)
        .with(stiffness(0), &[] as &[[u32; 3]])
        .with(stiffness(wild.len()), wild);
    let mut gradient: Vec<Vec3> = x.iter().map(|x| x * 0.1).collect();
    lists.add_gradient(x, &mut gradient);
    let mut assembly = Assembly::new(&PointMap::identity(x.len()));
    let mut assembler = assembly.begin(&PointMap::identity(x.len()));
    lists.add_hessian(x, Projection::None, &mut assembler);
    let blocks = assembler.finish().blocks().iter().flatten().map(|entry| entry.to_bits()).collect();
    let bits = gradient.iter().map(|g| [g.x, g.y, g.z].map(f64::to_bits)).collect();
    (lists.value(x).to_bits(), bits, blocks)
}

#[test]
fn many_threads_give_the_bits_of_the_plain_loop() {
    let x: Vec<Vec3> = (0..POINTS).map(|k| Vec3::new(number(k, 1), number(k, 2), number(k, 3))).collect();
    // Short, long, and so long that a border in wild order is not kept.
    for [count, loose] in [[40, 7], [3001, 200], [5000, 3000], [100, 100_000]] {
        let (stacked, wild) = (stacked(count), wild(loose));
        let (ours, theirs) = (stiffness(count), stiffness(loose));
        let mut plain: Vec<Vec3> = x.iter().map(|x| x * 0.1).collect();
        for (e, points) in stacked.iter().enumerate() {
            let parts = ours.gradient(e, &points.map(|p| x[p as usize]));
            points.iter().zip(parts).for_each(|(&p, part)| plain[p as usize] += part);
        }
        for (e, points) in wild.iter().enumerate() {
            let parts = theirs.gradient(e, &points.map(|p| x[p as usize]));
            points.iter().zip(parts).for_each(|(&p, part)| plain[p as usize] += part);
        }
        let plain: Vec<[u64; 3]> = plain.iter().map(|g| [g.x, g.y, g.z].map(f64::to_bits)).collect();
        let one = with_threads(1, || sums(&stacked, &wild, &x));
        assert_eq!(one.1, plain, "{count} and {loose}, one thread");
        for threads in [2, 3, 8] {
            let many = with_threads(threads, || sums(&stacked, &wild, &x));
            assert!(many == one, "{count} and {loose}, {threads} threads");
        }
    }
}
