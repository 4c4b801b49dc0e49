"""What text and Parquet logs look like out there, and what is to come of each: the tests run it, the documentation lists it."""

import gzip
from datetime import date
from pathlib import Path

import numpy as np

TIME = np.arange(60) * 0.01
PRESSURE = np.round(100.0 + 10.0 * np.sin(20.0 * TIME), 3)
READ, REFUSED = "read", "refused"
MARKED = "<!-- what text and Parquet logs hold -->"


def lines(row, head="time,p\n"):
    """A header and rows; `row` is a format of t, p and i."""
    return head + "".join(row.format(t=t, p=p, i=i) for i, (t, p) in enumerate(zip(TIME, PRESSURE, strict=True)))


def german(text):
    return text.replace(",", ";").replace(".", ",")


def clock(t, start):
    """A time of day."""
    t = (t + start) % 86400.0
    return f"{int(t // 3600):02d}:{int(t // 60) % 60:02d}:{t % 60:06.3f}"


def clocked(form, start=0.0, rows=None):
    return "time,p\n" + "".join(form.format(clock(t, start)) + f",{p}\n" for t, p in zip(TIME, PRESSURE, strict=True))


PLAIN = lines("{t:.2f},{p}\n")
BACK = "".join(
    f"2024-10-27 {clock(t, 7170.0 if t >= 0.3 else 10770.0)},{p}\n" for t, p in zip(TIME, PRESSURE, strict=True)
)

