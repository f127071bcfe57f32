"""A run on disk: volumes of a shot, frame by frame, and what is needed to repeat or continue it.

The folder holds ``density.0001.vdb`` and so on, with the frame numbers of the footage, ``run.toml`` (every option,
versions, device, hashes of the footage), ``frames.jsonl`` (a record for each finished frame), and at the end a
turntable and a report. Every file is written under another name and renamed, so whatever has its name is whole.
"""

import json
import platform
from collections.abc import Collection, Mapping
from importlib.metadata import version
from pathlib import Path

import numpy as np

from warpfluid import __version__
from warpfluid.errors import describe, writing
from warpfluid.files.atomic import remove_left, replacing
from warpfluid.files.folders import check_writable
from warpfluid.files.lines import append_line, line_of, read_lines
from warpfluid.files.tables import check_table, write_table
from warpfluid.files.vdb import layout, lost_mass, read_vdb, write_vdb
from warpfluid.options import OutputOptions
from warpfluid.settings import Settings, check_same, join_frames, read_settings

SETTINGS, RECORDS, FILM, PAGE = "run.toml", "frames.jsonl", "turntable.mp4", "report.html"
CHECKPOINT, BODIES = "checkpoint.npz", "bodies.json"  # of a simulation
VOLUMES = "density.*.vdb"
FARTHEST = 10**9  # frame; what claims to be further on is damaged
MADE = (RECORDS, FILM, PAGE, CHECKPOINT, BODIES)
PACKAGES = ("warp-lang", "numpy", "scipy", "scikit-image", "OpenEXR", "av")


