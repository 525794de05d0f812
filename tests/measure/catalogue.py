"""Write cases/catalogue.json, which ``polhode list`` reads: python tests/measure/catalogue.py."""

from __future__ import annotations

from polhode.output.cases import entry_of
from polhode.scenes import library

if __name__ == "__main__":
    text = library.written({name: entry_of(name) for name in library.names()})
    (library.folder() / library.FILE).write_text(text, "utf-8")
