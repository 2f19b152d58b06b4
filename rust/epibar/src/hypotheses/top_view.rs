//! Hypotheses from two maps of one floor.
//!
//! Each camera alone tells where figures stand on the floor ([`single_view`](super::single_view)). The two maps differ by a turn, a
//! shift and hardly in scale, which two figures give that are seen at the same moments by both; and they agree where at all
//! other moments figures stand where others do. This needs neither lines nor long tracks: it holds in crowds, in
//! queues, and where people dance on the spot.

use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::RngExt;

use super::ransac::{Estimator, Scored};
use super::single_view::SingleView;
use super::tracks::{Extremes, extremes};
use crate::frontier::{View, Views};
use crate::geometry::{CameraMatrices, Fundamental, SevenParameters};
use crate::random::Generator;
use crate::refine::least_squares::minimise;
use crate::refine::sampson::SampsonProblem;

/// Frames of which maps are made, evenly over time.
const MAPPED: usize = 3000;
/// Frames on which maps are compared, and fewer in crowds: so many figures of A beside so many of B, but for no fewer than the least.
const COMPARED: usize = 120;
const COMPARED_FIGURES: usize = 120_000;
const LEAST_COMPARED: usize = 24;
/// A preview looks at one of so many of them.
const PREVIEWED: usize = 6;
/// Figures at one place are no farther from each other than this, heights of a figure.
const NEAR: f64 = 0.5;
/// What a figure must be worth by chance.
const BY_CHANCE: f64 = 0.15;
/// Two figures that give a map are at least so far apart, heights of a figure.
const APART: f64 = 0.7;
/// Maps differ in scale by no more than this factor.
const SCALE: f64 = 1.5;
/// Samples that may be refused for one hypothesis.
const TRIES: usize = 30;
/// Rounds in which maps are laid over one another anew.
const ROUNDS: usize = 3;
/// Overlays that differ by no more are alike, radians and heights of a figure, and so many of them go on.
const ALIKE: (f64, f64) = (0.17, 1.0);
const COPIES: usize = 4;
/// Fewest figures that fit an `F`, and within how many pixels of a 640×480 image their ends meet, round by round.
const LEAST_MATCHES: usize = 20;
const TOLERANCES: [f64; 2] = [12.0, 5.0];
const ITERATIONS: usize = 8;

/// A whole silhouette, and where on the floor it stands.
struct PlacedSilhouette {
    place: [f64; 2],
    ends: Extremes,
}

/// A camera and its map.
struct Map {
    view: SingleView,
    frames: Vec<Vec<PlacedSilhouette>>,
}

/// A place in the map of A and one in that of B.
type PlacePair = ([f64; 2], [f64; 2]);

/// The map of B from that of A: `scale · R(turn) p + shift`, and which maps these are.
#[derive(Debug, Clone, Copy)]
pub struct Overlay {
    maps: [usize; 2],
    /// Cosine and sine, times the scale.
    turn: [f64; 2],
    shift: [f64; 2],
}

impl Overlay {
    /// The one that best sends points to points; `None` where they are at one place or differ too much in scale.
    fn of(maps: [usize; 2], pairs: &[PlacePair]) -> Option<Self> {
        let mean = |of: fn(&PlacePair) -> [f64; 2]| {
            let sum = pairs.iter().map(of).fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
            sum.map(|s| s / pairs.len() as f64)
        };
        let (p, q) = (mean(|m| m.0), mean(|m| m.1));
        let (mut cos, mut sin, mut square) = (0.0, 0.0, 0.0);
        for (a, b) in pairs {
            let (a, b) = ([a[0] - p[0], a[1] - p[1]], [b[0] - q[0], b[1] - q[1]]);
            cos += a[0] * b[0] + a[1] * b[1];
            sin += a[0] * b[1] - a[1] * b[0];
            square += a[0] * a[0] + a[1] * a[1];
        }
        let turn = [cos / square, sin / square];
        let scale = turn[0].hypot(turn[1]);
        let found = Self { maps, turn, shift: [0.0; 2] };
        let turned = found.sends(p);
        (1.0 / SCALE..=SCALE)
            .contains(&scale)
            .then_some(Self { shift: [q[0] - turned[0], q[1] - turned[1]], ..found })
    }

