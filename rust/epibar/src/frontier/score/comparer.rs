//! The comparison of all tangents of two views under one `F`.
//!
//! A [`Comparer`] holds what depends on `F` alone; [`Comparer::pair`] finds for each tangent of A the nearest of B when
//! the clocks are shifted so far; [`Paired::weigh`] gives each pair its weight at a radius. Buffers are kept from one
//! comparison of a thread to its next.

use std::cell::Cell;

use nalgebra::Vector3;
use pulp::Arch;

use super::passes::{Buffers, Chances, Meetings, Reversed, Sign, Touched};
use super::tangents::{BOTTOM, Sides, partner};
use crate::frontier::matches::{Class, CommonFrame, FrontierScore, TangentMatch};
use crate::frontier::views::{View, Views};
use crate::geometry::Fundamental;
use crate::image::ImageSize;

thread_local! {
    static SPARE: Cell<Option<Box<Buffers>>> = const { Cell::new(None) };
}

/// Tangents of both views from the epipoles of one `F`, and how often B's lie where.
pub struct Comparer {
    buffers: Box<Buffers>,
    sides: Sides,
    arch: Arch,
}

impl Drop for Comparer {
    fn drop(&mut self) {
        SPARE.set(Some(std::mem::take(&mut self.buffers)));
    }
}

impl Comparer {
    /// Tangents of A compared with those of B under `f`.
    pub fn new(views: &Views, f: &Fundamental) -> Self {
        Self::on(Arch::new(), &views.a, &views.b, f, views.upright)
    }

    /// Tangents of B compared with those of A under the same `f`.
    pub fn reversed(views: &Views, f: &Fundamental) -> Self {
        Self::on(Arch::new(), &views.b, &views.a, &f.transposed(), views.upright)
    }

    /// [`Comparer::reversed`] of what was made by [`Comparer::new`] for the same arguments.
    pub fn turned_round(mut self, views: &Views, f: &Fundamental) -> Self {
        let f = f.transposed();
        self.arch.dispatch(Reversed { buffers: &mut self.buffers, b: &views.a, f: &f });
        self.sides.same = keeps_side(&f, views.b.size);
        self
    }

    fn on(arch: Arch, a: &View, b: &View, f: &Fundamental, upright: bool) -> Self {
        let mut buffers = SPARE.take().unwrap_or_default();
        arch.dispatch(Touched { buffers: &mut buffers, a, b, f });
        Self { buffers, sides: Sides { same: keeps_side(f, a.size), upright }, arch }
    }

    /// The sign of the map of rays, `F` or `−F`: it shows on a few frames, by matches within `radius` pixels.
    pub fn sign(&mut self, shift: usize, radius: f64) -> f64 {
        self.arch.dispatch(Sign { buffers: &mut self.buffers, sides: self.sides, shift, radius })
    }

    /// Pairs each tangent of frame `t` of A with one of common frame `t + shift` of B, cyclically; the sign of the map of
    /// rays is that of [`Comparer::sign`].
    pub fn pair(&mut self, shift: usize, radius: f64) -> Paired<'_> {
        let sign = self.sign(shift, radius);
        self.pair_by(sign, shift)
    }

    /// [`Comparer::pair`] with a known sign of the map of rays.
    pub fn pair_by(&mut self, sign: f64, shift: usize) -> Paired<'_> {
        self.arch.dispatch(Meetings { buffers: &mut self.buffers, sides: self.sides, shift, sign });
        Paired { comparer: self, sign }
    }

    fn matches(&self, radius: f64) -> Vec<TangentMatch> {
        let Buffers { a, b, sent, .. } = &*self.buffers;
        let mut matches = Vec::new();
        for frame in 0..a[0].frames() {
            for side in 0..2 {
                let (tangents, sent) = (&a[side], &sent[side]);
                let targets = &b[partner(side, self.sides)];
                for i in tangents.of(frame) {
                    let distance = sent.squared[i].sqrt();
                    if distance < radius {
                        let j = sent.met[i] as usize;
                        matches.push(TangentMatch {
                            frame: CommonFrame(frame as u32),
                            a: [tangents.x[i], tangents.y[i]],
                            b: [targets.x[j], targets.y[j]],
                            distance,
                            surprise: sent.surprise[i],
                            class: if tangents.class[i] & BOTTOM == 0 { Class::Top } else { Class::Bottom },
                        });
                    }
                }
            }
        }
        matches
    }
}

/// Tangents of A, each with the one of B that it is nearest to, if that has none nearer.
pub struct Paired<'c> {
    comparer: &'c mut Comparer,
    sign: f64,
}

