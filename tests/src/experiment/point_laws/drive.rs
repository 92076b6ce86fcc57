//! Many material points under one law, in the lanes of a grid code, driven along paths.

use crate::experiment::Clock;
use mechanics_core::lanes::{Element, LaneKernel, Packet, dispatch};
use mechanics_core::state::StateHash;
use mechanics_core::tensor::{Mat3, Matrix3, from_entries};
use mpm_constitutive::{Motion, Numbers, PointLaw, Strain};
use nalgebra::Rotation3;
use std::time::{Duration, Instant};

/// Material points that can be deformed further, whatever their law and precision.
pub(super) trait Specimens {
    /// Takes the displacement gradients of the next step.
    fn load(&mut self, increments: &[Mat3]);
    /// A step of `step` seconds with them.
    fn run(&mut self, step: f64);
    /// The Kirchhoff stress of a point after the last step \[Pa\].
    fn stress(&self, point: usize) -> Mat3;
    /// Number `k` of the history of a point.
    fn history(&self, point: usize, k: usize) -> f64;
    /// J of the strain of a point.
    fn volume_ratio(&self, point: usize) -> f64;
}

/// Virgin points of `law`, with numbers of the type that the method's name ends with.
pub(super) fn specimens<L: PointLaw + 'static>(law: L, method: &str, points: usize) -> Box<dyn Specimens> {
    if method.ends_with("f32") {
        Box::new(Batch::<L, f32>::new(law, points))
    } else {
        Box::new(Batch::<L, f64>::new(law, points))
    }
}

/// Points in arrays, one for each number, as a grid code stores them.
struct Batch<L, E> {
    law: L,
    /// Points in an array: as many as whole packets need.
    count: usize,
    strain: Vec<E>,
    history: Vec<E>,
    increments: Vec<E>,
    stress: Vec<E>,
}

impl<L: PointLaw, E: Element> Batch<L, E> {
    fn new(law: L, points: usize) -> Self {
        let count = points.next_multiple_of(E::LANES);
        let zeros = |numbers: usize| vec![E::constant(0.0); numbers * count];
        let virgin = L::Strain::<E>::undeformed();
        let numbers = <L::Strain<E> as Numbers<E>>::COUNT;
        Self {
            law,
            count,
            strain: (0..numbers * count).map(|k| virgin.number(k / count)).collect(),
            history: zeros(<L::History<E> as Numbers<E>>::COUNT),
            increments: zeros(9),
            stress: zeros(9),
        }
    }
}

/// A step of all points.
struct Step<'a, L, E> {
    batch: &'a mut Batch<L, E>,
    step: f64,
}

impl<L: PointLaw, E: Element> LaneKernel<E> for Step<'_, L, E> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) {
        let Batch { law, count, strain, history, increments, stress } = self.batch;
        let (count, rate) = (*count, P::constant(1.0 / self.step));
        for i in (0..count).step_by(P::LANES) {
            let f = L::Strain::<P>::from_numbers(|k| P::load(&strain[k * count + i..]));
            let mut state = L::History::<P>::from_numbers(|k| P::load(&history[k * count + i..]));
            let velocity_gradient: Matrix3<P> =
                from_entries(|a, b| P::load(&increments[(3 * b + a) * count + i..]) * rate);
            let (f, found) = law.advance(&f, &mut state, &Motion { velocity_gradient, step: self.step });
            for k in 0..L::Strain::<P>::COUNT {
                f.number(k).store(&mut strain[k * count + i..]);
            }
            for k in 0..L::History::<P>::COUNT {
                state.number(k).store(&mut history[k * count + i..]);
            }
            for k in 0..9 {
                found.kirchhoff.number(k).store(&mut stress[k * count + i..]);
            }
        }
    }
}

impl<L: PointLaw, E: Element> Specimens for Batch<L, E> {
    fn load(&mut self, increments: &[Mat3]) {
        for (point, increment) in increments.iter().enumerate() {
            for k in 0..9 {
                self.increments[k * self.count + point] = E::constant(increment.number(k));
            }
        }
    }

