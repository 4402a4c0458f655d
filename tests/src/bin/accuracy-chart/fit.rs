//! `accuracy-chart fit`: finds the constants of the studio's own clay again.
//!
//! Owns its flags and what it prints; presses and descent are the library's.
//! Invariant: nothing is written; a constant changes only when somebody takes it over by hand.

use std::io::{self, IsTerminal, Write};

use indicatif::{ProgressBar, ProgressStyle};
use pottery_files::flags::number_from;
use pottery_shared::clay::{GridShape, PlasticCsem, PlasticLaw};
use pottery_tests::fit::dents::KnownDent;
use pottery_tests::fit::sides::{self, SIDES};
use pottery_tests::fit::speeds::{self, Quick};
use pottery_tests::fit::strokes::{self, StrokeFigures};
use pottery_tests::fit::walls::{self, KnownForce};
use pottery_tests::fit::{self, FREE, Misfit, SLIDING};
use pottery_tests::printed::{Printed, remark};

const MEANING: &str = "\
What it does:
  Presses every backed dent of tests/data/fem with the law and moves twelve constants downhill (Nelder and Mead, 1965),
  from those in use. A dent scores 1.5 x RMS of the surface that stays + RMS of the surface under the tool, both over
  the travel, + 0.7 x error of the force over its largest, of which 4 per cent count twice.
  Then it draws balls of 12 and 20 mm along the wall, 1 and 2 mm deep, and moves the eight constants of sliding downhill,
  with all else held. A stroke scores the larger of RMS of its groove over its depth and 1.2 x error of its force; the worst count
  most. How much clay heaps up before a ball follows from the forces along its motion by least squares.
  Nothing is fitted to a ball of 16 mm that is drawn, and to the dents called held_.
  It presses hollow pots to 0.5, 1, 2, 3, 4 and 6 mm, from outside and from inside, and moves when their walls fold, how they soften and
  clay on them weakens, by the RMS of the
  errors of the forces, of which 4 per cent count twice and the reference's own four times, and of both surfaces; then how far the inner wall goes along, by that behind what stays of each dent.
  Last it presses balls within a millisecond to four seconds into clay that takes its time, and moves what less a quick one raises,
  by the RMS of the differences to the slow one, and on coarse grids as on the finest, and finds by least squares what a sum over columns leaves out.
What to do with it:
  150 iterations take two or three minutes of a release build. Change PlasticLaw::FITTED only for a score that is lower by
  more than a per cent, and run the tests: they hold the law to more than its score.";

#[derive(clap::Args, Debug)]
#[command(after_help = MEANING)]
pub(crate) struct FitFlags {
    /// Steps downhill; the same number gives the same constants
    #[arg(long, value_name = "N", default_value_t = 150, allow_negative_numbers = true, value_parser = number_from(0_u32, 100_000))]
    iterations: u32,
}

type Printing = Result<(), Box<dyn std::error::Error>>;

/// Fits and prints.
pub(crate) fn run(flags: &FitFlags) -> Printing {
    let dents = fit::dents::finite_elements(GridShape::PAPER)?;
    let used = PlasticLaw::FITTED;
    let bar = if std::io::stderr().is_terminal() {
        ProgressBar::new(flags.iterations.into())
            .with_style(ProgressStyle::with_template("{bar:30} {pos}/{len}  {wide_msg}")?)
    } else {
        ProgressBar::hidden()
    };
    let tenth = (flags.iterations / 10).max(1);
    let tell = |what: &'static str| {
        let (bar, iterations) = (bar.clone(), flags.iterations);
        move |iteration: u32, best: f64| {
            bar.set_position(iteration.into());
            bar.set_message(format!("{what} score {best:.5}"));
            if bar.is_hidden() && iteration.is_multiple_of(tenth) {
                remark(format_args!("{what} {iteration}/{iterations}  score {best:.5}"));
            }
        }
    };
    let found = fit::fit(used, &dents, flags.iterations, tell("dents"))?;
    let found = fit::fit_strokes(found.law, GridShape::PAPER, flags.iterations, tell("strokes"))?;
    let found = fit::Fitted { law: fit::fit_heap(found.law, GridShape::PAPER)?, ..found };
    let forces = walls::finite_elements(GridShape::PAPER)?;
    let hollow = fit::dents::hollow(GridShape::PAPER)?;
    let found = walls::fit(found.law, &forces, &hollow, flags.iterations.min(40), tell("walls"))?;
    let found = walls::fit_following(found.law, &hollow, flags.iterations.min(40), tell("skins"))?;
    let found = speeds::fit(found.law, GridShape::PAPER, flags.iterations.min(20), tell("speeds"))?;
    let grids = sides::presses(&sides::FITTED, found.law)?;
    let found = fit::Fitted { law: sides::fit(found.law, &grids).law, ..found };
    bar.finish_and_clear();
    let laws = [used, found.law];
    let [before, after] = [fit::misfits(used, &dents)?, fit::misfits(found.law, &dents)?];
    print_constants(laws, [fit::score(&before), fit::score(&after)])?;
    print_dents(&dents, &before, &after)?;
    let held_out = fit::dents::held_out(GridShape::PAPER)?;
    writeln!(Printed, "held out of the fit")?;
    print_dents(&held_out, &fit::misfits(used, &held_out)?, &fit::misfits(found.law, &held_out)?)?;
    print_strokes(laws)?;
    print_walls(laws, &forces, &hollow)?;
    print_speeds(laws)?;
    print_sides(laws, &grids)
}

