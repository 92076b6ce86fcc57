//! The swept area against frames carried explicitly, by automatic differentiation, and the derivative checker.

use crate::samples::{Random, SECTION, crooked, gradient, hessian, twist};
use lagrangian::element::rod::RodTwist;
use mechanics_core::derivatives::{check_potential_gradient, check_potential_hessian};
use mechanics_core::jet::Jet2;
use mechanics_core::mesh::{PolylineEnds, TriMesh};
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{Vec3, cross, dot};

type Vector<S> = [S; 3];

fn plus<S: Scalar>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    std::array::from_fn(|k| a[k] + b[k])
}

fn times<S: Scalar>(a: Vector<S>, factor: S) -> Vector<S> {
    a.map(|a| a * factor)
}

fn unit<S: Scalar>(a: Vector<S>) -> Vector<S> {
    times(a, dot(&a, &a).sqrt().recip())
}

fn minus<S: Scalar>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    plus(a, times(b, S::constant(-1.0)))
}

/// v turned by the rotation about a × t that takes a to t (Rodrigues' formula).
fn carried<S: Scalar>(v: Vector<S>, a: Vector<S>, t: Vector<S>) -> Vector<S> {
    let axis = cross(&a, &t);
    let c = dot(&a, &t);
    let along = times(axis, dot(&axis, &v) / c.offset(1.0));
    plus(plus(times(v, c), cross(&axis, &v)), along)
}

/// A joint with frames that are vectors: directions of the edges, and a director for each.
#[derive(Clone, Copy)]
struct Frames {
    tangents: [Vector<f64>; 2],
    directors: [Vector<f64>; 2],
}

impl Frames {
    fn at_rest(x: [Vector<f64>; 3]) -> Self {
        let tangents = [unit(minus(x[1], x[0])), unit(minus(x[2], x[1]))];
        let director = unit(cross(&tangents[0], &[0.3, 0.5, 0.8]));
        Self { tangents, directors: [director, carried(director, tangents[0], tangents[1])] }
    }

    fn moved<S: Scalar>(&self, x: [Vector<S>; 3]) -> ([Vector<S>; 2], [Vector<S>; 2]) {
        let lift = |v: Vector<f64>| v.map(S::constant);
        let t = [unit(minus(x[1], x[0])), unit(minus(x[2], x[1]))];
        let d = std::array::from_fn(|k| carried(lift(self.directors[k]), lift(self.tangents[k]), t[k]));
        (t, d)
    }

    /// The angle about t₁ from the first director, carried over, to the second.
    fn twist<S: Scalar>(&self, x: [Vector<S>; 3]) -> S {
        let (t, d) = self.moved(x);
        let first = carried(d[0], t[0], t[1]);
        dot(&t[1], &cross(&first, &d[1])).atan2(dot(&first, &d[1]))
    }
}

/// ½ k (θ₁ − θ₀ + twist of the frames)² for the unknowns of three points and two turns.
fn energy<S: Scalar>(frames: &Frames, stiffness: f64, q: &[S; 11]) -> S {
    let point = |i: usize| [q[3 * i], q[3 * i + 1], q[3 * i + 2]];
    let turned = (q[10] - q[9]).scale(1.0 / SECTION.gyration_radius);
    (turned + frames.twist([point(0), point(1), point(2)])).square().scale(0.5 * stiffness)
}

/// A joint at rest, and GJ/ℓ̄.
fn joint(random: &mut Random) -> (RodTwist, Vec<Vec3>, f64) {
    let points = vec![
        Vec3::new(-1.0, 0.0, 0.0) + random.vector() * 0.3,
        random.vector() * 0.3,
        Vec3::new(0.7, 0.3, 0.1) + random.vector() * 0.3,
    ];
    let mesh = TriMesh::with_codimensional(points, vec![], vec![[0, 1], [1, 2]], vec![]).unwrap();
    let length = 0.5 * mesh.free_length();
    let (twist, x) = twist(&mesh, SECTION);
    (twist, x, SECTION.torsional / length)
}

