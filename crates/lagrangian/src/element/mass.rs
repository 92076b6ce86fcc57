//! Mass of points: lumped or consistent, and what is conserved with it.
//!
//! The kinetic energy ½ Σₐᵦ mₐᵦ vₐ · v_b of velocities v = Σₐ Nₐ vₐ has the consistent masses mₐᵦ = ∫ ρ Nₐ N_b dV. Lumping keeps the
//! diagonal alone, scaled so that every element keeps its mass (Hinton, Rock, Zienkiewicz 1976):
//! mₐ = mₐₐ · Σ_bc m_bc / Σ_b m_bb. For linear elements that is an equal share for each vertex. Consistent mass
//! overestimates frequencies, lumped mass underestimates them in general.
//!
//! # Reference
//! Hinton, Rock, Zienkiewicz, *A note on mass lumping and related processes in the finite element method*, Earthquake
//! Engineering and Structural Dynamics 4 (1976); Hughes, *The Finite Element Method*, 2000, section 7.3.

use super::error::{ElementError, check_not_negative, check_points, check_positive, check_volume};
use mechanics_core::mesh::tet_volume;
use mechanics_core::stencil::StencilError;
use mechanics_core::tensor::Vec3;

/// How an element's mass is given to its vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MassDistribution {
    /// To the vertices alone: a diagonal matrix.
    #[default]
    Lumped,
    /// As the shape functions demand: neighbours are coupled.
    Consistent,
}

/// The mass matrix M of points \[kg\]: symmetric, one number for each pair of points, the same along x, y and z.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mass {
    diagonal: Vec<f64>,
    /// Pairs i > j, ascending.
    pairs: Vec<[u32; 2]>,
    /// mᵢⱼ of each pair.
    couplings: Vec<f64>,
}

impl Mass {
    /// No mass on any of `points` points.
    pub fn zeros(points: usize) -> Self {
        Self { diagonal: vec![0.0; points], ..Self::default() }
    }

    /// Adds a mass \[kg\] at one point.
    ///
    /// # Errors
    /// [`ElementError`] if the mass is negative or not finite, or if there is no such point.
    pub fn add_point(&mut self, point: u32, mass: f64) -> Result<(), ElementError> {
        check_not_negative("mass", "vertex", point as usize, mass)?;
        let points = self.diagonal.len();
        let out_of_range = ElementError::PointOutOfRange { element: point as usize, point, points };
        *self.diagonal.get_mut(point as usize).ok_or(out_of_range)? += mass;
        Ok(())
    }

    /// Adds linear tetrahedra of density ρ [kg/m³], their vertices at rest in `points` \[m\]: mₐᵦ = ρV(1 + δₐᵦ)/20.
    ///
    /// # Errors
    /// [`ElementError`] names the density, element or vertex that is wrong; nothing has changed then.
    pub fn add_tetrahedra(
        &mut self,
        points: &[Vec3],
        cells: &[[u32; 4]],
        density: f64,
        distribution: MassDistribution,
    ) -> Result<(), ElementError> {
        check_positive("density", "material", 0, density)?;
        check_points(points, cells)?;
        let volumes: Vec<f64> =
            cells.iter().map(|cell| tet_volume(&cell.map(|i| points[i as usize]))).collect();
        for (element, cell) in cells.iter().enumerate() {
            check_volume(element, &cell.map(|i| points[i as usize]))?;
        }
        let share =
            |element: usize, a: usize, b: usize| density * volumes[element] * if a == b { 0.1 } else { 0.05 };
        self.add_elements(cells, distribution, |element| {
            std::array::from_fn(|a| std::array::from_fn(|b| share(element, a, b)))
        })
    }

    /// Adds elements by their consistent masses `local(element)[a][b]` \[kg\], of which the diagonal and the lower
    /// triangle are read.
    ///
    /// # Errors
    /// [`ElementError`] names an element whose diagonal or whole mass is not positive, whose couplings are not finite, or whose
    /// vertex does not exist or is named twice; nothing has changed then.
    pub fn add_elements<const N: usize>(
        &mut self,
        elements: &[[u32; N]],
        distribution: MassDistribution,
        local: impl Fn(usize) -> [[f64; N]; N],
    ) -> Result<(), ElementError> {
        let mut diagonal = self.diagonal.clone();
        let mut couplings: Vec<([u32; 2], f64)> = Vec::new();
        for (element, corners) in elements.iter().enumerate() {
            let mut local = local(element);
            check_local(element, corners, &local)?;
            if distribution == MassDistribution::Lumped {
                local = lumped(&local);
            }
            for (a, &point) in corners.iter().enumerate() {
                check_positive("mass", "element", element, local[a][a])?;
                let points = diagonal.len();
                let out_of_range = ElementError::PointOutOfRange { element, point, points };
                *diagonal.get_mut(point as usize).ok_or(out_of_range)? += local[a][a];
                for (b, &other) in corners[..a].iter().enumerate() {
                    if local[a][b] != 0.0 {
                        couplings.push(([point.max(other), point.min(other)], local[a][b]));
                    }
                }
            }
        }
        self.diagonal = diagonal;
        self.add_couplings(couplings);
        Ok(())
    }

