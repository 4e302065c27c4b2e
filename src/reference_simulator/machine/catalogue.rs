//! Random machines: the published bench and machines of any size. The parameter ranges do not depend on the
//! drawn values.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::description::Description;
use super::nuisance::Spread;
use super::number::Machine;
use crate::draw::Draw;
use crate::parameter::Parameter;

/// A description together with the true joint values.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnMachine {
    /// The engineer's description.
    pub description: Description,
    /// True joint values by parameter name.
    pub joints: BTreeMap<String, f64>,
    /// Nominal nut positions l1, l2 … from the left bearing, m.
    pub nut_m: Vec<f64>,
    /// Upper end of the measured band, Hz.
    pub band_hz: f64,
}

impl DrawnMachine {
    /// Returns the machine as described, with its true joints.
    pub fn with_true_joints(&self) -> Machine {
        let mut machine = self.description.as_believed();
        for (name, value) in &self.joints {
            if let Some(joint) = machine.joint_mut(name) {
                *joint = *value;
            }
        }
        machine
    }

    /// Returns the first and the last nut position, m.
    pub fn stroke_m(&self) -> [f64; 2] {
        [self.nut_m[0], self.nut_m[self.nut_m.len() - 1]]
    }
}

/// Draws the published bench with joint values close to those that explain its measured modes.
pub fn bench(held: bool, draw: &mut Draw) -> DrawnMachine {
    let mut parameters = vec![
        parameter(
            "k_al",
            5e7,
            5e6,
            5e8,
            "catalogue stiffness of angular-contact bearing sets for 30–50 mm journals",
        ),
        parameter("k_ar", 5e7, 5e6, 5e8, "as the left bearing"),
        parameter(
            "k_n",
            7e8,
            1e8,
            5e9,
            "catalogue rigidity of preloaded nuts for 40 mm screws, with an allowance to either side",
        ),
        parameter(
            "k_m",
            3e3,
            100.0,
            1e5,
            "catalogue torsional stiffness of couplings of this size, elastomer to bellows",
        ),
        parameter("c_al", 1e3, 10.0, 1e5, "loss factor 0.0003 to 3 of the bearing stiffness near 500 Hz"),
        parameter("c_ar", 1e3, 10.0, 1e5, "as the left bearing"),
        parameter("c_n", 1e5, 1e3, 1e7, "loss factor 0.003 to 30 of the nut stiffness near 500 Hz"),
        parameter("c_m", 0.1, 1e-3, 10.0, "loss factor 0.001 to 10 of the coupling stiffness near 500 Hz"),
    ];
    let hold = draw.log_between(1e3, 1e5);
    let k_m = draw.log_between(4e2, 5e3);
    let mut joints = BTreeMap::from([
        ("k_al".to_owned(), 4.1e7 * draw.log_between(0.85, 1.18)),
        ("k_ar".to_owned(), 2.7e7 * draw.log_between(0.85, 1.18)),
        ("k_n".to_owned(), 7.9e8 * draw.log_between(0.85, 1.18)),
        ("k_m".to_owned(), k_m),
        ("c_al".to_owned(), draw.log_between(200.0, 2000.0)),
        ("c_ar".to_owned(), draw.log_between(200.0, 2000.0)),
        ("c_n".to_owned(), 4.2e4 * draw.log_between(0.7, 1.4)),
        ("c_m".to_owned(), 0.045 * draw.log_between(0.8, 1.25) * (k_m / 4e2).sqrt()),
    ]);
    let hold_damping = 2.0 * draw.log_between(0.05, 0.3) * (hold * 1e-3).sqrt();
    if held {
        parameters.extend(hold_parameters([1e6, 10.0, 1e6], [1.0, 1e-4, 1e3]));
        joints.extend([("k_s".to_owned(), hold), ("c_s".to_owned(), hold_damping)]);
    }
    let description = Description {
        holds_rotor: held,
        table_mass_kg: 272.0,
        rotor_inertia_kg_m2: 1e-3,
        hub_inertia_kg_m2: 1e-4,
        screw_mass_kg: 0.25,
        screw_inertia_kg_m2: 1e-4,
        length_m: 2.6,
        diameter_m: 0.040,
        youngs_modulus_pa: 2e11,
        shear_modulus_pa: 7.75e10,
        density_kg_m3: 7850.0,
        lead_m: 0.040,
        parameters,
        spread: Spread::UNIFORM,
        states_tolerances: true,
        drive_ratio: 1.0,
    };
    DrawnMachine { description, joints, nut_m: vec![0.6, 0.8, 1.0, 1.3, 1.6, 1.9], band_hz: 1000.0 }
}

