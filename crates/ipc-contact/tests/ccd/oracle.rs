//! Contact of two moving features decided in exact arithmetic.
//!
//! The features meet at a time t when all four points are in a plane, a root of the cubic C(t) = [ b × c, d ] of three
//! differences, at which the meeting point lies within both. With integer coordinates (every f64 is one, times a common
//! power of two) C and the quartics of the inside test have integer coefficients. Their Bernstein coefficients over a
//! time interval bound them; halving an interval (de Casteljau) keeps them integers. No number is ever rounded.

use crate::planted::Pair;
use mechanics_core::tensor::Vec3;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

/// What is known for certain.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Truth {
    Free,
    /// The first contact lies between these times, closed.
    Contact([f64; 2]),
    /// Neither proved: the features graze, or stay in a plane.
    Undecided,
}

type Polynomial = Vec<BigInt>;
type PolynomialVector = [Polynomial; 3];

fn multiply(a: &Polynomial, b: &Polynomial) -> Polynomial {
    let mut product = vec![BigInt::zero(); a.len() + b.len() - 1];
    for (i, p) in a.iter().enumerate() {
        for (j, q) in b.iter().enumerate() {
            product[i + j] += p * q;
        }
    }
    product
}

fn subtract(a: &Polynomial, b: &Polynomial) -> Polynomial {
    a.iter().zip(b).map(|(p, q)| p - q).collect()
}

