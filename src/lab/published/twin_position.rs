//! Figures of Duan et al. over the nut position: Tab. 5 and Fig. 9.

use super::figure::{FigureSource, first_hz, read_published};
use crate::document::published::PublishedFigure;
use dynamics::model::elastic_frequencies_hz;
use identification::{Identification, IdentificationSettings, identify};
use long_work::Control;
use machine::contact::published::{LEAD_M, NUT_STIFFNESS_N_PER_M};
use machine::{Machine, Operating};
use measurement::{MeasurementSet, read_set};
use nalgebra::{DMatrix, DVector};
use numeric::linear_fit::LinearFit;
use numeric::unit::omega_rad_s;
use study::simulation::static_stiffness;
use study::{StudyError, StudyResult};

/// The machine with the physics of preloaded pairs, screws held by the servos.
pub const CONFIG: &str = "configs/twin-ball-screw.toml";
/// The machine of Eq. 6 without servos.
pub const CONFIG_AS_COMPUTED: &str = "configs/twin-ball-screw-as-computed.toml";
/// Overrides with which the nut is in series with bearing and screw, as Eq. 22 prints.
fn with_nut() -> [String; 2] {
    [1, 2].map(|axis| {
        format!("joint.drive-{axis}.stiffness={{series=[\"k_b\",{{segment=\"screw\",times=\"screw_factor\"}},{NUT_STIFFNESS_N_PER_M:e}]}}")
    })
}
/// x/L, f_the, f_exp and f_FEA (Hz) of Tab. 5.
const TABLE_5: [(f64, f64, f64, f64); 5] = [
    (0.0, 51.4, 49.7, 58.4),
    (0.25, 50.9, 48.3, 57.6),
    (0.5, 50.3, 47.6, 56.0),
    (0.75, 49.7, 45.1, 53.2),
    (1.0, 48.9, 44.0, 50.1),
];
/// Stroke (m) with which the theory of Tab. 5 follows: x/L = 1 is this far from the bearing. It is fitted to
/// the five frequencies.
const STROKE_OF_THEORY_M: f64 = 0.155;
/// Nut positions (m) chosen for x/L = 0 and 1 of the experiment.
const ENDS_M: (f64, f64) = (0.02, 0.46);

/// Returns a source in this paper.
pub fn at(place: &'static str) -> FigureSource {
    FigureSource { paper: "Duan et al. 2018, twin ball screw", place }
}

/// Returns the nut position (m) of the experiment at x/L.
pub fn nut_m(ratio: f64) -> f64 {
    ENDS_M.0 + ratio * (ENDS_M.1 - ENDS_M.0)
}

/// Returns the nut position (m) of the theory at x/L; the segment of the screw has a length above 0.
fn theory(ratio: f64) -> Operating {
    Operating::at_nut((ratio * STROKE_OF_THEORY_M).max(1e-6))
}

/// Computes all figures of Tab. 5 and Fig. 9.
pub fn figures() -> StudyResult<Vec<PublishedFigure>> {
    let nut: Vec<String> = with_nut().to_vec();
    let printed = read_published(CONFIG_AS_COMPUTED, &nut.iter().map(String::as_str).collect::<Vec<_>>())?;
    let computed = read_published(CONFIG_AS_COMPUTED, &[])?;
    let physics = read_published(CONFIG, &[])?;
    let mut figures = of_theory(&printed, &computed)?;
    figures.extend(of_experiment(&computed, &physics)?);
    figures.extend(of_elements(&computed)?);
    figures.push(of_both_directions(&physics)?);
    Ok(figures)
}

fn of_theory(printed: &Machine, computed: &Machine) -> StudyResult<Vec<PublishedFigure>> {
    TABLE_5
        .iter()
        .map(|(ratio, published, ..)| {
            let figure = at("Tab. 5").figure(format!("first frequency at x/L = {ratio}, theory"), "Hz").printed(*published, 0.1);
            let figure = figure.ours_as_printed(first_hz(printed, &theory(*ratio))?).mended(first_hz(computed, &theory(*ratio))?);
            Ok(figure.because(format!(
                "Eq. 6 with K_g = 0, printed K_b and Tab. 4: the screws turn against each other on bearing and screw; the table's centre \
                 rests. Printed: K_a of Eq. 22. Mended: the nut left out of K_a, K_n and yawing stiff. The stroke is not printed: \
                 {STROKE_OF_THEORY_M} m in both"
            )))
        })
        .collect()
}

/// Fits a machine on x/L = 0, 0.5, 1 of the experiment.
fn fitted(machine: &Machine, set: &MeasurementSet, frozen: &[&str]) -> StudyResult<Identification> {
    let (fit, held_out) = set.split(None, &[]).map_err(StudyError::impossible)?;
    let settings = IdentificationSettings {
        frozen: frozen.iter().map(|id| (*id).into()).collect(),
        ..IdentificationSettings::default()
    };
    identify(machine, &fit, &held_out, &settings, &Control::default()).map_err(StudyError::impossible)
}

