//! Tools from files: what other programs write is read, what is broken is told by name, and nothing is read without end.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::{Path, PathBuf};

use glam::Vec3;
use pottery_client::tool_file::{
    FILE_BYTES_MAX, LineProblem, Thinned, ToolFileError, ToolFileFault, USUAL_UNIT, read_tool,
};
use pottery_shared::session::{BROUGHT_TRIANGLES_MAX, mesh_of};
use pottery_shared::tool::{ConvexError, ConvexTool, rack};
use pottery_shared::units::Metres;
use proptest::prelude::*;

/// A tetrahedron of 30 mm legs as one program writes it: indented, with exponents.
const TEXT_STL: &str = "solid legs of thirty
  facet normal 0 0 -1
    outer loop
      vertex 0 0 0
      vertex 0 3.0e+01 0
      vertex 3.0e+01 0 0
    endloop
  endfacet
  facet normal 0 -1 0
    outer loop
      vertex 0 0 0
      vertex 30 0 0
      vertex 0 0 30
    endloop
  endfacet
  facet normal -1 0 0
    outer loop
      vertex 0 0 0
      vertex 0 0 30
      vertex 0 30 0
    endloop
  endfacet
  facet normal 0.577350 0.577350 0.577350
    outer loop
      vertex 30 0 0
      vertex 0 30 0
      vertex 0 0 30
    endloop
  endfacet
endsolid legs of thirty
";

/// A box of 10 × 20 × 30 mm in quads, with all that usually stands beside them.
const QUADS_OBJ: &str = "# made by hand
mtllib box.mtl
o box
v 0 0 0
v 10 0 0
v 10 20 0
v 0 20 0
v 0 0 30 1.0
v 10 0 30 0.5 0.5 0.5
v 10 20 30
v 0 20 30
vt 0 0
vn 0 0 1
g sides
usemtl wood
s off
f 1/1/1 4/1/1 3/1/1 2/1/1
f 5//1 6//1 7//1 8//1
f 1 2 6 5 # front
f -6 -5 -1 -2
f 2/1 3/1 7/1 6/1
f 4 1 5 8
";

fn write(name: &str, contents: impl AsRef<[u8]>) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tool-files");
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    fs::write(&path, contents).unwrap();
    path
}

fn read(name: &str, contents: impl AsRef<[u8]>) -> Result<ConvexTool, ToolFileError> {
    read_tool(&write(name, contents), USUAL_UNIT)
}

fn refused(name: &str, contents: impl AsRef<[u8]>) -> ToolFileError {
    let error = read(name, contents).expect_err("it should be refused");
    assert!(error.to_string().contains(name), "{error} does not name the file");
    assert!(error.to_string().matches(['\n', '\r']).count() == 0, "{error} is more than a line");
    error
}

/// Binary STL, mm.
fn binary(tool: &ConvexTool) -> Vec<u8> {
    let facets: Vec<_> = tool
        .triangles_m()
        .map(|corners| stl_io::Triangle {
            normal: stl_io::Normal::new([0.0; 3]),
            vertices: corners.map(|corner| stl_io::Vertex::new((corner * 1e3).to_array())),
        })
        .collect();
    let mut file = Vec::new();
    stl_io::write_stl(&mut file, facets.iter()).unwrap();
    file
}

#[test]
fn text_stl_is_read_however_it_is_written() {
    let with_mark = format!("\u{feff}{TEXT_STL}");
    for (name, text) in [
        ("plain.stl", TEXT_STL.to_owned()),
        ("SHOUTING.STL", TEXT_STL.to_uppercase()),
        ("windows.stl", TEXT_STL.replace('\n', "\r\n")),
        ("nameless.stl", TEXT_STL.replace(" legs of thirty", "")),
        ("blank-lines.stl", format!("\n  {}\n\n", TEXT_STL.replace("endfacet\n", "endfacet\n\n"))),
        ("byte-order-mark.stl", with_mark),
    ] {
        let tool = read(name, text).unwrap_or_else(|error| panic!("{error}"));
        // a sixth of the cube; the corners are rounded to 24 bits
        assert!((tool.volume_m3() / 4.5e-6 - 1.0).abs() < 1e-6, "{name}: {} m³", tool.volume_m3());
        assert!(tool.centre_m().distance(Vec3::splat(0.0075)) < 1e-8, "{name}: {}", tool.centre_m());
    }
}

