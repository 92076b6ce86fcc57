//! What comes out.

use super::DepthChannel;
use mechanics_core::lanes::Element;
use mechanics_core::scalar::Scalar;

/// A picture, row by row from the upper left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture<E> {
    pub(super) size: [usize; 2],
    pub(super) colours: Vec<[E; 3]>,
    pub(super) transmittance: Vec<E>,
    pub(super) depth: Option<Vec<E>>,
    pub(super) report: PictureReport,
}

/// What it took to make a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PictureReport {
    /// Gaussians of the scene.
    pub gaussians: usize,
    /// Gaussians behind the near plane, which were left out.
    pub near: usize,
    /// Gaussians that are visible somewhere in the picture, if nothing is in front of them.
    pub visible: usize,
    /// Pairs of a Gaussian and a tile that were drawn; those behind finished tiles are not counted.
    pub drawn: usize,
}

impl<E: Element> Picture<E> {
    /// A picture of no pixels, to be drawn into.
    pub fn empty() -> Self {
        let report = PictureReport::default();
        Self { size: [0, 0], colours: Vec::new(), transmittance: Vec::new(), depth: None, report }
    }

    /// Makes room; what was drawn before stays until it is drawn over.
    pub(super) fn resize(&mut self, size: [usize; 2], depth: DepthChannel) {
        let (pixels, zero) = (size[0] * size[1], E::constant(0.0));
        self.size = size;
        self.colours.resize(pixels, [zero; 3]);
        self.transmittance.resize(pixels, zero);
        match depth {
            DepthChannel::Absent => self.depth = None,
            DepthChannel::Present => self.depth.get_or_insert_default().resize(pixels, zero),
        }
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.size[0]
    }

    /// Rows of pixels.
    pub fn height(&self) -> usize {
        self.size[1]
    }

    /// Red, green and blue by pixel, the background included; at least zero, not cut at one.
    pub fn colours(&self) -> &[[E; 3]] {
        &self.colours
    }

    /// The share of the background that comes through, by pixel: one minus the picture's alpha.
    pub fn transmittance(&self) -> &[E] {
        &self.transmittance
    }

    /// Σ αᵢ Tᵢ zᵢ by pixel, the depths of the Gaussians weighted as their colours are \[m\]; divided by one minus the transmittance it is their
    /// mean depth. `None` if it was not asked for.
    pub fn depth(&self) -> Option<&[E]> {
        self.depth.as_deref()
    }

    /// What it took.
    pub fn report(&self) -> PictureReport {
        self.report
    }

    /// Red, green, blue of every pixel in bytes, as picture files want it: cut to \[0, 1\] and rounded to the nearest of 256 levels.
    pub fn to_rgb8(&self) -> Vec<u8> {
        let byte = |channel: &E| (Into::<f64>::into(*channel).clamp(0.0, 1.0) * 255.0).round() as u8;
        self.colours.iter().flatten().map(byte).collect()
    }

    /// The peak signal-to-noise ratio −10 log₁₀(mean squared difference of all channels) of two pictures \[dB\]; infinite for equal ones.
    ///
    /// # Panics
    /// If the pictures are not of one size.
    pub fn signal_to_noise<T: Element>(&self, other: &Picture<T>) -> f64 {
        assert_eq!(self.size, other.size, "pictures of one size");
        let difference = |(a, b): (&E, &T)| Scalar::square(Into::<f64>::into(*a) - Into::<f64>::into(*b));
        let channels = self.colours.iter().flatten().zip(other.colours.iter().flatten());
        let squares: f64 = channels.map(difference).sum();
        -10.0 * (squares / (3 * self.colours.len()) as f64).log10()
    }
}
