//! What a recorder and a stored recording refuse, and that they say why.

use epibar::internals::barcodes_of_segments;
use epibar::{Barcodes, Error, ImageSize, Recorder, RecorderOptions, Recording, RecordingParts, Segment};

type Damage = fn(&mut RecordingParts);

fn recorder() -> Recorder {
    let options = RecorderOptions::new().lines(20);
    Recorder::new(ImageSize::new(12, 9).unwrap(), options).unwrap()
}

fn recording() -> Recording {
    let mut recorder = recorder();
    for frame in 0..70 {
        let mut mask = vec![0; 108];
        for y in 2..6 {
            mask[y * 12 + frame % 7..y * 12 + frame % 7 + 4].fill(1);
        }
        recorder.push(&mask, frame as f64).unwrap();
    }
    recorder.finish().unwrap()
}

#[test]
fn a_recorder_refuses_and_goes_on() {
    let mut recorder = recorder();
    recorder.push(&[1; 108], 1.0).unwrap();
    assert!(matches!(
        recorder.push(&[1; 107], 2.0),
        Err(Error::MaskSize { frame: 1, actual: 107, width: 12, height: 9 })
    ));
    for time in [1.0, 0.5, f64::NAN, f64::INFINITY] {
        assert!(matches!(recorder.push(&[1; 108], time), Err(Error::FrameTime { frame: 1, .. })));
    }
    assert_eq!(recorder.frames(), 1);
    recorder.push(&[0; 108], 1.5).unwrap();
    let recording = recorder.finish().unwrap();
    assert_eq!(recording.moving_pixels(), [108, 0]);
    assert_eq!(Recording::try_from(RecordingParts::from(recording.clone())).unwrap(), recording);
}

#[test]
fn nothing_to_record() {
    assert_eq!(recorder().finish().unwrap_err(), Error::NoFrames);
    for lines in [0, 10_000_001] {
        let options = RecorderOptions::new().lines(lines);
        let made = Recorder::new(ImageSize::new(12, 9).unwrap(), options);
        assert!(matches!(made, Err(Error::Argument { name: "lines", .. })));
    }
    assert!(matches!(ImageSize::new(12, 1), Err(Error::ImageSize { width: 12, height: 1 })));
}

#[test]
fn masks_and_segments_that_do_not_fit() {
    let size = ImageSize::new(12, 9).unwrap();
    let segment = Segment { x0: -3.0, y0: 4.0, x1: 20.0, y1: 4.0 };
    let barcodes = barcodes_of_segments(&[1; 216], 2, size, &[segment]).unwrap();
    assert_eq!(barcodes.words(), [0b11]);
    assert_eq!(barcodes_of_segments(&[], 0, size, &[segment]).unwrap().count(), 1);
    assert_eq!(barcodes_of_segments(&[1; 216], 2, size, &[]).unwrap().frames(), 2);
    assert!(matches!(
        barcodes_of_segments(&[1; 215], 2, size, &[segment]),
        Err(Error::Length { left: 215, right: 216, .. })
    ));
    let bad = Segment { x1: f64::NAN, ..segment };
    let refused = barcodes_of_segments(&[1; 216], 2, size, &[segment, bad]);
    assert!(matches!(refused, Err(Error::Argument { name: "segments", .. })));
}

#[test]
fn every_kind_of_damage_is_found() {
    let damages: [(&str, Damage); 22] = [
        ("times order", |r| r.times.swap(3, 4)),
        ("times finite", |r| r.times[69] = f64::INFINITY),
        ("times length", |r| r.times.truncate(69)),
        ("segments length", |r| r.segments.truncate(19)),
        ("segment", |r| r.segments[7].y1 = f64::NAN),
        ("barcode bits", |r| r.barcodes.truncate(39)),
        ("barcode padding", |r| r.barcodes[5] |= 1 << 6),
        ("heat length", |r| r.heat.push(0)),
        ("heat range", |r| r.heat[3] = 71),
        ("heat sum", |r| r.heat[3] += 1),
        ("moving length", |r| r.moving_pixels.truncate(69)),
        ("moving range", |r| r.moving_pixels[2] = 109),
        ("frame table start", |r| r.frame_start[0] = 1),
        ("frame table order", |r| r.frame_start[5] = 9),
        ("frame table length", |r| r.frame_start.push(70)),
        ("frame table empty", |r| r.frame_start.clear()),
        ("hull table", |r| {
            r.hull_start[5] = r.hull_start[4];
        }),
        ("points", |r| r.hull_points.push([0, 0])),
        ("point range", |r| r.hull_points[4] = [12, 3]),
        ("area", |r| r.hull_area[0] = 0),
        ("border", |r| r.hull_border.truncate(3)),
        ("visible", |r| r.visible = Some(vec![1; 107])),
    ];
    for (name, damage) in damages {
        let mut damaged = RecordingParts::from(recording());
        damage(&mut damaged);
        let error = Recording::try_from(damaged).unwrap_err();
        assert!(matches!(error, Error::Damaged(_)), "{name}: {error}");
    }
    let mut empty = RecordingParts::from(recording());
    empty.times.clear();
    assert_eq!(Recording::try_from(empty).unwrap_err(), Error::NoFrames);
    let mut flat = RecordingParts::from(recording());
    flat.size = [12, 1];
    assert!(matches!(Recording::try_from(flat), Err(Error::ImageSize { .. })));
    assert!(matches!(Barcodes::from_words(2, 70, vec![0; 3]), Err(Error::Damaged(_))));
    assert!(matches!(Barcodes::from_words(1, 70, vec![0, 1 << 6]), Err(Error::Damaged(_))));
}
