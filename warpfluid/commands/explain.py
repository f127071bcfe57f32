"""Explain files one after another."""

import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from warpfluid.errors import describe
from warpfluid.explaining.files import explain
from warpfluid.explaining.words import lines


def explain_files(names: Sequence[str], common) -> int:
    """Print what files are; return the exit code, 1 if one of them cannot be read.

    Args:
        names: Files or folders.
        common: What most commands take.
    """
    found, failed = [], {}
    for name in names:
        try:
            found.append(explain(Path(os.path.expanduser(name))))
        except (ValueError, OSError, RuntimeError) as error:
            failed[name] = describe(error)
            continue
        if not common.json:
            print("\n".join(lines(found[-1])), flush=True)
    if common.json:
        print(json.dumps({"files": found, "failed": failed}, indent=2, allow_nan=False))
    for error in failed.values():
        print(f"error: {error}", file=sys.stderr)
    return 1 if failed else 0
