//! Implicit steps: see the module `implicit` for what is solved.

use super::nodes::{NodeReport, NodeUpdate};
use super::{Simulation, StepReport};
use crate::MpmError;
use crate::body::{StepSettings, Travel};
use crate::collider::ColliderStage;
use crate::forecast::Span;
use crate::implicit::{Conditions, ImplicitError, ImplicitReport, ImplicitStep, Minimum, minimum, potential};
use crate::material::Stiffness;
use mechanics_core::lanes::{Element, dispatch};

/// Whether boundaries move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Regime {
    /// They do, and time passes.
    Motion,
    /// They stand still where they are.
    Rest,
}

impl<E: Element, const D: usize> Simulation<E, D> {
    /// One implicit step of h \[s\]: backward Euler, of any length. Steps of ten to a hundred times [`stable_step`](Self::stable_step) pay
    /// where stiffness, not motion, limits explicit ones.
    ///
    /// Boundaries act on the nodes that are inside of them at the begin: matter that flies more than about a cell in a step is seen too late.
    ///
    /// # Errors
    /// [`MpmError::Implicit`] if the solve fails, and what [`step_unchecked`](Self::step_unchecked) gives. The step is not made then, not
    /// in part either.
    pub fn step_implicitly(&mut self, step: f64, options: &ImplicitStep) -> Result<ImplicitReport, MpmError> {
        super::compiled::implicit_step(self, step, options, Regime::Motion)
    }

    /// The step; where it fails after particles were sorted, they are put back in their old order.
    pub(super) fn whole_implicit_step(
        &mut self,
        step: f64,
        options: &ImplicitStep,
        regime: Regime,
    ) -> Result<ImplicitReport, MpmError> {
        let kept = (!self.sorted).then(|| self.keep());
        let done = self.try_implicit_step(step, options, regime);
        if let (Err(_), Some(kept)) = (&done, kept) {
            self.put_back(kept);
        }
        done
    }

