"""What an export wrote: one record for all exporters; texts of C from templates, and their way into a folder."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from string import Template

from polydraulic.files import write_texts

_TEMPLATES = Path(__file__).parent / "templates"


@dataclass(frozen=True)
class Exported:
    """What an export wrote; iterates over its files, and ``str()`` lists them with what must be known of them.

    Attributes
    ----------
    files : tuple of Path
        The main file first.
    notes : tuple of str
        What the user should know: names that were changed, a compiler that was missing, who has to shift lagged values.
    binaries : tuple of str
        Platforms with a binary in an FMU, as FMI 3.0 names them; none of other exports, and where there was no compiler.
    """

    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()
    binaries: tuple[str, ...] = ()

    def __iter__(self) -> Iterator[Path]:
        return iter(self.files)

    def __len__(self) -> int:
        return len(self.files)

    @property
    def main(self) -> Path:
        """The file to use: the header of C, else the only one."""
        return self.files[0]

    def __str__(self) -> str:
        main, *others = map(str, self.files)
        first = f"{main}: {', '.join(self.binaries)}" if self.binaries else main
        return "\n".join([first, *others, *(f"note: {note}" for note in self.notes)])


def filled(
    template: str, name: str, fill: Mapping[str, str], endings: tuple[str, ...] = (".h", ".c")
) -> dict[str, str]:
    """Texts of C files by file name: the package's templates of that name, one for each ending, filled in."""
    return {
        f"{name}{ending}": Template((_TEMPLATES / f"{template}{ending}.txt").read_text(encoding="utf-8")).substitute(
            fill
        )
        for ending in endings
    }


def write_exported(texts: Mapping[str, str], folder: str | Path) -> Exported:
    """Write texts by file name into a folder.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    files = {Path(folder) / name: text for name, text in texts.items()}
    write_texts(files)
    return Exported(tuple(files))
