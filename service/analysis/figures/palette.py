"""Colours of algorithms: bound to the name, so that a figure's order never changes them.

The Okabe-Ito palette (Okabe and Ito, 2008), told apart by the colour-blind. Curves of one colour
differ in their dashes. web/static/parts/palette.js has both too.
"""

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

COLOURS = {
    "ddpg": BLUE,
    "hybrid-ddpg": VERMILION,
    "hybrid-ddpg-cosine": PURPLE,
    "sac": SKY_BLUE,
    "hybrid-sac": ORANGE,
    "gd": GREEN,
    "mpc": BLACK,
}
OTHERS = (YELLOW, *COLOURS.values())


def colour(algorithm: str) -> str:
    """Return an algorithm's colour; one that others added gets one by its name."""
    return COLOURS.get(algorithm) or OTHERS[zlib.crc32(algorithm.encode()) % len(OTHERS)]


def dash(variant: int) -> str | Dash:
    """Return the line of the n-th curve of a colour: whole, dashed, dotted, then dots in dashes."""
    match variant:
        case 0:
            return "solid"
        case 1:
            return (0, (5, 2))
        case 2:
            return (0, (1, 1.5))
        case _:
            return (0, (5, 2, *((1, 2) * (variant - 2))))
