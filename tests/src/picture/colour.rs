//! Colours of equal steps.

use std::sync::LazyLock;

/// An sRGB colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Rgb(pub [u8; 3]);

/// Maps from \[0, 1\] to colours.
///
/// Both are made in OKLab, where equal steps look equally large, so that lightness is monotone (or symmetric) by
/// construction and survives printing in grey and most colour blindness.
///
/// # Reference
/// B. Ottosson 2020, “A perceptual color space for image processing” (the matrices of OKLab).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourMap {
    /// Dark violet through blue and green to yellow: for magnitudes.
    #[default]
    Magnitude,
    /// Blue through white to red: for signed values; give a symmetric range.
    Signed,
}

const STEPS: usize = 256;

static MAGNITUDE: LazyLock<[Rgb; STEPS]> = LazyLock::new(|| table(magnitude));
static SIGNED: LazyLock<[Rgb; STEPS]> = LazyLock::new(|| table(signed));

impl ColourMap {
    /// The colour at `share`, which is held to \[0, 1\]; NaN is taken as 0.
    pub fn colour(self, share: f64) -> Rgb {
        let step = (share.clamp(0.0, 1.0) * (STEPS - 1) as f64).round() as usize;
        match self {
            Self::Magnitude => MAGNITUDE[step],
            Self::Signed => SIGNED[step],
        }
    }
}

fn table(colour: fn(f64) -> [f64; 3]) -> [Rgb; STEPS] {
    std::array::from_fn(|step| shown(colour(step as f64 / (STEPS - 1) as f64)))
}

/// Lightness from 0.27 to 0.91 in equal steps while the hue turns from violet (310°) to yellow (105°).
fn magnitude(share: f64) -> [f64; 3] {
    let hue = (310.0 - 205.0 * share).to_radians();
    [0.27 + 0.64 * share, 0.16, hue]
}

/// Lightness 0.45 at both ends and 0.97 in the middle, where the colour fades.
fn signed(share: f64) -> [f64; 3] {
    let side = 2.0 * share - 1.0;
    let hue = if side < 0.0 { 255.0f64 } else { 28.0 };
    [0.97 - 0.52 * side.abs(), 0.19 * side.abs(), hue.to_radians()]
}

/// The sRGB colour of lightness, chroma and hue; chroma is reduced until the colour can be shown.
fn shown([lightness, chroma, hue]: [f64; 3]) -> Rgb {
    let linear = |chroma: f64| linear_rgb([lightness, chroma * hue.cos(), chroma * hue.sin()]);
    let fits = |rgb: [f64; 3]| rgb.iter().all(|c| (0.0..=1.0).contains(c));
    let (mut low, mut high) = (0.0, chroma);
    if !fits(linear(chroma)) {
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if fits(linear(middle)) { low = middle } else { high = middle }
        }
    } else {
        low = chroma;
    }
    Rgb(linear(low).map(|c| (255.0 * gamma(c.clamp(0.0, 1.0))).round() as u8))
}

/// OKLab to linear sRGB.
fn linear_rgb([l, a, b]: [f64; 3]) -> [f64; 3] {
    let long = (l + 0.3963377774 * a + 0.2158037573 * b).powi(3);
    let medium = (l - 0.1055613458 * a - 0.0638541728 * b).powi(3);
    let short = (l - 0.0894841775 * a - 1.2914855480 * b).powi(3);
    [
        4.0767416621 * long - 3.3077115913 * medium + 0.2309699292 * short,
        -1.2684380046 * long + 2.6097574011 * medium - 0.3413193965 * short,
        -0.0041960863 * long - 0.7034186147 * medium + 1.7076147010 * short,
    ]
}

/// The transfer curve of sRGB (IEC 61966-2-1).
fn gamma(linear: f64) -> f64 {
    if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}
