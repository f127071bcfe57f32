"""What is wrong with a command line: all of it, and the way out."""

from collections.abc import Sequence

import cyclopts
from cyclopts import App

from warpfluid.cli.examples import EXAMPLES
from warpfluid.errors import Problems

MOST = 20  # rounds in search of further mistakes
PLACES = dict.fromkeys(("reconstruct", "flow"), "footage follows --view ANGLE=, --front or --side")
PLACES |= {"simulate": "write what belongs together in quotes, --force 'drag strength=2'"}

READ = {"vdb": ("houdini", "maya", "arnold", "karma", "openvdb"), "usda": ("usd", "omniverse", "solaris")}
READ |= {"vti": ("paraview", "vtk"), "nvdb": ("nanovdb",), "npz": ("numpy", "pytorch")}


def usage_problems(app: App, arguments: Sequence[str], error: cyclopts.CycloptsError) -> Problems:
    """Return a line for everything that is wrong with a command line.

    What was found wrong is left out, and the rest is read again, until nothing else is; then the values of what remains
    are checked.

    Args:
        app: The application.
        arguments: The command line.
        error: What was found first.
    """
    problems, left = Problems(), list(arguments)
    for _ in range(MOST):
        problems.append(_sentence(error))
        shorter = _without(left, error)
        if shorter is None:
            return problems
        left = shorter
        try:
            bound = app.parse_args(left, exit_on_error=False, print_error=False)[1]
        except cyclopts.CycloptsError as found:
            error = found
        else:
            for flags in bound.arguments.values():
                problems.attempt(_check, flags)
            return problems
    return problems


def _check(flags) -> None:
    """Refuse flags that no options can be made of."""
    options = getattr(flags, "OPTIONS", None)
    if options:
        options(**{name: value for name, value in vars(flags).items() if value is not None})


def _without(arguments: list[str], error: cyclopts.CycloptsError) -> list[str] | None:
    """Return a command line without the option that is wrong, and its value, or with what it lacks; None if neither."""
    token = getattr(error, "token", None)
    keyword = (token.keyword or token.value) if token else getattr(error, "keyword", None)
    value = token.value if token else None
    if isinstance(error, cyclopts.MissingArgumentError) and not keyword and error.argument is not None:
        name = error.argument.name
        return [*arguments, name, "."] if name.startswith("--") and name not in arguments else None
    if not keyword:
        return None
    place = next((i for i, word in enumerate(arguments) if word.partition("=")[0] == keyword), None)
    if place is None:
        return None
    follows = arguments[place + 1 : place + 2]
    takes = follows and "=" not in arguments[place] and (follows[0] == value or not follows[0].startswith("-"))
    return arguments[:place] + arguments[place + 1 + bool(takes) :]


def _sentence(error: cyclopts.CycloptsError) -> str:
    """Return what is wrong, and the way out."""
    if isinstance(error, cyclopts.UnusedCliTokensError):
        rest = " ".join(error.unused_tokens or ())
        command = next(iter(error.command_chain or ()), "")
        return f"there is no place for {rest!r}: {PLACES.get(command, 'write what belongs together in quotes')}"
    if isinstance(error, cyclopts.MissingArgumentError) and error.argument is not None:
        what = error.argument.parameter.metavar or error.argument.name
        if error.keyword:
            return f"{error.keyword} requires an argument, {what}"
        command = " ".join(error.command_chain or ())
        return f"{command} requires {what}, as in: {EXAMPLES.get(command, command)}"
    return str(error) + _format_for(error)


def _format_for(error: cyclopts.CycloptsError) -> str:
    """Return which format a program reads whose name was given in place of one."""
    token = getattr(error, "token", None)
    if token is None or token.keyword != "--format":
        return ""
    name = token.value.lower()
    return next((f" {token.value} reads {kind}." for kind, programs in READ.items() if name in programs), "")
