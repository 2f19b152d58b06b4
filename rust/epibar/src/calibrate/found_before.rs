//! What was found by a clock nearly as good as the one of a time line.

use crate::recording::FramePair;
use crate::search::Solution;
use crate::verify::split::Split;

/// Geometries, best first, and the frames that they were searched and fitted with; none where nothing was found.
#[derive(Debug, Clone, Default)]
pub struct FoundBefore {
    /// The geometries.
    pub solutions: Vec<Solution>,
    /// The frames.
    pub fitted: Vec<FramePair>,
}

impl FoundBefore {
    /// The geometries, unless any of their frames lies in what `split` keeps aside of the `busy` ones: they would not be independent of the test.
    pub fn without_tested(&self, split: &Split, busy: &[FramePair]) -> &[Solution] {
        let is_tested = |pair: &FramePair| {
            split.tested.iter().any(|r| (busy[r.start].a..=busy[r.end - 1].a).contains(&pair.a))
        };
        if self.fitted.iter().any(is_tested) { &[] } else { &self.solutions }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Fundamental;
    use crate::hypotheses::Source;
    use crate::image::ImageSize;
    use crate::recording::RecordedFrame;
    use nalgebra::Vector3;

    #[test]
    fn what_was_fitted_to_frames_that_test_is_not_known() {
        let size = ImageSize::new(640, 480).unwrap();
        let matrix = Vector3::new(3.0, -1.0, 2.0).cross_matrix();
        let fundamental = Fundamental::from_matrix(&matrix, size, size).unwrap();
        let solution = Solution { fundamental, score: 1.0, chance: 0.0, source: Source::Floor };
        let pair = |a: u32| FramePair { a: RecordedFrame(a), b: RecordedFrame(a + 7) };
        let busy: Vec<FramePair> = (0..100).map(|k| pair(2 * k)).collect();
        let split = Split {
            fitted: Vec::new(),
            fitted_busy: Vec::new(),
            tested: std::iter::once(40..50).collect(),
            gap: 2,
            stay: 1,
        };
        let known = |fitted: &[u32]| {
            let fitted = fitted.iter().map(|&a| pair(a)).collect();
            FoundBefore { solutions: vec![solution], fitted }.without_tested(&split, &busy).len()
        };
        assert_eq!([known(&[0, 79, 99]), known(&[0, 78, 100]), known(&[])], [1, 1, 1]);
        assert_eq!([known(&[80]), known(&[98]), known(&[91])], [0, 0, 0]);
    }
}
