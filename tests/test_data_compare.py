"""Comparison of datasets: each kind of difference is found, and only those that count."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from fiv_cli.errors import InputError, UsageError
from fiv_cli.flags import ATTRACTOR, STATUS
from fiv_cli.reading import select
from fiv_cli.reading.causes import causes
from fiv_cli.reading.compare import (
    Difference,
    Tolerance,
    Tolerances,
    compare,
    count_filled,
    read_tolerances,
)

PERIODIC, CHAOTIC = ATTRACTOR.codes["periodic"], ATTRACTOR.codes["chaotic"]


def dataset() -> xr.Dataset:
    """Three periodic points and a chaotic one."""
    flags = {
        "flag_values": np.int8([0, 1, 2, 3]),
        "flag_meanings": "equilibrium periodic x chaotic",
    }
    attractor = np.array([[PERIODIC, PERIODIC], [PERIODIC, CHAOTIC]], np.int8)
    dims = ("mu_k", "initial")
    return xr.Dataset(
        {
            "status": (dims, np.zeros((2, 2), np.int8), {"units": "1"}),
            "attractor": (dims, attractor, {"units": "1", **flags}),
            "L_s": (dims, np.array([[1.0, 2.0], [3.0, 4.0]]), {"units": "m2"}),
            "period": (dims, np.array([[1.0, 2.0], [np.nan, np.nan]]), {"units": "s"}),
            "n_steps": (dims, np.full((2, 2), 7.0), {"units": "1"}),
            "section_value": ("section_obs", np.arange(6.0), {"units": "m"}),
            "section_row_size": (
                dims,
                np.array([[1, 2], [0, 3]], np.int32),
                {"units": "1", "sample_dimension": "section_obs"},
            ),
        },
        coords={"mu_k": ("mu_k", [0.1, 0.2]), "initial": ("initial", ["near", "far"])},
    )


def differences(
    right: xr.Dataset, tolerances: Tolerances | None = None, left: xr.Dataset | None = None
) -> list[Difference]:
    """Differences of `right` from `dataset`."""
    return compare({"": left or dataset()}, {"": right}, tolerances or Tolerances())


def refined() -> xr.Dataset:
    """The same, of which one point was filled in, not run."""
    found = dataset().assign_attrs(refined_of="attractor")
    flags = {"flag_values": np.int8([0, 3]), "flag_meanings": "run filled_in", "units": "1"}
    found["computed"] = (("mu_k", "initial"), np.int8([[0, 3], [0, 0]]), flags)
    found["status"].values[0, 1] = 1
    found["L_s"].values[0, 1] = found["period"].values[0, 1] = np.nan
    found["section_row_size"].values[0, 1] = 0
    kept = np.isin(np.arange(6), (1, 2), invert=True)
    return found.isel(section_obs=kept)


def test_what_a_refined_map_filled_in_is_compared_by_its_class_alone() -> None:
    """A map and the same refined were told to differ in every variable; that no class does, was
    not said."""
    assert differences(dataset(), left=refined()) == []
    assert differences(refined()) == differences(refined(), left=refined()) == []
    assert count_filled({"": refined()}, {"": dataset()}) == 1
    named = dataset().assign_attrs(analyses_json='{"r": {}}')
    alone = refined().assign_attrs(analyses_json='{"r": {}}')
    assert count_filled({"": alone}, {"r": named}) == 1
    other = refined()
    other["attractor"].values[0, 1] = CHAOTIC
    (found,) = differences(other)
    assert found.what == "attractor" and found.count == 1
    (found,) = differences(changed("L_s", (0, 0), 9.0), left=refined())
    assert found.what == "L_s" and found.count == 1


def changed(name: str, index: tuple[int, ...], value: float) -> xr.Dataset:
    """`dataset` with one value changed."""
    result = dataset()
    result[name].values[index] = value
    return result


def test_a_dataset_agrees_with_itself() -> None:
    assert differences(dataset()) == []


def test_a_number_that_differs_is_named_with_its_place() -> None:
    (found,) = differences(changed("L_s", (0, 1), 2.001))
    assert (found.what, found.count) == ("L_s", 1)
    assert "2 against 2.001 at mu_k=0.1, initial=far" in found.text


def test_numbers_that_differ_in_their_last_digits_have_all_of_them() -> None:
    exact = Tolerances(default=Tolerance(0.0, 0.0))
    (found,) = differences(changed("L_s", (0, 1), 2.0 + 2**-50), exact)
    assert found.text.startswith("2 against 2.0000000000000009 at")


def test_a_number_that_differs_has_its_error() -> None:
    left, right = (
        xr.Dataset(
            {"status": ("v", [0]), "boundary": ("v", [x]), "boundary_error": ("v", [1.2e-3])}
        )
        for x in (6.0, 6.5)
    )
    found = {one.what: one.text for one in differences(right, left=left)}
    assert found["boundary"] == "6 ± 0.0012 against 6.5 ± 0.0012 at the only point"


def test_a_coordinate_that_differs_hides_nothing_that_lies_elsewhere() -> None:
    left = dataset().assign(reference=("state", [1.0]))
    right = changed("L_s", (0, 1), 2.001).assign(reference=("state", [2.0, np.nan]))
    left, right = left.assign_coords(state=["x"]), right.assign_coords(state=["x", "x_dot"])
    assert [one.what for one in differences(right, left=left)] == ["state", "L_s"]
    elsewhere = changed("L_s", (0, 1), 2.001).assign_coords(mu_k=[0.3, 0.4])
    (found,) = differences(elsewhere)
    assert (found.what, found.count) == ("mu_k", 2)
    assert "what lies along it is not compared" in found.text


def test_points_that_both_have_are_compared() -> None:
    """By the values of axes, not by the places of points; values at a section follow them."""
    part = select.subset(dataset(), {"mu_k": 0.1})
    axes = "2 against 1 values, 1 of them in both and compared"
    assert [(one.what, one.text) for one in differences(part)] == [("mu_k", axes)]
    part["L_s"].values[0, 1] += 1.0
    part["section_value"].values[2] = 2.5
    told = [one.text for one in differences(part)]
    assert told == [axes, "2 against 3 at initial=far", "2 against 2.5 at initial=far"]


def test_an_axis_of_one_value_is_like_a_parameter() -> None:
    left, right = (dataset().isel(mu_k=[0], section_obs=[0, 1, 2]) for _ in range(2))
    right = right.assign_coords(mu_k=[0.4])
    right["L_s"].values[0, 0] = 5.0
    axis, number = differences(right, left=left)
    assert (axis.what, axis.text) == ("mu_k", "0.1 against 0.4")
    assert "1 against 5 at initial=near" in number.text


def test_datasets_over_other_axes_are_not_compared() -> None:
    (told,) = differences(dataset().rename(mu_k="N0"))
    assert told.text == "other axes, mu_k, initial against N0, initial: no point is compared"


def test_an_axis_from_another_formula_is_the_same() -> None:
    """0.3 and 3 * 0.1 are neighbouring numbers."""
    left, right = (dataset().assign_coords(mu_k=[0.1, end]) for end in (0.3, 3 * 0.1))
    right["L_s"].values[1, 0] = 4.0
    axis, number = differences(right, left=left)
    assert axis.text == "2 against 2 values, 2 of them in both and compared"
    assert "3 against 4 at mu_k=0.3" in number.text


def test_the_worst_offender_is_shown() -> None:
    right = changed("L_s", (0, 1), 2.001)
    right["L_s"].values[1, 0] = 4.0
    (found,) = differences(right)
    assert found.count == 2
    assert "3 against 4 at mu_k=0.2, initial=near" in found.text


@pytest.mark.parametrize(("kind", "told"), [("random", True), ("state", False)])
def test_random_starts_that_are_others_are_told(kind: str, told: bool) -> None:
    starts = json.dumps({"far": kind})
    labels = {"initial": ["far-000", "far-001"], "state": ["x"]}
    places = xr.DataArray([[[0.1], [0.2]]] * 2, dims=("mu_k", "initial", "state"))
    one = dataset().assign(initial_state=places).assign_coords(labels)
    one = one.assign_attrs(starts_json=starts)
    assert differences(one, left=one) == []
    found = differences(one.assign(initial_state=places + 0.3), left=one)
    assert [one.what for one in found] == ["initial"] * told + ["initial_state"]
    assert not told or "drawn anew" in found[0].text


def test_axes_in_another_order_are_one_difference() -> None:
    """By place every point would be another."""
    other = dataset()
    dims = [str(dim) for dim in other["status"].dims]
    (told,) = differences(other.transpose(*reversed(dims), ...))
    assert "in another order, " in told.text and ", ".join(dims) in told.text


def test_two_ulp_are_no_difference() -> None:
    right = dataset()
    right["L_s"] = right["L_s"].copy(data=np.nextafter(np.nextafter(right["L_s"], 9.0), 9.0))
    assert differences(right) == []


def test_a_tolerance_of_its_own() -> None:
    right = changed("L_s", (0, 1), 2.001)
    assert differences(right, Tolerances(variables={"L_s": Tolerance(rtol=1e-3)})) == []
    assert differences(right, Tolerances(ignore=("L_s",))) == []
    assert differences(right, Tolerances(default=Tolerance(rtol=1e-4)))


def test_a_number_against_nan_is_a_difference() -> None:
    assert [d.what for d in differences(changed("period", (1, 0), 1.0))] == ["period"]
    assert [d.what for d in differences(changed("period", (0, 0), np.nan))] == ["period"]


def test_infinities_agree_with_themselves_only() -> None:
    left = changed("period", (0, 0), np.inf)
    assert differences(changed("period", (0, 0), np.inf), left=left) == []
    for value in (-np.inf, np.nan, 1.0):
        assert [d.what for d in differences(changed("period", (0, 0), value), left=left)]


def test_a_single_point_without_dims() -> None:
    one = xr.Dataset({"L_s": ((), 1.0, {"units": "m2"})})
    other = xr.Dataset({"L_s": ((), 2.0, {"units": "m2"})})
    assert differences(one, left=one) == []
    assert "1 against 2 at the only point" in differences(other, left=one)[0].text


def test_status_and_class_are_exact() -> None:
    (found,) = differences(changed("status", (1, 1), STATUS.codes["failed"]))
    assert found.what == "status"
    (found,) = differences(changed("attractor", (0, 0), CHAOTIC))
    assert found.text == "periodic -> chaotic 1 at initial = near, mu_k = 0.1"


def test_what_class_the_motion_is_of_comes_first_whatever_the_analysis_is_called() -> None:
    left = {name: dataset() for name in ("eigenvalues", "response")}
    right = {name: changed("L_s", (0, 1), 9.0) for name in left}
    right["eigenvalues"]["status"].values[0, 0] = STATUS.codes["failed"]
    right["response"]["attractor"].values[0, 0] = CHAOTIC
    first, second, *rest = (one.what for one in compare(left, right, Tolerances()))
    assert (first, second) == ("response/attractor", "eigenvalues/status")
    assert rest == ["eigenvalues/L_s", "response/L_s"]


def test_classes_that_became_others_are_counted_and_numbers_compared_where_they_did_not() -> None:
    right = changed("L_s", (0, 1), 2.001)
    right["attractor"].values[:] = [[0, 0], [0, 1]]
    right["L_s"].values[1, 0] = 99.0
    (found,) = differences(right)
    assert (found.what, found.count) == ("attractor", 4)
    rest, other = found.changes
    assert (rest.first, rest.second, rest.count) == ("periodic", "equilibrium", 3)
    assert rest.places == ("initial = near, mu_k = 0.1 to 0.2", "initial = far, mu_k = 0.1")
    assert (other.first, other.second, other.count) == ("chaotic", "periodic", 1)
    names = [one.what for one in differences(right, Tolerances(ignore=("attractor",)))]
    assert names == ["L_s"], "who asks for no classes gets every number"


def test_chaotic_points_are_compared_by_statistics_only() -> None:
    assert differences(changed("L_s", (1, 1), 4.2)) == []
    assert [d.what for d in differences(changed("L_s", (1, 1), 5.0))] == ["L_s"]
    assert differences(changed("period", (1, 1), 3.0)) == []
    assert differences(changed("section_value", (4,), 99.0)) == []


@pytest.mark.parametrize(("error", "same"), [(0.2, True), (0.1, False), (np.nan, False)])
def test_chaos_agrees_within_what_its_window_leaves_open(error: float, same: bool) -> None:
    """4 against 5, beyond the tenth, where both tell a standard error."""
    sides = [
        one.assign(L_s_standard_error=one["L_s"] * 0.0 + error)
        for one in (dataset(), changed("L_s", (1, 1), 5.0))
    ]
    assert (differences(sides[1], left=sides[0]) == []) is same
    strict = Tolerances(standard_errors=0.0)  # of a file, and of regression sweeps
    assert [one.what for one in differences(sides[1], strict, left=sides[0])] == ["L_s"]
    periodic = changed("L_s", (0, 0), 1.01).assign(L_s_standard_error=sides[0].L_s_standard_error)
    assert [one.what for one in differences(periodic, left=sides[0])] == ["L_s"]


def test_what_lies_before_the_next_value_is_not_compared_where_that_is_another() -> None:
    along = {"units": "1", "along": "mu_k"}
    sides = [
        dataset().assign(coupling_point=(("mu_k", "initial"), [[first] * 2, [0.2] * 2], along))
        for first in (0.05, 0.08)
    ]
    assert [one.what for one in differences(sides[1], left=sides[0])] == ["coupling_point"]
    assert [one.what for one in differences(sides[1].isel(mu_k=[0]), left=sides[0])] == ["mu_k"]


def test_a_small_L_s_is_no_share_of_one() -> None:
    """Shares of time may differ by 0.02 as well as by a tenth; a vibration of 1e-4 m2 may not."""
    weak, strong = (
        dataset().assign(L_s=dataset()["L_s"] * size, slip_fraction=dataset()["L_s"] * size)
        for size in (1e-4, 1.2e-4)
    )
    for one in (weak, strong):
        one["attractor"].values[:] = CHAOTIC
        one["slip_fraction"].attrs["units"] = "1"
    found = differences(strong, left=weak)
    assert [(one.what, one.count) for one in found] == [("L_s", 4)]


def test_work_is_compared_only_when_asked() -> None:
    right = changed("n_steps", (0, 0), 8.0)
    assert differences(right) == []
    asked = Tolerances(variables={"n_steps": Tolerance(0.0, 0.0)})
    assert [d.what for d in differences(right, asked)] == ["n_steps"]


def test_rows_of_ragged_arrays() -> None:
    (found,) = differences(changed("section_value", (2,), 2.5))
    assert "2 against 2.5 at mu_k=0.1, initial=far" in found.text
    right = dataset()
    right["section_row_size"].values[:] = [[2, 1], [0, 3]]
    (found,) = differences(right)
    assert "1 against 2 values at mu_k=0.1, initial=near" in found.text


def test_the_shape_of_a_dataset() -> None:
    assert differences(dataset().drop_vars("L_s"))[0].text == "only in the first dataset"
    moved = dataset().assign_coords(mu_k=[0.1, 0.25])
    assert [(d.what, d.count) for d in differences(moved)] == [("mu_k", 1)]
    shorter = dataset().isel(mu_k=[0])
    assert any(d.what == "mu_k" and "2 against 1 values" in d.text for d in differences(shorter))
    renamed = dataset()
    renamed["L_s"].attrs["units"] = "mm2"
    assert "'m2' against 'mm2'" in differences(renamed)[0].text
    turned = dataset()
    turned["L_s"] = turned["L_s"].transpose()
    assert differences(turned)[0].what == "L_s"


def computed_with(k: float, line: str, t_max: float) -> dict[str, Any]:
    """Global attributes of a dataset of a model of one's own."""
    return {
        "model": "my-belt",
        "numerics_version": 9,
        "parameters_json": json.dumps({"k": k, "m": 1.0}),
        "analyses_json": json.dumps({"response": {"settings": {"t_max": t_max}}}),
        "own_json": json.dumps({"b.py": {"holds": ["my-belt"], "text": f"one\n{line}\n"}}),
    }


