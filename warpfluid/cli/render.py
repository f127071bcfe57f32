"""``warpfluid render``: pictures and films of volumes."""

from functools import partial
from pathlib import Path
from typing import Annotated, get_args

from cyclopts import Parameter

from warpfluid.cli.app import app
from warpfluid.cli.configured import check_volumes, configure
from warpfluid.cli.flags import COMMON, ClusterFlag, Common, ConfigFlag, JobsFlag, SourceArgument, make_flags
from warpfluid.options import CameraOptions, LightOptions, RenderOptions

CameraFlags = make_flags(CameraOptions, "Camera", 2)
LightFlags = make_flags(LightOptions, "Light", 3)
PictureFlags = make_flags(RenderOptions, "Picture", 1)
NO_CAMERA, NO_LIGHT, NO_PICTURE = (get_args(flags)[0]() for flags in (CameraFlags, LightFlags, PictureFlags))


@app.command
def render(
    source: SourceArgument,
    *,
    out: Annotated[
        Path | None,
        Parameter(name=["--out", "-o"], help="A film (.mp4, .webp, .gif), a picture, or name.####.exr or .png; needed"),
    ] = None,
    resume: Annotated[bool, Parameter(negative=(), help="Keep the numbered pictures that are there")] = False,
    overwrite: Annotated[bool, Parameter(negative=(), help="Replace what is there")] = False,
    jobs: JobsFlag = None,
    cluster: ClusterFlag = None,
    config: ConfigFlag = None,
    picture: PictureFlags = NO_PICTURE,
    camera: CameraFlags = NO_CAMERA,
    light: LightFlags = NO_LIGHT,
    common: Common = COMMON,
) -> int:
    """Render volumes with light and shadow: films, pictures, and layers for compositing."""
    from warpfluid.commands import render as command

    chosen = configure(common, config, jobs=jobs, cluster=cluster)
    if out is None:
        chosen.problems.append("no place is given for the pictures: add -o film.mp4, or -o picture.####.exr")
    asked = ((CameraOptions, "camera", camera), (LightOptions, "light", light), (RenderOptions, "render", picture))
    made = [chosen.options(*each) for each in asked]
    chosen.refuse(partial(check_volumes, source))
    return command.render(source, *made, out, resume=resume, overwrite=overwrite, **chosen.who)
