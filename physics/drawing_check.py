"""Drawing check: whether a task of functions draws its start state.

A task without a drawing may raise NotImplementedError.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from physics.drawing import Drawing

if TYPE_CHECKING:
    from physics.environment import Environment


def drawing_mistakes(task: "Environment", state: NDArray[np.float64]) -> list[str]:
    """The mistakes in how a task draws a state [n]."""
    expected = "must return a physics.drawing.Drawing"
    try:
        found = task.draw(state)
    except NotImplementedError:
        return []
    except Exception as error:
        return [f"draw raised {type(error).__name__}: {error}; it {expected} of a state [n]"]
    return [] if isinstance(found, Drawing) else [f"draw {expected}, not {found!r}"]
