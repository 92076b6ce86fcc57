//! Pictures in a row, as an animated GIF.

use super::image::{Image, Size};
use super::palette::Palette;
use crate::report::{WriteError, write_file};
use gif::{DisposalMethod, Encoder, Frame, Repeat};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Pictures of one size, shown one after the other.
#[derive(Clone, Debug)]
pub struct Film {
    seconds_a_frame: f64,
    frames: Vec<Image>,
}

/// What became of a film as MP4.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mp4 {
    /// It is there.
    Written,
    /// There is no ffmpeg.
    NoFfmpeg,
}

/// Why there is no film.
#[derive(Debug, thiserror::Error)]
pub enum FilmError {
    /// The frame is of another size than those before it.
    #[error("frame {index} is {found:?}, the frames before it {expected:?}")]
    SizeDiffers {
        /// Which frame, from 0.
        index: usize,
        /// Its size.
        found: Size,
        /// The size of the first.
        expected: Size,
    },
    /// The format holds at most 65535 pixels a side.
    #[error("a GIF holds at most 65535 pixels a side, the film is {0:?}")]
    TooLarge(Size),
    /// No frame.
    #[error("a film needs a frame")]
    Empty,
    /// The encoder failed.
    #[error("cannot encode {}: {source}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// Why.
        source: gif::EncodingError,
    },
    /// The file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// ffmpeg failed.
    #[error("ffmpeg cannot write {}: {message}", path.display())]
    Ffmpeg {
        /// The file.
        path: PathBuf,
        /// What it says, or the system.
        message: String,
    },
}

/// Browsers show frames shorter than this at a tenth of a second \[s\].
const SHORTEST_FRAME: f64 = 0.02;
/// Index of the pixel that stays as it was: the one that a palette leaves free.
const UNCHANGED: u8 = Palette::MOST as u8;

impl Film {
    /// An empty film whose frames stand for `seconds_a_frame` \[s\] each, at least 0.02 and at most 600.
    pub fn new(seconds_a_frame: f64) -> Self {
        let seconds_a_frame =
            if seconds_a_frame.is_nan() { 0.1 } else { seconds_a_frame.clamp(SHORTEST_FRAME, 600.0) };
        Self { seconds_a_frame, frames: Vec::new() }
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// [`FilmError::SizeDiffers`]; the film is as before.
    pub fn push(&mut self, frame: Image) -> Result<(), FilmError> {
        if let Some(first) = self.frames.first()
            && first.size() != frame.size()
        {
            let (found, expected) = (frame.size(), first.size());
            return Err(FilmError::SizeDiffers { index: self.frames.len(), found, expected });
        }
        self.frames.push(frame);
        Ok(())
    }

    /// Its frames.
    pub fn frames(&self) -> &[Image] {
        &self.frames
    }

    /// Writes the film as a GIF that repeats for ever, whole or not at all.
    ///
    /// One palette of 255 colours serves all frames, so that colours do not flicker; frames hold only the rectangle that
    /// changed. Frame times are whole hundredths of a second chosen so that the film's length is right to a hundredth.
    ///
    /// # Errors
    /// [`FilmError`] when there is no frame, when it is too large for the format, or cannot be written.
    pub fn save_gif(&self, path: &Path) -> Result<(), FilmError> {
        let first = self.frames.first().ok_or(FilmError::Empty)?;
        let side = |pixels: usize| u16::try_from(pixels).map_err(|_| FilmError::TooLarge(first.size()));
        let (width, height) = (side(first.size().width)?, side(first.size().height)?);
        let palette = Palette::of(&self.frames, Palette::MOST);
        let failed = |source| FilmError::Encode { path: path.to_owned(), source };
        let mut out = Vec::new();
        let mut encoder = Encoder::new(&mut out, width, height, &palette.bytes()).map_err(failed)?;
        encoder.set_repeat(Repeat::Infinite).map_err(failed)?;
        let mut shown: Vec<u8> = Vec::new();
        for (index, image) in self.frames.iter().enumerate() {
            let pixels = palette.indices(image);
            let mut frame = changed(&shown, &pixels, first.size());
            frame.delay = self.delay(index);
            encoder.write_frame(&frame).map_err(failed)?;
            shown = pixels;
        }
        drop(encoder);
        Ok(write_file(path, &out)?)
    }

    /// Writes the film as MP4 (H.264) where there is an ffmpeg, and answers whether there is one.
    ///
    /// # Errors
    /// [`FilmError`] when there is no frame, or ffmpeg fails.
    pub fn save_mp4(&self, path: &Path) -> Result<Mp4, FilmError> {
        let first = self.frames.first().ok_or(FilmError::Empty)?;
        let Size { width, height } = first.size();
        let failed = |message: String| FilmError::Ffmpeg { path: path.to_owned(), message };
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg.args(["-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s"]);
        ffmpeg.arg(format!("{width}x{height}")).args([
            "-r",
            &format!("{:?}", 1.0 / self.seconds_a_frame),
            "-i",
            "-",
        ]);
        // Players want whole numbers of pairs of pixels, and colours of half the resolution.
        ffmpeg.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"]).arg(path);
        ffmpeg.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = match ffmpeg.spawn() {
            Ok(child) => child,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Mp4::NoFfmpeg),
            Err(error) => return Err(failed(error.to_string())),
        };
        let fed = child.stdin.take().map_or(Ok(()), |mut input| {
            self.frames.iter().try_for_each(|frame| {
                let bytes: Vec<u8> = frame.pixels().iter().flat_map(|pixel| pixel.0).collect();
                input.write_all(&bytes)
            })
        });
        let output = child.wait_with_output().map_err(|error| failed(error.to_string()))?;
        if !output.status.success() {
            return Err(failed(String::from_utf8_lossy(&output.stderr).trim().to_owned()));
        }
        fed.map_err(|error| failed(error.to_string()))?;
        Ok(Mp4::Written)
    }

    /// Hundredths of a second that frame `index` stands: the difference of rounded times, so that rounding does not add up.
    fn delay(&self, index: usize) -> u16 {
        let end = |frames: usize| (100.0 * self.seconds_a_frame * frames as f64).round();
        (end(index + 1) - end(index)).clamp(1.0, 65535.0) as u16
    }
}

/// The least rectangle in which `pixels` differ from what is shown; inside it unchanged pixels are transparent, which packs
/// better. The first frame is whole; one without change is a single transparent pixel, so that it keeps its time.
fn changed(shown: &[u8], pixels: &[u8], size: Size) -> Frame<'static> {
    let differs = |x: usize, y: usize| {
        let at = y * size.width + x;
        shown.get(at) != Some(&pixels[at])
    };
    let (mut left, mut right, mut top, mut bottom) = (size.width, 0, size.height, 0);
    for y in 0..size.height {
        for x in 0..size.width {
            if differs(x, y) {
                (left, right) = (left.min(x), right.max(x + 1));
                (top, bottom) = (top.min(y), bottom.max(y + 1));
            }
        }
    }
    if left >= right {
        (left, right, top, bottom) = (0, 1, 0, 1);
    }
    let rectangle = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
    let buffer: Vec<u8> =
        rectangle.map(|(x, y)| if differs(x, y) { pixels[y * size.width + x] } else { UNCHANGED }).collect();
    Frame {
        left: left as u16,
        top: top as u16,
        width: (right - left) as u16,
        height: (bottom - top) as u16,
        transparent: Some(UNCHANGED),
        dispose: DisposalMethod::Keep,
        buffer: buffer.into(),
        ..Frame::default()
    }
}
