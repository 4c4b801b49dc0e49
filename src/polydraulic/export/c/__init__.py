"""Networks as C99: `text` (how C is written), `network` (a network as straight-line code), `source` (header, source, self-test).

Dynamic models row by row: `run`.
"""
