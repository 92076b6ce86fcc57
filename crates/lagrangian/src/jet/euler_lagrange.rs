//! The jet that the Euler–Lagrange equations need.

use mechanics_core::jet_scalar;
use mechanics_core::scalar::Scalar;
use std::ops::{AddAssign, Neg, SubAssign};

/// f(q, v, t) with those derivatives that d/dt ∂f/∂v − ∂f/∂q is made of.
///
/// Along a motion, d/dt ∂f/∂v = ∂²f/∂v∂v · q̈ + D ∂f/∂v, where D = w·∂/∂q + ∂/∂t and w is the velocity, held constant.
/// So no derivative of second order in q is wanted, and of the mixed ones only those along the one direction D:
/// 2 + 3N + N(N+1)/2 numbers in all, and a mark on jets that mention no velocity, or nothing else, which spares the
/// arithmetic on their zeros. The fields are named after what they are for f = T.
///
/// For y = φ(a), with primes for derivatives of φ:
///
/// - D y = φ′ D a, and likewise in q and in v;
/// - D ∂ᵢy = φ′ D ∂ᵢa + φ″ D a ∂ᵢa (∂ᵢ in vᵢ);
/// - ∂ᵢⱼy = φ′ ∂ᵢⱼa + φ″ ∂ᵢa ∂ⱼa.
///
/// The set is closed: no rule asks for a derivative that is not carried.
///
/// ```
/// use lagrangian::jet::EulerLagrangeJet;
/// use mechanics_core::scalar::Scalar;
///
/// // f = ½ q² v² at q = 3, v = 5: ∂f/∂v = q² v, D ∂f/∂v = 2 q v · v, ∂²f/∂v² = q².
/// let ([q], [v], _) = EulerLagrangeJet::phase(0.0, [3.0], [5.0]);
/// let f = (q * v).square().scale(0.5);
/// assert_eq!(f.momentum, [45.0]);
/// assert_eq!(f.momentum_rate, [150.0]);
/// assert_eq!(f.mass(0, 0), 9.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EulerLagrangeJet<S, const N: usize> {
    /// f.
    pub value: S,
    /// D f.
    pub rate: S,
    /// ∂f/∂qᵢ.
    pub slope: [S; N],
    /// ∂f/∂vᵢ.
    pub momentum: [S; N],
    /// D ∂f/∂vᵢ.
    pub momentum_rate: [S; N],
    /// ∂²f/∂vᵢ∂vⱼ in row `i ≥ j`, column `j`; zeros above the diagonal.
    lower_mass: [[S; N]; N],
    /// Which of these can be other than zero.
    mentions: Mentions,
}

/// What a jet mentions. Half of all numbers in a kinetic energy mention no velocity (a cosine of an angle), and many no
/// coordinate (the square of a velocity); the derivatives that are zero for it need no arithmetic, nor can they become NaN
/// by a product with an infinity. Where a formula is inlined and has no loop the compiler knows the marks beforehand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mentions {
    /// Nothing: a constant, all derivatives are zero.
    Nothing,
    /// Coordinates and time: `momentum`, `momentum_rate` and `lower_mass` are zero.
    NoVelocity,
    /// Velocities: `rate`, `slope` and `momentum_rate` are zero.
    NoPosition,
    /// Anything.
    All,
}

impl Mentions {
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        if self == other || other == Self::Nothing {
            self
        } else if self == Self::Nothing {
            other
        } else {
            Self::All
        }
    }

    #[inline(always)]
    fn velocity(self) -> bool {
        matches!(self, Self::NoPosition | Self::All)
    }

    #[inline(always)]
    fn position(self) -> bool {
        matches!(self, Self::NoVelocity | Self::All)
    }
}

