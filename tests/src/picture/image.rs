//! A picture.

use super::colour::Rgb;
use super::raster::PAPER;
use crate::report::{WriteError, write_file};
use std::path::Path;

/// Width and height in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels from left to right.
    pub width: usize,
    /// Pixels from top to bottom.
    pub height: usize,
}

/// A picture of sRGB pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    size: Size,
    pixels: Vec<Rgb>,
}

impl Image {
    /// A picture of one colour. A size of nothing becomes one pixel.
    pub fn filled(size: Size, colour: Rgb) -> Self {
        let size = Size { width: size.width.max(1), height: size.height.max(1) };
        Self { size, pixels: vec![colour; size.width * size.height] }
    }

    /// A picture of three bytes a pixel (red, green, blue), row by row from the top left.
    ///
    /// # Panics
    /// If there are not as many bytes.
    pub fn of_rgb8(size: Size, bytes: &[u8]) -> Self {
        assert_eq!(bytes.len(), 3 * size.width * size.height, "three bytes a pixel of {size:?}");
        let pixels = bytes.chunks_exact(3).map(|rgb| Rgb([rgb[0], rgb[1], rgb[2]])).collect();
        Self { size, pixels }
    }

    /// This picture and others to its right, all upper edges at one height.
    pub fn beside(&self, others: &[Self]) -> Self {
        let all = || std::iter::once(self).chain(others);
        let width = all().map(|image| image.size.width).sum();
        let height = all().map(|image| image.size.height).max().unwrap_or(1);
        let mut joined = Self::filled(Size { width, height }, PAPER);
        let mut left = 0;
        for image in all() {
            for (row, pixels) in image.pixels.chunks_exact(image.size.width).enumerate() {
                joined.pixels[row * width + left..][..pixels.len()].copy_from_slice(pixels);
            }
            left += image.size.width;
        }
        joined
    }

    /// Its size.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Its pixels, row by row from the top left.
    pub fn pixels(&self) -> &[Rgb] {
        &self.pixels
    }

    /// The pixel `x` from the left and `y` from the top.
    ///
    /// # Panics
    /// When there is none.
    pub fn pixel(&self, x: usize, y: usize) -> Rgb {
        assert!(x < self.size.width && y < self.size.height, "pixel ({x}, {y}) of {:?}", self.size);
        self.pixels[y * self.size.width + x]
    }

    pub(super) fn pixels_mut(&mut self) -> &mut [Rgb] {
        &mut self.pixels
    }

    /// Sets a pixel; outside the picture nothing happens.
    pub(super) fn set(&mut self, x: i64, y: i64, colour: Rgb) {
        if let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y))
            && x < self.size.width
            && y < self.size.height
        {
            self.pixels[y * self.size.width + x] = colour;
        }
    }

    /// The picture as PNG.
    ///
    /// # Errors
    /// When it is larger than the format holds (2³¹ pixels a side).
    pub fn png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let bytes: Vec<u8> = self.pixels.iter().flat_map(|pixel| pixel.0).collect();
        let side = |pixels: usize| u32::try_from(pixels).unwrap_or(u32::MAX);
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, side(self.size.width), side(self.size.height));
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&bytes)?;
        writer.finish()?;
        Ok(out)
    }

    /// Writes the picture as PNG, whole or not at all.
    ///
    /// # Errors
    /// [`WriteError`] when the file cannot be written.
    pub fn save_png(&self, path: &Path) -> Result<(), WriteError> {
        let failed = |error| WriteError { path: path.to_owned(), source: std::io::Error::other(error) };
        write_file(path, &self.png().map_err(failed)?)
    }
}
