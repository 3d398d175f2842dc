"""A friction law: friction force over normal force against slip velocity."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.errors import UsageError
from fiv_cli.friction import all_laws
from fiv_cli.friction.base import Law, Slip
from fiv_cli.notation.names import pick
from fiv_cli.own.load import following
from fiv_cli.plots import fitting, labels, legends, style
from fiv_cli.plots.drawn import DECORATION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FASTEST = 2.0  # m/s
SAMPLES = 801
STICK = ":"
FLAT = 5.0  # times as high as all others: what makes these look flat
TICK = 9.0  # size of the mark of what a law holds, pt

Given = tuple[Law, Mapping[str, float]]


def draw_laws(
    wanted: Sequence[str],
    look: style.Look | None = None,
    fastest: float = FASTEST,
    called: Sequence[str] = (),
) -> Figure:
    """Laws, each as ``NAME`` or ``NAME:PARAMETER=VALUE,...``; the rest by its table.

    Parameters
    ----------
    fastest : greatest slip velocity, m/s
    called : what each is called, if not by its name and parameters

    Raises
    ------
    UsageError : there is no such law or parameter, or they share no axis
    """
    laws = [_given(words) for words in wanted]
    with style.looks(look=look):
        names = called or [f"{law.name} ({_values(law, given)})" for law, given in laws]
        figure = _draw(laws, names, fastest)
        fitting.finish(figure)
        return figure


def _given(words: str) -> Given:
    """A law and the values of its parameters: ``stribeck:v_s=5 cm/s,mu_s=0.5``."""
    name, _, changes = words.partition(":")
    lists = following("plot --law", name.strip(), "fiv models --laws")
    law = pick(name.strip(), all_laws(), "friction law", lists)
    table = {parameter.name: parameter for parameter in law.parameters}
    given = {}
    for change in filter(str.strip, changes.split(",")):
        key, _, value = map(str.strip, change.partition("="))
        parameter = pick(key, table, f"parameter of {law.name}", f"fiv models {law.name}")
        try:
            given[key] = parameter.read(value)
        except ValueError as error:
            raise UsageError(
                f"--law {words}: {key}: {error}\nmust be {parameter.allowed}"
            ) from None
    return law, law.completed(given)


def _draw(laws: Sequence[Given], names: Sequence[str], fastest: float) -> Figure:
    figure, (ax,) = style.new_panels(1, 1, _title([law for law, _ in laws]))
    for number, given in enumerate(laws):
        colour = style.line_colours(len(laws))[number]
        look = {"color": colour, "ls": style.dash(number, len(laws))}
        _curve(ax, given, names[number], fastest, look, alone=len(laws) == 1)
    if len(laws) > 1:  # upon one another they would not be told apart
        _mark_held(ax, laws)
    forces = [not _scales_with_load(law) for law, _ in laws]
    ratio = "$F_T/F_N$"
    if any(forces) and not all(forces):
        of_force = [law.name for (law, _), is_force in zip(laws, forces, strict=True) if is_force]
        raise UsageError(
            f"{', '.join(of_force)}: of force, and the others of a coefficient, which share no axis"
            "\nnext: draw them apart"
        )
    ax.set_ylabel("$F_T$ (N)" if any(forces) else ratio)
    ax.set_xlabel(r"slip velocity $v_\mathrm{rel}$ (m/s)")
    if held := {_held(*given) for given in laws} - {0.0}:
        several: dict[str, Any] = {"marker": "_", "ms": TICK, "mew": 1.2}
        marks = several if len(laws) > 1 else {}
        to = (": each law to its mark" if len(held) > 1 else ", to the marks") * bool(marks)
        told = f"held in stick{to}"
        ax.plot([], [], STICK, color=style.BLACK, lw=1.2, label=told, **marks)
    style.add_notes(figure, [*_flattened(laws, fastest)])
    legends.colour_keys([ax])
    legends.legend_below(figure, legends.told_in([ax])[0])
    return figure


def _flattened(laws: Sequence[Given], fastest: float) -> Iterator[str]:
    """That one law reaches so far that the others look flat."""
    speed = np.linspace(fastest / SAMPLES, fastest, SAMPLES)
    reach = [float(np.abs(force(law, speed, given)).max()) for law, given in laws]
    *others, most = sorted(reach)
    if others and most > FLAT * others[-1]:
        law = laws[reach.index(most)][0].name
        yield (
            f"{law} reaches {most:.3g}, the others {others[-1]:.3g}, which look flat: "
            "a lower --speed, or it alone"
        )


def _title(laws: Sequence[Law]) -> str:
    title = laws[0].title if len(laws) == 1 else "friction laws"
    return title[0].upper() + title[1:]


def force(law: Law, velocity: np.ndarray, parameters: Mapping[str, float]) -> np.ndarray:
    """Friction force, N, under a normal force of 1 N at slip velocities (m/s) of one sign."""
    import sympy

    v = sympy.Symbol("v", real=True)
    sign = int(np.sign(velocity.sum()))
    values = {name: sympy.nsimplify(value) for name, value in parameters.items()}
    rows = law.row_symbols()
    slip = Slip(v, sympy.Integer(sign), sign * v, sympy.Integer(1), rows=rows)
    evaluate = sympy.lambdify([v, rows], law.sliding(slip, values), "numpy")
    numbers = np.array([law.rows_at(x, parameters) for x in velocity.tolist()])
    found = evaluate(velocity, np.moveaxis(numbers, 0, -1))
    return np.broadcast_to(np.asarray(found, dtype=float), velocity.shape)


def _scales_with_load(law: Law) -> bool:
    """Whether the normal force enters, so that F_T / F_N means something."""
    import sympy

    load = sympy.Symbol("N", positive=True)
    v = sympy.Symbol("v", positive=True)
    slip = Slip(v, sympy.Integer(1), v, load, rows=law.row_symbols())
    expression = law.sliding(slip, law.defaults)
    return bool(sympy.sympify(expression).has(load))


def _curve(
    ax: Axes, given: Given, name: str, fastest: float, look: dict[str, Any], alone: bool
) -> None:
    """Both branches, and between them what the contact can hold in stick: of several, its ends."""
    law, parameters = given
    speed = np.linspace(fastest / SAMPLES, fastest, SAMPLES) - fastest / SAMPLES * (1 - 1e-9)
    for velocity, label in ((-speed[::-1], name), (speed, f"_{name}")):
        ax.plot(velocity, force(law, velocity, parameters), label=label, **look)
    if held := _held(*given):
        line = {"ls": STICK, "lw": 1.2} if alone else {"ls": "none", "marker": "_", "ms": TICK}
        ax.plot([0.0, 0.0], [-held, held], **look | line, label=f"_{name}, held in stick")


def _mark_held(ax: Axes, laws: Sequence[Given]) -> None:
    """One line of what any law holds, with a mark at its ends of each; black of all that agree."""
    held = [_held(*given) for given in laws]
    look: dict[str, Any] = {"color": style.BLACK, "lw": 1.2, "label": DECORATION}
    if max(held) > 0.0:
        ax.plot([0.0, 0.0], [-max(held), max(held)], STICK, **look)
    for alike in {value for value in held if value and held.count(value) > 1}:
        ends = {"ls": "none", "marker": "_", "ms": TICK, "zorder": 3}
        ax.plot([0.0, 0.0], [-alike, alike], **look | ends)


def _held(law: Law, parameters: Mapping[str, float]) -> float:
    """The force that a contact can hold in stick; 0 of a law that does not stick."""
    return 0.0 if law.capacity is None else float(law.capacity(1.0, parameters))


def _values(law: Law, given: Mapping[str, float]) -> str:
    return ", ".join(
        f"${p.symbol}$ = {given[p.name]:g} {labels.unit_text(p.unit)}".rstrip()
        for p in law.parameters
    )
