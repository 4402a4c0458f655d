//! What a program says of flags that make no sense: which numbers it takes, and one sentence in the place of several lines.
//!
//! Owns those words; which flags there are, and what they are for, is the programs' affair.
//! Invariant: whoever gives a number that is not taken is told those that are.

use std::fmt::Display;
use std::str::FromStr;

/// How a number from `least` to `most` is read.
///
/// ```
/// use pottery_files::flags::number_from;
///
/// let potters = number_from(1_u16, 16);
/// assert_eq!(potters("3"), Ok(3));
/// for text in ["0", "-1", "17", "99999999999", "2.5", "many"] {
///     assert_eq!(potters(text).unwrap_err(), "choose a number from 1 to 16");
/// }
/// let radius_mm = number_from(0.5_f32, 40.0);
/// assert_eq!(radius_mm("nan").unwrap_err(), "choose a number from 0.5 to 40");
/// ```
pub fn number_from<T>(least: T, most: T) -> impl Fn(&str) -> Result<T, String> + Clone
where
    T: Clone + Display + FromStr + PartialOrd,
{
    move |text| {
        let number = text.parse().ok().filter(|number| (&least..=&most).contains(&number));
        number.ok_or_else(|| format!("choose a number from {least} to {most}"))
    }
}

/// What the reader of a command line says is wrong, without its usage and tips, of a program that has such commands: a word that is none of
/// them is said to be none, and not to be out of place beside a flag.
///
/// ```
/// use pottery_files::flags::first_sentence;
///
/// let commands = || ["knee", "soak"].into_iter();
/// let said = "error: these are missing:\n  --out <DIR>\n\nUsage: chart --out <DIR>\n";
/// assert_eq!(first_sentence(said, commands()), "these are missing: --out <DIR> (see --help)");
/// let beside = |word: &str| format!("error: the subcommand '{word}' cannot be used with '--spawn'\n");
/// assert_eq!(first_sentence(&beside("kne"), commands()), "unrecognized subcommand 'kne' (see --help)");
/// assert!(first_sentence(&beside("knee"), commands()).contains("cannot be used with"));
/// ```
#[must_use]
pub fn first_sentence<'a>(said: &str, mut commands: impl Iterator<Item = &'a str>) -> String {
    let lines = said.lines().take_while(|line| !line.trim().is_empty()).map(str::trim);
    let joined = lines.collect::<Vec<_>>().join(" ");
    let sentence = joined.strip_prefix("error: ").unwrap_or(&joined);
    let word = sentence.strip_prefix("the subcommand '").and_then(|rest| rest.split('\'').next());
    match word.filter(|word| !commands.any(|command| command == *word)) {
        Some(word) => format!("unrecognized subcommand '{word}' (see --help)"),
        None => format!("{sentence} (see --help)"),
    }
}
