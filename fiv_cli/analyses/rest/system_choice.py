"""Which system the linear analyses look at: the setting `system`, and what it adds to answers."""

from __future__ import annotations

from collections.abc import Iterator

from fiv_cli.analyses.settings import Choice, Known, Refusal
from fiv_cli.analyses.variables import Subject, Variable
from fiv_cli.friction import all_laws
from fiv_cli.notation.names import listed


class SystemChoice(Choice):
    """The system without its excitation, or averaged over it."""

    def check(self, value: str, known: Known) -> Iterator[Refusal]:
        """An average needs a fast motion, and laws that have one over it."""
        if value != "averaged":
            return
        if known.model.averaged_forcing() is None:
            message = f"{known.model.name} has no fast excitation to average over"
            yield Refusal(message, suggestion='write system = "original"')
        averaged = [name for name, law in all_laws().items() if law.average is not None]
        for law in [law for law in known.laws if law.average is None]:
            message = f"the law {law.name!r} has no average"
            yield Refusal(message, listed(averaged))


SYSTEM = SystemChoice(
    "system",
    "without its excitation, or averaged over it (thesis 5.7-5.15)",
    default="original",
    choices=("original", "averaged"),
)


def averaging(subject: Subject, along: str = "") -> list[Variable]:
    """How far an averaged system can be trusted."""
    if subject.settings.get("system") != "averaged":
        return []
    comment = "of the averaged system without damping; below 5 averaging is in doubt"
    name = "excitation frequency over the highest natural one"
    return [Variable("averaging_ratio", "1", name, along, comment=comment)]
