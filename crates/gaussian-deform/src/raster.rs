//! The picture of a scene, made on the processor.
//!
//! Every Gaussian is projected onto the image plane, where it is a Gaussian again (elliptical weighted averaging), and all of them are blended from
//! front to back: with the opacity αᵢ of the i-th nearest mean at a pixel and the light Tᵢ = Πⱼ₍ⱼ﹤ᵢ₎ (1 − αⱼ) that passes those before it,
//!
//! C = Σᵢ αᵢ Tᵢ cᵢ + T c₀,  αᵢ = min(0.99, oᵢ exp(−½ dᵀ Σᵢ⁻¹ d)),
//!
//! d from the projected mean to the pixel's centre, c₀ the background. αᵢ below 1/255 counts as zero, and a pixel is finished as soon as a Gaussian would leave
//! it less than 1e-4 of the light: that Gaussian and all behind it are left out. Means at the same depth are drawn in the order of the scene. `docs/theory/gaussian-picture.md`
//! derives all of it.
//!
//! ```
//! use gaussian_deform::camera::Camera;
//! use gaussian_deform::raster::{self, Settings};
//! use gaussian_deform::{Degree, Splat, Splats};
//! use mechanics_core::tensor::{Mat3, Vec3};
//!
//! // A green ball of standard deviation 0.1 m, two metres away.
//! let mut scene = Splats::<f64>::new(Degree::Zero);
//! let harmonics = [-1.0, 1.0, -1.0].map(|sign| sign * 0.5 / 0.28209479177387814);
//! scene.push(Splat {
//!     mean: Vec3::zeros(),
//!     axes: Mat3::identity() * 0.1,
//!     opacity: 0.8,
//!     harmonics: &harmonics,
//! });
//! let camera = Camera::look_at([65, 65], 0.5, Vec3::z() * 2.0, Vec3::zeros(), Vec3::y())?;
//! let picture = raster::render(&scene, &camera, &Settings::default())?;
//! let middle = picture.colours()[32 * 65 + 32];
//! assert!((middle[1] - 0.8).abs() < 1e-9 && middle[0] == 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # How
//! Two parallel stages. The first takes chunks of the scene, eight `f32` or four `f64` Gaussians at a time, and sorts what is visible of a chunk into bands of sixteen
//! rows. The second takes bands: sorts their Gaussians by depth, distributes them among the band's tiles, and blends tile by tile, eight or four pixels
//! at a time. Within a tile only blocks of 4 × 2 (`f64`: 4 × 1) pixels that the visible ellipse reaches are touched, and finished blocks no more.
//! Every pixel sees its Gaussians in an order that depends on nothing but the scene, so pictures have the same bits for any number of threads.

mod band;
mod error;
mod exponential;
mod footprint;
mod gathering;
mod order;
mod picture;
mod projection;
mod tile;

pub use error::RasterError;
pub use picture::{Picture, PictureReport};
pub use projection::{LOW_PASS, NEAR, Projection, View};

use crate::camera::Camera;
use crate::precision::{by_precision, known};
use crate::splats::Splats;
use band::{Band, Draw};
use gathering::Chunk;
use mechanics_core::lanes::{self, Element};
use mechanics_core::parallel;

/// Pixels along the side of a tile.
const TILE: usize = 16;

/// In which tiles a Gaussian is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// As trained scenes expect it: in the tiles that meet the square of three standard deviations (of the longer half-axis, rounded up) around the
    /// mean. Where the opacity is above e^4.5/255 = 0.353, that cuts off what should still be visible, along the edges of tiles.
    #[default]
    Exact,
    /// Wherever its opacity is at least 1/255: the ellipse within which that holds, and nothing else.
    Tight,
}

/// Whether depth is drawn too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DepthChannel {
    /// No depth.
    #[default]
    Absent,
    /// See [`Picture::depth`].
    Present,
}

/// What becomes of the opacity of Gaussians that the low-pass of 0.3 pixel² widens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Antialiasing {
    /// Nothing, as most scenes are trained: what is smaller than a pixel shows too bright and too thick from afar.
    #[default]
    Absent,
    /// It falls as the area grows ([`Projection::sharpness`]), for scenes that were trained so.
    Present,
}

/// How a picture is made. Exact mode before black without depth and antialiasing is the default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// In which tiles a Gaussian is drawn.
    pub mode: Mode,
    /// Red, green, blue of the background.
    pub background: [f64; 3],
    /// Whether depth is drawn too.
    pub depth: DepthChannel,
    /// Whether opacities make up for the low-pass.
    pub antialiasing: Antialiasing,
}

/// The picture of a scene.
///
/// # Errors
/// See [`render_into`].
pub fn render<E: Element>(
    splats: &Splats<E>,
    camera: &Camera,
    settings: &Settings,
) -> Result<Picture<E>, RasterError> {
    let mut picture = Picture::empty();
    render_into(splats, camera, settings, &mut picture)?;
    Ok(picture)
}

