"""What all benchmarks print alike: times with their ratios, Markdown tables, and peers that are left out."""

SCALES = {"ns": 1e9, "us": 1e6, "ms": 1e3}


def show(title, times, unit, *, per=1, notes=None):
    """Median times of one of `per` units of work, and their ratios; `notes` holds what follows on a line."""
    width = max(34, *(len(name) for name in times))
    print(f"\n{title}\n  {'':{width}s} {'median':>12s}      ratio (quartiles)")
    for name, (seconds, ratio) in times.items():
        figures = f"{seconds / per * SCALES[unit]:12.3f} {unit}   {ratio!s:24s}"
        print(f"  {name:{width}s} {figures} {(notes or {}).get(name, '')}".rstrip(), flush=True)


def table(title, header, rows):
    """Print a Markdown table."""
    print(f"\n### {title}\n\n| {' | '.join(header)} |\n|{'---|' * len(header)}")
    for row in rows:
        print(f"| {' | '.join(row)} |", flush=True)


def left_out(what, how):
    """Say that a peer takes no part, and how it would."""
    print(f"\n{'!' * 100}\nLEFT OUT: {what}\n  {how}\n{'!' * 100}", flush=True)
