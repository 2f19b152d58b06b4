//! Radial lens distortion, there and back, with its derivatives.
//!
//! Brown's polynomial as `OpenCV` writes it: a point at distance `r` from the axis, in units of the focal length, is
//! seen at `r (1 + k₁ r² + k₂ r⁴ + k₃ r⁶)`. The way back has no formula: `r` is found by Newton's steps, or by
//! halving where these do not end on the way out from the axis, and its derivatives follow from those of the polynomial (implicit function theorem).
//!
//! *Pitfall.* With a negative `k₁` alone the polynomial turns back at `r = 1/√(−3 k₁)`: nothing is seen beyond the
//! radius that it has there, and a point that claims to be has no ray. The slope is a cubic in `r²`, whose first root is that fold.

/// Coefficients of a lens, at distances in units of the focal length.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lens {
    /// `k₁, k₂, k₃` of `OpenCV`.
    pub k: [f64; 3],
}

/// How the distance from the axis is stretched on the way back, `s = r / ρ` for a distorted distance `ρ`, with
/// derivatives to `q = ρ²` and to the coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadialStretch {
    /// `s`.
    pub s: f64,
    /// `∂s/∂q`.
    pub s_q: f64,
    /// `∂²s/∂q²`.
    pub s_qq: f64,
    /// `∂s/∂kᵢ`.
    pub s_k: [f64; 3],
    /// `∂²s/∂q∂kᵢ`.
    pub s_qk: [f64; 3],
}

/// The way back of a distance.
struct Back {
    /// The distorted distance.
    rho: f64,
    /// The undistorted one.
    r: f64,
    /// Curvature of the polynomial there.
    curvature: f64,
    /// `∂r/∂ρ`.
    first: f64,
    /// `r / ρ`.
    s: f64,
    /// `∂s/∂ρ`.
    s1: f64,
}

/// Newton steps towards a radius; the polynomials of lenses need five.
const STEPS: usize = 30;
/// A step after which none is needed.
const SMALL: f64 = 1e-7;
/// Below this slope of the polynomial a lens shows nothing that can be told apart.
const LEAST_SLOPE: f64 = 0.02;
/// Distorted distances, squared, below which the series is exact.
const AXIS: f64 = 1e-6;
/// Halvings of an interval, after which its ends are neighbours.
const HALVINGS: usize = 60;
/// How often a distance is doubled on the way out of a lens that never turns back.
const OCTAVES: usize = 40;

impl Lens {
    /// No distortion.
    pub const NONE: Self = Self { k: [0.0; 3] };

    /// Of `OpenCV`'s `k₁ k₂ p₁ p₂ k₃`, of which the tangential ones are not used.
    pub fn of_opencv(&[k1, k2, _, _, k3]: &[f64; 5]) -> Self {
        Self { k: [k1, k2, k3] }
    }

    /// Whether it bends anything.
    pub fn is_none(&self) -> bool {
        self.k == [0.0; 3]
    }

    /// The polynomial, its slope and its curvature at an undistorted distance.
    fn polynomial(&self, r: f64) -> [f64; 3] {
        let ([k1, k2, k3], q) = (self.k, r * r);
        [
            r * (1.0 + q * (k1 + q * (k2 + q * k3))),
            self.slope(q),
            r * (6.0 * k1 + q * (20.0 * k2 + q * 42.0 * k3)),
        ]
    }

    /// Where a direction is seen, both in units of the focal length from the axis.
    pub fn distort(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let ([k1, k2, k3], q) = (self.k, x * x + y * y);
        let scale = 1.0 + q * (k1 + q * (k2 + q * k3));
        [x * scale, y * scale]
    }

    /// Slope of the polynomial, by the square of an undistorted distance.
    fn slope(&self, q: f64) -> f64 {
        let [k1, k2, k3] = self.k;
        1.0 + q * (3.0 * k1 + q * (5.0 * k2 + q * 7.0 * k3))
    }

