"""The shipped cases: all are right, the quick ones run, and their claims come out as told."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from fiv_cli.case.load import load_case
from fiv_cli.own.probe import use_files
from fiv_cli.plots import can_draw, draw, figures_of
from fiv_cli.reading.claims import CONFIRMED, CONTRADICTED, evaluate
from fiv_cli.reading.datasets import read_analyses
from fiv_cli.sweep.plan import make_plan
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import for_stderr
from fiv_cli.sweep.run import run_case

ROOT = Path(__file__).parents[1]
CASES = sorted((ROOT / "configs").rglob("*.toml"))
INDEX = (ROOT / "configs" / "INDEX.md").read_text(encoding="utf-8")
IN_PROCESS = Policy(workers=1)


@pytest.fixture(autouse=True, scope="module")
def _the_models_beside_cases_are_named():
    use_files([ROOT / "configs" / "own"])
    yield
    use_files(())


every_case = pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)


def header(path: Path) -> str:
    """The comment that a case file begins with."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return "\n".join(lines[: next(n for n, line in enumerate(lines) if line[:1] != "#")])


def runs(path: Path, overrides: tuple[str, ...], folder: Path):
    """Dataset of a case: name of the analysis -> dataset."""
    output = folder / f"{path.stem}.nc"
    run_case(load_case(path, overrides), output, IN_PROCESS, for_stderr(quiet=True))
    return read_analyses(output)


@every_case
def test_a_shipped_case_is_right_and_its_header_tells_the_truth(path):
    case = load_case(path)
    size = make_plan(case).size
    assert case.title
    assert case.reference
    assert case.claims
    assert case.figures
    own = "".join(f" --with {Path(o.path).relative_to(ROOT)}" for o in case.own.values())
    assert f"fiv run {path.relative_to(ROOT)}{own} &&" in header(path)
    assert re.search(rf"^# {size} runs\b.* s\b", header(path), re.MULTILINE)


@every_case
def test_what_a_case_assumes_stands_in_it(path):
    case = load_case(path)
    parts = {part.label for part in case.starts} | {axis.name for axis in case.axes}
    parts |= {key for analysis in case.analyses for key in analysis.settings}
    parts |= set(case.parameters) | {"initial"}
    for name in case.assumed:
        assert name in parts or name.split(".", 1)[-1] in parts, name


@every_case
def test_the_index_lists_the_case(path):
    assert f"({path.relative_to(ROOT / 'configs')})" in INDEX


def test_the_index_lists_nothing_else():
    listed = set(re.findall(r"\(((?:ch\d+|own)/\w+\.toml)\)", INDEX))
    assert sorted(listed) == [str(path.relative_to(ROOT / "configs")) for path in CASES]


def test_names_are_unique_for_they_name_datasets():
    assert len({path.stem for path in CASES}) == len(CASES)


# Small cases, whole: which of their claims the program contradicts.
QUICK = {
    "ch2/fig_2_01": (),
    "ch2/fig_2_02": (),
    "ch2/fig_2_03": (),
    "ch3/belt_harmonic": (),
    "ch3/fig_3_03": (),
    "ch3/fig_3_13": (3,),
    "ch3/forced_coulomb": (),
    "ch3/forced_stops": (),
    "ch4/plate": (),
    "ch4/sliding_speeds": (),
    "ch5/fig_5_04": (),
    "ch6/equilibria": (5,),
    "ch7/fig_7_02": (),
    "ch7/fig_7_03": (),
    "ch7/fig_7_04": (),
    "ch7/fig_7_05": (),
    "ch7/fig_7_12": (3,),
    "ch7/fig_7_14": (),
    "own/rollers_thrown": (),
    "own/stop_cycle": (),
    "own/stop_flights": (),
    "ch7/equilibrium": (),
}


# Those of them that take longest together: each of its chapter has others here or below.
LONGER = (
    "ch3/forced_coulomb", "ch3/forced_stops", "ch4/sliding_speeds", "ch6/equilibria",
    "ch7/fig_7_02", "ch7/fig_7_04", "ch7/fig_7_05", "ch7/fig_7_12",
)  # fmt: skip


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.campaign] * (name in LONGER), id=name)
        for name in QUICK
    ],
)
def test_a_quick_case_runs_and_its_claims_and_figures_come_out(name, tmp_path):
    path = ROOT / "configs" / f"{name}.toml"
    analyses, contradicted = runs(path, (), tmp_path), QUICK[name]
    every = range(len(load_case(path).claims))
    hold_claims(path, analyses, set(every) - set(contradicted), contradicted)
    for figure in figures_of(analyses):
        assert can_draw(analyses, figure)
        assert draw(analyses, figure).axes


