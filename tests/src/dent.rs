//! A sphere pressed into a pot, as the reference presses it.
//!
//! Owns the scenario and what is measured of it; the law of the clay is the method's.
//! Invariant: the tool stands exactly at its depth when the dent is measured.

use std::cell::Cell;
use std::time::Instant;

use glam::Vec3;
use pottery_shared::clay::{
    Bend, Contact, ErrorBound, GridShape, Lathe, Material, Method, MethodKind, PlasticCsem, Pot, PotSpec, Press,
    Strength, SubStep, Support, Window,
};
use pottery_shared::tool::{Side, Sphere, ToolError};
use pottery_shared::units::{Metres, Seconds};

pub use figure::{DentError, Figure, Range, Rounded};

use crate::reference::Profile;
use figure::{HAIR, sphere};

mod figure;

/// Steps in which the tool comes in, and in which it stands until the clay rests.
const STEPS_IN: u32 = 300;
const STEPS_STILL: u32 = 1500;
/// Length of a step, s.
const STEP: Seconds = Seconds(1e-3);
/// The reference knows no rate: clay gives way in the time that the quickest clay takes, or while the tool goes as far as this along it, m,
/// whichever is sooner. It is the way of 2 ms at 48 rpm, at which the constants of sliding are fitted.
const GIVES_WAY_M: f32 = 0.6e-3;
/// Columns over which the force on a tool that goes round is a mean: it rises and falls with each that the tool comes to.
const COLUMNS_FELT: f32 = 8.0;
/// Quickest wheel, turns a minute, and longest time that it turns, min.
const RPM_MAX: f32 = 3000.0;
const MINUTES_MAX: f32 = 60.0;

/// What is pressed into what.
#[derive(Clone, Copy, Debug)]
pub struct Dent {
    /// How the clay deforms.
    pub method: MethodKind,
    /// The pot.
    pub pot: PotSpec,
    /// The clay.
    pub strength: Strength,
    /// Radius of the sphere.
    pub tool: Metres,
    /// Its travel from first touch.
    pub depth: Metres,
    /// Radius of a ball that is held inside of the wall, opposite the tool and touching it.
    pub finger: Option<Metres>,
    /// Whether the tool is taken away before the surface is read.
    pub release: bool,
    /// After the press: turns a minute, feed along the axis for each turn, and number of turns.
    pub round: Option<(f32, Metres, f32)>,
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct Dented {
    /// Grid of the outer surface.
    pub shape: GridShape,
    /// Distance between rows, mm.
    pub row_height_mm: f32,
    /// Radial displacement, `[columns][rows]`, mm; negative is inwards.
    pub radial_mm: Vec<f32>,
    /// Radial force on the tool, N: in its last step as it stands still, or over the last eight columns that it goes over.
    pub force_n: f32,
    /// The same on the finger inside, towards the axis, if there is one.
    pub finger_n: Option<f32>,
    /// Elements that the tool touched in its last step.
    pub touched: u32,
    /// Volume pushed in and raised, mm³.
    pub volume_in_mm3: f64,
    /// Volume raised above the untouched surface, mm³.
    pub volume_out_mm3: f64,
    /// By how much the pot becomes higher by what stays pressed in and did not rise beside it, mm, where its clay is kept.
    pub grows_mm: Option<f64>,
    /// Radial displacement of the inner wall behind the tool's middle that stays, mm, from what knows of an inner wall.
    pub behind_mm: Option<f64>,
    /// Median time of a step with contact, ns; not a number when the tool met no element.
    pub step_ns: f64,
    /// Steps in which the wheel was a profile, of how many while it turned.
    pub profile_steps: (u32, u32),
}

impl Dent {
    /// Columns across the contact of a ball at its full depth δ on a core, by our method: in a wall of radius r one of radius R is
    /// `2·√(2·δ·r·R/(r + R))` wide. `None` for others, whose elements know nothing of each other.
    #[must_use]
    pub fn columns_across(&self) -> Option<f32> {
        let (tool, pot) = (self.tool.0, self.pot.radius.0);
        let is_ours = self.method == MethodKind::Plastic && self.pot.support == Support::Backed;
        let half_m = (2.0 * self.depth.0 * tool * pot / (tool + pot)).sqrt();
        is_ours.then(|| 2.0 * half_m / (pot * self.pot.shape.column_angle_rad()))
    }

