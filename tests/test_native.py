"""The compiler of kernels: machine code does what Python does, bit for bit, or it is refused."""

from __future__ import annotations

import importlib.util
import inspect
import math
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from test_codegen_cache import answer, start

from fiv_cli.codegen import cache, native, translate
from fiv_cli.codegen.generate import generate
from fiv_cli.codegen.native import (
    Floats,
    Floats2,
    Frame,
    Ints,
    Ints2,
    Ints3,
    KernelError,
    Library,
    call_generated,
    inlined,
    words_of,
)
from fiv_cli.friction import get_law
from fiv_cli.models import get_model

ANY_FLOAT = st.floats()
INT = st.integers(-(2**31), 2**31)
NUMBER = st.floats(-1e6, 1e6)
SHARE, LIMIT, LAST, SWITCH = 0.3, 5, -1, True
TABLE = np.array([0.5, np.inf, -0.0, 2.5])
WHOLE = np.array([7, -3, 2**40])


# --- kernels: everything that can be written ------------------------------------------------------
@native.native
def float_arithmetic(a: float, b: float, i: int, out: Floats) -> None:
    """Operations of floats, and of a float with an integer."""
    out[0] = a + b - a * b
    out[1] = -a / (b * b + 1.0)
    out[2] = a * i + i / 4 - 2 * b
    out[3] = a
    out[3] += b
    out[3] -= 3
    out[3] *= out[3]
    out[3] /= 7.0
    x = a
    x -= b
    x *= SHARE
    out[4] = x


@native.native
def int_arithmetic(i: int, j: int, out: Ints) -> None:
    """Operations of integers."""
    out[0] = i + j - 3 * i
    out[1] = -i
    out[2] = i // j
    out[3] = i % j
    out[4] = i // 4 + i % 8
    out[5] = i
    out[5] //= 3
    out[5] += LIMIT
    out[6] = abs(i)
    out[7] = min(i, j) - 2 * max(i, j)


@native.native
def comparisons(a: float, b: float, i: int, j: int, out: Ints) -> None:
    """Every comparison, of floats, of integers, of both, and of truths."""
    out[0] = 1 if a < b else 0
    out[1] = 1 if a <= b else 0
    out[2] = 1 if a > b else 0
    out[3] = 1 if a >= b else 0
    out[4] = 1 if a == b else 0
    out[5] = 1 if a != b else 0
    out[6] = 1 if i < a else 0
    out[7] = (1 if i < j else 0) + (2 if i <= j else 0) + (4 if i == j else 0)
    out[8] = (1 if i > j else 0) + (2 if i >= j else 0) + (4 if i != j else 0)
    out[9] = 1 if (a < b) == (i < j) else 0
    out[10] = 1 if (a < b) != SWITCH else 0
    out[11] = 1 if not a < b else 0
    out[12] = int((a < b) < (i < j)) + 2 * int((a < b) >= (i < j))


@native.native
def extremes(a: float, b: float, i: int, out: Floats) -> None:
    """min, max, abs, with what NaN, infinity and zeros of both signs make of them."""
    out[0], out[1] = min(a, b), max(a, b)
    out[2], out[3] = abs(a), -a
    out[4], out[5] = min(i, a), max(a, i)
    out[6] = a if a == a else -1.0
    out[7] = 1 if a < np.inf and -np.inf < a else 0.5


@native.native
def conversions(a: float, i: int, flag: bool, out: Floats) -> None:
    """int (towards zero), float, np.floor, powers."""
    out[0] = int(a)
    out[1] = float(i)
    out[2] = np.floor(a)
    out[3] = int(flag) + float(flag) + int(i)
    out[4] = abs(a) ** 0.5
    out[5] = a**2
    out[6] = abs(a) ** (1.0 / 7.0)
    out[7] = 2.0**SHARE
    out[8], out[9] = np.sqrt(a), np.sqrt(i)


@native.native
def chained(low: float, x: float, high: float) -> bool:
    """A chain of comparisons."""
    return low < x <= high != 1.0


