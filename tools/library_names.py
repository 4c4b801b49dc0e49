"""Write `src/polydraulic/export/library_names.txt`: words that the C and C++ libraries of this machine leave to nobody else.

A word of their headers is one if a function of that name cannot be declared in C beside them, or if in C++, after ``using namespace
std``, it cannot be called or another one is called in its place. Tried with gcc and g++, so that no list is written by hand.
"""

import re
import subprocess
import textwrap
from pathlib import Path
from tempfile import TemporaryDirectory

C_HEADERS = (
    "assert complex ctype errno fcntl fenv float inttypes iso646 limits locale math pthread setjmp signal stdalign stdarg "
    "stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string strings sys/stat sys/time sys/types tgmath threads time "
    "uchar unistd wchar wctype"
).split()
ARGUMENTS = "(const double a_[2], double b_[1])"
KEYWORDS = frozenset(
    "asm auto break case catch char class const constexpr continue default delete do double else enum explicit export extern "
    "false float for friend goto if inline int long mutable namespace new operator private protected public register restrict "
    "return short signed sizeof static struct switch template this throw true try typedef typeid typename union unsigned using "
    "virtual void volatile wchar_t while".split()
)
_EXTENDED = re.compile(
    r"\w+f(32|64|128)x?(_r)?"
)  # functions of other precisions: `export.names` knows them by their endings
PLACE = Path(__file__).parents[1] / "src/polydraulic/export/library_names.txt"


def compiled(folder: Path, command: list[str], text: str, ending: str) -> subprocess.CompletedProcess[str]:
    """A compiler on a text."""
    (folder / f"t{ending}").write_text(text)
    return subprocess.run([*command, f"t{ending}"], cwd=folder, capture_output=True, text=True)


def refused(folder: Path, command: list[str], head: str, words: list[str], ending: str, line: str) -> set[str]:
    """Words for which `line` does not compile after `head`; again without them, for what is refused can hide what stands behind."""
    text = head + "".join(line.format(word=word, k=k) + "\n" for k, word in enumerate(words))
    done = compiled(folder, [*command, "-fsyntax-only", "-w", "-fmax-errors=0"], text, ending)
    numbers = {
        int(found) for found in re.findall(r"^t\.\w+:(\d+):(?:\d+:)? +(?:error|required from here)", done.stderr, re.M)
    }
    bad = {word for k, word in enumerate(words) if k + 1 + head.count("\n") in numbers}
    rest = [word for word in words if word not in bad]
    return bad | refused(folder, command, head, rest, ending, line) if bad else bad


def words_of(folder: Path, command: list[str], head: str, ending: str) -> tuple[list[str], set[str]]:
    """Words of headers, and those that are macros."""
    text = compiled(folder, [*command, "-E", "-P"], head, ending).stdout
    defined = compiled(folder, [*command, "-dM", "-E"], head, ending).stdout
    macros = {line.split()[1].split("(")[0] for line in defined.splitlines()}
    found = set(re.findall(r"\b[A-Za-z]\w*", text)) | macros
    return sorted(word for word in found - KEYWORDS if not word.startswith("_")), macros


def main() -> None:
    """Find the words and write them."""
    taken: set[str] = set()
    head = "".join(f"#include <{name}.h>\n" for name in C_HEADERS)
    with TemporaryDirectory() as name:
        folder = Path(name)
        for standard in ("-std=c99", "-std=gnu11"):
            command = ["gcc", standard]
            words, macros = words_of(folder, command, head, ".c")
            taken |= macros & set(words)
            rest = [word for word in words if word not in taken]
            taken |= refused(folder, command, head, rest, ".c", f"int {{word}}{ARGUMENTS};")
        command, head = (
            ["g++", "-std=c++20"],
            "#include <bits/stdc++.h>\n#include <unistd.h>\nstruct own_ { int status; };\nusing namespace std;\n",
        )
        words, macros = words_of(folder, command, head, ".cpp")
        taken |= {word for word in macros & set(words) if re.search("[a-z]", word)}
        call = f'extern "C" own_ {{word}}{ARGUMENTS}; own_ call_{{k}}_(double *a_) {{{{ return {{word}}(a_, a_); }}}}'
        taken |= refused(folder, command, head, words, ".cpp", call)
    found = sorted((word for word in taken if not _EXTENDED.fullmatch(word)), key=lambda word: (word.lower(), word))
    PLACE.write_text(textwrap.fill(" ".join(found), 140, break_on_hyphens=False) + "\n", encoding="utf-8")
    print(f"{PLACE}: {len(found)} words")


if __name__ == "__main__":
    main()
