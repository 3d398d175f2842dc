"""What is taken of a variable along some axes, for figures and for claims."""

import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from synthetic_datasets import tried

from fiv_cli.case.case import FigureSpec
from fiv_cli.case.load import parse_case
from fiv_cli.case.structure import COUNTED
from fiv_cli.errors import CaseError
from fiv_cli.plots import draw
from fiv_cli.plots.style import look_of, notes_on
from fiv_cli.reading import select
from fiv_cli.reading.claims import CONFIRMED, CONTRADICTED, UNDETERMINED
from fiv_cli.reading.take import in_order, taken, taken_of_each, told_by_class, without_value

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


def plane(classes=CLASSES, status="ok"):
    found = data.response(classes, STICKS, data.axes(Omega=SPEEDS, psi_a=PHASES), status)
    return found.assign(stick_fraction=(found["L_s"].dims, STICKS, {"units": "1"}))


def failed_at(*place):
    status = np.full(CLASSES.shape, "ok", object)
    status[place] = "failed"
    return status


def share_of(condition, over=("psi_a",)):
    return {"what": "share", "of": condition, "over": list(over)}


SURVIVES = share_of(". > 0")


@pytest.mark.parametrize(
    ("variable", "share", "expected"),
    [
        ("stick_fraction", SURVIVES, [1.0, 0.5, 0.25]),
        ("attractor", share_of("not equilibrium"), [1.0, 0.5, 0.25]),
        ("attractor", share_of("chaotic"), [0.25, 0.0, 0.0]),
        ("attractor", share_of(["chaotic"]), [0.25, 0.0, 0.0]),
        ("attractor", share_of(["chaotic", "periodic"]), [1.0, 0.5, 0.25]),
        ("stick_fraction", share_of(". >= 0.3"), [1.0, 0.5, 0.0]),
        ("stick_fraction", SURVIVES | {"relative_to": {"Omega": 2.0}}, [2.0, 1.0, 0.5]),
        ("stick_fraction", SURVIVES | {"relative_to": {}}, [1.0, 0.5, 0.25]),
    ],
)
def test_a_share_counts_the_points_along_an_axis(variable, share, expected):
    assert taken(plane(), variable, share)["share"].values.tolist() == expected


def test_a_share_over_every_axis_is_one_number():
    share = taken(plane(), "stick_fraction", share_of(". > 0", over=("Omega", "psi_a")))
    assert share["share"].item() == pytest.approx(7 / 12)


def ends(found):
    return found["share_low"].values.tolist(), found["share_high"].values.tolist()


def test_a_share_with_a_point_missing_is_an_interval():
    partly = plane(status=failed_at(1, 2))
    found = taken(partly, "stick_fraction", SURVIVES)
    assert ends(found) == ([1.0, 0.5, 0.25], [1.0, 0.75, 0.25])
    assert found["share"].values.tolist() == [1.0, 0.625, 0.25]
    ratio = taken(partly, "stick_fraction", SURVIVES | {"relative_to": {"Omega": 2.0}})
    assert ends(ratio) == ([1.0 / 0.75, 0.5 / 0.75, 0.25 / 0.75], [2.0, 1.5, 0.5])


def test_a_share_without_any_answer_is_not_known():
    found = taken(plane(status=failed_at(1)), "stick_fraction", SURVIVES)
    assert np.isnan(found["share"].values).tolist() == [False, True, False]
    names = found["status"].attrs["flag_meanings"].split()
    assert names[int(found["status"][1])] == "failed"


def test_an_undecided_class_hides_the_class_but_not_how_much_it_sticks():
    classes = CLASSES.astype(object)
    classes[1, 0] = "undecided"
    sticking = taken(plane(classes), "stick_fraction", SURVIVES)
    moving = taken(plane(classes), "attractor", share_of("not equilibrium"))
    assert sticking["share"].values.tolist() == [1.0, 0.5, 0.25]
    assert ends(moving) == ([1.0, 0.25, 0.25], [1.0, 0.5, 0.25])


