//! What a joint does beside its spring and damper: friction, play, errors of its lead. Only motion shows it.

use schemars::JsonSchema;
use serde::Deserialize;

use super::{NumberSource, Value};

/// A wave over the travel: c·cos(2π·x/p) + s·sin(2π·x/p), of amplitude √(c² + s²).
#[derive(Debug, Clone, PartialEq)]
pub struct Wave {
    /// c.
    pub cosine: Value,
    /// s.
    pub sine: Value,
    /// Period p (m or rad of the travel); no wave where it is 0.
    pub period: Value,
}

/// Friction of a joint, on the rate v of its combination Σ cᵢ·qᵢ.
///
/// ```text
/// F = sgn(v)·g(v) + d·|v| + o             g = F_c + ΔF·exp(−(|v|/v_s)^n) + wave(x) + µ·|L|,  not below 0
/// ```
///
/// At rest, whatever force holds the joint, up to g(0) around o. With a presliding stiffness σ₀ the contact is elastic before it slides
/// (LuGre): F = σ₀·z + σ₁·ż + d·|v| + o, ż = v − σ₀·|v|/g(v)·z. Viscous friction is the joint's damping; d is what it has more forward, and less
/// backward. The constant o is half the difference of the Coulomb levels forward and backward (or a weight): the two cannot be told apart.
///
/// # Units      forces in N (N·m on angles), v in m/s (rad/s), d and σ₁ in N·s/m, σ₀ in N/m, v_s in m/s, x in m
/// # Limits     σ₀ → ∞ is friction without presliding
/// # Source     Duan et al., Eq. 11 (n = 2); hybrid multi-domain, Eq. 14 (n = 1; Deviation: |v| in the exponent, where the speed is printed with
/// its sign); Canudas de Wit et al., IEEE Trans. Autom. Control 40 (1995) 419–425 (LuGre).
#[derive(Debug, Clone, PartialEq)]
pub struct Friction {
    /// Coulomb level F_c.
    pub coulomb: Value,
    /// Constant force o.
    pub offset: Value,
    /// d: the viscous coefficient forward is higher by it, backward lower.
    pub viscous_asymmetry: Value,
    /// ΔF: static less Coulomb level.
    pub stribeck: Value,
    /// v_s.
    pub stribeck_velocity: Value,
    /// n.
    pub stribeck_exponent: Value,
    /// σ₀; 0 for none.
    pub presliding_stiffness: Value,
    /// σ₁.
    pub presliding_damping: Value,
    /// The part of the level that depends on the position.
    pub position: Wave,
    /// µ: share of the force L that goes through `load_of`, or of the drive's along the axis where that is `None`.
    pub load_share: Value,
    /// Joint (index) whose force loads it.
    pub load_of: Option<usize>,
}

/// Error of the lead of a screw joint: its combination Σ cᵢ·qᵢ is unstrained at γ·x + wave(x), x the travel of its first translation.
#[derive(Debug, Clone, PartialEq)]
pub struct LeadError {
    /// γ: growth along the travel, as heat makes it.
    pub growth: Value,
    /// What repeats along the travel.
    pub wave: Wave,
}

/// A wave over the travel, of amplitude √(cosine² + sine²).
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WaveFile {
    pub(super) cosine: Option<NumberSource>,
    pub(super) sine: Option<NumberSource>,
    /// Travel after which it repeats (m or rad).
    pub(super) period: Option<NumberSource>,
}

/// Friction of a joint; forces in N (N·m on angles), travel in m (rad). Viscous friction is the joint's damping.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrictionForceFile {
    /// Coulomb level.
    pub(super) coulomb: Option<NumberSource>,
    /// Constant force: half the difference of the levels forward and backward.
    pub(super) offset: Option<NumberSource>,
    /// What the viscous coefficient has more forward, and less backward.
    pub(super) viscous_asymmetry: Option<NumberSource>,
    /// Static less Coulomb level.
    pub(super) stribeck: Option<NumberSource>,
    /// Velocity over which the level falls.
    pub(super) stribeck_velocity: Option<NumberSource>,
    /// Exponent n of exp(−(|v|/v_s)^n); 2 by default.
    pub(super) stribeck_exponent: Option<NumberSource>,
    /// Stiffness before sliding (LuGre); none by default.
    pub(super) presliding_stiffness: Option<NumberSource>,
    /// Damping before sliding.
    pub(super) presliding_damping: Option<NumberSource>,
    /// Part of the level that depends on the position.
    pub(super) position: Option<WaveFile>,
    /// Share of the force of `load_of` that adds to the level.
    pub(super) load_share: Option<NumberSource>,
    /// The joint, described before this one, whose force loads it; the drive's force by default.
    pub(super) load_of: Option<String>,
}

/// Error of a screw's lead.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeadErrorFile {
    /// Growth along the travel (m per m).
    pub(super) growth: Option<NumberSource>,
    /// What repeats along the travel (m).
    pub(super) wave: Option<WaveFile>,
}

fn zero() -> Value {
    Value::number(0.0)
}

impl Default for Wave {
    fn default() -> Self {
        Wave { cosine: zero(), sine: zero(), period: zero() }
    }
}

impl Default for LeadError {
    fn default() -> Self {
        LeadError { growth: zero(), wave: Wave::default() }
    }
}

impl Default for Friction {
    fn default() -> Self {
        Friction {
            coulomb: zero(),
            offset: zero(),
            viscous_asymmetry: zero(),
            stribeck: zero(),
            stribeck_velocity: zero(),
            stribeck_exponent: Value::number(2.0),
            presliding_stiffness: zero(),
            presliding_damping: zero(),
            position: Wave::default(),
            load_share: zero(),
            load_of: None,
        }
    }
}

/// The numbers of a part, and of parts of it that may be absent, under their configuration keys, to be read and to be changed.
macro_rules! numbers {
    ($part:ty: $($key:literal $field:ident $(. $inner:ident)*,)+ $(; $($option:ident),+)?) => {
        impl $part {
            pub(super) fn values(&self) -> Vec<(&'static str, &Value)> {
                let own = vec![$(($key, &self.$field$(.$inner)*)),+];
                let all = own.into_iter();
                $($(let all = all.chain(self.$option.iter().flat_map(|part| part.values()));)+)?
                all.collect()
            }

            pub(super) fn values_mut(&mut self) -> Vec<(&'static str, &mut Value)> {
                let own = vec![$(($key, &mut self.$field$(.$inner)*)),+];
                let all = own.into_iter();
                $($(let all = all.chain(self.$option.iter_mut().flat_map(|part| part.values_mut()));)+)?
                all.collect()
            }
        }
    };
}
pub(super) use numbers;

numbers!(Friction:
    "coulomb" coulomb,
    "offset" offset,
    "viscous_asymmetry" viscous_asymmetry,
    "stribeck" stribeck,
    "stribeck_velocity" stribeck_velocity,
    "stribeck_exponent" stribeck_exponent,
    "presliding_stiffness" presliding_stiffness,
    "presliding_damping" presliding_damping,
    "position.cosine" position.cosine,
    "position.sine" position.sine,
    "position.period" position.period,
    "load_share" load_share,
);

numbers!(LeadError:
    "growth" growth,
    "wave.cosine" wave.cosine,
    "wave.sine" wave.sine,
    "wave.period" wave.period,
);
