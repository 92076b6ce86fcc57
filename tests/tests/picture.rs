//! The renderer against geometry: areas, order of depth, colours, frames that read back.

use std::path::{Path, PathBuf};
use std::time::Instant;
use validation::picture::*;

const SIZE: Size = Size { width: 320, height: 240 };
const PAPER: Rgb = Rgb([255, 255, 255]);

fn orthographic(towards: [f64; 3]) -> Camera {
    Camera { towards, lens: Lens::Orthographic, ..Camera::default() }
}

/// A sphere of radius 1 by subdividing longitude and latitude.
fn sphere(rings: usize) -> Scene3 {
    let around = 2 * rings;
    let angle = std::f64::consts::PI / rings as f64;
    let mut scene = Scene3 { shading: Shading::Smooth, ..Scene3::default() };
    for i in 0..=rings {
        for j in 0..around {
            let (theta, phi) = (angle * i as f64, angle * j as f64);
            scene.positions.push([theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]);
            let (a, b) = (i * around + j, i * around + (j + 1) % around);
            if i < rings {
                scene.triangles.push([a, b, a + around]);
                scene.triangles.push([b, b + around, a + around]);
            }
        }
    }
    scene
}

fn covered(image: &Image) -> usize {
    image.pixels().iter().filter(|pixel| **pixel != PAPER).count()
}

fn luminance(Rgb(c): Rgb) -> f64 {
    let linear = |c: u8| {
        let c = f64::from(c) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    };
    0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2])
}

/// The framed height is 84 % of the picture, so the sphere's radius is 0.42 heights.
#[test]
fn a_sphere_covers_the_area_of_a_disc() {
    let size = Size { width: 800, height: 600 };
    let radius = 0.42 * 600.0f64;
    let disc = std::f64::consts::PI * radius * radius;
    for towards in [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0]] {
        let image = render(&sphere(128), &orthographic(towards), size);
        // Half the pixels of the rim count too much: take it by its length.
        let area = covered(&image) as f64 - 0.5 * 2.0 * std::f64::consts::PI * radius;
        assert!((area / disc - 1.0).abs() < 0.01, "{towards:?}: {area} for {disc}");
    }
    let frame = Bounds { low: [-1.0; 3], high: [1.0; 3] };
    let point = Scene3 {
        positions: vec![[0.0; 3]],
        points: vec![0],
        point_size: PointSize::World(1.0),
        ..Scene3::default()
    };
    let image = render(&point, &orthographic([0.0, -1.0, 0.0]).framing(frame), size);
    let area = covered(&image) as f64 - 0.5 * 2.0 * std::f64::consts::PI * radius;
    assert!((area / disc - 1.0).abs() < 0.01, "point: {area} for {disc}");
}

fn square(y: f64) -> [[f64; 3]; 4] {
    [[0.0, y, 0.0], [1.0, y, 0.0], [1.0, y, 1.0], [0.0, y, 1.0]]
}

/// Two squares one behind the other: whatever order they come in, whatever lens, the near one is seen.
#[test]
fn nearer_things_hide_farther_ones() {
    let field = Field {
        name: "which".into(),
        unit: "1".into(),
        values: FieldValues::Triangles(vec![0.0, 0.0, 1.0, 1.0]),
        range: Some((0.0, 1.0)),
        map: ColourMap::Magnitude,
    };
    let near_then_far = Scene3 {
        positions: [square(0.0), square(1.0)].concat(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
        field: Some(field),
        ..Scene3::default()
    };
    let mut far_then_near = near_then_far.clone();
    far_then_near.triangles.rotate_left(2);
    far_then_near.field.as_mut().unwrap().values = FieldValues::Triangles(vec![1.0, 1.0, 0.0, 0.0]);
    for lens in [Lens::Orthographic, Lens::Perspective(40.0)] {
        for (towards, near) in [([0.0, -1.0, 0.0], 0.0), ([0.0, 1.0, 0.0], 1.0)] {
            let camera = Camera { towards, lens, ..Camera::default() };
            let image = render(&near_then_far, &camera, SIZE);
            assert_eq!(image, render(&far_then_near, &camera, SIZE));
            let Rgb(seen) = image.pixel(110, 120);
            let Rgb(full) = ColourMap::Magnitude.colour(near);
            // Light scales all channels alike: the direction of the colour tells which square it is.
            let dot = |a: [u8; 3], b: [u8; 3]| (0..3).map(|c| f64::from(a[c]) * f64::from(b[c])).sum::<f64>();
            let cosine = dot(seen, full) / (dot(seen, seen) * dot(full, full)).sqrt();
            assert!(cosine > 0.999, "{lens:?} {near}: {seen:?} {full:?}");
        }
    }
}

/// A plane seen aslant in perspective: the field at a pixel is that of the point seen there, not the linear blend in the
/// picture. The square's middle is where its diagonals cross.
#[test]
fn fields_are_right_in_perspective() {
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 8.0, 0.0], [0.0, 8.0, 0.0], [0.5, 4.0, 0.0]];
    let values = positions.iter().map(|p| p[1]).collect();
    let field = Field {
        name: String::new(),
        unit: String::new(),
        values: FieldValues::Positions(values),
        range: Some((0.0, 8.0)),
        map: ColourMap::Magnitude,
    };
    let coarse =
        Scene3 { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], field: Some(field), ..Scene3::default() };
    let mut fine = coarse.clone();
    fine.triangles = vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
    let camera = Camera { towards: [0.0, -1.0, 0.25], lens: Lens::Perspective(90.0), ..Camera::default() };
    let (a, b) = (render(&coarse, &camera, SIZE), render(&fine, &camera, SIZE));
    let worst =
        a.pixels().iter().zip(b.pixels()).flat_map(|(Rgb(a), Rgb(b))| (0..3).map(|c| a[c].abs_diff(b[c])));
    assert!(worst.max().unwrap() <= 3, "another triangulation of the same plane is the same picture");
}

