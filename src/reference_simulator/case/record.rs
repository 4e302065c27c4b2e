//! The published part of a case.

use super::channel_set::Quantity;
use crate::hammer::series::Line;
use crate::machine::description::Description;
use crate::machine::point::Channel;

/// A nut position as the description states it.
#[derive(Clone, Debug, PartialEq)]
pub struct Position {
    /// l1 …
    pub name: String,
    /// Distance from the left bearing, m.
    pub nut_m: f64,
}

impl Position {
    /// Returns the name of a position by its number.
    pub fn name_of(number: usize) -> String {
        format!("l{}", number + 1)
    }

    /// Returns the nominal positions of a machine with their names.
    pub fn all(nut_m: &[f64]) -> Vec<Self> {
        nut_m.iter().enumerate().map(|(number, &nut_m)| Self { name: Self::name_of(number), nut_m }).collect()
    }
}

/// How the files of a test state the scatter of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scatter {
    /// By its coherence, and the number of blows.
    Coherence,
    /// By the standard deviation of the mean over |H|. Lines of too low coherence are left out.
    Deviation,
}

/// One measured frequency response.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Name of the nut position.
    pub position: String,
    /// Response and excitation.
    pub channel: Channel,
    /// Record name if a position has several records of one channel.
    pub name: Option<String>,
    /// Peak force if the levels differ, N.
    pub force_n: Option<f64>,
    /// Lines in the quantity of the case.
    pub lines: Vec<Line>,
}

/// A machine description and its measurement, without any part of the label.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Neutral name.
    pub name: String,
    /// The engineer's description.
    pub description: Description,
    /// Nut positions.
    pub positions: Vec<Position>,
    /// Names of the fitted positions; the others are held out. Empty where the manifest states no split: all
    /// are fitted.
    pub fit: Vec<String>,
    /// How the files state the scatter of a line.
    pub scatter: Scatter,
    /// Quantity that the manifest states.
    pub quantity: Quantity,
    /// Number of averaged blows of each record.
    pub averages: usize,
    /// Frequency responses.
    pub records: Vec<Record>,
    /// Parameters that the case declares known and keeps at their start values.
    pub freeze: Vec<String>,
    /// A second measurement of the same machine with more channels.
    pub follow_up: Option<Box<Case>>,
}

impl Record {
    /// Returns the path of the record inside its set.
    pub fn file(&self) -> String {
        let mut stem = self.position.clone();
        if self.channel.response != self.channel.excitation || self.channel.response.name() != "table" {
            stem = format!("{stem}-{}-{}", self.channel.response.name(), self.channel.excitation.name());
        }
        if let Some(name) = &self.name {
            stem = format!("{stem}-{name}");
        }
        format!("frf/{stem}.csv")
    }
}
