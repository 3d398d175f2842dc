"""Datasets in other hands: the CF conventions, ways back to the points, and two runs as one."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest
import xarray as xr

from fiv_cli import api
from fiv_cli.analyses import all_analyses

BELT: dict[str, Any] = {
    "schema": 1,
    "model": {"name": "belt-1dof", "parameters": {"c": 0.1}},
    "initial": [{"kind": "state", "state": {"x": 10.0}}],
}
FIVE: dict[str, Any] = {"schema": 1, "model": {"name": "belt-5dof"}}
VARIED = {"parameter": "v", "bracket": [0.5, 9.0]}
PERIODIC = {"variable": "attractor", "expect": "periodic"}
KINDS: dict[str, dict[str, Any]] = {
    "history": BELT | {"analysis": [{"kind": "history", "t_end": 5.0, "sample": 0.5}]},
    "equilibrium": FIVE | {"analysis": [{"kind": "equilibrium"}]},
    "eigenvalues": FIVE | {"grid": {"mu_k": [0.1, 0.5]}, "analysis": [{"kind": "eigenvalues"}]},
    "critical": FIVE
    | {"analysis": [{"kind": "critical", "parameter": "mu_k", "bracket": [0.1, 2.0]}]},
    "response": BELT | {"grid": {"v": [0.5, 9.0]}, "analysis": [{"kind": "response"}]},
    "spectrum": BELT | {"analysis": [{"kind": "spectrum", "f_max": 2.0}]},
    "spectrogram": BELT
    | {"schedule": {"v": {"points": [[0.0, 1.0], [50.0, 2.0]]}}}
    | {"analysis": [{"kind": "spectrogram", "t_end": 50.0, "f_max": 2.0, "resolution": 0.2}]},
    "boundary": BELT | {"analysis": [{"kind": "boundary", "scan": 3, "of": PERIODIC, **VARIED}]},
    "cycle": BELT | {"analysis": [{"kind": "cycle", **VARIED}]},
    "plate": {"schema": 1, "model": {"name": "annular-plate"}, "analysis": [{"kind": "plate"}]},
    "characteristic": BELT
    | {"friction": {"law": "lugre"}, "analysis": [{"kind": "characteristic", "amplitude": 1e-3}]},
    "laws": BELT
    | {"grid": {"friction": ["coulomb", "stribeck"], "initial.x": [9.0, 10.0]}}
    | {"analysis": [{"kind": "response"}]},
}

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
MEANING = re.compile(r"[A-Za-z0-9_.+@-]+")


def test_every_kind_of_analysis_is_looked_at() -> None:
    assert {*all_analyses()} <= {*KINDS}


@pytest.fixture(scope="module", params=KINDS)
def written(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset of each kind."""
    path = tmp_path_factory.mktemp("cf") / f"{request.param}.nc"
    found = api.run(api.load(KINDS[request.param]), path, workers=1)
    assert (api.names_of(found["status"]) == "ok").all()
    return path


def broken_rules(file: netCDF4.Dataset) -> Iterator[str]:
    """What the conventions, sections 2 to 5 and 9, have against a file."""
    for name in ("Conventions", "title", "history", "source"):
        if not str(getattr(file, name, "")):
            yield f"no {name}"
    for name, variable in file.variables.items():
        attributes = variable.__dict__
        is_text = variable.dtype is str or variable.dtype.kind in "SU"
        if not NAME.fullmatch(name) or not attributes.get("long_name"):
            yield f"{name}: no name"
        if is_text == ("units" in attributes):
            yield f"{name}: a text has no unit, a number has one"
        if name in file.dimensions and "_FillValue" in attributes:
            yield f"{name}: a coordinate misses no value"
        if not all(map(MEANING.fullmatch, attributes.get("flag_meanings", "").split())):
            yield f"{name}: flag_meanings"
        named = attributes.get("ancillary_variables", "").split()
        named += attributes.get("coordinates", "").split()
        if not {*named} <= {*file.variables}:
            yield f"{name}: names {named}"
        since = " since " in attributes.get("units", "")
        if since != (attributes.get("standard_name") == "time" or "axis" in attributes):
            yield f"{name}: what counts from no date is no time axis (4.4)"
        if attributes.get("sample_dimension", "initial") not in {*file.dimensions, "initial"}:
            yield f"{name}: sample_dimension"


def test_every_kind_of_dataset_follows_the_conventions(written: Path) -> None:
    with netCDF4.Dataset(written) as file:
        assert list(broken_rules(file)) == []


# It asks that a dimension called `time` begins at a date. By 2.3 names mean nothing, and by 4.4
# plain seconds make no time axis: its authors take the rule out (issue 1245, pull request 1353).
MISTAKEN = "check_spatiotemporal_dims_have_coordinate_vars"


