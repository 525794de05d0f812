"""``polhode plot`` and ``polhode view``: figures, films and pages of a motion, a result, a file."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from polhode.common.errors import BadInput
from polhode.scenes import library
from polhode.verbs import terminal
from polhode.verbs.options import whole, word

if TYPE_CHECKING:
    from polhode.figures.source import Drawing

PAGE, FILM, PRINTED = ".html", ".gif", (".svg", ".png", ".pdf")


def add_plot(parser: ArgumentParser) -> None:
    """The options of plot."""
    help_text = (
        "of a motion angles (default), omega, momentum, attitude, hodographs, sphere, integrals, "
        "error, or motion: a film; of a map fli (default), megno, exponent, verdict"
    )
    _add_source(parser, "source")
    parser.add_argument("--what", type=word, metavar="WORD", help=help_text)
    endings = f"the figure: {', '.join(PRINTED)}; of a motion that moves {FILM}"
    parser.add_argument("-o", dest="file", type=word, required=True, metavar="FILE", help=endings)
    parser.add_argument("--title", metavar="TEXT", help="in place of the figure's own")
    parser.add_argument("--cmap", metavar="NAME", help="matplotlib's colours of a map (viridis)")
    for axis in "fh":
        parser.add_argument(f"--{axis}-range", metavar="A:B", help=f"of levels: the {axis} shown")


def _add_source(parser: ArgumentParser, name: str, nargs: str | None = None) -> None:
    """What is drawn, and how: the fields of :class:`polhode.figures.source.Request`."""
    of = "a case, a scene's path, the file of a result, or a table"
    parser.add_argument(name, type=word, metavar="SCENE|FILE", help=of, nargs=nargs)
    parser.add_argument("--end", metavar="T", help="the last time, instead of the scene's end")
    scene = "for a FILE: the scene that it belongs to"
    parser.add_argument("--scene", type=word, metavar="SCENE", help=scene)
    number = "double (default), extended, quad or mp; for a FILE: that of its decimals"
    parser.add_argument("--number", help=number)
    digits = "digits wanted, by which the number type is chosen"
    parser.add_argument("--digits", type=whole, help=digits)
    read = "for a FILE: the conventions to read it in, as for compare: 'omega degrees'"
    parser.add_argument("--read", metavar="WORDS", help=read)
    columns = "for a FILE: its columns in order, t,qw,qx,...; or some: 'time_ms=t*1e-3, Q.W=q0'"
    parser.add_argument("--columns", metavar="NAMES", help=columns)


def plot(options: Namespace) -> int:
    """Make one figure."""
    suffix = Path(options.file).suffix.lower()
    options.sources, options.text = [options.source], None
    if suffix == PAGE:
        meant = f"polhode view {options.source} -o {options.file}, which makes pages"
        raise BadInput(options.file, "-o", None, meant)
    if options.what is None and suffix == FILM:
        options.what = "motion"
    if options.what == "motion":
        for option in ("title", "cmap", "f-range", "h-range"):
            if (value := getattr(options, option.replace("-", "_"))) is not None:
                raise BadInput("plot motion", f"--{option}", value, "none, for a film")
        return _written(options, (FILM,))
    if suffix == FILM:
        expected = f"a name that ends in {', '.join(PRINTED)}; --what motion makes a film"
        raise BadInput(options.file, "-o", None, expected)
    return _written(options, PRINTED)


def add_view(parser: ArgumentParser) -> None:
    """The options of view."""
    _add_source(parser, "sources", "+")
    page = "the page: .html"
    parser.add_argument("-o", dest="file", type=word, required=True, metavar="FILE", help=page)
    parser.add_argument("--title", metavar="TEXT", help="a heading above the motions")
    text = "words below the heading, with empty lines between paragraphs"
    parser.add_argument("--text", metavar="TEXT", help=text)
    parser.set_defaults(what="motion")


def view(options: Namespace) -> int:
    """Make one page."""
    suffix = Path(options.file).suffix.lower()
    if suffix in (FILM, *PRINTED):
        figure = "motion" if suffix == FILM else "W"
        meant = f"polhode plot {options.sources[0]} --what {figure} -o {options.file}"
        raise BadInput(options.file, "-o", None, f"a name that ends in .html, or {meant}")
    return _written(options, (PAGE,))


def _written(options: Namespace, endings: tuple[str, ...]) -> int:
    """Write one file of these endings."""
    from polhode.common.files import called, check_writable, is_stdout, write_whole
    from polhode.figures import canvas, catalogue, film
    from polhode.figures.source import Request, Unreached, drawing_of

    path = Path(options.file)
    inputs = [library.path_of(name) for name in (*options.sources, options.scene) if name]
    check_writable(path, endings, inputs)
    terminal.refuse_two_on_stdout(path, options.json)
    suffix = path.suffix.lower() if path.suffix.lower() in endings else endings[0]  # a stream
    if suffix != PAGE:
        canvas.pyplot()
    request = Request(**{name: getattr(options, name) for name in vars(Request())})
    with terminal.ProgressLine("plot") as progress:
        try:
            every = [
                drawing_of(source, options.what, request, progress.show)
                for source in options.sources
            ]
        except Unreached as why:
            progress.clear()
            terminal.note(f"polhode: {why}; nothing was written")
            return terminal.NOT_REACHED
        drawing, notes = every[0], [line for x in every for line in x.notes]
        answer = {"file": str(path), "what": drawing.what, "of": drawing.name} | _span(drawing)
        if suffix == PAGE:
            command = ("polhode", options.verb, *(called(Path(x)) for x in options.sources))
            data = _page(every, " ".join(command), options).encode()
        elif suffix == FILM:
            filmed = film.filmed(drawing.motion, lambda share: progress.say(f"{100 * share:.0f} %"))
            data = filmed.data
            if filmed.closed:
                answer["to"] = filmed.end
                again = f"at t = {filmed.end:.6g} the motion is as at t = {filmed.begin:g}"
                end = f"to {film.CLOSED:.0e}: the film ends there, and repeats"
                notes.append(f"{drawing.name}: {again}, {end}")
        else:
            own = {name: getattr(options, name) for name in ("cmap", "f_range", "h_range")}
            own["title"] = options.title or ""
            data = catalogue.drawn(drawing.subject, suffix, drawing.name, drawing.what, **own)
        for line in notes:  # of a figure that there is: a refusal is one line
            terminal.note(line)
    write_whole({path: data})
    if options.json:
        terminal.print_json(answer | {"bytes": len(data)})
    elif not is_stdout(path):
        terminal.say(str(path))
    return terminal.DONE


def _page(every: Sequence[Drawing], command: str, options: Namespace) -> str:
    """The page of a motion; of several, or with words of one's own, one that has them in frames."""
    from polhode.common.texts import Page, together
    from polhode.figures.motion_page import page_of

    pages = [Page(drawing.name, page_of(drawing, command)) for drawing in every]
    return together(pages, options.title or "", options.text or "").text


def _span(drawing: Drawing) -> dict[str, float | int]:
    """How many samples of a motion are drawn, from when to when."""
    from polhode.figures.samples import Samples

    if not isinstance(drawing.subject, Samples):
        return {}
    t = drawing.subject.columns["t"]
    return {"samples": len(t), "from": float(t[0]), "to": float(t[-1])}
