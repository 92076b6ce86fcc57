//! Two edges, with the mollifier where they are nearly parallel.

use super::planar::LineLine;
use super::run::{LANES, Rule, Run};
use super::{PairLaw, eigen};
use crate::barrier::Barrier;
use crate::distance::{EdgeEdgeMollifier, Region, edge_edge_region};
use mechanics_core::lanes::{self, LaneKernel, Packet};
use mechanics_core::potential::Demand;
use mechanics_core::projection::Projection;
use mechanics_core::stencil::{LocalHessian, Stencil};
use mechanics_core::tensor::{Mat3, Vec3};

/// Pairs of the edges x₀x₁ and x₂x₃.
///
/// Beyond the mollifier's threshold, c = |e₁ × e₂|² ≥ ε, their lines are taken to be closest between the ends, as the contact
/// set has found: E = w κ b(s) with s of the two lines. Below it E = w κ m(c) b(s), where s is of the two bounded edges:
/// where an end of one of them is closest, its derivatives are those of the point–edge or point–point primitive, over
/// the same four points, and the mollifier makes up for the jumps between those ([`edge_edge_region`] at x says which).
///
/// The Hessian of a mollified pair has full rank but for translations; it is projected numerically in the nine
/// dimensions that are left. Gauss–Newton keeps m and leaves out its change.
///
/// Domain: s > 0, and edges that are not of zero length.
#[derive(Clone, Copy, Debug)]
pub struct EdgeEdgePairs<'a, B: ?Sized> {
    /// Barrier and stiffness.
    pub law: PairLaw<'a, B>,
    /// One weight for each pair.
    pub weights: &'a [f64],
    /// One mollifier for each pair: its threshold ε \[m⁴\].
    pub mollifiers: &'a [EdgeEdgeMollifier],
    /// The closest features of each pair, where they are known (the area-weighted contact set takes others where it
    /// subtracts); empty to have them found.
    pub regions: &'a [Region],
}

/// The parts of one mollified energy.
struct Mollified {
    region: Region,
    s: f64,
    mollifier: EdgeEdgeMollifier,
}

impl<B: Barrier + ?Sized> EdgeEdgePairs<'_, B> {
    /// The pairs of a run that are mollified.
    fn mollified(&self, first: usize, x: &[[Vec3; 4]]) -> impl Iterator<Item = (usize, Mollified)> {
        let mollifiers = &self.mollifiers[first..first + x.len()];
        x.iter().zip(mollifiers).enumerate().filter(|(_, (x, mollifier))| mollifier.is_active(x)).map(
            move |(k, (x, &mollifier))| {
                let region = self.regions.get(first + k).copied().unwrap_or_else(|| edge_edge_region(x));
                (k, Mollified { region, s: region.value(x), mollifier })
            },
        )
    }
}

impl Mollified {
    fn gradient<B: Barrier + ?Sized>(&self, law: PairLaw<'_, B>, weight: f64, x: &[Vec3; 4]) -> [Vec3; 4] {
        let by_distance = law.first(weight, self.s) * self.mollifier.value(x);
        let by_angle = law.energy(weight, self.s);
        let (distance, angle) = (self.region.gradient(x), self.mollifier.gradient(x));
        std::array::from_fn(|i| distance[i] * by_distance + angle[i] * by_angle)
    }

