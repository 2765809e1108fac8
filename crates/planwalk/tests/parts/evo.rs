//! Do the scores of an odometry agree with evo's?
//!
//! The numbers are those of evo 1.38.1: `evo_ape kitti TRUTH ESTIMATE -r trans_part|angle_deg [-a [-s]]`,
//! `evo_rpe kitti TRUTH ESTIMATE -r trans_part|angle_deg -d 1 -u m|f [-a [-s]]` (`tum` for the .tum files), printed in full.

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use planwalk::evaluate::{Alignment, OdometryScoreOptions, odometry};
use planwalk::types::{Body, Odom, Rigid3, Stamp};

/// What evo says of one estimate under one alignment.
struct Evo {
    files: [&'static str; 2],
    alignment: Alignment,
    /// RMSE, mean, median, standard deviation, largest; metres.
    ate_m: [f64; 5],
    /// RMSE, mean; degrees.
    rotation_deg: [f64; 2],
    metre_pairs: usize,
    /// RMSE and mean of metres, then of degrees.
    rpe_metre: [f64; 4],
    /// RMSE and mean of metres, then of degrees.
    rpe_frame: [f64; 4],
}

const ORB: [&str; 2] = ["kitti_odometry/KITTI_00_ORB.txt", "kitti_odometry/KITTI_00_gt.txt"];
const SPTAM: [&str; 2] = ["kitti_odometry/KITTI_00_SPTAM.txt", "kitti_odometry/KITTI_00_gt.txt"];
const HILTI1: [&str; 2] =
    ["simulated_hilti/floor_1_2025-05-05_run_1_seed1.tum", "simulated_hilti/floor_1_2025-05-05_run_1_seed1.truth.tum"];
const HILTI2: [&str; 2] =
    ["simulated_hilti/floor_2_2025-10-28_run_1_seed2.tum", "simulated_hilti/floor_2_2025-10-28_run_1_seed2.truth.tum"];

#[rustfmt::skip]
const EVO: [Evo; 12] = [
    Evo {
        files: ORB, alignment: Alignment::None, metre_pairs: 2718,
        ate_m: [7.790288882657, 7.011750401667, 6.801631674560, 3.394695447308, 13.458508807382],
        rotation_deg: [1.609558710630, 1.538165059974],
        rpe_metre: [0.046200726197, 0.027810877560, 0.192440487176, 0.076351726272],
        rpe_frame: [0.028120377017, 0.019301310981, 0.114973521260, 0.059583454923],
    },
    Evo {
        files: ORB, alignment: Alignment::Se3, metre_pairs: 2718,
        ate_m: [1.303449714565, 1.156997128539, 1.065624769556, 0.600282269397, 3.587949120679],
        rotation_deg: [0.756300516635, 0.616516410542],
        rpe_metre: [0.046200726197, 0.027810877560, 0.192440487176, 0.076351726272],
        rpe_frame: [0.028120377017, 0.019301310981, 0.114973521260, 0.059583454923],
    },
    Evo {
        files: ORB, alignment: Alignment::Sim3, metre_pairs: 2731,
        ate_m: [0.937709073611, 0.872692631969, 0.844691013486, 0.343082900827, 2.693499863613],
        rotation_deg: [0.756300516635, 0.616516410542],
        rpe_metre: [0.045130859234, 0.026997273548, 0.191240636741, 0.076236266301],
        rpe_frame: [0.027822453344, 0.018952973985, 0.114973521260, 0.059583454923],
    },
    Evo {
        files: SPTAM, alignment: Alignment::None, metre_pairs: 2727,
        ate_m: [9.224541737238, 8.623703555189, 8.282321409625, 3.274737738241, 14.911823227679],
        rotation_deg: [2.409096917509, 2.195778103080],
        rpe_metre: [0.051041191844, 0.034765646381, 0.454393232024, 0.343979277874],
        rpe_frame: [0.034919367573, 0.023406450625, 0.296389843246, 0.241716405113],
    },
    Evo {
        files: SPTAM, alignment: Alignment::Se3, metre_pairs: 2727,
        ate_m: [3.738487907583, 3.490976633085, 3.642584641743, 1.337674841805, 7.768977406571],
        rotation_deg: [1.725539722051, 1.377128609945],
        rpe_metre: [0.051041191844, 0.034765646381, 0.454393232024, 0.343979277874],
        rpe_frame: [0.034919367573, 0.023406450625, 0.296389843246, 0.241716405113],
    },
    Evo {
        files: SPTAM, alignment: Alignment::Sim3, metre_pairs: 2751,
        ate_m: [3.635293564339, 3.357305778621, 3.479863755296, 1.394222797032, 7.291831027982],
        rotation_deg: [1.725539722051, 1.377128609945],
        rpe_metre: [0.051386988033, 0.034759515257, 0.452052892573, 0.342984409098],
        rpe_frame: [0.035017252976, 0.023520177023, 0.296389843246, 0.241716405113],
    },
    Evo {
        files: HILTI1, alignment: Alignment::None, metre_pairs: 134,
        ate_m: [45.907247747773, 43.982875465170, 42.813365791283, 13.152264504288, 70.095410827235],
        rotation_deg: [173.152148533006, 173.126604354327],
        rpe_metre: [0.122303419609, 0.103445391491, 0.363580908404, 0.284244408105],
        rpe_frame: [0.025603844483, 0.021726889878, 0.155552866029, 0.122567426440],
    },
    Evo {
        files: HILTI1, alignment: Alignment::Se3, metre_pairs: 134,
        ate_m: [1.269512995131, 1.102972850912, 0.942634129843, 0.628581048837, 2.715505983137],
        rotation_deg: [3.059293825017, 2.525715579795],
        rpe_metre: [0.122303419609, 0.103445391491, 0.363580908404, 0.284244408105],
        rpe_frame: [0.025603844483, 0.021726889878, 0.155552866029, 0.122567426440],
    },
    Evo {
        files: HILTI1, alignment: Alignment::Sim3, metre_pairs: 144,
        ate_m: [0.645815875101, 0.591341539281, 0.562216352064, 0.259602250477, 1.485772877281],
        rotation_deg: [3.059293825017, 2.525715579795],
        rpe_metre: [0.064153002188, 0.052896912993, 0.344377187512, 0.267632032172],
        rpe_frame: [0.015098457006, 0.012303796148, 0.155552866029, 0.122567426440],
    },
    Evo {
        files: HILTI2, alignment: Alignment::None, metre_pairs: 114,
        ate_m: [33.570973771254, 32.403729564798, 33.087691366789, 8.775453848187, 50.470502136349],
        rotation_deg: [132.071565344461, 132.065947536105],
        rpe_metre: [0.189142879425, 0.178320715386, 0.330221436375, 0.263863214690],
        rpe_frame: [0.044954674231, 0.041656979805, 0.166090306120, 0.130267278071],
    },
    Evo {
        files: HILTI2, alignment: Alignment::Se3, metre_pairs: 114,
        ate_m: [1.658141938310, 1.496097399457, 1.332375942853, 0.714931646328, 3.282028325308],
        rotation_deg: [1.225109273495, 1.029790313552],
        rpe_metre: [0.189142879425, 0.178320715386, 0.330221436375, 0.263863214690],
        rpe_frame: [0.044954674231, 0.041656979805, 0.166090306120, 0.130267278071],
    },
    Evo {
        files: HILTI2, alignment: Alignment::Sim3, metre_pairs: 130,
        ate_m: [0.652552446378, 0.532628656399, 0.430349728400, 0.377003195818, 1.952458070359],
        rotation_deg: [1.225109273495, 1.029790313552],
        rpe_metre: [0.060023938640, 0.046706138040, 0.335076866724, 0.270847501575],
        rpe_frame: [0.016929127241, 0.013166144564, 0.166090306120, 0.130267278071],
    },
];

type Poses = Vec<(Stamp, Rigid3<Odom, Body>)>;

/// TUM lines, or KITTI lines a second apart; `None`, said aloud, where the data is not there and not required.
#[expect(clippy::print_stderr, reason = "a skipped test says so")]
fn read(name: &str) -> Option<Poses> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    let path = std::env::var_os("PLANWALK_DATA").map_or_else(|| beside.into(), std::path::PathBuf::from).join(name);
    let Ok(text) = std::fs::read_to_string(&path) else {
        let required = std::env::var_os("PLANWALK_REQUIRE_DATA").is_some_and(|v| v == "1");
        assert!(!required, "PLANWALK_REQUIRE_DATA=1, but {} is missing", path.display());
        eprintln!("skipped: no {name} (set PLANWALK_DATA to the folder of real data)");
        return None;
    };
    let lines = text.lines().filter(|line| !line.starts_with('#') && !line.trim().is_empty());
    Some(lines.enumerate().map(|(i, line)| pose(i, line)).collect())
}

