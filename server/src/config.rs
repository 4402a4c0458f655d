//! What a server is started with: defaults, then a file, then flags.
//!
//! Owns names, ranges and the sentences about them; opens nothing but the file it is told to read.
//! Invariant: what flags and file say together is checked, and nothing starts unchecked.

use std::net::{IpAddr, Ipv6Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use pottery_files::sentence::of_line;
use pottery_shared::clay::{
    Form, GridError, GridShape, Material, MaterialError, MethodKind, PotError, PotSpec, Preset, Support, Wetness, Wheel,
};
use pottery_shared::protocol::{JoinCode, JoinCodeError};
use pottery_shared::snapshot::PotRecord;
use pottery_shared::tool::Sphere;
use pottery_shared::units::{Metres, Rpm};
use serde::{Deserialize, Serialize};

use crate::{Arrivals, Input};

use written::{address, number, whole};

pub(crate) mod written;

/// Everything a server needs to know.
#[derive(Clone, Debug)]
pub struct ServerConfig {
    /// UDP address to listen on.
    pub listen: SocketAddr,
    /// The room's code; a fresh one when absent.
    pub code: Option<JoinCode>,
    /// Number of wheels.
    pub wheels: u16,
    /// Most people at one time.
    pub people_max: u16,
    /// The pot on every wheel, untouched.
    pub pot: PotSpec,
    /// Its form; any but a cylinder has a height and a radius of its own.
    pub form: Form,
    /// A pot that was made before and stands on every wheel instead.
    pub opened: Option<Arc<PotRecord>>,
    /// How clay deforms.
    pub method: MethodKind,
    /// How fast wheels turn at first.
    pub wheel_speed: Rpm,
    /// What the clay is made of at first.
    pub clay: Material,
    /// A session file to be written, which must not exist yet.
    pub record: Option<PathBuf>,
    /// The folder in which pots are kept from one start to the next; none are when absent.
    pub data: Option<PathBuf>,
    /// The folder in which the key, and pots that were pressed, are put by while nothing is kept in `data`, for whoever leaves without saving: the next
    /// start begins with new pots all the same, and has those of the last one under [`last_pot`](crate::last_pot). They are put nowhere when absent.
    pub spare: Option<PathBuf>,
    /// Whether wheels begin with new pots even so; those that were kept are put aside.
    pub is_fresh: bool,
    /// Whether a new teacher's token takes the place of the one whose hash is kept.
    pub renews_teacher: bool,
    /// Hours for which a code is good; for good when absent.
    pub code_hours: Option<f64>,
    /// Whether who comes waits until a teacher lets them in.
    pub has_lobby: bool,
    /// What the class is called where it announces itself; a word when absent.
    pub class: Option<String>,
    /// Whether the local network is told that the studio is there.
    pub is_announced: bool,
    /// Where operators on this machine ask how the server is.
    pub operate: Option<SocketAddr>,
    /// From what the pot's grid follows, in the place of its own shape.
    pub finest: Option<Finest>,
    /// How often people may knock.
    pub arrivals: Arrivals,
    /// How much people may send.
    pub input: Input,
}

/// What clay is worked with and looked at, as far as its grid goes by it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finest {
    /// Radius of the smallest tool.
    pub tool: Metres,
    /// Shortest length that anybody sees on the clay.
    pub seen: Metres,
}

impl Finest {
    /// What is seen of a pot that fills a large screen.
    pub const SEEN: Metres = Metres(0.1e-3);
    /// Smallest and largest tool that a grid may be for, mm.
    pub const TOOL_MM: (f32, f32) = (tenths_mm(Sphere::RADIUS_MIN), tenths_mm(Sphere::RADIUS_MAX));
    /// Shortest and longest length that may be seen, mm: a hundredth, and an element of the largest tool's grid.
    pub const SEEN_MM: (f32, f32) = (0.01, 10.0);

    /// For the smallest tool and, where it is known, the finest viewer.
    #[must_use]
    pub fn of_mm(tool: f32, seen: Option<f32>) -> Self {
        Self { tool: Metres::from_mm(tool), seen: seen.map_or(Self::SEEN, Metres::from_mm) }
    }

