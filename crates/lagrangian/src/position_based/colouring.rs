//! Colouring constraints so that those of one colour share no particle.

/// Numbers of constraints, colour after colour, each colour in ascending order.
///
/// Greedy: each constraint, in order, takes the smallest colour that none of its particles has. No more colours are
/// used than one and the largest number of other constraints that any one meets.
///
/// Particles are numbered anew first, so that memory goes with how many are named, not with the largest number.
pub(super) fn coloured_order<const N: usize>(elements: &[[u32; N]]) -> Vec<u32> {
    let mut named = elements.as_flattened().to_vec();
    named.sort_unstable();
    named.dedup();
    let number = |particle: u32| named.partition_point(|&other| other < particle) as u32;
    let mut taken: Vec<Vec<u64>> = vec![Vec::new(); named.len()];
    let colours: Vec<u32> =
        elements.iter().map(|element| take_colour(&mut taken, &element.map(number))).collect();
    let mut order: Vec<u32> = (0..elements.len() as u32).collect();
    order.sort_by_key(|&element| colours[element as usize]);
    order
}

/// The smallest bit that is clear for all particles of an element; sets it.
fn take_colour<const N: usize>(taken: &mut [Vec<u64>], element: &[u32; N]) -> u32 {
    let at = |taken: &[Vec<u64>], particle: u32, word: usize| {
        taken[particle as usize].get(word).copied().unwrap_or(0)
    };
    let mut word = 0;
    loop {
        let used = element.iter().fold(0, |used, &particle| used | at(taken, particle, word));
        if used != u64::MAX {
            let bit = used.trailing_ones();
            for &particle in element {
                let bits = &mut taken[particle as usize];
                bits.resize(bits.len().max(word + 1), 0);
                bits[word] |= 1 << bit;
            }
            return 64 * word as u32 + bit;
        }
        word += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::coloured_order;

    /// A star of 200 springs needs 200 colours, a path two; neighbours in the order share nothing.
    #[test]
    fn constraints_of_one_colour_share_no_particle() {
        let star: Vec<[u32; 2]> = (1..=200).map(|i| [0, i]).collect();
        assert_eq!(coloured_order(&star), (0..200).collect::<Vec<u32>>());
        let path: Vec<[u32; 2]> = (0..7).map(|i| [i, i + 1]).collect();
        assert_eq!(coloured_order(&path), [0, 2, 4, 6, 1, 3, 5]);
        assert!(coloured_order::<2>(&[]).is_empty());
    }
}
