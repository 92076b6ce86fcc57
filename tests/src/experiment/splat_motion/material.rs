//! Materials by name, and bodies of particles made of them.

use super::refused;
use crate::experiment::ExperimentError;
use crate::scene::quantity::{NonNegative, PoissonRatio, Positive};
use crate::scene::splats::{ParticleLaw, Preset};
use mechanics_core::law::Lame;
use mpm_constitutive::elastic::{FixedCorotated, Hencky, NeoHookean};
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_constitutive::plastic::{DruckerPrager, FrictionAngle, HerschelBulkley, Snow, VonMises, YieldStress};
use mpm_constitutive::{PointLaw, PointLawError, Viscosity, Viscous};
use mpm_core::{MpmError, Samples, Simulation};

/// What a body is made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Material {
    preset: Preset,
    law: Option<ParticleLaw>,
    density: Option<f64>,
}

impl Material {
    /// A preset, of which law and density may be replaced.
    pub(super) fn new(preset: Preset, law: Option<ParticleLaw>, density: Option<Positive>) -> Self {
        Self { preset, law, density: density.map(Positive::value) }
    }

    /// Density at rest \[kg/m³\].
    pub(super) fn density(&self) -> f64 {
        self.density.unwrap_or(match self.preset {
            Preset::Jelly | Preset::Water => 1000.0,
            Preset::Rubber => 1100.0,
            Preset::Foam => 100.0,
            Preset::Metal => 2700.0,
            Preset::Sand => 1600.0,
            Preset::Snow => 400.0,
        })
    }

    /// Adds a body of this material; its particles carry their total deformation. `key` is where the scene says so.
    pub(super) fn add_body(
        &self,
        simulation: &mut Simulation<f64, 3>,
        samples: Samples<'_, 3>,
        key: &str,
    ) -> Result<usize, ExperimentError> {
        let body = Body { simulation, density: self.density(), samples };
        let added = match self.law {
            Some(law) => body.of_law(law),
            None => body.of_preset(self.preset),
        };
        added.map_err(|error| match error {
            Refusal::Law(error) => refused(format!("{key}.law"), error),
            Refusal::Body(error) => refused(key, error),
        })
    }
}

/// Why there is no body.
enum Refusal {
    Law(PointLawError),
    Body(MpmError),
}

impl From<PointLawError> for Refusal {
    fn from(error: PointLawError) -> Self {
        Self::Law(error)
    }
}

struct Body<'a> {
    simulation: &'a mut Simulation<f64, 3>,
    density: f64,
    samples: Samples<'a, 3>,
}

/// Young's modulus \[Pa\] and Poisson's ratio as Lamé's constants.
fn lame(young: Positive, poisson: PoissonRatio) -> Result<Lame, Refusal> {
    solid(young.value(), poisson.value())
}

fn solid(young: f64, poisson: f64) -> Result<Lame, Refusal> {
    Lame::from_young_poisson(young, poisson).map_err(|error| Refusal::Law(error.into()))
}

impl Body<'_> {
    fn of<L: PointLaw + 'static>(self, law: L) -> Result<usize, Refusal> {
        self.simulation.add_tracked_body(law, self.density, self.samples).map_err(Refusal::Body)
    }

    fn of_preset(self, preset: Preset) -> Result<usize, Refusal> {
        match preset {
            Preset::Jelly => self.of(FixedCorotated::new(solid(6e4, 0.35)?)),
            Preset::Rubber => self.of(NeoHookean::new(solid(1e6, 0.45)?)),
            Preset::Foam => self.of(HerschelBulkley::new(solid(2e4, 0.3)?, 300.0, 30.0, 0.6)?),
            Preset::Metal => self.of(VonMises::new(solid(1e7, 0.33)?, YieldStress::linear(1e5, 2e5)?)?),
            Preset::Sand => {
                let angle = FrictionAngle::constant(35.0_f64.to_radians())?;
                self.of(DruckerPrager::new(solid(2e6, 0.3)?, angle, 0.0)?)
            }
            Preset::Snow => self.of(Snow::new(solid(1.4e5, 0.2)?, 2.5e-2, 7.5e-3, 10.0)?),
            Preset::Water => {
                let water = Tait::new(3e5, 7.0, Tension::Vanishes)?;
                self.of(Viscous::new(water, Viscosity::new(0.1, 0.0)?))
            }
        }
    }

    fn of_law(self, law: ParticleLaw) -> Result<usize, Refusal> {
        use ParticleLaw as Law;
        match law {
            Law::NeoHookean { young_modulus_pa, poisson_ratio } => {
                self.of(NeoHookean::new(lame(young_modulus_pa, poisson_ratio)?))
            }
            Law::FixedCorotated { young_modulus_pa, poisson_ratio } => {
                self.of(FixedCorotated::new(lame(young_modulus_pa, poisson_ratio)?))
            }
            Law::Hencky { young_modulus_pa, poisson_ratio } => {
                self.of(Hencky::new(lame(young_modulus_pa, poisson_ratio)?))
            }
            Law::Tait { bulk_modulus_pa, exponent, viscosity_pa_s } => {
                let fluid = Tait::new(bulk_modulus_pa.value(), exponent.value(), Tension::Vanishes)?;
                self.of(Viscous::new(fluid, Viscosity::new(viscosity_pa_s.value(), 0.0)?))
            }
            Law::VonMises { young_modulus_pa, poisson_ratio, yield_stress_pa, hardening_modulus_pa } => {
                let strength = YieldStress::linear(yield_stress_pa.value(), hardening_modulus_pa.value())?;
                self.of(VonMises::new(lame(young_modulus_pa, poisson_ratio)?, strength)?)
            }
            Law::DruckerPrager { young_modulus_pa, poisson_ratio, friction_angle_rad, cohesion_pa } => {
                let angle = FrictionAngle::constant(friction_angle_rad.value())?;
                let elasticity = lame(young_modulus_pa, poisson_ratio)?;
                self.of(DruckerPrager::new(elasticity, angle, cohesion_pa.value())?)
            }
            Law::Snow {
                young_modulus_pa,
                poisson_ratio,
                critical_compression,
                critical_stretch,
                hardening,
            } => {
                let elasticity = lame(young_modulus_pa, poisson_ratio)?;
                let limits = [critical_compression, critical_stretch, hardening].map(NonNegative::value);
                self.of(Snow::new(elasticity, limits[0], limits[1], limits[2])?)
            }
            Law::HerschelBulkley {
                young_modulus_pa,
                poisson_ratio,
                yield_stress_pa,
                consistency_pa_s,
                flow_index,
            } => self.of(HerschelBulkley::new(
                lame(young_modulus_pa, poisson_ratio)?,
                yield_stress_pa.value(),
                consistency_pa_s.value(),
                flow_index.value(),
            )?),
        }
    }
}
