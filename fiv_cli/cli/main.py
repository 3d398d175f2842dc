"""``fiv``: the group of commands, and what an exception means for the shell.

Commands are imported when they are called; until then only the table below knows them, so
``fiv --help`` is quick.
"""

from __future__ import annotations

import importlib
import os
import sys
import traceback
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NoReturn

import click
from click.shell_completion import CompletionItem, shell_complete

from fiv_cli import __version__, ending
from fiv_cli.errors import FivError

INTERNAL_ERROR = 1
INTERRUPTED = 130
# What a shell reports of a program whose reader went away (128 + SIGPIPE).
READER_GONE = 141
USAGE = 2

# The variable by which a shell asks for completions.
COMPLETE_VARIABLE = "_FIV_COMPLETE"

# name -> (module, one line); the order is that of a day's work, and of ``fiv --help``.
COMMANDS: dict[str, tuple[str, str]] = {
    "models": ("fiv_cli.cli.models", "List models and friction laws; print their equations."),
    "kinds": ("fiv_cli.cli.kinds", "List the kinds of analyses, starts, figures and claims."),
    "new": ("fiv_cli.cli.new", "Write a commented case file to start from."),
    "new-model": ("fiv_cli.cli.new_model", "Write a file of a model of your own to start from."),
    "new-law": ("fiv_cli.cli.new_law", "Write a file of a friction law of your own to start from."),
    "schema": ("fiv_cli.cli.schema", "Print the JSON schema of case files, for editors."),
    "variables": ("fiv_cli.cli.variables", "List what the analyses of a case give."),
    "check": ("fiv_cli.cli.check", "Check case files and say what a run would do."),
    "run": ("fiv_cli.cli.run", "Run case files; the answers land in NetCDF datasets."),
    "assemble": ("fiv_cli.cli.assemble", "Join the parts of a case that ran apart (run --shard)."),
    "status": ("fiv_cli.cli.status", "Say how far a run has come."),
    "history": ("fiv_cli.cli.history", "Run one point of a sweep again, with its full motion."),
    "show": ("fiv_cli.cli.show", "Summarise a dataset."),
    "plot": ("fiv_cli.cli.plot", "Draw the figures of a dataset, or a friction law."),
    "diff": ("fiv_cli.cli.diff", "Compare two datasets."),
    "regress": ("fiv_cli.cli.regress", "Run the regression sweeps against their references."),
    "claims": ("fiv_cli.cli.claims", "Hold what the publication says against what was found."),
    "verify": ("fiv_cli.cli.verify", "Check this installation against closed-form answers."),
    "completion": ("fiv_cli.cli.completion", "Print a script that completes fiv in your shell."),
}

# What else a command may be called -> what to type.
OTHER_WORDS = {
    "law": "fiv models --laws",
    "laws": "fiv models --laws",
    "list": "fiv models, or fiv kinds",
    "init": "fiv new MODEL",
    "template": "fiv new MODEL",
    "resume": "fiv run CASE.toml, which goes on where it stopped",
    "stop": "Ctrl-C where it runs; what is done is stored",
    "figure": "fiv plot FILE.nc",
    "figures": "fiv plot FILE.nc",
    "summary": "fiv show FILE.nc",
    "export": "fiv show FILE.nc --json, or any tool that reads NetCDF",
    "version": "fiv --version",
    "help": "fiv COMMAND --help",
}

EPILOG = """\b
Start here (fiv COMMAND --help has more lines to try):
  fiv models                                        what can be computed
  fiv kinds                                         analyses, starts, figures and claims
  fiv new pin-on-disc --analysis response > a.toml  a case to start from
  fiv check a.toml                                  is it right; what will it do
  fiv run a.toml                                    compute; writes runs/a.nc
  fiv plot runs/a.nc                                draw

\b
Exit codes:
  0  done
  1  internal error: a defect of fiv
  2  the command line is wrong, or the output cannot be written
  3  an input file is invalid
  4  points failed, or used up max_events or max_steps (run, assemble)
  5  a difference (diff, regress, verify, claims --strict)
  6  the stored run belongs to another case
  7  locked by a live run
  8  points are left (run --max-points, assemble, status --exit-code)
  9  a cluster is out of reach (run --cluster)
  129, 130, 143  ended by a hang-up, Ctrl-C or SIGTERM; 141 by a reader that went away

\b
Every option may stand in the environment: fiv run --workers 4 is FIV_RUN_WORKERS=4.
Data go to stdout, everything else to stderr. FIV_DEBUG=1 shows the traceback of an internal
error. Shell completion: fiv completion --help.
"""


