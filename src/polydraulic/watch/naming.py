"""Abductive networks that name the kind of a fault from the evidence for each kind, with a certainty: a second opinion beside the signatures.

Signatures weigh what one direction explains; networks have seen what all of them together look like under each kind of fault.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from polydraulic.networks.model.model import Model
from polydraulic.watch.diagnosis import scatter_of
from polydraulic.watch.directions import Direction
from polydraulic.watch.kernels.evidence import best_evidence
from polydraulic.watch.sequential import Since

_LEAST, _LEAST_SCATTER = 1e-9, 1e-3


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


@dataclass(frozen=True, eq=False)
class FaultNetworks:
    """Networks of all kinds of faults of one machine with some sensors.

    Attributes
    ----------
    directions : tuple of str
        Names of the directions whose evidence they read.
    models : tuple of Model
        One for each kind, which is the name of its output; inputs are as of `features`.
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
        row = features(directions, seen, together)[None, :]
        outputs = np.array([model.predict(row)[0] for model in self.models])
        likely = self.link[:, :-1] @ outputs + self.link[:, -1]
        share = np.exp(likely - likely.max())
        best = int(np.argmax(share))
        known = bool(self.models[best].inside(row)[0])
        return Opinion(self.kinds[best], float(share[best] / share.sum()), known)


def kinds_of(directions: Sequence[Direction]) -> tuple[str, ...]:
    """Kinds of directions, in their order."""
    return tuple(dict.fromkeys(d.kind for d in directions))


def features(directions: Sequence[Direction], seen: Since, together: float) -> np.ndarray:
    """What networks read, (2 n_kind + 1,).

    Of the strongest direction of each kind the square root of its share in the most evidence; the logarithm of that; and of each kind's again the
    logarithm of the scatter of blocks about it, which is large where it explains one block and not the next.
    """
    down = [int(d.both) for d in directions]
    fits = zip(seen.pull.tolist(), seen.information.tolist(), down, strict=True)
    evidence = np.array([max(best_evidence(pull, known, together, both), 0.0) for pull, known, both in fits])
    scatter = np.maximum(scatter_of(seen), _LEAST_SCATTER * together) / together
    kinds = np.array([d.kind for d in directions])
    strongest = [
        places[np.argmax(evidence[places])]
        for kind in kinds_of(directions)
        for places in [np.flatnonzero(kinds == kind)]
    ]
    most = max(float(evidence.max()), _LEAST)
    return np.concatenate([np.sqrt(evidence[strongest] / most), [np.log10(most)], np.log10(scatter[strongest])])


def inputs_of(directions: Sequence[Direction]) -> tuple[str, ...]:
    """Names of what `features` gives."""
    kinds = kinds_of(directions)
    return (*(f"share of {kind}" for kind in kinds), "evidence", *(f"scatter of {kind}" for kind in kinds))
