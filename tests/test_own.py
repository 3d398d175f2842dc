"""Models and laws from outside: known where they are named, refused with the line otherwise."""

from __future__ import annotations

import importlib
import json
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from own_models import CASE, MODEL

from fiv_cli import api, trial
from fiv_cli.case.identity import fingerprint
from fiv_cli.cli.common import TAKE_FILES
from fiv_cli.cli.main import COMMANDS, run
from fiv_cli.errors import ModelFileError, StoreMismatchError
from fiv_cli.friction import TANH_OF, all_laws
from fiv_cli.models import all_models
from fiv_cli.models.origin import Origin
from fiv_cli.notation.names import ascii_name
from fiv_cli.own import load
from fiv_cli.own.check import asymmetry, problems_of
from fiv_cli.own.mechanics import fed_by_damping
from fiv_cli.own.probe import examine, use_files
from fiv_cli.own.template import law_template, model_template
from fiv_cli.reading.changed import changed_since
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import for_stderr
from fiv_cli.sweep.run import run_case


@pytest.fixture(autouse=True)
def _nothing_is_left(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("my.py").write_text(MODEL)
    Path("case.toml").write_text(CASE)
    yield
    use_files(())


def mistaken(*changes: tuple[str, str], folder: str = ".") -> ModelFileError:
    """What is said of the model with these changes."""
    text = MODEL
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = Path(folder) / "my.py"
    path.write_text(text)
    with pytest.raises(ModelFileError) as caught:
        use_files([path])
    return caught.value


def line_of(error: ModelFileError, part: str) -> None:
    """The first problem is told on the line on which `part` stands."""
    line = error.problems[0].line
    text = Path(error.source).read_text().splitlines()
    assert line is not None and part in text[line - 1], error
    assert f"{error.source}:{line}" in str(error)


# --- what is right --------------------------------------------------------------------------------
def test_the_models_and_laws_in_the_box_pass_what_strangers_must():
    quick = [model for model in all_models().values() if "disc" not in model.name]
    laws = [law for name, law in all_laws().items() if not name.startswith(TANH_OF)]
    for thing in [*quick, *laws]:
        assert problems_of(thing, Origin("box", "")) == []


def test_a_model_of_ones_own_is_listed_run_and_told_with_its_text(capsys):
    assert run(["models", "my-belt", "--with", "my.py"]) == 0
    assert "k*x^2/2 + k3*x^4/4" in capsys.readouterr().out
    assert run(["run", "case.toml", "--with", "my.py", "-q", "-o", "a.nc"]) == 0
    (stored,) = json.loads(api.read("a.nc").attrs["own_json"]).values()
    assert stored["text"] == MODEL and stored["holds"] == ["my-belt"]
    assert run(["new", "my-belt", "--with", "my.py"]) == 0
    assert 'law = "coulomb"' in capsys.readouterr().out
    assert "my-belt" not in all_models()


def test_what_to_type_next_names_the_files_that_were_given(capsys):
    Path("bad.toml").write_text(CASE.replace("my-belt", "my-bel"))
    claim = '[[claim]]\nsource = "a"\ntext = "b"\nvariable = "L_s"\nexpect = { less_than = 1 }\n'
    Path("case.toml").write_text(CASE + claim)
    for command, said in (
        ("check bad.toml --with my.py", "`fiv check --with my.py bad.toml`"),
        ("check bad.toml --with=my.py", "`fiv check --with my.py bad.toml`"),
        ("run bad.toml --with my.py", "`fiv check --with my.py bad.toml`"),
        ("models my-bel --with my.py", "next: fiv models --with my.py, or fiv models --with my.py"),
        ("claims case.toml --with my.py", "compute it with: fiv run case.toml --with my.py\n"),
    ):
        run(command.split())
        told = capsys.readouterr()
        assert said in told.out + told.err


def test_the_commands_that_are_told_of_files_are_those_that_take_them():
    taking = [
        name
        for name, (module, _) in COMMANDS.items()
        if "own" in [one.name for one in importlib.import_module(module).command.params]
    ]
    assert sorted(taking) == sorted(TAKE_FILES)


def test_a_case_alone_runs_no_code_and_says_what_to_type(capsys):
    Path("my.py").write_text("open('was_run', 'w')\n" + MODEL)
    for command, said in (("check case.toml", "fiv run case.toml --with my.py"),
                          ("models my-belt", "next: fiv models my-belt --with my.py"),
                          ("new my-belt", "next: fiv new my-belt --with my.py")):  # fmt: skip
        assert run(command.split()) in (2, 3)
        assert said in capsys.readouterr().err
    Path("a.py").write_text(MODEL.replace("MODEL = Model(", "MODEL = Model(("))
    assert run(["check", "case.toml"]) == 3
    assert "--with my.py\n" in capsys.readouterr().err  # not a.py, which cannot be loaded
    Path("my.py").unlink()
    assert run(["check", "case.toml"]) == 3
    assert re.search(
        r"so \(mend its line \d+ first: .*never(.|\n)*--with a\.py", capsys.readouterr().err
    )
    assert not Path("was_run").exists()


def test_a_folder_stands_for_its_files_and_the_environment_for_the_option(monkeypatch, capsys):
    Path("models").mkdir()
    Path("models/one.py").write_text(MODEL)
    Path("models/two.py").write_text(MODEL.replace("my-", "your-"))
    monkeypatch.setenv("FIV_WITH", "models")
    assert run(["models", "--json"]) == 0
    names = [model["name"] for model in json.loads(capsys.readouterr().out)["models"]]
    assert {"my-belt", "your-belt"} <= {*names}


def test_a_law_in_a_file_of_its_own_is_told_to_be_named_too(monkeypatch, capsys):
    text = Path("my.py").read_text().replace('default_law="coulomb"', 'default_law="hill"')
    Path("my.py").write_text(text)
    Path("hill.py").write_text(law_template("hill"))
    assert run(["models", "my-belt", "--with", "my.py"]) == 3
    assert "named with a further --with FILE.py" in capsys.readouterr().err
    assert run(["models", "my-belt", "--with", "my.py", "--with", "hill.py"]) == 0
    monkeypatch.setenv("FIV_WITH", "hill.py")
    assert run(["models", "my-belt", "--with", "my.py"]) == 0


def test_a_name_that_a_file_of_the_environment_has_too_tells_that_it_counts(monkeypatch, capsys):
    Path("old.py").write_text(MODEL)
    monkeypatch.setenv("FIV_WITH", "old.py")
    assert run(["models", "my-belt", "--with", "my.py"]) == 3
    assert "name one of the two files; FIV_WITH counts too" in capsys.readouterr().err


def test_workers_load_the_text_that_was_read_not_the_file():
    case = api.load("case.toml", using="my.py")
    Path("my.py").unlink()
    policy = Policy(workers=2, chunk_points=1, in_process_below=0.0)
    run_case(case, Path("two.nc"), policy, for_stderr(quiet=True))
    run_case(case, Path("one.nc"), Policy(workers=1), for_stderr(quiet=True))
    assert api.read("two.nc").identical(api.read("one.nc"))


def test_a_copy_of_a_model_in_the_box_answers_as_it_does_and_passes_its_trial():
    from fiv_cli.models import pin_on_disc

    text = Path(pin_on_disc.__file__).read_text()
    Path("pin.py").write_text(text.replace('name="pin-on-disc"', 'name="my-pin"'))
    tables = {"schema": 1, "analysis": [{"kind": "response"}], "grid": {"Omega": [2.0, 8.0]}}
    mine, theirs = (
        api.run(api.load({**tables, "model": {"name": name}}, using="pin.py"), workers=1)
        for name in ("my-pin", "pin-on-disc")
    )
    assert mine.drop_attrs().identical(theirs.drop_attrs())
    assert run(["verify", "--with", "pin.py"]) == 0


def test_what_excites_a_model_of_ones_own_is_known_with_it():
    Path("case.toml").write_text(CASE + "[forcing]\nx = { amplitude = 0.5, omega = 1.0 }\n")
    case = api.load("case.toml", using="my.py")
    Path("my.py").write_text(MODEL.replace("displacement", "way"))
    edited = api.load("case.toml", using="my.py")
    assert "force_x" in case.model and set(case.own) == {case.model}
    assert fingerprint(edited) != fingerprint(case)
    found = api.run(case, workers=1)
    assert (found["status"] == 0).all() and "period_ratio" in found


# --- what was edited ------------------------------------------------------------------------------
def test_an_edited_model_meets_neither_old_results_nor_old_code():
    case = api.load("case.toml", using="my.py")
    before = api.run(case, "a.nc", workers=1)
    Path("my.py").write_text(MODEL.replace('p("k3") * x**3', '2 * p("k3") * x**3').replace(
        '* x**4 / 4', '* x**4 / 2'))  # fmt: skip
    edited = api.load("case.toml", using="my.py")
    assert fingerprint(edited) != fingerprint(case)
    changed = r"my-belt: my\.py was changed since\nnext: .*--fresh"
    with pytest.raises(StoreMismatchError, match=changed):
        api.run(edited, "a.nc", workers=1)
    Path("a.nc").unlink()
    with pytest.raises(StoreMismatchError, match=changed):
        api.run(edited, "a.nc", workers=1)
    after = api.run(edited, "a.nc", workers=1, fresh=True)
    assert (after["x_max"] < before["x_max"]).all()
    assert not changed_since(after.attrs, Path("a.nc"))
    Path("my.py").write_text(MODEL)
    assert changed_since(after.attrs, Path("a.nc")).startswith(
        "my.py was changed since: fiv run case.toml"
    )
    again = api.run(case, workers=1)  # a case is what it was loaded as
    assert again["x_max"].equals(before["x_max"])


def test_a_law_on_an_axis_is_known_by_its_text_too():
    text = CASE.replace("[grid]", '[grid]\nfriction = ["coulomb", "my-law"]')
    Path("case.toml").write_text(text)
    before = api.run(api.load("case.toml", using="my.py"), "a.nc", workers=1)
    Path("laws.py").write_text(MODEL[: MODEL.index("MODEL = ")] + MODEL[MODEL.index("LAW = ") :])
    Path("model.py").write_text(MODEL[: MODEL.index("LAW = ")])
    both = api.load("case.toml", using=["model.py", "laws.py"])
    api.run(both, "b.nc", workers=1)
    Path("laws.py").write_text(Path("laws.py").read_text().replace("0.4", "0.3"))
    edited = api.load("case.toml", using=["model.py", "laws.py"])
    after = api.run(edited, "b.nc", workers=1)  # only the points under that law are run again
    coulomb, mine = ({"friction": name} for name in ("coulomb", "my-law"))
    found = [one["x_max"].drop_vars("mu_0") for one in (before, after)]
    assert found[1].sel(coulomb).equals(found[0].sel(coulomb))
    assert not found[1].sel(mine).equals(found[0].sel(mine))
    assert float(after["mu_0"]) == 0.3


# --- what is wrong --------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("changes", "part", "said"),
    [
        ([("MODEL = Model(", "MODEL = Model((")], "Model((", "never closed|was not closed"),
        ([("        kinetic_energy=p(\"m\") * x_dot**2 / 2,\n", "")], "Equations(",
         "not given kinetic_energy"),
        ([("p(\"m\") * x_dot**2 / 2", "0 * x")], "kinetic_energy", "x_dot"),
        ([(" + p(\"k3\") * x**4 / 4", "")], "potential_energy", r"k3\*x\*\*3\*x_dot"),
        ([('"N m-3"', '"N m-2"')], '"k3"', "with another unit of k3"),
        ([('"N m-1"', '"N/mm"')], '"k"', "not in SI"),
        ([('"N m-1"', '"Newton"')], '"k"', "unknown unit"),
        ([('"kg", 1.0', '"kg", -1.0')], '"m"', "out of range"),
        ([('p("k3") * x**3', 'p("k4") * x**3')], "accelerations", "parameter 'k4'"),
        ([('"x", p("N"))', '"x", p("N") * symbols.normal_force(0))')], "p(\"N\")",
         "depends on the force"),
        ([("p(\"v\") - x_dot", "x_dot - p(\"v\")")], "Contact(", "drives its slip"),
        ([("symbols.tangential_force(0) - spring", "-spring")], "accelerations",
         r"changes no velocity .*\n.*tangential_force\(0\) to the force on the body"),
        ([('p["fall"] * slip.speed**2)', 'p["fall"] * slip.v)**0.5'),
          ('"s2 m-2", 1.0', '"s m-1", 2.0')], "force=",
         "a power of what is negative where v is"),
        ([('slip.sign * p["mu_0"]',
           'slip.sign * (1 + sympy.log(1 + 2 * p["fall"] * slip.v * slip.speed)) * p["mu_0"]'),
          ("from fiv_cli.friction", "import sympy\nfrom fiv_cli.friction")],
         "force=", "at v = -1 m/s F_T is no number"),
        ([('(1 + p["fall"]', '(1 - p["fall"]'), ('"s2 m-2", 1.0', '"s2 m-2", 0.1')], "force=",
         r"near v = 3.2 m/s F_T has no bound: it has 1/\(-fall"),
        ([('p["fall"] * slip.speed**2)', '(slip.speed * p["fall"]) ** p["q"])'),
          ('"s2 m-2", 1.0', '"s m-1", 1.0'),
          ("    parameters=(\n        Parameter(\"mu_0\"", "    parameters=(\n        "
           "Parameter(\"q\", \"q\", \"1\", -0.5, \"q\"), Parameter(\"mu_0\"")], "force=",
         "near v = 0 m/s F_T has no bound"),
        ([('p["fall"] * slip.speed**2)', '(p["fall"] * slip.v) ** p["mu_0"])'),
          ('"s2 m-2", 1.0', '"s m-1", 0.5'), ('"1", 0.4, "coefficient', '"1", 3.0, "coefficient')],
         "force=", "a power of what is negative where v is"),
        ([("slip.speed**2)", "slip.speed**2 + slip.states['x'])")], "force=",
         "there is no state 'x'; the law"),
        ([('name="my-belt"', 'name="belt-1dof"')], 'name="belt-1dof"', "comes with fiv"),
        ([('default_law="coulomb"', 'default_law="culomb"')], "default_law", "coulomb"),
        ([("PARAMETERS = (", "import own_models\nPARAMETERS = (")], "import own_models",
         "does not follow"),
        ([('p("N")),),', 'p("N")),) * 2,')], "Model(", "returns 2 contacts"),
        ([('"x", p("N"))', '"x", p("N") + p("k") * x)')], "constant_load", "is not constant"),
        ([('"mu_k": 0.2', '"mu_k": "zwei"')], "law_defaults", "the name of a parameter"),
        ([('"kg", 1.0, "mass"', '"kg", 1.0, "mass", default_from="k"')], '"m"', "and default_from"),
        ([('p("k") * x +', '9.81 * p("m") + p("k") * x +')], "accelerations", "the bare number"),
        ([("states=lambda options: (State", "states=(State")], "states=", "one alone with a comma"),
        ([('"""A mass', 'raise SystemExit(0)\n"""A mass')], "SystemExit", "SystemExit"),
        ([("    return Equations(", "    Equations(")], "MODEL = Model(", "returns NoneType, not"),
        ([('"kg", 1.0', '"kg", 1.0'), ('p("k3") * x**3', '0'), (' + p("k3") * x**4 / 4', "")],
         '"k3"', "no equation depends on it"),
        ([('p("k") * x +', 'p("k") * abs(x) +')], "accelerations", r"Abs\(x\) has no series"),
        ([('p("N")),', '-p("N")),')], "Contact(", "pulls where nothing has moved"),
        ([("constant_load=True", 'base=("z",)')], 'base=("z",)', "there is no state 'z'"),
        ([("constant_load=True", 'forcings=(Forcing("k3", lambda p: p["w"], "pumping"),)'),
          ("Model, Parameter", "Forcing, Model, Parameter")], "Forcing(", "no parameter 'w'"),
        ([('slip.sign * p["mu_0"]', 'p["mu_0"]')], "force=", "drives the slip"),
        ([('p["mu_0"] * N', 'p["mu_0"] * N / 2')], "capacity=", "bears 0.2 N where slip"),
        ([("tangential_force(0)", "tangential_force(1)")], "accelerations",
         "F_T of contact 2, of 1"),
        ([('"x", p("N"))', '"x", p["N"])')], 'p["N"]', r'write \("name"\) for \["name"\]'),
        ([("kinetic_energy=", "kinetic=")], "Equations(",
         "Equations is given 'kinetic', which it does not have\n *did you mean 'kinetic_energy'"),
        ([('p("k3") * x**3', "np.exp(x)"),
          ("PARAMETERS = (", "import numpy as np\nPARAMETERS = (")],
         "np.exp", "use those of sympy"),
        ([("import Contact, ", "import ")], "Contact(", "from fiv_cli.models.base import Contact"),
    ],
    ids=["syntax", "no energy", "no inertia", "energy of a spring", "unit", "not SI",
         "no unit", "default", "parameter", "own force", "sign", "no friction",
         "one side of a power", "one side of a law", "pole", "pole at rest", "signed power",
         "state of a law", "taken", "law",
         "companion", "contacts", "load", "default of a law", "two defaults", "number", "comma",
         "exit", "return",
         "unused", "series", "pull", "base", "frequency", "one way", "capacity",
         "force of no contact", "brackets", "keyword", "numpy", "import"],
)  # fmt: skip
def test_a_mistake_is_told_with_its_line(changes, part, said):
    error = mistaken(*changes)
    assert re.search(said, str(error)), error
    line_of(error, part)
    assert error.exit_code == 3


