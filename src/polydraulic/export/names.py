"""One rule for the names of what is exported: an identifier that C, C++, Python and file systems leave to us.

`c_name` keeps a name where it can. Signs that no identifier has become underscores; a word that is taken gets an underscore behind it:
keywords, what the libraries of C and C++ declare, what Python has built in, and its modules (a file ``random.py`` would stand before
them); so does a name of a file that is taken. What begins otherwise than with a letter, or as the names do that exports give to parts of
their own, gets ``m_`` before it. Long names end in a digest instead.
"""

import builtins
import hashlib
import keyword
import re
import sys
from collections.abc import Sequence
from functools import cache
from importlib.resources import files

_KEYWORDS = (
    "alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl const constexpr continue decltype "
    "default delete do double dynamic_cast else enum explicit export extern false final float for friend goto if inline int long "
    "mutable namespace new noexcept not not_eq nullptr operator or or_eq override private protected public register "
    "reinterpret_cast restrict return short signed sizeof static static_assert static_cast struct switch template this "
    "thread_local throw true try typedef typeid typename union unsigned using virtual void volatile wchar_t while xor xor_eq "
    "concept requires consteval constinit const_cast co_await co_return co_yield char8_t char16_t char32_t typeof"
)
_ELSEWHERE = (
    "main near far huge small hyper interface pascal cdecl min max IN OUT OPTIONAL CONST VOID BOOL INT TRUE FALSE ERROR DELETE "  # of Windows
    "numpy scipy sympy mpmath onnx onnxruntime fmpy pandas matplotlib polydraulic "  # modules that run beside an exported one
    "clamp sigmoid ramp not_a_number minimum maximum"  # helpers of exported files
)
_OTHER_PRECISIONS = re.compile(r"\w+f(32|64|128)x?(_r)?")  # sinf32, lgammaf128_r: as the C library names its variants
_FILES = frozenset(  # without ending, in any case: headers, sources of an FMU, devices of Windows
    "assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg stdatomic stdbool "
    "stddef stdint stdio stdlib stdnoreturn string strings tgmath threads time uchar wchar wctype unistd malloc memory features "
    "pthread sched fcntl regex search values poll glob alloca semaphore syslog termios error getopt windows config equations "
    "con prn aux nul com1 com2 com3 com4 com5 com6 com7 com8 com9 lpt1 lpt2 lpt3 lpt4 lpt5 lpt6 lpt7 lpt8 lpt9".split()
)
_OWN = re.compile(  # what exported files call their own parts
    r"own|own_\w*|value_\d+_\d+(_slopes)?|(region|low|high|share|place|outside)_\d+|(?i:fmu|fmu_\w*|fmi[23]?|fmi[23]?_\w*|fmi[23][a-z]\w*)"
)
_LONGEST = 63  # letters of which C99 promises that they count


def c_name(name: str) -> str:
    """An identifier that resembles `name` and is free in C, C++, Python and as the name of a file.

    Examples
    --------
    >>> [c_name(name) for name in ("boom.q_in", "lambda", "time", "3d", "p/bar")]
    ['boom_q_in', 'lambda_', 'time_', 'm_3d', 'p_bar']
    """
    text = re.sub(r"\W", "_", name, flags=re.ASCII)
    if not re.match(r"[A-Za-z]", text) or _OWN.fullmatch(text):
        text = f"m_{text}"
    if len(text) > _LONGEST:
        text = f"{text[: _LONGEST - 9]}_{hashlib.sha256(name.encode(errors='surrogatepass')).hexdigest()[:8]}"
    while text in _taken() or text.lower() in _FILES or _OTHER_PRECISIONS.fullmatch(text):
        text += "_"
    return text


def unique_names(names: Sequence[str]) -> list[str]:
    """Identifiers for `names`, numbered where two would be the same or differ in case alone."""
    found: list[str] = []
    for name in names:
        start = c_name(name)
        text, number = start, 2
        while text.upper() in (other.upper() for other in found):
            text, number = c_name(f"{start}_{number}"), number + 1
        found.append(text)
    return found


@cache
def _taken() -> frozenset[str]:
    """Words that mean something already."""
    libraries = files(__package__).joinpath("library_names.txt").read_text(encoding="utf-8")
    words = " ".join([_KEYWORDS, _ELSEWHERE, libraries]).split()
    return frozenset([*words, *keyword.kwlist, *keyword.softkwlist, *dir(builtins), *sys.stdlib_module_names])
