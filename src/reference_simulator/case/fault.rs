//! What goes wrong with one channel of a test.

use num_complex::Complex64;

use crate::TruthError;
use crate::draw::Draw;
use crate::hammer::series::{Fault, Line};

/// Least root-mean-square change of ln H of a faulty record.
const LEAST_CHANGE: f64 = 0.08;

/// One trouble of a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trouble {
    /// One record of a bad channel: station, channel and fault.
    Bad(usize, usize, Fault),
    /// Two records of one channel under each other's position: channel and the two stations.
    Exchanged(usize, usize, usize),
}

impl Trouble {
    /// Draws one for a test of so many stations and channels.
    pub fn drawn(stations: usize, channels: usize, band_hz: f64, draw: &mut Draw) -> Self {
        let (station, channel) = (draw.index(stations), draw.index(channels));
        match draw.index(4) {
            0 => Self::Bad(
                station,
                channel,
                Fault::LooseSensor { mount_hz: draw.log_between(80.0, 0.5 * band_hz), ratio: draw.between(0.05, 0.2) },
            ),
            1 => Self::Bad(station, channel, Fault::Clipped { share: draw.between(0.15, 0.4) }),
            2 => Self::Bad(station, channel, Fault::Dropouts { share: draw.between(0.1, 0.3) }),
            _ => Self::Exchanged(channel, station, (station + 2 + draw.index(3)) % stations),
        }
    }

    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bad(_, _, Fault::LooseSensor { .. }) => "loose-sensor",
            Self::Bad(_, _, Fault::Clipped { .. }) => "clipped",
            Self::Bad(_, _, Fault::Dropouts { .. }) => "dropouts",
            Self::Exchanged(..) => "records-exchanged",
        }
    }

    /// Whether a record is concerned.
    pub fn concerns(self, station: usize, channel: usize) -> bool {
        match self {
            Self::Bad(at, of, _) => (at, of) == (station, channel),
            Self::Exchanged(of, a, b) => of == channel && (a == station || b == station),
        }
    }

    /// The fault of a record, for the simulation of its blows.
    pub fn fault(self, station: usize, channel: usize) -> Option<Fault> {
        match self {
            Self::Bad(at, of, fault) if (at, of) == (station, channel) => Some(fault),
            _ => None,
        }
    }

    /// Exchanges records, if that is the trouble.
    pub fn exchange(self, lines: &mut [Vec<Vec<Line>>]) {
        if let Self::Exchanged(channel, a, b) = self {
            let kept = lines[a][channel].clone();
            lines[a][channel] = std::mem::replace(&mut lines[b][channel], kept);
        }
    }

    /// Refuses a trouble that changes the accepted lines of its records too little to be one.
    pub fn shows(self, exact: &[Vec<Vec<Complex64>>], lines: &[Vec<Vec<Line>>]) -> Result<(), TruthError> {
        let mut largest: f64 = 0.0;
        for (station, of_station) in lines.iter().enumerate() {
            for (channel, lines) in of_station.iter().enumerate().filter(|(channel, _)| self.concerns(station, *channel)) {
                let accepted = lines.iter().zip(&exact[station][channel]).filter(|(line, _)| line.coherence >= 0.8);
                let changes: Vec<f64> = accepted.map(|(line, exact)| (line.response / exact).ln().norm_sqr() / 2.0).collect();
                largest = largest.max((changes.iter().sum::<f64>() / changes.len().max(1) as f64).sqrt());
            }
        }
        if largest >= LEAST_CHANGE {
            return Ok(());
        }
        Err(TruthError::TooWeak { effect: self.name().to_owned(), reached: largest, wanted: LEAST_CHANGE })
    }
}
