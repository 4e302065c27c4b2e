//! Table of the nuisance parameters of motion records and their standard deviations: what axes and their
//! records commonly have although no description states it. The fit of parameters and the diagnosis take it
//! from here.
//!
//! The two ask different questions. A fit trusts the description, and corrects its parameters for any delay
//! and friction that it leaves out. A diagnosis doubts the description. It must not explain by a nuisance
//! parameter what it is to name, such as `control-delay` or `position-friction`, and it must not measure a
//! nuisance parameter by friction that the description may lack. Where a row has two values, this is why.

/// Standard deviation of the delay of the motion behind the recorded force in a fit (samples of the record).
///
/// # Source  a drive holds its force for one sample, which delays the motion by half a sample; its current
///   loop adds about as much.
pub const DELAY_SAMPLES: f64 = 1.0;
/// The same in a diagnosis (samples of the record): that of the held force alone, 0 to half a sample. A
/// longer delay is the effect `control-delay`.
pub const HOLD_SAMPLES: f64 = 0.25;

/// Speed over the fastest (1) below which a reversal blurs friction in a fit, and the standard deviation of
/// the change over dry friction (1). There dry friction takes any value up to its level. A diagnosis
/// describes the same by [`PRESLIDING`], which depends on the way since the reversal.
pub const REVERSAL: (f64, f64) = (0.02, 0.3);
/// Travels (m) of the presliding over which friction builds up, the wind-up of the parts that carry it
/// included, and the standard deviations of the share of friction that does (1).
pub const PRESLIDING: [(f64, f64); 4] = [(0.4e-6, 1.0), (1e-6, 1.0), (2e-6, 0.5), (4e-6, 0.5)];

/// Speeds over the fastest (1) below which friction rises, and the standard deviation of that rise over dry
/// friction (1).
///
/// # Source  mixed friction of lubricated seals and rolling guides; the speeds span the Stribeck velocities
///   of feed axes, a few mm/s to tens of mm/s.
pub const LOW_SPEEDS: [f64; 2] = [0.02, 0.1];
/// See [`LOW_SPEEDS`].
pub const LOW_SPEED_RISE: f64 = 0.03;

/// Number of half-waves of friction along the travel.
pub const TRAVEL_HALF_WAVES: u32 = 7;
/// Standard deviation of friction along the travel over dry friction (1), in a fit. Half-wave 0 is the mean
/// over the travel, by which friction on this travel differs from that of the axis.
///
/// # Source  guides are ground to a few percent of preload.
pub const FRICTION_ALONG_TRAVEL: f64 = 0.03;
/// Standard deviation of friction, and of force, along the travel over the root mean square of the force (1),
/// in a diagnosis: the description may lack friction. A fit estimates the size of this variation. A diagnosis
/// does not, since a large one is the effect `position-friction`, and takes half of it.
pub const FORCE_ALONG_TRAVEL: f64 = 0.015;

/// Returns the standard deviation of the n-th half-wave along the travel over that of the first: above the
/// third it falls with the wavelength.
pub fn half_wave_share(n: u32) -> f64 {
    (3.0 / f64::from(n.max(1))).min(1.0)
}

/// Root mean square of the ripple along the travel over that of the force (1), in a fit. A diagnosis has the
/// effect `torque-ripple`.
///
/// # Source  cogging and commutation of servo motors leave one to a few percent of the rated torque.
pub const RIPPLE: f64 = 0.05;
/// Number of half-waves of the ripple along the travel.
pub const RIPPLE_HALF_WAVES: u32 = 60;

/// Standard deviations of friction and of force that drift with time, over the root mean square of the force
/// (1).
///
/// # Source  friction of a warm axis changes by percents within a record.
pub const DRIFT: f64 = 0.01;
/// Standard deviation of the share of viscous friction at the fastest speed lost by shear thinning of the
/// film (1), in proportion to speed. With 5 % and more, weak dry friction missing from a description would
/// remain undetected.
///
/// # Source  friction of a film grows with less than the speed; in rolling bearings with its 2/3 power, after
///   Palmgren.
pub const THINNING: f64 = 0.03;
/// Compliances of a joint with undescribed parts in series, over the described compliance (1); each in
/// addition to the one before.
///
/// # Source  bearings, screw and coupling together are one to four times as compliant as the nut of a simple
///   description.
pub const COMPLIANCES: [f64; 3] = [1.0, 2.0, 4.0];
/// Standard deviations of wind-up, and of friction on its other side, over the described values (1).
pub const WIND_UP: f64 = 2.0;
/// Standard deviation of the scale error along the travel (m per m of travel).
///
/// # Source  linear scales of machine tools are specified to ±3 µm (some to ±5 µm) per metre.
pub const SCALE_ERROR: f64 = 2e-6;
