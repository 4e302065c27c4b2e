//! Figures of Duan et al., twin ball screw: joints, friction and velocity. Those of the nut position are in
//! `twin_position`.

use super::figure::{contact, first_hz, read_published};
use super::twin_position::{self, CONFIG, at};
use crate::document::published::PublishedFigure;
use machine::contact::published::{
    BEARING_PAIR_STIFFNESS_N_PER_M, BEARING_PRELOAD_N, CONFORMITY_OF_STIFFNESSES, LEAD_M, MOTOR_EFFICIENCY,
    NUT_BALLS, NUT_PRELOAD_N, NUT_STIFFNESS_N_PER_M, bearing, friction_axis_1, friction_axis_2, nut,
};
use machine::contact::{
    Balls, BearingData, LoadedBalls, NutData, Observation, ScrewDrive, Stiffness, StribeckCurve,
    StribeckNoise, StribeckOptions, fit_stribeck,
};
use machine::{Machine, Operating};
use study::simulation::separations;
use study::{StudyError, StudyResult};

const AS_PRINTED: [&str; 2] = ["contact_rule=as-printed", "contact_stiffness=secant"];
/// Overrides with which the screw carries P_T·f(v), P_T = 0.90 of Eq. 11, in place of f(v).
const SHARES: [&str; 4] = [
    "contact.screw-nut-1.share=0.9",
    "contact.screw-nut-2.share=0.9",
    "contact.bearing-1.share=0.9",
    "contact.bearing-2.share=0.9",
];
/// Normal and tangential stiffness (N/m) of guide and slider.
const SLIDER_N_PER_M: [f64; 2] = [3.2e7, 1.2e7];
/// Step of velocity (m/s) in the search for the minimum frequency: 0.2 m/min.
const STEP_M_S: f64 = 1e-2 / 3.0;

/// Computes all figures of the paper.
pub fn figures() -> StudyResult<Vec<PublishedFigure>> {
    let printed = read_published(CONFIG, &AS_PRINTED)?;
    let physics = read_published(CONFIG, &[])?;
    let mended = read_published(CONFIG, &[&AS_PRINTED[..], &SHARES[..]].concat())?;
    let mut figures = joints()?;
    figures.extend(friction()?);
    figures.extend(velocity([&printed, &mended, &physics])?);
    figures.extend(twin_position::figures()?);
    Ok(figures)
}

fn joints() -> StudyResult<Vec<PublishedFigure>> {
    let nut_stiffness = |data: &NutData| -> StudyResult<f64> {
        LoadedBalls::of_nut(data)
            .and_then(|n| n.stiffness_n_per_m(NUT_PRELOAD_N, Stiffness::Secant))
            .map_err(StudyError::impossible)
    };
    let f = CONFORMITY_OF_STIFFNESSES;
    let one_turn = NutData { screw_conformity: f, nut_conformity: f, ..nut(Balls::Turns(1.0)) };
    let wider = BearingData { inner_conformity: f, outer_conformity: f, ..bearing() };
    let single = LoadedBalls::of_bearing(&bearing()).map_err(StudyError::impossible)?;
    let secant = |data: &BearingData| -> StudyResult<f64> {
        let single = LoadedBalls::of_bearing(data).map_err(StudyError::impossible)?;
        single.stiffness_n_per_m(BEARING_PRELOAD_N, Stiffness::Secant).map_err(StudyError::impossible)
    };
    // Eq. 18, last line, prints δ_n·sin α.
    let sin = bearing().contact_angle_rad.sin();
    let eq_18 = BEARING_PRELOAD_N
        / (single.deflection_m(BEARING_PRELOAD_N).map_err(StudyError::impossible)? * sin * sin)
        / 2.0;
    let five_turns =
        LoadedBalls::of_nut(&nut(Balls::Turns(5.0))).map_err(StudyError::impossible)?.ball_count();
    Ok(vec![
        at("Tab. 1")
            .figure("balls of one nut, five turns", "1")
            .printed(98.0, 1.0)
            .ours_as_printed(five_turns)
            .because("N = i·π·d/(d_b·cos λ) below Eq. 9"),
        at("4.1.1")
            .figure("nut, P/δ at 1.115 kN", "N/m")
            .printed(NUT_STIFFNESS_N_PER_M, 1e6)
            .ours_as_printed(nut_stiffness(&nut(NUT_BALLS))?)
            .mended(nut_stiffness(&one_turn)?)
            .because(
                "Eq. 7–9 with the curvatures corrected. Printed: N = 98 and conformity 0.52. Mended: one loaded turn (i = 1) and conformity \
                 0.53, which also gives the bearings",
            ),
        at("4.1.2")
            .figure("bearing pair in series, P/δ at 1 kN", "N/m")
            .printed(BEARING_PAIR_STIFFNESS_N_PER_M, 1e6)
            .ours_as_printed(eq_18)
            .mended(0.5 * secant(&wider)?)
            .because(
                "Eq. 18–20; the pitch diameter, not printed, is chosen. Printed: δ_n·sin α, which breaks the balance of work. Mended: \
                 δ_n/sin α and conformity 0.53",
            ),
        at("Eq. 20")
            .figure("bearing pair by equilibrium, in parallel, dP/dδ", "N/m")
            .mended(3.0 * secant(&bearing())?)
            .because("a preloaded pair acts in parallel: six times the series of secants. The paper prints no such number"),
        at("4.1.3").figure("guide and slider, normal stiffness", "N/m").printed(SLIDER_N_PER_M[0], 1e6).because(
            "cause unknown: «calculated by the third section», which treats nut and bearings alone; the paper states neither type nor \
             preload of the guides",
        ),
        at("4.1.3")
            .figure("guide and slider, tangential stiffness", "N/m")
            .printed(SLIDER_N_PER_M[1], 1e6)
            .because("cause unknown: as above"),
        pitch_over_yaw(),
    ])
}

