//! Prints the digest of a fixed run for every method: the same on every machine and with whatever vectors it has.
//!
//! Owns the run; what its digests are is pinned by `tests/tests/clay/golden.rs`, which builds this for several processors.
//! Invariant: no figure of the run comes from the host's own functions, whose last bits differ.

use pottery_shared::clay::{
    Conditions, Material, MethodKind, Phase, Pot, PotError, PotSpec, SubStep, Support, Vectors, Wheel,
};
use pottery_shared::tool::{Orientation, Position, Shape, Side, Sphere, Tool, ToolSample};
use pottery_shared::units::{Metres, Rpm, Seconds, Tick};

/// Every method.
pub(crate) const METHODS: [MethodKind; 3] = [MethodKind::Original, MethodKind::Improved, MethodKind::Plastic];

/// 500 sub-steps of two tools outside and one inside, on a wheel that changes its speed and in clay that changes its
/// viscosity: the digest, and the volume of clay that is elsewhere, mm³.
///
/// # Errors
/// None: the default pot can be made.
pub(crate) fn run(method: MethodKind, vectors: Vectors) -> Result<(u64, f64), PotError> {
    run_on(PotSpec::default(), method, vectors)
}

/// The same on a hollow pot, whose wall bends.
///
/// # Errors
/// None: such a pot can be made.
pub(crate) fn run_hollow(method: MethodKind, vectors: Vectors) -> Result<(u64, f64), PotError> {
    run_on(PotSpec { support: Support::Hollow, ..PotSpec::default() }, method, vectors)
}

fn run_on(spec: PotSpec, method: MethodKind, vectors: Vectors) -> Result<(u64, f64), PotError> {
    let mut pot = Pot::new(spec)?;
    let mut conditions = Conditions {
        wheel: Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(90.0))),
        method,
        ..Conditions::default()
    };
    conditions.wheel.schedule(Tick(250), Wheel::rate_of(Rpm(-40.0)));
    conditions.material.set(Tick(300), Material { viscosity: Seconds(0.03), ..Material::default() });
    let mut substep = SubStep::for_grid(pot.spec().shape).using(vectors);
    let radii_mm = [12.0, 5.0, 7.0];
    let tools = radii_mm.map(|radius_mm| Sphere::new(Metres::from_mm(radius_mm)).unwrap_or_default());
    let mut before: [Option<ToolSample>; 3] = [None; 3];
    for number in 0..500_i32 {
        let places = [
            [6900 - number, 0, 8000 + 10 * number],
            [-3000, 6300 - number, 11_000 - 7 * number],
            [0, -5300 - number / 8, 9000 + 3 * number],
        ];
        let sides = [Side::Outside, Side::Outside, Side::Inside];
        let mut presses = Vec::new();
        for ((tool, centre), (side, before)) in tools.into_iter().zip(places).zip(sides.into_iter().zip(&mut before)) {
            let (tick, tool, orientation) = (Tick(number as u64), tool.into(), Orientation::default());
            let sample = ToolSample { tick, tool, orientation, centre: Position(centre), side };
            presses.push(conditions.press(&sample, before.as_ref()));
            *before = Some(sample);
        }
        substep.advance(&mut pot, &presses, method, |_, _| {});
    }
    Ok((pot.digest(), moved_mm3(&pot)?))
}

/// 500 sub-steps of a rib that goes round a turning pot while it sways, leans and rolls: as [`run`] answers.
///
/// # Errors
/// None: the default pot can be made.
pub(crate) fn run_rib(method: MethodKind, vectors: Vectors) -> Result<(u64, f64), PotError> {
    let mut pot = Pot::new(PotSpec::default())?;
    let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(90.0)));
    let conditions = Conditions { wheel, method, ..Conditions::default() };
    let mut substep = SubStep::for_grid(pot.spec().shape).using(vectors);
    let mut before: Option<ToolSample> = None;
    for number in 0..500_i16 {
        let sample = ToolSample {
            tick: Tick(number as u64),
            tool: Tool::Convex(Shape::RIB),
            orientation: Orientation([10 * number, 500 - 2 * number, 3 * number]),
            // its edge is 21.2 mm from its centre
            centre: Position([7950, 4 * i32::from(number), 9000 + 2 * i32::from(number)]),
            side: Side::Outside,
        };
        substep.advance(&mut pot, &[conditions.press(&sample, before.as_ref())], method, |_, _| {});
        before = Some(sample);
    }
    Ok((pot.digest(), moved_mm3(&pot)?))
}

/// Volume by which the walls are farther in or out than those of an untouched pot.
fn moved_mm3(pot: &Pot) -> Result<f64, PotError> {
    let untouched = Pot::new(*pot.spec())?;
    let moved_m3 = pot.surfaces().iter().zip(untouched.surfaces()).map(|(surface, untouched)| {
        let element_rad_m = f64::from(surface.shape().column_angle_rad()) * f64::from(surface.row_height_m());
        let radii_m = surface.radii_m().iter().zip(untouched.radii_m());
        let square_m2 = |radius_m: f32| f64::from(radius_m) * f64::from(radius_m);
        let moved_m2 = radii_m.map(|(&now, &before)| (square_m2(now) - square_m2(before)).abs());
        0.5 * moved_m2.sum::<f64>() * element_rad_m
    });
    Ok(moved_m3.sum::<f64>() * 1e9)
}

/// Prints three lines a method.
///
/// # Errors
/// None: the default pot can be made.
pub(crate) fn main() -> Result<(), PotError> {
    for method in METHODS {
        let (digest, moved_mm3) = run(method, Vectors::default())?;
        println!("{method:?} {digest:#018x}, {moved_mm3:.0} mm³ moved");
        let (digest, moved_mm3) = run_rib(method, Vectors::default())?;
        println!("{method:?} with a rib {digest:#018x}, {moved_mm3:.0} mm³ moved");
        let (digest, moved_mm3) = run_hollow(method, Vectors::default())?;
        println!("{method:?} on a hollow pot {digest:#018x}, {moved_mm3:.0} mm³ moved");
    }
    Ok(())
}