    fn check(&self) -> Result<Sphere, DentError> {
        self.pot.check()?;
        let youngs_pa = Range::Closed(Material::YOUNGS_PA_MIN, Material::YOUNGS_PA_MAX);
        Figure::Youngs.within(self.strength.youngs_pa, youngs_pa, "")?;
        // clay that is strained as far as it is long has torn before it yields
        let youngs_pa = self.strength.youngs_pa;
        let why = if youngs_pa < Material::YIELD_PA_MAX { "as much as Young's modulus" } else { "" };
        let yield_pa = Range::Closed(Material::YIELD_PA_MIN, Material::YIELD_PA_MAX.min(youngs_pa * (1.0 + HAIR)));
        Figure::Yield.within(self.strength.yield_pa, yield_pa, why)?;
        let PotSpec { radius, wall, support, .. } = self.pot;
        let tool = sphere(Figure::ToolRadius, self.tool, radius, "the pot's radius")?;
        self.check_depth()?;
        if let Some(finger) = self.finger {
            if support == Support::Backed {
                return Err(DentError::NoInside);
            }
            if self.method != MethodKind::Plastic {
                return Err(DentError::FingerIsUnknown);
            }
            // one that the wall comes to lie round is a core, which nothing here knows of
            let most = Metres(radius.0 - wall.0 - self.depth.0);
            sphere(Figure::FingerRadius, finger, most, "so that it fits into the pot, pressed in so far")?;
        }
        self.check_round()?;
        Ok(tool)
    }

    /// A core lets no tool deeper than its clay goes. Without one, the wall bends as far as the tool goes and beyond, by what is
    /// known of small deflections: from about half of the radius on, it would come out on the other side of the axis.
    fn check_depth(&self) -> Result<(), DentError> {
        let (wall_mm, third_mm) = (self.pot.wall.told_mm(), self.pot.radius.as_mm() / 3.0);
        let least_mm = PotSpec::WALL_MIN.told_mm();
        let squeezed_mm = wall_mm - least_mm;
        let (most_mm, why) = match self.pot.support {
            Support::Backed if wall_mm < third_mm => (wall_mm, "how thick the backed wall is"),
            Support::Hollow if self.finger.is_some() && squeezed_mm <= 0.0 => {
                return Err(DentError::ThinWall { wall_mm, least_mm });
            }
            Support::Hollow if self.finger.is_some() && squeezed_mm < third_mm => {
                (squeezed_mm, "what the finger leaves of the wall but a millimetre")
            }
            _ => (third_mm, "a third of the pot's radius"),
        };
        // what is told is taken: to the micrometre
        let most = Metres::from_mm(Metres::from_mm(most_mm).told_mm());
        Figure::Depth.within(self.depth.0, Range::UpTo(most.0), why)
    }

    fn check_round(&self) -> Result<(), DentError> {
        let Some((rpm, feed, turns)) = self.round else { return Ok(()) };
        // a step may not go round the pot, and somebody waits for the last one
        Figure::Speed.within(rpm, Range::UpTo(RPM_MAX), "")?;
        let (least, most) = (rpm / 60.0 * STEP.0, rpm * MINUTES_MAX);
        let asked = if (turns - least).abs() <= HAIR * least { least } else { turns };
        Figure::Turns.within(asked, Range::Closed(least, most), "from a millisecond to an hour at this speed")?;
        let most_m = 0.5 * self.pot.height.0 / turns * (1.0 + HAIR);
        Figure::Feed.within(feed.0, Range::Closed(-most_m, most_m), "so that the tool stays at the pot")
    }

    /// Presses in 300 steps and waits for 1500 more, of 1 ms each.
    ///
    /// # Errors
    /// [`DentError`] for figures that make no sense.
    pub fn press(&self) -> Result<Dented, DentError> {
        self.press_in(STEPS_IN)
    }

