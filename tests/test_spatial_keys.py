"""Every key of a spatial scenario refuses what it cannot mean; the cases come from the schema."""

import math

import numpy as np
import pytest
from multilift.errors import ScenarioError
from multilift.models.spatial import tables
from multilift.scenario import Scenario
from multilift.schema import controller_fields
from spatial_scenarios import FEEDBACK
from spatial_scenarios import tables as plate_tables

LAWS = tuple(tables.LAWS)
COUNT = 3
ENTRIES = {
    "push": {"body": "payload", "start": 0.5, "duration": 0.5},
    "event": {"kind": "cable_cut", "time": 1.0, "vehicle": "vehicle_1"},
}


def raw_of(law="energy_coupled"):
    """A plate under a law, with one push and one event."""
    raw = plate_tables(COUNT)
    gains = {f.name for f in tables.LAWS[law].gains}
    feedback = {k: v for k, v in FEEDBACK.items() if k in gains}
    raw["controller"] = {"law": law, "rate": 100.0, **feedback}
    for field in tables.LAWS[law].gains:
        if field.required and field.name not in feedback:
            raw["controller"][field.name] = 1.0
    return {**raw, **{name: [dict(entry)] for name, entry in ENTRIES.items()}}


def with_value(raw, table, key, value):
    """The tables with one key of one table changed, and how an error names it."""
    if table in ENTRIES:
        raw[table][0][key] = value
        return raw, f"{table}[0].{key}"
    node = raw
    for part in table.split("."):
        node = node.setdefault(part, {})
    node[key] = value
    return raw, f"{table}.{key}"


def all_fields():
    """Law, table, resolved field of every key that there is."""
    for name, table in tables.TABLES.items():
        for field in table.resolved({"n": COUNT}).fields:
            yield "energy_coupled", name, field
    for law, info in tables.LAWS.items():
        for field in (*controller_fields(LAWS), *info.gains):
            yield law, "controller", field.resolved({"n": COUNT})


def bad_values(field):
    """Values of the wrong kind, unit, shape or range for a field, each with words that say so."""
    yield {"a": 1.0}, ""
    if field.kind == "flag":
        return (yield from ((1, "truth value"), ("yes", "truth value")))
    if field.kind == "text":
        yield 3, "not a text"
        if field.choices:
            yield "none such", "not known"
        return
    yield True, ""
    yield "much", "not"
    if field.kind == "whole":
        yield 1.5, "whole number"
        yield field.least - 1, "out of range"
        yield field.most + 1, "out of range"
        return
    yield "1 furlong", "unit"
    yield math.nan, "finite"
    yield 10**400, "too large"
    if field.kind == "list":
        return
    if field.default is None or not np.isinf(field.default).any():
        yield math.inf, "finite"
    yield -math.inf, ""
    yield np.ones((*field.dims, COUNT + 4)).tolist(), "shape"
    for bound, worst in (("positive", 0.0), ("positive", -1.0), ("non_negative", -1e-9)):
        if field.range == bound:
            yield worst, "positive" if bound == "positive" else "negative"
            # One bad number among good ones is as bad.
            if field.dims:
                some = np.ones(field.dims)
                some.flat[-1] = worst
                yield some.tolist(), ""


CASES = [
    pytest.param(law, table, field, id=f"{law}-{table}-{field.name}")
    for law, table, field in all_fields()
]


@pytest.mark.parametrize("law", LAWS)
def test_the_plate_itself_is_no_mistake(law):
    Scenario(raw_of(law))


@pytest.mark.parametrize("law", LAWS)
def test_no_key_of_a_table_stands_for_two_things(law):
    model = Scenario(raw_of()).model
    for table in (*tables.TABLES.values(), model.controller_table(law)):
        names = [field.name for field in table.fields]
        assert len(set(names)) == len(names), table.name


@pytest.mark.parametrize(("law", "table", "field"), CASES)
def test_a_bad_value_gives_an_error_that_names_its_key(law, table, field):
    for value, words in bad_values(field):
        raw, key = with_value(raw_of(law), table, field.name, value)
        with pytest.raises(ScenarioError) as caught:
            Scenario(raw, "plate.toml")
        assert caught.value.key == key, value
        assert caught.value.where == "plate.toml"
        assert words in str(caught.value)


@pytest.mark.parametrize(("law", "table", "field"), CASES)
def test_finite_numbers_of_any_size_are_taken_or_refused_by_name(law, table, field):
    if field.kind != "number":
        return
    signs = (1.0, -1.0) if field.range == "any" else (1.0,)
    for size in (1e-300, 1e-9, 1e9, 1e300):
        for sign in signs:
            raw, _ = with_value(raw_of(law), table, field.name, sign * size)
            try:
                Scenario(raw)
            except ScenarioError as error:
                assert error.key, error


@pytest.mark.parametrize("table", [*tables.TABLES, "controller"])
def test_a_key_that_no_table_has_is_refused(table):
    raw, key = with_value(raw_of(), table, "none_such", 1.0)
    with pytest.raises(ScenarioError) as caught:
        Scenario(raw)
    assert caught.value.key == key


@pytest.mark.parametrize(
    ("law", "table", "field"), [case for case in CASES if case.values[2].required]
)
def test_a_missing_key_that_is_needed_is_named(law, table, field):
    raw = raw_of(law)
    if table in ENTRIES:
        del raw[table][0][field.name]
    else:
        node = raw
        for part in table.split("."):
            node = node.get(part, {})
        if table == "controller.assumed" or field.name not in node:
            return  # it follows another table, or this law's other spelling is given
        del node[field.name]
    with pytest.raises(ScenarioError) as caught:
        Scenario(raw)
    assert caught.value.key.endswith(field.name)
