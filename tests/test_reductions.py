"""Reductions: claims about one number along an axis such as time."""

from dataclasses import replace

import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr

from fiv_cli.case.case import ClaimSpec
from fiv_cli.case.load import parse_case
from fiv_cli.errors import CaseError
from fiv_cli.reading import select
from fiv_cli.reading.claims import CONFIRMED, CONTRADICTED, UNDETERMINED, evaluate
from fiv_cli.reading.reductions import reduced

TIMES = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
DISPLACEMENT = np.array([[0.0, 2.0, -1.0, 4.0, 0.0, 1.0], [1.0, 1.0, 1.0, np.nan, np.nan, np.nan]])
STATES = [["slip+", "stick", "slip+", "separation", "slip+", "separation"], ["stick"] * 6]
FREQUENCIES = np.array([0.0, 8.0, 16.0])
AMPLITUDES = np.array([[[0.0, 3.0, 1.0], [0.0, 1.0, 2.0], [np.nan] * 3]])


def history(status=("ok", "ok")):
    """Two motions over six instants."""
    codes = data.codes(data.CONTACT_STATES, STATES)
    return xr.Dataset(
        {
            "status": ("initial", data.codes(data.STATUS, status), data.status_flag()),
            "x": (("initial", "time"), DISPLACEMENT, {"units": "m"}),
            "contact_state": (("initial", "time"), codes, data.flag(data.CONTACT_STATES)),
        },
        coords={"initial": ["a", "b"], "time": ("time", TIMES, {"units": "s"})},
    )


def spectrogram():
    """One motion over three instants and three frequencies."""
    return xr.Dataset(
        {
            "status": ("initial", data.codes(data.STATUS, ["ok"]), data.status_flag()),
            "amplitude": (("initial", "time", "frequency"), AMPLITUDES, {"units": "rad"}),
        },
        coords={
            "initial": ["a"],
            "time": ("time", TIMES[:3], {"units": "s"}),
            "frequency": ("frequency", FREQUENCIES, {"units": "Hz"}),
        },
    )


@pytest.mark.parametrize(
    ("variable", "take", "of", "expected"),
    [
        ("x", "least", "", [-1.0, 1.0]),
        ("x", "greatest", "", [4.0, 1.0]),
        ("x", "range", "", [5.0, 0.0]),
        ("x", "mean", "", [1.0, 1.0]),
        ("x", "peak", "", [3.0, 0.0]),
        ("x", "entries", ". > 0", [3.0, 0.0]),
        ("x", "share", ". > 0", [0.5, 0.5]),
        ("contact_state", "entries", "separation", [2.0, 0.0]),
        ("contact_state", "entries", "stick", [1.0, 0.0]),
        ("contact_state", "share", "not stick", [5 / 6, 0.0]),
    ],
)
def test_what_is_taken_along_time(variable, take, of, expected):
    asked = {"over": "time", "take": take} | ({"of": of} if of else {})
    assert reduced(history(), variable, asked)[variable].values.tolist() == expected


def test_the_frequency_at_which_a_spectrum_is_largest_at_each_instant():
    found = reduced(spectrogram(), "amplitude", {"over": "frequency", "take": "peak"})
    assert found["amplitude"].attrs["units"] == "Hz"
    np.testing.assert_array_equal(found["amplitude"].values, [[8.0, 16.0, np.nan]])


@pytest.mark.parametrize(
    ("variable", "asked", "word"),
    [
        ("y", {"over": "time", "take": "mean"}, "y"),
        ("x", {"over": "frequency", "take": "mean"}, "frequency"),
        ("x", {"over": "initial", "take": "mean"}, "initial"),
        ("contact_state", {"over": "time", "take": "entries", "of": "flight"}, "flight"),
    ],
)
def test_what_cannot_be_reduced_is_refused(variable, asked, word):
    with pytest.raises(select.SelectionError, match=word):
        reduced(history(), variable, asked)


SEPARATIONS = {"over": "time", "take": "entries", "of": "separation"}


@pytest.mark.parametrize(
    ("at", "count", "verdict"),
    [
        ({"initial": "a"}, 2.0, CONFIRMED),
        ({"initial": "a", "time": "2 <= . <= 4"}, 1.0, CONFIRMED),
        ({"initial": "a", "time": "3 <= . <= 4"}, 0.0, CONFIRMED),
        ({}, 2.0, CONTRADICTED),
    ],
)
def test_how_often_contact_is_lost_between_two_instants(at, count, verdict):
    expect = {"value": count, "tolerance": 0.0}
    said = ClaimSpec("4.3", "as printed", "contact_state", expect, at, reduce=SEPARATIONS)
    assert evaluate(said, {"": history()}, lambda case: None).verdict == verdict


def test_the_peak_of_a_spectrum_stays_in_a_band():
    peak = {"over": "frequency", "take": "peak"}
    expect = {"interval": [8.0, 16.0], "tolerance": 0.0}
    said = ClaimSpec("4.3", "as printed", "amplitude", expect, reduce=peak)
    found = evaluate(said, {"": spectrogram()}, lambda case: None)
    assert (found.verdict, found.found) == (CONFIRMED, "2 of 2 ends, found 8 to 16 Hz")
    early = replace(said, at={"time": 0.0})
    assert evaluate(early, {"": spectrogram()}, lambda case: None).verdict == CONTRADICTED


def test_a_motion_that_was_not_computed_leaves_its_number_open():
    said = ClaimSpec(
        "4.3", "as printed", "contact_state", {"less_than": 9.0}, {}, reduce=SEPARATIONS
    )
    found = evaluate(said, {"": history(("ok", "failed"))}, lambda case: None)
    assert (found.verdict, found.hits, found.open) == (UNDETERMINED, 1, 1)


def case_with(reduce):
    return parse_case(
        f"""
schema = 1
[model]
name = "belt-1dof"
[[initial]]
label = "rest"
kind = "state"
[[analysis]]
kind = "history"
t_end = 10.0
[[claim]]
source = "4.3"
text = "as printed"
variable = "contact_state"
expect = {{ less_than = 3.0 }}
reduce = {{ {reduce} }}
""",
        "test.toml",
    )


def test_a_case_may_ask_for_a_reduction():
    (said,) = case_with('over = "time", take = "entries", of = "stick"').claims
    assert said.reduce == {"over": "time", "take": "entries", "of": "stick"}


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ('over = "v", take = "mean"', "no axis that a variable has of its own"),
        ('over = "time", take = "entries"', "neither a condition"),
        ('over = "time", take = "share", of = "Stick!"', "neither a condition"),
        ('over = "time", take = "mean", of = "stick"', "is for share and entries"),
        ('over = "time", take = "median"', "take"),
    ],
)
def test_a_reduction_that_says_nothing_is_a_mistake(text, word):
    with pytest.raises(CaseError, match=word):
        case_with(text)
