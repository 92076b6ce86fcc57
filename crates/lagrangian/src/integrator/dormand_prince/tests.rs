//! The coefficients against the order conditions.

#![allow(clippy::unwrap_used)]

use super::coefficients as tableau;
use super::*;
use std::collections::BTreeSet;

/// A rooted tree: its branches, sorted.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Tree(Vec<Tree>);

impl Tree {
    fn order(&self) -> usize {
        1 + self.0.iter().map(Self::order).sum::<usize>()
    }

    /// γ: the order times those of the branches.
    fn density(&self) -> f64 {
        self.order() as f64 * self.0.iter().map(Self::density).product::<f64>()
    }

    /// Φ_i at every stage: Π over branches of Σ_j a_ij Φ_j.
    fn weights(&self, a: &[[f64; 16]; 16]) -> [f64; 16] {
        let branches: Vec<[f64; 16]> = self.0.iter().map(|branch| branch.weights(a)).collect();
        std::array::from_fn(|i| {
            branches.iter().map(|of| a[i].iter().zip(of).map(|(a, x)| a * x).sum::<f64>()).product()
        })
    }
}

/// All rooted trees of at most `order` vertices: a leaf added at every vertex of the smaller ones.
fn trees(order: usize) -> BTreeSet<Tree> {
    fn grown(tree: &Tree) -> Vec<Tree> {
        let mut results = vec![Tree([tree.0.clone(), vec![Tree(Vec::new())]].concat())];
        for (k, branch) in tree.0.iter().enumerate() {
            for larger in grown(branch) {
                let mut branches = tree.0.clone();
                branches[k] = larger;
                results.push(Tree(branches));
            }
        }
        results.iter_mut().for_each(|tree| tree.0.sort());
        results
    }
    let mut all = BTreeSet::from([Tree(Vec::new())]);
    let mut newest = all.clone();
    for _ in 1..order {
        newest = newest.iter().flat_map(grown).collect();
        all.extend(newest.iter().cloned());
    }
    all
}

/// All weights, that of the first stage from their sum.
fn dense_row<const V: usize>(row: &[(usize, f64); V], sum: f64) -> [f64; 16] {
    let mut dense = [0.0; 16];
    dense[0] = sum - row.iter().map(|(_, weight)| weight).sum::<f64>();
    for &(j, weight) in row {
        dense[j] = weight;
    }
    dense
}

/// The nodes, the velocity weights and the position weights of all stages.
fn stages() -> ([f64; 16], [[f64; 16]; 16], [[f64; 16]; 16]) {
    let (mut nodes, mut a, mut squares) = ([0.0; 16], [[0.0; 16]; 16], [[0.0; 16]; 16]);
    macro_rules! fill {
        ($($index:expr => $row:ident,)*) => {$(
            nodes[$index] = tableau::$row.node;
            a[$index] = dense_row(&tableau::$row.velocity, nodes[$index]);
            squares[$index] = dense_row(&tableau::$row.position, tableau::$row.moment);
        )*};
    }
    fill! {
        1 => STAGE_2, 2 => STAGE_3, 3 => STAGE_4, 4 => STAGE_5, 5 => STAGE_6, 6 => STAGE_7, 7 => STAGE_8, 8 => STAGE_9,
        9 => STAGE_10, 10 => STAGE_11, 11 => STAGE_12, 12 => SOLUTION, 13 => STAGE_14, 14 => STAGE_15, 15 => STAGE_16,
    }
    (nodes, a, squares)
}

/// The largest |Σ b Φ − θ^order / γ| over trees of at most `order` vertices.
fn defect(b: &[f64; 16], theta: f64, order: usize) -> f64 {
    let (_, a, _) = stages();
    let of = |tree: &Tree| {
        let sum: f64 = b.iter().zip(tree.weights(&a)).map(|(b, phi)| b * phi).sum();
        (sum - theta.powi(tree.order() as i32) / tree.density()).abs()
    };
    trees(order).iter().map(of).fold(0.0, f64::max)
}

#[test]
fn there_are_as_many_trees_as_cayley_counted() {
    let counts: Vec<usize> =
        (1..=8).map(|n| trees(8).iter().filter(|tree| tree.order() == n).count()).collect();
    assert_eq!(counts, [1, 1, 2, 4, 9, 20, 48, 115]);
}

#[test]
fn the_solution_meets_all_order_conditions_up_to_eight() {
    let b = dense_row(&tableau::SOLUTION.velocity, 1.0);
    assert!(defect(&b, 1.0, 8) < 1e-14, "{:e}", defect(&b, 1.0, 8));
    assert!(defect(&b, 1.0, 9) > 1e-8, "a tenth order would be news");
}

#[test]
fn the_estimates_are_differences_to_orders_five_and_three() {
    let b = dense_row(&tableau::SOLUTION.velocity, 1.0);
    for (row, order) in
        [(dense_row(&tableau::ERROR_5.velocity, 0.0), 5), (dense_row(&tableau::ERROR_3.velocity, 0.0), 3)]
    {
        let embedded: [f64; 16] = std::array::from_fn(|i| b[i] - row[i]);
        assert!(defect(&embedded, 1.0, order) < 1e-14);
        assert!(defect(&embedded, 1.0, order + 1) > 1e-5);
    }
}

#[test]
fn position_weights_are_products() {
    let (_, a, squares) = stages();
    // The difference of a sum of products to its stored value, relative to what rounding may make of it: the first column holds
    // what is left of the others.
    let magnitude = |row: &[f64; 16]| row.iter().map(|x| x.abs()).sum::<f64>();
    let difference = |weights: &[f64; 16], j: usize, stored: f64| {
        let sum: f64 = (0..16).map(|k| weights[k] * a[k][j]).sum();
        let size: f64 = (0..16).map(|k| weights[k].abs() * (1.0 + magnitude(&a[k]))).sum();
        (sum - stored).abs() / size.max(1e-3)
    };
    for i in 0..16 {
        for j in 0..16 {
            assert!(difference(&a[i], j, squares[i][j]) < 1e-15, "entry {i}, {j}");
        }
    }
    let errors = [
        (dense_row(&tableau::ERROR_5.velocity, 0.0), dense_row(&tableau::ERROR_5.position, 0.0)),
        (dense_row(&tableau::ERROR_3.velocity, 0.0), dense_row(&tableau::ERROR_3.position, 0.0)),
    ];
    for (velocity, position) in errors {
        for j in 0..16 {
            assert!(difference(&velocity, j, position[j]) < 1e-15, "error weight {j}");
        }
    }
}

#[test]
fn the_dense_output_meets_all_order_conditions_up_to_seven() {
    // Its weights b_i(θ) are what it makes of unit slopes with Δy = b.
    let b = dense_row(&tableau::SOLUTION.velocity, 1.0);
    for theta in [0.1, 0.3, 0.5, 0.77, 0.95, 1.0] {
        let weights: [f64; 16] = std::array::from_fn(|stage| {
            let of = |index: usize| if index == stage { 1.0 } else { 0.0 };
            let differences = std::array::from_fn(|index| [of(index) - of(0)]);
            let r = interpolant([&[0.0], &[b[stage]]], [&[of(0)], &[of(12)]], &differences, 1.0);
            let step = DenseStep { start: 0.0, end: 1.0, q: r, v: r };
            step.at(theta).q[0]
        });
        assert!(defect(&weights, theta, 7) < 2e-13, "θ = {theta}: {:e}", defect(&weights, theta, 7));
    }
}
