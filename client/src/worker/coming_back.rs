//! Coming back to a wheel: to the own seat when the line broke, to another one when the teacher says so.
//!
//! Owns what becomes of hand, view and session meanwhile; the tries are the way back's.
//! Invariant: meanwhile the tool is lifted, what the hand made is not pressed afterwards, and the clay of before is seen until the first of
//! the new connection is whole.

use pottery_shared::session::{ClassEvent, Client, ClientError, ClientEvent};
use pottery_shared::snapshot::TileLayout;
use pottery_shared::units::Tick;
use tokio::time::Instant;

use super::{Command, Worker};
use crate::connection::Joined;
use crate::remote_hands::RemoteHands;
use crate::view::Link;
use crate::way_back::hear_the_rest;

impl Worker {
    /// Takes in what was told of the lesson.
    pub(super) fn hear_of_class(&mut self, event: ClassEvent) {
        let class = self.session.class();
        let mut view = self.view.lock();
        match event {
            ClassEvent::Place => {
                self.way_back.note_place(class);
                self.side.status().hold(self.is_coming || !class.may_press());
            }
            ClassEvent::Come => {
                self.way_back.note_call();
                self.side.status().hold(true);
            }
            ClassEvent::NoOrder(reason) => view.no_order = Some(reason),
            ClassEvent::People | ClassEvent::Class | ClassEvent::Progress => {}
        }
        view.class.clone_from(class);
    }

    /// Comes back after the connection ended so; how it stands when that cannot be.
    pub(super) async fn come_back(&mut self, link: Link) -> Result<(), Link> {
        if self.leaving.is_some() {
            // nobody is there to come back, and the seat is given up when the line has been still for long enough
            return Err(link);
        }
        self.is_coming = true;
        self.side.status().hold(true);
        let session = &mut self.session;
        hear_the_rest(&mut self.arriving, |frame| session.handle_control(frame).is_ok()).await;
        while let Some(event) = self.session.poll_event() {
            if let ClientEvent::Class(event) = event {
                self.hear_of_class(event);
            }
        }
        let way = self.way_back.begin(link)?;
        self.view.lock().link = Link::ComingBack(way.0.clone());
        let (epoch, commands) = (self.epoch, &mut self.commands);
        let open = |answer: &[u8], measured| Client::open(answer, epoch.elapsed().as_millis() as u64, measured);
        let view = self.view.clone();
        let tell = |link| view.lock().link = link;
        let (joined, session) = tokio::select! {
            biased;
            found = self.way_back.knock(way, self.connection.rtt(), open, tell) => found?,
            // what else is asked for meanwhile is asked of nobody
            () = async { while !matches!(commands.recv().await, Some(Command::Leave) | None) {} } => {
                return Err(Link::Closed);
            }
        };
        self.sit_down(joined, session)
    }

    /// Goes on with a new connection, at the wheel that it leads to.
    fn sit_down(&mut self, joined: Joined, session: Client) -> Result<(), Link> {
        let before = self.session.predicted().spec().shape;
        if session.predicted().spec().shape != before {
            joined.connection.close(0, b"");
            return Err(Link::Lost(ClientError::Otherwise.to_string()));
        }
        self.add_counts();
        (self.connection, self.outgoing) = (joined.connection, joined.streams.outgoing);
        self.arriving = joined.streams.arriving;
        self.session = session;
        self.heard_at = Instant::now();
        self.guiding.forget(&mut self.side, &self.view);
        self.way_back.note_return();
        // a server that has begun anew may count from less, and what the one before told is then newer for good
        self.hands = RemoteHands::default();
        self.side.status().set_tick_offset(self.session.tick_offset());
        self.side.status().begin_session();
        Ok(())
    }

    /// Shows the new connection's clay, and gives it to the hand, once it is whole; whether it is.
    pub(super) fn arrive(&mut self) -> bool {
        // a lifted tool has nothing to be confirmed, so that it is settled once it holds the newest that it has heard of
        if self.session.tools_tick() == Tick(0) || !self.session.is_settled() {
            return false;
        }
        self.is_coming = false;
        self.throw_samples_away();
        self.side.publish(|patch| self.session.patch_into(patch));
        self.side.status().hold(!self.session.class().may_press());
        let mut view = self.view.lock();
        let view = &mut *view;
        let mut all = view.changed.emptied();
        for (number, surface) in self.session.predicted().surfaces().iter().enumerate() {
            for tile in 0..TileLayout::new(surface.shape()).tiles() {
                all.add(number, tile);
            }
        }
        self.session.take_changed(&mut all);
        for (surface, _, window) in all.iter() {
            view.pot.copy_window(self.session.predicted(), surface, window);
        }
        view.picture.correct(&view.pot, &all);
        view.picture.draw(&view.pot, &all, self.epoch.elapsed(), &mut view.changed);
        view.number = self.session.number();
        view.rack = self.session.rack();
        // what is as it is at first is not told
        view.steps = *self.session.steps();
        view.guidance.target = self.session.guidance().target().cloned();
        (view.link, view.is_whole) = (Link::Open, true);
        true
    }
}
