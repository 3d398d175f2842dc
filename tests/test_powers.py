"""Laws of one's own with a power of the slip speed whose exponent is a parameter."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from motions import motion
from scipy.integrate import solve_ivp
from small_models import TWO_MASSES

from fiv_cli import api
from fiv_cli.analyses.base import SolverSettings
from fiv_cli.dynamics.motion import Stop
from fiv_cli.errors import ModelFileError
from fiv_cli.own.probe import use_files

LAW = """\
import sympy
from fiv_cli.friction.base import Law
from fiv_cli.models.base import Parameter

LAW = Law(
    name="my-power", title="falls with a power", reference="none", numerics_version=1,
    parameters=(
        Parameter("mu_0", "m", "1", 0.4, "at rest", minimum=0.0),
        Parameter("mu_1", "m", "1", 0.2, "far", minimum=0.0),
        Parameter("v_0", "v", "m s-1", 0.3, "speed of half the fall", minimum=0.0, exclusive=True),
        Parameter("q", "q", "1", 1.5, "exponent", minimum=0.0),
    ),
    force=lambda slip, p: slip.sign * slip.N * (
        p["mu_1"] + (p["mu_0"] - p["mu_1"]) / (1 + (slip.speed / p["v_0"]) ** p["q"])
    ),
    capacity=lambda N, p: p["mu_0"] * N,
)
"""
POWER = '(slip.speed / p["v_0"]) ** p["q"]'
SPEED, LOAD = 0.1, 2.0  # m/s, N; mass and stiffness are 1
EQUAL = {"k1": 1.0, "k2": 1.0, "k_c": 1.2, "m": 1.0, "v": 0.1}  # what moves alike from rest


def damped(symbols, options):
    found = TWO_MASSES.equations(symbols, options)
    free = found.accelerations.items()
    return replace(found, accelerations={x: a - 0.05 * symbols.velocity(x) for x, a in free})


DAMPED = replace(TWO_MASSES, name="two-damped-masses", equations=damped)


@pytest.fixture(autouse=True)
def _nothing_is_left(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    yield
    use_files(())


def wrote(*, instead: str = POWER) -> Path:
    assert POWER in LAW
    Path("law.py").write_text(LAW.replace(POWER, instead))
    return Path("law.py")


def period_by_scipy(q: float) -> float:
    """Of stick-slip on a belt, under the power itself: one slip by DOP853, the stick by hand."""
    release = 0.4 * LOAD

    def rates(t, y):
        speed = max(SPEED - y[1], 0.0)
        return y[1], LOAD * (0.2 + 0.2 / (1.0 + (speed / 0.3) ** q)) - y[0]

    def caught(t, y):
        return SPEED - y[1]

    caught.terminal, caught.direction = True, -1.0
    slip = solve_ivp(rates, (0.0, 50.0), (release, SPEED), "DOP853", events=caught,
                     rtol=1e-13, atol=1e-15, max_step=0.05)  # fmt: skip
    return float(slip.t[-1] + (release - slip.y[0, -1]) / SPEED)


@pytest.mark.parametrize(("load", "tightness"), [(9.0, 7.6), (9.0, 9.2), (14.0, 7.2), (14.0, 9.2)])
def test_contacts_that_let_go_together_do_not_take_turns(load, tightness):
    """Friction goes on from what stick bears, without a jump: neither mass pulls the other off."""
    use_files([wrote()])
    rough = {"q": 1.5, "mu_0": 0.4, "mu_1": 0.2, "v_0": 0.5}
    loads, solver = {"N1": load, "N2": load}, SolverSettings(rtol=10.0**-tightness)
    begun = motion(DAMPED, "my-power", solver=solver, **EQUAL, **loads, **rough)
    assert begun.run(80.0) == Stop.REACHED
    assert begun.n_events < 40


@pytest.mark.parametrize(("q", "error"), [(0.7, 1e-8), (1.0, 1e-10), (1.5, 1e-10), (2.5, 1e-10)])
def test_stick_slip_under_a_power_has_the_period_that_scipy_finds(q, error):
    use_files([wrote()])
    solver = SolverSettings(rtol=1e-12)
    found = api.analyse(
        "belt-1dof", "my-power", "response", {}, {}, solver=solver, q=q, v=SPEED, N=LOAD
    )
    assert found.values["attractor"] == "periodic"
    assert found.values["period"] == pytest.approx(period_by_scipy(q), rel=error)


@pytest.mark.parametrize("q", [0.1, 0.3, 0.6])
def test_slip_begins_with_what_stick_bears_however_steeply_friction_rises(q):
    """A force that rises from capacity at once: the mass comes to slide steadily."""
    rising = f'p["mu_0"] + (p["mu_0"] - p["mu_1"]) * {POWER}'
    text = (
        LAW[: LAW.index('        p["mu_1"] + (')]
        + rising
        + LAW[LAW.index("\n    ),\n    capacity") :]
    )
    Path("law.py").write_text(text)
    use_files([Path("law.py")])
    found = api.analyse("belt-1dof", "my-power", "response", {"x": 0.0}, {}, q=q, v=0.1, N=LOAD)
    assert found.status == "ok" and found.values["attractor"] == "equilibrium"


def test_a_whole_number_given_to_the_exponent_answers_as_the_law_that_knows_it():
    use_files([wrote()])
    own, shipped = (
        api.analyse("belt-1dof", law, "history", {}, {"t_end": 40.0},
                    solver=SolverSettings(rtol=1e-12), v=SPEED, N=LOAD, **given)
        for law, given in (
            ("my-power", {"q": 2.0}),
            ("rational", {"delta": 2.0, "mu_s": 0.4, "mu_k": 0.2, "v_s": 0.3}),
        )
    )  # fmt: skip
    times = own.ragged["event_time"]
    assert len(times) > 5
    np.testing.assert_allclose(times, shipped.ragged["event_time"], rtol=1e-11)


@pytest.mark.parametrize(
    "instead",
    [
        'sympy.exp(p["q"] * sympy.log(slip.speed / p["v_0"]))',
        'slip.speed / p["v_0"] * sympy.log(slip.speed / p["v_0"]) * p["q"]',
        'p["q"] * sympy.sin(slip.speed / p["v_0"]) / (slip.speed / p["v_0"])',
    ],
    ids=["logarithm in an exponent", "logarithm", "quotient"],
)
def test_what_is_no_number_as_slip_begins_is_refused_with_what_to_write(instead):
    with pytest.raises(ModelFileError) as caught:
        use_files([wrote(instead=instead)])
    said = str(caught.value)
    assert "F_T is no number at v = 0, where slip begins" in said
    assert "write a power (slip.speed / p['v_0']) ** p['q']" in said
    line = caught.value.problems[0].line
    assert line and "force=" in LAW.splitlines()[line - 1]