impl Paired<'_> {
    /// The weight of each pair where two tangents meet within `radius` pixels.
    pub fn weigh(&mut self, radius: f64) -> Weighed<'_> {
        self.chances(radius, true);
        Weighed { comparer: self.comparer, radius }
    }

    /// The tangents that meet within `radius` pixels, by frames.
    pub fn matches(&mut self, radius: f64) -> Vec<TangentMatch> {
        self.chances(radius, false);
        self.comparer.matches(radius)
    }

    fn chances(&mut self, radius: f64, objects: bool) {
        let Comparer { buffers, sides, arch } = &mut *self.comparer;
        arch.dispatch(Chances { buffers, sides: *sides, sign: self.sign, radius, objects });
    }
}

/// Pairs with their weights at one radius.
pub struct Weighed<'c> {
    comparer: &'c Comparer,
    radius: f64,
}

impl Weighed<'_> {
    /// The score.
    pub fn score(&self) -> FrontierScore {
        self.sum(0..self.frames())
    }

    /// [`FrontierScore::total`] of [`Weighed::score`], without what goes into the classes.
    pub fn total(&self) -> f64 {
        let Buffers { a, objects, .. } = &*self.comparer.buffers;
        (0..self.frames()).flat_map(|frame| &objects.evidence[a[0].hulls(frame)]).sum()
    }

    /// The score of some frames of A.
    pub fn score_of(&self, frames: &[usize]) -> FrontierScore {
        self.sum(frames.iter().copied())
    }

    fn frames(&self) -> usize {
        self.comparer.buffers.a[0].frames()
    }

    fn sum(&self, frames: impl Iterator<Item = usize> + Clone) -> FrontierScore {
        let mut score = FrontierScore::default();
        let radius2 = self.radius * self.radius;
        let Buffers { a, sent, objects, .. } = &*self.comparer.buffers;
        for (tangents, sent) in a.iter().zip(sent) {
            for i in frames.clone().flat_map(|frame| tangents.of(frame)) {
                let bottom = tangents.class[i] & BOTTOM != 0;
                let class = if bottom { &mut score.bottoms } else { &mut score.tops };
                class.tangents += 1;
                class.matches += usize::from(sent.squared[i] < radius2);
                class.expected += sent.chance[i];
                class.excess += sent.excess[i];
            }
        }
        for hull in frames.flat_map(|frame| a[0].hulls(frame)) {
            score.objects.add(objects.outcome[hull], objects.evidence[hull]);
        }
        score
    }

    /// Evidence of the silhouettes of each frame of A.
    pub fn per_frame(&self) -> Vec<f64> {
        let Buffers { a, objects, .. } = &*self.comparer.buffers;
        (0..self.frames()).map(|frame| objects.evidence[a[0].hulls(frame)].iter().sum()).collect()
    }

    /// The tangents that meet within the radius, by frames.
    pub fn matches(&self) -> Vec<TangentMatch> {
        self.comparer.matches(self.radius)
    }
}