    /// The grid for a pot of a form, by the form's greatest width.
    fn shape(self, form: Form, pot: PotSpec) -> Result<GridShape, ConfigError> {
        within("smallest_tool_mm", self.tool.told_mm(), Self::TOOL_MM)?;
        within("finest_view_mm", self.seen.told_mm(), Self::SEEN_MM)?;
        let pot = match form {
            Form::Cylinder => pot,
            form => {
                let made = form.pot(PotSpec { shape: GridShape::new(8, 200)?, ..pot })?;
                let radii_m = made.surfaces()[0].radii_m().iter();
                PotSpec { radius: Metres(radii_m.copied().fold(0.0, f32::max)), ..*made.spec() }
            }
        };
        let shape_for = |tool_mm| GridShape::for_tool_and_view(&pot, Metres::from_mm(tool_mm), self.seen);
        let tool_mm = self.tool.told_mm();
        shape_for(tool_mm).map_err(|_| {
            let most_mm = Self::TOOL_MM.1;
            // in tenths, as people choose
            let mut choices_mm = (1..10 * most_mm as u16).map(|tenths| f32::from(tenths) / 10.0);
            let least_mm = choices_mm.find(|&tool_mm| shape_for(tool_mm).is_ok()).unwrap_or(most_mm);
            ConfigError::TooFine { tool_mm, least_mm, most_mm }
        })
    }
}

/// A length of tenths of a millimetre, as it was written: 40, where its metres give 40.000004.
const fn tenths_mm(length: Metres) -> f32 {
    (length.as_mm() * 10.0).round() / 10.0
}

/// Whether a number can be used.
fn within(setting: &'static str, value: f32, (min, max): (f32, f32)) -> Result<(), ConfigError> {
    if (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(ConfigError::Range { setting, value: told(value), min, max })
    }
}

/// A number without the digits that binary adds and nobody wrote: six are left, which an `f32` has.
fn told(number: f32) -> f32 {
    format!("{number:.5e}").parse().unwrap_or(number)
}

impl ServerConfig {
    /// The studio's UDP port.
    pub const PORT: u16 = 4747;
    /// Most wheels in one process.
    pub const WHEELS_MAX: u16 = 1024;
    /// Shortest and longest time for which a code is good, h.
    pub const CODE_HOURS: (f64, f64) = (0.01, 10_000.0);
    /// Longest name of a class, characters.
    pub const CLASS_MAX: usize = 40;
    /// Most people in one process.
    pub const PEOPLE_MAX: u16 = 4096;

    /// The folder that its key and pots go to, if they go to one.
    pub(crate) fn folder(&self) -> Option<&Path> {
        self.data.as_deref().or(self.spare.as_deref())
    }

    /// Checks what types cannot, and gives the pot the grid that follows from [`ServerConfig::finest`].
    ///
    /// # Errors
    /// [`ConfigError`] naming the setting and its range.
    pub fn checked(mut self) -> Result<Self, ConfigError> {
        let count = |setting, number: u16, most: u16| within(setting, number.into(), (1.0, most.into()));
        count("wheels", self.wheels, Self::WHEELS_MAX)?;
        count("people_max", self.people_max, Self::PEOPLE_MAX)?;
        self.pot.check()?;
        if let Some(finest) = self.finest {
            self.pot.shape = finest.shape(self.form, self.pot)?;
        }
        within("wheel_rpm", self.wheel_speed.0, (-Wheel::RPM_MAX.0, Wheel::RPM_MAX.0))?;
        Material::new(self.clay.viscosity, self.clay.strength)?;
        if self.code.as_ref().is_some_and(|code| code.print().is_some()) {
            return Err(ConfigError::LongCode);
        }
        match &self.data {
            Some(folder) if folder.as_os_str().is_empty() => return Err(ConfigError::Data),
            None if self.is_fresh => return Err(ConfigError::FreshAlone),
            _ => {}
        }
        if let Some(address) = self.operate.filter(|address| !address.ip().is_loopback()) {
            return Err(ConfigError::Operate { address });
        }
        if let Some(hours) = self.code_hours.filter(|hours| !(Self::CODE_HOURS.0..=Self::CODE_HOURS.1).contains(hours))
        {
            return Err(ConfigError::CodeHours { hours });
        }
        let is_name = |name: &String| {
            let length = name.chars().count();
            (1..=Self::CLASS_MAX).contains(&length) && !name.chars().any(char::is_control)
        };
        if let Some(name) = self.class.clone().filter(|name| !is_name(name)) {
            return Err(ConfigError::Class { name, max: Self::CLASS_MAX });
        }
        let Arrivals { burst, per_s, .. } = self.arrivals;
        if burst == 0 || per_s == 0 {
            return Err(ConfigError::Arrivals { burst, per_s });
        }
        if !self.input.is_enough() {
            return Err(ConfigError::Input { input: self.input });
        }
        Ok(self)
    }
}

