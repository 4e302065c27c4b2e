//! Nuisance parameters of a machine, its records and its scales, with their standard deviations: none of them
//! is an effect.

use nalgebra::{DMatrix, DVector};

use super::data::MotionData;
use dynamics::inverse_dynamics::{ExtraChannel, MotionSignal, Rigid};
use identification::motion::nuisance_prior::{
    COMPLIANCES, DRIFT, FORCE_ALONG_TRAVEL, HOLD_SAMPLES, LOW_SPEED_RISE, LOW_SPEEDS, PRESLIDING,
    SCALE_ERROR, THINNING, TRAVEL_HALF_WAVES, WIND_UP, half_wave_share,
};
use machine::{Machine, Operating, Value};
use numeric::filter::central_differences;
use numeric::statistics::{extremes, root_mean_square};

/// A nuisance parameter: the change of all channels by one standard deviation.
#[derive(Debug, Clone, PartialEq)]
pub struct Nuisance {
    /// Name.
    pub name: String,
    /// Change of the force (N or N·m), and of the errors of extra channels, weighted as force.
    pub column: DVector<f64>,
}

/// Returns all nuisance parameters with an influence on a machine with given values along the records.
pub(super) fn nuisances(
    data: &MotionData<'_>,
    rigid: &Rigid,
    machine: &Machine,
    values: &[f64],
) -> Vec<Nuisance> {
    let of = Influences::new(data, rigid, machine, values);
    let mut all = [
        of.measuring_chain(),
        of.presliding(),
        of.compliances(),
        of.low_speed(),
        of.shear_thinning(),
        of.along_travel(),
        of.drift(),
    ]
    .concat();
    data.columns
        .iter()
        .for_each(|column| all.extend([of.scale_error(column), of.encoder_estimate(column)].concat()));
    all.retain(|n| n.column.norm() > 0.0);
    all
}

struct Influences<'o> {
    data: &'o MotionData<'o>,
    rigid: &'o Rigid,
    machine: &'o Machine,
    values: &'o [f64],
    /// Root mean square of the recorded force (N or N·m).
    level: f64,
    /// Dry friction at the drive (N or N·m).
    dry: f64,
    /// Fastest speed (m/s).
    fastest: f64,
    /// Travel of all records together, from and to (m): positions on the guide are the same in each.
    travel: (f64, f64),
}

fn along_direction(m: &MotionSignal, force: Vec<f64>) -> Vec<f64> {
    force.into_iter().zip(m.direction()).map(|(f, s)| f * s).collect()
}

/// Returns half the difference between the forces of steady forward and backward motion (N or N·m).
fn sliding(rigid: &Rigid, machine: &Machine, values: &[f64], speed_m_s: f64) -> f64 {
    0.5 * (rigid.steady(machine, values, speed_m_s) - rigid.steady(machine, values, -speed_m_s))
}

fn zero(m: &MotionSignal) -> Vec<f64> {
    vec![0.0; m.position_m.len()]
}

impl<'o> Influences<'o> {
    fn new(data: &'o MotionData<'o>, rigid: &'o Rigid, machine: &'o Machine, values: &'o [f64]) -> Self {
        let level = root_mean_square(data.motions.iter().flat_map(|m| m.load.iter().copied())).unwrap_or(0.0);
        let fastest = data.motions.iter().flat_map(|m| &m.velocity_m_s).fold(0.0_f64, |f, v| f.max(v.abs()));
        let dry = sliding(rigid, machine, values, 1e-9 * fastest).abs();
        let travel = extremes(data.motions.iter().flat_map(|m| &m.position_m));
        Influences { data, rigid, machine, values, level, dry, fastest, travel }
    }

    fn force(&self, machine: &Machine, m: &MotionSignal) -> Vec<f64> {
        self.rigid.force(machine, self.values, m)
    }

    fn nuisance(&self, name: impl Into<String>, of: impl Fn(&MotionSignal) -> Vec<f64>) -> Nuisance {
        Nuisance { name: name.into(), column: self.data.column(of) }
    }

    /// Returns a friction nuisance in units of the drive's force, with the compliance of extra measuring
    /// points under it.
    fn friction(&self, name: String, of: impl Fn(&MotionSignal) -> Vec<f64>) -> Nuisance {
        let mut column = self.data.column(&of);
        for further in &self.data.columns {
            let compliant = |m: &MotionSignal| {
                let at = m.extra_channels.iter().position(|f| f.column == *further);
                let compliant =
                    at.map_or(0.0, |at| self.rigid.deflection_per_friction(self.machine, self.values, m)[at]);
                of(m).into_iter().map(|f| compliant * f).collect::<Vec<f64>>()
            };
            column += self.data.channel(Some(further), compliant);
        }
        Nuisance { name, column }
    }

