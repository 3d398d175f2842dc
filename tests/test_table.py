"""Variables as a table: every value in a row, with the axes of its point."""

from __future__ import annotations

import csv
import io
import json

import numpy as np
import pytest
import synthetic_datasets as data

from fiv_cli import api
from fiv_cli.cli.main import run as fiv
from fiv_cli.errors import UsageError
from fiv_cli.reading.datasets import is_class
from fiv_cli.reading.table import as_csv, without_row


def rows(dataset, *names, **at):
    return list(csv.DictReader(io.StringIO(as_csv({"response": dataset}, names, at))))


def test_a_row_for_each_point_that_has_a_value():
    classes = np.array(["periodic", "not_computed", "chaotic"], object)
    found = data.response(classes, np.array([1.0, np.nan, 0.1]), {"v": [0.5, 1.0, 2.0]})
    assert rows(found, "attractor", "L_s") == [
        {"v": "0.5", "attractor": "periodic", "L_s": "1.0"},
        {"v": "2.0", "attractor": "chaotic", "L_s": "0.1"},
    ]
    assert [row["v"] for row in rows(found, "L_s", v=". > 0.5")] == ["2.0"]
    remark = without_row({"response": found}, ["L_s"], {"v": ". < 2"})
    assert remark.startswith("1 of 2 points without a row")
    assert not without_row({"response": found}, ["L_s"], {"v": 2.0})
    assert not without_row({"response": found}, ["L_s"], {"attractor": "chaotic"})
    errors = found.assign(critical_value=found["L_s"], critical_error=found["L_s"] / 10)
    assert rows(errors, "critical_value")[0] == {
        "v": "0.5", "critical_value": "1.0", "critical_error": "0.1"
    }  # fmt: skip
    by_chance = np.array([np.nan, np.nan, 0.01])
    told = rows(found.assign(L_s_standard_error=("v", by_chance)), "L_s")
    assert [row["L_s_standard_error"] for row in told] == ["", "0.01"]
    none = found.assign(L_s_standard_error=("v", by_chance * np.nan))
    assert [*rows(none, "L_s")[0]] == ["v", "L_s"]


def test_a_table_of_axes_that_advance_together_names_them_alone_and_only_what_is_there():
    classes = np.full(3, "periodic", object)
    along = {"both": np.arange(3)}
    found = data.response(classes, np.array([1.0, 2.0, 3.0]), along).drop_vars("both")
    found = found.assign_coords(v=("both", [0.5, 1.0, 0.5]), N=("both", [5.0, 6.0, 7.0]))
    assert rows(found, "L_s", v=0.5) == [
        {"v": "0.5", "N": "5.0", "L_s": "1.0"},
        {"v": "0.5", "N": "7.0", "L_s": "3.0"},
    ]
    with pytest.raises(UsageError, match=r"v = 0\.6: not in this dataset"):
        rows(found, "L_s", v=0.6)


def test_a_variable_of_several_states_has_a_column_for_each_that_is_asked_for():
    found = data.basin(count=5, speeds=(1.0,))
    starts = found["initial_state"].values[0]
    told = rows(found, "attractor", "initial_state[*]")
    assert [*told[0]] == [
        "Omega",
        "initial",
        "attractor",
        "initial_state[x]",
        "initial_state[x_dot]",
    ]
    both = [[float(row[f"initial_state[{name}]"]) for name in ("x", "x_dot")] for row in told]
    assert both == starts.tolist()
    (one,) = {tuple(row) for row in rows(found, "initial_state[x_dot]")}
    assert one == ("Omega", "initial", "initial_state[x_dot]")
    with pytest.raises(UsageError, match="state = y: not in this dataset\nstate: x, x_dot"):
        rows(found, "initial_state[y]")
    with pytest.raises(UsageError, match=r"attractor\[x\]: no variable with one axis of its own"):
        rows(found, "attractor[x]")


def test_a_table_of_the_points_that_have_a_class():
    found = data.basin(count=50)
    every, chosen = (
        rows(found, "attractor", "L_s", **at) for at in ({}, {"attractor": "periodic"})
    )
    assert chosen == [row for row in every if row["attractor"] == "periodic"]
    assert 0 < len(chosen) < len(every)
    both = rows(found, "L_s", attractor=["periodic", "equilibrium"], Omega=2.0)
    assert len(both) == 50
    with pytest.raises(UsageError, match="attractor = odd: no such class\nthere are: equilibrium"):
        rows(found, "L_s", attractor="odd")
    moving = data.bifurcation()
    told = rows(moving, "section_value", attractor="periodic")
    of_class = is_class(moving["attractor"], ("periodic",))
    assert len(told) == int(moving["section_row_size"].where(of_class).sum())
    assert len(told) > 0 == len(rows(moving, "section_value", attractor="equilibrium"))
    both = rows(moving, "attractor", "section_value", attractor="periodic")
    assert {row["attractor"] for row in both if row["section_value"]} == {"periodic"}


