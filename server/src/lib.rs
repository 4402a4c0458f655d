//! The authoritative pottery server: a thin shell round the shared room.
