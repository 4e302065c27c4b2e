//! Machines, results and files that a user hands over: implausible numbers, files that are none, links,
//! hidden characters, refused threads.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

fn jointid() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_jointid"));
    command.stdin(Stdio::null());
    command
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Runs a command that must end within a time. Returns its output.
fn run(arguments: &[&str]) -> Output {
    let begun = Instant::now();
    let output = jointid().args(arguments).output().unwrap();
    assert!(begun.elapsed() < Duration::from_secs(30), "{arguments:?} took {:?}", begun.elapsed());
    output
}

/// Asserts one line on stderr that contains `parts`, and exit code 2.
fn refused(arguments: &[&str], parts: &[&str]) -> String {
    let output = run(arguments);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    assert!(
        message.starts_with("jointid: ") && message.trim().lines().count() == 1,
        "{arguments:?}: {message}"
    );
    parts
        .iter()
        .for_each(|part| assert!(message.contains(part), "{arguments:?}: «{part}» is not in: {message}"));
    message
}

#[test]
fn implausible_numbers_are_named_with_their_likely_unit() {
    for (set, remedy) in [
        ("shaft.screw.youngs_modulus_pa=206", "206 looks like GPa; write 206e9"),
        ("shaft.screw.youngs_modulus_pa=2e5", "200000 looks like MPa"),
        ("shaft.screw.length_m=1120", "1120 looks like mm; write 1.12"),
        ("joint.nut.screw.lead_m=10", "10 looks like mm; write 0.01"),
        ("point.rotor.inertia_kg_m2=42", "42 looks like kg·cm²; write 0.0042"),
    ] {
        let modes = run(&["simulate", "modes", "--set", set]);
        let warnings = stderr(&modes);
        assert!(
            modes.status.success() && warnings.matches("warning: ").count() == 1 && warnings.contains(remedy),
            "{set}: {warnings}"
        );
    }
    // A search for thousands of modes is refused, and the message names the likely cause.
    for set in ["shaft.screw.youngs_modulus_pa=206", "shaft.screw.length_m=1120"] {
        for command in ["identify", "diagnose", "compare", "plan"] {
            refused(&[command, "--set", set], &["natural frequencies below", "looks like"]);
        }
    }
}

#[test]
fn refuse_numbers_beyond_physics_without_a_panic() {
    let keys = [
        "shaft.screw.length_m",
        "shaft.screw.diameter_m",
        "shaft.screw.youngs_modulus_pa",
        "shaft.screw.density_kg_m3",
        "point.table.mass_kg",
        "point.rotor.inertia_kg_m2",
        "joint.nut.screw.lead_m",
        "parameter.k_n.upper",
    ];
    for key in keys {
        for number in ["1e308", "-1e308", "5e-324", "inf", "nan"] {
            refused(&["simulate", "modes", "--set", &format!("{key}={number}")], &[key]);
        }
    }
    for arguments in [
        &["simulate", "modes", "--nut-m", "1e308"][..],
        &["simulate", "modes", "--max-hz", "1e308"],
        &["simulate", "frf", "--step-hz", "5e-324"],
        &["simulate", "frf", "--to-hz", "1e308"],
    ] {
        assert!(refused(arguments, &[]).len() < 300, "a number is written in full");
    }
}

#[test]
fn all_open_numbers_of_a_template_are_in_one_message() {
    let folder = tempfile::tempdir().unwrap();
    let axis = folder.path().join("axis");
    assert!(jointid().args(["init", "--quiet"]).arg(&axis).output().unwrap().status.success());
    let machine = axis.join("machine.toml");
    let keys = [
        "point.table.mass_kg",
        "point.rotor.inertia_kg_m2",
        "shaft.screw.length_m",
        "shaft.screw.diameter_m",
        "joint.nut.screw.lead_m",
    ];
    refused(&["simulate", "modes", "--config", machine.to_str().unwrap()], &keys);
}

