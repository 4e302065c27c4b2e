//! Times of a receptance at one line, an evaluation of an objective, and a whole identification: `cargo
//! bench`.

mod support;

use std::hint::black_box;
use std::sync::Arc;

use config::read_machine;
use criterion::{Criterion, criterion_group, criterion_main};
use dynamics::model::{RodModel, Structure};
use identification::objective::{FrfObjective, FrfSettings, ModeObjective, ModeSettings};
use identification::{IdentificationSettings, identify};
use long_work::Control;
use machine::Operating;
use measurement::read_set;
use optimizer::{Cost, LeastSquares};
use support::simulated_frfs;

fn bench(criterion: &mut Criterion) {
    let config = read_machine("configs/tian.toml", &[], &[]).expect("the bench's machine is valid");
    let set = read_set("measurements/tian").expect("the bench's measurements are valid");
    let machine = &config.machine;
    let (fit, held_out) = set.split(None, &[]).expect("the split is valid");

    let table = machine.point("table").expect("the machine has a table");
    let structure =
        Arc::new(Structure::new(machine, table, table, RodModel::Exact).expect("the table can move"));
    let (mut network, mut work) = (structure.empty_model(), structure.workspace());
    network.update(machine, &machine.start(), &Operating::at_nut(1.0));
    criterion.bench_function("receptance and slope, one line", |b| {
        b.iter(|| network.at(black_box(3000.0), &mut work).receptance)
    });
    criterion.bench_function("modes below a frequency", |b| {
        b.iter(|| network.modes_below(black_box(3000.0), &mut work))
    });

    let objective =
        ModeObjective::new(machine, &fit, ModeSettings::default(), &[]).expect("the objective is valid");
    let place = vec![0.4; objective.free.len()];
    criterion
        .bench_function("objective, 3 positions × 4 orders", |b| b.iter(|| objective.at(black_box(&place))));

    // Whole FRFs: 3 positions × 1,000 lines, simulated with the bench's machine.
    let nuts_m = [0, 2, 4].map(|position: usize| set.positions[position].nut_m);
    let frequencies_hz: Vec<f64> = (0..1000).map(|i| f64::from(i) + 5.0).collect();
    let whole = simulated_frfs(machine, ("table", "table"), &nuts_m, &frequencies_hz);
    let (frf_fit, _) = whole.split(None, &[]).expect("the split is valid");
    let frfs =
        FrfObjective::new(machine, &frf_fit, FrfSettings::default(), &[]).expect("the objective is valid");
    let place = vec![0.4; LeastSquares::dimension(&frfs)];
    criterion
        .bench_function("whole FRFs, χ² of 3,000 lines", |b| b.iter(|| frfs.chi_square(black_box(&place))));
    criterion.bench_function("whole FRFs, normal equations of 3,000 lines", |b| {
        b.iter(|| frfs.normal(black_box(&place)).chi_square)
    });

    let mut slow = criterion.benchmark_group("whole");
    slow.sample_size(10);
    let (_, frf_held_out) = whole.split(None, &[]).expect("the split is valid");
    for (name, tolerances, profile) in [
        ("identify, 3 × 1,000 lines", false, false),
        ("identify, 3 × 1,000 lines, tolerances and intervals", true, true),
    ] {
        let plan = IdentificationSettings {
            frf: Some(FrfSettings::default()),
            tolerances,
            profile,
            ..IdentificationSettings::default()
        };
        let run = || {
            identify(machine, &frf_fit, &frf_held_out, &plan, &Control::default())
                .expect("the identification succeeds")
        };
        println!("{name}: {} evaluations", run().evaluations);
        slow.bench_function(name, |b| b.iter(|| run().cost));
    }
    slow.bench_function("identify, default plan", |b| {
        b.iter(|| {
            identify(machine, &fit, &held_out, &IdentificationSettings::default(), &Control::default())
                .map(|i| i.cost)
                .expect("the identification succeeds")
        });
    });
    slow.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
