//! Scenarios, network simulator and golden data of the pottery studio.
