//! Plans: lists of the cases to generate.

use super::tour::Tour;
use crate::case::{Counts, Kind, Strength};
use crate::draw::Draw;
use crate::motion::effect::EffectKind;
use crate::motion::layout::MotionLayout;
use crate::motion::run::Side;

/// The full check: about 700 cases.
pub const FULL: Counts = Counts {
    nulls: 200,
    wrong_parameters: 40,
    bad_channels: 40,
    singles_per_effect: 15,
    contact_levels: 0,
    look_alikes_per_truth: 10,
    doubles: 60,
    unknowns_per_effect: 10,
};

/// A quick check: about 80 cases.
pub const QUICK: Counts = Counts {
    nulls: 20,
    wrong_parameters: 6,
    bad_channels: 6,
    singles_per_effect: 2,
    contact_levels: 0,
    look_alikes_per_truth: 1,
    doubles: 6,
    unknowns_per_effect: 1,
};

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
    /// Location of the position sensor, unless the effects determine it.
    pub side: Side,
    /// Motions of the first measurement.
    pub tour: Tour,
    /// Layout of the axis; that of the catalogue if absent.
    pub layout: Option<MotionLayout>,
}

/// Cases to generate, in random order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The cases.
    pub slots: Vec<Slot>,
}

impl Slot {
    /// Specifies a case of one kind without effects.
    pub fn plain(kind: Kind, side: Side) -> Self {
        Self {
            kind,
            effects: Vec::new(),
            partner: None,
            strength: None,
            side,
            tour: Tour::Usual,
            layout: None,
        }
    }

    /// Specifies a case of one library effect.
    pub fn single(effect: EffectKind, strength: Strength, side: Side) -> Self {
        Self {
            effects: vec![effect],
            strength: Some(strength),
            ..Self::plain(Kind::Single, effect.side().unwrap_or(side))
        }
    }

    /// Specifies a case of one of two effects that look alike in the chosen motions.
    pub fn look_alike(truth: EffectKind, partner: EffectKind, strength: Strength) -> Self {
        // In slow reversals, backlash and the wind-up by dry friction move the table alike. In steady
        // strokes, a delay and the wind-up lag alike.
        let tour = if [truth, partner].contains(&EffectKind::Backlash) { Tour::Gentle } else { Tour::Flat };
        Self {
            kind: Kind::LookAlike,
            partner: Some(partner),
            tour,
            ..Self::single(truth, strength, Side::Table)
        }
    }
}

impl Plan {
    /// Distributes the counts over strengths and sides, and shuffles the cases. Axes have no force level, so
    /// `contact_levels` has no effect.
    pub fn from_counts(counts: &Counts, seed: u64) -> Self {
        let strengths = [Strength::Weak, Strength::Strong, Strength::Clear];
        let clear = [Strength::Strong, Strength::Clear];
        let side = |index: usize| if index % 3 == 2 { Side::Table } else { Side::Motor };
        let mut slots = Vec::new();
        for (kind, count) in [
            (Kind::Null, counts.nulls),
            (Kind::HardNullWrongParameter, counts.wrong_parameters),
            (Kind::HardNullBadChannel, counts.bad_channels),
        ] {
            slots.extend((0..count).map(|index| Slot::plain(kind, side(index))));
        }
        for (number, effect) in EffectKind::LISTED.into_iter().enumerate() {
            let one = |index: usize| {
                Slot::single(effect, strengths[(index + number) % 3], side(index / 3 + index + number))
            };
            slots.extend((0..counts.singles_per_effect).map(one));
        }
        for (number, effect) in EffectKind::UNLISTED.into_iter().enumerate() {
            let one = |index: usize| Slot {
                kind: Kind::Unknown,
                ..Slot::single(effect, clear[(index + number) % 2], side(index + number))
            };
            slots.extend((0..counts.unknowns_per_effect).map(one));
        }
        for (number, (first, second)) in EffectKind::LOOK_ALIKES.into_iter().enumerate() {
            for (truth, partner) in [(first, second), (second, first)] {
                let one = |index: usize| Slot::look_alike(truth, partner, clear[(index + number) % 2]);
                slots.extend((0..counts.look_alikes_per_truth).map(one));
            }
        }
        let mut draw = Draw::new(seed).branch(0x6d6f_7469_6f6e);
        for index in 0..counts.doubles {
            let first = EffectKind::LISTED[draw.index(EffectKind::LISTED.len())];
            let others: Vec<EffectKind> =
                EffectKind::LISTED.into_iter().filter(|&other| first.is_distinct_from(other)).collect();
            let second = others[draw.index(others.len())];
            let side = first.side().or(second.side()).unwrap_or(side(index));
            slots.push(Slot {
                kind: Kind::Double,
                effects: vec![first, second],
                side,
                ..Slot::single(first, clear[index % 2], side)
            });
        }
        draw.shuffle(&mut slots);
        Self { slots }
    }

    /// Plans cases of one layout, or of all in turn, every second turn with random motions. In a turn an
    /// effect goes to the next layout that can have it; on one layout alone the cases of effects that it
    /// cannot have stay in the plan and are refused.
    pub fn on_layouts(counts: &Counts, seed: u64, layout: Option<MotionLayout>) -> Self {
        let mut plan = Self::from_counts(counts, seed);
        let count = MotionLayout::ALL.len();
        for (index, slot) in plan.slots.iter_mut().enumerate() {
            let can_have = |layout: &MotionLayout| {
                slot.effects.iter().chain(&slot.partner).all(|effect| layout.refusal(*effect).is_none())
            };
            let mut turn = MotionLayout::ALL.into_iter().cycle().skip(index % count).take(count);
            slot.layout = layout.or_else(|| turn.find(can_have));
            if slot.tour == Tour::Usual && index / count % 2 == 1 {
                slot.tour = Tour::Random;
            }
        }
        plan
    }
}
