//! The signals that end a program.
//!
//! Owns which they are on which system; what is done then is the program's.
//! Invariant: from the call on, none of them ends the program by itself.

/// Catches the signals that end a program from now on; what it returns is done when one has come.
///
/// # Errors
/// What the system says.
#[cfg(unix)]
pub fn stop_signal() -> std::io::Result<impl Future<Output = std::io::Result<()>>> {
    use tokio::signal::unix::{SignalKind, signal};
    let (mut terminated, mut interrupted) = (signal(SignalKind::terminate())?, signal(SignalKind::interrupt())?);
    Ok(async move {
        tokio::select! {
            _ = interrupted.recv() => Ok(()),
            _ = terminated.recv() => Ok(()),
        }
    })
}

/// Catches the signal that ends a program; what it returns is done when it has come.
///
/// # Errors
/// What the system says.
#[cfg(not(unix))]
pub fn stop_signal() -> std::io::Result<impl Future<Output = std::io::Result<()>>> {
    Ok(tokio::signal::ctrl_c())
}
