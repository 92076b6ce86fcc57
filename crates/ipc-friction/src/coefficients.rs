//! Which surfaces have which coefficient of friction.

use crate::FrictionError;
use crate::law::FrictionCoefficient;
use ipc_contact::collision_mesh::CollisionMesh;
use std::collections::BTreeMap;

/// The coefficient of every pair of surfaces: one for all, and exceptions for pairs of objects of a
/// [`CollisionMesh`] and for half-spaces. What is stated later replaces what was stated before.
///
/// ```
/// use ipc_friction::coefficients::CoefficientTable;
/// use ipc_friction::law::FrictionCoefficient;
///
/// let rubber = FrictionCoefficient::with_kinetic(1.0, 0.8)?;
/// let table = CoefficientTable::uniform(FrictionCoefficient::new(0.3)?)
///     .with_objects([2, 0], rubber)
///     .with_half_space(0, FrictionCoefficient::NONE);
/// assert_eq!(table.of_objects(0, 2), rubber);
/// assert_eq!(table.of_objects(0, 1).at_rest(), 0.3);
/// assert_eq!(table.of_half_space(0, 1), FrictionCoefficient::NONE);
/// # Ok::<(), ipc_friction::FrictionError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CoefficientTable {
    all: FrictionCoefficient,
    /// By both objects, lower first.
    objects: BTreeMap<[u32; 2], FrictionCoefficient>,
    /// By half-space and object.
    half_spaces: BTreeMap<[u32; 2], FrictionCoefficient>,
    /// By half-space, for objects without one of their own.
    whole_half_spaces: BTreeMap<u32, FrictionCoefficient>,
}

impl CoefficientTable {
    /// One coefficient for all surfaces.
    pub fn uniform(coefficient: FrictionCoefficient) -> Self {
        Self { all: coefficient, ..Self::default() }
    }

    /// The same, with another coefficient between two objects, or of one with itself.
    pub fn with_objects(mut self, [a, b]: [u32; 2], coefficient: FrictionCoefficient) -> Self {
        self.objects.insert([a.min(b), a.max(b)], coefficient);
        self
    }

    /// The same, with another coefficient between a half-space and all objects that have none of their own with it.
    pub fn with_half_space(mut self, half_space: u32, coefficient: FrictionCoefficient) -> Self {
        self.whole_half_spaces.insert(half_space, coefficient);
        self
    }

    /// The same, with another coefficient between a half-space and an object.
    pub fn with_half_space_and_object(
        mut self,
        half_space: u32,
        object: u32,
        coefficient: FrictionCoefficient,
    ) -> Self {
        self.half_spaces.insert([half_space, object], coefficient);
        self
    }

    /// Between two objects.
    pub fn of_objects(&self, a: u32, b: u32) -> FrictionCoefficient {
        *self.objects.get(&[a.min(b), a.max(b)]).unwrap_or(&self.all)
    }

    /// Between a half-space and an object.
    pub fn of_half_space(&self, half_space: u32, object: u32) -> FrictionCoefficient {
        let own = self.half_spaces.get(&[half_space, object]);
        *own.or_else(|| self.whole_half_spaces.get(&half_space)).unwrap_or(&self.all)
    }

    /// Checks that all objects and half-spaces exist.
    ///
    /// # Errors
    /// The first that does not.
    pub fn check(&self, mesh: &CollisionMesh) -> Result<(), FrictionError> {
        let (objects, half_spaces) = (mesh.object_count(), mesh.half_spaces().len());
        let named = self.objects.keys().flatten().chain(self.half_spaces.keys().map(|[_, object]| object));
        if let Some(&object) = named.into_iter().find(|&&object| object as usize >= objects) {
            return Err(FrictionError::ObjectOutOfRange { object, objects });
        }
        let named = self.whole_half_spaces.keys().chain(self.half_spaces.keys().map(|[number, _]| number));
        match named.into_iter().find(|&&number| number as usize >= half_spaces) {
            Some(&half_space) => Err(FrictionError::HalfSpaceOutOfRange { half_space, half_spaces }),
            None => Ok(()),
        }
    }
}