    /// Squares of undistorted distances at which the slope stops falling or rising, in their order; NaN where there are fewer.
    fn bends(&self) -> [f64; 2] {
        // Roots of 3 k₁ + 10 k₂ q + 21 k₃ q², without the difference of numbers that are nearly alike.
        let [c, b, a] = [3.0 * self.k[0], 10.0 * self.k[1], 21.0 * self.k[2]];
        let half = -0.5 * (b + b.signum() * (b * b - 4.0 * a * c).sqrt());
        let [one, other] = [half / a, c / half].map(|q| if q > 0.0 && q.is_finite() { q } else { f64::NAN });
        if one > other || one.is_nan() { [other, one] } else { [one, other] }
    }

    /// The undistorted distance at which the polynomial turns back; infinite where it never does.
    fn fold(&self) -> f64 {
        let bends = self.bends().into_iter().filter(|q| !q.is_nan());
        let last = bends.clone().next_back().unwrap_or(0.0);
        let mut beyond = (0..OCTAVES as i32).map(|n| (1.0 + last) * 2f64.powi(n));
        let mut low = 0.0;
        for end in bends.chain(beyond.find(|q| self.slope(*q) < LEAST_SLOPE)) {
            if self.slope(end) < LEAST_SLOPE {
                return halved([low, end], |q| self.slope(q) >= LEAST_SLOPE)[0].sqrt();
            }
            low = end;
        }
        f64::INFINITY
    }

    /// Whether the polynomial rises all the way from the axis to an undistorted distance.
    fn rises_to(&self, r: f64) -> bool {
        let square = r * r;
        // What makes it fall does so more and more on the way out, so that where it rises in spite of all of that it has risen before.
        let falling = Self { k: self.k.map(|k| k.min(0.0)) };
        if falling.slope(square) >= LEAST_SLOPE {
            return true;
        }
        let between = self.bends().into_iter().filter(|q| *q < square);
        between.chain([square]).all(|q| self.slope(q) >= LEAST_SLOPE)
    }

    /// The undistorted distance of a distorted one on the way out from the axis; `None` beyond the [reach](Self::reach).
    pub fn undistorted_distance(&self, distorted: f64) -> Option<f64> {
        self.by_steps(distorted).filter(|r| self.rises_to(*r)).or_else(|| self.by_halving(distorted))
    }

    /// By Newton's steps, which may end beyond a fold, or leave a root that is there.
    fn by_steps(&self, distorted: f64) -> Option<f64> {
        let mut r = distorted;
        // A start on the near side of the fold; where the root is beyond it, the steps below leave it again.
        while r > 0.0 && self.polynomial(r)[1] < LEAST_SLOPE {
            r = if r > 1e-3 { 0.8 * r } else { return None };
        }
        for _ in 0..STEPS {
            let [value, slope, _] = self.polynomial(r);
            if slope < LEAST_SLOPE || r < 0.0 {
                return None;
            }
            let step = (value - distorted) / slope;
            r -= step;
            // The next step would be about the square of this one.
            if step.abs() < SMALL * (1.0 + r) {
                return (r >= 0.0).then_some(r);
            }
        }
        None
    }

    /// By halving what lies before the fold: slow, and sure.
    fn by_halving(&self, distorted: f64) -> Option<f64> {
        let seen = |r: f64| self.polynomial(r)[0];
        let fold = self.fold();
        let far = (0..).map(|n| (1.0 + distorted) * 2f64.powi(n)).map(|r| r.min(fold));
        let high = far.take(OCTAVES).find(|r| seen(*r) >= distorted)?;
        Some(halved([0.0, high], |r| seen(r) < distorted)[1])
    }

    /// The distorted distance up to which there is a way back, or `most` where that is nearer.
    pub fn reach(&self, most: f64) -> f64 {
        let fold = self.fold();
        if fold.is_finite() { self.polynomial(fold)[0].min(most) } else { most }
    }

    /// The direction that is seen at a place; `None` where no direction is.
    pub fn undistort(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        if self.is_none() {
            return Some([x, y]);
        }
        let distorted = x.hypot(y);
        if distorted * distorted < AXIS {
            let s = 1.0 - self.k[0] * distorted * distorted;
            return Some([x * s, y * s]);
        }
        let s = self.undistorted_distance(distorted)? / distorted;
        Some([x * s, y * s])
    }

