"""What is wrong with one camera, in plain English, and what to do about it.

:func:`camera_findings` reads the numbers that :class:`~epibar.camera_health.CameraHealth` counted over the
video, which the recording keeps; :func:`motion_findings` what moved, as :mod:`epibar.diagnosis` measured it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .diagnosis import Diagnosis

__all__ = ["Finding", "camera_findings", "motion_findings"]

MANY_BLANKED = 0.05
MUCH_FLICKER = 2.0
"""Grey levels."""
SHAKEN_SHARE = 0.2
FROZEN_SHARE, FROZEN_LEAST, FROZEN_MOST = 0.25, 25, 300
"""A run of one and the same frame counts from this share of the video on, but not below so many frames, and
in any case from so many on: a live camera has noise, and a coded video is refreshed every few seconds."""
DARK_SHARE = 0.5
FEW_FRAMES = 100
RARE_MOTION = 0.1
FEW_LINES = 0.01
"""Of those drawn. One walker alone in 400 frames leaves 0.5 to 2 %, two 5 %."""
CROWDED = 0.1
"""Of the lines that are crossed often enough, those that are also free often enough."""
SMALL_PART = 0.04
STRAIGHT = 0.009
"""Of the image diagonal. One path strays by 0.4 to 0.7 %, two people under a low camera by 1.1 %."""
MANY_CUT = 0.8


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong.

    Attributes
    ----------
    kind : str
        One machine-readable word.
    text : str
        What it is and what to do, in plain English.
    serious : bool
        It can by itself be why a pair is refused.
    """

    kind: str
    text: str
    serious: bool = True


def camera_findings(health: Mapping[str, float]) -> list[Finding]:
    """Say what the numbers of a camera's health mean.

    Parameters
    ----------
    health : mapping of str to float
        :attr:`CameraHealth.numbers`; empty where no image was seen, e.g. for ready masks.
    """
    if not health:
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
    if health["shaken"] < 3 or health["shaken"] < SHAKEN_SHARE * health["motion_checks"]:
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


def motion_findings(seen: Diagnosis) -> list[Finding]:
    """Say what the motion of one camera means."""
    found = []
    if not seen.health and seen.flooded_frames > MANY_BLANKED:
        found.append(_white(seen))
    lines = seen.lines
    crowded = lines["crossed"] > lines["drawn"] / 4 and lines["free"] < CROWDED * lines["crossed"]
    if seen.moving_frames == 0:
        found.append(
            Finding(
                "no_motion",
                "nothing moves in any frame; film while people walk about, or, if these are masks, make "
                "white what moves",
            )
        )
        return found
    if crowded:
        found.append(
            Finding(
                "crowded",
                f"something moves everywhere all the time: of {lines['crossed']} lines that motion crosses "
                f"only {lines['free']} are free of it long enough; film when fewer people are about, or from "
                "higher up",
            )
        )
    elif seen.moving_frames < RARE_MOTION or lines["informative"] < FEW_LINES * lines["drawn"]:
        found.append(
            Finding(
                "little_motion",
                f"there is too little motion: something moves in {seen.moving_frames:.0%} of the frames, and "
                f"only {lines['informative']} of {lines['drawn']} lines are crossed by it again and again; "
                "film for longer, or when more people are about",
            )
        )
    if seen.straightness < STRAIGHT:
        found.append(
            Finding(
                "one_path",
                "everything moves on one straight path, and that does not determine the geometry; film while "
                "people also walk elsewhere",
            )
        )
    if seen.spread < SMALL_PART:
        found.append(
            Finding(
                "small_part",
                f"motion is in only a small part of the image, 95 % of it in {seen.spread:.1%}, and the "
                "geometry will be known only there; zoom in, or film while people also walk elsewhere",
                serious=False,
            )
        )
    if seen.cut > MANY_CUT:
        found.append(
            Finding(
                "cut",
                f"the border of what is seen cuts {seen.cut:.0%} of the silhouettes, and cut outlines say "
                "little; move the camera back, or zoom out",
                serious=False,
            )
        )
    if seen.frames < FEW_FRAMES:
        found.append(
            Finding(
                "short", f"there are only {seen.frames} frames; several hundred are better", serious=False
            )
        )
    return found


def _white(seen: Diagnosis) -> Finding:
    return Finding(
        "flooded",
        f"in {seen.flooded_frames:.0%} of the masks more than 60 % of the image is white; are they inverted? "
        "White must be what moves",
    )
