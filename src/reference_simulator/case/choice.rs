//! Random choices of a case before its test.

use super::layout::Layout;
use super::plan::{Kind, Slot};
use super::subject::Subject;
use crate::draw::Draw;
use crate::effect::Effect;
use crate::hammer::setting::Setting;
use crate::machine::catalogue::{any_size, bench};
use crate::machine::nuisance::Nuisance;

/// Force levels of a test at several levels, over the nominal force.
const LEVELS: [f64; 3] = [0.3, 1.0, 3.0];

/// Machine, test and effects of a case.
pub struct Choice {
    /// Machine, nuisance parameters and effects.
    pub subject: Subject,
    /// Settings of the test.
    pub setting: Setting,
    /// Channels of the first measurement.
    pub layout: Layout,
    /// Force levels.
    pub levels: Vec<f64>,
    /// Line spacing over frequency.
    pub spacing: f64,
    /// Nominal force, N.
    pub force_n: f64,
    /// Whether the machine is the published bench.
    pub is_bench: bool,
}

impl Choice {
    /// Draws machine, nuisance parameters, effects of size 1 and settings.
    pub fn random(slot: &Slot, attempt: usize, draw: &mut Draw) -> Self {
        let needs = |held: bool| slot.effects.iter().chain(&slot.partner).any(|effect| !effect.fits(!held));
        let held = needs(true) || (!needs(false) && draw.chance(0.75));
        let is_bench = draw.chance(0.25);
        let drawn = if is_bench { bench(held, draw) } else { any_size(held, draw) };
        let nuisance = Nuisance::random(drawn.nut_m.len(), draw);
        let effects = slot.effects.iter().map(|&kind| Effect::random(kind, &drawn, draw)).collect();
        let setting = Setting {
            rate_hz: Setting::rate_for(drawn.band_hz),
            samples: 16384,
            band_hz: drawn.band_hz,
            lowest_hz: 6.0,
            averages: 5 + draw.index(6),
            width_s: 1.1 / drawn.band_hz * draw.between(0.9, 1.1),
            spread: 0.15,
            noise: draw.log_between(0.015, 0.05),
            noise_corner_hz: draw.between(1.0, 5.0),
            bits: 20,
        };
        let spacing = 1.0 / draw.between(120.0, 220.0);
        let force_n = (500.0 * (drawn.description.table_mass_kg / 272.0).sqrt() / 50.0).round().max(1.0) * 50.0;
        // Later attempts use a layout with more channels: a layout may be unable to show an effect on any machine.
        let place = Layout::ALL.iter().position(|&layout| layout == slot.layout).unwrap_or(0);
        let layout = if slot.kind == Kind::LookAlike {
            Layout::ALL[(place + attempt / 8).min(2)]
        } else {
            Layout::ALL[(place + attempt / 4).min(3)]
        };
        let levels = if slot.levels { LEVELS.to_vec() } else { vec![1.0] };
        Self { subject: Subject { drawn, nuisance, effects }, setting, layout, levels, spacing, force_n, is_bench }
    }
}
