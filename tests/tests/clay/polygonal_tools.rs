//! Convex tools: what is refused, what is cut, and that a sphere made of facets is a sphere.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::f64::consts::PI;

use glam::{DQuat, DVec3, EulerRot, Quat, Vec2, Vec3};
use pottery_client::tool_file::Thinned;
use pottery_shared::session::BROUGHT_TRIANGLES_MAX;
use pottery_shared::tool::rack::{ball, blade, knuckle, loop_end, rib, standard};
use pottery_shared::tool::{ConvexError, ConvexTool, Extent, Lattice, Pose, Sections, Sides};
use pottery_shared::units::Metres;
use proptest::prelude::*;

const COLUMNS: usize = 360;
const ROWS: u32 = 400;
const ROW_HEIGHT_M: f32 = 0.2 / 399.0;

/// Rounding: the farthest place is 0.3 m away, where a place in `f32` is 3e-8 m wide, and a corner's place is the sum of
/// four products.
const ROUNDING_M: f64 = 2e-7;
/// Sections thinner than this may be left out, as [`Sections::cut`] says.
const LEFT_OUT_M: f64 = 2e-5;

fn directions() -> Vec<Vec2> {
    let angle = |column: usize| column as f64 * 2.0 * PI / COLUMNS as f64;
    (0..COLUMNS).map(|column| Vec2::new(angle(column).cos() as f32, angle(column).sin() as f32)).collect()
}

fn lattice(directions: &[Vec2]) -> Lattice<'_> {
    Lattice { directions, rows: ROWS, row_height_m: ROW_HEIGHT_M }
}

/// Every facet's plane in the room: `n·x ≤ d`.
fn planes(tool: &ConvexTool, pose: &Pose) -> Vec<(DVec3, f64)> {
    let turn = DQuat::from_array(pose.orientation.to_array().map(f64::from)).normalize();
    tool.triangles_m()
        .zip(tool.normals())
        .map(|([a, ..], normal)| {
            let normal = turn * normal.as_dvec3();
            (normal, normal.dot(turn * a.as_dvec3() + pose.centre_m.as_dvec3()))
        })
        .collect()
}

/// Where the ray at a height in a direction from the axis is inside all planes moved outwards by `out_m`; none when it
/// never is.
fn inside(planes: &[(DVec3, f64)], direction: Vec2, height_m: f64, out_m: f64) -> Option<(f64, f64)> {
    let (mut low, mut high) = (0.0_f64, f64::INFINITY);
    for (normal, distance) in planes {
        let along = normal.x * f64::from(direction.x) + normal.y * f64::from(direction.y);
        let room = distance + out_m - normal.z * height_m;
        if along < 0.0 {
            low = low.max(room / along);
        } else if along > 0.0 {
            high = high.min(room / along);
        } else if room < 0.0 {
            return None;
        }
    }
    (low <= high).then_some((low, high))
}

