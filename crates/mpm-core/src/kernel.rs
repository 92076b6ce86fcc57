//! B-spline kernels: how a particle's matter is spread over the nodes around it.
//!
//! A kernel of width W gives every particle W nodes an axis; weights multiply over the axes. With the position X in cells,
//! b the lowest of the W nodes and f = X − b:
//!
//! | kernel | W | f in | weights of nodes b, b + 1, … |
//! |---|---|---|---|
//! | linear | 2 | [0, 1] | 1 − f, f |
//! | quadratic | 3 | [½, 3⁄2] | ½(3⁄2 − f)², ¾ − (f − 1)², ½(f − ½)² |
//! | cubic | 4 | [1, 2], t = f − 1 | (1 − t)³/6, (3t³ − 6t² + 4)/6, (−3t³ + 3t² + 3t + 1)/6, t³/6 |
//!
//! All of them sum to one and reproduce linear functions: Σ wᵢ = 1, Σ wᵢ (xᵢ − x) = 0. At an end of its range f may be taken from
//! either side: the weights are the same function of X.
//!
//! # Reference
//! M. Steffen, R. M. Kirby, M. Berzins, *Analysis and reduction of quadrature errors in the material point method*, Int. J. Numer.
//! Meth. Engng 76, 2008, section 4.

use mechanics_core::scalar::Scalar;

/// The shape of a particle on the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Kernel {
    /// Tent functions: cheapest, and forces jump where a particle crosses into another cell.
    Linear,
    /// Quadratic B-splines: continuous forces; the usual choice.
    #[default]
    Quadratic,
    /// Cubic B-splines: smoothest; 64 nodes instead of 27 in three dimensions.
    Cubic,
}

impl Kernel {
    /// Nodes an axis that a particle reaches.
    pub fn width(self) -> usize {
        match self {
            Self::Linear => 2,
            Self::Quadratic => 3,
            Self::Cubic => 4,
        }
    }

    /// The second moment Σ wᵢ (xᵢ − x)² along an axis \[cells²\], where it is the same for every x: ¼ and ⅓. The linear kernel's,
    /// f(1 − f), vanishes at nodes: `None`.
    pub fn second_moment(self) -> Option<f64> {
        match self {
            Self::Linear => None,
            Self::Quadratic => Some(1.0 / 4.0),
            Self::Cubic => Some(1.0 / 3.0),
        }
    }
}

/// What rounding to the nearest integer needs: adding and subtracting it leaves no fraction bits.
#[inline(always)]
fn nearest_integer<S: Scalar>(x: S) -> S {
    // 1.5 / ε has the weight of its last bit equal to one.
    let shift = S::constant(1.5 / S::EPSILON);
    (x + shift) - shift
}

/// The lowest of the `W` nodes that a particle at `x` cells reaches, as a number without fraction; for |x| < ¼/ε.
#[inline(always)]
pub(crate) fn lowest_node<S: Scalar, const W: usize>(x: S) -> S {
    // Linear: floor(x); quadratic: floor(x − ½); cubic: floor(x) − 1. Floor as the nearest integer to half less: where
    // that is a tie, either neighbour gives the same weights.
    nearest_integer(x.offset(-0.5 * (W - 1) as f64))
}

/// The weights of the `W` nodes; `f` is the distance from the lowest one \[cells\].
#[inline(always)]
pub(crate) fn weights<S: Scalar, const W: usize>(f: S) -> [S; W] {
    let mut w = [S::constant(0.0); W];
    match W {
        2 => {
            w[0] = S::constant(1.0) - f;
            w[1] = f;
        }
        3 => {
            let (a, b, c) = (S::constant(1.5) - f, f.offset(-1.0), f.offset(-0.5));
            w[0] = a.square().scale(0.5);
            w[1] = S::constant(0.75) - b.square();
            w[2] = c.square().scale(0.5);
        }
        _ => {
            let t = f.offset(-1.0);
            let s = S::constant(1.0) - t;
            let cube = |a: S| (a.square() * a).scale(1.0 / 6.0);
            // ⅔ − a² + ½a³ for the two nodes within one cell.
            let near = |a: S| a.square() * a.scale(0.5).offset(-1.0);
            w[0] = cube(s);
            w[1] = near(t).offset(2.0 / 3.0);
            w[2] = near(s).offset(2.0 / 3.0);
            w[3] = cube(t);
        }
    }
    w
}

