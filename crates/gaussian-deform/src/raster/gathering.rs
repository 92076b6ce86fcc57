//! First stage: what is seen of each Gaussian, and in which bands of the picture.

use super::error::RasterError;
use super::footprint::{Extent, Footprint, NUMBERS};
use super::projection::{NEAR, View};
use super::{Antialiasing, Mode, Settings, TILE};
use crate::camera::Camera;
use crate::error::{Property, SplatError};
use crate::harmonics;
use crate::splats::{Degree, Splats};
use mechanics_core::lanes::{self, Element, LaneKernel, MOST_LANES, Packet};
use mechanics_core::parallel;
use mechanics_core::scalar::{Mask, Scalar};
use mechanics_core::tensor::{self, Matrix3};
use std::ops::Range;

/// Gaussians in a piece of the work: many enough to fill a vector, few enough to share among threads.
const CHUNK: usize = 4096;

/// A footprint and the half-open ranges of tiles that it may be drawn in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed<E> {
    pub footprint: Footprint<E>,
    pub columns: [u16; 2],
    pub bands: [u16; 2],
}

/// The visible Gaussians of one chunk, in the order of the scene.
pub(crate) struct Chunk<E> {
    pub placed: Vec<Placed<E>>,
    /// Numbers into `placed`, those of band 0 first, ascending within a band.
    entries: Vec<u32>,
    /// Where each band begins in `entries`, and the end.
    starts: Vec<u32>,
    /// Gaussians that are not in front of the near plane.
    pub near: usize,
}

impl<E> Chunk<E> {
    /// How many Gaussians a band has.
    pub(crate) fn count(&self, band: usize) -> usize {
        (self.starts[band + 1] - self.starts[band]) as usize
    }

    /// The Gaussians of one band, in the order of the scene.
    pub(crate) fn of_band(&self, band: usize) -> impl Iterator<Item = &Placed<E>> {
        let range = self.starts[band] as usize..self.starts[band + 1] as usize;
        self.entries[range].iter().map(|&i| &self.placed[i as usize])
    }
}

/// The visible Gaussians, chunk by chunk in the order of the scene.
///
/// # Errors
/// That of the first bad Gaussian.
pub(crate) fn gather<E: Element>(
    splats: &Splats<E>,
    camera: &Camera,
    settings: &Settings,
) -> Result<Vec<Chunk<E>>, RasterError> {
    parallel::map_chunks(splats.count(), CHUNK, |range| {
        let kernel = Kernel { splats, camera, settings, range };
        match splats.degree() {
            Degree::Zero => lanes::dispatch(kernel.with_coefficients::<3>()),
            Degree::One => lanes::dispatch(kernel.with_coefficients::<12>()),
            Degree::Two => lanes::dispatch(kernel.with_coefficients::<27>()),
            Degree::Three => lanes::dispatch(kernel.with_coefficients::<48>()),
        }
    })
    .into_iter()
    .collect()
}

struct Kernel<'a, E: Element> {
    splats: &'a Splats<E>,
    camera: &'a Camera,
    settings: &'a Settings,
    range: Range<usize>,
}

/// For `STRIDE` coefficients a Gaussian.
struct KernelOf<'a, E: Element, const STRIDE: usize>(Kernel<'a, E>);

impl<'a, E: Element> Kernel<'a, E> {
    fn with_coefficients<const STRIDE: usize>(self) -> KernelOf<'a, E, STRIDE> {
        KernelOf(self)
    }
}

impl<E: Element, const STRIDE: usize> LaneKernel<E> for KernelOf<'_, E, STRIDE> {
    type Output = Result<Chunk<E>, RasterError>;

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) -> Self::Output {
        let Kernel { splats, camera, settings, range } = self.0;
        let view = View::<P>::new(camera);
        let mut chunk = Collector::new(camera, settings.mode, range.len());
        let mut first = range.start;
        while first < range.end {
            let lanes = P::LANES.min(range.end - first);
            let pack = Pack::<P>::load(splats, first, lanes);
            if !pack.is_good() {
                return Err(culprit(splats, first..first + lanes));
            }
            let offset = view.offset(pack.mean);
            let projection = view.project(offset, &pack.axes);
            let opacity = match settings.antialiasing {
                Antialiasing::Absent => pack.opacity,
                Antialiasing::Present => pack.opacity * projection.sharpness(),
            };
            let (mut footprint, extent) = Footprint::new(&projection, opacity);
            let seen = chunk.seen(first, lanes, &footprint, &extent)?;
            if seen != 0 {
                footprint.colour = colours::<P, STRIDE>(splats, first, lanes, offset);
                chunk.push(first, seen, &footprint)?;
            }
            first += lanes;
        }
        Ok(chunk.finish())
    }
}

