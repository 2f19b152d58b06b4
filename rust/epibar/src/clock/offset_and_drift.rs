//! The clock to a fraction of a frame, once `F` is near: what moves shows when it was.
//!
//! A tangent point of B that moves `g` pixels per frame across its epipolar line has the residual `r + g δ` where the
//! clock is `δ` frames off. So the offset and the rate are two more parameters beside the seven of `F`, and all nine
//! are fitted together: `F` alone bends to meet a wrong clock, and the clock to meet a wrong `F`. `g` is taken from the
//! frames on either side of those that the point is drawn from, so that the noise of a residual is not in its slope.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::aligned::Aligned;
use super::between::{self, Hull};
use super::clock::Clock;
use super::equations::{ClockEquations, ClockError, ClockVector, Equation, Span};
use crate::frontier::{TangentMatch, Up, Views, busy_frames, tangent_matches};
use crate::geometry::Fundamental;
use crate::geometry::seven_parameters::{SevenParameters, Step};
use crate::recording::tracker::Links;
use crate::recording::{Recording, Silhouettes};
use crate::refine::residual_rows;

/// Frames that take part, evenly taken from the recording.
const FRAMES: usize = 3000;
/// Rounds of finding the tangents anew.
const ROUNDS: usize = 10;
/// Fewest points with a known motion.
const FEWEST_MOVING: usize = 40;
/// A rate is used where it differs from 1 by so many standard errors, and
const SIGNIFICANT: f64 = 4.0;
/// by so many frames from one end of the recording to the other, and
const NOTICEABLE_FRAMES: f64 = 0.2;
/// where its standard error, ppm, is no larger than what the clocks of cameras differ by.
pub const MEASURABLE_PPM: f64 = 100.0;
/// Largest change of the clock in one round, frames.
const MAX_STEP: f64 = 1.5;
/// The clock has settled where a round moves it by less, frames.
const SETTLED: f64 = 0.005;
/// Radii, pixels of a 640×480 image, at which tangents meet: the first, and the least.
const RADII: [f64; 2] = [10.0, 1.5];

/// A clock, and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// The clock; its rate is that of the start unless the recording shows another.
    pub clock: Clock,
    /// The geometry fitted with it.
    pub fundamental: Fundamental,
    /// Standard error of the offset, frames of B.
    pub offset_error: f64,
    /// Rate by the fit whether or not it is significant, seconds of B per second of A.
    pub rate: f64,
    /// Its standard error.
    pub rate_error: f64,
}

/// Sharpens a clock near which `f` is about right. `None` where too little moves across its epipolar lines.
///
/// `up`: in either image.
pub fn sharpen(
    a: &Recording,
    b: &Recording,
    links: &Links,
    start: Clock,
    f: &Fundamental,
    up: [Up; 2],
) -> Option<Measured> {
    let fitter = Fitter { a, b, links, up };
    let (alike, error) = fitter.settle(start, f, false)?;
    let (free, free_error) = fitter.settle(alike.clock, &alike.fundamental, true)?;
    let frames = a.frames() as f64 * (free.clock.rate - 1.0).abs();
    let significant = frames > NOTICEABLE_FRAMES
        && (free.clock.rate - 1.0).abs() > SIGNIFICANT * free_error.rate
        && 1e6 * free_error.rate <= MEASURABLE_PPM;
    let (chosen, offset_error) = if significant { (free, free_error.offset) } else { (alike, error.offset) };
    Some(Measured {
        clock: chosen.clock,
        fundamental: chosen.fundamental,
        offset_error,
        rate: free.clock.rate,
        rate_error: free_error.rate,
    })
}

/// A geometry with a clock.
#[derive(Debug, Clone, Copy)]
struct State {
    clock: Clock,
    fundamental: Fundamental,
}

struct Fitter<'a> {
    a: &'a Recording,
    b: &'a Recording,
    links: &'a Links,
    up: [Up; 2],
}