#[test]
fn quads_of_an_obj_are_cut_into_triangles() {
    for (name, text) in [("box.obj", QUADS_OBJ.to_owned()), ("windows.obj", QUADS_OBJ.replace('\n', "\r\n"))] {
        let tool = read(name, text).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(tool.normals().len(), 12, "{name}");
        assert!((tool.volume_m3() / 6e-6 - 1.0).abs() < 1e-6, "{name}: {} m³", tool.volume_m3());
        assert!(tool.centre_m().distance(Vec3::new(0.005, 0.01, 0.015)) < 1e-8, "{name}: {}", tool.centre_m());
    }
}

#[test]
fn unit_of_a_file_can_be_said() {
    let path = write("centimetres.obj", QUADS_OBJ);
    let tool = read_tool(&path, Metres::from_mm(2.0)).unwrap();
    assert!((tool.volume_m3() / 48e-6 - 1.0).abs() < 1e-6, "{} m³", tool.volume_m3());
    for unit in [Metres(1.0), Metres(0.0), Metres(f32::NAN)] {
        let fault = read_tool(&path, unit).expect_err("no tool is that large or small").fault;
        assert!(
            matches!(fault, ToolFileFault::Mesh(ConvexError::Size { .. } | ConvexError::NotANumber { .. })),
            "{fault}"
        );
    }
}

#[test]
fn every_tool_of_the_rack_comes_back_from_stl() {
    for tool in [rack::rib(), rack::blade(), rack::knuckle(), rack::loop_end(), rack::ball(3, Metres::from_mm(12.0))] {
        let tool = tool.unwrap();
        let mut file = binary(&tool);
        // the word that begins the text form, as some programs write it into binary files
        file[..11].copy_from_slice(b"solid tool\n");
        let back = read("rack.stl", &file).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(back.normals().len(), tool.normals().len());
        // written and read in mm: twice a rounding to 24 bits, and the centre found again
        for (written, read) in tool.triangles_m().flatten().zip(back.triangles_m().flatten()) {
            assert!(written.distance(read) < 5e-8, "{written} came back as {read}");
        }
    }
}

#[test]
fn broken_file_is_told_by_name_and_what_is_wrong() {
    let fault = |name: &str, contents: &[u8]| refused(name, contents).fault;
    let obj = |text: &str| fault("broken.obj", text.as_bytes());
    assert!(matches!(fault("tool.step", b"ISO-10303-21;"), ToolFileFault::Format));
    assert!(matches!(fault("tool", b""), ToolFileFault::Format));
    assert!(matches!(fault("empty.stl", b""), ToolFileFault::Empty));
    assert!(matches!(fault("noise.stl", &[0xff; 60]), ToolFileFault::Stl));
    assert!(matches!(fault("empty.obj", b""), ToolFileFault::Empty));
    assert!(matches!(fault("bare.obj", b"# nothing\n"), ToolFileFault::Mesh(ConvexError::TooFew { triangles: 0, .. })));
    let cut = TEXT_STL.find("    endloop").unwrap();
    assert!(matches!(fault("cut.stl", &TEXT_STL.as_bytes()[..cut]), ToolFileFault::Stl));
    assert!(matches!(fault("two.stl", TEXT_STL.repeat(2).as_bytes()), ToolFileFault::SeveralSolids));
    for (text, line) in [
        (TEXT_STL.replace("3.0e+01", "nan"), 5),
        (format!("\n\n{}", TEXT_STL.replace("0.577350 0.577350 0.577350", "0.577350 inf 0")), 25),
        (TEXT_STL.replace("vertex 30 0 0", "vertex 30 0 0 0"), 12),
        (TEXT_STL.replace("vertex 30 0 0", "vertex 30 0"), 12),
    ] {
        let fault = fault("numbers.stl", text.as_bytes());
        assert!(
            matches!(fault, ToolFileFault::Line { line: at, problem: LineProblem::Numbers } if at == line),
            "{fault}"
        );
    }
    assert!(matches!(obj("v 1 2 x\n"), ToolFileFault::Line { line: 1, problem: LineProblem::Corner }));
    assert!(matches!(
        obj(&QUADS_OBJ.replace("f 2/1 3/1 7/1 6/1", "f 2 3")),
        ToolFileFault::Line { line: 21, problem: LineProblem::Face }
    ));
    assert!(matches!(
        obj(&QUADS_OBJ.replace("f 4 1 5 8", "f 4 1 5 9")),
        ToolFileFault::Line { line: 22, problem: LineProblem::Number { number: 9, corners: 8 } }
    ));
    for number in ["0", "-9", "x", "99999999999999999999", "-9223372036854775808"] {
        let problem = obj(&QUADS_OBJ.replace("f 4 1 5 8", &format!("f 4 1 5 {number}")));
        assert!(matches!(problem, ToolFileFault::Line { line: 22, problem: LineProblem::Number { .. } }), "{problem}");
    }
    assert!(matches!(
        obj(&QUADS_OBJ.replace("v 0 0 0", "v NaN 0 0")),
        ToolFileFault::Mesh(ConvexError::NotANumber { .. })
    ));
    let open = obj(&QUADS_OBJ.replace("f 4 1 5 8\n", ""));
    assert!(matches!(open, ToolFileFault::Mesh(ConvexError::Open { .. })), "{open}");
    let dented = obj(&QUADS_OBJ.replace("v 10 20 30", "v 8 18 28"));
    assert!(matches!(dented, ToolFileFault::Mesh(ConvexError::NotConvex { .. })), "{dented}");
    assert!(dented.to_string().contains(" 0.005 mm are allowed"), "{dented}");
    let missing = read_tool(Path::new("no/such/file.stl"), USUAL_UNIT).expect_err("there is none");
    assert!(matches!(missing.fault, ToolFileFault::Unreadable(_)), "{missing}");
}

