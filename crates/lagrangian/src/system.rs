//! What a user writes (T and V), and what integrators read (their derivatives).

use crate::coordinates::Coordinates;
use crate::error::{LagrangianError, Symbol};
use mechanics_core::scalar::Scalar;

/// A mechanical system in `N` generalised coordinates: kinetic and potential energy, written once over any
/// [`Scalar`].
///
/// L = T − V; the equations of motion are d/dt ∂L/∂v = ∂L/∂q − ∂R/∂v + Q.
pub trait Lagrangian<const N: usize>: Send + Sync {
    /// T(q, v, t) \[J\]. Terms that are linear in the velocity (magnetic, gyroscopic) belong here too.
    fn kinetic<S: Scalar>(&self, q: &[S; N], v: &[S; N], t: S) -> S;

    /// V(q, t) \[J\].
    fn potential<S: Scalar>(&self, q: &[S; N], t: S) -> S;

    /// Rayleigh's dissipation function R(q, v, t) \[W\]; the force −∂R/∂v acts.
    fn rayleigh<S: Scalar>(&self, q: &[S; N], v: &[S; N], t: S) -> S {
        let _ = (q, v, t);
        S::constant(0.0)
    }

    /// A generalised force Q(q, v, t) that no potential gives; Q·δq is its work \[J\].
    fn force<S: Scalar>(&self, q: &[S; N], v: &[S; N], t: S) -> [S; N] {
        let _ = (q, v, t);
        [S::constant(0.0); N]
    }
}

/// [`Lagrangian`] for a number of coordinates known at run time: chains and networks of any length.
pub trait SlicedLagrangian: Send + Sync {
    /// The number of coordinates.
    fn dimension(&self) -> usize;

    /// T(q, v, t) \[J\].
    fn kinetic<S: Scalar>(&self, q: &[S], v: &[S], t: S) -> S;

    /// V(q, t) \[J\].
    fn potential<S: Scalar>(&self, q: &[S], t: S) -> S;

    /// Rayleigh's dissipation function R(q, v, t) \[W\].
    fn rayleigh<S: Scalar>(&self, q: &[S], v: &[S], t: S) -> S {
        let _ = (q, v, t);
        S::constant(0.0)
    }

    /// Adds a generalised force Q(q, v, t) to `force`.
    fn add_force<S: Scalar>(&self, q: &[S], v: &[S], t: S, force: &mut [S]) {
        let _ = (q, v, t, force);
    }
}

/// Energies, momenta, forces and masses at one (t, q, v): what one evaluation of the Euler–Lagrange equations needs.
///
/// With D = v·∂/∂q + ∂/∂t the equations of motion are `mass` · q̈ + `momentum_rate` = `slope` + `applied`.
#[derive(Clone, Debug, PartialEq)]
pub struct Expansion<C: Coordinates> {
    /// T \[J\].
    pub kinetic: f64,
    /// V \[J\].
    pub potential: f64,
    /// p = ∂L/∂v.
    pub momentum: C,
    /// D ∂L/∂v: the rate of the momentum without acceleration.
    pub momentum_rate: C,
    /// ∂L/∂q.
    pub slope: C,
    /// Q − ∂R/∂v: forces that no potential gives.
    pub applied: C,
    /// M = ∂²T/∂v∂v, whole and symmetric.
    pub mass: C::Matrix,
}

impl<C: Coordinates> Expansion<C> {
    /// Zeros.
    pub fn zeros(dimension: usize) -> Self {
        Self {
            kinetic: 0.0,
            potential: 0.0,
            momentum: C::zeros(dimension),
            momentum_rate: C::zeros(dimension),
            slope: C::zeros(dimension),
            applied: C::zeros(dimension),
            mass: C::zero_matrix(dimension),
        }
    }
}

impl<C: Coordinates> Expansion<C> {
    /// Refuses an expansion with a NaN or an infinity.
    ///
    /// # Errors
    /// [`LagrangianError::NonFinite`] names the first offending derivative; an entry (i, j) of the mass matrix has the
    /// index i n + j. An infinity goes before NaN, which it makes of its neighbours by products with their zeros.
    pub fn validate(&self, time: f64) -> Result<(), LagrangianError> {
        let derivatives = [
            (Symbol::Mass, C::entries(&self.mass)),
            (Symbol::Momentum, self.momentum.as_ref()),
            (Symbol::MomentumRate, self.momentum_rate.as_ref()),
            (Symbol::Slope, self.slope.as_ref()),
            (Symbol::Force, self.applied.as_ref()),
        ];
        for (symbol, values) in derivatives {
            let infinite = values.iter().position(|x| x.is_infinite());
            if let Some(index) = infinite.or_else(|| values.iter().position(|x| x.is_nan())) {
                return Err(LagrangianError::NonFinite { symbol, index, value: values[index], time });
            }
        }
        Ok(())
    }
}

/// Energies, first derivatives of L and applied forces at one (t, q, v): what discrete Euler–Lagrange equations need.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient<C> {
    /// T \[J\].
    pub kinetic: f64,
    /// V \[J\].
    pub potential: f64,
    /// p = ∂L/∂v.
    pub momentum: C,
    /// ∂L/∂q.
    pub slope: C,
    /// Q − ∂R/∂v: forces that no potential gives.
    pub applied: C,
}

impl<C: Coordinates> Gradient<C> {
    /// Zeros.
    pub fn zeros(dimension: usize) -> Self {
        let zero = || C::zeros(dimension);
        Self { kinetic: 0.0, potential: 0.0, momentum: zero(), slope: zero(), applied: zero() }
    }
}

