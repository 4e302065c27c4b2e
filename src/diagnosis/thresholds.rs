//! How much must be left to look on, and how much an effect must take to be named: by what kind of data.

use super::evidence::Domain;

/// Limits of one kind of data. Of FRFs nulls tell how well a right model fits; the weights of modes are an error of the model that nobody knows well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Thresholds {
    /// Share of nulls that may be called something; and of those that may where it foretells positions left out, too.
    pub alpha: f64,
    pub foretold_alpha: f64,
    /// Excess of the misfit over the middle null beyond which one effect more is looked for.
    pub more: f64,
    /// Share of what is left that it must take: where no more than that excess is left then, and where there is.
    pub much: (f64, f64),
    /// Share of all that it must take: the form of the first is not known better than to some six percent.
    pub form: f64,
    /// Excess beyond which an effect that explains little is not it.
    pub little_from: f64,
    /// Excess that several effects together leave where none of them is it.
    pub none_of_them: f64,
    /// Whether models are known better than to a share of what they gain: what fits as nulls do excludes what does not, and what several effects do together must be
    /// more than a free shape does.
    pub known: bool,
}

const FRF: Thresholds = Thresholds {
    alpha: 0.002,
    foretold_alpha: 0.01,
    more: 1.2,
    much: (0.25, 0.5),
    form: 0.004,
    little_from: 2.0,
    none_of_them: 10.0,
    known: true,
};
const MODES: Thresholds = Thresholds {
    alpha: 0.001,
    foretold_alpha: 0.001,
    more: 2.0,
    much: (0.4, 0.4),
    form: 0.0,
    little_from: 5.0,
    none_of_them: f64::INFINITY,
    known: false,
};

impl Thresholds {
    /// Of a kind of data.
    pub fn of(domain: Domain) -> Self {
        match domain {
            Domain::Frf(_) => FRF,
            Domain::Modes(_) => MODES,
        }
    }

    /// By how much χ² may differ since models are not known better: a share of what is gained, of known ones no more than is left beyond nulls.
    pub fn apart(&self, of_gain: f64, chi_square: f64, excess: f64) -> f64 {
        let beyond_nulls = chi_square * (1.0 - 1.0 / excess);
        if self.known { of_gain.min(beyond_nulls) } else { of_gain }
    }
}
