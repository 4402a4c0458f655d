//! The `pottery-server` binary: flags, a file, signals.
//!
//! Everything else is the library's. Invariant: SIGINT and SIGTERM end it with everybody told, and exit code 0 means that everything was kept.

/// Says a line to whoever reads; that nobody does any more is no reason to stop.
macro_rules! say {
    ($($part:tt)*) => {
        drop(std::io::Write::write_fmt(&mut std::io::stdout(), format_args!("{}\n", format_args!($($part)*))))
    };
}

mod console;

use std::cmp::Ordering;
use std::ffi::OsString;
use std::io::{IsTerminal as _, Write as _};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context as _;
use clap::error::{ContextKind, ContextValue};
use clap::{Arg, ArgMatches, CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use pottery_files::flags::{first_sentence, number_from};
use pottery_files::sentence::sentence;
use pottery_server::{FileConfig, Finest, Server, ServerConfig, address, stop_signal};
use pottery_shared::clay::{Form, Material, MethodKind, Preset, Support, Wetness};
use pottery_shared::protocol::JoinCode;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;

/// The pottery studio's server: people join it, shape the pots on its wheels together, and feel the clay.
///
/// Settings come from flags, then the environment, then the file given with --config, then the defaults.
#[derive(Debug, Parser)]
#[command(name = "pottery-server", version, after_help = EXAMPLES)]
#[command(allow_negative_numbers = true, args_conflicts_with_subcommands = true)]
struct Flags {
    #[command(subcommand)]
    command: Option<Command>,
    /// UDP address to listen on [default: [::]:4747, all networks]
    #[arg(long, value_name = "ADDRESS", value_parser = address, env = "POTTERY_LISTEN")]
    listen: Option<SocketAddr>,
    /// Join code of 8 characters; when left out a fresh one at each start, save after a server on the same --data that was killed
    #[arg(long, env = "POTTERY_CODE")]
    code: Option<JoinCode>,
    /// Hours for which a code is good: after that, and after a teacher has changed it, it lets nobody in [default: for good]
    #[arg(long, value_name = "HOURS", value_parser = number_from(ServerConfig::CODE_HOURS.0, ServerConfig::CODE_HOURS.1), env = "POTTERY_CODE_HOURS")]
    code_hours: Option<f64>,
    /// Who comes waits until a teacher lets them in
    #[arg(long, env = "POTTERY_LOBBY")]
    lobby: bool,
    /// What the class is called where it announces itself on the local network; a word when left out
    #[arg(long, value_name = "NAME", env = "POTTERY_CLASS")]
    class: Option<String>,
    /// Do not announce the studio on the local network
    #[arg(long, env = "POTTERY_NO_ANNOUNCE")]
    no_announce: bool,
    /// Make a new teacher's token; the one before teaches no longer
    #[arg(long)]
    new_teacher_token: bool,
    /// Number of wheels, each with its own pot
    #[arg(long, value_parser = number_from(1, ServerConfig::WHEELS_MAX), env = "POTTERY_WHEELS")]
    wheels: Option<u16>,
    /// Most people at one time [default: 64]
    #[arg(long, value_parser = number_from(1, ServerConfig::PEOPLE_MAX), env = "POTTERY_PEOPLE")]
    people: Option<u16>,
    /// What stands on every wheel at first: cylinder, bowl, bottle or ball [default: cylinder]
    #[arg(long, value_name = "NAME", value_parser = form, env = "POTTERY_FORM")]
    form: Option<Form>,
    /// Radius of the smallest tool that anybody will use, mm: the grid of every pot is as coarse as that tool allows. A finger has
    /// 8 to 12, and takes a tenth of the elements [default: 360 x 400 of them, which do for 4.2 mm]
    #[arg(long, value_name = "MM", value_parser = number_from(Finest::TOOL_MM.0, Finest::TOOL_MM.1), env = "POTTERY_SMALLEST_TOOL_MM")]
    smallest_tool_mm: Option<f32>,
    /// Shortest length on the clay that anybody sees, mm: where that is longer than the tool's elements, they are as long
    #[arg(long, value_name = "MM", value_parser = number_from(Finest::SEEN_MM.0, Finest::SEEN_MM.1), env = "POTTERY_FINEST_VIEW_MM")]
    finest_view_mm: Option<f32>,
    /// What stands behind every pot's wall: backed (a rigid core) or hollow (nothing: it bends) [default: backed]
    #[arg(long, value_name = "NAME", value_parser = support, env = "POTTERY_SUPPORT")]
    support: Option<Support>,
    /// How clay deforms: original, improved or plastic [default: plastic]
    #[arg(long, value_name = "NAME", value_parser = method, env = "POTTERY_METHOD")]
    method: Option<MethodKind>,
    /// Clay as potters name it: stiff, throwing, soft or slip [default: throwing]
    #[arg(long, value_name = "NAME", value_parser = preset, env = "POTTERY_CLAY")]
    clay: Option<Preset>,
    /// How wet the clay is instead, from 0.0 (crumbles) to 1.0 (runs)
    #[arg(long, value_name = "INDEX", value_parser = wetness, env = "POTTERY_WETNESS")]
    wetness: Option<Wetness>,
    /// Session file to write while the studio is open: pottery-studio replay goes through it again. It must not exist yet
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Print what the server counts as a line of JSON every so many seconds: people, ticks, how long they took, datagrams
    #[arg(long, value_name = "SECONDS", value_parser = number_from(1, FIGURES_S_MAX))]
    figures: Option<u32>,
    /// Folder in which the pots are kept: written every half minute, when everybody has left a wheel and at the end, and gone on with
    /// at the next start
    #[arg(long, value_name = "DIR", env = "POTTERY_DATA")]
    data: Option<PathBuf>,
    /// Begin with new pots; those in the data folder get another name
    #[arg(long)]
    fresh: bool,
    /// Loopback address that answers GET /livez, /readyz, /metrics and /lesson, and POST /order with the teacher's token
    #[arg(long, value_name = "ADDRESS", value_parser = address, env = "POTTERY_OPERATE")]
    operate: Option<SocketAddr>,
    /// How the log is written on standard error
    #[arg(long, value_enum, default_value_t = Log::Text, env = "POTTERY_LOG")]
    log: Log,
    /// Settings in TOML: listen, code, code_hours, lobby, class, announce, wheels, people_max, columns, rows, smallest_tool_mm, finest_view_mm,
    /// height_mm, radius_mm, wall_mm, form, method, wheel_rpm, clay, wetness, support, data, operate, [arrivals] with burst, per_s, wrong_code_costs, exempts_loopback, and
    /// [input] with datagrams_per_s, datagram_bytes_per_s, requests_per_s, request_bytes_per_s of each person, spare_people of each address
    #[arg(long, value_name = "FILE", env = "POTTERY_CONFIG")]
    config: Option<PathBuf>,
    /// Print the settings as they are in the end, as such a file, and stop
    #[arg(long)]
    print_config: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// How the lesson on this machine's server stands, and what a teacher orders there
    Console(console::ConsoleFlags),
}

/// Seconds of a day, after which figures are printed at the latest.
const FIGURES_S_MAX: u32 = 86_400;

const EXAMPLES: &str = "Examples:
  pottery-server                                  one wheel, a fresh join code
  pottery-server --wheels 8 --code K7QM-3XPD      a class round eight wheels
  pottery-server --listen 127.0.0.1:5000          this machine only
  pottery-server --clay soft                      wetter clay on every wheel
  pottery-server --smallest-tool-mm 10            a grid for fingers: more wheels on a small machine
  pottery-server --record monday.session          keep what happens, for pottery-studio replay
  pottery-server --data pots                      keep the pots, and go on with them at the next start
  pottery-server --operate 127.0.0.1:4748         answer this machine's operators
  pottery-server console                          how the lesson stands, for who is at this machine
  pottery-server console freeze 2                 order something, with the teacher's token
  pottery-server --wheels 4 --print-config        a file to begin settings from";

fn method(text: &str) -> Result<MethodKind, String> {
    MethodKind::from_name(text).ok_or_else(|| "choose original, improved or plastic".into())
}

fn form(text: &str) -> Result<Form, String> {
    Form::from_name(text).ok_or_else(|| "choose cylinder, bowl, bottle or ball".into())
}

fn support(text: &str) -> Result<Support, String> {
    Support::from_name(text).ok_or_else(|| "choose backed or hollow".into())
}

fn preset(text: &str) -> Result<Preset, String> {
    Preset::from_name(text).ok_or_else(|| "choose stiff, throwing, soft or slip".into())
}

fn wetness(text: &str) -> Result<Wetness, String> {
    let index = text.parse().map_err(|_| "choose a number from 0.0 to 1.0")?;
    Wetness::new(index).map_err(|error| error.to_string())
}

/// How the log is written.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Log {
    /// For people
    Text,
    /// A JSON object a line, for programs
    Json,
}

