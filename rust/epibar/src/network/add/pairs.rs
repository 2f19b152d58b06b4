//! Which pairs of new and stored cameras are worth a search.

use rayon::prelude::*;

use crate::error::Result;
use crate::network::check::refused;
use crate::network::given::clocks::{Offsets, likeness};
use crate::recording::Recording;

/// Pairs that are searched of each new camera: one right one puts it where it stands, and all others then have their say by tangents.
const EACH: usize = 4;

/// The pairs `a < b` of a stored and a new camera that are searched: all with few stored cameras, of many those that are likeliest to see
/// the same. The first `stored` recordings are those of stored cameras.
///
/// # Errors
/// [`Error::Argument`](crate::Error::Argument) where there is not an offset for each camera.
pub fn pairs_to_add(
    recordings: &[&Recording],
    stored: usize,
    offsets: &Offsets,
) -> Result<Vec<(usize, usize)>> {
    let n = recordings.len();
    if offsets.seconds.len() != n {
        return refused("offsets", offsets.seconds.len().to_string(), "an offset for each camera");
    }
    let mut chosen = Vec::new();
    for new in stored.min(n)..n {
        let between = |a: usize| offsets.seconds[new] - offsets.seconds[a];
        let filmed = |&a: &usize| offsets.overlap(a, new, recordings[a], recordings[new]);
        let reachable: Vec<usize> = (0..stored).filter(filmed).collect();
        let mut likely: Vec<(f64, usize)> = if reachable.len() <= EACH {
            reachable.into_iter().map(|a| (0.0, a)).collect()
        } else {
            let of = |&a: &usize| Ok((likeness(recordings[a], recordings[new], between(a))?, a));
            reachable.par_iter().map(of).collect::<Result<_>>()?
        };
        likely.sort_by(|p, q| q.0.total_cmp(&p.0).then(p.1.cmp(&q.1)));
        chosen.extend(likely.into_iter().take(EACH).map(|(_, a)| (a, new)));
    }
    chosen.sort_unstable();
    Ok(chosen)
}
