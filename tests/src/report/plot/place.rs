//! Where labels go: beside the end of their line where nothing is, else in the margin.

/// An upright rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rect {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Rect {
    fn overlaps(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }

    fn within(&self, other: &Self) -> bool {
        self.left >= other.left
            && self.right <= other.right
            && self.top >= other.top
            && self.bottom <= other.bottom
    }

    /// Whether the segment a–b enters the rectangle (Liang and Barsky 1984: clip the parameter interval side by side).
    fn meets(&self, a: (f64, f64), b: (f64, f64)) -> bool {
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let sides =
            [(-dx, a.0 - self.left), (dx, self.right - a.0), (-dy, a.1 - self.top), (dy, self.bottom - a.1)];
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for (towards, room) in sides {
            if towards == 0.0 {
                if room < 0.0 {
                    return false;
                }
            } else if towards < 0.0 {
                enter = enter.max(room / towards);
            } else {
                leave = leave.min(room / towards);
            }
        }
        enter < leave
    }
}

/// What is already drawn.
#[derive(Clone, Debug, Default)]
pub(super) struct Drawn {
    rects: Vec<Rect>,
    segments: Vec<[(f64, f64); 2]>,
}

impl Drawn {
    pub(super) fn add_rect(&mut self, rect: Rect) {
        self.rects.push(rect);
    }

    pub(super) fn add_marker(&mut self, (x, y): (f64, f64)) {
        let r = super::marker::RADIUS + 1.5;
        self.add_rect(Rect { left: x - r, right: x + r, top: y - r, bottom: y + r });
    }

    pub(super) fn add_polyline(&mut self, points: &[(f64, f64)]) {
        self.segments.extend(points.windows(2).map(|pair| [pair[0], pair[1]]));
    }

    /// How many drawn things `rect` would cover.
    pub(super) fn conflicts(&self, rect: &Rect) -> usize {
        let rects = self.rects.iter().filter(|drawn| drawn.overlaps(rect)).count();
        rects + self.segments.iter().filter(|[a, b]| rect.meets(*a, *b)).count()
    }
}

/// A label with its place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Label {
    /// Where its text begins, and its baseline.
    pub(super) at: (f64, f64),
    /// Where a thin line ties it to its line, if it is not beside it.
    pub(super) tie: Option<[(f64, f64); 2]>,
}

/// Height of a label.
pub(super) const HEIGHT: f64 = 15.0;

/// Labels in the margin are moved by this.
const STEP: f64 = HEIGHT / 3.0;

/// Width that `text` takes: an estimate for wide sans-serifs (DejaVu) at 12.5 units; others are narrower.
pub(super) fn text_width(text: &str) -> f64 {
    7.2 * text.chars().count() as f64
}

/// Places a label for every line. `lines[i]` are the drawn points of line i (none: it goes to the margin without a tie);
/// labels stay within `bounds`; the margin column begins at `margin`.
pub(super) fn labels(
    drawn: &mut Drawn,
    lines: &[Vec<(f64, f64)>],
    widths: &[f64],
    bounds: &Rect,
    margin: f64,
) -> Vec<Label> {
    let mut placed: Vec<Option<Label>> = vec![None; lines.len()];
    for (index, line) in lines.iter().enumerate() {
        let free = candidates(line, widths[index])
            .into_iter()
            .find(|rect| rect.within(bounds) && drawn.conflicts(rect) == 0);
        if let Some(rect) = free {
            drawn.add_rect(rect);
            placed[index] = Some(Label { at: (rect.left, rect.bottom - 4.0), tie: None });
        }
    }
    let left_over: Vec<usize> = (0..lines.len()).filter(|&index| placed[index].is_none()).collect();
    for (index, label) in
        left_over.iter().copied().zip(margin_labels(drawn, lines, &left_over, bounds, margin))
    {
        placed[index] = Some(label);
    }
    placed.into_iter().flatten().collect()
}

/// Places beside either end of a line, best first: right of the right end, left of the left end, then above and below.
fn candidates(line: &[(f64, f64)], width: f64) -> Vec<Rect> {
    let by_x = |a: &&(f64, f64), b: &&(f64, f64)| a.0.total_cmp(&b.0);
    let (Some(&left), Some(&right)) = (line.iter().min_by(by_x), line.iter().max_by(by_x)) else {
        return Vec::new();
    };
    let gap = 9.0;
    let rect =
        |x: f64, y: f64| Rect { left: x, right: x + width, top: y - HEIGHT / 2.0, bottom: y + HEIGHT / 2.0 };
    let mut places = Vec::new();
    for lift in [0.0, -7.0, 7.0] {
        places.push(rect(right.0 + gap, right.1 + lift));
    }
    for lift in [0.0, -7.0, 7.0] {
        places.push(rect(left.0 - gap - width, left.1 + lift));
    }
    for end in [right, left] {
        for shift in [0.5, 0.0, 1.0] {
            places.push(rect(end.0 - shift * width, end.1 - 16.0));
            places.push(rect(end.0 - shift * width, end.1 + 16.0));
        }
    }
    places
}