fn pose(index: usize, line: &str) -> (Stamp, Rigid3<Odom, Body>) {
    let n: Vec<f64> = line.split_whitespace().map(|cell| cell.parse().unwrap()).collect();
    if n.len() == 8 {
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(n[7], n[4], n[5], n[6]));
        return (Stamp::from_secs(n[0]).unwrap(), Rigid3::from_parts(Vector3::new(n[1], n[2], n[3]), turn));
    }
    let turn = Rotation3::from_matrix_unchecked(Matrix3::new(n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10]));
    let turn = UnitQuaternion::from_rotation_matrix(&turn);
    (Stamp(index as i64 * 1_000_000_000), Rigid3::from_parts(Vector3::new(n[3], n[7], n[11]), turn))
}

fn close(what: &str, of: &Evo, ours: &[f64], evos: &[f64], tolerance: f64) {
    for (a, b) in ours.iter().zip(evos) {
        assert!((a - b).abs() < tolerance, "{what} of {:?}, {}: {a} for evo's {b}", of.files, of.alignment);
    }
}

#[test]
fn odometry_scores_are_those_of_evo() {
    for evo in &EVO {
        let (Some(estimate), Some(truth)) = (read(evo.files[0]), read(evo.files[1])) else { return };
        let ours = odometry::score(&estimate, &truth, evo.alignment, &OdometryScoreOptions::default()).unwrap();
        let (ate, turn) = (ours.ate_m, ours.rotation_deg.unwrap());
        let (metre, frame) = (ours.rpe_metre.unwrap(), ours.rpe_frame.unwrap());
        // Two programs on the same numbers. Positions agree to round-off; KITTI's matrices of seven digits are no rotations to
        // the last one, and each program makes them so in its own way.
        close("ATE", evo, &[ate.rmse, ate.mean, ate.median, ate.std, ate.max], &evo.ate_m, 1e-9);
        close("rotation", evo, &[turn.rmse, turn.mean], &evo.rotation_deg, 1e-6);
        assert_eq!(metre.pairs, evo.metre_pairs, "{:?}", evo.files);
        let four = |e: &odometry::RelativeError| [e.translation_m.rmse, e.translation_m.mean, e.rotation_deg.rmse, e.rotation_deg.mean];
        close("RPE a metre", evo, &four(&metre), &evo.rpe_metre, 1e-6);
        close("RPE a frame", evo, &four(&frame), &evo.rpe_frame, 1e-6);
    }
}
