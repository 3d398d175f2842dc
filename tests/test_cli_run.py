"""The commands run, status, diff, regress and history through the command line."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import subprocess
import tomllib
from datetime import datetime, timedelta
from math import isfinite
from pathlib import Path
from typing import Any

import pytest

from fiv_cli.cli.main import run as fiv
from fiv_cli.data.netcdf import read_datasets
from fiv_cli.flags import ATTRACTOR
from fiv_cli.sweep.lock import hold
from fiv_cli.sweep.run import LOOKED_AT

EQUILIBRIUM = """
schema = 1
title = "equilibria of the pin"
[model]
name = "pin-on-disc"
[grid]
N0 = [10.0, 20.0]
mu_k = [0.1, 0.2]
[[analysis]]
kind = "equilibrium"
"""

RESPONSE = """
schema = 1
title = "a belt"
[model]
name = "belt-1dof"
parameters = { c = 0.1 }
[grid]
v = [0.5, 1.0]
[[initial]]
label = "rest"
kind = "state"
[[initial]]
label = "fast"
kind = "state"
state = { x_dot = "v" }
[[analysis]]
kind = "response"
t_max = 200.0
"""


MIXED = """
schema = 1
[model]
name = "pin-on-disc"
[grid]
N0 = [20.0, 30.0]
Omega = { start = 2, stop = 5, num = 4 }
[[initial]]
label = "far"
kind = "state"
state = { phi_dot = "Omega" }
[[initial]]
label = "any"
kind = "random"
box = { phi = [-0.1, 0.1], theta_dot = [-1.0, 1.0] }
[[initial]]
label = "down"
kind = "continue"
along = "Omega"
direction = "down"
from = "far"
on_loss = "restart"
[[analysis]]
kind = "response"
t_max = 30.0
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every test in a folder of its own, with a case in it."""
    monkeypatch.chdir(tmp_path)
    Path("pin.toml").write_text(EQUILIBRIUM)
    Path("belt.toml").write_text(RESPONSE)


def test_a_case_becomes_a_dataset_whose_path_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert fiv(["run", "pin.toml"]) == 0
    out, err = capsys.readouterr()
    assert out == "runs/pin.nc\n"
    assert "4 points: 4 ok" in err
    assert read_datasets(Path("runs/pin.nc"))[""].attrs["title"] == "equilibria of the pin"


def test_quiet_says_nothing_but_the_path(capsys: pytest.CaptureFixture[str]) -> None:
    assert fiv(["run", "pin.toml", "-q"]) == 0
    assert capsys.readouterr() == ("runs/pin.nc\n", "")


def test_an_answer_counts_what_the_grid_has_by_now(capsys: pytest.CaptureFixture[str]) -> None:
    """Not points of an earlier grid, which are kept."""
    case = """\
        schema = 1
        [model]
        name = "flutter-2dof"
        [grid]
        c1 = [0.1, 0.2, 0.3]
        [[analysis]]
        kind = "critical"
        parameter = "mu_k"
        bracket = [0.0, 60.0]
        """
    Path("flutter.toml").write_text(case)
    for grid, count in (("[0.1, 0.2, 0.3]", 3), ("[0.3, 0.4]", 2)):
        assert fiv(["run", "flutter.toml", "--set", f"grid.c1={grid}", "-o", "flutter.nc"]) == 0
        assert f" ({count}, within " in capsys.readouterr().err


def test_a_dataset_that_is_not_written_is_not_named_on_stdout(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("fiv_cli.sweep.run.VAST", 1)
    assert fiv(["run", "pin.toml", "--max-points", "0"]) == 8
    out, err = capsys.readouterr()
    assert not out and "runs/pin.nc is not written" in err


def test_several_cases_and_overrides(capsys: pytest.CaptureFixture[str]) -> None:
    assert fiv(["run", "pin.toml", "belt.toml", "-q"]) == 0
    assert capsys.readouterr().out == "runs/pin.nc\nruns/belt.nc\n"
    assert fiv(["run", "pin.toml", "--set", "grid.N0=[10.0]", "-q"]) == 0
    (path,) = capsys.readouterr().out.split()
    assert path.startswith("runs/pin-")
    assert read_datasets(Path(path))[""].sizes["N0"] == 1


def test_everything_wrong_with_any_case_is_said_before_anything_runs(
    capsys: pytest.CaptureFixture[str],
) -> None:
    Path("bad.toml").write_text(EQUILIBRIUM.replace("N0", "NO"))
    Path("worse.toml").write_text("schema = 2")
    assert fiv(["run", "pin.toml", "bad.toml", "worse.toml"]) == 3
    err = capsys.readouterr().err
    assert "bad.toml" in err and "worse.toml" in err
    assert not Path("runs").exists()


def test_usage_errors(capsys: pytest.CaptureFixture[str]) -> None:
    Path("notes.nc").write_text("notes")
    Path("copy").mkdir()
    shutil.copy("pin.toml", "copy/pin.toml")
    for arguments in (
        ["run", "missing.toml"],
        ["run", "pin.toml", "belt.toml", "-o", "x.nc"],
        ["run", "pin.toml", "copy/pin.toml"],
        ["run", "pin.toml", "-o", "notes.nc"],
        ["run", "pin.toml", "-o", "copy"],
        ["run", "pin.toml", "--workers", "0"],
        ["run"],
    ):
        assert fiv(arguments) == 2, arguments
        assert "Traceback" not in capsys.readouterr().err


def test_the_dataset_of_another_case_is_left_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert fiv(["run", "pin.toml", "-q", "-o", "x.nc"]) == 0
    before = Path("x.nc").read_bytes()
    assert fiv(["run", "belt.toml", "-q", "-o", "x.nc"]) == 6
    assert Path("x.nc").read_bytes() == before
    assert fiv(["run", "belt.toml", "-q", "-o", "x.nc", "--fresh"]) == 0


def test_of_several_cases_none_is_run_where_one_could_not_be_stored(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Nor is the motion of a point replaced by a sweep."""
    assert fiv(["run", "pin.toml", "-q"]) == 0
    Path("pin.toml").write_text(EQUILIBRIUM + "[solver]\nrtol = 1e-8\n")
    assert fiv(["run", "belt.toml", "pin.toml"]) == 6
    told = capsys.readouterr().err
    assert "pin.toml: of the 2 cases none is run\nruns/pin.run: holds results of" in told
    assert not Path("runs/belt.nc").exists()
    assert (
        fiv(["history", "belt.toml", "--at", "v=0.5,initial=fast", "-o", "one.nc", "--t-end", "1"])
        == 0
    )
    before = Path("one.nc").read_bytes()
    capsys.readouterr()
    assert fiv(["run", "belt.toml", "-o", "one.nc"]) == 6
    assert "one.nc: holds the motion at " in capsys.readouterr().err
    assert Path("one.nc").read_bytes() == before


