//! Whether two simplices share a point, in rational arithmetic and by another way than the crate's: the convex hulls meet
//! if 0 is a convex combination of differences, which is decided by solving for barycentric coordinates on every pair of
//! faces (a face is a subset of affinely independent corners).

use mechanics_core::tensor::Vec3;
use num_bigint::BigInt;
use num_rational::Ratio;
use num_traits::{Signed, Zero};

type Number = Ratio<BigInt>;

fn exact(p: &Vec3) -> [Number; 3] {
    [0, 1, 2].map(|k| Ratio::from_float(p[k]).unwrap())
}

/// Do the convex hulls of `first` and `second` share a point?
///
/// They do exactly if Σ λᵢ aᵢ = Σ μⱼ bⱼ, Σ λᵢ = Σ μⱼ = 1 has a solution λ, μ ≥ 0; and then it has one at a vertex of that
/// polyhedron, where the columns (aᵢ, 1, 0), (−bⱼ, 0, 1) with positive weight are linearly independent (the fundamental
/// theorem of linear programming). So all subsets of corners are tried.
pub(crate) fn hulls_meet(first: &[Vec3], second: &[Vec3]) -> bool {
    let one = Number::from_integer(1.into());
    let column = |p: &Vec3, sign: i32| {
        let sign = Number::from_integer(sign.into());
        let [a, b] =
            if sign.is_positive() { [one.clone(), Zero::zero()] } else { [Zero::zero(), one.clone()] };
        let mut column: Vec<Number> = exact(p).into_iter().map(|c| c * &sign).collect();
        column.extend([a, b]);
        column
    };
    let columns: Vec<Vec<Number>> =
        first.iter().map(|p| column(p, 1)).chain(second.iter().map(|p| column(p, -1))).collect();
    (1..1u32 << columns.len()).any(|subset| {
        let chosen: Vec<&Vec<Number>> =
            (0..columns.len()).filter(|i| subset >> i & 1 == 1).map(|i| &columns[i]).collect();
        unique_solution(&chosen).is_some_and(|weights| weights.iter().all(|w| !w.is_negative()))
    })
}

/// The weights w with Σ wᵢ columnᵢ = (0, 0, 0, 1, 1), if the columns are independent and there are such weights.
fn unique_solution(columns: &[&Vec<Number>]) -> Option<Vec<Number>> {
    let count = columns.len();
    let one = || Number::from_integer(1.into());
    let right = [Zero::zero(), Zero::zero(), Zero::zero(), one(), one()];
    let mut rows: Vec<Vec<Number>> =
        (0..5).map(|r| columns.iter().map(|c| c[r].clone()).chain([right[r].clone()]).collect()).collect();
    for k in 0..count {
        let pivot = (k..5).find(|&r| !rows[r][k].is_zero())?;
        rows.swap(k, pivot);
        for r in 0..5 {
            if r != k && !rows[r][k].is_zero() {
                let factor = &rows[r][k] / &rows[k][k];
                for c in k..=count {
                    let change = &factor * &rows[k][c];
                    rows[r][c] -= change;
                }
            }
        }
    }
    let consistent = rows[count.min(5)..].iter().all(|row| row[count].is_zero());
    consistent.then(|| (0..count).map(|k| &rows[k][count] / &rows[k][k]).collect())
}
