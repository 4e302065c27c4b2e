//! What is ordinarily a little wrong of a machine, its records and their scales, and how far: nothing of that is an effect.

use nalgebra::DVector;

use super::data::MotionData;
use dynamics::inverse_dynamics::{ExtraChannel, MotionSignal, Rigid};
use machine::{Machine, Operating, Value};
use numeric::filter::central_differences;
use numeric::statistics::{extremes, root_mean_square};

/// Something that is ordinarily a little wrong: what one standard deviation of it does to all channels.
#[derive(Debug, Clone, PartialEq)]
pub struct Nuisance {
    /// Name.
    pub name: String,
    /// Force (N or N·m); errors of further points, weighed as force.
    pub column: DVector<f64>,
}

/// Standard deviation of the time between force and position, in samples of the record.
const SKEW: f64 = 0.25;
/// Standard deviations of friction and force that vary smoothly along the travel, and drift with time, as shares of the force's root mean square.
const ALONG: f64 = 0.015;
const DRIFT: f64 = 0.01;
/// Half waves along the travel that are ordinary; those of more than three the less, the shorter they are.
const WAVES: u32 = 7;
/// Travels (m) over which friction ordinarily builds up before it slides, the wind-up of the parts that carry it included, and the standard
/// deviation of its share that does.
const REACHES: [(f64, f64); 4] = [(0.4e-6, 1.0), (1e-6, 1.0), (2e-6, 0.5), (4e-6, 0.5)];
/// Shares of the fastest speed below which friction ordinarily rises a little, and the standard deviation of that as a share of what rubs dry.
const SLOW: [f64; 2] = [0.02, 0.1];
const CREEP: f64 = 0.03;
/// Standard deviation of the share of the viscous friction at the fastest speed that the film loses there, growing in proportion to the speed. With 5 % and
/// more, weak dry friction that a description leaves out went unseen on the development cases.
const THINS: f64 = 0.03;
/// How many times as far as described a joint ordinarily gives way, with what stands in series with it and is not described; each beside the one before it.
const GIVES: [f64; 3] = [1.0, 2.0, 4.0];
/// Standard deviations of wind-up, and of friction on the other side of it, beside what is described.
const WINDS: f64 = 2.0;
/// Standard deviation of a scale's error along the travel, per travel.
const SCALE: f64 = 2e-6;

/// All that changes anything, of a machine with these values along the records.
///
/// # Source  widths: a drive holds its force for a sample, which comes half a sample late; guides are ground to a few percent of preload; friction of a
/// warm axis changes by percents within a record; the friction of a film grows with less than the speed (in rolling bearings with its 2/3 power, after
/// Palmgren); bearings, screw and coupling together give way one to four times as far as the nut that a plain description has; linear scales of machine
/// tools are sold as good to ±3 µm (some to ±5 µm) per metre.
pub(super) fn nuisances(data: &MotionData<'_>, rigid: &Rigid, machine: &Machine, values: &[f64]) -> Vec<Nuisance> {
    let of = MotionScales::new(data, rigid, machine, values);
    let mut all = [of.chain(), of.building_up(), of.giving_way(), of.slow(), of.thinning(), of.along(), of.drifting()].concat();
    data.columns.iter().for_each(|column| all.extend([of.scale(column), of.encoder_estimate(column)].concat()));
    all.retain(|n| n.column.norm() > 0.0);
    all
}

struct MotionScales<'o> {
    data: &'o MotionData<'o>,
    rigid: &'o Rigid,
    machine: &'o Machine,
    values: &'o [f64],
    /// Root mean square of the recorded force (N or N·m).
    level: f64,
    /// Dry friction, as the drive feels it (N or N·m).
    dry: f64,
    /// Fastest speed (m/s).
    fastest: f64,
    /// Travel of all records together, from and to (m): a place of the guide is the same place in each.
    travel: (f64, f64),
}

fn turned(m: &MotionSignal, force: Vec<f64>) -> Vec<f64> {
    force.into_iter().zip(m.direction()).map(|(f, s)| f * s).collect()
}

/// Half of what a steady speed forward takes more than the same backward (N or N·m).
fn sliding(rigid: &Rigid, machine: &Machine, values: &[f64], speed_m_s: f64) -> f64 {
    0.5 * (rigid.steady(machine, values, speed_m_s) - rigid.steady(machine, values, -speed_m_s))
}

fn nothing(m: &MotionSignal) -> Vec<f64> {
    vec![0.0; m.position_m.len()]
}

