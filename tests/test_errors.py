"""Errors travel between processes as they are."""

import pickle

import multilift as ml
import pytest


@pytest.mark.parametrize(
    "error",
    [
        ml.ScenarioError("is wrong", where="file", key="k", value=3, permitted="4", advice="do"),
        ml.MissingExtraError("scipy", "study", "this"),
        ml.OutputError("no\n  what to do: yes"),
        ml.ControllerError("no"),
    ],
)
def test_an_error_comes_back_from_another_process(error):
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert again.__dict__ == error.__dict__
