//! Friction of a list of normal forces, held constant: a term of the incremental potential that knows no contact.

use crate::FrictionError;
use crate::law::{FrictionCoefficient, SmoothedCoulomb, Strength};
use crate::pair::{FrictionPairs, LaggedPair};
use ipc_contact::normal_force::NormalForce;
use mechanics_core::parallel;
use mechanics_core::potential::{Demand, Potential, PotentialError};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stage::Scheme;
use mechanics_core::stencil::{StencilError, StencilTerm};
use mechanics_core::tensor::Vec3;

/// The name of the term.
const NAME: &str = "friction";
/// Pairs made by one task.
const CHUNK: usize = 1024;

/// Σ λ P(‖Tᵀv(x)‖)/a over pairs whose λ, w and n are held constant; see [`crate::pair`].
///
/// Pairs without strength (μ = 0 or λ = 0) are left out. Sums run over pairs of one point, two, three, four, each in the order of the
/// normal forces, and have the same bits for any number of threads; the assembler gets these four lists, always.
#[derive(Debug)]
pub struct LaggedFriction {
    ones: StencilTerm<FrictionPairs<1>, 1>,
    twos: StencilTerm<FrictionPairs<2>, 2>,
    threes: StencilTerm<FrictionPairs<3>, 3>,
    fours: StencilTerm<FrictionPairs<4>, 4>,
    /// Of the material of the second surface beyond that of its points, for each of [`pairs`](Self::pairs); empty if all are
    /// zero [m/s].
    surface_velocities: Vec<Vec3>,
}

/// What pairs are made of.
#[derive(Clone, Copy)]
struct Given<'a> {
    law: SmoothedCoulomb,
    forces: &'a [NormalForce],
    coefficients: &'a [FrictionCoefficient],
    surface_velocities: &'a [Vec3],
    scheme: &'a Scheme<'a>,
}

/// What friction does to one pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairFriction {
    points: [u32; 4],
    weights: [f64; 4],
    count: usize,
    /// The tangential velocity of the first feature relative to the second [m/s].
    pub slip_velocity: Vec3,
    /// The force on the first feature; on the second it is the opposite \[N\].
    pub force: Vec3,
    /// μ_s λ \[N\], which the force never exceeds (|μ_s λ| for the negative forces of the area-weighted barrier).
    pub bound: f64,
}

impl PairFriction {
    /// The points, those of the first feature first.
    pub fn points(&self) -> &[u32] {
        &self.points[..self.count]
    }

    /// Their weights: the force on point i is wᵢ times [`force`](Self::force).
    pub fn weights(&self) -> &[f64] {
        &self.weights[..self.count]
    }
}

impl LaggedFriction {
    /// The friction of `forces`, each with its coefficient, in a step of `scheme`.
    ///
    /// # Errors
    /// If a force is not finite, has a normal that is not of length one, or names a point twice.
    ///
    /// # Panics
    /// If there is not one coefficient for each force, or a force names a point that x̂ has not.
    pub fn new(
        law: SmoothedCoulomb,
        forces: &[NormalForce],
        coefficients: &[FrictionCoefficient],
        scheme: &Scheme<'_>,
    ) -> Result<Self, FrictionError> {
        Self::on_moving_surfaces(law, forces, coefficients, &vec![Vec3::zeros(); forces.len()], scheme)
    }

    /// The same where the material of the second surface of each force has a velocity [m/s] beyond that of its points: a belt's
    /// ([`crate::surface_motion`]).
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    ///
    /// # Panics
    /// If there is not one coefficient and one velocity for each force, or a force names a point that x̂ has not.
    pub fn on_moving_surfaces(
        law: SmoothedCoulomb,
        forces: &[NormalForce],
        coefficients: &[FrictionCoefficient],
        surface_velocities: &[Vec3],
        scheme: &Scheme<'_>,
    ) -> Result<Self, FrictionError> {
        assert_eq!(forces.len(), coefficients.len(), "one coefficient for each normal force");
        assert_eq!(forces.len(), surface_velocities.len(), "one surface velocity for each normal force");
        let given = Given { law, forces, coefficients, surface_velocities, scheme };
        let [ones, twos, threes, fours] = given.acting()?;
        Ok(Self {
            surface_velocities: given.velocities_of([&ones, &twos, &threes, &fours]),
            ones: given.term(&ones)?,
            twos: given.term(&twos)?,
            threes: given.term(&threes)?,
            fours: given.term(&fours)?,
        })
    }

    /// How many pairs have friction.
    pub fn len(&self) -> usize {
        self.ones.elements().len()
            + self.twos.elements().len()
            + self.threes.elements().len()
            + self.fours.elements().len()
    }

