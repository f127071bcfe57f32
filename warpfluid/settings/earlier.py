"""What runs of earlier versions were made with: an option that was not there yet had one value, not always today's."""

import dataclasses

EARLIER = {
    "reconstruct": {"coherence": "none", "highpass": "whole"},
    "simulate": {"blend_apart": 1.0, "liquid_surface": 0.0},
}


def fill_earlier(document: dict) -> dict:
    """Return the document of a run with the options that its version lacked and would choose otherwise today.

    Args:
        document: ``run.toml``; what has no ``made-with`` is no run and comes back as it is.
    """
    if "made-with" not in document:
        return document
    return document | {name: EARLIER[name] | document[name] for name in EARLIER if name in document}


def with_defaults(table: dict, kind: type) -> dict:
    """Return a table of options with the defaults of those that it lacks; what is None is left out, as in TOML.

    Args:
        table: Options of a section.
        kind: Their dataclass.
    """
    defaults = {field.name: field.default for field in dataclasses.fields(kind) if field.default is not None}
    return defaults | table
