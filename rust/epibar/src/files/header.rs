//! What a saved calibration holds beside its arrays, as JSON.

use serde_json::{Map, Value};

use super::json::{self, of_number};
use crate::calibration::{Calibration, Counts};
use crate::clock::{RunnerUp, Timing};
use crate::error::{Error, Result};
use crate::geometry::Fundamental;
use crate::hypotheses::Source;
use crate::options::Method;
use crate::verify::{Evidence, Kind, Rival, Verdict};
use nalgebra::Matrix3;

/// The source of a calibration that has none.
const NO_SOURCE: &str = "none";

fn object(entries: impl IntoIterator<Item = (&'static str, Value)>) -> Value {
    entries.into_iter().map(|(name, value)| (name.to_string(), value)).collect::<Map<_, _>>().into()
}

/// A number, or nothing where it is not known.
fn known(number: f64) -> Value {
    if number.is_nan() { Value::Null } else { of_number(number) }
}

/// The header of a calibration.
pub(super) fn of(c: &Calibration) -> Value {
    let mut header = object([
        ("accepted", c.accepted().into()),
        ("kind", c.verdict.kind.name().into()),
        ("reason", c.verdict.reason.as_str().into()),
        ("expected_error", c.expected_error.map_or(Value::Null, of_number)),
        ("time_offset", of_number(c.timing.offset)),
        ("counts", object(counts(&c.counts).map(|(name, count)| (name, count.into())))),
        ("rivals", c.rivals.iter().map(rival).collect()),
        ("evidence", evidence(&c.evidence)),
        ("source", c.source.map_or(NO_SOURCE, Source::name).into()),
        ("method", c.method.name().into()),
        ("seed", c.seed.into()),
        ("timing.frames_per_frame", of_number(c.timing.frames_per_frame)),
        ("timing.offset_uncertainty", known(c.timing.offset_error)),
        ("timing.drift", known(c.timing.drift)),
        ("timing.drift_uncertainty", known(c.timing.drift_error)),
        ("timing.drift_used", c.timing.drift_used.into()),
        ("timing.runner_up", c.timing.runner_up.map_or(Value::Null, |r| of_number(r.offset))),
        ("timing.runner_up_share", c.timing.runner_up.map_or(Value::Null, |r| of_number(r.share))),
        ("timing.offsets_tried", c.timing.trials.into()),
    ]);
    // Arrays that are not there.
    for (name, there) in
        [("F", c.fundamental.is_some()), ("floor", c.floor.is_some()), ("error_maps", c.error_maps.is_some())]
    {
        if !there {
            header[name] = Value::Null;
        }
    }
    header
}

fn counts(c: &Counts) -> [(&'static str, usize); 8] {
    [
        ("frames", c.frames),
        ("informative_a", c.informative_a),
        ("informative_b", c.informative_b),
        ("on_motion_lines", c.on_motion_lines),
        ("mutual_pairs", c.mutual_pairs),
        ("candidates", c.candidates),
        ("line_inliers", c.line_inliers),
        ("frontier_points", c.frontier_points),
    ]
}

fn evidence(e: &Evidence) -> Value {
    let always = [
        ("z", e.z),
        ("z_tops", e.z_tops),
        ("z_bottoms", e.z_bottoms),
        ("z_whole", e.z_whole),
        ("both_ends", e.both_ends),
        ("on_all_frames", f64::from(u8::from(e.on_all_frames))),
        ("explained", e.explained),
        ("explained_tops", e.explained_tops),
        ("explained_bottoms", e.explained_bottoms),
        ("explained_by_chance", e.explained_by_chance),
    ];
    let where_known = [
        ("tested_distance", e.tested_distance),
        ("plane_residual", e.plane_residual),
        ("spread_of_bottoms", e.spread_of_bottoms),
        ("tops_off_floor", e.tops_off_floor),
        ("may_turn", e.may_turn),
        ("holds", e.holds),
        ("halves_apart", e.halves_apart),
        ("repeats", e.repeats),
        ("essential_deviation", e.essential_deviation),
    ];
    let where_known = where_known.into_iter().filter(|(_, value)| !value.is_nan());
    object(always.into_iter().chain(where_known).map(|(name, value)| (name, of_number(value))))
}

fn rival(r: &Rival) -> Value {
    let f = r.fundamental.matrix();
    let rows: Value = (0..3).map(|i| (0..3).map(|j| of_number(f[(i, j)])).collect::<Value>()).collect();
    object([
        ("F", object([("ndarray", rows)])),
        ("evidence_share", of_number(r.share)),
        ("evidence_z", of_number(r.z)),
        ("distance", of_number(r.distance)),
        ("source", r.source.name().into()),
    ])
}

/// A part of the header, which knows its name.
struct Entry<'v>(&'v Value, &'static str);

impl<'v> Entry<'v> {
    fn get(&self, name: &'static str) -> Result<Entry<'v>> {
        let found = self.0.get(name).ok_or_else(|| Error::Damaged(format!("{name} is missing")))?;
        Ok(Entry(found, name))
    }

    fn of<T>(&self, value: Option<T>, kind: &str) -> Result<T> {
        value.ok_or_else(|| Error::Damaged(format!("{} is not {kind}", self.1)))
    }

    fn number(&self) -> Result<f64> {
        self.of(json::number(self.0), "a number")
    }

    fn optional(&self) -> Result<Option<f64>> {
        if self.0.is_null() { Ok(None) } else { self.number().map(Some) }
    }

    fn count(&self) -> Result<usize> {
        self.of(self.0.as_u64(), "a count").map(|count| count as usize)
    }

    fn text(&self) -> Result<&'v str> {
        self.of(self.0.as_str(), "a text")
    }

    /// The one of some things that has this name.
    fn one_of<T: Copy>(&self, all: &[T], name: impl Fn(T) -> &'static str) -> Result<T> {
        let text = self.text()?;
        self.of(all.iter().copied().find(|&one| name(one) == text), "known to this epibar")
    }
}

/// A calibration without its arrays.
///
/// # Errors
/// [`Error::Damaged`].
pub(super) fn read(text: &str) -> Result<Calibration> {
    let value = json::read(text).map_err(|error| Error::Damaged(format!("header: {error}")))?;
    let header = Entry(&value, "header");
    let kind = header.get("kind")?.one_of(&Kind::ALL, Kind::name)?;
    let reason = header.get("reason")?.text()?;
    let method = header.get("method")?.one_of(&[Method::Frontier, Method::Lines], Method::name)?;
    let seed = header.get("seed")?;
    let seed = seed.of(seed.0.as_u64(), "a seed")?;
    let mut c = Calibration::refused(Verdict::new(kind, reason), timing(&header)?, method, seed);
    c.expected_error = header.get("expected_error")?.optional()?;
    let source = header.get("source")?;
    if source.text()? != NO_SOURCE {
        c.source = Some(source.one_of(&Source::ALL, Source::name)?);
    }
    let stored = header.get("counts")?;
    let count = |name| stored.get(name)?.count();
    c.counts = Counts {
        frames: count("frames")?,
        informative_a: count("informative_a")?,
        informative_b: count("informative_b")?,
        on_motion_lines: count("on_motion_lines")?,
        mutual_pairs: count("mutual_pairs")?,
        candidates: count("candidates")?,
        line_inliers: count("line_inliers")?,
        frontier_points: count("frontier_points")?,
    };
    let stored = header.get("evidence")?;
    let always = |name| stored.get(name)?.number();
    let where_known = |name| if stored.0.get(name).is_some() { always(name) } else { Ok(f64::NAN) };
    c.evidence = Evidence {
        z: always("z")?,
        z_tops: always("z_tops")?,
        z_bottoms: always("z_bottoms")?,
        z_whole: where_known("z_whole")?,
        both_ends: where_known("both_ends")?,
        on_all_frames: where_known("on_all_frames")? == 1.0,
        explained: always("explained")?,
        explained_tops: where_known("explained_tops")?,
        explained_bottoms: where_known("explained_bottoms")?,
        explained_by_chance: always("explained_by_chance")?,
        tested_distance: where_known("tested_distance")?,
        plane_residual: where_known("plane_residual")?,
        spread_of_bottoms: where_known("spread_of_bottoms")?,
        tops_off_floor: where_known("tops_off_floor")?,
        may_turn: where_known("may_turn")?,
        holds: where_known("holds")?,
        halves_apart: where_known("halves_apart")?,
        repeats: where_known("repeats")?,
        essential_deviation: where_known("essential_deviation")?,
    };
    let rivals = header.get("rivals")?;
    let rivals = rivals.of(rivals.0.as_array(), "a list")?;
    c.rivals = rivals.iter().map(|value| stored_rival(&Entry(value, "rivals"))).collect::<Result<_>>()?;
    Ok(c)
}

fn timing(header: &Entry) -> Result<Timing> {
    let unknown = |name| header.get(name)?.optional().map(|value| value.unwrap_or(f64::NAN));
    let runner_up = header.get("timing.runner_up")?.optional()?;
    let share = header.get("timing.runner_up_share")?.optional()?;
    let drift_used = header.get("timing.drift_used")?;
    Ok(Timing {
        offset: header.get("time_offset")?.number()?,
        frames_per_frame: header.get("timing.frames_per_frame")?.number()?,
        offset_error: unknown("timing.offset_uncertainty")?,
        drift: unknown("timing.drift")?,
        drift_error: unknown("timing.drift_uncertainty")?,
        drift_used: drift_used.of(drift_used.0.as_bool(), "true or false")?,
        runner_up: runner_up.zip(share).map(|(offset, share)| RunnerUp { offset, share }),
        trials: header.get("timing.offsets_tried")?.count()?,
    })
}

fn stored_rival(entry: &Entry) -> Result<Rival> {
    let f = entry.get("F")?.get("ndarray")?;
    let rows = f.0.as_array().into_iter().flatten().flat_map(|row| row.as_array().into_iter().flatten());
    let entries: Vec<f64> = rows.filter_map(json::number).collect();
    let matrix = (entries.len() == 9).then(|| Matrix3::from_row_slice(&entries));
    let fundamental = matrix.and_then(|matrix| Fundamental::from_rank_two(&matrix));
    Ok(Rival {
        fundamental: f.of(fundamental, "a matrix of rank 2")?,
        share: entry.get("evidence_share")?.number()?,
        z: entry.get("evidence_z")?.number()?,
        distance: entry.get("distance")?.number()?,
        source: entry.get("source")?.one_of(&Source::ALL, Source::name)?,
    })
}
