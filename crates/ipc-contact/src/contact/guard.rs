//! Which positions are known to be free of intersections, and why.

use mechanics_core::tensor::Vec3;

/// Positions that need no look: those last found or accepted, and those on the segment that detection last cleared.
#[derive(Clone, Debug, Default)]
pub(super) struct Guard {
    accepted: Option<Vec<Vec3>>,
    cleared: Option<Segment>,
}

/// The positions x + α p with 0 ≤ α ≤ `fraction`.
#[derive(Clone, Debug)]
struct Segment {
    x: Vec<Vec3>,
    p: Vec<Vec3>,
    fraction: f64,
}

/// Rounding of positions on a segment, relative to the largest coordinate and displacement there: a map from unknowns to points rounds a few times.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

impl Guard {
    /// Whether `x` is known to be free of intersections.
    pub(super) fn knows(&self, x: &[Vec3]) -> bool {
        self.accepted.as_deref() == Some(x) || self.cleared.as_ref().is_some_and(|segment| segment.holds(x))
    }

    /// The positions last accepted.
    pub(super) fn accepted(&self) -> Option<&[Vec3]> {
        self.accepted.as_deref()
    }

    /// From now on `x` is known, and every position that was known before is not.
    pub(super) fn accept(&mut self, x: &[Vec3]) {
        if self.accepted.as_deref() == Some(x) {
            return;
        }
        overwrite(self.accepted.get_or_insert_default(), x);
        self.cleared = None;
    }

    /// Detection cleared the step from `x` along `p` up to `fraction`.
    pub(super) fn clear(&mut self, x: &[Vec3], p: &[Vec3], fraction: f64) {
        let empty = || Segment { x: Vec::new(), p: Vec::new(), fraction };
        let segment = self.cleared.get_or_insert_with(empty);
        overwrite(&mut segment.x, x);
        overwrite(&mut segment.p, p);
        segment.fraction = fraction;
    }
}

impl Segment {
    /// Whether `y` is x + α p up to rounding. The coordinate with the largest displacement says which α.
    fn holds(&self, y: &[Vec3]) -> bool {
        if y.len() != self.x.len() {
            return false;
        }
        let (mut displacement, mut moved, mut place) = (0.0_f64, 0.0, 0.0);
        for ((x, p), y) in self.x.iter().zip(&self.p).zip(y) {
            for k in 0..3 {
                if p[k].abs() > displacement.abs() {
                    (displacement, moved, place) = (p[k], y[k] - x[k], x[k]);
                }
            }
        }
        let part = if displacement == 0.0 { 0.0 } else { moved / displacement };
        // A short way from a far place ends where a few roundings of that place say.
        let far = 4.0 * f64::EPSILON * if displacement == 0.0 { 0.0 } else { (place / displacement).abs() };
        if !(part >= -ROUNDING - far && part <= self.fraction * (1.0 + ROUNDING) + far) {
            return false;
        }
        let largest = |v: &[Vec3]| v.iter().fold(0.0_f64, |size, v| size.max(v.amax()));
        // What has not been gone of a long way rounds nothing.
        let size = largest(&self.x) + part.abs() * displacement.abs();
        let near = |(x, p, y): (&Vec3, &Vec3, &Vec3)| (x + p * part - y).amax() <= ROUNDING * size;
        self.x.iter().zip(&self.p).zip(y).all(|((x, p), y)| near((x, p, y)))
    }
}

fn overwrite(target: &mut Vec<Vec3>, source: &[Vec3]) {
    target.clear();
    target.extend_from_slice(source);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knows_what_was_accepted_and_what_was_cleared_and_nothing_else() {
        let x = [Vec3::new(1.0, 2.0, 3.0), Vec3::new(-1.0, 0.0, 1e3)];
        let p = [Vec3::new(0.1, 0.0, -0.3), Vec3::new(1e-9, 0.0, 0.7)];
        let at = |part: f64| [x[0] + p[0] * part, x[1] + p[1] * part];
        let mut guard = Guard::default();
        assert!(!guard.knows(&x));
        guard.accept(&x);
        assert!(guard.knows(&x) && !guard.knows(&at(0.5)));
        guard.clear(&x, &p, 0.75);
        for part in [0.0, 0.1, 1.0 / 3.0, 0.75] {
            assert!(guard.knows(&at(part)), "{part}");
        }
        assert!(!guard.knows(&at(0.76)) && !guard.knows(&at(-0.01)));
        let mut beside = at(0.5);
        beside[0].y += 1e-9;
        assert!(!guard.knows(&beside));
        guard.accept(&at(0.5));
        assert!(guard.knows(&at(0.5)) && !guard.knows(&at(0.4)) && !guard.knows(&x));
        assert!(!guard.knows(&[Vec3::new(f64::NAN, 0.0, 0.0), x[1]]));
    }

    #[test]
    fn knows_the_end_of_a_short_step_far_from_the_origin() {
        let (x, p) = ([Vec3::new(1.0, 2e3, 3.0)], [Vec3::new(1e-5, -2e-4, 1e-5)]);
        for k in 1..1000 {
            let fraction = 1e-3 * f64::from(k);
            let mut guard = Guard::default();
            guard.accept(&x);
            guard.clear(&x, &p, fraction);
            assert!(guard.knows(&[x[0] + p[0] * fraction]), "{fraction}");
            assert!(!guard.knows(&[x[0] + p[0] * (fraction + 1e-6)]), "{fraction}");
        }
    }
}