/// Compares every element of the lattice with the planes; returns the number that is cut.
fn assert_cut_is_that_of_the_planes(tool: &ConvexTool, pose: &Pose, reach_m: f32) -> usize {
    let directions = directions();
    let mut sections = Sections::for_lattice(COLUMNS as u32, ROWS);
    sections.cut(tool, pose, &lattice(&directions), reach_m, Sides::Both);
    let planes = planes(tool, pose);
    let mut cut = vec![None; COLUMNS * ROWS as usize];
    for section in sections.iter() {
        let start = section.column as usize * ROWS as usize + section.first_row as usize;
        assert!(section.far_m.len() == section.near_m.len() && section.facet.len() == section.near_m.len());
        for (at, &near_m) in section.near_m.iter().enumerate() {
            assert!(usize::from(section.facet[at]) < tool.normals().len());
            let old = cut[start + at].replace((near_m, section.far_m[at], section.facet[at]));
            assert!(old.is_none(), "an element is cut twice");
        }
    }
    // rows far from the tool cost time and can be seen to be empty
    let reach_z = |row: u32| (row as f32 * ROW_HEIGHT_M - pose.centre_m.z).abs() <= tool.radius().0 + ROW_HEIGHT_M;
    for (at, found) in cut.iter().enumerate() {
        let (column, row) = (at / ROWS as usize, (at % ROWS as usize) as u32);
        let place = || format!("column {column}, row {row}: {found:?} in {pose:?}");
        if !reach_z(row) {
            assert!(found.is_none(), "{}", place());
            continue;
        }
        let (direction, height_m) = (directions[column], f64::from(row) * f64::from(ROW_HEIGHT_M));
        let outer = inside(&planes, direction, height_m, ROUNDING_M);
        let inner = inside(&planes, direction, height_m, -ROUNDING_M);
        if let Some((near_m, far_m, facet)) = *found {
            let Some((first_m, last_m)) = outer else { panic!("{}: the ray misses the tool", place()) };
            let (near_m, far_m) = (f64::from(near_m), f64::from(far_m));
            assert!(first_m - 1e-8 <= near_m && far_m <= last_m + 1e-8, "{}: {outer:?}", place());
            assert!(near_m <= far_m, "{}", place());
            if let Some((first_m, last_m)) = inner {
                assert!(near_m <= first_m + 1e-8 && last_m - 1e-8 <= far_m, "{}: {inner:?}", place());
            }
            // the facet named is the one that the near side lies on
            let (normal, distance) = planes[usize::from(facet)];
            let hit = DVec3::new(f64::from(direction.x) * near_m, f64::from(direction.y) * near_m, height_m);
            assert!(near_m == 0.0 || (normal.dot(hit) - distance).abs() < 2.0 * ROUNDING_M, "{}", place());
        } else if let Some((first_m, last_m)) = inside(&planes, direction, height_m, -LEFT_OUT_M) {
            let is_beyond = first_m > f64::from(reach_m) - LEFT_OUT_M || last_m < LEFT_OUT_M;
            assert!(is_beyond, "{}: left out, but inside from {first_m} to {last_m} m", place());
        }
    }
    assert_far_side_is_that_of_the_planes(tool, pose, &planes);
    cut.iter().flatten().count()
}

/// The same of the far side, as far as it is beyond 40 mm.
fn assert_far_side_is_that_of_the_planes(tool: &ConvexTool, pose: &Pose, planes: &[(DVec3, f64)]) {
    const WITHIN_M: f32 = 0.04;
    let directions = directions();
    let mut sections = Sections::for_lattice(COLUMNS as u32, ROWS);
    sections.cut(tool, pose, &lattice(&directions), WITHIN_M, Sides::Far);
    let mut cut = vec![None; COLUMNS * ROWS as usize];
    for section in sections.iter() {
        let start = section.column as usize * ROWS as usize + section.first_row as usize;
        assert!(section.near_m.is_empty() && section.facet.is_empty());
        assert_eq!(section.far_facet.len(), section.far_m.len());
        for (at, &far_m) in section.far_m.iter().enumerate() {
            let old = cut[start + at].replace((f64::from(far_m), section.far_facet[at]));
            assert!(old.is_none(), "an element is cut twice");
        }
    }
    let reach_z = |row: u32| (row as f32 * ROW_HEIGHT_M - pose.centre_m.z).abs() <= tool.radius().0 + ROW_HEIGHT_M;
    for (at, found) in cut.iter().enumerate() {
        let (column, row) = (at / ROWS as usize, (at % ROWS as usize) as u32);
        if !reach_z(row) {
            assert!(found.is_none());
            continue;
        }
        let (direction, height_m) = (directions[column], f64::from(row) * f64::from(ROW_HEIGHT_M));
        let place = || format!("column {column}, row {row}: {found:?} in {pose:?}");
        let hits = |out_m: f64| inside(planes, direction, height_m, out_m);
        if let Some((far_m, facet)) = *found {
            let Some((_, last_m)) = hits(ROUNDING_M) else { panic!("{}: the ray misses the tool", place()) };
            assert!(far_m <= last_m + 1e-8, "{}: {last_m}", place());
            if let Some((_, last_m)) = hits(-ROUNDING_M) {
                assert!(last_m - 1e-8 <= far_m, "{}: {last_m}", place());
            }
            let (normal, distance) = planes[usize::from(facet)];
            let hit = DVec3::new(f64::from(direction.x) * far_m, f64::from(direction.y) * far_m, height_m);
            assert!((normal.dot(hit) - distance).abs() < 2.0 * ROUNDING_M, "{}", place());
        } else if let Some((_, last_m)) = hits(-LEFT_OUT_M) {
            assert!(last_m < f64::from(WITHIN_M) + LEFT_OUT_M, "{}: left out, but ends at {last_m} m", place());
        }
    }
}

