//! The stroke file: what it says is where the tool is, what it cannot say is refused by line, and what is recorded
//! can be read again.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::PathBuf;

use glam::Vec3;
use pottery_client::stroke::{SampleError, Stroke, StrokeError, StrokeRecorder};
use pottery_shared::tool::{Orientation, Shape, Sphere, Tool};
use pottery_shared::units::{Metres, Rpm};
use proptest::prelude::*;

const HEADER: &str = "t_s,x_mm,y_mm,z_mm\n";
const TURNING: &str = "t_s,x_mm,y_mm,z_mm,yaw_deg,pitch_deg,roll_deg\n";
const UPRIGHT: Orientation = Orientation([0; 3]);

fn rows(rows: &str) -> Result<Stroke, StrokeError> {
    Stroke::parse(&format!("{HEADER}{rows}"))
}

/// Radius of the sphere that a stroke was made with, mm.
fn radius_mm(stroke: &Stroke) -> f32 {
    stroke.tool_at(0.0).sphere().unwrap().radius().as_mm()
}

/// From the tool's centre to what of it is nearest to the axis, mm: a rib's edge is 4·50/3π from its centre of volume.
fn reach_mm(stroke: &Stroke) -> f32 {
    match stroke.tool_at(0.0) {
        Tool::Sphere(sphere) => sphere.radius().as_mm(),
        Tool::Convex(shape) => {
            assert_eq!(shape, Shape::RIB);
            21.2
        }
    }
}

/// A sphere's radius is written to the micrometre.
fn is_the_same(one: Tool, other: Tool) -> bool {
    match (one.sphere(), other.sphere()) {
        (Some(one), Some(other)) => (one.radius().as_mm() - other.radius().as_mm()).abs() < 1e-3,
        _ => one == other,
    }
}

fn message(result: Result<Stroke, StrokeError>) -> String {
    result.unwrap_err().to_string()
}

fn assert_at(stroke: &Stroke, seconds: f64, expected_mm: [f32; 3]) {
    let found_mm = stroke.at(seconds).unwrap() * 1e3;
    // an f32 in metres resolves 0.06 µm at one metre
    assert!(found_mm.distance(Vec3::from_array(expected_mm)) < 1e-3, "at {seconds} s: {found_mm}");
}

#[test]
fn tool_moves_straight_between_rows_of_any_spacing() {
    let stroke = rows("0,100,0,0\n0.1,90,-10,5\n1.1,80,10,25\n").unwrap();
    assert_at(&stroke, 0.0, [100.0, 0.0, 0.0]);
    assert_at(&stroke, 0.05, [95.0, -5.0, 2.5]);
    assert_at(&stroke, 0.1, [90.0, -10.0, 5.0]);
    assert_at(&stroke, 0.35, [87.5, -5.0, 10.0]);
    assert_at(&stroke, 1.1, [80.0, 10.0, 25.0]);
}

#[test]
fn tool_is_nowhere_outside_the_stroke() {
    let stroke = rows("1,100,0,0\n2,90,0,0\n").unwrap();
    for seconds in [f64::NEG_INFINITY, -1.0, 0.999, 2.001, f64::INFINITY, f64::NAN] {
        assert_eq!(stroke.at(seconds), None, "at {seconds} s");
    }
    assert_eq!((stroke.start(), stroke.end(), stroke.duration()), (1.0, 2.0, 1.0));
}

#[test]
fn empty_line_lifts_the_tool_until_the_next_row() {
    let stroke = rows("\n0,100,0,0\n1,90,0,0\n\n\n3,-90,0,0\n4,-80,0,0\n\n").unwrap();
    assert_at(&stroke, 1.0, [90.0, 0.0, 0.0]);
    assert_eq!(stroke.at(1.001), None);
    assert_eq!(stroke.at(2.999), None);
    assert_at(&stroke, 3.0, [-90.0, 0.0, 0.0]);
    assert_at(&stroke, 3.5, [-85.0, 0.0, 0.0]);
}

#[test]
fn jump_over_a_lift_has_no_speed() {
    assert!(rows("0,-500,0,0\n0.01,500,0,0\n").is_err());
    assert!(rows("0,-500,0,0\n\n0.01,500,0,0\n").is_ok());
}