def test_a_checker_of_others_passes(written: Path) -> None:
    """And recommends nothing (2.3) but that the thesis' m be not beside its M."""
    from compliance_checker.runner import CheckSuite, ComplianceChecker

    CheckSuite().load_all_available_checkers()
    report = written.with_suffix(".json")
    passes, failed = ComplianceChecker.run_checker(
        str(written),
        ["cf:1.11"],
        0,
        "lenient",
        skip_checks=[MISTAKEN],
        output_filename=str(report),
        output_format="json",
    )
    assert passes and not failed
    (told,) = json.loads(report.read_text()).values()
    groups = [told[f"{priority}_priorities"] for priority in ("high", "medium", "low")]
    messages = [message for group in groups for one in group for message in one["msgs"]]
    assert told["possible_points"] > 0
    assert [m for m in messages if not m.endswith("Duplicate variables named: m")] == []


def test_a_ragged_value_leads_back_to_its_point() -> None:
    found = api.run(
        api.load(KINDS["laws"] | {"grid": {"v": [0.5, 1.0], "N": [5.0, 10.0]}}), workers=1
    )
    sizes = found["section_row_size"]
    assert sizes.sum() == found.sizes["section_obs"] > 0
    place = np.unravel_index(found["section_point"], found["status"].shape)
    counted = np.zeros(sizes.shape, int)
    np.add.at(counted, place, 1)
    np.testing.assert_array_equal(counted, sizes)
    x = found["section_value"].values
    assert (x >= found["x_min"].values[place] - 1e-12).all()
    assert (x <= found["x_max"].values[place] + 1e-12).all()


@pytest.mark.usefixtures("_defaults")
def test_values_of_any_number_are_found_with_their_points_in_joined_runs_too() -> None:
    """As in each run alone, behind one another; of grids that differ they are joined themselves."""
    runs = [run(**{"model.parameters.N": N}) for N in (5.0, 60.0)]
    alone = [api.observations(one, "section_value") for one in runs]
    for one, values in zip(runs, alone, strict=True):
        assert values.sizes["section_obs"] == one.sizes["section_obs"] > 0
        low, high = (one[f"x_{end}"].isel(initial=0).sel(v=values["v"]) for end in ("min", "max"))
        assert bool(((low <= values + 1e-12) & (values <= high + 1e-12)).all())
    other = run(**{"grid.v": [2.0, 0.5], "model.parameters.N": 60.0})
    whole = api.observations(xr.concat(runs, "N", join="outer"), "section_value")
    for joined in (whole, xr.concat(alone, "section_obs")):
        assert joined["v"].values.tolist() == [v for one in alone for v in one["v"].values]
        assert joined["N"].values.tolist() == [5.0] * alone[0].size + [60.0] * alone[1].size
        np.testing.assert_array_equal(joined, np.concatenate(alone))
    drawn = api.figure(xr.concat(runs, "N", join="outer"), "bifurcation").axes[0]
    points = [line.get_xydata() for line in drawn.lines if line.get_marker() not in ("None", "")]
    assert {*map(tuple, np.concatenate(points))} >= {
        *zip(whole["v"].values, whole.values, strict=True)
    }
    for part in (runs[0].isel(v=1), runs[0].isel(v=[1, 0])):
        with pytest.raises(api.UsageError, match="take the values of the whole dataset"):
            api.observations(part, "section_value")
    one = api.observations(xr.concat(runs, "N", join="outer").isel(N=1), "section_value")
    np.testing.assert_array_equal(one, alone[1])
    with pytest.raises(api.UsageError, match=r"api\.join"):
        api.observations(xr.concat([runs[0], other], "N", join="outer"), "section_value")
    with pytest.raises(api.UsageError, match="section_point, section_value"):
        api.observations(other, "L_s")


def test_values_of_any_number_are_found_in_the_analysis_that_has_them(tmp_path: Path) -> None:
    """In a file, a tree, and a group of it; where it is not said which, by a message that does."""
    case = KINDS["response"] | {"analysis": [{"kind": "equilibrium"}, {"kind": "response"}]}
    tree = api.run(api.load(case), tmp_path / "two.nc", workers=1)
    group = xr.open_dataset(tmp_path / "two.nc", group="response")
    for data in (tree, tmp_path / "two.nc", tree["response"], group):
        values = api.observations(data, "section_value")
        np.testing.assert_array_equal(values, tree["response"]["section_value"])
    with pytest.raises(api.UsageError, match=r'several analyses: equil.*, resp.*\n.*group="NAME"'):
        api.observations(xr.open_dataset(tmp_path / "two.nc"), "section_value")
    with pytest.raises(api.UsageError, match=r'in several analyses.*\n.*\["equilibrium"\]'):
        api.observations(tree, "status")
    with pytest.raises(api.UsageError, match="these are: section_point, section_value"):
        api.observations(tree, "section_valu")


