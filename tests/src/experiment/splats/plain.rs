//! A plain rasteriser in double precision, written from the papers' formulas: what pictures are compared with.
//!
//! It takes covariances and colours, not half-axes and harmonics, inverts Σ as it stands, looks at every pixel that a Gaussian could reach, and marks
//! the pixels whose colour hangs on a decision that rounding may turn.

use gaussian_deform::camera::Camera;
use gaussian_deform::raster::{Mode, Picture};
use mechanics_core::lanes::Element;
use mechanics_core::tensor::{Mat3, Vec3};

/// A Gaussian as it is seen by one camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gaussian {
    pub(super) mean: Vec3,
    /// A \[m²\].
    pub(super) covariance: Mat3,
    pub(super) opacity: f64,
    /// From this camera.
    pub(super) colour: [f64; 3],
}

/// What is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rules {
    /// What a mode of the rasteriser leaves out.
    Of(Mode),
    /// Nothing that is worth 1e-9: no cut at 1/255, no end at 1e-4, no tiles.
    Complete,
}

/// How far rounding may move what decisions are made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rounding {
    /// Opacities at a pixel and what light is left, relatively.
    pub(super) opacity: f64,
    /// Places in the picture \[pixels\].
    pub(super) place: f64,
    /// Depths \[m\].
    pub(super) depth: f64,
}

impl Rounding {
    /// Of pictures of some hundred pixels in double precision.
    pub(super) const DOUBLE: Self = Self { opacity: 1e-9, place: 1e-9, depth: 1e-12 };
    /// Of the same in single precision, of scenes of some metres: 2⁻²⁴ of a position, seen from there, is some 1e-4 pixels, by which a splat of half a
    /// pixel fades by some 1e-4 of itself.
    pub(super) const SINGLE: Self = Self { opacity: 1e-3, place: 1e-3, depth: 3e-6 };
}

/// A picture and which of its pixels are fragile.
pub(super) struct PlainPicture {
    pub(super) colours: Vec<[f64; 3]>,
    /// Whether a decision at this pixel is within rounding of the opposite one.
    pub(super) fragile: Vec<bool>,
}

/// A Gaussian on the image plane.
struct Flat {
    place: [f64; 2],
    /// Σ⁻¹: xx, xy, yy.
    conic: [f64; 3],
    /// Σ: xx, yy.
    variances: [f64; 2],
    /// Three standard deviations of the longer axis, before they are rounded up.
    reach: f64,
    depth: f64,
    opacity: f64,
    colour: [f64; 3],
}

impl Flat {
    /// Kerbl et al. (2023), equation 5, and the program published with it: low-pass 0.3, near plane 0.2 m, tangents cut at 1.3 times the edge's.
    fn of(gaussian: &Gaussian, camera: &Camera) -> Option<Self> {
        let size = [camera.width() as f64, camera.height() as f64];
        let focal = camera.focal();
        let view = camera.view(&gaussian.mean);
        if view.z <= 0.2 {
            return None;
        }
        let [x, y] = [0, 1].map(|k| {
            let limit = 1.3 * 0.5 * size[k] / focal[k];
            (view[k] / view.z).clamp(-limit, limit) * view.z
        });
        let (z, [fx, fy]) = (view.z, focal);
        let jacobian =
            Mat3::new(fx / z, 0.0, -fx * x / (z * z), 0.0, fy / z, -fy * y / (z * z), 0.0, 0.0, 0.0);
        let map = jacobian * camera.rotation();
        let sigma = map * gaussian.covariance * map.transpose();
        let (a, b, c) = (sigma[(0, 0)] + 0.3, sigma[(0, 1)], sigma[(1, 1)] + 0.3);
        let determinant = a * c - b * b;
        let mean = 0.5 * (a + c);
        let largest = mean + (mean * mean - determinant).max(0.1).sqrt();
        let place = [0, 1].map(|k| focal[k] * view[k] / z + 0.5 * (size[k] - 1.0));
        Some(Self {
            place,
            conic: [c / determinant, -b / determinant, a / determinant],
            variances: [a, c],
            reach: 3.0 * largest.sqrt(),
            depth: z,
            opacity: gaussian.opacity,
            colour: gaussian.colour,
        })
    }