BRIEFLY = ("analysis.0.t_max=50.0",)
ONE_PLACE = ("grid.N0=[30.0]", 'grid.psi_a=["0 deg"]', *BRIEFLY)
COARSE = ("analysis.0.scan=5", "analysis.0.width=0.02", "analysis.0.t_max=40.0")
COARSE_DAMPING = ("grid.c1=[0.0, 0.1, 0.2]", "grid.c2=[0.0, 0.1, 0.2]")

# Cases of many points on a few of them: those that the numbered claims, confirmed and
# contradicted, speak of.
REDUCED = [
    ("ch3/basin_stability", ("grid.v=[1.5, 1.85]",), (1, 3), ()),
    ("own/rollers", ("grid.mu_k=[0.3, 0.4]",), range(4), ()),
    (
        "own/pumped",
        ('grid."initial.x"=[0.8, 1.0]', 'grid."initial.x_dot"=[0.8, 1.0]'),
        range(3),
        (),
    ),
    ("ch7/fig_7_06_reached", ("grid.Omega=[2.0, 8.0]", "grid.N0=[8.0, 30.0]"), range(3), ()),
    (
        "ch7/fig_7_06_exists",
        ("grid.Omega={start=6.0, stop=8.0, step=0.1}", "grid.N0=[30.0]"),
        (),
        (1,),
    ),
    (
        "ch7/basins",
        ('grid."initial.phi"=[-0.1, 0.035]', 'grid."initial.phi_dot"=[-10.0, 0.0]'),
        (0, 1),
        (2, 3),
    ),
    ("ch7/basin_shares", ("grid.Omega=[2.0]", "grid.N0=[30.0]"), (0, 1), ()),
    ("ch7/fig_7_07", ("grid.Omega=[1.0, 2.5, 8.0]",), (0, 1), ()),
    ("ch6/slider_laws", ("grid.mu_k=[0.2, 2.5]",), (0, 1), (2,)),
    ("ch7/fig_7_08", ("grid.N0=[8.0, 15.0, 50.0]",), (0, 1), ()),
    ("ch7/fig_7_09a", ("grid.Omega=[1.0, 5.0]",), (0, 1), ()),
    ("ch7/fig_7_09b", ("grid.N0=[15.0, 50.0]",), (0, 1), ()),
    ("ch7/fig_7_10a", ("grid.Omega=[0.5, 1.5]",), (0, 1), ()),
    ("ch7/fig_7_10b", ("grid.N0=[25.0, 50.0]",), (0, 1), ()),
    ("ch7/fig_7_13", ("grid.Omega=[2.0, 4.0]", *ONE_PLACE), (), (5, 7)),
    (
        "ch7/fig_7_15",
        ('grid.beta=["0 deg", "15 deg"]', "grid.Omega=[2.0, 4.0, 8.0]", *ONE_PLACE),
        (2, 5),
        (),
    ),
    ("ch7/fig_7_16", ("grid.Omega=[1.5, 2.5]", *ONE_PLACE), range(3), ()),
    (
        "ch7/fig_7_17",
        (
            "grid.mu_s=[0.23, 0.3, 0.35, 0.4]",
            "grid.mu_k=[0.2, 0.23, 0.35]",
            "grid.Omega=[2.0, 4.0, 6.0, 9.0]",
            "grid.N0=[30.0]",
        ),
        (0, 1, 4),
        (),
    ),
    ("ch7/sector_equal", ("grid.Omega=[4.0]", *ONE_PLACE), (), (0,)),
    (
        "ch7/sector_survival",
        ("grid.Omega=[1.0, 2.0, 4.0]", 'grid.psi_a=["300 deg"]', "initial.3.count=1", *BRIEFLY),
        (3, 4),
        range(3),
    ),
    ("ch7/normal_force", ("grid.Omega=[0.2, 0.6]",), (0, 1), (2,)),
    ("ch7/equal_coefficients", ("grid.N0=[30.0]",), (0, 1), ()),
    ("ch3/fig_3_05", (), range(7), ()),
    ("ch3/fig_3_06", ("grid.omega=[0.5, 0.85]",), range(4), ()),
    ("ch3/fig_3_07", ("grid.omega=[0.5, 0.85]",), (0, 1), ()),
    (
        "ch3/negative_slope",
        ("grid.c=[0.0, 0.1, 0.2]", "grid.alpha_0=[-0.4, -0.2, 0.0, 0.2]"),
        range(9),
        (),
    ),
    ("ch3/fig_3_09", ("grid.D=[0.3]", "analysis.0.t_end=200.0"), (0, 3), ()),
    ("ch3/fig_3_10", ("grid.D=[0.1, 0.3]", "analysis.0.t_max=10000.0"), range(3), ()),
    ("ch3/fig_3_12", ("grid.mu_k=[4.1, 4.22, 4.24, 6.0]",), range(4), ()),
    ("ch3/fig_3_14", ("grid.mu_k=[4.22, 4.24, 4.82, 4.84, 7.96, 7.98, 12.0]",), range(5), ()),
    ("ch3/fig_3_15", COARSE_DAMPING, range(3), ()),
    ("ch3/fig_3_16", ("grid.mu_k=[4.22, 4.24, 4.8, 4.82, 10.28, 10.3, 12.0]",), range(4), ()),
    (
        "ch3/fig_3_17",
        ("grid.c1=[0.0, 1e-6, 0.05, 0.1]", "grid.c2=[0.0, 2e-6, 0.1, 0.2]"),
        (0, 2, 3, 4, 5),
        (1,),
    ),
    (
        "ch3/neutral_circle",
        ('grid."initial.x"=[1.0, 2.3, 3.6]', 'grid."initial.x_dot"=[-0.5, 0.5, 2.0]'),
        range(3),
        (),
    ),
    ("ch5/critical_friction", ("grid.v=[0.3]",), (0, 1), ()),
    ("ch5/critical_speed", ("grid.F=[100.0]",), (0,), ()),
    ("ch5/fig_5_03", ("grid.mu_k=[0.2, 0.365, 0.37, 0.6]",), range(4), ()),
    (
        "ch5/fig_5_05",
        ('grid.friction=["coulomb"]', "grid.mu_k=[0.7]", "analysis.history.t_end=1.0"),
        range(3),
        (),
    ),
    ("ch5/fig_5_06", ("grid.mu_k=[0.7]", "grid.R=[20.0]"), (0, 1), ()),
    ("ch5/fig_5_07", ("grid.R=[20.0]",), (0,), ()),
    ("ch5/fig_5_06_simulated", ("grid.mu_k=[0.7]", "grid.R=[20.0]", *COARSE), (3,), ()),
    ("ch5/fig_5_07_simulated", ("grid.R=[20.0]", *COARSE), (1,), ()),
    ("ch6/critical_stiff", ("grid.F=[800.0]",), (0, 1), ()),
    ("ch6/fig_6_02", ("grid.mu_k=[0.0, 3.0]",), (0, 1), ()),
    ("ch6/fig_6_03", ("grid.mu_k=[0.0, 3.0]",), (0, 1), ()),
    ("ch6/fig_6_04", ("grid.k_nl=[1e4]", "grid.F=[200.0, 400.0]"), (1,), ()),
    ("ch6/fig_6_05", ("grid.F=[200.0]",), (0,), ()),
    ("ch6/fig_6_06", ("grid.mu_k=[1.8, 1.9]",), (0, 1), ()),
    ("ch6/fig_6_06_critical", ("grid.F=[1000.0]",), range(4), ()),
    ("ch6/fig_6_07", ("analysis.history.t_end=1.0",), range(4), ()),
    ("ch6/fig_6_07_thesis", ("grid.mu_k=[0.3]", "analysis.history.t_end=1.0"), (0,), ()),
    ("ch6/fig_6_08", ("analysis.history.t_end=1.0",), (0,), (1, 2)),
    ("ch6/fig_6_09", ("grid.mu_k=[1.4]", "analysis.0.t_max=40.0"), (4,), ()),
    ("ch6/fig_6_11", ("grid.mu_k=[0.55, 1.3]",), (4, 7, 8, 9, 10, 13), (2, 14)),
    ("ch6/fig_6_13", ("grid.mu_k=[0.1, 0.38, 2.0]",), (0, 1, 2, 4, 5, 6, 7), (8,)),
    ("ch6/fig_6_13_phase", ("analysis.history.t_end=1.0",), range(3), ()),
    ("ch6/fig_6_18c", ("grid.mu_k=[1.8, 2.7]",), (), (1,)),
    ("ch6/fig_6_20", ("grid.mu_k=[0.0, 3.0]",), (0, 1), (2,)),
    ("ch6/fig_6_20_damped", ("grid.mu_k=[0.0, 3.0]",), (0, 1), ()),
    ("ch6/fig_6_20_modes", ("grid.k_nl=[0.0]", "grid.F=[1e4]"), (1, 2, 5, 6), (0, 3)),
    ("ch6/fig_6_22", ("grid.mu_k=[1.01, 1.02]",), range(4), ()),
    ("ch6/fig_6_23", ("grid.k_nl=[1e8]", "grid.F=[1e3, 2e3]"), (3, 4), ()),
    ("ch6/fig_6_23_rigid", ("grid.F=[1e3, 2e3, 3e3, 1e4]",), range(5), ()),
    ("ch6/disc_modes", ('grid.modes=["0,0 0,1 0,2 0,3"]',), (0, 1), ()),
    ("ch6/disc_slip", ("grid.mu_k=[2.9]",), (0, 2), ()),
    ("ch6/fig_6_26", ("grid.xi=[2e-4]", "grid.mu_k=[0.6]"), (8,), ()),
    ("ch6/fig_6_30", ("grid.k_nl=[1e8]", "grid.mu_k=[0.9, 1.2]"), (), (2,)),
    ("ch5/fig_5_08b", ("grid.F=[20.0]",), range(3), ()),
    ("ch5/fig_5_08c", ("grid.Omega=[0.25, 20.25]",), (0,), ()),
    ("ch6/fig_6_32", ("grid.mu_k=[0.3]",), (1,), ()),
    ("ch5/fig_5_09a", (), (0,), ()),
    ("ch5/fig_5_09b", (), (0,), ()),
    ("ch5/fig_5_11a", ("grid.R=[22.0]",), range(3), ()),
    ("ch5/fig_5_12b", ("grid.Omega=[5.25, 10.25]",), (0, 1), ()),
    ("ch5/fig_5_12c", ("grid.Omega=[5.25, 10.25]",), (1,), ()),
    ("ch6/fig_6_28", ("grid.k_nl=[1e8]", "grid.mu_k=[0.4]"), (3,), ()),
]


