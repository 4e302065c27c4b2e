"""Results as HTML, which notebooks show."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape


def table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table with a header."""
    head = "".join(f"<th>{escape(column)}</th>" for column in columns)
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def pairs(rows: Mapping[str, str]) -> str:
    """Names with their values, one a line."""
    return "".join(f"<div>{escape(name)}: <b>{escape(value)}</b></div>" for name, value in rows.items())


def page(kind: str, title: str, parts: Iterable[str], warnings: Sequence[str] = ()) -> str:
    """A result: its kind and title, its parts, and all of its warnings."""
    listed = "".join(f"<li>{escape(warning)}</li>" for warning in warnings)
    said = f"<div><b>{len(warnings)} warning{'s'[: len(warnings) != 1]}</b><ul>{listed}</ul></div>"
    return f"<div><b>{escape(kind)}</b> {escape(title)}{''.join(parts)}{said if warnings else ''}</div>"