/// Machine and measurements of a result are its own, and named in the output.
#[test]
fn a_result_brings_machine_and_measurements() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    fs::create_dir(at("set")).unwrap();
    for name in ["manifest.toml", "modes.csv", "published.csv"] {
        fs::copy(format!("measurements/tian/{name}"), format!("{}/{name}", at("set"))).unwrap();
    }
    let machine = fs::read_to_string("configs/tian.toml").unwrap().replace("title = \"", "title = \"mine, ");
    fs::write(at("machine.toml"), machine).unwrap();
    let (config, set, out) = (at("machine.toml"), at("set"), at("out"));
    let identified = run(&[
        "identify",
        "--config",
        &config,
        "--measurements",
        &set,
        "--repeats",
        "1",
        "--out",
        &out,
        "--json",
    ]);
    assert!(identified.status.success(), "{}", stderr(&identified));
    // The machine is that of the result even where its file is gone.
    fs::remove_file(&config).unwrap();
    let result = format!("{out}/identification.json");
    let hold = ["simulate", "hold", "--result", &result, "--constant", "1", "--lead-m", "0.04"];
    for arguments in [&["validate", "--result", &result][..], &["plan", "--result", &result], &hold] {
        let output = run(arguments);
        let text = String::from_utf8_lossy(&output.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            output.status.success()
                && text.contains("machine «mine, ")
                && text.contains(&format!("measurements {set}")),
            "{text}"
        );
    }
    let frf = run(&["simulate", "frf", "--result", &result, "--to-hz", "2"]);
    assert!(
        stderr(&frf).split_whitespace().collect::<Vec<_>>().join(" ").contains("machine «mine, "),
        "{}",
        stderr(&frf)
    );
    let document: Value = serde_json::from_slice(
        &run(&["simulate", "frf", "--result", &result, "--to-hz", "2", "--json"]).stdout,
    )
    .unwrap();
    let inputs: Vec<&str> =
        document["inputs"].as_array().unwrap().iter().map(|input| input["path"].as_str().unwrap()).collect();
    assert!(
        inputs.iter().any(|path| path.starts_with(&set)) && !inputs.iter().any(|path| path.contains("tian")),
        "{inputs:?}"
    );
    assert!(run(&["report", &out]).status.success());
}

/// A run with a cache of other settings gives what a run without a cache gives.
#[test]
fn cached_null_simulations_serve_their_own_settings_only() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache").display().to_string();
    let base = [
        "diagnose",
        "--positions",
        "l1,l3,l5",
        "--nulls",
        "20",
        "--repeats",
        "1",
        "--effects",
        "rotor-hold",
        "--json",
        "--quiet",
    ];
    let found = |more: &[&str]| -> Value {
        let output = jointid().args(base).args(more).output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    found(&["--cache", &cache]);
    for setting in [["--frequency-model-error", "0.05"], ["--objective", "frequencies"]] {
        let (cached, alone) = (
            found(&[&setting[..], &["--cache", &cache]].concat()),
            found(&[&setting[..], &["--no-cache"]].concat()),
        );
        assert_eq!(cached["verdict"], alone["verdict"], "{setting:?}");
        assert_eq!(cached["effects"], alone["effects"], "{setting:?}");
    }
    assert_eq!(fs::read_dir(&cache).unwrap().count(), 3);
}

