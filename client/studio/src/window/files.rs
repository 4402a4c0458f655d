//! Saving and exporting from the window: where to, the controls for it, and what came of it.
//!
//! Owns the thread that writes; the pot is copied for it, so that the picture goes on meanwhile.
//! Invariant: one file is written at a time, none that was there before without being asked twice, and none is given up
//! when the window closes.

use std::path::{Path, PathBuf};
use std::thread::JoinHandle;

use egui::RichText;
use pottery_client::export::{Format, export};
use pottery_client::pot_file::PotFile;

use crate::words::{Language, Words};

/// What the person asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wish {
    Save,
    Export,
}

/// What came of a wish.
#[derive(Clone, Debug)]
enum Outcome {
    Written(PathBuf),
    /// There is a file of that name.
    Taken(PathBuf),
    /// What is in the way, in a sentence.
    Refused(String),
    /// The thread did not come to an end.
    Lost,
    NoThread(String),
}

impl Outcome {
    const fn is_trouble(&self) -> bool {
        !matches!(self, Self::Written(_))
    }

    fn said(&self, words: &Words) -> String {
        let of = |path: &Path| path.display().to_string();
        match self {
            Self::Written(path) => words.say_with("written", &[("path", &of(path))]),
            Self::Taken(path) => words.say_with("replace", &[("path", &of(path))]),
            Self::Refused(sentence) => sentence.clone(),
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
    writing: Option<JoinHandle<Outcome>>,
    outcome: Option<Outcome>,
    /// What may be replaced: opened or written here, or asked for twice.
    replaceable: Vec<PathBuf>,
}

impl Files {
    /// Begins with the pot that was opened, or with a new name in the person's folder for documents.
    pub(super) fn new(opened: Option<&Path>) -> Self {
        let path = opened.map_or_else(unused_name, Path::to_path_buf);
        Self {
            path: path.display().to_string(),
            format: Format::Stl,
            wish: None,
            writing: None,
            outcome: None,
            replaceable: opened.map(Path::to_path_buf).into_iter().collect(),
        }
    }

    /// The pot file that is named.
    pub(super) fn path(&self) -> &Path {
        Path::new(&self.path)
    }

    pub(super) fn save(&mut self) {
        self.wish = Some(Wish::Save);
    }

    pub(super) fn export(&mut self) {
        self.wish = Some(Wish::Export);
    }

    /// Lays out the controls.
    pub(super) fn show(&mut self, ui: &mut egui::Ui, words: &Words) {
        ui.label(RichText::new(words.say("pot-file")).small());
        ui.add(egui::TextEdit::singleline(&mut self.path).desired_width(f32::INFINITY));
        ui.horizontal(|ui| {
            if ui.button(words.say("save")).clicked() {
                self.save();
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
        let said = match (&self.writing, &self.outcome) {
            (Some(_), _) => RichText::new(words.say("writing")),
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
        if self.writing.as_ref().is_some_and(JoinHandle::is_finished) {
            self.wait();
        }
        if self.writing.is_some() {
            return;
        }
        let Some(wish) = self.wish.take() else { return };
        let path = self.target(wish);
        if path.exists() && !self.replaceable.contains(&path) {
            self.outcome = Some(Outcome::Taken(path.clone()));
            self.replaceable.push(path);
            return;
        }
        self.replaceable.push(path.clone());
        let pot = take();
        let written = std::thread::Builder::new().name("files".into()).spawn(move || write(wish, &pot, &path));
        match written {
            Ok(thread) => self.writing = Some(thread),
            Err(error) => self.outcome = Some(Outcome::NoThread(error.to_string())),
        }
    }

    /// Where a wish leads: the path as typed, with the ending of its form.
    fn target(&self, wish: Wish) -> PathBuf {
        let path = PathBuf::from(self.path.trim());
        match wish {
            Wish::Save if path.extension().is_some() => path,
            Wish::Save => path.with_extension("pot"),
            Wish::Export => path.with_extension(self.format.ending()),
        }
    }

    fn wait(&mut self) {
        if let Some(thread) = self.writing.take() {
            self.outcome = Some(thread.join().unwrap_or(Outcome::Lost));
        }
    }
}

impl Drop for Files {
    fn drop(&mut self) {
        self.wait();
        if let Some(outcome) = self.outcome.as_ref().filter(|outcome| outcome.is_trouble()) {
            eprintln!("pottery-studio: {}", outcome.said(&Words::new(Language::English)));
        }
    }
}

fn write(wish: Wish, pot: &PotFile, path: &Path) -> Outcome {
    let written = match wish {
        Wish::Save => pot.write(path).map_err(|error| error.to_string()),
        Wish::Export => export(&pot.pot().pot(), path).map_err(|error| error.to_string()),
    };
    written.map_or_else(Outcome::Refused, |()| Outcome::Written(path.to_path_buf()))
}

/// A name in the person's folder for documents that nothing has yet.
fn unused_name() -> PathBuf {
    let folder = dirs::document_dir().or_else(dirs::home_dir).unwrap_or_default();
    let name = |number: u32| folder.join(if number == 1 { "pot.pot".into() } else { format!("pot-{number}.pot") });
    (1..).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(1))
}