    /// The Hessian, the full one not yet projected:
    /// w κ [m b″ ∇s∇sᵀ + m b′ ∇²s + b′ (∇s∇mᵀ + ∇m∇sᵀ) + b ∇²m].
    fn hessian<B: Barrier + ?Sized>(
        &self,
        law: PairLaw<'_, B>,
        weight: f64,
        x: &[Vec3; 4],
        rule: Rule,
    ) -> LocalHessian<4> {
        let factor = weight * law.stiffness;
        let [first, second] = law.barrier.first_and_second(self.s);
        let m = self.mollifier.value(x);
        let slope = self.region.gradient(x);
        if rule.is_gauss_newton() {
            // d²b/dd² ∇d∇dᵀ = (b″ + b′/(2s)) ∇s∇sᵀ.
            let along = rule.projection.apply(factor * m * (second + 0.5 * first / self.s));
            return blocks(|i, j| slope[i] * slope[j].transpose() * along);
        }
        let (curved, turn, turned) =
            (self.region.hessian(x), self.mollifier.gradient(x), self.mollifier.hessian(x));
        let energy = law.barrier.value(self.s);
        blocks(|i, j| {
            let mixed = slope[i] * turn[j].transpose() + turn[i] * slope[j].transpose();
            (slope[i] * slope[j].transpose() * (m * second)
                + curved[i][j] * (m * first)
                + mixed * first
                + turned[i][j] * energy)
                * factor
        })
    }
}

fn blocks(block: impl Fn(usize, usize) -> Mat3) -> LocalHessian<4> {
    std::array::from_fn(|i| std::array::from_fn(|j| if j <= i { block(i, j) } else { Mat3::zeros() }))
}

/// Pairs from a multiple of which on an [`Assembler`](mechanics_core::sparse::Assembler) asks for Hessians.
const GROUP: usize = 8;

/// Rows: an orthonormal basis of the weights on four points that sum to zero, times two.
const DIFFERENCES: [[f64; 4]; 3] = [[1.0, 1.0, -1.0, -1.0], [1.0, -1.0, 1.0, -1.0], [1.0, -1.0, -1.0, 1.0]];

/// A Hessian that no translation sees, in its nine other dimensions; the upper triangle.
type Differences = [[f64; 9]; 9];

/// The rows of [`DIFFERENCES`] on both sides of a Hessian, of which the lower triangle is read.
fn reduce(hessian: &LocalHessian<4>) -> Differences {
    let mut half = [[Mat3::zeros(); 4]; 3];
    for (half, signs) in half.iter_mut().zip(&DIFFERENCES) {
        for (j, half) in half.iter_mut().enumerate() {
            for (i, sign) in signs.iter().enumerate() {
                *half += if j <= i { hessian[i][j] * *sign } else { hessian[j][i].transpose() * *sign };
            }
        }
    }
    let mut small = [[0.0; 9]; 9];
    for a in 0..3 {
        for b in a..3 {
            let mut block = Mat3::zeros();
            for j in 0..4 {
                block += half[a][j] * (0.25 * DIFFERENCES[b][j]);
            }
            for k in 0..3 {
                for l in 0..3 {
                    small[3 * a + k][3 * b + l] = block[(k, l)];
                }
            }
        }
    }
    small
}

/// The reverse of [`reduce`]: the lower triangle from all of `small`.
fn restore(small: &Differences) -> LocalHessian<4> {
    let block = |a: usize, b: usize| Mat3::from_fn(|k, l| small[3 * a + k][3 * b + l]);
    let mut half = [[Mat3::zeros(); 3]; 4];
    for (i, half) in half.iter_mut().enumerate() {
        for (b, half) in half.iter_mut().enumerate() {
            for a in 0..3 {
                *half += block(a, b) * (0.25 * DIFFERENCES[a][i]);
            }
        }
    }
    blocks(|i, j| {
        half[i][0] * DIFFERENCES[0][j] + half[i][1] * DIFFERENCES[1][j] + half[i][2] * DIFFERENCES[2][j]
    })
}

/// Projects `matrices` and overwrites the Hessians with these numbers by them.
fn project_all(
    numbers: &[usize],
    matrices: &mut [Differences; LANES],
    projection: Projection,
    hessians: &mut [LocalHessian<4>],
) {
    lanes::dispatch(Project { matrices, projection });
    for (&number, matrix) in numbers.iter().zip(matrices.iter()) {
        hessians[number] = restore(matrix);
    }
}

/// Projects one matrix a lane.
struct Project<'a> {
    matrices: &'a mut [Differences],
    projection: Projection,
}

