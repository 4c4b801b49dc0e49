"""Valid files made hostile, one small change after the other, by a seed."""

import json
import re
import struct
import zlib

HOSTILE = ["1e308", "-1e308", "1e400", "nan", "-inf", "-1", "0", "-0.0", "1e-320", "0.5", "2147483648", "9223372036854775808", "9" * 400,
           "true", '""', '"x"', '"nan bar"', "[]", "{}", "null", "1979-05-27", "0x10", "[" * 60, '"\\ud800"', '"' + "m" * 3000 + '"']  # fmt: skip
VALUES = [1e308, -1e308, float("nan"), float("inf"), -1, 0, -0.0, 1e-320, 0.5, 2**31, 2**63, int("9" * 400), True, None, "", "x", [], {},
          [[]], "\ud800", "m" * 3000, [0.0] * 5000]  # fmt: skip
NUMBER = re.compile(rb"(?<![\w.])[-+]?\d[\d.]*(?:[eE][-+]?\d+)?")
WORD = re.compile(rb"[A-Za-z_][A-Za-z_0-9]*")
WHOLE = [0, 1, 2**7, 2**31 - 1, 2**31, 2**32 - 1, 2**62, 2**63 - 1, 2**63, 2**64 - 1]
AT_MOST = 1 << 20  # bytes of a file that is made


def damaged(content, rng):
    """Bytes of any file: flipped, overwritten, cut off, cut out, repeated, exchanged, filled in."""
    content = bytearray(content)
    for _ in range(rng.choice([1, 1, 1, 2, 5])):
        n = len(content)
        if not n:
            break
        at, size = rng.randrange(n), rng.choice([1, 2, 8, 64, 512])
        kind = rng.randrange(8)
        if kind == 0:
            content[at] ^= 1 << rng.randrange(8)
        elif kind == 1:
            content[at : at + size] = bytes([rng.choice([0, 255, 128, 10])]) * min(size, n - at)
        elif kind == 2:
            content[at : at + size] = rng.randbytes(min(size, n - at))
        elif kind == 3:
            del content[at:]
        elif kind == 4:
            del content[at : at + size]
        elif kind == 5:
            content[at:at] = content[at : at + size] * rng.choice([1, 2, 100])
        elif kind == 6:
            width, other = rng.choice([4, 8]), rng.randrange(n)
            word = (rng.choice(WHOLE) % (1 << 8 * width)).to_bytes(width, "little")
            content[at : at + width] = rng.choice([word, content[other : other + width]])[: n - at]
        else:
            other = rng.randrange(n)
            content[at : at + size], content[other : other + size] = (
                content[other : other + size],
                content[at : at + size],
            )
    return bytes(content[:AT_MOST])


def misspelt(content, rng):
    """Texts: numbers replaced, names changed, lines removed, repeated, exchanged."""
    for _ in range(rng.choice([1, 1, 2, 4])):
        lines = content.split(b"\n")
        at, kind = rng.randrange(len(lines)), rng.randrange(8)
        if kind <= 2:
            content = _one(NUMBER, content, rng, lambda m: rng.choice(HOSTILE).encode())
            continue
        if kind == 3:
            content = _one(WORD, content, rng, lambda m: rng.choice([m + m, m[:-1], b"x", m.upper(), b"\xff" + m]))
            continue
        if kind == 4:
            del lines[at]
        elif kind == 5:
            lines[at:at] = [lines[at]] * rng.choice([1, 1, 50])
        elif kind == 6:
            other = rng.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
        else:
            lines[at] = re.sub(rb"=.*", lambda m: b"= " + rng.choice(HOSTILE).encode(), lines[at])
        content = b"\n".join(lines)
    return content[:AT_MOST]


def _one(pattern, content, rng, change):
    found = list(pattern.finditer(content))
    if not found:
        return content
    match = rng.choice(found)
    return content[: match.start()] + change(match[0]) + content[match.end() :]


def reshaped(content, rng):
    """JSON: keys removed, renamed and added, values of other kinds, lists longer and shorter."""
    tree = json.loads(content)
    for _ in range(rng.choice([1, 1, 2])):
        places = [(tree, key) for key in _keys(tree)]
        for parent, key in places:  # grows
            places += [(parent[key], inner) for inner in _keys(parent[key])]
        if not places:
            break
        parent, key = rng.choice(places)
        kind = rng.randrange(5)
        if kind == 0:
            del parent[key]
        elif kind == 1 and isinstance(parent, dict):
            parent[rng.choice([key + "_", key.upper(), ""])] = parent.pop(key)
        elif kind == 2 and isinstance(parent, list):
            parent[key:key] = [parent[key]] * rng.choice([1, 3])
        elif kind == 3 and isinstance(parent[key], int | float):
            parent[key] = rng.choice([-parent[key], parent[key] * 1e200, parent[key] + 1, str(parent[key])])
        else:
            parent[key] = rng.choice(VALUES)
    return json.dumps(tree).encode()


def _keys(item):
    return list(item) if isinstance(item, dict) else list(range(len(item))) if isinstance(item, list) else []


def repacked(content, rng):
    """BLF: the objects of a container damaged, packed, and put in place of it."""
    begins = [m.start() for m in re.finditer(rb"LOBJ.{8}\x0a\0\0\0", content, re.DOTALL)]
    at = rng.choice(begins)
    (size,) = struct.unpack_from("<L", content, at + 8)
    inside = damaged(content[at + 32 : at + size], rng)
    packed = zlib.compress(inside)
    said, whole = rng.choice([len(inside), len(inside), *WHOLE]) % (1 << 32), 32 + len(packed)
    head = struct.pack("<4sHHLLH6xL4x", b"LOBJ", 16, 1, whole, 10, 2, said)
    return (content[:at] + head + packed + bytes(whole % 4) + content[at + size + size % 4 :])[:AT_MOST]
