//! Counts and times of many queries.

use crate::oracle::Truth;
use ipc_contact::ccd::Impact;

/// What a method answered to a set of queries, against the truth.
#[derive(Default)]
pub(crate) struct Statistics {
    pub(crate) missed: usize,
    pub(crate) false_positives: usize,
    pub(crate) free: usize,
    pub(crate) undecided: usize,
    pub(crate) too_close: usize,
    /// Of contacts: true time minus answer.
    pub(crate) lag: Vec<f64>,
    microseconds: Vec<f64>,
}

impl Statistics {
    pub(crate) fn add(&mut self, impact: Impact, truth: &Truth, microseconds: f64) {
        self.microseconds.push(microseconds);
        self.too_close += usize::from(matches!(impact, Impact::StartsTooClose { .. }));
        match *truth {
            Truth::Free => {
                self.free += 1;
                self.false_positives += usize::from(impact != Impact::Free);
            }
            Truth::Undecided => self.undecided += 1,
            Truth::Contact([_, latest]) => {
                self.missed += usize::from(impact == Impact::Free || impact.fraction() > latest);
                self.lag.push(latest - impact.fraction());
            }
        }
    }

    pub(crate) fn print(&mut self, name: &str) {
        let times = &mut self.microseconds;
        times.sort_by(f64::total_cmp);
        self.lag.sort_by(f64::total_cmp);
        let count = times.len();
        println!(
            "{name:32} {count:7} queries: {} missed, {} false positives of {} free, {} undecided, {} start too close; \
             median lag {:.1e}; mean {:.2} µs, 99 % {:.2}, worst {:.1}",
            self.missed,
            self.false_positives,
            self.free,
            self.undecided,
            self.too_close,
            self.lag.get(self.lag.len() / 2).unwrap_or(&0.0),
            times.iter().sum::<f64>() / count as f64,
            times[count * 99 / 100],
            times[count - 1]
        );
    }
}