#[test]
fn magnitude_colours_grow_lighter_and_signed_ones_fade_to_the_middle() {
    let shades: Vec<f64> =
        (0..256).map(|i| luminance(ColourMap::Magnitude.colour(f64::from(i) / 255.0))).collect();
    assert!(shades.is_sorted());
    assert!(shades[0] < 0.03 && shades[255] > 0.7, "{} to {}", shades[0], shades[255]);
    // Cube root of luminance is lightness: its steps are even to 60 %, against a factor of 20 for a rainbow map.
    let lightness: Vec<f64> = shades.iter().step_by(15).map(|y| 116.0 * y.cbrt() - 16.0).collect();
    let mean = (lightness[17] - lightness[0]) / 17.0;
    assert!(lightness.windows(2).all(|pair| ((pair[1] - pair[0]) / mean - 1.0).abs() < 0.6), "{lightness:?}");
    let signed: Vec<f64> =
        (0..256).map(|i| luminance(ColourMap::Signed.colour(f64::from(i) / 255.0))).collect();
    assert!(signed[..128].is_sorted() && signed[128..].iter().rev().is_sorted() && signed[127] > 0.85);
    for map in [ColourMap::Magnitude, ColourMap::Signed] {
        assert_eq!(map.colour(-3.0), map.colour(0.0));
        assert_eq!(map.colour(f64::INFINITY), map.colour(1.0));
    }
}

fn hard_scenes() -> Vec<Scene3> {
    let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]];
    let full = |positions: Vec<[f64; 3]>, values: Vec<f64>| Scene3 {
        positions,
        triangles: vec![[0, 1, 2], [1, 2, 3], [0, 0, 0], [0, 1, 99]],
        points: vec![0, 3, 77],
        point_size: PointSize::World(0.1),
        segments: vec![[0, 3], [1, 1], [2, 88]],
        field: Some(Field {
            name: "σ <von Mises> \u{1f600} and a name that is much too long for any colour bar".into(),
            unit: "Pa".into(),
            values: FieldValues::Positions(values),
            range: None,
            map: ColourMap::Signed,
        }),
        shading: Shading::Smooth,
        decorations: vec![Decoration::Ground(0.0), Decoration::Axes, Decoration::Edges],
        caption: "t = 0.25 s\nsecond line".into(),
    };
    let scaled = |s: f64| corners.iter().map(|p| p.map(|c| c * s)).collect::<Vec<_>>();
    let moved = |d: f64| corners.iter().map(|p| p.map(|c| c + d)).collect::<Vec<_>>();
    let mut broken = corners.clone();
    broken[1] = [f64::NAN, 0.0, 0.0];
    broken[2] = [0.0, f64::INFINITY, 0.0];
    vec![
        Scene3::default(),
        full(vec![], vec![]),
        full(vec![[1.0, 2.0, 3.0]; 4], vec![5.0; 4]),
        full(broken, vec![1.0, f64::NAN, 3.0, f64::NEG_INFINITY]),
        full(vec![[f64::NAN; 3]; 4], vec![f64::NAN; 4]),
        full(scaled(1e-200), vec![-f64::MAX, f64::MAX, 0.0, 1.0]),
        full(scaled(1e-12), vec![1e-300, 2e-300, 0.0, 1e-320]),
        full(scaled(1e140), vec![1e12, 1e12 + 1.0, 1e12, 1e12]),
        full(scaled(f64::MAX), vec![1.0; 4]),
        full(moved(1e9), vec![0.0, 1.0, 2.0, 3.0]),
        full(corners, vec![]),
    ]
}

