//! Simulated test of a subject: the published case and the curves for the label.

use super::channel_set::{ChannelSet, Quantity};
use super::choice::Choice;
use super::fault::DataFault;
#[cfg(test)]
use super::label::Exact;
use super::label::{HammerTest, Label};
use super::measure::{TestRig, as_quantity};
use super::plan::{Kind, Slot};
use super::record::{Case, Position, Record};
use crate::Result;
use crate::draw::Draw;
use crate::machine::point::Point;

/// Simulates the test and returns the case, for look-alikes with a follow-up of more channels. Adds the
/// test's properties to the label.
pub(super) fn simulated_test(
    slot: &Slot,
    choice: &Choice,
    label: &mut Label,
    draw: &mut Draw,
) -> Result<Case> {
    let misread = choice.subject.misread_power();
    let offered = match misread {
        power if power > 0.0 => &Quantity::ALL[..2],
        power if power < 0.0 => &Quantity::ALL[1..],
        _ => &Quantity::ALL[..],
    };
    let quantity = offered[draw.index(offered.len())];
    let test =
        TestRig::new(&choice.subject, &choice.setting, &choice.channels, &choice.levels, choice.spacing)?;
    label.hammer = Some(HammerTest {
        rotor_held: choice.subject.drawn.description.holds_rotor,
        bench: choice.is_bench,
        channels: choice.channels.len(),
        positions: choice.subject.drawn.nut_m.len(),
        block_s: test.block_s(),
        estimator_bias: test.bias,
        high_pass_hz: choice.subject.nuisance.sensor.map(|sensor| sensor.corner_hz),
    });
    #[cfg(test)]
    label.exact.extend(curves(choice, &test, quantity));
    let data_fault = (slot.kind == Kind::HardNullBadChannel)
        .then(|| DataFault::random(test.stations.len(), test.channels.len(), choice.setting.band_hz, draw));
    let records = simulated_records(choice, &test, quantity, data_fault, &draw.branch(1), label)?;
    let positions = Position::all(&choice.subject.drawn.nut_m);
    let mut case = Case {
        name: label.case.clone(),
        description: choice.subject.drawn.description.clone(),
        fit: choice
            .given
            .iter()
            .filter(|_| choice.given.len() < positions.len())
            .map(|at| Position::name_of(*at))
            .collect(),
        positions,
        scatter: choice.scatter,
        quantity,
        averages: choice.setting.averages,
        records,
        freeze: Vec::new(),
        follow_up: None,
    };
    if slot.kind == Kind::LookAlike {
        let test = TestRig::new(
            &choice.subject,
            &choice.setting,
            &ChannelSet::Axial.channels(),
            &choice.levels,
            choice.spacing,
        )?;
        let records = simulated_records(choice, &test, quantity, None, &draw.branch(2), label)?;
        case.follow_up =
            Some(Box::new(Case { name: format!("{}-more", case.name), records, ..case.clone() }));
    }
    Ok(case)
}

/// Simulates the records of a test in the quantity of the manifest.
fn simulated_records(
    choice: &Choice,
    test: &TestRig,
    quantity: Quantity,
    data_fault: Option<DataFault>,
    draw: &Draw,
    label: &mut Label,
) -> Result<Vec<Record>> {
    let mut lines = test.records(data_fault, draw);
    if let Some(data_fault) = data_fault {
        data_fault.exchange(&mut lines);
        data_fault.check_visible(&test.exact, &lines)?;
        label.fault = Some(data_fault.name().to_owned());
    }
    let misread = choice.subject.misread_power();
    let several = choice.levels.len() > 1;
    let mut records = Vec::new();
    for (station, of_station) in lines.iter().enumerate() {
        let (position, level) = test.stations[station];
        for (channel, lines) in of_station.iter().enumerate() {
            let record = Record {
                position: Position::name_of(position),
                channel: test.channels[channel],
                name: several.then(|| format!("level{}", station % choice.levels.len() + 1)),
                // A blow on the rotor is a torque, so the level has no force value.
                force_n: (several && test.channels[channel].excitation == Point::Table)
                    .then_some(choice.force_n * level),
                lines: as_quantity(lines, quantity, misread),
            };
            if data_fault.is_some_and(|data_fault| data_fault.affects(station, channel)) {
                label.faulty_records.push(record.file());
            }
            records.push(record);
        }
    }
    Ok(records)
}

/// Computes the noise-free curves of the first measurement.
#[cfg(test)]
fn curves(choice: &Choice, test: &TestRig, quantity: Quantity) -> Vec<Exact> {
    let mut out = Vec::new();
    for (&(position, _), values) in test.stations.iter().zip(&test.exact) {
        for (&channel, values) in test.channels.iter().zip(values) {
            let factor =
                |hz: f64| super::measure::from_accelerance(hz, quantity, choice.subject.misread_power());
            let with = values.iter().zip(&test.lines_hz).map(|(value, &hz)| value * factor(hz)).collect();
            out.push(Exact { position: Position::name_of(position), channel, with });
        }
    }
    out
}