    /// The same within the same time in another number of steps: `steps_in` until the tool has reached its depth, and
    /// five times as many while it stands.
    ///
    /// # Errors
    /// [`DentError`] for figures that make no sense.
    pub fn press_in(&self, steps_in: u32) -> Result<Dented, DentError> {
        self.press_stepping(steps_in, None, Pressing::step)
    }

    /// The same, with our method's turning wheel advanced as a profile wherever that is estimated to be as near as `bound`, and clay
    /// that takes the time it takes on the wheel: a groove that is whole after one pass is no profile's affair.
    ///
    /// # Errors
    /// [`DentError`] for figures that make no sense.
    pub fn press_as_profile(&self, bound: ErrorBound) -> Result<Dented, DentError> {
        self.press_stepping(STEPS_IN, Some(bound), Pressing::step)
    }

    /// The same, with steps of one's own: tool's angle, depth and height, and the way that the clay turns.
    ///
    /// # Errors
    /// [`DentError`] for figures that make no sense.
    pub fn press_by(&self, step: fn(&mut Pressing, f32, f32, f32, i8) -> f32) -> Result<Dented, DentError> {
        self.press_stepping(STEPS_IN, None, step)
    }

    fn press_stepping(
        &self,
        steps_in: u32,
        bound: Option<ErrorBound>,
        one: fn(&mut Pressing, f32, f32, f32, i8) -> f32,
    ) -> Result<Dented, DentError> {
        if steps_in == 0 {
            return Err(DentError::NoSteps);
        }
        let step = Seconds(STEP.0 * STEPS_IN as f32 / steps_in as f32);
        let mut pressing = match bound {
            Some(_) => Pressing::in_clay(*self, step, Material::default().viscosity)?,
            None => Pressing::new(*self, step)?,
        };
        pressing.touch();
        pressing.turning = bound.zip(self.round).map(|(bound, (rpm, ..))| Turning {
            lathe: Lathe::new(&pressing.pot.surfaces()[0], bound, PlasticCsem::default()),
            step_rad: rpm / 60.0 * step.0 * std::f32::consts::TAU,
            profile_steps: (0, 0),
        });
        let middle_z = 0.5 * self.pot.height.0;
        let mut times_ns = Vec::new();
        let mut force_n = 0.0;
        let mut timed = |angle_rad, depth_m, z_m, turning| {
            let begin = Instant::now();
            let force_n = one(&mut pressing, angle_rad, depth_m, z_m, turning);
            let took_ns = begin.elapsed().as_nanos() as f64;
            if pressing.contact.elements > 0 {
                times_ns.push(took_ns);
            }
            force_n
        };
        for number in 1..=steps_in + steps_in * STEPS_STILL / STEPS_IN {
            let share = (number as f32 / steps_in as f32).min(1.0);
            force_n = timed(0.0, self.depth.0 * share, middle_z, 0);
        }
        if let Some((rpm, feed, turns)) = self.round {
            let per_step = rpm / 60.0 * step.0;
            let steps = (turns / per_step).round() as u32;
            let felt = (COLUMNS_FELT / self.pot.shape.columns() as f32 / per_step).ceil().min(steps as f32);
            let mut sum_n = 0.0;
            for number in 1..=steps {
                let turned = number as f32 * per_step;
                let now_n = timed(turned * std::f32::consts::TAU, self.depth.0, middle_z + feed.0 * turned, 1);
                if (steps - number) < felt as u32 {
                    sum_n += f64::from(now_n);
                }
            }
            force_n = (sum_n / f64::from(felt)) as f32;
        }
        pressing.leave_profile();
        times_ns.sort_by(f64::total_cmp);
        let step_ns = times_ns.get(times_ns.len() / 2).copied();
        Ok(self.measure(&pressing, force_n, step_ns.unwrap_or(f64::NAN)))
    }

    /// The same with any method, unmeasured: the pot with the tool still in it.
    ///
    /// # Errors
    /// [`DentError`] for figures that make no sense.
    pub fn press_with(&self, method: impl Method + Copy, steps_in: u32) -> Result<Pressing, DentError> {
        if steps_in == 0 {
            return Err(DentError::NoSteps);
        }
        let mut pressing = Pressing::new(*self, Seconds(STEP.0 * STEPS_IN as f32 / steps_in as f32))?;
        pressing.touch();
        for number in 1..=steps_in + steps_in * STEPS_STILL / STEPS_IN {
            let share = (number as f32 / steps_in as f32).min(1.0);
            pressing.step_with(method, 0.0, self.depth.0 * share, 0.5 * self.pot.height.0, 0);
        }
        Ok(pressing)
    }

