//! What tells lists of elements from others without keeping them.

use crate::checksum;

/// Bytes passed on at a time.
const BUFFER: usize = 4096;

/// The CRC-64 of lists of elements.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fingerprint {
    register: u64,
}

impl Default for Fingerprint {
    fn default() -> Self {
        Self { register: !0 }
    }
}

impl Fingerprint {
    pub(super) fn add_term(&mut self, term: usize) {
        self.add(&[u32::MAX, term as u32]);
    }

    pub(super) fn add_list(&mut self, corners: usize, points: &[u32]) {
        self.add(&[corners as u32, (points.len() / corners.max(1)) as u32]);
        self.add(points);
    }

    pub(super) fn value(self) -> u64 {
        !self.register
    }

    fn add(&mut self, words: &[u32]) {
        let mut bytes = [0; BUFFER];
        for words in words.chunks(BUFFER / 4) {
            for (bytes, word) in bytes.as_chunks_mut::<4>().0.iter_mut().zip(words) {
                *bytes = word.to_le_bytes();
            }
            self.register = checksum::update(self.register, &bytes[..4 * words.len()]);
        }
    }
}
