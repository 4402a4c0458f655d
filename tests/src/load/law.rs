//! What each wheel, potter and looker-on costs a server: a law fitted to runs with more and fewer of each.
//!
//! Owns the loads that are tried and the fit; each load is a run.
//! Invariant: a load that the generator spoilt is not in the law, and a coefficient stands beside its standard error.

use serde::{Deserialize, Serialize};

use super::plan::{Plan, Sight};
use super::result::{RunResult, Verdict};
use super::run::{Options, RunError, run};
use crate::linear::Cholesky;
use crate::printed::remark;

/// What there may be more of, in the order of [`Load::counts`].
pub const PARTS: [&str; 6] = [
    "server that somebody is connected to",
    "wheel with one potter",
    "potter more at the same wheel",
    "subscriber with all a potter gets",
    "spectator, 30 a second",
    "small picture in a gallery, 5 a second",
];
/// What is fitted, in the order of [`Load::costs`].
pub const COSTS: [&str; 4] = ["% of a core", "MB", "kbit/s down", "kbit/s up"];

/// How the law is come by.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// Times that every load is gone through.
    pub turns: u32,
    /// Most people who look on.
    pub most: u32,
}

/// Why there is no law.
#[derive(Debug, thiserror::Error)]
pub enum LawError {
    /// A run could not be gone through.
    #[error(transparent)]
    Run(#[from] RunError),
    /// Too few loads to tell the parts from each other.
    #[error(
        "of {tried} loads only {held} were borne by generator and server, too few for a law: use a machine with more time to spare, \
         --server-cores, or fewer people with --most"
    )]
    TooFew {
        /// Loads that were tried.
        tried: usize,
        /// Those that held.
        held: usize,
    },
}

/// One load that was tried.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Load {
    /// How many of each of [`PARTS`].
    pub counts: [f64; PARTS.len()],
    /// What they cost, each of [`COSTS`].
    pub costs: [f64; COSTS.len()],
    /// How it ended; only one that passed is fitted.
    pub verdict: Verdict,
}

/// One cost as a sum over parts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fit {
    /// Cost of one of each part.
    pub each: [f64; PARTS.len()],
    /// Its standard error.
    pub error: [f64; PARTS.len()],
    /// Root of the mean square of what is left, over the degrees of freedom.
    pub residual: f64,
}

/// A law.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Law {
    /// Every load, in the order in which they were tried.
    pub loads: Vec<Load>,
    /// For each of [`COSTS`].
    pub fits: [Fit; COSTS.len()],
    /// The first run, for what it says of the machine.
    pub first: Option<RunResult>,
    /// Whether a person ended it before all loads were tried.
    pub is_interrupted: bool,
}

impl Fit {
    /// By least squares over `(counts, cost)`; `None` where the loads do not tell the parts apart.
    ///
    /// With X the counts and y the costs, each = (XᵀX)⁻¹·Xᵀy and the square of its error s²·(XᵀX)⁻¹ on the diagonal, where
    /// s² is the sum of squares that is left over loads less parts.
    #[must_use]
    pub fn of(points: &[([f64; PARTS.len()], f64)]) -> Option<Self> {
        let count = PARTS.len();
        let freedom = points.len().checked_sub(count).filter(|&freedom| freedom > 0)?;
        let normal = Cholesky::new(count, count - 1, |row, column| {
            points.iter().map(|(counts, _)| counts[row] * counts[column]).sum()
        })?;
        let mut each: [f64; PARTS.len()] =
            std::array::from_fn(|part| points.iter().map(|(counts, cost)| counts[part] * cost).sum());
        normal.solve(&mut each);
        let fit = Self { each, error: [0.0; PARTS.len()], residual: 0.0 };
        let left: f64 = points.iter().map(|(counts, cost)| (cost - fit.of_load(counts)).powi(2)).sum();
        let residual = (left / freedom as f64).sqrt();
        let error = std::array::from_fn(|part| {
            let mut unit = [0.0; PARTS.len()];
            unit[part] = 1.0;
            normal.solve(&mut unit);
            residual * unit[part].sqrt()
        });
        Some(Self { each, error, residual })
    }

    /// What a load costs by it.
    #[must_use]
    pub fn of_load(&self, counts: &[f64; PARTS.len()]) -> f64 {
        counts.iter().zip(self.each).map(|(count, each)| count * each).sum()
    }
}

