"""What the numbers of a camera's health mean: what is wrong with it or with the light, and what to do.

The numbers are those that :class:`~epibar.health.CameraHealth` counted over the video, which the recording
keeps.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from .finding import Finding

__all__ = ["camera_findings"]

MANY_BLANKED = 0.05
MUCH_FLICKER = 2.0
"""Grey levels."""
SHAKEN_SHARE = 0.2
FROZEN_SHARE, FROZEN_LEAST, FROZEN_MOST = 0.25, 25, 300
"""A run of one and the same frame counts from this share of the video on, but not below so many frames, and
in any case from so many on: a live camera has noise, and a coded video is refreshed every few seconds."""
DARK_SHARE = 0.5


COUNTED = (
    *("frames", "last_frame", "blanked", "first_blanked", "light_switches", "first_light_switch", "flicker"),
    *("dark", "repeated", "repeated_from", "motion_checks", "shaken", "moves"),
)
MOVED = ("moved_at", "moved_by", "moved_in_all", "gradual", "returned_at", "still_first", "still_last")


def is_counted(health: Mapping[str, float]) -> bool:
    """Whether the numbers are those of a camera that was watched, and not others that somebody kept."""
    names = COUNTED if not health.get("moves") else (*COUNTED, *MOVED)
    return all(name in health for name in names) and health["frames"] > 0


def camera_findings(health: Mapping[str, float]) -> list[Finding]:
    """Say what the numbers of a camera's health mean.

    Parameters
    ----------
    health : mapping of str to float
        :attr:`CameraHealth.numbers`; empty where no image was seen, e.g. for ready masks.
    """
    if not is_counted(health):
        return []
    found = [_moved(health), _shaken(health), _frozen(health), _dark(health), _flicker(health)]
    found += [_light_switches(health), _flooded(health)]
    return [finding for finding in found if finding is not None]


def _moved(health: Mapping[str, float]) -> Finding | None:
    if not health["moves"]:
        return None
    last = int(health["last_frame"])
    part = f"--frames {health['still_first']:.0f}:{health['still_last'] + 1:.0f}"
    if health["gradual"] * 2 > health["moves"]:
        return Finding(
            "drift",
            f"the camera drifts, by about {health['moved_in_all']:.0f} pixels until frame {last}, seen from "
            f"frame {health['moved_at']:.0f} on; fix its mount and film again, or use a shorter part in "
            f"which it stands still, the longest is {part}",
        )
    far = "by a lot" if math.isinf(health["moved_by"]) else f"by about {health['moved_by']:.0f} pixels"
    text = f"the camera moved, {far}, at or shortly before frame {health['moved_at']:.0f}, and "
    use = "use a part in which it stands still, the longest is"
    if health["returned_at"] >= 0:
        text += f"was back by frame {health['returned_at']:.0f}; unless something only hid the view, {use}"
    elif health["moves"] > 1:
        text += f"{health['moves'] - 1:.0f} times more later; {use}"
    else:
        text += (
            "stayed there until the end; use only the frames before or only those after; the longer part is"
        )
    return Finding("moved", f"{text} {part}")


def _shaken(health: Mapping[str, float]) -> Finding | None:
    if health["shaken"] < max(3, SHAKEN_SHARE * health["motion_checks"]) or not health["motion_checks"]:
        return None
    share = health["shaken"] / health["motion_checks"]
    return Finding(
        "shaken",
        f"the camera shakes: at {share:.0%} of the checks the whole view was displaced, and back soon after; "
        "fix its mount, or stabilise the video first",
    )


def _frozen(health: Mapping[str, float]) -> Finding | None:
    run = health["repeated"]
    if run < FROZEN_MOST and run < max(FROZEN_LEAST, FROZEN_SHARE * health["frames"]):
        return None
    start = health["repeated_from"]
    return Finding(
        "frozen",
        f"the picture is frozen: the frames {start:.0f} to {start + run:.0f} are one and the same; leave "
        "them out with --frames, or film again",
    )


def _dark(health: Mapping[str, float]) -> Finding | None:
    share = health["dark"] / health["frames"]
    if share < DARK_SHARE:
        return None
    return Finding(
        "dark",
        f"in {share:.0%} of the frames the picture is all one colour; is the lens covered, or the light off?",
    )


def _flicker(health: Mapping[str, float]) -> Finding | None:
    if health["flicker"] < MUCH_FLICKER:
        return None
    return Finding(
        "flicker",
        f"the light flickers, by {health['flicker']:.1f} of 255 grey levels from frame to frame; set exposure"
        " and gain by hand, and the shutter to a multiple of 1/100 s (50 Hz mains) or 1/120 s (60 Hz)",
    )


def _light_switches(health: Mapping[str, float]) -> Finding | None:
    count = int(health["light_switches"])
    if not count or health["flicker"] >= MUCH_FLICKER:
        return None
    more = f" and {count - 1} times more" if count > 1 else ""
    return Finding(
        "light",
        f"the light changed suddenly at frame {health['first_light_switch']:.0f}{more}; if masks are bad "
        "after it, use only the frames before or after",
        serious=False,
    )


def _flooded(health: Mapping[str, float]) -> Finding | None:
    blanked, frames = health["blanked"], health["frames"]
    if not blanked:
        return None
    first = int(health["first_blanked"])
    text = (
        f"{blanked:.0f} of {frames:.0f} frames, the first of them {first}, were left out: more "
        "than 60 % of the image changed"
    )
    many = blanked > MANY_BLANKED * frames
    if many:
        text += "; did the camera move, does the light flicker, or is somebody right in front of it?"
    return Finding("flooded", text, serious=many)
