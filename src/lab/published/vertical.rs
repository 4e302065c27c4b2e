//! Figures of the vertical axis under acceleration. The paper prints no values: its equations are compared
//! with ours.

use super::figure::{FigureSource, contact, first_hz, read_published};
use crate::document::published::PublishedFigure;
use config::{embedded_config, read_machine_text};
use machine::{Machine, Operating};
use study::simulation::{separations, static_stiffness};
use study::{StudyError, StudyResult};

/// The machine.
pub const CONFIG: &str = "configs/vertical-axis.toml";
const AS_PRINTED: [&str; 4] = [
    "contact_rule=as-printed",
    "contact.nut.weight=0.9",
    "contact.bearing-upper.weight=0.81",
    "contact.bearing-lower.weight=0.81",
];
/// Moved mass (kg) of the configuration, and preload (N) of its nut.
const MASS_KG: f64 = 150.0;
const NUT_PRELOAD_N: f64 = 1000.0;

fn at(place: &'static str) -> FigureSource {
    FigureSource { paper: "Vertical axis under acceleration", place }
}

fn here(acceleration_m_s2: f64, nut_m: f64) -> Operating {
    Operating { acceleration_m_s2: Some(acceleration_m_s2), ..Operating::at_nut(nut_m) }
}

/// Evaluates the paper's equations 26–28, with contact stiffnesses as printed.
fn equation_28(axis: &Machine, operating: &Operating) -> StudyResult<f64> {
    let stiffness = |name: &str| -> StudyResult<f64> {
        Ok(contact(axis, name)?.at(operating).map_err(StudyError::impossible)?.stiffness_n_per_m)
    };
    let (d, e, g, p, l): (f64, f64, f64, f64, f64) = (0.0275, 2.06e11, 7.9e10, 0.010, 0.9);
    let z = operating.nut_m.unwrap_or(0.5 * l);
    let pi = std::f64::consts::PI;
    let upper = 4.0 * g * e * pi.powi(3) * d.powi(4)
        / (16.0 * g * pi * pi * d * d * (l - z) + 32.0 * p * p * e * (l - z));
    let lower = pi * d * d * e / (4.0 * z);
    let (ku, kl, kn) = (stiffness("bearing-upper")?, stiffness("bearing-lower")?, stiffness("nut")?);
    let both = upper * ku / (upper + ku) + lower * kl / (lower + kl);
    Ok(both * kn / (both + kn))
}

/// Computes all figures of the paper.
pub fn figures() -> StudyResult<Vec<PublishedFigure>> {
    let printed = read_published(CONFIG, &AS_PRINTED)?;
    let physics = read_published(CONFIG, &[])?;
    let mut figures = Vec::new();
    for (a, z) in [(0.0, 0.45), (8.0, 0.2), (-25.0, 0.7)] {
        let condition = here(a, z);
        let by_paper = equation_28(&printed, &condition)?;
        let ours = static_stiffness(&printed, &condition, "head")?;
        let f_paper = (by_paper / MASS_KG).sqrt() / std::f64::consts::TAU;
        let f = first_hz(&printed, &condition)?;
        let equal = (ours / by_paper - 1.0).abs() < 1e-9 && (f / f_paper - 1.0).abs() < 1e-8;
        figures.push(at("Eq. 1, 26–29").figure(format!("first frequency at a = {a} m/s², z = {z} m"), "Hz").ours_as_printed(f).mended(first_hz(&physics, &condition)?).holds(equal).because(
            format!(
                "no number printed. As printed: our model equals the equations written out, {f_paper:.2} Hz with k_e = {by_paper:.3e} N/m. \
                 Mended: pairs by equilibrium, ends by compatibility, no weights"
            ),
        ));
    }
    figures.extend(unloading(&printed, &physics)?);
    figures.extend(ends(&printed, &physics)?);
    let f = |a: f64| first_hz(&physics, &here(a, 0.45));
    let (rest, up, down) = (f(0.0)?, f(9.0)?, f(-9.80665)?);
    figures.push(
        at("2.3")
            .figure("first frequency at 9 m/s² upward over at rest", "1")
            .ours_as_printed(first_hz(&printed, &here(9.0, 0.45))? / first_hz(&printed, &here(0.0, 0.45))?)
            .mended(up / rest)
            .because(
                "by the printed rule (the larger of two sides) it rises at once; by equilibrium it falls until nut B unloads, then rises",
            ),
    );
    figures.push(
        at("2.3")
            .figure("first frequency in free fall over at rest", "1")
            .mended(down / rest)
            .because("by equilibrium a pair is stiffest with the preload alone"),
    );
    figures.push(
        at("Eq. 14, 17")
            .figure("weight of the bearings' stiffness", "1")
            .printed(0.9, 0.1)
            .ours_as_printed(0.9 * 0.9)
            .mended(0.9)
            .because(
                "c_wb enters Eq. 14 and again Eq. 17–18: 0.81 in total. Mended: once. Ours by default: none",
            ),
    );
    Ok(figures)
}

