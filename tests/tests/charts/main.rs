//! What is charted, and the yardsticks that it is charted against.

mod accuracy_chart;
mod failures;
mod finite_elements;
mod fit;
mod network_chart;
mod stability;
mod transform;
mod yardsticks;