fn print_sides(laws: [PlasticLaw; 2], grids: &[sides::Known]) -> Printing {
    let constants = [[0.0; 4], sides::sides(&laws[0]), sides::sides(&laws[1])];
    let [_, used, found] = constants;
    writeln!(Printed)?;
    for (name, (used, found)) in SIDES.iter().zip(used.into_iter().zip(found)) {
        writeln!(Printed, "{name:<24}{used:>10.3}{found:>10.3}")?;
    }
    let [used, found] = [used, found].map(|constants| sides::score(grids, constants));
    writeln!(Printed, "{:<24}{used:>10.5}{found:>10.5}", "score")?;
    let held_out = sides::presses(&sides::HELD_OUT, laws[0])?;
    writeln!(Printed, "force less that on the finest grid, per cent: RMS and largest")?;
    writeln!(Printed, "{:<36}{:>20}{:>20}{:>20}", "ball and grid", "a sum", "FITTED", "found")?;
    for (what, known, balls) in [("", grids, &sides::FITTED[..]), (", held out", &held_out, &sides::HELD_OUT)] {
        for (tool_mm, _) in balls {
            for [columns, rows] in sides::GRIDS {
                let is_one = |known: &&sides::Known| known.press_mm[0] == *tool_mm && known.grid == [columns, rows];
                let known: Vec<_> = known.iter().filter(is_one).copied().collect();
                write!(Printed, "{:<36}", format!("{tool_mm} mm, {columns} × {rows}{what}"))?;
                for constants in constants {
                    let largest = known.iter().map(|known| known.error(constants).abs()).fold(0.0, f64::max);
                    let rms = sides::score(&known, constants);
                    write!(Printed, "{:>20}", format!("{:.2} {:.2}", 100.0 * rms, 100.0 * largest))?;
                }
                writeln!(Printed)?;
            }
        }
    }
    Ok(())
}

fn print_speeds(laws: [PlasticLaw; 2]) -> Printing {
    let [used, found] = laws.map(|law| speeds::press(law, GridShape::PAPER));
    let (used, found) = (used?, found?);
    writeln!(Printed, "\n{:<24}{:>10.3}{:>10.3}", "rim_ahead", laws[0].rim_ahead, laws[1].rim_ahead)?;
    writeln!(Printed, "{:<24}{:>10.5}{:>10.5}", "score", speeds::score(&used), speeds::score(&found))?;
    writeln!(Printed, "{:<32}{:^30}{:^30}", "quick less slow", "FITTED", "found")?;
    writeln!(Printed, "{:<32}{1:>10}{2:>20}{1:>10}{2:>20}", "press", "per cent", "ridge mm (slow)")?;
    for (used, found) in used.iter().zip(&found) {
        let Quick { press_mm: [ball, deep], within_ms, .. } = used;
        write!(Printed, "{:<32}", format!("ball {ball} mm, {deep} mm in {within_ms} ms"))?;
        for Quick { rms, ridge_mm: [quick, slow], .. } in [used, found] {
            write!(Printed, "{:>10.2}{:>20}", 100.0 * rms, format!("{quick:.3} ({slow:.3})"))?;
        }
        writeln!(Printed)?;
    }
    Ok(())
}

fn print_walls(laws: [PlasticLaw; 2], forces: &[KnownForce], hollow: &[KnownDent]) -> Printing {
    let [used, found] = laws.map(|law| walls::hollow(&law));
    writeln!(Printed)?;
    for (name, (used, found)) in walls::HOLLOW.iter().zip(used.into_iter().zip(found)) {
        writeln!(Printed, "{name:<24}{used:>10.3}{found:>10.3}")?;
    }
    let [used, found] = laws.map(|law| walls::score(law, forces, hollow));
    writeln!(Printed, "{:<24}{:>10.5}{:>10.5}", "score", used?, found?)?;
    let [used, found] = laws.map(|law| walls::following(&law));
    for (name, (used, found)) in walls::FOLLOWING.iter().zip(used.into_iter().zip(found)) {
        writeln!(Printed, "{name:<24}{used:>10.3}{found:>10.3}")?;
    }
    for (what, dents) in [("", hollow), ("held out of the fit", &fit::dents::hollow_held_out(GridShape::PAPER)?)] {
        writeln!(Printed, "{what}")?;
        print_dents(dents, &fit::misfits(laws[0], dents)?, &fit::misfits(laws[1], dents)?)?;
        print_behind(laws, dents)?;
    }
    for (what, forces) in [("", forces), (", held out of the fit", &walls::held_out(GridShape::PAPER)?)] {
        writeln!(Printed, "hollow, force over the largest, per cent{what}")?;
        writeln!(Printed, "{:<36}{:>10}{:>10}{:>20}", "press", "FITTED", "found", "reference N")?;
        let [used, found] = [walls::errors(laws[0], forces)?, walls::errors(laws[1], forces)?];
        for ((known, used), found) in forces.iter().zip(used).zip(found) {
            let press = format!("{} {} mm", known.name, known.depth_mm());
            writeln!(Printed, "{press:<36}{:>+10.2}{:>+10.2}{:>20.2}", 100.0 * used, 100.0 * found, known.force_n)?;
        }
    }
    Ok(())
}

