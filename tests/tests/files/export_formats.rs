//! What leaves the studio opens in programs that we did not write, and is there what it was here.
//!
//! assimp reads the solids, admesh counts open edges, ImageMagick reads the pictures and librsvg draws the section.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::HashSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use pottery_client::export::{ExportError, Format, SolidMesh, export};
use pottery_shared::clay::{GridShape, Pot, PotSpec, floor_row};
use pottery_tests::programs::folder;

/// A pot that is nowhere round, so that what is mirrored or turned is seen: a handle's stump along x, a dent along y.
fn crooked() -> Pot {
    let shape = GridShape::new(72, 60).unwrap();
    let mut pot = Pot::new(PotSpec { shape, ..PotSpec::default() }).unwrap();
    for column in 0..72 {
        for row in 0..60 {
            let height = row as f32 / 59.0;
            let belly_m = 0.05 + 0.02 * height;
            let stump_m = if !(3..70).contains(&column) && (0.6..0.7).contains(&height) { 0.03 } else { 0.0 };
            let dent_m = if (15..22).contains(&column) && (0.2..0.3).contains(&height) { 0.01 } else { 0.0 };
            pot.surfaces_mut()[0].set_radius(column, row, belly_m + stump_m - dent_m);
        }
    }
    pot
}

/// Runs a program that the machine must have.
fn run(program: &str, package: &str, arguments: &[&str]) -> Output {
    Command::new(program).args(arguments).output().unwrap_or_else(|error| {
        panic!("{program} cannot be run ({error}): install it, on Debian `apt install {package}`")
    })
}

fn text_of(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    text
}

/// The numbers after a name in what assimp says of a file.
fn numbers_after(text: &str, name: &str) -> Vec<f64> {
    let line = text.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("no {name} in {text}"));
    let is_number = |word: &&str| word.parse::<f64>().is_ok();
    let words = line[name.len()..].split(|sign: char| !(sign.is_ascii_digit() || "-.e".contains(sign)));
    words.filter(is_number).map(|word| word.parse().unwrap()).collect()
}

