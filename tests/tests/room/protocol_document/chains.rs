//! Snapshots of a pot into which dice press: what is told of it, and with which digests.

use pottery_shared::clay::{GridShape, Phase, Pot, PotSpec, Support, Surface, Window};
use pottery_shared::snapshot::{Author, Detail, Moment, Tier, Touched, Version, quantise};
use pottery_shared::units::Tick;
use pottery_tests::dice::Dice;
use serde_json::{Value, json};

use super::hex;

/// A pot into which dice press, without any law of clay: what is told, and with which digests.
struct Wheel {
    pot: Pot,
    author: Author,
    touched: Touched,
    dice: Dice,
    now: u64,
}

impl Wheel {
    const SHAPE: (u32, u32) = (44, 37);

    fn new(support: Support) -> Self {
        let shape = GridShape::new(Self::SHAPE.0, Self::SHAPE.1).unwrap();
        let mut pot = Pot::new(PotSpec { shape, support, ..PotSpec::default() }).unwrap();
        let author = Author::new(&mut pot);
        let touched = Touched::none(pot.surfaces().iter().map(Surface::shape));
        Self { pot, author, touched, dice: Dice::new(5), now: 0 }
    }

    /// A dent that stands in the room while the pot turns, with some roughness; now and then another one elsewhere.
    fn press(&mut self) -> (Vec<u8>, Moment) {
        let turned = (self.now * 3 / 2) as u32;
        let mut dents = vec![(turned % Self::SHAPE.0, 12_u32, 9_i32)];
        if self.now % 5 == 4 {
            dents.push(((turned + 20) % Self::SHAPE.0, 30, -120));
        }
        for (column, row, deep) in dents {
            for (aside, up) in (0..7).flat_map(|aside| (0..7).map(move |up| (aside, up))) {
                let (column, row) = ((column + aside) % Self::SHAPE.0, row + up);
                let (from_middle, rough) = ((aside as i32 - 3).pow(2) + (up as i32 - 3).pow(2), self.dice.roll() % 3);
                let depth = deep * (18 - from_middle) / 18 + rough as i32;
                // of a wall the inner skin goes half as far, and folds are on a grid of their own
                for (surface, depth) in
                    [depth, depth / 2, depth / 3].into_iter().enumerate().take(self.pot.surfaces().len())
                {
                    let radius_m = self.pot.surfaces()[surface].column_m(column)[row as usize];
                    let step = (i32::from(quantise(radius_m)) - depth) as u16;
                    self.pot.surfaces_mut()[surface].set_radius(
                        column,
                        row,
                        pottery_shared::snapshot::dequantise(step),
                    );
                    let window = Window { first_column: column, columns: 1, first_row: row, rows: 1 };
                    self.touched.add_window(surface, window);
                }
            }
        }
        self.now += 1;
        // with pauses, so that the time between deltas changes
        let tick = Tick(self.now * 17 + self.now / 4 * 30);
        let now = Moment { tick, phase: Phase((tick.0 as u32).wrapping_mul(5_000_000)) };
        (self.author.publish(&mut self.pot, &mut self.touched, now).unwrap().bytes, now)
    }
}

fn said(kind: &str, version: Version, bytes: &[u8], digest: u64) -> Value {
    json!({ "kind": kind, "version": version.0, "hex": hex(bytes), "digest": format!("{digest:016x}") })
}

fn keyframe_said(author: &Author, since: Version, goes_on: bool) -> Value {
    let mut value = said("keyframe", author.latest(), &author.keyframe(since, goes_on), author.digest());
    value["since"] = since.0.into();
    value["goes_on"] = goes_on.into();
    value
}

/// Snapshots as followers of a wheel hear of them: from the start, late, after a gap, coarse, and of both skins of a wall.
pub(super) fn all() -> Vec<Value> {
    let mut wheel = Wheel::new(Support::Backed);
    let (columns, rows) = Wheel::SHAPE;
    let PotSpec { radius, wall, .. } = PotSpec::default();
    let [outer, inner] = [radius.0, radius.0 - wall.0].map(quantise);
    let mut tiers = Detail::PRESETS.map(|detail| (detail, Tier::after(Version(0), &wheel.author, detail), Vec::new()));
    let (mut from_the_start, mut late, mut gap) = (Vec::new(), Vec::new(), Vec::new());
    for version in 1..=14 {
        let (bytes, now) = wheel.press();
        let delta = said("delta", wheel.author.latest(), &bytes, wheel.author.digest());
        from_the_start.push(delta.clone());
        match version {
            ..=3 => gap.push(delta.clone()),
            4..9 => {}
            9 => gap.push(keyframe_said(&wheel.author, Version(3), true)),
            _ => gap.push(delta.clone()),
        }
        match version {
            6 => late.push(keyframe_said(&wheel.author, Version(0), true)),
            7.. => late.push(delta),
            _ => {}
        }
        for (_, tier, chain) in &mut tiers {
            if let Some(delta) = tier.publish(&wheel.author, now) {
                chain.push(said("delta", delta.version, &delta.bytes, tier.digest()));
            }
        }
    }
    late.push(keyframe_said(&wheel.author, Version(0), false));
    let chain = |grids: &[(u32, u32, u16)], quantum: u16, said: &[Value]| json!({ "grids": grids, "quantum": quantum, "said": said });
    let skins = [(columns, rows, outer), (columns, rows, inner)];
    let mut chains: Vec<_> = [from_the_start, late, gap].iter().map(|said| chain(&skins[..1], 1, said)).collect();
    for ((detail, _, said), quantum) in tiers.iter().zip([3, 16]) {
        let grid = detail.grid_of(GridShape::new(columns, rows).unwrap());
        chains.push(chain(&[(grid.columns(), grid.rows(), outer)], quantum, said));
    }
    let (mut wall, mut told) = (Wheel::new(Support::Hollow), Vec::new());
    for version in 1..=6 {
        let (bytes, _) = wall.press();
        match version {
            4 => told.push(keyframe_said(&wall.author, Version(0), true)),
            5.. => told.push(said("delta", wall.author.latest(), &bytes, wall.author.digest())),
            _ => {}
        }
    }
    chains.push(chain(&[skins[0], skins[1], (96, 64, outer)], 1, &told));
    chains
}
