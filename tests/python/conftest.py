"""Machines and measurement sets that the tests share."""

from __future__ import annotations

import numpy as np
import pytest

import jointid as jd

BENCH = {"quantity": "receptance", "response": "table", "excitation": "table"}
LINES = np.linspace(8.0, 500.0, 150)
NUTS = {"p1": 0.6, "p2": 1.2, "p3": 1.8}


def taps(
    k_n: float, seed: int, noise: float = 0.01, lines: np.ndarray = LINES, nuts: dict[str, float] = NUTS
) -> jd.MeasurementSet:
    """A hammer test of the bench with another stiffness of the nut, with noise."""
    values = jd.Study(overrides={"parameter.k_n.start": k_n}).frf(lines, nut_m=list(nuts.values()), **BENCH)
    generator = np.random.default_rng(seed)
    values = values * (
        1
        + noise
        / np.sqrt(2)
        * (generator.normal(size=values.shape) + 1j * generator.normal(size=values.shape))
    )
    relative_sd = {name: np.full(lines.size, noise) for name in nuts}
    return jd.MeasurementSet.from_arrays(
        lines, dict(zip(nuts, values, strict=True)), relative_sd=relative_sd, nut_m=nuts, **BENCH
    )


@pytest.fixture(scope="session")
def study() -> jd.Study:
    return jd.Study().choose_fit(["l1", "l3", "l5"])


@pytest.fixture(scope="session")
def found(study: jd.Study) -> jd.Identification:
    return study.identify(progress=False)


@pytest.fixture(scope="session")
def on_frfs() -> jd.Identification:
    return jd.Study(None, taps(4e8, 1)).choose_fit(["p1", "p3"]).identify(progress=False)
