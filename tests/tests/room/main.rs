//! A room and its clients in one process, without a socket: what is sent, refused, mended and told.

mod arrivals;
mod brought_tools;
mod classroom;
mod codec;
mod guidance;
mod guiding_hands;
mod inputs;
mod lead;
mod mending;
mod payload;
mod payload_up;
mod predicting;
mod protocol_document;
mod reconciliation;
mod sans_io;
mod subscriptions;
mod tool_samples;
mod transcript;
mod undo;
mod watching;
