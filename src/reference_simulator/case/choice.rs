//! Random choices of a case before its test.

use super::channel_set::ChannelSet;
use super::fit::fitted_of;
use super::plan::{Kind, Slot};
use super::record::Scatter;
use super::subject::Subject;
use crate::draw::Draw;
use crate::effect::{Effect, EffectKind};
use crate::hammer::setting::Setting;
use crate::machine::catalogue::{any_size, bench};
use crate::machine::layout::Layout;
use crate::machine::nuisance::Nuisance;
use crate::machine::point::{Channel, Point};

/// Force levels of a test at several levels, over the nominal force.
const LEVELS: [f64; 3] = [0.3, 1.0, 3.0];

/// Machine, test and effects of a case.
pub struct Choice {
    /// Machine, nuisance parameters and effects.
    pub subject: Subject,
    /// Settings of the test.
    pub setting: Setting,
    /// Channels of the first measurement.
    pub channels: Vec<Channel>,
    /// Numbers of the positions that a diagnosis is given to fit.
    pub given: Vec<usize>,
    /// How the files state the scatter of a line.
    pub scatter: Scatter,
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
        let always = slot.layout.is_some_and(Layout::always_holds);
        let held = always || needs(true) || (!needs(false) && draw.chance(0.75));
        let mut is_bench = false;
        let (drawn, nuisance) = match slot.layout {
            None => {
                is_bench = draw.chance(0.25);
                let drawn = if is_bench { bench(held, draw) } else { any_size(held, draw) };
                let nuisance = Nuisance::random(drawn.nut_m.len(), draw);
                (drawn, nuisance)
            }
            Some(layout) => {
                let lacks_guide = slot
                    .effects
                    .iter()
                    .chain(&slot.partner)
                    .any(|effect| *effect == EffectKind::GuideViscous);
                let has_guide = layout == Layout::Vertical || (!lacks_guide && draw.chance(0.7));
                let drawn = layout.machine(held, has_guide, draw);
                let nuisance = Nuisance::of_layout(&drawn, draw);
                (drawn, nuisance)
            }
        };
        let effects = slot.effects.iter().map(|&kind| drawn_effect(kind, slot, &drawn, draw)).collect();
        let setting = Setting {
            rate_hz: Setting::rate_for(drawn.band_hz),
            samples: 16384,
            band_hz: drawn.band_hz,
            averages: 5 + draw.index(6),
            width_s: 1.1 / drawn.band_hz * draw.between(0.9, 1.1),
            noise: draw.log_between(0.015, 0.05),
            noise_corner_hz: draw.between(1.0, 5.0),
        };
        let spacing = 1.0 / draw.between(120.0, 220.0);
        let force_n =
            (500.0 * (drawn.description.table_mass_kg / 272.0).sqrt() / 50.0).round().max(1.0) * 50.0;
        let levels = if slot.levels { LEVELS.to_vec() } else { vec![1.0] };
        let positions = drawn.nut_m.len();
        let (channels, scatter) = match slot.layout {
            None => (channels_of(slot, attempt).channels(), Scatter::Coherence),
            Some(_) => (
                drawn_channels(slot, attempt, draw),
                if draw.chance(0.3) { Scatter::Deviation } else { Scatter::Coherence },
            ),
        };
        // Three positions are too few to hold one out: all are given.
        let given = if positions > 3 { fitted_of(positions) } else { (0..positions).collect() };
        Self {
            subject: Subject { drawn, nuisance, effects },
            setting,
            channels,
            given,
            scatter,
            levels,
            spacing,
            force_n,
            is_bench,
        }
    }
}

/// Draws an effect of size 1. The housing of a floating bearing carries no axial load, so the other one
/// tilts.
fn drawn_effect(
    kind: EffectKind,
    slot: &Slot,
    drawn: &crate::machine::catalogue::DrawnMachine,
    draw: &mut Draw,
) -> Effect {
    let mut effect = Effect::random(kind, drawn, draw);
    if slot.layout == Some(Layout::FixedFloating) && kind == EffectKind::HousingTilt {
        effect.shape[5] *= 0.5;
    }
    effect
}

/// Returns the channels of an attempt. Later attempts have more: few channels may be unable to show an effect
/// on any machine.
fn channels_of(slot: &Slot, attempt: usize) -> ChannelSet {
    let place = ChannelSet::ALL.iter().position(|&set| set == slot.channel_set).unwrap_or(0);
    if slot.kind == Kind::LookAlike {
        ChannelSet::ALL[(place + attempt / 8).min(2)]
    } else {
        ChannelSet::ALL[(place + attempt / 4).min(3)]
    }
}

/// Draws one to four channels, the table first; later attempts have more, and look-alikes begin with the
/// table alone.
fn drawn_channels(slot: &Slot, attempt: usize, draw: &mut Draw) -> Vec<Channel> {
    let mut others = [
        Channel::new(Point::Rotor, Point::Table),
        Channel::new(Point::Screw, Point::Table),
        Channel::new(Point::Left, Point::Table),
        Channel::new(Point::Right, Point::Table),
        Channel::direct(Point::Rotor),
    ];
    draw.shuffle(&mut others);
    let (first, most) = if slot.kind == Kind::LookAlike { (1, 3) } else { (1 + draw.index(4), 4) };
    let count = (first + attempt / 5).min(most);
    std::iter::once(Channel::direct(Point::Table)).chain(others).take(count).collect()
}
