//! Fault injection: terms that tell the truth but for one answer, or from one answer on, and the question what a step makes of every such lie.
//!
//! Used by the tests of every crate whose terms take part in a step.

#![allow(clippy::print_stdout, reason = "a test prints what it counted")]
#![allow(dead_code, reason = "each crate's tests use what they need")]

use mechanics_core::potential::{Changed, Demand, Potential, PotentialError, Quantity, StepLimit};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stage::Stage;
use mechanics_core::state::State;
use mechanics_core::tensor::{Mat3, Vec3};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What a term is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Question {
    Value,
    Gradient,
    Hessian,
    Limit,
    Freeze,
}

/// What it answers instead of the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Lie {
    /// This number: as the value, as an entry of the gradient or the Hessian, as the limit of a step.
    Number(f64),
    /// The opposite of the truth.
    Opposite,
    /// As a value: the truth and this much more than at the answer before \[J\], so that no step along a direction lowers it.
    Rising(f64),
    /// A typed error.
    Refusal,
}

/// Whether it lies again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lasting {
    Once,
    FromThenOn,
}

/// A lie, and when it is told.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fault {
    pub(crate) question: Question,
    pub(crate) lie: Lie,
    /// How many answers to the same question are true before.
    pub(crate) after: u64,
    pub(crate) lasting: Lasting,
}

/// Every lie that a step must see through. A finite lie about the Hessian is none of them: how far a minimum is away is read off the Hessian, and whether that is the
/// derivative of the gradient only the checker of derivatives can say.
pub(crate) const LIES: [(Question, Lie); 14] = [
    (Question::Value, Lie::Number(f64::NAN)),
    (Question::Value, Lie::Number(f64::INFINITY)),
    (Question::Value, Lie::Number(f64::NEG_INFINITY)),
    (Question::Value, Lie::Rising(1e3)),
    (Question::Gradient, Lie::Number(f64::NAN)),
    (Question::Gradient, Lie::Number(f64::INFINITY)),
    (Question::Gradient, Lie::Opposite),
    (Question::Hessian, Lie::Number(f64::NAN)),
    (Question::Hessian, Lie::Number(f64::INFINITY)),
    (Question::Limit, Lie::Number(f64::NAN)),
    (Question::Limit, Lie::Number(-0.5)),
    (Question::Limit, Lie::Number(1.5)),
    (Question::Limit, Lie::Number(0.0)),
    (Question::Freeze, Lie::Refusal),
];

/// Who decides when the terms of a step lie: shared by all of them, so that every answer of any is one in turn.
#[derive(Debug, Default)]
pub(crate) struct Switch {
    fault: Mutex<Option<Fault>>,
    asked: AtomicU64,
    told: AtomicU64,
}

impl Switch {
    pub(crate) fn fault(&self) -> MutexGuard<'_, Option<Fault>> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// From now on the terms lie like this, or not at all.
    pub(crate) fn set(&self, fault: Option<Fault>) {
        *self.fault() = fault;
        self.asked.store(0, Ordering::Relaxed);
        self.told.store(0, Ordering::Relaxed);
    }

    /// Lies told since.
    pub(crate) fn told(&self) -> u64 {
        self.told.load(Ordering::Relaxed)
    }

    /// Counts a question; answers the lie that is due.
    pub(crate) fn ask(&self, question: Question) -> Option<Lie> {
        let fault = (*self.fault()).filter(|fault| fault.question == question)?;
        let number = self.asked.fetch_add(1, Ordering::Relaxed);
        let due = match fault.lasting {
            Lasting::Once => number == fault.after,
            Lasting::FromThenOn => number >= fault.after,
        };
        self.told.fetch_add(u64::from(due), Ordering::Relaxed);
        due.then_some(fault.lie)
    }
}

/// A term that lies when its switch says so.
pub(crate) struct Lying<P> {
    pub(crate) term: P,
    switch: Arc<Switch>,
}

impl<P: Potential> Lying<P> {
    pub(crate) fn new(term: P, switch: &Arc<Switch>) -> Self {
        Self { term, switch: switch.clone() }
    }

    fn tell(&self, x: &[Vec3], gradient: &mut [Vec3], add: impl Fn(&P, &mut [Vec3])) {
        match self.switch.ask(Question::Gradient) {
            None | Some(Lie::Refusal | Lie::Rising(_)) => add(&self.term, gradient),
            Some(Lie::Number(number)) => {
                add(&self.term, gradient);
                gradient[x.len() - 1].y = number;
            }
            Some(Lie::Opposite) => {
                let mut own = vec![Vec3::zeros(); x.len()];
                add(&self.term, &mut own);
                gradient.iter_mut().zip(own).for_each(|(sum, own)| *sum -= own);
            }
        }
    }
}

impl<P: Potential> Potential for Lying<P> {
    fn name(&self) -> &str {
        self.term.name()
    }

