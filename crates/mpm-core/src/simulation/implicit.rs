//! Implicit steps: see the module `implicit` for what is solved.

use super::{Simulation, StepReport};
use crate::MpmError;
use crate::body::{StepSettings, Travel};
use crate::forecast::Span;
use crate::implicit::{Conditions, ImplicitError, ImplicitReport, ImplicitStep, solve};
use crate::material::Stiffness;
use mechanics_core::lanes::Element;

impl<E: Element, const D: usize> Simulation<E, D> {
    /// One implicit step of h \[s\], of any length that lets nothing move further than the boundaries can see: see [`ImplicitStep`].
    ///
    /// # Errors
    /// [`MpmError::Implicit`] if the solve fails, and what [`step_unchecked`](Self::step_unchecked) gives. The step is not made then, not
    /// in part either.
    pub fn step_implicitly(&mut self, step: f64, options: &ImplicitStep) -> Result<ImplicitReport, MpmError> {
        super::compiled::implicit_step(self, step, options)
    }

    pub(super) fn whole_implicit_step(
        &mut self,
        step: f64,
        options: &ImplicitStep,
    ) -> Result<ImplicitReport, MpmError> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(MpmError::Step { value: step });
        }
        if !(options.tolerance > 0.0 && options.tolerance.is_finite()) {
            return Err(ImplicitError::Tolerance { value: options.tolerance }.into());
        }
        let mut report = StepReport { step, ..StepReport::default() };
        if !self.sorted {
            self.sort()?;
            report.sorted = true;
        }
        let super::SimulationOptions { spacing, kernel, transfer } = self.options;
        let settings = StepSettings { step, spacing, kernel, transfer };
        let stiffness = self.scatter_without_stress(&settings);
        self.forecast_nodes(&settings)?;
        let conditions = Conditions {
            prescribed: &self.prescribed,
            boundaries: &self.boundaries,
            begin: self.time,
            end: self.time + step,
            gain: self.gravity.map(|g| g * step),
        };
        let (nodes, velocities, mut done) =
            solve(&self.grid, &self.bodies, settings, &conditions, options)?;
        nodes.write(&mut self.grid, &velocities);
        self.spans.clear();
        self.spans.extend(self.grid.blocks().map(|(_, nodes)| Span::of_nodes(nodes)));
        self.foresee(&settings)?;
        let travel = self.gather_all(&settings);
        self.sorted = !travel.left;
        self.limits = Some((stiffness, travel));
        self.time += step;
        self.steps += 1;
        report.blocks = self.grid.block_count();
        report.speed = travel.speed_squared.sqrt();
        report.wave_speed = stiffness.wave.sqrt();
        done.step = report;
        Ok(done)
    }

    /// Mass, momentum and impulses of tractions of the particles to the arenas.
    fn scatter_without_stress(&mut self, settings: &StepSettings) -> Stiffness {
        let stride = self.grid.arena_stride();
        // In no time stress has no impulse.
        let frozen = StepSettings { step: 0.0, ..*settings };
        let mut stiffness = Stiffness::default();
        let mut first = 0;
        for body in &mut self.bodies {
            let count = body.particles.blocks.len();
            let arenas = &mut self.arenas[first * stride..(first + count) * stride];
            stiffness = stiffness.merged(body.scatter(arenas, stride, &frozen));
            body.add_tractions(arenas, stride, settings);
            first += count;
        }
        stiffness
    }

    fn gather_all(&mut self, settings: &StepSettings) -> Travel {
        let mut travel = Travel::default();
        let mut first = 0;
        for body in &mut self.bodies {
            travel = travel.merged(body.gather(&self.grid, first, settings));
            first += body.particles.blocks.len();
        }
        travel
    }
}