BRISTLE = {  # of the file that a law is begun with: what it says of states, in place of the rest
    r"    force=lambda.*\n    capacity=.*\n": "    capacity=None,\n",
    "    # (states|rates|force)": r"    \1",
    "import Parameter": "import Parameter, State",
    r'Parameter\("fall".*': 'Parameter("stiff", "s", "m-1", 1e3, "stiffness", minimum=0.0),',
    '4, "coefficient at zero slip", minimum=0.0': '4, "as it slips", minimum=0.0, exclusive=True',
}


def bristle() -> str:
    text = law_template("my-bristle")
    for written, instead in BRISTLE.items():
        assert re.search(written, text)
        text = re.sub(written, instead, text)
    return text


@pytest.mark.parametrize(
    ("old", "new", "part", "said"),
    [
        ('"z": slip.v', '"z": -slip.v', "force=", "drives the slip"),
        ('"z": slip.v', '"y": slip.v', "rates=", "gives the rates of y; its states are z"),
        (r'\{"z": (slip.v.*)\},', r"[\1],", "rates=", "gives list\n.*name of a state: its rate"),
        (r"slip.states\[.z.\] / p\[.mu_0.\]", "slip.v**-2", "rates=", "v in m s-1 and"),
        (r'(p."stiff".*z"\] / p\["mu_0"\])\}', r"(\1) ** 3}", "rates=",
         "no single solution.*\n.*steady=lambda slip, p"),
        (r'"deflection"\),\)', '"deflection"))', "states=", "something else\n.*with a comma"),
        (r'p\["stiff"\]', "p.stiff", "force=|rates=", r'write \["stiff"\] for \.stiff'),
        (r'p\["stiff"\]', 'p["stif"]', "force=", "'stif'; the law has mu_0, stiff\n.*mean"),
        (r'/ p\["mu_0"\]', "/ 0.4", '"mu_0"', "the law does not read it"),
        ("slip.N,", "slip.F,", "force=", "it has v, sign, speed, N, states"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_law_with_a_state_of_its_own_is_told_with_its_line(old, new, part, said):
    text = bristle()
    assert re.search(old, text)
    Path("law.py").write_text(re.sub(old, new, text))
    with pytest.raises(ModelFileError) as caught:
        use_files([Path("law.py")])
    assert re.search(said, str(caught.value)), caught.value
    line = caught.value.problems[0].line
    assert line and re.search(part, Path("law.py").read_text().splitlines()[line - 1]), caught.value


@pytest.mark.parametrize(
    ("name", "instead", "said"),
    [("mu_0", "m", "parameters of one name: m"), ("z", "x", "states of one name: x")],
)
@pytest.mark.parametrize("place", ['[friction]\nlaw = "my-bristle"\n', ""])
def test_a_law_that_shares_a_name_with_the_model_is_refused_with_it(
    name, instead, said, place, capsys
):
    Path("law.py").write_text(bristle().replace(f'"{name}"', f'"{instead}"'))
    axis = "" if place else 'friction = ["coulomb", "my-bristle"]\n'
    table = "[friction.my-bristle]\nstiff = 2e3\n"
    Path("case.toml").write_text(CASE.replace("[grid]\n", f"{place}{table}[grid]\n{axis}"))
    assert run(["check", "case.toml", "--with", "my.py"]) == 3
    assert "law.py has it" in (err := capsys.readouterr().err)
    both = "fiv run --with my.py case.toml --with law.py"  # what was given stays
    assert err.endswith(f"\nnext: add --with law.py: {both}\n")
    assert run(["check", "case.toml", "--with", "my.py", "--with", "law.py"]) == 3
    err = capsys.readouterr().err  # once, where the law is named; not at its table again
    said = f": 'my-bristle' and my-belt have {said}; give it another name in law.py"
    assert "1 problem;" in err and said in err


def test_a_name_that_a_law_declares_is_no_other_spelling_of_another():
    Path("law.py").write_text(law_template("tilted").replace("mu_0", "mu_1"))
    text = CASE.replace("[grid]\n", '[friction]\nlaw = "tilted"\n[grid]\nmu_1 = [0.2, 0.3]\n')
    Path("case.toml").write_text(text)
    case = api.load("case.toml", using=["my.py", "law.py"])
    assert [axis.name for axis in case.axes] == ["mu_1", "v"]
    use_files([Path("my.py")])
    assert ascii_name("mu_1") == "mu_k"  # as the thesis calls it


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("sigma_0 = 1.0", "'sigma_0'(.|\n)*'sigma_0' is of law dahl,"),
        ('law = "linear-slope"\nmu_1 = 0.1', "unknown parameter 'mu_1'\n"),
        ("k_nl = 1.0", r"'k_nl' is of model .*disc-nonlinear-contact.* \(fiv models k_nl\)"),
        ("other-law.mu_0 = 0.1", "law.py has it"),
    ],
)
def test_what_is_not_of_the_laws_in_use_is_told_as_it_was_typed(line, said, capsys):
    Path("law.py").write_text(law_template("other-law"))
    Path("case.toml").write_text(CASE.replace("[grid]\n", f"[friction]\n{line}\n[grid]\n"))
    assert run(["check", "case.toml", "--with", "my.py"]) == 3
    assert re.search(said, capsys.readouterr().err)


def test_a_law_of_ones_own_keeps_its_defaults_but_on_a_model_of_its_author(capsys):
    """A model that comes with fiv sets mu_k for the laws that came with it; it says so."""
    Path("own.py").write_text(MODEL.replace('"mu_0"', '"mu_k"'))
    case = {"schema": 1, "model": {"name": "belt-1dof"}, "analysis": [{"kind": "equilibrium"}]}
    told = "mu_k: the default of"
    for model, law, value, is_of_model in (
        ("belt-1dof", "my-law", 0.4, False),
        ("my-belt", "my-law", 0.2, True),
        ("belt-1dof", "viscous", 0.23, True),
    ):
        loaded = api.load(
            case | {"model": {"name": model}, "friction": {"law": law}}, using="own.py"
        )
        assert loaded.parameters["mu_k"] == value
        assert (told in str(api.check(loaded))) == is_of_model
        assert run(["models", model, "--law", law, "--with", "own.py"]) == 0
        assert re.search(rf"^mu_k .* {value} ", capsys.readouterr().out, re.M)


def test_a_law_that_differs_between_both_sides_is_remarked(capsys):
    assert not any(asymmetry(law) for law in all_laws().values())
    text = law_template("one-sided").replace("slip.speed**2", "slip.speed**2 * (2 + slip.sign)")
    Path("law.py").write_text(text.replace('"s2 m-2", 1.0', '"s2 m-2", 0.1'))
    friction = '[friction]\nlaw = "one-sided"\n[grid]\n'
    Path("belt.toml").write_text(
        CASE.replace('"my-belt"', '"belt-1dof"').replace("[grid]\n", friction)
    )
    for command in (["models", "one-sided"], ["verify"], ["check", "belt.toml"]):
        assert run([*command, "--with", "law.py"]) == 0
        told = "".join(capsys.readouterr())
        assert "at v = -1 m/s |F_T| is 0.364 N, at 1 m/s 0.308 N" in told  # 0.4 / (1.2 +- 0.1)


def test_damping_that_gives_energy_is_remarked(capsys):
    """It may be meant so; that of every model which comes with fiv takes it."""
    assert not any(fed_by_damping(model) for model in all_models().values() if model.contacts)
    Path("my.py").write_text(MODEL.replace('- p("c") * x_dot', '+ p("c") * x_dot'))
    for command in (["models", "my-belt"], ["verify"], ["check", "case.toml"]):
        assert run([*command, "--with", "my.py"]) == 0
        assert "its damping gives energy to some motions" in "".join(capsys.readouterr())


def test_a_contact_that_may_pull_is_remarked(capsys):
    """Friction drove, and no command said a word of it; of a contact that ends or parts it is not
    said."""
    pressed = MODEL.replace('"x", p("N"))', '"x", p("N") - p("k") * x)')
    pressed = pressed.replace("constant_load=True,", "")
    for text, told in (
        (pressed, True),
        (pressed.replace('- p("k") * x)', '- p("k") * x, ends_at_zero_normal_force=True)'), False),
        (MODEL, False),
    ):
        Path("my.py").write_text(text)
        for command in (["models", "my-belt"], ["check", "case.toml"]):
            assert run([*command, "--with", "my.py"]) == 0
            said = " ".join("".join(capsys.readouterr()).split())
            assert (
                "contact 1 cannot part: where its normal force falls below zero" in said
            ) == told


def test_several_files_in_one_word_are_told_apart(monkeypatch, capsys):
    monkeypatch.setenv("FIV_WITH", "my.py other.py")
    assert run(["models"]) == 2
    assert "FIV_WITH=ONE:TWO" in capsys.readouterr().err


def test_what_is_assumed_of_belts_that_hold_jointly_is_told_by_check_and_show(capsys):
    """As `fiv models` tells it; of one belt there is nothing to tell."""
    belt = 'Contact(p("v") - x_dot, "x", p("N"))'
    two = MODEL.replace(belt, f"{belt}, {belt}")
    two = two.replace("force(0) -", "force(0) + symbols.tangential_force(1) -")
    Path("two.py").write_text(two.replace("    constant", "    contacts=2,\n    constant"))
    for name, count in (("two.py", 1), ("my.py", 0)):
        case = ["case.toml", "--with", name]
        assert run(["run", *case, "-q", "-o", f"{name}.nc"]) == 0
        for command in (["check", *case], ["show", f"{name}.nc"]):
            capsys.readouterr()
            assert run(command) == 0
            assert capsys.readouterr().out.count("contacts 1, 2 hold jointly") == count


def test_two_contacts_solved_for_one_coordinate_are_refused_where_the_second_stands():
    contact = 'contacts=(Contact(p("v") - x_dot, "x", p("N")),),'
    second = (
        'contacts=(Contact(p("v") - x_dot, "x", p("N")),\n Contact(-y_dot - x_dot, "x", p("N"))),'
    )
    error = mistaken(
        (contact, second),
        ("    spring =", '    y_dot = symbols.velocity("y")\n    spring ='),
        (' / p("m")}', ' / p("m"), "y": symbols.tangential_force(1) / p("m")}'),
        ("x_dot**2 / 2", "(x_dot**2 + y_dot**2) / 2"),
        ('"displacement"),)', '"displacement"), State("y", "y", "m", "sideways"))'),
        ("    constant_load=True,\n", "    constant_load=True,\n    contacts=2,\n"),
    )
    assert "contacts 1 and 2 are both solved for 'x'" in str(error)
    line_of(error, "-y_dot - x_dot")


@pytest.mark.parametrize(
    ("force", "said"),
    [("", "does not act on its gap"), (" + symbols.normal_force(1)", "closes its gap"),
     (" - symbols.normal_force(1)", "")],
)  # fmt: skip
def test_the_force_of_a_stop_opens_its_gap(force, said):
    """As the file to start from says a stop is written."""
    text = model_template("my-osc")
    stop, *_ = re.findall(r"stop\(gap.*\)\)", text)
    changes = {
        "Parameter, State\n": "Parameter, State, stop\n",
        "PARAMETERS = (\n": 'PARAMETERS = (Parameter("d", "d", "m", 1.0, "place"),\n'
        'Parameter("e", "e", "1", 0.5, "restitution", minimum=0.0, maximum=1.0),\n',
        "            # A stop at x": f"            {stop},\n            # A stop at x",
        "(friction - spring": f"(friction{force} - spring",
        "    default_law=": "    contacts=2, stops=1, default_law=",
    }
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new, 1)
    if not said:
        examine([Origin("osc.py", text)])
        return
    with pytest.raises(ModelFileError, match=said):
        examine([Origin("osc.py", text)])


