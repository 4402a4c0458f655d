//! What the window says, in the person's language.
//!
//! Owns the languages and their messages (`words/*.ftl`, in Project Fluent's syntax); knows no window.
//! Invariant: every language has every message with the same variables, which `tests/tests/house/words.rs` compares.

use fluent_bundle::{FluentArgs, FluentBundle, FluentResource, FluentValue};
use serde::{Deserialize, Serialize};
use unic_langid::LanguageIdentifier;

/// A language that the window speaks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Language {
    /// The original.
    #[default]
    English,
    /// Deutsch.
    German,
}

impl Language {
    /// All of them.
    pub(crate) const ALL: [Self; 2] = [Self::English, Self::German];

    /// What it calls itself.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::English => "English",
            Self::German => "Deutsch",
        }
    }

    /// The one that the system is set to, or English.
    pub(crate) fn of_system() -> Self {
        let is_german = sys_locale::get_locales().next().is_some_and(|locale| locale.starts_with("de"));
        if is_german { Self::German } else { Self::English }
    }

    const fn tag(self) -> &'static str {
        match self {
            Self::English => "en",
            Self::German => "de",
        }
    }

    const fn messages(self) -> &'static str {
        match self {
            Self::English => include_str!("words/en.ftl"),
            Self::German => include_str!("words/de.ftl"),
        }
    }
}

/// The messages of one language.
pub(crate) struct Words {
    language: Language,
    bundle: FluentBundle<FluentResource>,
}

impl Words {
    /// Reads a language's messages, which are part of the program.
    pub(crate) fn new(language: Language) -> Self {
        let tag: LanguageIdentifier = language.tag().parse().unwrap_or_default();
        let mut bundle = FluentBundle::new(vec![tag]);
        // all that is put in is digits and names, in the same direction of writing
        bundle.set_use_isolating(false);
        // what could be read is used; the tests hold the files to being read whole
        let resource = FluentResource::try_new(language.messages().to_owned()).unwrap_or_else(|(read, _)| read);
        bundle.add_resource_overriding(resource);
        Self { language, bundle }
    }

    /// Which language it is.
    pub(crate) const fn language(&self) -> Language {
        self.language
    }

    /// A message without variables.
    pub(crate) fn say(&self, message: &str) -> String {
        self.say_with(message, &[])
    }

    /// Keys as they are written on a keyboard of this language.
    pub(crate) fn keys(&self, keys: &str) -> String {
        keys.replace("Ctrl", &self.say("press-ctrl"))
    }

    /// A message with its variables put in.
    pub(crate) fn say_with(&self, message: &str, variables: &[(&str, &str)]) -> String {
        let mut arguments = FluentArgs::new();
        for (name, value) in variables {
            arguments.set(*name, FluentValue::from(*value));
        }
        let pattern = self.bundle.get_message(message).and_then(|message| message.value());
        let mut errors = Vec::new();
        pattern.map_or_else(
            || message.to_owned(),
            |pattern| self.bundle.format_pattern(pattern, Some(&arguments), &mut errors).into_owned(),
        )
    }

    /// A number with so many decimals, as the language writes it.
    pub(crate) fn number(&self, value: f64, decimals: usize) -> String {
        let text = format!("{value:.decimals$}");
        match self.language {
            Language::English => text,
            Language::German => text.replace('.', ","),
        }
    }

    /// A number as people of any language type it.
    pub(crate) fn parse(text: &str) -> Option<f64> {
        text.trim().replace(',', ".").parse().ok()
    }
}

impl std::fmt::Debug for Words {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Words").field("language", &self.language).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_language_is_read_whole() {
        for language in Language::ALL {
            assert!(FluentResource::try_new(language.messages().to_owned()).is_ok(), "{language:?}");
        }
    }

    #[test]
    fn numbers_are_written_as_the_language_does_and_read_in_either_way() {
        assert_eq!(Words::new(Language::German).number(0.274, 2), "0,27");
        assert_eq!(Words::new(Language::English).number(0.274, 2), "0.27");
        assert_eq!((Words::parse(" 1,5"), Words::parse("1.5"), Words::parse("x")), (Some(1.5), Some(1.5), None));
    }

    #[test]
    fn variables_are_put_in() {
        let words = Words::new(Language::English);
        assert_eq!(words.say_with("potter", &[("number", "3")]), "potter 3");
        assert_eq!(words.say("no-such-message"), "no-such-message");
    }
}
