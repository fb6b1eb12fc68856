"""Colours of algorithms: bound to the name, so that a figure's order never changes them.

The Okabe-Ito palette (Okabe and Ito, 2008), told apart by the colour-blind, and darker colours for
the learners beyond its eight. Curves of one algorithm are shades of its colour, and differ by their
dashes too. web/static/parts/palette.js has the same.
"""

import colorsys
import zlib

Dash = tuple[int, tuple[float, ...]]

BLACK = "#000000"
ORANGE = "#E69F00"
SKY_BLUE = "#56B4E9"
GREEN = "#009E73"
YELLOW = "#F0E442"
BLUE = "#0072B2"
VERMILION = "#D55E00"
PURPLE = "#CC79A7"
BROWN = "#A0623A"
VIOLET = "#7A5FD0"
OLIVE = "#8A8A00"
TEAL = "#1B6E6E"
GREY = "#808080"

COLOURS = {
    "ddpg": BLUE,
    "hybrid-ddpg": VERMILION,
    "hybrid-ddpg-cosine": PURPLE,
    "hybrid-ddpg-robust": BROWN,
    "td3": VIOLET,
    "hybrid-td3": OLIVE,
    "sac": SKY_BLUE,
    "hybrid-sac": ORANGE,
    "gd": GREEN,
    "shac": TEAL,
    "ppo": GREY,
    "mpc": BLACK,
}
DASHES: tuple[str | Dash, ...] = ("solid", (0, (5, 2)), (0, (1, 1.5)), (0, (5, 2, 1, 2)))
LIGHTNESS = (0.66, 0.28)
"""Of the first and the last shade."""
OTHERS = (YELLOW, *COLOURS.values())


def colour(algorithm: str) -> str:
    """Return an algorithm's colour; one that others added gets one by its name."""
    return COLOURS.get(algorithm) or OTHERS[zlib.crc32(algorithm.encode()) % len(OTHERS)]


def shades(colour: str, count: int) -> list[str]:
    """Return shades of a colour, from light to dark; a single one is the colour itself."""
    if count < 2:
        return [colour]
    red, green, blue = (int(colour[place : place + 2], 16) / 255 for place in (1, 3, 5))
    hue, _, saturation = colorsys.rgb_to_hls(red, green, blue)
    first, last = LIGHTNESS
    tints = [
        colorsys.hls_to_rgb(hue, first + (last - first) * place / (count - 1), saturation)
        for place in range(count)
    ]
    return ["#" + "".join(f"{int(255 * part + 0.5):02x}" for part in tint) for tint in tints]


def dash(variant: int) -> str | Dash:
    """Return the line of the n-th curve of an algorithm."""
    return DASHES[variant % len(DASHES)]
