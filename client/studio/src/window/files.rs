//! Saving, exporting and opening from the window: which file, the controls for it, and what came of it.
//!
//! Owns the thread that reads and writes; the pot is copied for it, so that the picture goes on meanwhile.
//! Invariant: one file is read or written at a time, none that was there before is written without being asked twice, and none is given
//! up when the window closes.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;

use egui::RichText;
use pottery_client::export::{Format, export};
use pottery_client::pot_file::PotFile;
use pottery_client::sentence;
use pottery_shared::session::fitted;
use pottery_shared::snapshot::PotRecord;

use crate::words::{Language, Words};

/// What the person asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wish {
    Save,
    Export,
    /// Put the pot of the file on the wheel.
    Open,
    /// The same with the pot that was left.
    OpenLast,
}

impl Wish {
    const fn writes(self) -> bool {
        matches!(self, Self::Save | Self::Export)
    }
}

/// What came of a wish.
#[derive(Clone, Debug)]
enum Outcome {
    Written(PathBuf),
    /// The pot of this file is to be put on the wheel.
    Opened(PathBuf, Arc<PotRecord>),
    /// There is a file of that name.
    Taken(PathBuf),
    /// What is in the way, in a sentence.
    Refused(String),
    /// No file is named.
    Nameless,
    /// The thread did not come to an end.
    Lost,
    NoThread(String),
}

impl Outcome {
    const fn is_trouble(&self) -> bool {
        !matches!(self, Self::Written(_) | Self::Opened(..))
    }

    fn said(&self, words: &Words) -> String {
        let of = |path: &Path| path.display().to_string();
        match self {
            Self::Written(path) => words.say_with("written", &[("path", &of(path))]),
            Self::Opened(path, _) => words.say_with("opened", &[("path", &of(path))]),
            Self::Taken(path) => words.say_with("replace", &[("path", &of(path))]),
            Self::Refused(sentence) => sentence.clone(),
            Self::Nameless => words.say("no-name"),
            Self::Lost => words.say("not-written"),
            Self::NoThread(reason) => words.say_with("no-thread", &[("reason", reason)]),
        }
    }
}

/// The files of one window.
pub(super) struct Files {
    /// The pot file, as the person may type it; exports lie beside it.
    path: String,
    format: Format,
    wish: Option<Wish>,
    working: Option<JoinHandle<Outcome>>,
    outcome: Option<Outcome>,
    /// What may be replaced: opened or written here, or asked for twice.
    replaceable: Vec<PathBuf>,
    /// A pot that was read and is to be put on the wheel.
    opened: Option<Arc<PotRecord>>,
    /// The pot that was on the wheel when an earlier window was left.
    last: Option<PathBuf>,
}

impl Files {
    /// Begins with the pot that was opened, or with a new name in the person's folder for documents; `last` is the pot that was left.
    pub(super) fn new(opened: Option<&Path>, last: Option<PathBuf>) -> Self {
        let path = opened.map_or_else(unused_name, Path::to_path_buf);
        Self {
            path: path.display().to_string(),
            format: Format::Stl,
            wish: None,
            working: None,
            outcome: None,
            replaceable: opened.map(Path::to_path_buf).into_iter().collect(),
            opened: None,
            last,
        }
    }

    /// The pot file that is named, as it would be opened.
    pub(super) fn path(&self) -> PathBuf {
        self.target(Wish::Open)
    }

    pub(super) fn save(&mut self) {
        self.wish = Some(Wish::Save);
    }

    pub(super) fn export(&mut self) {
        self.wish = Some(Wish::Export);
    }

    pub(super) fn open(&mut self) {
        self.wish = Some(Wish::Open);
    }

    /// A pot that was opened, to be put on the wheel; once.
    pub(super) fn take_opened(&mut self) -> Option<Arc<PotRecord>> {
        self.opened.take()
    }

    /// Lays out the controls.
    pub(super) fn show(&mut self, ui: &mut egui::Ui, words: &Words) {
        ui.label(RichText::new(words.say("pot-file")).small());
        if ui.add(egui::TextEdit::singleline(&mut self.path).desired_width(f32::INFINITY)).changed() {
            // what was asked for twice was asked of another name
            self.replaceable.clear();
            // and whoever types an ending means it
            self.format = Format::of(Path::new(&self.path)).unwrap_or(self.format);
        }
        ui.horizontal(|ui| {
            if ui.button(words.say("save")).clicked() {
                self.save();
            }
            if ui.button(words.say("open")).on_hover_text(words.say("open-hint")).clicked() {
                self.open();
            }
            if ui.button(words.say("export-as")).clicked() {
                self.export();
            }
            egui::ComboBox::from_id_salt("format").width(60.0).selected_text(self.format.ending()).show_ui(ui, |ui| {
                for format in Format::ALL {
                    ui.selectable_value(&mut self.format, format, format.ending());
                }
            });
        });
        if self.last.is_some() && ui.button(words.say("open-last")).on_hover_text(words.say("open-hint")).clicked() {
            self.wish = Some(Wish::OpenLast);
        }
        let said = match (&self.working, &self.outcome) {
            (Some(_), _) => RichText::new(words.say("file-busy")),
            (None, Some(outcome)) if outcome.is_trouble() => {
                RichText::new(outcome.said(words)).color(ui.visuals().error_fg_color)
            }
            (None, Some(outcome)) => RichText::new(outcome.said(words)),
            (None, None) => return,
        };
        ui.label(said.small());
    }