    /// Whether both lay the maps alike: turned by 10 degrees at most, and shifted by a figure's height.
    fn is_like(&self, other: &Self) -> bool {
        let angle = |o: &Self| o.turn[1].atan2(o.turn[0]);
        let (sin, cos) = (angle(self) - angle(other)).sin_cos();
        let apart = (self.shift[0] - other.shift[0]).hypot(self.shift[1] - other.shift[1]);
        sin.atan2(cos).abs() <= ALIKE.0 && apart <= ALIKE.1
    }

    fn sends(&self, p: [f64; 2]) -> [f64; 2] {
        let [cos, sin] = self.turn;
        [cos * p[0] - sin * p[1] + self.shift[0], sin * p[0] + cos * p[1] + self.shift[1]]
    }
}

/// Draws overlays of two maps, and scores them by figures that stand where others do.
pub struct TopView<'a> {
    views: &'a Views,
    /// How A may see the floor, and how B may.
    maps: [Vec<Map>; 2],
    /// Frames in which figures are seen by both, and those of them on which maps are compared.
    busy: Vec<usize>,
    compared: Vec<usize>,
}

/// The best overlays, of such that lay the maps alike no more than a few: focal lengths that differ give near copies.
pub fn different(overlays: Vec<Scored<Overlay>>, limit: usize) -> Vec<Scored<Overlay>> {
    let mut kept: Vec<Scored<Overlay>> = Vec::new();
    for overlay in overlays {
        if kept.len() < limit && kept.iter().filter(|k| k.model.is_like(&overlay.model)).count() < COPIES {
            kept.push(overlay);
        }
    }
    kept
}

impl<'a> TopView<'a> {
    /// From the silhouettes of both; `None` where they do not stand on a floor.
    pub fn new(views: &'a Views) -> Option<Self> {
        if !views.upright {
            return None;
        }
        let of = |view: &View, matrix: Option<&Matrix3<f64>>| -> Vec<Map> {
            SingleView::of(view, matrix).into_iter().map(|camera| Map::new(camera, view)).collect()
        };
        let cameras = views.cameras.as_ref();
        let (a, b) = rayon::join(
            || of(&views.a, cameras.map(CameraMatrices::a)),
            || of(&views.b, cameras.map(CameraMatrices::b)),
        );
        let seen = |maps: &[Map], t: usize| maps.iter().any(|map| !map.frames[t].is_empty());
        let busy: Vec<usize> = (0..views.frames()).filter(|&t| seen(&a, t) && seen(&b, t)).collect();
        let compared = compared(views, &busy);
        (!busy.is_empty()).then_some(Self { views, maps: [a, b], busy, compared })
    }

    /// What the overlay, laid anew where figures stand near each other, makes of the two cameras.
    pub fn fundamental(&self, overlay: &Overlay) -> Option<Fundamental> {
        let mut overlay = *overlay;
        for _ in 0..ROUNDS {
            let pairs: Vec<_> = self.near(&overlay).map(|[a, b]| (a.place, b.place)).collect();
            if pairs.len() < 2 {
                break;
            }
            overlay = Overlay::of(overlay.maps, &pairs)?;
        }
        let f = self.of_cameras(&overlay)?;
        let ends = |[a, b]: [&PlacedSilhouette; 2]| [0, 1].map(|k| (a.ends[k], b.ends[k]));
        let matches: Vec<_> = self.near(&overlay).flat_map(ends).collect();
        if matches.len() < 2 * LEAST_MATCHES {
            return Some(f);
        }
        let mut at = SevenParameters::new(&f, self.views.sizes())?;
        for tolerance in TOLERANCES {
            let points = SampsonProblem::of_matches(&matches, tolerance * self.views.pixel_scale());
            at = minimise(&points, at, ITERATIONS).0;
        }
        at.fundamental()
    }

    fn maps_of(&self, overlay: &Overlay) -> [&Map; 2] {
        [&self.maps[0][overlay.maps[0]], &self.maps[1][overlay.maps[1]]]
    }

    /// Figures of A and of B that stand at one place.
    fn near(&self, overlay: &Overlay) -> impl Iterator<Item = [&PlacedSilhouette; 2]> {
        let [a, b] = self.maps_of(overlay);
        let overlay = *overlay;
        self.compared.iter().flat_map(move |&t| {
            a.frames[t].iter().filter_map(move |figure| {
                let (squared, other) = nearest(&b.frames[t], overlay.sends(figure.place))?;
                (squared <= NEAR * NEAR).then_some([figure, other])
            })
        })
    }

