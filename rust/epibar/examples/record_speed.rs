//! How long a recording takes: `cargo run --release --example record_speed`.
//!
//! Twenty squares bounce through 800 frames of 640 × 480 pixels, with some noise, watched by 20,000 lines.

use epibar::{ImageSize, Recorder, RecorderOptions, barcodes_of_segments};
use std::time::Instant;

const SIZE: (usize, usize) = (640, 480);
const FRAMES: usize = 800;

fn main() -> epibar::Result<()> {
    let size = ImageSize::new(SIZE.0, SIZE.1)?;
    let masks: Vec<u8> = (0..FRAMES).flat_map(mask).collect();
    let started = Instant::now();
    let mut recorder = Recorder::new(size, RecorderOptions::default())?;
    for (frame, mask) in masks.chunks(size.pixels()).enumerate() {
        recorder.push(mask, frame as f64 / 25.0)?;
    }
    let recording = recorder.finish()?;
    let moving: u64 = recording.moving_pixels.iter().map(|&n| u64::from(n)).sum();
    println!(
        "Recorder: {:.3} s; {:.1} % moving, {} silhouettes of {} points, {} of {} lines informative",
        started.elapsed().as_secs_f64(),
        100.0 * moving as f64 / masks.len() as f64,
        recording.silhouettes.len(),
        recording.silhouettes.points.len(),
        recording.barcodes.informative(&epibar::Informative::default()).len(),
        recording.barcodes.count,
    );
    let started = Instant::now();
    let barcodes = barcodes_of_segments(&masks, FRAMES, size, &recording.segments)?;
    println!("barcodes_of_segments: {:.3} s", started.elapsed().as_secs_f64());
    assert!(barcodes == recording.barcodes);
    let started = Instant::now();
    let frames: Vec<u32> = (0..FRAMES as u32).filter(|frame| frame % 5 != 0).collect();
    let part = barcodes.select_frames(&frames);
    println!("select_frames, {} of them: {:.3} s", part.frames, started.elapsed().as_secs_f64());
    Ok(())
}

/// Twenty squares of 40 × 40 pixels on straight paths that bounce, and 0.2 % noise.
fn mask(frame: usize) -> Vec<u8> {
    let bounce = |position: usize, room: usize| room - (position % (2 * room)).abs_diff(room);
    let mut mask = vec![0; SIZE.0 * SIZE.1];
    for i in 0..20 {
        let x = bounce(i * 97 + frame * (1 + i % 5), SIZE.0 - 40);
        let y = bounce(i * 61 + frame * (1 + i % 3), SIZE.1 - 40);
        for y in y..y + 40 {
            mask[y * SIZE.0 + x..y * SIZE.0 + x + 40].fill(255);
        }
    }
    let mut state = frame as u32;
    for _ in 0..mask.len() / 500 {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noisy = (state >> 8) as usize % mask.len();
        mask[noisy] = 255;
    }
    mask
}