/// Compares pitching (Fig. 7d) with yawing (Fig. 7c). Of a rigid table on sliders at the distance ±a from its
/// centre along the guides
///
/// ```text
/// yaw: Σ K_τ·a²/J_z       pitch: Σ K_n·a²/J_y       f_pitch/f_yaw = √(K_n/K_τ · J_z/J_y)
/// ```
///
/// A flat table has J_y < J_z, so that the root of the stiffnesses alone is a lower limit. The distance
/// cancels; inertias are not printed.
fn pitch_over_yaw() -> PublishedFigure {
    let [normal, tangential] = SLIDER_N_PER_M;
    let ratio = (normal / tangential).sqrt();
    let figure = at("4.1.3, Fig. 7")
        .figure("pitching over yawing frequency of the table on its sliders, at least", "1");
    figure.ours_as_printed(ratio).holds(ratio > 1.0).because(
        "the third mode yaws and the fourth pitches: with the printed stiffnesses of the sliders and a rigid flat table pitching is the \
         higher one; screws, which stiffen the yawing, are left out. The frequencies are not printed",
    )
}

/// Recovers Tab. 2 from simulated torques, at 0.05–50 mm/s in both directions.
fn friction() -> StudyResult<Vec<PublishedFigure>> {
    let drive = ScrewDrive::new(LEAD_M, MOTOR_EFFICIENCY).map_err(StudyError::impossible)?;
    let mut figures = Vec::new();
    for (axis, curve) in [(1, friction_axis_1()), (2, friction_axis_2())] {
        let speeds = (0..24).map(|i| 0.05e-3 * 1000.0_f64.powf(f64::from(i) / 23.0));
        let runs: Vec<Observation> = speeds
            .flat_map(|v| [v, -v])
            .map(|v| {
                // Rounded to 1 mN·m, the resolution of a drive.
                let torque_nm = (drive.torque_nm(curve.force_n(v)) * 1e3).round() / 1e3;
                Observation { velocity_m_per_s: v, force_n: drive.force_n(torque_nm), sd_n: None }
            })
            .collect();
        let fit = fit_stribeck(&runs, &StribeckOptions::new(StribeckNoise::Uniform))
            .map_err(StudyError::impossible)?;
        let StribeckCurve { coulomb_n, static_n, viscous_n_s_per_m, stribeck_velocity_m_per_s } = fit.curve;
        let rows = [
            ("F_c", "N", curve.coulomb_n, coulomb_n, 0.01),
            ("F_s", "N", curve.static_n, static_n, 0.01),
            ("d_elt", "N·s/m", curve.viscous_n_s_per_m, viscous_n_s_per_m, 10.0),
            ("v_s", "mm/s", 1e3 * curve.stribeck_velocity_m_per_s, 1e3 * stribeck_velocity_m_per_s, 0.01),
        ];
        for (name, unit, published, ours, resolution) in rows {
            let remark = "recovered by `friction` from torques simulated with the printed curve, rounded to 1 mN·m: tests the fit, not the \
                          paper, whose torques are not printed";
            let figure = at("Tab. 2").figure(format!("{name} of axis {axis}"), unit);
            figures.push(figure.printed(published, resolution).ours_as_printed(ours).because(remark));
        }
    }
    Ok(figures)
}

