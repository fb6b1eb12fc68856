"""Colours of algorithms: bound to the name, so that a figure's order never changes them.

The Okabe-Ito palette (Okabe and Ito, 2008), told apart by the colour-blind.
"""

import zlib

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
