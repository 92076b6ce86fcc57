//! What the person at the terminal sees while scenes run: a bar with the time left, or one line a scene.

use crate::record::{SceneRecord, Verdict};
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

/// Progress on standard error.
pub struct Progress {
    style: Style,
    start: Instant,
    rows_total: usize,
    rows_done: usize,
    rows_timed: usize,
}

#[derive(Clone, Copy, PartialEq)]
enum Style {
    Bar,
    Lines,
    Quiet,
}

impl Progress {
    /// Progress over so many rows: a bar where standard error is a terminal, else one line a scene.
    pub fn on_standard_error(rows_total: usize) -> Self {
        Self::new(if std::io::stderr().is_terminal() { Style::Bar } else { Style::Lines }, rows_total)
    }

    /// No output.
    pub fn quiet() -> Self {
        Self::new(Style::Quiet, 0)
    }

    fn new(style: Style, rows_total: usize) -> Self {
        Self { style, start: Instant::now(), rows_total, rows_done: 0, rows_timed: 0 }
    }

    /// A row is about to run.
    pub fn row_starts(&self, scene: &str) {
        if self.style == Style::Bar {
            self.show(&self.bar(scene, self.start.elapsed()));
        }
    }

    /// A row has run.
    pub fn row_ended(&mut self) {
        self.rows_done += 1;
        self.rows_timed += 1;
    }

    /// A scene has its verdict; so many of its rows did not run in this process.
    pub fn scene_ended(&mut self, scene: &SceneRecord, rows_not_run: usize) {
        self.rows_done += rows_not_run;
        let verdict = match &scene.verdict {
            Verdict::Passed => "passed".to_owned(),
            Verdict::Failed => "FAILED".to_owned(),
            Verdict::Skipped { reason } => format!("SKIPPED ({reason})"),
        };
        let seconds: f64 = scene.lines.iter().flat_map(|line| &line.rows).map(|row| row.seconds).sum();
        match self.style {
            Style::Bar => self.show(&format!("\r\x1b[K{verdict:8} {}\n", scene.name)),
            Style::Lines => self.show(&format!("{verdict:8} {}  {seconds:.3} s\n", scene.name)),
            Style::Quiet => {}
        }
    }

    /// Nothing more runs.
    pub fn end(&self) {
        if self.style == Style::Bar {
            self.show("\r\x1b[K");
        }
    }

    fn bar(&self, scene: &str, elapsed: Duration) -> String {
        const WIDTH: usize = 24;
        let filled = (WIDTH * self.rows_done).checked_div(self.rows_total).unwrap_or(0).min(WIDTH);
        let left = self.time_left(elapsed).map_or_else(|| "--:--".to_owned(), clock);
        let bar = format!("{}{}", "=".repeat(filled), " ".repeat(WIDTH - filled));
        format!("\r\x1b[K[{bar}] {}/{} rows, {left} left  {scene}", self.rows_done, self.rows_total)
    }

    /// Rows that ran here took this long each; those that are left are taken to be like them.
    fn time_left(&self, elapsed: Duration) -> Option<Duration> {
        let left = self.rows_total.saturating_sub(self.rows_done);
        (self.rows_timed > 0).then(|| elapsed.mul_f64(left as f64 / self.rows_timed as f64))
    }

    fn show(&self, text: &str) {
        // A closed standard error is no reason to stop a run.
        let _ = std::io::stderr().write_all(text.as_bytes()).and_then(|()| std::io::stderr().flush());
    }
}

fn clock(time: Duration) -> String {
    let seconds = time.as_secs_f64().round() as u64;
    format!("{}:{:02}", seconds / 60, seconds % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_follows_the_rows_that_ran() {
        let mut progress = Progress::new(Style::Bar, 10);
        assert_eq!(progress.time_left(Duration::from_secs(5)), None);
        progress.row_ended();
        progress.row_ended();
        assert_eq!(progress.time_left(Duration::from_secs(30)), Some(Duration::from_secs(120)));
        assert!(progress.bar("core/svd", Duration::from_secs(30)).contains("2/10 rows, 2:00 left  core/svd"));
    }
}
