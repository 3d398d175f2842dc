"""Words of a figure: axis labels with symbol and unit, names of lines, the title."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fiv_cli.notation.names import dotted_symbol
from fiv_cli.reading.causes import settings_of

if TYPE_CHECKING:
    import xarray as xr

GREEK = frozenset(
    (
        *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "kappa", "lambda"),
        *("mu", "nu", "xi", "rho", "sigma", "tau", "phi", "chi", "psi", "omega"),
        *("Gamma", "Delta", "Theta", "Lambda", "Xi", "Sigma", "Phi", "Psi", "Omega"),
    )
)
# A name among words: Greek, with a number or a subscript, or a letter alone that is no word.
NAME = re.compile(
    rf"(?<![\w\\'-])(?:(?:{'|'.join(sorted(GREEK))})\w*|[A-Za-z]\d+\w*|[A-Za-z]_\w+|[B-HJ-Zb-hj-z])(?![\w-])"
)
FORMULA = re.compile(r"\w+ ?/ ?(?:\(|sqrt)")
# The thesis writes the angle with the open form of the letter.
VARIANTS = {"phi": r"\varphi"}

LONGEST_MEANING, LONGEST_WITHOUT_SYMBOL = 40, 60
START = "start: "  # before the meaning of a state
LONGEST_SUBSCRIPT = 3  # x_rms is a symbol, n_solutions is words
MOST_PARAMETERS = 2  # that tell datasets of one figure apart


def axis_label(variable: xr.DataArray, name: str = "") -> str:
    r"""What stands at an axis: ``disc speed $\Omega$ (rad/s)``, or ``$\varphi$ (rad)``.

    States where motions begin go by their symbols, since the meaning of one is short and of another
    long: ``initial $x$ (m)``; so do parameters of one value, of which it is the meaning of one:
    ``$V_1 = V_2$ (m/s)``.
    """
    name = name or str(variable.name)
    is_of_one = " = " not in str(variable.attrs.get("symbol", ""))
    meaning = str(variable.attrs.get("long_name", "")) if is_of_one else ""
    meaning = "initial" if meaning.startswith(START) and has_symbol(variable, name) else meaning
    most = LONGEST_MEANING if has_symbol(variable, name) else LONGEST_WITHOUT_SYMBOL
    words = with_symbols(meaning) if 0 < len(meaning) <= most else ""
    is_formula = bool(words and FORMULA.search(meaning))
    if has_symbol(variable, name):
        own = f"${symbol(variable, name)}$"
        before, formula, after = words.partition(" $") if is_formula else (words, "", "")
        words = f"{before} {own} = ${after}" if formula else f"{words} {own}".strip()
    words = words or quantity(variable, name)
    unit = unit_text(str(variable.attrs.get("units", "1")))
    return f"{words} ({unit})" if unit else words


def name_of(variable: xr.DataArray) -> str:
    r"""What stands at an axis without the unit, which stands there: ``greatest $x$``."""
    unit = unit_text(str(variable.attrs.get("units", "1")))
    return axis_label(variable).removesuffix(f" ({unit})")


def with_symbols(words: str) -> str:
    """Names of states and parameters among the words as symbols: ``x1 at the section``.

    From the first sign of a formula on (``c2 / (2 sqrt(m2 k2))``) all is one formula.
    """
    formula = FORMULA.search(words)
    if formula:
        begin = formula.start()
        roots = re.sub(r"sqrt\(([^()]*)\)", r"\\sqrt{\1}", words[begin:])
        inside = NAME.sub(lambda match: symbol_of_name(match[0]), roots)
        return f"{with_symbols(words[:begin])}${inside}$"
    return NAME.sub(lambda match: f"${symbol_of_name(match[0])}$", words)


def short_label(variable: xr.DataArray, name: str = "", of: str = "") -> str:
    r"""Symbol, what it is `of`, and unit, for narrow axes: ``$\dot{\varphi}$ (rad/s)``."""
    unit = unit_text(str(variable.attrs.get("units", "1")))
    words = f"{quantity(variable, name or str(variable.name))}{of}"
    return f"{words} ({unit})" if unit else words


def shared_label(variables: Sequence[xr.DataArray]) -> str:
    r"""Symbols of variables of one unit, and this: ``$x_\mathrm{min}$, $x_\mathrm{max}$ (m)``."""
    unit = unit_text(str(variables[0].attrs.get("units", "1")))
    words = _begun_alike([str(one.attrs.get("long_name", "")) for one in variables])
    if not words or any(has_symbol(one, str(one.name)) for one in variables):
        words = ", ".join(quantity(one, str(one.name)) for one in variables)
    return f"{words} ({unit})" if unit else words


def _begun_alike(names: Sequence[str]) -> str:
    """The words before the last "in" with which all begin: ``share of time``; "" without any."""
    begun = {name.rpartition(" in ")[0] for name in names}
    return begun.pop() if len(begun) == 1 else ""


def quantity(variable: xr.DataArray, name: str) -> str:
    """The symbol of a quantity or, where it goes by words, these: ``$\\dot{x}$ amplitude``."""
    if has_symbol(variable, name):
        return f"${symbol(variable, name)}$"
    state, amplitude, _ = name.partition("_amplitude")
    return f"${symbol_of_name(state)}$ amplitude" if amplitude else name.replace("_", " ")


def has_symbol(variable: xr.DataArray, name: str) -> bool:
    """Whether the quantity goes by a symbol rather than by words."""
    stem, *subscripts = name.removesuffix("_dot").partition("_over_")[0].split("_")
    letters = stem.rstrip("0123456789")
    short = len(letters) == 1 and all(len(word) <= LONGEST_SUBSCRIPT for word in subscripts)
    own = (letters in GREEK or short) and "amplitude" not in subscripts
    return "symbol" in variable.attrs or own


def symbol(variable: xr.DataArray, name: str) -> str:
    """LaTeX of a quantity, from the dataset where it stands there, else from its name."""
    return str(variable.attrs.get("symbol") or symbol_of_name(name))


def symbol_of_name(name: str) -> str:
    r"""LaTeX of an ASCII name: ``mu_k`` is ``\mu_{k}``, ``phi_dot`` is ``\dot{\varphi}``."""
    if "_over_" in name:
        return "/".join(map(symbol_of_name, name.split("_over_")))
    stem, dot, rest = name.partition("_dot")
    if dot and rest[:1] in ("", "_"):
        return dotted_symbol(symbol_of_name(stem + rest))
    stem, *subscripts = name.split("_")
    letters, digits = re.fullmatch(r"(.*?)(\d*)", stem).groups()  # type: ignore[union-attr]
    subscripts = [digits, *subscripts] if digits else subscripts
    letters = _letters(letters)
    return f"{letters}_{{{','.join(map(_letters, subscripts))}}}" if subscripts else letters


def _letters(word: str) -> str:
    """One part of a name: Greek, a letter, a number, or a word set upright."""
    if word in GREEK:
        return VARIANTS.get(word, f"\\{word}")
    return word if len(word) <= 1 or word.isdigit() else rf"\mathrm{{{word}}}"


def unit_text(unit: str) -> str:
    """A UDUNITS string as people write it: ``N s m-1`` is ``N s/m``, ``"1"`` is nothing."""
    if unit == "1":
        return ""
    factors = [_factor(token) for token in unit.split()]
    above = [_power(base, power) for base, power in factors if power > 0]
    below = [(base, power) for base, power in factors if power < 0]
    if above and len(below) == 1:
        return f"{' '.join(above)}/{_power(below[0][0], -below[0][1])}"
    return " ".join([*above, *(_power(base, power) for base, power in below)])


def _factor(token: str) -> tuple[str, int]:
    base, power = re.fullmatch(r"(.*?)([-+]?\d+)?", token).groups()  # type: ignore[union-attr]
    return base, int(power or 1)


def _power(base: str, power: int) -> str:
    return base if power == 1 else f"{base}$^{{{power}}}$"


def number_text(value: float, beside: Sequence[float] = ()) -> str:
    r"""A number as people write it: ``−0.5``, ``30``, ``$10^{7}$``, ``$2.5 \times 10^{-4}$``.

    With an exponent too where numbers `beside` it have one.
    """
    mantissa, _, exponent = f"{value:.6g}".partition("e")
    if not exponent and value and any("e" in f"{one:.6g}" for one in beside):
        mantissa, _, exponent = f"{value:.5e}".partition("e")
        mantissa = mantissa.rstrip("0").rstrip(".")
    if not exponent:
        return mantissa.replace("-", "\N{MINUS SIGN}")
    times = mantissa.removesuffix("1") if mantissa.strip("-") == "1" else rf"{mantissa} \times "
    return f"${times}10^{{{int(exponent)}}}$"


def value_label(axis: xr.DataArray, value: float | str) -> str:
    r"""One value of an axis: ``$N_0$ = 30 N``, ``$\beta$ = 15 deg``, or the label itself."""
    if axis.dtype.kind not in "fiu":
        return str(value) if any(map(str.isalpha, str(value))) else f"{axis.name} {value}"
    number, unit = float(value), unit_text(str(axis.attrs.get("units", "1")))
    if unit == "rad" and _whole_degrees(axis.values):
        number, unit = round(np.degrees(number)), "deg"
    return f"{quantity(axis, str(axis.name))} = {number_text(number)} {unit}".rstrip()


def values_along(axes: Sequence[xr.DataArray], index: int) -> list[str]:
    r"""One value of each of the axes that advance together; what is equal in all of it is one word.

    ``$c_1$ = $c_2$ = 3 N s/m``.
    """
    kinds = {(axis.dtype.kind, axis.attrs.get("units")) for axis in axes}
    alike = len(kinds) == 1 and all(np.array_equal(axis.values, axes[0].values) for axis in axes)
    if alike and next(iter(kinds))[0] in "fiu":
        return [_equal([axis[index] for axis in axes])]
    return [value_label(axis, axis.values[index]) for axis in axes]


def told_apart(files: Sequence[tuple[str, xr.Dataset]]) -> list[str]:
    r"""What to call each of several datasets in one figure: what they differ in, else their files.

    That is the law, or one or two fixed parameters or options: ``stribeck``; ``$c_1$ = $c_2$ = 3 N
    s/m``; ``$V_2$ = $V_1$``; or settings (``follow = up``) of the same starts, or those parameters
    that others vary.
    """
    datasets = [dataset for _, dataset in files]
    laws = [str(one.attrs.get("law", "")) for one in datasets]
    found = (
        laws
        if len(set(laws)) > 1
        else [", ".join(filter(None, words)) for words in zip(*_differing(datasets), strict=True)]
    )
    branches = ["branch_value" in one for one in datasets]  # they are called as their diagram is
    named = [name for name, branch in zip(found, branches, strict=False) if not branch] or found
    apart = len({*named}) == len(named) == (len(files) - sum(branches) or len(files))
    if apart and 0 < sum(branches) < len(files):  # branches lie over diagrams
        return found
    if apart:
        fixed = [_fixed_of_axes(one, datasets) for one in datasets]
        return [", ".join(filter(None, words)) for words in zip(found, fixed, strict=True)]
    fixed = [_fixed_of_axes(one, datasets) for one in datasets]
    if all(fixed) and len({*fixed}) == len(files):
        return fixed
    same_starts = len({str(one.attrs.get("starts_json")) for one in datasets}) == 1
    asked = _differing_settings(datasets)
    if same_starts and len({*asked}) == len(files):
        return asked
    alone = fixed.count("") == 1 < len(fixed)  # its own lines tell it from what is fixed
    return [
        name or ("" if alone and _has_lines(one, datasets) else file)
        for name, (file, one) in zip(fixed, files, strict=True)
    ]


def _has_lines(dataset: xr.Dataset, others: Sequence[xr.Dataset]) -> bool:
    """Whether it varies along an axis beside that of a figure, by itself, what others fix."""
    varied = [name for name, axis in dataset.coords.items() if axis.dims == (name,)]
    fixed = any(name in one.coords and one[name].ndim == 0 for name in varied for one in others)
    return fixed and sum(dataset.sizes[dim] > 1 for dim in dataset["status"].dims) > 1


def _differing_settings(datasets: Sequence[xr.Dataset]) -> list[str]:
    """In which settings of their analyses datasets differ, if these are few; "" for each if not.

    An analysis that one of them does not have is no setting.
    """
    each = [settings_of(dataset.attrs) for dataset in datasets]
    shared = [key for key in each[0] if all(key in one for one in each)]
    keys = [key for key in shared if any(one[key] != each[0][key] for one in each)]
    few = keys if len(keys) <= MOST_PARAMETERS else []
    return [
        ", ".join(f"{key.rpartition('.')[2]} = {_plain(one[key])}" for key in few) for one in each
    ]


def _plain(value: object) -> str:
    """A setting as a case gives it: ``1000`` of a float."""
    return f"{value:g}" if isinstance(value, float) else str(value)


def _fixed_of_axes(dataset: xr.Dataset, others: Sequence[xr.Dataset]) -> str:
    """The parameters of one value here that others vary, and those that others fix and an axis
    takes with it here; "" of none."""
    axes = [one.coords[name] for one in others for name in one["status"].coords]
    varied = {axis.name for axis in axes if axis.size > 1}
    kept = [dataset[name] for name in dataset.coords if name in varied - {_followed(dataset)}]
    alike: dict[tuple[object, float], list[xr.DataArray]] = {}
    for value in filter(_is_one_number, kept):
        alike.setdefault((value.attrs.get("units"), value.item()), []).append(value)
    return ", ".join([*map(_equal, alike.values()), *_led(dataset, others)])


def _led(dataset: xr.Dataset, others: Sequence[xr.Dataset]) -> Iterator[str]:
    """What others fix and an axis takes with it: ``$V_2$ = $V_1$``, or with other values."""
    fixed = {name for one in others for name, axis in one.coords.items() if not axis.ndim}
    for axis in (dataset[name] for name in dataset.coords if name in fixed):
        leaders = [one for one in dataset.coords.values() if one.dims == axis.dims and axis.ndim]
        plain = (one for one in leaders if one.name not in fixed and one.dtype.kind in "fiu")
        for leader in [*plain][:1]:
            how = "=" if np.array_equal(axis.values, leader.values) else "with"
            yield f"{quantity(axis, str(axis.name))} {how} {quantity(leader, str(leader.name))}"


def _differing(datasets: Sequence[xr.Dataset]) -> list[list[str]]:
    """Parameter of one value that differs -> that in each dataset; none where more than two do.

    Several that are equal in each dataset count as one.
    """
    differ: dict[tuple[object, ...], list[list[xr.DataArray]]] = {}
    for values in fixed_otherwise(datasets):
        numbers = (one.item() for one in values)
        differ.setdefault((values[0].attrs.get("units"), *numbers), []).append(values)
    chosen = _chosen_otherwise(datasets)
    if len(differ) + len(chosen) > MOST_PARAMETERS:
        return []
    return [*([*map(_equal, zip(*values, strict=True))] for values in differ.values()), *chosen]


def _chosen_otherwise(datasets: Sequence[xr.Dataset]) -> list[list[str]]:
    """Of options that all have, and of parameters that some tie to another one, what each has."""
    options = [json.loads(one.attrs.get("options_json", "{}")) for one in datasets]
    ties = [_ties(one) for one in datasets]
    shared = [name for name in options[0] if all(name in one for one in options)]
    names = dict.fromkeys([*shared, *(name for one in ties for name in one)])
    each = [
        [_chosen(name, *own) for own in zip(datasets, options, ties, strict=True)] for name in names
    ]
    return [words for words in each if len({*words}) > 1]


def _ties(dataset: xr.Dataset) -> dict[str, str]:
    """Parameter -> the one whose value it takes, as the name of the model tells: ``V2 = V1``."""
    _, *said = str(dataset.attrs.get("model", "")).split(" + ")
    return dict(text.split(" = ") for text in said if " = " in text)


def _chosen(
    name: str, dataset: xr.Dataset, options: Mapping[str, object], ties: Mapping[str, str]
) -> str:
    """What a dataset has of an option or a parameter that others tie; "" where it is an axis."""
    if name in ties:
        return f"${symbol_of_name(name)}$ = ${symbol_of_name(ties[name])}$"
    if name in options:
        return f"{name} = {options[name]}"
    fixed = name in dataset.coords and _is_one_number(dataset[name])
    return _equal([dataset[name]]) if fixed else ""


def fixed_otherwise(datasets: Sequence[xr.Dataset]) -> list[list[xr.DataArray]]:
    """The parameters that all hold fixed, not all at one value: those of each dataset.

    None is one that a branch follows: at which value it was begun says nothing of it.
    """
    followed = {_followed(one) for one in datasets}
    fixed = [
        [one[name] for one in datasets]
        for name in datasets[0].coords
        if all(name in one.coords and _is_one_number(one[name]) for one in datasets)
        and name not in followed
    ]
    return [values for values in fixed if len({one.item() for one in values}) > 1]


def _followed(dataset: xr.Dataset) -> str:
    """The parameter that branches follow; "" where there are none."""
    told = dataset["branch_value"].attrs.get("long_name", "") if "branch_value" in dataset else ""
    return str(told).partition(" ")[0]


def _is_one_number(coordinate: xr.DataArray) -> bool:
    """Whether it is a fixed parameter, or an axis of one value."""
    return coordinate.size == 1 and coordinate.dtype.kind in "fiu"


def _equal(parameters: Sequence[xr.DataArray]) -> str:
    """Parameters of one value, and it: ``$c_1$ = $c_2$ = 3 N s/m``."""
    *others, last = parameters
    symbols = [quantity(one, str(one.name)) for one in others]
    return " = ".join([*symbols, value_label(last, last.item())])


def _whole_degrees(angles: np.ndarray) -> bool:
    """Whether angles (rad) were most likely given in degrees: each is a whole number of them."""
    degrees = np.degrees(angles)
    return bool(np.any(degrees != 0.0) and np.all(np.abs(degrees - np.round(degrees)) < 1e-9))


def title_of(attributes: Mapping[str, object]) -> str:
    """Title and reference of the case."""
    title, reference = str(attributes.get("title", "")), str(attributes.get("reference", ""))
    return f"{title} ({reference})" if title and reference else title or reference
