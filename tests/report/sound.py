"""A page, read: its tags, checked to be balanced, its words, its pictures."""

import base64
import io
import re
from html.parser import HTMLParser

import numpy as np
from PIL import Image

VOID = {"meta", "img", "br", "hr"}


class Page(HTMLParser):
    """The tags of a page, checked to be balanced."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.tags, self.words = [], [], []
        self.feed(text)
        self.close()
        assert not self.open, f"never closed: {self.open}"

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)

    def images(self):
        """The decoded pictures of the page, by their alternative text."""
        pictures = {}
        for tag, attrs in self.tags:
            if tag == "img":
                kind, data = re.fullmatch(r"data:image/(\w+);base64,([\w+/=]+)", attrs["src"]).groups()
                with Image.open(io.BytesIO(base64.b64decode(data))) as picture:
                    assert picture.format.lower() == kind
                    frames = []
                    for i in range(getattr(picture, "n_frames", 1)):
                        picture.seek(i)
                        frames.append(np.array(picture))
                pictures[attrs["alt"]] = frames
        return pictures
