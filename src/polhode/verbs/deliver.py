"""One way for every result to leave a verb: files, JSON or a terminal; notes; the exit code."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common.errors import BadInput
from polhode.common.files import check_writable, is_stdout, is_stream, write_stdout, write_whole
from polhode.verbs import options, scene_options
from polhode.verbs.catalogue import Verb
from polhode.verbs.terminal import (
    DONE,
    FAILED,
    INTERRUPTED,
    NOT_REACHED,
    NotEnough,
    ProgressLine,
    note,
    say,
)

if TYPE_CHECKING:
    from polhode.results.result import Result

_DATA = (".csv", ".json", ".npz", ".parquet")
_FIGURES = (".svg", ".png", ".pdf")


def add_options(parser: ArgumentParser, verb: Verb) -> None:
    """The options of a verb: its function's, those of its scene, its files."""
    function = options.front(verb.home, verb.function)
    options.add(parser, function, verb.named)
    scene_options.add(parser, verb.scene)
    for option, how in (verb.figure_options or {}).items():
        parser.add_argument(option, **how)
    endings = f"{', '.join(_endings(verb))}; may be repeated"
    if any(x.name == "parts" for x in function.parameters):
        endings += "; what was interrupted continues from FILE.parts"
    told = f"write a file, its ending says what: {endings}"
    parser.add_argument(
        "-o", dest="places", type=options.word, metavar="FILE", action="append", help=told
    )
    parser.set_defaults(main=partial(main, verb, function))


def _endings(verb: Verb) -> Sequence[str]:
    own = (verb.own,) if verb.own and verb.own not in _DATA else ()
    return [*own, *_DATA, *(() if verb.figure_options is None else _FIGURES)]


def main(verb: Verb, function: options.Front, asked: Namespace) -> int:
    """Carry out a verb that is a function; the exit code."""
    from polhode.proofs.refusals import NotProved
    from polhode.scenes import library, start_box
    from polhode.scenes.start_box import StartBox
    from polhode.verbs import notes

    given = {
        x.name: vars(asked)[x.name]
        for x in function.parameters
        if verb.named.get(x.name, x.name) is not None and vars(asked).get(x.name) is not None
    }
    inputs = [library.path_of(x) for x in _sources(given)]
    others = [kind for name, kind in verb.other_kinds.items() if name in given]
    kind = others[0] if others else verb.kind
    places = Places(verb, kind, [*map(Path, asked.places or ())], asked.json, inputs)
    places.check()
    places.check_figure(vars(asked))
    if verb.scene:
        first = function.parameters[0].name
        box = start_box.read(given[first]) if verb.is_box else StartBox(library.load(given[first]))
        scene = scene_options.applied(asked, box.scene, verb.scene)
        given[first] = StartBox(scene, box.radii) if verb.is_box else scene
    with ProgressLine(verb.name) as line:
        try:
            made = import_module(verb.home)
            given |= places.told(function, line)
            try:
                found, missed = getattr(made, verb.function)(**given), ""
            except NotEnough as fault:
                found, missed = fault.found, str(fault)
            places.write(found, vars(asked), line)
            text = None if asked.json or places.paths else shown(found, given.get("details", False))
        except NotProved as why:
            line.clear()
            note(f"polhode: not proved: {why}")
            return NOT_REACHED
    if asked.json:
        write_stdout(found.to_json())
    elif text is not None:
        say(text)
    for told in notes.of(verb.name, found, places.paths, asked):
        note(told)
    if missed:
        note(missed)
        return NOT_REACHED
    return code_of(found)


def _sources(given: Mapping[str, object]) -> Iterable[str]:
    """What may be a file that is read."""
    for value in given.values():
        yield from (x for x in (value if isinstance(value, list) else [value]) if type(x) is str)