/// Exit code of flags that make no sense.
const SENSELESS: u8 = 2;

/// What is wrong with flags, or with a variable of the environment that stands in the place of one that is not on the line.
fn sentence_of(wrong: &clap::Error, line: impl Iterator<Item = OsString>) -> String {
    let mut program = Flags::command();
    program.build();
    let said = first_sentence(&wrong.to_string(), program.get_subcommands().map(clap::Command::get_name));
    let Some(ContextValue::String(named)) = wrong.get(ContextKind::InvalidArg) else { return said };
    let mut known = program.get_arguments().chain(program.get_subcommands().flat_map(clap::Command::get_arguments));
    let flag = known.find(|flag| flag.to_string() == *named);
    let (Some(long), Some(variable)) = (flag.and_then(Arg::get_long), flag.and_then(Arg::get_env)) else { return said };
    let is_it = |word: OsString| {
        word.to_string_lossy().strip_prefix("--").is_some_and(|word| word.split('=').next() == Some(long))
    };
    if std::env::var_os(variable).is_none() || line.skip(1).any(is_it) {
        return said;
    }
    said.replace(&format!("'{named}'"), &format!("{} in the environment", variable.display()))
}

#[tokio::main]
async fn main() -> ExitCode {
    let parsed = Flags::command().try_get_matches();
    let (flags, matches) = match parsed.and_then(|matches| Ok((Flags::from_arg_matches(&matches)?, matches))) {
        Ok(parsed) => parsed,
        Err(said) if !said.use_stderr() => said.exit(),
        Err(wrong) => {
            drop(writeln!(std::io::stderr(), "pottery-server: {}", sentence_of(&wrong, std::env::args_os())));
            return ExitCode::from(SENSELESS);
        }
    };
    let asked = std::env::var("RUST_LOG").ok().and_then(|filter| filter.parse::<Targets>().ok());
    let filter = asked.unwrap_or_else(|| Targets::new().with_target("pottery_server", LevelFilter::INFO));
    let has_colours = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|no| no.is_empty());
    // who reads the log no longer is no reason to end
    let log =
        tracing_subscriber::fmt::layer().with_writer(std::io::stderr).with_ansi(has_colours).log_internal_errors(false);
    match flags.log {
        Log::Text => tracing_subscriber::registry().with(log).with(filter).init(),
        Log::Json => tracing_subscriber::registry().with(log.json()).with(filter).init(),
    }
    match run(flags, &matches).await {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            drop(writeln!(std::io::stderr(), "pottery-server: {}", sentence(error.as_ref())));
            ExitCode::FAILURE
        }
    }
}