    /// The pixels along an axis at which the opacity may be above `least`.
    fn pixels(&self, axis: usize, count: usize, least: f64) -> std::ops::Range<usize> {
        let deviations = (2.0 * (self.opacity / least).ln()).max(0.0).sqrt();
        let half = deviations * self.variances[axis].sqrt() + 1.0;
        let end = |x: f64| x.clamp(0.0, count as f64) as usize;
        end(self.place[axis] - half)..end(self.place[axis] + half + 1.0)
    }

    /// The tiles along an axis that meet the square around the mean, and whether rounding may change them.
    fn tiles(&self, axis: usize, count: usize, rounding: f64) -> (std::ops::Range<usize>, bool) {
        let last = count.div_ceil(16) as f64;
        let tile = |x: f64| ((x / 16.0).trunc()).clamp(0.0, last) as usize;
        let ends = |reach: f64, shift: f64| {
            let radius = reach.ceil();
            tile(self.place[axis] - radius + shift)..tile(self.place[axis] + radius + 15.0 + shift)
        };
        let tiles = ends(self.reach, 0.0);
        let turned = [(-rounding, 0.0), (rounding, 0.0), (0.0, -rounding), (0.0, rounding)];
        let fragile = turned.into_iter().any(|(r, s)| ends(self.reach + r, s) != tiles);
        (tiles, fragile)
    }

    fn opacity_at(&self, x: usize, y: usize) -> f64 {
        let (dx, dy) = (self.place[0] - x as f64, self.place[1] - y as f64);
        let [a, b, c] = self.conic;
        self.opacity * (-0.5 * (a * dx * dx + c * dy * dy) - b * dx * dy).exp()
    }
}

/// What a pixel has seen so far.
#[derive(Clone, Copy)]
struct Pixel {
    colour: [f64; 3],
    light: f64,
    /// Of the last Gaussian.
    depth: f64,
    finished: bool,
    fragile: bool,
}

impl Pixel {
    /// Puts a Gaussian behind what is there.
    fn blend(&mut self, flat: &Flat, alpha: f64, rules: Rules, rounding: &Rounding) {
        if rules != Rules::Complete {
            self.fragile |= (alpha * 255.0 - 1.0).abs() < rounding.opacity;
            if alpha < 1.0 / 255.0 {
                return;
            }
        }
        self.fragile |= flat.depth - self.depth < rounding.depth;
        let alpha = alpha.min(0.99);
        let rest = self.light * (1.0 - alpha);
        if rules != Rules::Complete {
            self.fragile |= (rest / 1e-4 - 1.0).abs() < rounding.opacity;
            if rest < 1e-4 {
                self.finished = true;
                return;
            }
        }
        for (sum, colour) in self.colour.iter_mut().zip(flat.colour) {
            *sum += colour * alpha * self.light;
        }
        (self.light, self.depth) = (rest, flat.depth);
    }
}

