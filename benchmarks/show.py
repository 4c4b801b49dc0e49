"""What all benchmarks print alike: times of calls in turn with their ratios, Markdown tables, and peers that are left out."""


def show(title, turns, unit, *, base=None, notes=None):
    """Median times and the ratios to `base`, by default the first; `notes` holds what follows on a line."""
    scale = {"ns": 1e9, "us": 1e6, "ms": 1e3}[unit]
    base = base or next(iter(turns.seconds))
    width = max(34, *(len(name) for name in turns.seconds))
    print(f"\n{title}\n  {'':{width}s} {'median':>12s}      ratio (quartiles)")
    for name in turns.seconds:
        ratio = "1" if name == base else str(turns.ratio(name, base))
        line = (
            f"  {name:{width}s} {turns.median(name) * scale:12.3f} {unit}   {ratio:24s} {(notes or {}).get(name, '')}"
        )
        print(line.rstrip(), flush=True)


def table(title, header, rows):
    """Print a Markdown table."""
    print(f"\n### {title}\n\n| {' | '.join(header)} |\n|{'---|' * len(header)}")
    for row in rows:
        print(f"| {' | '.join(row)} |", flush=True)


def left_out(what, how):
    """Say that a peer takes no part, and how it would."""
    print(f"\n{'!' * 100}\nLEFT OUT: {what}\n  {how}\n{'!' * 100}", flush=True)