    fn try_implicit_step(
        &mut self,
        step: f64,
        options: &ImplicitStep,
        regime: Regime,
    ) -> Result<ImplicitReport, MpmError> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(MpmError::Step { value: step });
        }
        if !(options.tolerance > 0.0 && options.tolerance.is_finite()) {
            return Err(ImplicitError::Tolerance { value: options.tolerance }.into());
        }
        let count = self.colliders.iter().filter(|collider| collider.is_sheet()).count();
        if count > 0 {
            return Err(ImplicitError::NotKnown { what: "thin sheets", count }.into());
        }
        if self.options.transfer.passes() > 0 || self.options.transfer.position_part().is_some() {
            return Err(ImplicitError::Transfer.into());
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
        // Where nothing moves, no time passes.
        let (passing, speed) = if regime == Regime::Motion { (step, 1.0) } else { (0.0, 0.0) };
        let middle = self.time + 0.5 * passing;
        let grips = self.placed_grips(middle, step);
        let conditions = Conditions {
            grips: &grips,
            prescribed: &self.prescribed,
            boundaries: &self.boundaries,
            colliders: &ColliderStage::new(&self.colliders, self.time + passing, spacing),
            middle,
            end: self.time + passing,
            speed,
            gain: self.gravity.map(|g| g * step),
        };
        let problem = potential(&self.grid, &self.bodies, settings, &conditions);
        let Minimum { nodes, velocities, loads, report: mut done } = minimum(problem, &conditions, options)?;
        nodes.write(&mut self.grid, &velocities);
        self.spans.clear();
        self.spans.extend(self.grid.nodes_by_block().map(|(_, nodes)| Span::of_nodes(nodes)));
        self.foresee(&settings)?;
        let travel = self.gather_all(&settings);
        self.sorted = !travel.left;
        self.limits = Some((stiffness, travel));
        if regime == Regime::Motion {
            self.take_loads(&loads);
            self.time += step;
            self.steps += 1;
        }
        report.blocks = self.grid.block_count();
        report.speed = travel.speed_squared.sqrt();
        report.wave_speed = stiffness.wave.sqrt();
        done.step = report;
        Ok(done)
    }

    /// Mass, momentum and impulses of tractions of the particles to the nodes.
    fn scatter_without_stress(&mut self, settings: &StepSettings) -> Stiffness {
        // In no time stress has no impulse.
        let frozen = StepSettings { step: 0.0, ..*settings };
        self.scatter(&mut |body, blocks, (arenas, stride)| {
            let stiffness = body.scatter(blocks.clone(), (&mut *arenas, stride), &frozen);
            body.add_tractions(blocks, (arenas, stride), settings);
            stiffness
        })
    }

    /// Velocities of the nodes without stress and boundaries.
    fn forecast_nodes(&mut self, settings: &StepSettings) -> Result<(), MpmError> {
        let mut reports = vec![NodeReport::<D>::default(); self.grid.block_count()];
        let gain = self.gravity.map(|g| g * settings.step);
        self.grid.update(&mut reports, |origin, nodes, changes, report| {
            *report = dispatch(NodeUpdate::<E, D> { nodes, changes, gain });
            report.origin = *origin;
        });
        match reports.iter().find(|report| report.broken) {
            None => Ok(()),
            Some(report) => Err(self.culprit(Some(report.origin))),
        }
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use super::*;
    use crate::{Kernel, Samples, SimulationOptions, Transfer};
    use mechanics_core::law::Lame;
    use mechanics_core::objective::Objective;
    use mpm_constitutive::elastic::FixedCorotated;

    /// Value, gradient and product of the potential of one step against each other, by central differences.
    fn check<const D: usize>(kernel: Kernel, transfer: Transfer) {
        let options = SimulationOptions { spacing: 0.1, kernel, transfer };
        let mut simulation = Simulation::<f64, D>::new(options).unwrap();
        let line = 4_usize;
        let noise = |k: usize| (k as f64 * 0.618_033_988_749_894_9).fract() - 0.5;
        let positions: Vec<[f64; D]> = (0..line.pow(D as u32))
            .map(|k| {
                std::array::from_fn(|a| {
                    0.05 * ((k / line.pow(a as u32) % line) as f64 + 0.3 * noise(7 * k + a))
                })
            })
            .collect();
        let velocities = vec![[0.0; D]; positions.len()];
        let volumes = vec![0.05_f64.powi(D as i32); positions.len()];
        let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
        let law = FixedCorotated::new(Lame::from_young_poisson(1e5, 0.3).unwrap());
        simulation.add_body(law, 1000.0, samples).unwrap();
        simulation.sort().unwrap();
        let step = 10.0 * simulation.stable_step();
        let settings = StepSettings { step, spacing: 0.1, kernel, transfer };
        simulation.scatter_without_stress(&settings);
        simulation.forecast_nodes(&settings).unwrap();
        let conditions = Conditions {
            grips: &[],
            prescribed: &[],
            boundaries: &[],
            colliders: &ColliderStage::new(&[], 0.0, 0.1),
            middle: 0.5 * step,
            end: step,
            speed: 1.0,
            gain: [0.0; D],
        };
        let mut problem = potential(&simulation.grid, &simulation.bodies, settings, &conditions);
        let count = problem.dimension();
        // A stretch keeps the Hessian definite, so that nothing is projected.
        let rate = 0.2 / step;
        let x: Vec<f64> =
            (0..count).map(|i| rate * (problem.nodes.places[i / D][i % D] + 0.02 * noise(i))).collect();
        let d: Vec<f64> = (0..count).map(|i| 0.1 * rate * noise(3 * i + 1)).collect();
        let moved = |t: f64| -> Vec<f64> { x.iter().zip(&d).map(|(x, d)| x + t * d).collect() };
        let t = 1e-4;
        let mut gradients = [vec![0.0; count], vec![0.0; count], vec![0.0; count]];
        for (gradient, t) in gradients.iter_mut().zip([-t, t, 0.0]) {
            problem.gradient_into(&moved(t), gradient);
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let slope = (problem.value(&moved(t)) - problem.value(&moved(-t))) / (2.0 * t);
        let expected = dot(&gradients[2], &d);
        assert!((slope / expected - 1.0).abs() < 1e-6, "{kernel:?} {transfer:?}: slope {slope} {expected}");
        problem.linearise(&x);
        let product = problem.product(&d);
        let size = dot(&product, &product).sqrt();
        let difference: f64 = (0..count)
            .map(|i| ((gradients[1][i] - gradients[0][i]) / (2.0 * t) - product[i]).powi(2))
            .sum::<f64>()
            .sqrt();
        assert!(difference < 1e-6 * size, "{kernel:?} {transfer:?}: product {difference:e} of {size:e}");
        // The preconditioner's blocks are those of the Hessian.
        for node in [0, count / D / 2] {
            for a in 0..D {
                let unit: Vec<f64> = (0..count).map(|i| f64::from(u8::from(i == node * D + a))).collect();
                let column = problem.product(&unit);
                for b in 0..D {
                    let block = problem.blocks[node][(b, a)];
                    let error = (column[node * D + b] - block).abs();
                    assert!(error < 1e-10 * problem.blocks[node].norm(), "{kernel:?} {transfer:?}: {error}");
                }
            }
        }
    }

    #[test]
    fn value_gradient_and_product_belong_together() {
        for (kernel, transfer) in [
            (Kernel::Linear, Transfer::FLIP),
            (Kernel::Quadratic, Transfer::MlsApic),
            (Kernel::Quadratic, Transfer::APIC),
            (Kernel::Cubic, Transfer::MlsApic),
            (Kernel::Cubic, Transfer::Pic),
        ] {
            check::<2>(kernel, transfer);
        }
        check::<3>(Kernel::Quadratic, Transfer::MlsApic);
        check::<3>(Kernel::Quadratic, Transfer::APIC);
    }
}
