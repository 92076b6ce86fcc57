use super::graph::Graph;

/// Numbers the nodes `names` of `whole` by exact minimum degree; their neighbours outside count in the degrees but
/// are not numbered. Rows of the elimination graph are bit sets, so a step costs degree × size / 64.
pub(super) fn order(whole: &Graph, names: &[u32]) -> Vec<u32> {
    let mut eliminator = Eliminator::new(whole, names);
    (0..names.len()).map(|_| names[eliminator.eliminate_next()]).collect()
}

struct Eliminator {
    /// Words of a row.
    words: usize,
    /// Neighbours of each node to be numbered, itself excluded: bit k for node k, the outside after them.
    rows: Vec<u64>,
    degrees: Vec<u32>,
    remaining: Vec<u32>,
}

impl Eliminator {
    fn new(whole: &Graph, names: &[u32]) -> Self {
        let nodes = names.len();
        let mut sorted: Vec<(u32, u32)> = names.iter().zip(0..).map(|(&name, place)| (name, place)).collect();
        sorted.sort_unstable();
        let inside = |name: u32| sorted.binary_search_by_key(&name, |pair| pair.0).ok().map(|k| sorted[k].1);
        let neighbours = || names.iter().flat_map(|&name| whole.neighbours(name as usize));
        let mut outside: Vec<u32> = neighbours().copied().filter(|&name| inside(name).is_none()).collect();
        outside.sort_unstable();
        outside.dedup();
        let words = (nodes + outside.len()).div_ceil(64);
        let mut rows = vec![0u64; words * nodes];
        for (node, &name) in names.iter().enumerate() {
            for &next in whole.neighbours(name as usize) {
                let bit = match inside(next) {
                    Some(place) => place as usize,
                    None => nodes + outside.partition_point(|&other| other < next),
                };
                rows[node * words + bit / 64] |= 1 << (bit % 64);
            }
        }
        let degrees = (0..nodes).map(|node| count(&rows[node * words..(node + 1) * words])).collect();
        Self { words, rows, degrees, remaining: (0..nodes as u32).collect() }
    }

    /// Eliminates the node of least degree, the first one of equals.
    fn eliminate_next(&mut self) -> usize {
        let degree = |&(_, &node): &(usize, &u32)| self.degrees[node as usize];
        let (place, pivot) = match self.remaining.iter().enumerate().min_by_key(degree) {
            Some((place, &pivot)) => (place, pivot as usize),
            None => return 0,
        };
        self.remaining.remove(place);
        let words = self.words;
        let clique: Vec<u64> = self.rows[pivot * words..(pivot + 1) * words].to_vec();
        let pivot_bit = !(1u64 << (pivot % 64));
        for &node in &self.remaining {
            let node = node as usize;
            if clique[node / 64] >> (node % 64) & 1 == 0 {
                continue;
            }
            let row = &mut self.rows[node * words..(node + 1) * words];
            for (own, other) in row.iter_mut().zip(&clique) {
                *own |= other;
            }
            row[node / 64] &= !(1u64 << (node % 64));
            row[pivot / 64] &= pivot_bit;
            self.degrees[node] = count(row);
        }
        pivot
    }
}

fn count(row: &[u64]) -> u32 {
    row.iter().map(|word| word.count_ones()).sum()
}
