//! The table of a machine's numbers: each stands once, with key, meaning, plausible magnitude, range and use.

use super::error::{MachineError, fault};
use super::quantity::{
    ALONG_MOTOR, ALONG_TRAVEL, BALL_DIAMETER, CURRENT_GAIN, DAMPING, DELAY, DENSITY, DIAMETER, DISPLACEMENT,
    DRIVE_CONSTANT, ENCODER_STEP, EXPANSION, EXPONENT, FEED_FORWARD, FORCE, FRICTION, GAP, GRAVITY,
    INDUCTANCE, INERTIA, LEAD, LENGTH, LOAD, LOSS, MASS, OTHER, OUTPUT, PERIOD, POSITION_GAIN,
    PRESLIDING_DAMPING, PRESLIDING_STIFFNESS, PRESSURE, PROPORTIONAL_DAMPING, RATE, RATIO, RESISTANCE, SHARE,
    SHEAR_MODULUS, STIFFNESS, TIME, TRAVEL, VELOCITY, VELOCITY_GAIN, VOLTAGE, YOUNGS_MODULUS,
};
use super::{
    Bending, BendingFile, Chain, CurrentFile, CurrentLoop, Drive, DriveFile, Joint, JointPatch, Lever,
    LeverFile, Machine, Motor, MotorFile, NumberSource, Point, PointMotion, PointPatch, Quantity, Shaft,
    ShaftFile, TargetKind, Value,
};

/// A number of a machine's description.
#[derive(Debug, Clone, Copy)]
pub struct Number {
    /// Key below its part in the configuration, for example `friction.coulomb`.
    pub key: &'static str,
    /// Description with `{}` for the name of the part; empty for a number that no document names.
    pub words: &'static str,
    /// What it measures.
    pub quantity: Quantity,
    /// Values that it may take.
    pub range: Range,
    /// What depends on it.
    pub reach: Reach,
    /// How the changes of an effect name it; `None` for a number that no effect changes.
    pub target: Option<TargetKind>,
}

/// Values that a number may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// Finite and above 0.
    Positive,
    /// Above 0; infinite where a limit is absent.
    Limit,
    /// Finite, 0 or above.
    NotNegative,
    /// From 0 to `LARGEST_LOSS`.
    Loss,
    /// Finite, of either sign.
    Finite,
    /// From 0 to below 1.
    BelowOne,
    /// Not checked by itself.
    Unchecked,
}

/// Largest loss factor that a description may reach (1): where its quantity ends, too.
const LARGEST_LOSS: f64 = 100.0;

/// What depends on a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// Frequency responses, modes and motion.
    All,
    /// Motion, and frequency responses with the drive's loops closed.
    ClosedLoop,
    /// Motion alone.
    Motion,
    /// Motion alone; unless it is 0, frequency responses ignore something of its joint.
    MotionIgnored,
}

/// A number of parts of type P, which files of type F state.
pub(super) struct Row<P, F> {
    pub(super) number: Number,
    value: fn(&P) -> Option<&Value>,
    value_mut: fn(&mut P) -> Option<&mut Value>,
    /// What a file states; `None` for a number that no file states.
    stated: fn(&F) -> Option<&NumberSource>,
}

/// A number or source of a number that may be absent.
trait Given {
    type Item;
    fn given(&self) -> Option<&Self::Item>;
    fn given_mut(&mut self) -> Option<&mut Self::Item>;
}

impl<T> Given for Option<T> {
    type Item = T;
    fn given(&self) -> Option<&T> {
        self.as_ref()
    }
    fn given_mut(&mut self) -> Option<&mut T> {
        self.as_mut()
    }
}

macro_rules! always_given {
    ($($of:ty),+) => {$(
        impl Given for $of {
            type Item = Self;
            fn given(&self) -> Option<&Self> {
                Some(self)
            }
            fn given_mut(&mut self) -> Option<&mut Self> {
                Some(self)
            }
        }
    )+};
}
always_given!(Value, NumberSource);

