//! Cameras of a trained scene: `cameras.json`.

use super::{Camera, CameraError, NamedCamera};
use mechanics_core::tensor::{Mat3, Vec3};
use serde_json::Value;

/// The cameras of the text of a `cameras.json`, in its order.
///
/// The file is a list of objects with `width`, `height`, `fx`, `fy` \[pixels\], `position` (of the eye, three numbers) and `rotation` (camera to
/// world, a list of three rows), and perhaps `img_name` and the principal point `cx`, `cy` \[pixels\] (each the middle if it is not there). Other properties are skipped.
///
/// # Errors
/// [`CameraError::Syntax`], [`CameraError::NotAList`], [`CameraError::BadEntry`] with camera and property, [`CameraError::InFile`] with what
/// [`Camera::new`] has against a camera.
pub fn cameras_from_json(text: &str) -> Result<Vec<NamedCamera>, CameraError> {
    let value: Value = serde_json::from_str(text).map_err(|error| CameraError::Syntax {
        line: error.line(),
        column: error.column(),
        reason: error.to_string(),
    })?;
    let list = value.as_array().ok_or(CameraError::NotAList)?;
    list.iter().enumerate().map(|(index, value)| Entry { index, value }.camera()).collect()
}

/// One object of the list.
struct Entry<'a> {
    index: usize,
    value: &'a Value,
}

impl Entry<'_> {
    fn camera(&self) -> Result<NamedCamera, CameraError> {
        let size = [self.integer("width")?, self.integer("height")?];
        let focal = [self.number("fx")?, self.number("fy")?];
        let position = triple(self.property("position")).ok_or_else(|| self.bad("position", THREE))?;
        let rows =
            self.rows().ok_or_else(|| self.bad("rotation", "a list of three rows of three numbers"))?;
        // The file's matrix leads from the camera to the world: its rows are our columns.
        let rotation = Mat3::from_columns(&rows.map(Vec3::from));
        let [cx, cy] =
            [self.number_or("cx", 0.5 * size[0] as f64)?, self.number_or("cy", 0.5 * size[1] as f64)?];
        let camera = Camera::new(size, focal, rotation, position.into())
            .and_then(|camera| camera.with_principal_point([cx, cy]))
            .map_err(|error| CameraError::InFile { index: self.index, error: Box::new(error) })?;
        Ok(NamedCamera { name: self.property("img_name").as_str().unwrap_or_default().into(), camera })
    }

    /// `null` if there is none.
    fn property(&self, key: &str) -> &Value {
        self.value.get(key).unwrap_or(&Value::Null)
    }

    fn bad(&self, key: &'static str, wanted: &'static str) -> CameraError {
        CameraError::BadEntry { index: self.index, key, wanted }
    }

    fn integer(&self, key: &'static str) -> Result<usize, CameraError> {
        let number = self.property(key).as_u64().and_then(|n| usize::try_from(n).ok());
        number.ok_or_else(|| self.bad(key, "a whole number"))
    }

    fn number(&self, key: &'static str) -> Result<f64, CameraError> {
        self.property(key).as_f64().ok_or_else(|| self.bad(key, "a number"))
    }

    /// For a property that may be missing.
    fn number_or(&self, key: &'static str, default: f64) -> Result<f64, CameraError> {
        if self.property(key).is_null() { Ok(default) } else { self.number(key) }
    }

    fn rows(&self) -> Option<[[f64; 3]; 3]> {
        match self.property("rotation").as_array()?.as_slice() {
            [a, b, c] => Some([triple(a)?, triple(b)?, triple(c)?]),
            _ => None,
        }
    }
}

const THREE: &str = "a list of three numbers";

fn triple(value: &Value) -> Option<[f64; 3]> {
    match value.as_array()?.as_slice() {
        [a, b, c] => Some([a.as_f64()?, b.as_f64()?, c.as_f64()?]),
        _ => None,
    }
}
