//! Two views: fundamental matrices against cameras, pencils, areas, tangents, distances.

mod common;

use common::cameras::{Camera, error, fundamental, fundamental_matrix, points, random_pair};
use common::flying;
use common::masks::Random;
use epibar::internals::{LinePair, PencilHomography, area_between, epipolar_tangents};
use epibar::{Fundamental, ImageSize, Line, sampson_distance, symmetric_epipolar_distance};
use nalgebra::{Matrix3, Vector3};

fn line(homogeneous: &Vector3<f64>) -> Line {
    Line::from_homogeneous(homogeneous).unwrap()
}

fn at(p: [f64; 2]) -> Vector3<f64> {
    Vector3::new(p[0], p[1], 1.0)
}

/// Largest difference of two matrices of norm 1 that may differ in sign, with the columns for x and y and the rows
/// for x and y weighed by `scale` pixels, so that every entry counts.
fn difference(p: &Fundamental, q: &Matrix3<f64>, scale: f64) -> f64 {
    let weight = Matrix3::from_diagonal(&Vector3::new(scale, scale, 1.0));
    let (p, q) = (weight * p.matrix() * weight, weight * q * weight);
    let (p, q) = (p / p.norm(), q / q.norm());
    (p - q).amax().min((p + q).amax())
}

#[test]
fn a_thousand_scenes() {
    let mut random = Random(11);
    let mut transposed_errors = Vec::new();
    for _ in 0..1000 {
        let cameras = random_pair(&mut random);
        let matrix = fundamental_matrix(&cameras[0], &cameras[1]);
        let f = Fundamental::from_matrix(&matrix, cameras[0].size, cameras[1].size).unwrap();
        assert!((f.matrix().norm() - 1.0).abs() < 1e-12);
        assert!(difference(&f, &matrix, 300.0) < 1e-11);
        for (a, b) in points(&cameras, 5, &mut random) {
            assert!(symmetric_epipolar_distance(&f, a, b) < 1e-7);
            assert!(symmetric_epipolar_distance(&f.transposed(), b, a) < 1e-7);
            assert!(line(&f.line_in_b(&at(a))).signed_distance(b[0], b[1]).abs() < 1e-7);
            assert!(line(&f.line_in_a(&at(b))).signed_distance(a[0], a[1]).abs() < 1e-7);
        }
        // Each epipole is the image of the other camera.
        let centre_in_a = cameras[0].homogeneous(&cameras[1].centre()).normalize();
        let centre_in_b = cameras[1].homogeneous(&cameras[0].centre()).normalize();
        assert!(f.epipole_a().cross(&centre_in_a).norm() < 1e-9, "{centre_in_a} {}", f.epipole_a());
        assert!(f.epipole_b().cross(&centre_in_b).norm() < 1e-9, "{centre_in_b} {}", f.epipole_b());
        // Null vectors, each on its own side.
        assert!((f.matrix() * f.epipole_a()).norm() < 1e-12);
        assert!((f.matrix().transpose() * f.epipole_b()).norm() < 1e-12);
        transposed_errors.push(error(&f.transposed(), &cameras));
    }
    transposed_errors.sort_by(f64::total_cmp);
    assert!(transposed_errors[50] > 5.0, "95 % of the transposed are far off: {}", transposed_errors[50]);
}

#[test]
fn nearest_of_rank_two() {
    let mut random = Random(12);
    for _ in 0..200 {
        let cameras = random_pair(&mut random);
        let (a, b) = (cameras[0].size, cameras[1].size);
        // Noise of a thousandth in normalised coordinates, where all entries are alike.
        let scale = |size: ImageSize| {
            let unit = 2.0 / size.diagonal();
            Matrix3::from_diagonal(&Vector3::new(unit, unit, 1.0))
        };
        let noise = Matrix3::from_fn(|_, _| random.between(-1e-3, 1e-3));
        let exact = fundamental_matrix(&cameras[0], &cameras[1]);
        let denormalised = |m: &Matrix3<f64>, up: f64| {
            let weigh = |size| scale(size).map_diagonal(|d| d.powf(up));
            Matrix3::from_diagonal(&weigh(b)) * m * Matrix3::from_diagonal(&weigh(a))
        };
        let normalised = denormalised(&exact, -1.0);
        let noisy = denormalised(&(normalised / normalised.norm() + noise), 1.0);
        let f = Fundamental::from_matrix(&noisy, a, b).unwrap();
        // Rank 2 where the determinant means something, its epipoles the null vectors of the result.
        let result = denormalised(f.matrix(), -1.0);
        let mut values = (result / result.norm()).singular_values();
        values.as_mut_slice().sort_by(f64::total_cmp);
        assert!(values[0] < 1e-12 && values[1] > 1e-3, "{values}");
        assert!((f.matrix() * f.epipole_a()).norm() < 1e-12);
        assert!((f.matrix().tr_mul(f.epipole_b())).norm() < 1e-12);
        assert!(difference(&f, &exact, 200.0) < 2e-2);
    }
}