impl<'o> MotionScales<'o> {
    fn new(data: &'o MotionData<'o>, rigid: &'o Rigid, machine: &'o Machine, values: &'o [f64]) -> Self {
        let level = root_mean_square(data.motions.iter().flat_map(|m| m.load.iter().copied())).unwrap_or(0.0);
        let fastest = data.motions.iter().flat_map(|m| &m.velocity_m_s).fold(0.0_f64, |f, v| f.max(v.abs()));
        let dry = sliding(rigid, machine, values, 1e-9 * fastest).abs();
        let travel = extremes(data.motions.iter().flat_map(|m| &m.position_m));
        MotionScales { data, rigid, machine, values, level, dry, fastest, travel }
    }

    fn force(&self, machine: &Machine, m: &MotionSignal) -> Vec<f64> {
        self.rigid.force(machine, self.values, m)
    }

    fn nuisance(&self, name: impl Into<String>, of: impl Fn(&MotionSignal) -> Vec<f64>) -> Nuisance {
        Nuisance { name: name.into(), column: self.data.column(of) }
    }

    /// Friction in units of the drive's force, with what further points give way under it.
    fn rubbing(&self, name: String, of: impl Fn(&MotionSignal) -> Vec<f64>) -> Nuisance {
        let mut column = self.data.column(&of);
        for further in &self.data.columns {
            let gives = |m: &MotionSignal| {
                let at = m.further.iter().position(|f| f.column == *further);
                let gives = at.map_or(0.0, |at| self.rigid.rubbed(self.machine, self.values, m)[at]);
                of(m).into_iter().map(|f| gives * f).collect::<Vec<f64>>()
            };
            column += self.data.channel(Some(further), gives);
        }
        Nuisance { name, column }
    }

    /// Half a wave, and more of them, along the travel.
    fn wave(&self, m: &MotionSignal, n: f64, size: f64) -> Vec<f64> {
        let (low, high) = self.travel;
        m.position_m.iter().map(|x| size * (std::f64::consts::PI * n * (x - low) / (high - low)).cos()).collect()
    }

    /// A drive whose force comes late, the blur of filter and differences, and where the loops tell of a point clocks apart: the record of the force alone.
    fn chain(&self) -> Vec<Nuisance> {
        let slope = |m: &MotionSignal| central_differences(&self.force(self.machine, m));
        let clock = |m: &MotionSignal| slope(m).iter().map(|d| SKEW * d).collect::<Vec<f64>>();
        // What the loops tell shows how late their force is much better than that is known.
        let late = |m: &MotionSignal| {
            let periods_s = m.further.iter().filter_map(|f| Some(f.told.as_ref()?.periods_s)).fold(0.0, f64::max);
            slope(m).iter().map(|d| (SKEW + periods_s / m.step_s) * d).collect::<Vec<f64>>()
        };
        let mut all = vec![self.nuisance("~synchrony", late), self.nuisance("~blur", |m| central_differences(&slope(m)))];
        if self.data.is_identifiable() {
            all.push(Nuisance { name: "~clock".into(), column: self.data.recorded_force(clock) });
        }
        all
    }

    /// The machine with dry friction that builds up over a travel (m of the reading) where it is described to be there at once.
    fn elastic(&self, reach_m: f64) -> Machine {
        let mut elastic = self.machine.clone();
        for joint in &mut elastic.joints {
            let number = |value: &Value| value.at(self.values, &Operating::default());
            let (level, way) = (number(&joint.friction.coulomb), self.rigid.ratio(&joint.on).abs() * reach_m);
            if level > 0.0 && way > 0.0 && number(&joint.friction.presliding_stiffness) == 0.0 {
                joint.friction.presliding_stiffness = Value::number(level / way);
            }
        }
        elastic
    }

    /// The micrometres that rolling elements and seals give way before they slide.
    fn building_up(&self) -> Vec<Nuisance> {
        let described = self.data.column(|m| self.force(self.machine, m));
        let over = |(reach_m, sd): (f64, f64)| {
            let elastic = self.elastic(reach_m);
            let column = sd * (self.data.column(|m| self.force(&elastic, m)) - &described);
            Nuisance { name: format!("~slides after {:.1} µm", 1e6 * reach_m), column }
        };
        REACHES.into_iter().map(over).collect()
    }

    /// Joints that give way, and what stands in series with them.
    fn giving_way(&self) -> Vec<Nuisance> {
        // Where something gives way, friction builds up beyond it: not what that does by itself.
        let building_up = self.elastic(Rigid::BUILDS_UP_M);
        let sliding = |m: &MotionSignal| self.force(&building_up, m);
        let none = self.data.column(sliding);
        let mut all = Vec::new();
        for (joint, described) in self.machine.joints.iter().enumerate() {
            let mut less = none.clone();
            for times in GIVES {
                let gives = |m: &MotionSignal| self.rigid.force_giving_way((joint, times), self.machine, self.values, m);
                let more = self.data.column(|m| gives(m).unwrap_or_else(|| sliding(m)));
                all.push(Nuisance { name: format!("~{} gives way {times} times", described.name), column: &more - &less });
                less = more;
            }
        }
        all
    }