#[test]
fn settings_are_read_and_have_defaults() {
    let bare = rows("0,100,0,0\n").unwrap();
    assert_eq!((bare.tool_at(0.0), bare.wheel_speed()), (Tool::default(), Rpm(30.0)));
    let text = format!("# by hand: 1998\n#tool_radius_mm:7.5\n#  wheel_rpm : -10\n{HEADER}0,100,0,0\n# the end\n");
    let told = Stroke::parse(&text).unwrap();
    let small = Sphere::new(Metres::from_mm(7.5)).unwrap();
    assert_eq!((told.tool_at(0.0), told.wheel_speed()), (small.into(), Rpm(-10.0)));
}

#[test]
fn a_tool_of_facets_is_named_and_turns_the_short_way_between_rows() {
    let named = |name| Stroke::parse(&format!("# tool: {name}\n{HEADER}0,100,0,0\n")).unwrap().tool_at(0.0);
    for (name, shape) in [("rib", 0), ("blade", 1), ("knuckle", 2), ("loop", 3), ("4", 4), ("15", 15)] {
        assert_eq!(named(name), Tool::Convex(Shape(shape)), "{name}");
    }
    assert_eq!(rows("0,100,0,0\n").unwrap().orientation_at(0.0), UPRIGHT);
    let text = format!("# tool: rib\n{TURNING}0,100,0,0,170,0,-30\n1,100,0,0,-170,0,30\n\n3,100,0,0,360,-720,45\n");
    let stroke = Stroke::parse(&text).unwrap();
    let quarter = 16_384;
    assert_eq!(stroke.orientation_at(0.5), Orientation([i16::MIN, 0, 0]));
    assert_eq!(stroke.orientation_at(3.0), Orientation([0, 0, quarter / 2]));
    // there is no tool, and so no way that it is turned
    assert_eq!(stroke.orientation_at(2.0), UPRIGHT);
}

#[test]
fn another_tool_is_taken_up_between_two_rows_and_not_carried_there() {
    let tools = [Tool::Convex(Shape::RIB), Tool::Convex(Shape::KNUCKLE), Tool::default()];
    let text = format!(
        "# tool: rib\n{HEADER}0,100,0,0\n1,90,0,0\n# tool: knuckle\n2,-90,0,0\n\n# tool_radius_mm: 12\n4,80,0,0\n"
    );
    let stroke = Stroke::parse(&text).unwrap();
    assert!(stroke.tools().eq(tools));
    assert_eq!(
        [-1.0, 1.5, 2.0, 3.0, 9.0].map(|seconds| stroke.tool_at(seconds)),
        [0, 0, 1, 1, 2].map(|tool| tools[tool])
    );
    assert_eq!((stroke.at(1.5), stroke.at(3.0)), (None, None));
    let one = stroke.with_tool(tools[1], |tool| if tool == tools[0] { 0.01 } else { 0.0 }).unwrap();
    assert!(one.tools().eq([tools[1]]));
    assert_at(&one, 1.0, [100.0, 0.0, 0.0]);
    assert_at(&one, 4.0, [80.0, 0.0, 0.0]);
}

#[test]
fn text_of_a_spreadsheet_is_read() {
    let text = "\u{feff}# wheel_rpm: 20\r\n t_s, x_mm ,y_mm,z_mm\r\n 0.0 , 1e2,0,+5\r\n\r\n";
    assert_at(&Stroke::parse(text).unwrap(), 0.0, [100.0, 0.0, 5.0]);
}

