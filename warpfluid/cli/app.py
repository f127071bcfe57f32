"""The application that commands join; results go to stdout, everything else to stderr.

Exit codes: 0 done, 1 some frames failed (they are named), 2 the command or its input is wrong, 130 interrupted.
"""

import os
import sys
import traceback

import cyclopts
from cyclopts import App, Parameter

from warpfluid import __version__
from warpfluid.errors import describe

ENVIRONMENT = (
    "The environment counts where no flag is given: WARPFLUID_DEVICE, WARPFLUID_JOBS, WARPFLUID_CLUSTER as the flags "
    "of these names; WARPFLUID_THREADS: CPU threads; WARPFLUID_CACHE: folder of compiled kernels; NO_COLOR: no colours."
)


def spell(value: object) -> str | None:
    """Return a default as the help shows it; None, for nothing, where there is none."""
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}" if isinstance(value, float) else None if value is None else str(value)


app = App(
    name="warpfluid",
    help="Volumes of fire, smoke, explosions and splashes from one or a few videos.",
    help_epilogue=f"Begin with warpfluid demo, or with warpfluid inspect --front clip.mp4.\n\n{ENVIRONMENT}",
    version=__version__,
    default_parameter=Parameter(show_default=lambda value: spell(value or None)),
    suppress_keyboard_interrupt=False,
)


def main(arguments: list[str] | None = None) -> int:
    """Run a command and return its exit code.

    Args:
        arguments: What follows ``warpfluid``; of the command line when omitted.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    verbose = bool({"-v", "--verbose"} & set(arguments))
    try:
        command, bound, _ = app.parse_args(arguments, exit_on_error=False, print_error=False)
        if verbose and not getattr(bound.arguments.get("common"), "quiet", True):
            print(_versions(), file=sys.stderr)
        code = command(*bound.args, **bound.kwargs) or 0
        sys.stdout.flush()  # here a reader that is gone can still be told from a fault
        return code
    except KeyboardInterrupt as stop:
        print(str(stop) or "stopped", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader of stdout had enough, as head does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except cyclopts.CycloptsError as error:
        from warpfluid.cli.usage import usage_problems  # which nobody needs who makes no mistake

        return _fail("\n".join(dict.fromkeys(usage_problems(app, arguments, error))), 2)
    except Exception as error:
        if verbose:
            traceback.print_exc()
        if isinstance(error, ValueError | OSError | MemoryError):
            return _fail(describe(error), 2)
        return _fail(f"{describe(error)}: a fault of warpfluid; please report it with what -v prints", 1)


def _versions() -> str:
    """Return the versions of what takes part, in a line."""
    from warpfluid.run import versions

    return ", ".join(f"{name} {number}" for name, number in versions().items())


def _fail(message: str, code: int) -> int:
    print("\n".join(f"error: {line}" for line in message.splitlines()), file=sys.stderr)
    return code
