//! CRC-64/XZ, eight bytes at a time.

/// The generator polynomial of ECMA-182, bits reversed.
const POLYNOMIAL: u64 = 0xC96C_5795_D787_0F42;

/// `TABLES[k][b]` advances the register by byte `b` followed by `k` zero bytes.
static TABLES: [[u64; 256]; 8] = tables();

/// The 64-bit cyclic redundancy check CRC-64/XZ of `bytes`: generator 0x42F0E1EBA9EA3693 (ECMA-182), reflected,
/// initial value and final complement all ones. Of the nine ASCII digits `123456789` it is `0x995DC9BBDF1939FA`.
///
/// Any change confined to 64 consecutive bits changes the result; any other damage goes unnoticed with probability
/// 2⁻⁶⁴. It guards against accidents, not against an adversary.
///
/// # Reference
/// Ross N. Williams, *A painless guide to CRC error detection algorithms*, 1993 (the parameter model); ECMA-182,
/// 1992, annex B (the polynomial); Kounavis and Berry 2008, *Novel table lookup-based algorithms for
/// high-performance CRC generation* (eight tables).
pub fn crc64(bytes: &[u8]) -> u64 {
    !update(!0, bytes)
}

/// The register after `bytes`, from the register before: start with all ones, complement at the end.
pub(crate) fn update(mut register: u64, bytes: &[u8]) -> u64 {
    let (words, rest) = bytes.as_chunks::<8>();
    for word in words {
        let mixed = register ^ u64::from_le_bytes(*word);
        // Written out: a loop over the eight tables runs at a fraction of the speed.
        let table = |k: usize| TABLES[7 - k][(mixed >> (8 * k)) as usize & 0xFF];
        register =
            ((table(0) ^ table(1)) ^ (table(2) ^ table(3))) ^ ((table(4) ^ table(5)) ^ (table(6) ^ table(7)));
    }
    for &byte in rest {
        register = (register >> 8) ^ TABLES[0][((register as u8) ^ byte) as usize];
    }
    register
}

const fn tables() -> [[u64; 256]; 8] {
    let mut tables = [[0; 256]; 8];
    let mut byte = 0;
    while byte < 256 {
        tables[0][byte] = after_byte(byte as u64);
        byte += 1;
    }
    let mut k = 1;
    while k < 8 {
        let mut byte = 0;
        while byte < 256 {
            let register = tables[k - 1][byte];
            tables[k][byte] = (register >> 8) ^ tables[0][(register & 0xFF) as usize];
            byte += 1;
        }
        k += 1;
    }
    tables
}

/// The polynomial division of one byte, bit by bit.
const fn after_byte(byte: u64) -> u64 {
    let mut register = byte;
    let mut bit = 0;
    while bit < 8 {
        register = (register >> 1) ^ ((register & 1) * POLYNOMIAL);
        bit += 1;
    }
    register
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition, one bit at a time.
    fn bitwise(bytes: &[u8]) -> u64 {
        let mut register = !0u64;
        for &byte in bytes {
            register ^= u64::from(byte);
            for _ in 0..8 {
                let carry = register & 1;
                register = (register >> 1) ^ (carry * POLYNOMIAL);
            }
        }
        !register
    }

    #[test]
    fn agrees_with_the_published_check_value() {
        assert_eq!(crc64(b"123456789"), 0x995D_C9BB_DF19_39FA);
        assert_eq!(crc64(b""), 0);
    }

    #[test]
    fn agrees_with_the_definition_at_every_length_and_alignment() {
        let bytes: Vec<u8> = (0..100u32).map(|i| (i * i * 37 + 11) as u8).collect();
        for start in 0..8 {
            for end in start..bytes.len() {
                assert_eq!(crc64(&bytes[start..end]), bitwise(&bytes[start..end]), "{start}..{end}");
            }
        }
    }

    #[test]
    fn pieces_give_the_same_as_the_whole() {
        let bytes: Vec<u8> = (0..64u8).collect();
        for cut in 0..=64 {
            let pieces = !update(update(!0, &bytes[..cut]), &bytes[cut..]);
            assert_eq!(pieces, crc64(&bytes), "cut at {cut}");
        }
    }
}
