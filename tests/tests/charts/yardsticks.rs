//! Each yardstick against its own closed form, and all of them on the dents of the reference.
//!
//! What a yardstick makes of clay is reported, not judged: none of these methods knows that clay yields.

use std::f64::consts::PI;

use glam::Vec3;
use pottery_shared::clay::{GridShape, Method, MethodKind, Pot, PotSpec, Press, Strength, SubStep, Support};
use pottery_shared::tool::Sphere;
use pottery_shared::units::Metres;
use pottery_tests::chart::cases::{Support as Standing, reference_profile};
use pottery_tests::dent::{Dent, DentError, Dented};
use pottery_tests::yardstick::free_form::Lattice;
use pottery_tests::yardstick::greens::{Base, Contact, Layer, LocalTable};
use pottery_tests::yardstick::literal::LiteralCsem;
use pottery_tests::yardstick::long_elements::LongElements;
use pottery_tests::yardstick::shell::{End, Loose, Shell};
use pottery_tests::yardstick::{closed_forms, free_form, greens, literal, long_elements};

fn close(measured: f64, expected: f64, tolerance: f64, what: &str) {
    let error = measured / expected - 1.0;
    println!("{what}: {measured:.6e}, closed form {expected:.6e}, off by {error:.2e}");
    assert!(error.abs() < tolerance, "{what}: {measured} instead of {expected}");
}

#[test]
fn closed_forms_agree_where_they_meet() {
    // a thick tube becomes a thin one: w = pR²/(Et), but for t/R
    close(closed_forms::lame_mm(0.1, [99.0, 100.0], 2.0, 0.0, 100.0), 0.1 * 1e4 / 2.0, 1.1e-2, "Lamé of a thin tube");
    // a solid rod: u = p(1 − ν)r/E
    close(closed_forms::lame_mm(0.1, [0.0, 50.0], 2.0, 0.45, 50.0), 0.1 * 0.55 * 50.0 / 2.0, 1e-12, "Lamé of a rod");
    // Hertz's mean pressure at depth δ is 4E*/(3π)·√(δ/R)
    let (sphere, depth) = (12.0, 0.3_f64);
    let mean = closed_forms::hertz_n(CONTACT_MODULUS, sphere, depth) / (PI * sphere * depth);
    close(mean, 4.0 / (3.0 * PI) * CONTACT_MODULUS * (depth / sphere).sqrt(), 1e-12, "Hertz's mean pressure");
}

// free-form deformation

fn lattice() -> Lattice {
    Lattice::new([52.0, 60.0], 200.0, 24, 10)
}

/// Points within the wall, some at the seam, at foot and at rim.
fn points() -> Vec<[f64; 3]> {
    let angles = [0.0, 1e-9, 0.3, 3.0, 6.2, 2.0 * PI - 1e-9];
    let places = [(0.0, 52.0), (57.0, 54.5), (100.0, 60.0), (200.0, 60.0)];
    angles.iter().flat_map(|&angle| places.map(|(z, r)| [angle, z, r])).collect()
}

#[test]
fn lattice_at_rest_moves_nothing() {
    for point in points() {
        assert_eq!(lattice().deform(point), point);
    }
}

#[test]
fn weights_of_a_point_add_up_to_one() {
    for point in points() {
        let sum: f64 = lattice().weights(point).map(|(_, weight)| weight).sum();
        assert!((sum - 1.0).abs() < 1e-14, "{point:?}: {sum}"); // rounding of 32 products
    }
}

#[test]
fn affine_motion_of_the_lattice_moves_points_by_the_same_map() {
    let map = |[_, z, r]: [f64; 3]| [0.2, 3.0 + 0.1 * z - 0.2 * r, -1.0 + 0.05 * z + 0.3 * r];
    let mut lattice = lattice();
    for control in lattice.control_points() {
        lattice.shift(control, map(lattice.rest(control)));
    }
    for point in points() {
        let (moved, by) = (lattice.deform(point), map(point));
        for axis in 0..3 {
            let off = moved[axis] - point[axis] - by[axis];
            assert!(off.abs() < 1e-12 * 200.0, "{point:?}: off by {off}"); // rounding at 200 mm
        }
    }
}