fn of_experiment(computed: &Machine, physics: &Machine) -> StudyResult<Vec<PublishedFigure>> {
    let set = read_set("measurements/twin-ball-screw").map_err(StudyError::impossible)?;
    let screws = fitted(computed, &set, &["k_b"])?;
    let mass = fitted(physics, &set, &[])?;
    let value = |machine: &Machine, found: &Identification, id: &str| {
        machine.parameter(id).map_or(f64::NAN, |i| found.values[i])
    };
    let first = |machine: &Machine, found: &Identification, ratio: f64| {
        elastic_frequencies_hz(machine, 1, &found.values, &Operating::at_nut(nut_m(ratio)))
            .first()
            .copied()
            .unwrap_or(f64::NAN)
    };
    let mass_kg = value(physics, &mass, "moving_mass");
    let mut figures = Vec::new();
    for (ratio, theory, measured, _) in TABLE_5 {
        let held = if ratio == 0.25 || ratio == 0.75 { "held out" } else { "fitted" };
        let by_mass = 100.0 * (first(physics, &mass, ratio) / measured - 1.0);
        let figure = at("Tab. 5")
            .figure(format!("first frequency at x/L = {ratio}, experiment"), "Hz")
            .printed(measured, 0.1);
        figures.push(figure.ours_as_printed(theory).mended(first(computed, &screws, ratio)).because(format!(
            "{held}. As printed: the published theory. Mended: the same mode with printed K_b, stroke 0.44 m; yawing {:.1e} N·m/rad and \
             factor {:.3} on the screws fitted at x/L = 0, 0.5, 1. A moving mass of {mass_kg:.0} kg, screws held, gives {by_mass:+.1} %",
            value(computed, &screws, "k_yaw"),
            value(computed, &screws, "screw_factor"),
        )));
    }
    let inertia_kg_m2: f64 = 2.0 * 2.545e-4;
    let reflected_kg = inertia_kg_m2 * (std::f64::consts::TAU / LEAD_M).powi(2);
    figures.push(at("Tab. 4, 5").figure("mass that the level of Tab. 5 needs with the screws held, and reflected inertia", "kg").ours_as_printed(mass_kg).mended(reflected_kg).because(
        "as printed: fitted to the experiment in place of M_w = 24.43 kg. Mended: 2·(J_m + J_b)·(2π/p)² of Tab. 4. Both explain the level; \
         the data of Tab. 5 cannot distinguish them, the inertia needs no mass that the paper does not state",
    ));
    Ok(figures)
}

/// The column of the finite elements: its trend is not that of a chain of springs along the screw, whose 1/f²
/// is linear in x.
fn of_elements(computed: &Machine) -> StudyResult<Vec<PublishedFigure>> {
    let compliance = |hz: f64| omega_rad_s(hz).powi(-2);
    let frequency = |inverse: f64| 1.0 / (std::f64::consts::TAU * inverse.sqrt());
    let (first, last) = (compliance(TABLE_5[0].3), compliance(TABLE_5[4].3));
    let chain = |ratio: f64| frequency(first + ratio * (last - first));
    // Least squares of relative differences of 1/f² = c₀ + c₁·(x/L)².
    let rows = TABLE_5.map(|(ratio, .., published)| (ratio * ratio, compliance(published)));
    let columns = DMatrix::from_fn(rows.len(), 2, |i, j| if j == 0 { 1.0 } else { rows[i].0 } / rows[i].1);
    let fit = LinearFit::new(&columns, &DVector::from_element(rows.len(), 1.0));
    let own = fit
        .map(|fit| fit.coefficients)
        .ok_or_else(|| StudyError::impossible("Tab. 5 does not determine a parabola"))?;
    TABLE_5
        .iter()
        .map(|(ratio, .., published)| {
            let figure = at("Tab. 5").figure(format!("first frequency at x/L = {ratio}, finite elements"), "Hz").printed(*published, 0.1);
            let ours = frequency(own[0] + own[1] * ratio * ratio);
            Ok(figure.ours_as_printed(first_hz(computed, &theory(*ratio))?).mended(ours).because(format!(
                "as printed: the mode of Eq. 6 with the joints of the element model. Mended: the column's own trend, 1/f² = c₀·(1 + {:.3}·(x/L)²), two \
                 numbers fitted to five: a mass on a lever that grows with x, such as the table beside the middle of a yawing carriage. Its level is not \
                 derived: the element model's masses are not printed. Tried: a chain through both ends, whose 1/f² is linear in x, {:.1} Hz here",
                own[1] / own[0],
                chain(*ratio)
            )))
        })
        .collect()
}

fn of_both_directions(physics: &Machine) -> StudyResult<PublishedFigure> {
    let stage = |x: f64, y: f64| -> StudyResult<f64> {
        let k = |nut_m: f64| static_stiffness(physics, &Operating::at_nut(nut_m), "table");
        Ok(1.0 / (1.0 / k(x)? + 1.0 / k(y)?))
    };
    let (near, far) = (stage(ENDS_M.0, ENDS_M.0)?, stage(ENDS_M.1, ENDS_M.1)?);
    let figure = at("Fig. 9, Eq. 23")
        .figure("transmission stiffness of X and Y in series, smallest over largest", "1");
    Ok(figure.ours_as_printed(far / near).holds(far < near).because(format!(
        "falls in both directions from {near:.3e} N/m with both nuts left to {far:.3e} N/m with both right"
    )))
}