/// The picture of a scene, into the memory of an earlier one.
///
/// Numbers of Gaussians that are not visible are not looked at, but for their means, axes and opacities.
///
/// # Errors
/// The first Gaussian with a number that is NaN, infinite or out of range, or whose projection or colour overflows; a background that is not
/// finite. `picture` is as it was then.
pub fn render_into<E: Element>(
    splats: &Splats<E>,
    camera: &Camera,
    settings: &Settings,
    picture: &mut Picture<E>,
) -> Result<(), RasterError> {
    by_precision(
        picture,
        |picture| draw_single(known(splats), camera, settings, picture),
        |picture| draw_double(known(splats), camera, settings, picture),
    )
}

#[inline(never)]
fn draw_single(
    splats: &Splats<f32>,
    camera: &Camera,
    settings: &Settings,
    picture: &mut Picture<f32>,
) -> Result<(), RasterError> {
    draw_into(splats, camera, settings, picture)
}

#[inline(never)]
fn draw_double(
    splats: &Splats<f64>,
    camera: &Camera,
    settings: &Settings,
    picture: &mut Picture<f64>,
) -> Result<(), RasterError> {
    draw_into(splats, camera, settings, picture)
}

fn draw_into<E: Element>(
    splats: &Splats<E>,
    camera: &Camera,
    settings: &Settings,
    picture: &mut Picture<E>,
) -> Result<(), RasterError> {
    if let Some(channel) = settings.background.iter().position(|value| !value.is_finite()) {
        return Err(RasterError::BadBackground { channel, value: settings.background[channel] });
    }
    let chunks = gathering::gather(splats, camera, settings)?;
    let size = [camera.width(), camera.height()];
    picture.resize(size, settings.depth);
    let drawn = match settings.depth {
        DepthChannel::Absent => draw::<E, 4>(&chunks, settings.background, picture),
        DepthChannel::Present => draw::<E, 5>(&chunks, settings.background, picture),
    };
    picture.report = PictureReport {
        gaussians: splats.count(),
        near: chunks.iter().map(|chunk| chunk.near).sum(),
        visible: chunks.iter().map(|chunk| chunk.placed.len()).sum(),
        drawn,
    };
    Ok(())
}

/// Draws all bands with N values a pixel; answers how many pairs of a Gaussian and a tile were drawn.
fn draw<E: Element, const N: usize>(
    chunks: &[Chunk<E>],
    background: [f64; 3],
    picture: &mut Picture<E>,
) -> usize {
    let background = background.map(E::constant);
    let mut bands = bands(picture);
    parallel::for_each_chunk(&mut bands, 1, |_, bands| {
        for band in bands {
            lanes::dispatch(Draw::<E, N> { chunks, background, band });
        }
    });
    bands.iter().map(|band| band.drawn).sum()
}

/// A picture in parts of sixteen rows.
fn bands<E: Element>(picture: &mut Picture<E>) -> Vec<Band<'_, E>> {
    let size = picture.size;
    let pixels = TILE * size[0];
    let mut depth = picture.depth.as_deref_mut().unwrap_or_default();
    let parts = picture.colours.chunks_mut(pixels).zip(picture.transmittance.chunks_mut(pixels));
    let mut bands = Vec::with_capacity(size[1].div_ceil(TILE));
    for (number, (colours, transmittance)) in parts.enumerate() {
        let part;
        (part, depth) = depth.split_at_mut(pixels.min(depth.len()));
        bands.push(Band { number, size, colours, transmittance, depth: part, drawn: 0 });
    }
    bands
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Degree, Splat};
    use mechanics_core::tensor::{Mat3, Vec3};

    /// Processors without AVX2 draw the same picture, up to rounding: fused operations round once, separate ones twice.
    fn check<E: Element>(tolerance: f64) {
        let mut scene = Splats::<f64>::new(Degree::Zero);
        for k in 0..40 {
            let angle = f64::from(k);
            let axes = Mat3::new(0.2, 0.1, 0.0, -0.1 * angle.sin(), 0.3, 0.0, 0.0, 0.02, 0.1);
            let mean = Vec3::new(angle.sin(), angle.cos(), 0.02 * angle);
            let opacity = 0.3 + 0.01 * angle;
            scene.push(Splat { mean, axes, opacity, harmonics: &[angle.sin(), 0.5, -0.5] });
        }
        let camera = Camera::look_at([50, 40], 0.9, Vec3::z() * -3.0, Vec3::zeros(), Vec3::y()).unwrap();
        let settings = Settings { depth: DepthChannel::Present, ..Settings::default() };
        let mut picture = render(&scene.cast::<E>(), &camera, &settings).unwrap();
        let dispatched = picture.clone();
        let chunks = gathering::gather(&scene.cast::<E>(), &camera, &settings).unwrap();
        picture.colours.fill([E::constant(9.0); 3]);
        for band in &mut bands(&mut picture) {
            let background = [E::constant(0.0); 3];
            lanes::dispatch_portable(Draw::<E, 5> { chunks: &chunks, background, band });
        }
        for (a, b) in picture.colours.iter().flatten().zip(dispatched.colours.iter().flatten()) {
            assert!((Into::<f64>::into(*a) - (*b).into()).abs() < tolerance, "{a:?} for {b:?}");
        }
    }

    #[test]
    fn portable_packets_draw_the_same() {
        check::<f32>(1e-5);
        check::<f64>(1e-13);
    }
}
