//! Finished blocks of a recording that goes on: their words as deflate streams, a tenth to two fifths of their bytes.
//!
//! Of a day nearly all memory would be barcodes, and mostly nothing changes on a line from one frame to the next.

use super::barcode_words::BLOCK_WORDS;
use flate2::Compression;
use flate2::write::{DeflateDecoder, DeflateEncoder};
use std::io::Write;

/// Blocks one after the other, each with its 256 frames of every line. One allocation for all: many that stay, between those that
/// come and go with frames, would keep memory in pieces.
#[derive(Debug, Clone, Default)]
pub struct PackedBlocks {
    bytes: Vec<u8>,
    /// Where each block ends.
    ends: Vec<usize>,
}

impl PackedBlocks {
    /// Adds the words of a block, line after line.
    pub fn push(&mut self, lines: &[[u64; BLOCK_WORDS]]) {
        let mut packer = DeflateEncoder::new(&mut self.bytes, Compression::default());
        for words in lines {
            packer
                .write_all(words.map(u64::to_le_bytes).as_flattened())
                .expect("memory takes what is written");
        }
        packer.finish().expect("memory takes what is written");
        self.ends.push(self.bytes.len());
    }

    /// The words of each block again.
    pub fn iter(&self) -> impl Iterator<Item = Vec<[u64; BLOCK_WORDS]>> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| {
            let mut unpacker = DeflateDecoder::new(Vec::new());
            unpacker.write_all(&self.bytes[start..end]).expect("a stream that was packed here");
            let bytes = unpacker.finish().expect("a stream that was packed here");
            let lines = bytes.as_chunks::<{ BLOCK_WORDS * size_of::<u64>() }>().0.iter();
            lines.map(|line| std::array::from_fn(|k| u64::from_le_bytes(line.as_chunks().0[k]))).collect()
        })
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
        let mut still = vec![[0; BLOCK_WORDS]; 1000];
        still[999][BLOCK_WORDS - 1] = u64::MAX << 63;
        let mut packed = PackedBlocks::default();
        packed.push(&still);
        assert!(packed.bytes.len() < 400, "{}", packed.bytes.len());
        packed.push(&noise);
        packed.push(&[]);
        packed.push(&still);
        assert_eq!(packed.iter().collect::<Vec<_>>(), [still.clone(), noise, vec![], still]);
        assert_eq!(PackedBlocks::default().iter().count(), 0);
    }
}