    /// Reads the surface: what stays, or while the tool is in what it and the clay's elastic sink leave of it.
    fn measure(&self, pressing: &Pressing, force_n: f32, step_ns: f64) -> Dented {
        let pot = &pressing.pot;
        let surface = &pot.surfaces()[pot.skins()[0].surface];
        let shape = surface.shape();
        let (mut volume_in_mm3, mut volume_out_mm3) = (0.0, 0.0);
        let mut radial_mm = Vec::with_capacity(shape.elements());
        let sink = pressing.contact.sink.filter(|_| !self.release);
        let bends = pressing.bends(self.release);
        let at = pressing.at.unwrap_or_default();
        let element = f64::from(shape.column_angle_rad()) * f64::from(surface.row_height_m());
        for column in 0..shape.columns() {
            let angle = column as f32 * shape.column_angle_rad();
            for (row, &radius_m) in surface.column_m(column).iter().enumerate() {
                let z_m = surface.row_z_m(row as u32);
                let sunk = sink.map_or(0.0, |sink| sink.depth_at_m(angle, z_m));
                let bent: f32 = bends.iter().map(|bend| bend.at_m(angle, z_m)).sum();
                let free = radius_m - sunk - bent;
                let seen = if self.release { radius_m } else { free.min(near_side_m(at, pressing.tool, angle, z_m)) };
                radial_mm.push((seen - self.pot.radius.0) * 1e3);
                let (now, first) = (f64::from(seen), f64::from(self.pot.radius.0));
                let volume = 0.5 * (now * now - first * first) * element * 1e9;
                if volume < 0.0 {
                    volume_in_mm3 -= volume;
                } else {
                    volume_out_mm3 += volume;
                }
            }
        }
        let row_height_mm = surface.row_height_m() * 1e3;
        let profile_steps = pressing.turning.as_ref().map_or((0, 0), |turning| turning.profile_steps);
        let finger_n = pressing.finger.map(|(held, felt)| -felt.force_n.dot(held.centre_m.with_z(0.0).normalize()));
        Dented {
            shape,
            row_height_mm,
            radial_mm,
            force_n,
            finger_n,
            touched: pressing.contact.elements,
            volume_in_mm3,
            volume_out_mm3,
            grows_mm: self.method.keeps_volume().then(|| {
                let mut settled = pot.clone();
                let all = Window { first_column: 0, columns: shape.columns(), first_row: 0, rows: shape.rows() };
                settled.settle((0..pot.spec().skins()).map(|skin| (skin, all)));
                f64::from(settled.surfaces()[0].height_m()) * 1e3 - f64::from(self.pot.height.as_mm())
            }),
            behind_mm: Some(pressing.behind_mm()),
            step_ns,
            profile_steps,
        }
    }
}

/// A pot with a tool at it, advanced one step at a time.
#[derive(Clone, Debug)]
pub struct Pressing {
    dent: Dent,
    tool: Sphere,
    pot: Pot,
    substep: SubStep,
    step: Seconds,
    response: f32,
    /// Way along the clay within which it gives way, however fast the tool goes.
    gives_way_m: f32,
    /// Where the tool is, once it has come.
    at: Option<Vec3>,
    /// What it met last, and where it was then.
    contact: Contact,
    met_at: Vec3,
    /// A ball inside, and what it met.
    finger: Option<(Press, Contact)>,
    turning: Option<Turning>,
}

/// A wheel that turns, as a profile where that is near enough.
#[derive(Clone, Debug)]
struct Turning {
    lathe: Lathe,
    step_rad: f32,
    profile_steps: (u32, u32),
}

impl Pressing {
    /// An untouched pot and the tool of a dent, in steps of one length, of clay that gives way as one without a rate.
    ///
    /// # Errors
    /// [`DentError`] for figures that make no sense.
    pub fn new(dent: Dent, step: Seconds) -> Result<Self, DentError> {
        let pressing = Self::in_clay(dent, step, Material::VISCOSITY_MIN)?;
        Ok(Self { gives_way_m: GIVES_WAY_M, ..pressing })
    }

