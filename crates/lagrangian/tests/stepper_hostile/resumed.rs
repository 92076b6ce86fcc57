//! Runs that go on from a checkpoint taken at any tenth step, with new objects: the same bits.

use lagrangian::element::{DeadLoad, Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::{ExplicitScheme, ExplicitStepper, Stepper, StepperOptions, TimeScheme};
use mechanics_core::checkpoint::Checkpoint;
use mechanics_core::law::{Lame, NeoHookean};
use mechanics_core::mesh::{BoxSplit, TetMesh, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::stencil::StencilTerm;
use mechanics_core::tensor::Vec3;

pub(crate) const SCHEMES: [TimeScheme; 4] =
    [TimeScheme::BackwardEuler, TimeScheme::Bdf2, TimeScheme::Newmark, TimeScheme::ImplicitMidpoint];
pub(crate) const STEP: f64 = 0.01;

/// A soft bar, clamped at one end, which falls and swings.
pub(crate) struct Body {
    pub(crate) elastic: StencilTerm<Tetrahedra<NeoHookean>, 4>,
    pub(crate) gravity: DeadLoad,
    pub(crate) mass: Mass,
    pub(crate) map: PointMap,
    pub(crate) stepper: Stepper,
    pub(crate) state: State,
}

/// Its shape at rest, and what it is made of.
pub(crate) fn bar() -> (TetMesh, NeoHookean) {
    let mesh = block(&Vec3::zeros(), &Vec3::new(0.4, 0.1, 0.1), [4, 1, 1], BoxSplit::Six).unwrap();
    (mesh, NeoHookean::new(Lame::from_young_poisson(1e5, 0.3).unwrap()))
}

impl Body {
    pub(crate) fn new(scheme: TimeScheme) -> Self {
        let (mesh, law) = bar();
        let mut mass = Mass::zeros(mesh.points().len());
        mass.add_tetrahedra(mesh.points(), mesh.cells(), 1000.0, MassDistribution::Lumped).unwrap();
        let at_wall = (0..).zip(mesh.points()).filter(|(_, x)| x.x == 0.0);
        let fixed: Vec<(u32, Vec3)> = at_wall.map(|(point, x)| (point, *x)).collect();
        let map = PointMap::with_fixed(mesh.points().len(), &fixed).unwrap();
        let newton = NewtonOptions { tolerance: 1e-9, ..NewtonOptions::default() };
        let options = StepperOptions { scheme, newton, ..StepperOptions::default() };
        Self {
            elastic: Tetrahedra::term("elastic", law, &mesh).unwrap(),
            gravity: DeadLoad::gravity(&mass, &Vec3::new(0.0, 3.0, -9.81)).unwrap(),
            stepper: Stepper::new(mass.clone(), map.clone(), options),
            mass,
            map,
            state: State::at_rest(mesh.points().to_vec()),
        }
    }

    pub(crate) fn steps(&mut self, count: u32) {
        for _ in 0..count {
            let Self { elastic, gravity, stepper, state, .. } = self;
            stepper.step(state, &mut [elastic, gravity], STEP).unwrap();
        }
    }
}

/// As it is after a file.
fn saved(state: &State) -> State {
    let mut checkpoint = Checkpoint::new();
    state.save(&mut checkpoint, "state");
    let mut checkpoint = Checkpoint::from_bytes(&checkpoint.to_bytes()).unwrap();
    let loaded = State::load(&mut checkpoint, "state").unwrap();
    checkpoint.finish().unwrap();
    loaded
}

#[test]
fn implicit_runs_resumed_at_every_tenth_step_end_in_the_same_bits() {
    for scheme in SCHEMES {
        let mut whole = Body::new(scheme);
        let mut snapshots = Vec::new();
        for _ in 0..5 {
            whole.steps(10);
            snapshots.push(saved(&whole.state));
        }
        for snapshot in snapshots {
            let mut resumed = Body { state: snapshot, ..Body::new(scheme) };
            resumed.steps(50 - resumed.state.step as u32);
            assert_eq!(resumed.state.hash(), whole.state.hash(), "{scheme:?}");
        }
    }
}

#[test]
fn explicit_runs_resumed_at_every_tenth_step_end_in_the_same_bits() {
    for scheme in [ExplicitScheme::SymplecticEuler, ExplicitScheme::CentralDifferences] {
        let run = |state: State, steps: u64| {
            let Body { mut elastic, mut gravity, mass, map, .. } = Body::new(SCHEMES[0]);
            let stepper = ExplicitStepper::new(scheme, mass, map).unwrap();
            let (mut state, mut snapshots) = (state, Vec::new());
            while state.step < steps {
                stepper.step(&mut state, &mut [&mut elastic, &mut gravity], 1e-4).unwrap();
                if state.step.is_multiple_of(10) {
                    snapshots.push(saved(&state));
                }
            }
            (state.hash(), snapshots)
        };
        let (whole, snapshots) = run(Body::new(SCHEMES[0]).state, 100);
        for snapshot in snapshots {
            assert_eq!(run(snapshot, 100).0, whole, "{scheme:?}");
        }
    }
}
