//! What is timed.

use crate::peers::PeerScene;
use ipc_contact::broad_phase::{BroadPhase, Candidates};
use ipc_contact::ccd::{self, Pairs, Settings};
use ipc_contact::collision_mesh::{CollisionMesh, CollisionMeshBuilder, CollisionObject};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::contact_set::{ContactSet, Weighting};
use ipc_contact::intersection;
use ipc_contact::stiffness::{Scale, Stiffness};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::tensor::Vec3;
use std::hint::black_box;
use std::time::Instant;

/// A stage, its times, and what the other system calls it.
pub struct Stage {
    pub name: &'static str,
    /// Keys of its table whose times together do the same.
    pub peer_keys: &'static [&'static str],
    /// The largest ratio we want.
    pub bar: Option<f64>,
    pub milliseconds: Vec<f64>,
}

impl Stage {
    fn new(name: &'static str, peer_keys: &'static [&'static str], bar: Option<f64>) -> Self {
        Self { name, peer_keys, bar, milliseconds: Vec::new() }
    }

    /// The least and the median.
    pub fn summary(&self) -> [f64; 2] {
        let mut sorted = self.milliseconds.clone();
        sorted.sort_by(f64::total_cmp);
        [sorted[0], sorted[sorted.len() / 2]]
    }
}

/// A scene and everything that its stages work on.
pub struct Stages<'a> {
    pub scene: &'a PeerScene,
    pub mesh: CollisionMesh,
    pub contact: BarrierContact,
    /// Candidates at the start, and for the way to the end.
    pub near: Candidates,
    pub swept: Candidates,
    pub set: ContactSet,
    displacements: Vec<Vec3>,
    gradient: Vec<Vec3>,
    broad_phase: BroadPhase,
    assembly: Assembly,
}

impl<'a> Stages<'a> {
    pub fn new(scene: &'a PeerScene) -> Self {
        let mut builder = CollisionMeshBuilder::new(&scene.start);
        builder.add_object(CollisionObject::new(scene.triangles.clone()));
        let mesh = builder.build().expect("the scenes are valid");
        let options = ContactOptions::new(scene.activation_distance, Stiffness::fixed(Scale::Kappa(1.0)));
        let contact = BarrierContact::new(mesh.clone(), options).expect("the scenes are valid");
        let displacements = scene.start.iter().zip(&scene.end).map(|(x0, x1)| x1 - x0).collect();
        let mut stages = Self {
            scene,
            contact,
            near: Candidates::default(),
            swept: Candidates::default(),
            set: ContactSet::default(),
            displacements,
            gradient: Vec::new(),
            broad_phase: BroadPhase::new(&mesh),
            assembly: Assembly::new(&PointMap::identity(scene.start.len())),
            mesh,
        };
        stages.find_swept();
        stages.find_near();
        stages.set = stages.contact_set();
        stages
    }

    fn find_near(&mut self) {
        let (x, radius) = (&self.scene.start, 0.5 * self.scene.activation_distance);
        self.broad_phase.candidates(&self.mesh, x, x, radius, &mut self.near).expect("finite");
    }

    fn find_swept(&mut self) {
        let (x0, x1) = (&self.scene.start, &self.scene.end);
        self.broad_phase.candidates(&self.mesh, x0, x1, 0.0, &mut self.swept).expect("finite");
    }

    fn contact_set(&self) -> ContactSet {
        let squared = self.scene.activation_distance.powi(2);
        ContactSet::new(&self.mesh, &self.near, &self.scene.start, squared, Weighting::default())
    }

    /// The largest free part of the way from start to end.
    pub fn step_limit(&self) -> f64 {
        let pairs = Pairs {
            edges: self.mesh.edges(),
            triangles: self.mesh.triangles(),
            point_triangles: &self.swept.point_triangles,
            edge_edges: &self.swept.edge_edges,
            ..Pairs::default()
        };
        ccd::limit(&pairs, &self.scene.start, &self.displacements, 0.0, &Settings::default()).0
    }