def test_a_reference_without_hits_makes_no_ratio():
    share = share_of(". > 0.5") | {"relative_to": {"Omega": 3.0}}
    assert np.isnan(taken(plane(), "stick_fraction", share)["share"].values).all()


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
        taken(plane(), variable, share_of(of))


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
    assert tried(plane(), "stick_fraction", expect, at, take=SURVIVES).verdict == verdict


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
    partly = plane(status=failed_at(1, 2))  # the share at 2 rad/s is 0.5 to 0.75
    found = tried(partly, "stick_fraction", expect, {"Omega": 2.0}, take=SURVIVES)
    assert found.verdict == verdict


@pytest.mark.parametrize(("failed", "verdict"), [(1, CONFIRMED), (3, UNDETERMINED)])
def test_intervals_that_overlap_leave_a_trend_open(failed, verdict):
    status = failed_at(2, slice(failed))  # 0.25 to 0.5 and to 1, after 0.5
    shares = plane(status=status).isel(Omega=[0, 2])
    assert tried(shares, "stick_fraction", "decreasing", take=SURVIVES).verdict == verdict


@pytest.mark.parametrize(
    ("take", "told"),
    [
        (share_of(". > 0.1"), '2 without L_s (contact_lost 2) count as not ". > 0.1"'),
        ({"what": "greatest", "over": ["psi_a"]}, "2 without L_s (contact_lost 2) are left out"),
    ],
)
def test_decided_points_without_a_number_are_told_where_others_are_counted(take, told):
    classes, lost = CLASSES.astype(object), (0, slice(2))
    classes[lost] = "contact_lost"
    dataset = plane(classes)
    dataset["L_s"] = dataset["L_s"].where(classes != "contact_lost")
    verdict = tried(dataset, "L_s", {"less_than": 9.0}, take=take)
    assert told in verdict.found
    elsewhere = tried(dataset, "L_s", {"less_than": 9.0}, {"Omega": 3.0}, take=take)
    assert "without" not in elsewhere.found
    assert "without" not in tried(plane(), "L_s", {"less_than": 9.0}, take=take).found
    drawn = draw(dataset, FigureSpec("c", "curve", {"variable": "L_s", "take": take}))
    assert told in drawn.get_suptitle()


@pytest.mark.parametrize(
    ("undecided", "wrong", "verdict"),
    [(5, 0, CONFIRMED), (5, 1, CONTRADICTED), (50, 0, UNDETERMINED), (0, 0, CONFIRMED)],
)
def test_a_handful_of_undecided_points_leaves_a_claim_to_the_rest(undecided, wrong, verdict):
    classes = np.full((1, 1000), "periodic", object)
    classes[0, :undecided] = "undecided"
    classes[0, 900 : 900 + wrong] = "equilibrium"
    grid = data.axes(Omega=SPEEDS[:1], psi_a=np.arange(1000.0))
    many = data.response(classes, np.ones(classes.shape), grid)
    assert tried(many, "attractor", "periodic").verdict == verdict


def test_a_claim_may_select_points_beside_the_reference_of_its_share():
    said = ("stick_fraction", {"value": 0.25, "tolerance": 1e-12}, {"Omega": 3.0})
    for speed, verdict in ((1.0, CONFIRMED), (9.0, UNDETERMINED)):
        share = SURVIVES | {"relative_to": {"Omega": speed}}
        assert tried(plane(), *said, take=share).verdict == verdict


def test_a_curve_of_shares():
    settings = {"variable": "stick_fraction", "take": SURVIVES}
    axes = draw(plane(), FigureSpec("survival", "curve", settings)).axes[0]
    line = next(line for line in axes.lines if len(line.get_xdata()) == len(SPEEDS))
    assert line.get_ydata().tolist() == [1.0, 0.5, 0.25]
    assert "share with stick fraction > 0" in axes.get_ylabel()


