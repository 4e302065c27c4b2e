//! A subject is struck, and what comes out is written down: the case for the reader, the curves for the label.

use num_complex::Complex64;

use super::choice::Choice;
use super::fault::Trouble;
use super::label::{Exact, HammerTest, Label};
use super::layout::{Layout, Quantity};
use super::measure::{Bench, as_quantity, from_accelerance, on_lines};
use super::plan::{Kind, Slot};
use super::record::{Case, Position, Record};
use super::subject::axis;
use crate::TruthError;
use crate::draw::Draw;
use crate::machine::point::Point;

/// Strikes the subject: the case, with a follow-up of more channels for look-alikes. Fills in what the label says of the test.
pub(super) fn measured(slot: &Slot, choice: &Choice, label: &mut Label, draw: &mut Draw) -> Result<Case, TruthError> {
    let misread = choice.subject.misread_power();
    let offered = match misread {
        power if power > 0.0 => &Quantity::ALL[..2],
        power if power < 0.0 => &Quantity::ALL[1..],
        _ => &Quantity::ALL[..],
    };
    let quantity = offered[draw.index(offered.len())];
    let test = Bench::new(&choice.subject, &choice.setting, &choice.layout.channels(), &choice.levels, choice.spacing)?;
    label.hammer = Some(HammerTest {
        rotor_held: choice.subject.drawn.description.holds_rotor(),
        bench: choice.is_bench,
        layout: choice.layout,
        block_s: test.block_s(),
        estimator_bias: test.bias,
    });
    label.exact = curves(choice, &test, quantity)?;
    let trouble = (slot.kind == Kind::HardNullBadChannel)
        .then(|| Trouble::drawn(test.stations.len(), test.channels.len(), choice.setting.band_hz, draw));
    let records = struck(choice, &test, quantity, trouble, &draw.branch(1), label)?;
    let mut case = Case {
        name: label.case.clone(),
        description: choice.subject.drawn.description.clone(),
        positions: positions(choice),
        fit: ["l1", "l3", "l5"].map(str::to_owned).to_vec(),
        layout: choice.layout,
        quantity,
        averages: choice.setting.averages,
        records,
        freeze: Vec::new(),
        follow_up: None,
    };
    if slot.kind == Kind::LookAlike {
        let test = Bench::new(&choice.subject, &choice.setting, &Layout::Axial.channels(), &choice.levels, choice.spacing)?;
        let records = struck(choice, &test, quantity, None, &draw.branch(2), label)?;
        case.follow_up = Some(Box::new(Case { name: format!("{}-more", case.name), layout: Layout::Axial, records, ..case.clone() }));
    }
    Ok(case)
}

/// Name of a position by its number.
fn position_name(position: usize) -> String {
    format!("l{}", position + 1)
}

fn positions(choice: &Choice) -> Vec<Position> {
    choice.subject.drawn.nut_m.iter().enumerate().map(|(position, &nut_m)| Position { name: position_name(position), nut_m }).collect()
}

/// The records of a test in the quantity of the manifest.
fn struck(
    choice: &Choice,
    test: &Bench,
    quantity: Quantity,
    trouble: Option<Trouble>,
    draw: &Draw,
    label: &mut Label,
) -> Result<Vec<Record>, TruthError> {
    let mut lines = test.records(trouble, draw);
    if let Some(trouble) = trouble {
        trouble.exchange(&mut lines);
        trouble.shows(&test.exact, &lines)?;
        label.fault = Some(trouble.name().to_owned());
    }
    let misread = choice.subject.misread_power();
    let several = choice.levels.len() > 1;
    let mut records = Vec::new();
    for (station, of_station) in lines.iter().enumerate() {
        let (position, level) = test.stations[station];
        for (channel, lines) in of_station.iter().enumerate() {
            let record = Record {
                position: position_name(position),
                channel: test.channels[channel],
                name: several.then(|| format!("level{}", station % choice.levels.len() + 1)),
                // A blow on the rotor is a torque; its level has no force to be stated.
                force_n: (several && test.channels[channel].excitation == Point::Table).then_some(choice.force_n * level),
                lines: as_quantity(lines, quantity, misread),
            };
            if trouble.is_some_and(|trouble| trouble.concerns(station, channel)) {
                label.faulty_records.push(record.file());
            }
            records.push(record);
        }
    }
    Ok(records)
}

/// Noise-free curves of the first measurement, with the effects and without.
fn curves(choice: &Choice, test: &Bench, quantity: Quantity) -> Result<Vec<Exact>, TruthError> {
    let clean = on_lines(&choice.subject.without_effects(), &test.channels, &test.stations, &axis(&test.lines_hz))?;
    let turned = |values: &[Complex64], misread: f64| -> Vec<Complex64> {
        values.iter().zip(&test.lines_hz).map(|(value, &hz)| value * from_accelerance(hz, quantity, misread)).collect()
    };
    let mut out = Vec::new();
    for (station, &(position, level)) in test.stations.iter().enumerate() {
        for (channel, &name) in test.channels.iter().enumerate() {
            out.push(Exact {
                position: position_name(position),
                channel: name,
                level,
                frequency_hz: test.lines_hz.clone(),
                with: turned(&test.exact[station][channel], choice.subject.misread_power()),
                without: turned(&clean[station][channel], 0.0),
            });
        }
    }
    Ok(out)
}