#[test]
fn pulled_point_arrives_where_it_was_asked_to() {
    let asked = [([0.01, 88.0, 60.0], [0.02, 1.5, -2.0]), ([1.0, 20.0, 60.0], [0.0, 0.0, 1.0])];
    let mut lattice = lattice();
    lattice.pull(&asked, 1e-10);
    for (point, by) in asked {
        let moved = lattice.deform(point);
        for axis in 0..3 {
            let off = moved[axis] - point[axis] - by[axis];
            assert!(off.abs() < 1e-8, "off by {off}"); // the damping of the pseudo-inverse
        }
    }
}

#[test]
fn least_squares_move_meets_an_affine_demand_at_more_points_than_control_points() {
    let demand = |z: f64| -0.5 + 0.004 * z;
    let grid =
        (0..240).flat_map(|column| (0..=100).map(move |row| (f64::from(column) * PI / 120.0, f64::from(row) * 2.0)));
    let asked: Vec<_> = grid.map(|(angle, z)| ([angle, z, 60.0], [0.0, 0.0, demand(z)])).collect();
    let mut lattice = lattice();
    lattice.pull(&asked, 1e-10);
    for (point, by) in asked {
        let off = lattice.deform(point)[2] - 60.0 - by[2];
        assert!(off.abs() < 1e-6, "off by {off}"); // the splines hold the demand exactly; damping
    }
}

// long elements

#[test]
fn one_long_element_is_a_spring() {
    let (stiffness, pressure) = (0.25, 0.01);
    let mut one = LongElements::new([1, 1], [2.0, 3.0], [stiffness, 0.0], false);
    one.load_mpa[0] = pressure;
    one.rest();
    // K·x = P·A with K = k·A
    close(one.moved_mm()[0] * stiffness * 6.0, pressure * 6.0, 1e-12, "one element");
}

#[test]
fn even_pressure_moves_all_long_elements_alike_and_closed_ones_not_at_all() {
    for closed in [false, true] {
        let mut elements = LongElements::new([12, 9], [1.0, 0.5], [0.25, 0.7], closed);
        elements.load_mpa.fill(-0.02);
        elements.rest();
        let expected = if closed { 0.0 } else { -0.02 / 0.25 };
        for moved in elements.moved_mm() {
            assert!((moved - expected).abs() < 1e-4, "{moved} instead of {expected}"); // where the sweeps stop
        }
    }
}

#[test]
fn closed_long_elements_keep_their_volume() {
    let mut elements = LongElements::new([40, 30], [1.0, 0.5], [0.25, 0.7], true);
    for column in 10..20 {
        for row in 12..18 {
            elements.obstacle_mm[column * 30 + row] = -1.0;
        }
    }
    elements.rest();
    let pushed_in = 10.0 * 6.0 * 0.5;
    println!("volume {:.2e} mm³, pressure {:.4} MPa", elements.volume_mm3(), elements.pressure_mpa());
    assert!(elements.volume_mm3().abs() < 1e-12 * pushed_in * 1200.0); // rounding of 1,200 terms
    assert!(elements.pressure_mpa() > 0.0, "displaced volume raises the pressure");
}

#[test]
fn skin_of_long_elements_decays_like_a_membrane() {
    let (side, stiffness, tension) = (0.25, 0.25, 1.0);
    let mut strip = LongElements::new([1, 200], [1.0, side], [stiffness, tension], false);
    strip.obstacle_mm[0] = -1.0;
    strip.rest();
    for row in [2, 4, 8, 16, 24] {
        let expected = closed_forms::membrane_share(row as f64 * side, tension, stiffness);
        // differences over h instead of slopes: s·h²/(24λ³), 0.8 per thousand at the last point
        close(-strip.moved_mm()[row], expected, 2e-3, "membrane");
    }
}

// shell

fn shell() -> Shell {
    let ends = [End::Diaphragm; 2];
    Shell { radius_mm: 50.0, wall_mm: 6.0, height_mm: 120.0, youngs_mpa: 1.0, poisson: 0.45, ends }
}

#[test]
fn shell_deflects_under_a_point_as_the_double_series() {
    let compliance = shell().compliance(60, 80).unwrap();
    for (angle, expected) in closed_forms::SHELL_POINT_LOAD {
        let measured = compliance.at_mm(angle.to_radians(), 60.0, 60.0);
        println!("{angle}°: {measured:.4} mm, series {expected:.4} mm");
        // sixty waves instead of three hundred, whose rest is a cusp of 1/n³ under the load
        assert!((measured - expected).abs() < 2e-3, "{angle}°: {measured} instead of {expected}");
    }
}

