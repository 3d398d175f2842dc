"""Kernels compiled by numba: the bits of Python, no stale code, nothing that others can write."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_codegen_cache import answer, start

from fiv_cli.codegen import cache
from fiv_cli.codegen.compiled import Compiled
from fiv_cli.codegen.generate import generate
from fiv_cli.codegen.memory import (
    FixedFloat,
    FixedInt,
    Floats,
    Floats2,
    Frame,
    Ints,
    Ints2,
    OwnFloats,
    OwnInts,
    bits_of,
    call_generated,
    float_of,
    native,
)
from fiv_cli.codegen.setup import Setup
from fiv_cli.friction import get_law
from fiv_cli.models import get_model

HERE = Path(__file__)


# --- what kernels may do with a frame -------------------------------------------------------------
class Board(Frame):
    """Numbers and arrays of every kind."""

    factor: FixedFloat
    generated: FixedInt
    sum: float
    own: OwnFloats
    ranks: OwnInts
    count: int
    flat: Floats
    square: Floats2
    places: Ints
    table: Ints2


@native
def total(values: Floats) -> float:
    """Sum in order."""
    found = 0.0
    for i in range(len(values)):
        found += values[i]
    return found


@native
def rearranged(board: Board) -> float:
    """Fields, elements, rows, rests and lengths, read and written; bits; a generated function."""
    row, factor = board.square[1], board.factor
    row[0] = factor * row[1] + row[2]  # two roundings
    board.square[0, 2] = board.places[0] // 4 + board.places[0] % 3
    board.places[1] = board.table[1, 1] + board.table.shape[1]
    board.sum = 3  # an integer becomes a float, as in an array
    board.sum += total(board.flat[2:]) / factor
    board.count += len(board.own)
    board.ranks[0], board.own[0] = board.count, board.sum
    board.own[1] = board.own[0] / board.own[3] + len(board.flat) ** 0.5
    call_generated(board.generated, board.flat, factor, board.own[2:], board.square[2])
    return float_of(bits_of(factor) + 1)


def board_at(address: int) -> Any:
    """The frame at an address."""
    return Board.at(address)


def rearranged_at(address: int) -> float:
    """`rearranged` of the board at an address."""
    return rearranged(board_at(address))


def declared(entry: Callable[..., float]) -> Callable[..., float]:
    """The entry, numba told of what it calls."""
    from fiv_cli.codegen.kernels import register, register_frame

    register_frame(Board, board_at)
    register(sys.modules[__name__])
    return entry


REARRANGED = Compiled(
    "test-rearranged", "float64(int64)", (HERE,), partial(declared, rearranged_at)
)


def left_by(function: Callable[..., float], factor: float, length: int) -> list[Any]:
    """Result and frame afterwards, from the same frame each time."""
    made = generate(Setup(get_model("belt-1dof"), get_law("coulomb"), {}, {}, 8))
    random = np.random.default_rng(length)
    arrays: dict[str, Any] = {
        "flat": random.normal(size=made.n_coefficients + length),
        "square": random.normal(size=(3, 64)),
        "places": random.integers(-9, 9, 2),
        "table": random.integers(-9, 9, (2, length)),
    }
    board = Board.holding(arrays, {"own": 4, "ranks": 2}).copy()
    board.factor, board.generated, board.count = factor, made.address("slip_taylor"), length
    found = [function(board.address), board.sum, board.count, board.factor]
    found += [x for name in (*arrays, "own", "ranks") for x in getattr(board, name).ravel()]
    return [float(x).hex() for x in found]


@given(st.floats(0.1, 10.0), st.integers(2, 5))
def test_machine_code_does_what_python_does(factor: float, length: int) -> None:
    with np.errstate(all="ignore"):
        plain = left_by(rearranged_at, factor, length)
    assert left_by(REARRANGED.function, factor, length) == plain


@native
def overwritten(board: Board) -> None:
    """Writes what is fixed: a compiled kernel may have read it long before."""
    board.factor = 1.0


def overwritten_at(address: int) -> None:
    """`overwritten` of the board at an address."""
    overwritten(board_at(address))


def test_kernels_write_no_fixed_number() -> None:
    from numba import cfunc

    from fiv_cli.codegen.kernels import register, register_frame

    register_frame(Board, board_at)
    register(sys.modules[__name__])
    with pytest.raises(TypeError, match="kernels do not write factor"):
        cfunc("void(int64)")(overwritten_at)


def test_a_frame_shows_no_array_that_kernels_would_misread() -> None:
    for name, array in (("flat", np.zeros(2, int)), ("flat", np.zeros((2, 2))),
                        ("square", np.zeros((4, 4))[:, ::2])):  # fmt: skip
        with pytest.raises(TypeError, match=f"{name} is no array"):
            Board.holding({name: array}, {})


# --- once per user, anew after any edit -----------------------------------------------------------
KERNELS = """from __future__ import annotations
from fiv_cli.codegen.memory import native

