"""
Comparing results
=================

Which of three results is best? Least squares, appearance transfer frame by frame, and frames that start from the one
before, of the packaged fire. ``warpfluid compare`` finds the footage through their runs and sets them side by side.
"""

# %%
# Three runs of a few frames, small and quick.

from importlib.resources import files

from gallery import folder

from warpfluid.cli import main

samples = files("warpfluid") / "samples"
views = ["--front", f"{samples / 'front.####.png'}", "--side", f"{samples / 'side.####.png'}"]
quick = ["--frames", "1-5", "--resolution", "64", "--angles", "60", "--no-turntable", "--no-report", "--device", "cpu"]
choices = {
    "least-squares": ["--method", "lsm"],
    "alone": ["--coherence", "none"],
    "coherent": ["--coherence", "flow"],
}
for name, flags in choices.items():
    assert main(["reconstruct", *views, *quick, *flags, "-o", str(folder() / name), "--overwrite", "-q"]) == 0

# %%
# The table: distances in multiples of those of the footage's own views from each other. And the sheet.

runs = [str(folder() / name) for name in choices]
sheet = folder() / "compare.png"
assert main(["compare", *runs, "--measured-frames", "2", "-o", str(sheet), "--device", "cpu", "-q"]) == 0
print(f"wrote {sheet}")