@pytest.mark.parametrize("hang", ["while True:\n    pass", "sum(range(10**15))"])
def test_what_does_not_end_is_stopped_on_its_line(hang):
    text = f"{hang}\n{MODEL}"
    with pytest.raises(ModelFileError) as caught:
        examine([Origin("endless.py", text)], limit=1.0)
    (problem,) = caught.value.problems
    assert "(1 s to run" in problem.message and problem.line in (1, 2)


def test_a_model_may_name_a_law_of_a_file_that_comes_after_it():
    model, law = MODEL.index("MODEL = "), MODEL.index("LAW = ")
    text = MODEL[:law].replace('default_law="coulomb"', 'default_law="my-law"')
    Path("a.py").write_text(text.replace('{"mu_k": 0.2, "mu_s": 0.4}', "{}"))
    Path("b.py").write_text(MODEL[:model] + MODEL[law:])
    use_files([Path("a.py"), Path("b.py")])
    assert all_models()["my-belt"].default_law in all_laws()


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [("    title=", "    name_of=", "not have"), ('"N m-1"', '"Newton"', "unknown unit")],
    ids=["cannot be run", "is unsound"],
)
def test_what_is_wrong_in_several_files_is_told_at_once(right, wrong, said):
    Path("law.py").write_text(law_template("my-fall").replace("slip.speed**2", "slip.speed**-2"))
    Path("my.py").write_text(MODEL.replace(right, wrong))
    with pytest.raises(ModelFileError) as caught:
        use_files([Path("my.py"), Path("law.py")])
    told = str(caught.value)
    assert said in told and "Law.my-fall.force" in told
    assert told.endswith("correct the files, then `fiv models --with my.py --with law.py`")


