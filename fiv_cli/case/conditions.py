"""Conditions on the value ``.``, such as ``"0.9 <= . < 1.8"`` or ``". == 0.3"``: their grammar."""

from __future__ import annotations

import re

Test = tuple[str, float]
"""A sign of comparison and a bound: what ``.`` stands to the left of."""

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_CONDITION = re.compile(
    rf"\s*(?:(?P<low>{_NUMBER})\s*(?P<left><=?)\s*)?\.\s*"
    rf"(?:(?P<right><=?|>=?|==)\s*(?P<high>{_NUMBER})\s*)?"
)


def parse_condition(text: str) -> tuple[Test, ...]:
    """What `text` demands of ``.``, one or two tests; none when it is no condition."""
    parts = _CONDITION.fullmatch(text)
    if parts is None:
        return ()
    tests = []
    if parts["left"]:
        # ``a < .`` is ``. > a``
        tests.append((parts["left"].replace("<", ">"), float(parts["low"])))
    if parts["right"]:
        tests.append((parts["right"], float(parts["high"])))
    return tuple(tests)
