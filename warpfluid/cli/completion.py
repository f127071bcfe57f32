"""``warpfluid completion``: what the shell offers after a press of Tab."""

import json
from typing import Annotated, Literal

from cyclopts import Parameter

from warpfluid.cli.app import app
from warpfluid.cli.flags import COMMON, Common

# Run at once where zsh loads the script for the first Tab, and made known where ~/.zshrc sources it.
END_OF_ZSH = """
if [[ $funcstack[1] == _warpfluid ]]; then _warpfluid "$@"; else compdef _warpfluid warpfluid; fi"""
FILES = '$(compgen -f -- "${cur}")'  # of bash: it breaks names at blanks, and takes a folder for the end of a path


@app.command
def completion(
    shell: Annotated[Literal["bash", "zsh", "fish"], Parameter(help="The shell that the script is for")],
    /,
    *,
    common: Common = COMMON,
) -> int:
    """Print a script that lets a shell complete commands, options, their choices and files."""
    script = make_script(shell)
    print(json.dumps({"shell": shell, "script": script}) if common.json else script)
    return 0


def make_script(shell: str) -> str:
    """Return the script that completes our commands in ``bash``, ``zsh`` or ``fish``."""
    script = app.generate_completion(shell=shell)
    if shell == "bash":  # whose own completion of files is better, and knows --view 0=front.mp4
        script = script.replace(f"COMPREPLY=( {FILES} )", "COMPREPLY=()")
        script = script.replace("complete -F", "complete -o bashdefault -o default -F")
    if shell == "zsh":
        script = script.replace("_cyclopts_warpfluid", "_warpfluid") + END_OF_ZSH
    return script
