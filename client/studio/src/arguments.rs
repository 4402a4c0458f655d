//! The command line: what can be asked for, and the sentences when it cannot be done.
//!
//! Owns names, defaults and help; opens nothing but the stroke, tool and pot files it is given.
//! Invariant: a `Mode` that exists can be run as it is.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, bail, ensure};
use clap::{Args, Parser, Subcommand, ValueEnum};
use pottery_client::device::{ChoiceError, DeviceChoice};
use pottery_client::flags::number_from;
use pottery_client::pot_file::PotFile;
use pottery_client::stroke::Stroke;
use pottery_client::{Claim, Core, Found, Link, LoopRate, Target, sentence};
use pottery_server::{Finest, ServerConfig, address};
use pottery_shared::clay::{Form, Material, MethodKind, PotSpec, Preset, Support, Wetness};
use pottery_shared::protocol::{JoinCode, TeacherToken};
use pottery_shared::snapshot::Detail;
use pottery_shared::tool::{ConvexTool, Shape, Tool};

use crate::conversion::Conversion;
use crate::haptics::Bench;
use crate::headless_choice::{HandKind, HeadlessFlags};
use crate::joining::{self, Where};
use crate::known::Known;
use crate::network::Network;
use crate::record::check_writable;
use crate::replaying::ReplaySession;
use crate::tool_choice::{ToolChoice, ToolFlags};
use crate::watch_choice::{WatchFlags, WatchName};

/// A pottery studio for several people: shape one pot on one wheel together, and feel the clay.
///
/// Without a command it hosts a studio and opens a window on it; without a display, or with --headless, scripted
/// potters work in its place and the pot is written to files.
#[derive(Debug, Parser)]
#[command(name = "pottery-studio", version, after_help = EXAMPLES)]
#[command(allow_negative_numbers = true, args_conflicts_with_subcommands = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    host: HostFlags,
}

const EXAMPLES: &str = "Examples:
  pottery-studio                                         host and work in a window
  pottery-studio join 192.168.1.20 --code K7QM-3XPD      work at somebody else's wheel
  pottery-studio join 192.168.1.20 --code K7QM-3XPD --watch gallery
                                                         look on at all wheels; a click shows one closely
  pottery-studio join 192.168.1.20 --code K7QM-3XPD --watch spectator --watch-quantum 30 --watch-rate 10
                                                         look on over a line that carries little
  pottery-studio join                                    say which studios announce themselves on this network
  pottery-studio --open bowl.pot                         go on with a pot that was saved
  pottery-studio export bowl.pot bowl.3mf bowl.svg       give it to other programs
  pottery-studio --headless --potters 3 --seconds 10     let scripted potters work; pot.pot, pot.png, session.json
  pottery-studio --headless --stroke mine.csv            let one of them replay a recorded stroke
  pottery-studio --record mine.csv                       record what you do
  pottery-studio --record-session monday.session         keep all that happens at the wheel; replay goes through it again
  pottery-studio replay monday.session --at 90           see it from the 90th second on
  pottery-studio --network intercontinental              feel how it is when the studio is on another continent
  pottery-studio devices                                 say which devices are there, and why others are not
  pottery-studio haptics --bench                         measure how well this machine keeps the hand's 1 kHz
  pottery-studio --device falcon:firmware=nvent.bin      work with a haptic device
  pottery-studio --tool rib                              begin with a rib in hand; T takes the next tool
  pottery-studio join 192.168.1.20 --code K7QM-3XPD --tool-file mine.stl
                                                         bring a tool of your own, for everybody at the wheel

Tools: a sphere (--tool-radius, +/-), or a rib, blade, knuckle or loop, whose edge faces the pot wherever they are, inside their back. A
tool file is STL or OBJ in millimetres: one closed convex solid of at most 20,480 triangles; x points away from the axis.

