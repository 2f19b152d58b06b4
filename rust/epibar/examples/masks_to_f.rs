//! From masks to a fundamental matrix: `cargo run --release --example masks_to_f [seed]`.
//!
//! Balls fly through a room, seen by two cameras with nothing in common but the room. The cameras' positions
//! are used to draw the masks and, in the end, to say how far off the result is; the calibration sees
//! masks only.

use epibar::nalgebra::{Matrix3, Vector3};
use epibar::{
    CalibrateOptions, Fundamental, ImageSize, Recorder, RecorderOptions, Recording, calibrate,
    symmetric_epipolar_distance,
};
use std::time::Instant;

const FRAMES: usize = 300;
const BALLS: usize = 6;

fn main() -> epibar::Result<()> {
    let seed: u64 = std::env::args().nth(1).and_then(|seed| seed.parse().ok()).unwrap_or(0);
    let cameras = [
        Camera::new([5.5, -3.0, 2.4], (320, 240), 290.0, 0.06)?,
        Camera::new([-2.5, -6.0, 1.6], (384, 216), 350.0, -0.10)?,
    ];
    let balls: Vec<Ball> = (0..BALLS).map(|i| Ball::new(seed * BALLS as u64 + i as u64)).collect();

    let started = Instant::now();
    let [a, b] = [record(&cameras[0], &balls)?, record(&cameras[1], &balls)?];
    println!("drawn and recorded in {:.1} s", started.elapsed().as_secs_f64());
    let started = Instant::now();
    let calibration = calibrate(&a, &b, &CalibrateOptions::default())?;
    println!("calibrated in {:.1} s\n", started.elapsed().as_secs_f64());

    println!("{}: {}", calibration.verdict.kind.name(), calibration.verdict.reason);
    if let Some(f) = calibration.fundamental {
        println!("\nF, such that x_bᵀ F x_a = 0:{:12.3e}", f.matrix());
        if let Some(expected) = calibration.expected_error {
            println!("expected error            {expected:6.3} px");
        }
        println!("error against the truth   {:6.3} px", error(&f, &cameras, &balls));
    }
    Ok(())
}

/// A camera that looks at the middle of the room, turned a little about its axis. World: z up, metres.
struct Camera {
    size: ImageSize,
    k: Matrix3<f64>,
    rotation: Matrix3<f64>,
    position: Vector3<f64>,
}

impl Camera {
    fn new(position: [f64; 3], size: (usize, usize), focal: f64, roll: f64) -> epibar::Result<Self> {
        let size = ImageSize::new(size.0, size.1)?;
        let position = Vector3::from(position);
        let forward = (Vector3::new(0.0, 0.0, 1.2) - position).normalize();
        let right = forward.cross(&Vector3::z()).normalize();
        let down = forward.cross(&right);
        let (sin, cos) = roll.sin_cos();
        let rows = [right * cos + down * sin, down * cos - right * sin, forward];
        let k = Matrix3::new(focal, 0.0, 0.5 * size.x_max(), 0.0, focal, 0.5 * size.y_max(), 0.0, 0.0, 1.0);
        Ok(Self { size, k, rotation: Matrix3::from_rows(&rows.map(|row| row.transpose())), position })
    }

    fn project(&self, point: &Vector3<f64>) -> [f64; 2] {
        let x = self.k * self.rotation * (point - self.position);
        [x.x / x.z, x.y / x.z]
    }

    /// Sets the pixels whose rays meet a ball.
    fn draw(&self, ball: &Ball, frame: usize, mask: &mut [u8]) {
        let centre = self.rotation * (ball.centre(frame) - self.position);
        let [x, y] = self.project(&ball.centre(frame));
        let reach = 2.0 * self.k[(0, 0)] * ball.radius / centre.z;
        let range = |at: f64, size: usize| {
            (at - reach).max(0.0) as usize..((at + reach + 1.0).max(0.0) as usize).min(size)
        };
        let back = self.k.try_inverse().unwrap_or_else(Matrix3::identity);
        for row in range(y, self.size.height()) {
            for column in range(x, self.size.width()) {
                let ray = (back * Vector3::new(column as f64, row as f64, 1.0)).normalize();
                if (centre - ray * ray.dot(&centre)).norm() < ball.radius {
                    mask[row * self.size.width() + column] = 255;
                }
            }
        }
    }
}

/// A ball on a smooth closed path.
struct Ball {
    radius: f64,
    speed: Vector3<f64>,
    phase: Vector3<f64>,
}

impl Ball {
    fn new(seed: u64) -> Self {
        let mut state = seed;
        // SplitMix64, as numbers from 0 to 1.
        let mut random = || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
            (z >> 11) as f64 / (1u64 << 53) as f64
        };
        Self {
            radius: 0.15 + 0.2 * random(),
            speed: Vector3::from_fn(|_, _| 0.03 + 0.07 * random()),
            phase: Vector3::from_fn(|_, _| std::f64::consts::TAU * random()),
        }
    }

    fn centre(&self, frame: usize) -> Vector3<f64> {
        let path = (self.speed * frame as f64 + self.phase).map(f64::sin);
        path.component_mul(&Vector3::new(1.9, 1.9, 0.9)) + Vector3::new(0.0, 0.0, 1.2)
    }
}

fn record(camera: &Camera, balls: &[Ball]) -> epibar::Result<Recording> {
    let mut recorder = Recorder::new(camera.size, RecorderOptions::new().lines(6000))?;
    for frame in 0..FRAMES {
        let mut mask = vec![0; camera.size.pixels()];
        for ball in balls {
            camera.draw(ball, frame, &mut mask);
        }
        recorder.push(&mask, frame as f64 / 25.0)?;
    }
    recorder.finish()
}

/// Mean symmetric epipolar distance of the centres of the balls, pixels.
fn error(f: &Fundamental, [a, b]: &[Camera; 2], balls: &[Ball]) -> f64 {
    let centres: Vec<_> = balls.iter().flat_map(|ball| (0..FRAMES).map(|frame| ball.centre(frame))).collect();
    let distance =
        |centre: &Vector3<f64>| symmetric_epipolar_distance(f, a.project(centre), b.project(centre));
    centres.iter().map(distance).sum::<f64>() / centres.len() as f64
}
