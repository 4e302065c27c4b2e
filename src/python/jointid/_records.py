"""Checks of the records that a measurement set is made of: FRFs and motions as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from . import _arrays
from ._errors import argument


def gain_of(gain: float | str) -> float | None:
    """A gain above 0, or None for an unknown one."""
    if isinstance(gain, str):
        if gain != "unknown":
            raise argument("gain", f'is {gain!r}; give a number above 0, or "unknown"')
        return None
    value = _arrays.number("gain", gain, 'give a number above 0, or "unknown"')
    if value <= 0:
        raise argument("gain", f'is {value}; give a number above 0, or "unknown"')
    return value


# Keys of an FRF that a mapping may have beside its arrays, with their checks.
_OF_RECORD: dict[str, Any] = {
    "position": _arrays.optional_name,
    "record": _arrays.optional_name,
    "response": _arrays.optional_name,
    "excitation": _arrays.optional_name,
    "quantity": _arrays.optional_name,
    "averages": lambda key, given: _arrays.optional_count(key, given, 1),
    "force_n": lambda key, given: None if given is None else _arrays.number(key, given),
    "speed_m_s": lambda key, given: None if given is None else _arrays.number(key, given),
    "acceleration_m_s2": lambda key, given: None if given is None else _arrays.number(key, given),
}
_NOISE = ("coherence", "relative_sd")


def frfs_by_position(frequency_hz: Any, frfs: Any, coherence: Any, relative_sd: Any) -> list[dict[str, Any]]:
    """The records of FRFs given by position, one each."""
    values = _arrays.mapping("frfs", frfs)
    if frequency_hz is None:
        raise argument("frequency_hz", "is missing; give the frequencies of the FRFs in Hz")
    common = None if isinstance(frequency_hz, Mapping) else _arrays.frequencies("frequency_hz", frequency_hz)
    noise = {
        key: _arrays.optional_mapping(key, given)
        for key, given in (("coherence", coherence), ("relative_sd", relative_sd))
    }
    for key, given in noise.items():
        _arrays.unknown(key, given, values)
    records = []
    for position, value in values.items():
        own: dict[str, Any] = {"position": position, "value": value}
        if common is None:
            by_position = _arrays.mapping("frequency_hz", frequency_hz)
            if position not in by_position:
                raise argument("frequency_hz", f"has no «{position}»; give the frequencies of every position")
            own["frequency_hz"] = by_position[position]
        else:
            own["frequency_hz"] = common
        own |= {key: given[position] for key, given in noise.items() if position in given}
        label = repr(position)
        key_of = "frequency_hz" if common is not None else f"frequency_hz[{label}]"
        names = {"value": f"frfs[{label}]", "frequency_hz": key_of} | {
            key: f"{key}[{label}]" for key in _NOISE
        }
        records.append(_checked(own, names))
    return records


def frf_record(at: int, record: Any) -> dict[str, Any]:
    """One of several FRFs, each given with its own frequencies, channel and noise."""
    own = _arrays.mapping(f"frfs[{at}]", record)
    known = [*_OF_RECORD, "frequency_hz", "value", *_NOISE]
    _arrays.unknown(f"frfs[{at}]", own, known)
    for key in ("frequency_hz", "value"):
        if own.get(key) is None:
            raise argument(
                f"frfs[{at}]", f"has no {key}; give its frequencies (Hz) as frequency_hz and the FRF as value"
            )
    return _checked(own, {key: f"frfs[{at}][{key!r}]" for key in known})


def _checked(own: dict[str, Any], names: dict[str, str]) -> dict[str, Any]:
    lines = _arrays.frequencies(names["frequency_hz"], own["frequency_hz"])
    made: dict[str, Any] = {
        key: check(names.get(key, key), own.get(key)) for key, check in _OF_RECORD.items()
    }
    made |= {"frequency_hz": lines, "value": _arrays.complex_array(names["value"], own["value"])}
    made |= {
        key: None if own.get(key) is None else _arrays.real_array(names[key], own[key]) for key in _NOISE
    }
    for key in ("value", *_NOISE):
        if made[key] is not None:
            _arrays.same_length(names[key], made[key], names["frequency_hz"], lines.size)
            made[key] = _arrays.own(made[key])
    return made | {"frequency_hz": _arrays.own(lines)}


def motion_record(record: str, given: Any) -> dict[str, Any]:
    """A motion record: time, command, position, force or torque, and further columns."""
    label = f"motions[{record!r}]"
    arrays = {
        key: _arrays.own(_arrays.real_array(f"{label}[{key!r}]", array))
        for key, array in _arrays.mapping(label, given).items()
    }
    efforts = [key for key in ("force_n", "torque_nm") if key in arrays]
    missing = [key for key in ("time_s", "command_m", "position_m") if key not in arrays]
    if missing or len(efforts) != 1:
        raise argument(
            label,
            f"has {', '.join(arrays) or 'nothing'}; give time_s, command_m, position_m and one of force_n and torque_nm",
        )
    for key, array in arrays.items():
        _arrays.same_length(f"{label}[{key!r}]", array, f"{label}['time_s']", arrays["time_s"].size)
    made: dict[str, Any] = {key: arrays.pop(key) for key in ("time_s", "command_m", "position_m")}
    return made | {
        "name": record,
        "effort": arrays.pop(efforts[0]),
        "is_torque": efforts[0] == "torque_nm",
        "others": arrays,
    }


def require_channel(given: Mapping[str, Any], records: list[dict[str, Any]]) -> None:
    """Refuses FRFs whose quantity, points or averages neither they nor the set state."""
    for key, remedy in (
        ("quantity", "receptance, mobility or accelerance"),
        ("response", "the point of the machine"),
        ("excitation", "the point of the machine"),
    ):
        if given[key] is None and any(record[key] is None for record in records):
            raise argument(key, f"is missing; give {remedy}")
    if given["averages"] is None and any(
        record["coherence"] is not None and record["averages"] is None for record in records
    ):
        raise argument(
            "averages", "is missing, without which a coherence says nothing; give the number of averages"
        )
