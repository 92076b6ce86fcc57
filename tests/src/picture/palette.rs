//! Few colours in place of many.

use super::colour::Rgb;
use super::image::Image;

/// A few colours for all pictures, found by median cut on colours rounded to six bits a channel.
///
/// # Reference
/// P. Heckbert 1982, “Color image quantization for frame buffer display”, section 3 (median cut).
pub(super) struct Palette {
    colours: Vec<Rgb>,
    /// The palette's index of every rounded colour.
    index: Vec<u8>,
}

const BITS: u32 = 6;

fn bin(Rgb([r, g, b]): Rgb) -> usize {
    let top = |c: u8| usize::from(c >> (8 - BITS));
    top(r) << (2 * BITS) | top(g) << BITS | top(b)
}

/// A rounded colour that occurs: how often, and the sum of its exact colours.
#[derive(Clone, Copy, Default)]
struct Bin {
    at: usize,
    count: u64,
    sum: [u64; 3],
}

impl Bin {
    fn channel(&self, channel: usize) -> usize {
        self.at >> (BITS as usize * (2 - channel)) & ((1 << BITS) - 1)
    }
}

impl Palette {
    /// The most colours; a byte has one number more.
    pub(super) const MOST: usize = 255;

    /// At most `most` colours, themselves at most [`Palette::MOST`], for all `frames`.
    pub(super) fn of(frames: &[Image], most: usize) -> Self {
        let mut bins = vec![Bin::default(); 1 << (3 * BITS)];
        for pixel in frames.iter().flat_map(|frame| frame.pixels()) {
            let bin = &mut bins[bin(*pixel)];
            bin.count += 1;
            (0..3).for_each(|c| bin.sum[c] += u64::from(pixel.0[c]));
        }
        bins.iter_mut().enumerate().for_each(|(at, bin)| bin.at = at);
        bins.retain(|bin| bin.count > 0);
        let mut index = vec![0; 1 << (3 * BITS)];
        let mut colours = Vec::new();
        for group in median_cut(&mut bins, most.min(Self::MOST)) {
            group.iter().for_each(|bin| index[bin.at] = colours.len() as u8);
            let count: u64 = group.iter().map(|bin| bin.count).sum();
            let mean = |c: usize| (group.iter().map(|bin| bin.sum[c]).sum::<u64>() + count / 2) / count;
            colours.push(Rgb([0, 1, 2].map(|c| mean(c) as u8)));
        }
        Self { colours, index }
    }

    /// The palette as GIF wants it: 256 colours, the last one for the unchanged.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let mut bytes: Vec<u8> = self.colours.iter().flat_map(|colour| colour.0).collect();
        bytes.resize(3 * 256, 0);
        bytes
    }

    /// The colours of `image` as numbers of the palette.
    pub(super) fn indices(&self, image: &Image) -> Vec<u8> {
        image.pixels().iter().map(|pixel| self.index[bin(*pixel)]).collect()
    }
}

/// Splits `bins` into at most `most` groups: again and again the group with the largest squared spread times the fourth root of
/// its pixels, at the median of its widest channel. So few pixels of a rare colour still get one that is near to theirs.
fn median_cut(bins: &mut [Bin], most: usize) -> Vec<&mut [Bin]> {
    let mut groups = vec![bins];
    while groups.len() < most {
        let score = |group: &[Bin]| {
            let count: u64 = group.iter().map(|bin| bin.count).sum();
            (count as f64).powf(0.25) * (widest(group).1 as f64).powi(2)
        };
        let scores: Vec<f64> = groups.iter().map(|group| score(group)).collect();
        let Some(largest) = (0..groups.len()).max_by(|&a, &b| scores[a].total_cmp(&scores[b])) else { break };
        if scores[largest] == 0.0 {
            break;
        }
        let group = groups.swap_remove(largest);
        let channel = widest(group).0;
        group.sort_by_key(|bin| (bin.channel(channel), bin.at));
        let half = group.iter().map(|bin| bin.count).sum::<u64>() / 2;
        let mut before = 0;
        let median = group.iter().position(|bin| {
            before += bin.count;
            before > half
        });
        // A group that spreads has two bins or more, so that both halves hold one.
        let split = median.unwrap_or(1).clamp(1, group.len() - 1);
        let (low, high) = group.split_at_mut(split);
        groups.extend([low, high]);
    }
    groups
}

/// The channel in which a group spreads most, and how much.
fn widest(group: &[Bin]) -> (usize, usize) {
    let spread = |channel: usize| {
        let values = || group.iter().map(|bin| bin.channel(channel));
        values().max().unwrap_or(0) - values().min().unwrap_or(0)
    };
    let spreads = [spread(0), spread(1), spread(2)];
    let channel = (0..3).max_by_key(|&c| (spreads[c], 3 - c)).unwrap_or(0);
    (channel, spreads[channel])
}
