//! Which role may ask for what: the one table, which every request goes through.
//!
//! Pure; where somebody sits and whether a wheel is frozen is looked at afterwards, by those who know.
//! Invariant: a request that this table does not allow changes nothing.

use crate::protocol::{Request, Role};

/// Whether a role may make a request, about the wheel at which it sits where the request names none.
///
/// ```
/// use pottery_shared::protocol::{Order, Request, Role};
/// use pottery_shared::room::may;
/// let lock = Request::Order(Order::Lock { is_locked: true });
/// assert!(may(Role::Teacher, &lock) && !may(Role::Student, &lock));
/// ```
#[must_use]
pub const fn may(role: Role, request: &Request) -> bool {
    match request {
        // looking is for everybody who was let in, and so is going
        Request::Watch { .. } | Request::Unwatch { .. } | Request::MendSight { .. } | Request::Leave => true,
        // what keeps a copy of the clay whole
        Request::Again { .. } | Request::Resync { .. } | Request::Mend { .. } | Request::Retell { .. } => works(role),
        // what those at a wheel settle among themselves
        Request::WheelSpeed { .. }
        | Request::Clay { .. }
        | Request::Tool { .. }
        | Request::Undo { .. }
        | Request::Redo { .. }
        | Request::NewPot { .. }
        | Request::Pot { .. } => works(role),
        // letting go of a teacher's hand is for everybody who may have one
        Request::EndGuidance => works(role),
        Request::Order(_) | Request::Guide { .. } | Request::Target(_) => matches!(role, Role::Teacher),
    }
}

/// Whether a role may press clay.
#[must_use]
pub const fn may_press(role: Role) -> bool {
    works(role)
}

/// Whether a request changes what is at a wheel: nobody's counts while it is frozen, but a teacher's.
#[must_use]
pub const fn changes_clay(request: &Request) -> bool {
    matches!(
        request,
        Request::WheelSpeed { .. }
            | Request::Clay { .. }
            | Request::Tool { .. }
            | Request::Undo { .. }
            | Request::Redo { .. }
            | Request::NewPot { .. }
            | Request::Pot { .. }
    )
}

const fn works(role: Role) -> bool {
    matches!(role, Role::Teacher | Role::Student)
}
