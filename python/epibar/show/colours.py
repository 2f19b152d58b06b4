"""Colours in which plots, the report and the live view show what belongs together.

Told apart by most colour-blind eyes too (Okabe and Ito), the dark ones lightened.
"""

__all__ = ["HEX", "RGB"]

RGB = [
    (230, 159, 0),
    (86, 180, 233),
    (0, 190, 115),
    (240, 228, 66),
    (30, 130, 220),
    (235, 94, 40),
    (204, 121, 190),
    (245, 245, 245),
]
HEX = [f"#{red:02x}{green:02x}{blue:02x}" for red, green, blue in RGB]
