"""Names as people write them: Greek spellings, and what a misspelt name may have meant."""

from __future__ import annotations

import difflib
import re
from collections.abc import Collection, Iterable, Mapping
from typing import TypeVar

from fiv_cli.errors import UsageError

T = TypeVar("T")

_GREEK = {
    "α": "alpha",
    "β": "beta",
    "γ": "gamma",
    "δ": "delta",
    "ε": "epsilon",
    "ζ": "zeta",
    "η": "eta",
    "θ": "theta",
    "ϑ": "theta",
    "κ": "kappa",
    "λ": "lambda",
    "μ": "mu",
    "µ": "mu",
    "ν": "nu",
    "ξ": "xi",
    "ρ": "rho",
    "σ": "sigma",
    "τ": "tau",
    "φ": "phi",
    "ϕ": "phi",
    "ψ": "psi",
    "ω": "omega",
    "\N{GREEK CAPITAL LETTER OMEGA}": "Omega",
    "\N{OHM SIGN}": "Omega",
}
_SUBSCRIPTS = dict(zip("₀₁₂₃₄₅₆₇₈₉ₖₛₐ", "0123456789ksa", strict=True))
_ASCII = str.maketrans({**_GREEK, **_SUBSCRIPTS})
_SYNONYMS = {"mu_1": "mu_k"}  # chapter 4 of the thesis
_DECLARED: dict[str, frozenset[str]] = {}


def ascii_name(name: str) -> str:
    """The contract spelling of `name`: ``Ω`` -> ``Omega``, ``μ_k`` and ``μ_1`` -> ``mu_k``."""
    parts = name.translate(_ASCII).split(".")
    return ".".join(part if _is_declared(part) else _SYNONYMS.get(part, part) for part in parts)


def declare(kind: str, names: Iterable[str]) -> None:
    """Have the names that things of a `kind` declare mean themselves, though one be a synonym."""
    _DECLARED[kind] = frozenset(names)


def _is_declared(name: str) -> bool:
    return any(name in names for names in _DECLARED.values())


def axis_name(name: str) -> str:
    """The contract name of an axis or a parameter: ``friction.μ_k`` -> ``mu_k``."""
    return ascii_name(name).removeprefix("friction.")


def can_name_a_file(name: str) -> bool:
    """Whether `name` can be part of the name of a file, and be shown."""
    return bool(name) and name.isprintable() and not {"/", "\\"} & set(name)


def pick(name: str, known: Mapping[str, T], what: str, following: str) -> T:
    """What is called `name`.

    Raises
    ------
    UsageError
        nothing is; says what may have been meant, and what to type next (`following`).
    """
    if name not in known:
        hint = suggest(name, known.keys()) or f"there are: {listed(known)}"
        raise UsageError(f"there is no {what} {name!r}; {hint}\nnext: {following}")
    return known[name]


def suggest(name: str, known: Collection[str]) -> str:
    """A "did you mean" for `name`, or "" when nothing known resembles it.

    Names that differ from `name` in case only come first and are all listed, because ``Omega``
    and ``omega`` are different parameters. A mapping's values are printed as explanations.
    """
    candidates = _candidates(name, known)
    if not candidates:
        return ""
    return f"did you mean {' or '.join(_explained(one, known) for one in candidates)}?"


def nearest(name: str, known: Collection[str]) -> str | None:
    """The name that `suggest` would put first; None when nothing known resembles it."""
    return next(iter(_candidates(name, known)), None)


def dotted_symbol(symbol: str) -> str:
    r"""LaTeX of a rate of change: ``x_1`` -> ``\dot{x}_1``."""
    letter, subscript, rest = symbol.partition("_")
    return rf"\dot{{{letter}}}{subscript}{rest}"


def surely_meant(name: str, known: Collection[str]) -> str | None:
    """The name that can only be meant, so that what is given of it is read; None for none."""
    near = difflib.get_close_matches(name, list(known), n=1, cutoff=0.75)
    return next(iter(_same_but_for_case(name, known) or near), None)


def listed(names: Collection[str]) -> str:
    """The names in one line, for "allowed: ..."."""
    return ", ".join(names) if names else "none"


def _candidates(name: str, known: Collection[str]) -> list[str]:
    return _same_but_for_case(name, known) or _similar(name, known)


def _same_but_for_case(name: str, known: Collection[str]) -> list[str]:
    return [one for one in known if one.lower() == name.lower()] or [
        one for one in known if _bare(one) == _bare(name)
    ]


def _bare(name: str) -> str:
    return name.lower().replace("_", "").replace("-", "")


def _similar(name: str, known: Collection[str]) -> list[str]:
    near = difflib.get_close_matches(name, list(known), n=2, cutoff=0.6)
    near = near or [one for one in known if len(name) > 2 and one.startswith(name)][:2]
    told = {word for one in near for word in one.split("_")}
    untold = {word for word in name.split("_") if len(word) > 2} - told
    sharing = [one for one in known if untold & {*one.split("_")}]
    return near + difflib.get_close_matches(name, sharing, n=1, cutoff=0.0)


def _explained(name: str, known: Collection[str]) -> str:
    meaning = re.split(r"[;:(]", f"{known[name]}")[0].strip() if isinstance(known, Mapping) else ""
    return f"{name!r} ({meaning})" if meaning else repr(name)
