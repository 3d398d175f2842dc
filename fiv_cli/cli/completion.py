"""``fiv completion``: the script that completes fiv in a shell."""

from __future__ import annotations

import click


@click.command("completion")
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
def command(shell: str) -> None:
    """Print a script that completes commands, options and files of fiv in SHELL.

    \b
    Put one of these into the shell's start-up file:
      eval "$(fiv completion bash)"        ~/.bashrc
      eval "$(fiv completion zsh)"         ~/.zshrc
      fiv completion fish | source         ~/.config/fish/config.fish
    """
    from click.shell_completion import get_completion_class

    from fiv_cli.cli.main import COMPLETE_VARIABLE, cli

    complete = get_completion_class(shell)
    if complete is None:
        raise click.UsageError(f"there is no completion for {shell}")
    click.echo(complete(cli, {}, "fiv", COMPLETE_VARIABLE).source())
