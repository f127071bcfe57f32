"""Every command that a page shows runs, page by page: as shown, but for sizes and lengths that take their time."""

import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest
from test_docs import PAGES, blocks, command_lines
from tiny import BARE, flame, footage, run

import warpfluid as wf
from warpfluid.files.exr import write_exr
from warpfluid.files.images import write_png
from warpfluid.files.sequences import format_frames, parse_frames
from warpfluid.files.video import write_video

WIDTH, HEIGHT = 36, 27
SMALL = {
    "--resolution": str(WIDTH),
    "--size": f"{WIDTH}x{HEIGHT}",
    "--iterations": "1",
    "--turntable": "2",
    "--jobs": "1",
}
PLAIN = dict.fromkeys(BARE)
QUICK = {"--iterations": "1", "--angles": "6", "--cg-steps": "1", "--lsm-steps": "2"}
FEW = {"--frames": "1-2", "--resolution": str(WIDTH)}
ADDED = {
    "inspect": FEW,
    "flow": FEW,
    "reconstruct": FEW | QUICK | PLAIN,
    "simulate": PLAIN,
    "compare": {"--measured-frames": "1", "--scored-angles": "45"},
    "render": {"--resolution": "16x16"},
}
RUNS = ("campfire", "smoke", "blast", "alone", "coherent", "simulated", "truth", "warpfluid-demo")
CAMERA = '[{"frame": 1, "angle": 0}, {"frame": 2, "angle": 60, "target": [0, 4, 0]}]'
ELSEWHERE = ("demo", "doctor")  # tested elsewhere; the first is long, the second looks at this machine
LINES = {}
for _page, _line in command_lines():
    LINES.setdefault(_page, []).append(_line)


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """All that the pages speak of: footage, runs, volumes of other programs, skies, a path, a scene."""
    folder = tmp_path_factory.mktemp("pages")
    for name in ("front", "side", "right", "campfire", "clip"):
        make_footage(folder, name)
    footage(folder / "right", range(1, 61), lambda frame, _: flame(frame, 1, WIDTH, HEIGHT))
    views = ("--front", folder / "front.mp4", "--side", folder / "side.mp4")
    assert run("reconstruct", *views, *spelt(ADDED["reconstruct"]), "-q", "-o", folder / "fire") == 0
    for name in RUNS:
        shutil.copytree(folder / "fire", folder / name)
    for name in ("cache/smoke", "cache/plume", "houdini/smoke", "clouds"):
        make_volumes(folder / name)
    make_sky(folder)
    (folder / "path.json").write_text(CAMERA)
    (folder / "scene.toml").write_text(blocks("docs/simulating.md", "toml")[0])
    return folder


def make_footage(folder: Path, name: str) -> None:
    """Write a clip of 60 frames, and pictures 1001 and 1002 beside it."""
    angle = int(name in ("side", "right"))
    pictures = [flame(frame, angle, 96, 72)[..., None].repeat(3, axis=2) for frame in range(2)]
    count = 60 if name in ("front", "right") else 2
    write_video(folder / f"{name}.mp4", (pictures[frame % 2] for frame in range(count)), 24)
    for frame in (1001, 1002):
        light = flame(frame, angle, WIDTH, HEIGHT).astype(np.float32) / 255
        write_exr(folder / f"{name}.{frame}.exr", dict.fromkeys("RGB", light))


def make_volumes(stem: Path) -> None:
    """Write two frames of a ball with a wind in it, as another program has them."""
    stem.parent.mkdir(exist_ok=True)
    x, y, z = np.mgrid[:WIDTH, :HEIGHT, :WIDTH] - (np.array([WIDTH, HEIGHT, WIDTH]).reshape(3, 1, 1, 1) - 1) / 2
    for frame in (1, 2):
        ball = np.clip(9 - np.sqrt((x - frame) ** 2 + y**2 + z**2), 0, 4).astype(np.float32)
        grids = {"density": ball, "velocity": np.stack([ball, 0 * ball, 0 * ball], axis=-1)}
        if stem.name == "plume":
            grids = {"smoke": ball, "density": ball}
        wf.write_vdb(f"{stem}.{frame:04d}.vdb", grids, voxel_size=0.01)
    wf.write_nvdb(stem.parent / "plume.nvdb", {"density": ball})