#[test]
fn announced_numbers_are_not_believed() {
    let mut file = binary(&rack::rib().unwrap());
    file[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let fault = refused("boast.stl", &file).fault;
    assert!(matches!(fault, ToolFileFault::CutShort { triangles: u32::MAX, .. }), "{fault}");
    let mut file = binary(&rack::rib().unwrap());
    file.truncate(file.len() - 7);
    assert!(matches!(refused("short.stl", &file).fault, ToolFileFault::CutShort { .. }));
}

#[test]
fn large_file_is_left_before_its_end() {
    let one = &binary(&rack::rib().unwrap())[84..134];
    let mut file = vec![0; 80];
    let count = 30_000_u32;
    file.extend(count.to_le_bytes());
    file.extend(one.repeat(count as usize));
    // one more than allowed is kept, to be told about
    let too_many = |fault| matches!(fault, ToolFileFault::Mesh(ConvexError::TooMany { triangles: 20_481, .. }));
    assert!(too_many(refused("many.stl", &file).fault));
    let quads = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n{}", "f 1 2 3 4\n".repeat(30_000));
    assert!(too_many(refused("many.obj", quads).fault));
    let fan = format!("v 0 0 0\nv 1 0 0\nf 1 2 {}\n", "1 ".repeat(50_000));
    assert!(too_many(refused("fan.obj", fan).fault));
    let corners = "v 0 0 0\n".repeat(70_000);
    let fault = refused("corners.obj", corners).fault;
    assert!(
        matches!(fault, ToolFileFault::Line { line: 61_441, problem: LineProblem::TooManyCorners { .. } }),
        "{fault}"
    );
    let path = write("huge.stl", "");
    fs::File::options().write(true).open(&path).unwrap().set_len(FILE_BYTES_MAX + 1).unwrap();
    let fault = read_tool(&path, USUAL_UNIT).expect_err("it is too large").fault;
    assert!(matches!(fault, ToolFileFault::TooLarge { max: FILE_BYTES_MAX }), "{fault}");
}

/// A box with so many squares along each side of its faces, mm.
fn box_of(squares: usize, [x, y, z]: [f32; 3]) -> ConvexTool {
    let mut triangles_m = Vec::new();
    let place = |at: usize| at as f32 / squares as f32;
    for (axis, end) in (0..3).flat_map(|axis| [(axis, 0.0), (axis, 1.0)]) {
        for (u, v) in (0..squares * squares).map(|at| (at / squares, at % squares)) {
            let corner = |u: usize, v: usize| {
                let mut share = Vec3::splat(end);
                (share[(axis + 1) % 3], share[(axis + 2) % 3]) = (place(u), place(v));
                share * Vec3::new(x, y, z) * 1e-3
            };
            let [mut a, b, mut c, d] = [corner(u, v), corner(u + 1, v), corner(u + 1, v + 1), corner(u, v + 1)];
            if end == 0.0 {
                (a, c) = (c, a);
                triangles_m.extend([[a, b, c], [c, d, a]]);
            } else {
                triangles_m.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    ConvexTool::new(&triangles_m).unwrap()
}

/// A pebble: a ball with other measures along its axes, mm.
fn pebble(subdivisions: u32, measures_mm: Vec3) -> ConvexTool {
    let ball = rack::ball(subdivisions, Metres::from_mm(10.0)).unwrap();
    let scaled = |corner: Vec3| corner * measures_mm / 10.0;
    ConvexTool::new(&ball.triangles_m().map(|triangle| triangle.map(scaled)).collect::<Vec<_>>()).unwrap()
}

/// How far a tool reaches in a direction, m.
fn reach_m(tool: &ConvexTool, direction: Vec3) -> f32 {
    tool.triangles_m().flatten().map(|corner| corner.dot(direction)).fold(f32::MIN, f32::max)
}

#[test]
fn a_tool_too_fine_to_be_shared_keeps_its_form() {
    let directions = rack::ball(2, Metres::from_mm(10.0)).unwrap().normals().to_vec();
    // triangles of one size on a ball of radius R have sides s with 1280·s²·√3/4 = 4π·R², and lie s²/6R inside of their corners: 0.045
    // and 0.13 mm. What is thin stays a little thinner, since it is not to become longer
    for (name, tool, most_mm, share) in [
        ("ball", pebble(4, Vec3::splat(12.0)), 0.045, 1e-5),
        ("ball of a fist", pebble(5, Vec3::splat(35.0)), 0.13, 1e-5),
        ("pebble", pebble(4, Vec3::new(30.0, 12.0, 8.0)), 0.065, 0.006),
        ("kidney of 1 mm", pebble(4, Vec3::new(50.0, 25.0, 0.5)), 0.02, 0.02),
    ] {
        let Thinned { tool: thinner, apart } = Thinned::of(&tool, BROUGHT_TRIANGLES_MAX).unwrap();
        let volume = thinner.volume_m3() / tool.volume_m3() - 1.0;
        println!(
            "{name}: {} to {} triangles, {} mm, {volume}",
            tool.normals().len(),
            thinner.normals().len(),
            apart.as_mm()
        );
        assert!(thinner.normals().len() <= BROUGHT_TRIANGLES_MAX && apart.as_mm() < most_mm, "{name}");
        assert!(volume.abs() < share, "{name}");
        for direction in &directions {
            let out_m = reach_m(&thinner, *direction) - reach_m(&tool, *direction);
            // what it says is by its own facets: between two of them a corner stands out as far again at most
            assert!(out_m.abs() < 2.0 * apart.0, "{name}: {out_m} m along {direction}");
        }
        mesh_of(&thinner).unwrap();
    }
}

#[test]
fn a_tool_loses_no_corner_that_it_needs() {
    let tool = box_of(30, [80.0, 40.0, 5.0]);
    assert_eq!(tool.normals().len(), 10_800);
    let Thinned { tool: thinner, apart } = Thinned::of(&tool, BROUGHT_TRIANGLES_MAX).unwrap();
    // six faces of two triangles, and the rounding of corners
    assert!(thinner.normals().len() == 12 && apart.as_mm() < 1e-4, "{} mm, {thinner:?}", apart.as_mm());
    // so few enclose nothing
    assert!(Thinned::of(&tool, 3).is_none());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn any_file_makes_a_tool_or_an_error(
        bytes in prop::collection::vec(any::<u8>(), 0..400),
        at in 0_usize..1000,
        ending in prop::sample::select(vec!["stl", "obj"]),
    ) {
        // noise written over a good file reaches farther into the readers than noise alone
        let good = if ending == "stl" { TEXT_STL.as_bytes() } else { QUADS_OBJ.as_bytes() };
        let mut file = good.to_vec();
        let at = at % file.len();
        let end = (at + bytes.len() % 40).min(file.len());
        file.splice(at..end, bytes.iter().copied());
        let name = format!("noise.{ending}");
        if let Err(error) = read(&name, &file) {
            prop_assert!(error.to_string().contains(&name));
        }
    }
}
