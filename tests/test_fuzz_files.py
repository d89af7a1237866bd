"""Whatever stands in an STL or a CSV file: what it says, or one sentence, soon."""

import random
import struct

import numpy as np
import pytest
import trimesh

from refusals import sentence_of
from smoothprofile.config.files import read_bodies
from smoothprofile.triangles import load_surface

ODD_NUMBERS = (
    b"nan", b"inf", b"-inf", b"1e308", b"1e999", b"-1e-320", b"0", b"1" * 400, b"0x10", b"1_0",
    b"", b" ", b"--1", b"1,5", b'"', b'""', b"\xce\xbe", b"\xff\xfe", b"\x00", b"\xe2\x88\x921",
    "١".encode(), b"\r", b"#", b"1e", b"True",
)  # fmt: skip
ODD_COUNTS = (0, 1, 3, 5, 255, 10**7, 2**31 - 1, 2**31, 2**32 - 1)
CSV = b"x, y, z, radius, vx, vy, vz\n" + b"".join(
    b"%d.5, 2, 3e0, 0.5, 0, -1, .25\n" % n for n in range(6)
)


def solids():
    """A block and a pyramid, binary and ASCII."""
    block = trimesh.creation.box((2.0, 2.0, 2.0))
    pyramid = trimesh.Trimesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
    )
    found = []
    for mesh in (block, pyramid):
        text = mesh.export(file_type="stl_ascii")
        found += [mesh.export(file_type="stl"), text.encode() if isinstance(text, str) else text]
    return found


def damaged(content: bytes, choose: random.Random) -> bytes:
    """One to three things wrong: bits, bytes, lines, numbers, cut off, or twice there."""
    data = bytearray(content)
    for _ in range(choose.choice((1, 1, 2, 3))):
        kind, at = choose.randrange(9), choose.randrange(len(data) + 1)
        if kind == 0:
            del data[at:]
        elif kind == 1 and data:
            data[at % len(data)] ^= 1 << choose.randrange(8)
        elif kind == 2:
            data[at : at + choose.randint(0, 60)] = choose.randbytes(choose.randint(0, 60))
        elif kind == 3:
            data[at:at] = choose.choice(ODD_NUMBERS)
        elif kind == 4:
            data[80:84] = struct.pack("<I", choose.choice(ODD_COUNTS))
        elif kind == 5:
            number = choose.choice((np.nan, np.inf, 1e38, -1e-42, 0.0, 1e30))
            data[at : at + 4] = struct.pack("<f", number)
        elif kind == 6:
            words = bytes(data).split(b" ")
            words[choose.randrange(len(words))] = choose.choice(ODD_NUMBERS)
            data = bytearray(b" ".join(words))
        else:
            lines = bytes(data).split(b"\n")
            here = choose.randrange(len(lines))
            if kind == 7:
                del lines[here]
            else:
                lines[here:here] = lines[here : here + 1] * choose.choice((1, 2, 500))
            data = bytearray(b"\n".join(lines))
    return bytes(data)


def fuzz(tmp_path, name, contents, read, count, seed):
    """How many of `count` damaged files are refused."""
    choose, path, refused = random.Random(seed), tmp_path / name, 0
    for _ in range(count):
        content = damaged(choose.choice(contents), choose)
        path.write_bytes(content)
        try:
            sentence = sentence_of(lambda: read(path))
            refused += sentence is not None
            assert sentence is None or len(sentence) < 1000, sentence
        except Exception:
            print(repr(content[:3000]))
            raise
    return refused


def surfaces(tmp_path, count, seed):
    def read(path):
        load_surface(path, repair=count_of.pop() % 3 == 0)

    count_of = list(range(count))
    return fuzz(tmp_path, "body.stl", solids(), read, count, seed)


def bodies(tmp_path, count, seed):
    return fuzz(tmp_path, "bodies.csv", [CSV], lambda p: read_bodies(p, p.name), count, seed)


@pytest.fixture(autouse=True)
def few_nodes(monkeypatch):
    """Whole surfaces are sampled, on half a million nodes: that takes a third of a second each."""
    monkeypatch.setattr("smoothprofile.surfaces.NODES", 1000)


def test_damaged_surfaces_are_read_or_refused(tmp_path):
    assert 100 < surfaces(tmp_path, 200, 1) < 200


def test_damaged_tables_of_bodies_are_read_or_refused(tmp_path):
    assert 300 < bodies(tmp_path, 500, 1) < 500


@pytest.mark.slow
def test_five_thousand_damaged_surfaces_are_read_or_refused(tmp_path):
    refused = surfaces(tmp_path, 5000, 2)
    print(f"5000 surfaces, {refused} refused")
    assert refused > 2500


@pytest.mark.slow
def test_five_thousand_damaged_tables_of_bodies_are_read_or_refused(tmp_path):
    refused = bodies(tmp_path, 5000, 2)
    print(f"5000 tables, {refused} refused")
    assert refused > 2500


@pytest.mark.parametrize("count", [10**7, 2**32 - 1])
def test_a_header_that_claims_millions_of_triangles_is_refused_at_once(tmp_path, count):
    content = bytearray(solids()[0])
    content[80:84] = struct.pack("<I", count)
    (tmp_path / "body.stl").write_bytes(content)
    assert "not an STL file" in sentence_of(lambda: load_surface(tmp_path / "body.stl"))


@pytest.mark.parametrize("length", [1e5, 1e12, 1e30])
def test_needles_are_refused_at_once(tmp_path, length):
    """Their samples would be as many as their length in widths."""
    trimesh.creation.box((length, 1.0, 1.0)).export(tmp_path / "body.stl")
    assert sentence_of(lambda: load_surface(tmp_path / "body.stl"))


def test_tables_that_are_no_tables_are_refused(tmp_path):
    for content in (b"", b"\xef\xbb\xbf", b"\n" * 10_000, b"," * 10_000, b'"' * 999, b"\x00" * 99):
        (tmp_path / "bodies.csv").write_bytes(content)
        assert sentence_of(lambda: read_bodies(tmp_path / "bodies.csv", "bodies.csv"))
