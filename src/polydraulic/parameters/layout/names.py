"""What links, functions and circuits may be called: their names become names of Python and of C, and of columns."""

import keyword
import re

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
_C_WORDS = frozenset(
    "alignas alignof auto bool break case catch char char8_t char16_t char32_t class compl concept const consteval constexpr "
    "constinit const_cast continue co_await co_return co_yield decltype default delete do double dynamic_cast else enum "
    "explicit export extern false float for friend goto if inline int long mutable namespace new noexcept nullptr operator "
    "or private protected public register reinterpret_cast requires restrict return short signed sizeof static "
    "static_assert static_cast struct switch template this thread_local throw true try typedef typeid typename typeof "
    "union unsigned using virtual void volatile wchar_t while xor and not bitand bitor and_eq not_eq or_eq xor_eq "
    "asm fortran complex imaginary linux unix".split()
)
_COLUMNS = frozenset("time effector ground voltage spool angle rate".split())


def name_trouble(name: object) -> str:
    """Say why something cannot be a name of a link, function or circuit; nothing if it can."""
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        return "must be 1 to 40 ASCII letters, digits and underscores, beginning with a letter"
    if "__" in name or name.endswith("_"):
        return "must not hold two underscores in a row, nor end with one"
    if keyword.iskeyword(name) or keyword.issoftkeyword(name):
        return "is a word of Python"
    if name.lower() in _C_WORDS:
        return "is a word of C or C++"
    if name.lower() in _COLUMNS:
        return "is the name of a column or of the ground"
    return ""