@native.native
def not_of(flag: bool) -> bool:
    """A truth in and out."""
    return not flag


@native.native
def guarded(values: Floats, i: int) -> int:
    """Indices far out of range where what stands before them decides."""
    found = 0
    if i < len(values) and values[i] > 0.0:
        found += 1
    if i >= len(values) or values[i] <= 0.0:
        found += 2
    if 0 <= i < len(values) and not (i > 2 or values[i] == 1.0):
        found += 4
    if i < len(values) != values[i * len(values) // (i + 1)] > -1.0:
        found += 8
    far = values[i] if i < len(values) else -1.0
    return found + 16 if far < 0.0 else found


@native.native
def chain_guards(values: Floats, i: int) -> bool:
    """The third side of a chain is out of range where the first two decide."""
    return 0 <= i < len(values) <= int(values[i])


@native.native
def loops(n: int, step: int, out: Ints) -> int:
    """Ranges up and down, nested, left early; a loop variable that the body changes."""
    count = 0
    for i in range(n):
        count += i
        i = 100
        out[0] += i
    for i in range(n, -n, -3):
        if i == step:
            continue
        for k in range(i, n + i, 2):
            if k > 2 * step:
                break
            if k % 3 == 0:
                continue
            count = 3 * count + k if count < 1000000 else count % 1000
        out[1] = i
    k = n
    while k > 0 and out[2] < 40:
        k -= 1
        if k == step:
            continue
        out[2] += k
        while True:
            out[3] += 1
            if out[3] % 5 == 0:
                break
    for _ in range(n, 0):
        count += 1
    for end in range(k):
        k = 0
        out[4] = end
    return count


@native.native
def branches(i: int) -> int:
    """Early returns from everywhere."""
    if i < 0:
        return -1
    elif i == 0:
        return 0
    elif i < 10:
        for k in range(i):
            if k * k > i:
                return k
        while i > 0:
            i -= 2
            if i == 1:
                return 77
    else:
        if i % 2 == 0:
            return i // 2
        else:
            i = 3 * i + 1
        return i
    return 1000 + i


@native.native
def rows(a: Floats2, b: Ints2, c: Ints3, out: Floats) -> int:
    """Elements, rows and shapes."""
    total = 0
    for i in range(a.shape[0]):
        row = a[i]
        for k in range(len(row)):
            out[0] += row[k] * a[i, k]
        row[0], row[1] = row[1], a[i, 0]
    for i in range(c.shape[0]):
        plane = c[i]
        for k in range(plane.shape[0]):
            for m in range(len(c[i, k])):
                total = total * 3 + c[i, k, m] - plane[k, m] * b[0, 0] + c[i][k][m]
                c[i, k][m] += 1
    out[b.shape[0]] = b[1][1] + c.shape[2]
    return total + len(b) + a.shape[1] + b[0].shape[0]


@native.native
def alias(one: Floats, other: Floats, n: int) -> float:
    """Names of arrays, set on one of two ways, swapped, set again in a loop."""
    taken = one
    if n > 3:
        taken = other
    last = taken[0]
    for i in range(n):
        one, other = other, one
        one[0] += i
        tail = other[i % 2 :]
        tail[0] += len(tail)
        if one[0] > 50.0:
            taken = one
    return last + 2.0 * taken[0] + 3.0 * one[0]


@native.native
def next_place(places: Ints) -> int:
    """Count: a call that changes what it is asked about."""
    places[0] += 1
    return places[0]


@native.native
def asked_once(places: Ints, out: Floats) -> None:
    """The place of an augmented assignment is looked up once, before the value."""
    out[next_place(places)] += 1.0
    out[places[0]] += next_place(places)


@native.native
def tables(i: int, out: Floats) -> None:
    """Constants of the module."""
    out[0] = TABLE[i] + LIMIT + np.pi
    out[1] = len(TABLE) + LAST
    out[2] = WHOLE[i % 3] // 2 if SWITCH else 0.0
    out[3] = math.e


@native.native
def pair(a: float, i: int) -> tuple[float, int, bool]:
    """Several results."""
    return a * 2, i + 1, a > i


@inlined
def in_place(a: float, i: int) -> tuple[float, int, bool]:
    """The same, compiled into its callers, and calling on."""
    if i > 100:
        return a, i, True
    return pair(a, i)


@native.native
def results(a: float, i: int, out: Floats) -> None:
    """Tuples of results, swaps."""
    x, k, larger = pair(a, i)
    y, out[0], _ = in_place(x, k)
    x, y = y, x
    out[1], out[2] = x, y
    if larger:
        out[3] = k


@inlined
def factorial(n: int) -> int:
    """A kernel that calls itself."""
    return 1 if n <= 1 else n * factorial(n - 1)


@native.native
def is_even(n: int) -> bool:
    """Two kernels that call each other."""
    return n == 0 or is_odd(n - 1)


@native.native
def is_odd(n: int) -> bool:
    """The other one."""
    return n != 0 and is_even(n - 1)


@native.native
def recursive(n: int) -> int:
    """Calls of both."""
    return -factorial(n) if is_even(n) else factorial(n)


@native.native
def set_late(n: int) -> int:
    """A variable that is set after, in the text, it is first used otherwise; dead code."""
    for i in range(n):
        if i > 0:
            return i * 10
            n = 7
        count = i
        while count > -3:
            count -= 1
            if count < -1:
                break
    return n


class Pair(Frame):
    """Two arrays and a count."""

    values: Floats2
    numbers: Ints
    rest: Floats


@native.native
def sum_up(pair: Pair, scale: float) -> float:
    """Arrays of a frame."""
    total = 0.0
    for i in range(pair.values.shape[0]):
        for k in range(len(pair.values[i])):
            total += scale * pair.values[i, k]
            pair.numbers[0] += 1
    return total


@native.native
def framed(pair: Pair, scale: float) -> float:
    """A frame, given on."""
    row = pair.values[pair.numbers[1]]
    pair.numbers[1] = 1 - pair.numbers[1]
    return sum_up(pair, scale) + row[0] + len(pair.rest)


@native.native
def through_address(address: int, c: Floats, y: Floats, out: Floats) -> None:
    """A generated function."""
    call_generated(address, c, 0.0, y, out)


ENTRIES = (
    float_arithmetic, int_arithmetic, comparisons, extremes, conversions, chained, not_of, guarded,
    chain_guards, loops, branches, rows, alias, asked_once, tables, results, recursive, set_late,
    framed, through_address,
)  # fmt: skip
KERNELS = Library("test-native", (Path(__file__),), ENTRIES)


# --- both ways ------------------------------------------------------------------------------------
def bits(value: Any) -> Any:
    """What must be the same; NaN is NaN."""
    if isinstance(value, np.ndarray):
        return [bits(entry) for entry in value.ravel().tolist()]
    number = float(value)
    return "nan" if number != number else (number, math.copysign(1.0, number))


def check(kernel: Callable[..., Any], *given: Any) -> Any:
    """What a kernel gives, which must be what the same function gives under Python."""
    compiled, plain = ([_copied(value) for value in given] for _ in range(2))
    words: list[Any] = []
    for value in compiled:
        words += words_of(value) if isinstance(value, np.ndarray) else [value]
    found = KERNELS.function(kernel)(*words)
    with np.errstate(all="ignore"):
        expected = kernel(*plain)
    assert (found is None) == (expected is None)
    assert expected is None or bits(found) == bits(expected)
    for one, other in zip(compiled, plain, strict=True):
        assert bits(one) == bits(other)
    return found


def _copied(value: Any) -> Any:
    return value.copy() if isinstance(value, np.ndarray) else value


@given(a=NUMBER, b=NUMBER, i=INT)
def test_arithmetic_of_floats(a: float, b: float, i: int) -> None:
    check(float_arithmetic, a, b, i, np.zeros(5))


@given(i=INT, j=INT | st.integers(-9, 9))
def test_arithmetic_of_integers_of_either_sign(i: int, j: int) -> None:
    assume(j != 0)
    check(int_arithmetic, i, j, np.zeros(8, np.int64))


@given(a=ANY_FLOAT, b=ANY_FLOAT, i=INT | st.integers(-2, 2), j=INT | st.integers(-2, 2))
def test_comparisons(a: float, b: float, i: int, j: int) -> None:
    check(comparisons, a, b, i, j, np.zeros(13, np.int64))
    check(comparisons, a, a, i, i, np.zeros(13, np.int64))
    check(chained, a, b, max(a, b))
    check(chained, b, a, 1.0)


@given(a=ANY_FLOAT, b=ANY_FLOAT | st.just(0.0), i=INT | st.just(0))
def test_extremes(a: float, b: float, i: int) -> None:
    check(extremes, a, b, i, np.zeros(8))
    check(extremes, -0.0, 0.0, 0, np.zeros(8))


@given(a=NUMBER | st.floats(-9e15, 9e15), i=INT, flag=st.booleans())
def test_conversions_and_powers(a: float, i: int, flag: bool) -> None:
    check(conversions, a, i, flag, np.zeros(10))


def test_powers_are_those_of_the_library() -> None:
    """x ** 2 is not always x x, x ** 0.5 not always the root: compilers like to take them."""
    random = np.random.default_rng(1)
    for a in random.uniform(1.0, 2.0, 5000):
        check(conversions, float(a), 1, True, np.zeros(10))


@pytest.mark.parametrize("flag", [True, False])
def test_truths_in_and_out(flag: bool) -> None:
    assert check(not_of, flag) is not flag


@given(i=st.integers(0, 8) | st.integers(10**12, 10**15), value=st.floats(-3.0, 5.0))
def test_what_is_decided_is_not_looked_at(i: int, value: float) -> None:
    values = np.array([value, 1.0, -1.0, value, 4.0, value])
    check(guarded, values, i)
    for place in (i, i - 3, -i):
        check(chain_guards, np.array([value, 6.5, 2.0, value]), place)


@given(n=st.integers(-3, 12), step=st.integers(-4, 12))
def test_loops(n: int, step: int) -> None:
    check(loops, n, step, np.zeros(5, np.int64))


@given(i=st.integers(-5, 30))
def test_early_returns(i: int) -> None:
    check(branches, i)


@given(numbers=st.lists(st.integers(-9, 9), min_size=24, max_size=24))
def test_arrays_of_one_to_three_dimensions(numbers: list[int]) -> None:
    whole = np.array(numbers)
    floats = whole[:6].reshape(2, 3) / 7.0
    check(rows, floats, whole[6:10].reshape(2, 2), whole.reshape(2, 3, 4), np.zeros(3))


@given(n=st.integers(0, 20))
def test_names_of_arrays_may_be_set_anew(n: int) -> None:
    check(alias, np.array([2.0, 5.0]), np.array([3.0, 7.0]), n)


def test_an_augmented_assignment_looks_once() -> None:
    check(asked_once, np.array([0, 0]), np.zeros(4))


@pytest.mark.parametrize("i", range(4))
def test_constants_of_the_module(i: int) -> None:
    check(tables, i, np.zeros(4))


@given(a=NUMBER, i=INT | st.integers(0, 200))
def test_several_results(a: float, i: int) -> None:
    check(results, a, i, np.zeros(4))


@given(n=st.integers(0, 20))
def test_kernels_may_call_themselves_and_each_other(n: int) -> None:
    check(recursive, n)


@pytest.mark.parametrize("n", range(4))
def test_dead_code_and_late_variables(n: int) -> None:
    check(set_late, n)


# --- frames, generated functions ------------------------------------------------------------------
def test_a_frame_may_show_other_arrays_at_every_call() -> None:
    """Its words are read anew by each call, never twice by one."""
    random = np.random.default_rng(1)
    words = Pair.words({})
    for shape in ((2, 3), (2, 1), (4, 2), (2, 3)):
        pair = Pair()
        pair.values, pair.rest = random.normal(size=shape), np.zeros(shape[0])
        pair.numbers = np.array([3, shape[0] % 2])
        before = pair.numbers.copy()
        words[:] = Pair.words(vars(pair))
        found = KERNELS.function(framed)(native.address_of(words), 0.1)
        changed, pair.numbers = pair.numbers, before
        assert bits(found) == bits(framed(pair, 0.1))
        np.testing.assert_array_equal(changed, pair.numbers)


def test_a_generated_function_is_called_through_its_address() -> None:
    made = generate(get_model("belt-1dof"), get_law("coulomb"), {}, {}, 8)
    random = np.random.default_rng(1)
    coefficients, out = random.normal(size=made.n_coefficients), np.zeros(64)
    check(through_address, made.address("slip_taylor"), coefficients, random.normal(size=2), out)


# --- refusals -------------------------------------------------------------------------------------
def list_comprehension(a: Floats) -> float:
    total = 0.0
    for value in [2.0 * x for x in a]:  # here
        total += value
    return total


def float_in_int(a: float) -> int:
    count = 1
    if a > 0.0:
        count = a  # here
    return count


def kind_of_branches(a: float) -> float:
    if a > 0.0:
        x = 1
    else:
        x = 0.5  # here
    return x


def unknown_name(a: float) -> float:
    return a + nowhere  # noqa: F821 # here


def read_before(n: int) -> float:
    for _ in range(n):
        n = LIMIT  # noqa: F823 # here
        LIMIT = n + 1  # noqa: F841
    return 1.0


def no_kernel(a: float) -> float:
    return bits(a)  # here


def other_floor(a: float) -> float:
    return math.floor(a)  # here


def keyword(a: float) -> float:
    return max(a, 1.0, key=abs)  # here


def given_int_array(c: Ints) -> float:
    return sum_of(c)  # here


@native.native
def sum_of(a: Floats) -> float:
    """Called in the wrong ways."""
    return a[0] + a[1]


def given_plane(c: Floats2) -> float:
    return sum_of(c)  # here


def given_too_much(a: Floats) -> float:
    return sum_of(a, 1)  # here


class Other(Frame):
    """Not the frame that `framed` is for."""

    values: Floats2


def given_other_frame(run: Other) -> float:
    return sum_up(run, 1.0)  # here


def negative_index(a: Floats) -> float:
    return a[-1]  # here


def negative_constant(a: Floats) -> float:
    return a[LAST]  # here


def float_index(a: Floats) -> float:
    return a[a[0]]  # here


def too_many_indices(a: Floats) -> float:
    return a[0, 1]  # here


def whole_row(a: Floats2) -> None:
    a[0] = 1.0  # here


def changed_constant(i: int) -> None:
    TABLE[i] = 1.0  # here


def slice_of(a: Floats) -> float:
    return sum_of(a[0:2])  # here


def plane_from(a: Floats2) -> int:
    return len(a[1:])  # here


def from_the_end(a: Floats) -> int:
    return len(a[-2:])  # here


def else_of_loop(n: int) -> int:
    for i in range(n):  # here
        if i == 3:
            break
    else:
        n = 0
    return n


def no_step(n: int) -> int:
    for i in range(0, n, 0):  # here
        n = i
    return n


def over_floats(a: float) -> float:
    for _ in range(a):  # here
        a += 1.0
    return a


def truth_of_int(n: int) -> int:
    if n:  # here
        return 1
    return 0


def counted_truth(flag: bool) -> int:
    return flag + 1  # here


def truth_like_int(flag: bool, n: int) -> bool:
    return flag == n  # here


def two_targets(a: float) -> float:
    x = y = a  # here
    return x + y


def two_of_three(a: float) -> float:
    x, y = pair(a, 1)  # here
    return x + y


def compared_pairs(a: float) -> bool:
    return pair(a, 1) == pair(a, 2)  # here


def chosen_nothing(out: Ints) -> None:
    changed_constant_of(out) if len(out) > 1 else offset_of(out)  # here


@native.native
def offset_of(out: Ints) -> None:
    """Another one."""
    out[0] = 2


def nothing_taken(out: Ints) -> None:
    x = changed_constant_of(out)  # noqa: F841 # here


@native.native
def changed_constant_of(out: Ints) -> None:
    """A kernel without a result."""
    out[0] = 1


def short_result(a: float) -> tuple[float, float]:
    return (a,)  # here


def bare_return(a: float) -> float:
    if a > 0.0:
        return  # here
    return a


def lost_return(a: float) -> float:  # here
    if a > 0.0:
        return a
    while a < 1.0:
        a += 1.0


def whole_power(n: int) -> int:
    return n**n  # here


def huge(n: int) -> int:
    return n + 2**64 + 18446744073709551616  # here


def default_given(a: float = 1.0) -> float:  # here
    return a


def strange_parameter(a: str) -> float:  # here
    return 1.0


REFUSED = [
    list_comprehension, float_in_int, kind_of_branches, unknown_name, read_before, no_kernel,
    other_floor, keyword, given_int_array, given_plane, given_too_much, given_other_frame,
    negative_index, negative_constant, float_index, too_many_indices, whole_row, changed_constant,
    slice_of, plane_from, from_the_end, else_of_loop, no_step, over_floats, truth_of_int,
    counted_truth, truth_like_int,
    two_targets, two_of_three, compared_pairs, chosen_nothing, nothing_taken, short_result,
    bare_return, lost_return, whole_power, huge, default_given, strange_parameter,
]  # fmt: skip


@pytest.mark.parametrize("kernel", REFUSED, ids=lambda kernel: kernel.__name__)
def test_what_cannot_be_compiled_is_refused_with_its_place(kernel: Callable[..., Any]) -> None:
    lines, first = inspect.getsourcelines(kernel)
    (line,) = (first + i for i, text in enumerate(lines) if "# here" in text)
    with pytest.raises(KernelError, match=rf"^test_native.py, {kernel.__name__}, line {line}: "):
        translate.compile_kernels((native.native(kernel),))


def test_a_refusal_in_a_callee_names_the_callee() -> None:
    def caller(a: Floats) -> float:
        return negative_index(a)

    native.native(negative_index)
    with pytest.raises(KernelError, match="negative_index, line"):
        translate.compile_kernels((caller,))


def test_a_kernel_without_source_is_refused() -> None:
    names: dict[str, Any] = {"__name__": "nowhere"}
    exec("def made(a: float) -> float:\n    return a\n", names)
    with pytest.raises(KernelError, match=r"nowhere\.made: its source cannot be read"):
        translate.compile_kernels((names["made"],))


def test_annotations_must_be_texts(tmp_path: Path) -> None:
    """What `Floats` means to ctypes is known by its name."""
    text = TWICE.format(factor=3).replace("from __future__ import annotations\n", "")
    library = library_of(module_from(tmp_path / "today.py", text), "taken")
    with pytest.raises(KernelError, match=r"today\.taken: its file imports no annotations"):
        library.function(library.entries[0])


def test_python_takes_one_result() -> None:
    library = Library("test-pair", (Path(__file__),), (pair,))
    with pytest.raises(KernelError, match="pair: Python cannot take tuple"):
        library.function(pair)


# --- libraries ------------------------------------------------------------------------------------
TWICE = """from __future__ import annotations
from fiv_cli.codegen.native import native

FACTOR = {factor}

@native
def step(a: float) -> float:
    return FACTOR * a

@native
def taken(a: float) -> float:
    return step(a) + 1.0
"""


def module_from(path: Path, text: str) -> ModuleType:
    """A module made of `text`."""
    path.write_text(text)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules.pop(path.stem, None)
    spec.loader.exec_module(module)
    return module


def library_of(module: ModuleType, *entries: str) -> Library:
    """The kernels of a module in a library."""
    file = Path(str(module.__file__))
    return Library("test", (file,), tuple(getattr(module, name) for name in entries))


def test_kernels_of_one_name_from_two_modules(tmp_path: Path) -> None:
    """Also those that are called like functions of the C library."""
    modules = [module_from(tmp_path / f"m{i}.py", TWICE.format(factor=i)) for i in (3, 5)]
    entries = tuple(module.taken for module in modules)
    files = tuple(Path(str(module.__file__)) for module in modules)
    both = Library("test-both", files, entries)
    assert [both.function(entry)(2.0) for entry in entries] == [7.0, 11.0]
    pow_itself = TWICE.format(factor=1).replace("step", "pow").replace("FACTOR * a", "a ** 0.5")
    library = library_of(module_from(tmp_path / "p.py", pow_itself), "taken", "pow")
    assert library.function(library.entries[0])(9.0) == 4.0


def test_an_edit_has_its_own_code_beside_the_old(own_cache: Path, tmp_path: Path) -> None:
    """Two libraries in one process hold symbols of the same names."""
    libraries = []
    for factor in (3, 55):
        module = module_from(tmp_path / "edited.py", TWICE.format(factor=factor))
        libraries.append(library_of(module, "taken"))
        assert libraries[-1].function(module.taken)(2.0) == 2.0 * factor + 1.0
    first, second = libraries
    assert first.key() != second.key()
    assert first.function(first.entries[0])(2.0) == 7.0
    assert len(list(own_cache.iterdir())) == 2


def test_libraries_of_other_entries_have_other_keys(own_cache: Path, tmp_path: Path) -> None:
    module = module_from(tmp_path / "twice.py", TWICE.format(factor=3))
    first, second = library_of(module, "taken"), library_of(module, "taken", "step")
    assert first.function(module.taken)(1.0) == 4.0
    assert second.function(module.step)(1.0) == 3.0
    with pytest.raises(KernelError, match="does not hold"):
        first.function(module.step)


def test_code_of_a_file_edited_since_its_import_is_not_kept(
    own_cache: Path,
    tmp_path: Path,
) -> None:
    """Its text is new, its constants are old: nobody else may meet that."""
    module = module_from(tmp_path / "running.py", TWICE.format(factor=3))
    library = library_of(module, "taken")
    Path(str(module.__file__)).write_text(TWICE.format(factor=55))
    assert library.function(module.taken)(2.0) == 7.0
    assert not any(own_cache.iterdir())
    assert not library.is_warm()


@pytest.mark.parametrize("damage", [None, b"", b"short", b"\0" * 200])
def test_missing_or_damaged_code_is_made_again(
    own_cache: Path,
    tmp_path: Path,
    damage: bytes | None,
) -> None:
    module = module_from(tmp_path / "twice.py", TWICE.format(factor=3))
    first, second = library_of(module, "taken"), library_of(module, "taken")
    assert not first.is_warm()
    assert first.function(module.taken)(1.0) == 4.0
    (file,) = own_cache.iterdir()
    whole = file.read_bytes()
    if damage is None:
        file.unlink()
    else:
        file.write_bytes(damage)
    assert not second.is_warm()
    assert second.function(module.taken)(1.0) == 4.0
    assert second.is_warm()
    assert file.read_bytes() == whole


def test_warm_code_needs_no_compiler(
    own_cache: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    module = module_from(tmp_path / "twice.py", TWICE.format(factor=3))
    library_of(module, "taken").function(module.taken)
    monkeypatch.delattr(translate, "compile_kernels")
    monkeypatch.delattr(translate, "_definition")
    assert library_of(module, "taken").function(module.taken)(1.0) == 4.0


SETTLE = """
import numpy as np
from fiv_cli.analyses.settling import SETTLING, settled_period
print(settled_period(np.array([[1.0], [2.0]] * 20)), SETTLING.key())
"""


def test_two_processes_compile_at_once(own_cache: Path) -> None:
    first, second = [answer(p) for p in [start(SETTLE, own_cache) for _ in range(2)]]
    assert first == second
    assert first[0] == "2"
    (file,) = own_cache.iterdir()  # no temporary names
    assert cache.read(file.name) is not None