def run(**changes: Any) -> xr.Dataset:
    """A response under changed settings."""
    case = KINDS["response"] | {"grid": {"v": [0.5, 1.0, 9.0]}}
    return api.run(api.load(case, overrides=changes), workers=1)


@pytest.fixture(params=[False, True], ids=["as it was", "as it will be"])
def _defaults(request: pytest.FixtureRequest) -> Iterator[None]:
    """What xr.concat takes for granted."""
    with xr.set_options(use_new_combine_kwarg_defaults=request.param):
        yield


@pytest.mark.usefixtures("_defaults")
def test_two_runs_are_one_along_a_parameter_that_neither_varied() -> None:
    runs = [run(**{"model.parameters.c": c}) for c in (0.1, 0.2)]
    assert [float(one["c"]) for one in runs] == [0.1, 0.2]
    both = xr.concat(runs, "c", join="outer")
    assert both["L_s"].dims == ("c", "v", "initial") and both["c"].values.tolist() == [0.1, 0.2]
    for one in runs:
        part = both.sel(c=float(one["c"]))
        np.testing.assert_array_equal(part["L_s"], one["L_s"])
        values = part["section_value"].dropna("section_obs")
        np.testing.assert_array_equal(values, one["section_value"])
        points = part["section_point"].dropna("section_obs")
        np.testing.assert_array_equal(points, one["section_point"])


def test_runs_of_parts_of_a_grid_are_joined_to_the_run_of_the_whole() -> None:
    """Bit for bit, with all values of any number per point, whatever else the grid varies."""
    parts = [run(**{"grid.N": [5.0, 60.0], "grid.v": v}) for v in ([0.5, 9.0], [3.0, 1.0])]
    whole = run(**{"grid.N": [5.0, 60.0], "grid.v": [0.5, 9.0, 3.0, 1.0]})
    both = api.join(parts, "v")
    xr.testing.assert_identical(both.drop_attrs(deep=False), whole.drop_attrs(deep=False))
    assert both.sizes["section_obs"] == sum(one.sizes["section_obs"] for one in parts) > 0
    with pytest.raises(api.UsageError, match="take the values of the whole dataset"):
        api.join([parts[0].isel(v=[1]), parts[1]], "v")


def test_the_modes_of_joined_runs_are_followed_across_them() -> None:
    case = {"schema": 1, "model": {"name": "belt-2mass"}, "analysis": [{"kind": "eigenvalues"}]}
    mu = np.linspace(0.05, 1.5, 12).tolist()
    grids = (mu[:6], mu[6:], mu)
    *parts, whole = (api.run(api.load(case, {"grid.mu_k": g}), workers=1) for g in grids)
    both = api.join(parts, "mu_k")
    xr.testing.assert_identical(both.drop_attrs(deep=False), whole.drop_attrs(deep=False))


def test_of_a_part_only_what_still_belongs_to_its_points_is_drawn() -> None:
    whole = run()
    part = whole.sel(v=[1.0, 9.0])
    for kept in (part, part.drop_dims("section_obs")):
        (line,) = api.figure(kept, "curve").axes[0].lines
        assert {*line.get_xdata()} >= {1.0, 9.0} and 0.5 not in line.get_xdata()
        with pytest.raises(api.UsageError, match="no values at a section"):
            api.figure(kept, "bifurcation")
    drawn = api.figure(xr.DataTree.from_dict({"response": whole})["response"], "bifurcation")
    assert drawn.axes[0].lines
    with pytest.raises(api.UsageError, match="DataArray: not a dataset"):
        api.figure(whole["L_s"])  # type: ignore[arg-type]
    gaps = api.names_of(whole["status"].astype(float).where(whole["v"] > 0.5))
    assert gaps.values.ravel().tolist() == ["", "ok", "ok"]


