//! Pictures of a result without a display, a GPU or another program: a small software renderer.
//!
//! A [`Scene3`] (positions, triangles, points, segments, a scalar field) seen by a [`Camera`] becomes an [`Image`], saved as
//! PNG; several images become a [`Film`], saved as animated GIF. One thread, the same input gives the same bytes.
//!
//! Hidden surfaces go by a depth buffer at twice the resolution, light is one lamp near the camera (two-sided, without
//! shadows), colour is a perceptual map of the field with a bar that names its range. Nothing here fails on odd input:
//! elements with a position that is not finite are left out, an empty scene is an empty picture.
//!
//! A [`Chart`] holds curves over two linear axes. Gaussian splats are drawn by `gaussian-deform`; [`draw_splats`] makes an [`Image`] of it.
//!
//! Not here: transparency, textures, shadows.
//!
//! ```
//! use validation::picture::{Camera, Scene3, Size, render};
//! let scene = Scene3 {
//!     positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
//!     triangles: vec![[0, 1, 2]],
//!     ..Scene3::default()
//! };
//! let image = render(&scene, &Camera::default(), Size { width: 80, height: 60 });
//! assert_ne!(image.pixel(30, 35), image.pixel(1, 1));
//! ```

mod camera;
mod chart;
mod colour;
mod film;
mod font;
mod image;
mod legend;
mod palette;
mod raster;
mod scene3;
mod splats;
mod thumbnail;

pub use camera::{Bounds, Camera, Lens};
pub use chart::{Chart, Curve, Mark, draw_chart};
pub use colour::{ColourMap, Rgb};
pub use film::{Film, FilmError, Mp4};
pub use image::{Image, Size};
pub use raster::render;
pub use scene3::{Decoration, Field, FieldValues, PointSize, Scene3, Shading};
pub use splats::{colour_image, difference_image, draw_splats, splat_image};
pub use thumbnail::{ThumbnailError, description, thumbnail};
