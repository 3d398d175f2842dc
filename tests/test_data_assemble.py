"""Datasets: layout, attributes, files."""

from __future__ import annotations

import json
import resource
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from small_models import SUITED

from fiv_cli.analyses import all_analyses
from fiv_cli.analyses.base import Outcome, Varied
from fiv_cli.analyses.catalogue import variables_of
from fiv_cli.case.case import Axis
from fiv_cli.data.assemble import Blocks
from fiv_cli.data.assemble import assemble as assembled
from fiv_cli.data.block import Block, pack
from fiv_cli.data.dataset import Dataset
from fiv_cli.data.layout import Dim, Layout
from fiv_cli.data.modes import follow_modes
from fiv_cli.data.netcdf import read_datasets, to_attribute, write_datasets
from fiv_cli.errors import InputError, StorageError, UsageError
from fiv_cli.flags import REASONS, TABLES, advice
from fiv_cli.models import all_models

OMEGA = Dim((Axis("Omega", "parameter", (1.0, 2.0, 3.0)),))


def layout(kind: str, dims: tuple[Dim, ...] = (OMEGA,), starts: bool = False) -> Layout:
    """A layout on the pin-on-disc model."""
    labels = ("far",) if starts else None
    return Layout(kind, kind, "pin-on-disc", {}, {}, dims, labels, ("coulomb",))


def packed(what: Layout, *outcomes: Outcome) -> Block:
    """Outcomes as a block."""
    return pack(outcomes, [bytes(32)] * len(outcomes), what.variables)


def at(*positions: int) -> np.ndarray:
    """Positions of rows."""
    return np.array(positions, np.int64)


def assemble(what: Layout, blocks: Blocks) -> xr.Dataset:
    """The dataset of blocks, for what is asked of it here."""
    return assembled(what, blocks).to_xarray()


def test_blocks_in_any_order_give_the_same_dataset() -> None:
    what = layout("response", starts=True)
    runs = [
        Outcome(values={"L_s": float(i)}, ragged={"section_value": np.arange(i) + 0.5})
        for i in range(3)
    ]
    one = assemble(what, lambda: [(at(0, 1, 2), packed(what, *runs))])
    other = assemble(
        what,
        lambda: [
            (at(2, -1), packed(what, runs[2], runs[0])),
            (at(1, 0), packed(what, *runs[1::-1])),
        ],
    )
    assert one.identical(other)
    assert one["section_row_size"].values.ravel().tolist() == [0, 1, 2]
    assert one["section_value"].values.tolist() == [0.5, 0.5, 1.5]


def test_a_later_block_replaces_a_point() -> None:
    what = layout("response", starts=True)
    first = packed(what, Outcome(values={"L_s": 1.0}, ragged={"section_value": [1.0, 2.0, 3.0]}))
    later = packed(what, Outcome(values={"L_s": 9.0}, ragged={"section_value": [4.0]}))
    dataset = assemble(what, lambda: [(at(1), first), (at(1), later)])
    assert dataset["L_s"].values[1, 0] == 9.0
    assert dataset["section_value"].values.tolist() == [4.0]


def test_a_case_without_a_grid_has_variables_without_dims() -> None:
    what = layout("equilibrium", dims=())
    dataset = assemble(what, lambda: [(at(0), packed(what, Outcome(values={"n_solutions": 1})))])
    assert dataset["n_solutions"].dims == ()
    assert int(dataset["n_solutions"]) == 1


def test_points_without_a_block_are_pending() -> None:
    dataset = assemble(layout("response", starts=True), list)
    assert (dataset["status"] == TABLES["status"].codes["pending"]).all()
    assert np.isnan(dataset["L_s"]).all()
    assert dataset.sizes["section_obs"] == 0


@pytest.mark.parametrize(("model", "kind"), SUITED)
def test_every_variable_has_a_unit_a_name_and_sound_flags(kind: str, model: str) -> None:
    table = all_models()[model]
    settings = all_analyses()[kind].default_settings
    settings["parameter"] = Varied("mu_k")
    variables = variables_of(kind, table, table.default_options(), settings)
    assert [v.name for v in variables[:2]] == ["status", "reason"]
    assert len({v.name for v in variables}) == len(variables)
    for variable in variables:
        assert variable.units and variable.long_name
        assert (variable.kind == "flag") == (variable.flags in TABLES)


def test_flags_follow_the_conventions() -> None:
    dataset = assemble(layout("response", starts=True), list)
    for name in ("status", "reason", "attractor"):
        attributes = dataset[name].attrs
        assert dataset[name].dtype == np.int8
        assert len(attributes["flag_values"]) == len(attributes["flag_meanings"].split())
    assert dataset["L_s"].attrs["ancillary_variables"] == "status reason"
    assert dataset["section_row_size"].attrs["sample_dimension"] == "section_obs"
    assert dataset["Omega"].attrs["units"] == "rad s-1"
    assert dataset["phi_dot_max"].attrs["units"] == "rad s-1"


def test_every_reason_says_what_to_do() -> None:
    assert all(len(reason.advice) > 15 for reason in REASONS)
    assert len({reason.name for reason in REASONS}) == len(REASONS)
    assert advice("wall_clock") == next(r.advice for r in REASONS if r.name == "wall_clock")


def test_zipped_axes_and_names_become_coordinates() -> None:
    zipped = Dim((Axis("N0", "parameter", (1.0, 2.0)), Axis("Omega", "parameter", (3.0, 3.0))))
    named = Dim((Axis("friction", "law", ("coulomb", "stribeck")),))
    dataset = assemble(layout("equilibrium", (zipped, named)), list)
    assert dataset["status"].dims == ("N0_Omega", "friction")
    assert dataset["Omega"].dims == ("N0_Omega",)
    assert dataset["friction"].values.tolist() == ["coulomb", "stribeck"]
    assert dataset["state"].values.tolist() == ["phi", "theta"]


