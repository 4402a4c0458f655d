//! Pictures and windows, and the programs as a person starts them.

mod crossing;
mod deflection;
mod device_fitting;
mod door;
mod force;
mod gallery;
mod guided;
mod keys;
mod looking_on;
mod picture;
mod preferences;
mod render;
mod screenshots;
mod sound;
mod studio;
mod teacher;
mod water;
