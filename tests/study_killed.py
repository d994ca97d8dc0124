"""Runs a study in a child of this process that is killed again and again, at random instants.

python study_killed.py STUDY.toml FOLDER KILLS SEED: begins in new folders until so many kills have
struck while chunks were missing, finishes each folder undisturbed, prints one JSON line.
"""

import json
import os
import signal
import sys
import time
import traceback
from pathlib import Path

import numpy as np
import pandas  # noqa: F401 - pyarrow would load it again in every child
from multilift import study
from multilift.study import page, run
from multilift.study.store import open_store


def parts(folder):
    rows = folder / "rows"
    return {f.name for f in rows.glob("chunk-*.parquet")} if rows.is_dir() else set()


def attempt(plan, folder, delay):
    """One run in a child, killed after `delay` seconds; whether it was killed."""
    child = os.fork()
    if child == 0:
        status = 1
        try:
            run.run(plan, folder, chunk=2)
            status = 0
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(status)
    time.sleep(delay)
    os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    if os.WIFEXITED(status) and os.WEXITSTATUS(status) != 0:
        raise SystemExit("the study failed by itself")
    return os.WIFSIGNALED(status)


def main(file, target, kills, seed):
    plan = study.load(file)
    chunks = -(-plan.worlds // 2)
    page.write = lambda *_: None  # figures take longer than all the rest; not what is tested here
    rng = np.random.default_rng(seed)
    begin = time.perf_counter()
    run.run(plan, Path(target) / "timed", chunk=2)
    longest = 0.4 * (time.perf_counter() - begin)  # so that a few kills strike each folder
    done = {"kills": 0, "after_the_rows": 0, "folders": [], "lost": 0, "leftovers": 0}
    while done["kills"] < kills:
        folder = Path(target) / f"killed_{len(done['folders'])}"
        done["folders"].append(folder.name)
        before = set()
        for _ in range(10_000):
            killed = attempt(plan, folder, rng.uniform(0.0, longest))
            now = parts(folder)
            done["lost"] += len(before - now)
            before = now
            done["kills"] += killed and len(now) < chunks
            longest *= 1.1 if killed and len(now) == 0 else 1.0  # this machine got slower
            done["after_the_rows"] += killed and len(now) == chunks
            if not killed or len(now) == chunks:
                break
        run.run(plan, folder)
        done["leftovers"] += len(list(folder.rglob(".tmp-*")))
        with open_store(folder, plan) as store:
            assert store.missing() == []
            assert store.damaged == []
    print(json.dumps(done))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
