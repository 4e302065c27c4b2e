//! A machine whose parameters act on every kind of element, for tests of derivatives.

use machine::Machine;

/// Returns the bench with loss, integral action, relaxation, shaft, inertia, measuring chain and modifiers as
/// parameters.
pub fn everything() -> Machine {
    let text = std::fs::read_to_string("configs/tian.toml").unwrap();
    // Its parameters act on every kind of element: loss, integral action, relaxation, shaft, inertia,
    // measurement chain, modifiers.
    let more = r#"
[[effect]]
id = "everything"
description = "for the test"
rescale = [
    { part = "shaft-loss-factor", name = "screw", modifier = "replace", by = "eta" },
    { part = "shaft-diameter", name = "screw", modifier = "relative", by = "thick" },
    { part = "shaft-bore", name = "screw", modifier = "replace", by = "bore" },
    { part = "shaft-modulus", name = "screw", modifier = "relative", by = "modulus" },
    { part = "shaft-shear-modulus", name = "screw", modifier = "relative", by = "shear" },
    { part = "shaft-youngs-modulus", name = "screw", modifier = "relative", by = "youngs" },
    { part = "joint-lead-error", name = "nut", key = "growth", modifier = "added", by = "lead" },
    { part = "nut-position", name = "screw", modifier = "relative", by = "nut_scale" },
    { part = "nut-position", name = "screw", modifier = "added", by = "nut_offset" },
    { part = "point-inertia", name = "table", modifier = "relative", by = "mass" },
    { part = "joint-stiffness", name = "nut", modifier = "added", by = "slope" },
    { part = "joint-stiffness", name = "coupling", modifier = "in-series", by = "k_flange" },
    { part = "chain-delay", modifier = "replace", by = "delay" },
    { part = "chain-gain", modifier = "relative", by = "factor" },
    { part = "chain-power", modifier = "replace", by = "power" },
]
[[effect.joint]]
name = "pad"
between = ["table", "ground"]
stiffness = 1e6
damping = "c_pad"
loss_factor = "eta_pad"
integral_rate = "w_pad"
relaxation_stiffness = "k_pad"
[effect.parameter]
eta = { unit = "1", start = 0.01, lower = 0.0, upper = 0.1 }
bore = { unit = "1", start = 0.3, lower = 0.0, upper = 0.8 }
thick = { unit = "1", start = 0.02, lower = -0.1, upper = 0.1 }
modulus = { unit = "1", start = 0.01, lower = -0.1, upper = 0.1, sd = 0.02 }
shear = { unit = "1", start = -0.01, lower = -0.1, upper = 0.1, sd = 0.02 }
nut_scale = { unit = "1", start = 0.03, lower = -0.2, upper = 0.2 }
nut_offset = { unit = "m", start = 0.01, lower = -0.03, upper = 0.03 }
lead = { unit = "1", start = 0.03, lower = -0.2, upper = 0.2 }
youngs = { unit = "1", start = 0.03, lower = -0.2, upper = 0.2 }
mass = { unit = "1", start = -0.03, lower = -0.2, upper = 0.2 }
slope = { unit = "N/m", start = 0.2, lower = -1e8, upper = 1e8 }
k_flange = { unit = "N*m/rad", start = 1e4, lower = 1e3, upper = 1e6 }
delay = { unit = "s", start = 1e-5, lower = -1e-4, upper = 1e-4 }
factor = { unit = "1", start = 0.1, lower = -0.5, upper = 0.5 }
power = { unit = "1", start = 0.1, lower = -1.0, upper = 1.0 }
c_pad = { unit = "N*s/m", start = 3e3, lower = 10.0, upper = 1e5 }
eta_pad = { unit = "1", start = 0.1, lower = 0.01, upper = 1.0 }
w_pad = { unit = "1/s", start = 5.0, lower = 0.0, upper = 50.0 }
k_pad = { unit = "N/m", start = 2e6, lower = 1e5, upper = 1e8 }
"#;
    let text =
        text.replace("effects = [\"rotor-hold\"]", "effects = [\"rotor-hold\", \"everything\"]") + more;
    config::read_machine_text("test", &text, &[], &[]).unwrap().machine
}
