"""The settings of a reconstruction."""

from dataclasses import dataclass

from warpfluid.errors import Problems
from warpfluid.footage.sources import parse_view
from warpfluid.options import PAPER, InputOptions, OutputOptions, ReconstructOptions
from warpfluid.settings.tables import make_options, to_table, whole_path


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
        """Return plain tables with whole paths; options that are None are left out, as TOML has no such value."""
        tables = {name: to_table(getattr(self, name)) for name in ("input", "reconstruct", "output")}
        background = tables["input"].get("background", "median")
        if background != "median":
            tables["input"]["background"] = whole_path(background)
        return {"views": [_whole_view(view) for view in self.views], **tables}


def make_settings(
    views: list[str], footage, method, output, *, paper: bool = False, document: dict | None = None
) -> Settings:
    """Put settings together: flags first, then the paper's choices, the configuration file, the defaults.

    Args:
        views: ``ANGLE=PATH`` of every view; those of the configuration when empty.
        footage: Flags with the names of ``InputOptions``; None where not given. May be None altogether.
        method: The same for ``ReconstructOptions``.
        output: The same for ``OutputOptions``.
        paper: Make the paper's choices.
        document: What a configuration file or ``run.toml`` says, see ``read_settings``.

    Raises:
        ValueError: If any value is wrong; one line each.
    """
    document, problems = document or {}, Problems()
    tables = {name: document.get(name, {}) for name in ("input", "reconstruct", "output")}
    tables["reconstruct"] = tables["reconstruct"] | (PAPER if paper else {})
    made = {
        "input": problems.attempt(make_options, InputOptions, tables["input"], footage),
        "reconstruct": problems.attempt(make_options, ReconstructOptions, tables["reconstruct"], method),
        "output": problems.attempt(make_options, OutputOptions, tables["output"], output),
    }
    problems.raise_if_any()
    return Settings(views=tuple(views or document.get("views", ())), **made)


def _whole_view(view: str) -> str:
    angle_deg, path = parse_view(view)
    return f"{angle_deg:.15g}={whole_path(path)}"
