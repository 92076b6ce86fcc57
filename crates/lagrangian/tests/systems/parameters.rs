//! What constructors refuse.

use lagrangian::LagrangianError;
use lagrangian::systems::*;

fn culprit<T: std::fmt::Debug>(result: Result<T, LagrangianError>) -> (&'static str, f64) {
    match result.unwrap_err() {
        LagrangianError::Parameter { parameter, value, .. } => (parameter, value),
        other => panic!("{other}"),
    }
}

#[test]
fn masses_and_lengths_must_be_positive() {
    for bad in [0.0, -0.0, -1.0, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(culprit(MassOnSpring::new(bad, 1.0)), ("mass", bad));
        assert_eq!(culprit(MassOnSpring::new(1.0, bad)), ("stiffness", bad));
        assert_eq!(culprit(Projectile::new(bad, 9.81)), ("mass", bad));
        assert_eq!(culprit(Pendulum::new(bad, 1.0, 9.81)), ("mass", bad));
        assert_eq!(culprit(Pendulum::new(1.0, bad, 9.81)), ("length", bad));
        assert_eq!(culprit(CartesianPendulum::new(1.0, bad, 9.81)), ("length", bad));
        assert_eq!(culprit(SphericalPendulum::new(1.0, bad, 9.81)), ("length", bad));
        assert_eq!(culprit(SpringPendulum::new(1.0, bad, 1.0, 9.81)), ("stiffness", bad));
        assert_eq!(culprit(DoublePendulum::new([1.0, bad], [1.0; 2], 9.81)), ("masses", bad));
        assert_eq!(culprit(DoublePendulum::new([1.0; 2], [bad, 1.0], 9.81)), ("lengths", bad));
        assert_eq!(culprit(TriplePendulum::new([1.0, 1.0, bad], [1.0; 3], 9.81)), ("masses", bad));
        assert_eq!(culprit(PendulumChain::uniform(3, 1.0, bad, 9.81)), ("lengths", bad));
        assert_eq!(culprit(SpringChain::uniform(3, bad, 1.0)), ("masses", bad));
        assert_eq!(culprit(SpringChain::uniform(3, 1.0, bad)), ("stiffnesses", bad));
        assert_eq!(culprit(Kepler::new(bad, 1.0)), ("mass", bad));
        assert_eq!(culprit(PerturbedKepler::new(1.0, bad, 0.0)), ("strength", bad));
        assert_eq!(culprit(HeavyTop::new(1.0, bad, 1.0, 1.0, 9.81)), ("axial_inertia", bad));
        assert_eq!(culprit(FreeBody::new([1.0, bad, 1.0])), ("inertia", bad));
        assert_eq!(culprit(BeadOnHoop::new(1.0, bad, 9.81, 1.0)), ("radius", bad));
        assert_eq!(culprit(BeadOnWire::new(bad, 9.81, Parabola { curvature: 1.0 })), ("mass", bad));
        assert_eq!(culprit(CartPendulum::new(bad, 1.0, 1.0, 9.81)), ("cart_mass", bad));
    }
    let cart = CartPendulum::new(1.0, 1.0, 1.0, 9.81).unwrap();
    assert_eq!(culprit(cart.damped(0.0, -0.1)), ("hinge_damping", -0.1));
    let endless = Drive { amplitude: 1.0, frequency: f64::INFINITY };
    assert_eq!(culprit(cart.driven(endless)), ("drive.frequency", f64::INFINITY));
    assert_eq!(culprit(Duffing::new(1.0, 1.0, -0.1, 0.0, 0.0)), ("damping", -0.1));
    assert!(culprit(Pendulum::new(1.0, 1.0, f64::NAN)).1.is_nan());
    assert!(culprit(Pendulum::new(f64::NAN, 1.0, 9.81)).1.is_nan());
}

/// Weightlessness, a hoop that stands still, and springs that are cut are no errors.
#[test]
fn zero_is_allowed_where_it_means_something() {
    assert!(Pendulum::new(1.0, 1.0, 0.0).is_ok());
    assert!(BeadOnHoop::new(1.0, 1.0, 9.81, 0.0).is_ok());
    assert!(SpringChain::new(vec![1.0; 2], vec![0.0, 1.0, 0.0]).is_ok());
    assert!(Duffing::new(0.0, 0.0, 0.0, 0.0, 0.0).is_ok());
}

/// Under a hoop in a field upwards there is no rest at the bottom; a formula for the bottom must not claim it.
#[test]
fn a_hoop_upside_down_has_no_rest_at_the_bottom() {
    assert!(BeadOnHoop::new(1.0, 1.0, -9.81, 1.0).unwrap().equilibrium().is_nan());
    let critical = BeadOnHoop::new(1.0, 1.0, 9.0, 3.0).unwrap();
    assert_eq!([critical.equilibrium(), critical.frequency(), critical.growth_rate_at_bottom()], [0.0; 3]);
    assert_eq!(BeadOnHoop::new(1.0, 1.0, 0.0, 0.0).unwrap().equilibrium(), 0.0);
}

#[test]
fn the_message_can_be_acted_on() {
    let error = Pendulum::new(1.0, -2.0, 9.81).unwrap_err();
    assert_eq!(error.to_string(), "pendulum: the length is -2; it must be positive and finite");
}