    /// The same with clay that yields as slowly as one says.
    ///
    /// # Errors
    /// [`DentError`] for figures that make no sense.
    pub fn in_clay(dent: Dent, step: Seconds, viscosity: Seconds) -> Result<Self, DentError> {
        let tool = dent.check()?;
        let pot = Pot::new(dent.pot)?;
        let substep = SubStep::for_spheres(dent.pot.shape);
        let response = Material { viscosity, ..Material::default() }.response(step);
        let finger = dent.finger.map(|radius| {
            let at_m = Vec3::new(dent.pot.radius.0 - dent.pot.wall.0 - radius.0, 0.0, 0.5 * dent.pot.height.0);
            let held = Press::held(Sphere::new(radius)?, at_m);
            let press = Press { side: Side::Inside, response, strength: dent.strength, dt: step, ..held };
            Ok::<_, ToolError>((press, Contact::default()))
        });
        let (contact, finger) = (Contact::default(), finger.transpose()?);
        let (met_at, gives_way_m) = (Vec3::X, f32::INFINITY);
        Ok(Self {
            dent,
            tool,
            pot,
            substep,
            step,
            response,
            gives_way_m,
            at: None,
            contact,
            met_at,
            finger,
            turning: None,
        })
    }

    /// One step with the tool at an angle, a depth below the untouched surface and a height, on clay that turns one way
    /// (1), the other (−1) or not (0).
    ///
    /// Returns the radial force on the tool, N.
    pub fn step(&mut self, angle_rad: f32, depth_m: f32, z_m: f32, turning: i8) -> f32 {
        self.step_telling(angle_rad, depth_m, z_m, turning, |_, _| {})
    }

    /// The same, which tells of every surface and window that changed.
    pub fn step_telling(
        &mut self,
        angle_rad: f32,
        depth_m: f32,
        z_m: f32,
        turning: i8,
        touched: impl FnMut(usize, Window),
    ) -> f32 {
        let at = self.place(angle_rad, depth_m, z_m);
        let method = self.dent.method;
        // the published methods know where a tool is, and of no way there
        let from_m = self.at.replace(at).filter(|_| method == MethodKind::Plastic);
        self.advance(method, at, from_m, turning, touched)
    }

    /// The same with any method, which is told where the tool came from.
    pub fn step_with(&mut self, method: impl Method, angle_rad: f32, depth_m: f32, z_m: f32, turning: i8) -> f32 {
        let at = self.place(angle_rad, depth_m, z_m);
        let from_m = self.at.replace(at);
        self.advance(method, at, from_m, turning, |_, _| {})
    }

    /// Puts the tool where it begins, at the untouched surface.
    fn touch(&mut self) {
        self.at = Some(self.place(0.0, 0.0, 0.5 * self.dent.pot.height.0));
    }

    fn place(&self, angle_rad: f32, depth_m: f32, z_m: f32) -> Vec3 {
        let distance = self.dent.pot.radius.0 + self.tool.radius().0 - depth_m;
        Vec3::new(distance * angle_rad.cos(), distance * angle_rad.sin(), z_m)
    }

