//! The clock an experiment is given, so that set-up and measuring do not count as work.

use std::time::{Duration, Instant};

/// Wall time of the work and of its terms.
#[derive(Clone, Debug, Default)]
pub struct Clock {
    work: Option<Duration>,
    terms: Vec<(String, Duration)>,
}

impl Clock {
    /// Runs a piece of the work that the scene is about; the pieces' times are added up.
    pub fn time<R>(&mut self, work: impl FnOnce() -> R) -> R {
        let start = Instant::now();
        let result = work();
        *self.work.get_or_insert_default() += start.elapsed();
        result
    }

    /// Adds to the cost of an active term (elasticity, contact, linear solve, …).
    pub fn add_term(&mut self, name: &str, cost: Duration) {
        match self.terms.iter_mut().find(|(term, _)| term == name) {
            Some((_, total)) => *total += cost,
            None => self.terms.push((name.to_owned(), cost)),
        }
    }

    /// The work's time, if any piece was timed.
    pub fn work(&self) -> Option<Duration> {
        self.work
    }

    /// The active terms and their costs, in the order they were first named.
    pub fn terms(&self) -> &[(String, Duration)] {
        &self.terms
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_and_terms_add_up() {
        let mut clock = Clock::default();
        assert_eq!(clock.work(), None);
        for _ in 0..2 {
            clock.time(|| std::thread::sleep(Duration::from_millis(2)));
            clock.add_term("contact", Duration::from_millis(3));
        }
        assert!(clock.work() >= Some(Duration::from_millis(4)));
        assert_eq!(clock.terms(), [("contact".to_owned(), Duration::from_millis(6))]);
    }
}
