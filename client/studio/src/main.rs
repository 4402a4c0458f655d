//! The pottery studio: the desktop application.

fn main() {}