#[test]
fn no_fundamental_matrix() {
    let size = ImageSize::new(640, 480).unwrap();
    let of = |m: Matrix3<f64>| Fundamental::from_matrix(&m, size, size);
    assert!(of(Matrix3::zeros()).is_none());
    assert!(of(Matrix3::from_element(f64::NAN)).is_none());
    let mut infinite = Matrix3::identity();
    infinite[(1, 2)] = f64::INFINITY;
    assert!(of(infinite).is_none());
    let rank_one = Vector3::new(0.3, -0.2, 40.0) * Vector3::new(0.1, 0.7, -90.0).transpose();
    assert!(of(rank_one).is_none());
    assert!(Fundamental::from_rank_two(&rank_one).is_none());
}

/// Three epipolar line pairs: those of three points.
fn epipolar_pairs(f: &Fundamental, cameras: &[Camera; 2], random: &mut Random) -> Vec<LinePair> {
    let pair = |(a, b): ([f64; 2], [f64; 2])| LinePair {
        a: line(&f.epipole_a().cross(&at(a))),
        b: line(&f.epipole_b().cross(&at(b))),
    };
    points(cameras, 3, random).into_iter().map(pair).collect()
}

#[test]
fn three_epipolar_line_pairs_give_the_matrix() {
    let mut random = Random(13);
    for _ in 0..300 {
        let cameras = random_pair(&mut random);
        let sizes = [cameras[0].size, cameras[1].size];
        let f = fundamental(&cameras[0], &cameras[1]);
        let pairs = epipolar_pairs(&f, &cameras, &mut random);
        // A pencil of nearly equal lines has digits to lose.
        let apart = (0..3).map(|i| {
            let (p, q) = (&pairs[i].a, &pairs[(i + 1) % 3].a);
            (p.a() * q.b() - p.b() * q.a()).abs()
        });
        if apart.fold(f64::INFINITY, f64::min) < 0.02 {
            continue;
        }
        // The sign of a line says nothing.
        let flipped: Vec<LinePair> = pairs
            .iter()
            .enumerate()
            .map(
                |(i, pair)| {
                    if i == 1 { LinePair { a: line(&-pair.a.homogeneous()), ..*pair } } else { *pair }
                },
            )
            .collect();
        for pairs in [&pairs, &flipped] {
            let map = PencilHomography::from_line_pairs(f.epipole_a(), f.epipole_b(), pairs, sizes).unwrap();
            let found = map.fundamental().unwrap();
            assert!(difference(&found, f.matrix(), 300.0) < 1e-8);
            assert!(error(&found, &cameras) < 1e-5);
        }
    }
}

/// Paper eq. 3: `F = [e']× H^{-T}` for a homography of *lines* `l' = H l`, that is of points `x' = H^{-T} x`.
#[test]
fn the_pencil_gives_what_any_homography_of_it_gives() {
    let mut random = Random(14);
    let sizes = [ImageSize::new(640, 360).unwrap(), ImageSize::new(500, 480).unwrap()];
    for _ in 0..300 {
        let turn = random.between(-2.0, 2.0);
        let points_map = Matrix3::new(
            turn.cos() * random.between(0.6, 1.5),
            -turn.sin(),
            random.between(-80.0, 80.0),
            turn.sin(),
            turn.cos() * random.between(0.6, 1.5),
            random.between(-80.0, 80.0),
            random.between(-4e-4, 4e-4),
            random.between(-4e-4, 4e-4),
            1.0,
        );
        let lines_map = points_map.try_inverse().unwrap().transpose();
        let e = Vector3::new(random.between(-900.0, 1500.0), random.between(-900.0, 900.0), 1.0);
        let e_b = points_map * e;
        let pairs: Vec<LinePair> = [[50.0, 40.0], [600.0, 70.0], [320.0, 340.0]]
            .iter()
            .map(|&p| e.cross(&at(p)))
            .map(|l| LinePair { a: line(&l), b: line(&(lines_map * l)) })
            .collect();
        let crossing = |p: &Line, q: &Line| (p.a() * q.b() - p.b() * q.a()).abs();
        let apart = (0..3).map(|i| crossing(&pairs[i].a, &pairs[(i + 1) % 3].a));
        if apart.fold(f64::INFINITY, f64::min) < 0.02 {
            continue;
        }
        let expected = e_b.cross_matrix() * lines_map.try_inverse().unwrap().transpose();
        let found =
            PencilHomography::from_line_pairs(&e, &e_b, &pairs, sizes).unwrap().fundamental().unwrap();
        assert!(difference(&found, &expected, 300.0) < 1e-8);
        // Another H with the same action on the pencil: H + w eᵀ, since eᵀ l = 0.
        let other = lines_map + Vector3::new(2e-3, -1e-3, 0.4) * e.transpose();
        let other = e_b.cross_matrix() * other.try_inverse().unwrap().transpose();
        assert!(difference(&found, &other, 300.0) < 1e-7);
        // More pairs than three: the least squares of consistent ones agree.
        let mut more = pairs.clone();
        more.extend([[100.0, 300.0], [500.0, 10.0]].iter().map(|&p| {
            let l = e.cross(&at(p));
            LinePair { a: line(&l), b: line(&(lines_map * l)) }
        }));
        let found = PencilHomography::from_line_pairs(&e, &e_b, &more, sizes).unwrap().fundamental().unwrap();
        assert!(difference(&found, &expected, 300.0) < 1e-8);
    }
}

