//! `jointid plan`: ranks choices of measurements by the remaining uncertainty of the parameters.

use std::path::PathBuf;

use crate::arguments::{OutputArguments, RodArguments, Sources};
use crate::identified::{check_identification, identified_values, read_identification};
use crate::outcome::{CommandResult, deliver, prepare, to_message};
use crate::sources::{Loaded, load, load_with_result, stamp};
use identification::objective::{FrfSettings, ModeSettings};
use identification::{Choice, FrfPlan, PlanDesign};
use machine::ParameterValues;
use report::document::{ChoiceRow, PlanDocument, PlanRanking};
use report::plan_table;

/// Kinds of data, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum DataName {
    /// Natural frequencies and amplitudes
    Modes,
    /// Whole FRFs
    Frf,
}

/// Arguments of `plan`.
#[derive(Debug, clap::Args)]
pub struct PlanArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Machine, set and parameter values from this identification.json; --config and --measurements replace its own
    #[arg(long, value_name = "FILE")]
    pub result: Option<PathBuf>,
    /// Kind of data to measure; by default frf where the set has FRFs, else modes
    #[arg(long, value_enum)]
    pub data: Option<DataName>,
    /// Numbers of measurements to choose, comma-separated; by default 2,3, or 1 with --measured
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = clap::value_parser!(u8).range(1..=8))]
    pub choose: Vec<u8>,
    /// Measurements already made, comma-separated: positions, or position:response/excitation
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub measured: Vec<String>,
    /// Channels to choose from, response/excitation, comma-separated; that of the set by default
    #[arg(long, value_name = "POINT/POINT", value_delimiter = ',')]
    pub channels: Vec<String>,
    /// Relative standard deviation of an FRF line
    #[arg(long, value_name = "SHARE", default_value_t = 0.02)]
    pub noise: f64,
    /// Lowest and highest frequency (Hz), comma-separated
    #[arg(long, value_name = "FROM,TO", value_delimiter = ',', num_args = 1)]
    pub band: Vec<f64>,
    /// Number of lines of an FRF
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = clap::value_parser!(u16).range(2..))]
    pub lines: u16,
    /// Parameters to keep at their values, comma-separated
    #[arg(long, value_name = "PARAMETERS", value_delimiter = ',')]
    pub freeze: Vec<String>,
    #[command(flatten)]
    pub rods: RodArguments,
    /// Number of choices to show of each ranking
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub top: u16,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Largest number of choices, which are ranked exhaustively.
const MOST_CHOICES: f64 = 200_000.0;

/// Runs the command.
pub fn run(given: &PlanArguments) -> CommandResult {
    let result = given.result.as_ref().map(|path| Ok::<_, String>((path, read_identification(path)?))).transpose()?;
    let loaded = match &result {
        Some((path, (identified, _))) => {
            check_identification(path, identified)?;
            load_with_result(&given.sources, identified)?
        }
        None => load(&given.sources)?,
    };
    let machine = &loaded.config.machine;
    let mut values = machine.start();
    let mut inputs = Vec::new();
    if let Some((path, (identified, input))) = result {
        inputs.push(input);
        values = identified_values(path, &identified, &loaded.config)?;
    }
    let frfs = given.data.map_or(!loaded.set.frfs.is_empty(), |d| d == DataName::Frf);
    let channels = channels(given, &loaded)?;
    let design = if frfs { of_frfs(given, &loaded, &values, &channels)? } else { of_modes(given, &loaded, &values, &channels)? };
    if design.free.is_empty() {
        return Err("no free parameter to plan for; freeze fewer".into());
    }
    let name = |candidate: usize| {
        let c = &design.candidates[candidate];
        let channel = format!("{}/{}", c.channel.0, c.channel.1);
        match c.position.map(|p| &loaded.set.positions[p].name) {
            Some(position) if channels.len() > 1 => format!("{position}:{channel}"),
            Some(position) => position.clone(),
            None => channel,
        }
    };
    let made = measured(given, &loaded, &design, &name)?;
    let counts: Vec<u8> = match (&given.choose[..], made.is_empty()) {
        ([], true) => [2, 3].into_iter().filter(|n| usize::from(*n) <= design.candidates.len()).collect(),
        ([], false) => vec![1],
        (chosen, _) => chosen.to_vec(),
    };
    let counts = if counts.is_empty() { vec![1] } else { counts };
    let ids: Vec<String> = design.free.iter().map(|i| machine.parameters[*i].id.clone()).collect();
    let row = |choice: &Choice| ChoiceRow {
        measure: choice.candidates.iter().map(|i| name(*i)).collect(),
        score: choice.score,
        determined: ids.iter().enumerate().filter(|(c, _)| choice.determines(*c)).map(|(_, id)| id.clone()).collect(),
        half_width95: ids
            .iter()
            .enumerate()
            .map(|(column, id)| {
                let parameter = &machine.parameters[design.free[column]];
                (id.clone(), 1.96 * choice.sd[column] * parameter.unit_slope(values[design.free[column]]))
            })
            .collect(),
    };
    let mut rankings = Vec::new();
    for &count in &counts {
        let count = usize::from(count);
        let number = design.choices(made.len(), count);
        if number < 1.0 {
            return Err(format!(
                "--choose {count}: only {} measurements to choose from; choose fewer",
                design.candidates.len() - made.len()
            ));
        }
        if number > MOST_CHOICES {
            return Err(format!(
                "--choose {count}: {number:.0} choices are too many to rank; choose fewer at once, and name those made with --measured"
            ));
        }
        let ranked = design.ranking(&made, count);
        // Rank of the set's own split.
        let split: Option<Vec<usize>> = loaded.set.split.as_ref().filter(|_| made.is_empty() && channels.len() == 1).map(|names| {
            let mut which: Vec<usize> = (0..design.candidates.len()).filter(|i| names.contains(&name(*i))).collect();
            which.sort_unstable();
            which
        });
        let split_rank = split.and_then(|split| ranked.iter().position(|c| c.candidates == split)).map(|at| at + 1);
        rankings.push(PlanRanking { count, split_rank, choices: ranked.iter().map(row).collect() });
    }
    let mut stamped = stamp("plan", 0, true, &loaded, Vec::new());
    stamped.inputs.extend(inputs);
    let document = PlanDocument {
        stamp: stamped,
        data: if frfs { "frf" } else { "modes" }.into(),
        measured: made.iter().map(|i| name(*i)).collect(),
        parameters: ids,
        rankings,
    };
    let folder = prepare(&given.output)?;
    let units = |id: &str| machine.parameter(id).map_or(1.0, |i| values[i].abs());
    deliver(&given.output, folder.as_ref(), "plan.json", &document, &plan_table(&document, &units, usize::from(given.top)))
}

