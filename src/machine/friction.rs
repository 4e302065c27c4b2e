//! Nonlinear properties of a joint: friction, backlash and lead error. Only motion depends on them.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::{MachineError, fault};
use super::{NumberSource, Value};

/// A periodic function of the travel: c·cos(2π·x/p) + s·sin(2π·x/p), of amplitude √(c² + s²).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Wave {
    /// c.
    pub cosine: Value,
    /// s.
    pub sine: Value,
    /// Period p (m or rad of the travel); 0 without a wave.
    pub period: Value,
}

/// Friction of a joint, on the rate v of its combination Σ cᵢ·qᵢ.
///
/// ```text
/// F = sgn(v)·g(v) + d·|v| + o             g = F_c + ΔF·exp(−(|v|/v_s)^n) + table(|v|) + wave(x) + µ·|L|,  not below 0
/// ```
///
/// At rest the friction balances the applied force, up to g(0) around o. With a presliding stiffness σ₀ the
/// contact deforms elastically before it slides (LuGre): F = σ₀·z + σ₁·ż + d·|v| + o, ż = v − σ₀·|v|/g(v)·z.
///
/// Viscous friction is the joint's damping; d raises its coefficient forward and lowers it backward. The
/// constant o is half the difference of the forward and backward Coulomb levels, or a weight; the two cannot
/// be distinguished.
///
/// # Units      forces in N (N·m on angles), v in m/s (rad/s), d and σ₁ in N·s/m, σ₀ in N/m, v_s in m/s, x in
///   m
/// # Limits     σ₀ → ∞ gives friction without presliding
/// # Source     Duan et al., Eq. 11 (n = 2); hybrid multi-domain, Eq. 14 (n = 1; Deviation: |v| in the
///   exponent, where the paper prints the
/// signed speed); Canudas de Wit et al., IEEE Trans. Autom. Control 40 (1995) 419–425 (LuGre).
#[derive(Debug, Clone, PartialEq)]
pub struct Friction {
    /// Coulomb level F_c.
    pub coulomb: Value,
    /// Constant force o.
    pub offset: Value,
    /// d: added to the viscous coefficient forward, subtracted backward.
    pub viscous_asymmetry: Value,
    /// ΔF: static minus Coulomb level.
    pub stribeck: Value,
    /// v_s.
    pub stribeck_velocity: Value,
    /// n.
    pub stribeck_exponent: Value,
    /// σ₀; 0 for none.
    pub presliding_stiffness: Value,
    /// σ₁.
    pub presliding_damping: Value,
    /// Position-dependent part of the level.
    pub position: Wave,
    /// µ: share of the force L transmitted by `load_of`, or of the drive's axial force where that is `None`.
    pub load_share: Value,
    /// Joint (index) whose force loads the friction.
    pub load_of: Option<usize>,
    /// Measured part of the level over the speed.
    pub table: FrictionTable,
}

/// A measured friction curve: level over speed, in rising speed. Linear between its rows, constant outside.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrictionTable(Arc<[[f64; 2]]>);

