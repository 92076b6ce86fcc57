//! Whether the parts of a scene of splats fit together.

use super::{Checked, fault};
use crate::scene::SceneFile;
use crate::scene::quantity::{NonNegative, Positive};
use crate::scene::splats::{Preset, Region, SimulationBox, SplatCamera, SplatScene};
use std::path::Path;

/// Checks `[splats]`; `folder` is where its files are looked for.
pub(super) fn check(given: &SplatScene, file: &SceneFile, folder: &Path) -> Checked {
    check_source(given, folder)?;
    check_region("splats.region", &given.region)?;
    for (i, part) in given.parts.iter().enumerate() {
        check_region(&format!("splats.parts.{i}.region"), &part.region)?;
    }
    if let Some(camera) = &given.camera {
        check_camera(camera, folder)?;
    }
    check_particles(given)?;
    match file.meshes.is_empty() {
        true => check_without_meshes(file),
        false => check_with_meshes(given),
    }
}

fn check_source(given: &SplatScene, folder: &Path) -> Checked {
    match (&given.file, &given.surface) {
        (Some(path), None) if !folder.join(path).is_file() => {
            fault("splats.file", format!("there is no file {}", folder.join(path).display()))
        }
        (Some(_), None) | (None, Some(_)) => Ok(()),
        (Some(_), Some(_)) => {
            fault("splats.surface", "splats come from a `file` or from a `surface`, not both")
        }
        (None, None) => fault("splats", "needs `file`, a .ply, .splat or .spz file, or `surface`"),
    }
}

fn check_region(key: &str, region: &Region) -> Checked {
    match region {
        Region::Box { min, max } => match (0..3).find(|&k| min[k] > max[k]) {
            Some(k) => fault(
                format!("{key}.box.min.{k}"),
                format!("{} is above max's {}", min[k].value(), max[k].value()),
            ),
            None => Ok(()),
        },
        _ => Ok(()),
    }
}

fn check_camera(camera: &SplatCamera, folder: &Path) -> Checked {
    match &camera.file {
        Some(path) if !folder.join(path).is_file() => {
            return fault("splats.camera.file", format!("there is no file {}", folder.join(path).display()));
        }
        Some(_) => {}
        None if camera.picture.is_some() => {
            return fault("splats.camera.picture", "has no meaning without `file`");
        }
        None => return Ok(()),
    }
    let orbit = [
        ("azimuth_rad", camera.azimuth_rad.is_some()),
        ("elevation_rad", camera.elevation_rad.is_some()),
        ("turn_rad_s", camera.turn_rad_s.is_some()),
        ("distance", camera.distance.is_some()),
        ("target_m", camera.target_m.is_some()),
        ("field_of_view_rad", camera.field_of_view_rad.is_some()),
    ];
    match orbit.iter().find(|(_, given)| *given) {
        Some((key, _)) => {
            fault(format!("splats.camera.{key}"), "belongs to an orbit, and the camera is one of a `file`")
        }
        None => Ok(()),
    }
}

fn check_particles(given: &SplatScene) -> Checked {
    let Some(particles) = &given.particles else { return Ok(()) };
    let key = |part: &str| format!("splats.particles.{part}");
    for (i, hold) in particles.holds.iter().enumerate() {
        check_box(&key(&format!("holds.{i}.select")), &hold.select)?;
        let from = hold.from_s.map_or(0.0, NonNegative::value);
        if let Some(until) = hold.until_s.map(Positive::value)
            && until <= from
        {
            return fault(key(&format!("holds.{i}.until_s")), format!("must be after its begin at {from} s"));
        }
    }
    for (i, impulse) in particles.impulses.iter().enumerate() {
        check_box(&key(&format!("impulses.{i}.select")), &impulse.select)?;
    }
    for (i, collider) in particles.colliders.iter().enumerate() {
        if let crate::scene::splats::ColliderShape::HalfSpace { normal, .. } = &collider.shape
            && normal.iter().all(|component| component.value() == 0.0)
        {
            return fault(key(&format!("colliders.{i}.shape.half-space.normal")), "must not be zero");
        }
    }
    Ok(())
}

fn check_box(key: &str, given: &SimulationBox) -> Checked {
    match (0..3).find(|&k| given.min_m[k] >= given.max_m[k]) {
        Some(k) => fault(
            format!("{key}.min_m.{k}"),
            format!("{} is not below max_m's {}", given.min_m[k].value(), given.max_m[k].value()),
        ),
        None => Ok(()),
    }
}

/// Particles move the splats: what belongs to bodies of tetrahedra does nothing.
fn check_without_meshes(file: &SceneFile) -> Checked {
    let of_bodies = [
        ("materials", file.materials.is_empty()),
        ("initial", file.initial.is_empty()),
        ("boundary", file.boundary.is_empty()),
        ("loads", file.loads.is_empty()),
        ("contact", file.contact.is_none()),
        ("integration", file.integration.is_none()),
        ("solver", file.solver.is_none()),
    ];
    match of_bodies.iter().find(|(_, absent)| !absent) {
        Some((key, _)) if file.experiment.is_none() => fault(
            *key,
            "is of bodies of tetrahedra, and the scene has no `[[meshes]]`: particles are told in `[splats.particles]`",
        ),
        _ => Ok(()),
    }
}

/// Tetrahedra move the splats: what belongs to particles does nothing.
fn check_with_meshes(given: &SplatScene) -> Checked {
    let of_particles = [
        ("particles", given.particles.is_none()),
        ("parts", given.parts.is_empty()),
        ("material", given.material == Preset::default()),
        ("density_kg_m3", given.density_kg_m3.is_none()),
        ("law", given.law.is_none()),
    ];
    match of_particles.iter().find(|(_, absent)| !absent) {
        Some((key, _)) => fault(
            format!("splats.{key}"),
            "is of particles, and the scene's `[[meshes]]` move the splats: their material is in `[[materials]]`",
        ),
        None => Ok(()),
    }
}
