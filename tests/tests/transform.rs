//! The transform on the processor, which the studio's is measured against: right itself, and as small a measurement as can be.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pottery_client::render::{Gpu, probe_skin};
use pottery_shared::clay::{GridShape, Pot, PotSpec};
use pottery_tests::chart::machine::Machine;
use pottery_tests::chart::transform::{self, Way};
use pottery_tests::transform::CpuTransform;

/// A pot with waves round and along it.
fn wavy(shape: GridShape) -> Pot {
    let mut pot = Pot::new(PotSpec { shape, ..PotSpec::default() }).unwrap();
    let (columns, rows) = (shape.columns(), shape.rows());
    for column in 0..columns {
        for row in 0..rows {
            let (angle, along) = (column as f32 / columns as f32 * std::f32::consts::TAU, row as f32 / rows as f32);
            let radius_m = 0.056 + 0.003 * (3.0 * angle).sin() * (9.0 * along).cos();
            pot.surfaces_mut()[0].set_radius(column, row, radius_m);
        }
    }
    pot
}

#[test]
fn processor_and_shader_make_the_same_vertices() {
    let shape = GridShape::new(96, 80).unwrap();
    let pot = wavy(shape);
    let gpu = Gpu::headless().unwrap();
    let theirs = probe_skin(&gpu, &pot, pot.skins()[0]).unwrap();
    let mut transform = CpuTransform::new(shape);
    let ours = transform.transform(&pot);
    assert_eq!(ours.len(), theirs.len());
    for (element, (ours, theirs)) in ours.iter().zip(&theirs).enumerate() {
        let row = element as u32 % shape.rows();
        let apart_m = ours.position().distance(theirs.position_m);
        let turned_deg = ours.outwards().angle_between(theirs.normal).to_degrees();
        // f32 at 0.2 m; both take differences to both neighbours, where there are two, and the angle of two unit vectors is
        // known to the root of a rounding
        let most_deg = if row == 0 || row == shape.rows() - 1 { 2.0 } else { 0.05 };
        assert!(apart_m < 1e-7 && turned_deg < most_deg, "{ours:?} {theirs:?}: {apart_m} m, {turned_deg}°");
        assert!((ours.outwards().length() - 1.0).abs() < 1e-5);
    }
}

#[test]
fn every_way_is_measured_and_stands_in_every_file() {
    let gpu = Gpu::headless().unwrap();
    let shape = GridShape::new(90, 100).unwrap();
    let figures = transform::measure(&gpu, shape, true).unwrap();
    assert_eq!(figures.iter().map(|of| of.way).collect::<Vec<_>>(), Way::ALL);
    assert!(figures.iter().all(|of| of.transformation_ms.is_finite() && of.total.p50_us > 0.0), "{figures:?}");
    let files = transform::files(&figures, &Machine::this(None)).unwrap();
    let file = |name: &str| &files.iter().find(|(found, _)| *found == name).unwrap().1;
    let (table, page) = (String::from_utf8_lossy(file("transform.csv")), String::from_utf8_lossy(file("transform.md")));
    assert_eq!(table.lines().count(), 1 + Way::ALL.len(), "{table}");
    for way in Way::ALL {
        assert!(page.contains(way.title()), "{page}");
    }
    let picture = png::Decoder::new(std::io::Cursor::new(file("transform.png").as_slice())).read_info().unwrap();
    assert_eq!((picture.info().width, picture.info().height), (1400, 900));
}

#[test]
fn an_adapter_that_is_not_there_is_refused_with_those_that_are() {
    let out = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("transform");
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_accuracy-chart"))
        .args(["transform", "--adapter", "no such card", "--out"])
        .arg(&out)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("no adapter has such a name; there are: ") && said.contains("vulkan"), "{said}");
    assert!(!out.join("transform.csv").exists());
}
