//! How a room begins: with new pots, with one that was opened, or with those that were kept.
//!
//! Owns the choice; the room and the folder are others'.
//! Invariant: pots that were kept are gone on with or put aside, and never written over unseen.

use pottery_files::pot_file::PotFile;
use pottery_shared::clay::{Form, MethodKind, PotSpec, Support, Wheel};
use pottery_shared::protocol::JoinCode;
use pottery_shared::room::{Room, RoomConfig};
use pottery_shared::snapshot::PotRecord;

use crate::folder::Folder;
use crate::store::{Store, StoreError};
use crate::ticking::mark;
use crate::{ConfigError, ServerConfig, ServerError};

/// Opens the room of a configuration, with the folder that its pots are kept in, where there is one.
///
/// # Errors
/// [`ServerError`] saying what is in the way.
pub(crate) fn open(
    config: &ServerConfig,
    code: &JoinCode,
    folder: Option<Folder>,
) -> Result<(Room, Option<Store>), ServerError> {
    let mut room = RoomConfig {
        code: code.room().to_owned(),
        wheels: config.wheels,
        people_max: config.people_max,
        pot: config.pot,
        method: config.method,
        wheel_speed: config.wheel_speed,
        clay: config.clay,
    };
    let record = match (&config.opened, config.form) {
        (Some(record), _) => Some(PotRecord::clone(record)),
        (None, Form::Cylinder) => None,
        (None, form) => Some(PotRecord::of(&form.pot(config.pot).map_err(ConfigError::from)?)),
    };
    let asked = record.as_ref().map_or(config.pot, |record| *record.spec());
    let wheels = usize::from(config.wheels);
    let (folder, spare) = if config.data.is_some() { (folder, None) } else { (None, folder) };
    let Some(folder) = folder else {
        tell_stiff(&asked, config.method);
        let opened = match &record {
            Some(record) => Room::starting_from(room, record),
            None => Room::new(room),
        };
        let room = opened.map_err(ConfigError::from)?;
        let store = spare.map(|folder| Store::put_by(folder, wheels, |wheel| mark(&room, wheel))).transpose()?;
        return Ok((room, store));
    };
    let path = folder.path().to_path_buf();
    let (mut store, kept) = Store::open(folder, wheels, config.is_fresh)?;
    let method = kept.iter().flatten().map(PotFile::method).find(|method| *method != config.method);
    let kept = kept.into_iter().map(|kept| kept.map(|kept| (kept.pot().clone(), kept.clay(), kept.wheel_speed())));
    let mut records: Vec<_> = kept.collect();
    if let Some((first, ..)) = records.iter().flatten().next() {
        let spec = *first.spec();
        if let Some(wheel) =
            records.iter().position(|record| record.as_ref().is_some_and(|(other, ..)| *other.spec() != spec))
        {
            return Err(StoreError::Unlike { wheel: wheel + 1 }.into());
        }
        room.pot = spec;
        if config.opened.is_some() {
            return Err(StoreError::Opened { path }.into());
        }
        if let Some(words) = unlike(&asked, &spec) {
            tracing::warn!("{words}");
        }
        if let Some(method) = method {
            let (kept, now) = (method.name(), config.method.name());
            tracing::warn!("pots that were pressed with the {kept} method are gone on with by the {now} one");
        }
        let others = records.iter().flatten().filter(|(_, clay, _)| *clay != config.clay).count();
        let speeds = records
            .iter()
            .flatten()
            .filter(|(.., speed)| Wheel::rate_of(*speed) != Wheel::rate_of(config.wheel_speed))
            .count();
        if speeds > 0 {
            tracing::info!(
                wheels = speeds,
                "wheels with pots that were kept turn as they turned then, which is another speed than the settings' for new pots"
            );
        }
        if others > 0 {
            tracing::info!(
                pots = others,
                "pots that were kept are gone on with in the clay they had, which is other clay than the settings' for new pots"
            );
        }
    } else if record.is_some() {
        room.pot = asked;
    }
    tell_stiff(&room.pot, room.method);
    // wheels that have no pot of their own begin with what was asked for, where it is of the same make
    for empty in records.iter_mut().filter(|kept| kept.is_none()) {
        *empty = record
            .clone()
            .filter(|record| *record.spec() == room.pot)
            .map(|record| (record, config.clay, config.wheel_speed));
    }
    let room = Room::going_on_with(room, &records).map_err(ConfigError::from)?;
    store.know(|wheel| mark(&room, wheel));
    Ok((room, Some(store)))
}

/// Says where a wall could bend, and does not by the method that was chosen.
fn tell_stiff(pot: &PotSpec, method: MethodKind) {
    if pot.support == Support::Hollow && method != MethodKind::Plastic {
        let name = method.name();
        tracing::warn!(
            "a hollow pot's wall does not bend by the {name} method: choose the plastic method, or the support backed"
        );
    }
}

/// What is said where pots were kept that are of another make than what is asked for now; the kept ones go on as they are.
fn unlike(asked: &PotSpec, kept: &PotSpec) -> Option<String> {
    let make = |spec: &PotSpec| {
        let [height, radius, wall] = [spec.height, spec.radius, spec.wall].map(|length| length.as_mm());
        let (columns, rows) = (spec.shape.columns(), spec.shape.rows());
        let support = spec.support.name();
        format!(
            "{support}, {height:.1} mm high, {radius:.1} mm in radius, with a wall of {wall:.1} mm, on {columns} × {rows} elements"
        )
    };
    let [asked, kept] = [asked, kept].map(make);
    (asked != kept).then(|| {
        format!(
            "the pots that were kept are gone on with as they are: {kept}. What the settings say is for new pots alone (--fresh): {asked}"
        )
    })
}
