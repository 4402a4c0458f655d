//! `accuracy-chart dent`: one sphere pressed into one pot, as a file of the whole surface.
//!
//! Owns its flags and its file; the scenario is the library's.
//! Invariant: whatever makes no sense is refused in one sentence before anything is written.

use std::fmt::Write as _;
use std::io::{ErrorKind, Write as _};
use std::path::PathBuf;

use clap::ValueEnum;
use pottery_files::sentence::sentence;
use pottery_files::whole_file::{WriteError, write_whole};
use pottery_shared::clay::{ErrorBound, GridShape, MethodKind, PotSpec, Strength, Support};
use pottery_shared::units::Metres;
use pottery_tests::dent::{Dent, DentError, Dented, Figure, Rounded};
use pottery_tests::printed::{Printed, remark};

#[derive(Clone, Copy, Debug, ValueEnum)]
enum MethodName {
    /// Elastic up to yield, plastic beyond, with a rim
    Ours,
    /// Original CSEM, which pushes a tool that stands back no more once the clay has given way
    Original,
    /// Improved CSEM, the same
    Improved,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SupportName {
    /// The wall cannot give way as a whole
    Backed,
    /// The wall bends (by our method; the others take every wall as backed)
    Hollow,
}

#[derive(clap::Args, Debug)]
pub(crate) struct DentFlags {
    #[arg(long, value_enum)]
    method: MethodName,
    /// Outer radius of the pot, 10 to 150
    #[arg(long, default_value_t = 60.0, value_parser = number)]
    pot_radius_mm: f32,
    /// Thickness of the wall, 1 to half of the pot's radius [default: 8]
    #[arg(long, value_parser = number)]
    wall_mm: Option<f32>,
    /// Height of the pot, 20 to 600
    #[arg(long, default_value_t = 200.0, value_parser = number)]
    height_mm: f32,
    /// Radius of the tool, 0.5 to 40 and at most the pot's; the grid should have four elements to it
    #[arg(long, default_value_t = 12.0, value_parser = number)]
    tool_radius_mm: f32,
    /// Travel of the tool from first touch, at most a third of the pot's radius, in a backed pot at most the wall, and against a finger a millimetre less
    /// than the wall
    #[arg(long, default_value_t = 2.0, value_parser = number)]
    depth_mm: f32,
    /// What stands behind the wall
    #[arg(long, value_enum, default_value_t = SupportName::Backed)]
    support: SupportName,
    /// Hold a ball of this radius inside of the wall, opposite the tool: in a hollow pot, by our method; 0.5 to 40, and no wider than the pot has room for
    #[arg(long, value_parser = number)]
    finger_mm: Option<f32>,
    /// Columns x rows: 8 to 4096 columns, 4 to 4096 rows, 4,194,304 elements at most. A groove on a turning wheel needs 360x400
    #[arg(long, default_value = "360x400", value_parser = grid)]
    grid: GridShape,
    /// Young's modulus of the clay, 0.01 to 100 [default: 2]
    #[arg(long, value_parser = number)]
    youngs_mpa: Option<f32>,
    /// Its yield stress, 0.3 to 1000 and at most Young's modulus [default: 40]
    #[arg(long, value_parser = number)]
    yield_kpa: Option<f32>,
    /// Take the tool away before the surface is read
    #[arg(long)]
    release: bool,
    /// Go round the pot after the press, at this speed, up to 3000, for so many --turns. Clay of our method knows no rate then, as the reference's knows none; to a
    /// tool that goes along it at less than 40 mm/s it is one that hardly slides
    #[arg(long, requires = "turns", value_parser = number)]
    rpm: Option<f32>,
    /// Go along the axis by so much a turn, towards the foot for less than nothing, and by no more than half of the height in all [default: 0]
    #[arg(long, requires = "rpm", allow_hyphen_values = true, value_parser = number)]
    feed_mm_per_rev: Option<f32>,
    /// How often to go round: a millisecond at least, and an hour at most. After whole turns without a feed the tool is at the dent in which it began,
    /// which bears it less
    #[arg(long, requires = "rpm", value_parser = number)]
    turns: Option<f32>,
    /// While it goes round, advance our wheel as a profile wherever the error's RMS over the groove is estimated to stay below so many
    /// percent of the depth, 0.01 to 20; a hollow pot never is. The clay then takes the time that it takes on the wheel, 120 ms, and not
    /// the next to none of without this flag: what a profile changes is seen against --profile 0.01, which hardly ever chooses it
    #[arg(long, requires = "rpm", value_name = "PERCENT", num_args = 0..=1, default_missing_value = "1", value_parser = bound)]
    profile: Option<ErrorBound>,
    /// Comma-separated file for theta_rad,z_mm,u_r_mm of every element
    #[arg(long)]
    out: PathBuf,
}

fn grid(text: &str) -> Result<GridShape, String> {
    let sides = text.split_once('x').and_then(|(columns, rows)| Some((columns.parse().ok()?, rows.parse().ok()?)));
    let (columns, rows) = sides.ok_or_else(|| {
        let most = GridShape::ELEMENTS_MAX;
        format!("write it like 360x400, with 8 to 4096 columns, 4 to 4096 rows and at most {most} elements")
    })?;
    GridShape::new(columns, rows).map_err(|error| error.to_string())
}

fn number(text: &str) -> Result<f32, String> {
    text.parse().map_err(|_| "write it as a number, like 2.5".to_owned())
}

fn bound(text: &str) -> Result<ErrorBound, String> {
    let percent: f32 = text.parse().map_err(|_| "write it as a number of percent, like 1".to_owned())?;
    ErrorBound::new(0.01 * percent).map_err(|error| {
        let [least, most] = [error.min, error.max].map(|share| Rounded(100.0 * share));
        format!("choose an error bound from {least} to {most} percent of the depth")
    })
}

impl DentFlags {
    fn dent(&self) -> Dent {
        Dent {
            method: match self.method {
                MethodName::Ours => MethodKind::Plastic,
                MethodName::Original => MethodKind::Original,
                MethodName::Improved => MethodKind::Improved,
            },
            pot: PotSpec {
                shape: self.grid,
                height: Metres::from_mm(self.height_mm),
                radius: Metres::from_mm(self.pot_radius_mm),
                wall: Metres::from_mm(self.wall_mm.unwrap_or(8.0)),
                support: match self.support {
                    SupportName::Backed => Support::Backed,
                    SupportName::Hollow => Support::Hollow,
                },
                ..PotSpec::default()
            },
            strength: Strength {
                youngs_pa: self.youngs_mpa.unwrap_or(2.0) * 1e6,
                yield_pa: self.yield_kpa.unwrap_or(40.0) * 1e3,
            },
            tool: Metres::from_mm(self.tool_radius_mm),
            depth: Metres::from_mm(self.depth_mm),
            finger: self.finger_mm.map(Metres::from_mm),
            release: self.release,
            round: self.rpm.zip(self.turns).map(|(rpm, turns)| {
                let feed_mm = self.feed_mm_per_rev.unwrap_or(0.0);
                (rpm, Metres::from_mm(feed_mm), turns)
            }),
        }
    }

