//! Does what was given of a camera agree with what moves?
//!
//! A number that is given is held, and errors are stated as if it were right. Where another one explains what moves so much better that
//! chance does not explain it, what was given is contradicted.

use nalgebra::{DMatrix, DVector};

use super::alternatives::Alternative;
use crate::network::given::input::IntrinsicKind;
use crate::network::model::camera::{Camera, CameraStep};
use crate::network::thresholds as limits;

/// What was given of a camera, and is contradicted by what moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contradiction {
    /// Which camera.
    pub camera: usize,
    /// What was given.
    pub kind: IntrinsicKind,
    /// By how much another value fits better, a normal deviate.
    pub deviate: f64,
}

/// What is contradicted, and the cameras as they stand without that.
#[derive(Debug, Clone, PartialEq)]
pub struct Contradictions {
    /// Camera by camera, all of one kind.
    pub found: Vec<Contradiction>,
    /// Every camera as it is without that, and with what was given of it where that is not contradicted.
    pub cameras: Vec<Camera>,
}

/// What is contradicted of a network, of whose alternatives; of several kinds the one that explains most, as a wrong focal length asks for
/// another principal point as well.
pub fn contradictions(given: &[Camera], alternatives: &[Alternative]) -> Option<Contradictions> {
    let contradicted = alternatives.iter().filter_map(|one| Some((one.gain, contradicted(given, one)?)));
    contradicted.max_by(|p, q| p.0.total_cmp(&q.0)).map(|(_, found)| found)
}

fn contradicted(given: &[Camera], alternative: &Alternative) -> Option<Contradictions> {
    let Alternative { kind, freed, .. } = alternative;
    let by_evidence = by_evidence(alternative);
    let of_camera = |&camera: &usize| {
        let (off, covariance) = alternative.off(&[camera])?;
        let by_itself = deviate(&off, covariance)?;
        let deviate = if by_itself >= limits::CONTRADICTED_DEVIATES { by_itself } else { by_evidence? };
        Some(Contradiction { camera, kind: *kind, deviate })
    };
    let found: Vec<Contradiction> = freed.iter().filter_map(of_camera).collect();
    let mut cameras = alternative.solved.network.cameras.clone();
    for &c in freed.iter().filter(|&&c| found.iter().all(|one| one.camera != c)) {
        cameras[c] = with_given(&cameras[c], &given[c], *kind);
    }
    (!found.is_empty()).then_some(Contradictions { found, cameras })
}

/// A camera with the numbers of one kind as they were given: what is held stays where it starts.
fn with_given(camera: &Camera, given: &Camera, kind: IntrinsicKind) -> Camera {
    let mut step = CameraStep::zeros();
    for &k in kind.parameters() {
        step[k] = given.intrinsic()[k] - camera.intrinsic()[k];
    }
    camera.stepped(&step)
}

/// By how much an alternative in one camera fits better, as a normal deviate, where what the tangents cost says that chance does not
/// explain it (Wilks 1938).
fn by_evidence(alternative: &Alternative) -> Option<f64> {
    let numbers = alternative.kind.parameters().len() as f64;
    (alternative.log_evidence? >= limits::CONTRADICTED_NATS)
        .then(|| normal_of_chi_square(2.0 * (alternative.gain + numbers), numbers))
}

/// How many standard deviations what fits is from what was given, as a normal deviate; `None` where that is not known.
fn deviate(off: &DVector<f64>, covariance: DMatrix<f64>) -> Option<f64> {
    let squared = off.dot(&covariance.cholesky()?.solve(off));
    Some(normal_of_chi_square(squared, off.len() as f64))
}

/// The normal deviate that is as rare as a χ² (the cube-root approximation of Wilson and Hilferty 1931).
fn normal_of_chi_square(squared: f64, freedom: f64) -> f64 {
    let variance = 2.0 / (9.0 * freedom);
    ((squared / freedom).cbrt() - (1.0 - variance)) / variance.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::evidence::alternatives::alternatives;
    use crate::network::evidence::alternatives::tests::solved;
    use crate::network::evidence::outlines::Shapes;
    use crate::network::given::input::AS_SOLD;
    use crate::network::solve::networks::Solved;
    use crate::network::solve::principal::Likely;

    fn found_in(solved: &Solved) -> Option<Contradictions> {
        let tried = alternatives(solved, &Likely::only(AS_SOLD), Shapes::Masks);
        contradictions(&solved.network.cameras, &tried)
    }

    #[test]
    fn what_is_right_is_not_contradicted() {
        assert_eq!(found_in(&solved(|_, _| ())), None);
    }

    #[test]
    fn a_false_focal_length_is_of_its_camera() {
        let false_one = solved(|c, camera| camera.log_focal += if c == 2 { 0.1 } else { 0.0 });
        let found = found_in(&false_one).unwrap().found;
        let [one] = found[..] else { panic!("{found:?}") };
        assert_eq!((one.camera, one.kind), (2, IntrinsicKind::Focal));
        // What was given of the others is what they go on with.
        let found = found_in(&false_one).unwrap().cameras;
        for (c, camera) in found.iter().enumerate() {
            let given = false_one.network.cameras[c].log_focal;
            assert_eq!((camera.log_focal - given).abs() < 1e-12, c != 2, "{c}: {} {given}", camera.log_focal);
        }
    }

    #[test]
    fn two_false_focal_lengths_are_of_their_cameras() {
        let by = [0.0, -0.1, 0.1, 0.0];
        let found = found_in(&solved(|c, camera| camera.log_focal += by[c])).unwrap();
        let of: Vec<usize> = found.found.iter().map(|c| c.camera).collect();
        assert_eq!(of, [1, 2]);
        let turned_back = found.cameras[1].log_focal - (480_f64.ln() - 0.1);
        assert!((turned_back - 0.1).abs() < 0.01, "{turned_back}");
    }

    #[test]
    fn a_false_principal_point_is_of_its_camera_though_all_are_given() {
        let aside = |c: usize, camera: &mut Camera| camera.principal[0] += if c == 1 { 60.0 } else { 0.0 };
        let false_one = solved(aside);
        let found = found_in(&false_one).unwrap().found;
        let [one] = found[..] else { panic!("{found:?}") };
        assert_eq!((one.camera, one.kind), (1, IntrinsicKind::PrincipalPoint));
    }

    #[test]
    fn pixels_that_are_a_little_off_square_may_be_outlines() {
        let of = |aspect: f64| {
            let one = solved(|c, camera| camera.log_aspect += if c == 1 { aspect } else { 0.0 });
            found_in(&one).map_or(vec![], |found| found.found)
        };
        assert_eq!(of(0.008), []);
        let [one] = of(0.03)[..] else { panic!("{:?}", of(0.03)) };
        assert_eq!((one.camera, one.kind), (1, IntrinsicKind::Aspect));
    }

    #[test]
    fn a_chi_square_is_as_rare_as_a_normal_deviate() {
        // On both sides, and the approximation is a little short of rare ones.
        for (z, one_sided) in [(2.0, 1.69), (4.0, 3.83), (6.0, 5.88)] {
            let found = normal_of_chi_square(f64::powi(z, 2), 1.0);
            assert!((0.9 * one_sided..1.03 * one_sided).contains(&found), "{z}: {found}");
        }
        // Of three numbers 21.1 is as rare as 3.7 of one on one side (p = 1e-4).
        assert!((normal_of_chi_square(21.108, 3.0) - 3.72).abs() < 0.1);
        assert!(normal_of_chi_square(f64::NAN, 3.0).is_nan());
    }
}
