"""What is known of a file, in lines for people."""

from collections.abc import Iterator


def lines(told: dict) -> Iterator[str]:
    """Yield lines that say what a file is."""
    size = f", {_bytes(told['bytes'])}" if "bytes" in told else ""
    yield f"{told['path']}: {told['kind']}{size}"
    for name in ("made_of", "frames", "count", "depth", "rate", "seconds", "parts", "files"):
        if told.get(name) not in (None, []):
            yield f"  {name.replace('_', ' '):<10}{_text(told[name])}"
    if "size" in told:
        yield f"  size      {' x '.join(map(str, told['size']))}"
    if told.get("range"):
        yield f"  range     {_text(told['range'])}"
    for name, value in (told.get("layer") or {}).items():
        yield f"  {name:<9} {value}"
    for prim in told.get("prims") or ():
        yield f"  {prim['type']} {prim['name']}"
    for grid in told.get("grids") or ():
        yield from _grid(grid)
    for channel in told.get("channels") if isinstance(told.get("channels"), list) else ():
        yield f"  {channel['name']:<16}{channel['type']}  {_text(channel['range'])}"
    sequence = told.get("sequence")
    if sequence:
        missing = f", {sequence['missing']} missing" if "missing" in sequence else ""
        yield f"  sequence  {sequence['pattern']}: {sequence['frames']}, {sequence['count']} files{missing}"
    for warning in told.get("warnings") or ():
        yield f"  warning   {warning}"


def _grid(grid: dict) -> Iterator[str]:
    parts = [grid["type"], " x ".join(map(str, grid["size"]))]
    parts += [f"{grid['active']} active"] if grid.get("active") is not None else []
    parts += [f"voxel {grid['voxel_size']:g}"] if grid["voxel_size"] else []
    parts += [f"{_text(grid['range'])}"] if grid.get("range") else []
    parts += [f"longest {grid['longest']:.4g}"] if "longest" in grid else []
    parts += [f"sum {grid['sum']:.6g}"] if "sum" in grid and "longest" not in grid else []
    parts += [f"{grid['up']} up"] if grid.get("up") else []
    parts += [f"{_bytes(grid['memory'])} in memory"] if grid.get("memory") else []
    yield f"  {grid['name']:<12}{', '.join(parts)}"
    if grid.get("origin"):
        yield f"  {'':<12}first voxel at {', '.join(f'{place:.6g}' for place in grid['origin'])}, y up"


def _text(value) -> str:
    if isinstance(value, list) and len(value) == 2 and all(isinstance(number, float) for number in value):
        return f"{value[0]:.6g} to {value[1]:.6g}"
    if isinstance(value, list | tuple):
        return " ".join(map(str, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _bytes(count: int) -> str:
    """Return a number of bytes as people say it."""
    for unit in ("bytes", "kB", "MB", "GB"):
        if count < 1000 or unit == "GB":
            return f"{count:.0f} {unit}" if unit == "bytes" else f"{count:.1f} {unit}"
        count /= 1000
    return ""