fn unloading(printed: &Machine, physics: &Machine) -> StudyResult<Vec<PublishedFigure>> {
    let unloads = |axis: &Machine| -> StudyResult<(f64, f64)> {
        let found = separations(contact(axis, "nut")?, (-60.0, 60.0), |a| here(a, 0.45));
        let b = found
            .iter()
            .find(|s| s.side == "B")
            .ok_or_else(|| StudyError::impossible("nut B does not unload"))?;
        Ok((b.force_n / NUT_PRELOAD_N, b.at))
    };
    let (by_print, by_equilibrium) = (unloads(printed)?, unloads(physics)?);
    Ok(vec![
        at("Eq. 15").figure("force over preload where side B unloads", "1").printed(1.83, 0.01).ours_as_printed(by_print.0).because(
            "Eq. 15: m·(g + a) = 1.83·P follows as printed. It is the increment of side A's load, taken for the force; see the next row",
        ),
        at("Eq. 15")
            .figure("force over preload, and so acceleration, where nut B unloads by equilibrium", "1")
            .mended(by_equilibrium.0)
            .because(format!(
                "P_A − P_B = F and P_A^(2/3) + P_B^(2/3) = 2·P^(2/3) give 2^(3/2). For the chosen axis {:.2} m/s², as printed {:.2} m/s²",
                by_equilibrium.1, by_print.1
            )),
    ])
}

/// Reads the machine without the segments of its bearings, so that each end takes half of the force also by
/// equilibrium of the pairs.
fn with_halves() -> StudyResult<Machine> {
    let text = embedded_config(CONFIG).unwrap_or_default();
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with("segment = ")).collect();
    Ok(read_machine_text(CONFIG, &lines.join("\n"), &[], &[])?.machine)
}

/// Compares the shares of the two screw ends: half each as printed, by compatibility as it must be.
fn ends(printed: &Machine, physics: &Machine) -> StudyResult<Vec<PublishedFigure>> {
    let lower = |axis: &Machine, operating: &Operating| -> StudyResult<f64> {
        let force = |name: &str| -> StudyResult<f64> { Ok(contact(axis, name)?.force_n(operating)) };
        Ok(force("bearing-lower")? / (force("bearing-lower")? + force("bearing-upper")?))
    };
    let halves = with_halves()?;
    let mut figures = Vec::new();
    for (a, z) in [(0.0, 0.2), (0.0, 0.05), (10.0, 0.05)] {
        let condition = here(a, z);
        figures.push(
            at("Eq. 12")
                .figure(format!("share of the lower bearings at a = {a} m/s², z = {z} m"), "1")
                .printed(0.5, 0.1)
                .ours_as_printed(lower(printed, &condition)?)
                .because(format!(
                    "«equally divided at the ends of the lead screw». By compatibility of both ends at the nut, ours by default: {:.3}; first \
                     frequency {:.1} Hz in place of {:.1} Hz with halves",
                    lower(physics, &condition)?,
                    first_hz(physics, &condition)?,
                    first_hz(&halves, &condition)?,
                )),
        );
    }
    Ok(figures)
}
