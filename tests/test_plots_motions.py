"""Histories, phase portraits and spectra, drawn from small datasets."""

import csv
import json
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr
from matplotlib.collections import LineCollection, QuadMesh
from matplotlib.figure import Figure
from plotted import SLIP_MINUS, SLIP_PLUS, figure, legend_texts, marks

from fiv_cli.errors import EmptyFigureError, UsageError
from fiv_cli.flags import REASON
from fiv_cli.plots import draw, look_of, motion, spectrum, style
from fiv_cli.plots.drawn import as_csv
from fiv_cli.plots.spectrum import amplitude_spectrum
from fiv_cli.reading import sampling
from fiv_cli.reading.datasets import flag_names


def test_a_history_has_every_sample_and_shades_every_contact_state():
    dataset = data.history()
    drawn = draw(dataset, figure("history"))
    assert len(drawn.axes) == 4
    top = drawn.axes[0]
    x, y = top.lines[0].get_data()
    samples = np.isin(x, dataset["time"])
    assert np.array_equal(y[samples], dataset["phi"].sel(initial="far"))
    transitions = np.count_nonzero(np.diff(dataset["contact_state"].sel(initial="far")))
    assert len(top.patches) == transitions + 1
    assert top.get_ylabel() == r"$\varphi$ (rad)"
    assert drawn.axes[2].get_xlabel() == "time $t$ (s)"
    assert legend_texts(drawn) == [SLIP_PLUS, SLIP_MINUS, "stick"]


def without_events(dataset):
    return dataset.drop_vars([name for name in dataset if name.startswith("event_")])


def with_ledger():
    dataset = without_events(data.history())
    dataset["event_row_size"] = ("initial", [3, 1], {"sample_dimension": "event_obs"})
    dataset["event_time"] = ("event_obs", [1.0, 1.001, 2.5, 3.0], {"units": "s"})
    dataset["event_contact"] = ("event_obs", [1, 1, 1, 1], {"units": "1"})
    before, after = ["slip+", "stick", "slip+", "slip-"], ["stick", "slip+", "stick", "slip+"]
    for name, states in (("event_from", before), ("event_to", after)):
        dataset[name] = data.flags("event_obs", states, data.CONTACT_STATES)
    return dataset


def test_shades_follow_the_event_ledger_where_there_is_one():
    dataset = with_ledger()
    drawn = draw(dataset, figure("history"))
    far, near = (
        [(p.get_x(), p.get_x() + p.get_width()) for p in ax.patches] for ax in drawn.axes[:2]
    )
    end = float(dataset["time"][-1])
    assert np.ravel(far) == pytest.approx([0, 1, 1, 1.001, 1.001, 2.5, 2.5, end])
    assert np.ravel(near) == pytest.approx([0, 3, 3, end])
    assert legend_texts(drawn) == [SLIP_PLUS, SLIP_MINUS, "stick"]


def test_motions_without_a_known_sample_are_not_drawn():
    dataset = with_ledger()
    with pytest.raises(EmptyFigureError, match="window from 90 to 91 s: nothing to draw"):
        draw(dataset, figure("phase", window=[90.0, 91.0]))
    dataset["phi"][1] = np.nan
    assert not draw(dataset, figure("history")).axes[1].patches
    dataset["phi"][:] = np.nan
    with pytest.raises(EmptyFigureError, match="nothing to draw"):
        draw(dataset, figure("history"))


def test_no_line_goes_back_along_an_axis_that_others_advance_with():
    """Two values of the damping at one of the ratio: neither is joined to the other."""
    for dataset, name in ((data.crossings(), "critical_value"), (data.bifurcation(), "L_s")):
        axis = next(iter(dataset[name].dims))
        values = dataset[axis].values.copy()
        values[1::2] = values[:-1:2]
        back = dataset.assign_coords({axis: (axis, values, dataset[axis].attrs)})
        (ax,) = draw(back, figure("curve", variable=name, x=axis)).axes
        steps = [np.diff(line.get_xdata()) for line in ax.lines if line.get_linestyle() != "None"]
        assert steps and not any((along <= 0.0).any() for along in steps)


def test_spectra_none_of_which_is_known_are_not_drawn():
    dataset = data.spectra()
    dataset["amplitude"][:] = np.nan
    with pytest.raises(EmptyFigureError, match="amplitude: nothing to draw"):
        draw(dataset, figure("spectrum"))


def test_a_history_that_ended_early_is_drawn_as_far_as_it_goes():
    dataset = data.history()
    for name in ("phi", "phi_dot", "theta", "theta_dot"):
        dataset[name][1, 300:] = np.nan
    ended = draw(dataset, figure("history")).axes[1]
    assert np.isin(ended.lines[0].get_xdata(), dataset["time"]).sum() == 300
    assert max(p.get_x() + p.get_width() for p in ended.patches) < 3.0


@pytest.mark.parametrize("kind", ["history", "phase"])
def test_of_several_contacts_the_legend_says_which_one_is_shown(kind):
    dataset = data.history(labels=("far",))
    dataset["contact_state"] = dataset["contact_state"].expand_dims(contact=[1, 2], axis=1)
    for asked in ({"contact": 2}, {"select": {"contact": 2}}):
        drawn = draw(dataset, figure(kind, variable="phi", **asked))
        assert drawn.legends[0].get_title().get_text() == "colours: contact 2"
    both = draw(dataset, figure(kind, variable="phi", contact=[2, 1]))
    told = [note for note in style.notes_on(both) if note.startswith("contact 1: where it sticks")]
    assert len(told) == (kind == "history")
    first = draw(dataset.drop_vars("event_contact"), figure(kind, variable="phi"))
    assert first.legends[0].get_title().get_text() == "colours: contact 1"
    never = dataset.drop_vars("event_contact").copy(deep=True)
    never["contact_state"][:, 0] = data.codes(data.CONTACT_STATES, "slip+")  # of contact 1
    drawn = draw(never, figure(kind, variable="phi"))
    assert drawn.legends[0].get_title().get_text() == "colours: contact 2"
    assert "contact 2 sticks" not in legend_texts(drawn)
    with pytest.raises(UsageError, match="contact = 3: there are 1, 2"):
        draw(dataset, figure(kind, variable="phi", contact=3))
    alone = draw(data.history(labels=("far",)), figure(kind, variable="phi"))
    assert alone.legends[0].get_title().get_text() == ""


