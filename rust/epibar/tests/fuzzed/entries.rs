//! The functions that take recordings, masks, barcodes and numbers.

use arbitrary::{Result, Unstructured};
use epibar::internals::{barcodes_of_segments, mutual_matches};
use epibar::nalgebra::{Matrix3, Rotation3, Vector3};
use epibar::network::{
    Aspect, CameraInput, Expected, Knowledge, NetworkOptions, NetworkTime, Offsets, PairFound, PosedCamera,
    StoredCamera, TrackingCamera, add_cameras, calibrate_network, check_network, walker_tracks,
};
use epibar::{
    Barcodes, CalibrateOptions, CameraMatrices, ExamineOptions, Fundamental, ImageSize, Method, Recorder,
    RecorderOptions, Segment, TimeOffset, Unwatched, examine, symmetric_epipolar_distance,
};

use super::scenes::{CAMERAS, number, recordings};

const NAMES: [&str; CAMERAS] = ["hall", "door", "stairs", "yard"];

/// Masks of any bytes: what is recorded counts what they hold.
pub fn recorder(data: &[u8]) {
    let _ = record(&mut Unstructured::new(data));
}

fn record(u: &mut Unstructured) -> Result<()> {
    let Ok(size) = ImageSize::new(u.int_in_range(1..=70)?, u.int_in_range(1..=24)?) else { return Ok(()) };
    let options = RecorderOptions::new().lines(u.int_in_range(0..=60)?).min_component_area(u.arbitrary()?);
    let Ok(mut recorder) = Recorder::new(size, options) else { return Ok(()) };
    let (mut time, mut moving) = (0.0, Vec::new());
    while !u.is_empty() && moving.len() < 600 {
        time += if u.ratio(1, 16)? { number(u)? } else { 0.04 };
        // Each byte is a run, so that few bytes fill an image.
        let mut mask = Vec::with_capacity(size.pixels());
        while mask.len() < size.pixels() {
            let run = u.arbitrary::<u8>()?;
            let end = (mask.len() + 1 + usize::from(run >> 1)).min(size.pixels());
            mask.resize(end, run & 1);
        }
        if recorder.push(&mask, time).is_ok() {
            moving.push(mask.iter().map(|&pixel| u32::from(pixel)).sum::<u32>());
        }
    }
    assert_eq!(recorder.frames(), moving.len());
    let Ok(recording) = recorder.finish() else { return Ok(()) };
    assert_eq!(recording.moving_pixels(), moving);
    assert_eq!(recording.heat().iter().sum::<u32>(), moving.iter().sum::<u32>());
    assert_eq!(recording.barcodes().count(), options.lines);
    Ok(())
}

/// Barcodes of any bytes, and lines anywhere.
pub fn matching(data: &[u8]) {
    let _ = match_any(&mut Unstructured::new(data));
}

fn match_any(u: &mut Unstructured) -> Result<()> {
    let (frames, mutual) = (u.int_in_range(0..=200)?, u.int_in_range(0..=9)?);
    let (width, height) = (u.int_in_range(0..=40)?, u.int_in_range(0..=40)?);
    let mut segments = Vec::new();
    for _ in 0..u.int_in_range(0..=6)? {
        segments.push(Segment { x0: number(u)?, y0: number(u)?, x1: number(u)?, y1: number(u)? });
    }
    if let Ok(size) = ImageSize::new(width, height) {
        let frames = frames.min(6);
        let mut masks = u.bytes((frames * size.pixels()).min(u.len()))?.to_vec();
        masks.resize(frames * size.pixels(), 0);
        if let Ok(found) = barcodes_of_segments(&masks, frames, size, &segments) {
            assert_eq!(found.count(), segments.len());
        }
    }
    let words = frames.div_ceil(64).max(1);
    let mut some = |most: usize| -> Result<_> {
        let bits =
            (0..u.int_in_range(0..=most)? * words).map(|_| u.arbitrary()).collect::<Result<Vec<u64>>>()?;
        Ok(Barcodes::from_words(bits.len() / words, frames, bits))
    };
    if let (Ok(a), Ok(b)) = (some(20)?, some(20)?) {
        for found in mutual_matches(&a, &b, mutual).unwrap_or_default() {
            assert!((found.a as usize) < a.count() && (found.b as usize) < b.count());
            assert!(found.correlation.is_finite());
        }
    }
    Ok(())
}

/// Two recordings: a calibration, and a matrix that is examined.
pub fn calibrate(data: &[u8]) {
    let _ = calibrate_any(&mut Unstructured::new(data));
}