impl<S: Scalar, const N: usize> EulerLagrangeJet<S, N> {
    /// A constant over the inner scalar: zero derivatives.
    #[inline(always)]
    pub fn from_value(value: S) -> Self {
        let zero = S::constant(0.0);
        Self {
            value,
            rate: zero,
            slope: [zero; N],
            momentum: [zero; N],
            momentum_rate: [zero; N],
            lower_mass: [[zero; N]; N],
            mentions: Mentions::Nothing,
        }
    }

    /// A coordinate that moves at `rate` and is not differentiated by.
    #[inline(always)]
    pub fn moving(value: S, rate: S) -> Self {
        Self { rate, mentions: Mentions::NoVelocity, ..Self::from_value(value) }
    }

    /// A velocity, differentiated by if it has an index.
    ///
    /// # Panics
    /// If the index is not below `N`.
    #[inline(always)]
    pub fn velocity(value: S, index: Option<usize>) -> Self {
        let mut jet = Self::from_value(value);
        if let Some(i) = index {
            jet.momentum[i] = S::constant(1.0);
            jet.mentions = Mentions::NoPosition;
        }
        jet
    }

    /// The arguments of f at (t, q, v): coordinates, velocities and time.
    #[inline(always)]
    pub fn phase(t: S, q: [S; N], v: [S; N]) -> ([Self; N], [Self; N], Self) {
        let one = S::constant(1.0);
        let coordinate = |i: usize| {
            let mut jet = Self::moving(q[i], v[i]);
            jet.slope[i] = one;
            jet
        };
        let velocity = |i: usize| Self::velocity(v[i], Some(i));
        (std::array::from_fn(coordinate), std::array::from_fn(velocity), Self::moving(t, one))
    }

    /// ∂²f/∂vᵢ∂vⱼ.
    ///
    /// # Panics
    /// If an index is not below `N`.
    #[inline(always)]
    pub fn mass(&self, i: usize, j: usize) -> S {
        if i >= j { self.lower_mass[i][j] } else { self.lower_mass[j][i] }
    }

    /// The whole symmetric matrix ∂²f/∂v∂v.
    #[inline(always)]
    pub fn mass_matrix(&self) -> [[S; N]; N] {
        std::array::from_fn(|i| std::array::from_fn(|j| self.mass(i, j)))
    }

    /// φ(a), given φ, φ′ and φ″ at a's value.
    #[inline(always)]
    fn chain(&self, value: S, first: S, second: impl FnOnce() -> S) -> Self {
        let second = second();
        let mut jet = self.scaled_by(first);
        jet.value = value;
        if self.mentions.velocity() {
            for i in 0..N {
                let curved = second * self.momentum[i];
                for j in 0..=i {
                    jet.lower_mass[i][j] = curved.mul_add(self.momentum[j], jet.lower_mass[i][j]);
                }
            }
            if self.mentions.position() {
                let curved_rate = second * self.rate;
                for i in 0..N {
                    jet.momentum_rate[i] = curved_rate.mul_add(self.momentum[i], jet.momentum_rate[i]);
                }
            }
        }
        jet
    }

    /// φ(a, b), given φ, [φ_a, φ_b] and [φ_aa, φ_ab, φ_bb].
    #[inline(always)]
    fn chain_two(
        a: &Self,
        b: &Self,
        value: S,
        [first_a, first_b]: [S; 2],
        second: impl FnOnce() -> [S; 3],
    ) -> Self {
        let [aa, ab, bb] = second();
        let linear = |x: S, y: S| first_a.mul_add(x, first_b * y);
        let mut jet = Self::from_value(value);
        jet.mentions = a.mentions.or(b.mentions);
        jet.rate = linear(a.rate, b.rate);
        for i in 0..N {
            let (a_i, b_i) = (a.momentum[i], b.momentum[i]);
            jet.slope[i] = linear(a.slope[i], b.slope[i]);
            if !jet.mentions.velocity() {
                continue;
            }
            jet.momentum[i] = linear(a_i, b_i);
            let (along_a, along_b) = (aa.mul_add(a_i, ab * b_i), ab.mul_add(a_i, bb * b_i));
            let curved = |a_j: S, b_j: S, flat: S| along_a.mul_add(a_j, along_b.mul_add(b_j, flat));
            jet.momentum_rate[i] = curved(a.rate, b.rate, linear(a.momentum_rate[i], b.momentum_rate[i]));
            for j in 0..=i {
                let flat = linear(a.lower_mass[i][j], b.lower_mass[i][j]);
                jet.lower_mass[i][j] = curved(a.momentum[j], b.momentum[j], flat);
            }
        }
        jet
    }

