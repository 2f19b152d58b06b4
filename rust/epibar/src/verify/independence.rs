//! How many values of a series say something new.

use super::thresholds::reaches;

/// Rounds in which the bias of a short series and its time of correlation settle.
const ROUNDS: usize = 8;

/// How many of the values of a series are independent of one another, by what several series of the same length have in common: their
/// number over the integrated autocorrelation time, `1 + 2 Σ ρ(lag)` to the first that is not positive (Sokal 1997, *Monte Carlo methods in
/// statistical mechanics*, §3).
///
/// The mean of a short series lies too near its values, so that every `ρ` looks smaller, by the share that one independent value has of
/// all; that is given back. `None` where nothing varies.
pub fn independent(series: &[Vec<f64>]) -> Option<f64> {
    let n = series.first().map_or(0, Vec::len);
    let about_mean = |values: &Vec<f64>| -> Vec<f64> {
        let mean = values.iter().sum::<f64>() / n as f64;
        values.iter().map(|v| v - mean).collect()
    };
    let series: Vec<Vec<f64>> = series.iter().map(about_mean).collect();
    let covariance = |lag: usize| -> f64 {
        let of = |s: &Vec<f64>| -> f64 { s.iter().zip(&s[lag..]).map(|(p, q)| p * q).sum() };
        series.iter().map(of).sum::<f64>() / (n - lag) as f64
    };
    let variance = Some(covariance(0)).filter(|&v| v > 0.0)?;
    let correlations: Vec<f64> = (1..=n / 2).map(|lag| covariance(lag) / variance).collect();
    let mut time = 1.0;
    for _ in 0..ROUNDS {
        let share = time / n as f64;
        let unbiased = correlations.iter().map(|rho| (rho + share) / (1.0 + share));
        time = 1.0 + 2.0 * unbiased.take_while(|&rho| reaches(rho, 0.0)).sum::<f64>();
    }
    Some(n as f64 / time)
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::random::generator;

    /// Series of sixty values, each of which keeps `kept` of the one before.
    fn series(count: u64, kept: f64) -> Vec<Vec<f64>> {
        let one = |k: u64| {
            let mut random = generator(17, k);
            let mut value = 0.0;
            let mut next = || {
                value = kept * value + (1.0 - kept * kept).sqrt() * (random.random::<f64>() - 0.5);
                value
            };
            (0..200).for_each(|_| _ = next());
            (0..60).map(|_| next()).collect()
        };
        (0..count).map(one).collect()
    }

    #[test]
    fn what_follows_its_past_says_less() {
        // The time of such a series is (1 + kept) / (1 - kept): 60, 20, 6.7 and 1.5 are independent.
        for (kept, least, most) in [(0.0, 45.0, 60.0), (0.5, 15.0, 26.0), (0.8, 5.0, 9.0), (0.95, 1.0, 3.0)] {
            let found = independent(&series(5, kept)).unwrap();
            assert!((least..=most).contains(&found), "{kept}: {found}");
        }
    }

    #[test]
    fn what_does_not_vary_says_nothing() {
        assert_eq!(independent(&[vec![3.0; 60], vec![0.0; 60]]), None);
        assert_eq!(independent(&[]), None);
        assert_eq!(independent(&[vec![f64::NAN; 60]]), None);
    }
}