/// The hull of a few points in general position, by trying every three of them.
fn hull(points: &[Vec3]) -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    for (i, &a) in points.iter().enumerate() {
        for (j, &b) in points.iter().enumerate().skip(i + 1) {
            for &c in &points[j + 1..] {
                let [p, q, r] = [a, b, c].map(|point| point.as_dvec3());
                let normal = (q - p).cross(r - p).normalize_or_zero();
                let out = |point: &Vec3| normal.dot(point.as_dvec3() - p);
                let (low, high) = points.iter().map(out).fold((0.0_f64, 0.0_f64), |(l, h), o| (l.min(o), h.max(o)));
                if high < 1e-9 && low < -1e-9 {
                    triangles.push([a, b, c]);
                } else if low > -1e-9 && high > 1e-9 {
                    triangles.push([a, c, b]);
                }
            }
        }
    }
    triangles
}

fn any_quaternion() -> impl Strategy<Value = Quat> {
    prop::array::uniform4(-1.0_f32..1.0)
        .prop_filter("of no length", |parts| parts.iter().map(|part| part * part).sum::<f32>() > 1e-2)
        .prop_map(Quat::from_array)
}

/// Near the clay, round the axis, over the rim and under the foot.
fn any_pose() -> impl Strategy<Value = Pose> {
    (0.0_f32..0.12, -180.0_f32..180.0, -0.03_f32..0.23, any_quaternion()).prop_map(
        |(distance, turn, z, orientation)| {
            let (sin, cos) = turn.to_radians().sin_cos();
            Pose { centre_m: Vec3::new(distance * cos, distance * sin, z), orientation }
        },
    )
}

/// Turned by quarters and eighths, on a row or a column: facets edge-on and parallel to rows, corners on rows.
fn any_neat_pose() -> impl Strategy<Value = Pose> {
    (0_u32..8, 0_i32..25, 0_u32..400, prop::array::uniform3(0_i32..8)).prop_map(|(turn, distance, row, eighths)| {
        let (sin, cos) = (turn as f32 * 45.0).to_radians().sin_cos();
        let distance = distance as f32 * 0.005;
        let [x, y, z] = eighths.map(|eighth| eighth as f32 * std::f32::consts::FRAC_PI_4);
        let centre_m = Vec3::new(distance * cos, distance * sin, row as f32 * ROW_HEIGHT_M);
        Pose { centre_m, orientation: Quat::from_euler(EulerRot::XYZ, x, y, z) }
    })
}

fn any_hull() -> impl Strategy<Value = ConvexTool> {
    (prop::collection::vec(prop::array::uniform3(-1.0_f32..1.0), 4..14), 0.002_f32..0.06).prop_filter_map(
        "the hull is too thin",
        |(points, size)| {
            let points: Vec<Vec3> = points.into_iter().map(|point| Vec3::from_array(point) * size).collect();
            ConvexTool::new(&hull(&points)).ok()
        },
    )
}