impl FrictionTable {
    /// Checks the rows [speed, level] of a table under a key.
    ///
    /// # Errors  fewer than two rows, speeds that are negative or do not rise, a level that is no number or
    ///   negative.
    pub fn new(key: &str, rows: &[[f64; 2]]) -> Result<Self, MachineError> {
        let refused = |row: usize, what: String| Err(fault(key, format!("row {}: {what}", row + 1)));
        if rows.len() < 2 {
            return Err(fault(
                key,
                format!("has {} row(s); write at least two, each [speed, force]", rows.len()),
            ));
        }
        for (at, [speed, level]) in rows.iter().enumerate() {
            if !(*speed >= 0.0 && speed.is_finite()) {
                return refused(
                    at,
                    format!(
                        "the speed is {speed}; write 0 or a number above it, since the law is the same in both directions"
                    ),
                );
            }
            if !(*level >= 0.0 && level.is_finite()) {
                return refused(
                    at,
                    format!(
                        "the force is {level}; write 0 or a number above it, since friction acts against the motion"
                    ),
                );
            }
            if at > 0 && !(*speed > rows[at - 1][0]) {
                return refused(
                    at,
                    format!("the speed {speed} does not exceed {}; sort the rows by speed", rows[at - 1][0]),
                );
            }
        }
        Ok(FrictionTable(rows.into()))
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the level at a velocity; 0 without rows.
    pub fn level(&self, velocity: f64) -> f64 {
        let speed = velocity.abs();
        let above = self.0.partition_point(|[s, _]| *s <= speed);
        match (above.checked_sub(1).map(|at| self.0[at]), self.0.get(above).copied()) {
            (Some([s0, g0]), Some([s1, g1])) => g0 + (g1 - g0) * (speed - s0) / (s1 - s0),
            (Some([_, level]), None) | (None, Some([_, level])) => level,
            (None, None) => 0.0,
        }
    }

    /// Returns the smallest distance of two speeds, over which the level changes; `None` without rows.
    pub fn resolution(&self) -> Option<f64> {
        self.0.windows(2).map(|pair| pair[1][0] - pair[0][0]).reduce(f64::min)
    }
}

/// Lead error of a screw joint: its combination Σ cᵢ·qᵢ is unstrained at γ·x + wave(x), x the travel of its
/// first translation. Frequency responses, modes and simulated motion multiply the lead by 1 + γ; inverse
/// dynamics adds γ·x, which is the same except for γ².
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LeadError {
    /// γ: relative lead deviation (m/m), for example thermal expansion of the lead.
    pub growth: Value,
    /// Periodic part along the travel.
    pub wave: Wave,
}

/// A periodic function of the travel, of amplitude √(cosine² + sine²).
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WaveFile {
    pub(super) cosine: Option<NumberSource>,
    pub(super) sine: Option<NumberSource>,
    /// Period (m or rad of the travel).
    pub(super) period: Option<NumberSource>,
}

/// Friction of a joint; forces in N (N·m on angles), travel in m (rad). Viscous friction is the joint's
/// damping.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrictionForceFile {
    /// Coulomb level.
    pub(super) coulomb: Option<NumberSource>,
    /// Constant force: half the difference of the forward and backward levels.
    pub(super) offset: Option<NumberSource>,
    /// Added to the viscous coefficient forward, subtracted backward.
    pub(super) viscous_asymmetry: Option<NumberSource>,
    /// Static minus Coulomb level.
    pub(super) stribeck: Option<NumberSource>,
    /// Stribeck velocity v_s, over which the level falls.
    pub(super) stribeck_velocity: Option<NumberSource>,
    /// Exponent n of exp(−(|v|/v_s)^n); 2 by default.
    pub(super) stribeck_exponent: Option<NumberSource>,
    /// Stiffness before sliding (LuGre); none by default.
    pub(super) presliding_stiffness: Option<NumberSource>,
    /// Damping before sliding.
    pub(super) presliding_damping: Option<NumberSource>,
    /// Position-dependent part of the level.
    #[serde(default)]
    pub(super) position: WaveFile,
    /// Share of the force of `load_of` that is added to the level.
    pub(super) load_share: Option<NumberSource>,
    /// The joint, described before this one, whose force loads the friction; the drive's force by default.
    pub(super) load_of: Option<String>,
    /// Measured friction curve: rows [speed, force], added to the level; linear between them, constant
    /// outside.
    pub(super) table: Option<Vec<[f64; 2]>>,
}

/// Lead error of a screw.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeadErrorFile {
    /// Relative lead deviation along the travel (m per m), for example thermal expansion.
    pub(super) growth: Option<NumberSource>,
    /// Periodic part along the travel (m).
    #[serde(default)]
    pub(super) wave: WaveFile,
}

impl Default for Friction {
    fn default() -> Self {
        Friction {
            coulomb: Value::default(),
            offset: Value::default(),
            viscous_asymmetry: Value::default(),
            stribeck: Value::default(),
            stribeck_velocity: Value::default(),
            stribeck_exponent: Value::number(2.0),
            presliding_stiffness: Value::default(),
            presliding_damping: Value::default(),
            position: Wave::default(),
            load_share: Value::default(),
            load_of: None,
            table: FrictionTable::default(),
        }
    }
}
