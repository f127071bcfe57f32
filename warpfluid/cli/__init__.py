"""The command line, a file for each command."""

from warpfluid.cli import (
    compare,
    completion,
    demo,
    doctor,
    export,
    flow,
    inspect,
    preview,
    reconstruct,
    render,
    simulate,
)
from warpfluid.cli.app import app, main
from warpfluid.cli.examples import show_examples

show_examples(app)

__all__ = [
    "app",
    "compare",
    "completion",
    "demo",
    "doctor",
    "export",
    "flow",
    "inspect",
    "main",
    "preview",
    "reconstruct",
    "render",
    "simulate",
]