fn any_from_the_rack() -> impl Strategy<Value = ConvexTool> {
    prop_oneof![
        Just(rib().unwrap()),
        Just(blade().unwrap()),
        Just(knuckle().unwrap()),
        Just(loop_end().unwrap()),
        (0_u32..4, 0.5_f32..40.0).prop_map(|(subdivisions, mm)| ball(subdivisions, Metres::from_mm(mm)).unwrap()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn hulls_are_cut_as_their_planes_say(tool in any_hull(), pose in any_pose(), reach_m in 0.02_f32..0.1) {
        assert_cut_is_that_of_the_planes(&tool, &pose, reach_m);
    }

    #[test]
    fn tools_of_the_rack_are_cut_as_their_planes_say(tool in any_from_the_rack(), pose in any_pose()) {
        assert_cut_is_that_of_the_planes(&tool, &pose, 0.06);
    }

    #[test]
    fn neatly_held_tools_are_cut_as_their_planes_say(
        tool in prop_oneof![any_from_the_rack(), any_hull()],
        pose in any_neat_pose(),
    ) {
        assert_cut_is_that_of_the_planes(&tool, &pose, 0.07);
    }
}

fn cube(size_m: f32) -> Vec<[Vec3; 3]> {
    let corner = |at: usize| Vec3::new((at & 1) as f32, (at >> 1 & 1) as f32, (at >> 2) as f32) * size_m;
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]].map(|face| face.map(corner))).collect()
}

fn refused(triangles: &[[Vec3; 3]]) -> ConvexError {
    ConvexTool::new(triangles).expect_err("it should be refused")
}

#[test]
fn cube_is_accepted_with_its_measures() {
    let tool = ConvexTool::new(&cube(0.02)).unwrap();
    // four products of numbers with 24 bits
    assert!((tool.volume_m3() - 8e-6).abs() < 1e-12, "{}", tool.volume_m3());
    assert!(tool.centre_m().distance(Vec3::splat(0.01)) < 1e-8, "{}", tool.centre_m());
    assert!((tool.radius().0 - 0.01 * 3.0_f32.sqrt()).abs() < 1e-8, "{:?}", tool.radius());
    for ([a, b, c], normal) in tool.triangles_m().zip(tool.normals()) {
        assert!((b - a).cross(c - a).normalize().distance(*normal) < 1e-6);
        assert!(normal.dot(a) > 0.0, "the normal {normal} points inwards");
    }
}

#[test]
fn mesh_that_is_no_convex_solid_is_refused_for_what_it_is() {
    let good = cube(0.02);
    let with = |change: &dyn Fn(&mut Vec<[Vec3; 3]>)| {
        let mut mesh = good.clone();
        change(&mut mesh);
        refused(&mesh)
    };
    assert!(matches!(with(&|mesh| mesh[7][1].y = f32::NAN), ConvexError::NotANumber { triangle: 7 }));
    assert!(matches!(with(&|mesh| mesh[3][0].x = f32::INFINITY), ConvexError::NotANumber { triangle: 3 }));
    assert!(matches!(with(&|mesh| mesh.truncate(3)), ConvexError::TooFew { triangles: 3, min: 4, .. }));
    assert!(matches!(with(&|mesh| mesh.resize(20_481, mesh[0])), ConvexError::TooMany { triangles: 20_481, .. }));
    assert!(matches!(with(&|mesh| mesh.truncate(11)), ConvexError::Open { .. }));
    assert!(matches!(with(&|mesh| mesh[4].swap(0, 1)), ConvexError::Twisted { .. }));
    assert!(matches!(with(&|mesh| mesh.extend(mesh.clone())), ConvexError::Crowded { facets: 4, .. }));
    let beside = good.iter().map(|triangle| triangle.map(|corner| corner + Vec3::X * 0.03));
    let two = with(&|mesh| mesh.extend(beside.clone()));
    assert!(matches!(two, ConvexError::Several { solids: 2 }), "{two}");
    assert!(matches!(
        with(&|mesh| mesh.iter_mut().for_each(|triangle| triangle.swap(0, 1))),
        ConvexError::InsideOut { volume_mm3 } if (volume_mm3 + 8000.0).abs() < 0.1
    ));
    let scaled = |size: f32| with(&|mesh| mesh.iter_mut().flatten().for_each(|corner| *corner *= size));
    assert!(matches!(scaled(1000.0), ConvexError::Size { .. }));
    assert!(matches!(scaled(1e-3), ConvexError::Size { .. }));
    assert!(matches!(scaled(1e36), ConvexError::Size { .. }));
    let flat = with(&|mesh| mesh.iter_mut().flatten().for_each(|corner| corner.z *= 1e-3));
    assert!(matches!(flat, ConvexError::Thin { thickness_mm, .. } if (thickness_mm - 0.02).abs() < 1e-4), "{flat}");
}