/// The derivatives of the weights by the position \[1/cell\].
#[inline(always)]
pub(crate) fn slopes<S: Scalar, const W: usize>(f: S) -> [S; W] {
    let mut w = [S::constant(0.0); W];
    match W {
        2 => {
            w[0] = S::constant(-1.0);
            w[1] = S::constant(1.0);
        }
        3 => {
            w[0] = f.offset(-1.5);
            w[1] = f.offset(-1.0).scale(-2.0);
            w[2] = f.offset(-0.5);
        }
        _ => {
            let t = f.offset(-1.0);
            let s = S::constant(1.0) - t;
            let near = |a: S| a * a.scale(1.5).offset(-2.0);
            w[0] = s.square().scale(-0.5);
            w[1] = near(t);
            w[2] = -near(s);
            w[3] = t.square().scale(0.5);
        }
    }
    w
}

#[cfg(test)]
mod tests {
    use super::*;
    use mechanics_core::jet::Jet1;

    fn check<const W: usize>() {
        for k in 0..=4000 {
            let x = -7.3 + 0.0037 * f64::from(k);
            let low = lowest_node::<f64, W>(x);
            let f = x - low;
            let (w, d) = (weights::<f64, W>(f), slopes::<f64, W>(f));
            assert_eq!(low.fract(), 0.0);
            assert!(w.iter().all(|w| *w >= -1e-16), "{W} {x} {w:?}");
            assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            assert!(d.iter().sum::<f64>().abs() < 4e-15);
            let first: f64 = w.iter().enumerate().map(|(i, w)| w * (i as f64 - f)).sum();
            assert!(first.abs() < 1e-15, "{W} {x} {first}");
            let second: f64 = w.iter().enumerate().map(|(i, w)| w * (i as f64 - f).powi(2)).sum();
            let kernel = [Kernel::Linear, Kernel::Quadratic, Kernel::Cubic][W - 2];
            assert_eq!(kernel.width(), W);
            let expected = kernel.second_moment().unwrap_or(f * (1.0 - f));
            assert!((second - expected).abs() < 1e-15);
            let jets = weights::<Jet1<f64, 1>, W>(Jet1::variable(f, 0));
            for i in 0..W {
                assert!((jets[i].gradient[0] - d[i]).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn kernels_are_partitions_of_unity_and_reproduce_lines() {
        check::<2>();
        check::<3>();
        check::<4>();
    }

    /// The lecture's other formula of the splines: as functions of the distance from a node, N(|d|).
    #[test]
    fn weights_are_the_splines_of_the_distance() {
        let quadratic = |d: f64| match d.abs() {
            d if d < 0.5 => 0.75 - d * d,
            d if d < 1.5 => 0.5 * (1.5 - d).powi(2),
            _ => 0.0,
        };
        let cubic = |d: f64| match d.abs() {
            d if d < 1.0 => 0.5 * d.powi(3) - d * d + 2.0 / 3.0,
            d if d < 2.0 => (2.0 - d).powi(3) / 6.0,
            _ => 0.0,
        };
        for k in 0..1000 {
            let x = -2.0 + 0.00471 * f64::from(k);
            let (b3, b4) = (lowest_node::<f64, 3>(x), lowest_node::<f64, 4>(x));
            for (i, w) in weights::<f64, 3>(x - b3).into_iter().enumerate() {
                assert!((w - quadratic(x - b3 - i as f64)).abs() < 1e-15);
            }
            for (i, w) in weights::<f64, 4>(x - b4).into_iter().enumerate() {
                assert!((w - cubic(x - b4 - i as f64)).abs() < 1e-15);
            }
        }
    }
}