class Places:
    """The files that a verb is to write."""

    def __init__(
        self,
        verb: Verb,
        kind: str,
        paths: Sequence[Path],
        json: bool,
        inputs: Sequence[Path | None],
    ) -> None:
        self.verb, self.kind, self.paths, self.json, self.inputs = verb, kind, paths, json, inputs

    def check(self) -> None:
        """Refuse, before any work is done, what cannot or must not be written; raises BadInput."""
        streams = [path for path in self.paths if is_stdout(path)]
        if streams and self.json:
            expected = "a file: the results as JSON go to stdout"
            raise BadInput(str(streams[0]), "-o", None, expected)
        if len({path.absolute() for path in self.paths}) < len(self.paths) or len(streams) > 1:
            raise BadInput(str(self.paths[-1]), "-o", None, "each file once")
        for path in self.paths:
            check_writable(path, _endings(self.verb), self.inputs)
            if self._is_figure(path):
                from polhode.figures.canvas import canvas

                canvas.require()
            elif self._is_own(path):
                if path.suffix != ".toml":
                    from polhode.certificates import certificate_file
                    from polhode.results.places import refuse_facts

                    certificate_file.refuse_another(path)
                    refuse_facts(path)
            else:
                from polhode.results.places import check_place

                check_place(path, self.kind, self.inputs)

    def check_figure(self, asked: Mapping[str, Any]) -> None:
        """Refuse options of a figure where none is written, and figures that there are not."""
        given = {x: asked[x] for x in _figure_options(self.verb) if asked[x] is not None}
        if not any(map(self._is_figure, self.paths)):
            for name, value in given.items():
                option = f"--{name.replace('_', '-')}"
                expected = f"it with a figure: -o FILE{_FIGURES[0]}"
                raise BadInput(self.verb.name, option, value, expected)
        elif "what" in given:
            from polhode.figures import catalogue

            catalogue.chosen(self.verb.kind, given["what"], self.verb.name)

    def told(self, function: options.Front, line: ProgressLine) -> dict[str, object]:
        """What a function takes that no option says: how it tells its progress, what it is for.

        Unfinished work is kept in ``parts`` beside the first file of data.
        """
        show = partial(line.show, what=self.verb.counts)
        calls = {
            "Progress": show,
            "Progress | bool": show,
            "Message": line.say,
            "ProgressLine": line,
        }
        found = {x.name: calls[x.annotation] for x in function.parameters if x.annotation in calls}
        names = {x.name for x in function.parameters}
        if "certificate" in names:
            found["certificate"] = any(map(self._is_own, self.paths))
        data = [x for x in self.paths if not self._is_figure(x)]
        if "parts" in names and data:
            from polhode.common import checkpoint

            found["parts"] = checkpoint.beside(data[0])
        return found

    def write(self, found: Result, asked: Mapping[str, Any], line: ProgressLine) -> None:
        """Write all files or none; none where what was interrupted is kept in parts, which go else.

        Files of a kind's own, which are checked as they are made, are written once all others are
        made.
        """
        kept = getattr(found, "kept", None)
        if interrupted(found) and kept is not None and kept.folder.exists():
            return
        made: dict[Path, str | bytes] = {}
        for path in self.paths:
            if self._is_figure(path):
                made[path] = _drawn(found, path.suffix.lower(), self.verb, asked)
            elif not self._is_own(path):
                from polhode.results import places, writer

                content = found.content()
                places.check_place(path, content.kind, self.inputs)
                made |= writer.files(content, path)
        for path in filter(self._is_own, self.paths):
            if getattr(found, "times", True):  # of nothing there is no certificate
                self._save(found, path, line)
        write_whole(made)
        if kept is not None:
            kept.remove()

    def _save(self, found: Any, path: Path, line: ProgressLine) -> None:
        """Write a file of the kind's own: a scene, a certificate."""
        if self.verb.checks:
            found.save(path, line.foretelling(partial(_foretell, found.scene.name)))
        else:
            found.save(path)

    def _is_figure(self, path: Path) -> bool:
        return path.suffix.lower() in _FIGURES

    def _is_own(self, path: Path) -> bool:
        suffix = path.suffix.lower()
        stream = is_stream(path) and suffix not in _DATA
        return bool(self.verb.own) and (suffix == self.verb.own or stream)


def _foretell(name: str, seconds: float) -> None:
    if seconds > 10:
        note(f"{name}: making the certificate will take about {seconds:.2g} s")


def _drawn(found: Result, suffix: str, verb: Verb, asked: Mapping[str, Any]) -> bytes:
    """The figure of a result; of a run its scene's, integrated at as many times as curves need."""
    from polhode.figures import catalogue
    from polhode.figures.source import Asked, shown
    from polhode.verbs.notes import name_of

    seen = shown(found, asked.get("what"), Asked())
    for told in seen.notes:
        note(told)
    given = {name: asked.get(name) for name in _figure_options(verb) if name != "what"}
    return catalogue.drawn(seen.found, suffix, name_of(found), seen.what, **given)


def _figure_options(verb: Verb) -> Sequence[str]:
    """The options of a verb's figures, by the names of the parameters of what draws."""
    return [option.removeprefix("--").replace("-", "_") for option in verb.figure_options or ()]


def shown(found: Any, details: bool = False) -> str:
    """A result on a terminal: its report, where it has one, else its table.

    ``details``: whether all that is known is asked for.
    """
    from polhode.results.result import Result as Base
    from polhode.results.shown import lines

    if details:
        return str(found.details())
    report = type(found).__str__
    if report not in (object.__str__, getattr(Base, "__str__", None)):
        return str(found)
    return "\n".join(lines(found.table()))


def interrupted(found: Result) -> bool:
    """Whether Ctrl-C ended the work."""
    return bool(getattr(found, "interrupted", False))


def code_of(found: Result) -> int:
    """The exit code that a result means."""
    if interrupted(found):
        kept = getattr(found, "kept", None)
        if kept is not None and kept.folder.exists():
            note(f"polhode: the same command continues from {kept.folder}")
        return INTERRUPTED
    if getattr(found, "passed", None) is False:
        return FAILED
    return DONE if getattr(found, "complete", True) else NOT_REACHED
