"""An example for the help of each command, and the order in which commands are listed: that of the work."""

from cyclopts import App

EXAMPLES = {
    "demo": "warpfluid demo",
    "inspect": "warpfluid inspect --front clip.mp4",
    "reconstruct": "warpfluid reconstruct --front clip.mp4 --resolution 256 --black-level 20 -o fire",
    "preview": "warpfluid preview fire --html fire.html",
    "simulate": "warpfluid simulate fire --wind 2,0,0 -o windy",
    "presets": "warpfluid presets",
    "render": "warpfluid render fire -o fire-3d.mp4 --ground --elevation 6",
    "compare": "warpfluid compare fire windy -o film.mp4",
    "export": "warpfluid export fire --format blender -o fire-in-blender",
    "flow": "warpfluid flow --front clip.mp4 -o motion",
    "doctor": "warpfluid doctor",
    "completion": "warpfluid completion bash",
}


def show_examples(app: App) -> None:
    """Give each command its example and its place."""
    for place, (name, line) in enumerate(EXAMPLES.items()):
        app[name].sort_key = place
        app[name].help_epilogue = f"Example: {line}"