@native
def step(a: float) -> float:
    return {factor} * a
"""
ENTRY = """from __future__ import annotations
from test_edited_kernels import step

def taken(a):
    return step(a) + 1.0
"""


def module_from(path: Path, text: str) -> ModuleType:
    """A module made of `text`."""
    if not path.exists() or path.read_text() != text:
        path.write_text(text)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    spec.loader.exec_module(module)
    return module


def two_files(folder: Path, factor: float) -> Compiled:
    """An entry in one file, its kernel in another, imported anew."""
    kernels = module_from(folder / "test_edited_kernels.py", KERNELS.format(factor=factor))
    entry = module_from(folder / "test_edited_entry.py", ENTRY)
    files = tuple(Path(str(module.__file__)) for module in (kernels, entry))
    return Compiled("test", "float64(float64)", files, partial(declared_of, kernels, entry))


def declared_of(kernels: ModuleType, entry: ModuleType) -> Callable[..., Any]:
    """The entry, numba told of what it calls."""
    from fiv_cli.codegen.kernels import register

    register(kernels)
    taken: Callable[..., Any] = entry.taken
    return taken


def test_an_edit_in_another_file_than_the_entry_is_seen(own_cache: Path, tmp_path: Path) -> None:
    for factor, expected in ((3.0, 7.0), (55.0, 111.0), (3.0, 7.0)):
        assert two_files(tmp_path, factor).function(2.0) == expected
    assert len(list(own_cache.iterdir())) == 2


def test_what_is_compiled_is_found_again(own_cache: Path, tmp_path: Path) -> None:
    assert not two_files(tmp_path, 3.0).is_warm()
    assert two_files(tmp_path, 3.0).function(2.0) == 7.0
    again = two_files(tmp_path, 3.0)
    assert again.is_warm()
    assert again.function(2.0) == 7.0


def test_code_of_a_file_edited_since_its_import_is_not_kept(
    own_cache: Path, tmp_path: Path
) -> None:
    """Its text is new, its constants are old: nobody else may meet that."""
    compiled = two_files(tmp_path, 3.0)
    (tmp_path / "test_edited_kernels.py").write_text(KERNELS.format(factor=55.0))
    assert compiled.function(2.0) == 7.0
    assert not compiled.is_warm()


@pytest.mark.parametrize("damage", [None, b"", b"\0" * 200])
def test_missing_or_damaged_code_is_made_again(
    own_cache: Path, tmp_path: Path, damage: bytes | None
) -> None:
    assert two_files(tmp_path, 3.0).function(2.0) == 7.0
    (file,) = own_cache.iterdir()
    file.write_bytes(damage) if damage is not None else file.unlink()
    again = two_files(tmp_path, 3.0)
    assert not again.is_warm()
    assert again.function(2.0) == 7.0
    assert again.is_warm()


def test_with_nowhere_to_put_a_file_it_is_compiled_for_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FIV_CACHE_DIR", str(cache.NONE))
    compiled = two_files(tmp_path, 3.0)
    assert compiled.function(2.0) == 7.0
    assert not compiled.is_warm()
    assert list(tmp_path.rglob("*.nb?")) == []  # nor beside the sources


def raising(a: float) -> float:
    """There is nobody to take what it raises."""
    if a > 1.0:
        raise ValueError
    return a


def test_kernels_raise_no_exceptions(own_cache: Path) -> None:
    compiled = Compiled("raising", "float64(float64)", (HERE,), lambda: raising)
    with pytest.raises(TypeError, match="raising: kernels raise no exceptions"):
        _ = compiled.function
    assert not compiled.is_warm()


@native
def half(a: float) -> float:
    """A kernel of floats."""
    return 0.5 * a


def half_of_an_integer() -> float:
    """Calls a kernel with what its annotations do not say."""
    return half(3)


def test_a_kernel_is_compiled_for_what_it_says_and_nothing_else() -> None:
    from numba import TypingError, njit

    from fiv_cli.codegen.kernels import register

    register(sys.modules[__name__])
    with pytest.raises(TypingError, match="No implementation of function"):
        njit("float64()")(half_of_an_integer)


SETTLE = """
import sys
import numpy as np
from fiv_cli.analyses.attractor.settling import settled_period
print(settled_period(np.array([[1.0], [2.0]] * 20)), "numba" in sys.modules)
"""


def test_of_two_processes_one_compiles_and_neither_the_other_nor_the_next(own_cache: Path) -> None:
    processes = [start(SETTLE, own_cache) for _ in range(2)]
    assert sorted(answer(process) for process in processes) == [["2", "False"], ["2", "True"]]
    assert len(list(own_cache.iterdir())) == 1  # no temporary names
    assert answer(start(SETTLE, own_cache)) == ["2", "False"]
