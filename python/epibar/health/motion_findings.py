"""What the motion before one camera means: what is wrong with it, and what to do."""

from __future__ import annotations

from .camera_findings import MANY_BLANKED
from .diagnosis import Diagnosis
from .finding import Finding

__all__ = ["motion_findings"]

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