#[test]
fn every_fault_is_named_with_its_line() {
    for (text, expected) in [
        ("", "write the header"),
        ("# wheel_rpm: 10\n", "write the header"),
        (HEADER, "at least one row"),
        ("0,100,0,0\n", "line 1: expected the header"),
        ("# a\n\nt,x,y,z\n0,100,0,0\n", "line 3: expected the header"),
        ("t_s,x_mm,y_mm,z_mm\n0,100,0\n", "line 2: found 3 columns"),
        ("t_s,x_mm,y_mm,z_mm\n0,100,0,0,\n", "line 2: found 5 columns"),
        ("t_s,x_mm,y_mm,z_mm\n0;100;0;0\n", "separated by commas"),
        ("t_s,x_mm,y_mm,z_mm\n0,100,0,0\n1,,0,0\n", "line 3: x_mm is \"\""),
        ("t_s,x_mm,y_mm,z_mm\n0,100,12 mm,0\n", "line 2: y_mm is \"12 mm\""),
        ("t_s,x_mm,y_mm,z_mm\nNaN,100,0,0\n", "line 2: t_s is \"NaN\""),
        ("t_s,x_mm,y_mm,z_mm\n0,100,0,inf\n", "line 2: z_mm is \"inf\""),
        ("t_s,x_mm,y_mm,z_mm\n0,100,0,1e999\n", "line 2: z_mm is \"1e999\""),
        ("t_s,x_mm,y_mm,z_mm\n-1,100,0,0\n", "line 2: a time of -1 s"),
        ("t_s,x_mm,y_mm,z_mm\n1e6,100,0,0\n", "line 2: a time of 1000000 s"),
        ("t_s,x_mm,y_mm,z_mm\n0,100,0,0\n0,100,0,0\n", "line 3: 0 s does not come after 0 s"),
        ("t_s,x_mm,y_mm,z_mm\n2,100,0,0\n\n1,100,0,0\n", "line 4: 1 s does not come after 2 s"),
        ("t_s,x_mm,y_mm,z_mm\n0,0.9,0,1200\n", "farther than 1000 mm"),
        ("t_s,x_mm,y_mm,z_mm\n0,1e300,0,0\n", "farther than 1000 mm"),
        ("t_s,x_mm,y_mm,z_mm\n0,0,0,0\n0.001,6,0,0\n", "line 3: the tool moves at 6.00 m/s"),
        ("# tool_radius_mm: 0\nt_s,x_mm,y_mm,z_mm\n0,0,0,0\n", "line 1: a tool radius of 0 mm"),
        ("# tool_radius_mm: big\nt_s,x_mm,y_mm,z_mm\n0,0,0,0\n", "line 1: tool_radius_mm is \"big\""),
        ("# tool: spoon\nt_s,x_mm,y_mm,z_mm\n0,0,0,0\n", "line 1: there is no tool \"spoon\""),
        ("# tool: 256\nt_s,x_mm,y_mm,z_mm\n0,0,0,0\n", "line 1: there is no tool \"256\""),
        ("# tool: rib\n# tool_radius_mm: 5\nt_s,x_mm,y_mm,z_mm\n0,0,0,0\n", "line 2: tool_radius_mm was given before"),
        ("t_s,x_mm,y_mm,z_mm,yaw_deg\n0,0,0,0,0\n", "line 1: expected the header"),
        ("t_s,x_mm,y_mm,z_mm,yaw_deg,pitch_deg,roll_deg\n0,0,0,0\n", "line 2: found 4 columns, expected 7"),
        ("t_s,x_mm,y_mm,z_mm,yaw_deg,pitch_deg,roll_deg\n0,0,0,0,0,up,0\n", "line 2: pitch_deg is \"up\""),
        ("# wheel_rpm: 500\nt_s,x_mm,y_mm,z_mm\n0,0,0,0\n", "line 1: the wheel cannot turn at 500 rpm"),
        ("# wheel_rpm: 5\n# wheel_rpm: 5\nt_s,x_mm,y_mm,z_mm\n0,0,0,0\n", "line 2: wheel_rpm was given before"),
    ] {
        let message = message(Stroke::parse(text));
        assert!(message.contains(expected), "{text:?} gave {message:?}");
    }
}

#[test]
fn missing_file_is_named() {
    let message = message(Stroke::read("no/such/stroke.csv"));
    assert!(message.contains("no/such/stroke.csv"), "{message}");
}

#[test]
fn refused_sample_leaves_the_recording_as_it_was() {
    let mut recorder = StrokeRecorder::new(Tool::default(), Rpm(20.0));
    assert!(recorder.is_empty());
    recorder.push(1.0, Vec3::new(0.1, 0.0, 0.0), UPRIGHT).unwrap();
    let place = Vec3::new(-0.1, 0.0, 0.0);
    assert!(matches!(recorder.push(f64::NAN, place, UPRIGHT), Err(SampleError::Time { .. })));
    assert!(matches!(recorder.push(1.0, place, UPRIGHT), Err(SampleError::NotLater { .. })));
    // a tenth of a microsecond later is the same microsecond in the file
    assert!(matches!(recorder.push(1.000_000_1, place, UPRIGHT), Err(SampleError::NotLater { .. })));
    assert!(matches!(recorder.push(1.01, Vec3::NAN, UPRIGHT), Err(SampleError::TooFar { .. })));
    assert!(matches!(recorder.push(1.01, place, UPRIGHT), Err(SampleError::TooFast { .. })));
    recorder.lift();
    recorder.push(1.01, place, UPRIGHT).unwrap();
    let stroke = parsed(&recorder).unwrap();
    assert_eq!((stroke.start(), stroke.end()), (1.0, 1.01));
    assert_eq!(stroke.at(1.005), None);
}

