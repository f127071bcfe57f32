"""What a run says while it works, on stderr: a bar on a terminal, a line a frame elsewhere."""

import sys
import time
import traceback
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from warpfluid.footage.estimate import format_duration


class Progress:
    """Lines and bars on stderr.

    Args:
        quiet: Say nothing.
        verbose: Say when, in seconds since the begin, and show failures whole.
    """

    def __init__(self, *, quiet: bool = False, verbose: bool = False):
        self._console = Console(stderr=True, quiet=quiet, highlight=False, soft_wrap=True)
        self._verbose, self._begin = verbose, time.perf_counter()

    def line(self, text: str) -> None:
        """Say one line."""
        when = f"{time.perf_counter() - self._begin:8.2f} s  " if self._verbose else ""
        self._console.print(f"{when}{text}", markup=False)

    def stack(self, text: str | None = None) -> None:
        """Show, if that is wanted, where in the program something failed: in this process just now, or as a text."""
        text = text or (traceback.format_exc() if sys.exc_info()[0] else "")
        if self._verbose and text:
            self._console.print(text.rstrip(), markup=False)

    def notes(self, texts: Iterable[str]) -> None:
        """Say what the user should know, a line each."""
        for text in texts:
            self.line(f"note    {text}")

    @contextmanager
    def frames(self, frames: Sequence[int], iterations: int) -> Iterator["FrameBar"]:
        """Show the progress over some frames."""
        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeRemainingColumn(),
        )
        show = self._console.is_terminal and not self._console.quiet and len(frames) > 0
        with Bar(*columns, console=self._console, transient=True, disable=not show) as bar:
            task = bar.add_task("frames", total=max(len(frames) * max(iterations, 1), 1))
            yield FrameBar(self, bar, task, list(frames), max(iterations, 1))


def say_left(seconds: float) -> str:
    """Return the end of a line that says how long what is left will take; nothing where nothing is left."""
    return f", {format_duration(seconds)} left" if seconds else ""


class FrameBar:
    """The progress of a run: iterations of frames, with their energy."""

    def __init__(self, progress: Progress, bar: Bar, task, frames: list[int], iterations: int):
        self._progress, self._bar, self._task = progress, bar, task
        self._left, self._iterations = len(frames), iterations
        self._under_way: dict[int, int] = {}  # iterations by frame: several may be made at once
        self._begin, self._count = time.perf_counter(), 0

    def iteration(self, frame: int, iteration: int, energy: float) -> None:
        """Note that an iteration of a frame is done."""
        self._under_way[frame] = min(iteration, self._iterations)
        self._show(description=f"frame {frame}  energy {energy:.3g}")

    def finished(self, record: dict) -> None:
        """Note that a frame is done, or failed, and say how long the others will take."""
        self._count += 1
        self._left = max(self._left - 1, 0)  # frames that build on one that changed come on top
        left = (time.perf_counter() - self._begin) / self._count * self._left
        self._under_way.pop(record["frame"], None)
        self._show()
        if "error" in record:
            self._progress.line(f"frame   {record['frame']} failed: {record['error']}")
            self._progress.stack(record.get("stack"))
            return
        energies = record["energies"]
        falls = f"energy {energies[0][0]:.3g} -> {energies[-1][-1]:.3g}, " if energies else ""
        exact = min(record["input_psnr"])
        took = f"{record['seconds']:.1f} s, {falls}inputs {exact:.1f} dB"
        self._progress.line(f"frame   {record['frame']}  {took}, {record['file']}{say_left(left)}")

    def _show(self, **what) -> None:
        done = self._count * self._iterations + sum(self._under_way.values())
        self._bar.update(self._task, completed=done, **what)