fn calibrate_any(u: &mut Unstructured) -> Result<()> {
    let options = options(u)?;
    let entries = [(); 9].map(|()| number(u));
    let examined = ExamineOptions::new().radius(number(u)?).time_offset(number(u)?);
    let found = recordings(u, 2)?;
    let [a, b] = found.as_slice() else { return Ok(()) };
    if let Ok(found) = epibar::calibrate(a, b, &options) {
        assert!(!found.accepted() || found.fundamental.is_some());
        assert!(found.fundamental.is_none_or(|f| f.matrix().iter().all(|v| v.is_finite())));
        assert!(found.expected_error.is_none_or(|error| error >= 0.0));
        assert!(!found.verdict.reason.is_empty());
    }
    let matrix = Matrix3::from_row_slice(&entries.into_iter().collect::<Result<Vec<f64>>>()?);
    let kinds = [Fundamental::from_rank_two(&matrix), Fundamental::from_matrix(&matrix, a.size(), b.size())];
    for f in kinds.into_iter().flatten() {
        let _ = symmetric_epipolar_distance(&f, [1.0, 2.0], [3.0, 4.0]);
        let _ = examine(a, b, &f, &examined);
    }
    Ok(())
}

fn options(u: &mut Unstructured) -> Result<CalibrateOptions> {
    let offset = match u.int_in_range(0..=7)? {
        0 => TimeOffset::Known(number(u)?),
        1 => TimeOffset::About(number(u)?),
        2 => TimeOffset::Search { seconds: number(u)? },
        3 => TimeOffset::Auto { seconds: number(u)? },
        _ => TimeOffset::Known(0.0),
    };
    let mut options = CalibrateOptions::new()
        .method(if u.ratio(1, 4)? { Method::Lines } else { Method::Frontier })
        .time_offset(offset)
        .upright(u.arbitrary()?)
        .candidates(u.int_in_range(0..=40)?)
        .draws(u.int_in_range(0..=60)?)
        .seed(u.arbitrary()?);
    if u.ratio(1, 8)? {
        options = options.max_expected_error(number(u)?);
    }
    if u.ratio(1, 4)? {
        options.cameras = CameraMatrices::new(matrix(u)?, matrix(u)?).ok();
    }
    Ok(options)
}

fn matrix(u: &mut Unstructured) -> Result<Matrix3<f64>> {
    Ok(Matrix3::new(number(u)?, 0.0, number(u)?, 0.0, number(u)?, number(u)?, 0.0, 0.0, 1.0))
}

/// Two to four recordings: a network.
pub fn network(data: &[u8]) {
    let _ = network_any(&mut Unstructured::new(data));
}

fn network_any(u: &mut Unstructured) -> Result<()> {
    let count = u.int_in_range(1..=CAMERAS)?;
    let known = (0..count).map(|_| knowledge(u)).collect::<Result<Vec<_>>>()?;
    let time = if u.ratio(1, 2)? {
        NetworkTime::Known(
            (0..count).map(|_| if u.ratio(1, 8)? { number(u) } else { Ok(0.0) }).collect::<Result<_>>()?,
        )
    } else {
        NetworkTime::Search { seconds: number(u)? }
    };
    let options = NetworkOptions::new().pairs(options(u)?).time(time);
    let found = recordings(u, count)?;
    let cameras: Vec<CameraInput> = found
        .iter()
        .zip(known)
        .zip(NAMES)
        .map(|((recording, known), name)| CameraInput::new(name, recording).known(known))
        .collect();
    if let Ok(network) = calibrate_network(&cameras, &options) {
        assert_eq!(network.cameras.len(), cameras.len());
        for camera in network.cameras.iter().filter(|camera| camera.accepted()) {
            assert!(camera.matrix().is_some_and(|m| m.iter().all(|v| v.is_finite())));
            assert!(camera.position().is_some_and(|p| p.iter().all(|v| v.is_finite())));
        }
        for pair in network.pairs.iter().filter(|pair| pair.accepted) {
            assert!(pair.fundamental.is_some_and(|f| f.iter().all(|v| v.is_finite())));
        }
    }
    Ok(())
}

fn knowledge(u: &mut Unstructured) -> Result<Knowledge> {
    let mut known = Knowledge::default();
    match u.int_in_range(0..=7)? {
        0 => known.matrix = Some(matrix(u)?),
        1 => known.focal = Some((number(u)?, number(u)?)),
        2 => known.principal = Some([number(u)?, number(u)?]),
        3 => known.aspect = Aspect::Known(number(u)?),
        4 => known.aspect = Aspect::Unknown,
        5 => {
            known.matrix = Some(Matrix3::new(40.0, 0.0, 20.0, 0.0, 40.0, 15.0, 0.0, 0.0, 1.0));
            known.distortions = Some([number(u)?, number(u)?, 0.0, 0.0, number(u)?]);
        }
        _ => {}
    }
    Ok(known)
}

/// Cameras of a stored network and new recordings: who has moved, and who walks there.
pub fn network_check(data: &[u8]) {
    let _ = check_any(&mut Unstructured::new(data));
}

