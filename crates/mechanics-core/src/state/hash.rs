//! A fingerprint of named arrays.

use crate::checksum;
use crate::tensor::Vec3;

/// A 64-bit fingerprint of named arrays of numbers, the same on every machine for the same bits.
///
/// Two runs agree when their fingerprints do: for another number of threads, after a resume. It is the CRC-64/XZ
/// (see [`crc64`](crate::checkpoint::crc64)) of a byte string in which every array stands as the length of its name
/// (u64), the name, the number of values (u64), and the values, little-endian. So the names, the order of the
/// arrays, and the order of the values count, and values cannot move from one array to the next unnoticed. Two
/// arrays that differ in a single number always differ in their fingerprint; otherwise a coincidence has
/// probability 2⁻⁶⁴.
///
/// Numbers count by their bits: −0 and +0 differ, because later results may (1/x, atan2). All NaN count as one,
/// because IEEE 754 leaves their sign and payload to the machine.
///
/// ```
/// use mechanics_core::state::StateHash;
///
/// let mut hash = StateHash::new();
/// hash.add("energy", &[1.0, 2.0]);
/// let forward = hash.value();
/// let mut hash = StateHash::new();
/// hash.add("energy", &[2.0, 1.0]);
/// assert_ne!(hash.value(), forward);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StateHash {
    register: u64,
}

impl StateHash {
    /// The fingerprint of nothing, to be added to.
    pub fn new() -> Self {
        Self { register: !0 }
    }

    /// Adds an array of numbers.
    pub fn add(&mut self, name: &str, values: &[f64]) {
        self.begin(name, values.len());
        for &value in values {
            self.number(value);
        }
    }

    /// Adds an array of vectors, as [`add`](Self::add) does with their components one after the other.
    pub fn add_vectors(&mut self, name: &str, values: &[Vec3]) {
        self.begin(name, 3 * values.len());
        for value in values.iter().flatten() {
            self.number(*value);
        }
    }

    /// Adds an array of integers: a step's index, iteration counts, the state of a random generator.
    pub fn add_integers(&mut self, name: &str, values: &[u64]) {
        self.begin(name, values.len());
        for &value in values {
            self.word(value);
        }
    }

    /// The fingerprint of what was added so far.
    pub fn value(&self) -> u64 {
        !self.register
    }

    fn begin(&mut self, name: &str, count: usize) {
        self.word(name.len() as u64);
        self.register = checksum::update(self.register, name.as_bytes());
        self.word(count as u64);
    }

    fn number(&mut self, value: f64) {
        self.word(if value.is_nan() { f64::NAN.to_bits() } else { value.to_bits() });
    }

    fn word(&mut self, word: u64) {
        self.register = checksum::update(self.register, &word.to_le_bytes());
    }
}

impl Default for StateHash {
    fn default() -> Self {
        Self::new()
    }
}
