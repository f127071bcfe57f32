"""
What the options of render do
=============================

Draws the pictures of ``docs/rendering.md``: the same frame with a low and a high value of one option. Takes some
minutes; a second argument names a folder where the simulated runs are kept.
"""

# %%
# Each picture is labelled with what was typed.

from gallery import panel, save
from renders import evening, render


def draw(option: str, values: tuple[str, ...], name: str, frame: int, also: str = "", **how) -> None:
    """Save pictures of one option at some values, side by side."""
    row = {value: render(name, frame, f"{also} --{option} {value}", **how) for value in values}
    save(f"render-{option}.png", panel(row))


# %%
# The look.

NEAR = "--look explosion --zoom 1.6 --target 0,3,0"
CLOSE = "--look explosion --zoom 4.5 --target -1.3,4,0"
draw("interpolation", ("linear", "cubic"), "explosion", 16, CLOSE, size=(300, 240))
draw("mode", ("lit", "emission", "sum"), "explosion", 16, NEAR)
draw("thickness", ("0.15", "1", "5"), "smoke", 60)
draw("glow", ("0.25", "1", "4"), "fire", 12)
draw("bias", ("-0.4", "0", "0.4"), "explosion", 16, NEAR)
draw("anisotropy", ("-0.5", "0", "0.7"), "smoke", 60, "--key-light 0.4,0.5,-1 --key-strength 3 --thickness 0.5")
draw("edge-fade", ("0", "6", "20"), "smoke", 60)

# %%
# Light.

draw("key-light", ("-1,1,0.4", "1,0.3,0.6", "0,0.6,-1"), "smoke", 60, "--ground --elevation 12")
draw("key-strength", ("0", "1.5", "4"), "smoke", 60)
draw("ambient", ("0", "0.12", "0.6"), "smoke", 60)
draw("probe-rotation", ("0", "120", "240"), "smoke", 60, f"--probe {evening()} --sky --ground --elevation 12")

NIGHT = "--ground --key-strength 0 --ambient 0.03"
BALL = "--look explosion --elevation 12 --zoom 1.3 --target 0,4,0"
row = {
    text: render("explosion", 11, f"{BALL} {flags}")
    for text, flags in {"--no-ground": "", "--ground": "--ground", "--ground, at night": NIGHT}.items()
}
save("render-ground.png", panel(row))

# %%
# The camera.

draw("angle", ("0", "60", "120"), "explosion", 24, "--look explosion --zoom 1.2")
draw("elevation", ("0", "25", "60"), "explosion", 24, "--look explosion --ground")
draw("field-of-view", ("10", "30", "80"), "explosion", 24, "--look explosion --ground --elevation 8")

# %%
# What a screen shows of it.

draw("exposure", ("-2", "0", "2"), "fire", 12)
draw("rolloff", ("0.2", "0.6", "1"), "fire", 12)
draw("backdrop", ("0,0,0", "0.45,0.5,0.55", "1,1,1"), "smoke", 60)
draw("motion-blur", ("0", "0.5", "1"), "fire", 12, "--zoom 2.2 --target 0,3.5,0")
