use crate::samples::Random;
use mechanics_core::parallel::with_threads;
use mechanics_core::point_map::{PointMap, PointSource};
use mechanics_core::sparse::{Assembly, BlockMatrix};
use mechanics_core::stencil::LocalHessian;
use mechanics_core::tensor::{Mat3, Vec3};
use nalgebra::DMatrix;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

/// One element list and its Hessians.
struct List<const N: usize> {
    elements: Vec<[u32; N]>,
    hessians: Vec<LocalHessian<N>>,
}

impl<const N: usize> List<N> {
    fn random(random: &mut Random, count: usize, points: usize) -> Self {
        Self { elements: random.elements(count, points), hessians: random.hessians(count) }
    }

    /// Adds up `Wᵀ Hₑ W` densely, element after element.
    fn add_dense(&self, map: &PointMap, dense: &mut DMatrix<f64>) {
        for (element, hessian) in self.elements.iter().zip(&self.hessians) {
            for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
                map.for_each_unknown(element[i] as usize, |a, wa| {
                    map.for_each_unknown(element[j] as usize, |b, wb| {
                        let mut view = dense.fixed_view_mut::<3, 3>(3 * a as usize, 3 * b as usize);
                        view += hessian[i][j] * (wa * wb);
                    });
                });
            }
        }
    }

    /// The serial oracle for maps without weights: every block summed in element order.
    fn add_serial(&self, map: &PointMap, blocks: &mut BTreeMap<(u32, u32), Mat3>) {
        for (element, hessian) in self.elements.iter().zip(&self.hessians) {
            for (i, j) in (0..N).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                map.for_each_unknown(element[i] as usize, |a, _| {
                    map.for_each_unknown(element[j] as usize, |b, _| {
                        let block = if a >= b { hessian[i][j] } else { hessian[i][j].transpose() };
                        *blocks.entry((a.max(b), a.min(b))).or_insert_with(Mat3::zeros) += block;
                    });
                });
            }
        }
    }
}

fn assemble<const N: usize, const M: usize>(
    assembly: &mut Assembly,
    map: &PointMap,
    first: &List<N>,
    second: &List<M>,
) -> BlockMatrix {
    let mut assembler = assembly.begin(map);
    assembler.begin_term(0);
    assembler.add(&first.elements, |e| first.hessians[e]);
    assembler.begin_term(1);
    assembler.add(&second.elements, |e| second.hessians[e]);
    assembler.finish().clone()
}

fn to_dense(matrix: &BlockMatrix) -> DMatrix<f64> {
    let mut dense = DMatrix::zeros(matrix.dimension(), matrix.dimension());
    for column in 0..matrix.pattern().columns() {
        for slot in matrix.pattern().column(column) {
            let row = matrix.pattern().rows()[slot] as usize;
            dense.fixed_view_mut::<3, 3>(3 * row, 3 * column).copy_from(&matrix.blocks()[slot]);
            dense.fixed_view_mut::<3, 3>(3 * column, 3 * row).copy_from(&matrix.blocks()[slot].transpose());
        }
    }
    dense
}

fn bits(matrix: &BlockMatrix) -> Vec<u64> {
    matrix.blocks().iter().flatten().map(|entry| entry.to_bits()).collect()
}

fn weighted_map(points: usize) -> PointMap {
    let pairs: Vec<[(u32, f64); 2]> =
        (0..points as u32).map(|i| [(i / 2, 0.3), (points as u32 / 2 - i / 2, 0.7)]).collect();
    let sources = pairs.iter().enumerate().map(|(i, pairs)| match i % 5 {
        0 | 1 => PointSource::Unknown(i as u32 / 2),
        2 if pairs[0].0 != pairs[1].0 => PointSource::Weighted(pairs),
        3 => PointSource::Weighted(&pairs[..1]),
        _ => PointSource::Unknown(i as u32 / 2),
    });
    let sources: Vec<_> =
        sources.chain([PointSource::Fixed, PointSource::Unknown(points as u32 / 2)]).collect();
    PointMap::new(points / 2 + 1, sources).unwrap()
}

