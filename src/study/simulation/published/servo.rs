//! Published figures of the lumped servo axis, compared with ours. The configuration names the paper.

use super::figure::{CONFIGS, FigureSource, compared, read_published, stated};
use crate::simulation::sensitivity::mode_energy;
use crate::{StudyError, StudyResult};
use dynamics::model::elastic_frequencies_hz;
use dynamics::motion::{SCurve, SimulationSettings, gain_study};
use machine::{Machine, Operating};
use report::simulation::PublishedFigure;

const CONFIG: &str = CONFIGS[1];

fn at(place: &'static str) -> FigureSource {
    FigureSource { paper: "Lumped servo axis", place }
}

/// Computes the figures of the paper: natural frequencies, damping, deformations and the best gain of the position loop.
pub fn figures() -> StudyResult<Vec<PublishedFigure>> {
    let axis = read_published(CONFIG, &[])?;
    let rest = Operating::default();
    let all = elastic_frequencies_hz(&axis, 3, &axis.start(), &rest);
    let first = all.first().copied().ok_or_else(|| StudyError::impossible("the servo axis has no natural frequency"))?;
    let zeta = 0.5 * axis.stiffness_proportional_damping_s * std::f64::consts::TAU * first;
    let joints = mode_energy(&axis, &rest, first)?;
    // Deformations in rad are converted to travel of the nut, so that all springs are comparable. The lead is 20 mm.
    let travel_m_per_rad = 0.020 / std::f64::consts::TAU;
    let deformation = |name: &str| -> f64 {
        let scale = if ["coupling", "screw-torsion"].contains(&name) { travel_m_per_rad } else { 1.0 };
        joints.get(name).map_or(f64::NAN, |(d, _)| (d * scale).abs())
    };
    let others = ["coupling", "screw-torsion", "nut", "flange"].into_iter().map(deformation).fold(0.0, f64::max);
    let ratio = deformation("support") / others;
    let first_with_support = |factor: f64| -> StudyResult<f64> {
        let k = axis.parameter("k_0a").map_or(f64::NAN, |i| axis.start()[i]) * factor;
        let scaled = read_published(CONFIG, &[&format!("parameter.k_0a.start={k}")])?;
        elastic_frequencies_hz(&scaled, 1, &scaled.start(), &rest)
            .first()
            .copied()
            .ok_or_else(|| StudyError::impossible("the varied axis has no frequency"))
    };
    let (soft, stiff) = (first_with_support(0.5)?, first_with_support(1.5)?);
    let near = all.iter().filter(|f| (100.0..200.0).contains(*f)).count() as f64;
    // «Changes considerably» is taken as a change of the first frequency by more than 10 %.
    Ok(vec![
        compared(
            at("5"),
            "first natural frequency above 0",
            "Hz",
            (152.0, first),
            0.001,
            "the chosen stiffnesses are scaled to it, so this is no test",
        ),
        compared(at("5"), "damping ratio of that mode, b = 2ζ/ω₁", "1", (0.03, zeta), 0.001, "Eq. 19 and 21"),
        stated(
            at("Fig. 9"),
            "deformation of the support over the next largest",
            "1",
            ratio,
            ratio >= 2.0,
            "«at least doubles the others»; angles converted to travel of the nut. The paper prints no stiffness; ours are chosen",
        ),
        stated(
            at("Fig. 10"),
            "first frequency with half the support stiffness over nominal",
            "1",
            soft / first,
            soft < 0.9 * first,
            "«changes considerably»; no number printed",
        ),
        stated(
            at("Fig. 10"),
            "first frequency with 1.5 times the support stiffness over nominal",
            "1",
            stiff / first,
            stiff > 1.1 * first,
            "«changes considerably»; no number printed",
        ),
        compared(
            at("Fig. 7"),
            "natural frequencies between 100 and 200 Hz",
            "1",
            (2.0, near),
            0.1,
            "the real axis shows two, the paper's model and ours show one: the six coordinates lack a mode",
        ),
        compared(
            at("Tab. 1"),
            "best gain k_v",
            "1/min",
            (2725.0, 60.0 * best_gain_per_s(&axis)?),
            0.05,
            "`simulate gain`: friction, loops and motion profile are chosen; time and energy vary by 1 % over the gains, so the static error decides",
        ),
    ])
}

/// Finds the gain (1/s) of the position loop with the minimum cost, for the slide and the default cycle and gains of `simulate gain`.
fn best_gain_per_s(axis: &Machine) -> StudyResult<f64> {
    let curve = SCurve { from: 0.0, to: 0.3, velocity: 0.5, acceleration: 5.0, jerk: 200.0 };
    let course = curve.course(1e-3, 0.3, false).map_err(StudyError::impossible)?;
    // 500 to 12 000 1/min.
    let gains: Vec<f64> = (1..=24).map(|n| 500.0 * f64::from(n) / 60.0).collect();
    let slide = axis.point("slide").map(|at| (at, 1.0));
    let rows = gain_study(axis, &axis.start(), &gains, (&course, 0.3), slide, &SimulationSettings::default(), &|| true)
        .map_err(StudyError::impossible)?;
    let best = rows.iter().filter_map(|r| Some((r.gain_per_s, r.cost?))).min_by(|a, b| a.1.total_cmp(&b.1));
    best.map(|(gain, _)| gain).ok_or_else(|| StudyError::impossible("the servo axis is unstable or does not arrive at any gain"))
}
