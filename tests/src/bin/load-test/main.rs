//! `load-test`: how many people a server takes, before the lesson.
//!
//! Owns the command line and exit codes; everything else is the library's.
//! Invariant: nothing but a server on this machine is put under load unless a flag says so.

mod flags;

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use clap::{CommandFactory as _, Parser};
use pottery_client::whole_file::write_whole;
use pottery_files::flags::first_sentence;
use pottery_files::sentence::sentence;
use pottery_tests::load::plan::Plan;
use pottery_tests::load::result::{RunResult, Verdict};
use pottery_tests::load::run::RunError;
use pottery_tests::load::soak::Slope;
use pottery_tests::load::{knee, law, page, run, soak};
use pottery_tests::printed::{Printed, remark};

use flags::{Arguments, Command, KneeFlags, LawFlags, RunFlags, SoakFlags};

/// Exit code of a run that could not take place.
const ERROR: u8 = 1;
/// Exit code of flags that make no sense.
const SENSELESS: u8 = 2;

/// What is wrong with flags that make no sense.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Senseless(Box<dyn std::error::Error>);

/// What flags ask for, or that they make no sense.
fn asked<T>(flags: Result<T, Box<dyn std::error::Error>>) -> Result<T, Senseless> {
    flags.map_err(Senseless)
}

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(said) if !said.use_stderr() => said.exit(),
        Err(wrong) => {
            let program = Arguments::command();
            let commands = program.get_subcommands().map(clap::Command::get_name);
            remark(format_args!("load-test: {}", first_sentence(&wrong.to_string(), commands)));
            return ExitCode::from(SENSELESS);
        }
    };
    let done = match &arguments.command {
        None => once(&arguments.run),
        Some(Command::Knee(flags)) => climb(flags),
        Some(Command::Law(flags)) => fit(flags),
        Some(Command::Soak(flags)) => go_on(flags),
    };
    match done {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            remark(format_args!("load-test: {}", sentence(error.as_ref())));
            ExitCode::from(if error.is::<Senseless>() { SENSELESS } else { ERROR })
        }
    }
}

type Done = Result<u8, Box<dyn std::error::Error>>;

fn once(flags: &RunFlags) -> Done {
    let result = gone_through(flags, asked(flags.plan())?)?;
    tell(flags, &result)?;
    Ok(result.verdict.code())
}

/// What came of a run; of one that is interrupted, what it has measured is told and written as well.
fn gone_through(flags: &RunFlags, plan: Plan) -> Result<RunResult, Box<dyn std::error::Error>> {
    let done = run::run(plan, &asked(flags.options())?);
    if let Err(RunError::Interrupted { so_far: Some(so_far) }) = &done {
        tell(flags, so_far)?;
    }
    Ok(done?)
}

fn tell(flags: &RunFlags, result: &RunResult) -> Result<(), Box<dyn std::error::Error>> {
    write!(Printed, "{}", result.table())?;
    for said in &result.said {
        writeln!(Printed, "{said}")?;
    }
    writeln!(Printed, "verdict                     {}", in_words(result))?;
    write(flags.json.as_deref(), &serde_json::to_string_pretty(result)?)?;
    write(flags.html.as_deref(), &page::of_run(result))
}

const fn in_words(result: &RunResult) -> &'static str {
    match result.verdict {
        Verdict::Pass => "pass",
        Verdict::Breach if result.outside > 0 => "not everybody who was planned could come in",
        Verdict::Breach => "a threshold is broken",
        Verdict::Invalid if result.is_interrupted => "invalid: it was interrupted",
        Verdict::Invalid => "invalid: the generator did not keep its schedule",
        Verdict::Diverged => "the clay is not known to be the same everywhere",
    }
}

fn write(path: Option<&Path>, text: &str) -> Result<(), Box<dyn std::error::Error>> {
    let Some(path) = path else { return Ok(()) };
    write_whole(path, |file| std::io::Write::write_all(file, text.as_bytes()))?;
    Ok(writeln!(Printed, "written                     {}", path.display())?)
}

fn climb(flags: &KneeFlags) -> Done {
    let climb = knee::climb(&asked(flags.run.plan())?, asked(flags.way())?, &asked(flags.run.options())?)?;
    write!(Printed, "{}", climb.table())?;
    writeln!(Printed, "{}", climb.sentence())?;
    write(flags.run.json.as_deref(), &serde_json::to_string_pretty(&climb)?)?;
    write(flags.run.html.as_deref(), &page::of_climb(&climb))?;
    Ok(climb.verdict().code())
}

fn fit(flags: &LawFlags) -> Done {
    let law = law::fitted(&asked(flags.plan())?, flags.way(), &asked(flags.run.options())?)?;
    write!(Printed, "{}", law.table())?;
    writeln!(Printed, "{}", law.sentence())?;
    write(flags.run.json.as_deref(), &serde_json::to_string_pretty(&law)?)?;
    write(flags.run.html.as_deref(), &page::of_law(&law))?;
    Ok(law.verdict().code())
}

fn go_on(flags: &SoakFlags) -> Done {
    let plan = asked(flags.plan())?;
    if let Some(seconds) = flags.virtual_s {
        asked(flags.run.check_files())?;
        let done = soak::in_virtual_time(&plan.checked()?, seconds)?;
        writeln!(
            Printed,
            "{:.0} s in {:.1} s: memory {}; {} snapshots, {} samples refused",
            done.passed_s,
            done.took_s,
            Slope::told(done.memory.as_ref()),
            done.snapshots,
            done.refused
        )?;
        write(flags.run.json.as_deref(), &serde_json::to_string_pretty(&done)?)?;
        if !done.is_current {
            writeln!(Printed, "somebody does not hold the newest clay")?;
            return Ok(Verdict::Diverged.code());
        }
        let is_within = Slope::is_within(done.memory.as_ref(), flags.growth_max_mb);
        return Ok(if is_within { Verdict::Pass } else { Verdict::Breach }.code());
    }
    let mut result = gone_through(&flags.run, plan)?;
    let slope = soak::of_run(&result);
    let late = result.server.as_ref().map_or_else(
        || "its late ticks not told; a thread with nothing to do".to_owned(),
        |server| {
            let (late, alone) = (server.late_ticks, server.late_ticks_alone);
            format!("{late} late ticks, {alone} of them while no thread with nothing to do was late; that")
        },
    );
    let memory = Slope::told(slope.as_ref());
    result.said.push(format!("memory of the server {memory}; {late} was late {} times", result.bystander_late));
    if result.verdict == Verdict::Pass && !Slope::is_within(slope.as_ref(), flags.growth_max_mb) {
        result.verdict = Verdict::Breach;
        result.said.push(match slope {
            Some(_) => format!("it may grow by {} MB", flags.growth_max_mb),
            None => {
                "a soak without the server's memory says little: start one with --spawn, and go on for longer".into()
            }
        });
    }
    tell(&flags.run, &result)?;
    Ok(result.verdict.code())
}
