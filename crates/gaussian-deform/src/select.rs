//! Selecting matter: which Gaussians are simulated.

use crate::error::SplatError;

/// Whether a list of Gaussians is strictly ascending and within the scene.
pub(crate) fn check_ascending(list: &[u32], count: usize) -> Result<(), SplatError> {
    let bad = |entry: usize| list[entry] as usize >= count || (entry > 0 && list[entry - 1] >= list[entry]);
    match (0..list.len()).find(|&entry| bad(entry)) {
        None => Ok(()),
        Some(entry) => Err(SplatError::BadSelection { entry, splat: list[entry], count }),
    }
}