def test_a_map_of_a_share_draws_its_level():
    grid = data.axes(Omega=SPEEDS, N0=SPEEDS, psi_a=PHASES)
    classes, L_s = np.stack([CLASSES] * 3), np.stack([STICKS, STICKS / 2, STICKS / 4])
    cube = data.response(classes, L_s, grid)
    settings = {"variable": "L_s", "take": share_of(". > 0.1"), "level": 0.6}
    axes = draw(cube, FigureSpec("survival", "map", settings)).axes[0]
    assert len(axes.collections) == 2  # the mesh and the line
    status = np.full(L_s.shape, "ok", object)
    status[0, 0, 0] = "failed"
    partly = data.response(classes, L_s, grid, status)
    axes = draw(partly, FigureSpec("survival", "map", settings)).axes[0]
    assert len(axes.collections) == 3  # a line at each end of what is known


TIMES = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
DISPLACEMENT = np.array([[0.0, 2.0, -1.0, 4.0, 0.0, 1.0], [1.0, 1.0, 1.0, np.nan, np.nan, np.nan]])
STATES = [["slip+", "stick", "slip+", "separation", "slip+", "separation"], ["stick"] * 6]
FREQUENCIES = np.array([0.0, 8.0, 16.0])
AMPLITUDES = np.array([[[0.0, 3.0, 1.0], [0.0, 1.0, 2.0], [np.nan] * 3]])


def history(status=("ok", "ok")):
    """Two motions over six instants."""
    return xr.Dataset(
        {
            "status": data.statuses("initial", status),
            "x": (("initial", "time"), DISPLACEMENT, {"units": "m"}),
            "contact_state": data.flags(("initial", "time"), STATES, data.CONTACT_STATES),
        },
        coords={"initial": ["a", "b"], "time": ("time", TIMES, {"units": "s"})},
    )


def spectrogram():
    """One motion over three instants and three frequencies."""
    return xr.Dataset(
        {
            "status": data.statuses("initial", ["ok"]),
            "amplitude": (("initial", "time", "frequency"), AMPLITUDES, {"units": "rad"}),
        },
        coords={
            "initial": ["a"],
            "time": ("time", TIMES[:3], {"units": "s"}),
            "frequency": ("frequency", FREQUENCIES, {"units": "Hz"}),
        },
    )


@pytest.mark.parametrize(
    ("variable", "what", "of", "expected"),
    [
        ("x", "least", "", [-1.0, 1.0]),
        ("x", "greatest", "", [4.0, 1.0]),
        ("x", "spread", "", [5.0, 0.0]),
        ("x", "mean", "", [1.0, 1.0]),
        ("x", "peak", "", [3.0, 0.0]),
        ("x", "entries", ". > 0", [3.0, 0.0]),
        ("x", "share", ". > 0", [0.5, 0.5]),
        ("contact_state", "entries", "separation", [2.0, 0.0]),
        ("contact_state", "entries", "stick", [1.0, 0.0]),
        ("contact_state", "share", "not stick", [5 / 6, 0.0]),
    ],
)
def test_what_is_taken_along_time(variable, what, of, expected):
    take = {"over": ["time"], "what": what} | ({"of": of} if of else {})
    assert taken(history(), variable, take)[what].values.tolist() == expected


@pytest.mark.parametrize(
    ("what", "found", "lost"),
    [("spread", [0.2, np.nan, np.nan], 5), ("difference", [0.1, np.nan, np.nan], 3)],
)
def test_one_value_alone_is_no_agreement_and_a_figure_says_why_there_is_none(what, found, lost):
    """Over the last three phases all are known, then one, then none."""
    classes = CLASSES.astype(object)
    classes[1, 2:] = classes[2] = "contact_lost"
    dataset = plane(classes)
    known = dataset["stick_fraction"].where(classes != "contact_lost")
    dataset = dataset.assign(stick_fraction=known).isel(psi_a=slice(1, 4))
    take = {"what": what, "over": ["psi_a"]}
    np.testing.assert_allclose(taken(dataset, "stick_fraction", take)[what].values, found)
    settings = {"variable": "stick_fraction", "take": take}
    for titled in (True, False):
        drawn = draw(
            dataset, FigureSpec("c", "curve", settings), look=look_of("screen", titled=titled)
        )
        (ax,) = drawn.axes
        (mark,) = [line for line in ax.lines if line.get_label() == "contact lost"]
        assert mark.get_xdata().tolist() == [2.0, 3.0]
        told = f"{lost} without stick_fraction (contact_lost {lost}) are left out"
        assert (told in drawn.get_suptitle(), told in notes_on(drawn)) == (titled, not titled)


