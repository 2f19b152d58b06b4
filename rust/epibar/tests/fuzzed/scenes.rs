//! Small recordings of any bytes: things that move before several cameras, and damage to what was recorded.

use arbitrary::{Result, Unstructured};
use epibar::{ImageSize, Recorder, RecorderOptions, Recording, RecordingParts, Segment};

/// A rectangle that bounces. All cameras see it at the same heights, each at places of its own.
struct Mover {
    y: i32,
    speed: i32,
    width: i32,
    height: i32,
    across: [(i32, i32); CAMERAS],
    seen: u8,
}

/// At most so many cameras.
pub const CAMERAS: usize = 4;

impl Mover {
    fn new(u: &mut Unstructured) -> Result<Self> {
        let mut across = [(0, 0); CAMERAS];
        let (y, speed) = (i32::from(u.arbitrary::<u8>()?), i32::from(u.arbitrary::<i8>()?));
        let (width, height) = (u.int_in_range(1..=12)?, u.int_in_range(1..=16)?);
        for place in &mut across {
            *place = (i32::from(u.arbitrary::<u8>()?), i32::from(u.arbitrary::<i8>()?));
        }
        // Mostly by all cameras.
        Ok(Self { y, speed, width, height, across, seen: u.arbitrary::<u8>()? | u.arbitrary::<u8>()? })
    }

    fn draw(&self, mask: &mut [u8], size: ImageSize, frame: i32, camera: usize) {
        if self.seen & (1 << camera) == 0 {
            return;
        }
        let bounced = |start: i32, speed: i32, side: usize| {
            let side = side as i32;
            let at = (start + speed * frame / 16).rem_euclid(2 * side);
            at.min(2 * side - 1 - at)
        };
        let (x, speed) = self.across[camera];
        let (x, y) = (bounced(x, speed, size.width()), bounced(self.y, self.speed, size.height()));
        for row in y..(y + self.height).min(size.height() as i32) {
            let start = row as usize * size.width();
            mask[start + x as usize..start + (x + self.width).min(size.width() as i32) as usize].fill(1);
        }
    }
}

/// A number at the ends of what is allowed, beyond, or anywhere.
pub fn number(u: &mut Unstructured) -> Result<f64> {
    const ODD: [f64; 12] = [
        0.0,
        -0.0,
        1.0,
        1e-300,
        5e-324,
        f64::MAX,
        -1e9,
        1e300,
        536_870_911.0,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
    ];
    match u.arbitrary::<u8>()? {
        0..16 => Ok(*u.choose(&ODD)?),
        16..24 => u.arbitrary(),
        _ => Ok(f64::from(u.arbitrary::<i16>()?) / 32.0),
    }
}

/// What so many cameras recorded of one scene; fewer where what they recorded is refused.
pub fn recordings(u: &mut Unstructured, cameras: usize) -> Result<Vec<Recording>> {
    let movers = (0..u.int_in_range(0..=4)?).map(|_| Mover::new(u)).collect::<Result<Vec<_>>>()?;
    let frames = u.int_in_range(1..=90)?;
    let mut found = Vec::new();
    for camera in 0..cameras {
        found.extend(recording(u, &movers, frames, camera)?);
    }
    Ok(found)
}

fn recording(
    u: &mut Unstructured,
    movers: &[Mover],
    frames: i32,
    camera: usize,
) -> Result<Option<Recording>> {
    let size = ImageSize::new(u.int_in_range(2..=48)?, u.int_in_range(2..=40)?).expect("an allowed size");
    let options = RecorderOptions::new()
        .lines(u.int_in_range(1..=120)?)
        .seed(u.arbitrary()?)
        .min_component_area(u.int_in_range(0..=12)?);
    let mut recorder = Recorder::new(size, options).expect("allowed options");
    if u.ratio(1, 8)? {
        let visible = u.bytes(size.pixels().min(u.len()))?.to_vec();
        if visible.len() == size.pixels() {
            recorder = recorder.with_visible(&visible).expect("an area of the right size");
        }
    }
    let start = if u.ratio(1, 8)? { number(u)? } else { 0.0 };
    let step = if u.ratio(1, 8)? { number(u)?.abs() } else { 0.04 };
    let (dropped, later) = (u.arbitrary::<u8>()?, i32::from(u.arbitrary::<i8>()?) / 8);
    for frame in 0..frames {
        if dropped > 200 && (frame * i32::from(dropped)) % 7 == 0 {
            continue;
        }
        let mut mask = vec![0; size.pixels()];
        for mover in movers {
            mover.draw(&mut mask, size, frame + later, camera);
        }
        // A time that cannot be costs its frame.
        let _ = recorder.push(&mask, start + step * f64::from(frame));
    }
    let Ok(recording) = recorder.finish() else { return Ok(None) };
    let mut parts = RecordingParts::from(recording);
    for _ in 0..u.int_in_range(0..=8u32)?.saturating_sub(5) {
        damage(u, &mut parts)?;
    }
    Ok(Recording::try_from(parts).ok())
}

/// Changes one value.
fn damage(u: &mut Unstructured, parts: &mut RecordingParts) -> Result<()> {
    let (which, at) = (u.int_in_range(0..=12)?, usize::from(u.arbitrary::<u16>()?));
    macro_rules! put {
        ($values:expr, $value:expr) => {
            if let Some(found) = place(&mut $values, at) {
                *found = $value;
            }
        };
    }
    match which {
        0 => put!(parts.times, number(u)?),
        1 => put!(parts.barcodes, u.arbitrary()?),
        2 => put!(parts.hull_points, u.arbitrary()?),
        3 => put!(parts.hull_area, u.arbitrary()?),
        4 => put!(parts.hull_border, u.arbitrary()?),
        5 => put!(parts.frame_start, u.arbitrary::<u8>()?.into()),
        6 => put!(parts.hull_start, u.arbitrary::<u8>()?.into()),
        7 => put!(parts.heat, u.arbitrary::<u8>()?.into()),
        8 => put!(parts.moving_pixels, u.arbitrary::<u8>()?.into()),
        9 => put!(parts.outline_points, u.arbitrary()?),
        10 => put!(parts.outline_start, u.arbitrary::<u8>()?.into()),
        11 => {
            put!(parts.segments, Segment { x0: number(u)?, y0: number(u)?, x1: number(u)?, y1: number(u)? });
        }
        _ => parts.size = [usize::from(u.arbitrary::<u8>()?), parts.size[1]],
    }
    Ok(())
}

/// The value at a place, counted around.
fn place<T>(values: &mut [T], at: usize) -> Option<&mut T> {
    let count = values.len().max(1);
    values.get_mut(at % count)
}
