//! `jointid simulate circle`: contour error of two axes on a circle.

use rayon::prelude::*;

use super::drive::find_response;
use crate::arguments::{OutputArguments, Sources};
use crate::long_work::not_stopped;
use crate::outcome::{CommandResult, Outcome, deliver, prepare, to_message, warn};
use crate::sources::{Loaded, inputs, load_machine, stamp};
use dynamics::motion::{Circle, SimulationSettings, Trace, contour_error, simulate};
use machine::PointMotion;
use numeric::parallel::OrFirstError;
use report::columns;
use report::loops::{CircleRow, CirclesDocument};

/// Arguments of `simulate circle`.
#[derive(Debug, clap::Args)]
pub struct CircleArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Configuration of the second axis; that of the first by default
    #[arg(long, alias = "beside-config", value_name = "FILE")]
    pub second_axis_config: Option<String>,
    /// Override one key of the second axis's configuration, e.g. parameter.k_s.start=1e5
    #[arg(long, alias = "beside-set", value_name = "KEY=VALUE")]
    pub second_axis_set: Vec<String>,
    /// Angular speeds (rad/min), comma-separated
    #[arg(long, value_name = "W", value_delimiter = ',', default_value = "60,80,100,120", allow_negative_numbers = true)]
    pub speed_rad_min: Vec<f64>,
    /// Radius (m)
    #[arg(long, value_name = "M", default_value_t = 0.05, allow_negative_numbers = true)]
    pub radius_m: f64,
    /// Revolutions at full speed
    #[arg(long, value_name = "N", default_value_t = 2.0, allow_negative_numbers = true)]
    pub turns: f64,
    /// Point whose travel is evaluated; by default the reading of the position encoders
    #[arg(long, value_name = "POINT")]
    pub response: Option<String>,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &CircleArguments) -> CommandResult {
    let first = load_machine(&given.sources)?;
    let second = load_machine(&Sources {
        config: given.second_axis_config.clone().unwrap_or_else(|| given.sources.config.clone()),
        set: given.sources.set.iter().chain(&given.second_axis_set).cloned().collect(),
        ..given.sources.clone()
    })?;
    let step_s = [&first, &second].map(|l| l.config.machine.drive.as_ref().map(|d| d.position.period_s));
    let [Some(x_s), Some(y_s)] = step_s else {
        return Err(format!("{}: an axis has no drive; describe one as [drive]", first.config.path));
    };
    if (x_s / y_s - 1.0).abs() > 1e-9 {
        return Err(format!("drive.position.period_s: {x_s} s and {y_s} s differ between the axes; write the same for both"));
    }
    if let Some(name) = &given.response {
        for l in [&first, &second] {
            let point = find_response(&l.config.machine, name)?;
            if l.config.machine.points.iter().any(|p| p.name == point && p.motion == PointMotion::Rotation) {
                return Err(format!("--response {name}: rotates; name a point that moves along the axis"));
            }
        }
    }
    let folder = prepare(&given.output)?;
    let go_on = not_stopped();
    let rows: Result<Vec<Option<CircleRow>>, String> = given
        .speed_rad_min
        .par_iter()
        .map(|speed| {
            let circle = Circle { radius: given.radius_m, speed_rad_s: speed / 60.0, turns: given.turns, rise_s: 1.0 };
            if circle.turns * std::f64::consts::TAU <= 2.0 * SETTLED_S * circle.speed_rad_s {
                return Err(format!(
                    "--turns {}: at {speed} rad/min the circle ends before the axes have settled; write more turns",
                    given.turns
                ));
            }
            let [x, y] = circle.courses(x_s).map_err(to_message)?;
            let travel = |loaded: &Loaded, course| {
                let machine = &loaded.config.machine;
                let run = simulate(machine, &machine.start(), course, &SimulationSettings::default(), &go_on);
                run.map(|trace| (travel(&trace, given.response.as_deref()), trace)).map_err(|e| format!("{}: {e}", loaded.config.path))
            };
            let ((x, x_trace), (y, y_trace)) = (travel(&first, &x)?, travel(&second, &y)?);
            Ok((x_trace.complete && y_trace.complete).then(|| row(*speed, &circle, x_s, (&x, &y), &x_trace, &y_trace)))
        })
        .or_first_error();
    let rows = rows?;
    let complete = rows.iter().all(Option::is_some);
    let mut stamp = stamp("circle", 0, complete, &first, Vec::new());
    stamp.inputs.extend(inputs(&second));
    if !complete {
        stamp.warnings.push("an axis diverged or was stopped; its circles are left out".into());
    }
    warn(&given.output, &stamp.warnings);
    let document =
        CirclesDocument { stamp, response: given.response.clone(), radius_m: given.radius_m, rows: rows.into_iter().flatten().collect() };
    let heads = ["rad/min", "largest contour error µm", "mean µm", "at quadrants µm"].map(String::from);
    let um = |x: f64| format!("{:.3}", 1e6 * x);
    let cells = |r: &CircleRow| {
        vec![format!("{}", r.speed_rad_min), um(r.largest_m), um(r.mean_m), r.largest_at_quadrants_m.map_or_else(|| "–".into(), um)]
    };
    deliver(&given.output, folder.as_ref(), "circle.json", &document, &columns(&heads, document.rows.iter().map(cells)))?;
    Ok(if complete { Outcome::Done } else { Outcome::Stopped })
}

/// Returns the travel of a point from its initial position, or the reading of the encoder.
fn travel(trace: &Trace, point: Option<&str>) -> Vec<f64> {
    let at = point.and_then(|name| trace.points.iter().position(|p| p == name));
    let zero = at.map_or(0.0, |at| trace.samples[0].points[at]);
    trace.samples.iter().map(|s| at.map_or(s.position, |at| s.points[at] - zero)).collect()
}

/// Angle (rad) after a change of quadrant over which its error is evaluated.
const QUADRANT_RAD: f64 = 0.2;

/// Time (s) at full speed after which a circle is evaluated.
const SETTLED_S: f64 = 0.5;

fn row(speed_rad_min: f64, circle: &Circle, position_s: f64, (x, y): (&[f64], &[f64]), first: &Trace, second: &Trace) -> CircleRow {
    // Evaluates full speed only, at the samples of the position loop, which both axes share.
    let step = |trace: &Trace| (position_s / (trace.samples[1].time_s - trace.samples[0].time_s)).round().max(1.0) as usize;
    let times = first.samples.iter().step_by(step(first)).map(|s| s.time_s);
    let pairs = x.iter().step_by(step(first)).zip(y.iter().step_by(step(second))).zip(times);
    let steady: Vec<(f64, f64)> = pairs.filter(|(_, t)| *t > circle.rise_s + SETTLED_S).map(|((x, y), _)| (*x, *y)).collect();
    let (x, y): (Vec<f64>, Vec<f64>) = steady.into_iter().unzip();
    let error = contour_error(&x, &y, circle.centre(), circle.radius);
    let largest = |of: &mut dyn Iterator<Item = f64>| of.fold(0.0_f64, |m, e| m.max(e.abs()));
    let mean = error.iter().sum::<f64>() / error.len().max(1) as f64;
    let near = |i: usize| {
        let angle = (y[i] - circle.radius).atan2(x[i]);
        angle.rem_euclid(std::f64::consts::FRAC_PI_2) < QUADRANT_RAD
    };
    CircleRow {
        speed_rad_min,
        largest_m: largest(&mut error.iter().copied()),
        mean_m: mean,
        largest_at_quadrants_m: error.iter().enumerate().filter(|(i, _)| near(*i)).map(|(_, e)| (e - mean).abs()).reduce(f64::max),
    }
}
