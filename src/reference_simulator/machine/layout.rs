//! Layouts of feed drives: sizes, bearings and drives beside those of the catalogue.

use super::catalogue::{Dimensions, DrawnMachine, FRF_ONLY, on_screw, parameter, round_to, sized};
use super::nuisance::Spread;
use crate::draw::Draw;
use crate::effect::EffectKind;
use crate::parameter::Parameter;

named! {
    /// A layout of a feed drive.
    pub enum Layout {
        /// All of them.
        ALL {
            /// Screws of 16 to 32 mm and 0.6 to 1.3 m between two fixed bearings.
            ShortAxis = "short-axis",
            /// Screws of 32 to 50 mm and 1.3 to 2.8 m between two fixed bearings, as on the published bench.
            MediumAxis = "medium-axis",
            /// Screws of 50 to 80 mm and 2.8 to 5 m between two fixed bearings, tables up to 3 t.
            Gantry = "gantry",
            /// The right bearing floats: it carries no axial load.
            FixedFloating = "fixed-floating",
            /// A belt drives the screw.
            BeltDriven = "belt-driven",
            /// A vertical axis: a brake holds its rotor, and a counterbalance cylinder its table.
            Vertical = "vertical",
        }
    }
}

/// Limits of the sizes of a layout.
struct Sizes {
    diameters_mm: &'static [f64],
    length_m: [f64; 2],
    table_kg: [f64; 2],
}

/// Leads of ball screws, mm.
const LEADS_MM: [f64; 8] = [5.0, 8.0, 10.0, 16.0, 20.0, 25.0, 32.0, 40.0];
/// Limits of lead over diameter.
const LEAD_SHARE: std::ops::RangeInclusive<f64> = 0.15..=1.3;
/// Limits of length over diameter.
const SLENDERNESS: [f64; 2] = [15.0, 75.0];
/// Tables weigh about as many kilograms at 16 mm, and grow with the cube of the diameter.
const TABLE_AT_16_MM_KG: f64 = 20.0;
/// Ratios of the pulleys of belt drives.
const PULLEYS: [f64; 5] = [1.25, 1.5, 2.0, 2.5, 3.0];
/// Damping of a guide over the table mass, 1/s: described, and so little that it is not.
const GUIDE_PER_S: [f64; 2] = [0.2, 5.0];

impl Layout {
    fn sizes(self) -> Sizes {
        let (diameters_mm, length_m, table_kg): (&[f64], _, _) = match self {
            Self::ShortAxis => (&[16.0, 20.0, 25.0, 32.0], [0.6, 1.3], [20.0, 200.0]),
            Self::MediumAxis => (&[32.0, 40.0, 50.0], [1.3, 2.8], [100.0, 900.0]),
            Self::Gantry => (&[50.0, 63.0, 80.0], [2.8, 5.0], [500.0, 3000.0]),
            Self::FixedFloating => (&[20.0, 25.0, 32.0, 40.0, 50.0], [0.6, 2.0], [30.0, 600.0]),
            Self::BeltDriven => (&[25.0, 32.0, 40.0, 50.0, 63.0], [0.8, 3.0], [60.0, 1500.0]),
            Self::Vertical => (&[25.0, 32.0, 40.0, 50.0], [0.6, 1.6], [50.0, 800.0]),
        };
        Sizes { diameters_mm, length_m, table_kg }
    }

