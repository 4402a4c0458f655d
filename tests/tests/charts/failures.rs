//! Every scenario in which methods of deforming clay fail, and that its table is honest: our method passes, and what is
//! known to fail does.
//!
//! What is done and what it must keep to stands in `src/failures/`; nothing is measured here.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

use pottery_shared::clay::MethodKind;
use pottery_tests::failures::{self, Bound, METHODS, Outcome, SCENARIOS};
use pottery_tests::programs::program;

/// Every method in every scenario, run once.
static OUTCOMES: LazyLock<Vec<Outcome>> = LazyLock::new(|| failures::run(|_| true, |_| {}));

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("failures").join(name)
}

fn run(arguments: &[&str]) -> Output {
    Command::new(program("accuracy-chart")).arg("failures").args(arguments).output().unwrap()
}

/// Fails with every outcome that is not as it should be, one a line.
fn assert_none(rule: &str, outcomes: impl Iterator<Item = &'static Outcome>) {
    let broken: Vec<_> = outcomes
        .map(|Outcome { scenario, method, figure }| {
            format!("{}, {method:?}: {figure} {} for {}", scenario.name, scenario.unit, scenario.bound)
        })
        .collect();
    assert!(broken.is_empty(), "{rule}:\n  {}", broken.join("\n  "));
}

#[test]
fn our_method_passes_every_scenario() {
    let ours = OUTCOMES.iter().filter(|outcome| outcome.method == MethodKind::Plastic);
    assert_none("our method fails", ours.filter(|outcome| !outcome.passes()));
}

#[test]
fn published_methods_fail_where_they_are_known_to_and_nowhere_else() {
    let other = OUTCOMES.iter().filter(|outcome| outcome.method != MethodKind::Plastic && !outcome.is_as_known());
    assert_none("not as the list says", other);
}

#[test]
fn every_scenario_says_what_it_is_and_why() {
    let names: BTreeSet<_> = SCENARIOS.iter().map(|scenario| scenario.name).collect();
    assert_eq!(names.len(), SCENARIOS.len(), "two scenarios of one name");
    for scenario in SCENARIOS {
        let said = [scenario.name, scenario.figure, scenario.reason];
        assert!(said.iter().all(|words| words.len() > 5), "{}", scenario.name);
        assert!(scenario.bound.threshold().is_finite(), "{}", scenario.name);
        assert!(!scenario.fails.contains(&MethodKind::Plastic), "{}: our method is let off", scenario.name);
    }
}

#[test]
fn what_is_no_number_keeps_to_no_bound() {
    for bound in [Bound::AtMost(f64::MAX), Bound::AtLeast(f64::MIN)] {
        assert!(bound.holds(0.0) && !bound.holds(f64::NAN), "{bound}");
    }
    assert!(Bound::AtMost(2.0).holds(2.0) && !Bound::AtMost(2.0).holds(2.1));
    assert!(Bound::AtLeast(-1.0).holds(-1.0) && !Bound::AtLeast(-1.0).holds(-1.1));
}

#[test]
fn scenario_run_again_comes_to_the_same_figure() {
    for name in ["presses that make no sense", "two people pinch the wall", "a still hand pushes with 3 N"] {
        let again = failures::run(|scenario| scenario.name == name, |_| {});
        let first = OUTCOMES.iter().filter(|outcome| outcome.scenario.name == name);
        let figures = |outcome: &Outcome| (outcome.method.number(), outcome.figure.to_bits());
        assert_eq!(again.iter().map(figures).collect::<Vec<_>>(), first.map(figures).collect::<Vec<_>>(), "{name}");
    }
}

#[test]
fn files_hold_every_method_in_every_scenario() {
    let folder = folder("written");
    failures::write(&OUTCOMES, &folder).unwrap();
    let table = std::fs::read_to_string(folder.join("failures.csv")).unwrap();
    let page = std::fs::read_to_string(folder.join("failures.md")).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), SCENARIOS.len() * METHODS.len());
    for (row, outcome) in rows.iter().zip(&*OUTCOMES) {
        assert_eq!(row[7], if outcome.passes() { "yes" } else { "no" }, "{row:?}");
    }
    for scenario in SCENARIOS {
        // once in the table and once with the reason
        assert_eq!(page.matches(scenario.name).count(), 2, "{}", scenario.name);
        assert!(page.contains(scenario.reason), "{}", scenario.name);
    }
    let failed = OUTCOMES.iter().filter(|outcome| !outcome.passes()).count();
    assert_eq!(page.matches("**").count(), 2 * failed, "what fails is in bold");
}

#[test]
fn program_prints_and_writes_what_was_chosen() {
    let folder = folder("program");
    let output = run(&["--out", folder.to_str().unwrap(), "--only", "People"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8(output.stdout).unwrap();
    let chosen = SCENARIOS.iter().filter(|scenario| scenario.name.contains("people"));
    assert_eq!(said.lines().count(), 1 + chosen.clone().count(), "{said}");
    for scenario in chosen {
        assert!(said.contains(scenario.name), "{said}");
    }
    assert!(folder.join("failures.csv").exists() && folder.join("failures.md").exists());
}

#[test]
fn program_refuses_what_it_cannot_do_in_one_sentence() {
    let nowhere = folder("refused");
    let file = folder("in-the-way");
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    std::fs::write(&file, "").unwrap();
    let cases = [
        (vec!["--out", nowhere.to_str().unwrap(), "--only", "dragons"], "no scenario has such a name"),
        (vec!["--out", file.to_str().unwrap()], "choose another with --out"),
    ];
    for (arguments, words) in cases {
        let output = run(&arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && output.stdout.is_empty(), "{arguments:?}");
        assert!(said.contains(words) && said.lines().count() == 1, "{said}");
    }
    assert!(!nowhere.exists());
}
