"""What an export notes about itself, so that it can be continued, and read by the scenes that show it."""

import dataclasses
import json
from pathlib import Path

from warpfluid import __version__
from warpfluid.files.atomic import replacing
from warpfluid.options import ExportOptions
from warpfluid.run import SETTINGS
from warpfluid.volumes import EXPORT

FREE = {"frames"}  # may differ when an export is continued


class Record:
    """The file ``export.json`` of a folder.

    Args:
        folder: Where the export goes.
    """

    def __init__(self, folder: Path):
        self.path = folder / EXPORT
        self.content: dict = {}

    def begin(self, source: Path, options: ExportOptions, facts: dict, *, resume: bool, overwrite: bool) -> None:
        """Make the folder, or check that it can be continued or replaced.

        Args:
            source: The volumes.
            options: How they are written.
            facts: What else is noted.
            resume: Keep what is there.
            overwrite: Delete it.

        Raises:
            ValueError: If the folder is taken, or holds an export of another kind.
            OSError: If it cannot be written.
        """
        folder = self.path.parent
        if resume and overwrite:
            raise ValueError("--resume keeps what is there and --overwrite replaces it: choose one of them")
        if folder.exists() and not folder.is_dir():
            raise ValueError(f"{folder} is a file: name a folder with -o")
        if (folder / SETTINGS).exists() or folder.resolve() == (source if source.is_dir() else source.parent).resolve():
            raise ValueError(f"{folder} holds the volumes of a run or the source: choose another folder with -o")
        asked = {"source": str(source.resolve()), "options": dataclasses.asdict(options)}
        old = self._read() if self.path.exists() else {}
        there = sorted(folder.glob(f"density.*.{options.ending}"))
        if (old or there) and not (resume or overwrite):
            raise ValueError(f"{folder} holds volumes already: go on with --resume, or replace them with --overwrite")
        if resume and old:
            self._check_same(old, asked)
        if overwrite:
            for frame in old.get("frames", {}).values():
                (folder / Path(frame["file"]).name).unlink(missing_ok=True)
        folder.mkdir(parents=True, exist_ok=True)
        kept = old.get("frames", {}) if resume else {}
        kept = {frame: facts for frame, facts in kept.items() if (folder / Path(facts["file"]).name).is_file()}
        self.content = {"warpfluid": __version__, **asked, **facts, "frames": kept}

    def has(self, frame: int, source_hash: str) -> bool:
        """Return whether a frame is there, made from the volume that is there now."""
        return self.content["frames"].get(str(frame), {}).get("source_hash") == source_hash

    def add(self, frame: int, facts: dict) -> None:
        """Note a frame that is written.

        Raises:
            OSError: If the file cannot be written.
        """
        frames = self.content["frames"] | {str(frame): facts}
        self.content["frames"] = {key: frames[key] for key in sorted(frames, key=int)}
        self.write()

    def write(self) -> None:
        """Write the file.

        Raises:
            OSError: If it cannot be written.
        """
        with replacing(self.path) as file:
            file.write((json.dumps(self.content, indent=1, allow_nan=False) + "\n").encode())

    def _read(self) -> dict:
        try:
            content = json.loads(self.path.read_bytes())
            names = [frame["file"] for frame in content["frames"].values()]
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise ValueError(f"{self.path} is damaged: delete it, or choose another folder with -o") from error
        return content if all(isinstance(name, str) for name in names) else {}

    def _check_same(self, old: dict, asked: dict) -> None:
        before, after = old.get("options", {}), asked["options"]
        changed = [
            f"{name.replace('_', '-')} (was {before.get(name)}, now {after.get(name)})"
            for name in sorted({*before, *after} - FREE)
            if before.get(name) != after.get(name)
        ]
        if old.get("source") != asked["source"]:
            changed.insert(0, f"the source (was {old.get('source')})")
        if changed:
            raise ValueError(
                f"{self.path.parent} was exported otherwise: {', '.join(changed)}; "
                "use the same again, or --overwrite, or another folder with -o"
            )