    /// `F` of two cameras over one floor.
    fn of_cameras(&self, overlay: &Overlay) -> Option<Fundamental> {
        let [a, b] = self.maps_of(overlay).map(|map| &map.view);
        let [cos, sin] = overlay.turn;
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), sin.atan2(cos));
        let [x, y] = overlay.shift;
        let baseline = Vector3::new(x, y, cos.hypot(sin) * a.height() - b.height());
        let rotation = b.axes() * turn * a.axes().transpose();
        let essential = (b.axes() * baseline).cross_matrix() * rotation;
        let [size_a, size_b] = self.views.sizes();
        Fundamental::from_matrix(&(b.inverse().transpose() * essential * a.inverse()), size_a, size_b)
    }
}

impl Map {
    fn new(view: SingleView, of: &View) -> Self {
        let standing = |frame| {
            let figures = of.hulls_of(frame).filter_map(|hull| extremes(of, hull));
            figures.filter_map(|ends| Some(PlacedSilhouette { place: view.place(&ends)?, ends })).collect()
        };
        let step = of.frames().div_ceil(MAPPED).max(1);
        let mapped = |frame: usize| if frame.is_multiple_of(step) { standing(frame) } else { Vec::new() };
        Self { frames: (0..of.frames()).map(mapped).collect(), view }
    }
}

/// Of frames in which both see figures those on which maps are compared, evenly over time.
fn compared(views: &Views, busy: &[usize]) -> Vec<usize> {
    let beside = |&t: &usize| views.a.hulls_of(t).count() * views.b.hulls_of(t).count();
    let mean = busy.iter().map(beside).sum::<usize>() / busy.len().max(1);
    let taken = (COMPARED_FIGURES / mean.max(1)).clamp(LEAST_COMPARED, COMPARED).min(busy.len());
    (0..taken).map(|k| busy[k * busy.len() / taken]).collect()
}

/// The squared distance of the nearest figure, and which that is.
fn nearest(figures: &[PlacedSilhouette], at: [f64; 2]) -> Option<(f64, &PlacedSilhouette)> {
    let distances = figures.iter().map(|f| ((f.place[0] - at[0]).powi(2) + (f.place[1] - at[1]).powi(2), f));
    distances.min_by(|p, q| p.0.total_cmp(&q.0))
}

impl Estimator for TopView<'_> {
    type Model = Overlay;

    fn generate(&self, _index: usize, random: &mut Generator) -> Option<Overlay> {
        let [a, b] = &self.maps;
        let maps = [random.random_range(0..a.len()), random.random_range(0..b.len())];
        let [a, b] = [&a[maps[0]], &b[maps[1]]];
        let mut pair = || {
            let t = self.busy[random.random_range(0..self.busy.len())];
            let (p, q) = (&a.frames[t], &b.frames[t]);
            (!p.is_empty() && !q.is_empty())
                .then(|| (p[random.random_range(0..p.len())].place, q[random.random_range(0..q.len())].place))
        };
        let far = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]) >= APART;
        (0..TRIES).find_map(|_| {
            let (one, other) = (pair()?, pair()?);
            (far(one.0, other.0) && far(one.1, other.1)).then(|| Overlay::of(maps, &[one, other]))?
        })
    }

    fn score(&self, overlay: &Overlay) -> f64 {
        self.agreement(overlay, 1)
    }

    fn preview(&self, overlay: &Overlay) -> f64 {
        PREVIEWED as f64 * self.agreement(overlay, PREVIEWED)
    }
}

impl TopView<'_> {
    /// Of figures of A that B could see, how many stand where one of B does, in one of so many frames.
    fn agreement(&self, overlay: &Overlay, step: usize) -> f64 {
        let [a, b] = self.maps_of(overlay);
        let (w, h) = (self.views.b.size.width() as f64, self.views.b.size.height() as f64);
        let worth = |t: usize, figure: &PlacedSilhouette| {
            let at = overlay.sends(figure.place);
            let near = nearest(&b.frames[t], at).map_or(0.0, |n| 1.0 - n.0 / (NEAR * NEAR));
            if near > 0.0 {
                return near - BY_CHANCE;
            }
            let inside = |p: [f64; 2]| p[0] >= 0.0 && p[1] >= 0.0 && p[0] < w && p[1] < h;
            if b.view.pixel(at).is_some_and(inside) { -BY_CHANCE } else { 0.0 }
        };
        self.compared
            .iter()
            .step_by(step)
            .flat_map(|&t| a.frames[t].iter().map(move |figure| worth(t, figure)))
            .sum()
    }
}