    /// Returns a cosine of `n` half-waves along the travel.
    fn wave(&self, m: &MotionSignal, n: f64, size: f64) -> Vec<f64> {
        let (low, high) = self.travel;
        m.position_m
            .iter()
            .map(|x| size * (std::f64::consts::PI * n * (x - low) / (high - low)).cos())
            .collect()
    }

    /// Returns the delay of the drive's force and the blur by filter and differences. Where an encoder
    /// position is estimated from the control loop, also a clock offset of the recorded force alone.
    fn measuring_chain(&self) -> Vec<Nuisance> {
        let slope = |m: &MotionSignal| central_differences(&self.force(self.machine, m));
        let clock = |m: &MotionSignal| slope(m).iter().map(|d| HOLD_SAMPLES * d).collect::<Vec<f64>>();
        // The estimate from the loop reveals the delay of its force more precisely than it is known.
        let late = |m: &MotionSignal| {
            let periods_s = m
                .extra_channels
                .iter()
                .filter_map(|f| Some(f.encoder_estimate.as_ref()?.periods_s))
                .fold(0.0, f64::max);
            slope(m).iter().map(|d| (HOLD_SAMPLES + periods_s / m.step_s) * d).collect::<Vec<f64>>()
        };
        let mut all = vec![
            self.nuisance("synchrony", late),
            self.nuisance("filter blur", |m| central_differences(&slope(m))),
        ];
        if self.data.is_identifiable() {
            all.push(Nuisance { name: "clock offset".into(), column: self.data.recorded_force(clock) });
        }
        all
    }

    /// Returns the machine with dry friction that builds up over a travel (m of the reading) where its
    /// description has none.
    fn elastic(&self, travel_m: f64) -> Machine {
        let mut elastic = self.machine.clone();
        for joint in &mut elastic.joints {
            let number = |value: &Value| value.at(self.values, &Operating::default());
            let (level, way) =
                (number(&joint.friction.coulomb), self.rigid.ratio(&joint.on).abs() * travel_m);
            if level > 0.0 && way > 0.0 && number(&joint.friction.presliding_stiffness) == 0.0 {
                joint.friction.presliding_stiffness = Value::number(level / way);
            }
        }
        elastic
    }

    /// Returns presliding: rolling elements and seals deform by micrometres before they slide.
    fn presliding(&self) -> Vec<Nuisance> {
        let described = self.data.column(|m| self.force(self.machine, m));
        let over = |(travel_m, sd): (f64, f64)| {
            let elastic = self.elastic(travel_m);
            let column = sd * (self.data.column(|m| self.force(&elastic, m)) - &described);
            Nuisance { name: format!("presliding over {:.1} µm", 1e6 * travel_m), column }
        };
        PRESLIDING.into_iter().map(over).collect()
    }

    /// Returns compliances of joints with undescribed parts in series.
    fn compliances(&self) -> Vec<Nuisance> {
        // Beyond a compliant joint friction builds up by presliding; subtract the influence of that alone.
        let presliding = self.elastic(Rigid::PRESLIDING_TRAVEL_M);
        let sliding = |m: &MotionSignal| self.force(&presliding, m);
        let none = self.data.column(sliding);
        let mut all = Vec::new();
        for (joint, described) in self.machine.joints.iter().enumerate() {
            let mut less = none.clone();
            for factor in COMPLIANCES {
                let compliant = |m: &MotionSignal| {
                    self.rigid.force_with_compliant_joint((joint, factor), self.machine, self.values, m)
                };
                let more = self.data.column(|m| compliant(m).unwrap_or_else(|| sliding(m)));
                all.push(Nuisance {
                    name: format!("compliance of {}, factor {factor}", described.name),
                    column: &more - &less,
                });
                less = more;
            }
        }
        all
    }

    /// Returns a slight rise of friction towards standstill.
    fn low_speed(&self) -> Vec<Nuisance> {
        let below = |share: f64| {
            let of = |m: &MotionSignal| {
                let rises =
                    |v: &f64| LOW_SPEED_RISE * self.dry * (-(v / (share * self.fastest)).powi(2)).exp();
                along_direction(m, m.velocity_m_s.iter().map(rises).collect())
            };
            self.friction(format!("friction below {:.0} % of the fastest speed", 100.0 * share), of)
        };
        LOW_SPEEDS.into_iter().map(below).collect()
    }

