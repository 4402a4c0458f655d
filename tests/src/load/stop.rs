//! The signal that ends a load test: somebody's Ctrl-C, or what a system sends.
//!
//! Owns the thread that waits for it; whoever is at work asks here.
//! Invariant: a signal that has come is known from then on, also to a run that begins after it.

use std::io;

use tokio::runtime::Builder;
use tokio::sync::watch;

/// Whether the signal has come.
#[derive(Clone, Debug)]
pub struct Stop(watch::Receiver<bool>);

impl Stop {
    /// From now on the signal is caught, and ends nothing by itself.
    ///
    /// # Errors
    /// What the system says.
    pub fn caught() -> io::Result<Self> {
        let (tell, told) = watch::channel(false);
        let runtime = Builder::new_current_thread().enable_all().build()?;
        let signal = {
            let _inside = runtime.enter();
            pottery_server::stop_signal()?
        };
        std::thread::Builder::new().name("stop".into()).spawn(move || {
            if runtime.block_on(signal).is_ok() {
                tell.send_replace(true);
            }
        })?;
        Ok(Self(told))
    }

    /// Waits until it has come.
    pub async fn come(&self) {
        if self.0.clone().wait_for(|has_come| *has_come).await.is_err() {
            // nobody can tell any more
            std::future::pending::<()>().await;
        }
    }
}