# group -> what it is -> (content, what comes of it); a tuple of findings for what is named. Columns are called time and p.
TEXTS = {
    "delimiters and encodings": {
        "commas": (PLAIN, READ),
        "semicolons, decimal commas": (german(PLAIN), READ),
        "tabs": (PLAIN.replace(",", "\t"), READ),
        "pipes": (PLAIN.replace(",", "|"), READ),
        "runs of blanks": (lines("  {t:.2f}   {p}\n", " time p\n"), READ),
        "a line `sep=;`": ("sep=;\n" + german(PLAIN), READ),
        "UTF-8 with a byte order mark": (PLAIN.encode("utf-8-sig"), READ),
        "UTF-16": (german(PLAIN).encode("utf-16"), READ),
        "UTF-16 without a byte order mark": (PLAIN.encode("utf-16-le"), READ),
        "UTF-32": (PLAIN.encode("utf-32"), READ),
        "Windows letters, first in the header": (lines("{t:.2f},{p},x\n", "time,p,Öl €\n").encode("cp1252"), READ),
        "Latin-1 letters, first in the last row": ((lines("{t:.2f},{p},x\n", "time,p,note\n")[:-2] + "Öl\n").encode("latin-1"), READ),
        "blanks between a comma and a quote": (lines('"{t:.2f}", "{p}"\n', '"time", "p"\n'), READ),
        "blanks around cells in quotes": (lines(' "{t:.2f}" , "{p}" \n', ' "time" , "p" \n'), READ),
        "single quotes": (lines("'{t:.2f}','{p}'\n", "'time','p'\n"), READ),
        '`="1.5"`, so that a spreadsheet keeps all digits': (lines('="{t:.2f}",="{p}"\n'), READ),
        "blanks within quotes, between runs of blanks": (lines('"{t:.2f}"  {p}   "a b"\n', '"time" "p" "what it is"\n'), READ),
        "runs of blanks, and single cells that are blank": (
            "time p q\n" + "".join(f"{t:.2f} {p} 7\n" if i != 30 else f"{t:.2f} {' ' * 5} 7\n"
                                    for i, (t, p) in enumerate(zip(TIME, PRESSURE, strict=True))), ("missing line",)),
        "gzip": (gzip.compress(PLAIN.encode()), READ),
        "gzip, cut off": (gzip.compress(PLAIN.encode())[:-40], REFUSED),
        "commas between columns and within numbers": (PLAIN.replace(".", ","), REFUSED),
        "zeros, as of a binary file": (b"time,p\0\0\n1,2\n", REFUSED),
        "zeros at the end, as of a logger that lost its power": (PLAIN.encode() + b"\0" * 512, ("missing line",)),
        "zeros between rows, as of a logger that went on later": (
            PLAIN.replace("0.30,", "\0" * 512 + "\n0.30,").encode(), ("missing line",)),
        "empty": (b"", REFUSED),
        "a header and no rows": ("time,p\n", REFUSED),
    },
    "lines": {
        "a blank first line": ("\n" + PLAIN, READ),
        "comments above the header (`#`, `//`, `%`, `;`)": ("# logger\n// 7\n% x\n; y\n" + PLAIN, READ),
        "other lines above the header, as wide as the rows": ("-- logger 7, rate 100\n1,2\n" + PLAIN, READ),
        "a line of kinds of data below the units": (PLAIN.replace("time,p\n", "time,p\ns,bar\nfloat,double\n"), READ),
        "a line of kinds of data above the units": (PLAIN.replace("time,p\n", "time,p\nf8,f8\ns,bar\n"), READ),
        "units in a line above the names": ("s,bar\n" + PLAIN, READ),
        "a header that comes again": (PLAIN.replace("0.30,", "time,p\n0.30,"), ("no time",)),
        "a header with units that comes again after two rows": (
            PLAIN.replace("time,p\n", "time,p\ns,bar\n").replace("0.02,", "time,p\ns,bar\n0.02,"), ("no time",)),
        "a header that comes again after rows with gaps, and words for numbers": (
            "time,p,x\n" + "".join(("time,p,x\n" if i == 9 else "") + f"{t:.2f},{p},{('', 'open', 1)[i % 3]}\n"
                                   for i, (t, p) in enumerate(zip(TIME, PRESSURE, strict=True))), ("no time",)),
        "names in a comment, as NumPy writes them": (lines("{t:.2f} {p}\n", "# time p\n"), READ),
        "a block of metadata above the header": ("Device,ABC\nDate,2024-01-01\nRate,100\n\n" + PLAIN, READ),
        "units in a line below the header": (PLAIN.replace("time,p\n", "time,p\ns,bar\n"), READ),
        "`Time (s)`, `p (bar)`, `p [bar]` as names with units": (PLAIN.replace("time,p", "time (s),p (bar)"), READ),
        "`time/s`, `p/bar`, `p in bar`, `p, bar` as names with units": (PLAIN.replace("time,p", 'time/s,"p, bar"'), READ),
        "`time <s>`, `[bar] p`, `p {bar}`, `p - bar` as names with units": (PLAIN.replace("time,p", "time <s>,[bar] p"), READ),
        "what each name means, in words below it": (PLAIN.replace("time,p\n", "time,p\nTime since start,Pressure of the pump\n"), READ),
        "names, what they mean, and units, or these in between": (
            PLAIN.replace("time,p\n", "time,p\nTime since start,Pressure of the pump\ns,bar\n"), READ),
        "a line of dashes below the header": (PLAIN.replace("time,p\n", "time,p\n----,---\n"), READ),
        "numbers of rows without a name, as R writes them": (lines('"{i}",{t:.2f},{p}\n', '"time","p"\n'), ("header",)),
        "more fields in all rows than names": (lines("{t:.2f},{p},7{i}\n"), ("header",)),
        "names in quotes with their units in a second line": (PLAIN.replace("time,p\n", '"time\n(s)","p\n(bar)"\n'), READ),
        "a header that ends in a delimiter": (PLAIN.replace("time,p\n", "time,p,\n"), READ),
        "rows that end in a delimiter": (lines("{t:.2f},{p},\n"), READ),
        "rows shorter than the header": (PLAIN.replace("time,p\n", "time,p,x,y\n"), READ),
        "every third row shorter": (
            "time,p,x\n" + "".join(f"{t:.2f},{p}" + (",1\n" if i % 3 else "\n")
                                    for i, (t, p) in enumerate(zip(TIME, PRESSURE, strict=True))), ("short line",)),
        "a last line that breaks off within its last value": (PLAIN + "0.60,1", ("cut line",)),
        "single rows with too few or too many fields": (PLAIN.replace("0.30,", "0.30,,,"), ("missing line",)),
        "a column without a name, as pandas writes its index": (lines("{i},{t:.2f},{p}\n", ",time,p\n"), READ),
        "columns called by numbers": (lines("{t:.2f},{p},{i}\n", "time,p,1\n"), READ),
        "a quote that no other closes": (PLAIN.replace("0.30,", '0.30,"'), READ),
        "comments between the rows": (PLAIN.replace("0.30,", "# stop\n0.30,"), ("comment",)),
    },
    "numbers": {
        "Fortran exponents": (lines("{t:.4f}D+00,{p}\n"), READ),
        "thousands, beside decimal commas": (german(PLAIN).replace("100;", "100;").replace(";100,0\n", ";1.000,0\n"), ("thousands",)),
        "thousands, where other columns have the other mark for decimals": (
            "time;p\n" + "".join(f"{t:.2f};1,{i:03d}\n" for i, t in enumerate(TIME)), ("thousands",)),
        "one decimal point among decimal commas before three digits": (
            german(lines("{t:.2f},1{i:02d}.125\n")).replace("109,125", "109.25"), ("decimal mark", "text")),
        "decimal points among decimal commas": (
            german(PLAIN).replace(";100,0\n", ";100.0\n"), ("decimal mark", "text")),
        "three digits behind every point, beside whole numbers": (
            "time;p\n" + "".join(f"{i};{901 + i if i < 50 else f'1.{i:03d}'}\n" for i in range(60)), ("doubtful numbers",)),
        "TRUE and FALSE, on and off": ("time,p\n" + "".join(f"{t:.2f},{'TRUE' if i % 7 < 3 else 'FALSE'}\n" for i, t in enumerate(TIME)),
                                        ("on and off",)),
        "thin spaces between thousands": (lines("{t:.2f},{p:.3f},1\u2009{i:03d}.5\n", "time,p,q\n"), READ),
        "words among numbers, such as `OFF`": (PLAIN.replace(",100.0\n", ",OFF\n"), ("text",)),
    },
    "times": {
        "s, ms, us or ns since 1970": (lines("1711850398{i:02d}0000000,{p}\n"), READ),
        "ISO 8601": (clocked("2024-03-31T{}", 7170.0), READ),
        "ISO 8601 with `Z` or an offset": (clocked("2024-03-31T{}+01:00", 7170.0), READ),
        "times of day": (clocked("{}", 40000.0), READ),
        "times of day whose milliseconds stand behind a colon": (
            "time,p\n" + "".join(f"{clock(t, 40000.0).replace('.', ':')},{p}\n" for t, p in zip(TIME, PRESSURE, strict=True)), READ),
        "31.03.2024 and a time of day": (clocked("31.03.2024 {}", 40000.0), READ),
        "3/31/2024 1:59:57 PM": (clocked("3/31/2024 {} AM", 40000.0), READ),
        "31-Mar-2024": (clocked("31-Mar-2024 {}", 40000.0), READ),
        "Mar 31, 2024 and Sun Mar 31 13:59:57 2024": (clocked('"Mar 31, 2024 {} AM"', 40000.0), READ),
        "ISO 8601 with a zone by name, such as `CET`": (clocked("2024-03-31T{} CET", 7170.0), READ),
        "ISO 8601 with an offset and `[Europe/Berlin]` behind it": (clocked("2024-03-31T{}+01:00[Europe/Berlin]", 7170.0), READ),
        "date and time of day in two columns": (clocked("31.03.2024,{}", 40000.0).replace("time,p", "Date,time,p"), READ),
        "03/04/2024, where no day is above the 12th": (clocked("03/04/2024 {}", 40000.0), REFUSED),
        "times of day past midnight": (clocked("{}", 86399.7), ("midnight",)),
        "the end of summer time": ("time,p\n" + BACK, ("clock change",)),
        "20240331111957.010, or 20240331111957010": (
            "time,p\n" + "".join(f"20240331{clock(t, 40000.0).replace(':', '')},{p}\n" for t, p in zip(TIME, PRESSURE, strict=True)), READ),
        "times of day of twelve hours, without AM or PM": (
            "time,p\n" + "".join(f"{clock(t, 46799.7 if t < 0.3 else 3599.7)},{p}\n" for t, p in zip(TIME, PRESSURE, strict=True)),
            ("twelve hours",)),
        "a counter of 16 bits that runs over": (
            "time,p\n" + "".join(f"{(65300.0 + i / 100.0) % 65536.0:.2f},{p}\n" for i, p in enumerate(PRESSURE, 23580)), ("counter",)),
        "before 1980, or negative": (clocked("1970-01-01 {}", 5.0), ("impossible time",)),
        "single times that cannot be read": (PLAIN.replace("0.30,", "half past,"), ("no time",)),
    },
}  # fmt: skip


