"""The analysis `plate` through cases, datasets and figures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from motions import defaults
from scipy.optimize import brentq

from fiv_cli.analyses.base import Request
from fiv_cli.analyses.execute import execute
from fiv_cli.case.case import FigureSpec
from fiv_cli.case.load import parse_case
from fiv_cli.cli.main import run
from fiv_cli.codegen.setup import Setup
from fiv_cli.errors import CaseError, UsageError
from fiv_cli.models import get_model
from fiv_cli.plate import AnnularPlate, mode
from fiv_cli.plots import drawing
from fiv_cli.sweep.plan import make_plan

CASE = """\
schema = 1
title = "Modes of the disc"
[model]
name = "annular-plate"
options = { modes = [[0, 0], [0, 1], [0, 2], [0, 3], [1, 1]] }
[[analysis]]
kind = "plate"
n_r = 11
"""
DEFAULTS = {p.name: float(p.default or 0.0) for p in get_model("annular-plate").parameters}


@pytest.fixture
def dataset(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> xr.Dataset:
    monkeypatch.chdir(tmp_path)
    Path("plate.toml").write_text(CASE)
    assert run(["run", "plate.toml", "--workers", "1", "-q"]) == 0
    with xr.open_dataset("runs/plate.nc") as opened:
        return opened.load()


def test_frequencies_masses_and_shapes(dataset: xr.Dataset) -> None:
    """Independent values of the disc of Table 4.1."""
    first = dataset["plate_frequency"].sel(k=0)
    expected = [1491.92691, 1516.75732, 1823.88110, 2774.19385]
    np.testing.assert_allclose(first, expected, rtol=5e-9)
    masses = dataset["inverse_modal_mass"].sel(k=0)
    np.testing.assert_allclose(masses, [2.331299, 4.654327, 4.618520, 4.541565], rtol=3e-7)
    assert dataset["plate_frequency"].attrs["units"] == "rad s-1"
    asked = np.isfinite(dataset["plate_frequency"].values)
    np.testing.assert_array_equal(asked, [[True] * 4, [False, True, False, False]])
    assert dataset["shape"].dims == ("k", "l", "r")
    np.testing.assert_allclose(dataset["radius"], np.linspace(0.044, 0.12, 11), rtol=1e-14)
    edges = dataset["shape"].sel(k=1, l=1).values
    shape = mode(AnnularPlate(0.044, 0.12, 0.002, 7200.0, 150e9, 0.211), 1, 1).shape
    assert abs(edges[0]) < 1e-12
    assert edges[-1] == pytest.approx(float(shape(0.12) / shape(0.1)), rel=1e-13)


def test_a_node_at_the_slider_is_said() -> None:
    shape = mode(AnnularPlate(0.044, 0.12, 0.002, 7200.0, 150e9, 0.211), 1, 0).shape
    node = brentq(lambda r: float(shape(r)), 0.06, 0.119, xtol=1e-16)
    setup = Setup.of("annular-plate", options={"modes": "0,0 1,0"})
    found = execute(Request(setup, {**DEFAULTS, "r0": node}, "plate", {"n_r": 5}))
    assert (found.status, found.reason) == ("ok", "node_at_r0")
    assert "mode (1, 0) has a node" in found.message
    assert found.values["inverse_modal_mass"][1, 0] == 0.0
    assert np.isnan(found.values["shape"][1, 0]).all()
    assert np.isfinite(found.values["shape"][0, 0]).all()
    assert np.isfinite(found.values["plate_frequency"][1, 0])


def test_a_slider_on_a_node_is_no_reason_for_nonsense() -> None:
    shape = mode(AnnularPlate(0.044, 0.12, 0.002, 7200.0, 150e9, 0.211), 1, 0).shape
    node = brentq(lambda r: float(shape(r)), 0.06, 0.119, xtol=1e-16)
    model, law = get_model("excited-disc"), "exponential"
    for r0, expected in ((node, "node_at_r0"), (node + 1e-3, "")):
        parameters = defaults(model, law, r0=r0)
        setup = Setup.of(model, law, {"modes": "1,0"})
        found = execute(Request(setup, parameters, "equilibrium", {"system": "original"}))
        assert found.reason == expected
        assert ("mode (1, 0)" in found.message) == bool(expected)


@pytest.mark.parametrize("model", ["annular-plate", "excited-disc"])
@pytest.mark.parametrize("given", ["r0 = 0.13", "r0 = 0.04", "a = 0.2", "b = 0.04"])
def test_the_slider_is_on_the_disc(model: str, given: str) -> None:
    text = CASE.replace("annular-plate", model).replace("options", f"parameters.{given}\noptions")
    with pytest.raises(CaseError, match="the slider is not on the disc") as caught:
        parse_case(text, "a.toml")
    assert caught.value.problems[0].path == f"model.parameters.{given.split()[0]}"


@pytest.mark.parametrize("given", ["options.modes = [[0, 0], [1, 0]]\n", ""])
def test_an_excited_disc_needs_a_doublet(given: str) -> None:
    """omega = R omega_cr, and omega_cr = min omega_kl / l: else A would silently do nothing."""
    case = 'schema = 1\ntitle = "x"\n[model]\nname = "excited-disc"\n'
    analysis = '[[analysis]]\nkind = "eigenvalues"\n'
    axis = '[grid]\nmodes = ["0,0 0,1", "0,0"]\n'
    text = case + (given or axis) + analysis
    with pytest.raises(CaseError, match="no mode has a nodal diameter") as caught:
        parse_case(text, "a.toml")
    assert "l > 0" in caught.value.problems[0].allowed
    parse_case(text.replace("excited-disc", "disc-rigid-contact"), "a.toml")


def test_points_off_the_disc_are_not_computed() -> None:
    case = parse_case(CASE + "[grid]\nr0 = [0.1, 0.12, 0.13]\n", "a.toml")
    (plan,) = make_plan(case).analyses
    assert plan.excluded() == {"the slider is not on the disc": 1}
    assert "1 point where the slider is not on the disc" in "\n".join(make_plan(case).describe())


@pytest.mark.parametrize("kind", ["history", "response", "equilibrium", "eigenvalues"])
def test_a_plate_alone_does_not_move(kind: str) -> None:
    with pytest.raises(CaseError, match="has no contact and does not move") as caught:
        parse_case(CASE.replace('"plate"\nn_r = 11', f'"{kind}"'), "a.toml")
    assert caught.value.problems[0].allowed == "plate"


def test_a_belt_is_no_plate() -> None:
    text = CASE.replace("annular-plate", "belt-1dof").replace("options =", "# options =")
    with pytest.raises(CaseError, match="has no elastic disc"):
        parse_case(text, "a.toml")


def test_a_disc_with_a_slider_has_the_same_modes(dataset: xr.Dataset, tmp_path: Path) -> None:
    text = CASE.replace("annular-plate", "disc-rigid-contact")
    Path("disc.toml").write_text(text)
    assert run(["run", "disc.toml", "--workers", "1", "-q"]) == 0
    with xr.open_dataset("runs/disc.nc") as other:
        shapes = (found["shape"].reset_coords(drop=True) for found in (other.load(), dataset))
        xr.testing.assert_identical(*shapes)  # the slider has parameters of its own


def test_shapes_are_drawn_from_above(dataset: xr.Dataset) -> None:
    (figure,) = drawing.default_figures(dataset)
    assert figure.kind == "mode-shape"
    drawn = drawing.draw(dataset, figure)
    *panels, bar = drawn.axes
    titles = [ax.get_title() for ax in panels if ax.get_title()]
    assert [title.split(":")[0] for title in titles[:2]] == ["$k$ = 0, $l$ = 0", "$k$ = 0, $l$ = 1"]
    assert "1491.93 rad/s" in titles[0]
    (mesh,) = panels[2].collections  # two nodal diameters: four changes of sign around the edge
    edge = np.asarray(mesh.get_array()).reshape(11, -1)[-1]
    assert np.count_nonzero(np.diff(np.sign(edge))) == 4
    hertz = FigureSpec("x", "mode-shape", {"unit": "Hz", "select": {"l": 0}})
    titles = [ax.get_title() for ax in drawing.draw(dataset, hertz).axes]
    assert titles[0] == "$k$ = 0, $l$ = 0: 237.4 Hz" and len(titles) == 2
    bar.remove()


def test_one_plate_in_a_figure(dataset: xr.Dataset) -> None:
    two = xr.concat([dataset, dataset], "h").assign_coords(h=[1e-3, 2e-3])
    with pytest.raises(UsageError, match="h varies"):
        drawing.draw(two, FigureSpec("x", "mode-shape", {}))
    drawing.draw(two, FigureSpec("x", "mode-shape", {"select": {"h": 2e-3}}))


@pytest.mark.parametrize(
    ("model", "kind", "settings"),
    [
        ("annular-plate", "plate", {"n_r": 3}),
        ("disc-rigid-contact", "equilibrium", {"system": "original"}),
    ],
)
@pytest.mark.parametrize("share", [1e-9, 1e-100])
def test_a_hole_of_next_to_nothing_has_a_reason_of_its_own(
    model: str, kind: str, settings: dict[str, object], share: float
) -> None:
    """A mode with diameters is then that of a disc without a hole, to the last bit."""
    options = {"modes": "0,1 0,3"}
    law = "coulomb" if get_model(model).contacts else "none"
    parameters = defaults(model, law) if get_model(model).contacts else dict(DEFAULTS)
    parameters["a"] = share * parameters["b"]
    found = execute(Request(Setup.of(model, law, options), parameters, kind, settings))
    assert (found.status, found.reason) == ("failed", "hole_too_small")
    assert "is too small" in found.message