def test_where_no_run_has_a_point_it_is_pending() -> None:
    runs = [run(**{"model.parameters.N": 5.0, "grid.v": [3.0, 0.5]}), run(**{"grid.N": [60.0]})]
    both = api.join(runs, "N")
    assert {n: one.dtype for n, one in both.items()} == {n: o.dtype for n, o in runs[0].items()}
    status = api.names_of(both["status"]).isel(initial=0).sel(v=[0.5, 1.0, 3.0, 9.0])
    assert status.values.tolist() == [
        ["ok", "pending", "ok", "pending"],
        ["ok", "ok", "pending", "ok"],
    ]
    assert both.attrs["partial"] == "5 of 8 points" and "partial" not in runs[0].attrs
    found = api.observations(both, "section_value")
    for one in runs:
        values = api.observations(one, "section_value").sortby("v")
        of_run = found[found["N"] == one["N"].item()]
        np.testing.assert_array_equal(of_run, values)
        np.testing.assert_array_equal(of_run["v"], values["v"])
    for wrong, along, words in (
        (runs, "omega_y", "no parameter of run 1"),
        ([runs[0], runs[0]], "N", "2 runs have it"),
        ([runs[0], api.run(api.load(KINDS["history"]), workers=1)], "N", "join runs of one"),
        ([], "N", "join runs of one case"),
    ):
        with pytest.raises(api.UsageError, match=words):
            api.join(wrong, along)


def test_points_that_advance_together_are_found_in_a_run_over_a_grid() -> None:
    """Together they are no axis along which runs are joined; the error says what to type."""
    grid = run(**{"grid.N": [20.0, 40.0]})
    zipped = run(**{"grid.N": [20.0, 40.0], "grid.v": [1.0, 9.0], "sweep.zip": [["v", "N"]]})
    with pytest.raises(api.UsageError) as refused:
        api.join([grid, zipped], "N")
    told, following = str(refused.value).splitlines()
    assert told == "N: in run 2 it advances together with v"
    same = eval(following.partition(" are ")[2], {"grid": grid, "run": zipped})
    np.testing.assert_array_equal(same["L_s"].values, zipped["L_s"].values)


def test_joined_runs_of_every_kind_are_written_without_a_warning(written: Path) -> None:
    """And are read again by fiv, each part as it was."""
    one = api.read(written)
    along = next(str(n) for n, c in one.coords.items() if c.ndim == 0 and c > 0.0)
    other = one.assign_coords({along: 2.0 * one[along]})
    path = written.with_name("joined.nc")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        api.join([one, other], along).to_netcdf(path)
        both = api.read(path)
        both.isel({dim: [0] for dim in both["status"].dims}).to_netcdf(path.with_name("part.nc"))
    with netCDF4.Dataset(path) as file:
        assert list(broken_rules(file)) == []
    for place, part in enumerate((one, other)):
        for name, values in part.items():
            if along in both[name].dims:
                np.testing.assert_array_equal(both[name].isel({along: place}), values)
            elif not str(name).endswith("_point"):
                np.testing.assert_array_equal(both[name], np.tile(values, 2))


def test_a_parameter_is_described_as_the_law_in_use_does() -> None:
    """`delta` is an exponent of one law, and a rate in s/m of another; together it has no name."""
    case = BELT | {"analysis": [{"kind": "equilibrium"}]}
    laws = {"grid.friction": ["stribeck", "hyperbolic"]}
    for law, unit in (("stribeck", "1"), ("hyperbolic", "s m-1")):
        one = {"friction.law": law}
        for overrides in (one, one | {"grid.delta": [1.0, 2.0]}):
            found = api.run(api.load(case, overrides), workers=1)
            assert found["delta"].attrs["units"] == unit
    own = {"friction.stribeck.delta": 1.0, "friction.hyperbolic.delta": 1.0}
    assert "delta" not in api.run(api.load(case, laws | own), workers=1).coords
    with pytest.raises(api.CaseError, match="'delta' means different things"):
        api.load(case, laws | {"grid.delta": [1.0, 2.0]})


def test_a_parameter_of_one_of_several_laws_is_fixed() -> None:
    """And one that all have, where it is the same under each."""
    both = {"grid.friction": ["coulomb", "stribeck"], "friction.stribeck.v_s": 0.3}
    found = api.run(api.load(BELT | {"analysis": [{"kind": "equilibrium"}]}, both), workers=1)
    assert (float(found["v_s"]), float(found["mu_s"])) == (0.3, 0.4)
    apart = both | {"friction.coulomb.mu_s": 0.5}
    found = api.run(api.load(BELT | {"analysis": [{"kind": "equilibrium"}]}, apart), workers=1)
    assert "mu_s" not in found.coords


def test_what_the_analysis_itself_varies_is_no_fixed_parameter() -> None:
    found = api.run(api.load(KINDS["boundary"]), workers=1)
    assert "v" not in found.coords and float(found["c"]) == 0.1
    assert found["c"].attrs["units"] == "N s m-1"
    varying = api.run(api.load(KINDS["spectrogram"]), workers=1)
    assert varying["v"].dims[-1] == "time"