/// As many Gaussians as lanes; the last one again where there are fewer.
struct Pack<P> {
    mean: [P; 3],
    axes: Matrix3<P>,
    opacity: P,
}

impl<P: Packet> Pack<P> {
    #[inline(always)]
    fn load(splats: &Splats<P::Element>, first: usize, lanes: usize) -> Self {
        let mut mean = [<P::Element as Element>::Lanes::default(); 3];
        for lane in 0..P::LANES {
            let components = tensor::components(&splats.means()[first + lane.min(lanes - 1)]);
            for k in 0..3 {
                mean[k].as_mut()[lane] = components[k];
            }
        }
        let opacities = &splats.opacities()[first..first + lanes];
        Self {
            mean: [P::from_lanes(mean[0]), P::from_lanes(mean[1]), P::from_lanes(mean[2])],
            axes: matrices(splats.axes(), first, lanes),
            opacity: P::load_or(opacities, opacities[0]),
        }
    }

    /// Whether everything is finite and every opacity from 0 to 1.
    #[inline(always)]
    fn is_good(&self) -> bool {
        let (zero, one) = (P::constant(0.0), P::constant(1.0));
        // Zero times anything that is not finite is NaN.
        let mut poison = zero;
        for x in self.mean {
            poison = x.mul_add(zero, poison);
        }
        for column in tensor::columns(&self.axes) {
            for &x in column {
                poison = x.mul_add(zero, poison);
            }
        }
        let range = zero.less_equal(self.opacity).and(self.opacity.less_equal(one));
        poison.less_equal(zero).and(range).all()
    }
}

/// Matrices `first ..` as lanes; the last one again where there are fewer.
#[inline(always)]
fn matrices<P: Packet>(all: &[Matrix3<P::Element>], first: usize, lanes: usize) -> Matrix3<P> {
    if lanes == P::LANES {
        return lanes::load_matrices(&all[first..first + lanes]);
    }
    let mut filled = [all[first]; MOST_LANES];
    filled[..lanes].copy_from_slice(&all[first..first + lanes]);
    lanes::load_matrices(&filled[..P::LANES])
}

/// The colours of as many Gaussians as lanes, not cut off at zero. `offset` leads from the eye to the means.
///
/// (Loops, not closures: a closure that is not inlined would be compiled without vectors.)
#[inline(always)]
fn colours<P: Packet, const STRIDE: usize>(
    splats: &Splats<P::Element>,
    first: usize,
    lanes: usize,
    offset: [P; 3],
) -> [P; 3] {
    let coefficients = coefficients::<P, STRIDE>(splats.harmonics(), first, lanes);
    // No direction is needed in degree 0, also not of a Gaussian at the eye.
    let mut basis = [P::constant(harmonics::BAND_0); harmonics::MOST_COEFFICIENTS];
    if STRIDE > 3 {
        let length = tensor::dot(&offset, &offset).sqrt();
        let mut d = [offset[0] / length, offset[1] / length, offset[2] / length];
        if let Some(all) = splats.orientations() {
            let rotation = matrices(all, first, lanes);
            let columns = tensor::columns(&rotation);
            d = [tensor::dot(&columns[0], &d), tensor::dot(&columns[1], &d), tensor::dot(&columns[2], &d)];
        }
        basis = harmonics::basis(splats.degree(), d);
    }
    let mut colours = [P::constant(0.5); 3];
    for (channel, colour) in colours.iter_mut().enumerate() {
        for k in 0..STRIDE / 3 {
            *colour = coefficients[channel * (STRIDE / 3) + k].mul_add(basis[k], *colour);
        }
    }
    colours
}

