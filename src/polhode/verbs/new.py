"""``polhode new``: a commented scene file to begin with."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from polhode.common.errors import BadInput, one_line
from polhode.output import new_scene
from polhode.scenes import library, scene_file
from polhode.verbs.options import word
from polhode.verbs.terminal import DONE, print_json, refuse_two_on_stdout, say

_TILT, _SPIN, _END = "30 deg", "3000 rpm", "1 s"


def add_new(parser: ArgumentParser) -> None:
    """The verb's own options."""
    parser.add_argument("file", type=word, metavar="FILE", help="the new scene: .toml")
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--like", type=word, metavar="SCENE", help="a case that ships, or a path")
    for name, shape in new_scene.SHAPES.items():
        listed = ",".join(shape.numbers).upper()
        text = f'{shape.meaning}; numbers in SI or with units, as "3 cm"'
        group.add_argument(f"--{name}", metavar=listed, help=text)
    tilt = f"angle of the axis to the vertical ({_TILT})"
    parser.add_argument("--tilt", metavar="ANGLE", help=tilt)
    parser.add_argument("--spin", metavar="RATE", help=f"rate about the axis ({_SPIN})")
    parser.add_argument("--end", metavar="T", help=f"last time ({_END})")


def new(options: Namespace) -> int:
    """Write one file."""
    from polhode.common.files import check_writable, is_stdout, write_whole

    path = Path(options.file)
    like = None if options.like is None else library.path_of(options.like)
    if options.file in new_scene.SHAPES:
        numbers = ",".join(new_scene.SHAPES[options.file].numbers).upper()
        meant = f"a file's name: polhode new {options.file}.toml --{options.file} {numbers}"
        raise BadInput("new", "FILE", options.file, meant)
    if library.ships(options.file):
        meant = f"a file's name: polhode new FILE.toml --like {options.file}"
        raise BadInput("new", "FILE", options.file, meant)
    check_writable(path, [".toml"], [like])
    refuse_two_on_stdout(path, options.json)
    if path.exists() and not is_stdout(path):
        raise BadInput("new", "FILE", options.file, "a file that does not exist yet")
    text = _of_case(options) if options.like else _of_shape(options)
    scene = scene_file.parse(text, options.file)
    write_whole({path: text})
    if options.json:
        print_json({"file": str(path), "title": scene.title, "units": scene.units})
    elif not is_stdout(path):
        say(f"{path}: {one_line(scene.title)}")
        say(f"next: polhode run {path} -o {path.stem}.csv")
        say(f"      polhode view {path} -o {path.stem}.html")
    return DONE


def _of_case(options: Namespace) -> str:
    for name in ("tilt", "spin", "end"):
        if getattr(options, name) is not None:
            expected = "no value together with --like: change it in the file"
            raise BadInput("new", f"--{name}", getattr(options, name), expected)
    return new_scene.commented(library.load(options.like).source, options.file)


def _of_shape(options: Namespace) -> str:
    chosen = [name for name in new_scene.SHAPES if getattr(options, name) is not None]
    name = chosen[0] if chosen else "cone"
    numbers = getattr(options, name).split(",") if chosen else ["3 cm", "5 cm", "50 g"]
    tilt, spin, end = (
        usual if (value := getattr(options, key)) is None else value
        for key, usual in (("tilt", _TILT), ("spin", _SPIN), ("end", _END))
    )
    return new_scene.of_shape(name, numbers, tilt, spin, end, options.file)
