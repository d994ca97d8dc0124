"""A sample of the lab files that nobody should write; `make fuzz` reads millions."""

import fuzz_lab
import pytest


@pytest.mark.parametrize("seed", range(4))
def test_every_lab_file_is_one_or_one_clear_error(seed):
    # Were all good, or none, nothing would be tried.
    assert 0 < fuzz_lab.fuzz(1000, seed) < 1000


def test_a_scenario_that_is_not_there_is_said_of_the_lab(tmp_path):
    with pytest.raises(fuzz_lab.ScenarioError, match=r"fuzzed\.toml: scenario = 'nowhere'"):
        fuzz_lab.lab.parse({"scenario": "nowhere"}, fuzz_lab.WHERE, tmp_path)


def test_what_is_wrong_in_the_scenario_s_file_is_said_of_that(tmp_path):
    (tmp_path / "mine.toml").write_text("plant = 3")
    with pytest.raises(fuzz_lab.ScenarioError, match=r"mine\.toml: plant"):
        fuzz_lab.lab.parse({"scenario": "mine.toml"}, fuzz_lab.WHERE, tmp_path)
