use mechanics_core::decomposition::*;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::*;
fn frac<S: Scalar + Into<f64>, const K: usize>() {
    let mut state = 1u64;
    let mut number = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let n = 200000;
    let mut bad = [0; 6];
    let mut worst = 0.0f64;
    for _ in 0..n {
        let e: [f64; 9] = std::array::from_fn(|_| number());
        let f: Matrix3<S> = from_entries(|i, j| S::constant(e[3 * i + j]));
        let d = svd_with_sweeps::<S, K>(&f);
        let t = transpose_product(&d.u, &product(&f, &d.v));
        let c = columns(&t);
        let off = [c[1][0], c[2][0], c[2][1]]
            .map(|x| {
                let x: f64 = x.into();
                x.abs() / d.sigma[0].into() / S::EPSILON
            })
            .into_iter()
            .fold(0.0, f64::max);
        worst = worst.max(off);
        for (k, t) in [1.0, 2.0, 3.0, 4.0, 8.0, 1000.0].iter().enumerate() {
            if off > *t {
                bad[k] += 1;
            }
        }
    }
    println!(
        "{} sweeps {K}: worst {worst:.1e} eps, fractions beyond 1,2,3,4,8,1000: {:?}",
        std::any::type_name::<S>(),
        bad.map(|b| b as f64 / n as f64)
    );
}
fn main() {
    frac::<f32, 1>();
    frac::<f32, 2>();
    frac::<f32, 3>();
    frac::<f32, 4>();
    frac::<f64, 2>();
    frac::<f64, 3>();
    frac::<f64, 4>();
    frac::<f64, 5>();
}