def test_a_side_of_one_sample_tells_nothing_of_a_corner():
    """Another contact's event lies just before: the slip up to the stick has one sample."""
    time, values = np.arange(8.0), np.array([0.0, 0.05, 0.1, 0.13, 0.3, 0.3, 0.3, 0.3])
    events = (motion.Event(2.5, 2, "slip+", "stick"), motion.Event(3.7, 1, "slip+", "stick"))
    one = motion.Motion("", time, xr.Dataset(), events)
    sides = [sampling.led_to(one.instants, time, values, side) for side in (-1, 1)]
    assert one._met(values, *sides, 2)[1] == pytest.approx(0.3)
    again = motion.Event(3.8, 1, "stick", "stick")
    twice = motion.Motion("", time, xr.Dataset(), (events[1], again))  # no sample between
    sides = [sampling.led_to(twice.instants, time, values, side) for side in (-1, 1)]
    assert twice._met(values, *sides, 2) == pytest.approx([0.3, 0.3])
    line = motion.Motion(
        "",
        time,
        xr.Dataset(),
        (motion.Event(2.1, 1, "slip+", "stick"), motion.Event(2.9, 2, "slip+", "stick")),
    )
    sides = [sampling.led_to(line.instants, time, time, side) for side in (-1, 1)]
    assert line._met(time, *sides, 2) == pytest.approx([2.1, 2.9])


@pytest.mark.parametrize("kind", ["history", "phase"])
def test_a_motion_that_ended_before_its_time_has_a_mark_where_it_did(kind):
    dataset = data.history(labels=("far",))
    whole = draw(dataset, figure(kind, variable="phi")).legends[0]
    assert "contact lost" not in [text.get_text() for text in whole.get_texts()]
    lost = np.full(dataset["status"].shape, "contact_lost", object)
    dataset["reason"] = data.flags(dataset["status"].dims, lost, [*REASON.codes])
    drawn = draw(dataset, figure(kind, variable="phi"))
    assert "contact lost" in [text.get_text() for text in drawn.legends[0].get_texts()]
    (end,) = [line for line in drawn.axes[0].lines if line.get_marker() == "X"]
    last = dataset.squeeze().isel(time=-1)
    assert end.get_xdata()[0] == (last["time"] if kind == "history" else last["phi"])
    part = draw(dataset, figure(kind, variable="phi", window=(0.0, 0.1))).legends[0]
    assert "contact lost" not in [text.get_text() for text in part.get_texts()]


@pytest.mark.parametrize("kind", ["history", "phase"])
def test_sticks_of_other_contacts_are_marked_where_no_panel_is_about_one(kind):
    dataset = data.history(labels=("far",))
    states = dataset["contact_state"].expand_dims(contact=[1, 2], axis=1).copy()
    held = [n for n, word in flag_names(states.attrs).items() if word == "stick"]
    states[:, 1] = held[0]
    dataset["contact_state"] = states
    told = {}
    for asked in (None, 1, 2, (1, 2)):
        settings = {} if asked is None else {"contact": [*np.atleast_1d(asked).tolist()]}
        (legend,) = draw(dataset, figure(kind, variable="phi", **settings)).legends
        told[asked] = [text.get_text() for text in legend.get_texts()]
    assert "contact 2 sticks" in told[None] and "contact 1 sticks" not in told[None]
    assert told[1, 2] == told[None]
    assert told[1] == told[None]
    assert "contact 1 sticks" in told[2] and "contact 2 sticks" not in told[2]
    if kind == "phase":  # files of other numbers of contacts
        three = dataset.reindex(contact=[1, 2, 3]).assign(
            contact_state=states.isel(contact=[0, 1, 1]).assign_coords(contact=[1, 2, 3])
        )
        one = data.history(labels=("near",))
        for files in ([one, dataset], [dataset, three], [three, dataset]):
            shown = draw([(f"{n}", part) for n, part in enumerate(files)], figure(kind))
            words_ = [text.get_text() for text in shown.legends[0].get_texts()]
            assert "contact 2 sticks" in words_
            assert any("stick on several contacts" in note for note in style.notes_on(shown))
            assert ("contact 3 sticks" in words_) == any(one is three for one in files)
    (ax,) = draw(dataset, figure(kind, variable="phi")).axes
    bars = [patch.get_extents().height / ax.bbox.height for patch in ax.patches]
    assert kind == "phase" or min(bars) < 0.05 < 0.9 < max(bars)  # across, one is seen


@pytest.mark.parametrize("kind", ["map", "curve"])
def test_of_several_contacts_a_figure_says_which_one_is_selected(kind):
    both = data.stability_map().rename(L_s="stick_fraction")
    both["stick_fraction"] = both["stick_fraction"].expand_dims(contact=[1, 2], axis=-1)
    asked = {"variable": "stick_fraction"} | ({"select": {"N0": 10.0}} if kind == "curve" else {})
    every, second = (
        draw(both, figure(kind, **asked | {"select": asked.get("select", {}) | chosen}))
        for chosen in ({}, {"contact": 2})
    )
    one = draw(both.isel(contact=[1]), figure(kind, **asked))  # of the model itself
    told = [drawn.get_suptitle().count("contact = 2") for drawn in (every, second, one)]
    assert told == [0, 1, 0]
    with pytest.raises(UsageError, match="contact = 7: not in this dataset\ncontact: 1, 2"):
        draw(both, figure(kind, variable="stick_fraction", select={"contact": 7}))


