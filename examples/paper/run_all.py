"""
All figures
===========

Runs every script of this folder, in one folder: ``python run_all.py --out pictures``. Within 20 minutes on two cores;
with ``--full`` at the paper's sizes, hours. Figures share what they make; what is in the folder is used again.
"""

import runpy
import sys
import time
from pathlib import Path

from common import arguments, tell

HERE = Path(__file__).parent
SHARED = ("common.py", "run_all.py", "scenes.py", "sequences.py", "trees.py")

# %%
# One after the other; a script that fails does not keep the others from running.

out, rows, failed = arguments().out, {}, []
for path in sorted(HERE.glob("*.py")):
    if path.name in SHARED:
        continue
    begin = time.perf_counter()
    print(f"\n== {path.stem}", flush=True)
    try:
        runpy.run_path(str(path), run_name=path.stem)
    except (Exception, SystemExit) as error:
        failed.append(path.stem)
        print(f"{path.stem} failed: {error!r}", file=sys.stderr)
    rows[path.stem] = {"seconds": time.perf_counter() - begin}
rows["all"] = {"seconds": sum(row["seconds"] for row in rows.values())}
tell("run_all", rows)
print(f"wrote {out}")
sys.exit(f"failed: {', '.join(failed)}" if failed else 0)
