"""Where a model or a law stands that is not in the box."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256


@dataclass(frozen=True)
class Origin:
    """The text of models and laws from outside.

    Attributes
    ----------
    path : the file, as given; of an installed package its name and version
    text : what stood there when it was read
    entry : ``module:name`` that an installed package offers; empty: `text` is the file itself
    """

    path: str
    text: str
    entry: str = ""

    @property
    def is_named(self) -> bool:
        """Whether it is known where a command names its file: a table is where a case does."""
        return not self.entry and self.path.endswith(".py")

    @cached_property
    def digest(self) -> str:
        """What tells texts apart, 64 hexadecimal digits."""
        return sha256(self.text.encode()).hexdigest()
