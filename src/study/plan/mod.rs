//! Plan of measurements: ranks choices of positions, channels and operating states by what they decide.

mod prediction;
mod verdict;

use std::ops::RangeInclusive;
use std::path::Path;

use crate::modal_density::mode_frequencies_hz;
use crate::settings::checked_band;
use crate::{Study, StudyError, StudyResult};
use identification::objective::{FrfSettings, ModeSettings};
use identification::{Choice, FrfPlan, PlanDesign, PlannedMeasurement};
use machine::{ParameterValues, State};
use numeric::statistics::extremes;
use report::diagnosis::DiagnosisDocument;
use report::document::{ChoiceRow, IdentificationDocument, Input, PlanDocument, PlanRanking};
use report::vocabulary::DataKind;

/// Kinds of data to plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PlannedData {
    /// Natural frequencies and amplitudes.
    Modes,
    /// Whole FRFs.
    Frf,
}

/// What a plan chooses from.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanRequest {
    /// Identification whose values count instead of the start values, with its file where it has one.
    pub identified: Option<(IdentificationDocument, Option<Input>)>,
    /// Kind of data to measure; by default FRFs where the set has some, else modes.
    pub data: Option<PlannedData>,
    /// Numbers of measurements to choose; by default 2 and 3, or 1 where some are made already.
    pub choose: Vec<usize>,
    /// Measurements already made: positions, or `position:response/excitation`.
    pub measured: Vec<String>,
    /// Channels to choose from, as `response/excitation`; that of the set by default.
    pub channels: Vec<String>,
    /// Operating states to choose from: `as-is`, `servo-off`, `mass=KG` and `level=N`; `as-is` alone where
    /// empty.
    pub states: Vec<String>,
    /// Nut positions (m) whose predicted natural frequencies decide the ranking; empty: the parameters
    /// decide.
    pub predict_at_m: Vec<f64>,
    /// Ambiguous diagnosis, with its file where it has one: the probability that a choice settles it decides
    /// the ranking.
    pub diagnosis: Option<(DiagnosisDocument, Option<Input>)>,
    /// Relative standard deviation of an FRF line (1).
    pub noise: f64,
    /// Lowest and highest frequency (Hz).
    pub band_hz: Option<(f64, f64)>,
    /// Number of lines of an FRF.
    pub lines: usize,
}

impl Default for PlanRequest {
    fn default() -> Self {
        PlanRequest {
            identified: None,
            data: None,
            choose: Vec::new(),
            measured: Vec::new(),
            channels: Vec::new(),
            states: Vec::new(),
            predict_at_m: Vec::new(),
            diagnosis: None,
            noise: 0.02,
            band_hz: None,
            lines: 400,
        }
    }
}

impl PlanRequest {
    fn check(&self) -> StudyResult<()> {
        if let Some(count) = self.choose.iter().find(|count| !CHOSEN.contains(count)) {
            let fault = format!("write numbers from {} to {}", CHOSEN.start(), CHOSEN.end());
            return Err(StudyError::setting("choose", count, fault));
        }
        if self.lines < 2 {
            return Err(StudyError::setting("lines", self.lines, "an FRF has two lines or more"));
        }
        Ok(())
    }
}

/// Numbers of measurements to choose at once.
const CHOSEN: RangeInclusive<usize> = 1..=8;
/// Largest number of choices, which are ranked exhaustively.
const MOST_CHOICES: f64 = 200_000.0;

/// Points of a channel: response and excitation.
type ChannelNames = (String, String);

impl Study {
    /// Ranks choices of two and of three positions by the intervals that their measurement would leave.
    ///
    /// # Errors  as [`Study::plan_with`].
    pub fn plan(&self) -> StudyResult<PlanDocument> {
        self.plan_with(&PlanRequest::default())
    }