#[test]
fn speed_that_is_not_a_number_is_recorded_as_standing_still() {
    let mut recorder = StrokeRecorder::new(Tool::default(), Rpm(f32::NAN));
    recorder.push(0.0, Vec3::ZERO, UPRIGHT).unwrap();
    assert_eq!(parsed(&recorder).unwrap().wheel_speed(), Rpm(0.0));
}

fn parsed(recorder: &StrokeRecorder) -> Result<Stroke, StrokeError> {
    let mut file = Vec::new();
    recorder.write_to(&mut file).unwrap();
    Stroke::parse(&String::from_utf8(file).unwrap())
}

/// A time step, a place, a turn, whether the tool was lifted before it, and the tool that is taken up if another is.
type Move = (f64, [f32; 3], [i16; 3], bool, Option<u8>);

/// What a hand does: time steps from far too short to long, places from near to out of reach, and lifts.
/// Now and then another tool is taken.
fn hand() -> impl Strategy<Value = Vec<Move>> {
    let place = prop::array::uniform3(-0.7_f32..0.7);
    let turn = prop_oneof![Just([0; 3]), any::<[i16; 3]>()];
    let taken = prop::option::weighted(0.1, 0_u8..16);
    prop::collection::vec((1e-7..0.5, place, turn, prop::bool::weighted(0.2), taken), 1..60)
}

proptest! {
    #[test]
    fn whatever_was_taken_is_read_again(moves in hand(), radius in 0.5_f32..40.0, rpm in -500.0_f32..500.0) {
        let mut tool: Tool = Sphere::new(Metres::from_mm(radius)).unwrap().into();
        let mut recorder = StrokeRecorder::new(tool, Rpm(rpm));
        let mut now_s = 0.0;
        let mut taken = Vec::new();
        for (step_s, place, turn, lift, other) in moves {
            now_s += step_s;
            if lift {
                recorder.lift();
            }
            tool = other.map_or(tool, |shape| Tool::Convex(Shape(shape)));
            recorder.hold(tool);
            if recorder.push(now_s, Vec3::from_array(place), Orientation(turn)).is_ok() {
                taken.push((now_s, tool, Vec3::from_array(place), Orientation(turn)));
            }
        }
        prop_assume!(!taken.is_empty());
        let stroke = parsed(&recorder).unwrap();
        prop_assert!((stroke.wheel_speed().0 - rpm.clamp(-400.0, 400.0)).abs() < 1e-3);
        for (time_s, tool, place, orientation) in taken {
            let time_s = (time_s * 1e6).round() / 1e6;
            prop_assert_eq!(stroke.orientation_at(time_s), orientation);
            prop_assert!(is_the_same(stroke.tool_at(time_s), tool));
            let there = stroke.at(time_s).unwrap();
            // half a micrometre of rounding on each axis
            prop_assert!(there.distance(place) < 1e-6, "at {time_s} s: {there} for {place}");
        }
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "([-#:,.0-9eEatmxyz_sNin \n]|t_s,x_mm,y_mm,z_mm\n){0,80}") {
        if let Ok(stroke) = Stroke::parse(&text) {
            prop_assert!(stroke.at(stroke.start()).is_some());
        }
    }

    #[test]
    fn interpolation_stays_between_its_rows(from in -400_i32..400, to in -400_i32..400, share in 0.0..1.0) {
        let stroke = rows(&format!("0,{from},0,0\n1,{to},0,0\n")).unwrap();
        let x_mm = stroke.at(share).unwrap().x * 1e3;
        // one rounding of an f32 at 400 mm
        prop_assert!(x_mm >= from.min(to) as f32 - 1e-4 && x_mm <= from.max(to) as f32 + 1e-4);
    }
}

/// The strokes that come with the studio, by name.
fn shipped() -> Vec<(String, Stroke)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../data/strokes");
    let mut strokes: Vec<(String, Stroke)> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "csv"))
        .map(|path| (path.file_stem().unwrap().to_str().unwrap().to_owned(), Stroke::read(&path).unwrap()))
        .collect();
    strokes.sort_by(|one, other| one.0.cmp(&other.0));
    strokes
}

fn stroke_named(name: &str) -> Stroke {
    shipped().into_iter().find(|(found, _)| found == name).unwrap().1
}

