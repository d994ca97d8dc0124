"""A study's columns as figures want them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from multilift.study.store import Store
from multilift.study.summary import successes
from multilift.study.vary import Array, Vary

#: Bytes of columns that are kept once read; others are read again.
_KEPT = 2**28


class Columns:
    """A store's columns and who succeeded, each read when it is first wanted."""

    def __init__(self, store: Store) -> None:
        self.store = store
        self.study = store.study
        self._kept: dict[str, Array] = {}
        self.outcome: NDArray[np.int8] = store.column("outcome")
        self.finished = self.outcome == 0
        self.success, _ = successes(store, self.finished)

    def drawn(self, varied: Vary) -> Array:
        """What each world drew."""
        return np.asarray(self._column(varied.name)[0])

    def metric(self, name: str) -> Array:
        """A metric, shape (laws, worlds); NaN also where a run ended early."""
        return np.where(self.finished, self._column(name), np.nan)

    def _column(self, name: str) -> Array:
        values = self._kept.get(name)
        if values is None:
            values = self.store.column(name)
            if values.nbytes + sum(v.nbytes for v in self._kept.values()) <= _KEPT:
                self._kept[name] = values
        return values