/// Returns the pairs of response and excitation to choose from.
fn channels(given: &PlanArguments, loaded: &Loaded) -> Result<Vec<(String, String)>, String> {
    if given.channels.is_empty() {
        let point = |name: &Option<String>, key: &str| {
            name.clone()
                .or_else(|| loaded.set.frfs.first().map(|f| if key == "response" { f.response.clone() } else { f.excitation.clone() }))
        };
        let (response, excitation) = (point(&loaded.set.response, "response"), point(&loaded.set.excitation, "excitation"));
        return match (response, excitation) {
            (Some(response), Some(excitation)) => Ok(vec![(response, excitation)]),
            _ => Err(format!("{}: names no response and excitation; give --channels table/table", loaded.set.path)),
        };
    }
    let pair = |text: &String| match text.split_once('/') {
        Some((a, b)) if !a.is_empty() && !b.is_empty() => Ok((a.to_string(), b.to_string())),
        _ => Err(format!("--channels {text}: write RESPONSE/EXCITATION, two points of the machine")),
    };
    given.channels.iter().map(pair).collect()
}

fn of_frfs(given: &PlanArguments, loaded: &Loaded, values: &ParameterValues, channels: &[(String, String)]) -> Result<PlanDesign, String> {
    let (from, to) = band(given, (5.0, 1000.0))?;
    if !(given.noise > 0.0 && given.noise < 1.0) {
        return Err(format!("--noise {}: write a share above 0 and below 1, such as 0.02", given.noise));
    }
    let plan = FrfPlan { noise: given.noise, band_hz: (from, to), lines: usize::from(given.lines) };
    let settings = FrfSettings { rods: given.rods.represent(), ..FrfSettings::default() };
    PlanDesign::of_frfs(&loaded.config.machine, values, &loaded.set, channels, plan, settings, &given.freeze).map_err(to_message)
}

fn of_modes(given: &PlanArguments, loaded: &Loaded, values: &ParameterValues, channels: &[(String, String)]) -> Result<PlanDesign, String> {
    if loaded.set.positions.is_empty() {
        return Err(format!("{}: has no positions to take modes at; plan FRFs with --data frf", loaded.set.path));
    }
    let [channel] = channels else {
        return Err("--channels: modes are planned for one pair of points; name one, or --data frf".into());
    };
    let measured = loaded.set.modes.iter().flat_map(|m| m.positions.iter().flatten()).filter_map(|m| m.frequency_hz);
    let (low, high) = measured.fold((f64::INFINITY, 0.0_f64), |(a, b), f| (a.min(f), b.max(f)));
    let default_hz = if high > 0.0 { (0.5 * low, 1.1 * high) } else { (5.0, 1000.0) };
    let settings = ModeSettings { rods: given.rods.represent(), ..ModeSettings::default() };
    let band_hz = band(given, default_hz)?;
    PlanDesign::of_modes(&loaded.config.machine, values, &loaded.set, channel, band_hz, settings, &given.freeze).map_err(to_message)
}

fn band(given: &PlanArguments, default_hz: (f64, f64)) -> Result<(f64, f64), String> {
    match given.band[..] {
        [] => Ok(default_hz),
        [from, to] if from > 0.0 && to > from && to.is_finite() => Ok((from, to)),
        _ => Err("--band: write the lowest and the highest frequency in Hz, such as --band 5,1000".into()),
    }
}

/// Returns the candidates that are already measured.
fn measured(given: &PlanArguments, loaded: &Loaded, design: &PlanDesign, name: &dyn Fn(usize) -> String) -> Result<Vec<usize>, String> {
    let mut made = Vec::new();
    for wanted in &given.measured {
        let of_position = |i: &usize| design.candidates[*i].position.is_some_and(|p| loaded.set.positions[p].name == *wanted);
        let found: Vec<usize> = (0..design.candidates.len()).filter(|i| name(*i) == *wanted || of_position(i)).collect();
        if found.is_empty() {
            let known: Vec<String> = (0..design.candidates.len()).map(name).collect();
            return Err(format!("--measured {wanted}: there is no such measurement; there are {}", known.join(", ")));
        }
        made.extend(found);
    }
    made.sort_unstable();
    made.dedup();
    Ok(made)
}
