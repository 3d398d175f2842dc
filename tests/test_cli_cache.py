"""Compiled code where the user's cache cannot be written: no home, no permission, no space."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, NoReturn

import pytest
from motions import defaults

from fiv_cli.analyses import execute
from fiv_cli.analyses.base import Start
from fiv_cli.cli import common
from fiv_cli.codegen.setup import Setup
from fiv_cli.errors import StorageError


def test_a_cache_that_can_be_written_is_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("FIV_CACHE_DIR", str(tmp_path / "cache"))
    common.provide_cache()
    assert os.environ["FIV_CACHE_DIR"] == str(tmp_path / "cache")
    assert capsys.readouterr().err == ""
    assert list((tmp_path / "cache").iterdir()) == []


def test_a_cache_that_cannot_be_written_is_replaced_for_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("FIV_CACHE_DIR", str(tmp_path / "file" / "cache"))
    common.provide_cache()
    assert Path(os.environ["FIV_CACHE_DIR"]).is_dir()
    said = capsys.readouterr().err
    assert str(tmp_path / "file" / "cache") in said
    assert "next time: FIV_CACHE_DIR=FOLDER" in said


def test_a_user_without_a_home_folder_can_run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def nowhere() -> NoReturn:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setenv("FIV_CACHE_DIR", "")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", nowhere)
    common.provide_cache()
    assert Path(os.environ["FIV_CACHE_DIR"]).is_dir()
    assert "no home folder" in capsys.readouterr().err


def test_a_disk_that_fills_up_while_compiling_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*arguments: Any) -> NoReturn:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setenv("FIV_CACHE_DIR", "/somewhere")
    monkeypatch.setattr(execute, "_load", full)
    parameters, start = defaults("belt-1dof", "coulomb"), Start("a", "state")
    request = execute.Request(Setup.of("belt-1dof"), parameters, "history", {}, start=start)
    with pytest.raises(StorageError, match=r"/somewhere: .*No space left on device\nnext: free"):
        execute.prepare([request], lambda sentence: None)


def test_a_name_too_long_says_what_to_do(tmp_path: Path) -> None:
    case = tmp_path / "a.toml"
    case.write_text('schema = 1\n[model]\nname = "belt-1dof"\n[[analysis]]\nkind = "response"\n')
    entry = "from fiv_cli.cli.main import main; main()"
    output = tmp_path / f"{'a' * 300}.nc"
    done = subprocess.run(
        [sys.executable, "-c", entry, "run", str(case), "-o", str(output)],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 2
    assert "File name too long\nnext: " in done.stderr