/// Draws a machine of any size: lead 5–40 mm, length 0.4–3 m, diameter 16–63 mm, table 20–1500 kg; all other
/// values scale with these.
pub fn any_size(held: bool, draw: &mut Draw) -> DrawnMachine {
    let diameter_mm = [16.0, 20.0, 25.0, 32.0, 40.0, 50.0, 63.0][draw.index(7)];
    let leads: Vec<f64> = [5.0, 8.0, 10.0, 16.0, 20.0, 25.0, 32.0, 40.0]
        .into_iter()
        .filter(|lead| (0.2..=1.3).contains(&(lead / diameter_mm)))
        .collect();
    let lead_mm = leads[draw.index(leads.len())];
    let length_m = round_to((diameter_mm * 1e-3 * draw.log_between(20.0, 62.0)).clamp(0.4, 3.0), 2);
    let table =
        round_to((20.0 * (diameter_mm / 16.0).powi(3) * draw.log_between(0.5, 2.0)).clamp(20.0, 1500.0), 2);
    sized(Dimensions { diameter_mm, lead_mm, length_m, table_kg: table }, held, draw)
}

/// Main dimensions of a drawn machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimensions {
    /// Diameter of the screw, mm.
    pub diameter_mm: f64,
    /// Lead of the screw, mm per turn.
    pub lead_mm: f64,
    /// Length of the screw, m.
    pub length_m: f64,
    /// Mass of the table, kg.
    pub table_kg: f64,
}

