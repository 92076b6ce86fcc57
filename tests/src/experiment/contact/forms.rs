//! The barriers' formulas, written anew from their papers: what closed forms of gaps are made of.

use ipc_contact::contact::BarrierForm;

/// The methods of scenes that compare forms.
pub(in crate::experiment) const FORMS: &[&str] = &["squared-distance", "distance", "physical"];

/// The form that a method names.
pub(in crate::experiment) fn form(method: &str) -> BarrierForm {
    match method {
        "distance" => BarrierForm::Distance,
        "physical" => BarrierForm::Physical,
        _ => BarrierForm::SquaredDistance,
    }
}

/// −∂b/∂d at the distance `d` of a barrier that begins at `a`; zero beyond.
pub(in crate::experiment) fn pull(form: BarrierForm, a: f64, d: f64) -> f64 {
    if d >= a {
        return 0.0;
    }
    let slope = |r: f64| 2.0 * (r - 1.0) * r.ln() + (r - 1.0).powi(2) / r;
    let squares = (d / a).powi(2);
    match form {
        BarrierForm::SquaredDistance => 2.0 * d * a * a * slope(squares),
        BarrierForm::Distance => a * slope(d / a),
        BarrierForm::Physical => 2.0 * d / a * slope(squares),
    }
}

/// The distance in (0, a) where a function that falls becomes zero.
pub(in crate::experiment) fn crossing(a: f64, falling: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, a);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if falling(middle) > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
