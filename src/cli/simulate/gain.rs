//! `jointid simulate gain`: cycles with different gains of the position loop.

use super::drive::{find_drive, find_response};
use super::operating::{LoadArguments, find_operating};
use crate::arguments::{OutputArguments, Sources};
use crate::long_work::not_stopped;
use crate::outcome::{CommandResult, Outcome, deliver, prepare, to_message, warn};
use crate::sources::{load_machine, stamp};
use dynamics::motion::{SCurve, SimulationSettings, gain_study};
use machine::PointMotion;
use report::columns;
use report::loops::{GainStudyDocument, GainStudyRow};

/// Arguments of `simulate gain`.
#[derive(Debug, clap::Args)]
pub struct GainArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Smallest gain of the position loop (1/min)
    #[arg(long, value_name = "K", default_value_t = 500.0)]
    pub from_per_min: f64,
    /// Largest gain of the position loop (1/min)
    #[arg(long, value_name = "K", default_value_t = 12_000.0)]
    pub to_per_min: f64,
    /// Number of gains
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u16).range(2..=1000))]
    pub points: u16,
    /// Point whose position is evaluated; by default the reading of the position encoder
    #[arg(long, value_name = "POINT")]
    pub response: Option<String>,
    /// Travel (m)
    #[arg(long, value_name = "M", default_value_t = 0.3, allow_negative_numbers = true)]
    pub travel_m: f64,
    /// Largest velocity (m/s)
    #[arg(long, value_name = "V", default_value_t = 0.5)]
    pub velocity_m_s: f64,
    /// Largest acceleration (m/s²)
    #[arg(long, value_name = "A", default_value_t = 5.0)]
    pub acceleration_m_s2: f64,
    /// Largest jerk (m/s³)
    #[arg(long, value_name = "J", default_value_t = 200.0)]
    pub jerk_m_s3: f64,
    /// Rest before and after (s)
    #[arg(long, value_name = "S", default_value_t = 0.3)]
    pub rest_s: f64,
    /// Nut position at the start, from the left end of the screw (m); mid-stroke by default
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &GainArguments) -> CommandResult {
    let loaded = load_machine(&given.sources)?;
    let machine = &loaded.config.machine;
    let drive = find_drive(&loaded)?;
    let (from, to) = (given.from_per_min, given.to_per_min);
    if !(from > 0.0 && from < to && to.is_finite()) {
        return Err(format!("--from-per-min {from} --to-per-min {to}: write two gains above 0, the smaller first"));
    }
    if !(0.2 * given.rest_s >= 5.0 * drive.position.period_s && given.rest_s.is_finite()) {
        let least = 25.0 * drive.position.period_s;
        return Err(format!("--rest-s {}: write {least} s or more, in which the axis comes to rest", given.rest_s));
    }
    // The rotation of a point is scaled to travel as by the position encoder.
    let point = given.response.as_deref().map(|name| find_response(machine, name)).transpose()?;
    let point = point.and_then(|name| machine.point(name)).map(|at| {
        let rotates = machine.points[at].motion == PointMotion::Rotation;
        (at, if rotates { drive.position.encoder.travel } else { 1.0 })
    });
    let settings = SimulationSettings {
        operating: find_operating(&loaded, given.nut_m, None, &LoadArguments::default())?,
        ..SimulationSettings::default()
    };
    let curve = SCurve {
        from: 0.0,
        to: given.travel_m,
        velocity: given.velocity_m_s,
        acceleration: given.acceleration_m_s2,
        jerk: given.jerk_m_s3,
    };
    let course = curve.course(drive.position.period_s, given.rest_s, false).map_err(to_message)?;
    let folder = prepare(&given.output)?;
    let count = usize::from(given.points);
    let gains: Vec<f64> = (0..count).map(|i| (from + (to - from) * i as f64 / (count - 1) as f64) / 60.0).collect();
    let go_on = not_stopped();
    let found = gain_study(machine, &machine.start(), &gains, (&course, given.rest_s), point, &settings, &go_on).map_err(to_message)?;
    let complete = go_on();
    let unstable: Vec<String> = found.iter().filter(|r| !r.stable).map(|r| format!("{:.0}", 60.0 * r.gain_per_s)).collect();
    let mut warnings = Vec::new();
    if complete && !unstable.is_empty() {
        warnings.push(format!("at {} 1/min the loops are unstable: these gains have no results", unstable.join(", ")));
    }
    let best = found.iter().filter(|r| r.cost.is_some()).min_by(|a, b| a.cost.unwrap_or(0.0).total_cmp(&b.cost.unwrap_or(0.0)));
    let optimum_per_s = best.map(|r| r.gain_per_s);
    if best.is_some_and(|b| b.gain_per_s == gains[0] || b.gain_per_s == gains[count - 1]) {
        warnings.push("the minimum cost lies at an end of the range; widen it with --from-per-min or --to-per-min".into());
    }
    warn(&given.output, &warnings);
    let study = GainStudyDocument {
        stamp: stamp("gain", 0, complete, &loaded, warnings),
        response: given.response.clone(),
        rows: found
            .iter()
            .map(|r| GainStudyRow {
                gain_per_s: r.gain_per_s,
                gain_per_min: 60.0 * r.gain_per_s,
                time_s: r.time_s,
                static_error: r.static_error,
                energy_j: r.energy_j,
                cost: r.cost,
            })
            .collect(),
        optimum_per_s,
    };
    let heads = ["k_v 1/min", "time s", "static error µm", "energy J", "cost", ""].map(String::from);
    let cell = |x: Option<f64>, digits: usize| x.map_or_else(|| "–".into(), |x| format!("{x:.digits$}"));
    let row = |r: &GainStudyRow| {
        vec![
            format!("{:.0}", r.gain_per_min),
            cell(r.time_s, 4),
            cell(r.static_error.map(|x| 1e6 * x), 3),
            cell(r.energy_j, 3),
            cell(r.cost, 4),
            if Some(r.gain_per_s) == optimum_per_s { "minimum".into() } else { String::new() },
        ]
    };
    deliver(&given.output, folder.as_ref(), "gain.json", &study, &columns(&heads, study.rows.iter().map(row)))?;
    Ok(if complete { Outcome::Done } else { Outcome::Stopped })
}