    /// Friction that rises a little towards rest.
    fn slow(&self) -> Vec<Nuisance> {
        let below = |share: f64| {
            let of = |m: &MotionSignal| {
                let rises = |v: &f64| CREEP * self.dry * (-(v / (share * self.fastest)).powi(2)).exp();
                turned(m, m.velocity_m_s.iter().map(rises).collect())
            };
            self.rubbing(format!("~friction below {:.0} % of the fastest", 100.0 * share), of)
        };
        SLOW.into_iter().map(below).collect()
    }

    /// A film of oil whose viscosity falls with the speed at which it is sheared.
    fn thinning(&self) -> Vec<Nuisance> {
        let film = sliding(self.rigid, self.machine, self.values, self.fastest) - self.dry;
        let of = |m: &MotionSignal| turned(m, m.velocity_m_s.iter().map(|v| -THINS * film * (v / self.fastest).powi(2)).collect());
        vec![self.rubbing("~film thins".into(), of)]
    }

    /// Friction and force that vary smoothly along the travel.
    fn along(&self) -> Vec<Nuisance> {
        let of = |n: u32| {
            let size = ALONG * self.level * (3.0 / f64::from(n)).min(1.0);
            let wave = move |m: &MotionSignal| self.wave(m, f64::from(n), size);
            let friction = self.rubbing(format!("~friction along {n}"), move |m| turned(m, wave(m)));
            [friction, self.nuisance(format!("~force along {n}"), wave)]
        };
        (1..=WAVES).flat_map(of).collect()
    }

    /// Friction and force that drift with time.
    fn drifting(&self) -> Vec<Nuisance> {
        let drift = |m: &MotionSignal| {
            let count = m.position_m.len();
            (0..count).map(|i| DRIFT * self.level * (2.0 * i as f64 / count as f64 - 1.0)).collect::<Vec<f64>>()
        };
        vec![self.rubbing("~drift of friction".into(), |m| turned(m, drift(m))), self.nuisance("~drift of force", drift)]
    }

    /// Errors of both scales of a further point and of the way that vary smoothly along the travel, beside what
    /// [`Further::thinned`](dynamics::inverse_dynamics::Further::thinned) takes out.
    fn scale(&self, column: &str) -> Vec<Nuisance> {
        let of = |n: u32| {
            let wave = |m: &MotionSignal| {
                let (low, high) = extremes(&m.position_m);
                further(m, column)
                    .map_or_else(|| nothing(m), |f| self.wave(m, f64::from(n), self.rigid.point_ratio(f.point) * SCALE * (high - low)))
            };
            Nuisance { name: format!("~scale of {column} along {n}"), column: self.data.channel(Some(column), wave) }
        };
        (1..=3).map(of).collect()
    }

    /// What is ordinarily wrong of a further point that the loops tell of: their factor; wind-up, which is described in part,
    /// and on which side of it friction sits.
    fn encoder_estimate(&self, column: &str) -> Vec<Nuisance> {
        let told = |m: &MotionSignal| m.further.iter().position(|f| f.column == column && f.is_identifiable());
        let channel = |name: String, of: &dyn Fn(&MotionSignal, usize) -> Vec<f64>| {
            let column = self.data.channel(Some(column), |m| told(m).map_or_else(|| nothing(m), |at| of(m, at)));
            Nuisance { name, column }
        };
        let winds = |m: &MotionSignal, at: usize| {
            let winds = self.rigid.transmission(self.machine, self.values, m).swap_remove(at);
            winds.into_iter().map(|e| WINDS * e).collect()
        };
        let sides = |m: &MotionSignal, at: usize| {
            let gives = self.rigid.rubbed(self.machine, self.values, m)[at];
            m.direction().into_iter().map(|s| WINDS * self.dry * gives * s).collect()
        };
        let factor = |m: &MotionSignal, at: usize| m.further[at].told.as_ref().map_or_else(Vec::new, |t| t.factor_m.clone());
        vec![
            channel(format!("~factor of the loops of {column}"), &factor),
            channel(format!("~wind-up of {column}"), &winds),
            channel(format!("~side of friction in {column}"), &sides),
        ]
    }
}

fn further<'m>(m: &'m MotionSignal, column: &str) -> Option<&'m ExtraChannel> {
    m.further.iter().find(|f| f.column == column)
}
