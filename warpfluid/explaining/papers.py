"""What the texts of runs and exports are, in a line."""

import html
import json
import re
import tomllib
from pathlib import Path

from warpfluid.files.lines import read_lines
from warpfluid.settings.configuration import SECTIONS

PAPERS = (".toml", ".html", ".json", ".jsonl")
JSON = {
    "bodies.json": "the rigid bodies of a simulation, frame by frame",
    "export.json": "record of an export, by which --resume goes on: name its folder to hear more",
}
HEAD = 1 << 16  # characters of a page in which its title stands


def explain_paper(path: Path) -> dict:
    """Return what a text that lies beside volumes is, and what it is good for.

    Raises:
        ValueError: If it is damaged.
        OSError: If it cannot be read.
    """
    kinds = {".toml": _settings, ".html": _page, ".json": _json, ".jsonl": _records}
    return {"kind": kinds[path.suffix.lower()](path), "warnings": []}


def _settings(path: Path) -> str:
    try:
        document = tomllib.loads(path.read_text("utf-8"))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is not TOML: {error}") from error
    if "made-with" in document:
        command = "simulate" if "simulate" in document else "reconstruct"
        return f"settings of a run of {command}: make it again with {command} --config {path} -o FOLDER"
    known = [f"[{name}]" for name in document if name in SECTIONS]
    return f"configuration, {' '.join(known)}: give it with --config" if known else "TOML, no settings of warpfluid"


def _page(path: Path) -> str:
    with path.open(encoding="utf-8", errors="replace") as file:
        title = re.search("<title>(.*?)</title>", file.read(HEAD), re.DOTALL)
    return f"web page, {html.unescape(title[1].strip())}: open it in a browser" if title else "web page"


def _json(path: Path) -> str:
    try:
        document = json.loads(path.read_bytes())
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is not JSON: {error}") from error
    size = f"{len(document)} entries" if isinstance(document, dict | list) else "a value"
    return JSON.get(path.name, f"JSON, {size}")


def _records(path: Path) -> str:
    frames = {line["frame"] for line in read_lines(path) if type(line.get("frame")) is int}
    return f"records of {len(frames)} frames, a line each: name the folder to hear more"
