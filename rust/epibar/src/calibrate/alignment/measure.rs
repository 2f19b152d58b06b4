//! The clock to a fraction of a frame, once `F` is near: what moves shows when it was.
//!
//! A tangent point of B that moves `g` pixels per frame across its epipolar line has the residual `r + g δ` where the
//! clock is `δ` frames off. So the offset and the rate are two more parameters beside the seven of `F`, and all nine
//! are fitted together: `F` alone bends to meet a wrong clock, and the clock to meet a wrong `F`. `g` is taken from the
//! frames on either side of those that the point is drawn from, so that the noise of a residual is not in its slope.

use nalgebra::{SMatrix, SVector, Vector3};
use rayon::prelude::*;

use super::between::{self, Hull};
use super::{Aligned, Clock, Links, frame_interval};
use crate::estimate::evidence::pixel_scale;
use crate::estimate::frontier::{FrontierOptions, FrontierPoint, compare};
use crate::estimate::optimise::{SevenParameters, Step, cauchy};
use crate::estimate::refine::residual_rows;
use crate::estimate::views::{Views, busy_frames};
use crate::geometry::Fundamental;
use crate::recording::{Recording, Silhouettes};

/// Frames that take part, evenly spread over the recording.
const FRAMES: usize = 3000;
/// Rounds of finding the tangents anew.
const ROUNDS: usize = 10;
/// Fewest points with a known motion.
const MIN_POINTS: usize = 40;
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
/// A walker's outline is off in the same way for several steps.
const BLOCK_SECONDS: f64 = 4.0;
const MIN_BLOCKS: f64 = 30.0;
/// Radii, pixels of a 640×480 image, at which tangents meet: the first, and the least.
const RADII: [f64; 2] = [10.0, 1.5];

/// Equations that one thread adds up.
const SUMMED: usize = 512;

