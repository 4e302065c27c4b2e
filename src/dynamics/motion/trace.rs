//! What comes of a motion.

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// A friction came to rest.
    Sticks,
    /// A friction began to slide.
    Slides,
    /// A friction went from sliding one way to the other.
    Reverses,
    /// A play closed.
    Closes,
    /// A play opened.
    Opens,
}

/// An event of a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// When (s).
    pub time_s: f64,
    /// What.
    pub kind: EventKind,
    /// The joint.
    pub joint: String,
    /// Forward or upper side 1, backward or lower side −1, none 0.
    pub direction: i8,
}

/// One sample of a motion, at a period of the velocity loop.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceSample {
    /// Time (s).
    pub time_s: f64,
    /// Command (m or rad).
    pub command: f64,
    /// What the position loop's encoder reads.
    pub position: f64,
    /// Velocity as the velocity loop has it.
    pub velocity: f64,
    /// Force or torque as the drive records it (N or N·m).
    pub force: f64,
    /// Coordinate of every point that moves (m or rad), in the order of [`Trace::points`].
    pub points: Vec<f64>,
}

/// Where the energy went (J).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Work of the drive.
    pub supplied_j: f64,
    /// What of it was put in while the drive's force did not go against its motion: it drives or holds, and is not dragged.
    pub driving_j: f64,
    /// Stored at the end less stored at the start.
    pub stored_j: f64,
    /// Lost in dampers and friction.
    pub lost_j: f64,
    /// Sum of |work| of the drive, step by step, and of what is stored at the start: what an error is compared with.
    pub turned_over_j: f64,
}

impl Energy {
    /// |supplied − stored − lost| over what was turned over.
    pub fn imbalance(&self) -> f64 {
        let missing = (self.supplied_j - self.stored_j - self.lost_j).abs();
        if self.turned_over_j > 0.0 { missing / self.turned_over_j } else { missing }
    }
}

/// A motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Names of the points that [`TraceSample::points`] lists.
    pub points: Vec<String>,
    /// Samples.
    pub samples: Vec<TraceSample>,
    /// Events in the order of time.
    pub events: Vec<Event>,
    /// Energy.
    pub energy: Energy,
    /// When it left its bounds, and |command − position| then.
    pub unstable: Option<(f64, f64)>,
    /// Whether it ran to its end.
    pub complete: bool,
    /// What a person should know.
    pub warnings: Vec<String>,
}