#[test]
fn dent_in_a_mesh_is_measured() {
    // the corner at the far end drawn in: the diagonals of its three quads stand out
    let mut mesh = cube(0.02);
    for corner in mesh.iter_mut().flatten().filter(|corner| **corner == Vec3::splat(0.02)) {
        *corner = Vec3::splat(0.017);
    }
    let ConvexError::NotConvex { bulge_mm, max_mm, .. } = refused(&mesh) else { panic!("a dent is not convex") };
    // the corner was drawn in by 5.2 mm along the diagonal
    assert!(bulge_mm > 0.5 && bulge_mm < 5.2 && (max_mm - 0.005).abs() < 1e-6, "{bulge_mm} of {max_mm} mm");
    // a corner 2 µm inside of its faces is what a file with few digits leaves
    for corner in mesh.iter_mut().flatten().filter(|corner| **corner == Vec3::splat(0.017)) {
        *corner = Vec3::splat(0.019_998);
    }
    ConvexTool::new(&mesh).unwrap();
}

#[test]
fn slivers_and_nearly_equal_corners_change_nothing() {
    let mut mesh = cube(0.02);
    // an edge split at its middle on one side only, and the gap closed by a triangle without area
    let [a, b, c] = mesh[0];
    let middle = (a + b) / 2.0;
    mesh[0] = [a, middle, c];
    mesh.push([middle, b, c]);
    mesh.push([a, b, middle]);
    // a corner 0.3 µm beside itself
    mesh[5][2] += Vec3::new(3e-7, 0.0, 0.0);
    let (split, whole) = (ConvexTool::new(&mesh).unwrap(), ConvexTool::new(&cube(0.02)).unwrap());
    assert_eq!(split.normals().len(), 14);
    let pose = Pose { centre_m: Vec3::new(0.06, 0.0, 0.1), orientation: Quat::from_rotation_x(0.3) };
    let directions = directions();
    let cut = |tool: &ConvexTool| {
        let mut sections = Sections::for_lattice(COLUMNS as u32, ROWS);
        sections.cut(tool, &pose, &lattice(&directions), 0.055, Sides::Near);
        sections.iter().flat_map(|section| section.near_m.to_vec()).collect::<Vec<_>>()
    };
    let (split, whole) = (cut(&split), cut(&whole));
    assert!(!whole.is_empty());
    assert_eq!(split.len(), whole.len());
    // 0.3 µm, as the corner
    assert!(split.iter().zip(&whole).all(|(a, b)| (a - b).abs() < 5e-7));
}

#[test]
fn every_tool_of_the_rack_has_its_measures() {
    let extent_mm = |tool: &ConvexTool| {
        let all = || tool.triangles_m().flatten();
        (all().fold(Vec3::MIN, Vec3::max) - all().fold(Vec3::MAX, Vec3::min)) * 1e3
    };
    let measures = [
        ("rib", rib().unwrap(), Vec3::new(50.0, 4.0, 100.0), 20.0..140.0),
        ("blade", blade().unwrap(), Vec3::new(20.0, 6.0, 150.0), 10.0..60.0),
        ("knuckle", knuckle().unwrap(), Vec3::new(20.0, 18.0, 28.0), 300.0..330.0),
        ("loop", loop_end().unwrap(), Vec3::new(30.0, 3.0, 30.0), 300.0..500.0),
    ];
    for (name, tool, wanted_mm, facets) in measures {
        // the knuckle's corners stand out so that its volume is that of the smooth one: 1.5 % at 320 facets
        assert!((extent_mm(&tool) / wanted_mm - Vec3::ONE).abs().max_element() < 0.02, "{name}: {}", extent_mm(&tool));
        assert!(facets.contains(&(tool.normals().len() as f32)), "{name}: {} facets", tool.normals().len());
    }
    for subdivisions in 0..=5 {
        let tool = ball(subdivisions, Metres::from_mm(12.0)).unwrap();
        let sphere_m3 = 4.0 / 3.0 * PI * 0.012_f64.powi(3);
        // the corners are rounded to 24 bits
        assert!((f64::from(tool.volume_m3()) / sphere_m3 - 1.0).abs() < 1e-6, "{subdivisions}");
        assert_eq!(tool.normals().len(), 20 << (2 * subdivisions));
    }
    assert!(matches!(ball(6, Metres::from_mm(12.0)), Err(ConvexError::TooMany { triangles: 81_920, .. })));
    assert!(matches!(ball(u32::MAX, Metres::from_mm(12.0)), Err(ConvexError::TooMany { .. })));
    assert!(matches!(ball(2, Metres::from_mm(0.4)), Err(ConvexError::Size { .. })));
}

