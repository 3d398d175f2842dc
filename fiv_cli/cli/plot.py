"""``fiv plot``: the figures of a dataset, and friction laws."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from string import ascii_letters
from typing import TYPE_CHECKING, Any

import click

from fiv_cli.case.identity import MOTION
from fiv_cli.cli.common import provide_cache, with_option
from fiv_cli.errors import EmptyFigureError, UsageError
from fiv_cli.notation.names import listed

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from fiv_cli.case.case import FigureSpec
    from fiv_cli.plots import Look

    Source = tuple[Path, dict[str, xr.Dataset]]
    Sources = list[Source]
    Wanted = tuple[Path, Sources, FigureSpec]  # by default written to, drawn from


LINES_ALONE = (
    "the lines on the map alone; the map itself: fiv show FILE.nc --csv VARIABLE -o FILE.csv"
)
OWN_NAMES = "; lines drawn over those of another file have names of their own"
OF_A_VARIABLE = ("level", "border", "ylim", "zlim", "ylabel", "zlabel")  # settings of a figure
SAID_OF_A_FLAG = ("on", "off", "yes", "no", "true", "false", "none", "")


class Millimetres(click.ParamType):
    """A number of millimetres, or a length with its unit: ``84``, ``84mm``, ``8.4 cm``."""

    name = "MM"

    def convert(
        self, value: Any, parameter: click.Parameter | None, context: click.Context | None
    ) -> float:
        """The length, mm."""
        from fiv_cli.notation.units import convert

        text = str(value).strip()
        number = text.rstrip(ascii_letters)
        unit = text.removeprefix(number)
        try:
            return 1e3 * convert(f"{number.strip()} {unit}", "m") if unit else float(number)
        except ValueError:
            self.fail(f"{value!r} is no length: a number of mm, 84, or one with its unit, 8.4cm")


@click.command("plot")
@click.argument("files", nargs=-1, type=click.Path(path_type=Path), metavar="[FILE.nc...]")
@click.option(
    "-o",
    "--output",
    "outputs",
    type=click.Path(path_type=Path),
    multiple=True,
    help="Figure to write: .png, .svg or .pdf; .csv: its points and lines as numbers (repeatable). "
    "Default: STEM-FIGURE.png beside the dataset.",
)
@click.option(
    "--figure",
    "names",
    multiple=True,
    help="Draw this figure of the case only, or this kind of figure (repeatable).",
)
@click.option(
    "--variable",
    "variables",
    multiple=True,
    metavar="NAME",
    help="What that figure shows, in place of what its case says (repeatable); with --figure. "
    "Numbers of its own are left out: level = 2, zlim, ... "
    "fiv variables lists what there is, of a motion F_T, F_N, ... too.",
)
@click.option(
    "--label",
    "labels",
    multiple=True,
    metavar="WORDS",
    help="What to call a file among several, or a law: one for each, in their order, symbols "
    "between $ ('$N_0$ = 10 N'). Where one is drawn over "
    "the other, as a branch over its diagram, their lines have names of their own.",
)
@with_option
@click.option(
    "--law",
    "laws",
    multiple=True,
    metavar="NAME[:PARAMETER=VALUE,...]",
    help="Draw a friction law instead (repeatable).",
)
@click.option(
    "--speed", type=float, metavar="M/S", help="Greatest slip velocity of laws. Default: 2."
)
@click.option(
    "--loop",
    metavar="amplitude=A,omega=W,...",
    help="Force of laws over a slip that swings; see fiv kinds characteristic.",
)
@click.option(
    "--style", default="screen", help="What figures are for: screen, paper (90 mm, Times), talk."
)
@click.option("--width", type=Millimetres(), metavar="MM", help="Width of the whole figure, mm.")
@click.option(
    "--height", type=Millimetres(), metavar="MM", help="Its height, mm. Default: as it needs."
)
@click.option("--font", metavar="NAME", help="Font family, one that is installed.")
@click.option(
    "--title/--no-title", "titled", default=None, help="The title above. Default: not on paper."
)
def command(
    files: tuple[Path, ...],
    outputs: tuple[Path, ...],
    names: tuple[str, ...],
    variables: tuple[str, ...],
    labels: tuple[str, ...],
    laws: tuple[str, ...],
    speed: float | None,
    loop: str | None,
    style: str,
    width: float | None,
    height: float | None,
    font: str | None,
    titled: bool | None,
) -> None:
    """Draw the figures of datasets and print their paths.

    What is drawn stands in the [[figure]] tables of the case that the dataset carries; without
    any, a figure of each kind that suits it. Several files share one figure where that makes sense
    (curve, bifurcation, branch, history, phase), each called by what it differs in, or as --label
    says; a bifurcation diagram takes the cycles of files that hold a branch, and so does a curve of
    an amplitude or extreme; over basins lie, with --figure basin, the motions of histories. Kinds:
    map, basin, bifurcation, curve, branch, eigenvalues, history, phase, spectrum, spectrogram,
    mode-shape. A figure that would be empty is not written, and says why. Of several figures -o
    b.png makes b-a-NAME.png of each.

    \b
    Examples:
      fiv new pin-on-disc > a.toml && fiv run a.toml && fiv plot runs/a.nc
      fiv plot runs/a.nc --figure bifurcation -o a.pdf --style paper --width 84
      fiv history a.toml --at Omega=2 -o m.nc && fiv plot m.nc --figure history --variable F_T
      fiv run a.toml --set model.parameters.N0=20 -o lighter.nc
      fiv plot runs/a.nc lighter.nc --figure bifurcation -o both.svg -o both.csv
      fiv plot --law coulomb --law stribeck:mu_s=0.5,v_s=0.05 --speed 0.3
      fiv plot --law dahl --law lugre:sigma_1=10 --loop amplitude=1e-3,omega=5,periods=3
    """
    if bool(files) == bool(laws):
        raise UsageError("plot: name either datasets or laws\nexample: fiv plot runs/CASE.nc")
    what, count = ("law", len(laws)) if laws else ("file", len(files))
    if labels and loop is None and len(labels) != count:
        raise UsageError(
            f"--label: {len(labels)} for {count} {what}s\nnext: one --label WORDS for each {what}"
        )
    if labels and loop is not None:
        raise UsageError("--label: laws over a loop have their names\nnext: leave it out")
    if len(labels) == 1 and files:
        raise UsageError("--label: it tells several files in one figure apart\nnext: leave it out")
    if variables and (laws or len(names) != 1):
        raise UsageError("--variable: of which figure?\nnext: --figure KIND --variable NAME")
    if loop is not None and not laws:
        raise UsageError("--loop: of which law?\nnext: --law NAME --loop amplitude=A,omega=W")
    if titled and any(file.name.lower() in SAID_OF_A_FLAG and not file.exists() for file in files):
        raise UsageError("--title takes no value\nnext: --title, or --no-title")
    from fiv_cli.plots import look_of, save
    from fiv_cli.plots.drawn import has_plane

    look = look_of(style, width, font, titled, height)
    undrawn: list[UsageError] = []
    if loop is not None:
        figures = _of_loops(laws, loop, look)
    else:
        wanted = (files, names, variables, labels or [""] * len(files), look, undrawn)
        figures = _of_laws(laws, look, speed, labels) if laws else _of_files(*wanted)
    for path, figure in _with_paths(figures, outputs):
        try:
            save(figure, path, look)
            click.echo(path)
            if path.suffix == ".csv" and has_plane(figure):
                click.echo(f"{path}: {LINES_ALONE}", err=True)
        except UsageError as error:
            undrawn.append(error)
    for one in undrawn[:-1]:
        click.echo(one, err=True)
    if undrawn:
        raise undrawn[-1]


def _of_laws(
    laws: Sequence[str], look: Look, speed: float | None, called: Sequence[str]
) -> list[tuple[Path, Figure]]:
    """(default path, figure) of the laws in one figure."""
    from fiv_cli.own.load import seek
    from fiv_cli.plots import draw_laws
    from fiv_cli.plots.style import notes_on

    parts = [law.partition(":") for law in laws]
    laws = ["".join([seek(name), *changes]) for name, *changes in parts]
    names = dict.fromkeys(law.partition(":")[0].replace(" ", "-") for law in laws)
    given = {} if speed is None else {"fastest": speed}
    figure = draw_laws(laws, look, called=called, **given)
    for note in notes_on(figure):
        click.echo(f"figure of laws: {note}", err=True)
    return [(Path("runs") / f"law-{'-'.join(names)}.png", figure)]


def _of_loops(laws: Sequence[str], loop: str, look: Look) -> list[tuple[Path, Figure]]:
    """(default path, figure) of the force of each law over the slip."""
    from fiv_cli import api
    from fiv_cli.own.load import seek
    from fiv_cli.plots import draw

    provide_cache()
    parts = [law.partition(":") for law in laws]
    given = {seek(name): _assigned(changes) for name, _, changes in parts}
    if len(given) < len(laws):
        raise UsageError("--loop: a law is given twice\nnext: draw its loops apart")
    case = {
        "schema": 1,
        "title": "friction force over slip",
        "model": {"name": "belt-1dof"},  # whose mechanics take no part
        "friction": {name: changes for name, changes in given.items() if changes},
        "grid": {"friction": list(given)},
        "analysis": [{"kind": "characteristic", **_assigned(loop)}],
        "figure": [{"kind": "phase", "x": "slip", "y": "F_T"}],
    }
    loaded = api.load(case)
    dataset: Any = api.run(loaded, workers=1)  # of one analysis
    names = "-".join(name.replace(" ", "-") for name in given)
    return [(Path("runs") / f"loop-{names}.png", draw(dataset, loaded.figures[0], look=look))]


def _assigned(text: str) -> dict[str, float | int | str]:
    """``A=1e-3,B=5 cm`` as name -> number, or quantity."""
    found: dict[str, float | int | str] = {}
    for part in filter(str.strip, text.split(",")):
        name, _, value = map(str.strip, part.partition("="))
        found[name] = _number(value)
    return found


def _number(text: str) -> float | int | str:
    for kind in (int, float):
        with suppress(ValueError):
            return kind(text)
    return text


def _of_files(
    files: Sequence[Path],
    names: Sequence[str],
    variables: Sequence[str],
    called: Sequence[str],
    look: Look,
    undrawn: list[UsageError],
) -> list[tuple[Path, Figure]]:
    """(default path, figure) of every figure; those that overlay are drawn once for all files.

    One that would be empty is left out and says why on stderr, and so is every other that cannot be
    drawn but the last, which is added to `undrawn`.

    Raises
    ------
    UsageError : there is none at all
    """
    from fiv_cli.plots import nothing_suits
    from fiv_cli.plots.drawn import in_one_line
    from fiv_cli.plots.style import notes_on
    from fiv_cli.plots.style import unsaid as words_without_place
    from fiv_cli.reading.datasets import read_analyses

    drawn, left_out = [], []
    wanted = [*_asked(files, names, called)]
    for default, sources, asked in _plain(wanted, names[0]) if variables else wanted:
        try:
            figure = _showing(asked, variables)
            drawn.append((default, _drawn(sources, figure, look)))
            for name in _unsaid(drawn[-1][1], _names_in(sources, figure)):
                click.echo(f"--label {name}: not in the figure {figure.name}{OWN_NAMES}", err=True)
            for note in notes_on(drawn[-1][1]):
                click.echo(f"figure {figure.name}: {in_one_line(note)}", err=True)
            if unsaid := words_without_place(drawn[-1][1]):
                told = f"figure {figure.name}: words: {', '.join(map(repr, unsaid))}"
                said = "; ".join(_said(drawn[-1][1]))
                click.echo(f"{told}: in no legend and at no axis; there: {said}", err=True)
        except UsageError as error:
            whose = sources[0][0] if len(sources) == 1 else "all files"
            left_out.append(type(error)(f"figure {asked.name} of {whose}: not written: {error}"))
    if not drawn:
        for one in left_out[1:]:
            click.echo(one, err=True)
        raise left_out[0] if left_out else nothing_suits(read_analyses(files[0]))
    wrong = [error for error in left_out if not isinstance(error, EmptyFigureError)]
    undrawn += wrong[-1:]
    for one in left_out:
        if one not in undrawn:
            click.echo(one, err=True)
    return drawn


def _showing(figure: FigureSpec, variables: Sequence[str]) -> FigureSpec:
    """A figure of the variables that are named, if any are, without what its case says of its own.

    Raises
    ------
    UsageError : it takes a share, say, of its own
    """
    if not variables:
        return figure
    if "take" in figure.settings:
        raise UsageError(
            f"--variable: figure {figure.name} takes {figure.settings['take']['what']} of its own\n"
            f"next: --figure {figure.kind} --variable NAME, or a figure of it in the case"
        )
    kept = {key: value for key, value in figure.settings.items() if key not in OF_A_VARIABLE}
    if isinstance(level := figure.settings.get("level"), Mapping):  # which say of what they are
        kept["level"] = level
    return replace(figure, settings={**kept, "variable": [*variables]})


def _plain(wanted: Sequence[Wanted], kind: str) -> list[Wanted]:
    """Of the figures of a kind those that take nothing of what they show, or all without it; of a
    name the figure itself."""
    if any(figure.name == kind for *_, figure in wanted):
        return [*wanted]
    own = [{k: one for k, one in figure.settings.items() if k != "take"} for *_, figure in wanted]
    plain = [one for one, kept in zip(wanted, own, strict=True) if kept == one[2].settings]
    return plain or [
        (path, of, replace(figure, settings=kept))
        for (path, of, figure), kept in zip(wanted, own, strict=True)
    ]


def _names_in(sources: Sources, figure: FigureSpec) -> list[str]:
    """The names of files that a figure of several should have; that of one under others none."""
    from fiv_cli.plots.drawing import KINDS

    under = 0 if KINDS[figure.kind].overlays else 1
    named = sources[under:] if len(sources) > 1 else []
    return [name for _, one in named if (name := next(iter(one.values())).attrs.get("called"))]


def _said(figure: Figure) -> list[str]:
    """The words at the axes of a figure and in its legends, before its own took their places."""
    from fiv_cli.plots.style import before

    legends = [*figure.legends, *(one for ax in figure.axes if (one := ax.get_legend()))]
    texts = [text for legend in legends for text in legend.get_texts()]
    texts += [text for ax in figure.axes for text in (ax.title, ax.xaxis.label, ax.yaxis.label)]
    return [*dict.fromkeys(before(figure, text.get_text()) for text in texts if text.get_text())]


def _unsaid(figure: Figure, names: Sequence[str]) -> list[str]:
    """The names of files that stand nowhere in a figure."""
    from matplotlib.text import Text

    texts = " ".join(one.get_text() for one in figure.findobj(Text)).replace("\n", " ")
    return [name for name in names if name not in texts]


def _asked(files: Sequence[Path], names: Sequence[str], called: Sequence[str]) -> Iterator[Wanted]:
    """(default path, what it is drawn from, figure) of every figure that is asked for."""
    from fiv_cli.reading.changed import changed_since
    from fiv_cli.reading.datasets import read_analyses

    sources = [
        (file, {name: one.assign_attrs(called=own) for name, one in read_analyses(file).items()})
        for file, own in zip(files, called, strict=True)
    ]
    for file, source in sources:
        attributes = next(iter(source.values())).attrs
        if "partial" in attributes:
            click.echo(f"{file}: partial, {attributes['partial']}", err=True)
        if changed := changed_since(attributes, file):
            click.echo(f"WARNING: {file} is drawn as it was run; {changed}", err=True)
    for name in dict.fromkeys(names) or [None]:
        yield from _called(name, sources)


def _called(name: str | None, sources: Sources) -> Iterator[Wanted]:
    """(default path, what it is drawn from, figure) of what is called `name`; None: of every."""
    from fiv_cli.plots import nothing_suits
    from fiv_cli.plots.drawing import KINDS

    lender = next((source for _, source in sources if _has_figure(source, name)), None)
    shared: set[str] = set()  # figures of files before, in which later ones have their part
    for place, (file, source) in enumerate(sources):
        if name in shared:
            return
        asks = lender if lender and not _has_figure(source, name) else source
        before = frozenset(shared)
        figures = _chosen(file, asks, name)
        if not figures and len(sources) > 1 and not before:
            why = str(nothing_suits(source)).replace("\n", "; ")
            click.echo(f"{file}: left out: {why}", err=True)
        for figure in figures:
            default = file.with_name(f"{file.stem}-{figure.name}.png")
            if len(sources) == 1:
                yield default, sources, figure
            elif not KINDS[figure.kind].overlays:
                over = _over(sources, figure) if KINDS[figure.kind].completed else []
                if name is None:  # each file has its own figures
                    _tell_of_what_may_lie_over(sources[place], over, figure)
                    over = []
                if (file, source) not in over:
                    yield default, [_labelled(sources, place, over), *over], figure
            elif not before & {figure.name, figure.kind}:
                shared |= {figure.name, figure.kind}
                yield default, sources[place:], figure


def _has_figure(source: dict[str, xr.Dataset], name: str | None) -> bool:
    """Whether the case of a dataset has a figure of this name, or it is drawn so unasked; of those
    that show all files, which are as a case asks wherever it stands among them, only the former."""
    from fiv_cli.plots import figures_of
    from fiv_cli.plots.drawing import KINDS
    from fiv_cli.reading.datasets import figures_in

    shows_all = name in KINDS and KINDS[name].overlays
    figures = figures_in(source) if shows_all else figures_of(source)
    return any(figure.name == name for figure in figures)


def _over(sources: Sources, figure: FigureSpec) -> Sources:
    """The files that cannot be drawn so, and may lie over those that can, if there are any."""
    from fiv_cli.plots import can_draw

    over = [one for one in sources if not can_draw(one[1], figure)]
    return over if len(over) < len(sources) else []


def _tell_of_what_may_lie_over(one: Source, others: Sources, figure: FigureSpec) -> None:
    """Name the files that a figure of another takes in where it is asked for."""
    from fiv_cli.plots import Look

    taken = [other for other in others if _failure(_named([one, other]), figure, Look()) is None]
    for file, _ in taken:
        command = f"fiv plot {one[0]} {file} --figure {figure.name}"
        click.echo(f"{file} may lie over the figure {figure.name}: {command}", err=True)


def _labelled(sources: Sources, place: int, over: Sources) -> tuple[Path, dict[str, xr.Dataset]]:
    """A file whose figures say what it differs in from the others, but those that lie `over` it."""
    file, source = sources[place]
    under = [one for one in sources if one not in over]
    label = next(label for label, one in _named(under) if one is source)
    titles = {str(next(iter(one.values())).attrs.get("title", "")) for _, one in under}
    label = label if label != file.stem or len(titles) < len(under) else ""  # the title tells
    return file, {n: one.assign_attrs(differs=label, overrides="") for n, one in source.items()}


def _drawn(sources: Sources, figure: FigureSpec, look: Look) -> Figure:
    """One figure of all files; UsageError names the one it fails for, and what that can be."""
    from fiv_cli.plots import draw, nothing_suits
    from fiv_cli.plots.drawing import kinds_that_suit

    named = _named(sources)
    try:
        return draw(named if len(named) > 1 else named[0][1], figure, look=look)
    except EmptyFigureError:
        raise
    except UsageError as error:
        place, its = _blamed(named, figure, look) if len(named) > 1 else (0, None)
        file, source = sources[place]
        kinds = kinds_that_suit(source)
        if not kinds and len(named) == 1:
            raise nothing_suits(source) from None
        apart = "\nnext: draw each file by itself" * ("next:" not in str(its))
        told = f"{file}: {its}{apart}" if its else str(error)
        if figure.kind in kinds or not kinds:
            raise type(its or error)(told) from None
        raise UsageError(f"{told}\n{file} can be drawn with --figure {listed(kinds)}") from None


def _blamed(
    named: Sequence[tuple[str, dict[str, xr.Dataset]]], figure: FigureSpec, look: Look
) -> tuple[int, UsageError | None]:
    """Which of several files a figure fails for, and why; the first, where none alone is at fault.

    That is the first that the figure of those which can be drawn alone cannot take in: a branch,
    which is no diagram, may be laid over one.
    """
    alone = [_failure([one], figure, look) for one in named]
    sound = [one for one, error in zip(named, alone, strict=True) if error is None]
    for place, (one, error) in enumerate(zip(named, alone, strict=True)):
        if error and (joint := _failure([*sound, one], figure, look)):
            return place, type(joint)(str(joint).removeprefix(f"{one[0]}: "))
    return 0, None


def _failure(
    named: Sequence[tuple[str, dict[str, xr.Dataset]]], figure: FigureSpec, look: Look
) -> UsageError | None:
    """Why a figure cannot be drawn; None where it can."""
    from fiv_cli.plots import draw

    try:
        draw(named, figure, look=look)
    except UsageError as error:
        return error
    return None


def _named(sources: Sources) -> list[tuple[str, dict[str, xr.Dataset]]]:
    """(what it is called, or differs in from the others, analyses) of each file."""
    from fiv_cli.plots.labels import told_apart

    firsts = [(file.stem, next(iter(source.values()))) for file, source in sources]
    given = [str(one.attrs["called"]) for _, one in firsts]
    names = given if any(given) else told_apart(firsts)
    return [(name, source) for name, (_, source) in zip(names, sources, strict=True)]


def _chosen(file: Path, source: dict[str, xr.Dataset], name: str | None) -> list[FigureSpec]:
    """The figures to draw: those called `name`, or all that the dataset can show.

    What it cannot show is named on stderr, with the reason.
    """
    from fiv_cli.plots import can_draw, figures_called, figures_of, possible_figures

    if name is not None:
        return figures_called(source, name)
    for figure in figures_of(source):
        if not can_draw(source, figure):
            why = _why_not(source, figure)
            click.echo(f"{file}: figure {figure.name} left out: {why}", err=True)
    return possible_figures(source)


def _why_not(source: dict[str, xr.Dataset], figure: FigureSpec) -> str:
    """Why a dataset cannot be drawn so, in a line."""
    from fiv_cli.plots import draw

    if MOTION in next(iter(source.values())).attrs:
        return "of a sweep, and this is one motion of it"
    try:
        draw(source, figure)
    except UsageError as error:
        return str(error).replace("\n", "; ")
    return "nothing to draw"


def _with_paths(
    figures: list[tuple[Path, Figure]], outputs: Sequence[Path]
) -> Iterator[tuple[Path, Figure]]:
    """Each figure with where it goes: each of `outputs`, or beside it when there are several."""
    for default, figure in figures:
        if not outputs:
            yield default, figure
        for output in outputs:
            which = default.stem.removeprefix(f"{output.stem}-")
            several = f"{output.stem}-{which}{output.suffix}"
            yield output.with_name(several) if len(figures) > 1 else output, figure