    /// Returns why an effect cannot be missing from the description of such a machine.
    pub fn refusal(self, effect: EffectKind) -> Option<&'static str> {
        use EffectKind::{
            BearingStiffnessPosition, BedCompliance, ContactLevel, GuideViscous, LooseFoot, MotorThrust,
            RotorHold, ScaleFeedback, ServoLag,
        };
        match (self, effect) {
            (Self::FixedFloating, BedCompliance | BearingStiffnessPosition | ContactLevel | LooseFoot) => {
                Some("its right bearing carries no axial load")
            }
            (Self::BeltDriven, MotorThrust) => Some("its motor is not on the screw's axis"),
            (Self::Vertical, RotorHold) => Some("its rotor is always held"),
            (Self::Vertical, ServoLag | ScaleFeedback) => Some("a brake holds its rotor, no servo"),
            (Self::Vertical, GuideViscous) => {
                Some("its description contains the damping of the counterbalance")
            }
            _ => None,
        }
    }

    /// Whether the drive or a brake always holds the rotor.
    pub fn always_holds(self) -> bool {
        self == Self::Vertical
    }

    /// Draws a machine with its description. `has_guide` is whether the description contains the damping of
    /// the table's guide.
    pub fn machine(self, is_held: bool, has_guide: bool, draw: &mut Draw) -> DrawnMachine {
        let sizes = self.sizes();
        let diameter_mm = sizes.diameters_mm[draw.index(sizes.diameters_mm.len())];
        let leads: Vec<f64> =
            LEADS_MM.into_iter().filter(|lead| LEAD_SHARE.contains(&(lead / diameter_mm))).collect();
        let lead_mm = leads[draw.index(leads.len())];
        let slender = SLENDERNESS.map(|share| share * 1e-3 * diameter_mm);
        let [least_m, most_m] = [sizes.length_m[0].max(slender[0]), sizes.length_m[1].min(slender[1])];
        let length_m = round_to(draw.log_between(least_m, most_m), 3);
        let table = TABLE_AT_16_MM_KG * (diameter_mm / 16.0).powi(3) * draw.log_between(0.4, 2.5);
        let table_kg = round_to(table.clamp(sizes.table_kg[0], sizes.table_kg[1]), 3);
        let mut drawn = sized(Dimensions { diameter_mm, lead_mm, length_m, table_kg }, is_held, draw);
        drawn.nut_m = positions(length_m, draw);
        let description = &mut drawn.description;
        let factor = [0.5, 1.0, 1.0, 2.0][draw.index(4)];
        description.spread = Spread::USUAL.times(factor);
        description.states_tolerances = factor != 1.0 || draw.chance(0.5);
        if has_guide {
            let usual = round_to(table_kg, 1);
            let source = "viscous friction of profiled guides over the table mass, 0.01 to 100 1/s";
            let guide = Parameter {
                further: FRF_ONLY,
                ..parameter("c_g", usual, usual / 100.0, usual * 100.0, source)
            };
            description.parameters.push(guide);
            drawn
                .joints
                .insert("c_g".to_owned(), table_kg * draw.log_between(GUIDE_PER_S[0], GUIDE_PER_S[1]));
        }
        match self {
            Self::FixedFloating => {
                drawn.description.parameters.retain(|parameter| !["k_ar", "c_ar"].contains(&parameter.name));
                drawn.joints.retain(|name, _| !["k_ar", "c_ar"].contains(&name.as_str()));
            }
            Self::BeltDriven => drive_by_belt(&mut drawn, draw),
            Self::Vertical => {
                // A brake is stiffer than a servo.
                let factor = draw.log_between(2.0, 10.0);
                drawn.joints.entry("k_s".to_owned()).and_modify(|k| *k *= factor);
            }
            _ => {}
        }
        drawn
    }
}

/// Draws three to six nut positions (m).
fn positions(length_m: f64, draw: &mut Draw) -> Vec<f64> {
    let count = 3 + draw.index(4);
    let step = 0.56 / (count - 1) as f64;
    (0..count).map(|at| on_screw(0.22 + step * at as f64 + draw.within(0.03), length_m)).collect()
}

/// Replaces the coupling by a belt between pulleys: its stiffness counts at the motor's shaft, and the screw
/// carries the larger pulley.
fn drive_by_belt(drawn: &mut DrawnMachine, draw: &mut Draw) {
    let ratio = PULLEYS[draw.index(PULLEYS.len())];
    let factor = round_to(draw.log_between(0.3, 1.0) / (ratio * ratio), 1);
    let description = &mut drawn.description;
    description.drive_ratio = ratio;
    for parameter in
        description.parameters.iter_mut().filter(|parameter| ["k_m", "c_m"].contains(&parameter.name))
    {
        for value in [&mut parameter.start, &mut parameter.lower, &mut parameter.upper] {
            *value = round_to(*value * factor, 2);
        }
        parameter.source = "toothed belts from 1e5 to 1e7 N/m on the motor's pulley";
    }
    for name in ["k_m", "c_m"] {
        drawn.joints.entry(name.to_owned()).and_modify(|value| *value *= factor);
    }
    description.rotor_inertia_kg_m2 = round_to(description.rotor_inertia_kg_m2 / ratio, 2);
    description.hub_inertia_kg_m2 = round_to(description.hub_inertia_kg_m2 * draw.log_between(3.0, 8.0), 2);
}
