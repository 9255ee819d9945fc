"""Fields of named tuples, told by ``help``."""

from __future__ import annotations

import re
from typing import TypeVar

T = TypeVar("T")


def documented(kind: type[T]) -> type[T]:
    """Gives each field the words behind its name in the docstring of its class, as ```name``: words``."""
    for name, words in re.findall(r"^ *``(\w+)``: (.+(?:\n +(?! |``\w+``: ).+)*)", kind.__doc__ or "", re.M):
        vars(kind)[name].__doc__ = words[0].upper() + " ".join(words.split())[1:]
    return kind