    fn value(&self, x: &[Vec3]) -> f64 {
        match self.switch.ask(Question::Value) {
            Some(Lie::Number(number)) => number,
            Some(Lie::Opposite) => -self.term.value(x),
            Some(Lie::Rising(by)) => self.term.value(x) + by * self.switch.told() as f64,
            Some(Lie::Refusal) | None => self.term.value(x),
        }
    }

    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        self.tell(x, gradient, |term, gradient| term.add_gradient(x, gradient));
    }

    fn add_settled_gradient(&self, stage: &Stage<'_>, gradient: &mut [Vec3]) {
        self.tell(stage.x, gradient, |term, gradient| term.add_settled_gradient(stage, gradient));
    }

    fn soften(&mut self, velocity: f64) {
        self.term.soften(velocity);
    }

    /// The truth, and a block of zeros on the last point, in which lies are told.
    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        self.term.add_hessian(x, projection, hessian);
        let block = match self.switch.ask(Question::Hessian) {
            Some(Lie::Number(number)) => Mat3::from_diagonal_element(number),
            Some(Lie::Opposite | Lie::Rising(_) | Lie::Refusal) | None => Mat3::zeros(),
        };
        hessian.add(&[[x.len() as u32 - 1]], |_| [[block]]);
    }

    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        let changed = self.term.freeze(stage)?;
        match self.switch.ask(Question::Freeze) {
            None => Ok(changed),
            Some(_) => Err(self.refusal(Quantity::Value, f64::NAN)),
        }
    }

    fn limit_step(&mut self, x: &[Vec3], p: &[Vec3]) -> Result<StepLimit, PotentialError> {
        let limit = self.term.limit_step(x, p)?;
        match self.switch.ask(Question::Limit) {
            Some(Lie::Number(fraction)) => Ok(StepLimit { fraction, element: Some(7) }),
            _ => Ok(limit),
        }
    }

    fn is_settled(&self, x: &[Vec3], p: &[Vec3]) -> bool {
        self.term.is_settled(x, p)
    }

    fn demand(&self) -> Demand {
        self.term.demand()
    }

    fn locate(&self, x: &[Vec3], point: usize) -> Option<usize> {
        self.term.locate(x, point)
    }

    fn diagnose(&self, x: &[Vec3]) -> Option<PotentialError> {
        let lied = self.switch.told() > 0;
        self.term.diagnose(x).or_else(|| lied.then(|| self.refusal(Quantity::Gradient, f64::NAN)))
    }
}

impl<P: Potential> Lying<P> {
    fn refusal(&self, quantity: Quantity, value: f64) -> PotentialError {
        let term = self.term.name().to_owned();
        PotentialError::NonFinite { term, quantity, element: 7, points: vec![7], value }
    }
}

/// A step of a scene whose terms hang on a switch.
pub(crate) type Step = Box<dyn FnMut(&mut State) -> Result<(), String>>;

/// What came of the lies.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    pub(crate) errors: u32,
    /// Steps that were made all the same, and rightly.
    pub(crate) survived: u32,
    /// The farthest that such a step ended from the true one \[m\].
    pub(crate) farthest: f64,
}

/// Makes the step from `start` with every one of `lies` told at every answer in turn, once and from then on. A step that fails leaves the state as it was, bit for bit; one that does not
/// ends within `tolerance` \[m\] of the true end. After either, the same objects make the true step with the bits of objects that have seen no lie.
pub(crate) fn every_answer_in_turn(
    name: &str,
    lies: &[(Question, Lie)],
    start: &State,
    tolerance: f64,
    scene: impl Fn(&Arc<Switch>) -> Step,
) -> Tally {
    let switch = Arc::new(Switch::default());
    let mut truth = start.clone();
    scene(&switch)(&mut truth).unwrap();
    let mut step = scene(&switch);
    let mut tally = Tally::default();
    for &(question, lie) in lies {
        for lasting in [Lasting::Once, Lasting::FromThenOn] {
            for after in 0.. {
                let fault = Fault { question, lie, after, lasting };
                let mut state = start.clone();
                switch.set(Some(fault));
                let outcome = step(&mut state);
                let told = switch.told();
                switch.set(None);
                match outcome {
                    Err(error) => {
                        assert!(told > 0, "{name}: {error} without a lie");
                        assert_eq!(
                            state.hash(),
                            start.hash(),
                            "{name}: {fault:?}: {error} changed the state"
                        );
                        tally.errors += 1;
                    }
                    Ok(()) => {
                        let distances =
                            state.position.iter().zip(&truth.position).map(|(x, y)| (x - y).norm());
                        // A NaN is no distance.
                        let far = distances.fold(0.0, |far: f64, d| if d <= far { far } else { d });
                        assert!(
                            far <= tolerance,
                            "{name}: {fault:?} is believed: {far:e} m from the true end"
                        );
                        assert!(
                            state.velocity.iter().all(|v| v.iter().all(|v| v.is_finite())),
                            "{name}: {fault:?}"
                        );
                        tally.survived += u32::from(told > 0);
                        tally.farthest = tally.farthest.max(far);
                    }
                }
                let mut again = start.clone();
                step(&mut again).unwrap_or_else(|error| panic!("{name}: after {fault:?}: {error}"));
                assert_eq!(again.hash(), truth.hash(), "{name}: {fault:?} is not forgotten");
                if told == 0 {
                    break;
                }
            }
        }
    }
    println!("{name}: {tally:?}");
    tally
}