#[test]
fn every_scene_has_a_defined_picture() {
    let mut cameras =
        vec![orthographic([0.0, 0.0, 1.0]), orthographic([0.0; 3]), orthographic([f64::NAN; 3])];
    cameras.extend(
        [f64::NAN, 0.0, 180.0].map(|angle| Camera { lens: Lens::Perspective(angle), ..Camera::default() }),
    );
    let within = Bounds { low: [0.2; 3], high: [0.21; 3] };
    cameras.push(Camera::default().framing(within));
    for (number, scene) in hard_scenes().iter().enumerate() {
        for camera in &cameras {
            for size in [SIZE, Size { width: 0, height: 0 }, Size { width: 3, height: 500 }] {
                let image = render(scene, camera, size);
                assert_eq!(image.pixels().len(), size.width.max(1) * size.height.max(1));
            }
        }
        let image = render(scene, &Camera::default(), SIZE);
        assert_eq!(image, render(scene, &Camera::default(), SIZE), "the same bytes again: scene {number}");
    }
    assert_eq!(
        covered(&render(&Scene3::default(), &Camera::default(), SIZE)),
        0,
        "nothing is an empty picture"
    );
}

/// A part with a position that is not a number is left out; the rest is drawn as if it were not there.
#[test]
fn broken_parts_do_not_spoil_the_rest() {
    let good = sphere(12);
    let mut spoilt = good.clone();
    spoilt.positions.push([f64::NAN, 0.0, 0.0]);
    let last = spoilt.positions.len() - 1;
    spoilt.triangles.push([0, 1, last]);
    spoilt.points.push(last);
    spoilt.segments.push([0, last]);
    assert_eq!(render(&good, &Camera::default(), SIZE), render(&spoilt, &Camera::default(), SIZE));
}

#[test]
fn png_reads_back_to_the_same_pixels() {
    let image = render(&sphere(16), &Camera::default(), SIZE);
    let path = fresh_folder("png").join("deep/er/sphere.png");
    image.save_png(&path).unwrap();
    let decoder = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.width, info.height), (320, 240));
    let back: Vec<Rgb> = bytes.chunks_exact(3).map(|c| Rgb([c[0], c[1], c[2]])).collect();
    assert_eq!(back, image.pixels());
}

/// Decoded frame by frame onto a canvas, the film shows each image to within the palette's coarseness, for as long as stated.
#[test]
fn gif_shows_the_same_frames_for_the_stated_time() {
    let frame = Bounds { low: [-1.0; 3], high: [1.0; 3] };
    let mut film = Film::new(1.0 / 30.0);
    for k in 0..12 {
        let mut scene = sphere(24);
        let values = scene.positions.iter().map(|p| (3.0 * p[2] + f64::from(k)).sin()).collect();
        scene.positions.iter_mut().for_each(|p| p[2] *= 1.0 - 0.04 * f64::from(k));
        scene.field = Some(Field {
            name: "wave".into(),
            unit: "m".into(),
            values: FieldValues::Positions(values),
            range: Some((-1.0, 1.0)),
            map: ColourMap::Magnitude,
        });
        film.push(render(&scene, &Camera::default().framing(frame), SIZE)).unwrap();
    }
    // A frame like the one before keeps its time.
    film.push(film.frames()[11].clone()).unwrap();
    let path = fresh_folder("gif").join("wave.gif");
    film.save_gif(&path).unwrap();
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(std::fs::File::open(&path).unwrap()).unwrap();
    assert_eq!((decoder.width(), decoder.height()), (320, 240));
    assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
    let mut canvas = vec![[0u8; 3]; 320 * 240];
    let (mut shown, mut hundredths) = (0, 0);
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        hundredths += u32::from(frame.delay);
        for (at, pixel) in frame.buffer.chunks_exact(4).enumerate() {
            let (x, y) = (at % usize::from(frame.width), at / usize::from(frame.width));
            if pixel[3] > 0 {
                canvas[(y + usize::from(frame.top)) * 320 + x + usize::from(frame.left)] =
                    [pixel[0], pixel[1], pixel[2]];
            }
        }
        let errors = canvas.iter().zip(film.frames()[shown].pixels());
        let errors: Vec<u8> =
            errors.map(|(a, Rgb(b))| (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap()).collect();
        let mean = errors.iter().map(|&e| f64::from(e)).sum::<f64>() / errors.len() as f64;
        let worst = errors.into_iter().max().unwrap();
        assert!(mean < 1.5 && worst < 48, "frame {shown}: mean {mean}, worst {worst}");
        shown += 1;
    }
    assert_eq!(shown, 13);
    assert_eq!(hundredths, 43, "13 frames of 1/30 s");
    let bytes = std::fs::metadata(&path).unwrap().len();
    println!("13 frames of 320 × 240: {bytes} bytes");
    assert!(bytes < 13 * 320 * 240 / 2, "{bytes}");
}

