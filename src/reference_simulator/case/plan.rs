//! Plans: lists of the cases to generate.

use serde::{Deserialize, Serialize};

use super::channel_set::ChannelSet;
use crate::draw::Draw;
use crate::effect::EffectKind;
use crate::machine::layout::Layout;

/// Kind of a case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Nuisance parameters only, no effect.
    #[default]
    Null,
    /// As null, with a start value that is wrong by up to a factor of three, and frozen in half of the cases.
    HardNullWrongParameter,
    /// As null, with one record of a faulty channel, or two exchanged records.
    HardNullBadChannel,
    /// One effect of the library.
    Single,
    /// One of two effects that the first measurement can hardly distinguish; the follow-up should.
    LookAlike,
    /// Two effects of the library.
    Double,
    /// An effect outside the library.
    Unknown,
}

/// Strength of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Strength {
    /// Non-centrality 9, close to the noise.
    Faint,
    /// Non-centrality 25.
    Weak,
    /// Non-centrality 100.
    Clear,
    /// Non-centrality 100 or more: the gap is 1.3–3 times the gap of noise and nuisance parameters.
    Strong,
}

impl Strength {
    /// Returns the required non-centrality.
    pub fn noncentrality(self) -> f64 {
        match self {
            Strength::Faint => 9.0,
            Strength::Weak => 25.0,
            Strength::Clear | Strength::Strong => 100.0,
        }
    }

    /// Returns the strength nearest to a non-centrality.
    pub fn of(noncentrality: f64) -> Self {
        match noncentrality {
            d if d < 15.0 => Strength::Faint,
            d if d < 50.0 => Strength::Weak,
            d if d < 200.0 => Strength::Clear,
            _ => Strength::Strong,
        }
    }
}

/// Numbers of cases of each kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// Nulls with nuisance parameters only.
    pub nulls: usize,
    /// Nulls with a wrong start value.
    pub wrong_parameters: usize,
    /// Nulls with a data fault.
    pub bad_channels: usize,
    /// Single cases of each library effect, distributed evenly over strengths and channel sets.
    pub singles_per_effect: usize,
    /// Single cases with a dependence on the force level.
    pub contact_levels: usize,
    /// Cases of each true effect of each look-alike pair.
    pub look_alikes_per_truth: usize,
    /// Cases with two effects.
    pub doubles: usize,
    /// Cases of each effect outside the library.
    pub unknowns_per_effect: usize,
}

/// Specification of one case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slot {
    /// Kind.
    pub kind: Kind,
    /// Effects, the dominant one first.
    pub effects: Vec<EffectKind>,
    /// The other member of a look-alike pair.
    pub partner: Option<EffectKind>,
    /// Strength of the dominant effect.
    pub strength: Option<Strength>,
    /// Channels of the first measurement.
    pub channel_set: ChannelSet,
    /// Whether the test has three force levels.
    pub levels: bool,
    /// Layout of the machine; one of the catalogue's if absent.
    pub layout: Option<Layout>,
}

/// Cases to generate, in random order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The cases.
    pub slots: Vec<Slot>,
}

/// Pairs of effects that a table response can hardly distinguish.
pub const LOOK_ALIKES: [(EffectKind, EffectKind); 10] = [
    (EffectKind::RotorHold, EffectKind::GuideStiffness),
    (EffectKind::TableMass, EffectKind::FrfGain),
    (EffectKind::BedCompliance, EffectKind::TableRocking),
    (EffectKind::CouplingInertia, EffectKind::ScrewDiameter),
    (EffectKind::DriveFlexibility, EffectKind::CouplingInertia),
    (EffectKind::NutStiffnessPosition, EffectKind::BearingStiffnessPosition),
    (EffectKind::GuideViscous, EffectKind::TableRelaxation),
    (EffectKind::NutFlangeCompliance, EffectKind::ScrewDiameter),
    (EffectKind::ScrewBending, EffectKind::TableRocking),
    (EffectKind::ScrewLossFactor, EffectKind::GuideViscous),
];

impl Counts {
    /// The full check: about 1300 cases.
    pub const FULL: Self = Self {
        nulls: 300,
        wrong_parameters: 50,
        bad_channels: 50,
        singles_per_effect: 24,
        contact_levels: 12,
        look_alikes_per_truth: 10,
        doubles: 100,
        unknowns_per_effect: 15,
    };

    /// A quick check: about 120 cases.
    pub const QUICK: Self = Self {
        nulls: 30,
        wrong_parameters: 6,
        bad_channels: 6,
        singles_per_effect: 2,
        contact_levels: 2,
        look_alikes_per_truth: 1,
        doubles: 8,
        unknowns_per_effect: 1,
    };
}

