"""What tests of several files look at."""

import threading

import pytest

import trueaxis


def refused(call):
    """The one line in which a call is refused."""
    with pytest.raises(trueaxis.Error) as caught:
        call()
    text = str(caught.value)
    assert text and "\n" not in text
    return text


def assert_lock_is_released(work):
    """Python goes on while work is done in another thread."""
    ended, ticks = threading.Event(), 0

    def run():
        work()
        ended.set()

    thread = threading.Thread(target=run)
    thread.start()
    while not ended.wait(0.001):
        ticks += 1
    thread.join()
    assert ticks > 20
