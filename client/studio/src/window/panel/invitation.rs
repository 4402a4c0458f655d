//! How others join: address and code to read out, a command and a link to copy, and a code for a camera.
//!
//! Owns its layout; what is in the link is the client library's.
//! Invariant: address, code, link and picture say the same.

use std::net::SocketAddr;

use egui::{Color32, Rect, RichText, Vec2, pos2, vec2};
use pottery_client::{Link, Target};
use pottery_shared::protocol::JoinCode;
use qrcode::{Color, QrCode};

use crate::words::Words;

/// White modules round a code for cameras, as ISO/IEC 18004 wants them.
const QUIET: usize = 4;
/// Width of a module, points.
const MODULE: f32 = 5.0;

/// What others need to join.
#[derive(Debug)]
pub(in crate::window) struct Invitation {
    address: String,
    code: String,
    link: String,
    qr: Option<Modules>,
}

/// The modules of a code for cameras, row by row: which are dark.
#[derive(Debug)]
struct Modules {
    width: usize,
    dark: Vec<bool>,
}

impl Invitation {
    pub(in crate::window) fn new(address: SocketAddr, code: &JoinCode) -> Self {
        let target = Target::new(address.to_string(), code.clone(), 1);
        let link = Link(target).to_string();
        // a link is short enough for any code; without one there is still the link
        let qr = QrCode::new(&link).ok().map(|code| Modules {
            width: code.width(),
            dark: code.to_colors().iter().map(|colour| *colour == Color::Dark).collect(),
        });
        Self { address: address.to_string(), code: code.to_string(), link, qr }
    }

    /// Takes in the room's part of the code, which a teacher may have changed.
    pub(in crate::window) fn follow(&mut self, room: &str) {
        let (letters, length) = (self.code.replace('-', ""), room.len());
        if letters.starts_with(room) || letters.len() < length {
            return;
        }
        // the server, which the rest of the letters name, is the same
        if let (Ok(code), Ok(address)) = (format!("{room}{}", &letters[length..]).parse(), self.address.parse()) {
            *self = Self::new(address, &code);
        }
    }

    /// The command for another machine.
    pub(in crate::window) fn command(&self) -> String {
        format!("pottery-studio join {} --code {}", self.address, self.code)
    }

    /// Lays it out.
    pub(super) fn show(&self, ui: &mut egui::Ui, words: &Words) {
        ui.label(RichText::new(words.say("others-join")).small());
        ui.label(RichText::new(words.say_with("address", &[("address", &self.address)])).monospace());
        ui.label(RichText::new(words.say("code")).monospace());
        ui.label(RichText::new(&self.code).monospace().strong());
        ui.horizontal(|ui| {
            if ui.button(words.say("copy-command")).clicked() {
                ui.ctx().copy_text(self.command());
            }
            if ui.button(words.say("copy-link")).clicked() {
                ui.ctx().copy_text(self.link.clone());
            }
        });
        if let Some(qr) = &self.qr {
            egui::CollapsingHeader::new(words.say("qr-code")).id_salt("qr").show(ui, |ui| paint(ui, qr));
        }
    }
}

fn paint(ui: &mut egui::Ui, qr: &Modules) {
    let modules = qr.width + 2 * QUIET;
    let (response, painter) = ui.allocate_painter(Vec2::splat(modules as f32 * MODULE), egui::Sense::hover());
    let corner = response.rect.min;
    // black on white in either look: some cameras read nothing else
    painter.rect_filled(response.rect, 0.0, Color32::WHITE);
    for (at, _) in qr.dark.iter().enumerate().filter(|(_, is_dark)| **is_dark) {
        let (x, y) = (at % qr.width + QUIET, at / qr.width + QUIET);
        let min = pos2(corner.x + x as f32 * MODULE, corner.y + y as f32 * MODULE);
        painter.rect_filled(Rect::from_min_size(min, vec2(MODULE, MODULE)), 0.0, Color32::BLACK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_invitation_is_one_target_in_three_forms() {
        let code = JoinCode::new([1, 2, 3, 4, 5], &[7; 32]);
        let invitation = Invitation::new(SocketAddr::from(([192, 168, 1, 20], 4747)), &code);
        let link: Link = invitation.link.parse().expect("it is a link");
        assert_eq!((link.0.address.as_str(), &link.0.code), ("192.168.1.20:4747", &code));
        assert!(invitation.command().ends_with(&format!("join 192.168.1.20:4747 --code {code}")));
        assert!(invitation.qr.is_some());
        let mut followed = Invitation::new(SocketAddr::from(([192, 168, 1, 20], 4747)), &code);
        followed.follow("K7QM3XPD");
        let link: Link = followed.link.parse().expect("it is a link");
        assert_eq!((link.0.code.room(), link.0.code.print()), ("K7QM3XPD", code.print()));
    }
}
