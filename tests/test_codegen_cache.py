"""The per-user cache: whole files, one key for one content, no stale code."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import pytest

import fiv_cli
from fiv_cli.codegen import cache
from fiv_cli.codegen.generate import generate
from fiv_cli.codegen.setup import Setup
from fiv_cli.dynamics import compiled
from fiv_cli.friction import get_law
from fiv_cli.models import get_model

PACKAGE = Path(fiv_cli.__file__).parent

KEY = "from fiv_cli.dynamics.compiled import DRIVER; print(DRIVER.key())"

# Second coefficient of its displacement (half the acceleration at rest), by machine code.
ACCELERATE = """
import ctypes
from fiv_cli.codegen.generate import generate
from fiv_cli.codegen.setup import Setup
from fiv_cli.friction import get_law
from fiv_cli.models import get_model
made = generate(Setup(get_model("belt-1dof"), get_law("coulomb"), {}, {}, 8))
values = {"m": 1, "k": 1, "N": 10, "v": 9, "mu_k": 0.1, "sign.0": 1}
vector = [values.get(name, 0.0) for name in made.parameter_names]
pointer = ctypes.POINTER(ctypes.c_double)
kind = ctypes.CFUNCTYPE(None, pointer, ctypes.c_double, pointer, pointer)
c, y, out = (ctypes.c_double * 64)(), (ctypes.c_double * 64)(*vector), (ctypes.c_double * 64)()
kind(made.address("coefficients"))(c, 0.0, y, c)
kind(made.address("slip_taylor"))(c, 0.0, (ctypes.c_double * 2)(), out)
print(out[2], made.key)
"""

GENERATE = """
from fiv_cli.codegen import lower
from fiv_cli.codegen.generate import generate
from fiv_cli.codegen.setup import Setup
from fiv_cli.friction import get_law
from fiv_cli.models import get_model
compiled, compile_text = [], lower.compile_text
lower.compile_text = lambda text: compiled.append(text) or compile_text(text)
made = generate(Setup(get_model("belt-1dof"), get_law("coulomb"), {}, {}, 12), compiled.append)
made.address("slip_taylor"), made.address("slip_tangent", "tangent")
print(made.key, len(compiled))
"""


def start(program: str, cache_folder: Path, package: Path = PACKAGE) -> subprocess.Popen[str]:
    """A Python process with `package` as fiv_cli."""
    environment = os.environ | {
        "FIV_CACHE_DIR": str(cache_folder),
        "PYTHONPATH": str(package.parent),
    }
    return subprocess.Popen(
        [sys.executable, "-c", program],
        env=environment,
        cwd=package.parent,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def answer(process: subprocess.Popen[str]) -> list[str]:
    """Words printed by a process that must succeed."""
    out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    return out.split()


def test_what_was_written_is_read(own_cache: Path) -> None:
    cache.write("name", b"content")
    assert cache.read("name") == b"content"
    assert cache.read("other") is None
    assert [path.name for path in own_cache.iterdir()] == ["name"]


@pytest.mark.parametrize("damage", [b"", b"short", b"\0" * 100])
def test_a_damaged_file_is_not_there(own_cache: Path, damage: bytes) -> None:
    cache.write("name", b"content")
    (own_cache / "name").write_bytes(damage)
    assert cache.read("name") is None


def test_a_cache_that_cannot_be_written_is_replaced_for_this_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("FIV_CACHE_DIR", str(tmp_path / "file" / "cache"))
    cache.write("name", b"content")
    assert cache.read("name") == b"content"
    assert os.environ["FIV_CACHE_DIR"] != str(tmp_path / "file" / "cache")
    assert capsys.readouterr().err.count("\n") == 1


def test_without_any_folder_nothing_is_kept(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A root that is read only, no home and no folder for temporary files."""

    def nowhere(*arguments: object, **named: object) -> NoReturn:
        raise RuntimeError("Could not determine home directory.")

    def read_only(*arguments: object, **named: object) -> NoReturn:
        raise FileNotFoundError("No usable temporary directory found")

    monkeypatch.setenv("FIV_CACHE_DIR", "")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", nowhere)
    monkeypatch.setattr(tempfile, "mkdtemp", read_only)
    cache.write("name", b"content")
    assert cache.read("name") is None
    assert capsys.readouterr().err.count("no home folder") == 1


