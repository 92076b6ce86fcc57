//! `run` of physical scenes from outside: what it leaves in its folder, against closed forms, and what it refuses.

#[path = "run/killed.rs"]
mod killed;
#[path = "run/splats.rs"]
mod splats;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A neo-Hookean bar with Poisson's ratio zero, pulled by a traction: P = E/2 (λ − 1/λ), so E = 1 MPa and λ = 3/2
/// belong to P = 5/12 MPa (stretch 1.5 of `crates/mechanics-core/tests/fixtures/laws_uniaxial.json`).
const BAR: &str = r#"[[meshes]]
name = "bar"
material = "rubber"
source = { box = { size_m = [1.0, 0.2, 0.3], cells = [5, 2, 3] } }

[[materials]]
name = "rubber"
density_kg_m3 = 1000
law = { neo-hookean = { young_modulus_pa = 1e6, poisson_ratio = 0 } }

[[boundary]]
mesh = "bar"
select = { plane = { point_m = [0, 0, 0], normal = [-1, 0, 0], within_m = 1e-9 } }
motion = { fixed = { axes = ["x", "y", "z"] } }

[[loads]]
traction = { mesh = "bar", select = { box = { min_m = [1, 0, 0], max_m = [1, 1, 1] } }, traction_pa = [416666.6666666667, 0, 0] }

[integration.static]
load_steps = 4

[solver]
linear = "cholesky"
tolerance_m = 1e-10
max_iterations = 50

[output]
frame_every = 2
formats = ["vtu", "png", "gif"]
"#;

struct Answer {
    code: Option<i32>,
    err: String,
}

/// Writes `text` as a scene into `folder` and runs it there into `folder/out`.
fn run(folder: &Path, text: &str, arguments: &[&str]) -> Answer {
    let scene = folder.join("bar.toml");
    std::fs::write(&scene, text).expect("the folder is ours");
    let mut command = Command::new(env!("CARGO_BIN_EXE_validation"));
    command.arg("run").arg(&scene).arg("--out").arg(folder.join("out")).args(arguments);
    let output = command.output().expect("the program starts");
    Answer { code: output.status.code(), err: String::from_utf8_lossy(&output.stderr).into_owned() }
}

fn succeed(folder: &Path, text: &str, arguments: &[&str]) -> PathBuf {
    let answer = run(folder, text, arguments);
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    folder.join("out")
}