/// Writes a table of numbers, one a line: its place in the file, also its key; `=>` its place in the part,
/// where that differs; words, quantity, range, reach, and how effects name it. `none =>` begins a number that
/// no file states, under the key of its place.
macro_rules! numbers {
    ($(#[$doc:meta])* $table:ident: $part:ty, $file:ty, $prefix:literal;
     $($place:tt $(.$inner:ident)* $([$at:literal])? $(=> $own:ident $(.$own_inner:ident)*)?: $words:literal, $quantity:expr, $range:ident, $reach:ident $(, $target:ident)?;)*) => {
        $(#[$doc])*
        pub(super) const $table: &[Row<$part, $file>] = &[$(Row {
            number: Number {
                key: numbers!(@key $prefix, $place $(.$inner)* $(=> $own)?),
                words: $words,
                quantity: $quantity,
                range: Range::$range,
                reach: Reach::$reach,
                target: numbers!(@target $($target)?),
            },
            value: |part| numbers!(@value part, $place $(.$inner)* $([$at])? $(=> $own $(.$own_inner)*)?).given(),
            value_mut: |part| numbers!(@value part, $place $(.$inner)* $([$at])? $(=> $own $(.$own_inner)*)?).given_mut(),
            stated: |file| numbers!(@stated file, $place $(.$inner)* $([$at])?),
        }),*];
    };
    (@key $prefix:literal, none => $own:ident) => { concat!($prefix, stringify!($own)) };
    (@key $prefix:literal, $place:ident $(.$inner:ident)* $(=> $own:ident)?) => {
        concat!($prefix, stringify!($place) $(, ".", stringify!($inner))*)
    };
    (@target) => { None };
    (@target $target:ident) => { Some(TargetKind::$target) };
    (@value $part:ident, $place:tt $(.$inner:ident)* $([$at:literal])? => $own:ident $(.$own_inner:ident)*) => { $part.$own$(.$own_inner)* };
    (@value $part:ident, $place:ident $(.$inner:ident)* $([$at:literal])?) => { $part.$place$(.$inner)*$([$at])? };
    (@stated $file:ident, none) => {{ let _ = $file; None }};
    (@stated $file:ident, $place:ident $(.$inner:ident)* $([$at:literal])?) => { $file.$place$(.$inner)*$([$at])?.given() };
}

const fn inertia(
    (key, words, quantity): (&'static str, &'static str, Quantity),
    value: fn(&Point) -> Option<&Value>,
    value_mut: fn(&mut Point) -> Option<&mut Value>,
    stated: fn(&PointPatch) -> Option<&NumberSource>,
) -> Row<Point, PointPatch> {
    let target = Some(TargetKind::PointInertia);
    Row {
        number: Number { key, words, quantity, range: Range::NotNegative, reach: Reach::All, target },
        value,
        value_mut,
        stated,
    }
}

/// Inertias of points: a mass or a moment of inertia.
pub(super) const POINT: &[Row<Point, PointPatch>] = &[
    inertia(
        ("mass_kg", "mass of {}", MASS),
        |point| (point.motion == PointMotion::Translation).then_some(&point.inertia),
        |point| (point.motion == PointMotion::Translation).then_some(&mut point.inertia),
        |file| (file.motion == PointMotion::Translation).then_some(&file.inertia),
    ),
    inertia(
        ("inertia_kg_m2", "inertia of {}", INERTIA),
        |point| (point.motion == PointMotion::Rotation).then_some(&point.inertia),
        |point| (point.motion == PointMotion::Rotation).then_some(&mut point.inertia),
        |file| (file.motion == PointMotion::Rotation).then_some(&file.inertia),
    ),
];

numbers! { SHAFT: Shaft, ShaftFile, "";
    length_m => length: "length of {}", LENGTH, Positive, All;
    diameter_m => diameter: "diameter of {}", DIAMETER, Positive, All, ShaftDiameter;
    bore_ratio: "bore ratio of {}", RATIO, BelowOne, All, ShaftBore;
    youngs_modulus_pa => youngs_modulus: "Young's modulus of {}", YOUNGS_MODULUS, Positive, All, ShaftYoungsModulus;
    shear_modulus_pa => shear_modulus: "shear modulus of {}", SHEAR_MODULUS, Positive, All, ShaftShearModulus;
    density_kg_m3 => density: "density of {}", DENSITY, Positive, All;
    loss_factor: "loss factor of {}", LOSS, Loss, All, ShaftLossFactor;
    none => nut_position: "nut position on {}", DISPLACEMENT, Unchecked, All, NutPosition;
    none => nut_support_factor: "", RATIO, Unchecked, All;
    none => nut_support_offset: "", RATIO, Unchecked, All;
}

numbers! { BENDING: Bending, BendingFile, "";
    misalignment: "misalignment of {}", RATIO, Finite, All;
    eccentricity_m => eccentricity: "eccentricity of {}", DISPLACEMENT, NotNegative, All;
    lateral_stiffness: "lateral stiffness of {}", STIFFNESS, NotNegative, All;
    clamping[0]: "left clamping of {}", RATIO, NotNegative, All;
    clamping[1]: "right clamping of {}", RATIO, NotNegative, All;
    loss_factor: "loss factor of bending of {}", LOSS, Loss, All;
}

numbers! { JOINT: Joint, JointPatch, "";
    stiffness: "stiffness of {}", STIFFNESS, NotNegative, All, JointStiffness;
    damping: "damping of {}", DAMPING, NotNegative, All, JointDamping;
    loss_factor: "loss factor of {}", LOSS, Loss, All, JointLossFactor;
    integral_rate: "integral rate of {}", RATE, NotNegative, All, JointIntegralRate;
    relaxation_stiffness: "relaxation stiffness of {}", STIFFNESS, Positive, All;
    gap: "backlash of {}", GAP, NotNegative, MotionIgnored, JointGap;
    friction.coulomb: "coulomb friction of {}", FRICTION, NotNegative, MotionIgnored, JointFriction;
    friction.offset: "offset friction of {}", FRICTION, Finite, Motion, JointFriction;
    friction.viscous_asymmetry: "viscous asymmetry friction of {}", DAMPING, Finite, MotionIgnored, JointFriction;
    friction.stribeck: "stribeck friction of {}", FRICTION, NotNegative, MotionIgnored, JointFriction;
    friction.stribeck_velocity: "stribeck velocity friction of {}", VELOCITY, NotNegative, Motion, JointFriction;
    friction.stribeck_exponent: "stribeck exponent friction of {}", EXPONENT, Positive, Motion, JointFriction;
    friction.presliding_stiffness: "presliding stiffness friction of {}", PRESLIDING_STIFFNESS, NotNegative, Motion, JointFriction;
    friction.presliding_damping: "presliding damping friction of {}", PRESLIDING_DAMPING, NotNegative, Motion, JointFriction;
    friction.position.cosine: "friction position cosine of {}", FORCE, Finite, MotionIgnored, JointFriction;
    friction.position.sine: "friction position sine of {}", FORCE, Finite, MotionIgnored, JointFriction;
    friction.position.period: "friction position period of {}", ALONG_TRAVEL, NotNegative, Motion, JointFriction;
    friction.load_share: "load share friction of {}", SHARE, NotNegative, MotionIgnored, JointFriction;
    lead_error.growth: "lead error growth of {}", EXPANSION, Finite, Motion, JointLeadError;
    lead_error.wave.cosine: "lead error wave cosine of {}", DISPLACEMENT, Finite, MotionIgnored, JointLeadError;
    lead_error.wave.sine: "lead error wave sine of {}", DISPLACEMENT, Finite, MotionIgnored, JointLeadError;
    lead_error.wave.period: "lead error wave period of {}", ALONG_TRAVEL, NotNegative, Motion, JointLeadError;
}

numbers! { DRIVE: Drive, DriveFile, "";
    constant: "constant of the drive", DRIVE_CONSTANT, Positive, ClosedLoop, Drive;
    none => force_factor: "force factor of the drive", RATIO, Positive, ClosedLoop, Drive;
    delay_s: "delay s of the drive", DELAY, NotNegative, ClosedLoop, Drive;
    saturation: "saturation of the drive", OUTPUT, Limit, Motion, Drive;
    ripple.cosine: "ripple cosine of the drive", FORCE, Finite, Motion, Drive;
    ripple.sine: "ripple sine of the drive", FORCE, Finite, Motion, Drive;
    ripple.period: "ripple period of the drive", ALONG_MOTOR, NotNegative, Motion, Drive;
    position.encoder_step => position.encoder.step: "position encoder step of the drive", ENCODER_STEP, NotNegative, Motion, Drive;
    position.gain_per_s: "position gain per s of the drive", POSITION_GAIN, NotNegative, ClosedLoop, Drive;
    position.feed_forward: "position feed forward of the drive", SHARE, NotNegative, ClosedLoop, Drive;
    velocity.encoder_step => velocity.encoder.step: "velocity encoder step of the drive", ENCODER_STEP, NotNegative, Motion, Drive;
    velocity.gain: "velocity gain of the drive", VELOCITY_GAIN, NotNegative, ClosedLoop, Drive;
    velocity.integral_time_s: "velocity integral time s of the drive", TIME, Limit, ClosedLoop, Drive;
    velocity.acceleration_feed_forward: "velocity acceleration feed forward of the drive", FEED_FORWARD, NotNegative, ClosedLoop, Drive;
}

numbers! { MOTOR: Motor, MotorFile, "motor.";
    resistance_ohm: "motor resistance ohm of the drive", RESISTANCE, NotNegative, ClosedLoop, Drive;
    inductance_h: "motor inductance h of the drive", INDUCTANCE, Positive, ClosedLoop, Drive;
    inductance_d_h: "motor inductance d h of the drive", INDUCTANCE, Positive, Motion, Drive;
    dc_link_v: "motor dc link v of the drive", VOLTAGE, Limit, Motion, Drive;
}

numbers! { CURRENT: CurrentLoop, CurrentFile, "current.";
    gain: "current gain of the drive", CURRENT_GAIN, NotNegative, ClosedLoop, Drive;
    integral_time_s: "current integral time s of the drive", TIME, Limit, ClosedLoop, Drive;
}

numbers! { LEVER: Lever, LeverFile, "";
    read => sensor_arm: "arm of the sensor at {}", RATIO, Unchecked, All;
    struck => hammer_arm: "arm of the hammer at {}", RATIO, Unchecked, All;
}

numbers! { CHAIN: Chain, (), "chain-";
    none => gain: "gain of the measuring chain", RATIO, Positive, All, ChainGain;
    none => delay: "delay of the measuring chain", DELAY, Unchecked, All, ChainDelay;
    none => power: "power of frequency of the measuring chain", RATIO, Unchecked, All, ChainPower;
}

numbers! { LOSSES: Machine, (), "";
    none => loss_dispersion: "dispersion of loss factors", RATIO, Unchecked, All, LossDispersion;
}

/// Numbers of the configuration that no parameter stands for, by their keys.
const PLAIN: &[(&[&str], Quantity)] = &[
    (&["stiffness_proportional_damping_s"], PROPORTIONAL_DAMPING),
    (&["lead_m"], LEAD),
    (&["period_s"], PERIOD),
    (&["over_s"], TIME),
    (&["limits_m"], TRAVEL),
    (&["position_gain_per_s"], POSITION_GAIN),
    (&["velocity_gain"], VELOCITY_GAIN),
    (&["preload_n", "coulomb_n", "static_n"], LOAD),
    (&["pitch_diameter_m"], DIAMETER),
    (&["ball_diameter_m"], BALL_DIAMETER),
    (&["pressure_limit_pa"], PRESSURE),
    (&["moved_mass_kg"], MASS),
    (&["gravity_m_s2"], GRAVITY),
    (&["load_n"], FORCE),
    (&["at_m", "deflection_m", "nuts_m"], DISPLACEMENT),
    (&["viscous_n_s_per_m"], DAMPING),
    (&["weight", "share", "outside_share", "conformity", "times"], RATIO),
    (
        &[
            "ball_count",
            "loaded_turns",
            "tandem",
            "pole_pairs",
            "contact_angle_deg",
            "stribeck_velocity_m_s",
            "table",
            "on",
        ],
        OTHER,
    ),
];

/// Returns the numbers of a part, each with its row.
pub(super) fn numbers_of<'p, P, F>(
    rows: &'static [Row<P, F>],
    part: &'p P,
) -> impl Iterator<Item = (&'static Number, &'p Value)> {
    rows.iter().filter_map(move |row| Some((&row.number, (row.value)(part)?)))
}

fn change_numbers_of<P, F>(
    rows: &[Row<P, F>],
    name: &str,
    part: &mut P,
    change: &mut dyn FnMut(&Number, &str, &mut Value),
) {
    for row in rows {
        if let Some(value) = (row.value_mut)(part) {
            change(&row.number, name, value);
        }
    }
}

/// Checks the ranges of numbers; `path` returns the place of a key in the description.
pub(super) fn check_ranges<'p>(
    mut numbers: impl Iterator<Item = (&'static Number, &'p Value)>,
    path: impl Fn(&str) -> String,
    at: &impl Fn(&Value) -> f64,
) -> Result<(), MachineError> {
    numbers.try_for_each(|(number, value)| number.range.check(|| path(number.key), at(value)))
}