type Nine = SMatrix<f64, 9, 9>;
type Row = SVector<f64, 9>;

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
pub fn measure(
    a: &Recording,
    b: &Recording,
    links: &Links,
    start: Clock,
    f: &Fundamental,
    upright: bool,
) -> Option<Measured> {
    let fitter = Fitter { a, b, links, upright };
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

/// Standard errors of a clock.
#[derive(Debug, Clone, Copy)]
struct ClockError {
    offset: f64,
    rate: f64,
}

struct Fitter<'a> {
    a: &'a Recording,
    b: &'a Recording,
    links: &'a Links,
    upright: bool,
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
    fn rows(&self, state: &State, radius: f64) -> Option<Rows> {
        let aligned = Aligned::new(self.a, self.b, self.links, state.clock);
        let pairs = busy_frames(self.a, self.b, &aligned.frame_pairs(), FRAMES);
        let (first, last) = (pairs.first()?.0, pairs.last()?.0);
        let views = aligned.views(&pairs);
        let scale = pixel_scale(&views);
        let within = |radius: f64| radius.clamp(RADII[1] * scale, RADII[0] * scale);
        let radius = within(radius);
        let options = FrontierOptions { radius, upright: self.upright, shift: 0 };
        let points = compare(&views, &state.fundamental, &options).points;
        let at = SevenParameters::new(&state.fundamental, views.sizes())?;
        let span = Span::new(self.a, self.b, first, last);
        let motions = self.motions(&aligned, &views, &state.fundamental, &points);
        let mut rows = Rows { at, span, radius, next_radius: radius, equations: Vec::new() };
        let residuals = residual_rows(&rows.at, &points);
        for ((p, motion), (residual, seven)) in points.iter().zip(motions).zip(residuals) {
            let Some(motion) = motion else { continue };
            let frame = views.frame_pairs[p.frame as usize].0;
            let mut row = Row::zeros();
            row.fixed_rows_mut::<7>(0).copy_from(&seven);
            row[7] = motion;
            row[8] = motion * rows.span.place(self.a.times[frame as usize]);
            let time = self.a.times[frame as usize];
            let block = (time / rows.span.block()).floor() as i64;
            rows.equations.push(Equation { residual, row, weight: p.surprise, block });
        }
        if rows.equations.len() < MIN_POINTS {
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
        points: &[FrontierPoint],
    ) -> Vec<Option<f64>> {
        let silhouettes = &self.b.silhouettes;
        let of_frame = |points: &[FrontierPoint]| -> Vec<Option<f64>> {
            let position = aligned.position(views.frame_pairs[points[0].frame as usize].0);
            let hulls = between::hulls(silhouettes, self.links, position);
            let motion = |p: &FrontierPoint| {
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

/// The stretch of time that a clock is fitted over.
#[derive(Debug, Clone, Copy)]
struct Span {
    /// Seconds by A's clock, from A's first frame.
    start: f64,
    middle: f64,
    half: f64,
    step_b: f64,
}

impl Span {
    fn new(a: &Recording, b: &Recording, first: u32, last: u32) -> Self {
        let (first, last) = (a.times[first as usize], a.times[last as usize]);
        let (start, middle) = (a.times[0], 0.5 * (first + last));
        Self { start, middle, half: (0.5 * (last - first)).max(1e-9), step_b: frame_interval(b) }
    }

    /// −1 at the first frame, 1 at the last.
    fn place(&self, time: f64) -> f64 {
        (time - self.middle) / self.half
    }

    /// Seconds that share their error; a short recording keeps enough of them to tell a spread.
    fn block(&self) -> f64 {
        BLOCK_SECONDS.min(2.0 * self.half / MIN_BLOCKS)
    }

    /// A clock moved by `offset` frames in the middle, and by `drift` more at the end.
    fn stepped(&self, clock: Clock, offset: f64, drift: f64) -> Clock {
        Clock {
            offset: clock.offset + offset + drift * self.place(self.start),
            rate: clock.rate + drift * self.step_b / self.half,
        }
    }

    fn error(&self, covariance: &Nine) -> ClockError {
        let place = self.place(self.start);
        let offset =
            covariance[(7, 7)] + 2.0 * place * covariance[(7, 8)] + place * place * covariance[(8, 8)];
        ClockError { offset: offset.sqrt(), rate: covariance[(8, 8)].sqrt() * self.step_b / self.half }
    }
}

/// One matched tangent.
struct Equation {
    residual: f64,
    row: Row,
    weight: f64,
    block: i64,
}

/// Linear equations in the seven parameters of `F`, the offset in the middle and the drift to the end, frames of B.
struct Rows {
    at: SevenParameters,
    span: Span,
    radius: f64,
    /// The radius that suits these residuals.
    next_radius: f64,
    equations: Vec<Equation>,
}

/// Their solution.
struct Fit {
    step: Row,
    covariance: Nine,
}

impl Rows {
    /// Robust least squares; the covariance takes what a few seconds share as one (as [`crate::verify::covariance`]).
    fn fit(&self, with_rate: bool) -> Option<Fit> {
        const ROUNDS: usize = 8;
        let scale = 0.35 * self.radius;
        let mut step = Row::zeros();
        let mut inverse = Nine::zeros();
        for _ in 0..ROUNDS {
            let some = |equations: &[Equation]| {
                let (mut normal, mut gradient) = (Nine::zeros(), Row::zeros());
                for e in equations {
                    let weight = e.weight * cauchy(e.residual + e.row.dot(&step), scale).1;
                    normal.ger(weight, &e.row, &e.row, 1.0);
                    gradient.axpy(weight * e.residual, &e.row, 1.0);
                }
                (normal, gradient)
            };
            // Added up in their order, whatever thread they come from.
            let parts: Vec<(Nine, Row)> = self.equations.par_chunks(SUMMED).map(some).collect();
            let (mut normal, mut gradient) = (Nine::zeros(), Row::zeros());
            for part in &parts {
                normal += part.0;
                gradient += part.1;
            }
            if !with_rate {
                normal.row_mut(8).fill(0.0);
                normal.column_mut(8).fill(0.0);
                normal[(8, 8)] = 1.0;
                gradient[8] = 0.0;
            }
            inverse = normal.try_inverse()?;
            step = -(inverse * gradient);
        }
        let mut meat = Nine::zeros();
        let mut count = 0.0;
        for block in self.equations.chunk_by(|p, q| p.block == q.block) {
            let mut gradient = Row::zeros();
            for e in block {
                let residual = e.residual + e.row.dot(&step);
                gradient.axpy(e.weight * cauchy(residual, scale).1 * residual, &e.row, 1.0);
            }
            if !with_rate {
                gradient[8] = 0.0;
            }
            meat.ger(1.0, &gradient, &gradient, 1.0);
            count += 1.0;
        }
        let covariance = inverse * meat * inverse * (count / (count - 9.0f64).max(1.0));
        let finite = step.iter().chain(covariance.iter()).all(|v| v.is_finite());
        finite.then_some(Fit { step, covariance })
    }
}
