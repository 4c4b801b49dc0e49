"""What the kernels of a machine that is watched read, and where in its arrays everything stands."""

from typing import NamedTuple

import numpy as np

# places in `marks`, whole numbers that are kept from block to block
FILLED, GAPS, BLOCKS, OPENED, LAST, ALARMS, LISTED, STUCK, FIRST, TOLD, COURSE = range(11)
KIND, FAMILIAR, SUSPECTS = 11, 12, 13  # of the kind that networks take a fault for: 1 and its number, 0 none
MOST_LISTED = 5
OTHERS = SUSPECTS + MOST_LISTED
HEAD_OF_MARKS = OTHERS + MOST_LISTED
SINCE, SEEN, UNTIL = 0, 1, 2  # places in `live`, numbers that are kept: times of an alarm, s
GROWS, GROWN, GROWN_ERROR = 3, 4, 5  # how the error went on that it is named by
CERTAINTY, HEAD_OF_LIVE = 6, 7  # of networks


class WatchNumbers(NamedTuple):
    """A machine that is watched, and what is to be expected of it.

    Places named ``at_`` are in `live`, ``in_work`` in what is filled anew with each block, ``in_marks`` in whole numbers.
    """

    ints: np.ndarray
    floats: np.ndarray
    scales: np.ndarray
    offset: np.ndarray
    jitter: np.ndarray
    together: np.ndarray
    slow: np.ndarray
    down: np.ndarray
    group: np.ndarray
    harmless: np.ndarray
    errors: np.ndarray
    owner: np.ndarray
    belongs: np.ndarray
    limits: np.ndarray
    directions: int
    sensors: int
    owners: int
    rows: int
    before: int
    inside: int
    score_table: int
    states_table: int
    in_work: int
    in_course: int
    at_rows: int
    at_times: int
    at_sums: int
    at_chances: int
    in_marks: int
    threshold: float
    common: float
    raster: float