impl Default for ServerConfig {
    /// One wheel with the paper's pot, for everybody who can reach this machine.
    fn default() -> Self {
        Self {
            listen: SocketAddr::new(IpAddr::V6(Ipv6Addr::UNSPECIFIED), Self::PORT),
            code: None,
            wheels: 1,
            people_max: 64,
            pot: PotSpec::default(),
            form: Form::default(),
            opened: None,
            method: MethodKind::default(),
            wheel_speed: Rpm(60.0),
            clay: Material::default(),
            record: None,
            data: None,
            spare: None,
            is_fresh: false,
            renews_teacher: false,
            code_hours: None,
            has_lobby: false,
            class: None,
            is_announced: true,
            operate: None,
            finest: None,
            arrivals: Arrivals::default(),
            input: Input::default(),
        }
    }
}

/// Why a server cannot be configured like that.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// A number out of range.
    #[error("{setting} = {value} cannot be used: choose a number from {min} to {max}")]
    Range {
        /// Name of the setting.
        setting: &'static str,
        /// What was given.
        value: f32,
        /// Smallest allowed.
        min: f32,
        /// Largest allowed.
        max: f32,
    },
    /// A grid that cannot be had.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// More elements than there can be follow from the smallest tool and the finest viewer.
    #[error(
        "smallest_tool_mm = {tool_mm} cannot be used: it gives this pot more elements than there can be; choose a number from {least_mm} to \
         {most_mm}"
    )]
    TooFine {
        /// Radius of the tool.
        tool_mm: f32,
        /// Smallest that this pot can have a grid for, to a tenth.
        least_mm: f32,
        /// Largest allowed.
        most_mm: f32,
    },
    /// A grid named twice.
    #[error("'smallest_tool_mm' says how fine the grid is: leave 'columns' and 'rows' out")]
    GridTwice,
    /// A viewer without a tool.
    #[error("'finest_view_mm' makes a grid coarser than the smallest tool needs: give 'smallest_tool_mm' as well")]
    ViewAlone,
    /// A code nobody could type.
    #[error(transparent)]
    Code(#[from] JoinCodeError),
    /// A code with a fingerprint in it.
    #[error(
        "give the eight characters of the room alone as the code: the others are the certificate's fingerprint and are made here"
    )]
    LongCode,
    /// A folder without a name.
    #[error("'data' is empty: name the folder for the pots, or leave it out")]
    Data,
    /// Pots to be put aside, and nowhere to look for them.
    #[error("--fresh puts aside the pots of a data folder: name the folder with --data, or 'data' in the settings")]
    FreshAlone,
    /// A method that does not exist.
    #[error("there is no method '{name}': choose original, improved or plastic")]
    Method {
        /// What was given.
        name: String,
    },
    /// A support that does not exist.
    #[error("there is no support '{name}': choose backed or hollow")]
    Support {
        /// What was given.
        name: String,
    },
    /// A form that does not exist.
    #[error("there is no form '{name}': choose cylinder, bowl, bottle or ball")]
    Form {
        /// What was given.
        name: String,
    },
    /// Measures for a form that has its own.
    #[error("a {form} has measures of its own: leave 'height_mm' and 'radius_mm' out, or choose a cylinder")]
    Measures {
        /// The form.
        form: &'static str,
    },
    /// Clay that nobody knows by that name.
    #[error("there is no clay '{name}': choose stiff, throwing, soft or slip, or say how wet it is")]
    Clay {
        /// What was given.
        name: String,
    },
    /// Clay that cannot be had.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// Clay named twice.
    #[error("'clay' and 'wetness' both say what the clay is: leave one of them out")]
    ClayTwice,
    /// A port for operators that others could reach.
    #[error(
        "operators are answered on this machine alone: choose a loopback address such as 127.0.0.1:4748, not {address}"
    )]
    Operate {
        /// What was given.
        address: SocketAddr,
    },
    /// A name that nobody can read.
    #[error("a class needs a name of 1 to {max} characters in one line, not {name:?}")]
    Class {
        /// What was given.
        name: String,
        /// Most characters.
        max: usize,
    },
    /// A code that is good for no time.
    #[error("a code that is good for {hours} hours is none: choose from 0.01 to 10000, or leave code_hours out")]
    CodeHours {
        /// What was given.
        hours: f64,
    },
    /// Doors through which nobody comes.
    #[error("with arrivals.burst = {burst} and arrivals.per_s = {per_s} nobody comes in: choose at least 1 for both")]
    Arrivals {
        /// What was given.
        burst: u32,
        /// What was given.
        per_s: u32,
    },
    /// Shares with which nobody can work.
    #[error(
        "with input.datagrams_per_s = {}, datagram_bytes_per_s = {}, requests_per_s = {} and request_bytes_per_s = {} nobody can work: \
         choose at least {}, {}, 1 and {}",
        input.datagrams_per_s,
        input.datagram_bytes_per_s,
        input.requests_per_s,
        input.request_bytes_per_s,
        Input::DATAGRAMS_PER_S_LEAST,
        Input::BYTES_PER_S_LEAST,
        Input::BYTES_PER_S_LEAST
    )]
    Input {
        /// What was given.
        input: Input,
    },
    /// A file that cannot be read.
    #[error("the configuration {path} cannot be read: {source}")]
    File {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file that says something else.
    #[error("the configuration {path} is not understood: {reason}")]
    Syntax {
        /// Which file.
        path: PathBuf,
        /// What the parser said.
        reason: String,
    },
}

