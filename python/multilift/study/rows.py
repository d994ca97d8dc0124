"""A chunk of a study: its worlds simulated under every law, one row for each world and law."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift import quantities, schema
from multilift.batch import Batch, simulate_batch
from multilift.errors import MissingExtraError, ScenarioError
from multilift.study.draws import SEED, draw
from multilift.study.spec import Study

try:
    import pyarrow as pa
except ImportError:
    raise MissingExtraError("pyarrow", "study", "multilift study") from None

Draws = Mapping[str, NDArray[Any]]

#: Outcomes in the order in which tables and figures show them.
OUTCOMES = ("finished", "slack", "swing_limit", "diverged")


@dataclass(frozen=True)
class Chunk:
    """The rows of worlds `start` to `stop`, and what they took.

    Attributes:
        start, stop: first world, and the one after the last.
        table: laws in the study's order, worlds ascending within each.
        engine_seconds: wall time inside the batch engine.
        simulated_seconds: simulated time of all its runs.
    """

    start: int
    stop: int
    table: pa.Table
    engine_seconds: float
    simulated_seconds: float


def simulate(
    study: Study,
    start: int,
    stop: int,
    *,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> Chunk:
    """Simulates worlds `start` to `stop` under every law of the study.

    Args:
        study: what to simulate.
        start: first world.
        stop: the one after the last.
        threads: of the batch engine; None for its own choice.
        progress: told how many of the chunk's runs are done, all laws together.

    Raises:
        ScenarioError: if a world is drawn that the scenario does not permit.
    """
    drawn = draw(study, start, stop)
    batches: list[Batch] = []
    seconds = 0.0
    for k, law in enumerate(study.controllers):
        before = k * (stop - start)

        def advance(done: int, before: int = before) -> None:
            if progress is not None:
                progress(before + done)

        begin = time.perf_counter()
        try:
            batch = simulate_batch(
                study.under(law), overrides(study, law, drawn), controller=law,
                count=stop - start, threads=threads, progress=advance,
            )  # fmt: skip
        except ScenarioError as error:
            raise ScenarioError(
                f"draws a world, one of {start} to {stop - 1}, that the scenario does not "
                f"permit:\n    " + str(error).replace("\n", "\n    "),
                where=study.where,
                key="vary",
                advice="narrow what varies, so that every combination is possible",
            ) from None
        seconds += time.perf_counter() - begin
        batches.append(batch)
    simulated = float(sum(batch.end_time.sum() for batch in batches))
    return Chunk(start, stop, _table(study, start, drawn, batches), seconds, simulated)


def overrides(study: Study, law: str, drawn: Draws) -> dict[str, NDArray[Any]]:
    """The scenario keys that the drawn numbers set under a law; gains it lacks are left out."""
    gains = {f.name for f in schema.controller_table(law).fields} | {"assumed"}
    result: dict[str, NDArray[Any]] = {}
    for varied in study.vary:
        for key, value in varied.overrides(study.scenario, drawn[varied.name]).items():
            table, _, rest = key.partition(".")
            if table == "controller" and rest.split(".")[0].split("[")[0] not in gains:
                continue
            result[key] = value.astype(np.int64) if key == SEED else value
    if SEED in drawn and study.draws_noise:
        result[SEED] = drawn[SEED]
    return result


def reason(outcome: str, culprit: int) -> str:
    """Why a run ended, empty if it reached its end."""
    return {
        "finished": "",
        "slack": f"cable {culprit + 1} would go slack",
        "swing_limit": f"|theta{culprit + 1}| reached 90 degrees",
        "diverged": "diverged",
    }[outcome]


def arrow_schema(study: Study) -> pa.Schema:
    """The columns of a study's rows, each with unit and meaning in its metadata."""
    text = pa.dictionary(pa.int8(), pa.string())
    columns = [
        ("world", pa.int64(), "", "number of the world; the same draws under every law"),
        ("controller", text, "", "name of the law"),
        *((v.name, pa.float64(), v.unit, f"drawn: {v.label}") for v in study.vary),
    ]
    if study.draws_noise:
        columns.append((SEED, pa.int64(), "", "seed of the measurement noise"))
    columns += [
        ("outcome", text, "", "finished, slack, swing_limit or diverged"),
        ("reason", text, "", "why it ended early"),
        ("culprit", pa.int8(), "", "which cable or angle, counted from 0; -1 if none"),
        ("end_time", pa.float64(), "s", "when the run ended"),
        *((n, pa.float64(), q.unit, q.doc) for n, q in quantities.METRICS.items()),
        *((f"audit.{n}", pa.float64(), q.unit, q.doc) for n, q in quantities.AUDIT.items()),
    ]
    return pa.schema(
        [pa.field(n, t, metadata={"unit": u, "description": d}) for n, t, u, d in columns]
    )


def _table(study: Study, start: int, drawn: Draws, batches: list[Batch]) -> pa.Table:
    layout = arrow_schema(study)
    laws = len(batches)
    count = len(batches[0].end_time)
    status = np.concatenate([b.status for b in batches])
    culprit = np.concatenate([b.culprit for b in batches])
    columns: dict[str, Any] = {
        "world": np.tile(np.arange(start, start + count, dtype=np.int64), laws),
        "controller": _texts(np.repeat(np.arange(laws), count), study.controllers),
        **{name: np.tile(values, laws) for name, values in drawn.items()},
        "end_time": np.concatenate([b.end_time for b in batches]),
    }
    codes = np.zeros(len(status), dtype=np.int8)
    for k, outcome in enumerate(OUTCOMES):
        codes[status == outcome] = k
    reasons = list(dict.fromkeys(reason(o, c) for o in OUTCOMES for c in range(3)))
    place = {(o, c): reasons.index(reason(o, max(c, 0))) for o in OUTCOMES for c in range(-1, 3)}
    why = [place[OUTCOMES[o], int(c)] if c < 3 else 0 for o, c in zip(codes, culprit, strict=True)]
    columns["outcome"] = _texts(codes, OUTCOMES)
    columns["reason"] = _texts(np.array(why), reasons)
    columns["culprit"] = np.where(codes == 0, -1, culprit).astype(np.int8)
    for name in quantities.METRICS:
        columns[name] = np.concatenate([b.metrics[name] for b in batches])
    for name in quantities.AUDIT:
        columns[f"audit.{name}"] = np.concatenate([b.audit[name] for b in batches])
    arrays = [c if isinstance(c := columns[f.name], pa.Array) else pa.array(c, type=f.type)
              for f in layout]  # fmt: skip
    return pa.table(arrays, schema=layout)


def _texts(codes: NDArray[Any], texts: Any) -> pa.DictionaryArray:
    return pa.DictionaryArray.from_arrays(pa.array(codes.astype(np.int8)), pa.array(list(texts)))