/// The loads of one turn: people who look on in three ways beside one potter, potters at wheels of their own, and potters at one.
#[must_use]
pub fn loads(base: &Plan, most: u32) -> Vec<Plan> {
    let watched = [
        (Sight::Full, vec![0, most / 4, most / 2, most]),
        (Sight::SPECTATOR, vec![most / 2, most]),
        (Sight::GALLERY, vec![most]),
    ];
    let watched = watched.into_iter().flat_map(|(sight, counts)| {
        counts.into_iter().map(move |spectators| Plan { sight, spectators, potters: 1, wheels: 1, ..base.clone() })
    });
    let worked = [(2, 2), (4, 4), (8, 8), (4, 1), (8, 1)];
    let worked = worked.map(|(potters, wheels)| Plan { potters, wheels, spectators: 0, ..base.clone() });
    watched.chain(worked).collect()
}

fn counts_of(plan: &Plan) -> [f64; PARTS.len()] {
    let wheels = u32::from(plan.used()).min(plan.potters);
    let seen = |sight| f64::from(if plan.sight == sight { plan.spectators } else { 0 });
    let [full, spectator, gallery] = [Sight::Full, Sight::SPECTATOR, Sight::GALLERY].map(seen);
    [1.0, f64::from(wheels), f64::from(plan.potters - wheels), full, spectator, gallery]
}

/// Goes through the loads and fits the law.
///
/// # Errors
/// [`LawError`].
pub fn fitted(base: &Plan, way: Way, options: &Options) -> Result<Law, LawError> {
    let mut found = Vec::new();
    let (mut first, mut interrupted) = (None, None);
    let plans = loads(base, way.most);
    let all = plans.len() * way.turns as usize;
    for plan in (0..way.turns).flat_map(|_| &plans) {
        let result = match run(plan.clone(), options) {
            Err(ended @ RunError::Interrupted { .. }) => {
                interrupted = Some(ended);
                break;
            }
            result => result?,
        };
        let per_s = |bytes: u64| bytes as f64 * 8e-3 / result.measured_s;
        let costs = [
            result.server_cpu_percent.unwrap_or_default(),
            result.server_memory_mb.unwrap_or_default(),
            per_s(result.down_bytes),
            per_s(result.up_bytes),
        ];
        let load = Load { counts: counts_of(plan), costs, verdict: result.verdict };
        found.push(load);
        remark(format_args!("{:>3} of {all} {}", found.len(), found[found.len() - 1].row()));
        first.get_or_insert(result);
    }
    let held: Vec<_> = found.iter().filter(|load| load.verdict == Verdict::Pass).collect();
    let fits: Option<Vec<_>> = (0..COSTS.len())
        .map(|cost| Fit::of(&held.iter().map(|load| (load.counts, load.costs[cost])).collect::<Vec<_>>()))
        .collect();
    let is_interrupted = interrupted.is_some();
    let too_few = LawError::TooFew { tried: found.len(), held: held.len() };
    let fits = fits.and_then(|fits| fits.try_into().ok()).ok_or(interrupted.map_or(too_few, LawError::from))?;
    Ok(Law { loads: found, fits, first, is_interrupted })
}

impl Load {
    fn row(&self) -> String {
        let [_, wheels, more, full, spectator, gallery] = self.counts;
        let [cpu_percent, mb, down, up] = self.costs;
        format!(
            "{wheels:>3} wheels {:>3} potters {full:>5} subscribers {spectator:>5} spectators {gallery:>5} small pictures: \
             {cpu_percent:>6.1} % of a core {mb:>6.1} MB {down:>8.0} kbit/s down {up:>6.0} up  {}",
            wheels + more,
            self.verdict.name()
        )
    }
}

impl Law {
    /// Loads that are in it.
    #[must_use]
    pub fn held(&self) -> usize {
        self.loads.iter().filter(|load| load.verdict == Verdict::Pass).count()
    }

