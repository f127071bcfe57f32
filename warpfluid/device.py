"""Starting Warp and choosing where to compute."""

import atexit
import contextlib
import functools
import os
import shutil
import sys
import tempfile
from collections.abc import Iterable, Iterator

import warp as wp

KERNEL_BYTES = 1 << 18  # more than a compiled module of kernels has


def pick_device(name: str | wp.Device | None = None) -> wp.Device:
    """Return a device, starting Warp without noise.

    Args:
        name: ``cpu``, ``cuda:N``, or ``auto`` for the first GPU and the CPU where there is none; the default is auto.

    Raises:
        ValueError: If there is no such device.
    """
    start_warp()
    if name is None or name == "auto":
        return wp.get_device("cuda:0" if wp.is_cuda_available() else "cpu")
    try:
        return wp.get_device(name)
    except ValueError as error:
        there_are = ", ".join(str(device) for device in wp.get_devices())
        named = " (WARPFLUID_DEVICE)" if os.environ.get("WARPFLUID_DEVICE") == name else ""
        raise ValueError(
            f"there is no device {name!r}{named}: this machine has {there_are}; use --device auto"
        ) from error


def gpus() -> list[wp.Device]:
    """Return the GPUs there are."""
    start_warp()
    return list(wp.get_cuda_devices())


def compile_kernels(devices: Iterable[wp.Device]) -> str:
    """Compile what is imported, so that processes started later find it; return the folder where it lies."""
    wp.force_load(list({device.arch if device.is_cuda else "cpu": device for device in devices}.values()))
    return wp.config.kernel_cache_dir


@contextlib.contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let linear algebra use one thread, within this or, as a decorator, in a function.

    With several its sums end in other bits, as many as there are, and they would stand in the way of our own threads.
    """
    from threadpoolctl import threadpool_limits

    with threadpool_limits(limits=1, user_api="blas"):
        yield


@functools.cache
def start_warp() -> None:
    """Start Warp once, without its banner and without a warning where there is no GPU."""
    wp.config.log_level = wp.LOG_WARNING  # the banner would go to stdout, in the middle of --json
    wp.config.kernel_cache_dir = _named_cache() or wp.config.kernel_cache_dir
    wp.config.enable_tiles_in_stack_memory = False  # kernels of all threads would share the pointer to it
    with _without_driver_warning():
        try:
            wp.init()
        except OSError:  # it makes the folder of compiled kernels, or cannot
            wp.config.kernel_cache_dir = _make_cache()
            wp.init()
    if not _can_keep_kernels(wp.config.kernel_cache_dir):
        wp.config.kernel_cache_dir = _make_cache()


def _named_cache() -> str | None:
    """Return where ``WARPFLUID_CACHE`` wants compiled kernels, a folder for each version of Warp."""
    named = os.environ.get("WARPFLUID_CACHE")
    if not named:
        return None
    folder = os.path.abspath(os.path.expanduser(named))
    nearest = folder
    while not os.path.exists(nearest):
        nearest = os.path.dirname(nearest)
    if not os.path.isdir(nearest):
        raise ValueError(f"WARPFLUID_CACHE is {named!r}, but {nearest} is a file: name a folder, or unset it")
    return os.path.join(folder, wp.config.version)


def _make_cache() -> str:
    """Make a folder for compiled kernels that goes when this process ends."""
    folder = tempfile.mkdtemp(prefix="warpfluid-kernels-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def _can_keep_kernels(folder: str) -> bool:
    """Return whether compiled kernels can be written; a full disk tells only when something is."""
    try:
        os.makedirs(folder, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(KERNEL_BYTES))
    except OSError:
        return False
    return True


@contextlib.contextmanager
def _without_driver_warning() -> Iterator[None]:
    """Hold back one line: the native library prints it where there is no NVIDIA driver, and no setting stops it."""
    sys.stderr.flush()
    kept = os.dup(2)
    with tempfile.TemporaryFile() as caught:
        os.dup2(caught.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            caught.seek(0)
            lines = caught.read().decode(errors="replace").splitlines()
            for line in lines:
                if "NVIDIA CUDA driver" not in line:
                    print(line, file=sys.stderr)
