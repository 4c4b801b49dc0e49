"""Messages of a bag, read by rosbags: topics with their types, and messages in the order of their receipt."""

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

from polydraulic.errors import InputError
from polydraulic.measure.log_units import need

_MCAP_END = b"\x89MCAP0\r\n"
_PICTURES = {f"sensor_msgs/msg/{name}" for name in ("Image", "CompressedImage", "PointCloud", "PointCloud2")}
_BEFORE_IRON = "ROS2_HUMBLE"  # bags without definitions of their messages are no younger
Key = tuple[str, str]  # name and type of a topic


class Bag:
    """An opened bag.

    Attributes
    ----------
    topics : dict from (name, type) to str
        Why a topic is not read; empty where it is.
    said : Counter of (name, type)
        Messages that the bag says it has.
    """

    def __init__(self, reader: Any, path: Path) -> None:
        self._reader, self._path = reader, path
        self._old = path.suffix == ".bag"
        self._stores: dict[Key, Any] = {}
        self.topics: dict[Key, str] = {}
        self.said: Counter[Key] = Counter()
        for connection in reader.connections:
            key = connection.topic, connection.msgtype
            self.said[key] += connection.msgcount
            self.topics.setdefault(key, self._why_not(connection))

    def store(self, name: str, kind: str) -> Any:
        """Types of rosbags that know the type of a topic."""
        return self._stores[name, kind]

    def messages(self, keys: Sequence[Key]) -> Iterator[tuple[Key, int, Any]]:
        """Topic, time of receipt in ns since 1970 and message, or None for one that is damaged."""
        wanted = [c for c in self._reader.connections if (c.topic, c.msgtype) in set(keys)]
        if not wanted:
            return
        n = 0
        try:
            for connection, receipt, content in self._reader.messages(connections=wanted):
                n += 1
                key = connection.topic, connection.msgtype
                yield key, receipt, self._message(key, content)
        except Exception as error:  # as on opening
            raise InputError(f"{self._path}: the log is damaged after {n} messages ({error})") from error

    def _message(self, key: Key, content: bytes) -> Any:
        store, kind = self._stores[key], full_name(key[1])
        try:
            return store.deserialize_ros1(content, kind) if self._old else store.deserialize_cdr(content, kind)
        except Exception:  # errors of many kinds on damaged bytes
            return None

    def _why_not(self, connection: Any) -> str:
        """Make types for a topic; the reason where there are none."""
        kind = full_name(connection.msgtype)
        if kind in _PICTURES:
            return f"{kind}: images and point clouds are not channels"
        if not connection.msgcount:
            return "no message"
        encoding = getattr(connection.ext, "serialization_format", "ros1" if self._old else "cdr")
        if encoding != ("ros1" if self._old else "cdr"):
            return f"its messages are written as {encoding!r}, not as in ROS"
        types = import_module("rosbags.typesys")
        form, definition = connection.msgdef.format.name, connection.msgdef.data
        try:
            if form == "NONE":
                store = types.get_typestore(types.Stores[_BEFORE_IRON])
                if kind not in store.fielddefs:
                    return f"its type {kind} is not defined in the bag, and is not one of ROS itself"
            else:
                store = types.get_typestore(types.Stores.EMPTY)
                store.register(
                    types.get_types_from_msg(definition, kind) if form == "MSG" else _of_idl(types, definition)
                )
        except Exception as error:  # rosbags raises errors of many kinds
            return f"the definition of its type {kind} cannot be read: {error}"
        self._stores[connection.topic, connection.msgtype] = store
        return ""


def full_name(kind: str) -> str:
    """Name of a type with its middle, which some writers leave out: ``sensor_msgs/msg/Imu``."""
    return kind if kind.count("/") != 1 else kind.replace("/", "/msg/")


def _of_idl(types: Any, definition: str) -> Any:
    """Types of a definition in IDL: one, or several that begin with a line of ``=`` and ``IDL: NAME``."""
    line = "=" * 80 + "\n"
    if not definition.startswith(f"{line}IDL: "):
        return types.get_types_from_idl(definition)
    found: dict[str, Any] = {}
    for part in definition.split(line)[1:]:
        found |= types.get_types_from_idl(part.split("\n", 1)[1])
    return found


@contextmanager
def opened_bag(path: Path) -> Iterator[Bag]:
    """Open a bag for a while.

    Raises
    ------
    InputError
        rosbags is not installed, or the bag cannot be read; what a recording that was cut off needs is said.
    """
    need("rosbags", "ros")
    _check(path)
    reader_of = import_module("rosbags.rosbag1" if path.suffix == ".bag" else "rosbags.rosbag2").Reader
    try:
        reader = reader_of(path)
        reader.open()
    except Exception as error:  # rosbags raises errors of many kinds on damaged files
        raise InputError(f"{path}: cannot be read as a ROS bag ({error or type(error).__name__})") from error
    try:
        yield Bag(reader, path)
    finally:
        reader.close()


def _check(path: Path) -> None:
    """Refuse what rosbags would read otherwise than it is, or refuse without saying what helps."""
    if path.is_dir() and not (path / "metadata.yaml").is_file():
        files = sorted(file.name for file in path.iterdir() if file.suffix in (".mcap", ".db3"))
        raise InputError(
            f"{path}: a folder without metadata.yaml is not a bag"
            + (f", as after a recording that was cut off; give its files: {' '.join(files)}" if files else "")
        )
    if any(letter in str(path) for letter in "?#%"):
        raise InputError(
            f"{path}: the path of a bag may hold no '?', '#' or '%' (SQLite reads them otherwise); rename it"
        )
    if path.suffix == ".mcap":
        with path.open("rb") as file:
            size = file.seek(0, 2)
            file.seek(max(0, size - len(_MCAP_END)))
            if size and file.read() != _MCAP_END:
                raise InputError(
                    f"{path}: the log is cut off, as when the recorder loses power: it has no index at its end; "
                    "`mcap recover` (of the MCAP project) writes what is there into a new file"
                )


def unfinished(path: Path) -> dict[str, str]:
    """Files beside a database that hold what a recorder had not put into it when it ended; rosbags does not see them."""
    files = sorted(path.glob("*.db3")) if path.is_dir() else [path]
    beside = [
        file.with_name(file.name + end) for file in files if file.suffix == ".db3" for end in ("-wal", "-journal")
    ]
    return {
        file.name: "messages that the recorder did not put into the database; `sqlite3 FILE.db3 'PRAGMA wal_checkpoint'` does"
        for file in beside
        if file.is_file() and file.stat().st_size
    }