/// Against dense `Wᵀ H W`: identity, fixed points, weights (two unknowns a point, also the same one twice in an
/// element).
#[test]
fn the_matrix_is_the_congruence_of_the_sum() {
    let mut random = Random(11);
    let fixed: Vec<(u32, Vec3)> = [0, 7, 8, 39].map(|i| (i, Vec3::zeros())).into();
    let weighted = weighted_map(40);
    for (map, points) in
        [(PointMap::identity(40), 40), (PointMap::with_fixed(40, &fixed).unwrap(), 40), (weighted, 42)]
    {
        let first = List::<4>::random(&mut random, 150, points);
        let second = List::<2>::random(&mut random, 60, points);
        let mut dense = DMatrix::zeros(3 * map.unknowns(), 3 * map.unknowns());
        first.add_dense(&map, &mut dense);
        second.add_dense(&map, &mut dense);
        let matrix = assemble(&mut Assembly::new(&map), &map, &first, &second);
        let error = (to_dense(&matrix) - &dense).amax() / dense.amax();
        assert!(error < 1e-14, "relative error {error:e}");
    }
}

/// Bits, not tolerances: every block is the sum in element order, for any number of threads. More elements than a
/// batch, so that batches and runs of slots are cut.
#[test]
fn any_number_of_threads_gives_the_bits_of_the_serial_sum() {
    let mut random = Random(12);
    let points = 700;
    let map = PointMap::with_fixed(points, &[(5, Vec3::zeros()), (300, Vec3::x())]).unwrap();
    let first = List::<4>::random(&mut random, 3000, points);
    let second = List::<3>::random(&mut random, 2500, points);
    let mut expected = BTreeMap::new();
    first.add_serial(&map, &mut expected);
    second.add_serial(&map, &mut expected);
    for threads in [1, 2, 3, 8] {
        with_threads(threads, || {
            let mut assembly = Assembly::new(&map);
            for repeat in 0..2 {
                let matrix = assemble(&mut assembly, &map, &first, &second);
                assert_eq!(matrix.pattern().block_count(), expected.len());
                for (&(row, column), block) in &expected {
                    let slot = matrix.pattern().slot(row as usize, column as usize).unwrap();
                    assert_eq!(
                        &matrix.blocks()[slot],
                        block,
                        "({row}, {column}), {threads} threads, run {repeat}"
                    );
                }
            }
        });
    }
}

/// Elements whose points lie near each other and near those of the next element, as in a mesh.
fn strip(random: &mut Random, count: usize, points: usize) -> List<4> {
    let near = |e: usize| e * (points - 12) / count;
    let elements = (0..count)
        .map(|e| [0, 3, 6, 9].map(|corner| (near(e) + corner + random.below(3)) as u32))
        .map(|[a, b, c, d]| [c, a, d, b])
        .collect();
    List { elements, hessians: random.hessians(count) }
}

/// The same elements in an order as wild as can be.
fn shuffled(random: &mut Random, list: &List<4>) -> List<4> {
    let mut order: Vec<usize> = (0..list.elements.len()).collect();
    (1..order.len()).for_each(|k| order.swap(k, random.below(k + 1)));
    List {
        elements: order.iter().map(|&e| list.elements[e]).collect(),
        hessians: order.iter().map(|&e| list.hessians[e]).collect(),
    }
}

/// As above, for a list that threads share by windows and one that they compute in batches; the first assembly's
/// slots are numbered otherwise than those of later ones.
#[test]
fn lists_near_and_wild_have_the_bits_of_the_serial_sum() {
    let mut random = Random(23);
    let points = 900;
    let map = PointMap::with_fixed(points, &[(5, Vec3::zeros()), (300, Vec3::x())]).unwrap();
    let near = strip(&mut random, 3003, points);
    let wild = shuffled(&mut random, &near);
    let mut expected = BTreeMap::new();
    near.add_serial(&map, &mut expected);
    wild.add_serial(&map, &mut expected);
    for threads in [1, 2, 3, 8] {
        with_threads(threads, || {
            let mut assembly = Assembly::new(&map);
            for repeat in 0..3 {
                let matrix = assemble(&mut assembly, &map, &near, &wild);
                for (&(row, column), block) in &expected {
                    let slot = matrix.pattern().slot(row as usize, column as usize).unwrap();
                    let same = matrix.blocks()[slot] == *block;
                    assert!(same, "({row}, {column}), {threads} threads, run {repeat}");
                }
            }
        });
    }
}

