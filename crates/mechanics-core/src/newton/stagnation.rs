//! Whether steps still shrink, and what rounding does to the unknowns; the rule is derived in the parent module.

/// A gradient of so many roundings is noise: an element's gradient takes a few operations, each rounded.
pub(super) const ROUNDINGS: f64 = 8.0;
/// A step norm below this part of the shortest so far is progress.
const PROGRESS: f64 = 0.9;
/// Iterations without progress after which the directions must be wrong.
const PATIENCE: u32 = 25;

/// The shortest step of those whose effect on the value is lost in its rounding.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stagnation {
    pub(super) shortest: f64,
    /// Steps since then.
    since: u32,
}

impl Default for Stagnation {
    fn default() -> Self {
        Self { shortest: f64::INFINITY, since: 0 }
    }
}

impl Stagnation {
    pub(super) fn record(&mut self, step_norm: f64) {
        if step_norm < PROGRESS * self.shortest {
            *self = Self { shortest: step_norm, since: 0 };
        } else {
            self.since += 1;
        }
    }

    pub(super) fn is_suspected(&self) -> bool {
        self.since > 0
    }

    pub(super) fn is_certain(&self) -> bool {
        self.since >= PATIENCE
    }
}

/// xᵢ ± ε max(|xᵢ|, mean |x|), with signs that look random and are the same every time.
pub(super) fn moved_by_rounding(x: &[f64]) -> Vec<f64> {
    let mean = x.iter().map(|x| x.abs()).sum::<f64>() / x.len() as f64;
    let sign = |i: usize| if (i as f64 * 0.618_033_988_749_894_9).fract() < 0.5 { 1.0 } else { -1.0 };
    x.iter().enumerate().map(|(i, x)| x + sign(i) * f64::EPSILON * x.abs().max(mean)).collect()
}
