//! The list of scenarios: what each is called, what it must keep to and why, and who is known to fail.
//!
//! A scenario is an entry here and a function in one of the files beside; nothing else knows of it.
//! Invariant: names are unique, and a published method fails where it is listed as failing and nowhere else.

use pottery_shared::clay::MethodKind::{self, Improved, Original};

use super::mechanism::Grip;
use super::{felt, guided, jolts};
use crate::failures::{Bound, Scenario};

const NONE: &[MethodKind] = &[];
const ORIGINAL: &[MethodKind] = &[Original];
const PUBLISHED: &[MethodKind] = &[Original, Improved];

/// The resolution of a PHANToM Omni, m.
const OMNI_M: f32 = 55e-6;

/// Every scenario, in the order of the table.
pub const SCENARIOS: &[Scenario] = &[
    Scenario {
        name: "a light hand on a stiffer and stiffer wall",
        figure: "least stable stiffness over b/(T/2 + t_d) at 0 to 5 ms of delay",
        unit: "",
        bound: Bound::AtLeast(0.8),
        reason: "four fifths of what theory allows; a filter on the force leaves a twentieth",
        fails: PUBLISHED,
        measure: |method| felt::stiffness(method, Grip::LIGHT),
    },
    Scenario {
        name: "the standard hand on a stiffer and stiffer wall",
        figure: "least stable stiffness over b/(T/2 + t_d) at 0 to 5 ms of delay",
        unit: "",
        bound: Bound::AtLeast(0.8),
        reason: "the same",
        fails: ORIGINAL,
        measure: |method| felt::stiffness(method, Grip::STANDARD),
    },
    Scenario {
        name: "a firm hand on a stiffer and stiffer wall",
        figure: "least stable stiffness over b/(T/2 + t_d) at 0 to 5 ms of delay",
        unit: "",
        bound: Bound::AtLeast(0.8),
        reason: "the same",
        fails: ORIGINAL,
        measure: |method| felt::stiffness(method, Grip::FIRM),
    },
    Scenario {
        name: "a hand rests on the clay with 0.5 N",
        figure: "force above 20 Hz over the mean force",
        unit: "%",
        bound: Bound::AtMost(5.0),
        reason: "half of the 7–10 % from which on forces are told apart; who has no force left there is out",
        fails: PUBLISHED,
        measure: |method| felt::light_contact(method, 0.0, 0.0),
    },
    Scenario {
        name: "the same in steps of 0.055 mm",
        figure: "force above 20 Hz over the mean force",
        unit: "%",
        bound: Bound::AtMost(5.0),
        reason: "the same: the encoder of a PHANToM Omni is not felt; a step of it is 38 mN, which at 0.3 N would come to 7 %",
        fails: PUBLISHED,
        measure: |method| felt::light_contact(method, 0.0, OMNI_M),
    },
    Scenario {
        name: "the same on a wheel of 60 rpm",
        figure: "force above 20 Hz over the mean force",
        unit: "%",
        bound: Bound::AtMost(5.0),
        reason: "the same: a round pot that turns is smooth",
        fails: NONE,
        measure: |method| felt::light_contact(method, 60.0, OMNI_M),
    },
    Scenario {
        name: "grit in steps of 0.055 mm",
        figure: "ticks in a row in which the force goes up and down in turn",
        unit: "",
        bound: Bound::AtMost(3.0),
        reason: "a step of the encoder may be felt once and not as a row of them",
        fails: NONE,
        measure: felt::grit,
    },
    Scenario {
        name: "a hand presses with 1.5 N, a tick late",
        figure: "how fast it is shaken",
        unit: "mm/s",
        bound: Bound::AtMost(5.0),
        reason: "clay rendered without a coupling shakes it at 107 mm/s",
        fails: ORIGINAL,
        measure: felt::shaken,
    },
    Scenario {
        name: "ten presses and releases by a hand",
        figure: "least energy that device and clay have taken",
        unit: "mJ",
        bound: Bound::AtLeast(-1.0),
        reason: "clay only takes energy; a millijoule is what sampling a stiff contact at 1 kHz may feign",
        fails: ORIGINAL,
        measure: felt::energy,
    },
    Scenario {
        name: "the whole loop at 1 to 10 kHz",
        figure: "difference of the dents a hand has made after 1 s",
        unit: "%",
        bound: Bound::AtMost(2.0),
        reason: "a quarter of the 7–10 % from which on forces are told apart",
        fails: NONE,
        measure: felt::rate_of_the_loop,
    },
    Scenario {
        name: "in at 0.2 m/s until the centre is in the clay, and out",
        figure: "largest change of force in a tick over K·v·T",
        unit: "",
        bound: Bound::AtMost(2.0),
        reason: "an even spring changes by K·v·T a tick, twice that is felt as a knock; K is the stiffest that the hand feels",
        fails: PUBLISHED,
        measure: jolts::centre_crosses,
    },
    Scenario {
        name: "the loop stands still for 50 ms",
        figure: "largest change of force in a tick after it",
        unit: "N",
        // 3.3 N in f32 are known to 2e-7 N
        bound: Bound::AtMost(0.100_001),
        reason: "what has piled up comes over tens of milliseconds and not at once",
        fails: PUBLISHED,
        measure: jolts::stall,
    },
    Scenario {
        name: "the device jumps, reports no number or is gone",
        figure: "ticks until there is no force",
        unit: "",
        bound: Bound::AtMost(2.0),
        reason: "no motor follows faster; the session goes on and sound places are felt again. All methods have this gate here",
        fails: NONE,
        measure: jolts::faults,
    },
    Scenario {
        name: "the server lowers the clay under the tool by 0.5 mm",
        figure: "largest change of force in 20 ms over 7 % of it or 0.1 N",
        unit: "",
        bound: Bound::AtMost(1.0),
        reason: "less than a hand tells apart; the published methods have hardly a force left by then that could change",
        fails: NONE,
        measure: jolts::correction,
    },
    Scenario {
        name: "clay that somebody undoes comes back under the tool, 2 mm higher",
        figure: "largest change of force in 20 ms over 7 % of it or 0.1 N",
        unit: "",
        bound: Bound::AtMost(1.0),
        reason: "as for any other correction, however far; in the published methods clay that stands so deep in the tool gives way \
                 in 20 ms by more",
        fails: PUBLISHED,
        measure: jolts::undoing,
    },
    Scenario {
        name: "the tool is thrown through the pot at 4 m/s",
        figure: "how far it gets into the clay over the wall's thickness",
        unit: "",
        bound: Bound::AtMost(1.0),
        reason: "a tool outside stays outside, however far the device goes",
        fails: PUBLISHED,
        measure: jolts::thrown_through,
    },
    Scenario {
        name: "the tool comes at 4 m/s",
        figure: "how far it is in the clay in the tick in which it touches",
        unit: "mm",
        bound: Bound::AtMost(0.1),
        reason: "it is stopped where it first touches; 4 mm in a tick would be a hole that nobody pressed",
        fails: PUBLISHED,
        measure: jolts::first_touch,
    },
    Scenario {
        name: "more force is wanted than the device gives",
        figure: "largest angle between the force given and the one wanted",
        unit: "°",
        bound: Bound::AtMost(1.0),
        reason: "a hand tells directions of force apart from 20° on; a limit axis by axis would turn it by 30°",
        fails: NONE,
        measure: jolts::saturation,
    },
    Scenario {
        name: "a teacher guides a hand through 100 ms there and back, 40 ms of jitter and 5 % of loss",
        figure: "least of what the teacher's hand has given at her device, less the work on the student's at theirs",
        unit: "mJ",
        bound: Bound::AtLeast(-1.0),
        reason: "both devices and the network are a passive two-port, with nothing granted; a millijoule is on its way to a late device",
        fails: NONE,
        measure: guided::energy,
    },
    Scenario {
        name: "the teacher stops, vanishes, jumps by 50 mm or is no number",
        figure: "least of what the teacher's hand has given at her device, less the work on the student's at theirs",
        unit: "mJ",
        bound: Bound::AtLeast(-1.0),
        reason: "the same, whatever becomes of her",
        fails: NONE,
        measure: guided::odd_energy,
    },
    Scenario {
        name: "the same teacher",
        figure: "largest rise of force in a tick",
        unit: "N",
        bound: Bound::AtMost(0.1),
        reason: "a tenth of a newton is not told apart; what her tool does comes over tens of milliseconds, and goes at once",
        fails: NONE,
        measure: guided::odd_jolt,
    },
    Scenario {
        name: "a hand is guided as strongly as can be",
        figure: "largest force of guidance over a quarter of the device's",
        unit: "",
        // a force in f32 is known to 2e-7 of it
        bound: Bound::AtMost(1.000_001),
        reason: "whoever holds against it wins: a hand gives tens of newtons, and three quarters are left for the clay",
        fails: NONE,
        measure: guided::strength,
    },
    Scenario {
        name: "a student ends guidance while the teacher goes on",
        figure: "ticks until there is no force",
        unit: "",
        bound: Bound::AtMost(2.0),
        reason: "as for a fault: the student's word counts before anybody else has heard it",
        fails: NONE,
        measure: guided::ticks_to_end,
    },
    Scenario {
        name: "a light hand is led with half the strength",
        figure: "how far its tool is from the teacher's, over one that only sees her",
        unit: "",
        bound: Bound::AtMost(0.8),
        reason: "a fifth nearer is seen; the published programs guide nobody",
        fails: PUBLISHED,
        measure: guided::help,
    },
];
