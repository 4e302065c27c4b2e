//! Figures of the vertical axis under acceleration. The paper prints no values: its equations are compared with ours.

use super::figure::{CONFIGS, FigureSource, compared, ours_alone, read_published, stated};
use crate::simulation::stiffness::{separations, static_stiffness};
use crate::{StudyError, StudyResult};
use dynamics::model::elastic_frequencies_hz;
use machine::{Machine, Operating};
use report::simulation::PublishedFigure;

const CONFIG: &str = CONFIGS[2];
const AS_PRINTED: [&str; 4] =
    ["contact_rule=as-printed", "contact.nut.weight=0.9", "contact.bearing-upper.weight=0.81", "contact.bearing-lower.weight=0.81"];

fn at(place: &'static str) -> FigureSource {
    FigureSource { paper: "Vertical axis under acceleration", place }
}

/// Evaluates the paper's equations 26–28, with contact stiffnesses as printed.
fn equation_28(axis: &Machine, operating: &Operating) -> StudyResult<f64> {
    let contact = |name: &str| -> StudyResult<f64> {
        let found = axis.contacts.iter().find(|c| c.name == name).ok_or_else(|| StudyError::impossible(format!("no contact «{name}»")))?;
        Ok(found.at(operating).map_err(StudyError::impossible)?.stiffness_n_per_m)
    };
    let (d, e, g, p, l): (f64, f64, f64, f64, f64) = (0.0275, 2.06e11, 7.9e10, 0.010, 0.9);
    let z = operating.nut_m.unwrap_or(0.5 * l);
    let pi = std::f64::consts::PI;
    let upper = 4.0 * g * e * pi.powi(3) * d.powi(4) / (16.0 * g * pi * pi * d * d * (l - z) + 32.0 * p * p * e * (l - z));
    let lower = pi * d * d * e / (4.0 * z);
    let (ku, kl, kn) = (contact("bearing-upper")?, contact("bearing-lower")?, contact("nut")?);
    let both = upper * ku / (upper + ku) + lower * kl / (lower + kl);
    Ok(both * kn / (both + kn))
}

/// Computes all figures of the paper.
pub fn figures() -> StudyResult<Vec<PublishedFigure>> {
    let printed = read_published(CONFIG, &AS_PRINTED)?;
    let physics = read_published(CONFIG, &[])?;
    let mut figures = Vec::new();
    let mass_kg = 150.0;
    let here = |a: f64, z: f64| Operating { acceleration_m_s2: Some(a), ..Operating::at_nut(z) };
    for (a, z) in [(0.0, 0.45), (8.0, 0.2), (-25.0, 0.7)] {
        let condition = here(a, z);
        let by_paper = equation_28(&printed, &condition)?;
        let ours = static_stiffness(&printed, &condition, "head")?;
        let what = format!("k_e at a = {a} m/s², z = {z} m");
        figures.push(compared(
            at("Eq. 26–29"),
            &what,
            "N/m",
            (by_paper, ours),
            1e-9,
            "«printed»: the equations written out with our chosen numbers",
        ));
        let f_paper = (by_paper / mass_kg).sqrt() / std::f64::consts::TAU;
        let f = elastic_frequencies_hz(&printed, 1, &printed.start(), &condition).first().copied().unwrap_or(f64::NAN);
        figures.push(compared(
            at("Eq. 1"),
            &format!("first frequency at a = {a} m/s², z = {z} m"),
            "Hz",
            (f_paper, f),
            1e-8,
            "from k_e above and a mass of 150 kg",
        ));
    }
    for (axis, how, ratio, remark) in [
        (&printed, "as printed", 1.83, "Eq. 15: m·(g + a) = 1.83·P"),
        (&physics, "by equilibrium", 1.83, "1.83·P is the increment of side A's load, taken for the force; nut B unloads at 2.83·P"),
    ] {
        let nut = axis.contacts.iter().find(|c| c.name == "nut").ok_or_else(|| StudyError::impossible("no contact «nut»"))?;
        let found = separations(nut, (-60.0, 60.0), |a| here(a, 0.45));
        let b = found.iter().find(|s| s.side == "B").ok_or_else(|| StudyError::impossible("nut B does not unload"))?;
        figures.push(compared(
            at("Eq. 15"),
            &format!("force over preload where nut B unloads, {how}"),
            "1",
            (ratio, b.force_n / 1000.0),
            0.005,
            remark,
        ));
        figures.push(ours_alone(
            at("Eq. 15"),
            &format!("acceleration where nut B unloads, {how}"),
            "m/s²",
            b.at,
            "no number printed; ours for the chosen axis",
        ));
    }
    let k = |axis: &Machine, a: f64| elastic_frequencies_hz(axis, 1, &axis.start(), &here(a, 0.45)).first().copied().unwrap_or(f64::NAN);
    let (rest, up, down) = (k(&physics, 0.0), k(&physics, 9.0), k(&physics, -9.80665));
    figures.push(stated(
        at("2.3"),
        "first frequency at 9 m/s² upward over at rest, by equilibrium",
        "1",
        up / rest,
        up < rest,
        "falls until nut B unloads, then rises; by the printed rule (the larger of two) it rises at once",
    ));
    figures.push(stated(
        at("2.3"),
        "first frequency in free fall over at rest, by equilibrium",
        "1",
        down / rest,
        down > rest,
        "with the preload alone a pair is stiffest",
    ));
    figures.push(compared(
        at("Eq. 14, 17"),
        "weight of the bearings' stiffness",
        "1",
        (0.9, 0.81),
        0.01,
        "c_wb enters Eq. 14 and again Eq. 17–18: 0.81 in total. Ours by default: none",
    ));
    Ok(figures)
}
