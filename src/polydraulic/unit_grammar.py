"""The grammar of units as texts: names with powers up to four, products, quotients and brackets, at most 60 characters.

What it lets through is bounded, whoever wrote the text: so many names, so high powers, brackets so deep. It knows no unit.
"""

import re
import unicodedata
from collections.abc import Callable

LONGEST, DEEPEST, MOST_NAMES = 60, 3, 8  # characters, nested brackets, names of one unit


class UnknownError(Exception):
    """Why a text is no unit; empty if there is no more to say."""


# Signs that mean the same, after compatibility forms (superscripts, full width, the sign of ohm) have become plain ones.
_SIGNS = str.maketrans({**dict.fromkeys("·⋅∙•×", "*"), **dict.fromkeys("−–", "-"), **dict.fromkeys("∕⁄÷", "/"),
    "μ": "u", "Ω": "Ohm", "Δ": "delta_", "[": "(", "]": ")"})  # fmt: skip
_PHRASES: tuple[tuple[re.Pattern[str], str | Callable[[re.Match[str]], str]], ...] = tuple(
    (re.compile(pattern, re.IGNORECASE), said)
    for pattern, said in (
        (r"\bC ?°", "degC"),
        (r"(?:°|\b(?:deg(?:rees?)?|grad)\.?|\bo)[ _]?([CFK])(?:elsius|ahrenheit|elvin)?(?![a-z])", lambda m: f"deg{m[1].upper()}"),
        (r"\bdelta[ _-]*deg([CFK])\b", lambda m: f"delta_deg{m[1].upper()}"),
        (r"°", "deg"),
        (r"\b(?-i:g)_?(?-i:[0n])\b", "gn"),
        (r"\b(mm|cm|m|in)[ _]?H2O\b", r"\1WC"),
        (r"\b(?:uk|imp(?:erial|\.)?|i)[ _-]?(gpm|gal)\w*", r"imp_\1"),
        (r"\b(gpm|gal)(?:lons?)?[ _-]*\(?(?:uk|imp(?:erial|\.)?)\)?(?![a-z])", r"imp_\1"),
        (r"\bu\.?s\.?[ _-]?(gpm|gal)", r"\1"),
        (r"\b(gpm|gal)(?:lons?)?[ _-]*\(?u\.?s\.?\)?(?![a-z])", r"\1"),
        (r"\b(short|long|metric|us|uk)[ _-]tons?\b", r"\1_ton"),
        (r"\bmetric[ _-]?(?:hp|horsepower)\b|\bhp ?\((?:m|metric)\)", "metric_hp"),
        (r"\bhp ?\((?:i|mech(?:anical)?|imp(?:erial)?|uk|us)\)", "hp"),
        (r"\b(?:sq|square)[ _.-]*(in|inch|ft|foot|mm|cm|m)\b", r"\1^2"),
        (r"\b(?:cu|cubic)[ _.-]*(in|inch|ft|foot|mm|cm|m)\b", r"\1^3"),
        (r"([a-z])\.(?=$|[\s/)*])", r"\1"),
    )
)  # fmt: skip
_MARK = re.compile(
    r"(?P<unit>.+?)[\s_.,-]*(?:(?P<open>\()\s*)?"
    r"(?P<mark>gauge|gage|relative|rel\.?|absolute|abs\.?|differential|diff\.?|[gaüd])(?(open)\s*\))",
    re.IGNORECASE,
)
_TOKEN = re.compile(
    r"\s*(?:(?P<name>[A-Za-z_%‰]+)(?:\^?(?P<power>-?(?:[1-4](?:\.5)?|0\.5))(?![\d.]*\d)|\^\((?P<inner>-?[1-4])\))?"
    r"|(?P<sign>[*/().-])|(?P<one>1)(?![\d.])|(?P<end>$))"
)


def plain_text(text: str) -> str:
    """The text with one way to write each sign, and names of several words as one.

    Raises
    ------
    UnknownError
        A text that is too long.
    """
    if len(text) <= LONGEST:
        text = unicodedata.normalize("NFKC", text.replace("º", "°"))  # some signs become many
    if len(text) > LONGEST:
        raise UnknownError(f"longer than {LONGEST} characters")
    text = text.replace("**", "^").translate(_SIGNS)
    for pattern, said in _PHRASES:
        text = pattern.sub(said, text)
    text = text.strip()
    if text.startswith("(") and text.endswith(")") and text.find(")") > text.rfind("(", 0, -1):
        return text[1:-1].strip()
    return text


def split_mark(plain: str) -> tuple[str, str] | None:
    """A text that ends as pressures do that say what they are above, and ``"a"`` for absolute ones, ``"g"`` for others."""
    match = _MARK.fullmatch(plain)
    return None if match is None else (match["unit"], "a" if match["mark"].lower().startswith("a") else "g")


def names_of(plain: str) -> list[tuple[str, float]]:
    """Names with their powers, those divided by negative.

    Raises
    ------
    UnknownError
        A text that is none of the grammar.
    """
    tokens, place = [], 0
    while place < len(plain):
        match = _TOKEN.match(plain, place)
        if match is None:
            raise UnknownError(f"{plain[place:].strip()[:1]!r} has no place there")
        tokens.append(match)
        place = match.end()
    tokens = [token for token in tokens if token.lastgroup != "end"][::-1]  # to be taken from the end
    if len(tokens) > 1 and tokens[-1]["one"] and tokens[-2]["sign"] == "/":
        tokens.pop()  # the 1 of 1/min
    found = _product(tokens, 0)
    if tokens or len(found) > MOST_NAMES:
        raise UnknownError("brackets do not match, or there are too many names")
    return found


def _product(tokens: list[re.Match[str]], depth: int) -> list[tuple[str, float]]:
    found: list[tuple[str, float]] = []
    sign, divided, wanted = 1.0, False, not (tokens and depth == 0 and tokens[-1]["sign"] == "/")
    while tokens and tokens[-1]["sign"] != ")":
        token = tokens.pop()
        if token["one"]:
            raise UnknownError("a number has no place there")
        if token["sign"] and token["sign"] != "(":
            if wanted:
                raise UnknownError(f"a name is missing at {token['sign']!r}")
            sign, wanted = -1.0 if token["sign"] == "/" else 1.0, True
            continue
        if divided and sign > 0.0:
            raise UnknownError("put what is divided by in brackets, as in 'l/(min bar)'")
        if token["sign"]:
            part = _product(tokens, depth + 1) if depth < DEEPEST else []
            if not part or not tokens:
                raise UnknownError("brackets do not match, or are nested too deep")
            tokens.pop()
        else:
            part = [(token["name"], float(token["power"] or token["inner"] or 1.0))]
        found += [(name, sign * power) for name, power in part]
        divided, sign, wanted = divided or sign < 0.0, 1.0, False
    if wanted or not found:
        raise UnknownError("a name is missing")
    return found