def test_values_of_any_number_per_point_stand_beside_their_points():
    found = data.bifurcation()
    told = rows(found, "section_value")
    assert len(told) == found.sizes["section_obs"]
    assert [float(row["section_value"]) for row in told] == found["section_value"].values.tolist()
    sizes = found["section_row_size"]
    first = sizes.isel(initial=0).values
    label = str(found["initial"].values[0])
    counted = [
        sum(float(row["Omega"]) == Omega and row["initial"] == label for row in told)
        for Omega in found["Omega"].values
    ]
    assert counted == first.tolist()


def test_points_without_any_of_their_values_are_told():
    found = data.bifurcation()
    resting = found["Omega"].values[(found["section_row_size"] == 0).sel(initial="far").values]
    at = {"Omega": [float(one) for one in resting], "initial": "far"}
    told = without_row({"": found}, ["section_value"], at)
    assert told.startswith(f"no values at any of these {len(resting)} points: ")
    assert without_row({"": found}, ["section_value"], {}) == ""


def test_what_a_point_has_one_of_stands_beside_its_values_of_any_number():
    """And once where it has none; values of another number have a table of their own."""
    found = data.bifurcation()
    told = rows(found, "attractor", "section_value", "L_s")
    alone = rows(found, "section_value")
    by_point = {(r["Omega"], r["initial"]): r for r in rows(found, "attractor", "L_s")}
    for row, value in zip(told, alone, strict=False):
        point = by_point[row["Omega"], row["initial"]]
        assert row == {**point, "section_value": value["section_value"]}
    rest = told[len(alone) :]
    assert {row["section_value"] for row in rest} == {""}
    assert len(rest) + len({(r["Omega"], r["initial"]) for r in alone}) == len(by_point)
    apart = r"same number of values(.|\n)*--csv section_value; --csv other"
    with pytest.raises(UsageError, match=apart):
        as_csv({"": found.assign(other=("k", [1.0, 2.0]))}, ["section_value", "other"], {})


def test_an_error_that_is_not_computed_is_answered_with_what_tells_of_it():
    with pytest.raises(UsageError, match=r"no error of 'L_s'(.|\n)*solver.rtol=1e-10"):
        as_csv({"": data.bifurcation()}, ["L_s", "L_s_error"], {})


def test_of_several_analyses_with_a_variable_one_is_asked_for(tmp_path, monkeypatch, capsys):
    found = {"one": data.bifurcation(), "two": data.bifurcation()}
    with pytest.raises(UsageError, match="next: --analysis one or --analysis two"):
        as_csv(found, ["L_s"], {})
    assert as_csv({"two": found["two"]}, ["L_s"], {}) == as_csv({"": found["two"]}, ["L_s"], {})


def test_axes_may_be_named_too_and_a_file_takes_the_table(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = data.bifurcation()
    assert rows(found, "Omega", "section_value") == rows(found, "section_value")
    found.to_netcdf("a.nc")
    assert fiv(["show", "a.nc", "--csv", "attractor", "-o", "a.csv"]) == 0
    assert (tmp_path / "a.csv").read_text() == as_csv({"": found}, ["attractor"], {})
    assert fiv(["show", "a.nc", "-o", "a.csv"]) == 2


def test_what_is_not_there_is_told():
    with pytest.raises(UsageError, match=r"no variable 'L_S'; did you mean 'L_s'"):
        rows(data.bifurcation(), "L_S")
    with pytest.raises(UsageError, match=r"no variable 'rms'; here it is 'L_s'"):
        rows(data.bifurcation(), "rms")
    kinds = {"response": {"kind": "response", "settings": {}}}
    of_a_response = data.bifurcation().assign_attrs(analyses_json=json.dumps(kinds))
    with pytest.raises(UsageError, match=r"kind = \"critical\" computes it"):
        rows(of_a_response, "critical_value")
    with pytest.raises(UsageError, match=r"response computes it under other settings: fiv kinds"):
        rows(of_a_response, "section_kind")


def test_everything_is_as_many_tables_as_it_takes():
    """Each of which can be had as it is told, and together they hold every variable."""
    found = data.bifurcation()
    with pytest.raises(UsageError) as refused:
        rows(found, "all")
    tables = str(refused.value).partition("next: a command for each: ")[2].split("; ")
    told = [one.removeprefix("--csv ").split(",") for one in tables]
    assert sorted(name for names in told for name in names) == sorted(found.data_vars)
    for names in told:
        assert {*names} <= {*rows(found, *names)[0]}


def test_forces_of_a_history_have_a_column_for_each_contact():
    """Over time a row for each instant; of what is neither counted nor named there is no column."""
    asked = {"kind": "history", "t_end": 1.0, "sample": 0.5}
    case = {"schema": 1, "model": {"name": "belt-2mass"}, "analysis": [asked]}
    start = {"label": "far", "kind": "state", "state": {"x1": 1.0}}
    found = api.run(api.load(case | {"initial": [start]}), workers=1)
    told = rows(found, "F_T[*]")
    for number, forces in enumerate(found["F_T"].squeeze().transpose("contact", "time"), 1):
        assert [float(row[f"F_T[{number}]"]) for row in told] == forces.values.tolist()
    with pytest.raises(UsageError, match=r"x1\[\*\]: no variable .*\n.*\nnext: --csv x1, a row"):
        rows(found, "x1[*]")