def test_a_model_needs_no_defaults_of_laws():
    given = '    law_defaults={"mu_k": 0.2, "mu_s": 0.4},\n'
    assert given in MODEL
    Path("my.py").write_text(MODEL.replace(given, ""))
    use_files([Path("my.py")])
    assert not all_models()["my-belt"].law_defaults


def test_a_folder_may_hold_what_is_no_model():
    Path("script.py").write_text("raise RuntimeError('a script of its own')\n")
    use_files([Path(), Path("./my.py")])
    assert "my-belt" in all_models()


def test_two_files_may_not_hold_one_name():
    Path("other.py").write_text(MODEL)
    with pytest.raises(ModelFileError, match=r"stands in my\.py"):
        use_files([Path("my.py"), Path("other.py")])


def test_what_is_no_model_file_is_said_in_one_line(capsys):
    Path("empty.py").write_text("")
    assert run(["models", "--with", "empty.py"]) == 3
    assert run(["models", "--with", "nowhere.py"]) == 2
    assert "fiv new-model NAME" in capsys.readouterr().err


# --- to start from --------------------------------------------------------------------------------
def test_a_new_model_passes_its_own_test_as_does_a_new_law(capsys):
    for kind in ("model", "law"):
        assert run([f"new-{kind}", f"a-{kind}"]) == 0
        Path(f"{kind}.py").write_text(capsys.readouterr().out)
    Path("stiff.py").write_text(bristle())
    files = ("model.py", "law.py", "stiff.py")
    assert run(["verify", "--json", *(word for file in files for word in ("--with", file))]) == 0
    checks = json.loads(capsys.readouterr().out)["checks"]
    sources = {check["source"] for check in checks}
    assert sources >= {"model.py: a-model", "law.py: a-law", "model.py: a-model with a-law"}
    assert any("derivatives" in check["name"] for check in checks)
    assert run(["new-model", "belt-1dof"]) == 2
    assert run(["new-model", "a model"]) == 2