    /// The way back of a distorted distance that is not about the axis, given by its square.
    fn back(&self, q: f64) -> Option<Back> {
        let rho = q.sqrt();
        let r = if self.is_none() { rho } else { self.undistorted_distance(rho)? };
        let [_, slope, curvature] = self.polynomial(r);
        let first = 1.0 / slope;
        let s = r / rho;
        Some(Back { rho, r, curvature, first, s, s1: (first - s) / rho })
    }

    /// The `s` and `∂s/∂q` of [`Lens::stretch`], alone.
    pub fn stretch_only(&self, q: f64) -> Option<[f64; 2]> {
        if q < AXIS {
            let [k1, k2, _] = self.k;
            let second = 3.0 * k1 * k1 - k2;
            return Some([1.0 - k1 * q + second * q * q, -k1 + 2.0 * second * q]);
        }
        self.back(q).map(|back| [back.s, back.s1 / (2.0 * back.rho)])
    }

    /// How far a place, given by the square of its distance from the axis, is stretched on the way back.
    pub fn stretch(&self, q: f64) -> Option<RadialStretch> {
        let [k1, k2, _] = self.k;
        if q < AXIS {
            let second = 3.0 * k1 * k1 - k2;
            return Some(RadialStretch {
                s: 1.0 - k1 * q + second * q * q,
                s_q: -k1 + 2.0 * second * q,
                s_qq: 2.0 * second,
                s_k: [-q + 6.0 * k1 * q * q, -q * q, 0.0],
                s_qk: [-1.0 + 12.0 * k1 * q, -2.0 * q, 0.0],
            });
        }
        let Back { rho, r, curvature, first, s, s1 } = self.back(q)?;
        let second = -curvature * first * first * first;
        let s2 = (second - 2.0 * s1) / rho;
        let mut found = RadialStretch {
            s,
            s_q: s1 / (2.0 * rho),
            s_qq: (s2 - s1 / rho) / (4.0 * q),
            s_k: [0.0; 3],
            s_qk: [0.0; 3],
        };
        let square = r * r;
        let mut power = r;
        for i in 0..3 {
            let above = power; // r^(2i + 1), one power of r² behind
            power *= square;
            let r_k = -power * first;
            let slope_k = (2.0 * i as f64 + 3.0) * above * r + curvature * r_k;
            found.s_k[i] = r_k / rho;
            found.s_qk[i] = (-slope_k * first * first - found.s_k[i]) / (2.0 * q);
        }
        Some(found)
    }
}

