"""``python -m polydraulic.cli``."""

from polydraulic.cli import main

if __name__ == "__main__":
    main()
