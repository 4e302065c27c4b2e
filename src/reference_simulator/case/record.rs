//! What a case gives away.

use super::layout::{Layout, Quantity};
use crate::hammer::series::Line;
use crate::machine::description::Description;
use crate::machine::point::Channel;

/// One nut position as the engineer knows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Position {
    /// l1 …
    pub name: String,
    /// Distance from the left bearing.
    pub nut_m: f64,
}

/// One measured frequency response.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Name of its position.
    pub position: String,
    /// Response and excitation.
    pub channel: Channel,
    /// Name, where a position has several of one channel.
    pub name: Option<String>,
    /// Peak force, where levels differ.
    pub force_n: Option<f64>,
    /// Lines in the case's quantity.
    pub lines: Vec<Line>,
}

/// A machine, its measurement, and nothing of what is behind them.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Name; says nothing.
    pub name: String,
    /// What the engineer believes.
    pub description: Description,
    /// Nut positions.
    pub positions: Vec<Position>,
    /// Names of the positions to fit; the others are held out.
    pub fit: Vec<String>,
    /// Channels.
    pub layout: Layout,
    /// Quantity as the manifest states it.
    pub quantity: Quantity,
    /// Blows averaged for each record.
    pub averages: usize,
    /// Frequency responses.
    pub records: Vec<Record>,
    /// Parameters that the user declares known and keeps at their start values.
    pub freeze: Vec<String>,
    /// A second measurement of the same machine with more channels.
    pub follow_up: Option<Box<Case>>,
}

impl Record {
    /// File of the record inside its set.
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