/// Neighbouring ends of an interval: it holds up to the first one, and no more from the second one on.
fn halved([mut low, mut high]: [f64; 2], holds: impl Fn(f64) -> bool) -> [f64; 2] {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use rand::RngExt as _;

    use super::*;

    const LENSES: [[f64; 3]; 5] =
        [[0.0; 3], [-0.38, 0.21, -0.08], [-0.3, 0.0, 0.0], [0.05, 0.01, 0.0], [-0.12, 0.03, 0.002]];

    #[test]
    fn there_and_back() {
        for k in LENSES {
            let lens = Lens { k };
            for p in [[0.0, 0.0], [1e-4, 2e-4], [0.3, -0.2], [-0.5, 0.4]] {
                let back = lens.undistort(lens.distort(p)).unwrap();
                assert!((back[0] - p[0]).hypot(back[1] - p[1]) < 1e-11, "{k:?} {p:?} {back:?}");
            }
        }
    }

    #[test]
    fn beyond_the_fold_is_nothing() {
        let lens = Lens { k: [-0.3, 0.0, 0.0] };
        // The fold is at r = 1/√0.9, which is seen at 0.703.
        assert!(lens.undistort([0.69, 0.0]).is_some());
        for x in [0.71, 0.8, 1.0, 3.0] {
            assert!(lens.undistort([x, 0.0]).is_none(), "{x}");
        }
        assert!(lens.undistort([f64::NAN, 0.0]).is_none());
    }

    #[test]
    fn a_lens_reaches_to_its_fold() {
        let lens = Lens { k: [-0.3, 0.0, 0.0] };
        let fold = lens.reach(2.0);
        assert!((fold - 0.703).abs() < 1e-3, "{fold}");
        assert!(
            lens.undistort([0.999 * fold, 0.0]).is_some() && lens.undistort([1.001 * fold, 0.0]).is_none()
        );
        assert_eq!(lens.reach(0.5), 0.5);
        assert_eq!(Lens { k: [0.05, 0.01, 0.0] }.reach(2.0), 2.0);
        assert_eq!(Lens::NONE.reach(2.0), 2.0);
    }

    #[test]
    fn within_its_reach_every_lens_has_a_way_back_and_beyond_it_none() {
        let (second_branch, lost_by_newton) = ([-0.312, -0.169, 0.052], [-0.236, 0.032, -0.001]);
        for k in LENSES.into_iter().chain([second_branch, lost_by_newton, [-0.591, 0.249, -0.035]]) {
            let lens = Lens { k };
            let reach = lens.reach(2.0);
            for share in [0.01, 0.3, 0.7, 0.9, 0.999] {
                let back = lens.undistorted_distance(share * reach).unwrap();
                assert!((lens.polynomial(back)[0] - share * reach).abs() < 1e-12, "{k:?} {share}");
            }
            if reach < 2.0 {
                assert_eq!(lens.undistorted_distance(1.001 * reach), None, "{k:?}");
            }
        }
        assert_eq!(Lens::NONE.undistorted_distance(f64::NAN), None);
        assert_eq!(Lens::NONE.undistorted_distance(0.0), Some(0.0));
    }

    #[test]
    fn folds_and_ways_back_are_those_of_a_walk_from_the_axis() {
        let (mut folded, mut random) = (0, rand_pcg::Pcg64Mcg::new(3));
        for _ in 0..400 {
            let lens = Lens { k: [0.6, 0.3, 0.1].map(|most| random.random_range(-most..most)) };
            let walk = (0..20_000).map(|step| 1e-4 * f64::from(step));
            let end = walk.clone().find(|r| lens.polynomial(*r)[1] < LEAST_SLOPE);
            let reach = end.map_or(f64::INFINITY, |r| lens.polynomial(r)[0]);
            assert!((lens.reach(0.9) - reach.min(0.9)).abs() < 3e-6, "{lens:?}");
            folded += usize::from(reach < 0.9);
            for r in walk.step_by(700).take_while(|r| end.is_none_or(|end| *r < end - 1e-4)) {
                let back = lens.undistorted_distance(lens.polynomial(r)[0]).unwrap();
                assert!((back - r).abs() < 1e-9, "{lens:?} {r} {back}");
            }
            if end.is_some() {
                assert_eq!(lens.undistorted_distance(reach + 1e-3), None, "{lens:?}");
            }
        }
        assert!((100..300).contains(&folded), "{folded}");
    }

    #[test]
    fn derivatives_equal_differences() {
        for k in LENSES {
            for q in [0.01, 0.1, 0.2, 0.3] {
                let at = |k: [f64; 3], q: f64| Lens { k }.stretch(q).unwrap();
                let (found, h) = (at(k, q), 1e-5);
                let near = |difference: f64, derivative: f64| {
                    let off = (difference - derivative).abs();
                    assert!(off < 1e-5 * (1.0 + derivative.abs()), "{k:?} {q}: {difference} {derivative}");
                };
                assert_eq!(Lens { k }.stretch_only(q), Some([found.s, found.s_q]));
                near((at(k, q + h).s - at(k, q - h).s) / (2.0 * h), found.s_q);
                near((at(k, q + h).s_q - at(k, q - h).s_q) / (2.0 * h), found.s_qq);
                for i in 0..3 {
                    let moved = |by: f64| {
                        let mut k = k;
                        k[i] += by;
                        at(k, q)
                    };
                    near((moved(h).s - moved(-h).s) / (2.0 * h), found.s_k[i]);
                    near((moved(h).s_q - moved(-h).s_q) / (2.0 * h), found.s_qk[i]);
                }
            }
        }
    }

    #[test]
    fn the_series_joins_the_rest() {
        for k in LENSES {
            let lens = Lens { k };
            let (inside, outside) =
                (lens.stretch(0.999 * AXIS).unwrap(), lens.stretch(1.001 * AXIS).unwrap());
            assert!((inside.s - outside.s).abs() < 1e-8);
            assert!((inside.s_q - outside.s_q).abs() < 1e-4, "{inside:?} {outside:?}");
        }
    }
}
