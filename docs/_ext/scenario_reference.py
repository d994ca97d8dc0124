"""The tables of the scenario reference, from the schema that checks scenario files.

Run by Sphinx, it writes ``docs/generated/``; the pages include what it writes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from multilift import quantities, schema
from multilift.quantities import Quantity
from multilift.schema import Field, Table

if TYPE_CHECKING:
    from sphinx.application import Sphinx

NBSP = "\N{NO-BREAK SPACE}"
TABLES = (*schema.TABLES.values(), schema.PUSH)


def grid(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table."""
    lines = [list(heads)]
    lines.append(["---"] * len(lines[0]))
    lines += [[cell.replace("|", r"\|").replace("*", r"\*") for cell in row] for row in rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def value(field: Field) -> str:
    """What may be given, short: range and unit, and how many in parentheses."""
    if field.kind == "text":
        return ", ".join(f"`{c}`" for c in field.choices) if field.choices else "a text"
    if field.kind == "flag":
        return "`true`, `false`"
    bound = {"positive": "> 0", "non_negative": "≥ 0", "any": ""}[field.range]
    text = f"{bound} {unit(field.unit)}".strip() or "a number"
    count = "list" if field.kind == "list" else " × ".join(map(str, field.shape))
    return (f"{text} ({count})" if count else text).replace(" ", NBSP)


def unit(text: str) -> str:
    """A unit as people set it, on one line."""
    return powers(text).replace(" ", NBSP)


def powers(text: str) -> str:
    return text.replace("^2", "²").replace("^3", "³")


def default(field: Field) -> str:
    """The default, one number where all are equal."""
    if field.required:
        return "**required**".replace("*", "\0")
    if field.default is None:
        return "–"
    if field.kind == "flag":
        return "`false`" if not field.default else "`true`"
    if field.kind == "text":
        return f"`{field.default}`"
    numbers = set(np.ravel(field.default).tolist())
    assert len(numbers) == 1, f"{field.name}: defaults differ, show them one by one"
    number = numbers.pop()
    if math.isinf(number):
        return "no limit"
    return "π/2" if math.isclose(number, math.pi / 2) else f"{number:g}"


def field_table(fields: Iterable[Field]) -> str:
    rows = [(f"`{f.name}`", value(f), default(f), powers(f.doc)) for f in fields]
    return grid(("key", "value", "default", "meaning"), rows).replace("\0", "*")


def sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}."


def section(table: Table) -> str:
    name = "[[push]]" if table is schema.PUSH else f"[{table.name}]"
    anchor = f"(table-{table.name})="
    return f"{anchor}\n## `{name}`\n\n{sentence(table.doc)}\n\n{field_table(table.fields)}\n"


def scenario_tables() -> str:
    """Every table of a scenario file but the controller's."""
    return "\n".join(section(table) for table in TABLES)


def law_tables() -> str:
    """The controller's common keys, then each law's gains."""
    parts = [field_table(schema.CONTROLLER_COMMON)]
    for law, title in schema.LAW_TITLES.items():
        parts.append(f'### `law = "{law}"`\n\n{sentence(title)}')
        parts.append(field_table(schema.gain_fields(law)))
    return "\n\n".join(parts) + "\n"


def unit_table() -> str:
    """Which units a text may carry."""
    rows = [
        (f"`{base}`", ", ".join(f"`{name}`" for name in scales))
        for base, scales in schema.UNIT_SCALES.items()
    ]
    return grid(("unit of the key", "a text may also say"), rows) + "\n"


def quantity_table(table: dict[str, Quantity]) -> str:
    rows = [(f"`{q.name}`", unit(q.unit), powers(q.doc)) for q in table.values()]
    return grid(("name", "unit", "meaning"), rows) + "\n"


def pages() -> dict[str, str]:
    """Content of each generated file by its name."""
    return {
        "scenario-tables.md": scenario_tables(),
        "law-tables.md": law_tables(),
        "units.md": unit_table(),
        "columns.md": quantity_table(quantities.COLUMNS),
        "metrics.md": quantity_table(quantities.METRICS),
        "audit.md": quantity_table(quantities.AUDIT),
    }


def write(app: Sphinx) -> None:
    folder = Path(app.srcdir) / "generated"
    folder.mkdir(exist_ok=True)
    for name, content in pages().items():
        file = folder / name
        if not file.exists() or file.read_text(encoding="utf-8") != content:
            file.write_text(content, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
