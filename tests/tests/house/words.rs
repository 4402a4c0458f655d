//! What the window says: that every language says all of it, and that all that is said is known.
//!
//! Reads the messages and the source as texts; opens no window.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use pottery_client::render::Finish;
use pottery_shared::clay::{Form, Preset};
use pottery_shared::haptics::GuidanceMode;
use pottery_shared::protocol::Nickname;
use pottery_shared::tool::{Shape, rack};

fn studio() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../client/studio/src")
}

/// The messages of a language, each with its variables.
fn messages(language: &str) -> BTreeMap<String, BTreeSet<String>> {
    let path = studio().join("words").join(language).with_extension("ftl");
    let text = fs::read_to_string(&path).unwrap();
    let mut messages = BTreeMap::new();
    for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
        let (name, said) = line.split_once(" = ").unwrap_or_else(|| panic!("{}: {line:?}", path.display()));
        assert!(!said.trim().is_empty(), "{language}: {name} says nothing");
        let variables = said.split("{ $").skip(1).map(|rest| rest.split(' ').next().unwrap().to_owned()).collect();
        assert_eq!(said.matches('{').count(), said.matches("{ $").count(), "{language}: {name} has other braces");
        assert!(messages.insert(name.to_owned(), variables).is_none(), "{language}: {name} stands twice");
    }
    messages
}

fn sources(folder: &Path, into: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            into.push(fs::read_to_string(path).unwrap());
        }
    }
}

/// Names that are put together from what the core calls its things.
fn made_names() -> BTreeSet<String> {
    let finishes = Finish::ALL.map(|finish| format!("finish-{}", finish.name()));
    let clays = Preset::ALL.map(|preset| format!("clay-{}", preset.name()));
    let shapes = (0..rack::standard().len()).map(|number| Shape(number as u8).name().unwrap());
    let lesson = ["centre", "open", "pull", "shape"].map(|step| format!("lesson-{step}-how"));
    let forms = Form::ALL.map(|form| format!("form-{}", form.name()));
    let guidance =
        GuidanceMode::ALL.into_iter().flat_map(|mode| ["", "-hint"].map(|hint| format!("guide-{}{hint}", mode.name())));
    finishes
        .into_iter()
        .chain(forms)
        .chain(guidance)
        .chain(clays)
        .chain(shapes.map(|name| format!("tool-{name}")))
        .chain(lesson)
        .collect()
}

#[test]
fn every_language_has_every_message_with_the_same_variables() {
    let english = messages("en");
    assert!(english.len() > 100, "{}", english.len());
    let mut languages = 0;
    for entry in fs::read_dir(studio().join("words")).unwrap() {
        let path = entry.unwrap().path();
        let language = path.file_stem().unwrap().to_str().unwrap().to_owned();
        assert_eq!(messages(&language), english, "{language} against en");
        languages += 1;
    }
    assert!(languages >= 2, "English and one more");
}

#[test]
fn every_message_is_said_and_every_one_that_is_said_exists() {
    let english = messages("en");
    let mut texts = Vec::new();
    sources(&studio(), &mut texts);
    let made = made_names();
    for name in &made {
        assert!(english.contains_key(name), "{name} is put together and has no message");
    }
    for name in english.keys().filter(|name| !made.contains(*name)) {
        let literal = format!("\"{name}\"");
        assert!(texts.iter().any(|text| text.contains(&literal)), "nobody says {name}");
    }
    let mut said = 0;
    for text in &texts {
        // what the words' own tests say does not count
        let text = text.split("#[cfg(test)]").next().unwrap();
        for call in ["say(\"", "say_with(\""] {
            for rest in text.split(call).skip(1) {
                let name = rest.split('"').next().unwrap();
                assert!(english.contains_key(name), "{name} is said and has no message");
                said += 1;
            }
        }
    }
    assert!(said > 30, "{said}");
    // names in tables: whatever begins as messages do, in the window's own code
    let beginning = |name: &str| name.split_once('-').map(|(first, _)| first.to_owned());
    let known: BTreeSet<_> = english.keys().filter_map(|name| beginning(name)).collect();
    let mut window = Vec::new();
    sources(&studio().join("window"), &mut window);
    for text in &window {
        let text = text.split("#[cfg(test)]").next().unwrap();
        for literal in text.split('"').skip(1).step_by(2) {
            let is_name = literal.chars().all(|sign| sign.is_ascii_lowercase() || sign == '-');
            if is_name && !literal.ends_with('-') && beginning(literal).is_some_and(|first| known.contains(&first)) {
                assert!(english.contains_key(literal), "{literal} has no message");
            }
        }
    }
}

#[test]
fn every_language_has_a_word_of_its_own_for_everybody_there_can_be() {
    for entry in fs::read_dir(studio().join("words")).unwrap() {
        let path = entry.unwrap().path();
        let text = fs::read_to_string(&path).unwrap();
        let words = text.lines().find_map(|line| line.strip_prefix("nicknames = ")).unwrap();
        let words: Vec<_> = words.split(", ").collect();
        assert_eq!(words.len(), Nickname::WORDS.len(), "{}", path.display());
        assert_eq!(words.iter().collect::<BTreeSet<_>>().len(), words.len(), "{}: one stands twice", path.display());
        // a name is one word, so that it can stand in a line with others
        assert!(words.iter().all(|word| word.chars().all(char::is_alphabetic)), "{}", path.display());
        if path.file_stem().unwrap() == "en" {
            assert_eq!(words, Nickname::WORDS);
        }
    }
}