#[test]
fn assimp_reads_every_solid_as_it_is() {
    let folder = folder("assimp");
    let pot = crooked();
    let mesh = SolidMesh::of(&pot);
    let extent = |axis: usize| {
        let along = || mesh.corners_mm().iter().map(|corner| f64::from(corner[axis]));
        (along().fold(f64::MAX, f64::min), along().fold(f64::MIN, f64::max))
    };
    let ([x, y, z], facets) = ([0, 1, 2].map(extent), mesh.facets().len() as f64);
    for format in [Format::Stl, Format::ThreeMf, Format::Obj, Format::Ply, Format::Glb] {
        let path = folder.join("pot").with_extension(format.ending());
        export(&pot, &path).unwrap();
        let text = text_of(&run("assimp", "assimp-utils", &["info", path.to_str().unwrap()]));
        assert_eq!(numbers_after(&text, "Faces:"), [facets], "{format:?}");
        // glTF has metres and y upwards
        let (scale, [x, y, z]) = if format == Format::Glb { (1e-3, [x, z, (-y.1, -y.0)]) } else { (1.0, [x, y, z]) };
        for (name, expected) in [("Minimum point", [x.0, y.0, z.0]), ("Maximum point", [x.1, y.1, z.1])] {
            let found = numbers_after(&text, name);
            for (found, expected) in found.iter().zip(expected) {
                // assimp prints six decimals; coordinates are floats of 7 digits
                assert!(
                    (found - scale * expected).abs() < 2e-5 * scale.max(0.1),
                    "{format:?} {name}: {found} {expected}"
                );
            }
            assert_eq!(found.len(), 3);
        }
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn assimp_finds_the_normals_that_were_written() {
    let folder = folder("assimp-normals");
    let pot = crooked();
    for format in [Format::Stl, Format::Obj, Format::Ply, Format::Glb] {
        let path = folder.join("pot").with_extension(format.ending());
        export(&pot, &path).unwrap();
        // its own writer of PLY gives normals when the scene has them
        let written = folder.join(format!("{}-by-assimp.ply", format.ending()));
        let arguments = ["export", path.to_str().unwrap(), written.to_str().unwrap()];
        text_of(&run("assimp", "assimp-utils", &arguments));
        let text = fs::read_to_string(&written).unwrap();
        assert!(text.contains("property float nx"), "{format:?}: assimp found no normals");
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn admesh_finds_no_open_edge() {
    let folder = folder("admesh");
    let path = folder.join("pot.stl");
    export(&crooked(), &path).unwrap();
    let text = text_of(&run("admesh", "admesh", &[path.to_str().unwrap()]));
    for (name, expected) in [
        ("Total disconnected facets", 0),
        ("Number of parts", 1),
        ("Degenerate facets", 0),
        ("Edges fixed", 0),
        ("Facets reversed", 0),
        ("Backwards edges", 0),
        ("Normals fixed", 0),
    ] {
        // what it found comes before what it made of it
        let (_, counts) = text.split_once(name).unwrap_or_else(|| panic!("no {name} in {text}"));
        let first = counts.trim_start_matches([' ', ':']).split_whitespace().next();
        assert_eq!(first, Some(expected.to_string().as_str()), "{name} in {text}");
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn every_edge_lies_between_two_facets_and_normals_point_outwards() {
    let mesh = SolidMesh::of(&crooked());
    let mut edges = HashSet::new();
    for &[a, b, c] in mesh.facets() {
        for edge in [(a, b), (b, c), (c, a)] {
            assert!(edges.insert(edge), "{edge:?} twice");
        }
    }
    assert!(edges.iter().all(|&(from, to)| edges.contains(&(to, from))), "an open edge");
    let used: HashSet<_> = mesh.facets().iter().flatten().collect();
    assert_eq!(used.len(), mesh.corners_mm().len(), "a corner of no facet");
    for &facet in mesh.facets() {
        let [a, b, c] = facet.map(|corner| glam::Vec3::from_array(mesh.corners_mm()[corner as usize]));
        let upright = (b - a).cross(c - a).normalize();
        for corner in facet {
            let normal = glam::Vec3::from_array(mesh.normals()[corner as usize]);
            assert!((normal.length() - 1.0).abs() < 1e-5);
            // the stump's flank is steep: its edges are the sharpest, and none is sharper than a right angle by much
            assert!(normal.dot(upright) > -0.5, "{normal} on a facet of {upright}");
        }
    }
}

#[test]
fn image_magick_reads_picture_and_turntable() {
    let folder = folder("magick");
    let pot = crooked();
    let (picture, turning) = (folder.join("pot.png"), folder.join("pot.gif"));
    export(&pot, &picture).unwrap();
    export(&pot, &turning).unwrap();
    let statement = |path: &Path, format: &str| {
        let arguments = [path.to_str().unwrap(), "-format", format, "info:"];
        text_of(&run("convert", "imagemagick", &arguments))
    };
    assert_eq!(statement(&picture, "%m %w %h\n").trim_end(), "PNG 1280 960");
    let frames = statement(&turning, "%m %w %h %T\n");
    assert_eq!(frames.lines().collect::<Vec<_>>(), ["GIF 480 480 8"; 36]);
    // a black or empty picture has one colour; a turned pot is another picture, since it is crooked
    let deviation: f64 = statement(&picture, "%[fx:standard_deviation]").parse().unwrap();
    assert!(deviation > 0.02, "a picture without contrast: {deviation}");
    let difference = |other: &str| {
        let path = turning.to_str().unwrap();
        let arguments = [&format!("{path}[0]"), &format!("{path}[{other}]"), "-metric", "RMSE", "-compare"];
        let tail = ["-format", "%[distortion]", "info:"];
        let text = text_of(&run("convert", "imagemagick", &[&arguments.map(|word| word as &str)[..], &tail].concat()));
        text.trim().parse::<f64>().unwrap()
    };
    assert!(difference("0") < 1e-6);
    assert!(difference("9") > 0.02, "a quarter of a turn changes nothing: {}", difference("9"));
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn librsvg_draws_the_section_in_true_size() {
    let folder = folder("section");
    let pot = crooked();
    let (drawing, picture) = (folder.join("pot.svg"), folder.join("pot.png"));
    export(&pot, &drawing).unwrap();
    // 254 dots an inch are 10 a millimetre
    let paths = [picture.to_str().unwrap(), drawing.to_str().unwrap()];
    let arguments = ["--dpi-x", "254", "--dpi-y", "254", "-o", paths[0], paths[1]];
    text_of(&run("rsvg-convert", "librsvg2-bin", &arguments));
    let read = fs::read(&picture).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(read)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let channels = info.line_size / info.width as usize;
    let surface = &pot.surfaces()[0];
    let widest_mm = 1e3 * surface.column_m(0).iter().copied().fold(0.0, f32::max);
    // a margin of 10 mm all round
    assert!((info.width as f32 / 10.0 - 2.0 * (widest_mm + 10.0)).abs() < 0.2, "{} px wide", info.width);
    let is_clay = |x_mm: f32, z_mm: f32| {
        let column = ((widest_mm + 10.0 + x_mm) * 10.0) as usize;
        let row = ((10.0 + 1e3 * surface.height_m() - z_mm) * 10.0) as usize;
        let pixel = &pixels[row * info.line_size + column * channels..][..3];
        pixel == [0xd8, 0xb4, 0x9a]
    };
    for row in [5, 20, 37, 50] {
        let z_mm = 1e3 * surface.row_z_m(row);
        for (column, sign) in [(0, 1.0), (36, -1.0)] {
            let outer_mm = 1e3 * surface.column_m(column)[row as usize];
            // the walls are drawn 0.35 mm wide, half of it on each side
            let [middle_mm, outside_mm, hollow_mm] = [outer_mm - 4.0, outer_mm + 1.0, outer_mm - 9.0];
            assert!(is_clay(sign * middle_mm, z_mm), "no clay in the wall at row {row}");
            assert!(!is_clay(sign * outside_mm, z_mm), "clay outside at row {row}");
            assert_eq!(is_clay(sign * hollow_mm, z_mm), row < floor_row(&pot), "row {row}");
        }
    }
    let text = fs::read_to_string(&drawing).unwrap();
    for id in ["id=\"clay\"", "id=\"outer\"", "id=\"inner\"", "id=\"scale\"", ">50 mm<"] {
        assert!(text.contains(id), "{id} is not in the drawing");
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn ending_that_says_nothing_is_refused() {
    for name in ["pot", "pot.", ".stl", "pot.step", "stl"] {
        let error = export(&crooked(), Path::new(name)).unwrap_err();
        assert!(matches!(error, ExportError::Ending { .. }) && error.to_string().contains(".3mf"), "{error}");
    }
}
