"""Whether pyvista can draw here."""

import subprocess
import sys

# Where there is no OpenGL library this crashes, so it is tried in a process of its own. The class says what it drew on.
DRAW = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow
window = vtkRenderWindow()
window.SetShowWindow(False)
window.SetSize(8, 8)
window.Render()
print(window.GetClassName())
"""
SCREENLESS = ("EGL", "OSOpenGL")  # in the names of classes that draw in memory
PATIENCE = 30  # s


def drawing() -> str:
    """Return what pyvista can draw on here: a ``screen``, ``memory`` alone, or ``nothing``."""
    command = [sys.executable, "-c", DRAW]
    try:
        found = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return "nothing"
    if found.returncode != 0:
        return "nothing"
    return "memory" if any(name in found.stdout for name in SCREENLESS) else "screen"
