"""``python -m polydraulic.cli``."""

from polydraulic.cli import main

main()
