//! A scene pays for what it names, and for nothing else: which terms a run had, what contact asked for, and how many blocks the
//! Hessian had, as solvers report them.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Two soft cubes, one above the other, half a millimetre or ten apart, that fall freely for three steps.
const CUBES: &str = r#"
materials = [{ name = "rubber", density_kg_m3 = 1000, law = { stable-neo-hookean = { young_modulus_pa = 1e5, poisson_ratio = 0.4 } } }]
loads = [{ gravity = { acceleration_m_s2 = [0, 0, -9.81] } }]

[[meshes]]
name = "lower"
material = "rubber"
source = { box = { size_m = [0.1, 0.1, 0.1], cells = [2, 3, 1] } }

[[meshes]]
name = "upper"
material = "rubber"
source = { box = { size_m = [0.1, 0.1, 0.1], cells = [2, 3, 1] } }
translation_m = [0.01, 0.02, HEIGHT]

[integration.backward-euler]
step_s = 1e-3
end_s = 3e-3

[solver]
linear = "cholesky"
tolerance_m = 1e-8
max_iterations = 50

[output]
frame_every = 3
formats = ["ply"]
"#;

const CONTACT: &str = "[contact]\nactivation_distance_m = 1e-3\npair_force_n = 1\n";
const FRICTION: &str = "friction = { coefficient = 0.3, stick_velocity_m_s = 1e-3, lag_iterations = 2 }\n";

/// Points, edges, diagonals of faces and of cells of both boxes: the pairs of points that a tetrahedron has in common, each box of a grid
/// being cut into six along its diagonal.
fn elastic_blocks() -> u64 {
    let [x, y, z] = [2, 3, 1];
    let points = (x + 1) * (y + 1) * (z + 1);
    let edges = x * (y + 1) * (z + 1) + (x + 1) * y * (z + 1) + (x + 1) * (y + 1) * z;
    let faces = (x + 1) * y * z + x * (y + 1) * z + x * y * (z + 1);
    2 * (points + edges + faces + x * y * z)
}

/// What a run of a scene left.
struct Run {
    _folder: tempfile::TempDir,
    out: PathBuf,
}

impl Run {
    fn new(scene: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (file, out) = (folder.path().join("cubes.toml"), folder.path().join("out"));
        std::fs::write(&file, scene).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_validation"));
        let output = command.arg("run").arg(&file).arg("--out").arg(&out).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        Self { _folder: folder, out }
    }

    /// The names of the terms that were minimised, from the reports of the stepper.
    fn terms(&self) -> Vec<String> {
        let summary = read(&self.out.join("summary.txt"));
        let line = summary.lines().find_map(|line| line.strip_prefix("terms ")).unwrap();
        let name = |term: &str| term.trim().rsplitn(3, ' ').nth(2).unwrap().to_owned();
        line.split(',').map(name).collect()
    }

    /// A column of `diagnostics.csv`.
    fn counts(&self, name: &str) -> Vec<u64> {
        let table = read(&self.out.join("diagnostics.csv"));
        let mut lines = table.lines().map(|line| line.split(','));
        let at = lines.next().unwrap().position(|head| head == name).unwrap();
        lines.map(|mut row| row.nth(at).unwrap().parse().unwrap()).collect()
    }
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn cubes(gap: f64, contact: &str) -> Run {
    // Tables of the root come before all others.
    Run::new(&(CUBES.replace("HEIGHT", &format!("{}", 0.1 + gap)) + contact))
}

const ELASTIC: [&str; 4] = ["inertia", "elasticity of lower", "elasticity of upper", "loads"];

#[test]
fn without_contact_nothing_is_searched_and_no_block_is_beyond_the_elastic_ones() {
    // So close that contact would act, were it named.
    let run = cubes(5e-4, "");
    assert_eq!(run.terms(), ELASTIC);
    assert_eq!(run.counts("contact_searches"), [0; 3]);
    assert_eq!(run.counts("detection_queries"), [0; 3]);
    assert_eq!(run.counts("hessian_blocks"), [elastic_blocks(); 3]);
    assert_eq!(run.counts("lag_iterations"), [1; 3]);
}

#[test]
fn contact_costs_no_block_where_nothing_is_near() {
    let run = cubes(0.5, CONTACT);
    assert_eq!(run.terms()[4..], ["contact"]);
    assert!(run.counts("contact_searches")[0] > 0, "contact must look before it knows");
    assert_eq!(run.counts("contacts"), [0; 3]);
    assert_eq!(run.counts("hessian_blocks"), [elastic_blocks(); 3]);
}

#[test]
fn contact_without_friction_has_no_friction_and_only_its_own_blocks() {
    let run = cubes(5e-4, CONTACT);
    assert_eq!(run.terms(), [&ELASTIC[..], &["contact"]].concat());
    assert!(run.counts("contacts")[0] > 0);
    assert!(run.counts("detection_queries")[0] > 0);
    assert!(run.counts("hessian_blocks")[0] > elastic_blocks());
    // The loop of lagged friction is passed once, by all steps.
    assert_eq!(run.counts("lag_iterations"), [1; 3]);
}

#[test]
fn friction_is_a_term_of_its_own_name_where_a_scene_names_it() {
    let run = cubes(5e-4, &format!("{CONTACT}{FRICTION}"));
    assert_eq!(run.terms(), [&ELASTIC[..], &["contact with friction"]].concat());
    assert!(run.counts("lag_iterations").into_iter().any(|lags| lags == 2));
}
