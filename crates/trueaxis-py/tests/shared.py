"""Checks that several test files use."""

import threading

import pytest

import trueaxis


def refused(call, kind=trueaxis.Error):
    """Asserts that a call raises an error of one line; returns the line."""
    with pytest.raises(kind) as caught:
        call()
    text = str(caught.value)
    assert text and "\n" not in text
    return text


def assert_lock_is_released(work):
    """Asserts that Python continues while another thread works."""
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