    /// Flags that were given and that a published method makes nothing of.
    fn idle(&self) -> Vec<&'static str> {
        let given = [
            ("--wall-mm", self.wall_mm.is_some()),
            ("--youngs-mpa", self.youngs_mpa.is_some()),
            ("--yield-kpa", self.yield_kpa.is_some()),
            ("--support hollow", self.support == SupportName::Hollow),
        ];
        given.into_iter().filter_map(|(flag, is_given)| is_given.then_some(flag)).collect()
    }
}

/// Why a dent is refused, with the flag that it is about.
fn refusal(error: DentError) -> String {
    let flag = match error {
        DentError::Figure { figure, .. } => match figure {
            Figure::PotHeight => "--height-mm",
            Figure::PotRadius => "--pot-radius-mm",
            Figure::Wall => "--wall-mm",
            Figure::ToolRadius => "--tool-radius-mm",
            Figure::FingerRadius => "--finger-mm",
            Figure::Depth => "--depth-mm",
            Figure::Youngs => "--youngs-mpa",
            Figure::Yield => "--yield-kpa",
            Figure::Speed => "--rpm",
            Figure::Turns => "--turns",
            Figure::Feed => "--feed-mm-per-rev",
        },
        DentError::Grid(_) => "--grid",
        DentError::ThinWall { .. } => "--wall-mm",
        DentError::NoInside => return "a finger inside needs --support hollow: a backed pot has no inside".to_owned(),
        DentError::FingerIsUnknown | DentError::NoSteps => return error.to_string(),
    };
    format!("{flag}: {error}")
}