class LazyGroup(click.Group):
    """A group that imports a command when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = importlib.import_module(COMMANDS[cmd_name][0]).command
        _name_environment(command, cmd_name)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """As click's, with a "did you mean" for an unknown command."""
        from fiv_cli.notation.names import suggest

        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            other = OTHER_WORDS.get(args[0].lower()) or _kind_called(args[0])
            alike = [name for name in COMMANDS if args[0] in name or not other]
            near = suggest(args[0], alike)
            hint = f"; {near}" * bool(near) + f"\nnext: {other}" * bool(other)
            hint = hint or "; `fiv --help` lists the commands"
            ctx.fail(f"there is no command {args[0]!r}{hint}")
        name, command, rest = super().resolve_command(ctx, args)
        if command is not None:
            _warn_of_repeated(ctx, command, rest)
        return name, command, rest

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        names = [
            CompletionItem(name, help=text)
            for name, (_, text) in COMMANDS.items()
            if name.startswith(incomplete)
        ]
        return names or click.Command.shell_complete(self, ctx, incomplete)


def _warn_of_repeated(ctx: click.Context, command: click.Command, args: list[str]) -> None:
    """Say which options are given again though one value counts; as in every shell, the last."""
    # what is wrong is told elsewhere; the names of the help option are those of the group
    context = click.Context(command, parent=ctx, resilient_parsing=True)
    _, _, given = command.make_parser(context).parse_args(list(args))
    for option in dict.fromkeys(given):
        if isinstance(option, click.Option) and not (option.multiple or option.is_flag):
            times = given.count(option)
            if times > 1:
                told = f"{option.opts[-1]} is given {times} times; the last counts"
                click.echo(f"WARNING: {told}", err=True)


def _kind_called(word: str) -> str:
    """What to type to read of a kind or a table that a word means; empty: it means none."""
    from fiv_cli.case.kinds import TABLES, all_kinds
    from fiv_cli.case.words import meant

    known = {*TABLES, *(kind.name for kind in all_kinds() if kind.keys)}
    kinds = [word] if word in known else meant(word)
    what = " or ".join(map(repr, kinds))
    return f"{what} is asked for in a case: fiv kinds {kinds[0]}" if kinds else ""


def _name_environment(command: click.Command, name: str) -> None:
    """Give every option the twin that its flag suggests: ``run --workers`` is FIV_RUN_WORKERS."""
    for option in command.params:
        if isinstance(option, click.Option) and option.envvar is None:
            flag = max(option.opts, key=len).lstrip("-")
            option.envvar = f"FIV_{name}_{flag}".replace("-", "_").upper()


@click.group(
    cls=LazyGroup,
    epilog=EPILOG,
    context_settings={
        "help_option_names": ["-h", "--help"],
        "max_content_width": 100,
    },
)
@click.version_option(__version__, message="%(prog)s %(version)s")
def cli() -> None:
    """Batch runs of friction-induced vibration: brake squeal, creep groan, stick-slip.

    A TOML case file names a mechanical model, a friction law, a grid of parameters and what to
    compute; `fiv run` computes every point and writes one dataset.
    """


def main() -> NoReturn:
    """The console script."""
    ending.take_over()
    if "xarray" not in sys.modules:  # what it has seen once it goes on using
        sys.modules.setdefault("dask", None)  # type: ignore[arg-type]  # or xarray imports it
    try:
        code = run(sys.argv[1:])
    except (ending.Ended, OSError) as error:  # the latter: a terminal that is gone
        ending.finish(str(error) if isinstance(error, ending.Ended) else "")
        raise
    ending.disregard()
    sys.exit(code)


def run(arguments: Sequence[str]) -> int:
    """Carry out one command line; returns its exit code.

    Parameters
    ----------
    arguments : what stands behind ``fiv``
    """
    try:
        code = _invoke(arguments)
        sys.stdout.flush()
    except BrokenPipeError:
        _silence(sys.stdout)
        return READER_GONE
    except Exception as error:
        return _explain(error, arguments)
    except KeyboardInterrupt:
        click.echo("interrupted", err=True)
        return INTERRUPTED
    return code