/// Energy, gradient and Hessian of a joint that has been carried along twice, against jets of explicit frames.
#[test]
fn a_joint_agrees_with_automatic_differentiation_of_explicit_frames() {
    let mut random = Random(1);
    for round in 0..40 {
        let size = [1e-6, 0.05, 0.15, 0.25][round % 4];
        let (mut twist, mut x, stiffness) = joint(&mut random);
        let corners = |x: &[Vec3]| [0, 1, 2].map(|i| <[f64; 3]>::from(x[i]));
        let mut frames = Frames::at_rest(corners(&x));
        for _ in 0..2 {
            x.iter_mut().take(3).for_each(|x| *x += random.vector() * size);
            let (tangents, directors) = frames.moved(corners(&x));
            frames = Frames { tangents, directors };
            twist.transport_to(&x).unwrap();
        }
        x.iter_mut().take(3).for_each(|x| *x += random.vector() * size);
        (x[3].x, x[4].x) = (0.2 * random.number(), 0.2 * random.number());

        let flat = |k: usize| if k < 9 { x[k / 3][k % 3] } else { x[k - 6].x };
        let jet = energy(&frames, stiffness, &Jet2::variables(std::array::from_fn(flat)));
        let scale = jet.hessian_matrix().as_flattened().iter().fold(0.0_f64, |m, h| m.max(h.abs()));
        let (value, expected) = (twist.value(&x), jet.value);
        assert!((value - expected).abs() < 1e-13 * scale, "round {round}: {value} {expected}");
        let g = gradient(&twist, &x);
        let h = hessian(&[&twist], &x, &[]);
        let at = |k: usize| if k < 9 { k } else { 3 * (k - 6) };
        for k in 0..11 {
            assert!((g[at(k) / 3][at(k) % 3] - jet.gradient[k]).abs() < 1e-13 * scale, "round {round}: {k}");
            for l in 0..11 {
                let error = h[(at(k), at(l))] - jet.hessian(k, l);
                assert!(
                    error.abs() < 1e-12 * scale,
                    "round {round}: ({k}, {l}) off by {error:e} of {scale:e}"
                );
            }
        }
    }
}

/// Edges listed against each other, open and closed rods, natural twist.
#[test]
fn rods_pass_the_derivative_checker_and_project_to_semi_definite() {
    let mut random = Random(2);
    for round in 0..8 {
        let ends = [PolylineEnds::Open, PolylineEnds::Joined][round % 2];
        let mesh = crooked(&mut random, 7, ends);
        let edges: Vec<[u32; 2]> = mesh
            .free_edges()
            .iter()
            .map(|&[a, b]| if random.number() > 0.0 { [a, b] } else { [b, a] })
            .collect();
        let mesh = TriMesh::with_codimensional(mesh.points().to_vec(), vec![], edges, vec![]).unwrap();
        let (term, mut x) = twist(&mesh, SECTION);
        let mut term = term.with_natural_twist(0.3).unwrap();
        for _ in 0..2 {
            term.transport_to(&x).unwrap();
            x.iter_mut().for_each(|x| *x += random.vector() * 0.1);
        }
        check_potential_gradient(&term, &x).require(1e-7).unwrap();
        check_potential_hessian(&term, &x).require(1e-6).unwrap();

        let map = mechanics_core::point_map::PointMap::identity(x.len());
        for projection in [Projection::Clamp, Projection::Absolute] {
            let mut assembly = mechanics_core::sparse::Assembly::new(&map);
            let mut assembler = assembly.begin(&map);
            term.add_hessian(&x, projection, &mut assembler);
            let dense = crate::samples::dense(assembler.finish(), x.len());
            let values = dense.symmetric_eigenvalues();
            assert!(values.min() > -1e-13 * values.amax(), "{projection:?}: {}", values.min());
        }
    }
}

