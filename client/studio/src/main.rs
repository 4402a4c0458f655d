//! The pottery studio: one program that hosts, joins and shows.
//!
//! Owns the command line and the choice between window and headless; the rest stands in its modules.
//! Invariant: whatever goes wrong ends in one sentence on standard error and a code other than zero.

/// Says a line to whoever reads; that nobody does any more is no reason to stop.
macro_rules! say {
    ($($part:tt)*) => {
        drop(std::io::Write::write_fmt(&mut std::io::stdout(), format_args!("{}\n", format_args!($($part)*))))
    };
}

/// The same for what went wrong or must be known, with the program's name.
macro_rules! note {
    ($($part:tt)*) => {
        drop(std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("pottery-studio: {}\n", format_args!($($part)*))))
    };
}

mod arguments;
mod conversion;
mod endings;
mod haptics;
mod headless;
mod headless_choice;
mod hosting;
mod joining;
mod known;
mod network;
mod preferences;
mod record;
mod replaying;
mod report;
mod tool_choice;
mod watch_choice;
mod window;
mod words;

use std::io::IsTerminal as _;
use std::process::ExitCode;

use anyhow::Context;
use clap::{CommandFactory as _, Parser};
use pottery_client::device::survey;
use pottery_client::flags::first_sentence;
use pottery_client::sentence;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;

use arguments::{Arguments, Mode};

/// Exit code of flags that make no sense.
const SENSELESS: u8 = 2;

fn main() -> ExitCode {
    window::begin_timing();
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(said) if !said.use_stderr() => said.exit(),
        Err(wrong) => {
            let program = Arguments::command();
            let commands = program.get_subcommands().map(clap::Command::get_name);
            note!("{}", first_sentence(&wrong.to_string(), commands));
            return ExitCode::from(SENSELESS);
        }
    };
    let asked = std::env::var("RUST_LOG").ok().and_then(|filter| filter.parse::<Targets>().ok());
    let usual = [("winit", LevelFilter::ERROR), ("pulseaudio", LevelFilter::OFF)];
    let filter = asked.unwrap_or_else(|| Targets::new().with_default(LevelFilter::WARN).with_targets(usual));
    let has_colours = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|no| no.is_empty());
    // who reads the log no longer is no reason to end
    let log =
        tracing_subscriber::fmt::layer().with_writer(std::io::stderr).with_ansi(has_colours).log_internal_errors(false);
    tracing_subscriber::registry().with(log).with(filter).init();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            note!("{}", sentence(error.as_ref()));
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> anyhow::Result<()> {
    match arguments.mode()? {
        Mode::Export(job) => conversion::run(&job),
        Mode::Headless(session) => headless::run(&session),
        Mode::Replay(session) => replaying::run(&session),
        Mode::Found(found) => {
            joining::tell(&found);
            Ok(())
        }
        Mode::Devices => {
            for device in survey() {
                match device.found {
                    Ok(found) => say!("{:<12} there      {found}", device.name),
                    Err(why) => say!("{:<12} not there  {why}", device.name),
                }
            }
            Ok(())
        }
        Mode::Haptics(claim) => haptics::tell(claim),
        Mode::Bench(bench) => haptics::run(&bench),
        Mode::Watch(session) => match window::watch(&session)? {
            window::Ended::ByPerson => Ok(()),
            window::Ended::NoDisplay(reason) => {
                anyhow::bail!("looking on needs a display, and no window can be opened here ({reason})")
            }
        },
        Mode::Window(session) => match window::run(&session)? {
            window::Ended::ByPerson => Ok(()),
            window::Ended::NoDisplay(reason) => {
                let no_window = format!("no window can be opened here ({reason})");
                let session = arguments.headless_session().context(no_window.clone())?;
                note!("{no_window}; working headless instead");
                headless::run(&session)
            }
        },
    }
}
