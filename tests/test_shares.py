"""Shares: how many points along some axes satisfy a condition, in figures and in claims."""

from dataclasses import replace

import numpy as np
import pytest
import synthetic_datasets as data

from fiv_cli.case.case import ClaimSpec, FigureSpec
from fiv_cli.plots import draw
from fiv_cli.reading import select
from fiv_cli.reading.claims import CONFIRMED, CONTRADICTED, UNDETERMINED, evaluate
from fiv_cli.reading.shares import with_share

SPEEDS = np.array([1.0, 2.0, 3.0])
PHASES = np.array([0.0, 1.0, 2.0, 3.0])
# rows: speeds; columns: phases
CLASSES = np.array(
    [
        ["periodic", "periodic", "periodic", "chaotic"],
        ["periodic", "equilibrium", "equilibrium", "periodic"],
        ["equilibrium", "equilibrium", "equilibrium", "periodic"],
    ]
)
STICKS = np.array([[0.5, 0.5, 0.4, 0.6], [0.3, 0.0, 0.0, 0.3], [0.0, 0.0, 0.0, 0.2]])


def plane(classes=CLASSES, status=None):
    coords = {
        "Omega": data.axis("Omega", SPEEDS, r"\Omega", "rad s-1", "disc speed"),
        "psi_a": data.axis("psi_a", PHASES, r"\psi_a", "rad", "start of the sector"),
    }
    status = np.full(classes.shape, "ok") if status is None else status
    found = data.response(classes, STICKS, coords, ("Omega", "psi_a"), status)
    return found.assign(stick_fraction=(found["L_s"].dims, STICKS, {"units": "1"}))


SURVIVES = {"of": ". > 0", "over": ["psi_a"]}


@pytest.mark.parametrize(
    ("variable", "share", "expected"),
    [
        ("stick_fraction", SURVIVES, [1.0, 0.5, 0.25]),
        ("attractor", {"of": "not equilibrium", "over": ["psi_a"]}, [1.0, 0.5, 0.25]),
        ("attractor", {"of": "chaotic", "over": ["psi_a"]}, [0.25, 0.0, 0.0]),
        ("stick_fraction", {"of": ". >= 0.3", "over": ["psi_a"]}, [1.0, 0.5, 0.0]),
        ("stick_fraction", SURVIVES | {"relative_to": {"Omega": 2.0}}, [2.0, 1.0, 0.5]),
    ],
)
def test_a_share_counts_the_points_along_an_axis(variable, share, expected):
    assert with_share(plane(), variable, share)["share"].values.tolist() == expected


def test_a_share_over_every_axis_is_one_number():
    share = with_share(plane(), "stick_fraction", {"of": ". > 0", "over": ["Omega", "psi_a"]})
    assert share["share"].item() == pytest.approx(7 / 12)


def ends(found):
    return found["share_low"].values.tolist(), found["share_high"].values.tolist()


def test_a_share_with_a_point_missing_is_an_interval():
    status = np.full(CLASSES.shape, "ok", object)
    status[1, 2] = "failed"
    found = with_share(plane(status=status), "stick_fraction", SURVIVES)
    assert ends(found) == ([1.0, 0.5, 0.25], [1.0, 0.75, 0.25])
    assert found["share"].values.tolist() == [1.0, 0.625, 0.25]
    ratio = with_share(
        plane(status=status), "stick_fraction", SURVIVES | {"relative_to": {"Omega": 2.0}}
    )
    assert ends(ratio) == ([1.0 / 0.75, 0.5 / 0.75, 0.25 / 0.75], [2.0, 1.5, 0.5])


def test_a_share_without_any_answer_is_not_known():
    status = np.full(CLASSES.shape, "ok", object)
    status[1] = "failed"
    found = with_share(plane(status=status), "stick_fraction", SURVIVES)
    assert np.isnan(found["share"].values).tolist() == [False, True, False]
    names = found["status"].attrs["flag_meanings"].split()
    assert names[int(found["status"][1])] == "failed"


def test_an_undecided_class_hides_the_class_but_not_how_much_it_sticks():
    classes = CLASSES.astype(object)
    classes[1, 0] = "undecided"
    sticking = with_share(plane(classes), "stick_fraction", SURVIVES)
    moving = with_share(plane(classes), "attractor", {"of": "not equilibrium", "over": ["psi_a"]})
    assert sticking["share"].values.tolist() == [1.0, 0.5, 0.25]
    assert ends(moving) == ([1.0, 0.25, 0.25], [1.0, 0.5, 0.25])


def test_a_reference_without_hits_makes_no_ratio():
    share = {"of": ". > 0.5", "over": ["psi_a"], "relative_to": {"Omega": 3.0}}
    assert np.isnan(with_share(plane(), "stick_fraction", share)["share"].values).all()


@pytest.mark.parametrize(
    ("variable", "of", "word"),
    [
        ("nothing", ". > 0", "nothing"),
        ("attractor", "wobbling", "wobbling"),
        ("L_s", "periodic", "condition"),
    ],
)
def test_what_cannot_be_counted_is_refused(variable, of, word):
    with pytest.raises(select.SelectionError, match=word):
        with_share(plane(), variable, {"of": of, "over": ["psi_a"]})


def claim(expect, at=None, share=SURVIVES):
    return ClaimSpec("7.4", "as printed", "stick_fraction", expect, at or {}, share=share)