/// Coefficient k of as many Gaussians as lanes, for every k.
#[inline(always)]
fn coefficients<P: Packet, const STRIDE: usize>(
    harmonics: &[P::Element],
    first: usize,
    lanes: usize,
) -> [P; STRIDE] {
    let mut coefficients = [P::constant(0.0); STRIDE];
    let mut block = [P::constant(0.0); MOST_LANES];
    let block = &mut block[..P::LANES];
    for k in (0..STRIDE).step_by(P::LANES) {
        for (lane, row) in block.iter_mut().enumerate() {
            // A row may end in the next Gaussian's coefficients; those lanes are not used.
            let start = (first + lane.min(lanes - 1)) * STRIDE + k;
            let end = (start + P::LANES).min(harmonics.len());
            *row = P::load_or(&harmonics[start..end], P::Element::constant(0.0));
        }
        P::transpose(block);
        for (coefficient, row) in coefficients[k..].iter_mut().zip(block.iter()) {
            *coefficient = *row;
        }
    }
    coefficients
}

/// What is wrong with the first bad one of some Gaussians.
#[cold]
fn culprit<E: Element>(splats: &Splats<E>, range: Range<usize>) -> RasterError {
    for splat in range.clone() {
        let bad = |property, numbers: &[E]| {
            let value = numbers.iter().map(|&x| x.into()).find(|x: &f64| !x.is_finite())?;
            Some(SplatError::BadValue { splat, property, value })
        };
        let opacity: f64 = splats.opacities()[splat].into();
        let out_of_range = !(0.0..=1.0).contains(&opacity);
        let error = bad(Property::Mean, splats.means()[splat].as_slice())
            .or_else(|| bad(Property::Axes, splats.axes()[splat].as_slice()))
            .or_else(|| {
                let property = Property::Opacity;
                out_of_range.then_some(SplatError::BadValue { splat, property, value: opacity })
            });
        if let Some(error) = error {
            return error.into();
        }
    }
    RasterError::Overflow { splat: range.start }
}

/// The visible Gaussians of a chunk, as they come.
struct Collector<E> {
    mode: Mode,
    size: [usize; 2],
    tiles: [usize; 2],
    /// Of the packet that is being worked on, by lane.
    ranges: [[[u16; 2]; 2]; MOST_LANES],
    placed: Vec<Placed<E>>,
    counts: Vec<u32>,
    near: usize,
}

impl<E: Element> Collector<E> {
    fn new(camera: &Camera, mode: Mode, capacity: usize) -> Self {
        let size = [camera.width(), camera.height()];
        let tiles = size.map(|side| side.div_ceil(TILE));
        Self {
            mode,
            size,
            tiles,
            ranges: [[[0; 2]; 2]; MOST_LANES],
            placed: Vec::with_capacity(capacity),
            counts: vec![0; tiles[1] + 1],
            near: 0,
        }
    }

    /// Which lanes are seen, as bits; notes their tiles.
    #[inline(always)]
    fn seen<P: Packet<Element = E>>(
        &mut self,
        first: usize,
        lanes: usize,
        footprint: &Footprint<P>,
        extent: &Extent<P>,
    ) -> Result<u32, RasterError> {
        let valid = (1_u32 << lanes) - 1;
        let in_front = P::bits(P::constant(NEAR).less(footprint.depth)) & valid;
        let behind = P::bits(footprint.depth.less_equal(P::constant(NEAR))) & valid;
        self.near += behind.count_ones() as usize;
        let everything = extent.visible[0] + extent.visible[1] + footprint.slope + footprint.depth;
        let finite = P::bits(everything.is_finite());
        let overflowing = valid & !behind & !(in_front & finite);
        if overflowing != 0 {
            return Err(RasterError::Overflow { splat: first + overflowing.trailing_zeros() as usize });
        }
        let mut candidates = in_front & P::bits(P::constant(0.0).less_equal(footprint.reach));
        let mut seen = 0;
        let middle = [footprint.middle[0].to_lanes(), footprint.middle[1].to_lanes()];
        let visible = [extent.visible[0].to_lanes(), extent.visible[1].to_lanes()];
        let three_sigma = extent.three_sigma.to_lanes();
        while candidates != 0 {
            let lane = candidates.trailing_zeros() as usize;
            candidates &= candidates - 1;
            let radius = three_sigma.as_ref()[lane].into().ceil();
            for k in 0..2 {
                let (middle, visible) = (middle[k].as_ref()[lane].into(), visible[k].as_ref()[lane].into());
                let mut range = visible_tiles(middle, visible, self.size[k]);
                if self.mode == Mode::Exact {
                    let square = tiles_of_square(middle, radius, self.tiles[k]);
                    range = [range[0].max(square[0]), range[1].min(square[1])];
                }
                self.ranges[lane][k] = range;
            }
            let [columns, bands] = self.ranges[lane];
            if columns[0] < columns[1] && bands[0] < bands[1] {
                seen |= 1 << lane;
            }
        }
        Ok(seen)
    }

