//! Laws in lanes against the same laws on single numbers.

use crate::cases::{Random, Visit, each_law};
use mechanics_core::lanes::{
    Element, LaneKernel, Packet, dispatch, dispatch_portable, load_matrices, store_matrices,
};
use mechanics_core::law::{Domain, Hyperelastic};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{self, Mat3, Matrix3};

/// Everything a law gives, on every lane, as one list of numbers a matrix.
struct Everything<'a, L, E> {
    law: &'a L,
    matrices: &'a [Matrix3<E>],
    projection: Projection,
}

/// Rest gradients of a tetrahedron.
const GRADIENTS: [[f64; 3]; 3] = [[1.0, 0.2, -0.3], [0.1, 0.9, 0.4], [-0.2, 0.3, 1.1]];

impl<L: Hyperelastic, E: Element> LaneKernel<E> for Everything<'_, L, E> {
    type Output = Vec<Vec<f64>>;
    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) -> Self::Output {
        let mut all = Vec::new();
        for matrices in self.matrices.chunks_exact(P::LANES) {
            let f = load_matrices::<P>(matrices);
            let mut lists: Vec<Vec<f64>> = vec![Vec::new(); P::LANES];
            let energy = self.law.energy_density(&f).to_lanes();
            for (list, &energy) in lists.iter_mut().zip(energy.as_ref()) {
                list.push(energy.into());
            }
            let gradients = GRADIENTS.map(|g| g.map(P::constant));
            let blocks = self.law.stiffness(&f, self.projection).tetrahedron(&gradients, P::constant(1.0));
            for matrix in [self.law.first_piola(&f)].iter().chain(&blocks) {
                let mut back = vec![tensor::zero::<E>(); P::LANES];
                store_matrices(matrix, back.iter_mut());
                for (list, matrix) in lists.iter_mut().zip(&back) {
                    list.extend(matrix.iter().map(|&entry| entry.into()));
                }
            }
            all.extend(lists);
        }
        all
    }
}

/// The same of one matrix, without lanes.
fn single<L: Hyperelastic, E: Element>(law: &L, f: &Matrix3<E>, projection: Projection) -> Vec<f64> {
    let gradients = GRADIENTS.map(|g| g.map(E::constant));
    let blocks = law.stiffness(f, projection).tetrahedron(&gradients, E::constant(1.0));
    let mut list: Vec<f64> = vec![law.energy_density(f).into()];
    for matrix in [law.first_piola(f)].iter().chain(&blocks) {
        list.extend(matrix.iter().map(|&entry| entry.into()));
    }
    list
}

/// Near rest, moderate, indefinite, and inverted ones side by side in each packet.
fn matrices<E: Element>(random: &mut Random, domain: Domain) -> Vec<Matrix3<E>> {
    let mut next = |case: usize| match (case % 5, domain) {
        (0, _) => Mat3::identity() + random.matrix() * 1e-3,
        (1, _) => random.with_stretches([0.7, 0.5, 0.4]),
        (2, _) => random.with_stretches([2.5, 2.5, 0.6]),
        (3, Domain::EveryDeformation) => random.with_stretches([1.4, 0.9, -0.3]),
        _ => random.moderate(),
    };
    (0..80).map(|case| tensor::constant(&next(case))).collect()
}

/// Equal, NaN included, or within `allowed`.
fn close(a: f64, b: f64, allowed: f64) -> bool {
    a == b || (a.is_nan() && b.is_nan()) || (a - b).abs() <= allowed
}

struct Lanes;

impl Lanes {
    fn compare<L: Hyperelastic, E: Element>(name: &str, law: &L) {
        let mut random = Random::new(61);
        let mut matrices = matrices::<E>(&mut random, law.domain());
        // A packet with a mirror image and a NaN beside good neighbours.
        matrices[3] = tensor::constant(&Mat3::from_diagonal_element(-1.0));
        matrices[6] = tensor::constant(&Mat3::from_element(f64::NAN));
        for projection in [Projection::None, Projection::Clamp, Projection::Absolute] {
            let kernel = |matrices| Everything { law, matrices, projection };
            let (best, portable) = (dispatch(kernel(&matrices)), dispatch_portable(kernel(&matrices)));
            assert_eq!((best.len(), portable.len()), (80, 80));
            for (i, f) in matrices.iter().enumerate() {
                let expected = single(law, f, projection);
                let scale = expected.iter().filter(|x| x.is_finite()).fold(0.0_f64, |m, x| m.max(x.abs()));
                let allowed = 100.0 * <E as Scalar>::EPSILON * scale.max(1.0);
                for lanes in [&best[i], &portable[i]] {
                    assert_eq!(lanes.len(), expected.len());
                    // Outside its domain only the energy has a meaning.
                    let meaningful =
                        if i == 3 && law.domain() == Domain::PositiveVolume { 1 } else { lanes.len() };
                    for (k, (a, b)) in lanes.iter().zip(&expected).take(meaningful).enumerate() {
                        assert!(
                            close(*a, *b, allowed),
                            "{name} {projection:?}: number {k} is {a:e} in lanes and {b:e} alone, at {f:?}"
                        );
                    }
                }
            }
            // Neighbours of its own kind instead: same bits.
            let alike: Vec<_> = matrices.iter().flat_map(|f| vec![*f; E::LANES]).collect();
            for (mixed, alone) in best.iter().zip(dispatch(kernel(&alike)).iter().step_by(E::LANES)) {
                let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
                let all_same = mixed.iter().zip(alone).all(same);
                assert!(all_same, "{name} {projection:?}: a lane sees its neighbours");
            }
        }
    }
}

impl Visit for Lanes {
    fn visit<L: Hyperelastic>(&mut self, name: &str, law: &L) {
        Self::compare::<L, f64>(name, law);
        Self::compare::<L, f32>(name, law);
    }
}

#[test]
fn laws_in_lanes_are_those_of_single_numbers() {
    each_law(&mut Lanes);
}
