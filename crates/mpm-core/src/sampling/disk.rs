//! Poisson disk sampling by Bridson's method.

use super::random::SiteRandom;

/// Attempts around a place before it is given up.
const ATTEMPTS: usize = 30;

/// A background grid whose cells hold one place at most: their diagonal is the distance.
struct Cells<const D: usize> {
    low: [f64; D],
    edge: f64,
    counts: [usize; D],
    /// Number of the place in each cell, or `u32::MAX`.
    places: Vec<u32>,
}

impl<const D: usize> Cells<D> {
    fn new(low: &[f64; D], high: &[f64; D], distance: f64) -> Self {
        let edge = distance / (D as f64).sqrt();
        let counts = std::array::from_fn(|a| ((high[a] - low[a]) / edge) as usize + 1);
        Self { low: *low, edge, counts, places: vec![u32::MAX; counts.iter().product()] }
    }

    fn coordinates(&self, place: &[f64; D]) -> [usize; D] {
        std::array::from_fn(|a| (((place[a] - self.low[a]) / self.edge) as usize).min(self.counts[a] - 1))
    }

    fn index(&self, cell: &[usize; D]) -> usize {
        (0..D).fold(0, |index, a| index * self.counts[a] + cell[a])
    }

    /// Whether no place is closer than `distance`.
    fn is_free(&self, place: &[f64; D], sites: &[[f64; D]], distance: f64) -> bool {
        let cell = self.coordinates(place);
        // Two cells away along each axis: 2 edges are at least the distance for D ≤ 4.
        (0..5_usize.pow(D as u32)).all(|k| {
            let near: [i64; D] =
                std::array::from_fn(|a| cell[a] as i64 + (k / 5_usize.pow(a as u32) % 5) as i64 - 2);
            if (0..D).any(|a| near[a] < 0 || near[a] >= self.counts[a] as i64) {
                return true;
            }
            match self.places[self.index(&near.map(|c| c as usize))] {
                u32::MAX => true,
                other => squared(place, &sites[other as usize]) >= distance * distance,
            }
        })
    }
}

fn squared<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|k| (a[k] - b[k]).powi(2)).sum()
}

/// Places within a box.
pub(super) fn sites<const D: usize>(
    low: &[f64; D],
    high: &[f64; D],
    distance: f64,
    seed: u64,
) -> Vec<[f64; D]> {
    let mut random = SiteRandom::new(seed, &[0.0; D]);
    let mut cells = Cells::new(low, high, distance);
    let first: [f64; D] = std::array::from_fn(|a| low[a] + (high[a] - low[a]) * random.uniform());
    let mut sites = vec![first];
    let at = cells.index(&cells.coordinates(&first));
    cells.places[at] = 0;
    let mut active = vec![0_u32];
    while !active.is_empty() {
        let chosen = (random.uniform() * active.len() as f64) as usize;
        let centre = sites[active[chosen] as usize];
        let found = (0..ATTEMPTS).find_map(|_| {
            let place = around(&centre, distance, &mut random);
            let inside = (0..D).all(|a| low[a] <= place[a] && place[a] <= high[a]);
            (inside && cells.is_free(&place, &sites, distance)).then_some(place)
        });
        match found {
            Some(place) => {
                let at = cells.index(&cells.coordinates(&place));
                cells.places[at] = sites.len() as u32;
                active.push(sites.len() as u32);
                sites.push(place);
            }
            None => {
                active.swap_remove(chosen);
            }
        }
    }
    sites
}

/// A random place between one and two distances away: uniform in the box around, until it falls in the ring.
fn around<const D: usize>(centre: &[f64; D], distance: f64, random: &mut SiteRandom) -> [f64; D] {
    loop {
        let offset: [f64; D] = std::array::from_fn(|_| 4.0 * random.uniform() - 2.0);
        let square: f64 = offset.iter().map(|x| x * x).sum();
        if (1.0..4.0).contains(&square) {
            return std::array::from_fn(|a| centre[a] + distance * offset[a]);
        }
    }
}