/// Finds the velocity (m/min) at which side B of a contact unloads.
fn unloading_m_min(machine: &Machine, name: &str) -> StudyResult<f64> {
    let sweep = |v: f64| Operating { velocity_m_s: Some(v), ..Operating::default() };
    let found = separations(contact(machine, name)?, (1e-3, 1.5), sweep).into_iter().find(|s| s.side == "B");
    found
        .map(|s| 60.0 * s.at)
        .ok_or_else(|| StudyError::impossible(format!("{name} does not unload below 90 m/min")))
}

/// Finds the velocity (m/min) of the lowest first frequency; `None` where the frequency rises from rest on.
fn softest_m_min(machine: &Machine) -> StudyResult<Option<f64>> {
    let mut least = (0.0, f64::INFINITY);
    for step in 1..=300 {
        let v = f64::from(step) * STEP_M_S;
        let here = Operating { velocity_m_s: Some(v), ..Operating::at_nut(twin_position::nut_m(0.5)) };
        machine.check_operating("velocity", &here).map_err(StudyError::impossible)?;
        let hz = first_hz(machine, &here)?;
        if hz < least.1 {
            least = (v, hz);
        }
    }
    Ok((least.0 > STEP_M_S).then_some(60.0 * least.0))
}

fn velocity([printed, mended, physics]: [&Machine; 3]) -> StudyResult<Vec<PublishedFigure>> {
    let nut_1 = |machine: &Machine, v: f64| -> StudyResult<f64> {
        let here = Operating { velocity_m_s: Some(v), ..Operating::default() };
        Ok(contact(machine, "screw-nut-1")?.at(&here).map_err(StudyError::impossible)?.stiffness_n_per_m)
    };
    let bearing_m_min = unloading_m_min(mended, "bearing-1")?;
    let equal_m_s = friction_axis_1()
        .rising_branch_velocity_m_per_s(BEARING_PRELOAD_N / MOTOR_EFFICIENCY)
        .map_err(StudyError::impossible)?;
    let equilibrium = format!(
        "By equilibrium side B of a pair unloads at 2.83·P in place of 1.83·P: nut at {:.1}, bearing at {:.1} m/min",
        unloading_m_min(physics, "screw-nut-1")?,
        unloading_m_min(physics, "bearing-1")?
    );
    Ok(vec![
        at("5.2, Fig. 12")
            .figure("velocity at which nut B unloads", "m/min")
            .printed(35.0, 1.0)
            .ours_as_printed(unloading_m_min(printed, "screw-nut-1")?)
            .mended(unloading_m_min(mended, "screw-nut-1")?)
            .because(format!(
                "Eq. 10–17 with Tab. 2, axis 1. Mended: axial force P_T·f(v), P_T = 0.90 of Eq. 11. Axis 2: {:.1} m/min. {equilibrium}",
                unloading_m_min(mended, "screw-nut-2")?
            )),
        at("5.2, Fig. 12")
            .figure("velocity of least bearing stiffness", "m/min")
            .printed(30.0, 1.0)
            .mended(bearing_m_min)
            .because(format!(
                "Eq. 18–20 as printed contain no velocity. Mended: the bearing pair unloads by the rule of Eq. 12–16 at 1.83·F_p, axial force \
                 0.9·f(v), axis 1. The axial force equals the preload («because» in the text) at {:.1} m/min",
                60.0 * equal_m_s
            )),
        at("5.2, Fig. 13")
            .figure("velocity of the least first frequency", "m/min")
            .printed(30.0, 1.0)
            .maybe_as_printed(softest_m_min(printed)?)
            .mended(bearing_m_min)
            .because(
                "by Eq. 13 and 17 the frequency only rises: no minimum. Mended: the least stiffness of the bearing, the softest link, as \
                 above",
            ),
        at("5.2, Fig. 13")
            .figure("velocity of the least first frequency, by equilibrium", "m/min")
            .mended(softest_m_min(physics)?.unwrap_or(f64::NAN))
            .because("falls and then rises, as in Fig. 13, but later: each pair is softest where a side unloads"),
        at("Fig. 12")
            .figure("nut of axis 1 at 30 m/min over at rest", "1")
            .ours_as_printed(nut_1(printed, 0.5)? / nut_1(printed, 0.0)?)
            .mended(nut_1(physics, 0.5)? / nut_1(physics, 0.0)?)
            .holds(nut_1(physics, 0.5)? < nut_1(physics, 0.0)?)
            .because(
                "«decreases with the increase of the velocity»: by Eq. 13 and 17 the loaded nut A, which counts, stiffens; by equilibrium \
                 the pair softens until B unloads",
            ),
    ])
}