    /// Ranks choices of measurements by what they decide: intervals of the parameters or of predictions, or
    /// the verdict of a diagnosis.
    ///
    /// # Errors  a setting is outside its range; a measurement, channel or parameter is unknown; no parameter
    ///   is free; there are too many choices.
    pub fn plan_with(&self, request: &PlanRequest) -> StudyResult<PlanDocument> {
        self.check_responses("a plan")?;
        request.check()?;
        let machine = &self.config.machine;
        let mut values = machine.start();
        let mut inputs = Vec::new();
        if let Some((identified, file)) = &request.identified {
            let name = file.as_ref().map_or("the identification", |file| &file.path);
            values = self.identified_values(Path::new(name), identified)?;
            inputs.extend(file.clone());
        }
        self.check_measured_band()?;
        let frfs = request.data.map_or(!self.set.frfs.is_empty(), |d| d == PlannedData::Frf);
        let channels = self.channels(request)?;
        let states = states(request)?;
        let mut design = if frfs {
            self.design_of_frfs(request, &values, (&channels, &states))?
        } else {
            self.design_of_modes(request, &values, &channels)?
        };
        if design.free.is_empty() {
            return Err(StudyError::impossible("no free parameter to plan for; freeze fewer"));
        }
        design.predicted = self.predicted_frequencies(request, &values, &design.free, &channels[0])?;
        let discrimination = self.discrimination(request, (&channels, &states), frfs)?;
        inputs.extend(request.diagnosis.as_ref().and_then(|(_, file)| file.clone()));
        let name = |at: usize| self.measurement_name(&design.candidates[at], channels.len());
        let made = self.made(request, &design, &name)?;
        let counts: Vec<usize> = match (&request.choose[..], made.is_empty()) {
            ([], true) => [2, 3].into_iter().filter(|n| *n <= design.candidates.len()).collect(),
            ([], false) => vec![1],
            (chosen, _) => chosen.to_vec(),
        };
        let counts = if counts.is_empty() { vec![1] } else { counts };
        let ids: Vec<String> = design.free.iter().map(|i| machine.parameters[*i].id.clone()).collect();
        let half_width = |choice: &Choice, column: usize| {
            let at = design.free[column];
            1.96 * choice.sd[column] * machine.parameters[at].unit_slope(values[at])
        };
        let row = |(choice, settled): &(Choice, Option<f64>)| ChoiceRow {
            measure: choice.candidates.iter().map(|i| name(*i)).collect(),
            prediction95: choice.prediction_sd.map(|sd| 1.96 * sd),
            settled: *settled,
            score: choice.score,
            determined: ids
                .iter()
                .enumerate()
                .filter(|(c, _)| design.is_identifiable(choice, *c))
                .map(|(_, id)| id.clone())
                .collect(),
            half_width95: ids
                .iter()
                .enumerate()
                .map(|(column, id)| (id.clone(), half_width(choice, column)))
                .collect(),
        };
        let mut rankings = Vec::new();
        for &count in &counts {
            check_count(count, &design, made.len())?;
            let with_settled = |choice: Choice| {
                let all: Vec<usize> = made.iter().chain(&choice.candidates).copied().collect();
                let settled = discrimination.as_ref().map(|(found, _)| found.settled(&all));
                (choice, settled)
            };
            let mut ranked: Vec<(Choice, Option<f64>)> =
                design.ranking(&made, count).into_iter().map(with_settled).collect();
            // Choices that settle the verdict alike keep the order of their intervals.
            ranked.sort_by(|(_, a), (_, b)| b.unwrap_or(0.0).total_cmp(&a.unwrap_or(0.0)));
            // Rank of the set's own split.
            let split: Option<Vec<usize>> =
                self.set.split.as_ref().filter(|_| made.is_empty() && channels.len() == 1).map(|names| {
                    let mut which: Vec<usize> =
                        (0..design.candidates.len()).filter(|i| names.contains(&name(*i))).collect();
                    which.sort_unstable();
                    which
                });
            let split_rank = split
                .and_then(|split| ranked.iter().position(|(c, _)| c.candidates == split))
                .map(|at| at + 1);
            rankings.push(PlanRanking { count, split_rank, choices: ranked.iter().map(row).collect() });
        }
        let other = request.identified.iter().filter(|(identified, _)| !self.is_machine_of(identified));
        let warning = |_| {
            "the values are those of another machine: text, overrides or removed effects of its description differ".to_string()
        };
        let mut stamp = self.stamp("plan", 0, true, other.map(warning).collect());
        stamp.inputs.extend(inputs);
        Ok(PlanDocument {
            stamp,
            data: if frfs { DataKind::Frf } else { DataKind::Modes },
            measured: made.iter().map(|i| name(*i)).collect(),
            parameters: ids,
            predict_at_m: request.predict_at_m.clone(),
            rivals: discrimination.map(|(_, names)| names).unwrap_or_default(),
            rankings,
        })
    }

    /// Names a measurement by its position, by its channel among several, and by its state.
    fn measurement_name(&self, candidate: &PlannedMeasurement, channels: usize) -> String {
        let channel = format!("{}/{}", candidate.channel.0, candidate.channel.1);
        let measurement = match candidate.position.map(|p| &self.set.positions[p].name) {
            Some(position) if channels > 1 => format!("{position}:{channel}"),
            Some(position) => position.clone(),
            None => channel,
        };
        if candidate.state == State::Described {
            measurement
        } else {
            format!("{measurement}@{}", candidate.state.name())
        }
    }

    /// Returns the pairs of response and excitation to choose from.
    fn channels(&self, request: &PlanRequest) -> StudyResult<Vec<ChannelNames>> {
        let set = &self.set;
        if request.channels.is_empty() {
            let point = |name: &Option<String>, key: &str| {
                let of_first = || {
                    set.frfs
                        .first()
                        .map(|f| if key == "response" { f.response.clone() } else { f.excitation.clone() })
                };
                name.clone().or_else(of_first)
            };
            return match (point(&set.response, "response"), point(&set.excitation, "excitation")) {
                (Some(response), Some(excitation)) => Ok(vec![(response, excitation)]),
                _ => Err(StudyError::input(
                    &set.path,
                    "names no response and excitation; name channels, such as table/table",
                )),
            };
        }
        let pair = |text: &String| match text.split_once('/') {
            Some((a, b)) if !a.is_empty() && !b.is_empty() => Ok((a.to_string(), b.to_string())),
            _ => Err(StudyError::setting(
                "channels",
                text,
                "write RESPONSE/EXCITATION, two points of the machine",
            )),
        };
        request.channels.iter().map(pair).collect()
    }

