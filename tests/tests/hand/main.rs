//! The hand: devices, what stands between them and the clay, and what is heard of it.

mod device_falcon;
mod device_gamepad;
mod device_gamepad_linux;
mod device_inverse3;
mod device_openhaptics;
mod device_pointer;
mod device_rhythm;
mod device_simulated;
mod devices;
mod haptics;
mod haptics_bench;
mod sound;
mod sound_server;
mod stroke;
