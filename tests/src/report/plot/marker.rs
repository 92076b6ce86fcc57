//! Marker shapes, one a line, so that lines differ without colour.

/// Radius of a marker.
pub(super) const RADIUS: f64 = 4.5;

/// The marker of line `index` at (x, y), filled with the line's colour.
pub(super) fn marker(index: usize, x: f64, y: f64) -> String {
    let r = RADIUS;
    match index % 6 {
        0 => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r:.1}\"/>"),
        1 => polygon(x, y, &[(-r, -r), (r, -r), (r, r), (-r, r)].map(|(a, b)| (0.88 * a, 0.88 * b))),
        2 => polygon(x, y, &[(0.0, -1.2 * r), (1.15 * r, 0.8 * r), (-1.15 * r, 0.8 * r)]),
        3 => polygon(x, y, &[(0.0, -1.3 * r), (1.3 * r, 0.0), (0.0, 1.3 * r), (-1.3 * r, 0.0)]),
        4 => polygon(x, y, &[(0.0, 1.2 * r), (1.15 * r, -0.8 * r), (-1.15 * r, -0.8 * r)]),
        _ => polygon(x, y, &star()),
    }
}

/// The outline of a cross: a run that does not count.
pub(super) fn cross(x: f64, y: f64) -> String {
    let (arm, half) = (5.5, 1.7);
    let quarter: [(f64, f64); 3] = [(half, arm), (half, half), (arm, half)];
    let mut corners = Vec::new();
    let turn = std::f64::consts::FRAC_PI_2;
    for side in 0..4 {
        for &(a, b) in &quarter {
            let angle = std::f64::consts::FRAC_PI_4 - turn * f64::from(side);
            let (sin, cos) = angle.sin_cos();
            corners.push((cos * a - sin * b, sin * a + cos * b));
        }
    }
    polygon(x, y, &corners)
}

fn star() -> [(f64, f64); 10] {
    std::array::from_fn(|corner| {
        let angle = std::f64::consts::PI * (corner as f64 / 5.0 - 0.5);
        let radius = if corner % 2 == 0 { 1.45 * RADIUS } else { 0.65 * RADIUS };
        (radius * angle.cos(), radius * angle.sin())
    })
}

fn polygon(x: f64, y: f64, corners: &[(f64, f64)]) -> String {
    let points: Vec<String> = corners.iter().map(|(a, b)| format!("{:.1},{:.1}", x + a, y + b)).collect();
    format!("<polygon points=\"{}\"/>", points.join(" "))
}
