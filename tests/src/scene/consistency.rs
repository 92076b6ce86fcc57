//! Whether the parts of a scene fit together: what no single value shows.

mod splats;

use super::physics::{Integration, Load, Mesh, MeshSource, Selector};
use super::quantity::Finite;
use super::validation::{Expectation, Ladder, MeasureSpec, Validation};
use super::{Inconsistency, SceneFile};
use crate::experiment::Experiment;
use crate::record::ReferenceKind;
use std::path::Path;

type Checked = Result<(), Inconsistency>;

fn fault(key: impl Into<String>, message: impl Into<String>) -> Checked {
    Err(Inconsistency { key: key.into(), message: message.into() })
}

/// Checks a scene; `folder` is where its mesh files are looked for.
pub(crate) fn check(file: &SceneFile, experiment: &dyn Experiment, folder: &Path) -> Checked {
    if file.experiment.is_none() && file.meshes.is_empty() && file.splats.is_none() {
        return fault("", "nothing to run: a scene needs an `[experiment]`, `[[meshes]]` or `[splats]`");
    }
    if let Some(given) = &file.splats {
        splats::check(given, file, folder)?;
    }
    if !file.meshes.is_empty() {
        check_physics(file, folder)?;
    }
    match &file.validation {
        Some(validation) => check_validation(validation, experiment),
        None => Ok(()),
    }
}

fn check_physics(file: &SceneFile, folder: &Path) -> Checked {
    unique("meshes", "name", file.meshes.iter().map(|mesh| mesh.name.as_str()))?;
    unique("materials", "name", file.materials.iter().map(|material| material.name.as_str()))?;
    for (i, mesh) in file.meshes.iter().enumerate() {
        let materials = file.materials.iter().map(|material| material.name.as_str());
        known(&format!("meshes.{i}.material"), "material", &mesh.material, materials)?;
        check_source(i, &mesh.source, folder)?;
    }
    for (i, initial) in file.initial.iter().enumerate() {
        known_mesh(&format!("initial.{i}.mesh"), &initial.mesh, &file.meshes)?;
    }
    for (i, boundary) in file.boundary.iter().enumerate() {
        known_mesh(&format!("boundary.{i}.mesh"), &boundary.mesh, &file.meshes)?;
        check_selector(&format!("boundary.{i}.select"), &boundary.select)?;
    }
    for (i, load) in file.loads.iter().enumerate() {
        let (kind, mesh, select) = match load {
            Load::Gravity { .. } => continue,
            Load::NodalForce { mesh, select, .. } => ("nodal-force", mesh, select),
            Load::Traction { mesh, select, .. } => ("traction", mesh, select),
        };
        known_mesh(&format!("loads.{i}.{kind}.mesh"), mesh, &file.meshes)?;
        check_selector(&format!("loads.{i}.{kind}.select"), select)?;
    }
    check_contact(file)?;
    if file.integration.is_none() {
        return fault("integration", "missing; one of `static`, `backward-euler`, `bdf2`, `newmark`");
    }
    if file.solver.is_none() {
        return fault("solver", "missing; needs `linear`, `tolerance_m` and `max_iterations`");
    }
    Ok(())
}

fn check_contact(file: &SceneFile) -> Checked {
    let Some(contact) = &file.contact else { return Ok(()) };
    if matches!(file.integration, Some(Integration::Static { .. })) {
        return fault("contact", "an equilibrium with contact is not available; motion in time is");
    }
    let is_zero = |normal: &[Finite; 3]| normal.iter().all(|component| component.value() == 0.0);
    match contact.half_spaces.iter().position(|half_space| is_zero(&half_space.normal)) {
        Some(i) => fault(format!("contact.half_spaces.{i}.normal"), "must not be zero"),
        None => Ok(()),
    }
}

fn check_source(index: usize, source: &MeshSource, folder: &Path) -> Checked {
    match source {
        MeshSource::File { path, .. } if !folder.join(path).is_file() => fault(
            format!("meshes.{index}.source.file.path"),
            format!("there is no file {}", folder.join(path).display()),
        ),
        MeshSource::HeightField { heights_m, .. } => {
            let key = format!("meshes.{index}.source.height-field.heights_m");
            if heights_m.len() < 2 || heights_m[0].len() < 2 {
                return fault(key, "needs at least two rows of at least two heights");
            }
            match heights_m.iter().position(|row| row.len() != heights_m[0].len()) {
                Some(row) => fault(
                    format!("{key}.{row}"),
                    format!("has {} heights, the first row has {}", heights_m[row].len(), heights_m[0].len()),
                ),
                None => Ok(()),
            }
        }
        _ => Ok(()),
    }
}

fn check_selector(key: &str, select: &Selector) -> Checked {
    match select {
        Selector::All {} => Ok(()),
        Selector::Box { min_m, max_m } => match (0..3).find(|&k| min_m[k] > max_m[k]) {
            Some(k) => fault(
                format!("{key}.box.min_m.{k}"),
                format!("{} is above max_m's {}", min_m[k].value(), max_m[k].value()),
            ),
            None => Ok(()),
        },
        Selector::Plane { normal, .. } if normal.iter().all(|component| component.value() == 0.0) => {
            fault(format!("{key}.plane.normal"), "must not be zero")
        }
        Selector::Plane { .. } => Ok(()),
    }
}