#[test]
fn pinched_cylinder_is_the_benchmark() {
    let ends = [End::Diaphragm; 2];
    let cylinder = Shell { radius_mm: 300.0, wall_mm: 3.0, height_mm: 600.0, youngs_mpa: 3e6, poisson: 0.3, ends };
    let compliance = cylinder.compliance(100, 160).unwrap();
    let both = compliance.at_mm(0.0, 300.0, 300.0) + compliance.at_mm(PI, 300.0, 300.0);
    close(both, closed_forms::PINCHED_CYLINDER, 5e-3, "pinched cylinder"); // the series' own limit lies 2e-3 above
}

#[test]
fn shell_without_ends_is_a_ring_under_opposed_loads() {
    let ring = Shell { height_mm: 10.0, poisson: 0.0, wall_mm: 1.0, ends: [End::Free, End::Clamped], ..shell() };
    assert!(ring.compliance(2, 8).is_ok());
    let free = Shell { ends: [End::Free; 2], ..ring };
    assert_eq!(free.compliance(2, 8).unwrap_err(), Loose { harmonic: 1 });
    // harmonics one by one: the even ones from 2 on hold both loads, along a line from foot to rim
    let elements = 8;
    let load = |node: usize| if node == 0 || node == elements { 0.5 } else { 1.0 } / elements as f64;
    let change: f64 = (0..=60)
        .step_by(2)
        .map(|harmonic| {
            let compliance = free.harmonic(harmonic, elements).unwrap();
            let middle: f64 = (0..=elements).map(|node| load(node) * compliance.row(0, node)[elements / 2]).sum();
            // two loads, each of which moves both points
            4.0 * middle
        })
        .sum();
    let inertia = 10.0 / 12.0;
    let expected = closed_forms::ring_mm(1.0, 50.0, 1.0, inertia);
    // hoop strain, absent from the formula, is (t/R)²/12 beside bending; sixty waves leave 3e-5
    close(change, expected, 1e-3, "ring");
}

#[test]
fn shell_under_a_ring_load_is_a_beam_on_an_elastic_base() {
    let tube = Shell { height_mm: 200.0, wall_mm: 1.5, ..shell() };
    let compliance = tube.compliance(1, 200).unwrap();
    let measured = compliance.row(0, 100)[100] * 2.0 * PI * tube.radius_mm;
    // axial force from diaphragms that let go of it is nil; ends are ten decay lengths away
    close(measured, closed_forms::ring_load_mm(1.0, 50.0, 1.5, 1.0, 0.45), 2e-3, "ring load");
}

#[test]
fn shell_is_reciprocal() {
    let pot = Shell { ends: [End::Clamped, End::Free], height_mm: 200.0, ..shell() };
    let compliance = pot.compliance(12, 40).unwrap();
    for harmonic in 0..12 {
        for (one, other) in [(3, 38), (20, 40), (11, 12)] {
            let (there, back) = (compliance.row(harmonic, one)[other], compliance.row(harmonic, other)[one]);
            let largest = compliance.row(harmonic, other)[other];
            assert!((there - back).abs() < 1e-9 * largest, "{there} and {back}"); // rounding in a banded solve
        }
    }
}

// Green's functions

const CONTACT_MODULUS: f64 = 2.0 / (1.0 - 0.45 * 0.45);

fn layer(base: Base) -> Layer {
    Layer { wall_mm: 8.0, youngs_mpa: 2.0, poisson: 0.45, base }
}

/// Contact of flat elements 0.25 mm wide, `half` to all sides of a sphere's axis.
fn flat_contact(table: &LocalTable, half: i64) -> (Contact, Vec<f64>) {
    let side = 2 * half + 1;
    let place = |element: usize| (element as i64 / side - half, element as i64 % side - half);
    let contact = Contact::new((side * side) as usize, |one, other| {
        let ((x, y), (other_x, other_y)) = (place(one), place(other));
        table.at_mm(x.abs_diff(other_x) as usize, y.abs_diff(other_y) as usize)
    });
    let distances = (0..(side * side) as usize).map(|element| {
        let (x, y) = place(element);
        (x as f64 * 0.25).hypot(y as f64 * 0.25)
    });
    (contact, distances.collect())
}

#[test]
fn half_space_deflects_as_boussinesq_says() {
    let table = layer(Base::Deep).table([0.25, 0.25], [80, 80]);
    for distance in [4, 16, 64] {
        let r_mm = distance as f64 * 0.25;
        // a square of side h is a point but for h²/(24r²)
        close(
            table.at_mm(distance, 0),
            closed_forms::boussinesq_mm(1.0, CONTACT_MODULUS, r_mm),
            3e-3,
            &format!("Boussinesq at {r_mm} mm"),
        );
    }
}