    /// Returns the shear thinning of an oil film.
    fn shear_thinning(&self) -> Vec<Nuisance> {
        let film = sliding(self.rigid, self.machine, self.values, self.fastest) - self.dry;
        let of = |m: &MotionSignal| {
            along_direction(
                m,
                m.velocity_m_s.iter().map(|v| -THINNING * film * (v / self.fastest).powi(2)).collect(),
            )
        };
        vec![self.friction("shear thinning of the film".into(), of)]
    }

    /// Returns smooth variations of friction and force along the travel.
    fn along_travel(&self) -> Vec<Nuisance> {
        let of = |n: u32| {
            let size = FORCE_ALONG_TRAVEL * self.level * half_wave_share(n);
            let wave = move |m: &MotionSignal| self.wave(m, f64::from(n), size);
            let friction = self.friction(format!("friction along the travel, half-wave {n}"), move |m| {
                along_direction(m, wave(m))
            });
            [friction, self.nuisance(format!("force along the travel, half-wave {n}"), wave)]
        };
        (1..=TRAVEL_HALF_WAVES).flat_map(of).collect()
    }

    /// Returns drifts of friction and force with time.
    fn drift(&self) -> Vec<Nuisance> {
        let drift = |m: &MotionSignal| {
            let count = m.position_m.len();
            (0..count)
                .map(|i| DRIFT * self.level * (2.0 * i as f64 / count as f64 - 1.0))
                .collect::<Vec<f64>>()
        };
        vec![
            self.friction("drift of friction".into(), |m| along_direction(m, drift(m))),
            self.nuisance("drift of force", drift),
        ]
    }

    /// Returns smooth errors along the travel of both scales of an extra channel, in addition to the terms
    /// that [`ExtraChannel::thinned`] removes.
    fn scale_error(&self, column: &str) -> Vec<Nuisance> {
        let of = |n: u32| {
            let wave = |m: &MotionSignal| {
                let (low, high) = extremes(&m.position_m);
                further(m, column).map_or_else(
                    || zero(m),
                    |f| {
                        self.wave(
                            m,
                            f64::from(n),
                            self.rigid.point_ratio(f.point) * SCALE_ERROR * (high - low),
                        )
                    },
                )
            };
            Nuisance {
                name: format!("scale error of {column}, half-wave {n}"),
                column: self.data.channel(Some(column), wave),
            }
        };
        (1..=3).map(of).collect()
    }

    /// Returns the nuisance parameters of an extra channel estimated from the control loop. They are the
    /// factor of the loop, wind-up, which is described in part, and the side of it on which friction acts.
    fn encoder_estimate(&self, column: &str) -> Vec<Nuisance> {
        let estimated = |m: &MotionSignal| {
            m.extra_channels.iter().position(|f| f.column == column && f.is_identifiable())
        };
        let channel = |name: String, of: &dyn Fn(&MotionSignal, usize) -> Vec<f64>| {
            let column =
                self.data.channel(Some(column), |m| estimated(m).map_or_else(|| zero(m), |at| of(m, at)));
            Nuisance { name, column }
        };
        let wind_up = |m: &MotionSignal, at: usize| {
            let wind_up = self.rigid.transmission(self.machine, self.values, m).swap_remove(at);
            wind_up.into_iter().map(|e| WIND_UP * e).collect()
        };
        let friction_side = |m: &MotionSignal, at: usize| {
            let compliant = self.rigid.deflection_per_friction(self.machine, self.values, m)[at];
            m.direction().into_iter().map(|s| WIND_UP * self.dry * compliant * s).collect()
        };
        let factor = |m: &MotionSignal, at: usize| {
            m.extra_channels[at].encoder_estimate.as_ref().map_or_else(Vec::new, |t| t.factor_m.clone())
        };
        vec![
            channel(format!("loop factor of {column}"), &factor),
            channel(format!("wind-up of {column}"), &wind_up),
            channel(format!("friction side in {column}"), &friction_side),
        ]
    }
}

fn further<'m>(m: &'m MotionSignal, column: &str) -> Option<&'m ExtraChannel> {
    m.extra_channels.iter().find(|f| f.column == column)
}

/// Returns the columns of nuisance parameters side by side.
pub(super) fn columns_of(nuisances: &[Nuisance]) -> DMatrix<f64> {
    DMatrix::from_columns(&nuisances.iter().map(|n| n.column.clone()).collect::<Vec<_>>())
}
