//! The graph of pairs: which are searched for.

/// Up to so many cameras, all pairs are searched, and asked for their clocks.
pub const ALL_PAIRS: usize = 6;
/// Pairs that each of more cameras is part of, where there are so many that are likely.
const EACH: usize = 5;
/// Pairs beyond those that a camera may have to help one that has too few.
const TO_HELP: usize = 2;
/// Pairs for each camera, at most.
const MOST: usize = 3;

/// All pairs `a < b` of so many cameras.
pub fn all_pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |a| (a + 1..count).map(move |b| (a, b)))
}

/// Which pairs of cameras to search, by how likely each pair is to show the same, a score for each: all pairs of few
/// cameras; of many the tree of the likeliest, further ones while both cameras have too few, and then the likeliest ones of
/// the camera that has the fewest. About `5/2` for each camera and never more than 3, however many there are.
pub fn chosen(count: usize, likeness: &[(usize, usize, f64)]) -> Vec<(usize, usize)> {
    if count <= ALL_PAIRS {
        return all_pairs(count).collect();
    }
    let mut order: Vec<&(usize, usize, f64)> = likeness.iter().collect();
    order.sort_by(|p, q| q.2.total_cmp(&p.2).then((p.0, p.1).cmp(&(q.0, q.1))));
    let order: Vec<(usize, usize)> = order.into_iter().map(|&(a, b, _)| (a, b)).collect();
    let mut group: Vec<usize> = (0..count).collect();
    let mut taken = Taken { pairs: Vec::new(), degree: vec![0; count] };
    for &(a, b) in &order {
        if group[a] != group[b] {
            let (one, other) = (group[a], group[b]);
            group.iter_mut().filter(|g| **g == other).for_each(|g| *g = one);
            taken.take(a, b);
        }
    }
    for &(a, b) in &order {
        if taken.degree[a] < EACH && taken.degree[b] < EACH && !taken.pairs.contains(&(a, b)) {
            taken.take(a, b);
        }
    }
    let mut hopeless = vec![false; count];
    while taken.pairs.len() < MOST * count {
        let poor = (0..count).filter(|&c| !hopeless[c] && taken.degree[c] < EACH);
        let Some(poorest) = poor.min_by_key(|&c| taken.degree[c]) else { break };
        let helps = |&&(a, b): &&(usize, usize)| {
            let other = if a == poorest { b } else { a };
            (a == poorest || b == poorest)
                && taken.degree[other] < EACH + TO_HELP
                && !taken.pairs.contains(&(a, b))
        };
        match order.iter().find(helps) {
            Some(&(a, b)) => taken.take(a, b),
            None => hopeless[poorest] = true,
        }
    }
    taken.pairs.sort_unstable();
    taken.pairs
}

/// Pairs that are searched, and of how many each camera is part.
struct Taken {
    pairs: Vec<(usize, usize)>,
    degree: Vec<usize>,
}

impl Taken {
    fn take(&mut self, a: usize, b: usize) {
        self.pairs.push((a, b));
        self.degree[a] += 1;
        self.degree[b] += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn searches_grow_with_the_cameras_and_reach_all() {
        for count in [7, 12, 20, 60] {
            // Cameras along a street see what their neighbours see.
            let likeness: Vec<(usize, usize, f64)> =
                all_pairs(count).map(|(a, b)| (a, b, 10.0 / (b - a) as f64)).collect();
            let taken = chosen(count, &likeness);
            assert!(taken.len() <= 3 * count, "{count}: {}", taken.len());
            let mut reached = vec![false; count];
            reached[0] = true;
            for _ in 0..count {
                for &(a, b) in &taken {
                    let either = reached[a] || reached[b];
                    (reached[a], reached[b]) = (either, either);
                }
            }
            assert!(reached.iter().all(|r| *r));
        }
        assert_eq!(chosen(4, &[]).len(), 6);
    }

    #[test]
    fn at_most_three_searches_for_each_camera_whatever_is_likely() {
        let mut random = 1_u64;
        for count in [7, 8, 12, 20, 50] {
            for hubs in 0..20 {
                // Some cameras see what everybody sees, the last one hardly anything, the others what chance gives.
                let likeness: Vec<(usize, usize, f64)> = all_pairs(count)
                    .map(|(a, b)| {
                        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                        let chance = (random >> 40) as f64 / (1_u64 << 24) as f64;
                        let hub = if a < hubs % 4 { 1.0 } else { 0.0 };
                        (a, b, if b == count - 1 { 0.01 * chance } else { chance + hub })
                    })
                    .collect();
                let taken = chosen(count, &likeness);
                assert!(taken.len() <= 3 * count, "{count}, {hubs}: {}", taken.len());
                for camera in 0..count {
                    let own = taken.iter().filter(|&&(a, b)| a == camera || b == camera).count();
                    assert!(own >= 4, "{count}, {hubs}: camera {camera} has {own}");
                }
            }
        }
    }
}
