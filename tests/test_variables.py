"""The table of variables: what is known of one by its name, and that nobody keeps a list beside."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import fiv_cli
from fiv_cli.analyses import all_analyses
from fiv_cli.analyses.base import Varied
from fiv_cli.analyses.catalogue import every_variable, named, variables_of
from fiv_cli.analyses.variables import Role, Variable
from fiv_cli.flags import TABLES
from fiv_cli.models import all_models
from fiv_cli.models.base import Model

PACKAGE = Path(fiv_cli.__file__).parent

# Files that list names which are variables' names, too, and why they do.
LISTING = {"codegen/codes.py": "the outputs of generated code, which stands below the analyses"}


def variables_on(model: Model) -> Iterator[tuple[str, Variable]]:
    """(kind, variable) of everything that analyses of a model can have."""
    settings = {"parameter": Varied("v", (), "m s-1"), "follow": "both", "system": "averaged"}
    for kind, analysis in all_analyses().items():
        if not analysis.unsuited(model):
            for one in variables_of(kind, model, model.default_options(), settings):
                yield kind, one


@pytest.mark.parametrize("model", all_models().values(), ids=lambda model: model.name)
def test_a_name_alone_tells_what_a_variable_is_there_for(model: Model) -> None:
    for kind, one in variables_on(model):
        known = named(one.name)
        facts = [(v.role, v.statistic, v.unbounded, v.margin, v.width) for v in (one, known)]
        assert facts[0] == facts[1], f"{kind}: {one.name}"


def test_what_no_table_holds_is_an_answer_like_any_other() -> None:
    assert named("of_tomorrow") == Variable("of_tomorrow", "1", "of_tomorrow")


@pytest.mark.parametrize("model", all_models().values(), ids=lambda model: model.name)
def test_a_width_lies_beside_what_it_is_of(model: Model) -> None:
    table = {(kind, one.name): one for kind, one in variables_on(model)}
    for (kind, _), one in table.items():
        if one.width:
            width = table[kind, one.width]
            assert (width.units, width.along) == (one.units, one.along)


def test_classes_have_a_table_and_numbers_none() -> None:
    for one in every_variable().values():
        assert (one.flags in TABLES) == (one.kind == "flag")
        assert one.kind == "flag" or one.role not in (Role.STATUS, Role.CLASS)


def listed_names(path: Path) -> Iterator[tuple[int, list[str]]]:
    """(line, names) of every tuple, list and set of texts in which variables are named."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Tuple | ast.List | ast.Set):
            texts = [e.value for e in node.elts if isinstance(e, ast.Constant)]
            yield node.lineno, [t for t in texts if isinstance(t, str) and t in every_variable()]


@pytest.mark.parametrize(
    "path",
    [p for p in sorted(PACKAGE.rglob("*.py")) if str(p.relative_to(PACKAGE)) not in LISTING],
    ids=lambda path: str(path.relative_to(PACKAGE)),
)
def test_nobody_lists_variables_beside_the_table(path: Path) -> None:
    longest = max(listed_names(path), key=lambda found: len(found[1]), default=(0, []))
    assert len(longest[1]) < 3, f"{path}:{longest[0]}: ask fiv_cli.analyses.variables instead"