    /// Merges couplings into the sorted list, equal pairs summed in the order given.
    fn add_couplings(&mut self, new: Vec<([u32; 2], f64)>) {
        let mut all: Vec<([u32; 2], f64)> =
            self.pairs.iter().copied().zip(self.couplings.iter().copied()).chain(new).collect();
        all.sort_by_key(|&(pair, _)| pair);
        self.pairs.clear();
        self.couplings.clear();
        for (pair, mass) in all {
            match (self.pairs.last(), self.couplings.last_mut()) {
                (Some(last), Some(coupling)) if *last == pair => *coupling += mass,
                _ => {
                    self.pairs.push(pair);
                    self.couplings.push(mass);
                }
            }
        }
    }

    /// The number of points.
    pub fn points(&self) -> usize {
        self.diagonal.len()
    }

    /// mᵢᵢ \[kg\].
    pub fn diagonal(&self) -> &[f64] {
        &self.diagonal
    }

    /// The pairs i > j of points that are coupled, and mᵢⱼ \[kg\] of each.
    pub fn couplings(&self) -> (&[[u32; 2]], &[f64]) {
        (&self.pairs, &self.couplings)
    }

    /// Whether the matrix is diagonal.
    pub fn distribution(&self) -> MassDistribution {
        if self.pairs.is_empty() { MassDistribution::Lumped } else { MassDistribution::Consistent }
    }

    /// The mass that each point has in a common motion \[kg\]: Σⱼ mᵢⱼ.
    pub fn row_sums(&self) -> Vec<f64> {
        let mut sums = self.diagonal.clone();
        for (&[i, j], mass) in self.pairs.iter().zip(&self.couplings) {
            sums[i as usize] += mass;
            sums[j as usize] += mass;
        }
        sums
    }

    /// Σ mᵢⱼ \[kg\].
    pub fn total(&self) -> f64 {
        mechanics_core::diagnostics::total_mass(&self.row_sums())
    }

    /// Adds `factor` M `v` to `out`.
    ///
    /// # Panics
    /// If there is not one vector per point.
    pub fn add_product(&self, factor: f64, v: &[Vec3], out: &mut [Vec3]) {
        assert_eq!(v.len(), self.points(), "one vector per point");
        assert_eq!(out.len(), self.points(), "one vector per point");
        for ((out, v), mass) in out.iter_mut().zip(v).zip(&self.diagonal) {
            *out += v * (factor * mass);
        }
        for (&[i, j], mass) in self.pairs.iter().zip(&self.couplings) {
            let (i, j) = (i as usize, j as usize);
            out[i] += v[j] * (factor * mass);
            out[j] += v[i] * (factor * mass);
        }
    }

    /// The momenta p = M v of the points [kg m/s].
    ///
    /// # Panics
    /// If there is not one velocity per point.
    pub fn momenta(&self, velocity: &[Vec3]) -> Vec<Vec3> {
        let mut momenta = vec![Vec3::zeros(); self.points()];
        self.add_product(1.0, velocity, &mut momenta);
        momenta
    }

    /// ½ vᵀ M v \[J\].
    ///
    /// # Panics
    /// If there is not one velocity per point.
    pub fn kinetic_energy(&self, velocity: &[Vec3]) -> f64 {
        let mut sum = mechanics_core::diagnostics::CompensatedSum::new();
        self.momenta(velocity).iter().zip(velocity).for_each(|(p, v)| sum.add(0.5 * p.dot(v)));
        sum.value()
    }

    /// Σ (M v)ᵢ [kg m/s].
    ///
    /// # Panics
    /// If there is not one velocity per point.
    pub fn linear_momentum(&self, velocity: &[Vec3]) -> Vec3 {
        mechanics_core::diagnostics::linear_momentum(&vec![1.0; self.points()], &self.momenta(velocity))
    }

    /// Σ (xᵢ − `about`) × (M v)ᵢ [kg m²/s].
    ///
    /// # Panics
    /// If there is not one position and one velocity per point.
    pub fn angular_momentum(&self, position: &[Vec3], velocity: &[Vec3], about: &Vec3) -> Vec3 {
        let ones = vec![1.0; self.points()];
        mechanics_core::diagnostics::angular_momentum(&ones, position, &self.momenta(velocity), about)
    }
}

/// Refuses a matrix that is no mass before lumping turns it into one.
fn check_local<const N: usize>(
    element: usize,
    corners: &[u32; N],
    local: &[[f64; N]; N],
) -> Result<(), ElementError> {
    let mut total = 0.0;
    for a in 0..N {
        if corners[..a].contains(&corners[a]) {
            let term = "mass".to_owned();
            return Err(StencilError::RepeatedPoint { term, element, point: corners[a] }.into());
        }
        check_positive("mass", "element", element, local[a][a])?;
        total += local[a][a] + 2.0 * local[a][..a].iter().sum::<f64>();
    }
    check_positive("whole mass", "element", element, total)
}

/// The diagonal, scaled to the whole mass.
fn lumped<const N: usize>(local: &[[f64; N]; N]) -> [[f64; N]; N] {
    let trace: f64 = (0..N).map(|a| local[a][a]).sum();
    let off: f64 = (0..N).flat_map(|a| (0..a).map(move |b| local[a][b])).sum();
    let total = trace + 2.0 * off;
    let mut lumped = [[0.0; N]; N];
    for a in 0..N {
        lumped[a][a] = local[a][a] * (total / trace);
    }
    lumped
}
