"""Cases that are too large, too deep, or that would steer the terminal."""

from __future__ import annotations

from pathlib import Path

import pytest

from fiv_cli.case.load import parse_case
from fiv_cli.case.report import MOST_PROBLEMS
from fiv_cli.case.tables import MOST_TABLES
from fiv_cli.case.toml import DEEPEST, MOST_BYTES, TooMuchError, parse_toml
from fiv_cli.cli.main import run as fiv
from fiv_cli.errors import LONGEST_LINE, CaseError, UsageError, printable

CASE = 'schema = 1\n[model]\nname = "belt-1dof"\n[[analysis]]\nkind = "response"\n'


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("\n\na" + ".a" * (DEEPEST + 1) + " = 1", 3),
        ("a = 1\nb = " + "[" * (DEEPEST + 1), 2),
        ("b = " + "{ a = " * (DEEPEST + 1), 1),
        ("[" + "a." * DEEPEST + "a.a]", 1),
    ],
)
def test_what_nests_too_deeply_is_refused_before_it_is_read(text: str, line: int) -> None:
    with pytest.raises(
        TooMuchError, match=rf"nest too deeply; allowed: {DEEPEST} levels"
    ) as caught:
        parse_toml(text)
    assert caught.value.line == line
    with pytest.raises(CaseError, match=r"a\.toml:.*: case: tables, lists or dotted keys nest"):
        parse_case(text, "a.toml")


@pytest.mark.parametrize(
    "text",
    [
        "a" + ".a" * DEEPEST + " = 1",
        "b = " + "[" * DEEPEST + "]" * DEEPEST,
        'b = "' + "[" * 100 + '"',
        'b = "\\"' + "[" * 100 + '"',
        "b = '" + "\\[" * 100 + "'",
        'b = """' + '\n["' * 100 + '\\""""""',
        "b = '''" + "\n['" * 100 + "\n'''''",
        "# " + "[" * 100 + "\nb = 1 # " + "." * 100,
        "b = [" + "1.5, " * 100 + "]",
        "".join(f"[a{i}.b]\n" for i in range(100)),
    ],
)
def test_brackets_and_dots_that_do_not_nest_do_not_count(text: str) -> None:
    assert parse_toml(text)


@pytest.mark.parametrize("size", [MOST_BYTES + 1, 40 * MOST_BYTES])
def test_a_file_that_is_too_large_is_not_read(tmp_path: Path, size: int) -> None:
    path = tmp_path / "a.toml"
    with path.open("wb") as file:
        file.truncate(size)
    assert fiv(["check", str(path)]) == 3
    with pytest.raises(CaseError, match=rf"is too large .*\n +allowed: {MOST_BYTES:,} bytes"):
        parse_case("#" * size, "a.toml")


def test_a_setting_that_nests_too_deeply_is_malformed() -> None:
    for path, value in (("a", "[" * 3000), (".".join("a" * 3000), "1")):
        with pytest.raises(UsageError, match=r"nest too deeply|a path of 3000 parts"):
            parse_case(CASE, "a.toml", [f"{path}={value}"])


def test_of_many_problems_the_first_are_told() -> None:
    with pytest.raises(CaseError) as caught:
        parse_case(CASE + "[grid]\n" + "".join(f"k{i} = [1]\n" for i in range(5000)), "a.toml")
    assert len(caught.value.problems) == MOST_PROBLEMS + 1
    assert caught.value.problems[-1].message == "no more than 1,000 problems are told"


@pytest.mark.parametrize("kind", ["figure", "claim", "initial"])
def test_arrays_of_tables_have_an_end(kind: str) -> None:
    with pytest.raises(CaseError, match=r"2,001 tables are too many\n +allowed: at most 2,000"):
        parse_case(CASE + f'[[{kind}]]\nkind = "map"\n' * (MOST_TABLES + 1), "a.toml")


def test_lines_are_printable_and_have_an_end() -> None:
    assert printable("\x9b31m\tµ\n\udc80") == "\\x9b31m\\tµ\n\\udc80"
    long = printable("x" * (LONGEST_LINE + 1_234_567))
    assert long == "x" * LONGEST_LINE + " ... and 1,234,567 more characters"
