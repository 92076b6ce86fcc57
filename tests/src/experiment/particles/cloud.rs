//! Material points of a body at rest.

use std::f64::consts::TAU;

/// Material points and the volume \[m³\] that each one stands for; in the plane the area \[m²\].
#[derive(Clone, Debug, Default)]
pub(super) struct Cloud<const D: usize> {
    pub(super) points: Vec<[f64; D]>,
    pub(super) volumes: Vec<f64>,
}

impl<const D: usize> Cloud<D> {
    /// A box in `counts` equal parts an axis, one particle in the middle of each; the last axis runs fastest.
    pub(super) fn cuboid(low: [f64; D], high: [f64; D], counts: [usize; D]) -> Self {
        let gap: [f64; D] = std::array::from_fn(|a| (high[a] - low[a]) / counts[a] as f64);
        let parts: usize = counts.iter().product();
        let point = |k: usize| {
            std::array::from_fn(|a| {
                let faster: usize = counts[a + 1..].iter().product();
                low[a] + gap[a] * ((k / faster % counts[a]) as f64 + 0.5)
            })
        };
        Self { points: (0..parts).map(point).collect(), volumes: vec![gap.iter().product(); parts] }
    }

    /// Its volume \[m³\].
    pub(super) fn volume(&self) -> f64 {
        self.volumes.iter().sum()
    }
}

impl Cloud<2> {
    /// An annulus in rings of parts that are about `gap` wide and exactly tile it.
    pub(super) fn annulus(inner: f64, outer: f64, gap: f64) -> Self {
        let rings = ((outer - inner) / gap).round().max(1.0) as usize;
        let width = (outer - inner) / rings as f64;
        let mut cloud = Self::default();
        for ring in 0..rings {
            let radius = inner + width * (ring as f64 + 0.5);
            let parts = (TAU * radius / gap).round().max(1.0) as usize;
            let angle = TAU / parts as f64;
            for part in 0..parts {
                let (sine, cosine) = (angle * (part as f64 + 0.5)).sin_cos();
                cloud.points.push([radius * cosine, radius * sine]);
                cloud.volumes.push(radius * angle * width);
            }
        }
        cloud
    }
}
