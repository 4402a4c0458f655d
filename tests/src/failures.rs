//! Where methods of deforming clay fail: scenarios, what each must keep to, and what each method comes to.
//!
//! Owns the table and how it is written; [`SCENARIOS`] is the list, and what is done in a scenario stands in files by theme.
//! Invariant: a scenario is the same run every time: no clock, and dice with a seed of their own.

mod conserved;
mod grid;
mod hand;
mod hostile;
mod list;
mod scene;
mod shared_pot;

use std::fmt::{Display, Formatter, Write};
use std::path::Path;

use pottery_shared::clay::MethodKind;

use crate::chart::ChartError;
use crate::chart::csv::{self, Cell, Row};
pub use list::SCENARIOS;
pub(crate) use scene::{Scene, larger, smaller, spread_percent};

/// The methods that are tried, and their names, as the columns of the table.
pub const METHODS: [(MethodKind, &str); 3] =
    [(MethodKind::Original, "original"), (MethodKind::Improved, "improved"), (MethodKind::Plastic, "ours")];

/// What a figure must keep to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// No more than this.
    AtMost(f64),
    /// No less than this.
    AtLeast(f64),
}

impl Bound {
    /// Whether a figure keeps to it; what is not a number does not.
    #[must_use]
    pub fn holds(self, figure: f64) -> bool {
        match self {
            Self::AtMost(most) => figure <= most,
            Self::AtLeast(least) => figure >= least,
        }
    }

    /// The number alone.
    #[must_use]
    pub const fn threshold(self) -> f64 {
        match self {
            Self::AtMost(threshold) | Self::AtLeast(threshold) => threshold,
        }
    }
}

impl Display for Bound {
    fn fmt(&self, to: &mut Formatter<'_>) -> std::fmt::Result {
        let sign = match self {
            Self::AtMost(_) => '≤',
            Self::AtLeast(_) => '≥',
        };
        write!(to, "{sign} {}", shown(self.threshold()))
    }
}

/// One way in which a method may fail.
#[derive(Clone, Copy, Debug)]
pub struct Scenario {
    /// What is done.
    pub name: &'static str,
    /// What is measured.
    pub figure: &'static str,
    /// Unit of the figure; empty for a ratio or a number of things.
    pub unit: &'static str,
    /// What the figure must keep to.
    pub bound: Bound,
    /// Why that much and not more.
    pub reason: &'static str,
    /// The published methods of which it is known that they do not.
    pub fails: &'static [MethodKind],
    /// The figure of a method; infinite when a radius is out of bounds or a force no number.
    pub measure: fn(MethodKind) -> f64,
}

/// What a method came to in a scenario.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// The scenario.
    pub scenario: &'static Scenario,
    /// The method.
    pub method: MethodKind,
    /// Its figure, in the scenario's unit.
    pub figure: f64,
}

impl Outcome {
    /// Puts a method through a scenario.
    #[must_use]
    pub fn measured(scenario: &'static Scenario, method: MethodKind) -> Self {
        Self { scenario, method, figure: (scenario.measure)(method) }
    }

    /// Whether the figure keeps to the bound.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.scenario.bound.holds(self.figure)
    }

    /// Whether it passes or fails as the scenario says.
    #[must_use]
    pub fn is_as_known(&self) -> bool {
        self.passes() != self.scenario.fails.contains(&self.method)
    }
}

/// Puts every method through the scenarios of [`SCENARIOS`] of which `chosen` is true, and tells of each before it begins.
pub fn run(chosen: impl Fn(&Scenario) -> bool, told: impl FnMut(&Scenario)) -> Vec<Outcome> {
    run_of(SCENARIOS, chosen, told)
}

/// The same with another list.
pub fn run_of(
    scenarios: &'static [Scenario],
    chosen: impl Fn(&Scenario) -> bool,
    mut told: impl FnMut(&Scenario),
) -> Vec<Outcome> {
    let mut outcomes = Vec::new();
    for scenario in scenarios.iter().filter(|scenario| chosen(scenario)) {
        told(scenario);
        outcomes.extend(METHODS.map(|(method, _)| Outcome::measured(scenario, method)));
    }
    outcomes
}

impl Row for Outcome {
    const COLUMNS: &'static [&'static str] =
        &["method", "scenario", "measured", "unit", "figure", "passes_when", "threshold", "passes", "as_known"];

    fn cells(&self) -> Vec<Cell> {
        let Scenario { name, figure, unit, bound, .. } = self.scenario;
        let side = match bound {
            Bound::AtMost(_) => "at most",
            Bound::AtLeast(_) => "at least",
        };
        let method = METHODS.iter().find(|(method, _)| *method == self.method).map_or("", |(_, name)| name);
        // a comma parts cells
        let words = |text: &str| Cell::from(text.replace(',', "").as_str());
        vec![
            words(method),
            words(name),
            words(figure),
            words(unit),
            self.figure.into(),
            words(side),
            bound.threshold().into(),
            self.passes().into(),
            self.is_as_known().into(),
        ]
    }
}