#[test]
fn sphere_on_a_half_space_needs_the_force_of_hertz() {
    let table = layer(Base::Deep).table([0.25, 0.25], [40, 40]);
    let (mut contact, distances) = flat_contact(&table, 12);
    let (sphere_mm, depth_mm) = (12.0, 0.4);
    // the paraboloid that Hertz's solution holds for
    let gaps: Vec<f64> = distances.iter().map(|r| depth_mm - r * r / (2.0 * sphere_mm)).collect();
    contact.press(&gaps);
    let force: f64 = contact.forces_n().iter().sum();
    // contact radius 2.2 mm: nine elements
    close(force, closed_forms::hertz_n(CONTACT_MODULUS, sphere_mm, depth_mm), 1e-2, "Hertz");
    // the edge of the contact, √(Rδ), within one element's diagonal
    let edge = (sphere_mm * depth_mm).sqrt();
    for (force, r) in contact.forces_n().iter().zip(&distances) {
        assert!(*force == 0.0 || *r < edge + 0.36, "pressed at {r} mm");
        assert!(*force > 0.0 || *r > edge - 0.36, "not pressed at {r} mm");
    }
}

#[test]
fn layer_is_stiffer_than_a_half_space_and_the_thinner_the_stiffer() {
    let deep = layer(Base::Deep).table([0.5, 0.5], [40, 40]);
    let core = layer(Base::Core).table([0.5, 0.5], [40, 40]);
    let thin = Layer { wall_mm: 4.0, ..layer(Base::Core) }.table([0.5, 0.5], [40, 40]);
    let thick = Layer { wall_mm: 800.0, ..layer(Base::Core) }.table([0.5, 0.5], [40, 40]);
    for distance in 0..20 {
        let [deep, core, thin] = [&deep, &core, &thin].map(|table| table.at_mm(distance, 0));
        assert!(thin < core && core < deep, "{distance}: {thin}, {core}, {deep}");
        close(thick.at_mm(distance, 0), deep, 2e-2, "layer of 800 mm"); // 1.2·r/t of the half-space is missing
    }
}

#[test]
fn wide_load_presses_a_layer_as_a_bar() {
    // a strip without end, 24 wall thicknesses wide
    let (side, half) = (2.0, 48_usize);
    let thin = Layer { wall_mm: 4.0, ..layer(Base::Core) };
    let table = thin.table([side, side], [half + 1, 4 * half]);
    let mut moved = 0.0;
    for column in 0..=half {
        for row in 0..4 * half {
            let mirrored = if column == 0 { 1.0 } else { 2.0 } * if row == 0 { 1.0 } else { 2.0 };
            moved += mirrored * table.at_mm(column, row) * side * side;
        }
    }
    close(moved, closed_forms::wide_load_mm_per_mpa(4.0, CONTACT_MODULUS), 2e-2, "wide load"); // ends of the strip
}

// the improved CSEM, literally

/// A press of 0.1 mm at mid-height by a tool so small that it touches one element of a coarse pot: how far each has moved, m.
fn single(method: impl Method) -> (Vec<f32>, GridShape) {
    let shape = GridShape::new(90, 101).expect("a grid of 9090 elements is in range");
    let mut pot = Pot::new(PotSpec { shape, ..PotSpec::default() }).expect("the default pot can be made");
    let tool = Sphere::new(Metres::from_mm(3.0)).expect("3 mm is in range");
    // it touches 0.8 mm to all sides
    let press = Press { response: 1.0, ..Press::held(tool, Vec3::new(0.0629, 0.0, 0.1)) };
    SubStep::for_grid(shape).advance(&mut pot, &[press], method, |_, _| {});
    (pot.surfaces()[0].radii_m().iter().map(|radius_m| 0.06 - radius_m).collect(), shape)
}

#[test]
fn hulls_of_one_element_follow_the_published_formula() {
    let (moved_m, shape) = single(LiteralCsem);
    let arc_m = 0.06 * shape.column_angle_rad();
    let middle = 50_i64;
    let push_m = moved_m[middle as usize];
    assert!((push_m - 1e-4).abs() < 1e-7, "{push_m}"); // the rounding of 60 mm in f32 is 4 nm
    for (number, &moved) in moved_m.iter().enumerate() {
        let (column, row) = ((number / 101) as i64, (number % 101) as i64);
        let hull = column.min(90 - column).max((row - middle).abs()) as f32;
        let share = 1.0 / ((500.0 * arc_m * hull).powi(2) + 1.0);
        // hulls whose share is below one in twenty are not there
        let expected = if share < 0.05 { 0.0 } else { push_m * share };
        assert!((moved - expected).abs() < 1e-8, "column {column}, row {row}: {moved} m instead of {expected} m");
    }
}