def test_status_before_between_and_after(capsys: pytest.CaptureFixture[str]) -> None:
    assert fiv(["status", "pin.toml"]) == 0
    assert "0 of 4 points done" in capsys.readouterr().out
    assert fiv(["run", "pin.toml", "--max-points", "3", "-q"]) == 8
    capsys.readouterr()
    assert fiv(["status", "pin.toml", "--exit-code"]) == 8
    told = capsys.readouterr().out
    assert "runs/pin.nc (partial)\n  nobody is running it; the same `fiv run` goes on" in told
    assert re.search(r"  the last run that computed points: .* points/s( of late)?, some ", told)
    log, ago = Path("runs/pin.run/run.log"), datetime.now().astimezone() - timedelta(seconds=100)
    lines = [line.split(" ", 1)[1] for line in log.read_text().splitlines(keepends=True)[:2]]
    points = log.read_text().splitlines(keepends=True)[2:]
    log.write_text("".join([*(f"{ago.isoformat()} {line}" for line in lines), *points]))
    with hold(Path("runs/pin.run")):  # as a run that began a while ago
        assert fiv(["status", "pin.toml"]) == 0
    told = capsys.readouterr().out  # the points came in some s
    assert re.search(r"is running it: 100 s elapsed, 0\.03\d* points/s, some [23]\d s to go", told)
    assert fiv(["show", "runs/pin.nc"]) == 0
    assert "partial      3 of 4 points" in capsys.readouterr().out
    assert fiv(["plot", "runs/pin.nc", "--figure", "curve"]) == 0
    assert "runs/pin.nc: partial, 3 of 4 points" in capsys.readouterr().err
    claim = '\n[[claim]]\nsource = "a"\ntext = "b"\nvariable = "n_solutions"\n'
    Path("pin.toml").write_text(f"{EQUILIBRIUM}{claim}expect = {{ greater_than = 0 }}")
    assert fiv(["claims", "pin.toml"]) == 0
    told = capsys.readouterr().out
    assert "computed (pending 1); the run has 3 of 4 points, go on with: fiv run pin.toml\n" in told
    assert fiv(["status", "pin.toml", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert fiv(["status", "pin.toml", "--set", "model.parameters.k1=1", "-o", "runs/pin.nc"]) == 0
    told = "runs/pin.nc (partial, of another version of the case)\n  what is stored belongs"
    assert told in capsys.readouterr().out
    assert document["counts"]["ok"] == 3
    assert document["counts"]["pending"] == 1
    assert document["running"] is None
    assert fiv(["run", "pin.toml", "-q"]) == 0
    capsys.readouterr()
    assert fiv(["status", "pin.toml", "--set", "model.parameters.k1=1", "-o", "runs/pin.nc"]) == 0
    assert "runs/pin.nc (complete, of another version of the case)" in capsys.readouterr().out
    longer = ["--set", "grid.N0=[10.0, 20.0, 30.0]", "-o", "runs/pin.nc"]
    assert fiv(["status", "pin.toml", *longer]) == 0
    assert (
        "runs/pin.nc (complete, of another grid or other starts; `fiv run` writes"
        in capsys.readouterr().out
    )
    pinned = ["--set", "grid.N0=[10.0, 25.0]", "-o", "runs/pin.nc"]  # as many, and as whole
    assert fiv(["run", "pin.toml", *pinned, "-q"]) == 0
    capsys.readouterr()
    assert fiv(["status", "pin.toml"]) == 0
    assert "(complete, of another grid or other starts; `fiv run`" in capsys.readouterr().out
    assert fiv(["run", "pin.toml", "-q"]) == 0
    assert fiv(["run", "pin.toml", *longer, "--max-points", "1", "-q"]) == 8
    capsys.readouterr()
    assert fiv(["status", "pin.toml"]) == 0
    told = capsys.readouterr().out
    assert (
        "4 of 4 points done" in told
        and "runs/pin.nc (partial, of another grid or other starts; " in told
    )
    assert fiv(["run", "pin.toml", "-q"]) == 0
    shutil.rmtree("runs/pin.run")  # as --fresh does first
    capsys.readouterr()
    assert fiv(["status", "pin.toml"]) == 0
    assert "(complete, as it was before; `fiv run` writes it anew)" in capsys.readouterr().out
    assert fiv(["run", "pin.toml", "--max-points", "1", "-q"]) == 8
    shutil.rmtree("runs/pin.run")
    capsys.readouterr()
    assert fiv(["status", "pin.toml"]) == 0
    assert "(partial, as it was before; `fiv run` writes it anew)" in capsys.readouterr().out


def test_status_looks_again_where_a_live_run_has_merged_its_files(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file that was listed is gone when it is read: what it held lies in another by then."""
    from fiv_cli.data.shard import UnreadableShard
    from fiv_cli.sweep.journal import Journal

    assert fiv(["run", "pin.toml", "-q"]) == 0
    blocks, looks = Journal.blocks, []

    def gone_once(journal: Journal, index: int) -> Any:
        looks.append(index)
        if len(looks) == 1:
            raise UnreadableShard("no file")
        return blocks(journal, index)

    monkeypatch.setattr(Journal, "blocks", gone_once)
    assert fiv(["status", "pin.toml"]) == 0
    assert "4 of 4 points done" in capsys.readouterr().out and len(looks) > 1


def test_status_says_how_many_of_the_points_that_are_done_failed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    limited = ["--time-limit", "1e-5", "--max-points", "1", "-q"]
    assert fiv(["run", "pin.toml", *limited]) == 4
    capsys.readouterr()
    assert fiv(["status", "pin.toml"]) == 0
    told = "pin.toml: 1 of 4 points done, of which 1 failed\n"
    assert capsys.readouterr().out.startswith(told)


def test_a_class_that_t_max_leaves_open_is_an_answer_a_motion_out_of_events_is_none(
    capsys: pytest.CaptureFixture[str],
) -> None:
    Path("short.toml").write_text(RESPONSE.replace("200.0", "15.0"))
    assert fiv(["run", "short.toml", "--workers", "1"]) == 0
    assert "time_budget 4" in capsys.readouterr().err
    Path("few.toml").write_text(f"{RESPONSE}[solver]\nmax_events = 1\n")
    assert fiv(["run", "few.toml", "--workers", "1"]) == 4
    assert "too_many_events" in capsys.readouterr().err
    assert fiv(["status", "few.toml"]) == 0
    told = "few.toml: 4 of 4 points done, of which 4 met max_steps or max_events\n"
    assert capsys.readouterr().out.startswith(told)
    assert fiv(["run", "--help"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "4 where some failed or met max_steps or max_events" in told


def test_diff(capsys: pytest.CaptureFixture[str]) -> None:
    fiv(["run", "pin.toml", "-q", "-o", "a.nc"])
    fiv(["run", "pin.toml", "-q", "-o", "b.nc"])
    fiv(["run", "pin.toml", "-q", "-o", "c.nc", "--set", "model.parameters.k1=1501.0"])
    capsys.readouterr()
    assert fiv(["diff", "a.nc", "b.nc"]) == 0
    assert "agree" in capsys.readouterr().out
    assert fiv(["diff", "a.nc", "c.nc"]) == 5
    assert "equilibrium: " in capsys.readouterr().out
    assert fiv(["diff", "a.nc", "c.nc", "--json"]) == 5
    found = json.loads(capsys.readouterr().out)
    assert not found["equal"]
    Path("loose.toml").write_text("[default]\nrtol = 0.1\n")
    assert fiv(["diff", "a.nc", "c.nc", "--tolerances", "loose.toml"]) == 0
    Path("text.nc").write_text("no")
    assert fiv(["diff", "a.nc", "text.nc"]) == 3
    assert fiv(["diff", "a.nc", "missing.nc"]) == 2


def sweep_folder() -> Path:
    """A regression sweep with a fresh reference."""
    folder = Path("sweeps/pin")
    folder.mkdir(parents=True)
    shutil.copy("pin.toml", folder / "case.toml")
    assert fiv(["run", "pin.toml", "-q", "-o", str(folder / "reference.nc")]) == 0
    shutil.rmtree(folder / "reference.run")
    return folder


def test_regress_agrees_until_an_answer_changes(capsys: pytest.CaptureFixture[str]) -> None:
    folder = sweep_folder()
    capsys.readouterr()
    assert fiv(["regress"]) == 0
    assert "pin: agrees" in capsys.readouterr().out
    fiv(["run", "pin.toml", "-q", "-o", "c.nc", "--set", "model.parameters.k1=1501.0"])
    shutil.copy("c.nc", folder / "reference.nc")
    assert fiv(["regress"]) == 5
    assert "against" in capsys.readouterr().out
    assert fiv(["regress", str(folder)]) == 5
    assert fiv(["regress", "nowhere"]) == 2


def test_a_sweep_without_a_reference_says_how_to_make_one(
    capsys: pytest.CaptureFixture[str],
) -> None:
    (sweep_folder() / "reference.nc").unlink()
    assert fiv(["regress"]) == 2
    assert "--regenerate" in capsys.readouterr().err


def test_regenerate_needs_a_clean_tree(capsys: pytest.CaptureFixture[str]) -> None:
    folder = sweep_folder()
    identity = ["-c", "user.name=t", "-c", "user.email=t@t"]
    for arguments in (["init", "-q"], ["add", "."], [*identity, "commit", "-qm", "x"]):
        subprocess.run(["git", *arguments], check=True)
    (folder / "case.toml").write_text(EQUILIBRIUM + "\n# changed\n")
    assert fiv(["regress", "--regenerate"]) == 2
    subprocess.run(["git", *identity, "commit", "-qam", "y"], check=True)
    assert fiv(["regress", "--regenerate"]) == 0
    assert fiv(["regress"]) == 0


def test_the_real_engine_leaves_no_trace_of_how_it_was_run() -> None:
    """Continued, random and plain starts; one process, two workers, two goes."""
    Path("mixed.toml").write_text(MIXED)
    fiv(["run", "mixed.toml", "-q", "-o", "a.nc", "--workers", "1"])
    fiv(["run", "mixed.toml", "-q", "-o", "b.nc", "--time-limit", "600"])
    fiv(["run", "mixed.toml", "-q", "-o", "c.nc", "--max-points", "7"])
    fiv(["run", "mixed.toml", "-q", "-o", "c.nc"])
    expected = Path("a.nc").read_bytes()
    assert Path("b.nc").read_bytes() == expected
    assert Path("c.nc").read_bytes() == expected
    dataset = read_datasets(Path("a.nc"))[""]
    assert float(dataset["energy_residual"].max()) < 1e-9
    assert (dataset["attractor"].sel(initial="far") == ATTRACTOR.codes["periodic"]).any()


def test_history_of_a_point(capsys: pytest.CaptureFixture[str]) -> None:
    assert fiv(["history", "belt.toml", "--at", "v=0.5,initial=fast", "--t-end", "5"]) == 0
    out, err = capsys.readouterr()
    path = Path(out.strip())
    assert path == Path("runs/belt-history-v=0.5_initial=fast.nc")
    dataset = read_datasets(path)[""]
    assert dataset["time"].values[-1] == 5.0
    assert dataset["v"].values.tolist() == [0.5]
    assert float(dataset["x_dot"].isel(time=0).item()) == 0.5
    assert dataset.attrs["point"] == "v=0.5, initial=fast"
    when, end = err.splitlines()[-1].split(": ", 1)
    last = {name: dataset[name].values.ravel()[-1] for name in ("x", "x_dot")}
    assert (when, tomllib.loads(end)) == ("at t = 5 s", {"state": last})


def test_history_of_a_motion_that_ends_early_says_why_and_where(
    capsys: pytest.CaptureFixture[str],
) -> None:
    at = "Omega=7.5,N0=5,initial=far"
    Path("pin.toml").write_text(
        'schema = 1\n[model]\nname = "pin-on-disc"\n[grid]\nOmega = [7.5]\nN0 = [5.0]\n'
        '[[initial]]\nlabel = "far"\nkind = "state"\nstate = { phi_dot = "Omega" }\n'
        '[[analysis]]\nkind = "response"\n'
    )
    assert fiv(["history", "pin.toml", "--at", at, "--t-end", "1", "-o", "pin.nc"]) == 0
    *_, why, end, more = capsys.readouterr().err.splitlines()
    assert why.startswith("contact_lost: ") and "normal force" in why
    assert more.startswith("it ended before 0.0") and ": --t-end 0.0" in more
    finer = more.partition("--t-end ")[2].partition(",")[0]
    assert fiv(["history", "pin.toml", "--at", at, "--t-end", finer, "-o", "finer.nc"]) == 0
    known = [int(read_datasets(Path(f))[""]["phi"].count()) for f in ("pin.nc", "finer.nc")]
    assert known[1] > 5 * known[0]
    when, state = end.split(": ", 1)
    assert 0.05 < float(when.split()[3]) < 0.2
    assert all(map(isfinite, tomllib.loads(state)["state"].values()))


@pytest.mark.parametrize(
    "at",
    ["v=0.7,initial=fast", "v=0.5", "v=0.5,initial=slow", "w=1", "v", "v=0.5,v=1.0,initial=rest"],
)
def test_history_off_the_grid(capsys: pytest.CaptureFixture[str], at: str) -> None:
    assert fiv(["history", "belt.toml", "--at", at]) == 2
    assert "next:" in capsys.readouterr().err
    assert not Path("runs").exists()


def test_history_does_not_replace_a_sweep(capsys: pytest.CaptureFixture[str]) -> None:
    fiv(["run", "belt.toml", "-q"])
    at = ["--at", "v=0.5,initial=rest", "--t-end", "2 s"]
    assert fiv(["history", "belt.toml", *at, "-o", "runs/belt.nc"]) == 2
    assert fiv(["history", "belt.toml", *at, "-o", "motion.nc"]) == 0
    assert "replaced" not in capsys.readouterr().err
    assert fiv(["history", "belt.toml", *at, "-o", "motion.nc"]) == 0
    told = "motion.nc: the motion at v=0.5, initial=rest that it held is replaced"
    assert told in capsys.readouterr().err
    assert fiv(["history", "belt.toml", *at, "--sample", "-1"]) == 2


@pytest.mark.parametrize(("text", "why"), [("nan", "must be finite"), ("-1", "positive time")])
def test_history_to_no_time(capsys: pytest.CaptureFixture[str], text: str, why: str) -> None:
    at = ["--at", "v=0.5,initial=rest", "--t-end", text]
    assert fiv(["history", "belt.toml", *at]) == 2
    refused = capsys.readouterr().err
    assert refused.startswith(f"--t-end {text}: ") and why in refused


def test_what_another_output_holds_of_the_same_case_is_told_before_it_is_run_anew(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert fiv(["run", "pin.toml", "-q"]) == 0
    longer = ["run", "pin.toml", "--set", "grid.N0=[10.0, 20.0, 30.0]"]
    capsys.readouterr()
    assert fiv([*longer, "-o", "other.nc", "--max-points", "1"]) == 8
    told = "4 points of it lie in runs/pin.run; the same run with -o runs/pin.nc (in Python: "
    assert told in capsys.readouterr().err
    assert fiv([*longer, "-o", "other.nc", "--max-points", "1"]) == 8  # it has points of its own
    assert fiv([*longer, "-o", "other.nc", "--max-points", "1", "--fresh"]) == 8
    assert fiv(["run", "pin.toml", "--set", "grid.N0=[20.0, 31.0, 32.0]", "-o", "few.nc"]) == 0
    assert "lie in" not in capsys.readouterr().err
    assert fiv([*longer, "-o", "runs/pin.nc"]) == 0
    assert "6 points, 4 already stored, 2 to run" in capsys.readouterr().err


def test_a_run_does_not_read_all_runs_beside_it(monkeypatch: pytest.MonkeyPatch) -> None:
    for number in range(3 * LOOKED_AT):
        Path(f"runs/{number}.run").mkdir(parents=True)
    read: list[Path] = []
    monkeypatch.setattr("fiv_cli.sweep.journal.stored_identity", lambda path: read.append(path))
    assert fiv(["run", "pin.toml", "-q"]) == 0
    assert len(set(read)) <= LOOKED_AT + 1  # and its own


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("20.0]", "20.0, 30.0]", "(other values in the grid): fiv run pin.toml\n"),
        ('"pin-on-disc"', '"pin-on-disc"\nparameters = { c1 = 3.0 }', "parameters.c1: stored "),
        ('"equilibrium"', '"equilibrium"\n[[figure]]\nkind = "curve"\nx = "N0"', "(other figures)"),
        ('"pin-on-disc"', '"pin"', "pin.toml was changed since (fiv status pin.toml says whether"),
        ("equilibria of the pin", "another title", ""),
    ],
)  # fmt: skip
def test_a_figure_of_what_the_case_was_says_so(
    capsys: pytest.CaptureFixture[str], old: str, new: str, told: str
) -> None:
    assert fiv(["run", "pin.toml", "-q"]) == 0
    Path("pin.toml").write_text(EQUILIBRIUM.replace(old, new))
    capsys.readouterr()
    assert fiv(["plot", "runs/pin.nc", "--figure", "curve"]) == 0
    said, warning = capsys.readouterr().err, "WARNING: runs/pin.nc is drawn as it was run; pin.toml"
    assert told in said
    assert (warning in said) == bool(told)


def test_a_line_of_what_another_case_was_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    lined = 'kind = "map"\nvariable = "growth_rate"'
    Path("map.toml").write_text(
        EQUILIBRIUM.replace("equilibrium", "eigenvalues")
        + f"[[figure]]\n{lined}\nlevel = {{ 'pin:n_solutions' = 1.5 }}\n"
    )
    assert [fiv(["run", name, "-q"]) for name in ("pin.toml", "map.toml")] == [0, 0]
    assert fiv(["plot", "runs/map.nc"]) == 0
    assert "as it was run" not in capsys.readouterr().err
    Path("pin.toml").write_text(EQUILIBRIUM.replace("0.2]", "0.2, 0.3]"))
    assert fiv(["plot", "runs/map.nc"]) == 0
    told = "what is drawn of pin is of runs/pin.nc as it was run; pin.toml was changed since (other"
    assert told in capsys.readouterr().err


def test_what_a_warning_says_to_run_takes_it_away(capsys: pytest.CaptureFixture[str]) -> None:
    """Also of a dataset that was run with settings of its own, to a file of its own."""
    assert fiv(["run", "pin.toml", "-q", "--set", "grid.N0=[20.0, 31.0]", "-o", "other.nc"]) == 0
    Path("pin.toml").write_text(EQUILIBRIUM + '[[figure]]\nkind = "curve"\nx = "N0"\n')
    capsys.readouterr()
    assert fiv(["plot", "other.nc", "--figure", "curve"]) == 0
    advised = capsys.readouterr().err.split("(other figures): ")[1].splitlines()[0]
    assert fiv([*shlex.split(advised)[1:], "-q"]) == 0
    capsys.readouterr()
    assert fiv(["plot", "other.nc", "--figure", "curve"]) == 0
    assert "WARNING" not in capsys.readouterr().err
