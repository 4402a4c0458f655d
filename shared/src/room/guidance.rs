//! Who guides whose hand, and what everybody's pot is to become.
//!
//! Owns the leads and the target; whoever asks has been found to have the right to. What is felt is the student's own affair.
//! Invariant: a student has at most one teacher and a teacher at most one student, both are connected and at a wheel, and both have
//! been told.

use alloc::vec::Vec;

use super::progress::Progress;
use super::{Lane, PeerId, Room, Transmit};
use crate::protocol::{
    GuidanceEnd, GuidanceWire, HandWire, LeadWire, NoGuidance, Notice, Request, Role, ShapeWire, TargetWire,
};
use crate::session::{Peer, guidance_of, target_of};
use crate::tool::{Sphere, rack};

/// A teacher's hand on a student's.
#[derive(Clone, Copy, Debug)]
struct Lead {
    teacher: PeerId,
    student: PeerId,
}

/// Everything of the kind in a room.
#[derive(Debug, Default)]
pub(super) struct Leads {
    leads: Vec<Lead>,
    pub(super) target: Option<TargetWire>,
    pub(super) progress: Progress,
}

impl Room {
    /// Answers a request about guidance, of somebody who may make it.
    pub(super) fn hear_of_guidance(&mut self, peer: PeerId, client: u16, request: Request) {
        let now = self.now;
        if !self.people.person_mut(client).is_some_and(|person| person.allowance.grant(now, 1)) {
            self.counts.forbidden += 1;
            return;
        }
        let outcome = match request {
            Request::Guide { student, guidance } => self.guide(peer, client, student, guidance),
            Request::EndGuidance => {
                let ends = |lead: &Lead| (lead.student == peer).then_some(GuidanceEnd::Student);
                self.end_leads(|lead| ends(lead).or_else(|| (lead.teacher == peer).then_some(GuidanceEnd::Teacher)));
                Ok(())
            }
            Request::Target(target) => self.set_target(target),
            _ => Ok(()),
        };
        if let Err(reason) = outcome {
            self.send(peer, Lane::Control(Peer::notice(&Notice::NoGuidance(reason))));
        }
    }

    fn guide(&mut self, peer: PeerId, client: u16, student: u16, guidance: GuidanceWire) -> Result<(), NoGuidance> {
        guidance_of(guidance).ok_or(NoGuidance::Unknown)?;
        if student == client {
            return Err(NoGuidance::Oneself);
        }
        self.places.get(&peer).ok_or(NoGuidance::NoHand)?;
        let person = self.people.person(student).filter(|person| person.role == Role::Student);
        let other = person
            .and_then(|person| person.peer)
            .filter(|other| self.places.contains_key(other))
            .ok_or(NoGuidance::Nobody)?;
        self.end_leads(|lead| {
            let is_same = lead.teacher == peer && lead.student == other;
            let shares = [lead.teacher, lead.student].iter().any(|one| *one == peer || *one == other);
            (shares && !is_same).then_some(GuidanceEnd::Replaced)
        });
        let wire = LeadWire { teacher: client, student, guidance };
        self.guidance.leads.retain(|lead| lead.teacher != peer);
        self.guidance.leads.push(Lead { teacher: peer, student: other });
        for to in [peer, other] {
            self.send(to, Lane::Control(Peer::notice(&Notice::Guidance(wire))));
        }
        Ok(())
    }

    /// Ends the leads for which there is a reason, and tells both of each.
    fn end_leads(&mut self, reason: impl Fn(&Lead) -> Option<GuidanceEnd>) {
        let mut ended = Vec::new();
        self.guidance.leads.retain(|lead| {
            let why = reason(lead);
            ended.extend(why.map(|why| (*lead, why)));
            why.is_none()
        });
        for (Lead { teacher, student }, why) in ended {
            let notice = Peer::notice(&Notice::GuidanceEnded(why));
            for to in [teacher, student].into_iter().filter(|to| self.places.contains_key(to)) {
                self.outbox.push_back(Transmit { to, lane: Lane::Control(notice.clone()) });
            }
            if let Some(bench) = self.places.get(&student).map(|place| &mut self.benches[*place]) {
                bench.show_hand(student, None);
            }
        }
    }

    /// Ends what somebody took part in who is not there any more.
    pub(super) fn end_leads_of(&mut self, peer: PeerId) {
        self.end_leads(|lead| (lead.teacher == peer || lead.student == peer).then_some(GuidanceEnd::Gone));
    }

    fn set_target(&mut self, target: Option<TargetWire>) -> Result<(), NoGuidance> {
        if target.as_ref().is_some_and(|target| target_of(target).is_none()) {
            return Err(NoGuidance::Unknown);
        }
        self.guidance.target = target;
        self.begin_progress();
        let everybody: Vec<_> = self.people.here().map(|(_, _, peer)| peer).collect();
        for to in everybody {
            self.tell_target(to);
        }
        Ok(())
    }

    /// Tells somebody who works or looks on what the pots are to become.
    pub(super) fn tell_target(&mut self, to: PeerId) {
        let notice = Peer::notice(&Notice::Target(self.guidance.target.clone()));
        self.send(to, Lane::Control(notice));
    }

    /// Whether pots are to become something.
    pub(super) const fn has_target(&self) -> bool {
        self.guidance.target.is_some()
    }

    /// Passes every teacher's hand on to the student, with the next pulse.
    pub(super) fn relay_hands(&mut self) {
        for at in 0..self.guidance.leads.len() {
            let Lead { teacher, student } = self.guidance.leads[at];
            let (Some(&from), Some(&to)) = (self.places.get(&teacher), self.places.get(&student)) else { continue };
            let hand = self.benches[from].hand(teacher).map(|hand| if from == to { hand } else { elsewhere(hand) });
            self.benches[to].show_hand(student, hand);
        }
    }
}

/// A hand as it is seen at another wheel: what somebody brought to its own does not hang there.
fn elsewhere(hand: HandWire) -> HandWire {
    let radius_um = (Sphere::default().radius().0 * 1e6) as u16;
    match hand.tool {
        ShapeWire::Convex { shape, .. } if usize::from(shape) >= rack::standard().len() => {
            HandWire { tool: ShapeWire::Sphere { radius_um }, ..hand }
        }
        _ => hand,
    }
}
