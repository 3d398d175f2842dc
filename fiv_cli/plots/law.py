"""A friction law: friction force over normal force against slip velocity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fiv_cli.errors import UsageError
from fiv_cli.friction import all_laws
from fiv_cli.friction.base import Law, Slip
from fiv_cli.notation.names import pick
from fiv_cli.plots import labels, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.typing import ColorType

FASTEST = 2.0  # m/s
SAMPLES = 801


def draw_laws(names: Sequence[str], look: style.Look | None = None) -> Figure:
    """The laws called `names`, with the defaults of their tables.

    Raises
    ------
    UsageError : there is no such law, or they share no axis
    """
    known = all_laws()
    laws = [pick(name, known, "friction law", "fiv models --laws") for name in names]
    with style.looks(look=look):
        figure = _draw(laws)
        style.finish(figure)
        return figure


def _draw(laws: Sequence[Law]) -> Figure:
    figure, (ax,) = style.new_panels(1, 1, _title(laws))
    for law, colour in zip(laws, style.line_colours(len(laws)), strict=True):
        _curve(ax, law, colour)
    forces = [not _scales_with_load(law) for law in laws]
    ratio = r"$F_\mathrm{T}/F_\mathrm{N}$"
    if any(forces) and not all(forces):
        raise UsageError("a law of force and a law of a coefficient share no axis\ndraw them apart")
    ax.set_ylabel(r"$F_\mathrm{T}$ (N)" if any(forces) else ratio)
    ax.set_xlabel(r"slip velocity $v_\mathrm{rel}$ (m/s)")
    ax.plot([], [], "--", color=style.BLACK, lw=1.0, label="held in stick")
    figure.legend(loc="outside lower center")
    return figure


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


def _curve(ax: Axes, law: Law, colour: ColorType) -> None:
    """Both branches, and between them what the contact can hold in stick."""
    speed = np.linspace(FASTEST / SAMPLES, FASTEST, SAMPLES) - FASTEST / SAMPLES * (1 - 1e-9)
    parameters = law.defaults
    for velocity, label in ((-speed[::-1], f"{law.name} ({_values(law)})"), (speed, "")):
        ax.plot(velocity, force(law, velocity, parameters), color=colour, label=label or None)
    if law.capacity is not None:
        held = float(law.capacity(1.0, parameters))
        ax.plot([0.0, 0.0], [-held, held], "--", color=colour, lw=1.0)


def _values(law: Law) -> str:
    given = law.defaults
    return ", ".join(
        f"${p.symbol}$ = {given[p.name]:g} {labels.unit_text(p.unit)}".rstrip()
        for p in law.parameters
    )