impl From<PotError> for ConfigError {
    fn from(error: PotError) -> Self {
        match error {
            PotError::Grid(error) => Self::Grid(error),
            PotError::Measure { field, value_mm, min_mm: min, max_mm: max } => {
                let setting = match field {
                    "height" => "height_mm",
                    "radius" => "radius_mm",
                    _ => "wall_mm",
                };
                Self::Range { setting, value: told(value_mm), min, max }
            }
        }
    }
}

/// The configuration file (TOML); every entry may be left out.
///
/// ```
/// let file = "listen = \"[::]:4747\"\nwheels = 4\nsupport = \"hollow\"\n";
/// let config = toml::from_str::<pottery_server::FileConfig>(file).unwrap().into_config().unwrap();
/// assert_eq!((config.wheels, config.pot.support.name()), (4, "hollow"));
/// ```
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct FileConfig {
    #[serde(deserialize_with = "address")]
    listen: Option<SocketAddr>,
    code: Option<String>,
    code_hours: Option<f64>,
    lobby: Option<bool>,
    class: Option<String>,
    announce: Option<bool>,
    #[serde(deserialize_with = "whole::<_, _, 1, { ServerConfig::WHEELS_MAX as u32 }>")]
    wheels: Option<u32>,
    #[serde(deserialize_with = "whole::<_, _, 1, { ServerConfig::PEOPLE_MAX as u32 }>")]
    people_max: Option<u32>,
    // how many there may be in all is the grid's affair
    #[serde(deserialize_with = "whole::<_, _, 8, 4096>")]
    columns: Option<u32>,
    #[serde(deserialize_with = "whole::<_, _, 4, 4096>")]
    rows: Option<u32>,
    #[serde(deserialize_with = "number")]
    smallest_tool_mm: Option<f32>,
    #[serde(deserialize_with = "number")]
    finest_view_mm: Option<f32>,
    #[serde(deserialize_with = "number")]
    height_mm: Option<f32>,
    #[serde(deserialize_with = "number")]
    radius_mm: Option<f32>,
    #[serde(deserialize_with = "number")]
    wall_mm: Option<f32>,
    form: Option<String>,
    method: Option<String>,
    #[serde(deserialize_with = "number")]
    wheel_rpm: Option<f32>,
    clay: Option<String>,
    #[serde(deserialize_with = "number")]
    wetness: Option<f32>,
    support: Option<String>,
    data: Option<PathBuf>,
    #[serde(deserialize_with = "address")]
    operate: Option<SocketAddr>,
    arrivals: Option<Arrivals>,
    input: Option<Input>,
}

