//! The client of the pottery studio: a thin shell round the shared core.
//!
//! Owns files, devices, the connection and the picture; what the clay does is decided in `pottery-shared`.

pub mod export;
pub mod stroke;