Keys in the window: Enter takes the force away at once and gives it back, left button or W/S press and lift the tool,
wheel sets how deep it presses, Shift + arrows move it without a mouse, right button or left/right turns the view, T next tool, +/- sphere size, Q/E turn the tool, A/D (Shift + wheel) roll it, F/G (Alt + wheel) lean it,
X upright again, up/down wheel speed, V/B drier and wetter clay, R resets the view, M sound,
Ctrl+S saves the pot, Ctrl+E exports it, Esc closes what is open, or leaves.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Host a studio (the same as no command)
    #[command(allow_negative_numbers = true)]
    Host(HostFlags),
    /// Join a studio that somebody hosts
    #[command(allow_negative_numbers = true)]
    Join(JoinFlags),
    /// Turn a pot file into what other programs read
    Export(ExportFlags),
    /// Go through a session that was kept with --record-session
    #[command(allow_negative_numbers = true)]
    Replay(ReplayFlags),
    /// Say which devices are there, and of each other one why not
    Devices,
    /// Say what the system grants the hand's thread, and measure how well it keeps its thousand ticks a second (--bench)
    Haptics(HapticsFlags),
}

/// The hand's thread asks for real-time priority and says in a sentence when the system refuses it.
///
/// With --bench a simulated hand of 0.195 kg works on a pot of 144,000 elements, in the studio's own loop, and it is measured when
/// each tick begins and how long it takes. A tick that begins 200 µs after its deadline is late; one whose deadline went by is
/// left out and counted.
#[derive(Args, Clone, Debug)]
#[command(after_help = HAPTICS, allow_negative_numbers = true)]
struct HapticsFlags {
    /// Measure, print a histogram and write haptics.csv and haptics.svg
    #[arg(long)]
    bench: bool,
    /// How long, s
    #[arg(long, default_value_t = 60.0, value_parser = number_from(0.5, 86_400.0), requires = "bench")]
    seconds: f64,
    /// Folder for haptics.csv and haptics.svg
    #[arg(long, value_name = "DIR", default_value = "haptics-out", requires = "bench")]
    out: PathBuf,
    /// Run a server beside it, at whose wheel the hand works over loopback
    #[arg(long, requires = "bench")]
    server: bool,
    /// Draw pictures beside it, as large and as often as the window does
    #[arg(long, requires = "bench")]
    renderer: bool,
    /// Leave the thread its ordinary priority, to compare
    #[arg(long)]
    ordinary: bool,
    /// Keep the thread on one core, counted from 0
    #[arg(long, value_name = "N")]
    pin_core: Option<Core>,
    /// How often a second the hand's loop reads the device and gives force, Hz: 1000, or thousands more up to 10000; the clay keeps to a
    /// thousand
    #[arg(long, value_name = "HZ", default_value = "1000")]
    rate: LoopRate,
}

const HAPTICS: &str = "Examples:
  pottery-studio haptics                                 which priority a hand's thread gets here
  pottery-studio haptics --bench                         a minute of the hand alone
  pottery-studio haptics --bench --server --renderer     with all that a session in a window has beside it
  pottery-studio haptics --bench --ordinary              the same without real-time priority
  pottery-studio haptics --bench --pin-core 1            on the second core
  pottery-studio haptics --bench --rate 4000             the loop at 4 kHz

Read the share of late ticks first: under 0.1 % is what a hand does not notice. If it is more, compare it with that of a
loop which has nothing to do, kept before and after: what both have is the machine's, or its host's where it is a virtual
one. Then look at the work: ticks that take close to a millisecond mean a slow machine; short ones mean that other
programs keep the core busy, and priority, a core of its own or fewer programs help.";