def test_what_a_file_cannot_compute_is_told_with_its_line(capsys):
    assert run(["new-model", "a-model"]) == 0
    text = capsys.readouterr().out.replace('cycle.values["period"]', 'cycle.values["perod"]')
    Path("model.py").write_text(text)
    assert run(["verify", "--with", "model.py"]) == 5
    (line,) = (n for n, row in enumerate(text.splitlines(), 1) if "perod" in row)
    told = capsys.readouterr()
    assert f"model.py:{line}: verify: there is no 'perod'" in told.out
    assert "5 of 6 checks passed" in told.err


@pytest.mark.parametrize(
    ("given", "said"), [("yield 'T', 3.0, 3.1", "tuple"), ("pass", "NoneType")]
)
def test_what_is_no_check_is_told(given, said):
    text = f"{MODEL}\ndef verify(bench):\n    {given}\n"
    (told,) = trial._of_file(Origin("own.py", text), api.analyse)
    assert not told.passed and f"verify is to yield Check(...), not {said}" in told.name


@pytest.mark.parametrize(("halvings", "passed"), [(0, False), (trial.HALVINGS, True)])
def test_a_sharp_law_asks_for_finer_steps_of_rk4_and_is_not_taken_for_wrong(
    monkeypatch, halvings, passed
):
    monkeypatch.setattr(trial, "HALVINGS", halvings)
    monkeypatch.setattr(trial, "STEPS", 100.0)
    sharp = re.sub(
        "law_defaults={.*}", 'law_defaults={"mu_s": 0.4, "mu_k": 0.25, "v_s": 0.02}', MODEL
    )
    Path("my.py").write_text(sharp.replace('default_law="coulomb"', 'default_law="stribeck"'))
    use_files([Path("my.py")])
    checks = [one for one in trial.try_own() if one.source.endswith("my-belt with stribeck")]
    assert {one.passed for one in checks if "rk4" in one.name} == {passed}