impl FileConfig {
    /// Reads a file.
    ///
    /// # Errors
    /// [`ConfigError::File`] or [`ConfigError::Syntax`].
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let text =
            std::fs::read_to_string(path).map_err(|source| ConfigError::File { path: path.to_path_buf(), source })?;
        toml::from_str(&text).map_err(|error| ConfigError::Syntax {
            path: path.to_path_buf(),
            reason: of_line(&text, error.span().map(|span| span.start), error.message()),
        })
    }

    /// The file that says all of a configuration, but for a pot that was opened and a session that is recorded.
    #[must_use]
    pub fn of(config: &ServerConfig) -> Self {
        let pot = &config.pot;
        let has_measures = config.form == Form::Cylinder;
        Self {
            listen: Some(config.listen),
            code: config.code.as_ref().map(JoinCode::to_string),
            code_hours: config.code_hours,
            lobby: Some(config.has_lobby),
            class: config.class.clone(),
            announce: Some(config.is_announced),
            wheels: Some(config.wheels.into()),
            people_max: Some(config.people_max.into()),
            columns: Some(pot.shape.columns()),
            rows: Some(pot.shape.rows()),
            smallest_tool_mm: None,
            finest_view_mm: None,
            height_mm: has_measures.then_some(pot.height.told_mm()),
            radius_mm: has_measures.then_some(pot.radius.told_mm()),
            wall_mm: Some(pot.wall.told_mm()),
            form: Some(config.form.name().to_owned()),
            method: Some(config.method.name().to_owned()),
            wheel_rpm: Some(config.wheel_speed.0),
            clay: None,
            wetness: Some(config.clay.wetness().liquidity_index()),
            support: Some(pot.support.name().to_owned()),
            data: config.data.clone(),
            operate: config.operate,
            arrivals: Some(config.arrivals),
            input: Some(config.input),
        }
    }

    /// The text of the file.
    ///
    /// # Errors
    /// What the writer of TOML says.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// The same with what flags say of tool and viewer; a tool of theirs stands in the place of the file's own grid.
    #[must_use]
    pub fn with_finest(mut self, tool_mm: Option<f32>, view_mm: Option<f32>) -> Self {
        if tool_mm.is_some() {
            (self.columns, self.rows) = (None, None);
        }
        self.smallest_tool_mm = tool_mm.or(self.smallest_tool_mm);
        self.finest_view_mm = view_mm.or(self.finest_view_mm);
        self
    }

    /// The defaults with this file's entries in place; ranges are looked at by [`ServerConfig::checked`].
    ///
    /// # Errors
    /// [`ConfigError`] for entries that mean nothing, or do not go together.
    pub fn into_config(self) -> Result<ServerConfig, ConfigError> {
        let mut config = ServerConfig::default();
        let pot = &mut config.pot;
        let (columns, rows) = (pot.shape.columns(), pot.shape.rows());
        pot.shape = GridShape::new(self.columns.unwrap_or(columns), self.rows.unwrap_or(rows))?;
        config.finest = match (self.smallest_tool_mm, self.finest_view_mm) {
            (Some(_), _) if self.columns.is_some() || self.rows.is_some() => return Err(ConfigError::GridTwice),
            (None, Some(_)) => return Err(ConfigError::ViewAlone),
            (tool, seen) => tool.map(|tool| Finest::of_mm(tool, seen)),
        };
        pot.height = self.height_mm.map_or(pot.height, Metres::from_mm);
        pot.radius = self.radius_mm.map_or(pot.radius, Metres::from_mm);
        pot.wall = self.wall_mm.map_or(pot.wall, Metres::from_mm);
        config.listen = self.listen.unwrap_or(config.listen);
        config.code = self.code.map(|code| code.parse()).transpose()?;
        config.code_hours = self.code_hours;
        config.has_lobby = self.lobby.unwrap_or(config.has_lobby);
        config.class = self.class;
        config.is_announced = self.announce.unwrap_or(config.is_announced);
        config.wheels = self.wheels.map_or(config.wheels, |wheels| wheels as u16);
        config.people_max = self.people_max.map_or(config.people_max, |people| people as u16);
        config.wheel_speed = self.wheel_rpm.map_or(config.wheel_speed, Rpm);
        config.data = self.data;
        config.operate = self.operate;
        config.arrivals = self.arrivals.unwrap_or(config.arrivals);
        config.input = self.input.unwrap_or(config.input);
        if let Some(name) = self.form {
            config.form = Form::from_name(&name).ok_or(ConfigError::Form { name })?;
            if config.form != Form::Cylinder && (self.height_mm.is_some() || self.radius_mm.is_some()) {
                return Err(ConfigError::Measures { form: config.form.name() });
            }
        }
        if let Some(name) = self.support {
            config.pot.support = Support::from_name(&name).ok_or(ConfigError::Support { name })?;
        }
        if let Some(name) = self.method {
            config.method = MethodKind::from_name(&name).ok_or(ConfigError::Method { name })?;
        }
        let wetness = match (self.clay, self.wetness) {
            (Some(_), Some(_)) => return Err(ConfigError::ClayTwice),
            (Some(name), None) => Some(Preset::from_name(&name).ok_or(ConfigError::Clay { name })?.wetness()),
            (None, Some(index)) => Some(Wetness::new(index)?),
            (None, None) => None,
        };
        config.clay = wetness.map_or(config.clay, Material::from_wetness);
        Ok(config)
    }
}
