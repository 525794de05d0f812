"""``polhode view``: a motion as one page that moves."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from polhode.common.errors import BadInput
from polhode.scenes import library
from polhode.verbs import plot
from polhode.verbs.options import whole, word
from polhode.verbs.terminal import DONE, print_json, refuse_two_on_stdout, say

HELP = "a motion as one animated HTML page that needs nothing else"


def options(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument(
        "what_of", type=word, metavar="SCENE|FILE", help="a case, a scene's path, or a table"
    )
    parser.add_argument(
        "-o", dest="file", type=word, required=True, metavar="FILE", help="the page: .html"
    )
    parser.add_argument("--end", metavar="T", help="show up to this time instead of the scene's")
    parser.add_argument(
        "--scene", type=word, metavar="SCENE", help="for a FILE: the scene that it belongs to"
    )
    plot.table_options(parser)
    parser.add_argument("--number", help="double (default), extended, quad or mp")
    parser.add_argument(
        "--digits", type=whole, help="digits wanted, by which the number type is chosen"
    )


def main(options: Namespace) -> int:
    """Make one page."""
    from polhode.common.files import called, check_writable, is_stdout, write_whole
    from polhode.figures import film
    from polhode.figures.canvas import canvas
    from polhode.figures.drawing import page_of

    path = Path(options.file)
    inputs = [library.path_of(name) for name in (options.what_of, options.scene) if name]
    if path.suffix.lower() in (*film.SUFFIXES, *canvas.SUFFIXES):
        what = "motion" if path.suffix.lower() in film.SUFFIXES else "W"
        meant = f"polhode plot {options.what_of} --what {what} -o {path}"
        raise BadInput(str(path), "-o", None, f"a name that ends in .html, or {meant}")
    check_writable(path, [".html"], inputs)
    refuse_two_on_stdout(path, options.json)
    options.what = "motion"
    found = plot.samples_of(options)
    if isinstance(found, int):
        return found
    if plot.is_file(options.what_of):
        plot.warn_of_motion(found)
    command = f"polhode view {called(Path(options.what_of))}"
    text = page_of(found, command, plot.is_file(options.what_of))
    write_whole({path: text})
    t = found.columns["t"]
    if options.json:
        told = {"file": str(path), "of": found.name, "samples": len(t), "bytes": len(text.encode())}
        print_json(told | {"from": float(t[0]), "to": float(t[-1])})
    elif not is_stdout(path):
        say(str(path))
    return DONE
