"""Waiting for conditions; the tests of the nodes never wait for a time."""
import threading
import time

POLL_PERIOD = 0.002  # s
DEADLINE = 30.0  # s of wall time; a loaded machine needs some


def wait_until(condition, what, timeout=DEADLINE):
    """Returns what `condition()` returns as soon as that is true; fails saying `what` did not happen."""
    value = soon(condition, timeout)
    if not value:
        raise AssertionError("waited %.1f s in vain until %s" % (timeout, what() if callable(what) else what))
    return value


def soon(condition, timeout):
    """Returns what `condition()` returns as soon as that is true, or at the latest after `timeout` (s)."""
    end = time.monotonic() + timeout
    pause = threading.Event()
    while True:
        value = condition()
        if value or time.monotonic() > end:
            return value
        pause.wait(POLL_PERIOD)