# Cases whose points take long: a claim on a few of them.
LONG = [
    ("ch7/pin_laws", ("grid.Omega=[1.0, 8.0]",), (), (0, 1)),
    ("ch6/fig_6_34", ("grid.mu_k=[0.3]",), (1,), ()),
    ("ch5/fig_5_08a", ("grid.F=[100.0, 1000.0]",), (0, 2, 3), (1, 4)),
    ("ch5/fig_5_11b", ("grid.R=[22.0]",), range(3), ()),
    ("ch5/fig_5_12a", ("grid.Omega=[5.25, 20.25]",), (0, 1), ()),
    (
        "ch6/fig_6_24",
        ("grid.mu_k=[0.3]", "analysis.history.t_end=0.1", "analysis.response.t_max=20.0"),
        (0,),
        (),
    ),
    ("ch5/fig_5_10a", (), (0, 1), ()),
    ("ch5/fig_5_10b", (), (0, 1), ()),
    ("ch5/fig_5_11a_simulated", ("grid.R=[4.0]",), (4, 5), ()),
    ("ch5/fig_5_11b_simulated", ("grid.R=[4.0]",), (0, 4, 5), ()),
    ("ch4/fig_4_03", ("grid.Omega=[10.0]", "grid.alpha=[10.0]", "grid.c_z=[10.0, 11.0]"), (0,), ()),
    (
        "ch4/modes",
        ('grid.modes=["0,0 0,1 0,2 0,3", "0,0 0,1 0,2 0,3 0,4 0,5 0,6"]',),
        (0,),
        (1, 3, 4, 5),
    ),
    ("ch4/fig_4_04", (), (0, 1), ()),
    ("ch4/fig_4_05", (), (0, 1), ()),
    ("ch4/fig_4_06", (), (0,), ()),
    ("ch4/fig_4_07", (), (0, 1), ()),
    ("ch4/fig_4_08", (), range(1, 6), ()),
    ("ch4/fig_4_10", (), range(5), ()),
    ("ch4/fig_4_13", (), (1, 2, 3), ()),
    ("ch4/fig_4_15", (), (0, 1, 2, 3, 4, 5, 6, 7, 11), (8, 9, 10)),
    ("ch4/fig_4_15_ringing", (), range(7), ()),
    ("ch4/fig_4_18", (), (0, 1), ()),
    ("ch4/fig_4_20", (), range(5), ()),
    ("ch4/fig_4_22a", (), (0, 1), ()),
    ("ch4/fig_4_22b", (), (0, 1), ()),
    ("ch4/fig_4_25", (), (0, 1), ()),
    ("ch7/fig_7_06_cycles", (), (0,), ()),
    ("ch5/fig_5_06_smoothed", ("grid.mu_k=[0.4]", "grid.R=[20.0]"), (0,), ()),
    ("ch6/fig_6_09_cycles", (), (0,), (1,)),
    ("ch6/fig_6_08_thesis", ("grid.mu_k=[1.4]",), (0,), (1,)),
    ("ch6/fig_6_09_thesis", ("grid.mu_k=[1.4, 2.4]",), (0, 3, 4), ()),
    ("ch6/fig_6_09", ("grid.mu_k=[0.3, 1.4, 2.0]",), (0, 3, 4, 7), ()),
    ("ch6/fig_6_10", ("grid.k_nl=[1e4]",), (3, 4), (5,)),
    ("ch6/fig_6_10_thesis", ("grid.k_nl=[0.0]",), (0, 1), ()),
    ("ch6/fig_6_11_thesis", ("grid.k_nl=[0.0]", "grid.mu_k=[0.95, 1.3, 1.45]"), (0, 1), (2,)),
    ("ch6/fig_6_15", ("grid.F=[200.0, 400.0]",), (0, 3, 4), ()),
    ("ch6/fig_6_15_thesis", ("grid.F=[200.0, 600.0]",), (0, 1), ()),
    ("ch6/fig_6_16", (), (0, 1), ()),
    ("ch6/fig_6_16_thesis", ("analysis.history.t_end=1.0",), (0,), (1,)),
    ("ch6/fig_6_17", ("grid.mu_k=[0.1, 0.15]",), (1, 2), ()),
    ("ch6/fig_6_17_thesis", ("grid.mu_k=[0.1, 2.9]",), range(3), ()),
    ("ch6/fig_6_17_slip", ("grid.mu_k={start=1.1, stop=1.8, step=0.1}",), (0,), ()),
    ("ch6/fig_6_18a", ("grid.mu_k=[2.0]",), (1,), ()),
    ("ch6/fig_6_18a_thesis", ("grid.mu_k=[2.5]",), (0, 1), ()),
    ("ch6/fig_6_18b", ("grid.mu_k=[2.7]",), (0, 1), ()),
    ("ch6/fig_6_18d", ("grid.mu_k=[2.0]",), (1,), ()),
    ("ch6/fig_6_18c_cycle", (), range(4), ()),
]