def of_two_contacts():
    """A motion on two contacts: 6 N of friction at the first, -1 N at the second."""
    dataset = data.history(labels=("far",))
    states = dataset["contact_state"].expand_dims(contact=[1, 2], axis=1)
    forces = dataset["F_T"].expand_dims(contact=[1, 2], axis=1).copy()
    forces[:, 1] = -1.0
    return dataset.assign(contact_state=states, F_T=forces)


FORCES = {"$F_T$ of contact 1 (N)": 6.0, "$F_T$ of contact 2 (N)": -1.0}


@pytest.mark.parametrize("asked", [{}, {"contact": [1, 2]}, {"contact": 2}, {"contact": [1]}])
def test_a_force_is_drawn_of_every_contact_that_is_not_left_out_each_by_its_name(asked):
    drawn = draw(of_two_contacts(), figure("history", variable=["phi", "F_T"], **asked))
    state, *of_contacts = drawn.axes
    found = {ax.get_ylabel(): ax.lines[0].get_ydata()[0] for ax in of_contacts}
    wanted = np.atleast_1d(asked.get("contact", [1, 2]))
    assert found == {word: force for word, force in FORCES.items() if int(word[-5]) in wanted}
    assert state.get_ylabel() == r"$\varphi$ (rad)"


@pytest.mark.parametrize("contact", [1, 2])
def test_a_loop_says_of_which_contact_its_force_is(contact):
    loop = figure("phase", x="phi", y="F_T", contact=contact)
    assert draw(of_two_contacts(), loop).axes[0].get_ylabel() == [*FORCES][contact - 1]
    lines = figure("spectrum", variable="F_T", select={"contact": contact})
    assert [*FORCES][contact - 1] in draw(of_two_contacts(), lines).axes[0].get_ylabel()


def test_what_a_law_holds_in_stick_is_named_in_its_loop():
    dataset = data.history(labels=("far",))
    dataset = dataset.rename(phi="slip", phi_dot="slip_dot")
    assert "held in stick" not in legend_texts(draw(dataset, figure("phase", y="F_T")))
    held = dataset.assign(static_capacity=0.4)
    drawn = draw(held, figure("phase", x="slip_dot", y="F_T"))
    assert marks(drawn.axes[0], "_held in stick").tolist() == [[0.0, -0.4], [0.0, 0.4]]
    assert "held in stick" in legend_texts(drawn)


def test_other_variables_of_a_history_can_be_asked_for():
    drawn = draw(data.history(), figure("history", variable=["F_T"], select={"initial": "far"}))
    assert drawn.axes[0].get_ylabel() == "$F_T$ (N)"
    with pytest.raises(UsageError, match="no variable over time"):
        draw(data.history(), figure("history", variable="status"))


def test_a_phase_portrait_is_coloured_by_contact_state_without_gaps():
    dataset = data.history(labels=("far",))
    drawn = draw(dataset, figure("phase"))
    (ax,) = drawn.axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\varphi$ (rad)", r"$\dot{\varphi}$ (rad/s)")
    collections = [c for c in ax.collections if isinstance(c, LineCollection)]
    segments = [segment for c in collections for segment in c.get_segments()]
    begins, ends = ({tuple(np.round(s[at], 12)) for s in segments} for at in (0, -1))
    assert len(begins ^ ends) == 2  # where the motion begins and ends; else one meets the next
    assert len({tuple(c.get_colors()[0]) for c in collections}) == 3
    assert legend_texts(drawn) == [SLIP_PLUS, SLIP_MINUS, "stick", "start"]


def sawtooth(sample):
    """A mass that is braked and driven in turn, from 0.5 s on each second: F_T is 3 N or -1 N."""
    time = np.arange(0.0, 5.0, sample)
    kicks = np.arange(0.5, 5.0)
    driven = np.searchsorted(kicks, time) % 2 == 1
    knots = np.append(0.0, kicks)
    pushes = np.where(np.arange(knots.size) % 2 == 1, 3.0, -1.0)
    speeds = np.append(0.0, np.cumsum(pushes[:-1] * np.diff(knots)))
    piece = np.searchsorted(kicks, time)
    since = time - knots[piece]
    ways = np.append(
        0.0, np.cumsum(speeds[:-1] * np.diff(knots) + 0.5 * pushes[:-1] * np.diff(knots) ** 2)
    )
    dataset = without_events(data.history(labels=("far",))).isel(time=slice(len(time)))
    states = np.where(driven, "slip+", "slip-")[None]
    found = dataset.assign_coords(time=("time", time)).assign(
        phi=(
            ("initial", "time"),
            (ways[piece] + speeds[piece] * since + 0.5 * pushes[piece] * since**2)[None],
        ),
        phi_dot=(("initial", "time"), (speeds[piece] + pushes[piece] * since)[None]),
        theta=(("initial", "time"), 0.0 * since[None]),
        theta_dot=(("initial", "time"), 0.0 * since[None]),
        F_T=(("initial", "time"), pushes[piece][None], {"units": "N"}),
        contact_state=data.flags(("initial", "time"), states, data.CONTACT_STATES),
        **data.ledger(time, states),
    )
    found["event_time"][:] = kicks
    return found, np.column_stack([ways[1:], speeds[1:]])