/// Prints what the program was run for.
///
/// # Errors
/// Nobody takes it.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).context("it cannot be printed")
}

/// How wet the clay is to be, where flags or the environment say so; flags stand before the environment.
fn asked_wetness(flags: &Flags, matches: &ArgMatches) -> anyhow::Result<Option<Wetness>> {
    match matches.value_source("clay").cmp(&matches.value_source("wetness")) {
        Ordering::Greater => Ok(flags.clay.map(Preset::wetness)),
        Ordering::Less => Ok(flags.wetness),
        Ordering::Equal if flags.clay.is_none() => Ok(None),
        Ordering::Equal => anyhow::bail!(
            "--clay and --wetness, or POTTERY_CLAY and POTTERY_WETNESS, both say what the clay is: leave one of them out"
        ),
    }
}

async fn run(flags: Flags, matches: &ArgMatches) -> anyhow::Result<()> {
    let wetness = asked_wetness(&flags, matches)?;
    if let Some(Command::Console(flags)) = flags.command {
        return tokio::task::spawn_blocking(move || console::run(&flags)).await?;
    }
    let file = flags.config.as_deref().map_or_else(|| Ok(FileConfig::default()), FileConfig::read)?;
    let mut config = file.with_finest(flags.smallest_tool_mm, flags.finest_view_mm).into_config()?;
    config.listen = flags.listen.unwrap_or(config.listen);
    config.wheels = flags.wheels.unwrap_or(config.wheels);
    config.people_max = flags.people.unwrap_or(config.people_max);
    config.code = flags.code.or(config.code);
    config.code_hours = flags.code_hours.or(config.code_hours);
    config.has_lobby |= flags.lobby;
    config.class = flags.class.or(config.class);
    config.is_announced &= !flags.no_announce;
    config.renews_teacher = flags.new_teacher_token;
    config.record = flags.record;
    config.form = flags.form.unwrap_or(config.form);
    config.pot.support = flags.support.unwrap_or(config.pot.support);
    config.method = flags.method.unwrap_or(config.method);
    config.clay = wetness.map_or(config.clay, Material::from_wetness);
    config.data = flags.data.or(config.data);
    config.is_fresh = flags.fresh;
    config.operate = flags.operate.or(config.operate);
    if flags.print_config {
        return print(&FileConfig::of(&config.checked()?).to_toml()?);
    }
    // before anybody is told that it listens, and may end it
    let stopped = stop_signal()?;
    let server = Server::start(config)?;
    say!("listening on {}", server.address());
    say!("join code    {}", server.code());
    match server.teacher_token() {
        Some(token) => say!("teacher      {token} (shown once: pottery-studio join --teacher-token)"),
        None => say!("teacher      the token that was shown at the first start; --new-teacher-token makes another"),
    }
    if let Some(address) = server.operated_at() {
        say!("operators    http://{address}/metrics");
    }
    tokio::pin!(stopped);
    loop {
        let next = tokio::time::sleep(Duration::from_secs(flags.figures.unwrap_or(u32::MAX).into()));
        tokio::select! {
            ended = &mut stopped => break ended?,
            // who watches this program begins it anew; people come back by themselves
            () = server.ended() => break,
            () = next => say!("{}", server.figures().await?.to_json_line()),
        }
    }
    say!("closing: telling everybody");
    let losses = server.stop().await;
    anyhow::ensure!(losses.is_none(), "{losses}");
    Ok(())
}
