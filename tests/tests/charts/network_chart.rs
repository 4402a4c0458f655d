//! What `accuracy-chart network` says of lines, bytes and codecs, held to the laws that it shows.
//!
//! Measured once, as `--quick` does, over sessions that the real server records in virtual time.
//! Invariant under test: prediction is exact where nobody else presses, and our codec takes little more than its own contexts' entropy.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::PathBuf;
use std::process::Command;
use std::sync::LazyLock;

use pottery_server::recording::Recording;
use pottery_shared::clay::{MethodKind, Support};
use pottery_tests::chart::network::codecs::Scheme;
use pottery_tests::chart::network::prediction::{self, Case, Overlap};
use pottery_tests::chart::network::{NetworkExtent, NetworkFigures, Take, files, measure};
use pottery_tests::chart::progress::{Piece, Progress};
use pottery_tests::programs::{folder, program};

struct Chart {
    figures: NetworkFigures,
    folder: PathBuf,
    pieces: Vec<(u32, u32)>,
}

static CHART: LazyLock<Chart> = LazyLock::new(|| {
    let folder = folder("network-chart");
    let mut pieces = Vec::new();
    let mut progress = Progress::new(|piece: &Piece<'_>| pieces.push((piece.done, piece.of)));
    let figures = measure(&NetworkExtent::quick(), &folder, &[], &mut progress).unwrap();
    drop(progress);
    Chart { figures, folder, pieces }
});

/// Steps of the finest quantum, mm.
const STEP_MM: f64 = 1e3 / 262_144.0;

/// All that is looked at in the chart that was measured once: every test may be a process of its own, which would measure it again.
#[test]
fn the_chart_of_the_network_holds_to_the_laws_that_it_shows() {
    own_clay_that_nobody_else_touches_is_predicted_to_the_last_bit_at_any_latency_and_loss();
    a_tool_far_away_costs_a_step_and_one_that_overlaps_is_felt();
    coarser_and_rarer_take_fewer_bytes_and_show_less();
    our_codec_is_within_five_per_cent_of_its_contexts_entropy_and_far_below_the_others();
    sessions_are_kept_and_whole();
    progress_tells_of_every_piece_that_was_expected();
    every_file_has_rows_and_every_picture_is_whole();
}

fn own_clay_that_nobody_else_touches_is_predicted_to_the_last_bit_at_any_latency_and_loss() {
    let alone = CHART.figures.prediction.iter().filter(|figures| figures.case.overlap == Overlap::Alone);
    let mut seen = 0;
    for figures in alone {
        println!("{figures:?}");
        assert_eq!((figures.worst_mm, figures.corrected_mm, figures.exact), ([0.0; 3], 0.0, 1.0), "{figures:?}");
        seen += figures.snapshots;
    }
    assert!(seen > 300, "{seen} snapshots");
}

fn a_tool_far_away_costs_a_step_and_one_that_overlaps_is_felt() {
    let p99 = |overlap: Overlap| {
        let own = CHART.figures.prediction.iter().filter(|of| of.case.overlap == overlap && of.case.loss_percent == 0);
        own.map(|figures| figures.worst_mm[1]).fold(0.0, f64::max)
    };
    // it makes the pot higher, by as little as it presses in a way and back
    assert!(p99(Overlap::Apart) < 2.5 * STEP_MM, "{}", p99(Overlap::Apart));
    assert!(p99(Overlap::Overlapping) > 20.0 * STEP_MM, "{}", p99(Overlap::Overlapping));
    // both press 2.5 mm deep at most
    assert!(CHART.figures.prediction.iter().all(|figures| figures.worst_mm[2] < 2.5), "{:?}", CHART.figures.prediction);
}

/// A welcome that was lost and said again tells an older time. A hand that stamped by it was late for five seconds, and its clay off by 0.6 mm.
/// What rounding alone leaves is 0.3 of a step, root of the mean square.
#[test]
fn who_came_over_a_long_line_that_loses_presses_in_time_at_once() {
    let folder = folder("network-chart-welcome");
    let lines = [1, 5, 10];
    let mut corrected_mm = 0.0;
    for loss_percent in lines {
        let case = Case { round_trip_ms: 400, loss_percent, overlap: Overlap::Apart };
        let figures = prediction::measure(&case, 3.0, &folder).unwrap();
        println!("{figures:?}");
        assert!(figures.worst_mm[1] <= 3.0 * STEP_MM && figures.worst_mm[2] < 5.0 * STEP_MM, "{figures:?}");
        assert!(figures.rms_mm < 0.5 * STEP_MM, "{figures:?}");
        // what a prediction is off by is what it is corrected by
        assert!(figures.corrected_mm < 5.0 * STEP_MM, "{figures:?}");
        corrected_mm += figures.corrected_mm / lines.len() as f64;
    }
    // the largest correction of a line is that of one element, which rounding moves by a step
    assert!(corrected_mm < 4.0 * STEP_MM, "{corrected_mm} mm");
}

fn coarser_and_rarer_take_fewer_bytes_and_show_less() {
    let all = &CHART.figures.subscription;
    let NetworkExtent { subscribed, details, .. } = NetworkExtent::quick();
    assert_eq!(all.len(), subscribed * details.len());
    for one in all {
        let is_finer = |other: &&_| -> bool {
            let other: &pottery_tests::chart::network::subscription::SubscriptionFigures = other;
            (other.quantum_um < one.quantum_um && other.rate_hz == one.rate_hz)
                || (other.quantum_um == one.quantum_um && other.rate_hz > one.rate_hz)
        };
        for finer in all.iter().filter(is_finer) {
            assert!(finer.bytes_per_s > one.bytes_per_s, "{finer:?} and {one:?}");
            assert!(finer.error_um[0] < one.error_um[0], "{finer:?} and {one:?}");
        }
    }
}

fn our_codec_is_within_five_per_cent_of_its_contexts_entropy_and_far_below_the_others() {
    let sessions = NetworkExtent::quick().takes.len();
    let all = &CHART.figures.codecs;
    assert_eq!(all.len(), sessions * Scheme::ALL.len());
    for session in all.chunks(Scheme::ALL.len()) {
        let bytes = |scheme| session.iter().find(|figures| figures.scheme == scheme).unwrap().bytes;
        let (ours, least) = (bytes(Scheme::Ours), bytes(Scheme::OursEntropy));
        println!(
            "{}: {ours:.1} B a snapshot, {:.2} % above the entropy",
            session[0].session,
            100.0 * (ours / least - 1.0)
        );
        assert!(session[0].snapshots > 100 && session[0].cells > 100.0, "{:?}", session[0]);
        // learning costs something at first; a clay that changes is followed better than by one probability for the whole session
        assert!(ours < 1.05 * least && ours > 0.9 * least, "{ours} and {least}");
        let others = [Scheme::Cells, Scheme::Tiles, Scheme::TilesZstd1, Scheme::TilesZstd19, Scheme::TilesEntropy];
        assert!(others.into_iter().all(|other| ours < 0.5 * bytes(other)), "{session:?}");
    }
}

/// A hollow pot has three surfaces, and every scheme tells all of them.
#[test]
fn a_session_of_a_hollow_pot_is_told_in_every_scheme() {
    let folder = folder("network-chart-hollow");
    let take = Take { method: MethodKind::Plastic, support: Support::Hollow, people: 2, seconds: 1.5 };
    let recorded = take.record(&folder).unwrap();
    let extent = NetworkExtent { prediction: Vec::new(), takes: Vec::new(), subscribed: 0, ..NetworkExtent::quick() };
    let mut progress = Progress::new(|_: &Piece<'_>| ());
    let NetworkFigures { codecs, .. } = measure(&extent, &folder, &[recorded], &mut progress).unwrap();
    assert_eq!(codecs.len(), Scheme::ALL.len());
    println!("{codecs:?}");
    let bytes = |scheme| codecs.iter().find(|figures| figures.scheme == scheme).unwrap().bytes;
    assert!(codecs[0].snapshots > 50 && codecs[0].cells > 100.0, "{:?}", codecs[0]);
    let others = [Scheme::Cells, Scheme::Tiles, Scheme::TilesZstd1, Scheme::TilesZstd19, Scheme::TilesEntropy];
    assert!(others.into_iter().all(|other| bytes(Scheme::Ours) < bytes(other)), "{codecs:?}");
}

fn sessions_are_kept_and_whole() {
    let mut sessions = 0;
    // the recordings are there once all is measured
    assert!(!CHART.figures.codecs.is_empty());
    for entry in std::fs::read_dir(&CHART.folder).unwrap() {
        let path = entry.unwrap().path();
        assert_eq!(path.extension().unwrap(), "session");
        assert!(Recording::open(std::fs::File::open(&path).unwrap()).unwrap().is_whole(), "{}", path.display());
        sessions += 1;
    }
    assert_eq!(sessions, NetworkExtent::quick().takes.len());
}

fn progress_tells_of_every_piece_that_was_expected() {
    let expected = CHART.pieces[0].1;
    assert_eq!(CHART.pieces, (0..expected).map(|done| (done, expected)).collect::<Vec<_>>());
}

fn every_file_has_rows_and_every_picture_is_whole() {
    for (name, bytes) in files(&CHART.figures).unwrap() {
        if name.ends_with(".csv") {
            let text = String::from_utf8(bytes).unwrap();
            let columns = text.lines().next().unwrap().split(',').count();
            assert!(text.lines().count() > 4, "{name}");
            assert!(text.lines().all(|line| line.split(',').count() == columns), "{name}");
            continue;
        }
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height), (1400, 900), "{name}");
        let dark = pixels.chunks_exact(3).filter(|pixel| pixel.iter().all(|part| *part < 128)).count();
        let share = dark as f64 / (1400.0 * 900.0);
        assert!((0.002..0.3).contains(&share), "{name}: {share} of it is dark");
    }
}

#[test]
fn a_session_that_is_none_is_refused_in_a_sentence() {
    let folder = folder("network-chart-refused");
    let file = folder.join("none.session");
    std::fs::write(&file, "no session").unwrap();
    let out = folder.join("out");
    let run = |flags: &[&str]| {
        let output = Command::new(program("accuracy-chart")).arg("network").args(flags).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let said = run(&["--quick", "--out", out.to_str().unwrap(), "--session", file.to_str().unwrap()]);
    assert!(said.contains("none.session cannot be gone through: it is no session file"), "{said}");
    assert!(!out.exists(), "a folder was made for nothing");
    assert!(run(&[]).contains("--out"));
}