    pub fn gradient(&mut self) -> &[Vec3] {
        self.gradient.resize(self.scene.start.len(), Vec3::zeros());
        self.gradient.fill(Vec3::zeros());
        self.contact.add_gradient(&self.scene.start, &mut self.gradient);
        &self.gradient
    }

    /// Assembles the Hessian, and answers the root of the sum of the squares of its entries.
    pub fn hessian_norm(&mut self, projection: Projection) -> f64 {
        self.assemble(projection);
        let matrix = self.assembly.matrix();
        let pattern = matrix.pattern();
        let column = |c: usize| {
            let squares = pattern.column(c).map(|slot| {
                // The lower triangle is stored.
                let count = if pattern.rows()[slot] as usize == c { 1.0 } else { 2.0 };
                count * matrix.blocks()[slot].norm_squared()
            });
            squares.sum::<f64>()
        };
        (0..pattern.columns()).map(column).sum::<f64>().sqrt()
    }

    fn assemble(&mut self, projection: Projection) {
        let mut assembler = self.assembly.begin(&PointMap::identity(self.scene.start.len()));
        self.contact.add_hessian(&self.scene.start, projection, &mut assembler);
        black_box(assembler.finish());
    }

    /// Runs all stages in turn, `repeats` times.
    pub fn measure(&mut self, repeats: usize) -> Vec<Stage> {
        const NARROW: &str = "NormalCollisions.build from candidates (narrow)";
        let mut stages = vec![
            Stage::new("candidates at rest, new tree", &["broad static (inflate dhat/2) LBVH"], None),
            Stage::new("candidates at rest, refitted", &["broad static (inflate dhat/2) LBVH"], None),
            Stage::new("contact set from candidates", &[NARROW], Some(0.35)),
            Stage::new("candidates (new tree) and set", &["NormalCollisions.build (incl"], Some(0.6)),
            Stage::new("energy", &["barrier value"], None),
            Stage::new("gradient", &["barrier gradient"], None),
            Stage::new("energy and gradient", &["barrier value", "barrier gradient"], Some(0.6)),
            Stage::new("Hessian, not projected, assembled", &["barrier hessian (no projection)"], None),
            Stage::new("Hessian, clamped, assembled", &["barrier hessian PSD clamp"], Some(0.1)),
            Stage::new("Hessian, absolute, assembled", &["barrier hessian PSD abs"], None),
            Stage::new("candidates for the way, refitted", &["broad CCD LBVH"], None),
            Stage::new("additive detection over its candidates", &["CCD narrow only Additive"], Some(0.5)),
            Stage::new("exact check at the start", &["has_intersections t0"], Some(1.0)),
            Stage::new("exact check at the end", &["has_intersections t1"], Some(1.0)),
        ];
        // Everything remembered is remembered before time counts.
        black_box(self.contact.value(&self.scene.start));
        self.assemble(Projection::Clamp);
        for _ in 0..repeats {
            for (k, stage) in stages.iter_mut().enumerate() {
                let start = Instant::now();
                self.run(k);
                stage.milliseconds.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
        stages
    }

    pub fn run(&mut self, stage: usize) {
        let x = &self.scene.start;
        match stage {
            0 => {
                self.broad_phase = BroadPhase::new(&self.mesh);
                self.find_near();
            }
            1 => self.find_near(),
            2 => drop(black_box(self.contact_set())),
            3 => {
                self.broad_phase = BroadPhase::new(&self.mesh);
                self.find_near();
                black_box(self.contact_set());
            }
            4 => _ = black_box(self.contact.value(x)),
            5 => _ = black_box(self.gradient()),
            6 => {
                black_box(self.contact.value(x));
                black_box(self.gradient());
            }
            7 => self.assemble(Projection::None),
            8 => self.assemble(Projection::Clamp),
            9 => self.assemble(Projection::Absolute),
            10 => self.find_swept(),
            11 => _ = black_box(self.step_limit()),
            12 => drop(black_box(intersection::check(&self.mesh, x))),
            _ => drop(black_box(intersection::check(&self.mesh, &self.scene.end))),
        }
    }
}
