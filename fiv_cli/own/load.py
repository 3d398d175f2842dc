"""From a file or an installed package to models and laws that have names like those in the box.

A file is run from the text that was read, under a name of its own, so whatever stands in it
afterwards: workers load the same text, and generated code is kept under it. It is run where
somebody named it (``--with``, `using`), never because a case file names one of its models.
"""

from __future__ import annotations

import ast
import importlib
import importlib.util
import os
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import redirect_stdout
from dataclasses import replace
from functools import cache
from importlib.abc import ExecutionLoader
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from fiv_cli.errors import ModelFileError, Problem, UsageError
from fiv_cli.friction import all_laws, know_laws
from fiv_cli.friction.base import Law
from fiv_cli.friction.tabulated import FORM, SUFFIX, tabulated
from fiv_cli.models import all_models, know_models
from fiv_cli.models.base import Model
from fiv_cli.models.origin import Origin

GROUPS = ("fiv.models", "fiv.laws")
"""Entry points of installed packages."""

SEARCHED = 200  # files beside a case that are searched for a name
MOST_BYTES = 2**20  # of a file of models
_MADE = r"(?m)^\w+ = (?:\w+\.)*(?:Model|Law|replace)\("
_NAME = r"(?a)[A-Za-z][\w.-]*"


def read(paths: Iterable[Path]) -> tuple[Origin, ...]:
    """What stands in files; a folder stands for those in it that make a model or a law.

    Raises
    ------
    UsageError
        one cannot be read.
    """
    files = {file.resolve(): file for path in paths for file in _files_of(path)}
    return tuple(Origin(str(file), _text(file)) for file in files.values())


def _files_of(path: Path) -> list[Path]:
    if not path.is_dir():
        return [path]
    files = [file for file in sorted(path.glob("*.py")) if re.search(_MADE, _text(file))]
    if not files:
        raise UsageError(f"--with {path}: no file in it makes a model\nnext: fiv new-model NAME")
    return files


def _text(path: Path) -> str:
    try:
        with path.open("rb") as file:
            content = file.read(MOST_BYTES + 1)
        if len(content) > MOST_BYTES:
            raise UsageError(f"--with {path}: more than {MOST_BYTES:,} bytes are no model")
        return importlib.util.decode_source(content)
    except OSError as error:
        several = (
            " " in str(path) and f"several: --with ONE --with TWO, FIV_WITH=ONE{os.pathsep}TWO"
        )
        following = several or "fiv new-model NAME > FILE.py"
        raise UsageError(
            f"--with {path}: cannot be read: {error.strerror}\nnext: {following}"
        ) from None
    except (SyntaxError, UnicodeDecodeError, LookupError) as error:
        raise ModelFileError(str(path), [Problem("text", f"is no text: {error}")]) from None


def is_name(name: object) -> bool:
    """Whether a model or a law can be called so: in a case, on a command line, in a file's name."""
    return isinstance(name, str) and bool(re.fullmatch(_NAME, name))


def use(origins: Iterable[Origin]) -> None:
    """Know the models and laws of these origins, beside those in the box, and no others.

    Raises
    ------
    ModelFileError
        one of them cannot be loaded, or holds a name that there is already.
    """
    know_models((), alone=True)
    know_laws((), alone=True)
    for origin in dict.fromkeys(origins):
        _refuse_taken_names(origin)
        know([origin])


def know(origins: Iterable[Origin]) -> None:
    """Have the names of their models and laws mean what stands there."""
    for origin in origins:
        know_models(thing for thing in declared(origin) if isinstance(thing, Model))
        know_laws(thing for thing in declared(origin) if isinstance(thing, Law))