/// What threads compute more than once is little where elements lie near each other, and nothing where they do not.
#[test]
fn few_elements_are_computed_twice() {
    let mut random = Random(24);
    let points = 4000;
    let map = PointMap::identity(points);
    let near = strip(&mut random, 8000, points);
    let wild = shuffled(&mut random, &near);
    let count = |list: &List<4>, threads: usize| {
        with_threads(threads, || {
            let computed = AtomicUsize::new(0);
            let mut assembly = Assembly::new(&map);
            for _ in 0..2 {
                computed.store(0, Ordering::Relaxed);
                let mut assembler = assembly.begin(&map);
                assembler.add(&list.elements, |e| {
                    computed.fetch_add(1, Ordering::Relaxed);
                    list.hessians[e]
                });
                assembler.finish();
            }
            computed.into_inner()
        })
    };
    // An element spans 12 points, two elements begin at each: 24 elements a cut, in 3 or 4 groups of eight.
    for (threads, cuts) in [(1, 0), (2, 1), (3, 2), (8, 7)] {
        let near = count(&near, threads);
        assert!((8000..=8000 + cuts * 40).contains(&near), "{threads} threads computed {near} of 8000");
        assert_eq!(count(&wild, threads), 8000, "{threads} threads");
    }
}

#[test]
fn weights_give_the_same_bits_for_any_number_of_threads() {
    let mut random = Random(13);
    let map = weighted_map(400);
    let first = List::<4>::random(&mut random, 2000, map.points());
    let second = List::<2>::random(&mut random, 3000, map.points());
    let run =
        |threads| with_threads(threads, || bits(&assemble(&mut Assembly::new(&map), &map, &first, &second)));
    let serial = run(1);
    for threads in [2, 3, 8] {
        assert!(run(threads) == serial, "{threads} threads");
    }
}

/// Contacts come and go: whatever was assembled before, blocks have the bits of a fresh assembly, and blocks that
/// are left over are zero.
#[test]
fn changing_lists_leave_no_trace_in_the_values() {
    let mut random = Random(14);
    let points = 300;
    let map = PointMap::with_fixed(points, &[(17, Vec3::zeros())]).unwrap();
    let body = List::<4>::random(&mut random, 1200, points);
    let mut assembly = Assembly::new(&map);
    for round in 0..40 {
        let count = [0, 3, 50, 700][random.below(4)];
        let mut contacts = List::<4>::random(&mut random, count, points);
        // Contacts between points that the body does not connect.
        contacts.elements.iter_mut().for_each(|e| e[0] = (e[0] + 120) % points as u32);
        contacts.elements.iter_mut().for_each(|e| {
            if e[1..].contains(&e[0]) {
                e[0] = (e[3] + 150) % points as u32;
            }
        });
        let matrix = assemble(&mut assembly, &map, &body, &contacts);
        let fresh = assemble(&mut Assembly::new(&map), &map, &body, &contacts);
        let mut left_over = 0;
        for column in 0..matrix.pattern().columns() {
            for slot in matrix.pattern().column(column) {
                let row = matrix.pattern().rows()[slot] as usize;
                let block = &matrix.blocks()[slot];
                match fresh.pattern().slot(row, column) {
                    Some(same) => assert_eq!(block, &fresh.blocks()[same], "round {round}"),
                    None => {
                        left_over += 1;
                        assert_eq!(block, &Mat3::zeros(), "round {round}");
                    }
                }
            }
        }
        assert_eq!(
            left_over + fresh.pattern().block_count(),
            matrix.pattern().block_count(),
            "none is missing"
        );
        assert!(
            4 * left_over <= matrix.pattern().block_count() + 4 * left_over / 3,
            "{left_over} stale blocks"
        );
        assembly.begin_step();
        let tidy = assemble(&mut assembly, &map, &body, &contacts);
        assert_eq!(tidy.pattern(), fresh.pattern(), "a new step forgets, round {round}");
        assert_eq!(bits(&tidy), bits(&fresh), "round {round}");
    }
}

