//! Radial lens distortion, there and back, with its derivatives.
//!
//! Brown's polynomial as `OpenCV` writes it: a point at distance `r` from the axis, in units of the focal length, is
//! seen at `r (1 + k₁ r² + k₂ r⁴ + k₃ r⁶)`. The way back has no formula: `r` is found by Newton steps, and its derivatives
//! follow from those of the polynomial (implicit function theorem).
//!
//! *Pitfall.* With a negative `k₁` alone the polynomial turns back at `r = 1/√(−3 k₁)`: nothing is seen beyond the
//! radius that it has there, and a point that claims to be has no ray.

/// Coefficients of a lens, at distances in units of the focal length.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lens {
    /// `k₁, k₂, k₃` of `OpenCV`.
    pub k: [f64; 3],
}

/// How the distance from the axis is stretched on the way back, `s = r / ρ` for a distorted distance `ρ`, with
/// derivatives to `q = ρ²` and to the coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
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
/// Steps on the way out from the axis: this, in units of the focal length, and this share of the distance.
const REACH_STEP: f64 = 1e-3;
/// Halvings of such a step.
const HALVINGS: usize = 50;

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
            1.0 + q * (3.0 * k1 + q * (5.0 * k2 + q * 7.0 * k3)),
            r * (6.0 * k1 + q * (20.0 * k2 + q * 42.0 * k3)),
        ]
    }

    /// Where a direction is seen, both in units of the focal length from the axis.
    pub fn distort(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let ([k1, k2, k3], q) = (self.k, x * x + y * y);
        let scale = 1.0 + q * (k1 + q * (k2 + q * k3));
        [x * scale, y * scale]
    }

    /// The undistorted distance of a distorted one; `None` beyond where the polynomial turns back.
    fn radius(&self, distorted: f64) -> Option<f64> {
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

    /// The distorted distance up to which there is a way back, or `most` where that is nearer.
    pub fn reach(&self, most: f64) -> f64 {
        match self.first_to(most) {
            Ok(_) => most,
            Err(farthest) => self.polynomial(farthest)[0],
        }
    }

    /// The undistorted distance of a distorted one on the way out from the axis, by halving: slow, and sure. `None` beyond the
    /// [reach](Self::reach).
    pub fn undistorted_distance(&self, distorted: f64) -> Option<f64> {
        let [mut low, mut high] = self.first_to(distorted).ok()?;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.polynomial(middle)[0] < distorted { low = middle } else { high = middle }
        }
        Some(high)
    }

    /// Undistorted distances between which the polynomial first comes to a value; otherwise the last one before it turns back.
    fn first_to(&self, value: f64) -> Result<[f64; 2], f64> {
        let mut last = 0.0;
        let mut r = 0.0;
        loop {
            let [reached, slope, _] = self.polynomial(r);
            if reached >= value {
                return Ok([last, r]);
            }
            if slope >= LEAST_SLOPE && reached < value {
                (last, r) = (r, r + REACH_STEP * (1.0 + r));
            } else {
                return Err(last);
            }
        }
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
        let s = self.radius(distorted)? / distorted;
        Some([x * s, y * s])
    }

    /// The way back of a distorted distance that is not about the axis, given by its square.
    fn back(&self, q: f64) -> Option<Back> {
        let rho = q.sqrt();
        let r = if self.is_none() { rho } else { self.radius(rho)? };
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
    pub fn stretch(&self, q: f64) -> Option<Stretch> {
        let [k1, k2, _] = self.k;
        if q < AXIS {
            let second = 3.0 * k1 * k1 - k2;
            return Some(Stretch {
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
        let mut found = Stretch {
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

#[cfg(test)]
mod tests {
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