    #[inline(always)]
    fn scaled_by(&self, factor: S) -> Self {
        let mut jet = *self;
        jet.value *= factor;
        if self.mentions.position() {
            jet.rate *= factor;
            for i in 0..N {
                jet.slope[i] *= factor;
            }
        }
        if self.mentions.velocity() {
            for i in 0..N {
                jet.momentum[i] *= factor;
                for j in 0..=i {
                    jet.lower_mass[i][j] *= factor;
                }
            }
            if self.mentions.position() {
                for i in 0..N {
                    jet.momentum_rate[i] *= factor;
                }
            }
        }
        jet
    }

    /// The product with a factor that mentions no velocity.
    #[inline(always)]
    fn times_still(&self, still: &Self) -> Self {
        let (a, b) = (self.value, still.value);
        let mut jet = self.scaled_by(b);
        jet.mentions = self.mentions.or(still.mentions);
        if !still.mentions.position() {
            return jet;
        }
        let flat = |x: S, term: S| if self.mentions.position() { x + term } else { term };
        jet.rate = flat(jet.rate, a * still.rate);
        for i in 0..N {
            jet.slope[i] = flat(jet.slope[i], a * still.slope[i]);
        }
        if self.mentions.velocity() {
            for i in 0..N {
                jet.momentum_rate[i] = flat(jet.momentum_rate[i], self.momentum[i] * still.rate);
            }
        }
        jet
    }

    /// D ∂ᵢ(ab) = a D ∂ᵢb + b D ∂ᵢa + D a ∂ᵢb + D b ∂ᵢa, and the same with ∂ⱼ in place of D.
    #[inline(always)]
    fn times(&self, other: &Self) -> Self {
        if !self.mentions.velocity() {
            return other.times_still(self);
        }
        if !other.mentions.velocity() {
            return self.times_still(other);
        }
        let (a, b) = (self.value, other.value);
        let linear = |a_i: S, b_i: S| a.mul_add(b_i, b * a_i);
        let mut jet = Self { mentions: self.mentions.or(other.mentions), ..Self::from_value(a * b) };
        for i in 0..N {
            let (a_i, b_i) = (self.momentum[i], other.momentum[i]);
            jet.momentum[i] = linear(a_i, b_i);
            for j in 0..=i {
                let flat = linear(self.lower_mass[i][j], other.lower_mass[i][j]);
                jet.lower_mass[i][j] = a_i.mul_add(other.momentum[j], b_i.mul_add(self.momentum[j], flat));
            }
        }
        if jet.mentions.position() {
            jet.rate = linear(self.rate, other.rate);
            for i in 0..N {
                let flat = linear(self.momentum_rate[i], other.momentum_rate[i]);
                let (a_i, b_i) = (self.momentum[i], other.momentum[i]);
                jet.slope[i] = linear(self.slope[i], other.slope[i]);
                jet.momentum_rate[i] = a_i.mul_add(other.rate, b_i.mul_add(self.rate, flat));
            }
        }
        jet
    }