/// How far the inner wall has gone behind each dent.
fn print_behind(laws: [PlasticLaw; 2], dents: &[KnownDent]) -> Printing {
    writeln!(Printed, "{:<24}{:>10}{:>10}{:>20}", "behind the wall, per cent", "FITTED", "found", "reference mm")?;
    let [used, found] = [walls::behind(laws[0], dents)?, walls::behind(laws[1], dents)?];
    for ((known, used), found) in dents.iter().zip(used).zip(found) {
        let press = format!("{} {} mm", known.name, known.dent.depth.as_mm());
        writeln!(Printed, "{press:<24}{:>+10.2}{:>+10.2}{:>20.3}", 100.0 * used, 100.0 * found, known.behind_mm)?;
    }
    Ok(())
}

fn print_constants(laws: [PlasticLaw; 2], scores: [f64; 2]) -> Printing {
    writeln!(Printed, "{:<24}{:>10}{:>10}", "constant", "FITTED", "found")?;
    let row = |name: &str, [used, found]: [f64; 2]| writeln!(Printed, "{name:<24}{used:>10.3}{found:>10.3}");
    let [used, found] = laws.map(|law| fit::free(&law));
    FREE.iter().zip(used.into_iter().zip(found)).try_for_each(|(name, (used, found))| row(name, [used, found]))?;
    writeln!(Printed, "{:<24}{:>10.5}{:>10.5}", "score", scores[0], scores[1])?;
    let [used, found] = laws.map(|law| fit::sliding(&law));
    SLIDING.iter().zip(used.into_iter().zip(found)).try_for_each(|(name, (used, found))| row(name, [used, found]))?;
    let [used, found] = laws.map(|law| fit::strokes_score(law, GridShape::PAPER));
    writeln!(Printed, "{:<24}{:>10.5}{:>10.5}", "score", used?, found?)?;
    Ok(row("slide_heap", laws.map(|law| f64::from(law.slide_heap)))?)
}

fn print_dents(dents: &[KnownDent], used: &[Misfit], found: &[Misfit]) -> io::Result<()> {
    writeln!(Printed, "\n{:<32}{:^30}{:^30}", "per cent", "FITTED", "found")?;
    writeln!(Printed, "{:<32}{1:>10}{2:>10}{3:>10}{1:>10}{2:>10}{3:>10}", "dent", "permanent", "loaded", "force")?;
    for ((dent, used), found) in dents.iter().zip(used).zip(found) {
        write!(Printed, "{:<32}", format!("{} {} mm", dent.name, dent.dent.depth.as_mm()))?;
        for misfit in [used, found] {
            let [permanent, loaded, force] = [misfit.permanent, misfit.loaded, misfit.force].map(|part| 100.0 * part);
            write!(Printed, "{permanent:>10.2}{loaded:>10.2}{force:>+10.2}")?;
        }
        writeln!(Printed)?;
    }
    Ok(())
}

fn print_strokes(laws: [PlasticLaw; 2]) -> Printing {
    writeln!(Printed, "\n{:<24}{:>10}{:>20}{:>20}", "stroke", "groove", "radial N (ref.)", "tangential N (ref.)")?;
    for (whose, law) in ["FITTED", "found"].into_iter().zip(laws) {
        writeln!(Printed, "{whose}")?;
        let method = PlasticCsem { law };
        let drawn = strokes::draw(method, GridShape::PAPER)?;
        for (figures, state) in drawn
            .iter()
            .map(|figures| (figures, ""))
            .chain(strokes::draw_held_out(method, GridShape::PAPER)?.iter().map(|figures| (figures, "held out")))
        {
            let StrokeFigures { name, number, groove, force_n: [radial, along], reference_force_n, .. } = *figures;
            let [radial, along] = [(radial, reference_force_n[0]), (along, reference_force_n[1])]
                .map(|(ours, theirs)| format!("{ours:.2} ({theirs:.2})"));
            let stroke = format!("{name} {number}");
            writeln!(Printed, "{stroke:<24}{:>8.1} %{radial:>20}{along:>20}  {state}", 100.0 * groove)?;
        }
    }
    Ok(())
}
