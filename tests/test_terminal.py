import time

import pytest

from polydraulic import terminal


@pytest.mark.parametrize(("patience", "shown"), [(60.0, False), (0.0, True)])
def test_progress_appears_only_when_work_takes_long(capsys, patience, shown):
    with terminal.progress_bar("work", patience=patience) as progress:
        progress("first", 0, 2)
        if shown:
            time.sleep(0.2)  # the timer's thread needs a moment
        progress("second", 2, 2)
    printed = capsys.readouterr().err
    assert ("2/2" in printed) is shown
    assert ("second" in printed) is shown


def test_an_error_ends_the_progress():
    with pytest.raises(ValueError, match="mine"), terminal.progress_bar("work", patience=60.0):
        raise ValueError("mine")