fn temporary() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The rows of `diagnostics.csv` by column name.
fn column(out: &Path, name: &str) -> Vec<f64> {
    let table = read(&out.join("diagnostics.csv"));
    let mut lines = table.lines().map(|line| line.split(','));
    let at = lines.next().expect("a head").position(|head| head == name).expect("the column is there");
    lines.map(|mut row| row.nth(at).expect("a full row").parse().expect("a number")).collect()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder");
    let mut names: Vec<String> =
        entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_pulled_bar_stretches_as_the_closed_form_says_in_every_load_step() {
    let folder = temporary();
    let out = succeed(folder.path(), BAR, &[]);
    let stretch = |load: f64| {
        let p = load * 5.0 / 12.0;
        p + (p * p + 1.0).sqrt()
    };
    let far = column(&out, "largest_displacement_m");
    assert_eq!(column(&out, "load_step"), [1.0, 2.0, 3.0, 4.0]);
    for (load, far) in [0.25, 0.5, 0.75, 1.0].into_iter().zip(far) {
        assert!((far - (stretch(load) - 1.0)).abs() < 1e-9, "{load}: {far}");
    }
    for (load, det) in [0.25, 0.5, 0.75, 1.0].into_iter().zip(column(&out, "smallest_det_f")) {
        assert!((det - stretch(load)).abs() < 1e-8, "{load}: {det}");
    }
    // W V − P A (λ − 1) L with the fixture's W / E at stretch 1.5.
    let energy = (0.109_767_445_945_917_8 - 0.5 * 5.0 / 12.0) * 1e6 * 0.06;
    assert!((column(&out, "energy_j")[3] - energy).abs() < 1e-7 * energy.abs());
    assert!(column(&out, "residual_n").into_iter().all(|residual| residual < 1e-3));
    assert_eq!(names(&out), ["diagnostics.csv", "film.gif", "frames", "frames.pvd", "summary.txt"]);
    let frames = ["00000", "00002", "00004"].map(|number| format!("frame_{number}"));
    let wanted: Vec<String> = frames.iter().flat_map(|f| [format!("{f}.png"), format!("{f}.vtu")]).collect();
    assert_eq!(names(&out.join("frames")), wanted);
    let series = read(&out.join("frames.pvd"));
    assert!(frames.iter().all(|frame| series.contains(&format!("file=\"frames/{frame}.vtu\""))), "{series}");
    assert_eq!(names(folder.path()), ["bar.toml", "out"], "nothing half-written is left");
}

#[test]
fn a_bar_pulled_by_its_end_is_stretched_affinely_whatever_is_inside() {
    let folder = temporary();
    // The end is moved instead of loaded; a second run replaces the first.
    let moved = BAR.find("[[loads]]").expect("loads")..BAR.find("[integration").expect("integration");
    let mut text = BAR.to_owned();
    text.replace_range(
        moved,
        "[[boundary]]\nmesh = \"bar\"\nselect = { box = { min_m = [1, 0, 0], max_m = [1, 1, 1] } }\n\
         motion = { prescribed = { displacement_m = [-0.4, 0, 0] } }\n\n",
    );
    succeed(folder.path(), BAR, &[]);
    let out = succeed(folder.path(), &text, &["--export", "obj,ply", "--steps", "3"]);
    let points: Vec<[f64; 3]> = read(&out.join("frames/frame_00003.obj"))
        .lines()
        .filter_map(|line| line.strip_prefix("v "))
        .map(|line| {
            let mut numbers = line.split_whitespace().map(|number| number.parse().expect("a number"));
            std::array::from_fn(|_| numbers.next().expect("three coordinates"))
        })
        .collect();
    // Each coordinate is one of its grid's: cells of 0.2 shortened by 3/4 of 0.4, others as they were.
    assert_eq!(points.len(), 6 * 3 * 4 - 4 * 2);
    for point in points {
        for (x, cell) in point.into_iter().zip([0.2 * 0.7, 0.1, 0.1]) {
            assert!((x / cell - (x / cell).round()).abs() < 1e-8, "{point:?}");
        }
    }
    assert_eq!(names(&out), ["diagnostics.csv", "frames", "summary.txt"]);
}

#[test]
fn a_resumed_run_goes_on_with_the_same_bits() {
    let folder = temporary();
    let whole = column(&succeed(folder.path(), BAR, &["--checkpoint-every", "2"]), "energy_j");
    let checkpoint = folder.path().join("out.checkpoints/step_00002.checkpoint");
    let path = checkpoint.to_string_lossy().into_owned();
    let resumed = succeed(folder.path(), BAR, &["--resume", &path]);
    assert_eq!(column(&resumed, "load_step"), [3.0, 4.0]);
    assert_eq!(column(&resumed, "energy_j"), whole[2..]);
    let other = run(folder.path(), &BAR.replace("416666", "316666"), &["--resume", &path]);
    assert!(other.code == Some(2) && other.err.contains("step_00002.checkpoint"), "{}", other.err);
    assert_eq!(column(&resumed, "load_step"), [3.0, 4.0], "the earlier result is untouched");
}

#[test]
fn what_cannot_be_run_exits_2_with_file_and_line() {
    let source = "box = { size_m = [1.0, 0.2, 0.3], cells = [5, 2, 3] }";
    for (good, bad, words) in [
        (source, "file = { path = \"none.msh\" }", "there is no file"),
        (source, "file = { path = \"bar.toml\" }", "read from MSH files only"),
        (source, "rod = { length_m = 1, cells = 3, radius_m = 0.1 }", "a solid needs tetrahedra"),
        ("material = \"rubber\"", "material = \"steel\"", "there is no material `steel`"),
        ("[\"x\", \"y\", \"z\"]", "[\"x\", \"z\"]", "along all axes only"),
        ("min_m = [1, 0, 0]", "min_m = [1, 0.5, 0]", "selects no point of `bar`"),
        ("min_m = [1, 0, 0], max_m = [1, 1, 1]", "min_m = [1, 0, 0], max_m = [1, 0, 0]", "no whole triangle"),
        ("fixed = { axes = [\"x\", \"y\", \"z\"] }", "moving = { velocity_m_s = [1, 0, 0] }", "no velocity"),
        (
            "[integration.static]\nload_steps = 4",
            "[integration.newmark]\nend_s = 2\nstep_s = 0.3",
            "no whole number of steps",
        ),
        (
            "[integration.static]",
            "[contact]\nactivation_distance_m = 1e-3\npair_force_n = 1\n\n[integration.static]",
            "an equilibrium with contact is not available",
        ),
    ] {
        let folder = temporary();
        let text = BAR.replace(good, bad);
        let answer = run(folder.path(), &text, &[]);
        let first = bad.lines().next().expect("a line");
        let line = text.lines().position(|line| line.contains(first)).expect("the text says so") + 1;
        assert_eq!(answer.code, Some(2), "{bad}: {}", answer.err);
        // A table's place is its head or its first key.
        let places = [line, line + 1].map(|line| format!("bar.toml:{line}:"));
        assert!(places.iter().any(|place| answer.err.contains(place)), "{bad}: {}", answer.err);
        assert!(answer.err.contains(words), "{bad}: {}", answer.err);
        assert_eq!(names(folder.path()), ["bar.toml"], "{bad}");
    }
}

#[test]
fn a_load_step_without_equilibrium_is_named_with_its_term_and_leaves_no_folder() {
    let folder = temporary();
    let answer = run(folder.path(), &BAR.replace("max_iterations = 50", "max_iterations = 1"), &[]);
    assert_eq!(answer.code, Some(2));
    for words in ["load step 1 of 4 (load factor 0.25", "not converged to 1e-10", "point"] {
        assert!(answer.err.contains(words), "{words}: {}", answer.err);
    }
    // The end is pushed through the bar: tetrahedra turn inside out before the first iteration.
    let crushed = BAR.replace(
        "[[loads]]",
        "[[boundary]]\nmesh = \"bar\"\nselect = { box = { min_m = [1, 0, 0], max_m = [1, 1, 1] } }\n\
         motion = { prescribed = { displacement_m = [-4, 0, 0] } }\n\n[[loads]]",
    );
    let answer = run(folder.path(), &crushed, &[]);
    assert_eq!(answer.code, Some(2));
    for words in ["load step 1 of 4", "elasticity of bar", "element"] {
        assert!(answer.err.contains(words), "{words}: {}", answer.err);
    }
    assert_eq!(names(folder.path()), ["bar.toml"]);
}

#[test]
fn a_folder_that_no_run_has_written_is_not_replaced() {
    let folder = temporary();
    let mine = folder.path().join("out/thesis.tex");
    std::fs::create_dir(folder.path().join("out")).expect("the folder is ours");
    std::fs::write(&mine, "years of work").expect("the folder is ours");
    let answer = run(folder.path(), BAR, &[]);
    assert!(answer.code == Some(2) && answer.err.contains("thesis.tex"), "{}", answer.err);
    assert_eq!(read(&mine), "years of work");
}

/// A stiff cube of 1 kg that is thrown.
const CUBE: &str = r#"[[meshes]]
name = "cube"
material = "rubber"
source = { box = { size_m = [0.1, 0.1, 0.1], cells = [2, 2, 2] } }
translation_m = [0, 0, 0.2]

[[materials]]
name = "rubber"
density_kg_m3 = 1000
law = { stable-neo-hookean = { young_modulus_pa = 1e6, poisson_ratio = 0.3 } }

[[initial]]
mesh = "cube"
velocity_m_s = [1, 0, 0]

[[loads]]
gravity = { acceleration_m_s2 = [0, 0, -10] }

[integration.newmark]
step_s = 0.01
end_s = 0.1

[solver]
linear = "cholesky"
tolerance_m = 1e-11
max_iterations = 100

[output]
frame_every = 5
formats = ["vtu", "png"]
"#;

/// The same with a floor at z = 0, friction and BDF2, for half a second.
fn on_a_floor() -> String {
    let contact = "[contact]\nactivation_distance_m = 2e-3\npair_force_n = 1.1111111\n\
        friction = { coefficient = 0.5, stick_velocity_m_s = 1e-3, lag_iterations = 3 }\n\
        half_spaces = [{ point_m = [0, 0, 0], normal = [0, 0, 2] }]\n\n[integration.bdf2]";
    let text = CUBE.replace("[integration.newmark]", contact).replace("end_s = 0.1", "end_s = 0.5");
    text.replace("tolerance_m = 1e-11", "tolerance_m = 1e-7")
}

#[test]
fn a_thrown_cube_falls_as_newmark_does() {
    let folder = temporary();
    let out = succeed(folder.path(), CUBE, &[]);
    let (mass, g, h) = (1.0, 10.0, 0.01);
    let time = column(&out, "time_s");
    assert_eq!(column(&out, "step"), (1..=10).map(f64::from).collect::<Vec<_>>());
    // Average acceleration is exact where the acceleration is constant.
    for (k, (&t, far)) in time.iter().zip(column(&out, "largest_displacement_m")).enumerate() {
        assert!((t - h * (k + 1) as f64).abs() < 1e-15);
        assert!((far - (t * t + (0.5 * g * t * t).powi(2)).sqrt()).abs() < 1e-9, "{t}: {far}");
    }
    let momentum = ["x", "y", "z"].map(|axis| column(&out, &format!("momentum_{axis}_kg_m_s")));
    for (k, &t) in time.iter().enumerate() {
        for (found, exact) in momentum.iter().zip([mass, 0.0, -mass * g * t]) {
            assert!((found[k] - exact).abs() < 1e-8, "{t}: {} {exact}", found[k]);
        }
    }
    let total =
        |k: usize| column(&out, "kinetic_j")[k] + column(&out, "load_j")[k] + column(&out, "elastic_j")[k];
    assert!((total(9) - total(0)).abs() < 1e-8, "{} {}", total(0), total(9));
    let series = read(&out.join("frames.pvd"));
    for (time, frame) in [("0", "00000"), ("0.05", "00005"), ("0.1", "00010")] {
        let at = series.find(&format!("frames/frame_{frame}.vtu")).expect("the frame is listed");
        let line = series[..at].rfind('<').map_or("", |start| &series[start..at]);
        let found: f64 = line.split('"').nth(1).expect("a time").parse().expect("a number");
        assert!((found - time.parse::<f64>().expect("a number")).abs() < 1e-12, "{line}");
    }
    assert_eq!(names(&out), ["diagnostics.csv", "frames", "frames.pvd", "summary.txt"]);
}

#[test]
fn a_spinning_cube_keeps_its_momenta() {
    let folder = temporary();
    let text = CUBE
        .replace("velocity_m_s = [1, 0, 0]", "angular_velocity_rad_s = [0, 0, 5]")
        .replace("[0, 0, -10]", "[0, 0, 0]");
    let out = succeed(folder.path(), &text, &[]);
    // A cube of tetrahedra with lumped mass: its moment of inertia is near m a²/6, and the same from step to step.
    let spin = column(&out, "angular_momentum_z_kg_m2_s");
    assert!(spin.iter().all(|l| (l / spin[0] - 1.0).abs() < 2e-3), "{spin:?}");
    assert!((1.0..1.6).contains(&(spin[0] / (5.0 / 600.0))), "{spin:?}");
    assert!(column(&out, "momentum_x_kg_m_s").iter().all(|p| p.abs() < 1e-9));
}

#[test]
fn a_cube_on_a_floor_slides_and_stops_as_coulomb_says() {
    let folder = temporary();
    // Let down from the distance it rests at, with a little air.
    let text = on_a_floor().replace("translation_m = [0, 0, 0.2]", "translation_m = [0, 0, 0.001]");
    let out = succeed(folder.path(), &text, &["--steps", "30"]);
    // v = v₀ − μ g t until it stops at 0.2 s, after v₀²/(2 μ g) = 0.1 m.
    let momentum = column(&out, "momentum_x_kg_m_s");
    let far = column(&out, "largest_displacement_m");
    println!("momentum {momentum:?}\nfar {far:?}");
    assert!((momentum[9] - 0.5).abs() < 0.05, "{momentum:?}");
    // Stopped, it rocks on its sole; the mean is at rest.
    let mean = momentum[20..].iter().sum::<f64>() / 10.0;
    assert!(mean.abs() < 5e-3, "{momentum:?}");
    assert!((far[29] - 0.1).abs() < 0.01, "{far:?}");
    assert!(column(&out, "smallest_distance_m").iter().all(|distance| *distance > 0.0));
    let worn: f64 = column(&out, "friction_j").iter().sum();
    assert!((worn - 0.5).abs() < 0.05, "friction took {worn} J of ½ J");
}

#[test]
fn a_resumed_motion_goes_on_with_the_same_bits() {
    for text in [on_a_floor(), CUBE.to_owned(), CUBE.replace("newmark", "backward-euler")] {
        let folder = temporary();
        let text = text.replace("end_s = 0.5", "end_s = 0.3");
        let whole = succeed(folder.path(), &text, &["--checkpoint-every", "6"]);
        let columns = ["kinetic_j", "elastic_j", "contact_j", "momentum_x_kg_m_s", "newton_iterations"];
        let before = columns.map(|name| column(&whole, name));
        let checkpoint = folder.path().join("out.checkpoints/step_00006.checkpoint");
        let resumed = succeed(folder.path(), &text, &["--resume", &checkpoint.to_string_lossy()]);
        for (name, before) in columns.iter().zip(&before) {
            assert_eq!(column(&resumed, name), before[6..], "{name}");
        }
    }
}

#[test]
fn a_moving_clamp_draws_the_bar_along() {
    let folder = temporary();
    let moving = BAR
        .replace("fixed = { axes = [\"x\", \"y\", \"z\"] }", "moving = { velocity_m_s = [0, 2, 0] }")
        .replace(
            "[integration.static]\nload_steps = 4",
            "[integration.backward-euler]\nstep_s = 0.01\nend_s = 0.2",
        );
    let loads = moving.find("[[loads]]").expect("loads")..moving.find("[integration").expect("integration");
    let mut text = moving;
    text.replace_range(loads, "[[initial]]\nmesh = \"bar\"\nvelocity_m_s = [0, 2, 0]\n\n");
    let out = succeed(folder.path(), &text, &[]);
    // All of it moves alike: nothing is strained.
    for (t, far) in column(&out, "time_s").iter().zip(column(&out, "largest_displacement_m")) {
        assert!((far - 2.0 * t).abs() < 1e-8, "{t}: {far}");
    }
    assert!(column(&out, "elastic_j").iter().all(|energy| energy.abs() < 1e-9));
}

/// Says it past the test harness, which shows what a test prints only if it fails: the gate counts these lines.
fn skipped(reason: &str) {
    std::io::stderr().write_all(format!("\nSKIPPED ({reason})\n").as_bytes()).expect("standard error");
}

#[test]
fn meshio_reads_the_frames_of_a_motion() {
    let Some(python) = std::env::var_os("MESHIO_PYTHON") else {
        skipped("MESHIO_PYTHON does not name a Python with meshio");
        return;
    };
    let folder = temporary();
    let out = succeed(folder.path(), CUBE, &[]);
    let script = "import meshio, sys\n\
        m = meshio.read(sys.argv[1])\n\
        assert m.cells_dict['tetra'].shape == (48, 4)\n\
        assert abs(m.point_data['velocity'] - [1, 0, -1]).max() < 1e-8\n\
        assert abs(m.point_data['displacement'] - [0.1, 0, -0.05]).max() < 1e-8\n";
    let status = Command::new(python).args(["-c", script]).arg(out.join("frames/frame_00010.vtu")).status();
    assert!(status.expect("Python starts").success());
}

#[test]
fn meshio_reads_the_frames() {
    let Some(python) = std::env::var_os("MESHIO_PYTHON") else {
        skipped("MESHIO_PYTHON does not name a Python with meshio");
        return;
    };
    let folder = temporary();
    let out = succeed(folder.path(), BAR, &[]);
    // F = diag(3/2, 1, 1): det F = 3/2, and the Cauchy stress is P₁₁ alone.
    let script = "import meshio, numpy, sys\n\
        m = meshio.read(sys.argv[1])\n\
        u, rest = m.point_data['displacement'], m.points - m.point_data['displacement']\n\
        assert m.cells_dict['tetra'].shape == (180, 4)\n\
        assert abs(u - rest * [0.5, 0, 0]).max() < 1e-9\n\
        assert abs(m.cell_data['det F'][0] - 1.5).max() < 1e-8\n\
        assert abs(m.cell_data['von Mises stress'][0] / 416666.6666666667 - 1).max() < 1e-8\n";
    let status = Command::new(python).args(["-c", script]).arg(out.join("frames/frame_00004.vtu")).status();
    assert!(status.expect("Python starts").success());
}

#[test]
fn the_committed_guide_is_current() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut program = Command::new(env!("CARGO_BIN_EXE_validation"));
    let guide = program.arg("guide").output().expect("the program starts").stdout;
    let committed = package.join("../docs/VALIDATION.md");
    assert!(
        read(&committed) == String::from_utf8_lossy(&guide),
        "docs/VALIDATION.md is out of date: `cargo xtask guide > docs/VALIDATION.md` renews it"
    );
}
