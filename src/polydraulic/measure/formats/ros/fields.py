"""Messages of ROS as rows of numbers: which fields hold any, what their columns are called, and what is left out.

Fields within fields are ``pose.position.x``, elements of arrays ``data[0]``. Where a message names its elements (``name`` of a
JointState), these are ``boom.position``.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from polydraulic.measure.formats.ros.message_units import MessageUnit, unit_of

LONGEST = 64  # elements of an array that are columns; what is longer is a picture or a cloud of points
_NAMES = ("name", "names", "joint_name", "joint_names")
_TEXTS = ("string", "wstring", "wchar")
_TIMES = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")
_HEADER = "std_msgs/msg/Header"
_LAYOUT = "std_msgs/msg/MultiArrayLayout"  # what the elements of an array mean, in words
_BASE, _NAME, _ARRAY = 1, 2, 3  # kinds of field in a definition; 4 is a sequence

Getter = Callable[[Any], Any]
Layout = tuple[int | tuple[str, ...], ...]  # of each array and sequence how long it is, or what its elements are called


class BagColumn(NamedTuple):
    """A column of numbers; `whole` where they are integers of 64 bits."""

    name: str
    unit: MessageUnit = MessageUnit()
    whole: bool = False


class _Series(NamedTuple):
    """A field of several numbers."""

    column: BagColumn
    get: Getter
    labels: Getter | None
    before: str  # path of the message that it is in


class Fields:
    """The numbers of a type of message.

    Parameters
    ----------
    store : Typestore
        Of rosbags, which knows the type.
    kind : str
        Name of the type.

    Attributes
    ----------
    stamped : bool
        Whether messages have a header with a time.
    left_out : dict from str to str
        Fields that are not columns, with the reason.
    uneven : Counter of str
        Messages with another number of values than of names, by field.
    """

    def __init__(self, store: Any, kind: str) -> None:
        self.stamped = False
        self.left_out: dict[str, str] = {}
        self.uneven: Counter[str] = Counter()
        self._single: list[tuple[BagColumn, Getter]] = []
        self._series: list[_Series] = []
        self._walk(store, kind, "", lambda message: message, MessageUnit())

    @property
    def empty(self) -> bool:
        """Whether no field holds numbers."""
        return not self._single and not self._series

    def row(self, message: Any) -> tuple[Layout, list[float]]:
        """Numbers of a message, and what they are of."""
        values = [float(get(message)) for _, get in self._single]
        layout: list[int | tuple[str, ...]] = []
        for series in self._series:
            found = series.get(message)
            if len(found) > LONGEST and series.labels is None:
                self.left_out[series.column.name] = f"an array of more than {LONGEST} numbers"
                layout.append(0)
                continue
            if series.labels is not None and len(found):
                labels = tuple(series.labels(message))
                if len(labels) != len(found):
                    self.uneven[series.column.name] += 1
                    layout.append(0)
                    continue
                layout.append(labels)
            else:
                layout.append(len(found))
            values += map(float, found)
        return tuple(layout), values

    def columns(self, layout: Layout) -> list[BagColumn]:
        """Columns of the numbers of a layout, in order."""
        found = [column for column, _ in self._single]
        for series, part in zip(self._series, layout, strict=True):
            if isinstance(part, int):
                found += [series.column._replace(name=f"{series.column.name}[{place}]") for place in range(part)]
            else:
                field = series.column.name.removeprefix(series.before)
                found += [series.column._replace(name=f"{series.before}{label}.{field}") for label in _different(part)]
        return found

    def _walk(self, store: Any, kind: str, before: str, at: Getter, unit: MessageUnit) -> None:
        """Go through the fields of a message type, and of those in it."""
        fields = store.get_msgdef(kind).fields
        labels = next((name for name, what in fields if name in _NAMES and _of_texts(what)), None)
        label_getter = None if labels is None else _within(at, labels)
        for name, (what, detail) in fields:
            path, get = f"{before}{name.rstrip('_')}", _within(at, name)
            own = unit_of(kind, name, unit)
            if what == _BASE:
                if detail[0] not in _TEXTS:
                    self._single.append((BagColumn(path, own, detail[0] in ("int64", "uint64")), get))
            elif what == _NAME:
                if detail == _HEADER:
                    self.stamped = self.stamped or before == ""
                elif detail in _TIMES:
                    self._single.append((BagColumn(path, MessageUnit("s")), _seconds(get)))
                elif detail != _LAYOUT:
                    self._walk(store, detail, f"{path}.", get, own)
            else:
                self._several(store, what, detail, (path, get, own), (label_getter, before))

    def _several(
        self,
        store: Any,
        what: int,
        detail: Any,
        field: tuple[str, Getter, MessageUnit],
        label: tuple[Getter | None, str],
    ) -> None:
        """An array or a sequence."""
        (of, kind), length = detail
        path, get, unit = field
        if of == _BASE:
            if kind[0] in _TEXTS:
                return
            if what == _ARRAY and length > LONGEST:
                self.left_out[path] = f"an array of more than {LONGEST} numbers"
            else:
                column = BagColumn(path, unit, kind[0] in ("int64", "uint64"))
                self._series.append(_Series(column, get, None if what == _ARRAY else label[0], label[1]))
        elif what == _ARRAY and length <= LONGEST and kind not in _TIMES:
            for place in range(length):
                self._walk(store, kind, f"{path}[{place}].", _element(get, place), unit)
        else:
            self.left_out[path] = "a list of messages"


def _of_texts(what: Any) -> bool:
    return what[0] not in (_BASE, _NAME) and what[1][0][0] == _BASE and what[1][0][1][0] in _TEXTS


def _within(at: Getter, name: str) -> Getter:
    return lambda message: getattr(at(message), name)


def _element(get: Getter, place: int) -> Getter:
    return lambda message: get(message)[place]


def _seconds(get: Getter) -> Getter:
    def seconds(message: Any) -> float:
        time = get(message)
        return float(time.sec + 1e-9 * time.nanosec)

    return seconds


def _different(labels: Sequence[str]) -> list[str]:
    """Names of elements, with their places where a name is empty or comes again."""
    return [
        label if label and label not in labels[:place] else f"{label or 'element'}[{place}]"
        for place, label in enumerate(labels)
    ]