def _invoke(arguments: Sequence[str]) -> int:
    """A command returns None or its exit code."""
    instruction = os.environ.get(COMPLETE_VARIABLE)
    if instruction:
        return shell_complete(cli, {}, "fiv", COMPLETE_VARIABLE, instruction)
    with cli.make_context("fiv", list(arguments)) as context:
        result: Any = cli.invoke(context)
    return result if isinstance(result, int) else 0


def _explain(error: Exception, arguments: Sequence[str]) -> int:
    """Say on stderr what stopped the command; returns the exit code."""
    if isinstance(error, click.exceptions.Exit):
        return error.exit_code
    if isinstance(error, click.Abort):
        click.echo("interrupted", err=True)
        return INTERRUPTED
    if isinstance(error, click.ClickException):
        instead = _instead(error) if isinstance(error, click.NoSuchOption) else ""
        if isinstance(error, click.NoSuchOption) and instead:
            error = click.NoSuchOption(error.option_name, ctx=error.ctx)
        error.show()
        _show_use(error, instead)
        return USAGE
    if isinstance(error, FivError):
        from fiv_cli.cli.common import with_files

        click.echo(with_files(str(error), _given_files(arguments)), err=True)
        return error.exit_code
    if isinstance(error, OSError) and not _debugging(arguments):
        return _explain_storage(error)
    return _explain_internal(error, arguments)


def _given_files(arguments: Sequence[str]) -> list[str]:
    """The files of models and laws on a command line; those of the environment stay there."""
    apart = (one.split("=", 1) if one.startswith("--with=") else [one] for one in arguments)
    words = [word for parts in apart for word in parts]
    return [after for word, after in pairwise(words) if word == "--with"]


def _instead(error: click.NoSuchOption) -> str:
    """What does what an unknown option asks for; "" where only its spelling helps."""
    from fiv_cli.cli.options import instead_of

    if error.ctx is None or error.ctx.command is cli:
        return ""
    commands = {name: cli.get_command(error.ctx, name) for name in COMMANDS}
    others = {name: command for name, command in commands.items() if command is not None}
    return instead_of(error.option_name.lstrip("-"), error.ctx.command, others)


def _show_use(error: click.ClickException, instead: str) -> None:
    """What would have been right: the options there are, an example of the command's help."""
    from fiv_cli.cli.options import flags

    context = error.ctx if isinstance(error, click.UsageError) else None
    if context is None or context.command is cli:
        return
    if isinstance(error, click.NoSuchOption):
        click.echo(f"options: {', '.join(flags(context.command))}", err=True)
    lines = map(str.strip, (context.command.help or "").splitlines())
    example = next((line for line in lines if line.startswith("fiv ")), "")
    if instead:
        click.echo(f"next: {instead}", err=True)
    elif example:
        click.echo(f"example: {example}", err=True)


def _explain_storage(error: OSError) -> int:
    """A file or stream that cannot be written or read."""
    place = f"{error.filename}: " if error.filename else ""
    click.echo(
        f"fiv: {place}{error.strerror or error}\n"
        "next: see to the path, its permissions and its space, then run the same command again",
        err=True,
    )
    _silence(sys.stdout)
    return USAGE


def _explain_internal(error: Exception, arguments: Sequence[str]) -> int:
    if _debugging(arguments):
        traceback.print_exception(error)
    click.echo(
        f"fiv: internal error: {type(error).__name__}: {error}\n"
        "This is a defect of fiv, not of your input.\n"
        "next: run it again with FIV_DEBUG=1 in the environment and report what it prints",
        err=True,
    )
    return INTERNAL_ERROR


def _debugging(arguments: Sequence[str]) -> bool:
    return bool(os.environ.get("FIV_DEBUG")) or bool({"-v", "--verbose"} & set(arguments))


def _silence(stream: Any) -> None:
    """Let what is still in a dead stream's buffer vanish, so that closing it is quiet."""
    devnull = os.open(os.devnull, os.O_WRONLY)
    os.dup2(devnull, stream.fileno())
    os.close(devnull)
