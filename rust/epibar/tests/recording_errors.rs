//! What a recorder and a stored recording refuse, and that they say why.

use epibar::{Error, ImageSize, Recorder, RecorderOptions, Recording, Segment, barcodes_of_segments};

type Damage = fn(&mut Recording);

fn recorder() -> Recorder {
    let options = RecorderOptions { lines: 20, ..Default::default() };
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
    assert_eq!(recording.moving_pixels, [108, 0]);
    recording.validate().unwrap();
}

#[test]
fn nothing_to_record() {
    assert_eq!(recorder().finish().unwrap_err(), Error::NoFrames);
    for lines in [0, 10_000_001] {
        let options = RecorderOptions { lines, ..Default::default() };
        let made = Recorder::new(ImageSize::new(12, 9).unwrap(), options);
        assert!(matches!(made, Err(Error::Argument { name: "lines", .. })));
    }
    let flat = ImageSize { width: 12, height: 1 };
    assert!(matches!(Recorder::new(flat, RecorderOptions::default()), Err(Error::ImageSize { .. })));
}

#[test]
fn masks_and_segments_that_do_not_fit() {
    let size = ImageSize::new(12, 9).unwrap();
    let segment = Segment { x0: -3.0, y0: 4.0, x1: 20.0, y1: 4.0 };
    let barcodes = barcodes_of_segments(&[1; 216], 2, size, &[segment]).unwrap();
    assert_eq!(barcodes.bits, [0b11]);
    assert_eq!(barcodes_of_segments(&[], 0, size, &[segment]).unwrap().count, 1);
    assert_eq!(barcodes_of_segments(&[1; 216], 2, size, &[]).unwrap().frames, 2);
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
    recording().validate().unwrap();
    let damages: [(&str, Damage); 25] = [
        ("times order", |r| r.times.swap(3, 4)),
        ("times finite", |r| r.times[69] = f64::INFINITY),
        ("times length", |r| r.times.truncate(69)),
        ("segments length", |r| r.segments.truncate(19)),
        ("segment", |r| r.segments[7].y1 = f64::NAN),
        ("barcode frames", |r| r.barcodes.frames = 71),
        ("barcode count", |r| r.barcodes.count = usize::MAX),
        ("barcode words", |r| r.barcodes.words_per = 1),
        ("barcode bits", |r| r.barcodes.bits.truncate(39)),
        ("barcode padding", |r| r.barcodes.bits[5] |= 1 << 6),
        ("heat length", |r| r.heat.push(0)),
        ("heat range", |r| r.heat[3] = 71),
        ("heat sum", |r| r.heat[3] += 1),
        ("moving length", |r| r.moving_pixels.truncate(69)),
        ("moving range", |r| r.moving_pixels[2] = 109),
        ("frame table start", |r| r.silhouettes.frame_start[0] = 1),
        ("frame table order", |r| r.silhouettes.frame_start[5] = 9),
        ("frame table length", |r| r.silhouettes.frame_start.push(70)),
        ("frame table empty", |r| r.silhouettes.frame_start.clear()),
        ("hull table", |r| {
            r.silhouettes.hull_start[5] = r.silhouettes.hull_start[4];
        }),
        ("points", |r| r.silhouettes.points.push([0, 0])),
        ("point range", |r| r.silhouettes.points[4] = [12, 3]),
        ("area", |r| r.silhouettes.area[0] = 0),
        ("border", |r| r.silhouettes.border.truncate(3)),
        ("visible", |r| r.visible = Some(vec![1; 107].into())),
    ];
    for (name, damage) in damages {
        let mut damaged = recording();
        damage(&mut damaged);
        let error = damaged.validate().unwrap_err();
        assert!(matches!(error, Error::Damaged(_)), "{name}: {error}");
    }
    let mut empty = recording();
    empty.times.clear();
    assert_eq!(empty.validate().unwrap_err(), Error::NoFrames);
}
