"""Abductive networks that name the kind of a fault from the evidence for each kind, with a certainty: a second opinion beside the signatures.

Signatures weigh what one direction explains; networks have seen what all of them together look like under each kind of fault.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.table import pack, work_size
from polydraulic.watch.directions import Direction
from polydraulic.watch.kernels.opinions import KindNumbers, opinion_of, read_evidence
from polydraulic.watch.sequential import Since


class Opinion(NamedTuple):
    """What networks take a fault for.

    Attributes
    ----------
    kind : str
        ``leak_across``, whatever it is of.
    certainty : float
        Probability among the kinds that were learnt.
    known : bool
        Whether the evidence is like that which was learnt from; where it is not, the certainty tells little.
    """

    kind: str
    certainty: float
    known: bool


class AskedNetworks(NamedTuple):
    """Networks as kernels ask them: their numbers, room for what they read and say, and for their nodes."""

    numbers: KindNumbers
    room: np.ndarray
    slots: np.ndarray


@dataclass(frozen=True, eq=False)
class FaultNetworks:
    """Networks of all kinds of faults of one machine with some sensors.

    Attributes
    ----------
    directions : tuple of str
        Names of the directions whose evidence they read.
    models : tuple of Model
        One for each kind, which is the name of its output, of one network everywhere; inputs are as of `features`.
    link : (n_kind, n_kind + 1) array
        From their outputs to logarithms of probabilities: factors, and a constant last.
    """

    directions: tuple[str, ...]
    models: tuple[Model, ...]
    link: np.ndarray

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of faults that are known."""
        return tuple(model.output.name for model in self.models)

    def opinion(self, directions: Sequence[Direction], seen: Since, together: float) -> Opinion:
        """What is seen of all directions is taken for.

        Parameters
        ----------
        directions : sequence of Direction
        seen : Since
        together : float
            What evidence is divided by.
        """
        numbers, room, slots = self.asked(directions)
        said = opinion_of(numbers, np.concatenate(seen[:3]), 0, seen.blocks, together, _down(directions), room, slots)
        return Opinion(self.kinds[said.kind], said.certainty, bool(said.familiar))

    def asked(self, directions: Sequence[Direction]) -> AskedNetworks:
        """The networks as kernels ask them about what is seen of these directions.

        Raises
        ------
        InputError
            If they were learnt for others, or have regions.
        """
        inputs = len(inputs_of(directions))
        same = self.directions == tuple(d.name for d in directions)
        if not (same and all(len(model.inputs) == inputs for model in self.models)):
            raise InputError(
                "networks: learnt for other faults than those that are watched; learn networks for this machine with these sensors"
            )
        if several := [model.output.name for model in self.models if len(model.networks) > 1]:
            raise InputError(
                f"networks: that of {several[0]} has regions; of each kind of fault there must be one network"
            )
        table, known = pack([network for model in self.models for network in model.networks]), len(self.models)
        kind, watched = _kind_numbers(directions), len(kinds_of(directions))
        numbers = KindNumbers(table, self.link.astype(np.float64), kind, known, watched, inputs)
        return AskedNetworks(numbers, np.zeros(inputs + 2 * known), np.zeros(work_size(table)))


def kinds_of(directions: Sequence[Direction]) -> tuple[str, ...]:
    """Kinds of directions, in their order."""
    return tuple(dict.fromkeys(d.kind for d in directions))


def features(directions: Sequence[Direction], seen: Since, together: float) -> np.ndarray:
    """What networks read, (2 n_kind + 1,): shares of kinds in the most evidence, how much that is, and how blocks scatter (`read_evidence`)."""
    flat, watched = np.concatenate(seen[:3]), len(kinds_of(directions))
    found = np.empty(2 * watched + 1)
    read_evidence(_kind_numbers(directions), watched, flat, 0, seen.blocks, together, _down(directions), found)
    return found


def _kind_numbers(directions: Sequence[Direction]) -> np.ndarray:
    kinds = kinds_of(directions)
    return np.array([kinds.index(d.kind) for d in directions], dtype=np.int64)


def _down(directions: Sequence[Direction]) -> np.ndarray:
    return np.array([d.both for d in directions], dtype=np.int64)


def inputs_of(directions: Sequence[Direction]) -> tuple[str, ...]:
    """Names of what `features` gives."""
    kinds = kinds_of(directions)
    return (*(f"share of {kind}" for kind in kinds), "evidence", *(f"scatter of {kind}" for kind in kinds))