def open_to_others(path: Path) -> None:
    path.chmod(path.stat().st_mode | 0o020)


def linked(path: Path) -> None:
    path.rename(path.with_name("elsewhere"))
    path.symlink_to(path.with_name("elsewhere"))


@pytest.mark.parametrize("change", [open_to_others, linked])
def test_code_that_others_may_have_written_is_not_read(
    own_cache: Path, change: Callable[[Path], None]
) -> None:
    cache.write("name", b"content")
    change(own_cache / "name")
    assert cache.read("name") is None


def test_two_users_do_not_share_a_cache(own_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither the folder of another user is taken, nor a file of theirs in one's own."""
    cache.write("name", b"content")
    another = os.geteuid() + 1
    monkeypatch.setattr(cache.os, "geteuid", lambda: another)
    assert "belongs to another user" in cache._trouble(own_cache)
    with pytest.raises(PermissionError):
        cache._own_content(own_cache / "name")


def test_a_folder_that_others_can_write_to_is_not_used(
    own_cache: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cache.write("name", b"content")
    open_to_others(own_cache)
    assert cache.read("name") is None
    cache.write("name", b"for this run")
    assert cache.read("name") == b"for this run"
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert str(own_cache) in said
    assert [path.name for path in own_cache.iterdir()] == ["name"]


def aged(path: Path, days: float) -> None:
    """Let a file have been used so many days ago."""
    then = time.time() - 86400.0 * days
    os.utime(path, (then, then))


def test_what_nobody_has_used_for_long_goes(own_cache: Path) -> None:
    for name in ("old", "used", "new"):
        cache.write(name, b"content")
    aged(own_cache / "old", 100.0)
    aged(own_cache / "used", 100.0)
    assert cache.read("used") == b"content"
    cache.write("another", b"content")
    assert {path.name for path in own_cache.iterdir()} == {"used", "new", "another"}


def test_of_too_much_goes_what_was_used_longest_ago(
    own_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """But never what was used within a week, however much it is."""
    monkeypatch.setattr(cache, "KEPT_BYTES", 3000)
    for number, days in enumerate((30.0, 20.0, 10.0, 5.0, 4.0, 3.0, 2.0)):
        cache.write(f"{number}", bytes(1000))
        aged(own_cache / f"{number}", days)
    cache.write("new", bytes(1000))
    assert {path.name for path in own_cache.iterdir()} == {"3", "4", "5", "6", "new"}


def test_keys_tell_parts_from_their_concatenation() -> None:
    assert cache.content_key(["ab", "c"]) != cache.content_key(["a", "bc"])


def test_damaged_code_is_made_again(own_cache: Path) -> None:
    belt, coulomb = get_model("belt-1dof"), get_law("coulomb")
    first = generate(Setup(belt, coulomb, {}, {}, 8))
    first.address("slip_taylor")
    for path in own_cache.iterdir():
        path.write_bytes(path.read_bytes()[:-7])
    said: list[str] = []
    second = generate(Setup(belt, coulomb, {}, {}, 8), said.append)
    assert len(said) == 1
    assert not second.is_compiled()
    assert second.address("slip_taylor") != 0
    assert second.is_compiled()
    assert second.texts == first.texts


def test_the_key_follows_law_options_structure_and_order(own_cache: Path) -> None:
    belt = get_model("belt-1dof")
    keys = {
        generate(Setup(belt, get_law("coulomb"), {}, {}, 8)).key,
        generate(Setup(belt, get_law("coulomb"), {}, {}, 9)).key,
        generate(Setup(belt, get_law("hyperbolic"), {}, {}, 8)).key,
        generate(Setup(belt, get_law("stribeck"), {}, {"delta": 1.0}, 8)).key,
        generate(Setup(belt, get_law("stribeck"), {}, {"delta": 2.0}, 8)).key,
    }
    assert len(keys) == 5


def test_of_processes_that_generate_at_once_one_does(own_cache: Path) -> None:
    processes = [start(GENERATE, own_cache) for _ in range(3)]
    keys, made = zip(*map(answer, processes), strict=True)
    assert len({*keys}) == 1
    assert sum(map(int, made)) == 3  # text and tables, flow, tangent flow
    files = [path for path in own_cache.iterdir() if path.is_file()]
    assert len(files) == 3  # text and tables, flow, tangent flow: no temporary names
    assert all(cache.read(path.name) is not None for path in files)


def edited(package: Path, file: str, old: str, new: str) -> None:
    """Replace one piece of a source file."""
    path = package / file
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A copy of the program to edit."""
    copied = tmp_path / "copy" / "fiv_cli"
    shutil.copytree(PACKAGE, copied, ignore=shutil.ignore_patterns("__pycache__"))
    return copied


def test_edited_files_never_run_stale_code(tmp_path: Path, package: Path) -> None:
    """x'' = mu_k N / m at rest, so x_2 is half of it: each edit changes it as it must."""
    edits = [
        ("friction/coulomb.py", 'slip.sign * p["mu_k"]', '2 * slip.sign * p["mu_k"]', 1.0),
        ("models/belt_1dof.py", 'force / p("m")', 'force / p("m") / 4', 0.25),
        ("codegen/emit.py", "{1.0 / k!r}", "{3.0 / k!r}", 0.75),
    ]
    answers = [answer(start(ACCELERATE, tmp_path / "cache", package))]
    assert answers[0] == answer(start(ACCELERATE, tmp_path / "cache", package))
    assert float(answers[0][0]) == 0.5
    for file, old, new, expected in edits:
        edited(package, file, old, new)
        answers.append(answer(start(ACCELERATE, tmp_path / "cache", package)))
        assert float(answers[-1][0]) == pytest.approx(expected, rel=1e-15)
    assert len({key for _, key in answers}) == len(answers)


def test_the_driver_has_another_key_after_any_edit(tmp_path: Path, package: Path) -> None:
    """What a key is for: see `test_kernels.py`."""
    files = {f"dynamics/{name}.py" for name in ("kernel", "roots", "compiled")}
    files |= {f"codegen/{name}.py" for name in ("kernels", "lower", "memory", "compiled")}
    keys = [answer(start(KEY, tmp_path / "cache", package))]
    for file in sorted(files):
        with (package / file).open("a") as text:
            text.write("# edited\n")
        keys.append(answer(start(KEY, tmp_path / "cache", package)))
    assert len({key for (key,) in keys}) == 1 + len(files)


def test_every_kernel_file_counts_for_the_key() -> None:
    texts = {path.name: path.read_text() for path in compiled.FOLDER.glob("*.py")}
    with_kernels = {
        name for name, text in texts.items() if re.search(r"^@(native|inlined)", text, re.M)
    }
    entry = Path(compiled.__file__).name
    assert any("from fiv_cli.codegen.codes import" in texts[name] for name in with_kernels)
    assert with_kernels | {entry, "codes.py"} == {path.name for path in compiled.DRIVER.files}


def test_a_full_disk_leaves_no_piece_behind(tmp_path, monkeypatch):
    def full(self, target):
        raise OSError(28, "No space left on device")

    monkeypatch.setenv("FIV_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(cache.Path, "replace", full)
    cache.write("name.o", b"code")
    assert cache.read("name.o") is None
    assert list(tmp_path.iterdir()) == []