#[test]
fn pairs_that_fix_no_homography() {
    let mut random = Random(15);
    for _ in 0..50 {
        let cameras = random_pair(&mut random);
        let sizes = [cameras[0].size, cameras[1].size];
        let f = fundamental(&cameras[0], &cameras[1]);
        let solve = |pairs: &[LinePair]| {
            PencilHomography::from_line_pairs(f.epipole_a(), f.epipole_b(), pairs, sizes).is_some()
        };
        let [p, q, r] = epipolar_pairs(&f, &cameras, &mut random).try_into().unwrap();
        assert!(solve(&[p, q, r]));
        assert!(!solve(&[]) && !solve(&[p]) && !solve(&[p, q]));
        assert!(!solve(&[p, p, p]) && !solve(&[p, q, p]));
        // Two lines of one view that are one line: no invertible map.
        assert!(!solve(&[p, LinePair { a: p.a, b: q.b }, r]));
        assert!(!solve(&[p, LinePair { a: q.a, b: p.b }, r]));
        let nowhere = Vector3::zeros();
        assert!(PencilHomography::from_line_pairs(&nowhere, f.epipole_b(), &[p, q, r], sizes).is_none());
    }
}

/// The area by its definition: how many of a fine grid of points lie on which sides of both lines.
#[test]
fn area_between_lines_is_what_counting_gives() {
    const FINE: usize = 6;
    let mut random = Random(16);
    let size = ImageSize::new(64, 45).unwrap();
    let total = size.x_max() * size.y_max();
    let (mut crossing, mut apart) = (0, 0);
    for _ in 0..400 {
        let [p, q] = [(); 2].map(|()| {
            let (through, turn) = (
                [random.between(0.0, 63.0), random.between(0.0, 44.0)],
                random.between(0.0, std::f64::consts::TAU),
            );
            let (a, b) = (turn.cos(), turn.sin());
            line(&Vector3::new(a, b, -a * through[0] - b * through[1]))
        });
        let mut parts = [0; 4];
        let (columns, rows) = (63 * FINE, 44 * FINE);
        for i in 0..rows {
            for j in 0..columns {
                let [x, y] = [j, i].map(|k| (k as f64 + 0.5) / FINE as f64);
                let beyond = |line: &Line| usize::from(line.signed_distance(x, y) < 0.0);
                parts[2 * beyond(&p) + beyond(&q)] += 1;
            }
        }
        let cells = |n: usize| n as f64 / (FINE * FINE) as f64;
        let wedges = cells(parts[0] + parts[3]).min(cells(parts[1] + parts[2]));
        let empty: Vec<usize> = (0..4).filter(|k| parts[*k] == 0).collect();
        let crosses_at = p.homogeneous().cross(&q.homogeneous());
        let [x, y] = [crosses_at.x, crosses_at.y].map(|v| v / crosses_at.z);
        let inside =
            |by: f64| (-by..=size.x_max() + by).contains(&x) && (-by..=size.y_max() + by).contains(&y);
        // Where they cross on the border the area jumps, and a grid does not tell on which side of it they do.
        if inside(1.0) != inside(-1.0) || empty.len() > 1 {
            continue;
        }
        let counted = if inside(0.0) { wedges } else { cells(parts[3 - empty[0]]) };
        crossing += usize::from(inside(0.0));
        apart += usize::from(!inside(0.0));
        let area = area_between(&p, &q, size);
        // Counting errs by a fraction of a cell along some 200 px of lines.
        assert!((area - counted).abs() < 3.0, "{area} {counted} {p:?} {q:?}");
        let back = line(&-q.homogeneous());
        assert!((area_between(&q, &p, size) - area).abs() < 1e-9);
        assert!((area_between(&p, &back, size) - area).abs() < 1e-9);
    }
    assert!(crossing > 150 && apart > 50, "{crossing} {apart}");
    let outside = line(&Vector3::new(1.0, 0.0, 5.0));
    let inside = line(&Vector3::new(1.0, 0.0, -5.0));
    assert!((area_between(&outside, &inside, size) - total).abs() < 1e-9);
}