#[test]
fn refuse_sets_whose_files_lie_outside_and_quote_nothing_of_them() {
    let folder = tempfile::tempdir().unwrap();
    let (set, secret) = (folder.path().join("set"), folder.path().join("secret"));
    fs::create_dir(&set).unwrap();
    fs::write(&secret, "root:x:0:0:password\nsecond\n").unwrap();
    let manifest = fs::read_to_string("measurements/tian/manifest.toml").unwrap();
    let path = set.to_str().unwrap();
    for outside in ["../secret", secret.to_str().unwrap()] {
        fs::write(set.join("manifest.toml"), manifest.replace("modes.csv", outside)).unwrap();
        refused(&["identify", "--measurements", path], &["secret", "outside the folder"]);
        let message = refused(
            &["identify", "--measurements", path, "--allow-outside"],
            &["secret, line 1", "is not the header"],
        );
        assert!(!message.contains("root"), "{message}");
    }
    for arguments in [
        &["friction", "--data"][..],
        &["identify", "--config"],
        &["validate", "--result"],
        &["import", "--list"],
    ] {
        let message = refused(&[arguments, &[secret.to_str().unwrap()]].concat(), &["secret"]);
        assert!(!message.contains("root") && !message.contains("password"), "{message}");
    }
}

/// The same set, read from its folder through a file outside of it.
#[test]
fn limit_files_outside_are_read_where_that_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    fs::create_dir(&set).unwrap();
    fs::copy("measurements/tian/modes.csv", folder.path().join("modes.csv")).unwrap();
    fs::copy("measurements/tian/published.csv", set.join("published.csv")).unwrap();
    let manifest = fs::read_to_string("measurements/tian/manifest.toml")
        .unwrap()
        .replace("\"modes.csv\"", "\"../modes.csv\"");
    fs::write(set.join("manifest.toml"), manifest).unwrap();
    let read = |path: &str, outside| measurement::read_set_from(path, outside).map(|set| set.modes);
    assert!(read(set.to_str().unwrap(), false).is_err());
    assert_eq!(read(set.to_str().unwrap(), true).unwrap(), read("measurements/tian", false).unwrap());
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn refuse_pipes_and_devices_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [pipe.to_str().unwrap(), "/dev/zero"] {
            for arguments in [
                &["identify", "--config"][..],
                &["validate", "--result"],
                &["friction", "--data"],
                &["import", "--list"],
                &["simulate", "motion", "--config", "configs/emps.toml", "--reference"],
            ] {
                refused(&[arguments, &[path]].concat(), &["only regular files are read"]);
            }
        }
        for name in ["manifest.toml", "identification.json"] {
            let inside = folder.path().join(name);
            assert!(Command::new("mkfifo").arg(&inside).status().unwrap().success());
        }
        let path = folder.path().to_str().unwrap();
        refused(&["identify", "--measurements", path], &["manifest.toml", "is a pipe"]);
        refused(&["report", path], &["identification.json", "is a pipe"]);
    }

    /// Links and files of other names in the result folder are refused; what they point to keeps its content.
    #[test]
    fn refuse_links_that_lead_out_of_the_result_folder() {
        let folder = tempfile::tempdir().unwrap();
        let (out, victim, other) =
            (folder.path().join("out"), folder.path().join("victim"), folder.path().join("other"));
        fs::write(&victim, "kept").unwrap();
        fs::create_dir(&other).unwrap();
        let fresh = || {
            let _ = fs::remove_dir_all(&out);
            fs::create_dir(&out).unwrap();
        };
        let path = out.to_str().unwrap();
        fresh();
        symlink(&victim, out.join(".jointid-lock")).unwrap();
        refused(&["simulate", "modes", "--out", path], &[".jointid-lock", "link"]);
        fresh();
        fs::hard_link(&victim, out.join(".jointid-lock")).unwrap();
        refused(&["simulate", "modes", "--out", path], &[".jointid-lock", "second name"]);
        fresh();
        symlink(&victim, out.join("unfinished.jsonl")).unwrap();
        refused(&["identify", "--repeats", "1", "--out", path], &["unfinished.jsonl", "is a link"]);
        fresh();
        symlink(&other, out.join("measurements")).unwrap();
        refused(&["init", path], &["measurements", "is a link"]);
        fresh();
        symlink(&victim, out.join("modes.json")).unwrap();
        refused(&["simulate", "modes", "--out", path], &["modes.json", "is a link"]);
        fresh();
        symlink("nowhere", out.join("machine.toml")).unwrap();
        refused(&["init", path], &["machine.toml", "is a link"]);
        assert_eq!(fs::read_dir(&out).unwrap().count(), 1);
        assert_eq!(fs::read_to_string(&victim).unwrap(), "kept");
        assert_eq!(fs::read_dir(&other).unwrap().count(), 0);
    }

    #[test]
    fn a_full_or_closed_stderr_costs_no_result() {
        for end in ["2>/dev/full", "2>&-"] {
            for command in [
                "identify --repeats 1",
                "simulate modes --set point.rotor.inertia_kg_m2=42",
                "identify --repeats 1 --verbose",
            ] {
                let script = format!("\"$0\" {command} {end}");
                let output =
                    Command::new("sh").args(["-c", &script, env!("CARGO_BIN_EXE_jointid")]).output().unwrap();
                assert!(output.status.success() && !output.stdout.is_empty(), "{script}");
            }
        }
        let script = "\"$0\" identify --config nowhere.toml 2>/dev/full";
        let output = Command::new("sh").args(["-c", script, env!("CARGO_BIN_EXE_jointid")]).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
    }

    /// Sends SIGINT to a run after a time, and returns how long it then takes to end, with its output.
    fn interrupted(arguments: &[&str], after: Duration) -> (Duration, Output) {
        let child = jointid().args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(after);
        let begun = Instant::now();
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        (begun.elapsed(), output)
    }

    #[test]
    fn an_interrupt_ends_a_machine_with_implausible_numbers_soon() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out").display().to_string();
        let run = ["identify", "--set", "shaft.screw.length_m=350", "--out", &out];
        let (time, output) = interrupted(&run, Duration::from_secs(2));
        assert!(time < Duration::from_secs(2), "{time:?}");
        assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
        assert!(!Path::new(&out).join(".jointid-lock").exists());
    }

    /// Ctrl-C ends a command within a second, with or without a result, and leaves neither locks nor
    /// unfinished files.
    #[test]
    fn an_interrupt_ends_every_command_soon() {
        let folder = tempfile::tempdir().unwrap();
        let set = folder.path().join("long");
        fs::create_dir(&set).unwrap();
        let table: String =
            (1..1_500_000).map(|line| format!("{line},{}e-9,-1e-9\n", line % 7 + 1)).collect();
        fs::write(folder.path().join("long.csv"), format!("frequency_hz,real,imag\n{table}")).unwrap();
        let long = folder.path().join("long.csv").display().to_string();
        let hybrid = ["--config", "configs/hybrid-axis.toml"];
        let commands: [(&[&str], u64); 4] = [
            (&["diagnose", "--positions", "l1,l3,l5", "--no-cache"], 900),
            (&["simulate", "motion", hybrid[0], hybrid[1], "--reference", "sine", "--periods", "60"], 1500),
            (&["simulate", "bode", hybrid[0], hybrid[1]], 500),
            (&["import", &long, "--quantity", "receptance"], 150),
        ];
        for (at, (command, after)) in commands.into_iter().enumerate() {
            let out = folder.path().join(format!("out{at}"));
            let out = out.display().to_string();
            let (time, output) =
                interrupted(&[command, &["--out", &out]].concat(), Duration::from_millis(after));
            // The deadline of the command is 0.85 s; the rest is for a busy processor.
            assert!(time < Duration::from_secs(2), "{command:?}: {time:?}");
            assert!(
                [0, 3].contains(&output.status.code().unwrap()),
                "{command:?}: {:?} {}",
                output.status,
                stderr(&output)
            );
            let left = fs::read_dir(&out)
                .into_iter()
                .flatten()
                .map(|entry| entry.unwrap().file_name().into_string().unwrap());
            let left: Vec<String> = left.filter(|name| name.starts_with('.')).collect();
            assert!(left.is_empty(), "{command:?}: {left:?}");
        }
    }
}

