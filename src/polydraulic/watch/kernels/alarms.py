"""Alarms: when one begins, how long it lasts, and what it is named."""

import numpy as np

from polydraulic._kernel import driver
from polydraulic.watch.kernels.courses import follow_course
from polydraulic.watch.kernels.evidence import (
    KEPT,
    LEAST_BLOCKS,
    best_evidence,
    diagnose,
    gather,
    ring_place,
    sum_since,
)
from polydraulic.watch.kernels.numbers import (
    ALARMS,
    BLOCKS,
    FIRST,
    LAST,
    LISTED,
    OPENED,
    OTHERS,
    SEEN,
    SINCE,
    STUCK,
    SUSPECTS,
    TOLD,
    UNTIL,
    WatchNumbers,
)
from polydraulic.watch.kernels.stays import FLAT, MOVES, RESTS

QUIET = 30  # blocks without an alarm after which it is over
DIAGNOSED = 60  # blocks that a diagnosis is made of: of an alarm, or since its sensor moves again
ALONE = 3  # times as long a sensor stays until that alone is an alarm
NONE, GOES_ON, BEGINS = 0, 1, 2  # what a block means for alarms


@driver
def decide(numbers: WatchNumbers, work: np.ndarray, live: np.ndarray, marks: np.ndarray) -> int:
    """Take the scores of a block: whether there is an alarm, and whether it begins."""
    n, sensors = numbers.directions, numbers.sensors
    white = numbers.in_work + n + n * n
    begin = live[numbers.at_rows + numbers.before * (sensors + 1)]
    began = numbers.in_marks
    flat = began + 2 * n
    states = flat + 2 * sensors + numbers.owners
    worked = states + 2 * sensors
    stood = worked + sensors
    count = marks[BLOCKS] + 1
    marks[BLOCKS] = count
    live[numbers.at_times + ring_place(count - 1)] = begin
    gather(
        work,
        white,
        numbers.together,
        numbers.slow,
        numbers.down,
        numbers.threshold,
        count,
        live,
        numbers.at_sums,
        marks,
        began,
    )
    # in a block in which a sensor begins to move again, it may have stayed at first
    if marks[STUCK] > 0 and named_stay(numbers, marks):
        marks[FIRST] = count
    # the block before which the sensor that stays the longest was not flat
    alone, stays, still = False, 1, count - 1
    for c in range(sensors):
        state = marks[states + c]
        marks[worked + c] += 0 if state == RESTS else 1
        longer = marks[flat + c] + 1 if state == FLAT else (0 if state == MOVES else marks[flat + c])
        marks[stood + c] = count - 1 if longer == 1 and marks[flat + c] == 0 else marks[stood + c]
        marks[flat + c] = longer
        own = longer >= ALONE * numbers.limits[c]
        alone = alone or own
        still = marks[stood + c] if own and longer > stays else still
        stays = longer if own and longer > stays else stays
    beyond = False
    for k in range(2 * n):
        beyond = beyond or live[numbers.at_sums + k] >= numbers.threshold
    if marks[OPENED] >= 0 and count - marks[LAST] > QUIET:
        marks[OPENED] = -1
    if not (beyond or alone):
        return NONE
    after, found = -1, GOES_ON
    if marks[OPENED] >= 0 and beyond:
        behind = behind_unusual_work(numbers, work, live, marks)
        after = marks[FIRST] + DIAGNOSED if behind else -1
        marks[OPENED] = -1 if behind else marks[OPENED]
    if marks[OPENED] < 0:
        opened, most = still, -1.0
        for k in range(2 * n):
            total = live[numbers.at_sums + k]
            more = total >= numbers.threshold and marks[began + k] > after and total > most
            opened = marks[began + k] if more else opened
            most = total if more else most
        marks[OPENED] = max(max(opened, count - KEPT), 0)
        marks[FIRST] = marks[OPENED]
        marks[ALARMS] += 1
        marks[LISTED] = 0
        marks[STUCK] = 0
        live[SINCE] = live[numbers.at_times + ring_place(marks[OPENED])]
        live[SEEN] = begin + float(numbers.inside) * numbers.raster
        found = BEGINS
    marks[LAST] = count
    live[UNTIL] = begin + float(numbers.inside) * numbers.raster
    anew = something_else(numbers, work, live, marks)
    if anew:
        marks[STUCK] = 0
        marks[LISTED] = 0
    if marks[STUCK] == 0 and (count - marks[FIRST] <= DIAGNOSED or marks[LISTED] == 0):
        seen = white + 2 * n
        sum_since(live, numbers.at_sums, n, first_kept(marks[FIRST], count), count, work, seen)
        marks[LISTED] = diagnose(
            work, seen, n, numbers.common, numbers.down, numbers.group, live, numbers.at_chances, marks, SUSPECTS
        )
        marks[TOLD] = count
    name_sensors(numbers, marks)
    follow_course(numbers, work, live, marks)
    return found


