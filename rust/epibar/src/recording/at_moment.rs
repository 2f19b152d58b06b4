//! Which silhouettes there are at a moment between two frames.

/// A silhouette at a moment: a share of the way from one in a frame to the one in the next that is the same object. One that
/// is not followed stands still.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Between<H> {
    /// The silhouette in the frame before (or at) the moment.
    pub first: H,
    /// The silhouette in the frame after; `first` where it stands still.
    pub last: H,
    /// Of the way from `first` to `last`, 0 to below 1.
    pub share: f64,
}

/// The silhouettes at a moment a `share` of the way from the frame of `here` to that of `there`. `next` and `previous` follow one
/// to the other frame; one that is not followed stands still in the nearer.
pub fn at_moment<H: Copy>(
    here: impl Iterator<Item = H>,
    there: impl Iterator<Item = H>,
    next: impl Fn(H) -> Option<H>,
    previous: impl Fn(H) -> Option<H>,
    share: f64,
) -> impl Iterator<Item = Between<H>> {
    let still = |h: H| Between { first: h, last: h, share: 0.0 };
    let known = here.filter_map(move |first| match next(first) {
        Some(last) if share > 0.0 => Some(Between { first, last, share }),
        _ => (share < 0.5).then(|| still(first)),
    });
    known.chain(there.filter(move |&h| share >= 0.5 && previous(h).is_none()).map(still))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_followed_stands_still_in_the_nearer_frame() {
        // 0 goes on as 10; 1 is lost, and 11 is new.
        let seen = |share| -> Vec<(u32, u32, f64)> {
            let next = |h| (h == 0).then_some(10);
            let previous = |h| (h == 10).then_some(0);
            let all = at_moment([0, 1].into_iter(), [10, 11].into_iter(), next, previous, share);
            all.map(|b| (b.first, b.last, b.share)).collect()
        };
        assert_eq!(seen(0.0), [(0, 0, 0.0), (1, 1, 0.0)]);
        assert_eq!(seen(0.25), [(0, 10, 0.25), (1, 1, 0.0)]);
        assert_eq!(seen(0.5), [(0, 10, 0.5), (11, 11, 0.0)]);
    }
}
