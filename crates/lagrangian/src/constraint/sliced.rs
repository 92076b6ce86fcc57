//! Constraints of run-time size, differentiated in as few passes as their sparsity allows.

use super::set::moving;
use super::{ConstraintSet, ExpansionOf, Layout, SlicedHolonomic};
use mechanics_core::jet::Jet1;
use std::ops::Range;

/// Directions of one pass.
const WIDTH: usize = 8;
type Jet = Jet1<f64, WIDTH>;

/// A [`SlicedHolonomic`] with its derivatives.
///
/// The Jacobian is compressed: two columns that no constraint has in common share one direction of differentiation,
/// and a pass of jets takes eight directions at once. A chain needs four directions (two coordinates of two
/// neighbours) however long it is, so its Jacobian costs one pass.
///
/// Which constraint mentions which coordinate is found at construction: directions are seeded with NaN, which the
/// chain rule carries to everything that mentions the seeded number (0 · NaN is NaN) and to nothing else. Where a
/// constraint *selects* between branches that mention different coordinates, only the branch taken at the probing
/// points is seen: write such a constraint so that both branches mention the same (add `x.scale(0.0)`).
///
/// # Reference
/// Curtis, Powell & Reid 1974, *On the estimation of sparse Jacobian matrices*.
#[derive(Clone, Debug, PartialEq)]
pub struct SlicedConstraints<H> {
    holonomic: H,
    /// For every constraint, the columns it mentions, ascending; column `dimension` is time.
    mentions: Vec<Vec<usize>>,
    /// For every constraint, the range of coordinates it mentions.
    support: Vec<Range<usize>>,
    /// For every column, time included, its direction.
    direction: Vec<usize>,
    /// The number of directions.
    directions: usize,
}

impl<H: SlicedHolonomic> SlicedConstraints<H> {
    /// The derivatives of `holonomic`.
    pub fn new(holonomic: H) -> Self {
        let mentions = mentions(&holonomic);
        let direction = colour(&mentions, holonomic.dimension() + 1);
        let directions = direction.iter().map(|d| d + 1).max().unwrap_or(0);
        let support = mentions.iter().map(|row| span(row, holonomic.dimension())).collect();
        Self { holonomic, mentions, support, direction, directions }
    }

    /// The constraints as the user wrote them.
    pub fn holonomic(&self) -> &H {
        &self.holonomic
    }

    /// How many directions the Jacobian is differentiated in: a pass over the constraints takes eight.
    pub fn directions(&self) -> usize {
        self.directions
    }
}

/// For every constraint the columns it mentions, by NaN in the seed of eight columns at a time.
fn mentions<H: SlicedHolonomic>(holonomic: &H) -> Vec<Vec<usize>> {
    let (n, count) = (holonomic.dimension(), holonomic.count());
    let mut mentions = vec![Vec::new(); count];
    // Any point will do; fractional parts of multiples of the golden ratio avoid symmetric ones.
    let mut q: Vec<Jet> =
        (0..=n).map(|i| Jet::from_value(0.5 + (i as f64 * 0.618_033_988_75).fract())).collect();
    let mut phi = vec![Jet::from_value(0.0); count];
    for start in (0..=n).step_by(WIDTH) {
        let block = start..(start + WIDTH).min(n + 1);
        for j in block.clone() {
            q[j].gradient[j - start] = f64::NAN;
        }
        holonomic.constraint_into(&q[..n], q[n], &mut phi);
        for (k, value) in phi.iter().enumerate() {
            mentions[k].extend(block.clone().filter(|j| value.gradient[j - start] != 0.0));
        }
        for j in block {
            q[j].gradient[j - start] = 0.0;
        }
    }
    mentions
}

/// From the first to the last of the columns below `n`, which ascend.
fn span(columns: &[usize], n: usize) -> Range<usize> {
    let mut coordinates = columns.iter().copied().filter(|&j| j < n);
    let Some(first) = coordinates.next() else { return 0..0 };
    first..coordinates.next_back().unwrap_or(first) + 1
}

/// The smallest direction, column by column, that no column of a common constraint has.
fn colour(mentions: &[Vec<usize>], columns: usize) -> Vec<usize> {
    let mut rows_of = vec![Vec::new(); columns];
    for (k, row) in mentions.iter().enumerate() {
        row.iter().for_each(|&j| rows_of[j].push(k));
    }
    let mut taken: Vec<Vec<usize>> = vec![Vec::new(); mentions.len()];
    (0..columns)
        .map(|j| {
            let mut colour = 0;
            while rows_of[j].iter().any(|&k| taken[k].contains(&colour)) {
                colour += 1;
            }
            rows_of[j].iter().for_each(|&k| taken[k].push(colour));
            colour
        })
        .collect()
}

impl<H: SlicedHolonomic> ConstraintSet for SlicedConstraints<H> {
    type Coordinates = Vec<f64>;
    type Multipliers = Vec<f64>;
    type Jacobian = Vec<f64>;
    const LAYOUT: Layout = Layout::Envelope;

    #[inline]
    fn shape(&self) -> (usize, usize) {
        (self.direction.len() - 1, self.mentions.len())
    }

    fn expand(&self, t: f64, q: &Vec<f64>, out: &mut ExpansionOf<Self>) {
        let n = self.dimension();
        assert_eq!(q.len(), n, "one number per coordinate");
        let mut phi = vec![Jet::from_value(0.0); self.count()];
        out.rate.fill(0.0);
        for first in (0..self.directions.max(1)).step_by(WIDTH) {
            let seed = |j: usize, x: f64| {
                let mut jet = Jet::from_value(x);
                if let Some(d) = self.direction[j].checked_sub(first).filter(|&d| d < WIDTH) {
                    jet.gradient[d] = 1.0;
                }
                jet
            };
            let seeded: Vec<Jet> = q.iter().enumerate().map(|(j, &x)| seed(j, x)).collect();
            self.holonomic.constraint_into(&seeded, seed(n, t), &mut phi);
            for (k, row) in self.mentions.iter().enumerate() {
                out.value[k] = phi[k].value;
                for &j in row {
                    let Some(d) = self.direction[j].checked_sub(first).filter(|&d| d < WIDTH) else {
                        continue;
                    };
                    if j == n {
                        out.rate[k] = phi[k].gradient[d];
                    } else {
                        out.jacobian[k * n + j] = phi[k].gradient[d];
                    }
                }
            }
        }
    }

    fn curve(&self, t: f64, q: &Vec<f64>, v: &Vec<f64>, out: &mut Vec<f64>) {
        let along: Vec<_> = q.iter().zip(v).map(|(&q, &v)| moving(q, v)).collect();
        let mut phi = vec![moving(0.0, 0.0); self.count()];
        self.holonomic.constraint_into(&along, moving(t, 1.0), &mut phi);
        out.iter_mut().zip(&phi).for_each(|(out, phi)| *out = phi.hessian(0, 0));
    }

    #[inline]
    fn support(&self, index: usize) -> Range<usize> {
        self.support[index].clone()
    }
}
