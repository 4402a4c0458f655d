//! The pot file: what comes back is what was written, and what was not written so is refused.
//!
//! Invariant under test: bytes make a pot or a sentence, in memory that the bytes and the largest grid bound.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use pottery_client::pot_file::{FormatError, PotFile, PotFileError};
use pottery_shared::clay::{
    Conditions, GridShape, Material, MethodKind, Phase, Pot, PotSpec, Schedule, Support, Surface, Wetness, Wheel,
    Window,
};
use pottery_shared::snapshot::{Author, Moment, PotRecord, QUANTUM_M, Replica, Touched, Version};
use pottery_shared::units::{Metres, Rpm, Tick};
use pottery_tests::dice::Dice;
use pottery_tests::programs::folder;
use proptest::prelude::*;

/// Notes the largest block that a thread asks for.
struct Watching;

thread_local! {
    static LARGEST: Cell<usize> = const { Cell::new(0) };
}

fn note(bytes: usize) {
    LARGEST.with(|largest| largest.set(largest.get().max(bytes)));
}

// SAFETY: hands everything on to the system's allocator as it is; the note is a plain cell that allocates nothing.
unsafe impl GlobalAlloc for Watching {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note(layout.size());
        // SAFETY: the caller's promises are passed on
        unsafe { System.alloc(layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        note(new_size);
        // SAFETY: the caller's promises are passed on
        unsafe { System.realloc(memory, layout, new_size) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are passed on
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Watching = Watching;

/// The largest block asked for meanwhile, bytes.
fn largest_block(work: impl FnOnce()) -> usize {
    LARGEST.set(0);
    work();
    LARGEST.get()
}

fn everywhere(shape: GridShape) -> Window {
    Window { first_column: 0, columns: shape.columns(), first_row: 0, rows: shape.rows() }
}

/// A pot on a wheel, after a snapshot of radii that dice and a belly chose.
fn on_a_wheel(spec: PotSpec, seed: u64) -> (Pot, Author) {
    let mut pot = Pot::new(spec).unwrap();
    let mut author = Author::new(&mut pot);
    let mut dice = Dice::new(seed);
    let (shape, (low_m, high_m)) = (spec.shape, pot.surfaces()[0].bounds_m());
    for column in 0..shape.columns() {
        for row in 0..shape.rows() {
            let height = row as f32 / (shape.rows() - 1) as f32;
            let belly_m = spec.radius.0 * (1.0 + 0.2 * (3.0 * height).sin());
            let any_m = low_m + (high_m - low_m) * dice.share() as f32;
            let radius_m = if dice.share() < 0.9 { belly_m + 1e-4 * dice.share() as f32 } else { any_m };
            pot.surfaces_mut()[0].set_radius(column, row, radius_m);
            if let [outer, inner, ..] = pot.surfaces_mut() {
                let within_m = outer.column_m(column)[row as usize] - 2.0 * spec.wall.0 * dice.share() as f32;
                inner.set_radius(column, row, within_m);
            }
        }
    }
    let mut touched = Touched::none(pot.surfaces().iter().map(Surface::shape));
    (0..pot.surfaces().len()).for_each(|surface| touched.add_window(surface, everywhere(shape)));
    author.publish(&mut pot, &mut touched, Moment::default()).unwrap();
    (pot, author)
}

fn conditions(method: MethodKind, wetness: f32, rpm: f32) -> Conditions {
    Conditions {
        wheel: Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(rpm))),
        material: Schedule::new(Material::from_wetness(Wetness::nearest(wetness))),
        method,
    }
}

fn small_hollow_spec() -> PotSpec {
    PotSpec { support: Support::Hollow, ..small_spec() }
}

fn small_spec() -> PotSpec {
    PotSpec { shape: GridShape::new(24, 16).unwrap(), ..PotSpec::default() }
}

fn small_file() -> PotFile {
    PotFile::of(&on_a_wheel(small_spec(), 7).0, &conditions(MethodKind::Plastic, 0.3, 60.0), Tick(0))
}

/// A file's bytes with a checksum that fits them.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let end = bytes.len() - 4;
    let checksum = crc32fast::hash(&bytes[..end]);
    bytes[end..].copy_from_slice(&checksum.to_le_bytes());
    bytes
}

/// The small file with other bytes at a place, and a length and a checksum that fit.
fn with(at: usize, value: &[u8]) -> Vec<u8> {
    let mut bytes = small_file().encode();
    bytes[at..at + value.len()].copy_from_slice(value);
    sealed(bytes)
}

fn assert_is_a_sentence(text: &str) {
    assert!((10..300).contains(&text.len()) && !text.contains(['\n', '{', '}']), "{text}");
}

fn any_spec() -> impl Strategy<Value = PotSpec> {
    (8_u32..40, 4_u32..40, 20.0_f32..600.0, 10.0_f32..150.0, 0.0_f32..1.0, any::<bool>(), any::<bool>()).prop_map(
        |(columns, rows, height_mm, radius_mm, wall, keeps_volume, is_hollow)| PotSpec {
            shape: GridShape::new(columns, rows).unwrap(),
            height: Metres::from_mm(height_mm),
            radius: Metres::from_mm(radius_mm),
            wall: Metres::from_mm(1.0 + (radius_mm * 0.499 - 1.0) * wall),
            keeps_volume,
            support: if is_hollow { Support::Hollow } else { Support::Backed },
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn pot_read_back_is_the_pot_on_the_wheel(
        spec in any_spec(), seed in any::<u64>(), method in 0_u8..3, wetness in 0.0_f32..1.0, rpm in -400.0_f32..400.0,
    ) {
        let (pot, _) = on_a_wheel(spec, seed);
        let conditions = conditions(MethodKind::from_number(method), wetness, rpm);
        let file = PotFile::of(&pot, &conditions, Tick(0));
        let read = PotFile::decode(&file.encode()).unwrap();
        prop_assert_eq!(&read, &file);
        let again = read.pot().pot();
        prop_assert_eq!(again.digest(), pot.digest());
        prop_assert_eq!(again.surfaces()[0].height_m().to_bits(), pot.surfaces()[0].height_m().to_bits());
        prop_assert_eq!(again.pressed_m3().to_bits(), pot.pressed_m3().to_bits());
        prop_assert!(again == pot);
        prop_assert_eq!(read.method(), conditions.method);
        prop_assert_eq!(read.clay(), conditions.material.at(Tick(0)));
        prop_assert_eq!(read.wheel_speed(), conditions.wheel.speed(Tick(0)));
    }

    #[test]
    fn whatever_the_bytes_say_nothing_breaks(
        changes in proptest::collection::vec((0_usize..2000, any::<u8>()), 1..6),
        cut in proptest::option::of(0_usize..2000),
    ) {
        let mut bytes = small_file().encode();
        let length = bytes.len();
        for (at, value) in changes {
            // signature, version and length are refused before the rest is looked at; the rest is what is tried here
            bytes[16 + at % (length - 20)] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(76 + cut % (length - 76));
            let length = bytes.len() as u32;
            bytes[12..16].copy_from_slice(&length.to_le_bytes());
        }
        match PotFile::decode(&sealed(bytes)) {
            Err(error) => assert_is_a_sentence(&error.to_string()),
            Ok(file) => prop_assert_eq!(PotFile::decode(&file.encode()), Ok(file)),
        }
    }

    #[test]
    fn bytes_of_any_kind_are_refused(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        prop_assert_eq!(PotFile::decode(&bytes), Err(FormatError::NotAPot));
    }
}

#[test]
fn no_byte_can_be_changed_unseen() {
    let bytes = small_file().encode();
    for at in 0..bytes.len() {
        for flip in [0x01, 0x80, 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] ^= flip;
            let error = PotFile::decode(&damaged).unwrap_err();
            assert_is_a_sentence(&error.to_string());
        }
    }
}

#[test]
fn cut_short_or_grown_is_refused() {
    let bytes = small_file().encode();
    for length in 0..bytes.len() {
        let error = PotFile::decode(&bytes[..length]).unwrap_err();
        let expected = if length < 8 { "no pot file" } else { "take another copy" };
        assert!(error.to_string().contains(expected), "{length} bytes: {error}");
    }
    let error = PotFile::decode(&[&bytes[..], b"\n"].concat()).unwrap_err();
    assert_eq!(error, FormatError::Length { bytes: bytes.len() + 1, expected: bytes.len() });
}

#[test]
fn file_from_the_future_is_refused_whatever_else_it_holds() {
    let bytes = [&small_file().encode()[..8], &3_u32.to_le_bytes(), b"who knows"].concat();
    assert_eq!(PotFile::decode(&bytes), Err(FormatError::FromTheFuture { version: 3, newest: 2 }));
    assert_eq!(PotFile::decode(&with(8, &[0; 4])), Err(FormatError::Number { field: "version", number: 0 }));
}

#[test]
fn numbers_that_make_no_pot_are_refused() {
    for (at, value, expected) in [
        (16, u32::MAX.to_le_bytes(), "a grid of 4294967295"),
        (20, 3_u32.to_le_bytes(), "x 3 rows"),
        (24, f32::NAN.to_le_bytes(), "height of NaN"),
        (24, 7.0_f32.to_le_bytes(), "height of 7000"),
        (28, 0.0_f32.to_le_bytes(), "radius of 0"),
        (32, 1.0_f32.to_le_bytes(), "wall of 1000"),
        (36, 401.0_f32.to_le_bytes(), "401 rpm"),
        (36, f32::NAN.to_le_bytes(), "NaN rpm"),
        (40, (-1.0_f32).to_le_bytes(), "viscosity"),
        (44, f32::INFINITY.to_le_bytes(), "Young's modulus"),
        (48, 0.0_f32.to_le_bytes(), "yield stress"),
        (52, [2, 0, 2, 1], "rule for the volume 2"),
        (52, [1, 9, 2, 1], "support 9"),
        (52, [1, 0, 3, 1], "method 3"),
        (52, [1, 0, 2, 2], "count of surfaces 2"),
        (64, [1, 2, 3, 4], "come out differently"),
    ] {
        let error = PotFile::decode(&with(at, &value)).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
        assert_is_a_sentence(&error);
    }
}

#[test]
fn radius_beyond_what_its_pot_takes_is_refused() {
    // a wall of 29 mm keeps the skin farther from the axis than the file's narrowest radii
    let narrow = PotRecord::new(small_spec(), vec![vec![(0.012 / QUANTUM_M) as u16; 24 * 16]]).unwrap();
    let bytes = PotFile::of(&narrow.pot(), &Conditions::default(), Tick(0)).encode();
    let mut thick = bytes.clone();
    thick[32..36].copy_from_slice(&0.029_f32.to_le_bytes());
    let error = PotFile::decode(&sealed(thick)).unwrap_err().to_string();
    assert!(error.contains("a radius of 12.00 mm") && error.contains("column 0, row 0"), "{error}");
}

#[test]
fn claims_of_size_cost_no_memory() {
    // the largest grid claimed, with radii for 384 elements
    let claims = with(16, &[4096_u32.to_le_bytes(), 1024_u32.to_le_bytes()].concat());
    // a stream that unpacks to 8 MB where 768 bytes belong
    let largest = PotSpec { shape: GridShape::new(4096, 1024).unwrap(), ..PotSpec::default() };
    let mut bomb = PotFile::of(&Pot::new(largest).unwrap(), &Conditions::default(), Tick(0)).encode();
    assert!(bomb.len() < 64 << 10, "{} bytes for a pot that nobody touched", bomb.len());
    bomb[16..24].copy_from_slice(&[24_u32.to_le_bytes(), 16_u32.to_le_bytes()].concat());
    for bytes in [claims, sealed(bomb)] {
        let block = largest_block(|| assert_eq!(PotFile::decode(&bytes), Err(FormatError::Packing)));
        // the window of a zlib stream is 32 kB and its reader's buffer as much again
        assert!(block < 256 << 10, "{block} bytes in one block");
    }
}

#[test]
fn pot_of_the_paper_takes_as_much_room_as_its_marks() {
    let untouched = PotFile::of(&Pot::new(PotSpec::default()).unwrap(), &Conditions::default(), Tick(0)).encode();
    // two flat planes of 144,000 bytes are runs of 258: a bit or two each
    assert!(untouched.len() < 600, "{} bytes for an untouched pot", untouched.len());
    let (rough, _) = on_a_wheel(PotSpec::default(), 3);
    let bytes = PotFile::of(&rough, &Conditions::default(), Tick(0)).encode();
    assert!(bytes.len() < 2 * rough.spec().shape.elements() + 200, "{} bytes for dice", bytes.len());
}

#[test]
fn wheel_that_begins_with_a_record_brings_late_comers_the_pot() {
    let (saved, _) = on_a_wheel(small_spec(), 21);
    let record = PotRecord::of(&saved);
    let mut pot = Pot::new(small_spec()).unwrap();
    let author = Author::starting_from(&mut pot, &record);
    assert!(pot == saved, "the wheel begins with the pot that was saved");
    assert_eq!(author.latest(), Version(1));
    let mut replica = Replica::new(Pot::new(small_spec()).unwrap());
    let mut touched = Touched::none(pot.surfaces().iter().map(Surface::shape));
    let keyframe = author.keyframe(Version(0), false);
    replica.apply_keyframe(author.latest(), Version(0), &keyframe, false, &mut touched).unwrap();
    assert!(*replica.pot() == saved);
    assert_eq!(replica.digest(), author.digest());
}

#[test]
fn record_of_an_untouched_pot_is_version_0() {
    let record = PotRecord::of(&Pot::new(small_spec()).unwrap());
    let mut pot = Pot::new(small_spec()).unwrap();
    assert_eq!(Author::starting_from(&mut pot, &record).latest(), Version(0));
}

#[test]
fn file_of_version_1_is_read_for_good() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/pots/version-1.pot");
    let file = PotFile::read(&path).unwrap();
    assert_eq!(file.pot().pot().digest(), 0xd446_9ea1_8e1d_e2f6);
    assert_eq!((file.method(), file.wheel_speed().0.round()), (MethodKind::Plastic, 60.0));
}

#[test]
fn a_hollow_pot_keeps_both_skins_and_one_of_version_1_gets_its_inner_one() {
    let (squeezed, _) = on_a_wheel(small_hollow_spec(), 5);
    let conditions = conditions(MethodKind::Plastic, 0.3, 60.0);
    let bytes = PotFile::of(&squeezed, &conditions, Tick(0)).encode();
    assert_eq!((bytes[8], bytes[55]), (2, 2), "version and surfaces");
    assert!(PotFile::decode(&bytes).unwrap().pot().pot() == squeezed);
    assert_eq!(small_file().encode()[8], 1, "what older readers know stays as they know it");
    // as a wheel of its day wrote it: the outer skin of a hollow pot alone
    let mut old = small_file().encode();
    old[53] = 1;
    let read = PotFile::decode(&sealed(old)).unwrap().pot().pot();
    let [outer, inner, ..] = read.surfaces() else { panic!("a hollow pot has two skins") };
    assert_eq!(outer.radii_m(), small_file().pot().pot().surfaces()[0].radii_m());
    let wall_mm = outer.radii_m().iter().zip(inner.radii_m()).map(|(outer_m, inner_m)| (outer_m - inner_m) * 1e3);
    assert!(wall_mm.into_iter().all(|wall_mm| (wall_mm - 8.0).abs() < 0.01 || wall_mm < 8.0));
    // skins that cross are no wall
    let crossed = PotRecord::new(small_hollow_spec(), vec![vec![15_000; 24 * 16], vec![15_001; 24 * 16]]);
    assert!(crossed.unwrap_err().to_string().contains("column 0, row 0"));
}

#[test]
fn file_is_written_and_read_and_says_its_name_when_it_cannot_be() {
    let folder = folder("pot-written");
    let path = folder.join("bowl.pot");
    small_file().write(&path).unwrap();
    assert_eq!(PotFile::read(&path).unwrap(), small_file());
    fs::write(&path, &small_file().encode()[..200]).unwrap();
    let error = PotFile::read(&path).unwrap_err();
    assert!(matches!(error, PotFileError::Format { .. }) && error.to_string().contains("bowl.pot"), "{error}");
    for path in [folder.join("none.pot"), folder.clone(), PathBuf::from("/dev/zero")] {
        let error = PotFile::read(&path).unwrap_err().to_string();
        assert!(error.contains(path.to_str().unwrap()), "{error}");
        assert_is_a_sentence(&error);
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn reader_in_the_description_reads_the_same_radii() {
    let description =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/files/POT-FILE.md")).unwrap();
    let (_, program) = description.split_once("```python\n").unwrap();
    let (program, _) = program.split_once("```").unwrap();
    let folder = folder("pot-described");
    let path = folder.join("small.pot");
    let hollow = on_a_wheel(small_hollow_spec(), 9).0;
    for file in [small_file(), PotFile::of(&hollow, &conditions(MethodKind::Plastic, 0.3, 60.0), Tick(0))] {
        file.write(&path).unwrap();
        let output = Command::new("python3").args(["-c", program]).arg(&path).output().unwrap_or_else(|error| {
            panic!("python3 cannot be run ({error}): install it, on Debian `apt install python3`")
        });
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).unwrap();
        let mut lines = text.lines();
        let (head, pot) = (lines.next().unwrap(), file.pot().pot());
        let [columns, rows, height_mm] =
            [0, 1, 2].map(|word| head.split(' ').nth(word).unwrap().parse::<f64>().unwrap());
        assert_eq!((columns as u32, rows as u32), (24, 16));
        assert!((height_mm - f64::from(pot.surfaces()[0].height_m()) * 1e3).abs() < 1e-3, "{head}");
        for surface in &pot.surfaces()[..pot.spec().skins()] {
            let mm = |&radius_m: &f32| format!("{:.6}", f64::from(radius_m) * 1e3);
            let expected: Vec<_> = surface.radii_m().iter().map(mm).collect();
            assert_eq!(lines.next().unwrap().split(' ').collect::<Vec<_>>(), expected);
        }
        assert_eq!(lines.next(), None);
    }
    fs::remove_dir_all(folder).unwrap();
}