def test_what_was_computed_with_other_values_says_so() -> None:
    left = computed_with(4.0, "two", 100.0)
    assert causes(left, left) == []
    assert causes(left, computed_with(2.0, "three", 50.0)) == [
        "parameter k: 4 against 2",
        "analysis response.settings.t_max: 100 against 50",
        "text of my-belt (b.py), of 2 changed lines: - two",
    ]
    assert causes(left, left | {"numerics_version": 8}) == ["numerics version: 9 against 8"]
    own, met = ({"kind": kind, "event": "slip->stick", "contact": 1} for kind in ("own", "event"))
    asked = [{"analyses_json": json.dumps({"a": {"section": one}})} for one in (own, met)]
    told = '{ event = "any" }, as where a case names none'
    assert causes(*asked) == [
        f'analysis a.section: {told} against {{ event = "slip->stick", contact = 1 }}'
    ]
    starts = [{"case": f'[[initial]]\nlabel = "far"\nstate = {{ x = {x} }}'} for x in (1.0, 2.0)]
    assert causes(*starts) == ["start far state.x: 1 against 2"]
    chains = ('label = "up"\nkind = "continue"\n' + more for more in ("", 'steps = "grid"\n'))
    cases = [{"case": f"[[initial]]\n{one}"} for one in chains]
    assert causes(*cases) == ["start up steps: shorter against grid"]  # which it is unsaid
    said = [starts[0], starts[0] | {"overrides": "initial.0.state={x=3}\nsolver.rtol=1e-8"}]
    assert causes(*said) == ["--set initial.0.state: none against {x=3}"]
    fewer = left | {"parameters_json": '{"m": 1.0}'}
    assert causes(left, fewer, axes={"k"}) == []
    assert causes(fewer, left) == ["parameter k: none against 4"]  # its model had no k
    assert causes(fewer | {"model": "other"}, left) == ["model: other against my-belt"]


