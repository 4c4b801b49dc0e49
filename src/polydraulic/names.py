"""Names that other programs can take: what a text file, a table, XML and a compiler carry from one to the next."""

import re

from polydraulic.errors import InputError

# Controls but tabs and line ends, separators of lines, marks that turn the direction of reading, halves of characters, and what
# Unicode keeps from being characters.
_STRANGE = re.compile(
    r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff\ufdd0-\ufdef\ufffe\uffff]"
)


def checked_text(text: str, what: str) -> str:
    """`text` if it can stand in a file; `what` says in the error whose it is.

    Raises
    ------
    InputError
        If it is not a string, or holds a control character, a lone surrogate, or a noncharacter.
    """
    if not isinstance(text, str):
        raise InputError(f"{what} {text!r}: must be a string")
    if found := _STRANGE.search(text):
        raise InputError(
            f"{what} {text!r}: holds the character {found[0]!r}, which files and other programs do not take: rename it"
        )
    return text


def checked_name(name: str, what: str) -> str:
    """As `checked_text`, and not blank.

    Raises
    ------
    InputError
        As `checked_text`, or if there is nothing to see in it.
    """
    if not checked_text(name, what).strip():
        raise InputError(f"{what} {name!r}: is blank: give it a name")
    return name