fn check_any(u: &mut Unstructured) -> Result<()> {
    let count = u.int_in_range(1..=3)?;
    let (mut stored, mut tracking, mut seconds) = (Vec::new(), Vec::new(), Vec::new());
    let height = number(u)?;
    let places = (0..count).map(|_| place(u)).collect::<Result<Vec<_>>>()?;
    let clocks =
        (0..count).map(|_| if u.ratio(1, 6)? { number(u) } else { Ok(0.0) }).collect::<Result<Vec<_>>>()?;
    let found = recordings(u, count)?;
    for (index, recording) in found.iter().enumerate() {
        let expected = Expected::new(0.01, 0.01, 0.1);
        stored.push(StoredCamera::new(NAMES[index], recording, places[index], expected));
        tracking.push(TrackingCamera::new(recording, places[index]).clock(clocks[index], 0.0));
        seconds.push(clocks[index]);
    }
    if let Ok(found) = check_network(&stored, &Offsets::given(seconds), &mut Unwatched) {
        assert_eq!(found.len(), stored.len());
    }
    if let Ok(points) = walker_tracks(&tracking, height, &mut Unwatched) {
        assert!(points.iter().all(|point| point.foot.iter().chain(&point.top).all(|v| v.is_finite())));
    }
    Ok(())
}

/// New cameras beside those of a stored network, some of whose pairs were searched.
pub fn network_add(data: &[u8]) {
    let _ = add_any(&mut Unstructured::new(data));
}

fn add_any(u: &mut Unstructured) -> Result<()> {
    let (held, new) = (u.int_in_range(1..=3)?, u.int_in_range(1..=2)?);
    let count = (held + new).min(CAMERAS);
    let places = (0..held).map(|_| place(u)).collect::<Result<Vec<_>>>()?;
    let known = (held..count).map(|_| knowledge(u)).collect::<Result<Vec<_>>>()?;
    let seconds =
        (0..count).map(|_| if u.ratio(1, 6)? { number(u) } else { Ok(0.0) }).collect::<Result<Vec<_>>>()?;
    let mut pairs = Vec::new();
    for _ in 0..u.int_in_range(0..=3)? {
        let (a, b) = (u.int_in_range(0..=4)?, u.int_in_range(0..=4)?);
        let geometry = Matrix3::from_fn(|_, _| f64::from(u.arbitrary::<i8>().unwrap_or(1)) / 64.0);
        if let Ok(pair) = PairFound::new(a, b, vec![(geometry, number(u)?)]) {
            pairs.push(pair.verdict(number(u)?, u.arbitrary()?));
        }
    }
    let found = recordings(u, count)?;
    let expected = Expected::new(0.01, 0.01, 0.1);
    let (old, fresh) = found.split_at(held.min(found.len()));
    let stored: Vec<StoredCamera> = old
        .iter()
        .zip(places)
        .zip(NAMES)
        .map(|((recording, place), name)| StoredCamera::new(name, recording, place, expected))
        .collect();
    let added: Vec<CameraInput> = fresh
        .iter()
        .zip(known)
        .zip(&NAMES[stored.len()..])
        .map(|((recording, known), name)| CameraInput::new(name, recording).known(known))
        .collect();
    if let Ok(found) =
        add_cameras(&stored, &added, &pairs, &Offsets::given(seconds[..found.len()].to_vec()), &mut Unwatched)
    {
        assert_eq!(found.cameras.len(), added.len());
        for camera in found.cameras.iter().filter(|camera| camera.accepted()) {
            assert!(camera.position().is_some_and(|p| p.iter().all(|v| v.is_finite())));
        }
    }
    Ok(())
}

/// A camera that looks at the origin, or one of any numbers.
fn place(u: &mut Unstructured) -> Result<PosedCamera> {
    let matrix = if u.ratio(1, 8)? {
        matrix(u)?
    } else {
        Matrix3::new(40.0, 0.0, 20.0, 0.0, 40.0, 15.0, 0.0, 0.0, 1.0)
    };
    let mut distortions = [0.0; 5];
    if u.ratio(1, 8)? {
        distortions[u.int_in_range(0..=4)?] = number(u)?;
    }
    let mut rotation = *Rotation3::from_euler_angles(
        f64::from(u.arbitrary::<i8>()?) / 40.0,
        f64::from(u.arbitrary::<i8>()?) / 40.0,
        f64::from(u.arbitrary::<i8>()?) / 40.0,
    )
    .matrix();
    if u.ratio(1, 8)? {
        rotation[u.int_in_range(0..=8)?] = number(u)?;
    }
    let translation = Vector3::new(number(u)?, number(u)?, number(u)?);
    Ok(PosedCamera { matrix, distortions, rotation, translation })
}
