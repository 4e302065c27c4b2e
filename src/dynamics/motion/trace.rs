//! Results of a simulation in time.

/// Kind of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// A friction sticks.
    Sticks,
    /// A friction starts to slide.
    Slides,
    /// A friction reverses its direction of sliding.
    Reverses,
    /// A backlash closes.
    Closes,
    /// A backlash opens.
    Opens,
}

/// An event of a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Time (s).
    pub time_s: f64,
    /// Kind of the event.
    pub kind: EventKind,
    /// The joint.
    pub joint: String,
    /// 1 forward or upper side, −1 backward or lower side, 0 none.
    pub direction: i8,
}

/// One sample of a motion, once per period of the velocity loop.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceSample {
    /// Time (s).
    pub time_s: f64,
    /// Command (m or rad).
    pub command: f64,
    /// Reading of the position loop's encoder.
    pub position: f64,
    /// Velocity as measured by the velocity loop.
    pub velocity: f64,
    /// Force or torque as recorded by the drive (N or N·m).
    pub force: f64,
    /// Coordinate of every moving point (m or rad), in the order of [`Trace::points`].
    pub points: Vec<f64>,
}

/// Energy balance (J).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Work of the drive.
    pub supplied_j: f64,
    /// Work supplied while the drive's force does not oppose its motion: it drives or holds, and is not
    /// dragged.
    pub driving_j: f64,
    /// Stored energy at the end less that at the start.
    pub stored_j: f64,
    /// Energy lost in dampers, friction and windings.
    pub lost_j: f64,
    /// Sum of |work| of the drive over all steps, and the energy stored at the start: the reference of the
    /// imbalance.
    pub throughput_j: f64,
}

impl Energy {
    /// Returns |supplied − stored − lost| relative to `throughput_j`.
    pub fn imbalance(&self) -> f64 {
        let missing = (self.supplied_j - self.stored_j - self.lost_j).abs();
        if self.throughput_j > 0.0 { missing / self.throughput_j } else { missing }
    }
}

/// A motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Names of the points in [`TraceSample::points`].
    pub points: Vec<String>,
    /// Samples.
    pub samples: Vec<TraceSample>,
    /// Events in order of time.
    pub events: Vec<Event>,
    /// Energy balance.
    pub energy: Energy,
    /// Time (s) at which the motion left its bounds, and |command − position| then.
    pub unstable: Option<(f64, f64)>,
    /// Whether the motion ran to its end.
    pub complete: bool,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}
