//! Who is on which side of what: checks that see a body which has passed right through another.

use crate::experiment::ExperimentError;
use ipc_contact::ContactError;
use ipc_contact::topology::{ClosedSurface, Location, Surface, linking_number};
use mechanics_core::potential::{Changed, Demand, Potential, PotentialError, StepLimit};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stage::Stage;
use mechanics_core::tensor::Vec3;

/// What must hold after every step.
pub(in crate::experiment) enum Watch {
    /// From each of the points the straight way to where it looks crosses no triangle of the surface.
    Sight { surface: Surface, points: Vec<u32>, towards: Towards },
    /// None of the points is inside the surface.
    Outside { surface: ClosedSurface, points: Vec<u32> },
    /// Two closed chains of points have a linking number.
    Linked { chains: [Vec<u32>; 2], number: i32 },
}

/// Where a point looks.
#[derive(Clone, Copy, Debug)]
pub(in crate::experiment) enum Towards {
    /// Straight up (+z), to this height (m).
    Above(f64),
    /// To the nearest point of the z axis.
    Axis,
}

impl Towards {
    fn from(self, point: &Vec3) -> Vec3 {
        match self {
            Self::Above(height) => Vec3::new(point.x, point.y, height),
            Self::Axis => Vec3::new(0.0, 0.0, point.z),
        }
    }
}

/// How many single questions were asked, and how many had the wrong answer.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::experiment) struct Found {
    pub(in crate::experiment) checks: u64,
    pub(in crate::experiment) failures: u64,
}

impl Found {
    /// One more question, with no wrong answer or one.
    fn add(&mut self, failures: u64) {
        self.checks += 1;
        self.failures += failures;
    }
}

impl Watch {
    /// That `points` see nothing of the triangles above them, up to a height (m).
    pub(in crate::experiment) fn above(
        triangles: Vec<[u32; 3]>,
        point_count: usize,
        points: impl IntoIterator<Item = u32>,
        height: f64,
    ) -> Result<Self, ExperimentError> {
        let surface = Surface::new(triangles, point_count).map_err(ExperimentError::stopped)?;
        Ok(Self::Sight { surface, points: points.into_iter().collect(), towards: Towards::Above(height) })
    }

    /// That `points` stay out of the body with this surface.
    pub(in crate::experiment) fn outside(
        triangles: Vec<[u32; 3]>,
        point_count: usize,
        points: impl IntoIterator<Item = u32>,
    ) -> Result<Self, ExperimentError> {
        let surface = Surface::new(triangles, point_count).and_then(Surface::closed);
        let surface = surface.map_err(ExperimentError::stopped)?;
        Ok(Self::Outside { surface, points: points.into_iter().collect() })
    }

    /// Checks it at the positions `x`.
    pub(in crate::experiment) fn check(&self, x: &[Vec3]) -> Result<Found, ExperimentError> {
        let mut found = Found::default();
        match self {
            Self::Sight { surface, points, towards } => {
                for &point in points {
                    let from = &x[point as usize];
                    match surface.crossings(x, from, &towards.from(from)) {
                        Ok(crossings) => found.add(u64::from(crossings.along + crossings.against > 0)),
                        Err(ContactError::OnSurface { .. }) => found.add(1),
                        Err(error) => return Err(ExperimentError::stopped(error)),
                    }
                }
            }
            Self::Outside { surface, points } => {
                for &point in points {
                    let location = surface.locate(x, &x[point as usize]).map_err(ExperimentError::stopped)?;
                    found.add(u64::from(location != Location::Off { winding: 0 }));
                }
            }
            Self::Linked { chains, number } => {
                let [first, second] = chains
                    .each_ref()
                    .map(|chain| chain.iter().map(|&p| x[p as usize]).collect::<Vec<Vec3>>());
                let linked = linking_number(&first, &second).map_err(ExperimentError::stopped)?;
                found.add(u64::from(linked != *number));
            }
        }
        Ok(found)
    }
}

/// Contact whose limit is asked for and ignored.
pub(in crate::experiment) struct Unlimited<'a>(pub(in crate::experiment) &'a mut dyn Potential);

impl Potential for Unlimited<'_> {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn value(&self, x: &[Vec3]) -> f64 {
        self.0.value(x)
    }

    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        self.0.add_gradient(x, gradient);
    }

    fn add_settled_gradient(&self, stage: &Stage<'_>, gradient: &mut [Vec3]) {
        self.0.add_settled_gradient(stage, gradient);
    }

    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        self.0.add_hessian(x, projection, hessian);
    }

    fn soften(&mut self, velocity: f64) {
        self.0.soften(velocity);
    }

    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        self.0.freeze(stage)
    }

    fn limit_step(&mut self, x: &[Vec3], p: &[Vec3]) -> Result<StepLimit, PotentialError> {
        self.0.limit_step(x, p).map(|_| StepLimit::FULL)
    }

    fn is_settled(&self, x: &[Vec3], p: &[Vec3]) -> bool {
        self.0.is_settled(x, p)
    }

    fn demand(&self) -> Demand {
        self.0.demand()
    }

    fn locate(&self, x: &[Vec3], point: usize) -> Option<usize> {
        self.0.locate(x, point)
    }

    fn diagnose(&self, x: &[Vec3]) -> Option<PotentialError> {
        self.0.diagnose(x)
    }
}
