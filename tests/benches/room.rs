//! What the ticks of a room take with one core and with two: potters who press without a pause, in virtual time.
//!
//! Measures, asserts nothing. Run it with `cargo bench -p pottery-tests --bench room -- [wheels] [potters]`. Rooms that are equal but
//! for who does their wheels take turns of a quarter of a second of their own time; the hands' part is not counted.

use std::time::Duration;

use pottery_server::Helpers;
use pottery_shared::room::Alone;
use pottery_tests::load::plan::Plan;
use pottery_tests::load::virtual_room::VirtualRoom;

/// Milliseconds of a turn, and how many turns there are after one that is not counted.
const TURN_MS: u64 = 250;
const TURNS: usize = 40;

/// One kind of crew and the time that its turns took, s for one of the room's.
struct Entrant {
    name: &'static str,
    helpers: Option<Helpers>,
    room: VirtualRoom,
    shares: Vec<f64>,
    ticks_us: Vec<f64>,
}

impl Entrant {
    fn turn(&mut self, turn: u64, is_counted: bool) {
        let mut took = Duration::ZERO;
        for millisecond in turn * TURN_MS + 1..=(turn + 1) * TURN_MS {
            let tick = match &self.helpers {
                Some(helpers) => self.room.pass(millisecond, helpers, |_| {}),
                None => self.room.pass(millisecond, &Alone, |_| {}),
            };
            took += tick;
            if is_counted {
                self.ticks_us.push(tick.as_secs_f64() * 1e6);
            }
        }
        if is_counted {
            self.shares.push(took.as_secs_f64() * 1e3 / TURN_MS as f64);
        }
    }
}

fn at(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share) as usize]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asked: Vec<u32> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    let loads = match asked[..] {
        [wheels, potters] => vec![(wheels, potters)],
        _ => vec![(1, 8), (8, 24), (24, 24), (48, 96)],
    };
    for (wheels, potters) in loads {
        let plan = Plan { wheels: u16::try_from(wheels)?, potters, ..Plan::default() };
        let entrant = |name, helpers| -> Result<_, Box<dyn std::error::Error>> {
            Ok(Entrant { name, helpers, room: VirtualRoom::open(&plan)?, shares: Vec::new(), ticks_us: Vec::new() })
        };
        let mut entrants = [entrant("one core", None)?, entrant("two cores", Helpers::new(1))?];
        for turn in 0..=TURNS {
            for entrant in &mut entrants {
                entrant.turn(turn as u64, turn > 0);
            }
        }
        let [one, two] = entrants.each_mut().map(|entrant| {
            let share = at(&mut entrant.shares, 0.5);
            let [middle, high] = [0.5, 0.99].map(|share| at(&mut entrant.ticks_us, share));
            println!(
                "{wheels:>3} wheels {potters:>3} potters {:<9} {:>5.1} % of the time, a tick {middle:>6.1} µs (p99 {high:>6.1})",
                entrant.name,
                share * 100.0
            );
            share
        });
        println!("    two cores do {:.2} times as much; the same clay: {}", one / two, same(&entrants));
    }
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("load averages at the end: {}", load.trim());
    Ok(())
}

fn same([one, two]: &[Entrant; 2]) -> bool {
    one.room.digests() == two.room.digests()
}
