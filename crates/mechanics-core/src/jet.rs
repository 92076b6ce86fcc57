//! First- and second-order jets: forward-mode automatic differentiation over any [`Scalar`](crate::scalar::Scalar).
//!
//! A jet is a truncated Taylor expansion in `N` independent variables q: [`Jet1`] carries (f, ∇f) and [`Jet2`]
//! carries (f, ∇f, ∇∇f). Every operation maps expansions to expansions by the chain rule, so a formula written
//! over [`Scalar`](crate::scalar::Scalar) and fed with [`Jet2::variables`] returns its exact gradient and Hessian (up to rounding; there
//! is no step size).
//!
//! For y = φ(a):
//!
//! - ∂ᵢy = φ′ ∂ᵢa
//! - ∂ᵢⱼy = φ′ ∂ᵢⱼa + φ″ ∂ᵢa ∂ⱼa
//!
//! and for y = φ(a, b):
//!
//! - ∂ᵢy = φ_a ∂ᵢa + φ_b ∂ᵢb
//! - ∂ᵢⱼy = φ_a ∂ᵢⱼa + φ_b ∂ᵢⱼb + φ_aa ∂ᵢa ∂ⱼa + φ_bb ∂ᵢb ∂ⱼb + φ_ab (∂ᵢa ∂ⱼb + ∂ᵢb ∂ⱼa)
//!
//! Jets nest: the entries of a jet may be `f64`, `f32`, lanes, or jets again, so `Jet1<Jet2<f64, 1>, 1>` gives third
//! derivatives.
//!
//! ```
//! use mechanics_core::jet::Jet2;
//! use mechanics_core::scalar::Scalar;
//!
//! // f(x, y) = x² sin y at (3, 0): f_xy = 2 x cos y = 6.
//! let [x, y] = Jet2::variables([3.0, 0.0]);
//! let f = x.square() * y.sin();
//! assert_eq!(f.gradient, [0.0, 9.0]);
//! assert_eq!(f.hessian(0, 1), 6.0);
//! ```
//!
//! # Where a derivative does not exist
//!
//! - `abs`, `min`, `max`, `select` carry the derivatives of the branch their *value* takes; `abs` at zero takes +1.
//! - `sqrt` at zero has the infinite slope it should; the product with a derivative of its argument that is zero
//!   is NaN (0 · ∞): the Hessian of √x, the gradient of √(x²). Regularise under the root, or select.
//! - `powf` with an exponent below 2 (below 1) has an infinite second (first) derivative at zero, with the same
//!   consequence. Exponents 0 and 1, and every `powi` with exponent ≥ 0, are exact everywhere, at zero too.
//! - `atan2` at the origin and `asin`, `acos` at ±1 give NaN or infinite derivatives.
//! - [`is_finite`](crate::scalar::Scalar::is_finite) and the comparisons look at the value alone.

mod chain;
mod first;
mod second;

#[doc(hidden)]
pub use chain::inverse_root_of_one_minus_square;
pub use first::Jet1;
pub use second::Jet2;
