"""How kernels are launched: one thread handles a run of heights of one column.

All heights of a column share one ray, so a thread works the ray out once and applies it to a contiguous run of
heights: 48 on the CPU, where the run fills vector registers and a slab of 48 heights stays in the cache, and 4 on
CUDA, where neighbouring threads then read neighbouring memory. One Warp launch uses one CPU thread but releases the
interpreter lock, so ranges of rows are launched side by side from Python threads. Nobody above knows about this.
"""

import functools
import os
from concurrent.futures import ThreadPoolExecutor

import warp as wp

from warpfluid.kernels import checks

CPU_RUN = 48
CUDA_RUN = 4
MOST_THREADS = 1024

# Opens the body of a native function over (block, heights): the run of `count` heights that starts at `y`.
RUN_OF_HEIGHTS = f"""
#if defined(__CUDA_ARCH__)
    enum {{ RUN = {CUDA_RUN} }};
#else
    enum {{ RUN = {CPU_RUN} }};
#endif
    const int y = block * RUN;
    const int count = heights - y < RUN ? heights - y : RUN;
"""

_ROWS_A_JOB = 16
_ROWS_OF_WHOLE_COLUMNS_A_JOB = 4
_ELEMENTS_A_JOB = 1 << 18


def run_count(heights: int, device: wp.Device) -> int:
    """Return how many runs of heights a column has on a device."""
    return -(-heights // (CUDA_RUN if device.is_cuda else CPU_RUN))


def thread_count() -> int:
    """Return the number of CPU threads that kernels use: ``WARPFLUID_THREADS``, or all this process may use.

    Raises:
        ValueError: If the variable is no such number.
    """
    named = os.environ.get("WARPFLUID_THREADS", "")
    if named:
        if not (named.isascii() and named.isdigit() and 0 < int(named) <= MOST_THREADS):
            raise ValueError(f"WARPFLUID_THREADS is {named!r}, expected a number of threads from 1 to {MOST_THREADS}")
        return int(named)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@functools.cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="warpfluid")


def launch(
    kernel: wp.Kernel,
    shape: tuple[int, int, int],
    inputs: list,
    outputs: list,
    device: wp.Device,
    *,
    whole_columns: bool = False,
) -> None:
    """Launch a kernel over (rows, columns, heights), a run of heights a thread.

    Args:
        kernel: Takes ``first_row`` and ``first_block`` before ``inputs``; its thread index is (row, column, block).
        shape: Rows, columns and heights of what is written.
        inputs: Further inputs.
        outputs: Arrays to write; no two threads may write the same place.
        device: Where the arrays are.
        whole_columns: Do all runs of a column one after the other: faster for a kernel that reads its surroundings
            once, from many arrays. Otherwise a slab as high as a run is done at a time: rays find it in the cache.
    """
    rows, columns, heights = shape
    blocks = run_count(heights, device)
    if device.is_cuda:
        wp.launch(kernel, dim=(rows, columns, blocks), inputs=[0, 0, *inputs], outputs=outputs, device=device)
        return
    kernel.module.load(device)  # two threads that meet an unloaded module would both compile it

    step = _ROWS_OF_WHOLE_COLUMNS_A_JOB if whole_columns else _ROWS_A_JOB
    depth = max(blocks, 1) if whole_columns else 1

    def work(job):
        block, row = job
        dim = (min(step, rows - row), columns, depth)
        wp.launch(kernel, dim=dim, inputs=[row, block, *inputs], outputs=outputs, device=device)

    jobs = [(block, row) for block in range(0, blocks, depth) for row in range(0, rows, step)]
    list(_pool(thread_count()).map(work, jobs))


def each(kernel: wp.Kernel, count: int, inputs: list, device: wp.Device) -> None:
    """Launch a kernel over long pieces of work that know nothing of each other, a piece a thread.

    Args:
        kernel: Takes ``first`` before ``inputs``; its thread index counts from there.
        count: Number of pieces.
        inputs: Further inputs, arrays to write among them.
        device: Where the arrays are.
    """
    if device.is_cuda:
        # threads of one warp that go different ways wait for each other, so each gets a block
        wp.launch(kernel, dim=count, inputs=[0, *inputs], device=device, block_dim=1)
        return
    kernel.module.load(device)

    def work(piece):
        wp.launch(kernel, dim=1, inputs=[piece, *inputs], device=device)

    list(_pool(thread_count()).map(work, range(count)))


def elementwise(kernel: wp.Kernel, inputs: list, out: wp.array) -> wp.array:
    """Launch a kernel over all elements of arrays of one shape.

    Args:
        kernel: Takes ``inputs`` and ``out``; its thread index is an element of flat arrays, or of a range of them.
        inputs: Arrays of the shape of ``out``, and numbers.
        out: Array to write; it may be one of the inputs.

    Returns:
        ``out``.

    Raises:
        ValueError: If shapes, types or devices do not fit.
    """
    arrays = {f"argument {i}": value for i, value in enumerate(inputs) if not isinstance(value, int | float)}
    device = checks.same_device(out=out, **arrays)
    checks.floats(out.ndim, out=out, **arrays)
    checks.same_shape(out=out, **arrays)
    flat = [value.flatten() if isinstance(value, wp.array) else value for value in inputs]
    to = out.flatten()
    if device.is_cuda or out.size <= _ELEMENTS_A_JOB:
        wp.launch(kernel, dim=out.size, inputs=flat, outputs=[to], device=device)
        return out
    kernel.module.load(device)

    def work(begin):
        part = slice(begin, min(begin + _ELEMENTS_A_JOB, out.size))
        some = [value[part] if isinstance(value, wp.array) else value for value in flat]
        wp.launch(kernel, dim=part.stop - begin, inputs=some, outputs=[to[part]], device=device)

    list(_pool(thread_count()).map(work, range(0, out.size, _ELEMENTS_A_JOB)))
    return out
