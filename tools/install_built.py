"""Install what `python -m build` made, each into a fresh environment outside of the checkout, and try it there.

The wheel is installed as a stranger would: with all it depends on, chosen anew from its metadata (the files come from pip's cache where
`.venv` has just fetched them). The source distribution is built and installed without dependencies, which it borrows from the first
environment: the same metadata were resolved there already, and unpacking them again would only take time. A path file after its own
packages lends them, so that a file which the distribution lacks is not found elsewhere: `try_installed.py` asks where it runs from.
"""

import subprocess
import sys
import tempfile
import venv
from pathlib import Path

TRY = Path(__file__).with_name("try_installed.py").resolve()


def main(folder: Path) -> None:
    """Install and try the one wheel and the one source distribution in a folder."""
    (wheel,), (source,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    with tempfile.TemporaryDirectory(prefix="polydraulic-") as place:
        lender = environment(Path(place) / "wheel")
        pip(lender, wheel.resolve())
        try_in(lender)
        borrower = environment(Path(place) / "source")
        pip(borrower, "--no-deps", source.resolve())
        (packages(borrower) / "lent.pth").write_text(f"{packages(lender)}\n")
        pip(lender, "--yes", "polydraulic", command="uninstall")  # or the borrower might run what the lender has
        try_in(borrower)


def environment(path: Path) -> Path:
    """A fresh virtual environment."""
    venv.create(path, with_pip=True)
    return path


def packages(environment: Path) -> Path:
    """Where an environment keeps its packages."""
    return next(environment.glob("lib/python*/site-packages"))


def pip(environment: Path, *arguments: object, command: str = "install") -> None:
    """Run pip of an environment."""
    words = [environment / "bin" / "python", "-m", "pip", command, "--quiet", *arguments]
    subprocess.run(list(map(str, words)), check=True)


def try_in(environment: Path) -> None:
    """Run `try_installed.py` from outside of the checkout, isolated from the caller's paths."""
    subprocess.run([environment / "bin" / "python", "-I", TRY], cwd=environment, check=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