def test_solutions_are_padded_to_the_longest() -> None:
    what = layout("equilibrium")
    runs = [
        Outcome(values={"equilibrium": np.full((n, 2), float(n)), "n_solutions": n})
        for n in (1, 3, 2)
    ]
    dataset = assemble(what, lambda: [(at(i), packed(what, run)) for i, run in enumerate(runs)])
    assert dataset["equilibrium"].shape == (3, 3, 2)
    assert np.isfinite(dataset["equilibrium"]).sum("solution").values[:, 0].tolist() == [1, 3, 2]


def test_a_motion_that_ends_early_keeps_the_common_time() -> None:
    what = layout("history", starts=True)
    time = np.linspace(0.0, 1.0, 5)
    whole = Outcome(values={"time": time, "phi": time})
    short = Outcome(values={"time": time[:3], "phi": time[:3]})
    blocks = [(at(0, 1), packed(what, short, whole)), (at(2), packed(what, short))]
    dataset = assemble(what, lambda: blocks)
    assert dataset["time"].values.tolist() == time.tolist()
    assert np.isfinite(dataset["phi"]).sum("time").values.ravel().tolist() == [3, 5, 3]


def crossing_modes() -> xr.Dataset:
    """Two modes sorted by frequency at each point, whose branches cross at Omega = 2."""
    what = layout("eigenvalues")
    runs = []
    for Omega in (1.0, 1.9, 2.1):
        branches = [(Omega, [1.0, 0.0]), (2.0, [0.0, 1.0])]
        ordered = sorted(branches, key=lambda branch: branch[0])
        runs.append(
            Outcome(
                values={
                    "eigenvalue_real": np.zeros(2),
                    "eigenvalue_imag": np.array([value for value, _ in ordered]),
                    "eigenvector_real": np.array([vector for _, vector in ordered]),
                    "eigenvector_imag": np.zeros((2, 2)),
                }
            )
        )
    return assemble(what, lambda: [(at(0, 1, 2), packed(what, *runs))])


def test_modes_are_followed_through_a_crossing() -> None:
    dataset = crossing_modes()
    assert dataset["eigenvalue_imag"].isel(mode=0).values.tolist() == [1.0, 1.9, 2.1]
    assert dataset["eigenvalue_imag"].isel(mode=1).values.tolist() == [2.0, 2.0, 2.0]
    np.testing.assert_array_equal(dataset["eigenvector_real"].values[2], np.eye(2))


def test_following_twice_changes_nothing() -> None:
    dataset = crossing_modes()
    assert follow_modes(Dataset.of(dataset)).to_xarray().identical(dataset)


def test_a_file_reads_back_and_is_the_same_twice(tmp_path: Path) -> None:
    dataset = crossing_modes()
    for name in ("a.nc", "b.nc"):
        write_datasets(
            tmp_path / name, {"eigenvalues": Dataset.of(dataset)}, {"title": "x", "extra": {"k": 1}}
        )
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()
    back = read_datasets(tmp_path / "a.nc")[""]
    form = json.loads(back.attrs.pop("variables_json"))["eigenvalues"]
    assert form["eigenvector_real"] == ["numbers", "Omega", "mode", "state"]
    assert back.attrs == {"title": "x", "extra": '{"k": 1}'}
    xr.testing.assert_equal(back["eigenvalue_imag"], dataset["eigenvalue_imag"])


def test_several_analyses_are_groups_with_common_attributes(tmp_path: Path) -> None:
    dataset = Dataset.of(crossing_modes())
    write_datasets(tmp_path / "a.nc", {"first": dataset, "second": dataset}, {"title": "x"})
    groups = read_datasets(tmp_path / "a.nc")
    assert list(groups) == ["first", "second"]
    assert groups["second"].attrs["title"] == "x"


def test_a_file_that_cannot_be_written_leaves_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.nc"
    write_datasets(path, {"x": Dataset.of(crossing_modes())}, {"title": "old"})
    before = path.read_bytes()

    def full(*arguments: object, **named: object) -> None:
        assert len(list(tmp_path.iterdir())) == 2  # the new file is open
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("fiv_cli.data.netcdf._define", full)
    with pytest.raises(StorageError, match="No space left"):
        write_datasets(path, {"x": Dataset.of(crossing_modes())}, {"title": "new"})
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_disk_that_refuses_more_is_a_storage_error(tmp_path: Path) -> None:
    """The system itself refuses files above 4 KiB, so that the library fails as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, hard))
    try:
        with pytest.raises(StorageError, match="disk full"):
            write_datasets(tmp_path / "a.nc", {"x": Dataset.of(crossing_modes())}, {"title": "new"})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert not list(tmp_path.iterdir())


def test_reading_what_is_no_dataset(tmp_path: Path) -> None:
    (tmp_path / "a.nc").write_text("hello")
    with pytest.raises(InputError):
        read_datasets(tmp_path / "a.nc")
    for path in (tmp_path, tmp_path / "missing.nc"):
        with pytest.raises(UsageError):
            read_datasets(path)


@pytest.mark.parametrize(
    ("value", "attribute"),
    [(True, 1), ({"b": 1, "a": 2}, '{"a": 2, "b": 1}'), (("x", "y"), "x\ny"), (1.5, 1.5)],
)
def test_attributes_are_what_netcdf_can_hold(value: object, attribute: object) -> None:
    assert to_attribute(value) == attribute