#[derive(Args, Clone, Debug)]
struct HoldFlags {
    /// What is in the hand: mouse, gamepad, inverse3, openhaptics, falcon, simulated or replay, with parameters after a
    /// colon, as falcon:number=1,scale=1.5 or simulated:specs=falcon,delay=5 [default: mouse; headless: the first potter's stroke]
    #[arg(long, value_name = "NAME[:KEY=VALUE,...]", value_parser = device)]
    device: Option<DeviceChoice>,
    /// Keep the hand's 1 kHz thread on one core, counted from 0; best one that the system leaves alone (isolcpus on Linux)
    #[arg(long, value_name = "N")]
    pin_core: Option<Core>,
    /// How often a second the hand's loop reads the device and gives force, Hz: 1000, or thousands more up to 10000; the clay keeps to a
    /// thousand
    #[arg(long, value_name = "HZ", default_value = "1000")]
    rate: LoopRate,
    /// Begin without the sound of the clay; M in the window turns it on
    #[arg(long)]
    mute: bool,
    /// A worse network than there is between this hand and the studio, to feel it: lan, school-wifi, home, intercontinental or
    /// awful
    #[arg(long, value_name = "NAME")]
    network: Option<Network>,
}

#[derive(Args, Clone, Debug)]
struct HostFlags {
    /// UDP address to listen on; port 0 takes any free one [default: all networks, port 4747; headless: loopback, any]
    #[arg(long, value_name = "ADDRESS", value_parser = address)]
    listen: Option<SocketAddr>,
    /// Join code of 8 characters; a fresh one when left out
    #[arg(long)]
    code: Option<JoinCode>,
    /// What the class is called where it announces itself on the local network; a word when left out
    #[arg(long, value_name = "NAME")]
    class: Option<String>,
    /// Do not announce the studio on the local network
    #[arg(long)]
    no_announce: bool,
    /// Pot file to go on with; it says what pot and clay there are, and how the clay deforms
    #[arg(long, value_name = "FILE", conflicts_with_all = ["form", "method", "support", "clay", "wetness"])]
    open: Option<PathBuf>,
    /// How the clay deforms
    #[arg(long, value_enum, default_value_t = MethodName::Plastic)]
    method: MethodName,
    /// What stands on the wheel at first
    #[arg(long, value_enum, default_value_t = FormName::Cylinder)]
    form: FormName,
    /// What stands behind the pot's wall
    #[arg(long, value_enum, default_value_t = SupportName::Backed)]
    support: SupportName,
    /// Clay as potters name it; everybody at the wheel may change it later
    #[arg(long, value_enum, default_value_t = ClayName::Throwing)]
    clay: ClayName,
    /// How wet the clay is instead, from 0.0 (crumbles) to 1.0 (runs); not together with --clay
    #[arg(long, value_name = "INDEX", value_parser = wetness, conflicts_with = "clay")]
    wetness: Option<Wetness>,
    /// Radius of the smallest tool that anybody will use, mm: the pot's grid is as coarse as that tool allows. A finger has 8 to 12,
    /// and takes a tenth of the elements [default: 360 x 400 of them, which do for 4.2 mm]
    #[arg(long, value_name = "MM", conflicts_with = "open", value_parser = number_from(Finest::TOOL_MM.0, Finest::TOOL_MM.1))]
    smallest_tool_mm: Option<f32>,
    /// Shortest length on the clay that anybody sees, mm: where that is longer than the tool's elements, they are as long
    #[arg(long, value_name = "MM", requires = "smallest_tool_mm", value_parser = number_from(Finest::SEEN_MM.0, Finest::SEEN_MM.1))]
    finest_view_mm: Option<f32>,
    #[command(flatten)]
    scripted: HeadlessFlags,
    /// Somebody who looks on, and how closely; repeat it for more (headless)
    #[arg(long, value_enum, value_name = "DETAIL")]
    watch: Vec<WatchName>,
    /// Record the own stroke (headless: the first potter's) to a file, in which there is nothing yet
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Keep everything that happens at the wheel in a session file, which must not exist yet; see replay
    #[arg(long, value_name = "FILE")]
    record_session: Option<PathBuf>,
    #[command(flatten)]
    hold: HoldFlags,
    #[command(flatten)]
    tool: ToolFlags,
}

