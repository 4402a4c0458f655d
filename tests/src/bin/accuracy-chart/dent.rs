//! `accuracy-chart dent`: one sphere pressed into one pot, as a file of the whole surface.
//!
//! Owns its flags and its file; the scenario is the library's.
//! Invariant: whatever makes no sense is refused in one sentence before anything is written.

use std::fmt::Write;
use std::path::PathBuf;

use clap::ValueEnum;
use pottery_shared::clay::{ErrorBound, GridShape, MethodKind, PotSpec, Strength, Support};
use pottery_shared::units::Metres;
use pottery_tests::dent::Dent;

#[derive(Clone, Copy, Debug, ValueEnum)]
enum MethodName {
    /// Elastic up to yield, plastic beyond, with a rim
    Ours,
    /// Original CSEM
    Original,
    /// Improved CSEM
    Improved,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SupportName {
    /// The wall cannot give way as a whole
    Backed,
    /// The wall bends (ours; the others take every wall as backed)
    Hollow,
}

#[derive(clap::Args, Debug)]
pub(crate) struct DentFlags {
    #[arg(long, value_enum)]
    method: MethodName,
    #[arg(long, default_value_t = 60.0)]
    pot_radius_mm: f32,
    #[arg(long, default_value_t = 8.0)]
    wall_mm: f32,
    #[arg(long, default_value_t = 200.0)]
    height_mm: f32,
    #[arg(long, default_value_t = 12.0)]
    tool_radius_mm: f32,
    /// Travel of the tool from first touch
    #[arg(long, default_value_t = 2.0)]
    depth_mm: f32,
    /// What stands behind the wall
    #[arg(long, value_enum, default_value_t = SupportName::Backed)]
    support: SupportName,
    /// Hold a ball of this radius inside of the wall, opposite the tool
    #[arg(long)]
    finger_mm: Option<f32>,
    /// Columns x rows
    #[arg(long, default_value = "360x400", value_parser = grid)]
    grid: GridShape,
    #[arg(long, default_value_t = 2.0)]
    youngs_mpa: f32,
    #[arg(long, default_value_t = 40.0)]
    yield_kpa: f32,
    /// Take the tool away before the surface is read
    #[arg(long)]
    release: bool,
    /// Go round the pot after the press, at this speed
    #[arg(long, requires = "turns")]
    rpm: Option<f32>,
    /// Go along the axis by so much a turn
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true)]
    feed_mm_per_rev: f32,
    /// How often to go round
    #[arg(long, requires = "rpm")]
    turns: Option<f32>,
    /// While it goes round, advance our wheel as a profile wherever the error is estimated to stay below so many percent of the depth;
    /// the clay then takes the time it takes on the wheel
    #[arg(long, requires = "rpm", value_name = "PERCENT", num_args = 0..=1, default_missing_value = "1", value_parser = bound)]
    profile: Option<ErrorBound>,
    /// Comma-separated file for theta_rad,z_mm,u_r_mm of every element
    #[arg(long)]
    out: PathBuf,
}

fn grid(text: &str) -> Result<GridShape, String> {
    let sides = text.split_once('x').and_then(|(columns, rows)| Some((columns.parse().ok()?, rows.parse().ok()?)));
    let (columns, rows) = sides.ok_or("write it like 360x400")?;
    GridShape::new(columns, rows).map_err(|error| error.to_string())
}

fn bound(text: &str) -> Result<ErrorBound, String> {
    let percent: f32 = text.parse().map_err(|_| "write it as a number of percent, like 1".to_owned())?;
    ErrorBound::new(0.01 * percent).map_err(|error| error.to_string())
}

/// Presses as the flags say, writes the surface and prints what was measured.
pub(crate) fn run(flags: &DentFlags) -> Result<(), Box<dyn std::error::Error>> {
    let dent = Dent {
        method: match flags.method {
            MethodName::Ours => MethodKind::Plastic,
            MethodName::Original => MethodKind::Original,
            MethodName::Improved => MethodKind::Improved,
        },
        pot: PotSpec {
            shape: flags.grid,
            height: Metres::from_mm(flags.height_mm),
            radius: Metres::from_mm(flags.pot_radius_mm),
            wall: Metres::from_mm(flags.wall_mm),
            support: match flags.support {
                SupportName::Backed => Support::Backed,
                SupportName::Hollow => Support::Hollow,
            },
            ..PotSpec::default()
        },
        strength: Strength { youngs_pa: flags.youngs_mpa * 1e6, yield_pa: flags.yield_kpa * 1e3 },
        tool: Metres::from_mm(flags.tool_radius_mm),
        depth: Metres::from_mm(flags.depth_mm),
        finger: flags.finger_mm.map(Metres::from_mm),
        release: flags.release,
        round: flags.rpm.zip(flags.turns).map(|(rpm, turns)| (rpm, Metres::from_mm(flags.feed_mm_per_rev), turns)),
    };
    let dented = match flags.profile {
        Some(_) if dent.method != MethodKind::Plastic => {
            return Err("only our method has a profile: choose --method ours, or leave out --profile".into());
        }
        Some(bound) => dent.press_as_profile(bound)?,
        None => dent.press()?,
    };
    let rows = dented.shape.rows() as usize;
    let mut text = String::from("theta_rad,z_mm,u_r_mm\n");
    for (at, radial_mm) in dented.radial_mm.iter().enumerate() {
        let angle_rad = (at / rows) as f32 * dented.shape.column_angle_rad();
        let z_mm = (at % rows) as f32 * dented.row_height_mm;
        writeln!(text, "{angle_rad:.6},{z_mm:.4},{radial_mm:.6}")?;
    }
    std::fs::write(&flags.out, text).map_err(|error| format!("{} cannot be written: {error}", flags.out.display()))?;
    println!("radial force    {:.3} N", dented.force_n);
    if let Some(finger_n) = dented.finger_n {
        println!("on the finger   {finger_n:.3} N");
    }
    println!("volume in       {:.2} mm³", dented.volume_in_mm3);
    println!("volume out      {:.2} mm³", dented.volume_out_mm3);
    if let (Some(behind_mm), Support::Hollow) = (dented.behind_mm, dent.pot.support) {
        println!("inner wall      {behind_mm:.3} mm behind the tool, when it has left");
    }
    println!("a step          {:.0} ns", dented.step_ns);
    if flags.profile.is_some() {
        println!("as a profile    {} of {} steps", dented.profile_steps.0, dented.profile_steps.1);
    }
    Ok(())
}
