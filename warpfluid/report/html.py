"""The pieces of the report's page: embedded pictures and tables."""

import base64
import io
from collections.abc import Mapping, Sequence
from html import escape
from numbers import Integral, Real

import numpy as np

from warpfluid.rendering.ramps import apply_ramp


def section(title: str, content: str) -> str:
    """Return a titled card, or nothing if it has no content."""
    return f'<h2>{escape(title)}</h2><div class="card">{content}</div>' if content else ""


def side_by_side(*parts: str) -> str:
    """Return the parts in a row that breaks on narrow screens; empty ones are left out."""
    parts = [part for part in parts if part]
    return f'<div class="side">{"".join(parts)}</div>' if parts else ""


def image(picture: np.ndarray, words: str, style: str = "") -> str:
    """Return a picture, embedded as PNG, uint8 of shape (rows, columns) or (rows, columns, 3)."""
    from PIL import Image

    png = io.BytesIO()
    Image.fromarray(_checked(picture, words)).save(png, "PNG")
    kind = f' class="{style}"' if style else ""
    return f'<img{kind} alt="{escape(words)}" src="{_data_uri("png", png)}">'


def film(pictures: np.ndarray, rate: float, words: str) -> str:
    """Return pictures as an endless film, embedded as WebP."""
    from PIL import Image

    first, *others = [Image.fromarray(_checked(picture, words)) for picture in pictures]
    webp = io.BytesIO()
    first.save(webp, "WEBP", save_all=True, append_images=others, duration=round(1000 / rate), loop=0, quality=85)
    return f'<img alt="{escape(words)}" src="{_data_uri("webp", webp)}">'


def table(rows: Sequence[Mapping[str, object]]) -> str:
    """Return rows of the same columns as a table; numbers go to the right."""
    if not rows:
        return ""
    names = list(rows[0])
    numeric = {name: all(isinstance(row.get(name), Real | None) for row in rows) for name in names}
    kind = {name: ' class="number"' if numeric[name] else "" for name in names}
    head = "".join(f"<th{kind[name]}>{escape(name)}</th>" for name in names)
    lines = "".join(
        "<tr>" + "".join(f"<td{kind[name]}>{cell(row.get(name))}</td>" for name in names) + "</tr>" for row in rows
    )
    return scroll(f"<table><tr>{head}</tr>{lines}</table>")


def scroll(content: str) -> str:
    """Return content that may be wider than a narrow screen, and is then moved sideways."""
    return f'<div class="scroll">{content}</div>' if content else ""


def shortened(text: str, most: int = 60) -> str:
    """Return a text with its middle left out if it is long; the whole of it shows on hovering."""
    if len(text) <= most:
        return escape(text)
    head, tail = most // 3, most - most // 3 - 1
    return f'<span title="{escape(text)}">{escape(text[:head])}…{escape(text[-tail:])}</span>'


def cell(value: object) -> str:
    """Return a value as people write it: three digits of a number, a dash for none."""
    if value is None:
        return "–"
    if isinstance(value, Real) and not isinstance(value, Integral):
        size = abs(value)
        digits = 3 if size < 9.9995 else 1 if size < 9999.5 else 0
        return f"{value:.{digits}f}".replace("-", "−") if np.isfinite(value) else "–"
    return escape(str(value))


def colour_bar(end: float) -> str:
    """Return the jet colours of densities from 0 to ``end``."""
    stops = apply_ramp(np.linspace(0, 255, 33), "jet")
    colours = ", ".join("#{:02x}{:02x}{:02x}".format(*map(int, stop)) for stop in stops)
    labels = "".join(f"<span>{end * share:.3g}</span>" for share in (0, 0.25, 0.5, 0.75, 1))
    style = f"background: linear-gradient(to right, {colours})"
    return f'<div class="bar" style="{style}"></div><div class="ends">{labels}</div>'


def _checked(picture: np.ndarray, words: str) -> np.ndarray:
    """Return the picture, contiguous, or say what is wrong with it."""
    picture = np.ascontiguousarray(picture)
    grey_or_rgb = picture.ndim == 2 or (picture.ndim == 3 and picture.shape[2] == 3)
    if picture.dtype != np.uint8 or not grey_or_rgb or picture.size == 0:
        raise ValueError(
            f"picture '{words}' is {picture.dtype} of shape {picture.shape}; "
            "uint8 of shape (rows, columns) or (rows, columns, 3) is needed"
        )
    return picture


def _data_uri(kind: str, content: io.BytesIO) -> str:
    """Return bytes as an address that holds them."""
    return f"data:image/{kind};base64,{base64.b64encode(content.getvalue()).decode()}"
