"""A run on disk: volumes of a shot, frame by frame, and what is needed to repeat or continue it.

The folder holds ``density.0001.vdb`` and so on, with the frame numbers of the footage, ``run.toml`` (every option,
versions, device, hashes of the footage), ``frames.jsonl`` (a record for each finished frame), and at the end a
turntable and a report. Every file is written under another name and renamed, so whatever has its name is whole.
"""

import dataclasses
import json
import os
import platform
import tomllib
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np

from warpfluid import __version__
from warpfluid.files.atomic import replacing
from warpfluid.files.vdb import lost_mass, read_vdb, write_vdb
from warpfluid.options import InputOptions, OutputOptions, ReconstructOptions

SETTINGS, RECORDS = "run.toml", "frames.jsonl"
SECTIONS = {"input": InputOptions, "reconstruct": ReconstructOptions, "output": OutputOptions}
PACKAGES = ("warp-lang", "numpy", "scipy", "scikit-image", "OpenEXR", "av")


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Everything that decides what a run makes.

    Attributes:
        views: ``ANGLE=PATH`` of every view.
        input: How pictures become images.
        reconstruct: The method.
        output: What is written.
    """

    views: tuple[str, ...]
    input: InputOptions
    reconstruct: ReconstructOptions
    output: OutputOptions

    def to_dict(self) -> dict:
        """Return plain tables; options that are None are left out, as TOML has no such value."""
        tables = {name: dataclasses.asdict(getattr(self, name)) for name in SECTIONS}
        tables = {name: {k: v for k, v in table.items() if v is not None} for name, table in tables.items()}
        return {"views": list(self.views), **tables}


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
        path, found = self.folder / RECORDS, {}
        if path.exists():
            for line in path.read_text("utf-8").splitlines():
                try:
                    record = json.loads(line)
                except json.JSONDecodeError:  # the run was stopped while it wrote this line
                    continue
                if self.volume_path(record["frame"]).exists():
                    found[record["frame"]] = record
        return dict(sorted(found.items()))

    def volume(self, frame: int) -> np.ndarray:
        """Return the volume of a frame, shape (x, z, y)."""
        return np.ascontiguousarray(read_vdb(self.volume_path(frame), ["density"]).grids["density"].transpose(0, 2, 1))

    def settings(self) -> dict:
        """Return what ``run.toml`` says.

        Raises:
            ValueError: If the folder is no run.
        """
        return read_settings(self.folder / SETTINGS)

    def begin(self, settings: Settings, facts: dict, *, resume: bool, overwrite: bool) -> None:
        """Make the folder and write ``run.toml``, or check that an old one can be continued.

        Args:
            settings: What decides the result.
            facts: What else to note: device, hashes of the footage.
            resume: Continue a run of the same settings.
            overwrite: Delete the volumes and records of an earlier run.

        Raises:
            ValueError: If there is a run already, or the one to resume differs.
            OSError: If the folder cannot be written.
        """
        path = self.folder / SETTINGS
        if path.exists() and not (resume or overwrite):
            raise ValueError(f"{self.folder} holds a run already: continue it with --resume, or use --overwrite or another -o")
        if path.exists() and resume:
            self._check_same(settings, facts)
        self.folder.mkdir(parents=True, exist_ok=True)
        if overwrite and path.exists():
            for frame in self.records():
                self.volume_path(frame).unlink(missing_ok=True)
            (self.folder / RECORDS).unlink(missing_ok=True)
        document = {**settings.to_dict(), "made-with": {**versions(), **facts}}
        _write_toml(path, document)

    def write_frame(self, frame: int, density: np.ndarray, output: OutputOptions, record: dict) -> dict:
        """Write a frame's volume, then its record.

        Args:
            frame: Its number.
            density: Volume, shape (x, z, y).
            output: How it is stored.
            record: What else to note.

        Returns:
            The whole record.
        """
        threshold = output.drop_below * float(density.max())
        size, width, depth = output.voxel_size, density.shape[0], density.shape[1]
        write_vdb(
            self.volume_path(frame),
            {"density": density.transpose(0, 2, 1)},
            voxel_size=size,
            origin=(-(width - 1) / 2 * size, 0.5 * size, -(depth - 1) / 2 * size),
            half=output.half,
            threshold=threshold,
            up=output.up,
            metadata={"frame": frame},
        )
        lost = lost_mass(density, threshold)
        record = {"frame": frame, "file": self.volume_path(frame).name, **record, "mass_dropped": lost}
        with (self.folder / RECORDS).open("a", encoding="utf-8") as file:
            file.write(json.dumps(record) + "\n")
            file.flush()
            os.fsync(file.fileno())
        return record

    def _check_same(self, settings: Settings, facts: dict) -> None:
        old, new = self.settings(), settings.to_dict()
        changed = []
        for name in ("views", "reconstruct", "input", "output"):
            before, after = old.get(name, {}), new[name]
            if name == "views":
                changed += ["views"] if before != after else []
                continue
            for key in sorted({*before, *after} - {"frames", "turntable", "report", "look"}):
                if before.get(key) != after.get(key):
                    changed.append(f"{key} (was {before.get(key)}, now {after.get(key)})")
        before = old.get("made-with", {}).get("inputs", {})
        changed += [f"footage {name}" for name, hash_ in facts.get("inputs", {}).items() if before.get(name, hash_) != hash_]
        if changed:
            raise ValueError(
                f"{self.folder} was made with other settings: {', '.join(changed)}; "
                "use the same ones, or --overwrite, or another -o"
            )


def read_settings(path: str | Path) -> dict:
    """Read ``run.toml`` or a configuration file and check its names.

    Raises:
        ValueError: If it is no TOML, or names something unknown.
    """
    import difflib

    try:
        document = tomllib.loads(Path(path).read_text("utf-8"))
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror or error}; it should be a configuration or run.toml") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path} is not TOML: {error}") from error
    problems = []
    for name, table in document.items():
        if name not in (*SECTIONS, "views", "made-with"):
            problems.append(f"{path}: unknown section [{name}], expected views, {', '.join(f'[{s}]' for s in SECTIONS)}")
        elif name in SECTIONS and not isinstance(table, dict):
            problems.append(f"{path}: {name} is {table!r}, expected a table [{name}]")
        elif name in SECTIONS:
            known = [field.name for field in dataclasses.fields(SECTIONS[name])]
            for key in set(table) - set(known):
                near = difflib.get_close_matches(key, known, 1)
                hint = f", did you mean {near[0]}?" if near else f"; it has {', '.join(known)}"
                problems.append(f"{path}: [{name}] has no option {key!r}{hint}")
    if problems:
        raise ValueError("\n".join(problems))
    return document


def versions() -> dict[str, str]:
    """Return the versions of what takes part, and the machine."""
    found = {name: version(name) for name in PACKAGES}
    return {"warpfluid": __version__, **found, "python": platform.python_version(), "system": f"{platform.system()} {platform.machine()}"}


def _write_toml(path: Path, document: dict) -> None:
    import tomli_w

    with replacing(path) as file:
        tomli_w.dump(document, file)