/// Draws Gaussians.
pub(super) fn draw(
    gaussians: &[Gaussian],
    camera: &Camera,
    background: [f64; 3],
    rules: Rules,
    rounding: &Rounding,
) -> PlainPicture {
    let size = [camera.width(), camera.height()];
    let mut flats: Vec<Flat> = gaussians.iter().filter_map(|gaussian| Flat::of(gaussian, camera)).collect();
    flats.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    let untouched =
        Pixel { colour: [0.0; 3], light: 1.0, depth: f64::NEG_INFINITY, finished: false, fragile: false };
    let mut pixels = vec![untouched; size[0] * size[1]];
    let least = if rules == Rules::Complete { 1e-9 } else { 0.9 / 255.0 };
    for flat in &flats {
        let [columns, rows] = [0, 1].map(|axis| flat.pixels(axis, size[axis], least));
        let [across, down] = [0, 1].map(|axis| flat.tiles(axis, size[axis], rounding.place));
        let square = rules == Rules::Of(Mode::Exact);
        for y in rows {
            for x in columns.clone() {
                let pixel = &mut pixels[y * size[0] + x];
                if pixel.finished {
                    continue;
                }
                if square {
                    pixel.fragile |= across.1 || down.1;
                    if !(across.0.contains(&(x / 16)) && down.0.contains(&(y / 16))) {
                        continue;
                    }
                }
                pixel.blend(flat, flat.opacity_at(x, y), rules, rounding);
            }
        }
    }
    let coloured = |pixel: &Pixel| [0, 1, 2].map(|k| pixel.colour[k] + pixel.light * background[k]);
    PlainPicture {
        colours: pixels.iter().map(coloured).collect(),
        fragile: pixels.iter().map(|pixel| pixel.fragile).collect(),
    }
}

/// How two pictures differ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Difference {
    /// The largest of a channel, over pixels that are not fragile.
    pub(super) largest: f64,
    /// The root of the mean square over all channels of all pixels.
    pub(super) root_mean_square: f64,
    /// Fragile pixels by all pixels.
    pub(super) fragile: f64,
}

/// The colours of a picture in double precision.
pub(super) fn colours<E: Element>(picture: &Picture<E>) -> Vec<[f64; 3]> {
    picture.colours().iter().map(|colour| colour.map(Into::into)).collect()
}

/// The difference of two pictures; `fragile` says which pixels do not count for the largest one.
///
/// # Panics
/// If they are not of one size.
pub(super) fn difference(a: &[[f64; 3]], b: &[[f64; 3]], fragile: &[bool]) -> Difference {
    assert!(a.len() == b.len() && a.len() == fragile.len(), "pictures of one size");
    let (mut largest, mut squares) = (0.0_f64, 0.0);
    for ((a, b), &fragile) in a.iter().zip(b).zip(fragile) {
        for k in 0..3 {
            let off = (a[k] - b[k]).abs();
            squares += off * off;
            largest = if fragile { largest } else { largest.max(off) };
        }
    }
    let share = fragile.iter().filter(|fragile| **fragile).count() as f64 / a.len() as f64;
    let root_mean_square = (squares / (3 * a.len()) as f64).sqrt();
    Difference { largest, root_mean_square, fragile: share }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One red ball straight ahead: the profile in closed form, and both rules.
    #[test]
    fn a_ball_has_its_profile() {
        let camera = Camera::new([41, 41], [60.0, 60.0], Mat3::identity(), Vec3::zeros()).unwrap();
        let (mean, opacity, colour) = (Vec3::new(0.0, 0.0, 2.0), 0.8, [1.0, 0.0, 0.5]);
        let ball = Gaussian { mean, covariance: Mat3::identity() * 0.01, opacity, colour };
        let draw = |rules| draw(&[ball], &camera, [0.0, 1.0, 0.0], rules, &Rounding::DOUBLE);
        let (complete, tight) = (draw(Rules::Complete), draw(Rules::Of(Mode::Tight)));
        for pixel in 0..41 * 41 {
            let (x, y) = ((pixel % 41) as f64 - 20.0, (pixel / 41) as f64 - 20.0);
            let alpha = 0.8 * (-0.5 * (x * x + y * y) / (9.0 + 0.3)).exp();
            let expected = [alpha, 1.0 - alpha, 0.5 * alpha];
            let cut = if alpha < 1.0 / 255.0 { [0.0, 1.0, 0.0] } else { expected };
            for k in 0..3 {
                assert!((complete.colours[pixel][k] - expected[k]).abs() < 2e-9);
                assert!((tight.colours[pixel][k] - cut[k]).abs() < 1e-14);
            }
        }
        assert_eq!(tight.fragile.iter().filter(|fragile| **fragile).count(), 0);
    }
}