@pytest.mark.parametrize("sample", [0.09, 0.31])
def test_motions_are_drawn_through_the_instants_of_their_events(sample):
    """Jumps of the friction force stand upright there, and a phase portrait has its corners."""
    dataset, corners = sawtooth(sample)
    (ax,) = draw(dataset, figure("history", variable="F_T")).axes
    time, force = ax.lines[0].get_data()
    jumps = np.flatnonzero(np.diff(force))
    np.testing.assert_array_equal(time[jumps], time[jumps + 1])
    np.testing.assert_array_equal(time[jumps], np.arange(0.5, 5.0))
    (ax,) = draw(dataset, figure("phase")).axes
    segments = [s for c in ax.collections for s in c.get_segments()]
    ends = np.array(sorted((s[-1] for s in segments if len(s) > 2), key=lambda p: p[0]))
    for corner in corners:
        np.testing.assert_allclose(np.min(np.abs(ends - corner).max(axis=1)), 0.0, atol=1e-12)


def test_a_motion_of_whole_periods_ends_before_the_jump_at_its_end():
    """Its last sample is what comes after the event there, and looked like an artefact."""
    dataset, _ = sawtooth(0.1)
    cut = dataset.isel(time=slice(36)).copy(deep=True)
    cut["event_time"][3] = cut["time"][-1] - 1e-13
    before = float(cut["F_T"][0, -2])
    cut["F_T"][0, -1] = 2.0 - before  # 3 N and -1 N in turn
    (ax,) = draw(cut, figure("history", variable="F_T")).axes
    time, force = ax.lines[0].get_data()
    assert (time[-1], force[-1]) == (pytest.approx(3.5), before)
    earlier = cut.assign(event_time=cut["event_time"].copy())
    earlier["event_time"][3] -= 0.05  # within the motion
    (ax,) = draw(earlier, figure("history", variable="F_T")).axes
    assert ax.lines[0].get_ydata()[-1] == 2.0 - before


def test_a_jump_in_a_phase_portrait_is_of_neither_state_beside_it():
    """No slip has a force that it never has, and the head lies on no jump."""
    found, _ = sawtooth(0.09)
    (ax,) = draw(found, figure("phase", x="phi_dot", y="F_T")).axes
    parts = {str(c.get_label()): np.concatenate(c.get_segments()) for c in ax.collections}
    jumps = parts.pop("_jump")
    assert {*map(tuple, np.ptp(jumps.reshape(-1, 2, 2), axis=1))} == {(0.0, 4.0)}
    assert {name: {*points[:, 1]} for name, points in parts.items()} == {
        "slip+": {3.0},
        "slip-": {-1.0},
    }
    assert ax.texts[0].xyann[1] == ax.texts[0].xy[1]
    assert "jump" in legend_texts(ax.figure)
    smooth = draw(found, figure("phase"))
    assert "jump" not in legend_texts(smooth)


def test_motions_of_which_one_is_coarse_share_a_phase_portrait():
    coarse, fine = (sawtooth(sample)[0] for sample in (0.8, 0.09))
    for layers in ([("a", coarse), ("b", fine)], [("b", fine), ("a", coarse)]):
        drawn = draw(layers, figure("phase", x="phi_dot", y="F_T"))
        assert {"jump", SLIP_PLUS, SLIP_MINUS} <= {*legend_texts(drawn)}


