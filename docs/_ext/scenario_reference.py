"""The tables of the scenario reference, from the tables that check scenario files.

Run by Sphinx, it writes ``docs/generated/``, a folder for each model; the pages include what it
writes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from multilift import models
from multilift.fields import UNIT_SCALES, Field
from multilift.models import Model
from multilift.quantities import Quantity
from multilift.schema import Table, controller_fields

if TYPE_CHECKING:
    from sphinx.application import Sphinx

NBSP = "\N{NO-BREAK SPACE}"


def grid(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table."""
    lines = [list(heads)]
    lines.append(["---"] * len(lines[0]))
    lines += [[cell.replace("|", r"\|").replace("*", r"\*") for cell in row] for row in rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def value(field: Field) -> str:
    """What may be given, short: range and unit, and how many in parentheses."""
    if field.kind == "text":
        return ", ".join(map(choice, field.choices)) if field.choices else "a text"
    if field.kind == "flag":
        return "`true`, `false`"
    bound = {"positive": "> 0", "non_negative": "≥ 0", "any": ""}[field.range]
    text = f"{bound} {unit(field.unit)}".strip() or "a number"
    if field.kind == "whole":
        text = f"{field.least} to {field.most}" + f", {field.size} in shapes" * bool(field.size)
    count = "list" if field.kind == "list" else " × ".join(map(str, field.shape))
    return (f"{text} ({count})" if count else text).replace(" ", NBSP)


def choice(text: str) -> str:
    """A permitted text; one for each of a size n where it ends with it."""
    head, brace, size = text.rstrip("}").partition("{")
    return f"`{head}1` … `{head}{size}`" if brace else f"`{text}`"


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
    if field.kind in ("flag", "text"):
        return f"`{field.default}`".replace("True", "true").replace("False", "false")
    numbers = np.ravel(field.default).tolist()
    if len(set(numbers)) > 1:
        return ", ".join(f"{x:g}" for x in numbers)
    number = numbers[0]
    if math.isinf(number):
        return "no limit"
    return "π/2" if math.isclose(number, math.pi / 2) else f"{number:g}"


def field_table(fields: Iterable[Field]) -> str:
    rows = [(f"`{f.name}`", value(f), default(f), powers(f.doc)) for f in fields]
    return grid(("key", "value", "default", "meaning"), rows).replace("\0", "*")


def sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}."


def section(model: Model, table: Table) -> str:
    name = f"[[{table.name}]]" if table.repeated else f"[{table.name}]"
    anchor = f"(table-{model.name}-{table.name})="
    parts = [f"{anchor}\n### `{name}`", sentence(table.doc)]
    if table.follows:
        parts.append(f"The keys of [`[{table.follows}]`](#table-{model.name}-{table.follows}).")
    else:
        parts.append(field_table(table.fields))
    return "\n\n".join(parts) + "\n"


def scenario_tables(model: Model) -> str:
    """Every table of a scenario file but the controller's and those inside it."""
    tables = [t for t in model.tables.values() if not t.name.startswith("controller.")]
    return "\n".join(section(model, table) for table in tables)


def law_tables(model: Model) -> str:
    """The controller's common keys, each law's gains, and the tables inside the controller's."""
    parts = [field_table(controller_fields(tuple(model.laws)))]
    for name, law in model.laws.items():
        parts.append(f'#### `law = "{name}"`\n\n{sentence(law.title)}')
        parts.append(field_table(law.gains))
    inside = [t for t in model.tables.values() if t.name.startswith("controller.")]
    parts += [section(model, table).rstrip() for table in inside]
    return "\n\n".join(parts) + "\n"


def unit_table() -> str:
    """Which units a text may carry."""
    rows = [
        (f"`{base}`", ", ".join(f"`{name}`" for name in scales))
        for base, scales in UNIT_SCALES.items()
    ]
    return grid(("unit of the key", "a text may also say"), rows) + "\n"


def quantity_table(table: Mapping[str, Quantity]) -> str:
    rows = [(f"`{q.name}`", unit(q.unit), powers(q.doc)) for q in table.values()]
    return grid(("name", "unit", "meaning"), rows) + "\n"


def model_pages(model: Model) -> dict[str, str]:
    """Content of a model's generated files by name."""
    names = model.described
    return {
        "scenario-tables.md": scenario_tables(model),
        "law-tables.md": law_tables(model),
        "columns.md": quantity_table(names.columns),
        "metrics.md": quantity_table(names.metrics),
        "audit.md": quantity_table(names.audit),
    }


def pages() -> dict[str, str]:
    """Content of each generated file by its path below ``docs/generated``."""
    result = {"units.md": unit_table()}
    for model in map(models.by_name, models.names()):
        result |= {f"{model.name}/{name}": text for name, text in model_pages(model).items()}
    return result


def write(app: Sphinx) -> None:
    folder = Path(app.srcdir) / "generated"
    for name, content in pages().items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        if not file.exists() or file.read_text(encoding="utf-8") != content:
            file.write_text(content, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