/// Volume between the near side and a cylinder of 60 mm, m³, and the places on the near side.
fn pressed(tool: &ConvexTool, pose: &Pose) -> (f64, Vec<DVec3>) {
    let directions = directions();
    let mut sections = Sections::for_lattice(COLUMNS as u32, ROWS);
    sections.cut(tool, pose, &lattice(&directions), 0.06, Sides::Near);
    let element_m2 = 2.0 * PI / COLUMNS as f64 * f64::from(ROW_HEIGHT_M) * 0.06;
    let mut depth_m = 0.0;
    let mut places = Vec::new();
    for section in sections.iter() {
        let direction = directions[section.column as usize].as_dvec2();
        for (row, &near_m) in (section.first_row..).zip(section.near_m) {
            depth_m += 0.06 - f64::from(near_m);
            places.push((direction * f64::from(near_m)).extend(f64::from(row) * f64::from(ROW_HEIGHT_M)));
        }
    }
    (depth_m * element_m2, places)
}

#[test]
fn ball_of_facets_presses_as_the_sphere_does() {
    let sphere_m3 = |centre: DVec3| {
        let mut depth_m = 0.0;
        for direction in directions() {
            for row in 0..ROWS {
                let (cos, sin) = (f64::from(direction.x), f64::from(direction.y));
                let (along, aside) = (centre.x * cos + centre.y * sin, centre.y * cos - centre.x * sin);
                let above = f64::from(row) * f64::from(ROW_HEIGHT_M) - centre.z;
                let within = 0.012 * 0.012 - aside * aside - above * above;
                if within > 0.0 && along > 0.0 {
                    depth_m += (0.06 - along + within.sqrt()).max(0.0);
                }
            }
        }
        depth_m * 2.0 * PI / COLUMNS as f64 * f64::from(ROW_HEIGHT_M) * 0.06
    };
    // a facet of an icosphere has sides of about 1.1·R/2ⁿ and its middle lies s²/6R inside of its corners
    let radius = Metres::from_mm(12.0);
    let fine = ball(4, radius).unwrap();
    let thinned = Thinned::of(&fine, BROUGHT_TRIANGLES_MAX).unwrap().tool;
    for (subdivisions, tool, share) in [(3, ball(3, radius).unwrap(), 0.02), (4, fine, 0.005), (3, thinned, 0.02)] {
        let side_m = 1.2 * 0.012 / f64::from(1 << subdivisions);
        let sagitta_m = side_m * side_m / (6.0 * 0.012);
        for (turn, z, depth_mm) in [(0.0, 0.1, 2.0), (0.7, 0.05, 1.0), (2.5, 0.123, 4.0), (-3.0, 0.2, 2.0)] {
            let distance_m = 0.072 - depth_mm * 1e-3;
            let centre = DVec3::new(distance_m * f64::cos(turn), distance_m * f64::sin(turn), z);
            let orientation = Quat::from_xyzw(0.3, turn as f32, 0.2, 0.7);
            let (volume_m3, places) = pressed(&tool, &Pose { centre_m: centre.as_vec3(), orientation });
            let exact_m3 = sphere_m3(centre);
            let error = volume_m3 / exact_m3 - 1.0;
            assert!(error.abs() < share, "{subdivisions} subdivisions, {depth_mm} mm: {error}");
            for place in places {
                let out_m = place.distance(centre) - 0.012;
                assert!(out_m.abs() < sagitta_m, "{place} lies {out_m} m out of the sphere, allowed {sagitta_m}");
            }
        }
    }
}