/// Turning an edge's direction round in the list changes the sign of its turn and nothing else.
#[test]
fn the_direction_of_edges_is_a_matter_of_signs() {
    let mut random = Random(3);
    let mesh = crooked(&mut random, 6, PolylineEnds::Open);
    let turned: Vec<[u32; 2]> = mesh.free_edges().iter().map(|&[a, b]| [b, a]).collect();
    let turned = TriMesh::with_codimensional(mesh.points().to_vec(), vec![], turned, vec![]).unwrap();
    let (one, mut x) = twist(&mesh, SECTION);
    let (other, _) = twist(&turned, SECTION);
    x.iter_mut().take(6).for_each(|x| *x += random.vector() * 0.1);
    x.iter_mut().skip(6).for_each(|x| x.x = 0.1 * random.number());
    let mut y = x.clone();
    y.iter_mut().skip(6).for_each(|x| x.x = -x.x);
    assert!((one.value(&x) - other.value(&y)).abs() < 1e-14 * one.value(&x));
    for (i, (g, h)) in gradient(&one, &x).iter().zip(gradient(&other, &y)).enumerate() {
        let h = if i < 6 { h } else { -h };
        assert!((g - h).norm() < 1e-13, "point {i}: {g} {h}");
    }
}

/// Carrying frames along twice to the same place is exact, in every bit; a twist can be saved and put back.
#[test]
fn frames_that_stay_keep_their_bits() {
    let mut random = Random(4);
    let mesh = crooked(&mut random, 9, PolylineEnds::Joined);
    let (mut term, mut x) = twist(&mesh, SECTION);
    for _ in 0..20 {
        x.iter_mut().take(9).for_each(|x| *x += random.vector() * 0.05);
        term.transport_to(&x).unwrap();
        let before = term.reference_twists();
        term.transport_to(&x).unwrap();
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&before), bits(&term.reference_twists()));
        let (mut fresh, _) = twist(&mesh, SECTION);
        fresh.restore(&x, &before).unwrap();
        let y: Vec<Vec3> = x.iter().map(|x| x + random.vector() * 0.02).collect();
        assert_eq!(term.value(&y).to_bits(), fresh.value(&y).to_bits());
    }
}

#[test]
fn edges_that_turn_too_far_are_refused() {
    let mesh = TriMesh::with_codimensional(
        vec![Vec3::zeros(), Vec3::x(), Vec3::x() * 2.0],
        vec![],
        vec![[0, 1], [1, 2]],
        vec![],
    )
    .unwrap();
    let (mut term, x) = twist(&mesh, SECTION);
    let at = |angle: f64| {
        let mut y = x.clone();
        y[2] = Vec3::new(1.0 + angle.cos(), angle.sin(), 0.0);
        y
    };
    assert!(term.value(&at(3.1)) < 1e-20, "a plane curve has no twist");
    // Turned by 100° and then by another 100°, one edge in the end folds back beyond 180°.
    assert!(term.transport_to(&at(1.7)).is_ok());
    let folded: Vec<Vec3> = at(1.7 + 1.7);
    assert_eq!(term.value(&folded), f64::INFINITY);
    let before = term.reference_twists();
    let error = term.transport_to(&folded).unwrap_err().to_string();
    assert!(error.contains("[0, 1, 2]"), "{error}");
    assert_eq!(before, term.reference_twists());
    let mut collapsed = x.clone();
    collapsed[2] = collapsed[1];
    assert_eq!(term.value(&collapsed), 0.0);
    assert!(gradient(&term, &collapsed).iter().all(|g| *g == Vec3::zeros()));
    assert!(term.twists(&collapsed)[0].is_nan());
}

#[test]
fn what_has_no_twist_is_refused() {
    use lagrangian::element::rod::TwistSection;
    let mesh = mechanics_core::mesh::rod(&Vec3::zeros(), &Vec3::x(), 3).unwrap();
    let message = |section| RodTwist::new("twist", &mesh, section, 4).unwrap_err().to_string();
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(message(TwistSection { torsional: value, ..SECTION }).contains("torsional rigidity"));
        assert!(message(TwistSection { gyration_radius: value, ..SECTION }).contains("radius of gyration"));
        assert!(TwistSection::circular(value, 0.1).is_err() && TwistSection::circular(1.0, value).is_err());
    }
    let new = || RodTwist::new("twist", &mesh, SECTION, 4).unwrap();
    assert!(new().with_natural_twist(f64::NAN).unwrap_err().to_string().contains("natural twist"));
    assert!(
        new().restore(mesh.points(), &[0.0, f64::NAN]).unwrap_err().to_string().contains("reference twist")
    );
    // The turns begin among the mesh's own points.
    assert!(RodTwist::new("twist", &mesh, SECTION, 2).unwrap_err().to_string().contains("turn"));
}