@pytest.mark.parametrize(
    ("name", "overrides", "confirmed", "contradicted"),
    [*REDUCED, *(pytest.param(*row, marks=pytest.mark.campaign) for row in LONG)],
    ids=[row[0] for row in [*REDUCED, *LONG]],
)
def test_claims_on_a_few_points_of_a_large_case(name, overrides, confirmed, contradicted, tmp_path):
    path = ROOT / "configs" / f"{name}.toml"
    hold_claims(path, runs(path, overrides, tmp_path), confirmed, contradicted)


def hold_claims(path, analyses, confirmed, contradicted):
    """What becomes of claims of a case, by their numbers."""
    claims = load_case(path).claims
    for numbers, expected in ((confirmed, CONFIRMED), (contradicted, CONTRADICTED)):
        for claim in (claims[number] for number in numbers):
            verdict = evaluate(claim, analyses, lambda case: None)
            assert verdict.verdict == expected, (claim.text, verdict.found)


def test_every_case_is_run_by_one_of_these_tests():
    run = {*QUICK, *(row[0] for row in [*REDUCED, *LONG])}
    assert run == {str(path.relative_to(ROOT / "configs").with_suffix("")) for path in CASES}


def test_the_demonstration_draws_one_figure():
    """`make demo` names the file of its figure."""
    assert len(load_case(ROOT / "configs/ch7/fig_7_06_reached.toml").figures) == 1