#[derive(Args, Clone, Debug)]
struct JoinFlags {
    /// Host and port of the studio, the port is 4747 when left out; or the whole link, pottery://…; when it is left out, say
    /// which studios announce themselves on the local network, and join if there is one and its code is given
    address: Option<String>,
    /// The join code that the host shows; a link has it already
    #[arg(long)]
    code: Option<JoinCode>,
    /// Which wheel to work at, from 1 on [default: 1, or the link's]
    #[arg(long, value_parser = number_from(1, ServerConfig::WHEELS_MAX))]
    wheel: Option<u16>,
    #[command(flatten)]
    watch: WatchFlags,
    /// Teach there: the token that the server showed when it first started; a teacher needs no code that is still good
    #[arg(long, value_name = "TOKEN", env = "POTTERY_TEACHER_TOKEN", hide_env_values = true)]
    teacher_token: Option<TeacherToken>,
    /// Trust the key that the studio shows, although it showed another one before (short codes)
    #[arg(long)]
    trust_new_key: bool,
    /// Record the own stroke to a file, in which there is nothing yet
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    #[command(flatten)]
    hold: HoldFlags,
    #[command(flatten)]
    tool: ToolFlags,
}

#[derive(Args, Clone, Debug)]
struct ExportFlags {
    /// The pot file
    pot: PathBuf,
    /// What to write; the ending says the form: .stl .3mf .obj .ply (solids, mm), .glb (solid, metres as glTF wants it),
    /// .svg (section, mm), .png (picture), .gif (one turn)
    #[arg(required = true)]
    out: Vec<PathBuf>,
}

