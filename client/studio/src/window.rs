//! The window. (in progress)
use crate::arguments::WindowSession;
pub(crate) enum Ended {
    ByPerson,
    NoDisplay(String),
}
pub(crate) fn run(_s: &WindowSession) -> anyhow::Result<Ended> {
    Ok(Ended::NoDisplay("soon".into()))
}
