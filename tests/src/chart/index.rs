//! The page that shows every picture and says when to choose which method.
//!
//! Owns the words between the pictures; every figure in them is one that was measured.
//! Invariant: a picture or file that the page names is written beside it.

use std::fmt::Write;

use super::Figures;
use super::cases::Support;
use super::entrant::ENTRANTS;
use super::pictures;

/// The page.
pub(super) fn page(figures: &Figures) -> String {
    let mut page = String::from("# Which method, and what it costs\n\n");
    let mut line = |text: std::fmt::Arguments<'_>| writeln!(page, "{text}").expect("writing to a string does not fail");
    line(format_args!("Measured on {}.", figures.machine.sentence()));
    if figures.extent.quick {
        line(format_args!("A quick run: fewer steps, travels and pitches."));
    }
    let grid = figures.extent.case_grid;
    line(format_args!("\n## When to choose which\n"));
    line(format_args!(
        "On {} × {} elements; errors are RMS differences to the finite-element dents over the depth, backed wall. A step goes on from what the \
         method has left of the clay, into which it falls more or less; in a first step on untouched clay all touch the same elements.\n",
        grid.columns(),
        grid.rows()
    ));
    line(format_args!(
        "| method | a step, median | against ours | p99 | p99.9 | a first step, against ours | dent that stays | under the tool | force, largest error |"
    ));
    line(format_args!("|---|---|---|---|---|---|---|---|---|"));
    for (row, entrant) in ENTRANTS.iter().enumerate() {
        let Some(own) = figures.methods.iter().find(|own| own.row == row && own.grid == grid) else { continue };
        let forces = figures
            .forces
            .iter()
            .filter(|force| force.row == row && force.support == Support::Backed)
            .filter_map(|force| force.error());
        let force = forces.map(f64::abs).fold(0.0, f64::max) * 100.0;
        let [p99, p999] = [own.times.map(|times| times.p99_us), own.times.map(|times| times.p999_us)]
            .map(|time| time.map_or_else(|| "–".to_owned(), |time_us| format!("{time_us:.1} µs")));
        let first = own.first.map_or_else(|| "–".to_owned(), |[_, over_ours]| format!("{over_ours:.1} ×"));
        let (permanent, loaded) = (own.permanent * 100.0, own.loaded * 100.0);
        let title = entrant.title;
        line(format_args!(
            "| {title} | {:.1} µs | {:.1} × | {p99} | {p999} | {first} | {permanent:.1} % | {loaded:.1} % | {force:.0} % |",
            own.p50_us, own.over_ours
        ));
    }
    line(format_args!(""));
    for (row, entrant) in ENTRANTS.iter().enumerate() {
        if figures.methods.iter().any(|own| own.row == row) {
            line(format_args!("- **{}.** {}", entrant.title, entrant.choose));
        }
    }
    line(format_args!(
        "\nGrids: twice as many elements each way cost two to four times as much a step. Take the coarsest whose elements are a \
         third of the smallest tool's contact; finer ones change the picture and hardly the dent. What is \
         missing on finer grids would take minutes there."
    ));
    for (file, _) in pictures::ALL {
        let (heading, files) = about(file);
        line(format_args!("\n## {heading}\n\n![{heading}]({file})\n\nFigures: {files}."));
    }
    line(format_args!("\n## Further\n"));
    line(format_args!("- [volume.csv](volume.csv): the clay that is pushed away, and how much of it is still there"));
    line(format_args!("- [closed-forms.csv](closed-forms.csv): laws that can be written down"));
    line(format_args!(
        "- [table1.md](table1.md), [table1.csv](table1.csv): the paper's Table I and rates beside these"
    ));
    line(format_args!("- [machine.json](machine.json): what it was measured on"));
    page
}

/// What a picture shows, and the files of its figures.
fn about(picture: &str) -> (&'static str, &'static str) {
    match picture {
        "methods.png" => ("Time against error", "[methods.csv](methods.csv)"),
        "cases.png" => ("Every reference case", "[cases.csv](cases.csv)"),
        "profiles.png" => ("Dents in a backed wall", "[cases.csv](cases.csv)"),
        "profiles-hollow.png" => ("Dents in a hollow pot", "[cases.csv](cases.csv)"),
        "profiles-finger.png" => ("Dents with a finger inside", "[cases.csv](cases.csv)"),
        "force.png" => ("Force over travel", "[force.csv](force.csv)"),
        "convergence.png" => ("Finer steps, finer elements", "[convergence.csv](convergence.csv)"),
        "lathe.png" => ("A fast wheel as a profile", "[lathe.csv](lathe.csv)"),
        _ => ("A thread on a turning wheel", "[helix.csv](helix.csv)"),
    }
}