@pytest.mark.parametrize(
    ("expect", "at", "verdict"),
    [
        ({"less_than": 0.3}, {"Omega": 3.0}, CONFIRMED),
        ({"less_than": 0.3}, {"Omega": 2.0}, CONTRADICTED),
        ({"value": 0.0, "tolerance": 0.0}, {"Omega": 3.0, "psi_a": ". < 2.5"}, CONFIRMED),
        ("decreasing", {}, CONFIRMED),
        ("increasing", {}, CONTRADICTED),
    ],
)
def test_claims_about_shares(expect, at, verdict):
    assert evaluate(claim(expect, at), {"": plane()}, lambda case: None).verdict == verdict


@pytest.mark.parametrize(
    ("expect", "verdict"),
    [
        ({"less_than": 0.8}, CONFIRMED),
        ({"less_than": 0.6}, UNDETERMINED),
        ({"less_than": 0.5}, CONTRADICTED),
        ({"value": 0.6, "tolerance": 0.2}, CONFIRMED),
        ({"value": 0.6, "tolerance": 0.05}, UNDETERMINED),
        ({"value": 0.9, "tolerance": 0.1}, CONTRADICTED),
    ],
)
def test_a_claim_about_an_interval_is_decided_where_its_ends_agree(expect, verdict):
    status = np.full(CLASSES.shape, "ok", object)
    status[1, 2] = "failed"  # the share at 2 rad/s is 0.5 to 0.75
    found = evaluate(claim(expect, {"Omega": 2.0}), {"": plane(status=status)}, lambda case: None)
    assert found.verdict == verdict


@pytest.mark.parametrize(("failed", "verdict"), [(1, CONFIRMED), (3, UNDETERMINED)])
def test_intervals_that_overlap_leave_a_trend_open(failed, verdict):
    status = np.full(CLASSES.shape, "ok", object)
    status[2, :failed] = "failed"  # 0.25 to 0.5 and to 1, after 0.5
    shares = plane(status=status).isel(Omega=[0, 2])
    assert evaluate(claim("decreasing"), {"": shares}, lambda case: None).verdict == verdict


@pytest.mark.parametrize(
    ("undecided", "wrong", "verdict"),
    [(5, 0, CONFIRMED), (5, 1, CONTRADICTED), (50, 0, UNDETERMINED), (0, 0, CONFIRMED)],
)
def test_a_handful_of_undecided_points_leaves_a_claim_to_the_rest(undecided, wrong, verdict):
    classes = np.full((1, 1000), "periodic", object)
    classes[0, :undecided] = "undecided"
    classes[0, 900 : 900 + wrong] = "equilibrium"
    coords = {
        "Omega": data.axis("Omega", SPEEDS[:1], r"\Omega", "rad s-1", "disc speed"),
        "psi_a": data.axis("psi_a", np.arange(1000.0), r"\psi_a", "rad", "start of the sector"),
    }
    status = np.full(classes.shape, "ok")
    many = data.response(classes, np.ones(classes.shape), coords, ("Omega", "psi_a"), status)
    said = ClaimSpec("7.4", "as printed", "attractor", "periodic", {})
    assert evaluate(said, {"": many}, lambda case: None).verdict == verdict


def test_a_claim_may_select_points_beside_the_reference_of_its_share():
    share = SURVIVES | {"relative_to": {"Omega": 1.0}}
    said = claim({"value": 0.25, "tolerance": 1e-12}, {"Omega": 3.0}, share)
    assert evaluate(said, {"": plane()}, lambda case: None).verdict == CONFIRMED
    other = replace(said, share=SURVIVES | {"relative_to": {"Omega": 9.0}})
    assert evaluate(other, {"": plane()}, lambda case: None).verdict == UNDETERMINED


def test_a_curve_of_shares():
    settings = {"variable": "stick_fraction", "share": SURVIVES}
    axes = draw(plane(), FigureSpec("survival", "curve", settings)).axes[0]
    line = next(line for line in axes.lines if len(line.get_xdata()) == len(SPEEDS))
    assert line.get_ydata().tolist() == [1.0, 0.5, 0.25]
    assert "share with stick fraction > 0" in axes.get_ylabel()


def test_a_map_of_a_share_draws_its_level():
    coords = {
        "Omega": data.axis("Omega", SPEEDS, r"\Omega", "rad s-1", "disc speed"),
        "N0": data.axis("N0", SPEEDS, "N_0", "N", "preload"),
        "psi_a": data.axis("psi_a", PHASES, r"\psi_a", "rad", "start of the sector"),
    }
    L_s = np.stack([STICKS, STICKS / 2, STICKS / 4])
    cube = data.response(
        np.stack([CLASSES] * 3), L_s, coords, ("Omega", "N0", "psi_a"), np.full(L_s.shape, "ok")
    )
    settings = {"variable": "L_s", "share": {"of": ". > 0.1", "over": ["psi_a"]}, "level": 0.6}
    axes = draw(cube, FigureSpec("survival", "map", settings)).axes[0]
    assert len(axes.collections) == 2  # the mesh and the line
    status = np.full(L_s.shape, "ok", object)
    status[0, 0, 0] = "failed"
    partly = data.response(np.stack([CLASSES] * 3), L_s, coords, ("Omega", "N0", "psi_a"), status)
    axes = draw(partly, FigureSpec("survival", "map", settings)).axes[0]
    assert len(axes.collections) == 3  # a line at each end of what is known