    /// How it ended: clay that was not the same everywhere is no load that was merely too much, and one that was interrupted is not whole.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        let has_diverged = self.loads.iter().any(|load| load.verdict == Verdict::Diverged);
        match (has_diverged, self.is_interrupted) {
            (true, _) => Verdict::Diverged,
            (false, true) => Verdict::Invalid,
            (false, false) => Verdict::Pass,
        }
    }

    /// A table for a person: what one of each part costs, with its standard error.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = format!("{:<40}", "for each");
        for name in COSTS {
            table.push_str(&format!("{name:>14}{:>9}", "±"));
        }
        for (part, name) in PARTS.iter().enumerate() {
            table.push_str(&format!("\n{name:<40}"));
            for fit in &self.fits {
                table.push_str(&format!("{:>14.3}{:>9.3}", fit.each[part], fit.error[part]));
            }
        }
        table.push_str(&format!("\n{:<40}", "what is left, root of the mean square"));
        for fit in &self.fits {
            table.push_str(&format!("{:>14.2}{:>9}", fit.residual, ""));
        }
        table.push('\n');
        table
    }

    /// What the law rests on.
    #[must_use]
    pub fn sentence(&self) -> String {
        let shared_out = self.first.as_ref().map_or_else(String::new, |first| first.host.shared_out());
        let diverged = match self.loads.iter().filter(|load| load.verdict == Verdict::Diverged).count() {
            0 => String::new(),
            count => format!(" In {count} of the others the clay is not known to be the same everywhere."),
        };
        let interrupted = if self.is_interrupted { " It was interrupted before all loads were tried." } else { "" };
        let (held, tried) = (self.held(), self.loads.len());
        format!("{held} of {tried} loads are in the law; server and generator {shared_out}.{diverged}{interrupted}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_of_costs_that_follow_one_is_that_law() {
        let each = [3.0, 1.5, 2.0, 0.05, 0.04, 0.01];
        let cost_of = |counts: [f64; 6]| counts.iter().zip(each).map(|(count, each)| count * each).sum::<f64>();
        let points: Vec<_> = loads(&Plan::default(), 400).iter().map(counts_of).map(|at| (at, cost_of(at))).collect();
        let fit = Fit::of(&points).unwrap();
        for part in 0..PARTS.len() {
            assert!((fit.each[part] - each[part]).abs() < 1e-9, "{}: {}", PARTS[part], fit.each[part]);
            assert!(fit.error[part] < 1e-9, "{}: ± {}", PARTS[part], fit.error[part]);
        }
        assert!(fit.residual < 1e-9);
    }

    #[test]
    fn error_is_that_of_the_textbook() {
        // every load twice, 0.5 above the law and 0.5 below: what is left is 0.5 over all, more over the degrees of freedom
        let once: Vec<_> = loads(&Plan::default(), 400).iter().map(counts_of).collect();
        let points: Vec<_> = once.iter().flat_map(|&at| [(at, 7.0 * at[1] + 0.5), (at, 7.0 * at[1] - 0.5)]).collect();
        let fit = Fit::of(&points).unwrap();
        let expected = 0.5 * (24.0_f64 / 18.0).sqrt();
        assert!((fit.residual - expected).abs() < 1e-9, "{}", fit.residual);
        // without others that vary with it the error of a part is the residual over the root of its spread
        let alone: Vec<_> = (0..12)
            .map(|load| {
                let mut at = [0.0; PARTS.len()];
                at[load % PARTS.len()] = 2.0;
                (at, if load < 6 { 1.0 } else { 3.0 })
            })
            .collect();
        let fit = Fit::of(&alone).unwrap();
        for part in 0..PARTS.len() {
            assert!((fit.each[part] - 1.0).abs() < 1e-12);
            assert!((fit.error[part] - fit.residual / 8.0_f64.sqrt()).abs() < 1e-12);
        }
    }

    #[test]
    fn clay_that_was_not_the_same_everywhere_is_no_matter_of_figures() {
        let load = |verdict| Load { counts: [1.0; PARTS.len()], costs: [1.0; COSTS.len()], verdict };
        let fit = Fit { each: [0.0; PARTS.len()], error: [0.0; PARTS.len()], residual: 0.0 };
        let law = |verdict| {
            let loads = vec![load(Verdict::Pass), load(verdict), load(Verdict::Pass)];
            Law { loads, fits: [fit; COSTS.len()], first: None, is_interrupted: false }
        };
        assert_eq!(law(Verdict::Invalid).verdict(), Verdict::Pass);
        assert_eq!(law(Verdict::Diverged).verdict(), Verdict::Diverged);
        let interrupted = Law { is_interrupted: true, ..law(Verdict::Pass) };
        assert_eq!(interrupted.verdict(), Verdict::Invalid);
        assert!(interrupted.sentence().contains("interrupted"), "{}", interrupted.sentence());
        assert!(
            law(Verdict::Diverged).sentence().contains("In 1 of the others the clay"),
            "{}",
            law(Verdict::Diverged).sentence()
        );
    }

    #[test]
    fn loads_that_do_not_tell_parts_apart_make_no_law() {
        let at = [1.0, 1.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!(Fit::of(&[(at, 1.0); 12]), None);
        let few: Vec<_> = loads(&Plan::default(), 400).iter().take(6).map(counts_of).map(|at| (at, 1.0)).collect();
        assert_eq!(Fit::of(&few), None);
    }
}