    /// Is there no friction?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What friction does to each pair at `x`, in the order of the sums.
    pub fn pairs(&self, x: &[Vec3]) -> Vec<PairFriction> {
        let mut pairs = Vec::with_capacity(self.len());
        add_pairs(&self.ones, x, &mut pairs);
        add_pairs(&self.twos, x, &mut pairs);
        add_pairs(&self.threes, x, &mut pairs);
        add_pairs(&self.fours, x, &mut pairs);
        pairs
    }

    /// What friction pushes each point with at `x` \[N\].
    pub fn forces(&self, x: &[Vec3]) -> Vec<Vec3> {
        let mut forces = vec![Vec3::zeros(); x.len()];
        self.add_gradient(x, &mut forces);
        forces.iter_mut().for_each(|force| *force = -*force);
        forces
    }

    /// The heat \[J\] of the time `duration` h \[s\] at the rate of the instant when the points are at `end`: −h Σ β·u, never less than zero.
    /// u is the slip velocity that the scheme reads off there.
    ///
    /// - Backward Euler: h u is the slip of the step, and this is the work of the forces that the step is made with.
    /// - BDF2: its energy law has the power at the end of the step times h (`docs/theory/ipc-friction.md`), which is this.
    /// - Average acceleration: its energy law has the mean of the forces at both ends, times the way. Summed over steps, that and
    ///   this differ by the first order of h, since the mean rule and the rule of the right end do.
    /// - Statics: h = 1, and u is the slip of the part of the load \[m\].
    pub fn heat(&self, end: &[Vec3], duration: f64) -> f64 {
        let rate = self.pairs(end).into_iter().map(|pair| -pair.force.dot(&pair.slip_velocity));
        rate.fold(0.0, |sum, part| sum + part) * duration
    }

    /// The part of the [heat](Self::heat) that moving surfaces put in \[J\] in the time `duration` \[s\] with the forces that act at `end`;
    /// the rest is what the points lose.
    pub fn driven(&self, end: &[Vec3], duration: f64) -> f64 {
        if self.surface_velocities.is_empty() {
            return 0.0;
        }
        let pairs = self.pairs(end);
        let power =
            pairs.iter().zip(&self.surface_velocities).map(|(pair, velocity)| pair.force.dot(velocity));
        power.fold(0.0, |sum, part| sum + part) * duration
    }

    /// Sets the [floor](FrictionPairs::floor) θ under the curvature along the slip; zero for the true Hessian, as it is at first.
    pub fn set_floor(&mut self, floor: f64) {
        self.ones.stencil_mut().floor = floor;
        self.twos.stencil_mut().floor = floor;
        self.threes.stencil_mut().floor = floor;
        self.fours.stencil_mut().floor = floor;
    }

    /// The largest μ_s |λ| that acts on a point: Σ |wᵢ| μ_s |λ| \[N\] over its pairs.
    pub(crate) fn largest_bound(&self, points: usize) -> f64 {
        let mut bounds = vec![0.0; points];
        add_bounds(&self.ones, &mut bounds);
        add_bounds(&self.twos, &mut bounds);
        add_bounds(&self.threes, &mut bounds);
        add_bounds(&self.fours, &mut bounds);
        bounds.into_iter().fold(0.0, f64::max)
    }
}

impl Potential for LaggedFriction {
    fn name(&self) -> &str {
        NAME
    }

    fn value(&self, x: &[Vec3]) -> f64 {
        self.ones.value(x) + self.twos.value(x) + self.threes.value(x) + self.fours.value(x)
    }

    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        self.ones.add_gradient(x, gradient);
        self.twos.add_gradient(x, gradient);
        self.threes.add_gradient(x, gradient);
        self.fours.add_gradient(x, gradient);
    }

    /// Four lists, always: pairs of one point, two, three, four.
    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        self.ones.add_hessian(x, projection, hessian);
        self.twos.add_hessian(x, projection, hessian);
        self.threes.add_hessian(x, projection, hessian);
        self.fours.add_hessian(x, projection, hessian);
    }

    fn demand(&self) -> Demand {
        Demand::EndPositions
    }

    /// The number of the pair among [`pairs`](LaggedFriction::pairs).
    fn locate(&self, x: &[Vec3], point: usize) -> Option<usize> {
        let pull = |(number, pair): (usize, &PairFriction)| {
            let at = pair.points().iter().position(|&other| other as usize == point)?;
            Some((number, (pair.force * pair.weights()[at]).norm()))
        };
        let pairs = self.pairs(x);
        let pulls = pairs.iter().enumerate().filter_map(pull);
        pulls.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(number, _)| number)
    }

    fn diagnose(&self, x: &[Vec3]) -> Option<PotentialError> {
        None.or_else(|| self.ones.diagnose(x))
            .or_else(|| self.twos.diagnose(x))
            .or_else(|| self.threes.diagnose(x))
            .or_else(|| self.fours.diagnose(x))
    }
}

