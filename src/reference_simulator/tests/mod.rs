//! Checks of the truth: elements against closed forms, physics, the statistics of the hammer test, cases.

mod case;
mod chain;
mod element;
mod hammer;
mod physics;

use super::case::Subject;
use super::draw::Draw;
use super::hammer::setting::Setting;
use super::machine::catalogue::{any_size, bench};
use super::machine::nuisance::Nuisance;

/// The bench (even seeds) or a machine of any size, with ordinary nuisances.
fn subject(seed: u64) -> Subject {
    let mut draw = Draw::new(seed);
    let drawn = if seed.is_multiple_of(2) { bench(true, &mut draw) } else { any_size(true, &mut draw) };
    let nuisance = Nuisance::drawn(drawn.nut_m.len(), &mut draw);
    Subject { drawn, nuisance, effects: Vec::new() }
}

/// A usual test of a band.
fn setting(band_hz: f64) -> Setting {
    Setting {
        rate_hz: Setting::rate_for(band_hz),
        samples: 16384,
        band_hz,
        lowest_hz: 6.0,
        averages: 8,
        width_s: 1.1 / band_hz,
        spread: 0.15,
        noise: 0.03,
        noise_corner_hz: 2.0,
        bits: 20,
    }
}