/// Returns the numbers that a section of a file states, each with its row.
pub(super) fn stated_in<'f, P, F>(
    rows: &'static [Row<P, F>],
    file: &'f F,
) -> impl Iterator<Item = (&'static Number, &'f NumberSource)> {
    rows.iter().filter_map(move |row| Some((&row.number, (row.stated)(file)?)))
}

fn rows_of<P, F>(rows: &'static [Row<P, F>]) -> impl Iterator<Item = &'static Number> {
    rows.iter().map(|row| &row.number)
}

impl Number {
    /// Returns all numbers of a description that may be parameters.
    pub fn all() -> impl Iterator<Item = &'static Number> {
        let structure = rows_of(POINT).chain(rows_of(SHAFT)).chain(rows_of(BENDING)).chain(rows_of(JOINT));
        let drive = rows_of(DRIVE).chain(rows_of(MOTOR)).chain(rows_of(CURRENT));
        structure.chain(drive).chain(rows_of(LEVER)).chain(rows_of(CHAIN)).chain(rows_of(LOSSES))
    }

    /// Returns the key below its section: `coulomb` of `friction.coulomb`.
    pub(super) fn key_in_section(&self) -> &'static str {
        let below = |section| self.key.strip_prefix(section);
        below("friction.").or_else(|| below("lead_error.")).unwrap_or(self.key)
    }

    /// Returns the quantity of the numbers with a key; the key alone, without the sections that contain it.
    /// `None` for an unknown key.
    pub fn quantity_of(key: &str) -> Option<Quantity> {
        let own = Number::all()
            .find(|number| number.key.rsplit('.').next() == Some(key))
            .map(|number| number.quantity);
        own.or_else(|| PLAIN.iter().find(|(keys, _)| keys.contains(&key)).map(|(_, quantity)| *quantity))
    }
}

