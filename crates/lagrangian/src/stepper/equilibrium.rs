//! Static equilibrium: the same minimisation without inertia, the load put on in steps.

use super::minimisation::Minimisation;
use super::{StepError, StepReport, Stepper, Terms};
use mechanics_core::newton::Proceed;
use mechanics_core::objective::TimeStep;
use mechanics_core::point_map::PointMap;
use mechanics_core::stage::Scheme;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use std::time::Instant;

impl Stepper {
    /// Moves `state` to a minimum of the terms' energy near it, at rest.
    ///
    /// The load is put on in `load_steps` equal parts: at part k of n terms see the time k/n (so that a load with
    /// [`Amplitude::Ramp`](crate::element::Amplitude) is on by that part), fixed points stand that part of the way from where the
    /// state has them to their targets, and each equilibrium starts from the last, moved on by as much as the last part moved it as far
    /// as the terms admit, if the energy is lower there (the secant predictor of continuation: exact where the answer is linear in the
    /// load). Newton's tolerance is a length \[m\]. Time and step count of the state stay, its velocities become zero
    /// and its history is forgotten.
    ///
    /// A body that nothing holds has no unique equilibrium; the minimiser then shifts the Hessian's diagonal, and the report counts that.
    /// A start that is a saddle exactly has no gradient, so it is kept; whether the end is a minimum is in [`StepReport::minimum`].
    ///
    /// # Errors
    /// [`StepError`] names the culprit; the state is then as it was.
    ///
    /// # Panics
    /// If the state is not for as many points as the mass.
    ///
    /// # Reference
    /// E. L. Allgower, K. Georg, *Introduction to Numerical Continuation Methods*, SIAM, 2003, section 10.2 (secant predictors).
    pub fn equilibrium(
        &mut self,
        state: &mut State,
        terms: Terms<'_, '_>,
        load_steps: u32,
    ) -> Result<StepReport, StepError> {
        let begin = Instant::now();
        if load_steps == 0 {
            return Err(StepError::NoLoadSteps);
        }
        self.check_state(state)?;
        let mut report = StepReport::default();
        let mut x = state.position.clone();
        let mut q = vec![0.0; 3 * self.map.unknowns()];
        self.map.unknowns_into(&x, &mut q)?;
        let mut expected = q.clone();
        for part in 1..=load_steps {
            let fraction = f64::from(part) / f64::from(load_steps);
            let map = self.map_at(state, fraction)?;
            let time_step = TimeStep { time: fraction, step: 0.0, scheme: Scheme::statics(&x) };
            let minimisation = Minimisation { map: &map, start: &x, time_step, expected: &expected };
            let before = q.clone();
            self.minimise(terms, &minimisation, &mut q, &mut |_| Proceed::Continue, &mut report)?;
            if part == load_steps {
                report.minimum = self.verify(terms, &minimisation, &q);
            }
            expected
                .iter_mut()
                .zip(q.iter().zip(&before))
                .for_each(|(next, (q, before))| *next = 2.0 * q - before);
            map.points_into(&q, &mut x);
        }
        state.velocity.fill(Vec3::zeros());
        state.position = x;
        state.clear_history();
        report.time = begin.elapsed();
        Ok(report)
    }

    /// The map with scripted points a fraction of their way.
    fn map_at(&self, state: &State, fraction: f64) -> Result<PointMap, StepError> {
        let mut map = self.map.clone();
        if fraction < 1.0 {
            for &point in &self.scripted {
                let target = self.map.offset(point as usize);
                let start = state.position[point as usize];
                map.set_offset(point as usize, start + (target - start) * fraction)?;
            }
        }
        Ok(map)
    }
}
