"""What was found, in lines for people, with the way out of what does not work."""

from collections.abc import Iterator

from warpfluid.doctor.examining import READS, WRITES, complaints


def lines(found: dict) -> Iterator[str]:
    """Yield what ``examine`` found as plain text."""
    for name, number in found["versions"].items():
        yield f"{name:<12} {number or 'MISSING: install warpfluid again'}"
    for one in found["devices"]:
        fault = f"; FAILS: {one['error']}; see whether `nvidia-smi` works" if one["error"] else ""
        yield f"device       {one['name']}: {one['description']}, {_gb(one['memory'])}{fault}"
    for error in found["errors"]:
        yield f"device       FAILS: {error}"
    if found["threads"]:
        yield f"threads      {found['threads']}; WARPFLUID_THREADS sets another number"
    if found["memory"]:
        yield f"memory       {_gb(found['memory']['free'])} of {_gb(found['memory']['total'])} are free"
    yield _disk(found["disk"])
    if found["kernels"]:
        yield _kernels(found["kernels"])
    yield _video(found["video"])
    yield _windows(found["windows"])
    yield _cluster(found["cluster"])
    yield from _programs(found["programs"])
    for complaint in complaints(found):
        yield f"problem      {complaint}"


def _disk(disk: dict) -> str:
    few = "; FEW: a frame has 1 to 100 MB, choose another folder with -o" if disk["free"] < 1e9 else ""
    return f"disk         {_gb(disk['free'])} are free in {disk['folder']}{few}"


def _kernels(cache: dict) -> str:
    if cache["warm"]:
        state = f"compiled, {cache['bytes'] / 1e6:.0f} MB"
    elif cache["begun"]:
        state = "being compiled by a command that runs now, or half done by one that was stopped"
    else:
        state = "compiled at the first run, about a minute"
    kept = "" if cache["lasting"] else "; NOT KEPT: set WARPFLUID_CACHE to a folder that can be written"
    return f"kernels      {cache['folder']}: {state}{kept}"


def _video(video: dict) -> str:
    lacks = [name for name in READS if name not in video["read"]]
    writes = f"writes {WRITES}" if video["write"] else f"LACKS the encoder {WRITES} of .mp4"
    way_out = "; install av from PyPI, its wheels have all" if lacks or not video["write"] else ""
    without = f" (LACKS {' '.join(lacks)})" if lacks else ""
    return f"video        reads {' '.join(video['read']) or 'nothing'}{without}, {writes}{way_out}"


def _windows(kind: str) -> str:
    found = {
        "screen": "yes",
        "memory": "no screen: `preview` writes a page or a picture instead",
        "nothing": "no OpenGL: warpfluid draws without; that of `preview` needs libegl1, libgl1-mesa-dri",
    }
    return f"windows      {found[kind]}"


def _cluster(cluster: dict) -> str:
    here, address = cluster["distributed"], cluster["address"]
    if not here:
        return "cluster      no distributed: `pip install 'warpfluid[cluster]'` if many machines shall work"
    if not address:
        return f"cluster      distributed {here}; doctor --cluster tcp://host:8786 asks one"
    if cluster["workers"] is None:
        return f"cluster      {address} DOES NOT ANSWER: start it with `dask scheduler`, or mend the address"
    if not cluster["workers"]:
        return f"cluster      {address} HAS NO WORKERS: start some with `dask worker {address} --nthreads 1`"
    versions = ", ".join(f"warpfluid {name} on {count}" for name, count in cluster["versions"].items())
    return f"cluster      {address}: {cluster['workers']} workers, {cluster['threads']} threads, {versions}"


def _programs(programs: dict) -> Iterator[str]:
    blender, openvdb = programs["blender"], programs["openvdb"]
    yield f"Blender      {blender or 'not on this machine; what `export` writes for it opens elsewhere, too'}"
    yield f"OpenVDB      {openvdb or 'no Python binding here; warpfluid reads and writes .vdb by itself'}"


def _gb(count: float) -> str:
    return f"{count / 1e9:.3g} GB"