/// Draws a machine of given dimensions; all other values scale with them.
pub fn sized(dimensions: Dimensions, held: bool, draw: &mut Draw) -> DrawnMachine {
    let Dimensions { diameter_mm, lead_mm, length_m, table_kg: table } = dimensions;
    let size = diameter_mm / 40.0;
    let rotor = round_to(1e-3 * size.powi(4) * draw.log_between(0.5, 2.0), 2);
    let hub = round_to(1e-4 * size.powi(4) * draw.log_between(0.6, 1.6), 2);
    let bearing = round_to(1e6 * diameter_mm, 1);
    let nut = round_to(1.6e7 * diameter_mm, 1);
    let coupling = round_to(2e3 * size.powi(3), 1);
    let at_500 = 2.0 * PI * 500.0;
    let bearing_damping = round_to(0.05 * bearing / at_500, 1);
    let nut_damping = round_to(0.1 * nut / at_500, 1);
    let coupling_damping = round_to(0.1 * coupling / at_500, 1);
    let decade = |name, start: f64, factor: f64, source: &'static str| {
        parameter(name, start, start / factor, start * factor, source)
    };
    let mut parameters = vec![
        decade("k_al", bearing, 10.0, "catalogue stiffness of bearing sets for screws of this diameter"),
        decade("k_ar", bearing, 10.0, "as the left bearing"),
        decade("k_n", nut, 10.0, "catalogue rigidity of preloaded nuts for screws of this diameter"),
        decade(
            "k_m",
            coupling,
            20.0,
            "catalogue torsional stiffness of couplings of this size, elastomer to bellows",
        ),
        decade(
            "c_al",
            bearing_damping,
            100.0,
            "loss factor 0.0005 to 5 of the bearing stiffness near 500 Hz",
        ),
        decade("c_ar", bearing_damping, 100.0, "as the left bearing"),
        decade("c_n", nut_damping, 100.0, "loss factor 0.001 to 10 of the nut stiffness near 500 Hz"),
        decade(
            "c_m",
            coupling_damping,
            100.0,
            "loss factor 0.001 to 10 of the coupling stiffness near 500 Hz",
        ),
    ];
    let mut lossy = |stiffness: f64, low: f64, high: f64| stiffness * draw.log_between(low, high) / at_500;
    let spread =
        [lossy(at_500, 0.5, 2.2), lossy(at_500, 0.5, 2.2), lossy(at_500, 0.5, 2.2), lossy(at_500, 0.3, 3.0)];
    let [k_al, k_ar, k_n, k_m] =
        [bearing * spread[0], bearing * spread[1], nut * spread[2], coupling * spread[3]];
    let mut joints = BTreeMap::from([
        ("c_al".to_owned(), lossy(k_al, 0.02, 0.15)),
        ("c_ar".to_owned(), lossy(k_ar, 0.02, 0.15)),
        ("c_n".to_owned(), lossy(k_n, 0.03, 0.3)),
        ("c_m".to_owned(), lossy(k_m, 0.04, 0.3)),
        ("k_al".to_owned(), k_al),
        ("k_ar".to_owned(), k_ar),
        ("k_n".to_owned(), k_n),
        ("k_m".to_owned(), k_m),
    ]);
    let hold = draw.log_between(2e3, 6e4) * size.powi(3);
    let hold_damping = 2.0 * draw.log_between(0.05, 0.3) * (hold * rotor).sqrt();
    if held {
        let damping = round_to(0.2 * (10.0 * coupling * rotor).sqrt(), 1);
        parameters.extend(hold_parameters(
            [round_to(100.0 * coupling, 1), round_to(coupling / 100.0, 1), round_to(1000.0 * coupling, 1)],
            [damping, damping / 1000.0, damping * 1000.0],
        ));
        joints.extend([("k_s".to_owned(), hold), ("c_s".to_owned(), hold_damping)]);
    }
    let steel = [(2.06e11, 7.9e10), (2.1e11, 8.08e10), (2e11, 7.75e10)][draw.index(3)];
    let description = Description {
        holds_rotor: held,
        table_mass_kg: table,
        rotor_inertia_kg_m2: rotor,
        hub_inertia_kg_m2: hub,
        screw_mass_kg: round_to(0.25 * size.powi(3), 2),
        screw_inertia_kg_m2: round_to(1e-4 * size.powi(5), 2),
        length_m,
        diameter_m: diameter_mm * 1e-3,
        youngs_modulus_pa: steel.0,
        shear_modulus_pa: steel.1,
        density_kg_m3: 7850.0,
        lead_m: lead_mm * 1e-3,
        parameters,
        spread: Spread::UNIFORM,
        states_tolerances: true,
        drive_ratio: 1.0,
    };
    let nut_m =
        (0..6).map(|index| on_screw(0.23 + 0.1 * f64::from(index) + draw.within(0.025), length_m)).collect();
    let torsion_hz = (steel.1 / 7850.0f64).sqrt() / (2.0 * length_m);
    DrawnMachine { description, joints, nut_m, band_hz: round_to((1.7 * torsion_hz).clamp(800.0, 1600.0), 2) }
}

/// Key of a parameter that only the fit of frequency responses uses.
pub(super) const FRF_ONLY: Option<(&str, &str)> = Some(("fit", "frf"));

/// Returns a nut position (m) by its share of the screw's length, to the 5 mm of a scale on the machine.
pub(super) fn on_screw(share: f64, length_m: f64) -> f64 {
    (share * length_m * 200.0).round() / 200.0
}

pub(super) fn parameter(
    name: &'static str,
    start: f64,
    lower: f64,
    upper: f64,
    source: &'static str,
) -> Parameter {
    let unit = match name {
        "k_m" | "k_s" => "N*m/rad",
        "c_m" | "c_s" => "N*m*s/rad",
        _ if name.starts_with('k') => "N/m",
        _ => "N*s/m",
    };
    Parameter::new(name, unit, [start, lower, upper], source)
}

/// Returns the parameters of the drive's hold: start and limits of stiffness and damping.
fn hold_parameters(stiffness: [f64; 3], damping: [f64; 3]) -> [Parameter; 2] {
    let one = |name, [start, lower, upper]: [f64; 3], source| Parameter {
        further: FRF_ONLY,
        ..parameter(name, start, lower, upper, source)
    };
    [
        one("k_s", stiffness, "position loop from slack to practically fixed"),
        one("c_s", damping, "velocity loop from none to stiff"),
    ]
}

/// Rounds a value to a number of significant digits.
pub fn round_to(value: f64, digits: i32) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    format!("{value:.*e}", (digits - 1).max(0) as usize).parse().unwrap_or(value)
}
