//! Some of many, evenly spread.

/// Which of `count` things to take for at most `limit`: all, or evenly spread ones.
pub fn evenly(count: usize, limit: usize) -> impl Iterator<Item = usize> {
    let taken = count.min(limit);
    (0..taken).map(move |k| k * count / taken)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_of_few_and_some_of_many() {
        let of = |count, limit| evenly(count, limit).collect::<Vec<_>>();
        assert_eq!(of(3, 5), [0, 1, 2]);
        assert_eq!(of(5, 5), [0, 1, 2, 3, 4]);
        assert_eq!(of(10, 4), [0, 2, 5, 7]);
        assert!(of(0, 4).is_empty() && of(4, 0).is_empty());
    }
}