def test_of_a_difference_the_ends_of_the_axis_alone_count():
    classes, take = CLASSES.astype(object), {"what": "difference", "over": ["psi_a"]}
    classes[:, 1:3] = "undecided"
    part = plane(classes)
    np.testing.assert_allclose(taken(part, "stick_fraction", take)["difference"], [0.1, 0.0, 0.2])
    assert without_value(part.where(part["psi_a"] != 1.0), "stick_fraction", take) == ""
    ends = part["psi_a"].values[[0, -1]].tolist()
    for listed, sign in ((ends, 1.0), (ends[::-1], -1.0)):  # the last of a list less its first
        ordered = taken(part, "stick_fraction", in_order(take, {"psi_a": listed}))["difference"]
        np.testing.assert_allclose(ordered, sign * np.array([0.1, 0.0, 0.2]))
    plain = taken(part, "stick_fraction", take)["difference"]
    for listed in (
        [". >= 0", ends[0]],
        [9.9, ends[1]],
        [ends[1], ends[1]],
        [*ends, ends[0]],
    ):  # tell no order
        assert plain.equals(
            taken(part, "stick_fraction", in_order(take, {"psi.a": listed}))["difference"]
        )


def test_what_is_taken_over_a_dim_that_classes_have_none_of_says_what_vibrates_there():
    part = plane(CLASSES.astype(object))
    part["force"] = part["stick_fraction"] * xr.DataArray([1.0, 3.0], dims="contact")
    for what in ("spread", "difference"):
        found = taken(part, "force", {"what": what, "over": ["contact"]})
        np.testing.assert_allclose(found[what], 2.0 * part["stick_fraction"])
        assert found["moving"].dims == part["attractor"].dims


def test_what_is_counted_over_motions_without_a_value_is_an_answer():
    """The first of which something holds is nowhere, whatever the others are."""
    classes = CLASSES.astype(object)
    classes[2, 3] = "contact_lost"
    part = plane(classes)
    known = part["stick_fraction"].where(classes != "contact_lost")
    part = part.assign(stick_fraction=known)
    take = {"what": "first", "over": ["psi_a"], "of": ". > 0.9"}
    found = taken(part, "stick_fraction", take)
    assert found["first"].isnull().all()
    assert told_by_class(found, part, "stick_fraction", take) is found


def test_the_frequency_at_which_a_spectrum_is_largest_at_each_instant():
    found = taken(spectrogram(), "amplitude", {"over": ["frequency"], "what": "peak"})
    assert found["peak"].attrs["units"] == "Hz"
    np.testing.assert_array_equal(found["peak"].values, [[8.0, 16.0, np.nan]])


@pytest.mark.parametrize(
    ("variable", "take", "word"),
    [
        ("y", {"over": ["time"], "what": "mean"}, "y"),
        ("x", {"over": ["frequency"], "what": "mean"}, "frequency"),
        ("x", {"over": ["initial"], "what": "first", "of": ". > 0"}, "initial: an axis of labels"),
        ("contact_state", {"over": ["time"], "what": "entries", "of": "flight"}, "flight"),
    ],
)
def test_what_cannot_be_taken_is_refused(variable, take, word):
    with pytest.raises(select.SelectionError, match=word):
        taken(history(), variable, take)


SEPARATIONS = {"over": ["time"], "what": "entries", "of": "separation"}


def test_of_what_is_counted_the_nearest_that_there_is_is_told():
    counted = xr.DataArray(np.arange(20), dims="section_obs", name="section_obs")
    with pytest.raises(select.SelectionError, match="; the nearest is 19"):
        select.matching(counted, 99, nearest=True)


def test_of_what_a_dataset_has_none_nothing_is_taken():
    take = {"what": "share", "over": ["initial"], "of": "each"}
    with pytest.raises(select.SelectionError, match="no variable of the dataset"):
        taken_of_each(data.stability_map().drop_vars("attractor"), "attractor", take)


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
    assert tried(history(), "contact_state", expect, at, take=SEPARATIONS).verdict == verdict