class Run:
    """The folder of a run.

    Args:
        folder: Where it is or will be.
    """

    def __init__(self, folder: str | Path):
        self.folder = Path(folder)

    def volume_path(self, frame: int) -> Path:
        """Return the file of a frame's volume."""
        return self.folder / f"density.{frame:04d}.vdb"

    def records(self) -> dict[int, dict]:
        """Return the record of every finished frame whose volume is there, by frame, ascending."""
        found = {record["frame"]: record for record in self._all_records()}
        return {frame: found[frame] for frame in sorted(found) if self.volume_path(frame).exists()}

    def is_whole(self, frame: int) -> bool:
        """Return whether the volume of a frame is there and, by its checksum, undamaged."""
        try:
            data = self.volume_path(frame).read_bytes()
        except OSError:
            return False
        return len(data) > layout.ID.stop and data[layout.ID] == layout.content_id(data)

    def volume_id(self, frame: int) -> str:
        """Return what tells the volume of a frame from others: the checksum that its file holds.

        Raises:
            OSError: If it cannot be read.
        """
        with open(self.volume_path(frame), "rb") as file:
            return file.read(layout.ID.stop)[layout.ID].decode("ascii", "replace")

    def volume(self, frame: int) -> np.ndarray:
        """Return the volume of a frame, shape (x, z, y).

        Raises:
            ValueError: If its file is damaged.
            OSError: If it cannot be read.
        """
        return np.ascontiguousarray(read_vdb(self.volume_path(frame), ["density"]).grids["density"].transpose(0, 2, 1))

    def settings(self) -> dict:
        """Return what ``run.toml`` says.

        Raises:
            ValueError: If the folder is no run.
        """
        if not (self.folder / SETTINGS).is_file():
            raise ValueError(f"{self.folder} is no run, there is no {SETTINGS} in it: name a folder of reconstruct -o")
        return read_settings(self.folder / SETTINGS)

    def check_free(self, *, resume: bool = False, overwrite: bool = False) -> None:
        """Check, without making it, that the folder can take a run.

        Args:
            resume: An earlier run may be there.
            overwrite: The same, and stray volumes.

        Raises:
            ValueError: If it cannot.
        """
        if resume and overwrite:
            raise ValueError("--resume keeps an earlier run and --overwrite deletes it: choose one of them")
        nearest = next(path for path in (self.folder, *self.folder.absolute().parents) if path.exists())
        if not nearest.is_dir():
            raise ValueError(f"{self.folder} cannot be a folder, {nearest} is a file: choose another one with -o")
        check_writable(self.folder)
        there = (self.folder / SETTINGS).exists()
        if there and not (resume or overwrite):
            raise ValueError(
                f"{self.folder} holds a run already: continue it with --resume, or use --overwrite or another -o"
            )
        if not (there or overwrite) and any(self.folder.glob(VOLUMES)):
            raise ValueError(f"{self.folder} holds volumes of another origin, {VOLUMES}: choose another folder with -o")

    def begin(self, settings: Settings, facts: dict, *, resume: bool = False, overwrite: bool = False) -> dict:
        """Make the folder and write ``run.toml``, or check that an old run can be continued.

        Args:
            settings: What decides the result.
            facts: What else to note: device, hashes of the footage as ``inputs``.
            resume: Continue a run of the same settings.
            overwrite: Delete an earlier run.

        Returns:
            The records of the frames that are there and whole, by frame; none without ``resume``.

        Raises:
            ValueError: If the folder is taken, or the run to resume differs.
            OSError: If the folder cannot be written.
        """
        self.check_free(resume=resume, overwrite=overwrite)
        document = {**settings.to_dict(), "made-with": {**versions(), **facts}}
        there = (self.folder / SETTINGS).exists()
        if there and resume:
            old = self.settings()
            check_table(self.folder / SETTINGS)
            check_same(self.folder, old, document)
            join_frames(old, document)
        self._make_folder()
        if overwrite:
            for path in (*self.folder.glob(VOLUMES), *(self.folder / name for name in MADE)):
                path.unlink(missing_ok=True)
        remove_left(self.folder)
        kept = self._keep_whole() if resume else {}
        write_table(self.folder / SETTINGS, document)
        return kept

    def write_frame(
        self,
        frame: int,
        density: np.ndarray,
        output: OutputOptions,
        record: dict,
        *,
        more: Mapping[str, np.ndarray] | None = None,
    ) -> dict:
        """Write a frame's volume, then its record; see ``write_volume``."""
        record = self.write_volume(frame, density, output, record, more=more)
        self.add_record(record)
        return record

    def write_volume(
        self,
        frame: int,
        density: np.ndarray,
        output: OutputOptions,
        record: dict,
        *,
        more: Mapping[str, np.ndarray] | None = None,
    ) -> dict:
        """Write a frame's volume; it counts as made once its record is added.

        Args:
            frame: Its number.
            density: Volume, shape (x, z, y).
            output: How it is stored.
            record: What else to note.
            more: Further grids by name, shape (x, z, y) or (x, z, y, 3) with vectors (x, y, z).

        Returns:
            The whole record.

        Raises:
            ValueError: If the volume is not finite, or the record holds what JSON lacks.
            CannotWriteError: If the file cannot be written.
        """
        if not np.isfinite(density).all():
            raise ValueError(
                "the volume is not finite: the footage is too bright for the options; see --white, --shoulder"
            )
        path = self.volume_path(frame)
        lost = lost_mass(density, output.drop_below * float(np.abs(density).max()))
        record = {"frame": frame, "file": path.name, **record, "mass_dropped": lost}
        json.dumps(record, allow_nan=False)
        remove_left(self.folder, path.name)
        kept = stored(density, output)
        size, width, depth = output.voxel_size, density.shape[0], density.shape[1]
        grids = {
            "density": kept.transpose(0, 2, 1),
            **{name: grid.swapaxes(1, 2) for name, grid in (more or {}).items()},
        }
        place = {"voxel_size": size, "origin": (-(width - 1) / 2 * size, 0.5 * size, -(depth - 1) / 2 * size)}
        with writing(path):
            write_vdb(path, grids, **place, half=output.half, up=output.up, metadata={"frame": frame})
        return record

    def add_record(self, record: dict) -> None:
        """Note that a frame is made, on a line of its own even after half a line.

        Raises:
            CannotWriteError: If the file cannot be written.
        """
        path = self.folder / RECORDS
        with writing(path):
            append_line(path, record)

    def _make_folder(self) -> None:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            reason = describe(OSError(error.errno, error.strerror))
            raise OSError(f"{self.folder} cannot be made ({reason}): choose another folder with -o") from error

    def _all_records(self) -> list[dict]:
        """Return the records in the order of the file, without lines that are none."""
        lines = read_lines(self.folder / RECORDS)
        return [line for line in lines if type(line.get("frame")) is int and abs(line["frame"]) < FARTHEST]

    def forget(self, frames: Collection[int]) -> None:
        """Drop the records of frames, which are to be made again."""
        self._write_records({frame: record for frame, record in self.records().items() if frame not in frames})

    def _keep_whole(self) -> dict[int, dict]:
        """Drop the records of frames that are missing or damaged, and return the others."""
        kept = {frame: record for frame, record in self.records().items() if self.is_whole(frame)}
        self._write_records(kept)
        return kept

    def _write_records(self, records: Mapping[int, dict]) -> None:
        path = self.folder / RECORDS
        lines = b"".join(map(line_of, records.values()))
        if path.exists() and path.read_bytes() != lines:
            with replacing(path) as file:
                file.write(lines)


def stored(density: np.ndarray, output: OutputOptions) -> np.ndarray:
    """Return a volume as its file gives it back: faint density dropped, in half precision if so chosen.

    Args:
        density: Shape (x, z, y).
        output: How it is stored.
    """
    size = np.abs(density)
    kept = np.where(size > output.drop_below * float(size.max()), density, np.float32(0))
    return kept.astype(np.float16).astype(np.float32) if output.half else kept


def versions() -> dict[str, str]:
    """Return the versions of what takes part, and the machine."""
    found = {name: version(name) for name in PACKAGES}
    machine = f"{platform.system()} {platform.machine()}"
    return {"warpfluid": __version__, **found, "python": platform.python_version(), "system": machine}
