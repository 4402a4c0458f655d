//! Which cores a spawned server keeps to, and which are the generator's.
//!
//! Owns the two sets; threads and processes are born on the cores of the thread that starts them.
//! Invariant: the sets share no core, and a thread is back on its own cores when a [`Kept`] is dropped.

#[cfg(target_os = "linux")]
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

/// The cores of this machine in two parts.
///
/// A generator that shares its cores with the server waits for it, a scheduler's slice at a time, and then blames the server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Apart {
    #[cfg(target_os = "linux")]
    all: CpuSet,
    #[cfg(target_os = "linux")]
    server: CpuSet,
    #[cfg(target_os = "linux")]
    generator: CpuSet,
    servers: usize,
}

/// Why cores cannot be told apart.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ApartError {
    /// Each side needs one.
    #[error(
        "of the {allowed} cores that this program may use the server cannot have {wanted}: at least one is the server's, and one the generator's"
    )]
    Count {
        /// Cores that were to be the server's.
        wanted: usize,
        /// Cores that there are.
        allowed: usize,
    },
    /// The system does not say, or nobody wrote it for this system.
    #[error("processes are kept to cores on Linux alone so far, and not here ({reason}): leave --server-cores out")]
    Unsupported {
        /// What the system said.
        reason: String,
    },
}

/// While it lives, the thread that asked for it keeps to one part, and so does what it starts.
#[derive(Debug)]
#[must_use = "the thread is back on all of its cores when this is dropped"]
pub struct Kept {
    #[cfg(target_os = "linux")]
    before: CpuSet,
}

impl Apart {
    /// The server has the first `servers` of the cores that this program may use.
    ///
    /// # Errors
    /// [`ApartError`].
    #[cfg(target_os = "linux")]
    pub fn new(servers: usize) -> Result<Self, ApartError> {
        let all = sched_getaffinity(None).map_err(|error| ApartError::Unsupported { reason: error.to_string() })?;
        let allowed: Vec<_> = (0..CpuSet::MAX_CPU).filter(|&core| all.is_set(core)).collect();
        if !(1..allowed.len()).contains(&servers) {
            return Err(ApartError::Count { wanted: servers, allowed: allowed.len() });
        }
        let set = |cores: &[usize]| {
            let mut set = CpuSet::new();
            cores.iter().for_each(|&core| set.set(core));
            set
        };
        Ok(Self { all, server: set(&allowed[..servers]), generator: set(&allowed[servers..]), servers })
    }

    /// None, since threads are kept to cores on Linux alone so far.
    ///
    /// # Errors
    /// [`ApartError::Unsupported`].
    #[cfg(not(target_os = "linux"))]
    pub fn new(_: usize) -> Result<Self, ApartError> {
        Err(ApartError::Unsupported { reason: std::env::consts::OS.to_owned() })
    }

    /// How many are the server's.
    #[must_use]
    pub const fn servers(&self) -> usize {
        self.servers
    }

    /// Keeps the calling thread to the server's cores.
    ///
    /// # Errors
    /// What the system says.
    pub fn keep_to_server(&self) -> std::io::Result<Kept> {
        #[cfg(target_os = "linux")]
        return keep(&self.server);
        #[cfg(not(target_os = "linux"))]
        Err(std::io::ErrorKind::Unsupported.into())
    }

    /// Keeps the calling thread to the generator's cores.
    ///
    /// # Errors
    /// What the system says.
    pub fn keep_to_generator(&self) -> std::io::Result<Kept> {
        #[cfg(target_os = "linux")]
        return keep(&self.generator);
        #[cfg(not(target_os = "linux"))]
        Err(std::io::ErrorKind::Unsupported.into())
    }

    /// Lets the calling thread go on any core of both.
    ///
    /// # Errors
    /// What the system says.
    pub fn keep_to_none(&self) -> std::io::Result<Kept> {
        #[cfg(target_os = "linux")]
        return keep(&self.all);
        #[cfg(not(target_os = "linux"))]
        Err(std::io::ErrorKind::Unsupported.into())
    }
}

#[cfg(target_os = "linux")]
fn keep(to: &CpuSet) -> std::io::Result<Kept> {
    let before = sched_getaffinity(None)?;
    sched_setaffinity(None, to)?;
    Ok(Kept { before })
}

#[cfg(target_os = "linux")]
impl Drop for Kept {
    fn drop(&mut self) {
        if let Err(error) = sched_setaffinity(None, &self.before) {
            tracing::debug!(%error, "a thread stays on fewer cores than it had");
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn each_side_has_a_core_of_its_own_and_gives_it_back() {
        let all = sched_getaffinity(None).unwrap();
        let count = all.count() as usize;
        for wanted in [0, count] {
            assert_eq!(Apart::new(wanted), Err(ApartError::Count { wanted, allowed: count }));
        }
        let Ok(apart) = Apart::new(1) else {
            assert_eq!(count, 1, "of two cores one can be the server's");
            return;
        };
        let cores = || std::thread::scope(|scope| scope.spawn(|| sched_getaffinity(None).unwrap()).join().unwrap());
        let kept = apart.keep_to_server().unwrap();
        let server = cores();
        drop(kept);
        let kept = apart.keep_to_generator().unwrap();
        let generator = cores();
        let bystander = {
            let _kept = apart.keep_to_none().unwrap();
            cores()
        };
        assert_eq!(cores(), generator);
        drop(kept);
        assert_eq!((server.count(), generator.count() as usize), (1, count - 1));
        assert!((0..CpuSet::MAX_CPU).all(|core| !(server.is_set(core) && generator.is_set(core))));
        assert_eq!([bystander, cores()], [all; 2]);
    }
}
