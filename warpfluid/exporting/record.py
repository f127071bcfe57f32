"""What an export notes about itself, so that it can be continued, and read by the scenes that show it."""

import dataclasses
import hashlib
import json
from pathlib import Path

from warpfluid import __version__
from warpfluid.files.atomic import replacing
from warpfluid.files.lines import CHECK, checksum
from warpfluid.options import ExportOptions
from warpfluid.run import SETTINGS
from warpfluid.volumes import ENDINGS, EXPORT

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
                (folder / frame["file"]).unlink(missing_ok=True)
        folder.mkdir(parents=True, exist_ok=True)
        kept = old.get("frames", {}) if resume else {}
        kept = {frame: facts for frame, facts in kept.items() if self._is_whole(facts)}
        self.content = {"warpfluid": __version__, **asked, **facts, "frames": kept}

    def has(self, frame: int, source_hash: str) -> bool:
        """Return whether a frame is there, made from the volume that is there now."""
        return self.content["frames"].get(str(frame), {}).get("source_hash") == source_hash

    def add(self, frame: int, facts: dict) -> None:
        """Note a frame that is written, and what is in its file.

        Raises:
            OSError: If the file cannot be read, or this one not be written.
        """
        noted = facts | {"file_hash": _whole_hash(self.path.with_name(facts["file"]))}
        frames = self.content["frames"] | {str(frame): noted}
        self.content["frames"] = {key: frames[key] for key in sorted(frames, key=int)}
        self.write()

    def write(self) -> None:
        """Write the file.

        Raises:
            OSError: If it cannot be written.
        """
        content = self.content | {CHECK: checksum(self.content)}
        with replacing(self.path) as file:
            file.write((json.dumps(content, indent=1, allow_nan=False) + "\n").encode())

    def _is_whole(self, facts: dict) -> bool:
        """Return whether the file of a frame is there as it was written."""
        path = self.path.with_name(facts["file"])
        return path.is_file() and _whole_hash(path) == facts.get("file_hash")

    def _read(self) -> dict:
        try:
            content = json.loads(self.path.read_bytes())
            sound = content.pop(CHECK, None) in (None, checksum(content))
            sound &= all(_is_own(int(frame), facts["file"]) for frame, facts in content["frames"].items())
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            sound = False
        if not sound:
            raise ValueError(f"{self.path} is damaged: delete it, or choose another folder with -o")
        return content

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


def _is_own(frame: int, name: str) -> bool:
    """Return whether the name of a frame's file is such as we write: a damaged record names anything."""
    return name in {f"density.{frame:04d}{ending}" for ending in ENDINGS}


def _whole_hash(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
