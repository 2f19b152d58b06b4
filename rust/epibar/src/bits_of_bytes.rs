//! Answers of vectorised loops, one byte each, as the bits of a word, and the ones of a word.

/// The bits of eight bytes that are 0 or 1, the lowest byte's lowest.
#[inline(always)]
pub(crate) fn gathered(bytes: u64) -> u64 {
    // Byte `j` lands on bit 56 + j.
    bytes.wrapping_mul(0x0102_0408_1020_4080) >> 56
}

/// The bits of bytes that are 0 or 1.
#[inline(always)]
pub(crate) fn word_of(bytes: &[u8; 64]) -> u64 {
    let eights = bytes.as_chunks::<8>().0.iter().enumerate();
    eights.fold(0, |word, (k, eight)| word | gathered(u64::from_le_bytes(*eight)) << (8 * k))
}

/// Places of the ones of a word, lowest first.
#[inline(always)]
pub(crate) fn ones_of(mut word: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = (word != 0).then(|| word.trailing_zeros() as usize);
        word &= word.wrapping_sub(1);
        place
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_become_bits_and_bits_places() {
        let places = [0, 1, 7, 8, 30, 31, 56, 63];
        let mut bytes = [0; 64];
        for place in places {
            bytes[place] = 1;
        }
        assert!(ones_of(word_of(&bytes)).eq(places));
        assert_eq!((word_of(&[0; 64]), word_of(&[1; 64])), (0, u64::MAX));
        assert_eq!(ones_of(0).count(), 0);
    }
}