def test_what_a_file_holds_to_be_known_is_checked(capsys):
    assert run(["new-model", "a-model"]) == 0
    wrong = capsys.readouterr().out.replace("x, 0.5, 1e-12", "x, 0.6, 1e-12")
    Path("model.py").write_text(wrong)
    assert run(["verify", "--with", "model.py", "--json"]) == 5
    checks = json.loads(capsys.readouterr().out)["checks"]
    assert [check["name"] for check in checks if not check["passed"]] == ["x of steady sliding (m)"]


PIECED = """\
from fiv_cli.friction.base import Exit, Law, Piece
LAW = Law(
    name="my-pieces", title="a border at 1 m/s", reference="none", numerics_version=1,
    parameters=(), capacity=None,
    force=lambda slip, p: slip.sign * (1 + slip.rows[0][0]) * slip.N / 4,
    pieces=(
        Piece("backward", (0.0,), (Exit("forward", (0,)),)),
        Piece("forward", (1.0,), (Exit("backward", (0,)),)),
    ),
    guards=lambda slip, p: [((1 - 2 * slip.rows[0][0]) * (1 - slip.speed),)],
    resting=lambda v, p: ["forward" if abs(v) > 1.0 else "backward"],
)
"""


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('Exit("forward"', 'Exit("foward"', "there is no piece 'foward'"),
        ("(1.0,), (Exit", "(1.0, 2.0), (Exit", "not as many as those of the others"),
        ('"backward", (0,)', '"backward", (0, 1)', "has not 1 numbers"),
        ('Piece("forward"', 'Piece("fast"', "'fast' is no word that events are booked under"),
        ("(1 - slip.speed),)]", "(1 - slip.speed), 1)]", "gives no 1 guards"),
        ('if abs(v) > 1.0 else "backward"', 'if abs(v) > 1.0 else "slow"', "no piece 'slow'"),
    ],
)
def test_pieces_of_a_law_fit_together(old, new, said):
    Path("law.py").write_text(PIECED)
    use_files([Path("law.py")])
    assert old in PIECED
    Path("law.py").write_text(PIECED.replace(old, new))
    with pytest.raises(ModelFileError, match=re.escape(said)):
        use_files([Path("law.py")])