/// So many elements that a force is a sum and not a staircase.
const FEW: u32 = 6;
/// Columns across a contact from which on they tell its force within some percent.
const FEW_ACROSS: f32 = 4.0;

/// How far clay may lie beyond a tool without a word, of its travel and at least, mm.
const BEYOND: f32 = 0.01;
const BEYOND_MM: f32 = 0.02;

/// What is to be known of a grid whose elements are longer than a quarter of the tool's radius.
fn coarse(dent: &Dent) -> Option<String> {
    // whatever anybody sees
    let finest = Metres(f32::MIN_POSITIVE);
    let needed = GridShape::for_tool_and_view(&dent.pot, dent.tool, finest);
    let shape = dent.pot.shape;
    let advice = match needed {
        Ok(needed) if needed.columns() <= shape.columns() && needed.rows() <= shape.rows() => return None,
        Ok(needed) => format!("give at least --grid {}x{}", needed.columns(), needed.rows()),
        Err(_) => "no grid is fine enough, so take a larger tool or a smaller pot".to_owned(),
    };
    let across_mm = std::f32::consts::TAU * dent.pot.radius.as_mm() / shape.columns() as f32;
    let up_mm = dent.pot.height.as_mm() / (shape.rows() - 1) as f32;
    Some(format!(
        "the grid is too coarse for this tool and figures may be far off: an element is {} mm across and {} mm high, \
         and should be at most {} mm, a quarter of the tool's radius; {advice}",
        Rounded(across_mm),
        Rounded(up_mm),
        Rounded(0.25 * dent.tool.as_mm())
    ))
}

/// How far clay lies beyond a tool that still presses it, mm, where that is worth a word: in a hollow wall that folds more steeply than the tool is round.
/// Looked at within half the tool's radius, since a tall pot leans, and its rim goes farther than the tool.
fn beyond_mm(dent: &Dent, dented: &Dented) -> Option<f32> {
    let is_felt = dent.method == MethodKind::Plastic && !dent.release && dent.round.is_none();
    let (near, rows) = (0.5 * dent.tool.0, dented.shape.rows() as usize);
    let near_columns = (near / (dent.pot.radius.0 * dented.shape.column_angle_rad())) as usize;
    let near_rows = (1e3 * near / dented.row_height_mm) as usize;
    let farthest_mm = dented
        .radial_mm
        .chunks(rows)
        .enumerate()
        .filter(|(column, _)| (*column).min(dented.shape.columns() as usize - column) <= near_columns)
        .flat_map(|(_, column)| &column[(rows / 2).saturating_sub(near_rows)..(rows / 2 + near_rows + 1).min(rows)])
        .fold(0.0_f32, |most, moved_mm| most.max(-moved_mm));
    let beyond_mm = farthest_mm - dent.depth.as_mm();
    (is_felt && beyond_mm > BEYOND_MM.max(BEYOND * dent.depth.as_mm())).then_some(beyond_mm)
}