fn check_validation(validation: &Validation, experiment: &dyn Experiment) -> Checked {
    let key = |key: &str| format!("validation.{key}");
    if validation.methods.is_empty() {
        return fault(key("methods"), "at least one method is needed");
    }
    unique("validation.methods", "", validation.methods.iter().map(String::as_str))?;
    if validation.method_sets.is_none() {
        for (i, method) in validation.methods.iter().enumerate() {
            known(&key(&format!("methods.{i}")), "method", method, experiment.methods().iter().copied())?;
        }
    }
    if validation.threads.is_empty() {
        return fault(key("threads"), "at least one number of threads is needed");
    }
    if validation.measures.is_empty() && validation.reference.kind != ReferenceKind::Invariants {
        return fault(key("measures"), "a scene with a reference needs at least one measure");
    }
    if validation.measures.is_empty() && validation.invariants.is_empty() {
        return fault(key("invariants"), "a scene without a reference needs at least one invariant");
    }
    unique("validation.measures", "name", validation.measures.iter().map(|measure| measure.name.as_str()))?;
    check_ladder(&validation.ladder)?;
    for (i, measure) in validation.measures.iter().enumerate() {
        check_measure(&key(&format!("measures.{i}")), measure, validation)?;
    }
    for (name, bounds) in &validation.invariants {
        if bounds.min.is_none() && bounds.max.is_none() && bounds.above.is_none() {
            return fault(key(&format!("invariants.{name}")), "needs `min`, `max` or `above`");
        }
    }
    Ok(())
}

/// Points of a ladder.
const MOST_VALUES: usize = 100;

fn check_ladder(ladder: &Ladder) -> Checked {
    let values: Vec<f64> = ladder.values.iter().map(|value| value.value()).collect();
    if values.is_empty() {
        return fault("validation.ladder.values", "at least one value is needed");
    }
    // Every value is put into the scene and read when the file is; thousands would take minutes.
    if values.len() > MOST_VALUES {
        let message = format!("{} values are too many, at most {MOST_VALUES} are allowed", values.len());
        return fault("validation.ladder.values", message);
    }
    let rises = values.windows(2).all(|pair| pair[0] < pair[1]);
    let falls = values.windows(2).all(|pair| pair[0] > pair[1]);
    if !rises && !falls {
        return fault("validation.ladder.values", "must only rise or only fall, from coarse to fine");
    }
    match ladder.quick_points {
        Some(points) if points.value() >= values.len() => fault(
            "validation.ladder.quick_points",
            format!("{} is not fewer than the ladder's {} values", points.value(), values.len()),
        ),
        _ => Ok(()),
    }
}

fn check_measure(key: &str, measure: &MeasureSpec, validation: &Validation) -> Checked {
    for method in measure.methods.keys() {
        let key = format!("{key}.methods.{method}");
        known(&key, "method", method, validation.methods.iter().map(String::as_str))?;
    }
    let ordered = measure.order.is_some() || measure.methods.values().any(|own| own.order.is_some());
    if measure.order_tolerance.is_some() && !ordered {
        return fault(key, "`order` and `order_tolerance` go together");
    }
    for method in &validation.methods {
        check_expectation(key, &measure.expectation(method), &validation.ladder)?;
    }
    Ok(())
}

fn check_expectation(key: &str, expected: &Expectation, ladder: &Ladder) -> Checked {
    if expected.order.is_some() && expected.order_tolerance.is_none() {
        return fault(key, "`order` and `order_tolerance` go together");
    }
    if expected.order.is_some() && ladder.values.len() < 2 {
        return fault(format!("{key}.order"), "an order needs at least two ladder values");
    }
    if let Some(from) = expected.order_from {
        if expected.order.is_none() {
            return fault(format!("{key}.order_from"), "has no meaning without `order`");
        }
        if !ladder.values.iter().any(|value| value.value() == from.value()) {
            return fault(format!("{key}.order_from"), "must be one of the ladder's values");
        }
    }
    if expected.quick_bound.is_some() && ladder.quick_points.is_none() {
        return fault(format!("{key}.quick_bound"), "has no meaning without `ladder.quick_points`");
    }
    if expected.bound.is_none() && expected.order.is_none() {
        return fault(key, "needs a `bound` or an `order`, else nothing is checked");
    }
    Ok(())
}

fn known_mesh(key: &str, name: &str, meshes: &[Mesh]) -> Checked {
    known(key, "mesh", name, meshes.iter().map(|mesh| mesh.name.as_str()))
}

fn known<'a>(key: &str, what: &str, name: &str, allowed: impl Iterator<Item = &'a str>) -> Checked {
    let allowed: Vec<&str> = allowed.collect();
    if allowed.contains(&name) {
        return Ok(());
    }
    fault(key, format!("there is no {what} `{name}`; there are: {}", allowed.join(", ")))
}

fn unique<'a>(list: &str, field: &str, names: impl Iterator<Item = &'a str>) -> Checked {
    let mut seen = Vec::new();
    for (i, name) in names.enumerate() {
        if seen.contains(&name) {
            let key = if field.is_empty() { format!("{list}.{i}") } else { format!("{list}.{i}.{field}") };
            return fault(key, format!("the name `{name}` is taken"));
        }
        seen.push(name);
    }
    Ok(())
}