def _refuse_taken_names(origin: Origin) -> None:
    from fiv_cli.own.lines import Lines

    lines, problems = Lines(origin.text), []
    known: dict[str, Model | Law] = {**all_models(), **all_laws()}
    for thing in declared(origin):
        other = known.setdefault(thing.name, thing)
        if other is not thing:
            home = "comes with fiv" if other.origin is None else f"stands in {other.origin.path}"
            line = lines.of(type(thing).__name__, thing.name, "name")
            said = f"the name {thing.name!r} is taken: what is called so {home}"
            hint = "" if other.origin is None else "name one of the two files; FIV_WITH counts too"
            problems.append(Problem("name", said, "a name of its own", hint, line))
    if problems:
        raise ModelFileError(origin.path, problems)


@cache
def declared(origin: Origin) -> tuple[Model | Law, ...]:
    """The models and laws that are made at the top level of a file, or of a package's entry.

    Raises
    ------
    ModelFileError
        there are none, or the file cannot be run.
    """
    if origin.path.endswith(SUFFIX):
        return (replace(tabulated(origin.path, origin.text), origin=origin),)
    if origin.entry:
        things: Iterable[Any] = [_of_entry(origin)]
    else:
        things = vars(module_of(origin)).values()
    box = {id(thing) for table in (all_models(), all_laws()) for thing in table.values()}
    found = [t for t in _flat(things) if isinstance(t, Model | Law) and id(t) not in box]
    if not found:
        hint = "fiv new-model NAME writes one to begin with"
        raise ModelFileError(
            origin.path, [Problem("file", "holds no MODEL = Model(...) and no LAW", "", hint)]
        )
    once = {id(thing): thing for thing in found}
    return tuple(_placed(thing, origin) for thing in once.values())


def _placed(thing: Model | Law, origin: Origin) -> Model | Law:
    return replace(thing, origin=origin)


def _flat(things: Iterable[Any]) -> Iterator[Any]:
    for thing in things:
        yield from thing if isinstance(thing, tuple | list) else (thing,)


class _Text(ExecutionLoader):
    """Loads a module from the text that was read."""

    def __init__(self, origin: Origin) -> None:
        self.origin = origin

    def get_filename(self, fullname: str) -> str:
        return self.origin.path

    def get_source(self, fullname: str) -> str:
        return self.origin.text


@cache
def module_of(origin: Origin) -> ModuleType:
    """The module that the text of a file makes; what it prints goes to stderr."""
    if origin.entry:
        return importlib.import_module(origin.entry.partition(":")[0])
    from fiv_cli.own.lines import Lines

    lines = Lines(origin.text)
    name = f"fiv_own_{origin.digest}"
    try:
        _refuse_companions(origin, lines.imports())
        loader = _Text(origin)
        spec = importlib.util.spec_from_loader(name, loader)
        assert spec is not None
        module = sys.modules[name] = importlib.util.module_from_spec(spec)
        with redirect_stdout(sys.stderr):
            loader.exec_module(module)
    except ModelFileError:
        raise
    except (Exception, SystemExit) as error:
        sys.modules.pop(name, None)
        raise ModelFileError(origin.path, [lines.problem(error, origin.path)]) from None
    return module


def _refuse_companions(origin: Origin, imports: Iterable[tuple[str, int]]) -> None:
    """Refuse modules that are neither Python's nor installed: nothing would follow their text."""
    problems = [
        Problem(
            f"import {name}",
            f"comes from {found}, whose text fiv does not follow",
            "modules of Python, of fiv and of installed packages",
            "write what is needed of it into this file, or install it as a package",
            line,
        )
        for name, line in imports
        if (found := _companion(name))
    ]
    if problems:
        raise ModelFileError(origin.path, problems)


def _companion(name: str) -> str:
    """Where a module lies, if it is neither Python's nor installed; empty where it is."""
    if name == "fiv_cli" or name in sys.stdlib_module_names:
        return ""
    spec = importlib.util.find_spec(name)
    place = "" if spec is None else spec.origin or ""
    return "" if {"site-packages", "dist-packages"} & {*Path(place).parts} else place


