"""The shipped studies at a very small size, as `multilift reproduce` can show them."""

from multilift.paper import studies


def test_every_shipped_study_runs_and_has_its_row_and_page(tmp_path, monkeypatch):
    real = studies.small

    def short(name, **sizes):
        plan = real(name, **sizes)
        shorter = {"simulation.duration": 0.5}
        return plan.__class__(**{**plan.__dict__, "scenario": plan.scenario.with_values(shorter)})

    monkeypatch.setattr(studies, "small", short)
    done = []
    table = studies.table(tmp_path, lambda: done.append(1), count=2, points=2)
    assert len(table.rows) == len(done) == len(studies.names())
    assert all(len(row) == len(table.heads) for row in table.rows)
    for name, row in zip(studies.names(), table.rows, strict=True):
        assert (tmp_path / name / "report.html").is_file()
        assert name in row[-1]


def test_the_small_size_keeps_the_range_of_a_grid():
    full = studies.study.load("gains_sim1")
    small = studies.small("gains_sim1")
    assert small.worlds < full.worlds / 8
    for a, b in zip(small.vary, full.vary, strict=True):
        assert a.bounds() == b.bounds()
        assert set(a.values) <= set(b.values)
