"""``python -m polydraulic``: the command line."""

from polydraulic.cli import main

if __name__ == "__main__":
    main()