impl From<FrictionError> for PotentialError {
    fn from(error: FrictionError) -> Self {
        Self::Term { term: NAME.to_owned(), source: Box::new(error) }
    }
}

/// A normal of a length that differs from one by more than this is none.
const UNIT: f64 = 1e-9;

fn check(force: &NormalForce) -> Result<(), FrictionError> {
    let is_unit = (force.normal.norm() - 1.0).abs() <= UNIT;
    if is_unit && force.magnitude.is_finite() && force.weights().iter().all(|weight| weight.is_finite()) {
        return Ok(());
    }
    let (points, normal) = (force.points().to_vec(), force.normal.into());
    Err(FrictionError::NormalForce { points, magnitude: force.magnitude, normal })
}

impl Given<'_> {
    /// The numbers of the forces that have friction: those on one point, two, three, four.
    fn acting(&self) -> Result<[Vec<u32>; 4], FrictionError> {
        let mut acting: [Vec<u32>; 4] = Default::default();
        for (number, (force, &coefficient)) in (0..).zip(self.forces.iter().zip(self.coefficients)) {
            check(force)?;
            if Strength::new(coefficient, force.magnitude).at_rest != 0.0 {
                acting[force.points().len() - 1].push(number);
            }
        }
        Ok(acting)
    }

    /// The surfaces' velocities in the order of the pairs; nothing if nothing moves.
    fn velocities_of(&self, acting: [&[u32]; 4]) -> Vec<Vec3> {
        let each =
            || acting.iter().copied().flatten().map(|&number| self.surface_velocities[number as usize]);
        if each().all(|velocity| velocity == Vec3::zeros()) { Vec::new() } else { each().collect() }
    }

    fn pair<const N: usize>(&self, number: u32) -> LaggedPair<N> {
        let number = number as usize;
        let force = &self.forces[number];
        let strength = Strength::new(self.coefficients[number], force.magnitude);
        let mut pair = LaggedPair::new(force, strength, self.scheme);
        pair.origin += self.surface_velocities[number] / self.scheme.coefficients.velocity;
        pair
    }

    /// The pairs of N points, made in parallel.
    fn term<const N: usize>(
        &self,
        numbers: &[u32],
    ) -> Result<StencilTerm<FrictionPairs<N>, N>, FrictionError> {
        let mut pairs = vec![LaggedPair::default(); numbers.len()];
        parallel::map_into(&mut pairs, CHUNK, |k| self.pair(numbers[k]));
        let points = |&number: &u32| std::array::from_fn(|i| self.forces[number as usize].points()[i]);
        let elements: Vec<[u32; N]> = numbers.iter().map(points).collect();
        let velocity_factor = self.scheme.coefficients.velocity;
        let stencil = FrictionPairs { law: self.law, velocity_factor, floor: 0.0, pairs };
        StencilTerm::new(NAME, stencil, elements).map_err(|error| {
            let StencilError::RepeatedPoint { element, point, .. } = error;
            let points = self.forces[numbers[element] as usize].points().to_vec();
            FrictionError::RepeatedPoint { points, point }
        })
    }
}

fn gather<const N: usize>(points: &[u32; N], x: &[Vec3]) -> [Vec3; N] {
    points.map(|point| x[point as usize])
}

fn add_pairs<const N: usize>(
    term: &StencilTerm<FrictionPairs<N>, N>,
    x: &[Vec3],
    list: &mut Vec<PairFriction>,
) {
    let stencil = term.stencil();
    list.extend(term.elements().iter().enumerate().map(|(number, element)| {
        let x = gather(element, x);
        let LaggedPair { weights: own, strength, .. } = stencil.pairs[number];
        let (mut points, mut weights) = ([0; 4], [0.0; 4]);
        points[..N].copy_from_slice(element);
        weights[..N].copy_from_slice(&own);
        let (slip_velocity, force) = (stencil.slip_velocity(number, &x), stencil.force(number, &x));
        PairFriction { points, weights, count: N, slip_velocity, force, bound: strength.at_rest.abs() }
    }));
}

fn add_bounds<const N: usize>(term: &StencilTerm<FrictionPairs<N>, N>, bounds: &mut [f64]) {
    for (element, pair) in term.elements().iter().zip(&term.stencil().pairs) {
        for (&point, weight) in element.iter().zip(&pair.weights) {
            bounds[point as usize] += (weight * pair.strength.at_rest).abs();
        }
    }
}
