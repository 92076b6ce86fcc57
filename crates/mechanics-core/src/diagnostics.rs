//! Conserved quantities of moving points: mass, momentum, angular momentum, kinetic energy.
//!
//! They are sums of many terms of either sign whose total often should be zero, so they are compensated (see
//! [`CompensatedSum`]) within chunks of a fixed size, in index order, and then over the chunks: the error of the
//! summation itself is about one rounding of the total however many points there are, and the bits do not depend on
//! the number of threads. What remains is the rounding of each term, a few 1e-16 of its size.
//!
//! NaN and infinite input gives NaN or infinite output.

mod compensated_sum;

pub use compensated_sum::CompensatedSum;

use crate::parallel::map_chunks;
use crate::tensor::Vec3;

/// Points per chunk: fixed, because the bits of the result depend on it.
const CHUNK: usize = 4096;

/// Σ m \[kg\].
pub fn total_mass(masses: &[f64]) -> f64 {
    sum_over(masses.len(), |i| [masses[i]])[0]
}

/// The centre of mass Σ m x / Σ m \[m\]; `None` if the total mass is zero.
///
/// Accurate to a few 1e-16 of the largest |x| when all masses have one sign.
///
/// # Panics
/// If the lengths differ.
pub fn centre_of_mass(masses: &[f64], positions: &[Vec3]) -> Option<Vec3> {
    require_equal_lengths(masses, positions, "position");
    let total = total_mass(masses);
    let moment = Vec3::from(sum_over(masses.len(), |i| (masses[i] * positions[i]).into()));
    (total != 0.0).then(|| moment / total)
}

/// The linear momentum Σ m v \[kg m/s\].
///
/// # Panics
/// If the lengths differ.
pub fn linear_momentum(masses: &[f64], velocities: &[Vec3]) -> Vec3 {
    require_equal_lengths(masses, velocities, "velocity");
    Vec3::from(sum_over(masses.len(), |i| (masses[i] * velocities[i]).into()))
}

/// The angular momentum Σ m (x − `about`) × v about a point fixed in space \[kg m²/s\].
///
/// About the centre of mass it does not depend on a common velocity of all points.
///
/// # Panics
/// If the lengths differ.
pub fn angular_momentum(masses: &[f64], positions: &[Vec3], velocities: &[Vec3], about: &Vec3) -> Vec3 {
    require_equal_lengths(masses, positions, "position");
    require_equal_lengths(masses, velocities, "velocity");
    let term = |i: usize| masses[i] * (positions[i] - about).cross(&velocities[i]);
    Vec3::from(sum_over(masses.len(), |i| term(i).into()))
}

/// The kinetic energy Σ ½ m |v|² \[J\].
///
/// # Panics
/// If the lengths differ.
pub fn kinetic_energy(masses: &[f64], velocities: &[Vec3]) -> f64 {
    require_equal_lengths(masses, velocities, "velocity");
    sum_over(masses.len(), |i| [0.5 * masses[i] * velocities[i].norm_squared()])[0]
}

/// Σ `term(i)`, each component compensated.
fn sum_over<const N: usize>(count: usize, term: impl Fn(usize) -> [f64; N] + Sync) -> [f64; N] {
    let chunks = map_chunks(count, CHUNK, |range| {
        let mut sums = [CompensatedSum::new(); N];
        for i in range {
            let term = term(i);
            for k in 0..N {
                sums[k].add(term[k]);
            }
        }
        sums
    });
    let mut sums = [CompensatedSum::new(); N];
    for chunk in chunks {
        for k in 0..N {
            sums[k].add_sum(&chunk[k]);
        }
    }
    sums.map(|sum| sum.value())
}

fn require_equal_lengths(masses: &[f64], vectors: &[Vec3], name: &str) {
    assert_eq!(masses.len(), vectors.len(), "one mass per {name}");
}
