"""Sphinx makes a site of these pages: `sphinx-build -W docs site`, with the packages of the extra `docs`.

The pages are plain Markdown, so that they read as well unbuilt. What only the site needs stands in comments, which are
turned into directives here: `<!-- toctree -->` lists the pages that the page links to, a part for each of its headings,
and `<!-- autodoc MODULE: NAMES -->` shows the docstrings of these names. Nothing is downloaded, and no GPU is needed.
"""

import dataclasses
import re
from pathlib import Path
from typing import Annotated, get_args, get_origin, get_type_hints

from warpfluid import __version__

HERE = Path(__file__).parent

project = "warpfluid"
author = "the authors of warpfluid"
copyright = author
version = release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_build"]
root_doc = "index"

myst_heading_anchors = 4  # links lead to headings by the anchors that forges make
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = f"warpfluid {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_copyright = False
html_show_sphinx = False


def expand_comments(app, docname: str, source: list[str]) -> None:
    """Turn the comments of a page into directives; the page of changes is the changelog."""
    text = source[0]
    if docname == "changes":
        text = (HERE.parent / "CHANGELOG.md").read_text("utf-8")
    text = re.sub(r"<!-- autodoc ([\w.]+): ([\w, ]+) -->", autodoc, text)
    text = text.replace("<!-- toctree -->", toctrees(text))
    folder = (HERE / docname).parent  # a forge lists the folders that a page links to; a site has none
    links = re.compile(r"\[([^\]]+)\]\((\.\.?/[^)#]+)\)")
    source[0] = links.sub(lambda link: link[1] if (folder / link[2]).is_dir() else link[0], text)


def autodoc(match: re.Match) -> str:
    """Return the directives that show the docstrings of a module's names."""
    home, names = match[1], match[2].split(", ")
    module = __import__(home, fromlist=names)
    kinds = {name: "class" if isinstance(getattr(module, name), type) else "function" for name in names}
    blocks = []
    for name, kind in kinds.items():
        members = "   :members:\n" if kind == "class" else ""
        blocks.append(f".. auto{kind}:: {home}.{name}\n{members}")
    return "\n".join(["```{eval-rst}", *blocks, "```"])


def toctrees(text: str) -> str:
    """Return hidden tables of contents: the pages that the tables of a page begin with, a part for each heading."""
    found = []
    for part in re.split(r"^## ", text, flags=re.MULTILINE)[1:]:
        links = re.findall(r"^\| \[(.+?)\]\(([\w/-]+)\.md\)", part, re.MULTILINE)
        pages = [f"{title} <{page}>" for title, page in links]
        if any(page.startswith("paper/") for _, page in links):  # the others of that folder follow
            others = {f"paper/{page.stem}" for page in (HERE / "paper").glob("*.md")}
            pages += sorted(others - {page for _, page in links})
        if pages:
            options = [":hidden:", f":caption: {part.splitlines()[0]}"]
            found.append("\n".join(["```{toctree}", *options, "", *pages, "```"]))
    return "\n\n".join(found)


def describe_options(app, kind: str, name: str, made, options, lines: list[str]) -> None:
    """Add to an options class what its fields mean, with their defaults."""
    if not is_options(made):
        return
    hints = get_type_hints(made, include_extras=True)
    lines.append("")
    for field in dataclasses.fields(made):
        plain, about = get_args(hints[field.name])[:2]
        words = re.sub(r"`+([^`]+)`+", r"``\1``", about)
        choices = ", ".join(f"``{choice}``" for choice in get_args(plain) if isinstance(choice, str))
        lines.append(f"* ``{field.name}`` = ``{field.default!r}`` – {words}" + f" ({choices})" * bool(choices))
    lines.append("")


def shorten_signature(app, kind: str, name: str, made, options, signature, returned):
    """Leave the fields of an options class to the list below it."""
    return ("(**fields)", returned) if is_options(made) else None


def is_options(made) -> bool:
    """Return whether this is a class of options, whose fields tell what they are."""
    if not (isinstance(made, type) and dataclasses.is_dataclass(made)):
        return False
    return any(get_origin(hint) is Annotated for hint in get_type_hints(made, include_extras=True).values())


def keep_flags_whole(app, page: str, template: str, context: dict, doctree) -> None:
    """Mark flags, in text and in commands, so that no line ends within one."""
    if "body" in context:
        flag = re.compile(r"(?<=[\s>])(--?[a-z][\w-]*)(?=[\s<])")
        commands = re.compile(r'(<div class="highlight-(?:sh|console).*?</pre>|<code [^>]*>.*?</code>)', re.DOTALL)
        mark = r'<span class="whole">\1</span>'
        context["body"] = commands.sub(lambda code: flag.sub(mark, code[1]), context["body"])


def setup(app) -> dict:
    """Join Sphinx."""
    app.connect("html-page-context", keep_flags_whole)
    app.connect("source-read", expand_comments)
    app.connect("autodoc-process-docstring", describe_options)
    app.connect("autodoc-process-signature", shorten_signature)
    return {"parallel_read_safe": True}