/// Whether the 1-D homography of `F` keeps the sense of rotation between oriented pencils `e × x` and `F x`.
fn keeps_side(f: &Fundamental, size_a: ImageSize) -> bool {
    let (e, e_b) = (f.epipole_a(), f.epipole_b());
    // Two points whose epipolar lines differ: of three corners some pair always does.
    let (x, y) = (size_a.x_max(), size_a.y_max());
    let corners = [Vector3::new(0.0, 0.0, 1.0), Vector3::new(x, 0.0, 1.0), Vector3::new(0.0, y, 1.0)];
    let mut best = (0.0f64, true);
    for (p, q) in [(0, 1), (1, 2), (2, 0)] {
        let (p, q) = (corners[p], corners[q]);
        let in_a = e.dot(&p.cross(&q));
        let in_b = f.line_in_b(&p).cross(&f.line_in_b(&q)).dot(e_b);
        if in_a.abs() > best.0 {
            best = (in_a.abs(), in_a * in_b > 0.0);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::generator;
    use crate::recording::FramePair;
    use nalgebra::Matrix3;
    use rand::RngExt;

    /// Polygons of 3 to 70 vertices here and there, none to 20 in a frame.
    fn polygons(size: ImageSize, frames: usize, seed: u64) -> View {
        let mut random = generator(seed, 0);
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let frames: Vec<Vec<Vec<[f64; 2]>>> = (0..frames)
            .map(|_| {
                (0..between(0.0, 21.0) as usize)
                    .map(|_| {
                        let n = if between(0.0, 1.0) < 0.05 { 70 } else { between(3.0, 20.0) as usize };
                        let (x, y) = (between(0.0, size.x_max()), between(0.0, size.y_max()));
                        let (w, h, turn) = (between(2.0, 30.0), between(5.0, 60.0), between(0.0, 6.0));
                        let at = |k: usize| turn + k as f64 * std::f64::consts::TAU / n as f64;
                        (0..n).map(|k| [x + w * at(k).cos(), y + h * at(k).sin()]).collect()
                    })
                    .collect()
            })
            .collect();
        View::made_up(size, &frames)
    }

    fn levels() -> Vec<Arch> {
        let mut levels = vec![Arch::Scalar];
        #[cfg(target_arch = "x86_64")]
        {
            levels.extend(pulp::x86::V3::try_new().map(Arch::V3));
            levels.extend(pulp::x86::V4::try_new().map(Arch::V4));
        }
        levels
    }

    /// By one tangent after the other, as the definition says: the nearest of both, and its squared distance.
    fn met(a: &View, b: &View, f: &Fundamental, shift: usize, radius: f64) -> usize {
        use crate::geometry::{TangentPoint, epipolar_tangents, sampson_distance};
        let same = keeps_side(f, a.size);
        let count = |sign: f64, step: usize| {
            let mut count = 0;
            for frame in (0..a.frames()).step_by(step) {
                let of = |view: &View, frame, e| -> Vec<TangentPoint> {
                    let both = view.hulls_of(frame).filter_map(|h| epipolar_tangents(h, e)).flatten();
                    both.filter(|t| !view.on_border(t.point)).collect()
                };
                let in_a = of(a, frame, f.epipole_a());
                let in_b = of(b, (frame + shift) % b.frames(), f.epipole_b());
                let distance = |p: &TangentPoint, q: &TangentPoint| {
                    let ray = f.line_in_b(&Vector3::new(p.point[0], p.point[1], 1.0)) * sign;
                    let other = f.epipole_b().cross(&Vector3::new(q.point[0], q.point[1], 1.0));
                    let may = (p.positive == q.positive) == same && ray.dot(&other) > 0.0;
                    if may { sampson_distance(f, p.point, q.point).abs() } else { f64::INFINITY }
                };
                for p in &in_a {
                    let nearest = in_b.iter().min_by(|q, r| distance(p, q).total_cmp(&distance(p, r)));
                    count += usize::from(nearest.is_some_and(|q| {
                        let d = distance(p, q);
                        d < radius && in_a.iter().all(|r| distance(r, q) >= d)
                    }));
                }
            }
            count
        };
        count(1.0, 1).max(count(-1.0, 1))
    }

    #[test]
    fn every_level_finds_what_the_definition_says() {
        let sizes = [ImageSize::new(640, 480).unwrap(), ImageSize::new(800, 450).unwrap()];
        let (a, b) = (polygons(sizes[0], 60, 1), polygons(sizes[1], 60, 2));
        let mut random = generator(3, 0);
        let mut matches = 0;
        for k in 0..24 {
            let matrix = Matrix3::from_fn(|i, j| {
                let scale = [1.0, 1.0, 600.0][i] * [1.0, 1.0, 600.0][j];
                (2.0 * random.random::<f64>() - 1.0) * scale / 360_000.0
            });
            let Some(f) = Fundamental::from_matrix(&matrix, sizes[0], sizes[1]) else { continue };
            let mut first: Option<(FrontierScore, Vec<TangentMatch>, Vec<f64>)> = None;
            for arch in levels() {
                let mut comparer = Comparer::on(arch, &a, &b, &f, k % 2 == 0);
                let mut paired = comparer.pair(k, 4.0);
                let matches_alone = paired.matches(4.0);
                let found = paired.weigh(4.0);
                assert_eq!(found.total(), found.score().total());
                let found = (found.score(), found.matches(), found.per_frame());
                assert_eq!(matches_alone, found.1);
                assert!((found.2.iter().sum::<f64>() - found.0.total()).abs() < 1e-6);
                assert_eq!(found.0.matches(), found.1.len());
                assert_eq!(*first.get_or_insert_with(|| found.clone()), found, "{arch:?}");
            }
            let found = first.unwrap().0.matches();
            matches += found;
            if k % 2 == 1 {
                // The sign is decided on a few frames, and may be the one with fewer matches where there is no answer.
                assert!(found <= met(&a, &b, &f, k, 4.0));
                assert!(10 * found >= 8 * met(&a, &b, &f, k, 4.0), "{found}");
            }
        }
        assert!(matches > 500, "{matches}");
    }

    #[test]
    fn a_comparison_turned_round_is_that_of_the_views_exchanged() {
        let sizes = [ImageSize::new(640, 480).unwrap(), ImageSize::new(800, 450).unwrap()];
        let (a, b) = (polygons(sizes[0], 30, 4), polygons(sizes[1], 30, 5));
        let pairs = (0..30).map(|i| FramePair::new(i, i)).collect();
        let views = Views::of(a, b, pairs);
        let rows = Matrix3::new(0.0, -1e-6, 2e-4, 2e-6, 0.0, -1.2e-3, -3e-4, 1e-3, 0.03);
        let f = Fundamental::from_matrix(&rows, sizes[0], sizes[1]).unwrap();
        let of = |mut comparer: Comparer| {
            let mut paired = comparer.pair(1, 4.0);
            let found = paired.weigh(4.0);
            (found.score(), found.matches())
        };
        let turned = of(Comparer::new(&views, &f).turned_round(&views, &f));
        assert_eq!(turned, of(Comparer::reversed(&views, &f)));
        assert!(turned.1.len() > 20 && turned != of(Comparer::new(&views, &f)), "{}", turned.1.len());
    }
}
