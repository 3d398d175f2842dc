"""Writing figures to files whose bytes depend on the data alone."""

from __future__ import annotations

import io
from pathlib import Path

from matplotlib.figure import Figure

from fiv_cli.errors import StorageError, UsageError
from fiv_cli.files import refuse_special, write_whole
from fiv_cli.plots import drawn, fitting, style

IMMENSE = 1e250  # what matplotlib squares on its way must stay a number

# What each format would otherwise stamp with the time of writing.
UNDATED = {
    ".png": {"Software": "fiv"},
    ".svg": {"Date": None, "Creator": "fiv"},
    ".pdf": {"CreationDate": None, "ModDate": None, "Creator": "fiv", "Producer": "fiv"},
}
TABLE = ".csv"


def refuse_the_immense(figure: Figure, path: Path) -> None:
    """Refuse axes so long that no ticks can be set on them.

    Raises
    ------
    UsageError
    """
    for axes in figure.axes:
        for low, high in (axes.get_xlim(), axes.get_ylim()):
            if not abs(low) < IMMENSE > abs(high):
                raise UsageError(
                    f"{path}: it would reach from {low:g} to {high:g}, which cannot be drawn\n"
                    "next: choose a part with `select`, `xlim` or `ylim` in the [[figure]]"
                )


def save(figure: Figure, path: str | Path, look: style.Look | None = None) -> None:
    """Write `figure`, drawn in a look, as PNG, SVG or PDF, or as the numbers that it draws (CSV).

    Raises
    ------
    UsageError : another suffix, or what is there is no regular file; a plane as CSV
    StorageError : the file cannot be written
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in UNDATED | {TABLE: {}}:
        told = f"{path}: figures are written as {', '.join(UNDATED)}"
        table = f", or, for the numbers that it draws, {path.stem or 'NAME'}{TABLE}"
        raise UsageError(f"{told}\nuse -o {path.stem or 'NAME'}.png{table}")
    refuse_special(path)
    contents = (
        drawn.as_csv(figure, path).encode() if suffix == TABLE else _image(figure, path, look)
    )
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, contents, durable=False)
    except OSError as error:
        raise StorageError(
            f"{path}: cannot be written ({error.strerror})\nchoose -o FIG"
        ) from error


def _image(figure: Figure, path: Path, look: style.Look | None) -> bytes:
    """The bytes of an image of the format that `path` names."""
    image, suffix = io.BytesIO(), path.suffix.lower()
    with style.looks(look=look):
        refuse_the_immense(figure, path)
        fitting.tame_texts(figure)
        figure.savefig(image, format=suffix[1:], metadata=UNDATED[suffix])
    return image.getvalue()