#[test]
fn section_too_thin_to_walk_on_ends_after_one_round() {
    // a needle's end between two columns: what goes round it has to stop by itself, and the search has to go on
    let [a, b, c, d] = [
        Vec3::new(-0.007254274, 0.014021458, -0.009717814),
        Vec3::new(-0.009284683, 0.022689747, 0.004732199),
        Vec3::new(-0.007854514, 0.015532464, -0.03245885),
        Vec3::new(0.024393471, -0.052243672, 0.037444465),
    ];
    let needle = ConvexTool::new(&[[a, b, c], [a, d, b], [a, c, d], [b, d, c]]).unwrap();
    let centre_m = Vec3::new(-0.0048544533, 0.09825789, 0.12654728);
    let orientation = Quat::from_xyzw(-0.16762556, -0.59425706, 0.3946442, -0.43461362);
    assert!(assert_cut_is_that_of_the_planes(&needle, &Pose { centre_m, orientation }, 0.085_512_19) > 0);
}

#[test]
fn faces_that_lie_in_a_row_are_cut_as_their_planes_say() {
    // a plane along a ray meets it anywhere
    for (tool, half_m, level) in [
        (ConvexTool::new(&cube(0.02)).unwrap(), 0.01, Quat::IDENTITY),
        (blade().unwrap(), 0.003, Quat::from_rotation_x(std::f32::consts::FRAC_PI_2)),
    ] {
        for tilt_rad in [0.0_f32, 1e-7, -1e-6, 1e-5, -1e-4, 1e-3] {
            for off_m in [0.0_f32, 1e-8, -1e-7, 3e-6, -1e-5] {
                let centre_m = Vec3::new(0.07, 0.003, 200.0 * ROW_HEIGHT_M + half_m + off_m);
                let orientation = Quat::from_rotation_y(tilt_rad) * Quat::from_rotation_x(0.3 * tilt_rad) * level;
                assert!(assert_cut_is_that_of_the_planes(&tool, &Pose { centre_m, orientation }, 0.08) > 0);
            }
        }
    }
}

#[test]
fn pose_that_is_none_cuts_nothing() {
    let (tool, directions) = (knuckle().unwrap(), directions());
    let mut sections = Sections::for_lattice(COLUMNS as u32, ROWS);
    let centre_m = Vec3::new(0.06, 0.0, 0.1);
    let good = Pose { centre_m, orientation: Quat::IDENTITY };
    sections.cut(&tool, &good, &lattice(&directions), 0.06, Sides::Near);
    assert!(sections.iter().len() > 10);
    let strange = [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e30];
    let places =
        strange.iter().flat_map(|&bad| [0, 1, 2].map(|axis| Pose { centre_m: moved(centre_m, axis, bad), ..good }));
    let turns = [f32::NAN, f32::INFINITY].map(|bad| Pose { orientation: Quat::from_xyzw(0.0, bad, 0.0, 1.0), ..good });
    let turns = turns.into_iter().chain([Pose { orientation: Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), ..good }]);
    for pose in places.chain(turns) {
        sections.cut(&tool, &pose, &lattice(&directions), 0.06, Sides::Both);
        assert_eq!(sections.iter().len(), 0, "{pose:?}");
        assert_eq!(sections.extent(), Extent::default());
    }
    for (rows, row_height_m) in [(0, 1e-3), (400, 0.0), (400, f32::NAN), (400, -1e-3), (1 << 20, 1e-3), (400, 1e-9)] {
        sections.cut(&tool, &good, &Lattice { directions: &directions, rows, row_height_m }, 0.06, Sides::Near);
        assert_eq!(sections.iter().len(), 0, "{rows} rows, {row_height_m} m apart");
    }
    sections.cut(&tool, &good, &Lattice { directions: &[], rows: 400, row_height_m: 1e-3 }, 0.06, Sides::Near);
    assert_eq!(sections.iter().len(), 0, "no columns");
}

