"""A wrong value at any place of a certificate is one line that names the place, and exit code 2."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import polhode
from shared.tools import CHECKER, altered, python

STORED = Path(__file__).parents[2] / "cases" / "certificates"
#: JSON texts that are wrong wherever a certificate has a number, a list or an object.
WRONG = {
    "a word": '"x"',
    "nothing": "null",
    "a float": "1.5",
    "not a number": "NaN",
    "truth": "true",
    "an empty object": "{}",
    "an empty list": "[]",
    "a list in a list": "[[]]",
    "deep nesting": "[" * 400 + "]" * 400,
    "a division by zero": '"1/0"',
    "a large exponent": '"1e99999"',
    "a long number": "1" * 30_000,
    "a long text": '"' + "7" * 100_000 + '"',
}
PARTS = ("charts", "sets", "transits")  # of which a certificate of chaos needs two
#: These two where most places are those of another certificate, too.
FEW = ("nothing", "an empty list")


@pytest.fixture(autouse=True)
def _lowest_limit_of_digits():
    """Python's own limit for the conversion of integers, as low as it may be set."""
    before = sys.get_int_max_str_digits()
    sys.set_int_max_str_digits(640)
    yield
    sys.set_int_max_str_digits(before)


@pytest.fixture(scope="module")
def certificates(tmp_path_factory):
    """Of states, with their attitude too; in other axes; of an orbit, stability, chaos."""
    path = tmp_path_factory.mktemp("certificates") / "attitude.json"
    scene = replace(polhode.load("general/asymmetric-regular"), outputs=("attitude",))
    polhode.certify(scene, at=["1/2", 1], digits=16).save(path)
    files = {word: STORED / f"{word}.json" for word in ("turned-axes", "elliptic", "chaos")}
    files["stability"] = STORED / "grioli-stability.json"
    files["attitude"] = path
    documents = {word: json.loads(file.read_text()) for word, file in files.items()}
    documents["chaos"] |= {key: documents["chaos"][key][:2] for key in PARTS}
    return documents


def places(value, at=()):
    """The path of each part of a JSON value."""
    if at:
        yield at
    if isinstance(value, (dict, list)):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from places(value[key], (*at, key))


def samples(certificate):
    """The first and the last path of each form: elements of one list are alike."""
    forms = {}
    for at in places(certificate):
        forms.setdefault(tuple("" if isinstance(key, int) else key for key in at), []).append(at)
    return [at for paths in forms.values() for at in sorted({paths[0], paths[-1]}, key=repr)]


def changed(certificate, at, text):
    """The certificate's bytes with another text at a place."""
    parent = certificate
    for key in at[:-1]:
        parent = parent[key]
    value, parent[at[-1]] = parent[at[-1]], "\0"
    try:
        return json.dumps(certificate).replace(json.dumps("\0"), text).encode()
    finally:
        parent[at[-1]] = value


def named(at):
    """A path as the checker writes it: ``statement[0].balls``."""
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in at)[1:]


@pytest.mark.slow
@pytest.mark.parametrize("word", ["turned-axes", "elliptic", "stability", "attitude", "chaos"])
def test_a_wrong_value_at_any_place_is_told_with_its_place(word, certificates, tmp_path):
    certificate, path, tried = certificates[word], tmp_path / "x.json", 0
    for at in samples(certificate):
        if at == ("format",):
            continue
        for wrong in WRONG if word in ("turned-axes", "elliptic") else FEW:
            text = WRONG[wrong]
            if (at[-1], text) == ("least", "true"):  # which is what may stand there
                continue
            path.write_bytes(changed(certificate, at, text))
            with pytest.raises(polhode.BadInput) as fault:
                polhode.verify(path)
            assert "\n" not in str(fault.value)
            line = str(fault.value).partition("expected one of polhode's (")[2]
            assert 0 < len(line) < 150
            # the place itself, a part of it, or the list or object that it belongs to
            assert line.startswith((named(at), named(at[:-1]) or at[0])), (at, wrong, line)
            tried += 1
    assert tried > 50


def test_the_file_alone_says_so_with_exit_code_2(certificates, tmp_path):
    path = tmp_path / "x.json"
    path.write_bytes(changed(certificates["turned-axes"], ("grid", 0), WRONG["a long number"]))
    process = python("-I", str(CHECKER), str(path))
    assert (process.returncode, process.stdout) == (2, "")
    expected = "grid[0]: expected a whole number of at most 20000 bits"
    assert process.stderr == f"{path}: no certificate: {expected}\n"


def test_a_weight_of_thousands_of_digits_is_printed(certificates, tmp_path):
    """Python's limit would stop it; the centre is as much nearer, so that the body is the same."""
    path, zeros = tmp_path / "x.json", "0" * 5500
    nearer = altered(
        certificates["elliptic"], "scene centre", lambda centre: [x + zeros for x in centre]
    )
    path.write_bytes(changed(nearer, ("scene", "weight"), f"1{zeros}"))
    verdict = polhode.verify(path)
    assert verdict.proved
    assert f"weight 1{zeros}," in verdict.text
