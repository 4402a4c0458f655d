//! `load-test`: how many people a server takes, before the lesson.
//!
//! Owns the command line and exit codes; everything else is the library's.
//! Invariant: nothing but a server on this machine is put under load unless a flag says so.

mod flags;

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use pottery_client::whole_file::write_whole;
use pottery_tests::load::result::{RunResult, Verdict};
use pottery_tests::load::{knee, law, page, run, soak};

use flags::{Arguments, Command, KneeFlags, LawFlags, RunFlags, SoakFlags};

/// Exit code of a run that could not take place.
const ERROR: u8 = 1;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let done = match &arguments.command {
        None => once(&arguments.run),
        Some(Command::Knee(flags)) => climb(flags),
        Some(Command::Law(flags)) => fit(flags),
        Some(Command::Soak(flags)) => go_on(flags),
    };
    match done {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            eprintln!("load-test: {error:#}");
            ExitCode::from(ERROR)
        }
    }
}

type Done = Result<u8, Box<dyn std::error::Error>>;

fn once(flags: &RunFlags) -> Done {
    let result = run::run(flags.plan()?, &flags.options()?)?;
    tell(flags, &result)?;
    Ok(result.verdict.code())
}

fn tell(flags: &RunFlags, result: &RunResult) -> Result<(), Box<dyn std::error::Error>> {
    print!("{}", result.table());
    for said in &result.said {
        println!("{said}");
    }
    println!("verdict                     {}", sentence(result.verdict));
    write(flags.json.as_deref(), &serde_json::to_string_pretty(result)?)?;
    write(flags.html.as_deref(), &page::of_run(result))
}

const fn sentence(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "pass",
        Verdict::Breach => "a threshold is broken",
        Verdict::Invalid => "invalid: the generator did not keep its schedule",
        Verdict::Diverged => "the clay is not the same everywhere",
    }
}

fn write(path: Option<&Path>, text: &str) -> Result<(), Box<dyn std::error::Error>> {
    let Some(path) = path else { return Ok(()) };
    write_whole(path, |file| std::io::Write::write_all(file, text.as_bytes()))?;
    println!("written                     {}", path.display());
    Ok(())
}

fn climb(flags: &KneeFlags) -> Done {
    let climb = knee::climb(&flags.run.plan()?, flags.way(), &flags.run.options()?)?;
    print!("{}", climb.table());
    println!("{}", climb.sentence());
    write(flags.run.json.as_deref(), &serde_json::to_string_pretty(&climb)?)?;
    write(flags.run.html.as_deref(), &page::of_climb(&climb))?;
    Ok(if climb.knee.is_some() { 0 } else { Verdict::Breach.code() })
}

fn fit(flags: &LawFlags) -> Done {
    let law = law::fitted(&flags.plan()?, flags.way(), &flags.run.options()?)?;
    print!("{}", law.table());
    println!("{}", law.sentence());
    write(flags.run.json.as_deref(), &serde_json::to_string_pretty(&law)?)?;
    write(flags.run.html.as_deref(), &page::of_law(&law))?;
    Ok(0)
}

fn go_on(flags: &SoakFlags) -> Done {
    let plan = flags.plan()?;
    if let Some(seconds) = flags.virtual_s {
        let done = soak::in_virtual_time(&plan.checked()?, seconds)?;
        println!(
            "{:.0} s in {:.1} s: memory {:+.2} ± {:.2} MB/h, grown by {:.2} MB beyond the error; {} snapshots, {} samples refused",
            done.passed_s,
            done.took_s,
            done.memory.mb_per_h,
            done.memory.error_mb_per_h,
            done.memory.growth_mb(),
            done.snapshots,
            done.refused
        );
        write(flags.run.json.as_deref(), &serde_json::to_string_pretty(&done)?)?;
        if !done.is_current {
            println!("somebody does not hold the newest clay");
            return Ok(Verdict::Diverged.code());
        }
        return Ok(if done.memory.growth_mb() <= flags.growth_max_mb { 0 } else { Verdict::Breach.code() });
    }
    let mut result = run::run(plan, &flags.run.options()?)?;
    let slope = soak::of_run(&result);
    let grown = slope.growth_mb();
    let said = format!(
        "memory of the server {:+.2} ± {:.2} MB/h, grown by {grown:.2} MB beyond the error; {} late ticks, {} of them while no thread with nothing to do was late; that was late {} times",
        slope.mb_per_h,
        slope.error_mb_per_h,
        result.server.as_ref().map_or(0, |server| server.late_ticks),
        result.server.as_ref().map_or(0, |server| server.late_ticks_alone),
        result.bystander_late
    );
    result.said.push(said);
    if result.verdict == Verdict::Pass && grown > flags.growth_max_mb {
        result.verdict = Verdict::Breach;
        result.said.push(format!("it may grow by {} MB", flags.growth_max_mb));
    }
    tell(&flags.run, &result)?;
    Ok(result.verdict.code())
}