# --- installed packages ---------------------------------------------------------------------------
def seek(name: str) -> str:
    """Have a model or a law at hand that an installed package or a table may offer; its name.

    Raises
    ------
    UsageError
        a package cannot be loaded, or there is no such table.
    """
    if name.endswith(SUFFIX):
        try:
            know_table(Path(name).name, name)
        except ValueError as error:
            raise UsageError(f"{error}\nnext: name a table: {FORM}") from None
        return Path(name).name
    if name not in {**all_models(), **all_laws()}:
        know_installed()
    return name


def know_installed() -> None:
    """Know what installed packages offer, where the name is not taken.

    Raises
    ------
    UsageError
        one cannot be loaded.
    """
    for entry in (entry for group in GROUPS for entry in entry_points(group=group)):
        origin = _origin_of(entry)
        taken = {**all_models(), **all_laws()}
        if not any(thing.name in taken for thing in declared(origin)):
            know([origin])


def _origin_of(entry: EntryPoint) -> Origin:
    of = f"{entry.dist.name} {entry.dist.version}" if entry.dist else entry.module
    return Origin(f"{of} ({entry.value})", _text_of_package(entry.module), entry.value)


def _text_of_package(module: str) -> str:
    """The text of every Python file of the package that a module belongs to."""
    top = module.partition(".")[0]
    spec = importlib.util.find_spec(top)
    if spec is None or spec.origin is None:
        raise UsageError(f"package {top}: is not there\nnext: install it anew")
    file = Path(spec.origin)
    files = sorted(file.parent.rglob("*.py")) if spec.submodule_search_locations else [file]
    return "\n".join(path.read_text(encoding="utf-8") for path in files)


def _of_entry(origin: Origin) -> object:
    module, _, name = origin.entry.partition(":")
    try:
        found: object = getattr(importlib.import_module(module), name)
    except Exception as error:
        raise UsageError(
            f"{origin.path}: cannot be loaded: {type(error).__name__}: {error}\n"
            "next: mend the package, or remove it"
        ) from error
    if _text_of_package(module) != origin.text:
        raise UsageError(f"{origin.path}: was changed while it was in use\nnext: run it again")
    return found


# --- tables ---------------------------------------------------------------------------------------
def know_table(name: str, case: str) -> None:
    """Know the law of the table in a file, by the path that a case gives from its folder.

    Raises
    ------
    ValueError
        there is no such file, or which of its rows is wrong.
    """
    path = Path(case).parent / name
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise ValueError(f"{str(path)!r} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ValueError(f"{str(path)!r} is no text") from None
    try:
        know([Origin(name, text)])
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


# --- which file is meant --------------------------------------------------------------------------
def file_with(name: str, case: str) -> Path | None:
    """A file of models beside a case in which `name` is written in quotes; it is not run."""
    found = [path for path in sorted(Path(case).parent.glob("*.py"))[:SEARCHED] if _has(path, name)]
    return min(found, key=lambda path: bool(to_mend(path)), default=None)


def files_with(name: str, case: str) -> list[Path]:
    """That file and, where it takes a law that another beside the case has, this one too."""
    file = file_with(name, case)
    if file is None:
        return []
    laws = re.findall(r"default_law=[\"']([^\"']+)", _text(file))
    theirs = (file_with(law, case) for law in laws if law not in all_laws())
    return list(dict.fromkeys([file, *(one for one in theirs if one is not None)]))


def _has(path: Path, name: str) -> bool:
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False
    return bool(re.search(_MADE, text)) and (f'"{name}"' in text or f"'{name}'" in text)


def to_mend(path: Path) -> str:
    """Where a file is no Python and cannot be loaded; empty where nothing is to be seen."""
    try:
        ast.parse(path.read_bytes())
    except SyntaxError as error:
        return f" (mend its line {error.lineno} first: {error.msg})"
    except (OSError, ValueError):
        return " (which is no Python)"
    return ""


def following(command: str, name: str, otherwise: str) -> str:
    """What to type where `command` knows no `name`: with the file here that has it, if one has."""
    file = file_with(name, "")
    return f"fiv {command} {name} --with {file}{to_mend(file)}" if file else otherwise