    fn run(&mut self, step: f64) {
        dispatch(Step { batch: self, step });
    }

    fn stress(&self, point: usize) -> Mat3 {
        Mat3::from_numbers(|k| self.stress[k * self.count + point].into())
    }

    fn history(&self, point: usize, k: usize) -> f64 {
        self.history[k * self.count + point].into()
    }

    fn volume_ratio(&self, point: usize) -> f64 {
        L::Strain::<E>::from_numbers(|k| self.strain[k * self.count + point]).volume_ratio().into()
    }
}

/// Where points are looked at along a path.
pub(super) const STATIONS: usize = 25;

/// A path of deformation of several points, each in a frame of its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    pub(super) points: usize,
    /// Steps from one station to the next.
    pub(super) steps: usize,
    /// Of the whole path \[s\].
    pub(super) duration: f64,
}

impl Course {
    /// The course whose steps cover the part `ladder` of the path, as nearly as whole steps between stations allow.
    pub(super) fn new(points: usize, ladder: f64, duration: f64) -> Self {
        let steps = (1.0 / (STATIONS as f64 * ladder)).round().max(1.0) as usize;
        Self { points, steps, duration }
    }

    /// Steps of the path.
    pub(super) fn total(&self) -> usize {
        STATIONS * self.steps
    }

    /// Steps of all points.
    pub(super) fn updates(&self) -> u64 {
        (self.total() * self.points) as u64
    }

    /// Takes the specimens along: `deformation` is F of a point after step k of [`total`](Self::total), from k = 1, in its own frame. `look`
    /// sees the stress of each point at every station from 1, in that frame too.
    pub(super) fn run(
        &self,
        specimens: &mut dyn Specimens,
        clock: &mut Clock,
        deformation: impl Fn(usize, usize) -> Mat3,
        mut look: impl FnMut(usize, usize, &Mat3, &dyn Specimens),
    ) {
        let frames: Vec<Mat3> = (0..self.points).map(frame).collect();
        let mut inverses: Vec<Mat3> = vec![Mat3::identity(); self.points];
        let mut increments = vec![Mat3::zeros(); self.points];
        let mut spent = Duration::ZERO;
        for k in 1..=self.total() {
            for (point, frame) in frames.iter().enumerate() {
                let f = deformation(point, k);
                increments[point] = frame * (f * inverses[point] - Mat3::identity()) * frame.transpose();
                inverses[point] = f.try_inverse().unwrap_or_else(Mat3::zeros);
            }
            specimens.load(&increments);
            let start = Instant::now();
            clock.time(|| specimens.run(self.duration / self.total() as f64));
            spent += start.elapsed();
            if k % self.steps == 0 {
                for (point, frame) in frames.iter().enumerate() {
                    let stress = frame.transpose() * specimens.stress(point) * frame;
                    look(k / self.steps, point, &stress, specimens);
                }
            }
        }
        clock.add_term("a million point updates", spent.mul_f64(1e6 / self.updates() as f64));
    }
}

/// The frame in which a point is deformed: another one for each, so that no axis is special.
fn frame(point: usize) -> Mat3 {
    let angle = 0.7 + point as f64;
    Rotation3::from_euler_angles(angle, 1.3 * angle, 0.4 * angle).into_inner()
}

/// A hash of the stresses of all points.
pub(super) fn stress_hash(specimens: &dyn Specimens, points: usize) -> u64 {
    let mut hash = StateHash::new();
    for point in 0..points {
        hash.add("stress", specimens.stress(point).as_slice());
    }
    hash.value()
}

/// The largest magnitude of what it is given.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Largest(pub(super) f64);

impl Largest {
    pub(super) fn take(&mut self, value: f64) {
        // NaN is kept.
        self.0 = if value.abs() <= self.0 { self.0 } else { value.abs() };
    }
}
