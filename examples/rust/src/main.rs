//! Two cameras calibrated by what moves before both, in a program that uses the crate `epibar` as anybody would.
//!
//! `cargo run -- FOLDER` draws masks of flying balls, records them and saves the recordings as `FOLDER/a.npz` and
//! `FOLDER/b.npz`. Then, or with recordings of your own by `cargo run -- A.npz B.npz FOLDER`, it loads them,
//! calibrates the pair, prints the result and saves it as `FOLDER/pair.npz`. Python reads and writes the same files.

use std::error::Error;
use std::path::{Path, PathBuf};

use epibar::{
    CalibrateOptions, Calibration, ImageSize, Recorder, RecorderOptions, Recording, SavedRecording, Stage,
    calibrate_watched,
};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let (a, b, folder) = match arguments.as_slice() {
        [folder] => {
            std::fs::create_dir_all(folder)?;
            let (a, b) = (folder.join("a.npz"), folder.join("b.npz"));
            record(ImageSize::new(160, 140)?, |phase| 80.0 + 60.0 * (1.7 * phase).sin())?.save(&a)?;
            record(ImageSize::new(180, 140)?, |phase| 90.0 + 65.0 * (2.3 * phase).cos())?.save(&b)?;
            (a, b, folder)
        }
        [a, b, folder] => (a.clone(), b.clone(), folder),
        _ => return Err("give a folder, or two recordings and a folder".into()),
    };
    let calibration = calibrate_files(&a, &b)?;
    calibration.save(folder.join("pair.npz"))?;
    print(&Calibration::load(folder.join("pair.npz"))?);
    Ok(())
}

/// Balls that fly before two cameras far away and at a right angle to one another: how high they fly is common to both,
/// where across the image is not, and the epipolar lines are horizontal.
fn record(size: ImageSize, across: fn(f64) -> f64) -> epibar::Result<Recording> {
    let mut recorder = Recorder::new(size, RecorderOptions::new().lines(2000))?;
    for frame in 0..200 {
        let mut mask = vec![0; size.pixels()];
        for ball in 0..4 {
            let phase = 0.05 * f64::from(frame) * (1.0 + 0.3 * f64::from(ball)) + f64::from(ball);
            let (u, v, radius) = (across(phase), 70.0 + 45.0 * phase.cos(), 6.0 + f64::from(ball));
            for (pixel, value) in mask.iter_mut().enumerate() {
                let (x, y) = ((pixel % size.width()) as f64, (pixel / size.width()) as f64);
                *value |= u8::from((x - u).hypot(y - v) < radius);
            }
        }
        recorder.push(&mask, f64::from(frame) / 25.0)?;
    }
    recorder.finish()
}

fn calibrate_files(a: &Path, b: &Path) -> epibar::Result<Calibration> {
    let (a, b) = (SavedRecording::load(a)?, SavedRecording::load(b)?);
    let mut options = CalibrateOptions::new().seed(0);
    if let (Some(in_a), Some(in_b)) = (a.matrix, b.matrix) {
        options = options.cameras(epibar::CameraMatrices::new(in_a, in_b)?);
    }
    let mut last = None;
    let mut watch = |stage: Stage, _done: f64| {
        if last.replace(stage) != Some(stage) {
            eprintln!("{} ...", stage.name());
        }
        true
    };
    calibrate_watched(&a.recording, &b.recording, &options, &mut watch)
}

fn print(calibration: &Calibration) {
    println!("{}: {}", calibration.verdict.kind.name(), calibration.verdict.reason);
    if let Some(f) = &calibration.fundamental {
        println!("F, such that x_b^T F x_a = 0:{:12.3e}", f.matrix());
    }
    if let Some(error) = calibration.expected_error {
        println!("expected error {error:.3} px, {} frontier points", calibration.frontier_points.len());
    }
}