# --- installed packages ---------------------------------------------------------------------------
def test_an_installed_package_is_known_when_it_is_named(monkeypatch, capsys):
    Path("somebodys.py").write_text(MODEL)
    monkeypatch.syspath_prepend(".")
    entry = SimpleNamespace(
        module="somebodys", value="somebodys:MODEL", dist=SimpleNamespace(name="s", version="1")
    )
    asked = {"fiv.models": [entry], "fiv.laws": []}
    monkeypatch.setattr(load, "entry_points", lambda group: asked[group])
    assert run(["new", "my-belt"]) == 0
    use_files(())
    assert run(["models", "my-belt"]) == 0
    use_files(())
    found = api.run(api.load("case.toml"), workers=1)
    assert "s 1 (somebodys:MODEL)" in json.loads(found.attrs["own_json"])


# --- what it costs --------------------------------------------------------------------------------
def test_models_of_the_box_load_nothing_that_checks():
    program = (
        "from fiv_cli import api\n"
        "case = {'schema': 1, 'model': {'name': 'belt-1dof'}, 'analysis': [{'kind': 'response'}]}\n"
        "api.run(api.load(case), workers=1)\n"
        "import sys; names = [name.split('fiv_cli.own.') for name in sys.modules]\n"
        "print(sorted(name[1] for name in names if len(name) > 1))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.strip() == "['load']"


def test_a_model_is_called_for_with_the_law_that_it_takes(capsys):
    """What is told to type works as it stands."""
    Path("law.py").write_text(bristle())
    Path("my.py").write_text(re.sub(r'default_law="\S+?"', 'default_law="my-bristle"', MODEL))
    Path("case.toml").write_text(CASE)
    assert run(["check", "case.toml"]) == 3
    given = "--with my.py --with law.py"
    assert capsys.readouterr().err.endswith(f"\nnext: add {given}: fiv run case.toml {given}\n")
    assert run(["check", "case.toml", *given.split()]) == 0


@pytest.mark.parametrize(
    ("body", "advice"),
    [
        ("abs(slip.v) * slip.N", "of a slip velocity slip.speed is |v|, slip.sign its sign"),
        ("slip.N if slip.v > 0 else -slip.N", "slip.sign is the sign and slip.speed the modulus"),
    ],
)
def test_a_law_is_told_what_has_the_sign_of_slip(body, advice, capsys):
    law = law_template("my-law")
    force = f"    force=lambda slip, p: {body},"
    Path("law.py").write_text(re.sub(r"(?m)^    force=.*$", force, law, count=1))
    assert run(["verify", "--with", "law.py"]) == 3
    assert advice in capsys.readouterr().err
