//! Contour error of two axes on a circle.

use rayon::prelude::*;

use super::contour::{Circle, contour_error};
use dynamics::motion::{SimulationSettings, Trace, simulate};
use machine::PointMotion;
use numeric::parallel::OrFirstError;
use report::loops::{CircleRow, CirclesDocument};
use study::simulation::find_response;
use study::{Study, StudyError, StudyResult};

/// What [`circle`] computes.
#[derive(Debug, Clone, PartialEq)]
pub struct CircleRequest {
    /// Angular speeds (rad/min).
    pub speed_rad_min: Vec<f64>,
    /// Radius (m).
    pub radius_m: f64,
    /// Revolutions at full speed.
    pub turns: f64,
    /// Name of the point whose travel is evaluated; the reading of the position encoders where absent.
    pub response: Option<String>,
}

impl Default for CircleRequest {
    fn default() -> Self {
        CircleRequest {
            speed_rad_min: vec![60.0, 80.0, 100.0, 120.0],
            radius_m: 0.05,
            turns: 2.0,
            response: None,
        }
    }
}

/// Computes the contour error of two axes, each with its drive, on circles of several speeds. The control is
/// that of the first.
///
/// # Errors  a setting outside its range; an axis has no drive or no such point, or its position loop has
///   another period; a command is beyond the stroke.
pub fn circle(first: &Study, second: &Study, request: &CircleRequest) -> StudyResult<CirclesDocument> {
    let period_s = common_period_s(first, second)?;
    if let Some(name) = &request.response {
        for study in [first, second] {
            let point = find_response(study.machine(), name)?;
            if study.machine().points[point].motion == PointMotion::Rotation {
                return Err(StudyError::setting(
                    "response",
                    name,
                    "rotates; name a point that moves along the axis",
                ));
            }
        }
    }
    let go_on = || !first.control().stopped();
    let rows = request.speed_rad_min.par_iter().map(|speed| {
        let circle =
            Circle { radius: request.radius_m, speed_rad_s: speed / 60.0, turns: request.turns, rise_s: 1.0 };
        if circle.turns * std::f64::consts::TAU <= 2.0 * SETTLED_S * circle.speed_rad_s {
            let fault =
                format!("at {speed} rad/min the circle ends before the axes have settled; write more turns");
            return Err(StudyError::setting("turns", request.turns, fault));
        }
        let [x, y] = circle.courses(period_s)?;
        let travel = |study: &Study, course| {
            let machine = study.machine();
            let run = simulate(machine, &machine.start(), course, &SimulationSettings::default(), &go_on);
            run.map(|trace| (travel(&trace, request.response.as_deref()), trace))
                .map_err(|e| StudyError::input(&study.config().path, e.to_string()))
        };
        let ((x, x_trace), (y, y_trace)) = (travel(first, &x)?, travel(second, &y)?);
        Ok((x_trace.complete && y_trace.complete)
            .then(|| row(*speed, &circle, period_s, (&x, &y), &x_trace, &y_trace)))
    });
    let rows = rows.or_first_error()?;
    let complete = rows.iter().all(Option::is_some);
    let mut stamp = first.stamp("circle", 0, complete, Vec::new());
    stamp.inputs.extend(second.inputs());
    if !complete {
        stamp.warnings.push("an axis diverged or was stopped; its circles are left out".into());
    }
    Ok(CirclesDocument {
        stamp,
        response: request.response.clone(),
        radius_m: request.radius_m,
        rows: rows.into_iter().flatten().collect(),
    })
}

/// Returns the period (s) of both position loops.
///
/// # Errors  an axis has no drive; the periods differ.
fn common_period_s(first: &Study, second: &Study) -> StudyResult<f64> {
    let period_s =
        [first, second].map(|study| study.machine().drive.as_ref().map(|drive| drive.position.period_s));
    let [Some(x_s), Some(y_s)] = period_s else {
        return Err(StudyError::input(&first.config().path, "an axis has no drive; describe one as [drive]"));
    };
    if (x_s / y_s - 1.0).abs() > 1e-9 {
        let fault = format!(
            "drive.position.period_s: {x_s} s and {y_s} s differ between the axes; write the same for both"
        );
        return Err(StudyError::impossible(fault));
    }
    Ok(x_s)
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

fn row(
    speed_rad_min: f64,
    circle: &Circle,
    position_s: f64,
    (x, y): (&[f64], &[f64]),
    first: &Trace,
    second: &Trace,
) -> CircleRow {
    // Evaluates full speed only, at the samples of the position loop, which both axes share.
    let step = |trace: &Trace| {
        (position_s / (trace.samples[1].time_s - trace.samples[0].time_s)).round().max(1.0) as usize
    };
    let times = first.samples.iter().step_by(step(first)).map(|s| s.time_s);
    let pairs = x.iter().step_by(step(first)).zip(y.iter().step_by(step(second))).zip(times);
    let steady: Vec<(f64, f64)> =
        pairs.filter(|(_, t)| *t > circle.rise_s + SETTLED_S).map(|((x, y), _)| (*x, *y)).collect();
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
        largest_at_quadrants_m: error
            .iter()
            .enumerate()
            .filter(|(i, _)| near(*i))
            .map(|(_, e)| (e - mean).abs())
            .reduce(f64::max),
    }
}