def parquet_tables():
    """As `TEXTS`, for Parquet: Arrow tables."""
    import pyarrow as pa

    ms = (TIME * 1000 + 0.5).astype(np.int64)
    p = pa.array(PRESSURE)
    day = 1_711_850_398_000 + ms
    sentinel = np.arange(60)
    sentinel[30] = np.iinfo(np.int64).min
    return {
        "float, integer, decimal, bool": (pa.table({"time": TIME, "p": p}), READ),
        "timestamps, with or without a zone": (pa.table({"time": pa.array(day, pa.timestamp("ms", "UTC")), "p": p}), READ),
        "durations": (pa.table({"time": pa.array(ms, pa.duration("ms")), "p": p}), READ),
        "times of day": (pa.table({"time": pa.array(ms.astype(np.int32), pa.time32("ms")), "p": p}), READ),
        "times as strings": (pa.table({"time": [f"2024-03-31 {clock(t, 40000.0)}" for t in TIME], "p": p}), READ),
        "03/04/2024 as strings": (pa.table({"time": [f"03/04/2024 {clock(t, 40000.0)}" for t in TIME], "p": p}), REFUSED),
        "dates and times of day in columns side by side": (
            pa.table({"date": pa.array([date(2024, 3, 31)] * 60), "time": pa.array(ms.astype(np.int32), pa.time32("ms")), "p": p}), READ),
        "fields of records, as `record.field`, beside others": (
            pa.table({"time": TIME, "p": p, "record": pa.array([{"field": 1.0}] * 60)}), READ),
        "a column that has no name": (pa.table([pa.array(TIME), p, p], names=["time", "p", ""]), ("not read",)),
        "ns since 1970 as 64-bit integers": (pa.table({"time": day * 1_000_000, "p": p}), READ),
        "the least or largest 64-bit integer": (pa.table({"time": TIME, "p": sentinel}), ("text",)),
        "on and off as strings": (pa.table({"time": TIME, "p": ["on" if i % 7 < 3 else "off" for i in range(60)]}), ("on and off",)),
        "numbers as strings with decimal commas": (pa.table({"time": [f"{t:.2f}".replace(".", ",") for t in TIME],
                                                             "p": [f"{x}".replace(".", ",") for x in PRESSURE]}), READ),
        "two columns of one name": (pa.table([pa.array(TIME), p, pa.array(["x"] * 60)], names=["time", "p", "p"]), ("duplicate",)),
        "no rows": (pa.table({"time": TIME[:0], "p": PRESSURE[:0]}), REFUSED),
        "columns of lists alone": (pa.table({"time": [[1.0]] * 60}), REFUSED),
    }  # fmt: skip


def cases():
    """All of them: (group, what it is, content, what comes of it)."""
    found = [(group, what, *case) for group, of in TEXTS.items() for what, case in of.items()]
    return found + [("Parquet", what, *case) for what, case in parquet_tables().items()]


def write(folder, what, content):
    """Write a case as a file."""
    if isinstance(content, str | bytes):
        path = Path(folder) / ("log.csv.gz" if what.startswith("gzip") else "log.csv")
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path
    import pyarrow.parquet as pq

    path = Path(folder) / "log.parquet"
    pq.write_table(content, path)
    return path


def documented():
    """The table of the documentation."""
    rows = ["| | file | what comes of it |", "|---|---|---|"]
    before = ""
    for group, what, _, came in cases():
        said = came if isinstance(came, str) else "read; named as " + ", ".join(f"`{kind}`" for kind in came)
        rows.append(f"| {group if group != before else ''} | {what} | {said} |")
        before = group
    return "\n".join([MARKED, *rows]) + "\n"