def test_analyses_are_compared_by_name() -> None:
    found = compare({"a": dataset()}, {"b": dataset()}, Tolerances())
    assert [(d.what, d.text) for d in found] == [
        ("a", "only in the first dataset"),
        ("b", "only in the second dataset"),
    ]
    alone = dataset().assign_attrs(analyses_json='{"a": {}}')
    (found,) = compare({"": alone}, {"a": dataset(), "b": dataset()}, Tolerances())
    assert (found.what, found.text) == ("b", "only in the second dataset")
    (found_inside,) = compare({"a": dataset()}, {"a": changed("L_s", (0, 0), 9.0)}, Tolerances())
    assert found_inside.what == "a/L_s"


def test_a_file_says_how_closely_chaos_is_compared(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text("[default]\nrtol = 1e-9\n")
    assert read_tolerances(tmp_path / "a.toml").standard_errors == 0.0


def test_tolerances_are_read_from_toml(tmp_path: Path) -> None:
    path = tmp_path / "tolerances.toml"
    path.write_text(
        'ignore = ["period"]\n[default]\nrtol = 1e-3\n[variables.L_s]\nrtol = 0.5\natol = 0.0\n'
    )
    tolerances = read_tolerances(path)
    assert tolerances.of("L_s") == Tolerance(0.5, 0.0)
    assert tolerances.of("x_max") == Tolerance(rtol=1e-3)
    assert tolerances.ignore == ("period",)


@pytest.mark.parametrize("text", ["[default]\nrtoll = 1\n", "nonsense", "[defaults]\nrtol = 1\n"])
def test_a_bad_table_of_tolerances(tmp_path: Path, text: str) -> None:
    path = tmp_path / "tolerances.toml"
    path.write_text(text)
    with pytest.raises(InputError):
        read_tolerances(path)
    with pytest.raises(UsageError):
        read_tolerances(tmp_path / "missing.toml")