    fn design_of_frfs(
        &self,
        request: &PlanRequest,
        values: &ParameterValues,
        among: (&[ChannelNames], &[State]),
    ) -> StudyResult<PlanDesign> {
        let (plan, settings) = self.planned_frf(request)?;
        Ok(PlanDesign::of_frfs(
            &self.config.machine,
            values,
            &self.set,
            among,
            plan,
            settings,
            &self.settings.freeze,
        )?)
    }

    /// Returns noise and lines of a planned FRF, and the settings of its objective.
    fn planned_frf(&self, request: &PlanRequest) -> StudyResult<(FrfPlan, FrfSettings)> {
        let band_hz = request.band_hz.map_or(Ok((5.0, 1000.0)), checked_band)?;
        if !(request.noise > 0.0 && request.noise < 1.0) {
            return Err(StudyError::setting(
                "noise",
                request.noise,
                "write a share above 0 and below 1, such as 0.02",
            ));
        }
        let plan = FrfPlan { noise: request.noise, band_hz, lines: request.lines };
        Ok((plan, FrfSettings { rods: self.settings.rods, ..FrfSettings::default() }))
    }

    fn design_of_modes(
        &self,
        request: &PlanRequest,
        values: &ParameterValues,
        channels: &[ChannelNames],
    ) -> StudyResult<PlanDesign> {
        let set = &self.set;
        if !request.states.is_empty() {
            return Err(StudyError::setting(
                "states",
                "",
                "operating states are planned for FRFs (data frf)",
            ));
        }
        if set.positions.is_empty() {
            return Err(StudyError::input(
                &set.path,
                "has no positions to take modes at; plan FRFs (data frf)",
            ));
        }
        let [channel] = channels else {
            return Err(StudyError::setting(
                "channels",
                "",
                "modes are planned for one pair of points; name one, or plan FRFs (data frf)",
            ));
        };
        let (low, high) = extremes(&mode_frequencies_hz(set));
        let default_hz = if high > 0.0 { (0.5 * low, 1.1 * high) } else { (5.0, 1000.0) };
        let settings = ModeSettings { rods: self.settings.rods, ..ModeSettings::default() };
        let band_hz = request.band_hz.map_or(Ok(default_hz), checked_band)?;
        Ok(PlanDesign::of_modes(
            &self.config.machine,
            values,
            set,
            channel,
            band_hz,
            settings,
            &self.settings.freeze,
        )?)
    }

    /// Returns the candidates that are already measured.
    fn made(
        &self,
        request: &PlanRequest,
        design: &PlanDesign,
        name: &dyn Fn(usize) -> String,
    ) -> StudyResult<Vec<usize>> {
        let mut made = Vec::new();
        for wanted in &request.measured {
            let of_position = |i: &usize| {
                let candidate = &design.candidates[*i];
                candidate.state == State::Described
                    && candidate.position.is_some_and(|p| self.set.positions[p].name == *wanted)
            };
            let found: Vec<usize> =
                (0..design.candidates.len()).filter(|i| name(*i) == *wanted || of_position(i)).collect();
            if found.is_empty() {
                let known: Vec<String> = (0..design.candidates.len()).map(name).collect();
                let fault = format!("there is no such measurement; there are {}", known.join(", "));
                return Err(StudyError::setting("measured", wanted, fault));
            }
            made.extend(found);
        }
        made.sort_unstable();
        made.dedup();
        Ok(made)
    }
}

/// Checks that there are enough measurements to choose from, and not too many choices.
fn check_count(count: usize, design: &PlanDesign, made: usize) -> StudyResult<()> {
    let number = design.choices(made, count);
    if number < 1.0 {
        let fault =
            format!("only {} measurements to choose from; choose fewer", design.candidates.len() - made);
        return Err(StudyError::setting("choose", count, fault));
    }
    if number > MOST_CHOICES {
        let fault = format!(
            "{number:.0} choices are too many to rank; choose fewer at once, and name those made already as measured"
        );
        return Err(StudyError::setting("choose", count, fault));
    }
    Ok(())
}

/// Returns the operating states to choose from.
fn states(request: &PlanRequest) -> StudyResult<Vec<State>> {
    let mut states = Vec::new();
    for text in &request.states {
        let fault = |fault: &str| StudyError::setting("states", text, fault);
        let state = State::named(text)
            .ok_or_else(|| fault("write as-is, servo-off, mass=KG or level=N, such as mass=20"))?;
        if states.contains(&state) {
            return Err(fault("is named twice; write each state once"));
        }
        states.push(state);
    }
    Ok(if states.is_empty() { vec![State::Described] } else { states })
}
