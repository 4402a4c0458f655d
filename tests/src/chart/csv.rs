//! Figures as comma-separated text.
//!
//! Owns how a number is written; each measurement names its own columns, units included.
//! Invariant: a row has as many cells as there are columns, and a cell holds no comma.

use std::fmt::Write;

/// One cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number that was measured: six digits that count; empty when it is not finite.
    Number(f64),
    /// A number of things.
    Count(u64),
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<Option<f64>> for Cell {
    fn from(number: Option<f64>) -> Self {
        Self::Number(number.unwrap_or(f64::NAN))
    }
}

impl From<u32> for Cell {
    fn from(count: u32) -> Self {
        Self::Count(count.into())
    }
}

impl From<bool> for Cell {
    fn from(yes: bool) -> Self {
        Self::Text(if yes { "yes" } else { "no" }.to_owned())
    }
}

/// A row of a file.
pub trait Row {
    /// Names of the columns; a name ends in its unit.
    const COLUMNS: &'static [&'static str];

    /// What stands in them.
    fn cells(&self) -> Vec<Cell>;
}

/// The whole file.
///
/// # Panics
/// When a row has another number of cells than there are columns, or a comma in one.
#[must_use]
pub fn text<R: Row>(rows: &[R]) -> String {
    let mut text = R::COLUMNS.join(",");
    text.push('\n');
    for row in rows {
        let cells = row.cells();
        assert_eq!(cells.len(), R::COLUMNS.len(), "{cells:?}");
        let written: Vec<String> = cells.iter().map(written).collect();
        assert!(written.iter().all(|cell| !cell.contains(',')), "{written:?}");
        text.push_str(&written.join(","));
        text.push('\n');
    }
    text
}

fn written(cell: &Cell) -> String {
    let mut text = String::new();
    let done = match cell {
        Cell::Text(words) => write!(text, "{words}"),
        Cell::Count(count) => write!(text, "{count}"),
        Cell::Number(number) if !number.is_finite() => Ok(()),
        Cell::Number(number) => {
            let digits_before = if *number == 0.0 { 0.0 } else { number.abs().log10().floor() };
            write!(text, "{number:.*}", (5.0 - digits_before).clamp(0.0, 9.0) as usize)
        }
    };
    done.expect("writing to a string does not fail");
    text
}
