//! What the figures were measured on.
//!
//! Owns the questions to the system; whatever it does not answer is said to be unknown.
//! Invariant: no clock is asked: a date comes from whoever starts the chart.

use std::fs;

/// A machine and the build that ran on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Machine {
    /// Model of the processor.
    pub cpu: String,
    /// Cores that the program may use.
    pub cores: usize,
    /// Operating system and architecture.
    pub system: String,
    /// Compiler that built the program.
    pub rustc: String,
    /// Release or debug.
    pub profile: &'static str,
    /// Date of the measurement, when it was given.
    pub date: Option<String>,
}

impl Machine {
    /// The machine that this runs on.
    #[must_use]
    pub fn this(date: Option<String>) -> Self {
        let unknown = || "unknown".to_owned();
        let line = |path: &str, name: &str, sign: char| {
            let text = fs::read_to_string(path).ok()?;
            let line = text.lines().find(|line| line.starts_with(name))?;
            Some(line.split_once(sign)?.1.trim().trim_matches('"').to_owned())
        };
        let system = line("/etc/os-release", "PRETTY_NAME", '=').unwrap_or_else(|| std::env::consts::OS.to_owned());
        Self {
            cpu: line("/proc/cpuinfo", "model name", ':').unwrap_or_else(unknown),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            system: format!("{system}, {}", std::env::consts::ARCH),
            rustc: env!("CHART_RUSTC_VERSION").to_owned(),
            profile: if cfg!(debug_assertions) { "debug" } else { "release" },
            date,
        }
    }

    /// In one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let date = self.date.as_ref().map_or_else(String::new, |date| format!(", {date}"));
        let Self { cpu, cores, system, rustc, profile, .. } = self;
        format!("{cpu}, {cores} cores, {system}, {rustc}, {profile} build{date}")
    }

    /// As a JSON file.
    #[must_use]
    pub fn json(&self) -> String {
        let value = serde_json::json!({
            "cpu": self.cpu,
            "cores": self.cores,
            "system": self.system,
            "rustc": self.rustc,
            "profile": self.profile,
            "date": self.date,
        });
        format!("{value:#}\n")
    }
}
