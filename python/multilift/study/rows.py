"""A chunk of a study: its worlds simulated under every law, one row for each world and law."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.batch import Batch, simulate_batch
from multilift.errors import MissingExtraError, ScenarioError
from multilift.study.draws import SEED, draw
from multilift.study.spec import Study

try:
    import pyarrow as pa
except ImportError:
    raise MissingExtraError("pyarrow", "study", "multilift study") from None

Draws = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class Chunk:
    """The rows of worlds `start` to `stop`, and what they took.

    Attributes:
        start, stop: first world, and the one after the last.
        table: laws in the study's order, worlds ascending within each.
        kernel_seconds: wall time in the compiled kernel.
        simulated_seconds: simulated time of all its runs.
    """

    start: int
    stop: int
    table: pa.Table
    kernel_seconds: float
    simulated_seconds: float


@dataclass(frozen=True)
class Flown:
    """Simulated worlds whose rows are not made yet: that may be done in another thread.

    Attributes:
        study: whose worlds.
        start: the first of them.
        drawn: what they drew.
        batches: what became of them, law by law.
    """

    study: Study
    start: int
    drawn: Draws
    batches: tuple[Batch, ...]

    def chunk(self) -> Chunk:
        """Their rows."""
        return Chunk(
            self.start,
            self.start + self.batches[0].count,
            _table(self.study, self.start, self.drawn, list(self.batches)),
            sum(batch.kernel_seconds for batch in self.batches),
            float(sum(batch.end_time.sum() for batch in self.batches)),
        )


def fly(
    study: Study,
    start: int,
    stop: int,
    *,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> Flown:
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
    for k, law in enumerate(study.controllers):
        before = k * (stop - start)

        def advance(done: int, before: int = before) -> None:
            if progress is not None:
                progress(before + done)

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
        batches.append(batch)
    return Flown(study, start, drawn, tuple(batches))


def overrides(study: Study, law: str, drawn: Draws) -> dict[str, NDArray[Any]]:
    """The scenario keys that the drawn numbers set under a law; gains it lacks are left out."""
    gains = study.scenario.model.controller_keys(law)
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


def arrow_schema(study: Study) -> pa.Schema:
    """The columns of a study's rows, each with unit and meaning in its metadata."""
    names = study.scenario.quantities
    text = pa.dictionary(pa.int8(), pa.string())
    why = pa.dictionary(_code_type(_reasons(study)), pa.string())
    columns = [
        ("world", pa.int64(), "", "number of the world; the same draws under every law"),
        ("controller", text, "", "name of the law"),
        *((v.name, pa.float64(), v.unit, f"drawn: {v.label}") for v in study.vary),
    ]
    if study.draws_noise:
        columns.append((SEED, pa.int64(), "", "seed of the measurement noise"))
    columns += [
        ("outcome", text, "", _alternatives(study.outcomes)),
        ("reason", why, "", "why it ended early"),
        ("culprit", pa.int8(), "", study.scenario.model.culprit_doc),
        ("end_time", pa.float64(), "s", "when the run ended"),
        *((n, pa.float64(), q.unit, q.doc) for n, q in names.metrics.items()),
        *((f"audit.{n}", pa.float64(), q.unit, q.doc) for n, q in names.audit.items()),
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
    for k, outcome in enumerate(study.outcomes):
        codes[status == outcome] = k
    reasons = _reasons(study)
    model, most = study.scenario.model, study.scenario.model.culprits(study.scenario)
    place = np.array([[reasons.index(model.reason(o, max(c, 0))) for c in range(-1, most)]
                      for o in study.outcomes])  # fmt: skip
    columns["outcome"] = _texts(codes, study.outcomes)
    columns["reason"] = _texts(place[codes, culprit + 1], reasons)
    columns["culprit"] = np.where(codes == 0, -1, culprit).astype(np.int8)
    for name in study.scenario.quantities.metrics:
        columns[name] = np.concatenate([b.metrics[name] for b in batches])
    for name in study.scenario.quantities.audit:
        columns[f"audit.{name}"] = np.concatenate([b.audit[name] for b in batches])
    arrays = [c if isinstance(c := columns[f.name], pa.Array) else pa.array(c, type=f.type)
              for f in layout]  # fmt: skip
    return pa.table(arrays, schema=layout)


def _reasons(study: Study) -> list[str]:
    """Every reason why a run of the study can end."""
    model = study.scenario.model
    culprits = range(model.culprits(study.scenario))
    return list(dict.fromkeys(model.reason(o, c) for o in study.outcomes for c in culprits))


def _alternatives(words: Sequence[str]) -> str:
    return f"{', '.join(words[:-1])} or {words[-1]}"


def _code_type(texts: Sequence[str]) -> pa.DataType:
    return pa.int8() if len(texts) <= np.iinfo(np.int8).max else pa.int16()


def _texts(codes: NDArray[Any], texts: Sequence[str]) -> pa.DictionaryArray:
    return pa.DictionaryArray.from_arrays(
        pa.array(codes, type=_code_type(texts)), pa.array(list(texts))
    )
