"""Files are written whole, and through nobody's link, pipe or device."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from small_cases import PIN as CASE

from fiv_cli import files
from fiv_cli.cli.main import run as fiv
from fiv_cli.errors import UsageError


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a case in it."""
    monkeypatch.chdir(tmp_path)
    Path("s.toml").write_text(CASE)
    Path("m.toml").write_text(CASE.replace("equilibrium", "history") + "t_end = 1.0\n")
    return tmp_path


def test_what_was_there_is_replaced_and_nothing_is_left(here: Path) -> None:
    path = here / "a"
    for content in (b"first", b"second"):
        files.write_whole(path, content)
        assert path.read_bytes() == content
    assert {one.name for one in here.iterdir()} == {"a", "s.toml", "m.toml"}


def test_a_new_file_has_the_permissions_that_the_umask_leaves(here: Path) -> None:
    before = os.umask(0o027)
    try:
        files.write_whole(here / "a", b"")
    finally:
        os.umask(before)
    assert (here / "a").stat().st_mode & 0o777 == 0o640


def test_a_link_is_replaced_not_written_through(here: Path) -> None:
    (here / "victim").write_text("kept")
    (here / "a").symlink_to("victim")
    files.write_whole(here / "a", b"new")
    assert (here / "victim").read_text() == "kept"
    assert (here / "a").read_bytes() == b"new"


def test_a_name_that_is_taken_is_not_written_through(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Even where somebody foresaw it."""
    (here / "victim").write_text("kept")
    monkeypatch.setattr(files.secrets, "token_hex", lambda count: "foreseen")
    (here / f".a.foreseen{files.SUFFIX}").symlink_to("victim")
    with pytest.raises(FileExistsError):
        files.write_whole(here / "a", b"new")
    assert (here / "victim").read_text() == "kept"


def test_a_file_that_is_exchanged_while_it_is_written_does_not_count(here: Path) -> None:
    with (
        pytest.raises(OSError, match="another file was put in its place"),
        files.replacing(here / "a") as temporary,
    ):
        temporary.unlink()
        temporary.write_bytes(b"another's")
    assert {one.name for one in here.iterdir()} == {"s.toml", "m.toml"}


@pytest.mark.parametrize("name", [".s.nc.tmp", "s.run/run.log", "s.run/lock", "s.run/.beat-0"])
def test_links_planted_where_a_run_writes_are_not_followed(here: Path, name: str) -> None:
    victim = here / "victim"
    victim.write_text("kept")
    (here / name).parent.mkdir(exist_ok=True)
    (here / name).symlink_to(victim)
    assert fiv(["run", "s.toml", "-o", "s.nc", "--workers", "1"]) in (0, 2)
    assert victim.read_text() == "kept"


@pytest.mark.parametrize("name", ["identity.json", "case.toml", "shards/000000.h5"])
def test_links_to_files_of_others_in_a_journal_are_not_followed(here: Path, name: str) -> None:
    victim = here / "victim"
    victim.write_text("kept")
    (here / "s.run" / "shards").mkdir(parents=True)
    (here / "s.run" / name).symlink_to(victim)
    assert fiv(["run", "s.toml", "-o", "s.nc", "--workers", "1"]) == 0
    assert victim.read_text() == "kept"


COMMANDS = [
    ["run", "s.toml", "--workers", "1", "-o"],
    ["history", "m.toml", "--at", "mu_k=0.1", "--t-end", "1", "-o"],
    ["plot", "--law", "coulomb", "-o"],
]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command[0])
@pytest.mark.parametrize("kind", ["pipe", "link to a pipe", "device", "folder"])
def test_only_a_regular_file_or_a_new_name_is_written(
    here: Path, command: list[str], kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    target = here / "target.png"
    if kind == "folder":
        target.mkdir()
    elif kind == "device":
        target.symlink_to(os.devnull)
    elif kind == "pipe":
        os.mkfifo(target)
    else:
        os.mkfifo(here / "pipe")
        target.symlink_to("pipe")
    assert fiv([*command, str(target)]) == 2
    said = capsys.readouterr().err
    assert str(target) in said
    assert "next: name a" in said


def test_a_name_below_a_file_is_left_to_who_makes_folders(here: Path) -> None:
    files.refuse_special(here / "s.toml" / "a")
    with pytest.raises(UsageError, match="is a folder"):
        files.refuse_special(here)


def test_leftovers_of_a_killed_run_are_swept(here: Path) -> None:
    assert fiv(["run", "s.toml", "-o", "s.nc", "--workers", "1"]) == 0
    for name in (".s.nc.0123456789abcdef.tmp", "s.run/.identity.json.01.tmp"):
        (here / name).write_bytes(b"half")
    (here / "s.run" / ".beat-1").mkdir()
    assert fiv(["run", "s.toml", "-o", "s.nc", "--workers", "1"]) == 0
    assert not list(here.glob(".*.tmp"))
    assert not list(here.glob("s.run/.*.tmp"))