fn cross(a: &PolynomialVector, b: &PolynomialVector) -> PolynomialVector {
    let minor = |i: usize, j: usize| subtract(&multiply(&a[i], &b[j]), &multiply(&a[j], &b[i]));
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn dot(a: &PolynomialVector, b: &PolynomialVector) -> Polynomial {
    let terms = [0, 1, 2].map(|c| multiply(&a[c], &b[c]));
    (0..terms[0].len()).map(|i| &terms[0][i] + &terms[1][i] + &terms[2][i]).collect()
}

/// Mantissa and exponent: the value is mantissa · 2^exponent, exactly.
fn parts(x: f64) -> (i64, i32) {
    let bits = x.to_bits();
    let exponent = ((bits >> 52) & 0x7FF) as i32;
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let mantissa = if exponent == 0 { fraction << 1 } else { fraction | 1 << 52 };
    (if x < 0.0 { -mantissa } else { mantissa }, exponent - 1075)
}

/// All coordinates times a common power of two.
fn integers(points: &[Vec3]) -> Vec<[BigInt; 3]> {
    let least =
        points.iter().flat_map(|p| p.iter()).filter(|c| **c != 0.0).map(|c| parts(*c).1).min().unwrap_or(0);
    let integer = |x: f64| {
        let (mantissa, exponent) = parts(x);
        if mantissa == 0 { BigInt::zero() } else { BigInt::from(mantissa) << (exponent - least) as usize }
    };
    points.iter().map(|p| [integer(p.x), integer(p.y), integer(p.z)]).collect()
}

/// Bernstein coefficients over [0, 1], times the factorial of the degree.
fn bernstein(a: &Polynomial) -> Polynomial {
    let n = a.len() - 1;
    let binomial = |n: usize, k: usize| (0..k).fold(BigInt::one(), |b, i| b * (n - i) / (i + 1));
    let factorial: BigInt = (1..=n).map(BigInt::from).product();
    (0..=n).map(|i| (0..=i).map(|j| &a[j] * binomial(i, j) * &factorial / binomial(n, j)).sum()).collect()
}

/// Coefficients over both halves, times 2^degree.
fn halve(b: &Polynomial) -> [Polynomial; 2] {
    let n = b.len() - 1;
    let (mut left, mut right) = (vec![BigInt::zero(); n + 1], vec![BigInt::zero(); n + 1]);
    let mut row = b.clone();
    for i in 0..=n {
        left[i] = row[0].clone() << (n - i);
        right[n - i] = row[n - i].clone() << (n - i);
        row = (0..n - i).map(|j| &row[j] + &row[j + 1]).collect();
    }
    [left, right]
}

/// The coplanarity cubic, and quartics that are positive when the meeting point is inside.
struct Conditions {
    coplanar: Polynomial,
    inside: Vec<Polynomial>,
}

impl Conditions {
    fn new(pair: Pair, start: &[Vec3; 4], end: &[Vec3; 4]) -> Self {
        let all: Vec<Vec3> = start.iter().chain(end).copied().collect();
        let x = integers(&all);
        // The difference of points i and j as a polynomial of t.
        let between = |i: usize, j: usize| -> PolynomialVector {
            [0, 1, 2].map(|c| {
                let (from, to) = (&x[i][c] - &x[j][c], &x[i + 4][c] - &x[j + 4][c]);
                vec![from.clone(), to - from]
            })
        };
        let (coplanar, inside) = match pair {
            Pair::PointTriangle => {
                let normal = cross(&between(2, 1), &between(3, 1));
                let corners = [between(1, 0), between(2, 0), between(3, 0)];
                let areas = [0, 1, 2].map(|k| dot(&normal, &cross(&corners[k], &corners[(k + 1) % 3])));
                (dot(&normal, &corners[0]), areas.to_vec())
            }
            Pair::PointPoint | Pair::PointEdge => panic!("a contact of smaller features is a matter of luck"),
            Pair::EdgeEdge => {
                let (a, b, r) = (between(1, 0), between(3, 2), between(2, 0));
                let normal = cross(&a, &b);
                let square = dot(&normal, &normal);
                let on = [dot(&normal, &cross(&r, &b)), dot(&normal, &cross(&r, &a))];
                let rest = [subtract(&square, &on[0]), subtract(&square, &on[1])];
                (dot(&normal, &r), on.into_iter().chain(rest).collect())
            }
        };
        Self { coplanar: bernstein(&coplanar), inside: inside.iter().map(bernstein).collect() }
    }

    fn halves(&self) -> [Self; 2] {
        let [left, right] = halve(&self.coplanar);
        let (lefts, rights) = self.inside.iter().map(|p| halve(p).into()).unzip();
        [Self { coplanar: left, inside: lefts }, Self { coplanar: right, inside: rights }]
    }

    fn is_impossible(&self) -> bool {
        let negative = |p: &Polynomial| p.iter().all(Signed::is_negative);
        negative(&self.coplanar)
            || self.coplanar.iter().all(Signed::is_positive)
            || self.inside.iter().any(negative)
    }

    /// A root in the closed interval, and inside throughout.
    fn is_certain(&self) -> bool {
        let (first, last) = (&self.coplanar[0], &self.coplanar[3]);
        let changes_sign =
            !(first.is_positive() && last.is_positive() || first.is_negative() && last.is_negative());
        changes_sign && self.inside.iter().all(|p| p.iter().all(Signed::is_positive))
    }
}

/// Halvings at most; the interval is as short as the spacing of f64 below 1 then.
const DEPTH: i32 = 52;

/// Decides for a triangle or two edges whether the features of a query meet, and when first.
pub(crate) fn contact(pair: Pair, start: &[Vec3; 4], end: &[Vec3; 4]) -> Truth {
    let mut budget = 4_000;
    search(Conditions::new(pair, start, end), 0.0, 0, &mut budget)
}

fn search(conditions: Conditions, from: f64, depth: i32, budget: &mut u32) -> Truth {
    let width = 0.5_f64.powi(depth);
    if conditions.is_impossible() {
        return Truth::Free;
    }
    *budget = budget.saturating_sub(1);
    if depth == DEPTH || *budget == 0 {
        return if conditions.is_certain() { Truth::Contact([from, from + width]) } else { Truth::Undecided };
    }
    let certain = conditions.is_certain();
    let [left, right] = conditions.halves();
    let answer = match search(left, from, depth + 1, budget) {
        Truth::Free => search(right, from + 0.5 * width, depth + 1, budget),
        decided => decided,
    };
    // Something happens in this interval, though not surely in either half.
    if certain && answer == Truth::Undecided { Truth::Contact([from, from + width]) } else { answer }
}

/// Distance of the planes or lines that two features span, from exact parameters, if the foot is inside both: where
/// edges are so nearly parallel that plain floating point knows nothing of it.
pub(crate) fn inner_distance(pair: Pair, x: &[Vec3; 4]) -> Option<f64> {
    type Vector = [BigRational; 3];
    let exact = |k: usize| -> Vector { [0, 1, 2].map(|c| BigRational::from_float(x[k][c]).unwrap()) };
    let minus = |a: &Vector, b: &Vector| -> Vector { [0, 1, 2].map(|c| &a[c] - &b[c]) };
    let dot = |a: &Vector, b: &Vector| (0..3).map(|c| &a[c] * &b[c]).sum::<BigRational>();
    let [a, b, c, d] = [0, 1, 2, 3].map(exact);
    let (r, e, f) = match pair {
        Pair::EdgeEdge => (minus(&c, &a), minus(&b, &a), minus(&c, &d)),
        _ => (minus(&a, &b), minus(&c, &b), minus(&d, &b)),
    };
    let (ee, ef, ff, re, rf) = (dot(&e, &e), dot(&e, &f), dot(&f, &f), dot(&r, &e), dot(&r, &f));
    let determinant = &ee * &ff - &ef * &ef;
    if determinant.is_zero() {
        return None;
    }
    let (s, t) = ((&ff * &re - &ef * &rf) / &determinant, (&ee * &rf - &ef * &re) / &determinant);
    let within = match pair {
        Pair::EdgeEdge => s <= BigRational::one() && t <= BigRational::one(),
        _ => &s + &t <= BigRational::one(),
    };
    let left: Vector = [0, 1, 2].map(|c| &r[c] - &s * &e[c] - &t * &f[c]);
    let inside = within && !s.is_negative() && !t.is_negative();
    inside.then(|| dot(&left, &left).to_f64().unwrap().sqrt())
}