/// The table of scenarios and methods as Markdown, and the reason for every threshold.
#[must_use]
pub fn page(heading: &str, outcomes: &[Outcome]) -> String {
    let mut page = format!("# {heading}\n\n");
    let mut line = |text: std::fmt::Arguments<'_>| writeln!(page, "{text}").expect("writing to a string does not fail");
    line(format_args!("What fails is in bold. Nothing is timed, and dice have a fixed seed.\n"));
    let names = METHODS.map(|(_, name)| name).join(" | ");
    line(format_args!("| scenario | measured | passes when | {names} |"));
    line(format_args!("|---|---|---|{}", "---:|".repeat(METHODS.len())));
    for of_one in by_scenario(outcomes) {
        let Scenario { name, figure, unit, bound, .. } = of_one[0].scenario;
        let cells: Vec<String> = of_one
            .iter()
            .map(|outcome| {
                let figure = shown(outcome.figure);
                if outcome.passes() { figure } else { format!("**{figure}**") }
            })
            .collect();
        line(format_args!("| {name} | {figure} | {} | {} |", with_unit(&bound.to_string(), unit), cells.join(" | ")));
    }
    line(format_args!("\n## Why these thresholds\n"));
    for of_one in by_scenario(outcomes) {
        let Scenario { name, unit, bound, reason, .. } = of_one[0].scenario;
        line(format_args!("- {name}, {}: {reason}.", with_unit(&bound.to_string(), unit)));
    }
    page
}

/// The same in columns for a terminal.
#[must_use]
pub fn table(outcomes: &[Outcome]) -> String {
    let width = outcomes.iter().map(|outcome| outcome.scenario.name.chars().count()).max().unwrap_or(0);
    let mut table = format!("{:width$}  {:>12}", "scenario", "passes when");
    for (_, name) in METHODS {
        write!(table, "  {name:>14}").expect("writing to a string does not fail");
    }
    for of_one in by_scenario(outcomes) {
        let Scenario { name, unit, bound, .. } = of_one[0].scenario;
        let bound = with_unit(&bound.to_string(), unit);
        write!(table, "\n{name:width$}  {bound:>12}").expect("writing to a string does not fail");
        for outcome in of_one {
            let verdict = if outcome.passes() { "pass" } else { "FAIL" };
            write!(table, "  {:>9} {verdict}", shown(outcome.figure)).expect("writing to a string does not fail");
        }
    }
    table
}

/// Writes `failures.csv` and `failures.md` into a folder, which is made when it is not there.
///
/// # Errors
/// [`ChartError::Write`] when one cannot be written; choose another folder.
pub fn write(outcomes: &[Outcome], folder: &Path) -> Result<(), ChartError> {
    write_as(outcomes, folder, "failures", "Where methods fail")
}

/// The same under another name and heading.
///
/// # Errors
/// As [`write`](fn@write).
pub fn write_as(outcomes: &[Outcome], folder: &Path, name: &str, heading: &str) -> Result<(), ChartError> {
    let written = |path: &Path, done: std::io::Result<()>| {
        done.map_err(|source| ChartError::Write { path: path.to_owned(), source })
    };
    written(folder, std::fs::create_dir_all(folder))?;
    for (ending, text) in [("csv", csv::text(outcomes)), ("md", page(heading, outcomes))] {
        let path = folder.join(name).with_extension(ending);
        written(&path, std::fs::write(&path, text))?;
    }
    Ok(())
}

/// The outcomes of each scenario together, as [`run`] leaves them.
fn by_scenario(outcomes: &[Outcome]) -> impl Iterator<Item = &[Outcome]> {
    outcomes.chunk_by(|one, other| one.scenario.name == other.scenario.name)
}

fn with_unit(figure: &str, unit: &str) -> String {
    if unit.is_empty() { figure.to_owned() } else { format!("{figure} {unit}") }
}

/// Three digits that count.
fn shown(figure: f64) -> String {
    match figure.abs() {
        0.0 => "0".to_owned(),
        size if !size.is_finite() => "broken".to_owned(),
        size if size < 1e-3 => format!("{figure:.1e}"),
        size => {
            let digits = (2.0 - size.log10().floor()).clamp(0.0, 5.0) as usize;
            let text = format!("{figure:.digits$}");
            if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
        }
    }
}
