//! Data faults of a hammer test.

use num_complex::Complex64;

use crate::draw::Draw;
use crate::hammer::series::{Fault, Line};
use crate::{Result, SimulatorError};

/// Least rms change of ln H for which a data fault counts.
const LEAST_CHANGE: f64 = 0.08;

/// A data fault of a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DataFault {
    /// One record of a faulty channel: station, channel and fault.
    FaultyChannel(usize, usize, Fault),
    /// Two records of one channel are exchanged between positions: channel and the two stations.
    Exchanged(usize, usize, usize),
}

impl DataFault {
    /// Draws a data fault for a test of so many stations and channels.
    pub fn random(stations: usize, channels: usize, band_hz: f64, draw: &mut Draw) -> Self {
        let (station, channel) = (draw.index(stations), draw.index(channels));
        match draw.index(4) {
            0 => Self::FaultyChannel(
                station,
                channel,
                Fault::LooseSensor {
                    mount_hz: draw.log_between(80.0, 0.5 * band_hz),
                    ratio: draw.between(0.05, 0.2),
                },
            ),
            1 => Self::FaultyChannel(station, channel, Fault::Clipped { share: draw.between(0.15, 0.4) }),
            2 => Self::FaultyChannel(station, channel, Fault::Dropouts { share: draw.between(0.1, 0.3) }),
            _ => {
                let apart = match 2 + draw.index(3) {
                    whole if whole % stations == 0 => 1,
                    apart => apart,
                };
                Self::Exchanged(channel, station, (station + apart) % stations)
            }
        }
    }

    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Self::FaultyChannel(_, _, Fault::LooseSensor { .. }) => "loose-sensor",
            Self::FaultyChannel(_, _, Fault::Clipped { .. }) => "clipped",
            Self::FaultyChannel(_, _, Fault::Dropouts { .. }) => "dropouts",
            Self::Exchanged(..) => "records-exchanged",
        }
    }

    /// Whether the data fault affects a record.
    pub fn affects(self, station: usize, channel: usize) -> bool {
        match self {
            Self::FaultyChannel(at, of, _) => (at, of) == (station, channel),
            Self::Exchanged(of, a, b) => of == channel && (a == station || b == station),
        }
    }

    /// Returns the channel fault of a record for the simulation of its blows.
    pub fn fault(self, station: usize, channel: usize) -> Option<Fault> {
        match self {
            Self::FaultyChannel(at, of, fault) if (at, of) == (station, channel) => Some(fault),
            _ => None,
        }
    }

    /// Exchanges two records if that is the data fault.
    pub fn exchange(self, lines: &mut [Vec<Vec<Line>>]) {
        if let Self::Exchanged(channel, a, b) = self {
            let kept = lines[a][channel].clone();
            lines[a][channel] = std::mem::replace(&mut lines[b][channel], kept);
        }
    }

    /// Returns an error if the data fault changes the accepted lines of its records too little.
    pub fn check_visible(self, exact: &[Vec<Vec<Complex64>>], lines: &[Vec<Vec<Line>>]) -> Result<()> {
        let mut largest: f64 = 0.0;
        for (station, of_station) in lines.iter().enumerate() {
            for (channel, lines) in
                of_station.iter().enumerate().filter(|(channel, _)| self.affects(station, *channel))
            {
                let accepted =
                    lines.iter().zip(&exact[station][channel]).filter(|(line, _)| line.coherence >= 0.8);
                let changes: Vec<f64> =
                    accepted.map(|(line, exact)| (line.response / exact).ln().norm_sqr() / 2.0).collect();
                largest = largest.max((changes.iter().sum::<f64>() / changes.len().max(1) as f64).sqrt());
            }
        }
        if largest >= LEAST_CHANGE {
            return Ok(());
        }
        Err(SimulatorError::TooWeak {
            effect: self.name().to_owned(),
            reached: largest,
            wanted: LEAST_CHANGE,
        })
    }
}
