"""What numbered pictures were made with, noted beside them: pictures of two kinds must not become one sequence.

``fire.####.png`` gets ``fire.png.jsonl``: a line with the options, then a line a picture with the hash of its volume.
"""

import dataclasses
from collections.abc import Iterable
from pathlib import Path

from warpfluid.errors import writing
from warpfluid.files.atomic import replacing
from warpfluid.files.lines import append_line, line_of, read_lines
from warpfluid.files.sequences import before_number
from warpfluid.footage.sources import file_hash
from warpfluid.options import CameraOptions, LightOptions, RenderOptions
from warpfluid.rendering.output import Target

FREE = {"frames", "fps"}  # what a picture does not depend on


class PictureRecords:
    """The record of numbered pictures.

    Args:
        target: Where the pictures go.
    """

    def __init__(self, target: Target):
        path = target.path
        self._target = target
        self.path = path.with_name(f"{before_number(path) or 'pictures'}{path.suffix}.jsonl")

    def begin(self, made_with: dict, hashes: dict[str, str], numbers: Iterable[int], *, resume: bool) -> set[int]:
        """Note what pictures are made with, or check that earlier ones were made with the same.

        Args:
            made_with: What ``made_with`` returns.
            hashes: Of the volumes, by frame.
            numbers: Of the pictures to make.
            resume: Earlier pictures are kept.

        Returns:
            Numbers of the pictures that are there and were made of the volumes that there are.

        Raises:
            ValueError: If earlier pictures were made with something else.
            CannotWriteError: If the record cannot be written.
        """
        lines = read_lines(self.path) if resume else []
        if resume and not lines and any(file.exists() for number in numbers for file in self._target.files(number)):
            raise ValueError(
                f"{self._target.path}: there is no record of what its pictures were made with, {self.path.name}: "
                "use --overwrite, or another -o"
            )
        if not lines:
            self._write([made_with])
            return set()
        changed = [
            f"{name} (was {_short(lines[0].get(name))}, now {_short(made_with.get(name))})"
            for name in sorted({*lines[0], *made_with})
            if lines[0].get(name) != made_with.get(name)
        ]
        if changed:
            raise ValueError(
                f"{self._target.path}: its pictures were made with something else: {', '.join(changed)}; "
                "use the same again, or --overwrite, or another -o"
            )
        kept = {line["picture"]: line for line in lines[1:] if self._is_good(line, hashes)}
        self._write([made_with, *kept.values()])
        return set(kept)

    def add(self, record: dict, hashes: dict[str, str]) -> None:
        """Note that a picture is made.

        Raises:
            CannotWriteError: If that cannot be written.
        """
        with writing(self.path):
            append_line(self.path, {**record, "volume": hashes[str(record["frame"])]})

    def _is_good(self, line: dict, hashes: dict[str, str]) -> bool:
        number, frame = line.get("picture"), line.get("frame")
        if not isinstance(number, int) or hashes.get(str(frame)) != line.get("volume"):
            return False
        return all(file.exists() for file in self._target.files(number))

    def _write(self, lines: list[dict]) -> None:
        with writing(self.path), replacing(self.path) as file:
            file.write(b"".join(map(line_of, lines)))


def made_with(camera: CameraOptions, light: LightOptions, options: RenderOptions, look: str, scale: float) -> dict:
    """Return everything that a picture depends on besides its volume, as plain values.

    Args:
        camera: Where from.
        light: What lights it.
        options: How it looks.
        look: The look, where the options leave it to the run.
        scale: What brings densities to grey levels.
    """
    table = {}
    for part in (camera, light, options):
        table |= {name.replace("_", "-"): value for name, value in dataclasses.asdict(part).items() if name not in FREE}
    table |= {"look": look, "scale": scale}
    for name in ("look", "probe", "camera"):
        path = Path(table[name] or "").expanduser()
        if path.is_file():
            table[f"the file of {name}"] = file_hash([path])
    return table


def _short(value: object) -> str:
    text = str(value)
    return text if len(text) < 24 else f"{text[:12]}..."