/// Presses as the flags say, writes the surface and prints what was measured.
pub(crate) fn run(flags: &DentFlags) -> Result<(), Box<dyn std::error::Error>> {
    let dent = flags.dent();
    let dented = match flags.profile {
        Some(_) if dent.method != MethodKind::Plastic => {
            return Err("only our method has a profile: choose --method ours, or leave out --profile".into());
        }
        Some(bound) => dent.press_as_profile(bound),
        None => dent.press(),
    };
    let dented = dented.map_err(refusal)?;
    if let Some(warning) = coarse(&dent) {
        remark(format_args!("accuracy-chart: {warning}"));
    } else if dent.method == MethodKind::Plastic && (1..FEW).contains(&dented.touched) {
        remark(format_args!(
            "accuracy-chart: the tool touches {} elements, so that its force comes in steps; press deeper, or give a finer --grid",
            dented.touched
        ));
    } else if let Some(columns) = dent.columns_across().filter(|columns| *columns < FEW_ACROSS) {
        remark(format_args!(
            "accuracy-chart: the tool is met by {columns:.1} columns across, so that force and dent come in steps of up to a tenth; press deeper, or give \
             more columns with --grid"
        ));
    }
    if let Some(beyond_mm) = beyond_mm(&dent, &dented) {
        remark(format_args!(
            "accuracy-chart: the wall lies up to {beyond_mm:.2} mm beyond the tool, since a wall that is pressed in so deep is folded only roughly; press less deep"
        ));
    }
    let idle = flags.idle();
    if dent.method != MethodKind::Plastic && !idle.is_empty() {
        remark(format_args!("accuracy-chart: {} makes no difference to a published method", idle.join(", ")));
    }
    write_surface(flags, &dented)?;
    print(flags, &dent, &dented)
}

fn write_surface(flags: &DentFlags, dented: &Dented) -> Result<(), Box<dyn std::error::Error>> {
    let rows = dented.shape.rows() as usize;
    let mut text = String::from("theta_rad,z_mm,u_r_mm\n");
    for (at, radial_mm) in dented.radial_mm.iter().enumerate() {
        let angle_rad = (at / rows) as f32 * dented.shape.column_angle_rad();
        let z_mm = (at % rows) as f32 * dented.row_height_mm;
        writeln!(text, "{angle_rad:.6},{z_mm:.4},{radial_mm:.6}")?;
    }
    write_whole(&flags.out, |file| file.write_all(text.as_bytes())).map_err(|error| {
        let source = match error {
            WriteError::Folder { .. } => ErrorKind::IsADirectory.into(),
            WriteError::Refused { source, .. } => source,
        };
        format!("{} cannot be written: {}", flags.out.display(), sentence(&source))
    })?;
    Ok(())
}

/// A figure as it is printed: nothing has no sign.
fn thousandths(figure: f64) -> f64 {
    (figure * 1e3).round() / 1e3 + 0.0
}

fn print(flags: &DentFlags, dent: &Dent, dented: &Dented) -> Result<(), Box<dyn std::error::Error>> {
    let when = if dent.release { ", before the tool was taken away" } else { "" };
    writeln!(Printed, "radial force    {:.3} N{when}", thousandths(dented.force_n.into()))?;
    if let Some(finger_n) = dented.finger_n {
        writeln!(Printed, "on the finger   {:.3} N", thousandths(finger_n.into()))?;
    }
    writeln!(Printed, "volume in       {:.2} mm³", dented.volume_in_mm3)?;
    writeln!(Printed, "volume out      {:.2} mm³", dented.volume_out_mm3)?;
    if let Some(grows_mm) = dented.grows_mm {
        let way = if grows_mm < 0.0 { "lower" } else { "higher" };
        // on a core, which is no clay to the law, what is kept is the volume of all that the surface holds
        let over = if dent.pot.support == Support::Backed { ", over all of its section" } else { "" };
        writeln!(
            Printed,
            "pot becomes     {:.3} mm {way} by what stays pressed in{over}",
            thousandths(grows_mm.abs())
        )?;
    }
    let knows_inside = dent.method == MethodKind::Plastic && dent.pot.support == Support::Hollow;
    if let Some(behind_mm) = dented.behind_mm.filter(|_| knows_inside) {
        let behind_mm = thousandths(behind_mm);
        writeln!(Printed, "inner wall      {behind_mm:.3} mm behind the tool, when it has left")?;
    }
    if dented.step_ns.is_nan() {
        writeln!(Printed, "a step          none met any clay")?;
    } else {
        writeln!(Printed, "a step          {:.0} ns", dented.step_ns)?;
    }
    if flags.profile.is_some() {
        writeln!(Printed, "as a profile    {} of {} steps", dented.profile_steps.0, dented.profile_steps.1)?;
    }
    Ok(())
}