fn moved(place: Vec3, axis: usize, to: f32) -> Vec3 {
    let mut parts = place.to_array();
    parts[axis] = to;
    Vec3::from_array(parts)
}

/// Bits of everything that is cut, column by column.
fn bits(sections: &Sections) -> Vec<u64> {
    let mut found = Vec::new();
    let mut cut: Vec<_> = sections.iter().collect();
    cut.sort_by_key(|section| section.column);
    for section in cut {
        found.push(u64::from(section.column) << 32 | u64::from(section.first_row));
        found.extend(section.near_m.iter().map(|near_m| u64::from(near_m.to_bits())));
        found.extend(section.facet.iter().map(|&facet| u64::from(facet)));
    }
    found
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn what_was_cut_before_leaves_no_trace(
        first in any_from_the_rack(),
        second in any_from_the_rack(),
        poses in (any_pose(), any_pose()),
    ) {
        let directions = directions();
        let mut used = Sections::for_lattice(COLUMNS as u32, ROWS);
        used.cut(&first, &poses.0, &lattice(&directions), 0.06, Sides::Both);
        used.cut(&second, &poses.1, &lattice(&directions), 0.06, Sides::Near);
        let mut fresh = Sections::default();
        fresh.cut(&second, &poses.1, &lattice(&directions), 0.06, Sides::Near);
        prop_assert_eq!(bits(&used), bits(&fresh));
    }

    #[test]
    fn extent_holds_every_section(tool in any_from_the_rack(), pose in any_pose()) {
        let directions = directions();
        let mut sections = Sections::for_lattice(COLUMNS as u32, ROWS);
        sections.cut(&tool, &pose, &lattice(&directions), 0.06, Sides::Near);
        let extent = sections.extent();
        for section in sections.iter() {
            let local = (section.column + COLUMNS as u32 - extent.first_column) % COLUMNS as u32;
            prop_assert!(local < extent.columns);
            prop_assert!(section.first_row >= extent.first_row);
            prop_assert!(section.first_row + section.near_m.len() as u32 <= extent.first_row + extent.rows);
        }
    }
}

#[test]
fn tools_on_the_wall_are_made_once_for_all() {
    let threads: Vec<_> = (0..4).map(|_| std::thread::spawn(standard)).collect();
    for rack in threads.into_iter().map(|thread| thread.join().unwrap()) {
        assert_eq!(rack.len(), 4);
        assert!(std::sync::Arc::ptr_eq(&rack, &standard()));
    }
}

#[test]
fn cut_has_the_same_bits_everywhere() {
    let directions = directions();
    let mut sections = Sections::for_lattice(COLUMNS as u32, ROWS);
    let mut digest = 0xcbf2_9ce4_8422_2325_u64;
    for tool in [rib(), blade(), knuckle(), loop_end(), ball(3, Metres::from_mm(12.0))] {
        let tool = tool.unwrap();
        for step in 0..40_u8 {
            let turn = f32::from(step) * 0.3;
            let orientation = Quat::from_xyzw(0.1 * turn, 0.5, 0.3 - 0.2 * turn, 1.0);
            let centre_m = Vec3::new(0.068 - 0.001 * turn, 0.002 * turn, 0.02 + 0.01 * turn);
            sections.cut(&tool, &Pose { centre_m, orientation }, &lattice(&directions), 0.06, Sides::Near);
            // FNV-1a over words
            digest = bits(&sections).iter().fold(digest, |sum, word| (sum ^ word).wrapping_mul(0x0100_0000_01b3));
        }
    }
    assert_eq!(format!("{digest:016x}"), "e7c64a9df89cc2a3");
}