def make_sky(folder: Path) -> None:
    """Write light probes, flat and small, and a picture of an empty set."""
    for name in ("sky", "evening"):
        write_exr(folder / f"{name}.exr", dict.fromkeys("RGB", np.full((4, 8), 0.5, np.float32)))
    pixels = np.full((4, 8, 4), 128, np.uint8).tobytes()
    (folder / "sky.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + pixels)
    write_png(folder / "empty.png", np.zeros((HEIGHT, WIDTH), np.uint8))


def small(line: str) -> list[str]:
    """Return the words of a command line with small numbers in place of large ones, and what makes it quick."""
    command, *words = shlex.split(re.sub(r" --cluster \S+", "", line))[1:]  # there is no scheduler here
    for at, word in enumerate(words[:-1]):
        if word == "--frames":
            words[at + 1] = few_frames(command, words)
        elif word == "--crop":
            words[at + 1] = re.sub(r"\d+", lambda number: str(int(number[0]) // 10), words[at + 1])  # clips are 96 x 72
        elif word in SMALL:
            words[at + 1] = "16x16" if command == "render" and word == "--resolution" else SMALL[word]
    added = ADDED.get(command, {})
    of_files = command == "inspect" and not words[0].startswith("-")
    if of_files or (command == "simulate" and "--resume" in words):
        added = {}
    elif "--config" in words:
        added = PLAIN | (QUICK if command == "reconstruct" else {})
    elif "--preset" in words:
        added = added | {"--preroll": "0"}
    return [command, *words, *spelt({flag: value for flag, value in added.items() if flag not in words}), "-q"]


def spelt(flags: dict[str, str | None]) -> list[str]:
    """Return flags as words; some have no value."""
    return [word for pair in flags.items() for word in pair if word is not None]


def few_frames(command: str, words: list[str]) -> str:
    """Return frames that there are, as few as show the same: one, or two."""
    frames = parse_frames(words[words.index("--frames") + 1])
    if command in ("reconstruct", "flow"):
        return format_frames(frames[:2])
    if command == "simulate":
        return "1-3" if "--resume" in words else "1-2"
    there = wf.open_volumes(words[0]).frames
    return format_frames(there[: min(2, len(frames))])


def clear(words: list[str]) -> None:
    """Remove what a command would find in its place."""
    for at, word in enumerate(words[:-1]):
        if word in ("-o", "--out") and "--resume" not in words:
            shutil.rmtree(words[at + 1], ignore_errors=True)


@pytest.mark.parametrize("page", LINES)
def test_commands_of_a_page_run(page, made, tmp_path, monkeypatch, capfd):
    """They run one after the other, as a reader would run them, and succeed."""
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("warpfluid.preview.show.drawing", lambda: "nothing")
    for line in LINES[page]:
        if line.split()[1] not in ELSEWHERE:
            words = small(line)
            clear(words)
            assert run(*words) == 0, f"{line}\n{shlex.join(words)}\n{capfd.readouterr().err}"


@pytest.mark.parametrize("page", [page for page in PAGES if page.startswith("docs/") and blocks(page, "python")])
def test_python_of_a_page_runs(page, made, tmp_path, monkeypatch):
    """What programmers are shown works as it stands, one block after the other."""
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    for kind, folder in (("nvdb", "fn"), ("npz", "fa")):
        assert run("export", "cache/smoke.####.vdb", "--format", kind, "-o", folder, "-q") == 0
    shared = {}
    for script in blocks(page, "python"):
        code = compile(script, page, "exec")
        if "dask" not in script:  # there is no cluster here
            exec(code, shared)