@driver
def first_kept(block: int, count: int) -> int:
    """A block, or the first one of which anything is kept."""
    return max(max(block, count - KEPT), 0)


@driver
def behind_unusual_work(numbers: WatchNumbers, work: np.ndarray, live: np.ndarray, marks: np.ndarray) -> bool:
    """Whether tests that began when an alarm of no fault was diagnosed are explained by something else."""
    n, count = numbers.directions, marks[BLOCKS]
    first = count
    for k in range(2 * n):
        began = marks[numbers.in_marks + k]
        later = live[numbers.at_sums + k] >= numbers.threshold and began > marks[FIRST] + DIAGNOSED
        first = min(first, began) if later else first
    no_fault = marks[STUCK] == 0 and marks[LISTED] > 0
    if no_fault:
        no_fault = numbers.harmless[marks[SUSPECTS]] != 0
    if not no_fault or count - first < LEAST_BLOCKS:
        return False
    seen = numbers.in_work + 3 * n + n * n
    sum_since(live, numbers.at_sums, n, first_kept(first, count), count, work, seen)
    listed = diagnose(work, seen, n, numbers.common, numbers.down, numbers.group, work, seen + 3 * n, marks, OTHERS)
    other, suspects = listed > 0, marks[LISTED]
    for k in range(suspects):
        other = other and numbers.group[marks[SUSPECTS + k]] != numbers.group[marks[OTHERS]]
    return other


@driver
def named_stay(numbers: WatchNumbers, marks: np.ndarray) -> bool:
    """Whether a sensor that the alarm is named by had not moved again by the block before."""
    flat = numbers.in_marks + 2 * numbers.directions
    stay = False
    for c in range(numbers.sensors):
        stay = stay or (marks[flat + numbers.sensors + c] != 0 and marks[flat + c] >= numbers.limits[c])
    return stay


@driver
def something_else(numbers: WatchNumbers, work: np.ndarray, live: np.ndarray, marks: np.ndarray) -> bool:
    """Whether blocks since the sensors of an alarm move again are an alarm by themselves."""
    n, count = numbers.directions, marks[BLOCKS]
    if marks[STUCK] == 0 or count - marks[FIRST] < LEAST_BLOCKS:
        return False
    seen = numbers.in_work + 3 * n + n * n
    sum_since(live, numbers.at_sums, n, first_kept(marks[FIRST], count), count, work, seen)
    most = 0.0
    for k in range(n):
        known = work[seen + n + k]
        wide = numbers.together[k] + numbers.slow[k] * known
        most = max(most, best_evidence(work[seen + k], known, wide, numbers.down[k]))
    return most >= numbers.threshold


@driver
def name_sensors(numbers: WatchNumbers, marks: np.ndarray) -> None:
    """Sensors that stay: each for itself after long enough, or sooner if what is suspected is of the same function or circuit."""
    n, sensors, owners = numbers.directions, numbers.sensors, numbers.owners
    flat = numbers.in_marks + 2 * n
    named = flat + sensors
    suspected = named + sensors
    suspects = marks[LISTED]
    for o in range(owners):
        marks[suspected + o] = 0
    for k in range(suspects):
        if marks[STUCK] == 0:
            marks[suspected + numbers.owner[marks[SUSPECTS + k]]] = 1
    for c in range(sensors):
        if marks[STUCK] > 0 and marks[named + c] != 0:
            marks[suspected + numbers.owner[n + c]] = 1
    stuck = 0
    for c in range(sensors):
        stuck += 1 if _stays(numbers, marks, flat, suspected, c) else 0
    if stuck > 0:
        for c in range(sensors):
            marks[named + c] = 1 if _stays(numbers, marks, flat, suspected, c) else 0
        marks[STUCK] = stuck


@driver
def _stays(numbers: WatchNumbers, marks: np.ndarray, flat: int, suspected: int, c: int) -> bool:
    stays = marks[flat + c] >= ALONE * numbers.limits[c]
    for o in range(numbers.owners):
        both = numbers.belongs[c * numbers.owners + o] != 0 and marks[suspected + o] != 0
        stays = stays or (both and marks[flat + c] >= numbers.limits[c])
    return stays