#[derive(Args, Clone, Debug)]
struct ReplayFlags {
    /// The session file
    session: PathBuf,
    /// Where to begin, s after the first tick that was kept; headless: where to stop, in place of the end
    #[arg(long, value_name = "SECONDS", value_parser = number_from(0.0, 1e9))]
    at: Option<f64>,
    /// Which wheel
    #[arg(long, default_value_t = 1, value_parser = number_from(1, ServerConfig::WHEELS_MAX))]
    wheel: u16,
    /// Go through it without a window, compare every digest and write the pot
    #[arg(long)]
    headless: bool,
    /// Folder for pot.pot (headless)
    #[arg(long, value_name = "DIR", default_value = "studio-out", requires = "headless")]
    out: PathBuf,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MethodName {
    /// Circular Sector Element Method, every element by itself
    Original,
    /// The same with local propagation
    Improved,
    /// The studio's own: elastic up to yield, plastic beyond, displaced clay comes back as a rim
    Plastic,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FormName {
    /// Straight walls, 120 mm wide and 200 mm high
    Cylinder,
    /// Wide and low, 200 by 100 mm
    Bowl,
    /// A belly, shoulders and a narrow neck, 140 by 240 mm
    Bottle,
    /// A sphere without its poles, 160 by 130 mm
    Ball,
}

impl FormName {
    const fn form(self) -> Form {
        match self {
            Self::Cylinder => Form::Cylinder,
            Self::Bowl => Form::Bowl,
            Self::Bottle => Form::Bottle,
            Self::Ball => Form::Ball,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SupportName {
    /// A rigid core: the wall cannot give way as a whole
    Backed,
    /// Nothing: the wall bends under a tool and springs back (--method plastic)
    Hollow,
}

impl SupportName {
    const fn support(self) -> Support {
        match self {
            Self::Backed => Support::Backed,
            Self::Hollow => Support::Hollow,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ClayName {
    /// Wetness 0.10: keeps its shape, needs force
    Stiff,
    /// Wetness 0.27: for throwing
    Throwing,
    /// Wetness 0.45: gives way easily
    Soft,
    /// Wetness 1.0: hardly carries itself
    Slip,
}

impl ClayName {
    const fn preset(self) -> Preset {
        match self {
            Self::Stiff => Preset::Stiff,
            Self::Throwing => Preset::Throwing,
            Self::Soft => Preset::Soft,
            Self::Slip => Preset::Slip,
        }
    }
}

/// What is to be done.
#[derive(Debug)]
pub(crate) enum Mode {
    Export(Conversion),
    Headless(HeadlessSession),
    Replay(ReplaySession),
    Window(WindowSession),
    Watch(WatchSession),
    /// Say which studios there are.
    Found(Vec<Found>),
    /// Look for devices and say what was found.
    Devices,
    /// Say what a hand's thread gets.
    Haptics(Claim),
    /// Measure a hand's thread.
    Bench(Bench),
}

/// A session of scripted potters.
#[derive(Clone, Debug)]
pub(crate) struct HeadlessSession {
    pub(crate) server: ServerConfig,
    /// One for each potter.
    pub(crate) strokes: Vec<Arc<Stroke>>,
    pub(crate) seconds: f64,
    pub(crate) out: PathBuf,
    pub(crate) hand: HandKind,
    /// What the first potter holds instead of a scripted hand.
    pub(crate) device: Option<DeviceChoice>,
    /// Where the first potter's hand has its thread.
    pub(crate) core: Option<Core>,
    pub(crate) rate: LoopRate,
    /// What lies between everybody and the studio.
    pub(crate) network: Option<Network>,
    pub(crate) record: Option<PathBuf>,
    /// A tool that the first of them brings to the wheel.
    pub(crate) brought: Option<Arc<ConvexTool>>,
    /// Who looks on, and how closely.
    pub(crate) watch: Vec<Detail>,
}

/// Somebody who looks on in a window.
#[derive(Clone, Debug)]
pub(crate) struct WatchSession {
    /// Which studio, and which wheel for a close look.
    pub(crate) target: Target,
    pub(crate) detail: Detail,
    /// How they work there, should they want to.
    pub(crate) working: WindowSession,
}

/// A session in a window.
#[derive(Clone, Debug)]
pub(crate) struct WindowSession {
    pub(crate) place: Place,
    pub(crate) device: DeviceChoice,
    /// Where the hand has its thread.
    pub(crate) core: Option<Core>,
    pub(crate) rate: LoopRate,
    pub(crate) is_muted: bool,
    /// What lies between the hand and the studio.
    pub(crate) network: Option<Network>,
    /// What a simulated hand follows that was given no stroke.
    pub(crate) stroke: Arc<Stroke>,
    /// The pot file that is gone on with.
    pub(crate) opened: Option<PathBuf>,
    pub(crate) tool: ToolChoice,
    pub(crate) record: Option<PathBuf>,
    /// Flags that were given for scripted potters, who work only where no window can be opened.
    pub(crate) unfollowed: Vec<&'static str>,
}

/// Whose studio the window is on.
#[derive(Clone, Debug)]
pub(crate) enum Place {
    Hosted(Box<ServerConfig>),
    Joined(Target),
}

fn device(text: &str) -> Result<DeviceChoice, String> {
    text.parse().map_err(|error: ChoiceError| sentence(&error))
}

fn wetness(text: &str) -> Result<Wetness, String> {
    let index = text.parse().map_err(|_| "choose a number from 0.0 to 1.0")?;
    Wetness::new(index).map_err(|error| error.to_string())
}

impl JoinFlags {
    /// Where to, from the link or from what was typed one by one, at an address.
    fn target(&self, address: &str) -> anyhow::Result<Target> {
        let target = if Link::is_meant(address) {
            ensure!(self.code.is_none(), "the link has its code already: leave --code out");
            address.parse::<Link>()?.0
        } else {
            ensure!(
                !address.contains('/'),
                "{address} is no address of a studio: give a host and a port, such as 192.168.1.20:4747, or the whole link, pottery://…"
            );
            let code = self.code.clone();
            let code =
                code.context("the studio's code is missing: give --code and what the host shows, or the whole link")?;
            Target::new(address.to_owned(), code, 1)
        };
        let teacher = self.teacher_token.or(target.teacher);
        let target = Target { wheel: self.wheel.unwrap_or(target.wheel), teacher, ..target };
        Ok(if target.code.print().is_none() { Known::open()?.expect(target, self.trust_new_key) } else { target })
    }
}

/// The strokes that potters replay when they are given no others: the paper's evaluation stroke first.
const STROKES: [(&str, &str); 5] = [
    ("evaluation.csv", include_str!("../../../tests/data/strokes/evaluation.csv")),
    ("waist.csv", include_str!("../../../tests/data/strokes/waist.csv")),
    ("foot.csv", include_str!("../../../tests/data/strokes/foot.csv")),
    ("neck.csv", include_str!("../../../tests/data/strokes/neck.csv")),
    ("rib.csv", include_str!("../../../tests/data/strokes/rib.csv")),
];

impl Arguments {
    pub(crate) fn mode(&self) -> anyhow::Result<Mode> {
        let flags = match &self.command {
            Some(Command::Join(join)) => {
                let target = match joining::look(join.address.as_deref(), join.code.is_some())? {
                    Where::At(address) => join.target(&address)?,
                    Where::Among(found) => return Ok(Mode::Found(found)),
                };
                join.record.as_deref().map_or(Ok(()), check_writable)?;
                let place = Place::Joined(target.clone());
                let session = window(place, None, &join.hold, &join.tool, join.record.as_ref())?;
                return Ok(match join.watch.detail()? {
                    Some(detail) => Mode::Watch(WatchSession { target, detail, working: session }),
                    None => Mode::Window(session),
                });
            }
            Some(Command::Export(flags)) => {
                return Ok(Mode::Export(Conversion { pot: flags.pot.clone(), out: flags.out.clone() }));
            }
            Some(Command::Replay(flags)) => return Ok(Mode::Replay(flags.session())),
            Some(Command::Devices) => return Ok(Mode::Devices),
            Some(Command::Haptics(flags)) => return Ok(flags.mode()),
            Some(Command::Host(flags)) => flags,
            None => &self.host,
        };
        flags.record.as_deref().map_or(Ok(()), check_writable)?;
        if flags.scripted.headless {
            return Ok(Mode::Headless(flags.headless_session()?));
        }
        ensure!(
            flags.watch.is_empty(),
            "who hosts works at the wheel; look on with pottery-studio join ADDRESS --code CODE --watch gallery, or with --headless here"
        );
        let server = flags.server_config(ServerConfig::default().listen)?;
        let place = Place::Hosted(Box::new(server));
        let session = window(place, flags.open.clone(), &flags.hold, &flags.tool, flags.record.as_ref())?;
        Ok(Mode::Window(WindowSession { unfollowed: flags.scripted.given(), ..session }))
    }

    /// The headless session to fall back to when there is no display.
    pub(crate) fn headless_session(&self) -> anyhow::Result<HeadlessSession> {
        match &self.command {
            Some(Command::Join(_)) => bail!("joining needs a display; start it where a window can be opened"),
            Some(Command::Devices | Command::Export(_) | Command::Haptics(_) | Command::Replay(_)) => {
                bail!("nothing here opens a window")
            }
            Some(Command::Host(flags)) => flags.headless_session(),
            None => self.host.headless_session(),
        }
    }
}

impl HapticsFlags {
    fn mode(&self) -> Mode {
        let claim = Claim { is_raised: !self.ordinary, core: self.pin_core, rate: self.rate };
        if !self.bench {
            return Mode::Haptics(claim);
        }
        Mode::Bench(Bench {
            seconds: self.seconds,
            out: self.out.clone(),
            has_server: self.server,
            has_renderer: self.renderer,
            claim,
        })
    }
}

impl ReplayFlags {
    fn session(&self) -> ReplaySession {
        ReplaySession {
            path: self.session.clone(),
            at_s: self.at,
            wheel: self.wheel,
            out: self.headless.then(|| self.out.clone()),
        }
    }
}

impl HostFlags {
    fn server_config(&self, listen: SocketAddr) -> anyhow::Result<ServerConfig> {
        let mut config = ServerConfig {
            listen: self.listen.unwrap_or(listen),
            code: self.code.clone(),
            class: self.class.clone(),
            is_announced: !self.no_announce,
            method: match self.method {
                MethodName::Original => MethodKind::Original,
                MethodName::Improved => MethodKind::Improved,
                MethodName::Plastic => MethodKind::Plastic,
            },
            form: self.form.form(),
            pot: PotSpec { support: self.support.support(), ..PotSpec::default() },
            clay: Material::from_wetness(self.wetness.unwrap_or(self.clay.preset().wetness())),
            record: self.record_session.clone(),
            finest: self.smallest_tool_mm.map(|tool| Finest::of_mm(tool, self.finest_view_mm)),
            ..ServerConfig::default()
        };
        if let Some(path) = &self.open {
            let file = PotFile::read(path)?;
            config.method = file.method();
            config.clay = file.clay();
            config.wheel_speed = file.wheel_speed();
            config.opened = Some(Arc::new(file.pot().clone()));
        }
        Ok(config)
    }

    fn headless_session(&self) -> anyhow::Result<HeadlessSession> {
        let potters = self.scripted.potters()?;
        let mut strokes = Vec::new();
        let choice = self.tool.choice()?;
        // in a window one may take the sphere later on
        ensure!(
            choice.is_sphere() || !choice.is_sized,
            "only a sphere has a radius: leave --tool-radius out, or say --tool sphere"
        );
        for path in &self.scripted.stroke {
            let stroke = Stroke::read(path).with_context(|| format!("the stroke {}", path.display()))?;
            let tools = Shape::NAMED.len() + usize::from(choice.brought.is_some());
            if let Some(Shape(shape)) =
                stroke.tools().filter_map(Tool::shape).find(|shape| usize::from(shape.0) >= tools)
            {
                bail!("the stroke {} needs tool {shape}, which nobody brings; add --tool-file", path.display());
            }
            strokes.push(Arc::new(stroke));
        }
        for potter in strokes.len()..potters {
            let (name, text) = STROKES[potter % STROKES.len()];
            let stroke = Stroke::parse(text).with_context(|| format!("the stroke {name}"))?;
            let stroke = choice.stroke(stroke).with_context(|| format!("the stroke {name} with another tool"))?;
            strokes.push(Arc::new(stroke));
        }
        if self.hold.device.as_ref().is_some_and(|device| device.name() == "mouse") {
            bail!("the mouse needs a window; leave --headless out, or choose another device");
        }
        let mut server = self.server_config(SocketAddr::from(([127, 0, 0, 1], 0)))?;
        server.wheel_speed = strokes[0].wheel_speed();
        Ok(HeadlessSession {
            server,
            strokes,
            seconds: self.scripted.seconds(),
            out: self.scripted.out(),
            hand: self.scripted.hand(),
            device: self.hold.device.clone(),
            core: self.hold.pin_core,
            rate: self.hold.rate,
            network: self.hold.network,
            record: self.record.clone(),
            brought: choice.brought,
            watch: self.watch.iter().map(|watch| watch.detail()).collect(),
        })
    }
}

fn window(
    place: Place,
    opened: Option<PathBuf>,
    hold: &HoldFlags,
    tool: &ToolFlags,
    record: Option<&PathBuf>,
) -> anyhow::Result<WindowSession> {
    let (name, text) = STROKES[0];
    let stroke = Arc::new(Stroke::parse(text).with_context(|| format!("the stroke {name}"))?);
    let device = hold.device.clone().unwrap_or_default();
    let tool = tool.choice()?;
    let (core, rate) = (hold.pin_core, hold.rate);
    let (network, record) = (hold.network, record.cloned());
    let is_muted = hold.mute;
    let unfollowed = Vec::new();
    Ok(WindowSession { place, device, core, rate, is_muted, network, stroke, opened, tool, record, unfollowed })
}
