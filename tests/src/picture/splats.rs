//! Gaussian splats as pictures of this module, drawn by the rasteriser of `gaussian-deform`.

use super::image::{Image, Size};
use super::legend;
use super::raster::PAPER;
use gaussian_deform::Splats;
use gaussian_deform::camera::Camera;
use gaussian_deform::raster::{self, Mode, Picture, RasterError, Settings};
use mechanics_core::lanes::Element;

/// Splats before white paper, all that is visible of them, with a caption in the corner.
///
/// # Errors
/// What the rasteriser refuses: numbers that are not finite.
pub fn draw_splats(splats: &Splats<f32>, camera: &Camera, caption: &str) -> Result<Image, RasterError> {
    let background = PAPER.0.map(|channel| f64::from(channel) / 255.0);
    let settings = Settings { mode: Mode::Tight, background, ..Settings::default() };
    Ok(splat_image(&raster::render(splats, camera, &settings)?, caption))
}

/// A picture of splats with a caption in the corner.
pub fn splat_image<E: Element>(picture: &Picture<E>, caption: &str) -> Image {
    let mut image = Image::of_rgb8(size(picture), &picture.to_rgb8());
    legend::draw_caption(&mut image, caption);
    image
}

/// Colours row by row from the upper left corner, cut to \[0, 1\], with a caption in the corner.
///
/// # Panics
/// If there is not one for each pixel.
pub fn colour_image(size: Size, colours: &[[f64; 3]], caption: &str) -> Image {
    let byte = |channel: &f64| (channel.clamp(0.0, 1.0) * 255.0).round() as u8;
    let bytes: Vec<u8> = colours.as_flattened().iter().map(byte).collect();
    let mut image = Image::of_rgb8(size, &bytes);
    legend::draw_caption(&mut image, caption);
    image
}

/// Where two pictures of one size differ: white for not at all, `gain` times the difference taken away from each channel.
///
/// # Panics
/// If there is not one colour for each pixel.
pub fn difference_image(size: Size, (a, b): (&[[f64; 3]], &[[f64; 3]]), gain: f64, caption: &str) -> Image {
    assert_eq!(a.len(), b.len(), "pictures of one size");
    let left = |(a, b): (&[f64; 3], &[f64; 3])| [0, 1, 2].map(|k| 1.0 - gain * (a[k] - b[k]).abs());
    colour_image(size, &a.iter().zip(b).map(left).collect::<Vec<_>>(), caption)
}

fn size<E: Element>(picture: &Picture<E>) -> Size {
    Size { width: picture.width(), height: picture.height() }
}

#[cfg(test)]
mod tests {
    use super::super::colour::Rgb;
    use super::*;
    use gaussian_deform::{Degree, Splat};
    use mechanics_core::tensor::{Mat3, Vec3};

    #[test]
    fn a_splat_is_where_the_camera_sees_it() {
        let mut splats = Splats::new(Degree::Zero);
        let mean = Vec3::new(0.5, 0.0, 0.0).cast();
        splats.push(Splat { mean, axes: Mat3::identity().cast() * 0.1, opacity: 1.0, harmonics: &[-2.0; 3] });
        let camera = Camera::look_at([80, 60], 0.6, Vec3::z() * 4.0, Vec3::zeros(), Vec3::y()).unwrap();
        let image = draw_splats(&splats, &camera, "").unwrap();
        let [x, y] = camera.project(&Vec3::new(0.5, 0.0, 0.0)).unwrap().map(|place| place.round() as usize);
        assert!(image.pixel(x, y).0[0] < 10, "{:?}", image.pixel(x, y));
        assert_eq!(image.pixel(80 - x, y), Rgb([255; 3]));
        let twice = image.beside(std::slice::from_ref(&image));
        assert_eq!(twice.pixel(80 + x, y), image.pixel(x, y));
    }
}
