//! Servers and clients over sockets, or over a network in memory and virtual time.

mod crossing;
mod delta_age;
mod guided;
mod input_limits;
mod lesson;
mod load;
mod looking_again;
mod loopback;
mod operation;
mod simulated_network;
