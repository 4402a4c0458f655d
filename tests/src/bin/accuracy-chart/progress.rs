//! What is shown of a long measurement: a bar where somebody looks, and lines where nobody does.
//!
//! Owns the bar; measures nothing.
//! Invariant: nothing of it goes to the standard output.

use std::cell::Cell;
use std::io::IsTerminal;
use std::time::Instant;

use indicatif::style::TemplateError;
use indicatif::{ProgressBar, ProgressStyle};
use pottery_tests::chart::progress::{Piece, Progress};
use pottery_tests::printed::remark;

/// Does a measurement and shows how far it is.
pub(crate) fn shown<T>(begin: Instant, measure: impl FnOnce(&mut Progress<'_>) -> T) -> Result<T, TemplateError> {
    if std::io::stderr().is_terminal() {
        let bar = ProgressBar::new(0).with_style(ProgressStyle::with_template("{bar:30} {pos}/{len}  {wide_msg}")?);
        let told = |piece: &Piece<'_>| {
            bar.set_length(piece.of.into());
            bar.set_position(piece.done.into());
            bar.set_message(piece.what.to_owned());
        };
        let measured = measure(&mut Progress::new(told));
        bar.finish_and_clear();
        return Ok(measured);
    }
    let next = Cell::new(0);
    let told = |piece: &Piece<'_>| {
        // a line for every tenth of the way
        if piece.done * 10 >= next.get() * piece.of {
            remark(format_args!(
                "{:>3.0} s  {}/{}  {}",
                begin.elapsed().as_secs_f64(),
                piece.done,
                piece.of,
                piece.what
            ));
            next.set(piece.done * 10 / piece.of + 1);
        }
    };
    Ok(measure(&mut Progress::new(told)))
}
