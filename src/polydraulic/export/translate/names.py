"""C names of functions, structs and constants: those of Python, unless they are private, taken or reserved."""

from collections.abc import Hashable

_KEYWORDS = frozenset(
    "auto break case char const continue default do double else enum extern float for goto if inline int long "
    "register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while "
    "bool true false".split()
)
_RESERVED = _KEYWORDS | frozenset(
    # math.h, with what systems add to it
    "acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh drem erf erfc exp exp10 exp2 expm1 fabs fdim "
    "finite floor fma fmax fmin fmod fpclassify frexp gamma hypot ilogb isfinite isinf isnan isnormal j0 j1 jn ldexp lgamma "
    "llrint llround log log10 log1p log2 logb lrint lround modf nan nearbyint nextafter nexttoward pow pow10 remainder "
    "remquo rint round scalb scalbln scalbn signbit signgam significand sin sincos sinh sqrt tan tanh tgamma trunc y0 y1 yn "
    # the rest of the C library that a file may see, macros of Windows
    "abs div index labs main memcpy memset remove rename signal time NULL HUGE_VAL INFINITY NAN near far min max small "
    # ours
    "minimum maximum minimum_int maximum_int bits_of from_bits".split()
)


def field_name(name: str) -> str:
    """C name of a field."""
    return f"{name}_" if name in _KEYWORDS else name


def local_name(name: str) -> str:
    """C name of a variable."""
    return f"{name}_" if name in _RESERVED else name


class Names:
    """Names at file level, each given once."""

    def __init__(self) -> None:
        self._given: dict[Hashable, str] = {}

    def of(self, key: Hashable, name: str, module: str) -> str:
        """Name of what `key` stands for; `module` goes before it where it is private, taken or reserved.

        Parameters
        ----------
        key : hashable
        name : str
            In Python; its case is kept.
        module : str
            Where it is defined.
        """
        if key in self._given:
            return self._given[key]
        taken = _RESERVED | set(self._given.values())
        bare, last = name.lstrip("_"), module.rsplit(".", 1)[-1]
        if bare.isupper():
            longer = f"{last.upper()}_{bare}"
        elif bare[0].isupper():
            longer = "".join(part.capitalize() for part in last.split("_")) + bare
        else:
            longer = f"{last}_{bare}"
        found = longer if name.startswith("_") or bare in taken else bare
        number = 2
        while found in taken:
            found, number = f"{longer}_{number}", number + 1
        self._given[key] = found
        return found

    def reserve(self, key: Hashable, name: str) -> str:
        """Give `key` a name that is chosen from outside."""
        self._given[key] = name
        return name

    def forget(self, key: Hashable) -> None:
        """Take a name back."""
        del self._given[key]