/// Second derivatives of L and first derivatives of the applied forces F = Q − ∂R/∂v at one (t, q, v): what Newton's
/// method on an implicit step needs. Entry (i, j) of a matrix differentiates component i.
#[derive(Clone, Debug, PartialEq)]
pub struct Curvature<C: Coordinates> {
    /// ∂²L/∂qᵢ∂qⱼ.
    pub qq: C::Matrix,
    /// ∂²L/∂vᵢ∂qⱼ.
    pub vq: C::Matrix,
    /// ∂²L/∂vᵢ∂vⱼ, the mass matrix.
    pub vv: C::Matrix,
    /// ∂Fᵢ/∂qⱼ.
    pub applied_q: C::Matrix,
    /// ∂Fᵢ/∂vⱼ.
    pub applied_v: C::Matrix,
}

impl<C: Coordinates> Curvature<C> {
    /// Zeros.
    pub fn zeros(dimension: usize) -> Self {
        let zero = || C::zero_matrix(dimension);
        Self { qq: zero(), vq: zero(), vv: zero(), applied_q: zero(), applied_v: zero() }
    }
}

/// Which of its arguments a Lagrangian mentions, found by running its formulas on a number that only keeps track.
///
/// "Mentions" is on the safe side: what cancels is still mentioned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dependence {
    /// For every coordinate, whether T mentions it.
    pub kinetic_on_q: Vec<bool>,
    /// For every coordinate, whether V mentions it.
    pub potential_on_q: Vec<bool>,
    /// For every coordinate, whether R or Q mentions it or its velocity, or is not zero in its direction.
    pub applied_on: Vec<bool>,
    /// Whether T mentions time.
    pub kinetic_on_time: bool,
    /// Whether V mentions time.
    pub potential_on_time: bool,
    /// Whether R or Q is there at all (is anything but the constant zero).
    pub applied: bool,
    /// Whether T is a quadratic form in v without linear part, as far as degrees can be tracked.
    pub kinetic_quadratic: bool,
}

/// What integrators read of a system. [`EulerLagrange`](crate::EulerLagrange) and
/// [`SlicedEulerLagrange`](crate::SlicedEulerLagrange) are the two implementations.
pub trait System: Send + Sync {
    /// How coordinates are stored.
    type Coordinates: Coordinates;

    /// The number of coordinates.
    fn dimension(&self) -> usize;

    /// Overwrites `expansion` with that at (t, q, v). Not checked for NaN.
    fn expand(
        &self,
        t: f64,
        q: &Self::Coordinates,
        v: &Self::Coordinates,
        expansion: &mut Expansion<Self::Coordinates>,
    );

    /// Overwrites `gradient` with that at (t, q, v). Not checked for NaN. Cheaper than [`expand`](Self::expand), of
    /// which it is a part.
    fn differentiate(
        &self,
        t: f64,
        q: &Self::Coordinates,
        v: &Self::Coordinates,
        gradient: &mut Gradient<Self::Coordinates>,
    ) {
        let mut at = Expansion::zeros(self.dimension());
        self.expand(t, q, v, &mut at);
        let Expansion { kinetic, potential, momentum, slope, applied, .. } = at;
        *gradient = Gradient { kinetic, potential, momentum, slope, applied };
    }

    /// Overwrites `curvature` with that at (t, q, v). Not checked for NaN.
    fn curve(
        &self,
        t: f64,
        q: &Self::Coordinates,
        v: &Self::Coordinates,
        curvature: &mut Curvature<Self::Coordinates>,
    );

    /// Which arguments the formulas mention at (t, q, v).
    fn dependence(&self, t: f64, q: &Self::Coordinates, v: &Self::Coordinates) -> Dependence;

    /// Overwrites `acceleration` with q̈ = M⁻¹(∂L/∂q + F − D ∂L/∂v).
    ///
    /// # Errors
    /// [`LagrangianError::SingularMass`], or [`LagrangianError::NonFinite`], which names the derivative that is not
    /// finite. `acceleration` then holds no meaningful numbers.
    #[inline]
    fn acceleration(
        &self,
        t: f64,
        q: &Self::Coordinates,
        v: &Self::Coordinates,
        acceleration: &mut Self::Coordinates,
    ) -> Result<(), LagrangianError> {
        let mut at = Expansion::zeros(self.dimension());
        self.expand(t, q, v, &mut at);
        let a = acceleration.as_mut();
        for i in 0..a.len() {
            a[i] = at.slope.as_ref()[i] + at.applied.as_ref()[i] - at.momentum_rate.as_ref()[i];
        }
        crate::dense::solve_mass::<Self::Coordinates>(t, &mut at.mass, a)
            .map_err(|refusal| culprit(self, (t, q, v), refusal))
    }

    /// The energy function (Jacobi's integral) h = v·∂L/∂v − L \[J\], which is T + V where T is quadratic in v.
    fn energy(&self, t: f64, q: &Self::Coordinates, v: &Self::Coordinates) -> f64 {
        let mut at = Expansion::zeros(self.dimension());
        self.expand(t, q, v, &mut at);
        let pv: f64 = at.momentum.as_ref().iter().zip(v.as_ref()).map(|(p, v)| p * v).sum();
        pv - at.kinetic + at.potential
    }
}

/// Why an acceleration could not be had: the first derivative that is not finite, or else what the solver says.
#[cold]
pub(crate) fn culprit<S: System + ?Sized>(
    system: &S,
    (t, q, v): (f64, &S::Coordinates, &S::Coordinates),
    refusal: LagrangianError,
) -> LagrangianError {
    let mut at = Expansion::zeros(system.dimension());
    system.expand(t, q, v, &mut at);
    at.validate(t).err().unwrap_or(refusal)
}