def test_what_no_line_would_show_in_a_phase_portrait_is_a_dot():
    """One that lasts for a sample of hundreds."""
    found = data.history(labels=("far",))
    time = found["time"].values
    states = np.where(np.arange(time.size) == time.size // 2, "stick", "slip+")[None]
    for name in ("phi", "theta"):
        found[name] = found[name].copy(data=(time / time[-1])[None])
        found[f"{name}_dot"] = found[name].copy(data=np.full_like(time, 1.0 / time[-1])[None])
    found["contact_state"] = data.flags(("initial", "time"), states, data.CONTACT_STATES)
    found = found.drop_dims("event_obs").assign(data.ledger(time, states))
    drawn = draw(found, figure("phase", x="phi", y="theta"))
    (dot,) = (line for line in drawn.axes[0].lines if line.get_marker() == ".")
    assert dot.get_label().endswith("stick") and dot.get_xdata() == pytest.approx(0.5, abs=0.01)
    (legend,) = drawn.legends
    keys = {t.get_text(): h for t, h in zip(legend.get_texts(), legend.legend_handles, strict=True)}
    assert [keys[word].get_marker() for word in ("stick", SLIP_PLUS)] == [".", "None"]


def test_a_corner_without_a_sample_behind_it_is_as_what_is_before_leads_there():
    """Where a second event comes before the next sample."""
    time = np.arange(0.0, 2.05, 0.1)
    speed = np.minimum(time / 0.95, 1.0)
    found = xr.Dataset({"x": ("time", time), "x_dot": ("time", speed)}, {"time": time})
    events = (motion.Event(0.95, 1, "slip+", "stick"), motion.Event(0.97, 2, "slip+", "slip-"))
    drawn = motion.Motion("", time, found, events).drawn("x_dot", speed)
    np.testing.assert_allclose(drawn[10:14], 1.0, atol=1e-12)


def test_a_phase_portrait_points_in_the_direction_of_its_motion():
    found = without_events(data.history(labels=("far",)))
    (ax,) = draw(found, figure("phase")).axes
    (arrow,) = ax.texts
    (x, y), (next_x, _) = arrow.xyann, arrow.xy
    assert (next_x - x) * y > 0.0  # phi grows where its rate is above zero
    corners = np.concatenate([c.get_segments() for c in ax.collections if len(c.get_segments())])
    nearest = np.abs((corners.reshape(-1, 2) - arrow.xy) / np.ptp(corners, axis=(0, 1))).max(axis=1)
    assert nearest.min() < 0.01
    begun = found["time"] < 1.0
    resting = found.assign({name: found[name].where(begun, 0.0) for name in ("phi", "phi_dot")})
    (arrow,) = draw(resting, figure("phase")).axes[0].texts  # not where it rests
    assert np.abs(arrow.xyann / np.abs(corners).max(axis=(0, 1))).max() > 0.1


def test_motions_of_several_files_share_a_phase_portrait():
    """Each with a mark of its own, by the name of its file."""
    layers = [
        (name, data.history(labels=(label,))) for name, label in (("a", "far"), ("b", "near"))
    ]
    (ax,) = draw(layers, figure("phase")).axes
    assert [text for text in legend_texts(ax) if text.startswith("start: ")] == [
        "start: a",
        "start: b",
    ]
    unnamed = [(name, one.assign_attrs(called="")) for name, one in layers]
    (ax,) = draw(unnamed, figure("phase")).axes
    assert {"start: far", "start: near"} <= {*legend_texts(ax)}
    dashes = {
        line.get_linestyle()
        for line in ax.figure.legends[0].get_lines()
        if line.get_marker() in "os"
    }
    assert len(dashes) == 2
    settled = unnamed[0][1].assign_attrs(steady_state="unstable cycle", point="x, settled")
    for called, told in (("", "unstable cycle"), ("mine", "mine")):
        cycle = ("a", settled.assign_attrs(called=called))
        assert told in legend_texts(draw([cycle, unnamed[1]], figure("phase")).axes[0])
    reaches = [np.ptp(line.get_xydata()[:, 0]) for line in ax.lines]
    assert len(ax.texts) == 2 and len(reaches) >= 2
    with pytest.raises(UsageError, match="theta_dot: no variable over time"):
        lacking = data.history().drop_vars("theta_dot")
        draw([layers[0], ("c", lacking)], figure("phase", x="phi", y="theta_dot"))


def test_histories_that_have_no_room_side_by_side_stand_below():
    """Each motion with all its variables; empty places stay empty."""
    found = without_events(data.history()).isel(initial=[0, 1, 0])
    found["initial"] = ["start-0", "start-1", "start-2"]
    drawn = draw(found, figure("history", variable=["phi", "theta"]), look=look_of("paper", 84.0))
    titled = [ax.get_title() for ax in drawn.axes]
    assert titled == ["start-0", "start-1", "", "", "start-2", "", "", ""]
    assert [ax.axison for ax in drawn.axes] == [True] * 5 + [False, True, False]
    resting = data.history(labels=("far",))
    for name in ("phi", "phi_dot", "theta", "theta_dot"):
        resting[name] = 0.0 * resting[name] + (1e-17 if name.endswith("_dot") else 0.02)
    (ax,) = draw(resting, figure("history", variable="phi_dot")).axes
    assert not ax.lines[0].get_ydata().any()  # what it has is rounding


@pytest.mark.parametrize("turn", [0.0, 1.5 * np.pi])
def test_the_arrow_of_a_phase_portrait_does_not_hide_its_start(turn):
    """It stands on the straight part of the curve, that of stick, beside where that begins."""
    found = without_events(data.history(labels=("far",)))
    angle = 9.0 * found["time"] + turn
    rate = np.minimum(-0.09 * np.sin(angle), 0.05)
    phi = 0.02 + 0.01 * np.cos(angle)
    found["phi"], found["phi_dot"] = (
        found[name].copy(data=one.values[None]) for name, one in (("phi", phi), ("phi_dot", rate))
    )
    (arrow,) = draw(found, figure("phase")).axes[0].texts
    middle = 0.5 * (np.array(arrow.xyann) + arrow.xy)
    start = np.array([phi.isel(time=0), rate.isel(time=0)])
    assert np.linalg.norm((middle - start) / [0.02, 0.14]) > 0.1
    assert middle[1] == pytest.approx(0.05, abs=1e-3)


def test_the_arrow_of_a_phase_portrait_does_not_hide_a_short_stick():
    found = data.history(labels=("far",))
    angle = 9.0 * found["time"].values
    short = (np.sin(angle) > 0.995)[None]
    states = np.where(short, "stick", "slip+")
    found["phi_dot"] = found["phi_dot"].copy(data=np.minimum(-0.09 * np.sin(angle), 0.08)[None])
    found["contact_state"] = data.flags(("initial", "time"), states, data.CONTACT_STATES)
    found = found.drop_dims("event_obs").assign(data.ledger(found["time"].values, states))
    (ax,) = draw(found, figure("phase")).axes
    stick = next(one for one in ax.collections if one.get_label().endswith("stick"))
    places = np.concatenate(stick.get_segments())
    (arrow,) = ax.texts
    middle = 0.5 * (np.array(arrow.xyann) + arrow.xy)
    assert np.linalg.norm((middle - places) / [0.02, 0.17], axis=1).min() > 0.1


@pytest.mark.parametrize(
    ("periods", "log", "lines"), [(3.0, "", 2), (3.0, "y", 3), (2.9, "", None)]
)
def test_of_whole_periods_a_spectrum_has_upright_lines_at_their_harmonics(periods, log, lines):
    """At 2, 6 and 10 Hz, the last too small to be seen but on a logarithmic axis."""
    time = np.linspace(0.0, periods / 2.0, 601)
    angle = 4.0 * np.pi * time
    values = np.sin(angle) + 0.2 * np.cos(3.0 * angle) + 1e-4 * np.sin(5.0 * angle)
    found = without_events(data.history(labels=("far",))).isel(time=slice(601))
    found = found.assign_coords(time=("time", time, found["time"].attrs))
    for name in ("phi", "theta"):
        rates = np.gradient(values, time)
        rates[-1] = rates[0]
        for of, its in (("", values), ("_dot", rates)):
            found[name + of].values[:] = its if found[name + of].ndim == 1 else its[None]
    (ax,) = draw(found, figure("spectrum", variable="phi", **({"log": log} if log else {}))).axes
    (line,) = ax.lines
    x, height = line.get_data()
    top, (_, right) = height[np.isfinite(height)].max(), ax.get_xlim()
    if lines is None:
        assert x.size == 301 and right < 10.0
        return
    seen = height > top * (1e-6 if log else 1e-3)
    np.testing.assert_allclose(x[seen], [2.0, 6.0, 10.0][:lines])
    np.testing.assert_allclose(height[seen], [1.0, 0.2, 1e-4][:lines], rtol=1e-9)
    assert right == pytest.approx(1.05 * x[seen].max())
    assert not log or ax.get_ylim()[0] == pytest.approx(1e-5 * top)  # a decade below the least
    (both,) = draw(found, figure("spectrum", variable=["phi", "theta"])).axes
    assert both.get_ylim()[1] == pytest.approx(1.05)
    wide = figure("spectrum", variable=["phi", "theta"], xlim=[0.0, 200.0])
    note, _ = style.notes_on(draw(found, wide, look=look_of("paper", width=84.0)))
    assert note.startswith("lines of 2 spectra stand side by side, here up to 0.")
    assert style.notes_on(both.figure) == []  # of 10 Hz
    for look in ("screen", "paper", "talk"):
        asked = figure("spectrum", variable=["phi", "theta"])
        (both,) = draw(found, asked, look=look_of(look)).axes
        x, _ = np.transpose([line.get_transform().transform((2.0, 0.5)) for line in both.lines])
        wide = both.lines[0].get_linewidth() / 72.0 * both.figure.dpi
        assert x[1] - x[0] > wide  # one does not hide the other
    rows = [*csv.DictReader(as_csv(both.figure, Path("a.csv")).splitlines())]
    told = np.array([[float(row["x"]), float(row["y"])] for row in rows])
    heights = [line.get_ydata()[1::3] for line in both.lines]
    np.testing.assert_array_equal(told[:, 1], np.concatenate(heights))  # and not one of their feet
    np.testing.assert_allclose(told[told[:, 1] > 0.1 * top, 0], [2.0, 6.0] * 2)


def test_spectra_of_each_unit_have_a_panel():
    """Radians and newtons shared an axis, on which the angle was a speck at the origin."""
    found = data.history(labels=("far",))
    drawn = draw(found, figure("spectrum", variable=["phi", "F_T", "theta"]))
    assert [len(ax.lines) for ax in drawn.axes] == [2, 1]
    assert drawn.axes[0].get_ylabel() == "amplitude ($10^{-3}$ rad)"
    assert drawn.axes[1].get_ylabel().startswith("amplitude of $F_T$")
    assert drawn.axes[0].get_xlim() == drawn.axes[1].get_xlim()


def test_a_spectrogram_of_a_motion_ends_where_nothing_is_seen_any_more():
    found = data.history(labels=("far",))
    drawn = draw(found, figure("spectrogram", variable="phi"))
    mesh, (_, top) = drawn.axes[0].collections[0], drawn.axes[0].get_ylim()
    heights = mesh.get_coordinates()[:-1, 0, 1]
    seen = (mesh.get_array() > mesh.norm.vmin).any(axis=1)
    assert seen.any() and not seen[heights > top].any()
    given = draw(found, figure("spectrogram", variable="phi", ylim=[0.0, 40.0]))
    assert given.axes[0].get_ylim() == (0.0, 40.0)


def test_the_spectrum_of_what_jumps_between_samples_knows_where():
    """A square wave, 1 for 0.3037 of its period and 0 else: |c_n| = |sin(0.3037 n pi)| / (n pi)."""
    share, first, count = 0.3037, 0.2218, 100
    time = np.arange(count + 1) / count
    values = (((time - first) % 1.0) < share).astype(float)
    edges = np.array([first, first + share])
    _, whole = amplitude_spectrum(time, values, True, (edges, np.array([1.0, -1.0])))
    numbers = np.arange(1, 11)
    known = 2.0 * np.abs(np.sin(np.pi * share * numbers)) / (np.pi * numbers)
    np.testing.assert_allclose(whole[1:11], known, rtol=1e-12)
    _, sampled = amplitude_spectrum(time, values, True)
    assert np.abs(sampled[1:11] / known - 1.0).max() > 0.01


def test_a_phase_portrait_of_other_states():
    (ax,) = draw(data.history(labels=("far",)), figure("phase", x="theta", y="phi")).axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\theta$ (rad)", r"$\varphi$ (rad)")


def test_motions_may_share_one_phase_portrait():
    drawn = draw(data.history(), figure("phase", overlay=True))
    (ax,) = drawn.axes
    marks = {line.get_label(): (line.get_marker(), line.get_xydata().tolist()) for line in ax.lines}
    assert [marker for marker, _ in marks.values()] == ["o", "s"]
    assert legend_texts(drawn)[-2:] == ["start: far", "start: near"]
    assert ax.get_title() == ""


def test_a_motion_at_rest_is_a_mark_in_its_phase_portrait():
    """Not a line through the last digits of what it would be."""
    found = without_events(data.history(labels=("far",)))
    digits = 1e-17 * np.arange(found.sizes["time"])
    still = {name: 0.0 * found[name] + 1.0 for name in ("phi", "theta")}
    moving = dict.fromkeys(("phi_dot", "theta_dot"), 0.0 * found["phi"] + digits)
    drawn = draw(found.assign(still | moving), figure("phase"))
    (ax,) = drawn.axes
    (mark,) = ax.lines
    assert mark.get_xydata().tolist() == [[1.0, 0.0]] and not ax.collections
    assert legend_texts(drawn)[-1] == "at rest"


@pytest.mark.parametrize("kind", ["phase", "history"])
def test_a_window_of_time_is_all_that_is_drawn(kind):
    dataset = data.history(labels=("far",))
    drawn = draw(dataset, figure(kind, window=[2.0, "3 s"], variable="phi"))
    (ax,) = drawn.axes
    if kind == "history":
        (line,) = ax.lines
        assert (line.get_xdata().min(), line.get_xdata().max()) == pytest.approx((2.0, 3.0))
    else:
        assert not ax.lines  # a window has no start
        assert "start" not in legend_texts(drawn)


def test_motions_need_a_history_and_a_choice():
    for kind in ("history", "phase", "spectrum", "spectrogram"):
        with pytest.raises(UsageError, match="no motion"):
            draw(data.bifurcation(), figure(kind))
    many = xr.concat(
        [
            without_events(data.history()).assign_coords(initial=[f"{n}-a", f"{n}-b"])
            for n in range(3)
        ],
        "initial",
        data_vars="minimal",
    )
    with pytest.raises(UsageError, match="choose from initial"):
        draw(many, figure("phase"))
    with pytest.raises(UsageError, match="next: fiv history CASE --at"):
        draw(data.bifurcation(), figure("spectrum", variable=["F_N", "F_T"]))


@pytest.mark.parametrize(("share", "ranges"), [(0.5, 1), (0.01, 2)])
def test_forces_of_two_contacts_have_one_range_where_none_is_flat_in_it(share, ranges):
    found = of_two_contacts()
    wave = np.sin(np.arange(found.sizes["time"]))
    forces = found["F_T"].transpose("initial", "contact", "time").copy()
    forces[:] = np.stack([wave, share * wave])
    drawn = draw(found.assign(F_T=forces), figure("history", variable="F_T"))
    assert len({ax.get_ylim() for ax in drawn.axes}) == ranges
    notes = [note for note in style.notes_on(drawn) if "range of its own" in note]
    assert len(notes) == ranges - 1
    assert drawn.legends[0].get_title().get_text() == "colours: the contact of each panel"
    called = [one.assign_attrs(called=name) for name, one in
              (("a", found.assign(F_T=forces)), ("b", found.assign(F_T=0.8 * forces)))]  # fmt: skip
    drawn = draw([("a", called[0]), ("b", called[1])], figure("history", variable="F_T"))
    assert len({ax.get_ylim() for ax in drawn.axes}) == ranges  # of each contact one, at least
    notes = [note for note in style.notes_on(drawn) if "range of its own" in note]
    assert [note.startswith("F_T: each contact has") for note in notes] == [True] * (ranges - 1)
    constant = draw(found.assign(F_T=0.0 * forces + 6.0), figure("history", variable="F_T"))
    assert not [note for note in style.notes_on(constant) if "range of its own" in note]


def test_motions_of_several_files_stand_side_by_side_in_a_history():
    """Each by its start, or as a cycle, stable or not; with a range for all."""
    far, near = (data.history(labels=(label,)).assign_attrs(called="") for label in ("far", "near"))
    cycle = near.assign_attrs(steady_state="unstable cycle", point="v=1, settled")
    drawn = draw([("a", far), ("b", cycle)], figure("history", variable="phi"))
    assert [ax.get_title() for ax in drawn.axes] == ["far", "unstable cycle"]
    assert len({ax.get_ylim() for ax in drawn.axes}) == 1
    assert not [note for note in style.notes_on(drawn) if "range of its own" in note]
    flat = cycle.assign(phi=1e-3 * cycle["phi"])
    apart = draw([("a", far), ("b", flat)], figure("history", variable="phi"))
    assert len({ax.get_ylim() for ax in apart.axes}) == 2
    (note,) = [note for note in style.notes_on(apart) if "range of its own" in note]
    (both,) = re.findall(r"ylim = (\[.*?\])", note)
    asked = figure("history", variable="phi", ylim=json.loads(both))
    alike = draw([("a", far), ("b", flat)], asked)
    assert len({ax.get_ylim() for ax in alike.axes}) == 1 and not style.notes_on(alike)
    (phase,) = draw([("a", far), ("b", cycle)], figure("phase")).axes
    assert {"start: far", "unstable cycle"} <= {*legend_texts(phase)}
    many = [(f"{n}", far) for n in range(6)]  # more than stand side by side
    several = draw(many, figure("history", variable="phi")).axes
    assert len({round(ax.get_position().y0, 2) for ax in several}) == 2
    lacking = near.drop_vars("theta_dot")
    with pytest.raises(UsageError, match="theta_dot: no variable over time"):
        draw([("a", far), ("b", lacking)], figure("history", variable="theta_dot"))


@pytest.mark.parametrize("amplitude", [0.3, 2.0])
def test_a_sine_shows_its_amplitude_at_its_frequency(amplitude):
    time = np.append(np.arange(0.0, 4.0, 0.005), 4.0021)
    frequency, height = amplitude_spectrum(time, 7.0 + amplitude * np.sin(2 * np.pi * 12.5 * time))
    assert frequency[np.argmax(height)] == pytest.approx(12.5)
    assert height.max() == pytest.approx(amplitude, rel=1e-6)


def test_a_spectrum_refuses_samples_that_are_not_uniform():
    with pytest.raises(UsageError, match="equal intervals"):
        amplitude_spectrum(np.linspace(0.0, 1.0, 50) ** 2, np.zeros(50))
    with pytest.raises(UsageError, match="16 samples"):
        amplitude_spectrum(np.linspace(0.0, 1.0, 8), np.zeros(8))


@pytest.mark.parametrize(
    ("unit", "label", "peak"),
    [("Hz", "$f$ (Hz)", 9 / (2 * np.pi)), ("rad/s", r"$\omega$ (rad/s)", 9)],
)
def test_a_spectrum_is_in_the_unit_asked_for(unit, label, peak):
    (ax,) = draw(data.history(labels=("far",)), figure("spectrum", unit=unit, variable="phi")).axes
    x, y = ax.lines[0].get_data()
    assert ax.get_xlabel() == label
    assert x[np.argmax(y)] == pytest.approx(peak, abs=x[1])
    assert ax.get_ylabel() == r"amplitude of $\varphi$ ($10^{-3}$ rad)"


def test_spectra_along_a_parameter_are_colours_with_dots_at_growing_modes():
    drawn = draw(data.spectra(), figure("spectrum"))
    near, far = drawn.axes[:2]
    assert (near.get_title(), far.get_title()) == ("near", "far")
    (mesh,) = [c for c in far.collections if isinstance(c, QuadMesh)]
    cells = mesh.get_array().reshape(81, 12)
    np.testing.assert_allclose(cells[50], 1e-3 * np.linspace(0.1, 1.2, 12))
    assert np.all(cells[0] == pytest.approx(1.2e-6))  # nothing: three decades below the largest
    dots = np.concatenate([line.get_xydata() for line in far.lines])
    dots = dots[np.isfinite(dots[:, 1])]
    np.testing.assert_allclose(dots[:, 1], 20.0 + dots[:, 0])
    assert len(dots) == np.count_nonzero(np.linspace(0.1, 1.2, 12) > 0.5)


def test_a_motion_without_bound_leaves_its_column_hatched_and_named():
    drawn = draw(data.spectra(), figure("spectrum", select={"initial": "near"}))
    (mesh,) = [c for c in drawn.axes[0].collections if isinstance(c, QuadMesh)]
    assert np.ma.getmaskarray(mesh.get_array()).reshape(81, 12)[:, -1].all()
    assert drawn.axes[0].patch.get_hatch()
    assert legend_texts(drawn) == ["unstable eigenfrequency", "diverged"]


@pytest.mark.parametrize(("unit", "factor"), [("Hz", 1.0), ("rad/s", 2 * np.pi)])
def test_a_single_spectrum_is_a_line_with_growing_modes_upright(unit, factor):
    (ax,) = draw(
        data.spectra(), figure("spectrum", select={"mu_k": 0.9, "initial": "far"}, unit=unit)
    ).axes
    x, y = ax.lines[0].get_data()
    assert x[np.argmax(y)] == pytest.approx(25.0 * factor)
    (upright,) = [line for line in ax.lines if line.get_label() == "unstable eigenfrequency"]
    assert upright.get_xdata()[0] == pytest.approx(20.9 * factor)
    assert ax.get_ylabel() == "amplitude of $x$ ($10^{-4}$ m)"


def test_harmonics_of_a_period_stand_where_they_are_and_not_in_the_middle_of_an_interval():
    one = data.spectra().isel(mu_k=[5]).sel(initial=["far"])
    raster = float(one["frequency"][1])
    heights = np.zeros(one["frequency"].size)
    heights[[30, 59]] = 2e-3, 1e-3
    one["amplitude"].values[...] = heights.reshape(one["amplitude"].shape)
    whole = draw(one, figure("spectrum")).axes[0].lines[0].get_xdata()
    assert whole.size == heights.size
    basic = 29.7 * raster
    one["period"] = one["status"] * 0.0 + 1.0 / basic
    x, y = draw(one, figure("spectrum")).axes[0].lines[0].get_data()
    np.testing.assert_allclose(x, np.repeat([basic, 2 * basic], 3))
    (word,) = draw(one, figure("spectrum", unit="rad/s")).axes[0].texts
    assert word.get_text() == rf"$\omega_1$ = {2 * np.pi * basic:.4g} rad/s"
    assert word.xy == pytest.approx((2 * np.pi * basic, 2e-3))
    for log in (False, "y"):  # it stands within the panel
        drawn = draw(one, figure("spectrum", log=log), look=look_of("paper", width=84.0))
        drawn.draw_without_rendering()
        (ax,) = drawn.axes
        assert ax.texts[0].get_window_extent().y1 <= ax.bbox.y1 + 1.0
    np.testing.assert_array_equal(y, [0.0, 2e-3, np.nan, 0.0, 1e-3, np.nan])
    one["period"] = one["period"] * 0.0 + 2.0 / raster  # several harmonics in each interval
    assert draw(one, figure("spectrum")).axes[0].lines[0].get_xdata().size == heights.size


@pytest.mark.parametrize("width", [84.0, 88.0, 92.0, 96.0])
@pytest.mark.parametrize("ends", [(-0.0055, 0.0125), (-0.0061, 0.0131)])
def test_ticks_along_x_leave_each_other_room_however_long_they_are(width, ends):
    motion = data.history(labels=("far",))
    low, high = motion["phi"].min(), motion["phi"].max()
    motion["phi"] = ends[0] + (ends[1] - ends[0]) * (motion["phi"] - low) / (high - low)
    drawn = draw(motion, figure("phase"), look=look_of("paper", width=width))
    drawn.draw_without_rendering()
    (ax,) = drawn.axes
    boxes = [label.get_window_extent() for label in ax.get_xticklabels()]
    seen = [box for box in boxes if ax.bbox.x0 <= 0.5 * (box.x0 + box.x1) <= ax.bbox.x1]
    gaps = [after.x0 - before.x1 for before, after in pairwise(seen)]
    assert len(gaps) > 1 and min(gaps) > 0.3 * seen[0].height


def test_upright_lines_stand_aside_of_one_another_alone():
    """Beside the spectrum of a chaotic motion those of a period stood 4 % off their frequency."""
    frequency = np.array([1.0, 2.0, 3.0])
    lines, curve = spectrum.upright(frequency, frequency), (frequency, frequency)
    for spectra, is_moved in (([lines, curve], False), ([lines, curve, lines], True)):
        ax = Figure().add_subplot(xlim=(0.0, 4.0))
        spectrum._plot_among(ax, 0, spectra)
        (line,) = ax.lines
        place, there = (of.transform((1.0, 0.0)) for of in (line.get_transform(), ax.transData))
        assert (place[0] != pytest.approx(there[0])) == is_moved