impl Range {
    /// Checks a number of a part, given by its place in the description.
    pub(super) fn check(self, part: impl FnOnce() -> String, x: f64) -> Result<(), MachineError> {
        let remedy = match self {
            Range::Unchecked => return Ok(()),
            Range::BelowOne if !(0.0..1.0).contains(&x) => "write bore over diameter, from 0 to below 1",
            _ if x.is_nan() || (x.is_infinite() && self != Range::Limit) => {
                return Err(fault(part(), format!("is {x}; write a finite number")));
            }
            Range::Positive | Range::Limit if !(x > 0.0) => "write a number above 0",
            Range::Loss if !(0.0..=LARGEST_LOSS).contains(&x) => "write a loss factor from 0 to 100",
            Range::NotNegative if !(x >= 0.0) => "write 0 or a number above it",
            _ => return Ok(()),
        };
        Err(fault(part(), format!("is {x:?}; {remedy}")))
    }
}

impl Machine {
    /// Returns all numbers of the machine, each with its row and the name of its part: of a point, joint or
    /// shaft; «drive», «measurement» or «losses».
    pub(super) fn numbers(&self) -> impl Iterator<Item = (&'static Number, &str, &Value)> {
        fn named<'p, P, F>(
            rows: &'static [Row<P, F>],
            name: &'p str,
            part: &'p P,
        ) -> impl Iterator<Item = (&'static Number, &'p str, &'p Value)> {
            numbers_of(rows, part).map(move |(number, value)| (number, name, value))
        }
        let points = self.points.iter().flat_map(|p| named(POINT, &p.name, p));
        let shafts = self.shafts.iter().flat_map(|s| named(SHAFT, &s.name, s));
        let bending = self
            .shafts
            .iter()
            .flat_map(|s| s.bending.iter().flat_map(|bending| named(BENDING, &s.name, bending)));
        let joints = self.joints.iter().flat_map(|j| named(JOINT, &j.name, j));
        let drive =
            self.drive.iter().flat_map(Drive::numbers).map(|(number, value)| (number, "drive", value));
        let levers = self.chain.levers.iter().flat_map(|l| named(LEVER, &self.points[l.point].name, l));
        points
            .chain(shafts)
            .chain(bending)
            .chain(joints)
            .chain(levers)
            .chain(named(CHAIN, "measurement", &self.chain))
            .chain(named(LOSSES, "losses", self))
            .chain(drive)
    }

    /// Calls a function for each number of the machine, with its row and the name of its part as in
    /// [`Machine::numbers`].
    pub(super) fn change_numbers(&mut self, change: &mut dyn FnMut(&Number, &str, &mut Value)) {
        self.points.iter_mut().for_each(|p| change_numbers_of(POINT, &p.name.clone(), p, change));
        for shaft in &mut self.shafts {
            change_numbers_of(SHAFT, &shaft.name.clone(), shaft, change);
            shaft
                .bending
                .iter_mut()
                .for_each(|bending| change_numbers_of(BENDING, &shaft.name, bending, change));
        }
        self.joints.iter_mut().for_each(|j| change_numbers_of(JOINT, &j.name.clone(), j, change));
        for lever in &mut self.chain.levers {
            change_numbers_of(LEVER, &self.points[lever.point].name, lever, change);
        }
        change_numbers_of(CHAIN, "measurement", &mut self.chain, change);
        change_numbers_of(LOSSES, "losses", self, change);
        if let Some(drive) = &mut self.drive {
            change_numbers_of(DRIVE, "drive", drive, change);
            drive.motor.iter_mut().for_each(|motor| change_numbers_of(MOTOR, "drive", motor, change));
            drive.current.iter_mut().for_each(|current| change_numbers_of(CURRENT, "drive", current, change));
        }
    }

    /// Writes what a section of a file states into the numbers of a part; those that it does not state stay.
    /// `path` is the section's place.
    pub(super) fn set_numbers<P, F>(
        &self,
        rows: &[Row<P, F>],
        path: &str,
        file: &F,
        part: &mut P,
    ) -> Result<(), MachineError> {
        for row in rows {
            if let (Some(source), Some(value)) = ((row.stated)(file), (row.value_mut)(part)) {
                *value = self.value(&format!("{path}.{}", row.number.key), source)?;
            }
        }
        Ok(())
    }
}

impl Drive {
    /// Returns its numbers with those of motor and current loop.
    pub(super) fn numbers(&self) -> impl Iterator<Item = (&'static Number, &Value)> {
        let motor = self.motor.iter().flat_map(|motor| numbers_of(MOTOR, motor));
        numbers_of(DRIVE, self)
            .chain(motor)
            .chain(self.current.iter().flat_map(|current| numbers_of(CURRENT, current)))
    }
}