/// Text from a file reaches terminal, messages, documents and page escaped.
#[test]
fn hidden_characters_are_escaped_everywhere() {
    let hidden = |text: &str| {
        text.chars().any(|c| c != '\n' && (c.is_control() || ('\u{202a}'..='\u{202e}').contains(&c)))
    };
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let evil = "\\u001B[31mred\\u202Efdp\\n";
    let machine =
        fs::read_to_string("configs/tian.toml").unwrap().replace("title = \"", &format!("title = \"{evil}"));
    let machine = machine.replace("\"table\"", "\"ta\\\"ble\\u202E\\u001B\"");
    fs::write(at("machine.toml"), machine).unwrap();
    fs::create_dir(at("set")).unwrap();
    let manifest = fs::read_to_string("measurements/tian/manifest.toml")
        .unwrap()
        .replace("\"table\"", "\"ta\\\"ble\\u202E\\u001B\"");
    fs::write(at("set/manifest.toml"), manifest.replace("\"l1\"", "\"l1, \\\"x\\\"\\u202E\"")).unwrap();
    let modes = fs::read_to_string("measurements/tian/modes.csv").unwrap();
    fs::write(at("set/modes.csv"), modes.replace("l1,", "\"l1, \"\"x\"\"\u{202e}\",")).unwrap();
    fs::copy("measurements/tian/published.csv", at("set/published.csv")).unwrap();
    let (config, set, out) = (at("machine.toml"), at("set"), at("out"));
    let sources = ["--config", &config, "--measurements", &set];
    let shown = |arguments: &[&str]| {
        let output = run(&[arguments, &sources].concat());
        let text = String::from_utf8(output.stdout.clone()).unwrap() + &stderr(&output);
        assert!(!hidden(&text) && !text.contains("panicked"), "{text}");
        text
    };
    shown(&["identify", "--repeats", "1", "--out", &out]);
    shown(&["identify", "--repeats", "1", "--json"]);
    shown(&["simulate", "modes", "--json"]);
    let csv = shown(&["simulate", "frf", "--to-hz", "2"]);
    assert!(csv.contains("\"l1, \"\"x\"\"\\u{202e}\",1,"), "{csv}");
    let message = shown(&["identify", "--positions", "a\u{1b}[1m\nb"]);
    assert_eq!(message.trim().lines().count(), 1, "{message}");
    assert!(run(&["report", &out]).status.success());
    let document = fs::read_to_string(format!("{out}/identification.json")).unwrap();
    assert!(
        !hidden(&document)
            && serde_json::from_str::<Value>(&document).unwrap()["machine"]["text"]
                .as_str()
                .unwrap()
                .contains("\\u202E")
    );
    let page = fs::read_to_string(format!("{out}/report.html")).unwrap();
    assert!(!page.contains('\u{202e}') && !page.contains('\u{1b}') && !page.contains("&quot;x"));
}

/// The work of a description grows at most linearly up to its limits; beyond them it is refused.
#[test]
fn limit_descriptions_up_to_the_limits_are_computed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("chain.toml");
    let chain = |count: usize| {
        let points = (0..count)
            .map(|at| format!("[[point]]\nname = \"p{at}\"\nmotion = \"translation\"\nmass_kg = 1.0\n"));
        let joints = (1..count).map(|at| {
            let before = at - 1;
            format!("[[joint]]\nname = \"j{at}\"\nbetween = [\"p{before}\", \"p{at}\"]\nstiffness = 1e7\n")
        });
        format!("title = \"chain\"\n{}", points.chain(joints).collect::<String>())
    };
    for (count, accepted) in [(200, true), (201, false), (5000, false)] {
        fs::write(&path, chain(count)).unwrap();
        let output = run(&["simulate", "modes", "--config", path.to_str().unwrap()]);
        assert_eq!(output.status.success(), accepted, "{count}: {}", stderr(&output));
        assert_eq!(stderr(&output).contains("at most 200"), !accepted);
    }
}
