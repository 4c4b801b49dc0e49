import pytest

from polydraulic import terminal


@pytest.mark.parametrize(("patience", "shown"), [(60.0, False), (0.0, True)])
def test_progress_appears_only_when_work_takes_long(capsys, patience, shown):
    with terminal.steps("work", 2, patience=patience) as begin:
        begin("first")
        if shown:
            import time

            time.sleep(0.2)  # the timer's thread needs a moment
        begin("second")
    with terminal.counted("draw", patience=patience) as update:
        update(3, 3)
    assert ("2/2" in capsys.readouterr().err) is shown


def test_an_error_ends_the_progress():
    with pytest.raises(ValueError, match="mine"), terminal.steps("work", 1, patience=60.0):
        raise ValueError("mine")
