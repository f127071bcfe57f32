"""Tables of settings as TOML, whose first line is a checksum of the others."""

import zlib
from pathlib import Path

from warpfluid.files.atomic import replacing

HEAD = "# crc32 of the lines below: "


def write_table(path: str | Path, document: dict) -> None:
    """Write a document.

    Raises:
        OSError: If the file cannot be written.
    """
    import tomli_w

    text = tomli_w.dumps(document).encode()
    with replacing(path) as file:
        file.write(f"{HEAD}{zlib.crc32(text):08x}\n".encode() + text)


def check_table(path: str | Path) -> None:
    """Refuse a file whose checksum does not fit; one that has none is good.

    Raises:
        ValueError: If it does not.
        OSError: If the file cannot be read.
    """
    head, _, text = Path(path).read_bytes().partition(b"\n")
    if not text.strip():
        raise ValueError(f"{path} is empty or cut off: bring it back as it was, or begin anew with --overwrite")
    told = head.removeprefix(HEAD.encode())
    if told != head and told.removesuffix(b"\r") != f"{zlib.crc32(text):08x}".encode():
        raise ValueError(
            f"{path} was changed or is damaged, its checksum does not fit: bring it back as it was, "
            "or begin anew with --overwrite"
        )