#[test]
fn a_list_is_looked_up_only_when_it_changes() {
    let mut random = Random(15);
    let map = PointMap::identity(200);
    let body = List::<4>::random(&mut random, 800, 200);
    let mut contacts = List::<2>::random(&mut random, 30, 200);
    let mut assembly = Assembly::new(&map);
    for _ in 0..3 {
        assemble(&mut assembly, &map, &body, &contacts);
    }
    assert_eq!(assembly.counts().lists_mapped, 2, "three assemblies of two lists that stay");
    assert_eq!(assembly.counts().pattern_changes, 1);
    let pattern = assembly.matrix().pattern().clone();
    contacts.elements.truncate(29);
    assemble(&mut assembly, &map, &body, &contacts);
    assert_eq!(assembly.counts().lists_mapped, 3, "one list changed");
    assert!(std::sync::Arc::ptr_eq(&pattern, assembly.matrix().pattern()), "fewer contacts, same pattern");
    // Other fixed points: everything is new.
    let other = PointMap::with_fixed(200, &[(3, Vec3::zeros())]).unwrap();
    assert_eq!(assemble(&mut assembly, &other, &body, &contacts).dimension(), 3 * 199);
    assert_eq!(assembly.counts().lists_mapped, 5);
}

/// An assembly that was given up half-way (a panic, an early return) does not spoil the next.
#[test]
fn an_abandoned_assembly_does_no_harm() {
    let mut random = Random(16);
    let map = PointMap::identity(60);
    let (body, other) = (List::<4>::random(&mut random, 100, 60), List::<4>::random(&mut random, 90, 60));
    let contacts = List::<2>::random(&mut random, 30, 60);
    let mut assembly = Assembly::new(&map);
    assemble(&mut assembly, &map, &body, &contacts);
    let mut abandoned = assembly.begin(&map);
    abandoned.add(&other.elements, |e| other.hessians[e]);
    let _ = abandoned;
    let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        assembly.begin(&map).add(&[[0, 60]], |_| [[Mat3::zeros(); 2]; 2]);
    }));
    assert!(result.is_err(), "point 60 does not exist");
    assembly.begin_step();
    let again = assemble(&mut assembly, &map, &body, &contacts);
    let fresh = assemble(&mut Assembly::new(&map), &map, &body, &contacts);
    assert_eq!(again.pattern(), fresh.pattern());
    assert_eq!(bits(&again), bits(&fresh));
}

#[test]
fn nothing_to_add_is_the_zero_matrix() {
    let map = PointMap::identity(3);
    let mut assembly = Assembly::new(&map);
    assert_eq!(assembly.begin(&map).finish().pattern().block_count(), 3);
    let mut assembler = assembly.begin(&map);
    assembler.add(&[] as &[[u32; 4]], |_| unreachable!("no elements"));
    assert!(assembler.finish().blocks().iter().all(|block| *block == Mat3::zeros()));
    let empty = PointMap::identity(0);
    assert_eq!(Assembly::new(&empty).begin(&empty).finish().dimension(), 0);
    // All points fixed: elements have nowhere to go.
    let fixed = PointMap::with_fixed(2, &[(0, Vec3::zeros()), (1, Vec3::x())]).unwrap();
    let mut assembly = Assembly::new(&fixed);
    let mut assembler = assembly.begin(&fixed);
    assembler.add(&[[0, 1]], |_| [[Mat3::identity(); 2]; 2]);
    assert_eq!(assembler.finish().dimension(), 0);
}

/// Else the second list would take the place of the first, and blocks of the first would be dropped as stale.
#[test]
#[should_panic(expected = "the lists of term 1 were added before")]
fn a_term_is_begun_once() {
    let map = PointMap::identity(4);
    let mut assembly = Assembly::new(&map);
    let mut assembler = assembly.begin(&map);
    assembler.begin_term(1);
    assembler.add(&[[0, 1]], |_| [[Mat3::identity(); 2]; 2]);
    assembler.begin_term(0);
    assembler.add(&[[0, 2]], |_| [[Mat3::identity(); 2]; 2]);
    assembler.begin_term(1);
}