    /// Takes in what came of the last wish and begins with the next; `take` copies the pot.
    pub(super) fn pass(&mut self, take: impl FnOnce() -> PotFile) {
        if self.working.as_ref().is_some_and(JoinHandle::is_finished) {
            self.wait();
        }
        if self.working.is_some() {
            return;
        }
        let Some(wish) = self.wish.take() else { return };
        let path = self.target(wish);
        if path.file_name().is_none() {
            self.outcome = Some(Outcome::Nameless);
            return;
        }
        if wish.writes() && path.exists() && !self.replaceable.contains(&path) {
            self.outcome = Some(Outcome::Taken(path.clone()));
            self.replaceable.push(path);
            return;
        }
        if wish.writes() {
            self.replaceable.push(path.clone());
        }
        let pot = take();
        let working = std::thread::Builder::new().name("files".into()).spawn(move || work(wish, &pot, &path));
        match working {
            Ok(thread) => self.working = Some(thread),
            Err(error) => self.outcome = Some(Outcome::NoThread(error.to_string())),
        }
    }

    /// Where a wish leads: the path as typed, with the ending of its form; as it is, where a pot was opened or is to be opened under that name.
    fn target(&self, wish: Wish) -> PathBuf {
        let path = PathBuf::from(self.path.trim());
        match wish {
            Wish::OpenLast => self.last.clone().unwrap_or_default(),
            Wish::Save if self.replaceable.contains(&path) => path,
            Wish::Open if path.is_file() => path,
            Wish::Save | Wish::Open => with_ending(&path, "pot"),
            Wish::Export => with_ending(&path, self.format.ending()),
        }
    }

    fn wait(&mut self) {
        if let Some(thread) = self.working.take() {
            let outcome = thread.join().unwrap_or(Outcome::Lost);
            if let Outcome::Opened(path, record) = &outcome {
                if self.last.as_ref() != Some(path) {
                    self.replaceable.push(path.clone());
                }
                self.opened = Some(Arc::clone(record));
            }
            self.outcome = Some(outcome);
        }
    }
}

impl Drop for Files {
    fn drop(&mut self) {
        self.wait();
        if let Some(outcome) = self.outcome.as_ref().filter(|outcome| outcome.is_trouble()) {
            note!("{}", outcome.said(&Words::new(Language::English)));
        }
    }
}

fn work(wish: Wish, pot: &PotFile, path: &Path) -> Outcome {
    let written = || Outcome::Written(path.to_path_buf());
    let came = match wish {
        Wish::Save => pot.write(path).map(|()| written()).map_err(|error| sentence(&error)),
        Wish::Export => export(&pot.pot().pot(), path).map(|()| written()).map_err(|error| sentence(&error)),
        Wish::Open | Wish::OpenLast => PotFile::read(path).map_err(|error| sentence(&error)).and_then(|file| {
            let record = fitted(file.pot(), pot.pot().spec()).map_err(|error| error.to_string())?;
            Ok(Outcome::Opened(path.to_path_buf(), Arc::new(record)))
        }),
    };
    came.unwrap_or_else(Outcome::Refused)
}

/// The path with that ending, in the place of one that is known: what else follows a point belongs to the name.
fn with_ending(path: &Path, ending: &str) -> PathBuf {
    let is_known = |written: &str| {
        let mut known = Format::ALL.iter().map(|format| format.ending()).chain(["pot"]);
        known.any(|known| known.eq_ignore_ascii_case(written))
    };
    let Some(name) = path.file_name() else { return path.to_path_buf() };
    match path.extension().and_then(|written| written.to_str()) {
        Some(written) if written.eq_ignore_ascii_case(ending) => path.to_path_buf(),
        Some(written) if is_known(written) => path.with_extension(ending),
        _ => {
            let mut name = name.to_os_string();
            name.push(format!(".{ending}"));
            path.with_file_name(name)
        }
    }
}

/// A name in the person's folder for documents that nothing has yet.
fn unused_name() -> PathBuf {
    let folder = dirs::document_dir().or_else(dirs::home_dir).unwrap_or_default();
    let name = |number: u32| folder.join(if number == 1 { "pot.pot".into() } else { format!("pot-{number}.pot") });
    (1..).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_follows_a_point_of_a_name_is_no_ending() {
        for (typed, save, solid) in [
            ("vase", "vase.pot", "vase.stl"),
            ("vase 2.1", "vase 2.1.pot", "vase 2.1.stl"),
            ("vase.pot", "vase.pot", "vase.stl"),
            ("bowls/vase.POT", "bowls/vase.POT", "bowls/vase.stl"),
            ("vase.stl", "vase.pot", "vase.stl"),
            ("", "", ""),
        ] {
            let mut files = Files::new(None, None);
            files.path = format!(" {typed} ");
            assert_eq!(files.target(Wish::Save), PathBuf::from(save));
            assert_eq!(files.target(Wish::Export), PathBuf::from(solid));
            assert_eq!(files.path(), PathBuf::from(save));
        }
        // a pot that was opened is saved where it was
        let opened = Files::new(Some(Path::new("vase.bak")), None);
        assert_eq!(opened.target(Wish::Save), PathBuf::from("vase.bak"));
        assert_eq!(opened.target(Wish::Export), PathBuf::from("vase.bak.stl"));
    }
}