#[test]
fn tangents_from_epipoles_anywhere() {
    let mut random = Random(17);
    let (mut within, mut touching) = (0, 0);
    for round in 0..2000 {
        let count = 3 + random.below(9);
        let cloud = (0..count).map(|_| [random.between(0.0, 60.0), random.between(0.0, 40.0)]).collect();
        let mut hull = flying::hull(cloud);
        if round % 2 == 0 {
            hull.reverse();
        }
        let w = [1.0, -1.0, 1e-3, -40.0, 0.0][round % 5];
        let reach = [30.0, 200.0, 1e6][random.below(3)];
        let (x, y) = (random.between(-reach, reach), random.between(-reach, reach));
        let e = if w == 0.0 { Vector3::new(x, y, 0.0) } else { Vector3::new(x * w, y * w, w) };
        // Inside, the point is on one side of all edges; a point at infinity never is.
        let sides = hull.iter().enumerate().map(|(i, &p)| {
            let q = hull[(i + 1) % hull.len()];
            (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]) > 0.0
        });
        let positive = sides.filter(|&side| side).count();
        let inside = w != 0.0 && (positive == 0 || positive == hull.len());
        let Some(tangents) = epipolar_tangents(&hull, &e) else {
            assert!(inside, "{hull:?} {e}");
            within += 1;
            continue;
        };
        assert!(!inside, "{hull:?} {e}");
        assert!(tangents[0].positive && !tangents[1].positive);
        for tangent in tangents {
            assert!(hull.contains(&tangent.point));
            let l = line(&e.cross(&at(tangent.point)));
            for p in &hull {
                let d = l.signed_distance(p[0], p[1]);
                assert!(if tangent.positive { d > -1e-6 } else { d < 1e-6 }, "{d} {e} {hull:?}");
            }
        }
        touching += 1;
    }
    assert!(within > 20 && touching > 1000, "{within} {touching}");
    // A segment has tangents at its ends, and a point none.
    let segment = [[1.0, 1.0], [5.0, 3.0]];
    assert!(epipolar_tangents(&segment, &Vector3::new(0.0, 9.0, 1.0)).is_some());
    assert!(epipolar_tangents(&segment[..1], &Vector3::new(0.0, 9.0, 1.0)).is_none());
    assert!(epipolar_tangents(&[], &Vector3::new(0.0, 9.0, 1.0)).is_none());
}

#[test]
fn distances_by_hand() {
    let of = |m| Fundamental::from_rank_two(&m).unwrap();
    let close = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-12, "{value} {expected}");
    // Rectified cameras: y_a = y_b.
    let rectified = of(Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0));
    let (a, b) = ([10.0, 20.0], [50.0, 23.0]);
    close(symmetric_epipolar_distance(&rectified, a, b), 3.0);
    close(sampson_distance(&rectified, a, b), -3.0 / 2f64.sqrt());
    close(sampson_distance(&rectified, b, a), 3.0 / 2f64.sqrt());
    // B at half the scale: y_a = 2 y_b, so 20 against 13 is 6 px in A and 3 in B.
    let halved = of(Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, -2.0, 0.0, 1.0, 0.0));
    let (a, b) = ([70.0, 20.0], [5.0, 13.0]);
    close(symmetric_epipolar_distance(&halved, a, b), 4.5);
    close(sampson_distance(&halved, a, b), -6.0 / 5f64.sqrt());
    close(symmetric_epipolar_distance(&halved.transposed(), b, a), 4.5);
    close(line(&halved.line_in_b(&at(a))).signed_distance(b[0], b[1]).abs(), 3.0);
    close(line(&halved.line_in_a(&at(b))).signed_distance(a[0], a[1]).abs(), 6.0);
    // The epipole itself has no epipolar line.
    let e = Vector3::z();
    let around = Fundamental::from_rank_two(&e.cross_matrix()).unwrap();
    assert!(symmetric_epipolar_distance(&around, [0.0, 0.0], [3.0, 4.0]).is_infinite());
    assert!(symmetric_epipolar_distance(&around, [3.0, 4.0], [0.0, 0.0]).is_infinite());
    close(symmetric_epipolar_distance(&around, [3.0, 4.0], [6.0, 8.0]), 0.0);
}