/// A point named twice within an element: H_qq = Wᵀ H W with equal rows in W, on a selection and on a weighted map.
#[test]
fn repeated_points_add_up() {
    let mut random = Random(19);
    let elements = vec![[3, 3, 1, 2], [2, 2, 2, 2], [0, 3, 0, 1]];
    let list = List::<4> { hessians: random.hessians(elements.len()), elements };
    let other = List::<2> { elements: Vec::new(), hessians: Vec::new() };
    let fixed = PointMap::with_fixed(4, &[(1, Vec3::x())]).unwrap();
    for map in [PointMap::identity(4), fixed, weighted_map(4)] {
        let mut dense = DMatrix::zeros(3 * map.unknowns(), 3 * map.unknowns());
        list.add_dense(&map, &mut dense);
        let matrix = assemble(&mut Assembly::new(&map), &map, &list, &other);
        let error = (to_dense(&matrix) - &dense).amax() / dense.amax();
        assert!(error < 1e-14, "relative error {error:e}");
    }
}

/// Whatever an assembly went through (maps with weights and fixed points that change, lists that change at every call or are empty or
/// move nothing, near and wild orders, other numbers of threads at every call), blocks have the bits of a fresh serial one.
#[test]
fn an_assembly_forgets_whatever_it_went_through() {
    let mut random = Random(41);
    let points = 500;
    let fixed: Vec<(u32, Vec3)> = (100..260).map(|i| (i, Vec3::zeros())).collect();
    let weighted = {
        // Point 501 of it is unknown 250, point 500 is fixed.
        let pairs: Vec<[(u32, f64); 2]> = (0..250).map(|i| [(i, 0.25), (250 - i, 0.75)]).collect();
        let own = (0..250).map(PointSource::Unknown);
        let mixed = pairs.iter().enumerate().map(|(i, pairs)| match i {
            125 => PointSource::Fixed,
            _ => PointSource::Weighted(pairs),
        });
        let ends = [PointSource::Fixed, PointSource::Unknown(250)];
        PointMap::new(251, own.chain(mixed).chain(ends)).unwrap()
    };
    let maps = [PointMap::identity(points), PointMap::with_fixed(points, &fixed).unwrap(), weighted];
    let mut assembly = Assembly::new(&maps[0]);
    let mut map = &maps[0];
    for round in 0..60 {
        if random.below(5) == 0 {
            map = &maps[random.below(3)];
        }
        let count = [0, 1, 300, 2100][random.below(4)];
        let near = strip(&mut random, count, points);
        let first = if random.below(2) == 0 { shuffled(&mut random, &near) } else { near };
        let count = [0, 7, 1500][random.below(3)];
        let mut second = List::<3>::random(&mut random, count, points);
        if random.below(3) == 0 {
            // None of these has unknowns in the second map.
            second.elements.iter_mut().flatten().for_each(|point| *point = 100 + *point % 160);
        }
        if random.below(4) == 0 {
            assembly.begin_step();
        }
        let repeats = 1 + random.below(2);
        for _ in 0..repeats {
            let threads = [1, 2, 3, 8][random.below(4)];
            let matrix = with_threads(threads, || assemble(&mut assembly, map, &first, &second));
            let fresh = with_threads(1, || assemble(&mut Assembly::new(map), map, &first, &second));
            for column in 0..matrix.pattern().columns() {
                for slot in matrix.pattern().column(column) {
                    let row = matrix.pattern().rows()[slot] as usize;
                    let known = fresh.pattern().slot(row, column);
                    let expected = known.map_or_else(Mat3::zeros, |same| fresh.blocks()[same]);
                    let same =
                        matrix.blocks()[slot].iter().zip(&expected).all(|(a, b)| a.to_bits() == b.to_bits());
                    assert!(same, "round {round}, {threads} threads, block ({row}, {column})");
                }
            }
            let missing = |column: usize| {
                fresh.pattern().column(column).any(|slot| {
                    matrix.pattern().slot(fresh.pattern().rows()[slot] as usize, column).is_none()
                })
            };
            assert!(!(0..fresh.pattern().columns()).any(missing), "round {round}");
        }
    }
}
