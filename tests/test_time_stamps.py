"""Seconds of frames by the stamps of a container, whatever these do."""

import numpy as np
import pytest

from epibar.sources.time_stamps import TimeStamps


def seconds(stamps, fps=25.0):
    clock = TimeStamps(fps, stamps[0])
    return np.array([0.0, *(clock.at(stamp) for stamp in stamps[1:])]), clock


def regular(count, step=0.04, start=0.0):
    return [start + step * k for k in range(count)]


def test_stamps_that_make_sense_are_the_times():
    stamps = np.cumsum([0.5, 0.04, 0.033, 0.04, 0.5, 59.0, 0.04])
    times, clock = seconds(list(stamps))
    np.testing.assert_allclose(times, stamps - stamps[0], atol=1e-12)
    assert clock.replaced == 0


def test_a_pause_that_is_too_long_is_left_out_and_stamps_count_again():
    stamps = regular(20, 0.033) + regular(50, 0.08, start=500.0)
    times, clock = seconds(stamps, fps=0.14)
    assert clock.replaced == 1
    np.testing.assert_allclose(np.diff(times)[20:], 0.08, atol=1e-9)
    assert np.diff(times)[19] == pytest.approx(0.033)
    assert clock.span == pytest.approx(500.0 + 49 * 0.08)


def test_stamps_that_begin_anew_go_on():
    times, clock = seconds(regular(100) + regular(100, 0.08))
    np.testing.assert_allclose(np.diff(times)[100:], 0.08, atol=1e-9)
    assert times[-1] == pytest.approx(99 * 0.04 + 0.04 + 99 * 0.08)
    assert clock.replaced == 1


@pytest.mark.parametrize("late", [0.3, 5.0, 90.0])
def test_after_one_stamp_that_is_too_late_the_others_are_caught_up_with(late):
    stamps = regular(300)
    stamps[50] += late
    times, _ = seconds(stamps)
    assert np.all(np.diff(times) > 0)
    after = 60 + int(late / 0.036) if late < 60 else 60
    np.testing.assert_allclose(times[after:], regular(300)[after:], atol=1e-9)


def test_stamps_that_stand_still_are_no_late_ones():
    times, _ = seconds(regular(100) + [99 * 0.04] * 1000 + regular(50, start=99 * 0.04 + 0.04))
    np.testing.assert_allclose(np.diff(times), 0.04, atol=1e-9)
    times, _ = seconds([stamp for stamp in regular(50, 0.08) for _ in range(2)])
    np.testing.assert_allclose(np.diff(times), 0.04, atol=1e-9)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_some_that_are_too_early_shift_nothing_after_them(count):
    stamps = regular(100)
    stamps[50 : 50 + count] = [stamp - 1.0 for stamp in stamps[50 : 50 + count]]
    times, _ = seconds(stamps)
    np.testing.assert_allclose(times, regular(100), atol=1e-9)


def test_without_stamps_frames_follow_at_the_rate():
    times, clock = seconds([0.0] * 10)
    np.testing.assert_allclose(times, regular(10), atol=1e-12)
    assert clock.replaced == 9
    times, _ = seconds([0.0, *[float("nan")] * 4], fps=10.0)
    np.testing.assert_allclose(times, regular(5, 0.1), atol=1e-12)


def test_time_that_passes_without_frames_counts():
    clock = TimeStamps(10.0, 0.0)
    clock.at(0.1)
    clock.go_on(3.0, 77.0)
    assert clock.at(77.0) == pytest.approx(3.2)
    assert clock.at(77.1) == pytest.approx(3.3)
