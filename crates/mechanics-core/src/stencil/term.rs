//! Sums of stencils.

use super::Stencil;
use super::list::{CHUNK, ListGradients, StencilList, gather};
use crate::parallel;
use crate::potential::{Demand, Potential, PotentialError, Quantity, StepLimit};
use crate::projection::Projection;
use crate::sparse::{Assembler, Scatter};
use crate::tensor::Vec3;

/// A list of elements of one [`Stencil`], as a term of the incremental potential: `E(x) = Σₑ Eₑ(x at e's points)`.
///
/// Every sum runs in element order, in parallel, and has the same bits for any number of threads.
#[derive(Debug)]
pub struct StencilTerm<S, const N: usize> {
    name: String,
    stencil: S,
    elements: Vec<[u32; N]>,
    /// One more than the largest point number.
    points: usize,
    /// Adds gradients.
    scatter: Scatter,
}

/// Why a list of elements makes no term.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StencilError {
    /// An element names a point twice.
    #[error("{term}: element {element} names point {point} twice")]
    RepeatedPoint {
        /// The term's name.
        term: String,
        /// The element.
        element: usize,
        /// The point.
        point: u32,
    },
}

impl<S: Stencil<N>, const N: usize> StencilTerm<S, N> {
    /// The sum of `stencil` over `elements`, each given by its point numbers; element `e` of the list is element
    /// `e` of the stencil.
    ///
    /// # Errors
    /// If an element names a point twice.
    pub fn new(name: impl Into<String>, stencil: S, elements: Vec<[u32; N]>) -> Result<Self, StencilError> {
        let name = name.into();
        let points = check(&name, &elements)?;
        let scatter = Scatter::default();
        Ok(Self { name, stencil, elements, points, scatter })
    }

    /// The stencil.
    pub fn stencil(&self) -> &S {
        &self.stencil
    }

    /// The stencil, to change its data (a stiffness, a rest shape).
    pub fn stencil_mut(&mut self) -> &mut S {
        &mut self.stencil
    }

    /// The elements' point numbers.
    pub fn elements(&self) -> &[[u32; N]] {
        &self.elements
    }

    /// Replaces the elements and the stencil that knows them.
    ///
    /// # Errors
    /// If an element names a point twice; nothing has changed then.
    pub fn replace(&mut self, stencil: S, elements: Vec<[u32; N]>) -> Result<(), StencilError> {
        self.points = check(&self.name, &elements)?;
        self.scatter = Scatter::default();
        (self.stencil, self.elements) = (stencil, elements);
        Ok(())
    }

    fn list(&self) -> StencilList<'_, &S, N> {
        StencilList { stencil: &self.stencil, elements: &self.elements }
    }

    fn check_points(&self, x: &[Vec3]) {
        assert!(
            self.points <= x.len(),
            "{}: an element names point {}, but there are {} points",
            self.name,
            self.points.saturating_sub(1),
            x.len()
        );
    }

    fn non_finite(&self, element: usize, quantity: Quantity, value: f64) -> PotentialError {
        let points = self.elements[element].to_vec();
        PotentialError::NonFinite { term: self.name.clone(), quantity, element, points, value }
    }
}

impl<S: Stencil<N>, const N: usize> Potential for StencilTerm<S, N> {
    fn name(&self) -> &str {
        &self.name
    }

    fn value(&self, x: &[Vec3]) -> f64 {
        self.check_points(x);
        let list = self.list();
        parallel::map_chunks(self.elements.len(), CHUNK, |range| list.value(range, x)).into_iter().sum()
    }

    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        self.check_points(x);
        assert_eq!(gradient.len(), x.len(), "one gradient per point");
        self.scatter.accumulate(&[&ListGradients { list: &self.list(), x }], gradient);
    }

    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        self.check_points(x);
        self.list().add_hessian(x, projection, hessian);
    }

    fn limit_step(&mut self, x: &[Vec3], p: &[Vec3]) -> Result<StepLimit, PotentialError> {
        self.check_points(x);
        assert_eq!(p.len(), x.len(), "one displacement per point");
        let limit = |e: usize| {
            let element = &self.elements[e];
            self.stencil.limit_step(e, &gather(element, x), &gather(element, p))
        };
        match parallel::minimum(self.elements.len(), CHUNK, limit) {
            None => Ok(StepLimit::FULL),
            Some((element, fraction)) if fraction >= 0.0 => Ok(StepLimit::by_element(fraction, element)),
            Some((element, fraction)) => {
                Err(PotentialError::StepLimit { term: self.name.clone(), element: Some(element), fraction })
            }
        }
    }

    fn demand(&self) -> Demand {
        self.stencil.demand()
    }

    fn locate(&self, x: &[Vec3], point: usize) -> Option<usize> {
        let pull = |(e, points): (usize, &[u32; N])| {
            let local = points.iter().position(|&other| other as usize == point)?;
            Some((e, self.stencil.gradient(e, &gather(points, x))[local].norm()))
        };
        let pulls = self.elements.iter().enumerate().filter_map(pull);
        pulls.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(element, _)| element)
    }

    fn diagnose(&self, x: &[Vec3]) -> Option<PotentialError> {
        self.elements.iter().enumerate().find_map(|(e, points)| {
            let x = gather(points, x);
            let value = self.stencil.value(e, &x);
            if !value.is_finite() {
                return Some(self.non_finite(e, Quantity::Value, value));
            }
            let gradient = self.stencil.gradient(e, &x);
            let entry = gradient.iter().flatten().find(|entry| !entry.is_finite());
            if let Some(&entry) = entry {
                return Some(self.non_finite(e, Quantity::Gradient, entry));
            }
            let hessian = self.stencil.hessian(e, &x, Projection::None);
            let lower = (0..N).flat_map(|i| (0..=i).map(move |j| (i, j)));
            let entry = lower
                .flat_map(|(i, j)| hessian[i][j].iter().copied().collect::<Vec<_>>())
                .find(|entry| !entry.is_finite());
            entry.map(|entry| self.non_finite(e, Quantity::Hessian, entry))
        })
    }
}

fn check<const N: usize>(term: &str, elements: &[[u32; N]]) -> Result<usize, StencilError> {
    let mut points = 0;
    for (element, corners) in elements.iter().enumerate() {
        for (k, &point) in corners.iter().enumerate() {
            if corners[..k].contains(&point) {
                return Err(StencilError::RepeatedPoint { term: term.to_owned(), element, point });
            }
            points = points.max(point as usize + 1);
        }
    }
    Ok(points)
}
