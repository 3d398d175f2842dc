"""What is wrong with a damaged dataset is said, by whatever command; nothing of it is believed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import attacks
import h5py
import numpy as np
import pytest

from fiv_cli.cli.main import run as fiv
from fiv_cli.data import hdf5
from fiv_cli.errors import InputError
from fiv_cli.reading.datasets import read_analyses

SEED = 20261122
ENTRY = Path(attacks.__file__)
CONFIGS = ENTRY.parent.parent / "configs"


@pytest.fixture(scope="module")
def ground(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a sound dataset, its case and a sweep."""
    folder = tmp_path_factory.mktemp("ground")
    before = Path.cwd()
    os.chdir(folder)
    name = "response"
    Path(f"{name}.toml").write_text(attacks.CASES[name])
    assert fiv(["run", f"{name}.toml", "--workers", "1", "-q"]) in (0, 4)
    os.chdir(before)
    return folder


@pytest.fixture
def dataset(ground: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy to damage."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "bad.nc"
    path.write_bytes((ground / "runs" / "response.nc").read_bytes())
    return path


DAMAGES = {
    "a variable away": (lambda f: f.__delitem__("reason"), "reason is missing"),
    "flags without names": (
        lambda f: f["attractor"].attrs.__delitem__("flag_meanings"),
        "do not go",
    ),
    "flags of no class": (lambda f: f["status"].__setitem__(0, 99), "status holds a number"),
    "fewer names": (
        lambda f: f["reason"].attrs.create("flag_meanings", "none"),
        "do not go with 1",
    ),
    "rows of negative length": (
        lambda f: f["section_row_size"].__setitem__((0, 0, 0), -1),
        "rows of negative length",
    ),
    "rows that do not add up": (
        lambda f: f["section_row_size"].__setitem__((0, 0, 0), 1000),
        "does not come to",
    ),
    "no dimension of rows": (
        lambda f: f["section_row_size"].attrs.create("sample_dimension", 3.5),
        "sample_dimension is no text",
    ),
    "an axis of NaN": (lambda f: f["v"].__setitem__(0, np.nan), "the axis v"),
    "figures that are none": (lambda f: f.attrs.create("figures_json", "[{}]"), "figures_json"),
    "a title of numbers": (lambda f: f.attrs.create("title", np.arange(3)), "title is no text"),
    "analyses that are none": (lambda f: f.attrs.create("analyses_json", "3"), "analyses_json"),
    "an analysis without a kind": (
        lambda f: f.attrs.create("analyses_json", '{"a": {"settings": {}}}'),
        "analyses_json",
    ),
    "a section of lists": (
        lambda f: f.attrs.create(
            "analyses_json", '{"a": {"kind": "response", "settings": {"section": {"event": []}}}}'
        ),
        "analyses_json",
    ),
    "starts that are none": (lambda f: f.attrs.create("starts_json", "[1]"), "starts_json"),
    "parameters of numbers": (
        lambda f: f.attrs.create("parameters_json", np.arange(3)),
        "parameters_json",
    ),
    "a tolerance of words": (
        lambda f: f.attrs.create("solver_json", '{"rtol": "small"}'),
        "rtol is no number",
    ),
    "files of no text": (lambda f: f.attrs.create("own_json", '{"a.py": {}}'), "own_json holds"),
    "no status": (lambda f: f.__delitem__("status"), "holds no case"),
    "no case": (lambda f: f.attrs.__delitem__("case"), "holds no case"),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_what_is_wrong_is_said_by_every_command(
    dataset: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    change, told = DAMAGES[name]
    with h5py.File(dataset, "r+") as file:
        change(file)
    commands = (["show", "bad.nc"], ["plot", "bad.nc"], ["diff", "bad.nc", "bad.nc"])
    for command in commands:
        assert fiv(command) == 3
        said = capsys.readouterr().err
        assert "bad.nc" in said
        assert told in said
        assert said.splitlines()[-1].startswith(("next: ", "write a dataset with: "))


@pytest.mark.parametrize(
    ("name", "code"), [("starts_json", 0), ("analyses_json", 0), ("fingerprint", 6)]
)
def test_a_run_makes_a_damaged_dataset_of_its_own_again(
    dataset: Path, name: str, code: int, capsys: pytest.CaptureFixture[str]
) -> None:
    """One that does not say any more of which case it is, it leaves alone."""
    Path("response.toml").write_text(attacks.CASES["response"])
    with h5py.File(dataset, "r+") as file:
        file.attrs[name] = np.arange(3)
    assert fiv(["run", "response.toml", "-o", "bad.nc", "-q"]) == code
    if code:
        assert "holds the dataset of another case" in capsys.readouterr().err
    else:
        assert fiv(["show", "bad.nc"]) == 0


def no_contact(file: h5py.File) -> None:
    """A single bit makes the number of a contact a missing one."""
    file["event_contact"][1] ^= -(2**31)


def no_time(file: h5py.File) -> None:
    file["time"][...] = 0.0


def no_width(file: h5py.File) -> None:
    file["boundary_width"][...] = -1.0


@pytest.mark.parametrize(
    ("case", "change", "told"),
    [
        ("history", no_contact, "an event without a contact"),
        ("history", no_time, "time does not go"),
        ("boundary", no_width, "boundary_width holds a negative width"),
    ],
)
def test_what_is_wrong_with_the_values_is_said(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    case: str,
    change: Callable[[h5py.File], None],
    told: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.toml").write_text(attacks.CASES[case])
    assert fiv(["run", "a.toml", "-o", "a.nc", "--workers", "1", "-q"]) == 0
    with h5py.File("a.nc", "r+") as file:
        change(file)
    assert fiv(["plot", "a.nc"]) == 3
    assert told in capsys.readouterr().err


def huge(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        del file["L_s"]
        file.create_dataset("L_s", (10**6, 10**6), "f8", chunks=(100, 100))


def strange_type(path: Path) -> None:
    """The NetCDF library ends the process at this one."""
    with h5py.File(path, "r+") as file:
        shape = file["L_s"].shape
        del file["L_s"]
        file.create_dataset("L_s", data=np.zeros(shape, "f2"))


def half(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-3000])


@pytest.mark.parametrize("change", [huge, strange_type, half])
def test_a_file_that_is_none_any_more_is_refused(dataset: Path, change: object) -> None:
    change(dataset)  # type: ignore[operator]
    with pytest.raises(InputError, match=r"bad\.nc: (not a NetCDF|a damaged) dataset"):
        read_analyses(dataset)
    assert fiv(["run", "response.toml", "-o", "bad.nc"]) == 2  # there is no such case
    Path("response.toml").write_text(attacks.CASES["response"])
    in_the_way = fiv(["run", "response.toml", "-o", "bad.nc", "--workers", "1", "-q"])
    assert in_the_way == (3 if change is half else 0)


def test_no_changed_byte_reaches_what_may_never_return(
    dataset: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At some damaged files HDF5 does not come back: whatever the damage, it is not asked."""
    content = dataset.read_bytes()
    case = dataset.with_name("response.toml")
    case.write_text(attacks.CASES["response"])
    monkeypatch.setattr(h5py, "File", lambda *_: pytest.fail("HDF5 was asked"))
    sealed = len(content) - len(hdf5.SEAL) - hdf5.DIGEST_BYTES
    for place in (0, 8, 40, sealed // 3, sealed // 2, sealed - 1, sealed + len(hdf5.SEAL)):
        damaged = bytearray(content)
        damaged[place] ^= 1
        dataset.write_bytes(damaged)
        for command in ("show bad.nc", "plot bad.nc", "run response.toml -o bad.nc"):
            assert fiv(command.split()) == 3 or place < 8, place


def test_who_changes_a_dataset_is_believed(dataset: Path) -> None:
    """The libraries cut off what follows a file that they write to, and NetCDF reads beside it."""
    import netCDF4

    assert hdf5.SEAL in dataset.read_bytes()
    for title in ("another", "a longer title than any that was there before"):
        with netCDF4.Dataset(dataset, "a") as file:
            file.setncattr("title", title)
        assert hdf5.SEAL not in dataset.read_bytes()
        assert read_analyses(dataset)[""].attrs["title"] == title


def test_texts_of_a_dataset_do_not_steer_the_terminal(
    dataset: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with h5py.File(dataset, "r+") as file:
        file.attrs["title"] = "\x1b[2Ja title\u202e"
    assert fiv(["show", "bad.nc"]) == 0
    said = capsys.readouterr().out
    assert "\\x1b[2Ja title\\u202e" in said
    assert said.replace("\n", "").isprintable()


# --- campaigns ------------------------------------------------------------------------------------
def carried_out(what: str, first: int, count: int, folder: Path) -> dict[str, int]:
    """Attacks in a process of their own; the exit codes, none out of bounds."""
    print(f"attacks on {what}: seed {SEED}, numbers {first} to {first + count - 1}")
    done = subprocess.run(
        [sys.executable, str(ENTRY), what, str(SEED), str(first), str(count)],
        cwd=folder,
        env=os.environ | {"FIV_ATTACK_CASES": str(CONFIGS)},
        capture_output=True,
        text=True,
        check=False,
    )
    lines = done.stdout.splitlines()
    assert done.returncode == 0, f"ended by {done.returncode} at {done.stderr[-200:]}"
    assert [json.loads(line) for line in lines[:-1]] == []
    codes: dict[str, int] = json.loads(lines[-1])["summary"]["codes"]
    print(codes)
    return codes


def test_a_sample_of_damaged_datasets(tmp_path: Path) -> None:
    codes = carried_out("datasets", 0, 12, tmp_path)
    assert codes["show 3"] > 3 and codes["show 0"] > 0


def test_a_sample_of_mutated_cases(tmp_path: Path) -> None:
    codes = carried_out("cases", 0, 100, tmp_path)
    assert codes["check 3"] > 50 and codes["check 0"] > 0


@pytest.mark.campaign
@pytest.mark.parametrize("part", range(8))
def test_damaged_datasets(tmp_path: Path, part: int) -> None:
    """2,000 of them, by every command that reads one."""
    carried_out("datasets", 250 * part, 250, tmp_path)


@pytest.mark.campaign
@pytest.mark.parametrize("part", range(10))
def test_mutated_cases(tmp_path: Path, part: int) -> None:
    """5,000 of them."""
    carried_out("cases", 500 * part, 500, tmp_path)


@pytest.mark.campaign
def test_attacks_from_a_shell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Fifty damaged datasets, each shown by a process of its own."""
    import random

    monkeypatch.chdir(tmp_path)
    attacks.prepare(tmp_path)
    for number in range(50):
        for _, arguments, right in attacks.attacks_on_datasets(random.Random(f"{SEED}/{number}")):
            if arguments[0] != "regress":
                entry = "from fiv_cli.cli.main import main; main()"
                done = subprocess.run(
                    [sys.executable, "-c", entry, *arguments], capture_output=True, check=False
                )
                assert done.returncode in right, f"{number} {arguments} {done.stderr[-300:]!r}"