impl Fitter<'_> {
    /// Fits until the clock stays where it is.
    fn settle(&self, clock: Clock, f: &Fundamental, with_rate: bool) -> Option<(State, ClockError)> {
        let mut state = State { clock, fundamental: *f };
        let mut radius = f64::INFINITY;
        let mut error = None;
        for _ in 0..ROUNDS {
            let rows = self.rows(&state, radius)?;
            let fit = rows.fit(with_rate)?;
            let move_by = fit.step[7].abs() + fit.step[8].abs();
            let share = (MAX_STEP / move_by).min(1.0);
            let step = Step::from_fn(|k, _| fit.step[k] * share);
            state.fundamental = rows.at.stepped(&step).fundamental()?;
            state.clock = rows.span.stepped(state.clock, fit.step[7] * share, fit.step[8] * share);
            error = Some(rows.span.error(&fit.covariance));
            let narrowed = rows.next_radius > 0.9 * rows.radius;
            radius = rows.next_radius;
            if move_by < SETTLED && narrowed {
                break;
            }
        }
        error.map(|error| (state, error))
    }

    /// The equations of a state: matched tangents whose motion is known.
    fn rows(&self, state: &State, radius: f64) -> Option<ClockEquations> {
        let aligned = Aligned::new(self.a, self.b, self.links, state.clock, self.up);
        let pairs = busy_frames(self.a, self.b, &aligned.frame_pairs(), Some(FRAMES));
        let (first, last) = (pairs.first()?.a, pairs.last()?.a);
        let views = aligned.views(&pairs);
        let scale = views.pixel_scale();
        let within = |radius: f64| radius.clamp(RADII[1] * scale, RADII[0] * scale);
        let radius = within(radius);
        let points = tangent_matches(&views, &state.fundamental, radius);
        let at = SevenParameters::new(&state.fundamental, views.sizes())?;
        let span = Span::new(self.a, self.b, first, last);
        let motions = self.motions(&aligned, &views, &state.fundamental, &points);
        let mut rows = ClockEquations { at, span, radius, next_radius: radius, equations: Vec::new() };
        let residuals = residual_rows(&rows.at, &points);
        for ((p, motion), (residual, seven)) in points.iter().zip(motions).zip(residuals) {
            let Some(motion) = motion else { continue };
            let frame = views.frame_pairs[p.frame.index()].a;
            let mut row = ClockVector::zeros();
            row.fixed_rows_mut::<7>(0).copy_from(&seven);
            row[7] = motion;
            row[8] = motion * rows.span.place(self.a.times[frame.index()]);
            let time = self.a.times[frame.index()];
            let block = (time / rows.span.block()).floor() as i64;
            rows.equations.push(Equation { residual, row, weight: p.surprise, block });
        }
        if rows.equations.len() < FEWEST_MOVING {
            return None;
        }
        let mut sizes: Vec<f64> = rows.equations.iter().map(|e| e.residual.abs()).collect();
        let middle = sizes.len() / 2;
        rows.next_radius = within(4.0 * 1.4826 * *sizes.select_nth_unstable_by(middle, f64::total_cmp).1);
        Some(rows)
    }

    /// Change of each point's Sampson distance per frame of B, pixels. The points come frame by frame.
    fn motions(
        &self,
        aligned: &Aligned,
        views: &Views,
        f: &Fundamental,
        points: &[TangentMatch],
    ) -> Vec<Option<f64>> {
        let silhouettes = &self.b.silhouettes;
        let of_frame = |points: &[TangentMatch]| -> Vec<Option<f64>> {
            let position = aligned.position(views.frame_pairs[points[0].frame.index()].a);
            let hulls = between::hulls(silhouettes, self.links, position);
            let motion = |p: &TangentMatch| {
                let hull = hulls.iter().find(|hull| hull.vertices.contains(&p.b))?;
                let (line, back) = (
                    f.line_in_b(&Vector3::new(p.a[0], p.a[1], 1.0)),
                    f.line_in_a(&Vector3::new(p.b[0], p.b[1], 1.0)),
                );
                let norm = line.x.hypot(line.y);
                let across = self.motion_across(silhouettes, hull, [line.x / norm, line.y / norm], p.b)?;
                Some(across * norm / norm.hypot(back.x.hypot(back.y)))
            };
            points.iter().map(motion).collect()
        };
        points.par_chunk_by(|p, q| p.frame == q.frame).flat_map_iter(of_frame).collect()
    }

    /// How fast a silhouette's tangent of a direction moves along its normal at a point, pixels per frame.
    fn motion_across(
        &self,
        silhouettes: &Silhouettes,
        hull: &Hull,
        normal: [f64; 2],
        point: [f64; 2],
    ) -> Option<f64> {
        let (before, after) = (self.links.previous(hull.first)?, self.links.next(hull.last)?);
        let frames = if hull.first == hull.last { 2.0 } else { 3.0 };
        let along = |p: [f64; 2]| p[0] * normal[0] + p[1] * normal[1];
        let count = hull.vertices.len() as f64;
        let middle: f64 = hull.vertices.iter().map(|p| along(*p)).sum::<f64>() / count;
        let side = if along(point) > middle { 1.0 } else { -1.0 };
        let support = |h: usize| {
            let values = silhouettes.hull(h).iter().map(|p| side * along(p.map(f64::from)));
            values.fold(f64::NEG_INFINITY, f64::max)
        };
        Some(side * (support(after) - support(before)) / frames)
    }
}
