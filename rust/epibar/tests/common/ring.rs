//! Four cameras round what flies, and what they record of it.

use epibar::network::{Expected, PosedCamera, StoredCamera};
use epibar::{Recorder, RecorderOptions, Recording};

use super::cameras::Camera;
use super::flying::Scene;

/// Frames of a recording, at 25 a second.
pub const FRAMES: usize = 260;
/// What the cameras are called.
pub const NAMES: [&str; 4] = ["cam1", "cam2", "cam3", "cam4"];

/// Cameras that differ in everything.
pub fn cameras() -> Vec<Camera> {
    [
        ([5.4, -3.0, 2.6], (320, 240), 300.0, 0.10),
        ([-2.6, -6.0, 1.5], (368, 208), 340.0, -0.14),
        ([-4.5, 3.8, 2.9], (320, 240), 260.0, 0.03),
        ([3.0, 5.5, 0.6], (336, 252), 350.0, 0.07),
    ]
    .map(|(position, size, focal, roll)| Camera::new(position, [0.0, 0.1, 1.2], size, focal, roll).centred())
    .to_vec()
}

/// A recording whose frame number `k` shows the scene at its moment `moment(k)`.
pub fn recorded(
    scene: &Scene,
    camera: &Camera,
    options: RecorderOptions,
    moment: impl Fn(usize) -> f64,
) -> Recording {
    let mut recorder = Recorder::new(camera.size, options).unwrap();
    for frame in 0..FRAMES {
        recorder.push(&scene.seen_by(camera, moment(frame)), frame as f64 / 25.0).unwrap();
    }
    recorder.finish().unwrap()
}

/// A camera as a network has it.
pub fn posed(camera: &Camera) -> PosedCamera {
    PosedCamera {
        matrix: camera.matrix(),
        distortions: [0.0; 5],
        rotation: camera.rotation(),
        translation: -(camera.rotation() * camera.centre()),
    }
}

/// Cameras of a stored network, and what they saw since.
pub fn stored<'r>(
    cameras: &[Camera],
    recordings: &'r [Recording],
    expected: Expected,
) -> Vec<StoredCamera<'r>> {
    let seen = cameras.iter().zip(recordings).zip(NAMES);
    seen.map(|((camera, recording), name)| StoredCamera::new(name, recording, posed(camera), expected))
        .collect()
}