def test_the_peak_of_a_spectrum_stays_in_a_band():
    peak = {"over": ["frequency"], "what": "peak"}
    wide, narrow = (
        tried(spectrogram(), "amplitude", {"between": [8.0, high]}, take=peak)
        for high in (16.0, 15.0)
    )
    assert (wide.verdict, wide.found) == (CONFIRMED, "2 of 2 points, found 8 to 16 Hz")
    assert narrow.verdict == CONTRADICTED


def test_a_motion_that_was_not_computed_leaves_its_number_open():
    partly = history(("ok", "failed"))
    found = tried(partly, "contact_state", {"less_than": 9.0}, take=SEPARATIONS)
    assert (found.verdict, found.hits, found.open) == (UNDETERMINED, 1, 1)


FOUND = {}
"""What is taken of three values and their statuses."""


@given(
    st.lists(st.tuples(st.sampled_from([0.0, 1.0, 2.0]), st.booleans()), min_size=3, max_size=3),
    st.sampled_from(["share", "first", "last", "classes", "least", "greatest", "mean"]),
)
def test_what_is_taken_lies_between_its_ends_whatever_the_missing_points_hold(points, what):
    """Over points that were not computed, and of those that were, for every completion."""
    values, failed = (np.array(column) for column in zip(*points, strict=True))
    take = {"what": what, "over": ["Omega"]} | ({"of": ". > 0"} if what in COUNTED else {})

    def found(L_s, status):
        key = what, *map(float, L_s), *status
        if key not in FOUND:  # examples share most of their completions
            along = data.axes(Omega=SPEEDS)
            FOUND[key] = taken(data.response(["periodic"] * 3, L_s, along, status), "L_s", take)
        return FOUND[key]

    asked = found(values, np.where(failed, "failed", "ok"))
    low, high = (float(asked[f"{what}_{end}"]) for end in ("low", "high"))
    if failed.all():
        assert np.isnan([low, high]).all()
        return
    for filled in np.ndindex(*np.where(failed, 3, 1)):
        complete = float(found(np.where(failed, filled, values), ["ok"] * 3)[what])
        anywhere = np.isinf([low, high]).all()
        assert anywhere or low <= complete <= high or np.isnan([low, complete]).all()


def case_with(take):
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
{take}
""",
        "test.toml",
    )


def test_a_case_may_take_a_number():
    (said,) = case_with('take = { over = "time", what = "entries", of = "stick" }').claims
    assert said.take == {"over": ["time"], "what": "entries", "of": "stick"}


@pytest.mark.parametrize(
    ("take", "word"),
    [
        ('over = "w", what = "mean"', "nothing called 'w' to vary"),
        ('over = "time", what = "entries"', "entries needs of: a class"),
        ('over = "time", what = "classes", of = "stick"', "classes is taken of all values"),
        ('over = "time", what = "share", of = "Stick!"', "neither a condition"),
        ('over = "time", what = "mean", of = "stick"', "of is for share, entries, first, last"),
        ('over = "time", what = "median"', "'median' .a string. is not allowed"),
        ('over = ["time", "initial"], what = "peak"', "along one axis, not 2"),
        ('over = [], what = "mean"', "along one axis, not 0"),
        ('over = "time", what = "mean", relative_to = { time = 1 }', "is for share, not mean"),
    ],
)
def test_a_take_that_says_nothing_is_a_mistake(take, word):
    with pytest.raises(CaseError, match=word):
        case_with(f"take = {{ {take} }}")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (
            'share = { of = ". > 0", over = ["v"], relative_to = { v = 1 } }',
            'take = { what = "share", of = ". > 0", over = ["v"], relative_to = { v = 1 } }',
        ),
        ('reduce = { over = "time", take = "range" }', 'take = { what = "spread", over = "time" }'),
    ],
)
def test_what_a_case_of_before_says_is_told_in_the_words_of_now(old, new):
    with pytest.raises(CaseError) as caught:
        case_with(old)
    (problem,) = caught.value.problems
    assert problem.message.endswith(f"write {new}")