    /// Appends the lanes that are seen.
    #[inline(always)]
    fn push<P: Packet<Element = E>>(
        &mut self,
        first: usize,
        seen: u32,
        footprint: &Footprint<P>,
    ) -> Result<(), RasterError> {
        let [red, green, blue] = footprint.colour;
        // Before the cut at zero, which may hide NaN.
        let finite = P::bits((red + green + blue).is_finite());
        if seen & !finite != 0 {
            return Err(RasterError::BadColour { splat: first + (seen & !finite).trailing_zeros() as usize });
        }
        let zero = P::constant(0.0);
        let colour = [red.max(zero), green.max(zero), blue.max(zero)];
        let packets = Footprint { colour, ..*footprint }.numbers();
        let mut lanes = [E::Lanes::default(); NUMBERS];
        for k in 0..NUMBERS {
            lanes[k] = packets[k].to_lanes();
        }
        let mut seen = seen;
        while seen != 0 {
            let lane = seen.trailing_zeros() as usize;
            seen &= seen - 1;
            let [columns, bands] = self.ranges[lane];
            for band in bands[0]..bands[1] {
                self.counts[band as usize + 1] += 1;
            }
            let mut numbers = [E::constant(0.0); NUMBERS];
            for k in 0..NUMBERS {
                numbers[k] = lanes[k].as_ref()[lane];
            }
            self.placed.push(Placed { footprint: Footprint::from_numbers(numbers), columns, bands });
        }
        Ok(())
    }

    /// Sorts by band.
    fn finish(self) -> Chunk<E> {
        let mut starts = self.counts;
        for band in 1..starts.len() {
            starts[band] += starts[band - 1];
        }
        let mut ends = starts.clone();
        let total = starts.last().copied().unwrap_or(0);
        let mut entries = vec![0; total as usize];
        for (i, placed) in self.placed.iter().enumerate() {
            for band in placed.bands[0]..placed.bands[1] {
                let end = &mut ends[band as usize];
                entries[*end as usize] = i as u32;
                *end += 1;
            }
        }
        Chunk { placed: self.placed, entries, starts, near: self.near }
    }
}

/// The tiles of a side of `size` pixels that have a pixel within `reach` of `middle`.
#[inline(always)]
fn visible_tiles(middle: f64, reach: f64, size: usize) -> [u16; 2] {
    // Casts to integers saturate.
    let first = (middle - reach).ceil() as i64;
    let last = ((middle + reach).floor() as i64).min(size as i64 - 1);
    let first = first.max(0);
    if last < first { [0, 0] } else { [(first as usize / TILE) as u16, (last as usize / TILE) as u16 + 1] }
}

/// The tiles, of a number of `tiles`, that the original rules draw a Gaussian in.
#[inline(always)]
fn tiles_of_square(middle: f64, radius: f64, tiles: usize) -> [u16; 2] {
    let side = TILE as f64;
    let tile = |x: f64| (x as i64).clamp(0, tiles as i64) as u16;
    [tile((middle - radius) / side), tile((middle + radius + side - 1.0) / side)]
}