impl Slot {
    /// Specifies a case of one kind without effects.
    pub fn plain(kind: Kind, channel_set: ChannelSet) -> Self {
        Self {
            kind,
            effects: Vec::new(),
            partner: None,
            strength: None,
            channel_set,
            levels: false,
            layout: None,
        }
    }

    /// Specifies a case of one library effect.
    pub fn single(effect: EffectKind, strength: Strength, channel_set: ChannelSet) -> Self {
        let levels = effect == EffectKind::ContactLevel;
        let strength = if effect == EffectKind::FrfQuantity { Strength::Strong } else { strength };
        Self {
            effects: vec![effect],
            strength: Some(strength),
            levels,
            ..Self::plain(Kind::Single, channel_set)
        }
    }
}

impl Plan {
    /// Distributes the counts over strengths and channel sets, and shuffles the cases.
    pub fn from_counts(counts: &Counts, seed: u64) -> Self {
        Self::with_outside(counts, seed, EffectKind::UNLISTED.into_iter())
    }

    /// Plans cases of one layout, or of all in turn. In a turn an effect goes to the next layout that can
    /// have it; on one layout alone the cases of effects that it cannot have stay in the plan and are
    /// refused.
    pub fn on_layouts(counts: &Counts, seed: u64, layout: Option<Layout>) -> Self {
        let mut plan = Self::with_outside(
            counts,
            seed,
            EffectKind::UNLISTED.into_iter().chain([EffectKind::FrictionDamper]),
        );
        for (index, slot) in plan.slots.iter_mut().enumerate() {
            let can_have = |layout: &Layout| {
                slot.effects.iter().chain(&slot.partner).all(|effect| layout.refusal(*effect).is_none())
            };
            let mut turn =
                Layout::ALL.into_iter().cycle().skip(index % Layout::ALL.len()).take(Layout::ALL.len());
            slot.layout = layout.or_else(|| turn.find(can_have));
        }
        plan
    }

    fn with_outside(counts: &Counts, seed: u64, outside: impl Iterator<Item = EffectKind>) -> Self {
        let strengths = [
            Strength::Faint,
            Strength::Weak,
            Strength::Strong,
            Strength::Clear,
            Strength::Strong,
            Strength::Strong,
        ];
        let clear = [Strength::Strong, Strength::Strong, Strength::Strong, Strength::Clear];
        let mut slots = Vec::new();
        let plain = |kind, count: usize| {
            (0..count).map(move |index| Slot {
                levels: kind == Kind::Null && index % 10 == 9,
                ..Slot::plain(kind, ChannelSet::ALL[index % 4])
            })
        };
        slots.extend(plain(Kind::Null, counts.nulls));
        slots.extend(plain(Kind::HardNullWrongParameter, counts.wrong_parameters));
        slots.extend(plain(Kind::HardNullBadChannel, counts.bad_channels));
        let one = |kind, effect, index: usize| Slot {
            kind,
            ..Slot::single(effect, strengths[index % 6], ChannelSet::ALL[(index + index / 4) % 4])
        };
        for (number, effect) in EffectKind::LISTED.into_iter().enumerate() {
            slots.extend(
                (0..counts.singles_per_effect).map(|index| one(Kind::Single, effect, index + number)),
            );
        }
        slots.extend(
            (0..counts.contact_levels).map(|index| one(Kind::Single, EffectKind::ContactLevel, index + 2)),
        );
        for (number, effect) in outside.enumerate() {
            slots.extend((0..counts.unknowns_per_effect).map(|index| Slot {
                strength: Some(clear[(index + number) % 4]),
                ..one(Kind::Unknown, effect, index + number)
            }));
        }
        for (number, (first, second)) in LOOK_ALIKES.into_iter().enumerate() {
            for (truth, partner) in [(first, second), (second, first)] {
                slots.extend((0..counts.look_alikes_per_truth).map(|index| Slot {
                    partner: Some(partner),
                    strength: Some(clear[(index + number) % 4]),
                    channel_set: ChannelSet::Table,
                    ..one(Kind::LookAlike, truth, index)
                }));
            }
        }
        let mut draw = Draw::new(seed).branch(0x706c_616e);
        for index in 0..counts.doubles {
            let first = EffectKind::LISTED[draw.index(17)];
            let others: Vec<EffectKind> = EffectKind::LISTED[..17]
                .iter()
                .copied()
                .filter(|&other| first.is_distinct_from(other))
                .collect();
            let second = others[draw.index(others.len())];
            let strength = Some(clear[index % 4]);
            slots.push(Slot { effects: vec![first, second], strength, ..one(Kind::Double, first, index) });
        }
        draw.shuffle(&mut slots);
        Self { slots }
    }
}
