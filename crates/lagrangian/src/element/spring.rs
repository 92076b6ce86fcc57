//! Springs and dashpots between two points.
//!
//! With d = x₁ − x₀, l = ‖d‖, n = d/l, rest length L and stiffness k the energy of a spring is ½k(l − L)². Its gradient
//! at point 1 is k(l − L) n and minus that at point 0; with the block
//!
//! - K = k n nᵀ + k (1 − L/l)(I − n nᵀ)
//!
//! its Hessian is \[K, −K; −K, K\]. The eigenvalues of K are k along n and k(1 − L/l) across, negative in a compressed
//! spring, and those of the Hessian are twice these and zeros. So projection replaces the second one.
//!
//! A spring of no length has no direction: its gradient is taken as zero there and K as k I.
//!
//! A dashpot with coefficient c resists the rate of its length: its rate potential is ½c((v₁ − v₀) · n)² with n at the start of the
//! step, see [`DampingTerm`](super::DampingTerm).

use super::damping::Dissipation;
use super::error::{ElementError, check_not_negative, check_points, check_positive};
use mechanics_core::projection::Projection;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};

/// Springs between pairs of points.
#[derive(Clone, Debug)]
pub struct Springs {
    /// k [N/m].
    stiffness: Vec<f64>,
    /// L \[m\].
    rest_length: Vec<f64>,
}

impl Springs {
    /// Springs of the given stiffnesses k > 0 [N/m] and rest lengths L ≥ 0 \[m\].
    ///
    /// # Errors
    /// [`ElementError::OutOfRange`] names the spring.
    ///
    /// # Panics
    /// If the lists differ in length.
    pub fn new(stiffness: Vec<f64>, rest_length: Vec<f64>) -> Result<Self, ElementError> {
        assert_eq!(stiffness.len(), rest_length.len(), "one stiffness per rest length");
        for (spring, (&k, &length)) in stiffness.iter().zip(&rest_length).enumerate() {
            check_positive("stiffness", "spring", spring, k)?;
            check_not_negative("rest length", "spring", spring, length)?;
        }
        Ok(Self { stiffness, rest_length })
    }

    /// Springs of one stiffness [N/m] along `edges`, at rest in `points` \[m\], as a term.
    ///
    /// # Errors
    /// [`ElementError`] names the spring or vertex that is wrong.
    pub fn term(
        name: impl Into<String>,
        stiffness: f64,
        points: &[Vec3],
        edges: Vec<[u32; 2]>,
    ) -> Result<StencilTerm<Self, 2>, ElementError> {
        check_points(points, &edges)?;
        let length = |&[i, j]: &[u32; 2]| (points[j as usize] - points[i as usize]).norm();
        let springs = Self::new(vec![stiffness; edges.len()], edges.iter().map(length).collect())?;
        Ok(StencilTerm::new(name, springs, edges)?)
    }
}

impl Stencil<2> for Springs {
    fn value(&self, spring: usize, x: &[Vec3; 2]) -> f64 {
        let extension = (x[1] - x[0]).norm() - self.rest_length[spring];
        0.5 * self.stiffness[spring] * extension * extension
    }

    fn gradient(&self, spring: usize, x: &[Vec3; 2]) -> [Vec3; 2] {
        let d = x[1] - x[0];
        let length = d.norm();
        if length == 0.0 {
            return [Vec3::zeros(); 2];
        }
        let force = d * (self.stiffness[spring] * (1.0 - self.rest_length[spring] / length));
        [-force, force]
    }

    fn hessian(&self, spring: usize, x: &[Vec3; 2], projection: Projection) -> LocalHessian<2> {
        let k = self.stiffness[spring];
        let d = x[1] - x[0];
        let length = d.norm();
        let block = if length == 0.0 {
            Mat3::from_diagonal_element(k)
        } else {
            let along = (d / length) * (d / length).transpose();
            let across = projection.apply(k * (1.0 - self.rest_length[spring] / length));
            along * (k - across) + Mat3::from_diagonal_element(across)
        };
        [[block, -block], [-block, block]]
    }
}

/// Dashpots between pairs of points.
#[derive(Clone, Debug)]
pub struct Dashpots {
    /// c [N s/m].
    coefficient: Vec<f64>,
}

impl Dashpots {
    /// Dashpots with the given coefficients c ≥ 0 [N s/m].
    ///
    /// # Errors
    /// [`ElementError::OutOfRange`] names the dashpot.
    pub fn new(coefficient: Vec<f64>) -> Result<Self, ElementError> {
        for (dashpot, &c) in coefficient.iter().enumerate() {
            check_not_negative("coefficient", "dashpot", dashpot, c)?;
        }
        Ok(Self { coefficient })
    }
}

impl Dissipation<2> for Dashpots {
    fn damping(&self, dashpot: usize, x: &[Vec3; 2]) -> LocalHessian<2> {
        let n = (x[1] - x[0]).try_normalize(0.0).unwrap_or_default();
        let block = n * n.transpose() * self.coefficient[dashpot];
        [[block, -block], [-block, block]]
    }
}