    /// y = a/b: from y b = a, D y = (D a − y D b) / b and D ∂ᵢy = (D ∂ᵢa − y D ∂ᵢb − D y ∂ᵢb − D b ∂ᵢy) / b, and the
    /// same with ∂ⱼ in place of D.
    #[inline(always)]
    fn over(&self, other: &Self) -> Self {
        let (y, r) = (self.value / other.value, other.value.recip());
        let flat = |a_i: S, b_i: S| (-y).mul_add(b_i, a_i);
        let mut jet = Self::from_value(y);
        jet.mentions = self.mentions.or(other.mentions);
        jet.rate = flat(self.rate, other.rate) * r;
        for i in 0..N {
            let b_i = other.momentum[i];
            let y_i = flat(self.momentum[i], b_i) * r;
            jet.slope[i] = flat(self.slope[i], other.slope[i]) * r;
            jet.momentum[i] = y_i;
            let mixed = jet.rate.mul_add(b_i, other.rate * y_i);
            jet.momentum_rate[i] = (flat(self.momentum_rate[i], other.momentum_rate[i]) - mixed) * r;
            for j in 0..=i {
                let mixed = y_i.mul_add(other.momentum[j], jet.momentum[j] * b_i);
                jet.lower_mass[i][j] = (flat(self.lower_mass[i][j], other.lower_mass[i][j]) - mixed) * r;
            }
        }
        jet
    }

    #[inline(always)]
    fn selected(mask: S::Mask, yes: &Self, no: &Self) -> Self {
        let pick = |yes: S, no: S| S::select(mask, yes, no);
        let mut jet = Self::from_value(pick(yes.value, no.value));
        jet.mentions = yes.mentions.or(no.mentions);
        jet.rate = pick(yes.rate, no.rate);
        for i in 0..N {
            jet.slope[i] = pick(yes.slope[i], no.slope[i]);
            jet.momentum[i] = pick(yes.momentum[i], no.momentum[i]);
            jet.momentum_rate[i] = pick(yes.momentum_rate[i], no.momentum_rate[i]);
            for j in 0..=i {
                jet.lower_mass[i][j] = pick(yes.lower_mass[i][j], no.lower_mass[i][j]);
            }
        }
        jet
    }
}

impl<S: Scalar, const N: usize> AddAssign for EulerLagrangeJet<S, N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.value += other.value;
        if other.mentions.position() {
            self.rate += other.rate;
            for i in 0..N {
                self.slope[i] += other.slope[i];
            }
        }
        if !other.mentions.velocity() {
            self.mentions = self.mentions.or(other.mentions);
            return;
        }
        for i in 0..N {
            self.momentum[i] += other.momentum[i];
            for j in 0..=i {
                self.lower_mass[i][j] += other.lower_mass[i][j];
            }
        }
        if other.mentions.position() {
            for i in 0..N {
                self.momentum_rate[i] += other.momentum_rate[i];
            }
        }
        self.mentions =
            if other.mentions == Mentions::All { Mentions::All } else { self.mentions.or(other.mentions) };
    }
}

impl<S: Scalar, const N: usize> SubAssign for EulerLagrangeJet<S, N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        self.value -= other.value;
        if other.mentions.position() {
            self.rate -= other.rate;
            for i in 0..N {
                self.slope[i] -= other.slope[i];
            }
        }
        if !other.mentions.velocity() {
            self.mentions = self.mentions.or(other.mentions);
            return;
        }
        for i in 0..N {
            self.momentum[i] -= other.momentum[i];
            for j in 0..=i {
                self.lower_mass[i][j] -= other.lower_mass[i][j];
            }
        }
        if other.mentions.position() {
            for i in 0..N {
                self.momentum_rate[i] -= other.momentum_rate[i];
            }
        }
        self.mentions =
            if other.mentions == Mentions::All { Mentions::All } else { self.mentions.or(other.mentions) };
    }
}

impl<S: Scalar, const N: usize> Neg for EulerLagrangeJet<S, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        self.value = -self.value;
        self.rate = -self.rate;
        for i in 0..N {
            self.slope[i] = -self.slope[i];
            self.momentum[i] = -self.momentum[i];
            self.momentum_rate[i] = -self.momentum_rate[i];
            for j in 0..=i {
                self.lower_mass[i][j] = -self.lower_mass[i][j];
            }
        }
        self
    }
}

jet_scalar!(EulerLagrangeJet);
