use super::dissection::nested_dissection;
use super::elimination::{Elimination, Numbering, UpperPattern};
use super::error::LinearError;
use super::supernodal::{SupernodalStructure, approximate_minimum_degree};
use super::{Ordering, Reuse};
use crate::sparse::BlockPattern;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// An old order is given up when it needs this many times the flops it needed for the pattern it was made for …
const TOLERATED_GROWTH: f64 = 1.5;

/// … and when the growth is worth more than this many flops for each stored block, about what ordering costs.
const ORDERING_FLOPS: f64 = 3e4;

/// A numbering and what it costs on a pattern.
#[derive(Debug)]
pub(super) struct Analysis {
    pub(super) pattern: Arc<BlockPattern>,
    pub(super) numbering: Numbering,
    pub(super) upper: UpperPattern,
    pub(super) flops: f64,
    pub(super) entries: usize,
    structure: std::sync::OnceLock<Arc<SupernodalStructure>>,
}

impl Analysis {
    /// The numbering `order` made a postorder of its own elimination tree, which changes no fill.
    fn new(pattern: &Arc<BlockPattern>, order: Numbering) -> Self {
        let tree = Elimination::new(&UpperPattern::renumbered(pattern, &order));
        let (flops, entries) = (tree.flops(), tree.entries());
        let old = tree.postorder().into_iter().map(|position| order.old[position as usize]).collect();
        let numbering = Numbering::from_old(old);
        let upper = UpperPattern::renumbered(pattern, &numbering);
        Self { pattern: pattern.clone(), numbering, upper, flops, entries, structure: Default::default() }
    }

    /// The supernodal structure, made when it is first needed.
    pub(super) fn structure(&self) -> Result<Arc<SupernodalStructure>, LinearError> {
        if let Some(structure) = self.structure.get() {
            return Ok(structure.clone());
        }
        let structure =
            Arc::new(SupernodalStructure::new(&self.pattern, &self.numbering, &self.upper, self.flops)?);
        Ok(self.structure.get_or_init(|| structure).clone())
    }
}

/// The analyses of a family of patterns: one order, kept while contacts only perturb the pattern.
#[derive(Debug, Default)]
pub(super) struct Family {
    current: Option<Arc<Analysis>>,
    /// What every step starts from, whatever was analysed before.
    base: Option<Arc<Analysis>>,
    /// The last order made from nothing but its pattern, with that pattern.
    fresh: Option<Arc<Analysis>>,
}

/// What an analysis cost.
#[derive(Clone, Copy, Debug)]
pub(super) struct AnalysisReport {
    pub(super) reuse: Reuse,
    pub(super) ordering_time: Duration,
}

impl Family {
    /// Analyses `pattern` now, for every step to start from.
    pub(super) fn start_from(&mut self, pattern: &Arc<BlockPattern>, ordering: Ordering) {
        let analysis = Arc::new(Analysis::new(pattern, order(pattern, ordering)));
        self.base = Some(analysis.clone());
        self.fresh = Some(analysis.clone());
        self.current = Some(analysis);
    }

    /// Forgets which patterns came before: the next order depends on its pattern alone, and on the base.
    pub(super) fn begin_step(&mut self) {
        self.current.clone_from(&self.base);
        if self.base.is_some() {
            self.fresh.clone_from(&self.base);
        }
    }

    /// The analysis of `pattern`. The same pattern (by address or by content) keeps everything; a pattern with the
    /// same number of columns keeps the order, as long as that costs at most [`TOLERATED_GROWTH`] times the flops
    /// of the pattern the order was made for, or the growth is not worth a new order.
    pub(super) fn analyse(
        &mut self,
        pattern: &Arc<BlockPattern>,
        ordering: Ordering,
    ) -> (Arc<Analysis>, AnalysisReport) {
        let mut reuse = Reuse::Nothing;
        if let Some(current) = &self.current {
            if Arc::ptr_eq(&current.pattern, pattern) || current.pattern == *pattern {
                let report = AnalysisReport { reuse: Reuse::Everything, ordering_time: Duration::ZERO };
                return (current.clone(), report);
            }
            if current.pattern.columns() == pattern.columns() {
                let perturbed = Analysis::new(pattern, current.numbering.clone());
                if self.keeps_order(&perturbed) {
                    let analysis = Arc::new(perturbed);
                    self.current = Some(analysis.clone());
                    return (analysis, AnalysisReport { reuse: Reuse::Order, ordering_time: Duration::ZERO });
                }
                reuse = Reuse::OrderGivenUp;
            }
        } else if let Some(fresh) = self.fresh.as_ref().filter(|fresh| fresh.pattern == *pattern) {
            self.current = Some(fresh.clone());
            let report = AnalysisReport { reuse: Reuse::Everything, ordering_time: Duration::ZERO };
            return (fresh.clone(), report);
        }
        let start = Instant::now();
        let order = order(pattern, ordering);
        let ordering_time = start.elapsed();
        let analysis = Arc::new(Analysis::new(pattern, order));
        self.fresh = Some(analysis.clone());
        self.current = Some(analysis.clone());
        (analysis, AnalysisReport { reuse, ordering_time })
    }

    fn keeps_order(&self, perturbed: &Analysis) -> bool {
        let fresh_flops = self.fresh.as_ref().map_or(0.0, |fresh| fresh.flops);
        let growth = perturbed.flops - fresh_flops;
        perturbed.flops <= TOLERATED_GROWTH * fresh_flops
            || growth <= ORDERING_FLOPS * perturbed.pattern.block_count() as f64
    }
}

/// A fresh numbering.
pub(super) fn order(pattern: &BlockPattern, ordering: Ordering) -> Numbering {
    match ordering {
        Ordering::FewestFlops => {
            let candidates = [nested_dissection(pattern), approximate_minimum_degree(pattern)];
            let [dissection, degree] = candidates.map(Numbering::from_old);
            let flops = |order| Elimination::new(&UpperPattern::renumbered(pattern, order)).flops();
            if flops(&degree) < flops(&dissection) { degree } else { dissection }
        }
        Ordering::NestedDissection => Numbering::from_old(nested_dissection(pattern)),
        Ordering::MinimumDegree => Numbering::from_old(approximate_minimum_degree(pattern)),
        Ordering::Natural => Numbering::identity(pattern.columns()),
    }
}

/// What a complete factorisation would cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FactorPrediction {
    /// Multiplications and additions.
    pub flops: f64,
    /// Scalar entries of the factor.
    pub entries: usize,
    /// Time to order the graph.
    pub ordering_time: Duration,
}

/// Orders a pattern and counts what its factorisation would cost, without any numbers.
pub fn predict_factor(pattern: &Arc<BlockPattern>, ordering: Ordering) -> FactorPrediction {
    let start = Instant::now();
    let order = order(pattern, ordering);
    let ordering_time = start.elapsed();
    let tree = Elimination::new(&UpperPattern::renumbered(pattern, &order));
    FactorPrediction { flops: tree.flops(), entries: tree.entries(), ordering_time }
}