/// The labels of `which`, one below the other in the margin, each as near to its line's right end as order allows.
fn margin_labels(
    drawn: &Drawn,
    lines: &[Vec<(f64, f64)>],
    which: &[usize],
    bounds: &Rect,
    margin: f64,
) -> Vec<Label> {
    let end = |index: usize| lines[index].iter().copied().max_by(|a, b| a.0.total_cmp(&b.0));
    let mut order: Vec<usize> = (0..which.len()).collect();
    let height = |place: usize| end(which[place]).map_or(bounds.top, |point| point.1);
    order.sort_by(|&a, &b| height(a).total_cmp(&height(b)));
    let taken: Vec<&Rect> = drawn.rects.iter().filter(|rect| rect.right > margin - 8.0).collect();
    let steps = ((bounds.bottom - bounds.top - HEIGHT) / STEP) as usize;
    let mut free: Vec<f64> = (0..=steps)
        .map(|step| bounds.top + HEIGHT / 2.0 + STEP * step as f64)
        .filter(|y| taken.iter().all(|rect| y + HEIGHT / 2.0 <= rect.top || y - HEIGHT / 2.0 >= rect.bottom))
        .collect();
    // More labels than room cannot happen with six lines; the last slot is then shared.
    let mut labels = vec![Label { at: (margin, bounds.bottom), tie: None }; which.len()];
    for (rank, &place) in order.iter().enumerate() {
        let to_come = order.len() - rank - 1;
        let kept = to_come * (HEIGHT / STEP) as usize;
        let choice = &free[..free.len().saturating_sub(kept).max(1).min(free.len())];
        let tie = |y: f64| end(which[place]).map(|point| [point, (margin - 4.0, y)]);
        // Better a longer tie than one across another label.
        let crossed =
            |y: f64| tie(y).map_or(0, |[a, b]| taken.iter().filter(|rect| rect.meets(a, b)).count());
        let distance = |y: f64| (y - height(place)).abs();
        let better =
            |a: &f64, b: &f64| crossed(*a).cmp(&crossed(*b)).then(distance(*a).total_cmp(&distance(*b)));
        let Some(y) = choice.iter().copied().min_by(better) else { continue };
        free.retain(|&slot| slot >= y + HEIGHT);
        let tie = tie(y);
        labels[place] = Label { at: (margin, y + HEIGHT / 2.0 - 4.0), tie };
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_segment_meets_a_rectangle_exactly_when_a_dense_sampling_says_so() {
        let rect = Rect { left: 2.0, right: 5.0, top: 1.0, bottom: 3.0 };
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            8.0 * (state >> 40) as f64 / (1u64 << 24) as f64 - 0.5
        };
        for _ in 0..2000 {
            let (a, b) = ((random(), random()), (random(), random()));
            let inside = |t: f64| {
                let (x, y) = (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1));
                x > rect.left && x < rect.right && y > rect.top && y < rect.bottom
            };
            let sampled = (0..=4000).any(|i| inside(f64::from(i) / 4000.0));
            if sampled {
                assert!(rect.meets(a, b), "{a:?} {b:?}");
            }
            // Grown by the sampling distance, a miss of the samples is a miss.
            let shrunk = Rect { left: 2.01, right: 4.99, top: 1.01, bottom: 2.99 };
            if shrunk.meets(a, b) {
                assert!(
                    sampled || (b.0 - a.0).hypot(b.1 - a.1) < 0.05 || !corner_free(a, b, &rect),
                    "{a:?} {b:?}"
                );
            }
        }
    }

    /// Whether the segment stays away from the corners, where a sampling can miss a short stay.
    fn corner_free(a: (f64, f64), b: (f64, f64), rect: &Rect) -> bool {
        let corners = [
            (rect.left, rect.top),
            (rect.right, rect.top),
            (rect.left, rect.bottom),
            (rect.right, rect.bottom),
        ];
        let length = (b.0 - a.0).hypot(b.1 - a.1);
        corners.iter().all(|c| ((b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)).abs() / length > 0.02)
    }
}