    fn advance(
        &mut self,
        method: impl Method,
        at: Vec3,
        from_m: Option<Vec3>,
        turning: i8,
        touched: impl FnMut(usize, Window),
    ) -> f32 {
        let way_m = from_m.map_or(0.0, |from_m| from_m.distance(at)) * self.dent.pot.radius.0 / at.truncate().length();
        let response = self.response.max(1.0 - (-way_m / self.gives_way_m).exp());
        let strength = self.dent.strength;
        let press = Press { turning, response, strength, from_m, dt: self.step, ..Press::held(self.tool, at) };
        // while the wheel stands there is no profile
        let profiled =
            self.turning.as_mut().filter(|_| turning != 0).and_then(|Turning { lathe, step_rad, profile_steps }| {
                let contact = lathe.advance(&mut self.pot.surfaces_mut()[0], &press, *step_rad, |_| ());
                *profile_steps = (profile_steps.0 + u32::from(contact.is_some()), profile_steps.1 + 1);
                contact
            });
        let contact = match profiled {
            // until it has gone a quarter of a turn, what was met before stands
            Some(contact) if contact == Contact::default() => self.contact,
            Some(contact) => contact,
            None => match &mut self.finger {
                Some((held, felt)) => {
                    if turning != 0 {
                        let from_m = from_m.map(|_| held.centre_m);
                        let opposite = at.truncate().normalize() * held.centre_m.truncate().length();
                        *held = Press { centre_m: opposite.extend(at.z), from_m, turning, response, ..*held };
                    }
                    let contacts = self.substep.advance(&mut self.pot, &[press, *held], method, touched);
                    *felt = contacts[1];
                    contacts[0]
                }
                None => self.substep.advance(&mut self.pot, &[press], method, touched)[0],
            },
        };
        // a profile tells of the same contact for a quarter of a turn, in which the tool goes on
        if profiled.is_none() || contact != self.contact {
            (self.contact, self.met_at) = (contact, at);
        }
        self.contact.force_n.dot(self.met_at.with_z(0.0).normalize())
    }

    /// Writes a profile that is in force to the grid, and feels there what the tool meets.
    fn leave_profile(&mut self) {
        let Some(Turning { lathe, .. }) = self.turning.as_mut().filter(|turning| turning.lathe.is_turning()) else {
            return;
        };
        lathe.leave(&mut self.pot.surfaces_mut()[0], |_| ());
        if let Some(at) = self.at {
            let press = Press { response: 0.0, strength: self.dent.strength, ..Press::held(self.tool, at) };
            self.contact = self.substep.feel(&self.pot, &press, self.dent.method);
        }
    }

    /// Takes the tool away: wherever it comes back, it has not been drawn there.
    pub const fn lift(&mut self) {
        self.at = None;
    }

    /// Displacement of the outer surface at any angle and height, mm (bilinear): what stays, or with the tool in, the
    /// clay round it sunk and a hollow wall bent. Elements are looked at when they are first asked for.
    pub fn radial_mm(&self, release: bool) -> impl Fn(f64, f64) -> f64 {
        let surface = &self.pot.surfaces()[self.pot.skins()[0].surface];
        let shape = surface.shape();
        let bends = self.bends(release);
        let seen_m = move |column: u32, row: usize| {
            let stays_m = surface.column_m(column)[row];
            let Some(at) = self.at.filter(|_| !release) else { return stays_m };
            let (angle, z_m) = (column as f32 * shape.column_angle_rad(), surface.row_z_m(row as u32));
            let sunk_m = self.contact.sink.map_or(0.0, |sink| sink.depth_at_m(angle, z_m));
            let bent_m: f32 = bends.iter().map(|bend| bend.at_m(angle, z_m)).sum();
            (stays_m - sunk_m - bent_m).min(near_side_m(at, self.tool, angle, z_m))
        };
        let known = vec![Cell::new(f64::NAN); shape.elements()];
        move |angle_rad, z_mm| {
            bilinear(shape, f64::from(surface.row_height_m()) * 1e3, angle_rad, z_mm, |column, row| {
                let known = &known[column as usize * shape.rows() as usize + row];
                if known.get().is_nan() {
                    known.set(f64::from(seen_m(column, row) - self.dent.pot.radius.0) * 1e3);
                }
                known.get()
            })
        }
    }

    /// Radial displacement of the inner wall behind the tool's middle that stays, mm.
    #[must_use]
    pub fn behind_mm(&self) -> f64 {
        let PotSpec { radius, wall, .. } = *self.pot.spec();
        let surface = self.pot.met_from(Side::Inside);
        let (shape, inset_m) = (surface.shape(), surface.inset_m(Side::Inside));
        let (row_mm, middle_mm) = (surface.row_height_m() * 1e3, 0.5 * surface.height_m() * 1e3);
        let inner_mm = bilinear(shape, row_mm.into(), 0.0, middle_mm.into(), |column, row| {
            f64::from(surface.column_m(column)[row] - inset_m) * 1e3
        });
        inner_mm - f64::from(radius.as_mm() - wall.as_mm())
    }

