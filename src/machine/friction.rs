//! What a joint does beside its spring and damper: friction, play, errors of its lead. Only motion shows it.

use super::Value;

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