#[test]
fn literal_reading_runs_away_where_the_studios_does_not() {
    let deepest = |press: Presses, (columns, rows)| {
        let pot = PotSpec { shape: GridShape::new(columns, rows).unwrap(), ..PotSpec::default() };
        let dent = Dent { method: MethodKind::Improved, pot, ..dent(2, true) };
        let radial_mm = press(&dent).unwrap().radial_mm;
        f64::from(-radial_mm.into_iter().fold(f32::MAX, f32::min))
    };
    let grids = [(180, 200), (360, 400)];
    let read = grids.map(|grid| deepest(|dent| dent.press(), grid));
    let literal = grids.map(|grid| deepest(literal::press, grid));
    println!("2 mm on {grids:?}: {read:.2?} mm as the studio reads it, {literal:.2?} mm as it is written");
    assert!((read[1] / read[0] - 1.0).abs() < 0.05, "{read:?} mm");
    assert!(literal[1] > 1.05 * read[1] && literal[1] > 1.05 * literal[0], "{literal:?} mm");
}

// all on the dents of the reference

fn dent(depth_mm: u32, release: bool) -> Dent {
    Dent {
        method: MethodKind::Plastic,
        pot: PotSpec::default(),
        strength: Strength::default(),
        tool: Metres::from_mm(12.0),
        depth: Metres::from_mm(depth_mm as f32),
        finger: None,
        release,
        round: None,
    }
}

type Presses = fn(&Dent) -> Result<Dented, DentError>;

const YARDSTICKS: [(&str, Presses); 3] =
    [("free-form", free_form::press), ("long elements", long_elements::press), ("Green's functions", greens::press)];

#[test]
fn every_yardstick_draws_the_tool_and_only_a_drawing_stays() {
    for (name, press) in YARDSTICKS {
        for (depth, release) in [(1, false), (2, false), (1, true), (2, true)] {
            let dent = dent(depth, release);
            let dented = press(&dent).unwrap();
            let error = dented.error(&reference_profile(Standing::Backed, depth, release), &dent);
            let tip = dented.radial_mm_at(0.0, 100.0);
            println!(
                "{name}, {depth} mm, {}: RMS/depth {error:.4}, tip {tip:.3} mm, force {:.2} N, in {:.1}, out {:.1} mm³, \
                 {:.0} ns a step",
                if release { "released" } else { "loaded" },
                dented.force_n,
                dented.volume_in_mm3,
                dented.volume_out_mm3,
                dented.step_ns,
            );
            let expected = if release && name != "free-form" { 0.0 } else { -f64::from(depth) };
            // the point under the tool lies between two rows; a spline may miss it by a few hundredths
            assert!((tip - expected).abs() < 0.06 * f64::from(depth), "{name}: {tip}");
        }
    }
}

#[test]
fn hollow_wall_bends_under_green_s_functions_alone() {
    for (name, press) in YARDSTICKS {
        let behind = |support| Dent { pot: PotSpec { support, ..PotSpec::default() }, ..dent(1, false) };
        let [backed, hollow] = [Support::Backed, Support::Hollow].map(|support| press(&behind(support)).unwrap());
        let side = hollow.radial_mm_at(0.5 * PI, 100.0);
        println!("{name}, hollow, 1 mm: {:.2} N, {side:.3} mm at 90°, {:.0} ns a step", hollow.force_n, hollow.step_ns);
        assert!(backed.radial_mm_at(0.5 * PI, 100.0).abs() < 0.02);
        if name == "Green's functions" {
            assert!(hollow.force_n < 0.5 * backed.force_n, "{} and {} N", hollow.force_n, backed.force_n);
            assert!(side > 0.1, "an oval pot is wider at 90°, {side}");
        } else {
            assert!(side.abs() < 0.02, "{name}: {side} mm at 90°");
        }
    }
}

#[test]
fn bad_figures_are_refused_by_name() {
    for (_, press) in YARDSTICKS {
        let bad = Dent { depth: Metres::from_mm(-1.0), ..dent(1, false) };
        assert!(press(&bad).unwrap_err().to_string().contains("depth"));
    }
}