    /// How the wall is bent, by the tool and what is held inside.
    fn bends(&self, release: bool) -> Vec<Bend> {
        let surface = &self.pot.surfaces()[self.pot.skins()[0].surface];
        let contacts = [Some(self.contact), self.finger.map(|(_, contact)| contact)];
        let sinks = contacts.into_iter().flatten().filter(|_| !release).filter_map(|contact| contact.sink);
        sinks.filter_map(|sink| sink.bend(surface)).collect()
    }

    /// What the last step met.
    #[must_use]
    pub const fn contact(&self) -> Contact {
        self.contact
    }

    /// The pot as it is now.
    #[must_use]
    pub const fn pot(&self) -> &Pot {
        &self.pot
    }

    /// The pot, to be changed.
    pub const fn pot_mut(&mut self) -> &mut Pot {
        &mut self.pot
    }
}

/// Radius at which the tool's near side meets the ray of an element; infinite beside the tool.
fn near_side_m(at: Vec3, tool: Sphere, angle: f32, z_m: f32) -> f32 {
    let (distance, direction) = (at.with_z(0.0).length(), at.y.atan2(at.x));
    let (along, aside) = (distance * (angle - direction).cos(), distance * (angle - direction).sin());
    let rest = tool.radius().0.powi(2) - (z_m - at.z).powi(2) - aside * aside;
    if rest > 0.0 && along > 0.0 { along - rest.sqrt() } else { f32::INFINITY }
}

/// Value at an angle and a height between the four elements round it.
fn bilinear(shape: GridShape, row_height_mm: f64, angle_rad: f64, z_mm: f64, at: impl Fn(u32, usize) -> f64) -> f64 {
    let column = angle_rad / f64::from(shape.column_angle_rad());
    let row = (z_mm / row_height_mm).clamp(0.0, f64::from(shape.rows() - 2));
    let (left, across) = (column.floor(), column - column.floor());
    let (low, up) = (row.floor() as usize, row - row.floor());
    let [left, right] = [left, left + 1.0].map(|column| shape.wrap(column as i64));
    let below = at(left, low) * (1.0 - across) + at(right, low) * across;
    let above = at(left, low + 1) * (1.0 - across) + at(right, low + 1) * across;
    below * (1.0 - up) + above * up
}

impl Dented {
    /// Displacement at an angle and a height, mm (bilinear).
    #[must_use]
    pub fn radial_mm_at(&self, angle_rad: f64, z_mm: f64) -> f64 {
        bilinear(self.shape, self.row_height_mm.into(), angle_rad, z_mm, |column, row| {
            f64::from(self.radial_mm[column as usize * self.shape.rows() as usize + row])
        })
    }

    /// Root mean square of the difference to a reference over 15 mm of arc and height to all sides, on a raster of
    /// 0.25 mm, divided by the tool's travel.
    #[must_use]
    pub fn error(&self, reference: &Profile, dent: &Dent) -> f64 {
        let difference_mm = self.rms_mm(dent, |angle, z_mm| reference.radial_mm(angle, z_mm));
        difference_mm / f64::from(dent.depth.as_mm())
    }

    /// Root mean square of the difference to another surface over the same raster, mm.
    #[must_use]
    pub fn difference_mm(&self, other: &Self, dent: &Dent) -> f64 {
        self.rms_mm(dent, |angle, z_mm| other.radial_mm_at(angle, z_mm))
    }

    fn rms_mm(&self, dent: &Dent, other_mm: impl Fn(f64, f64) -> f64) -> f64 {
        let (radius_mm, middle_mm) = (f64::from(dent.pot.radius.as_mm()), f64::from(dent.pot.height.as_mm()) * 0.5);
        let steps = -60..=60_i32;
        let mut sum = 0.0;
        for across in steps.clone() {
            for up in steps.clone() {
                let (angle, z_mm) = (f64::from(across) * 0.25 / radius_mm, middle_mm + f64::from(up) * 0.25);
                sum += (self.radial_mm_at(angle, z_mm) - other_mm(angle, z_mm)).powi(2);
            }
        }
        (sum / f64::from(121 * 121)).sqrt()
    }
}
