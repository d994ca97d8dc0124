"""What tests of studies share: small studies, and their rows as one table."""

import hashlib

import pandas as pd

SMALL = """
schema = 1
name = "small"
title = "A small study"
scenario = "sim1"
controllers = ["energy_coupled", "pd"]
count = 10
seed = 5
metrics = ["peak_swing_1", "swing_settling_time"]

[set]
simulation.duration = 0.05

[[vary]]
key = "plant.bar_mass"
distribution = "uniform"
low = 0.6
high = 1.0

[[vary]]
key = "controller.k_lambda"
distribution = "list"
values = [0.7, 1.4]

[[success]]
metric = "peak_swing_1"
below = 0.02
"""


def write(folder, text=SMALL, name="small.toml"):
    file = folder / name
    file.write_text(text)
    return file


def rows(folder):
    """All rows of a study's folder, parts in order."""
    parts = sorted((folder / "rows").glob("chunk-*.parquet"))
    return pd.concat([pd.read_parquet(p) for p in parts], ignore_index=True)


def fingerprint(folder):
    """Every bit of every row."""
    table = rows(folder)
    digest = hashlib.sha256()
    for name in table.columns:
        column = table[name]
        text = column.astype(str) if column.dtype.kind not in "if" else column
        content = "\n".join(text) if text is not column else column.to_numpy().tobytes()
        digest.update(name.encode() + (content.encode() if isinstance(content, str) else content))
    return digest.hexdigest()