#[test]
fn films_refuse_what_they_cannot_hold() {
    let path = fresh_folder("film").join("none.gif");
    assert!(matches!(Film::new(0.1).save_gif(&path), Err(FilmError::Empty)));
    let mut film = Film::new(f64::NAN);
    film.push(Image::filled(SIZE, PAPER)).unwrap();
    let other = Image::filled(Size { width: 1, height: 1 }, PAPER);
    assert!(matches!(film.push(other), Err(FilmError::SizeDiffers { index: 1, .. })));
    assert_eq!(film.frames().len(), 1);
    film.save_gif(&path).unwrap();
    let mut large = Film::new(0.1);
    large.push(Image::filled(Size { width: 70_000, height: 1 }, PAPER)).unwrap();
    assert!(matches!(large.save_gif(&path), Err(FilmError::TooLarge(_))));
    let folder = path.parent().unwrap().to_owned();
    assert!(matches!(film.save_gif(&folder), Err(FilmError::Write(_))), "a folder is not a file");
}

/// Four times as many triangles at 800 × 600 take four times as long, up to 100 000 with a field: work that grew with their square would take sixteen times. Ratios of one run,
/// since times depend on the machine; they are printed.
#[test]
fn time_grows_with_the_number_of_triangles() {
    let surface = |rings: usize| {
        let mut scene = sphere(rings);
        let values = scene.positions.iter().map(|p| (9.0 * p[0]).sin() * p[2]).collect();
        scene.field = Some(Field {
            name: "wave".into(),
            unit: "m".into(),
            values: FieldValues::Positions(values),
            range: None,
            map: ColourMap::Magnitude,
        });
        scene
    };
    let scenes = [surface(80), surface(160)];
    assert!(scenes[1].triangles.len() > 100_000 && scenes[1].triangles.len() < 5 * scenes[0].triangles.len());
    let size = Size { width: 800, height: 600 };
    let mut best = [f64::INFINITY; 2];
    for _ in 0..5 {
        for (scene, best) in scenes.iter().zip(&mut best) {
            let start = Instant::now();
            let image = render(scene, &Camera::default(), size);
            *best = best.min((start.elapsed().as_secs_f64(), covered(&image)).0);
        }
    }
    println!("{} triangles at 800 × 600: {:.0} ms", scenes[1].triangles.len(), 1e3 * best[1]);
    assert!(best[1] < 8.0 * best[0], "{best:?} s");
}

/// What there is to look at: everything at once, kept in the build folder.
#[test]
fn a_picture_with_everything_is_written() {
    let mut scene = sphere(40);
    let values = scene.positions.iter().map(|p| 2.5e5 * (4.0 * p[0]).sin() * p[2]).collect();
    scene.positions.extend([[-1.6, -0.5, -1.0], [1.6, -0.5, 1.0], [1.5, 0.5, -0.8]]);
    let n = scene.positions.len();
    scene.segments.push([n - 3, n - 2]);
    scene.points.extend([n - 3, n - 2, n - 1]);
    scene.point_size = PointSize::World(0.12);
    scene.decorations = vec![Decoration::Ground(-1.0), Decoration::Axes];
    scene.caption = "Sphere with a made-up stress\nt = 0.25 s".into();
    scene.field = Some(Field {
        name: "stress".into(),
        unit: "Pa".into(),
        values: FieldValues::Positions(values),
        range: None,
        map: ColourMap::Magnitude,
    });
    let folder = fresh_folder("look");
    let size = Size { width: 800, height: 600 };
    render(&scene, &Camera::default(), size).save_png(&folder.join("smooth.png")).unwrap();
    let mut flat = sphere(12);
    let mids = flat.triangles.iter().map(|t| flat.positions[t[0]][2]).collect();
    flat.shading = Shading::Flat;
    flat.decorations = vec![Decoration::Edges, Decoration::Axes];
    flat.field = Some(Field {
        name: "height".into(),
        unit: "m".into(),
        values: FieldValues::Triangles(mids),
        range: Some((-1.0, 1.0)),
        map: ColourMap::Signed,
    });
    render(&flat, &orthographic([1.0, -1.0, 0.6]), size).save_png(&folder.join("flat.png")).unwrap();
}

fn fresh_folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("picture").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder for the test");
    folder
}