impl LaneKernel<f64> for Project<'_> {
    type Output = ();
    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) {
        for matrices in self.matrices.chunks_exact_mut(P::LANES) {
            let mut packets = [[P::constant(0.0); 9]; 9];
            for p in 0..9 {
                for q in p..9 {
                    let mut lanes = packets[p][q].to_lanes();
                    for (lane, matrix) in lanes.as_mut().iter_mut().zip(matrices.iter()) {
                        *lane = matrix[p][q];
                    }
                    packets[p][q] = P::from_lanes(lanes);
                }
            }
            let packets = eigen::project(&packets, self.projection);
            for p in 0..9 {
                for q in 0..9 {
                    let lanes = packets[p][q].to_lanes();
                    for (lane, matrix) in lanes.as_ref().iter().zip(matrices.iter_mut()) {
                        matrix[p][q] = *lane;
                    }
                }
            }
        }
    }
}

impl<B: Barrier + ?Sized> Stencil<4> for EdgeEdgePairs<'_, B> {
    fn value(&self, pair: usize, x: &[Vec3; 4]) -> f64 {
        let mut value = [0.0];
        self.values_into(pair, std::slice::from_ref(x), &mut value);
        value[0]
    }

    fn gradient(&self, pair: usize, x: &[Vec3; 4]) -> [Vec3; 4] {
        let mut gradient = [[Vec3::zeros(); 4]];
        self.gradients_into(pair, std::slice::from_ref(x), &mut gradient);
        gradient[0]
    }

    fn hessian(&self, pair: usize, x: &[Vec3; 4], projection: Projection) -> LocalHessian<4> {
        let mut hessian = [[[Mat3::zeros(); 4]; 4]];
        self.hessians_into(pair, std::slice::from_ref(x), projection, &mut hessian);
        hessian[0]
    }

    fn demand(&self) -> Demand {
        Demand::EndPositions
    }

    fn values_into(&self, first: usize, x: &[[Vec3; 4]], values: &mut [f64]) {
        Run::new(self.law, self.weights, first, x).values(LineLine, values);
        for (k, pair) in self.mollified(first, x) {
            values[k] = self.law.energy(self.weights[first + k], pair.s) * pair.mollifier.value(&x[k]);
        }
    }

    fn gradients_into(&self, first: usize, x: &[[Vec3; 4]], gradients: &mut [[Vec3; 4]]) {
        Run::new(self.law, self.weights, first, x).gradients(LineLine, gradients);
        for (k, pair) in self.mollified(first, x) {
            gradients[k] = pair.gradient(self.law, self.weights[first + k], &x[k]);
        }
    }

    fn hessians_into(
        &self,
        first: usize,
        x: &[[Vec3; 4]],
        projection: Projection,
        hessians: &mut [LocalHessian<4>],
    ) {
        Run::new(self.law, self.weights, first, x).hessians(LineLine, projection, hessians);
        let rule = Rule { projection, curvature: self.law.curvature };
        // Those that wait until there is one for every lane. Lanes are diagonalised together, which changes the last bits, so
        // they come from one group of the list: an assembler calls for whole groups, how many depends on its threads.
        let (mut numbers, mut matrices, mut count) = ([0; LANES], [[[0.0; 9]; 9]; LANES], 0);
        let group = |k: usize| (first + k) / GROUP;
        for (k, pair) in self.mollified(first, x) {
            hessians[k] = pair.hessian(self.law, self.weights[first + k], &x[k], rule);
            if !rule.is_full_and_projected() {
                continue;
            }
            if count == LANES || count > 0 && group(k) != group(numbers[0]) {
                matrices[count..].fill([[0.0; 9]; 9]);
                project_all(&numbers[..count], &mut matrices, projection, hessians);
                count = 0;
            }
            (numbers[count], matrices[count]) = (k, reduce(&hessians[k]));
            count += 1;
        }
        if count > 0 {
            matrices[count..].fill([[0.0; 9]; 9]);
            project_all(&numbers[..count], &mut matrices, projection, hessians);
        }
    }
}
