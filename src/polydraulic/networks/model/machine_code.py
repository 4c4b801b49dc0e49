"""Machine code of a model's networks, for kernels that ask for one row at a time: compiled once, kept on disk, called by its address.

Kernels are compiled for a layout and never for a model: they are given the addresses as numbers, so that none stands in what numba
keeps. A kept file begins with a digest of itself and says what it is of: the model's numbers, the processor, its features, and the
version of llvmlite. One that is damaged, or of something else, is replaced; where none can be written, every process compiles.
"""

import hashlib
import os
from array import array
from collections.abc import Sequence
from contextlib import suppress
from ctypes import Array, c_int64
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple
from weakref import WeakValueDictionary

import llvmlite
import llvmlite.binding as llvm
import numpy as np
from llvmlite import ir
from numba import types
from numba.core.registry import cpu_target
from numba.extending import intrinsic

from polydraulic._kernel import cache_folder, kernel
from polydraulic._kernel_cache import warn_uncached
from polydraulic.errors import InputError
from polydraulic.files import replacing
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.partition import flatten
from polydraulic.networks.model.straight_line import ENTRY, network_text

_MOST_KEPT = 500  # files; of more, those that nobody has read for longest are removed
_DIGEST = hashlib.sha256().digest_size


class NetworkCode(NamedTuple):
    """Machine code of models.

    Attributes
    ----------
    begins : (n_model,) array of int64
        Addresses; 0 for a model that is a constant. The code lives as long as this array does, or a view of it; a copy does not keep it.
    constants : (n_model,) array of float
        Outputs of those.
    """

    begins: np.ndarray
    constants: np.ndarray


def network_code(models: Sequence[Model]) -> NetworkCode:
    """Machine code of models, compiled or read from where it is kept; called by `answer_of`."""
    constants = [_constant(model) for model in models]
    with _lock:
        loaded = [_loaded(model) if y is None else None for model, y in zip(models, constants, strict=True)]
    held = _Addresses(len(loaded))(*(code.begins if code else 0 for code in loaded))
    held.loaded = loaded
    return NetworkCode(np.frombuffer(held, dtype=np.int64), np.array([y or 0.0 for y in constants]))


def _constant(model: Model) -> float | None:
    """Output of a model that is one network without nodes, as `table.evaluate` computes it."""
    if len(model.networks) > 1 or model.networks[0].nodes:
        return None
    network = model.networks[0]
    return min(max(network.y_mean + network.y_scale * 0.0, network.y_low), network.y_high)


@kernel
def answer_of(code: NetworkCode, number: int, x: np.ndarray) -> float:
    """Output of a model, by its number, for inputs in the first places of `x`, which stay as they are; the bits of `table.evaluate`."""
    begins = code.begins[number]
    return _answer_at(begins, x) if begins != 0 else code.constants[number]


@intrinsic
def _answer_at(typing: Any, begins: Any, x: Any) -> Any:
    """``_answer_at(address, x)``: output of the model whose code is there."""
    found = types.float64(types.int64, types.Array(types.float64, 1, "C"))

    def call(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        inputs = context.make_array(signature.args[1])(context, builder, values[1]).data
        kind = ir.FunctionType(ir.DoubleType(), [inputs.type])
        return builder.call(builder.inttoptr(values[0], kind.as_pointer()), [inputs], attrs=("nounwind", "readonly"))

    return found, call


def _Addresses(n: int) -> Any:
    """Class of arrays of addresses, which can hold what keeps these alive."""
    return type("_Addresses", (Array,), {"_type_": c_int64, "_length_": n})


class _Loaded:
    """The code of one model in memory, which is given back when this goes."""

    def __init__(self, code: bytes, target: "_Target") -> None:
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target.machine(), use_lmm=True)
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        self._engine.finalize_object()
        self.begins: int = self._engine.get_function_address(ENTRY)


_lock = Lock()
_in_memory: WeakValueDictionary[bytes, _Loaded] = WeakValueDictionary()


def _loaded(model: Model) -> _Loaded:
    target = _target()
    key = _key(model, target)
    found = _in_memory.get(key)
    if found is None:
        path = _path(key)
        code = _read(path, key)
        if code is None:
            code = _compiled(model, target)
            _keep(path, key, code)
        found = _in_memory[key] = _Loaded(code, target)
    return found


class _Target(NamedTuple):
    """What code is compiled for: as numba does, whose settings of processor and features count."""

    triple: str
    processor: str
    features: str

    def machine(self) -> Any:
        # constants stand beside the code and are found from where it is: the memory manager of `_Loaded` keeps them close
        of = llvm.Target.from_triple(self.triple)
        return of.create_target_machine(cpu=self.processor, features=self.features, reloc="pic", codemodel="small")


def _target() -> _Target:
    return _Target(*cpu_target.target_context.codegen().magic_tuple())


def _key(model: Model, target: _Target) -> bytes:
    """Digest of all numbers of a model, with how many of each there are, and of what its code is compiled for and by."""
    whole, numbers = array("q"), array("d")
    for network in model.networks:
        whole.extend((network.n_inputs, len(network.nodes)))
        for node in network.nodes:
            whole.extend((node.kind, len(node.inputs), *node.inputs, len(node.coef)))
            numbers.extend(node.coef)
        for of_inputs in (network.x_mean, network.x_scale, network.x_low, network.x_high):
            numbers.extend(of_inputs)
        numbers.extend((network.y_mean, network.y_scale, network.y_low, network.y_high))
    regions = (np.asarray(part) for part in flatten(model.partition))
    parts = [whole.tobytes(), numbers.tobytes(), *(part.tobytes() for part in regions)]
    digest = hashlib.sha256(repr((*target, llvmlite.__version__, [len(part) for part in parts])).encode())
    for part in parts:
        digest.update(part)
    return digest.digest()


def _compiled(model: Model, target: _Target) -> bytes:
    module = llvm.parse_assembly(network_text(model))
    module.triple = target.triple
    module.verify()
    code: bytes = target.machine().emit_object(module)
    return code


def _path(key: bytes) -> Path | None:
    folder = cache_folder()
    return None if folder is None else Path(folder) / "networks" / f"{key.hex()[:32]}.code"


def _read(path: Path | None, key: bytes) -> bytes | None:
    """Code that was kept under a key; None where there is none, or the file is damaged or of something else."""
    if path is None:
        return None
    try:
        content = path.read_bytes()
    except OSError:
        return None
    digest, body = content[:_DIGEST], content[_DIGEST:]
    if hashlib.sha256(body).digest() != digest or body[:_DIGEST] != key:
        return None
    with suppress(OSError):
        os.utime(path)
    return body[_DIGEST:]


def _keep(path: Path | None, key: bytes, code: bytes) -> None:
    """Write a file, or say once that nothing can be kept."""
    if path is None:
        return
    body = key + code
    try:
        with replacing(path) as temporary:
            temporary.write_bytes(hashlib.sha256(body).digest() + body)
    except InputError as error:
        warn_uncached(path.parent, error)
    with suppress(OSError):
        files = sorted(path.parent.glob("*.code"), key=lambda file: file.stat().st_mtime)
        for file in files[:-_MOST_KEPT]:
            file.unlink(missing_ok=True)
