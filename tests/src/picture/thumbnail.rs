//! Small copies of pictures and of the last frames of films, which know what they show.

use super::colour::Rgb;
use super::image::{Image, Size};
use super::palette::Palette;
use std::path::Path;

/// Colours of a small copy: few pack better, and more are not told apart at that size.
const COLOURS: usize = 64;

/// The keyword that PNG (third edition, section 11.3.3.1) gives to what a picture shows.
const DESCRIPTION: &str = "Description";

/// Why there is no small copy.
#[derive(Debug, thiserror::Error)]
pub enum ThumbnailError {
    /// The file cannot be opened.
    #[error("cannot be read: {0}")]
    Read(#[from] std::io::Error),
    /// It is not a PNG.
    #[error("is not a PNG that we write: {0}")]
    Png(#[from] png::DecodingError),
    /// It is not a GIF.
    #[error("is not a GIF that we write: {0}")]
    Gif(#[from] gif::DecodingError),
    /// Pixels are not three bytes, or there are none.
    #[error("is not of red, green and blue bytes")]
    Format,
    /// The copy cannot be encoded.
    #[error("has no small copy: {0}")]
    Encode(#[from] png::EncodingError),
}

/// The picture at `path`, or the last frame of the film, as a PNG of few colours that fits into `size` and holds the `description`.
///
/// # Errors
/// [`ThumbnailError`] unless it is a PNG or GIF as this package writes them.
pub fn thumbnail(path: &Path, size: Size, description: &str) -> Result<Vec<u8>, ThumbnailError> {
    let film = path.extension().is_some_and(|kind| kind.eq_ignore_ascii_case("gif"));
    let image = if film { last_frame(path)? } else { picture(path)? };
    Ok(few_colours(&reduced(&image, size), description)?)
}

/// What the PNG at `path` says that it shows.
pub fn description(path: &Path) -> Option<String> {
    let file = std::io::BufReader::new(std::fs::File::open(path).ok()?);
    let reader = png::Decoder::new(file).read_info().ok()?;
    let texts = &reader.info().utf8_text;
    texts.iter().find(|text| text.keyword == DESCRIPTION).and_then(|text| text.get_text().ok())
}

fn picture(path: &Path) -> Result<Image, ThumbnailError> {
    let mut reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(path)?)).read_info()?;
    let mut bytes = vec![0; reader.output_buffer_size().ok_or(ThumbnailError::Format)?];
    let info = reader.next_frame(&mut bytes)?;
    let rgb = (info.color_type, info.bit_depth) == (png::ColorType::Rgb, png::BitDepth::Eight);
    let size = Size { width: info.width as usize, height: info.height as usize };
    if rgb { Ok(Image::of_rgb8(size, &bytes)) } else { Err(ThumbnailError::Format) }
}

/// Frames hold only what changed, and stay.
fn last_frame(path: &Path) -> Result<Image, ThumbnailError> {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(std::io::BufReader::new(std::fs::File::open(path)?))?;
    let size = Size { width: usize::from(decoder.width()), height: usize::from(decoder.height()) };
    let mut image = Image::filled(size, Rgb([255; 3]));
    while let Some(frame) = decoder.read_next_frame()? {
        let (left, top, width) = (i64::from(frame.left), i64::from(frame.top), usize::from(frame.width));
        for (k, pixel) in frame.buffer.chunks_exact(4).enumerate().filter(|(_, pixel)| pixel[3] > 0) {
            let (x, y) = (left + (k % width) as i64, top + (k / width) as i64);
            image.set(x, y, Rgb([pixel[0], pixel[1], pixel[2]]));
        }
    }
    Ok(image)
}

/// A copy that fits into `size`, never larger; each pixel is the mean of what it covers.
fn reduced(image: &Image, size: Size) -> Image {
    let from = image.size();
    let scale = (from.width as f64 / size.width as f64).max(from.height as f64 / size.height as f64).max(1.0);
    let to = |pixels: usize| ((pixels as f64 / scale) as usize).max(1);
    let mut copy = Image::filled(Size { width: to(from.width), height: to(from.height) }, Rgb([255; 3]));
    let Size { width, height } = copy.size();
    for (y, rows) in shares(from.height, height).iter().enumerate() {
        for (x, columns) in shares(from.width, width).iter().enumerate() {
            let mut sum = [0.0; 3];
            for &(j, b) in rows {
                for &(i, a) in columns {
                    let Rgb(pixel) = image.pixel(i, j);
                    (0..3).for_each(|c| sum[c] += a * b * f64::from(pixel[c]));
                }
            }
            copy.set(x as i64, y as i64, Rgb(sum.map(|value| value.round() as u8)));
        }
    }
    copy
}

/// For each of `to` equal parts of a row of `from` pixels the pixels in it, with their shares, which sum to one.
fn shares(from: usize, to: usize) -> Vec<Vec<(usize, f64)>> {
    let length = from as f64 / to as f64;
    let part = |k: usize| {
        let (start, end) = (k as f64 * length, (k + 1) as f64 * length);
        let covered = |i: usize| ((i + 1) as f64).min(end) - (i as f64).max(start);
        let last = (end.ceil() as usize).min(from);
        (start as usize..last).map(|i| (i, covered(i) / length)).filter(|(_, share)| *share > 0.0).collect()
    };
    (0..to).map(part).collect()
}

fn few_colours(image: &Image, description: &str) -> Result<Vec<u8>, png::EncodingError> {
    let palette = Palette::of(std::slice::from_ref(image), COLOURS);
    let side = |pixels: usize| u32::try_from(pixels).unwrap_or(u32::MAX);
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, side(image.size().width), side(image.size().height));
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette.bytes());
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    encoder.add_itxt_chunk(DESCRIPTION.to_owned(), description.to_owned())?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&palette.indices(image))?;
    writer.finish()?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cover_a_row_once() {
        for (from, to) in [(1, 1), (800, 320), (390, 225), (7, 7), (7, 3)] {
            let shares = shares(from, to);
            assert_eq!(shares.len(), to);
            let mut covered = vec![0.0; from];
            for part in &shares {
                assert!((part.iter().map(|(_, share)| share).sum::<f64>() - 1.0).abs() < 1e-12);
                part.iter().for_each(|(i, share)| covered[*i] += share * from as f64 / to as f64);
            }
            assert!(covered.iter().all(|pixel: &f64| (pixel - 1.0).abs() < 1e-12), "{from} to {to}");
        }
    }

    #[test]
    fn a_copy_of_a_picture_and_of_a_film_keeps_shape_and_colours() {
        let folder = std::env::temp_dir().join(format!("thumbnail-{}", std::process::id()));
        let mut image = Image::filled(Size { width: 64, height: 32 }, Rgb([250, 250, 250]));
        (0..32).for_each(|y| (0..32).for_each(|x| image.set(x, y, Rgb([200, 30, 20]))));
        let mut film = super::super::Film::new(0.1);
        film.push(Image::filled(image.size(), Rgb([0; 3]))).expect("the first frame");
        film.push(image.clone()).expect("a frame of the same size");
        let (still, moving) = (folder.join("a.png"), folder.join("a.gif"));
        image.save_png(&still).expect("a picture");
        film.save_gif(&moving).expect("a film");
        assert_eq!(description(&still), None);
        for path in [still, moving] {
            let copy = thumbnail(&path, Size { width: 16, height: 16 }, "h = 10⁻³ s").expect("a small copy");
            let small = folder.join("small.png");
            std::fs::write(&small, copy).expect("a file");
            assert_eq!(description(&small).as_deref(), Some("h = 10⁻³ s"));
            let mut decoder =
                png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&small).expect("it")));
            decoder.set_transformations(png::Transformations::EXPAND);
            let mut reader = decoder.read_info().expect("a header");
            let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
            let info = reader.next_frame(&mut bytes).expect("pixels");
            assert_eq!((info.width, info.height), (16, 8));
            assert!(bytes[0] > 190 && bytes[1] < 40, "{:?}", &bytes[..3]);
            assert!(bytes[3 * 15 + 1] > 240, "{:?}", &bytes[45..48]);
        }
        std::fs::remove_dir_all(folder).expect("the folder");
    }
}
