//! Going downhill without slopes: the simplex of Nelder and Mead (1965).
//!
//! Owns the walk and nothing of what it is for.
//! Invariant: the walk follows from the start, the number of iterations and the values alone.

/// A place and the value there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner<const N: usize> {
    /// The place.
    pub at: [f64; N],
    /// The value.
    pub value: f64,
}

/// By how much the first corners lie apart, of each coordinate; a coordinate of 0 is moved by as much as it is.
const APART: f64 = 0.15;
/// Iterations after which the walk begins anew: a simplex becomes flat before it is at the bottom.
const ANEW: u32 = 150;
/// Share of the value by which it has to be lower then, or the corners are nearer and to the other side.
const LOWER: f64 = 1e-3;

/// The lowest place that so many iterations find, from a start whose coordinates are each made 15 % larger. After 150 it
/// begins anew from the best place; where that has not come lower since, by half as much to the other side.
///
/// An iteration moves the worst corner through the middle of the others: reflection −1, expansion −2, contraction ±½, and
/// where nothing helps all corners go half way to the best one. `tell` hears the number of the iteration that begins, from
/// 1, and the lowest value so far.
///
/// # Errors
/// The first that `value` gives.
pub fn descend<const N: usize, E>(
    start: [f64; N],
    iterations: u32,
    mut value: impl FnMut([f64; N]) -> Result<f64, E>,
    mut tell: impl FnMut(u32, f64),
) -> Result<Corner<N>, E> {
    let mut corner = |at| Ok(Corner { at, value: value(at)? });
    let mut corners = vec![corner(start)?];
    let (mut apart, mut lowest) = (APART, f64::INFINITY);
    for iteration in 1..=iterations {
        if (iteration - 1).is_multiple_of(ANEW) {
            corners.sort_by(|a, b| a.value.total_cmp(&b.value));
            corners.truncate(1);
            let Corner { at: best, value } = corners[0];
            if value > (1.0 - LOWER) * lowest {
                apart *= -0.5;
            }
            lowest = value;
            for moved in 0..N {
                let mut at = best;
                at[moved] += apart * if at[moved] == 0.0 { 1.0 } else { at[moved] };
                corners.push(corner(at)?);
            }
        }
        corners.sort_by(|a, b| a.value.total_cmp(&b.value));
        let (best, worst, second) = (corners[0], corners[N], corners[N - 1]);
        tell(iteration, best.value);
        let middle: [f64; N] =
            std::array::from_fn(|axis| corners[..N].iter().map(|corner| corner.at[axis]).sum::<f64>() / N as f64);
        let away = |share: f64| std::array::from_fn(|axis| middle[axis] + share * (worst.at[axis] - middle[axis]));
        let reflected = corner(away(-1.0))?;
        if reflected.value < best.value {
            let expanded = corner(away(-2.0))?;
            corners[N] = if expanded.value < reflected.value { expanded } else { reflected };
            continue;
        }
        if reflected.value < second.value {
            corners[N] = reflected;
            continue;
        }
        let contracted = corner(away(if reflected.value < worst.value { -0.5 } else { 0.5 }))?;
        if contracted.value < worst.value {
            corners[N] = contracted;
            continue;
        }
        for shrunk in &mut corners[1..] {
            *shrunk = corner(std::array::from_fn(|axis| 0.5 * (shrunk.at[axis] + best.at[axis])))?;
        }
    }
    corners.sort_by(|a, b| a.value.total_cmp(&b.value));
    Ok(corners[0])
}
