//! A finished block of a recording that goes on: its words as a deflate stream, a ninth to a third of their bytes.
//!
//! Of a day nearly all memory would be barcodes, and mostly nothing changes on a line from one frame to the next.

use super::barcode_words::BLOCK_WORDS;
use flate2::Compression;
use flate2::write::{DeflateDecoder, DeflateEncoder};
use std::io::Write;

/// 256 frames of every line.
#[derive(Debug, Clone)]
pub struct PackedBlock(Box<[u8]>);

impl PackedBlock {
    /// Packs the words of a block, line after line.
    pub fn new(lines: &[[u64; BLOCK_WORDS]]) -> Self {
        let mut packer = DeflateEncoder::new(Vec::new(), Compression::fast());
        for words in lines {
            packer
                .write_all(words.map(u64::to_le_bytes).as_flattened())
                .expect("memory takes what is written");
        }
        Self(packer.finish().expect("memory takes what is written").into_boxed_slice())
    }

    /// The words again.
    pub fn lines(&self) -> Vec<[u64; BLOCK_WORDS]> {
        let mut unpacker = DeflateDecoder::new(Vec::new());
        unpacker.write_all(&self.0).expect("a stream that was packed here");
        let bytes = unpacker.finish().expect("a stream that was packed here");
        let lines = bytes.as_chunks::<{ BLOCK_WORDS * size_of::<u64>() }>().0.iter();
        lines.map(|line| std::array::from_fn(|k| u64::from_le_bytes(line.as_chunks().0[k]))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::generator;
    use rand::Rng;

    #[test]
    fn words_come_back_and_stillness_takes_no_memory() {
        let mut random = generator(7, 0);
        let noise: Vec<[u64; BLOCK_WORDS]> =
            (0..1000).map(|_| std::array::from_fn(|_| random.next_u64())).collect();
        assert_eq!(PackedBlock::new(&noise).lines(), noise);
        let mut still = vec![[0; BLOCK_WORDS]; 1000];
        still[999][BLOCK_WORDS - 1] = u64::MAX << 63;
        let packed = PackedBlock::new(&still);
        assert_eq!(packed.lines(), still);
        assert!(packed.0.len() < 400, "{}", packed.0.len());
        assert_eq!(PackedBlock::new(&[]).lines(), Vec::<[u64; BLOCK_WORDS]>::new());
    }
}