/// How deep the tool stands in an untouched cylinder of 60 mm radius and 200 mm height; negative is the air between.
fn depth_mm(stroke: &Stroke, seconds: f64) -> f32 {
    let centre_mm = stroke.at(seconds).unwrap() * 1e3;
    60.0 + reach_mm(stroke) - centre_mm.truncate().length()
}

/// How deep the finger inside stands in the untouched wall, whose inner face is 52 mm from the axis.
fn depth_inside_mm(stroke: &Stroke, seconds: f64) -> f32 {
    (stroke.at(seconds).unwrap() * 1e3).truncate().length() + reach_mm(stroke) - 52.0
}

#[test]
fn seven_strokes_come_with_the_studio() {
    let names: Vec<String> = shipped().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["evaluation", "foot", "neck", "pull-inside", "pull-outside", "rib", "waist"]);
}

#[test]
fn shipped_strokes_begin_and_end_in_the_air_and_press_in_between() {
    for (name, stroke) in shipped() {
        let depth_mm = if name == "pull-inside" { depth_inside_mm } else { depth_mm };
        assert!(depth_mm(&stroke, stroke.start()) <= -20.0, "{name} begins on the clay");
        assert!(depth_mm(&stroke, stroke.end()) <= -20.0, "{name} ends on the clay");
        let middle = stroke.start() + 0.5 * stroke.duration();
        assert!(depth_mm(&stroke, middle) > 2.0, "{name} does not press");
        let (lasts_s, rpm) = if name.starts_with("pull-") { (24.0..=24.0, 60.0) } else { (8.5..=9.5, 20.0) };
        assert!(lasts_s.contains(&stroke.duration()), "{name} lasts {} s", stroke.duration());
        assert_eq!(stroke.wheel_speed(), Rpm(rpm), "{name}");
    }
}

#[test]
fn shipped_strokes_are_smooth() {
    const STEP_S: f64 = 0.01;
    for (name, stroke) in shipped() {
        let places: Vec<Vec3> = (0..).map_while(|step| stroke.at(f64::from(step) * STEP_S)).collect();
        let speeds: Vec<Vec3> = places.windows(2).map(|pair| (pair[1] - pair[0]) / STEP_S as f32).collect();
        let fastest = speeds.iter().map(|speed| speed.length()).fold(0.0, f32::max);
        assert!(fastest < 0.5, "{name} moves at {fastest} m/s");
        let sharpest = speeds.windows(2).map(|pair| pair[1].distance(pair[0]) / STEP_S as f32).fold(0.0, f32::max);
        // a hand's easy movement; rounding to 1 µm alone gives up to 0.04 m/s²
        assert!(sharpest < 1.0, "{name} accelerates by {sharpest} m/s²");
    }
}

#[test]
fn evaluation_stroke_runs_from_rim_to_foot_within_nine_seconds() {
    let stroke = stroke_named("evaluation");
    assert_eq!(stroke.tool_at(0.0), Tool::default());
    assert!(stroke.duration() <= 9.0);
    let pressed: Vec<Vec3> = (0..900)
        .map(|step| f64::from(step) * 0.01)
        .filter(|&seconds| depth_mm(&stroke, seconds) > 0.0)
        .map(|seconds| stroke.at(seconds).unwrap() * 1e3)
        .collect();
    let (first, last) = (pressed[0], pressed[pressed.len() - 1]);
    // the tool covers its radius above and below its centre
    assert!(first.z > 200.0 - 12.0 && last.z < 0.0 + 12.5, "pressed from z = {} to {} mm", first.z, last.z);
    assert!(pressed.windows(2).all(|pair| pair[1].z <= pair[0].z), "it goes back up");
    let deepest = pressed.iter().map(|place| 72.0 - place.x).fold(0.0, f32::max);
    assert!((3.0..=4.0).contains(&deepest), "{deepest} mm deep");
}

#[test]
fn waist_and_evaluation_work_on_the_same_band_at_the_same_time() {
    let (evaluation, waist) = (stroke_named("evaluation"), stroke_named("waist"));
    let together = (0..900).map(|step| f64::from(step) * 0.01).filter(|&seconds| {
        let both = depth_mm(&evaluation, seconds) > 0.0 && depth_mm(&waist, seconds) > 0.0;
        let apart_m = evaluation.at(seconds).unwrap().z - waist.at(seconds).unwrap().z;
        both && apart_m.abs() * 1e3 < radius_mm(&evaluation)
    });
    // half a second is more than the tools need to meet on one another's traces
    assert!(together.count() > 50);
}
