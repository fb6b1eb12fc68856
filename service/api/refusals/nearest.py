"""Names that are not known, and the known one that was perhaps meant."""

from collections.abc import Sequence
from difflib import get_close_matches

from service.api.refusals.problems import Fault, printable

MIN_SIMILARITY = 0.5


def unknown_name(field: str, name: str, known: Sequence[str]) -> Fault:
    """Return the fault of a name that is none of the known ones."""
    folded = {each.casefold(): each for each in known}
    near = get_close_matches(name.casefold()[:200], folded, n=1, cutoff=MIN_SIMILARITY)
    hint = f"; did you mean {folded[near[0]]!r}?" if near else ""
    listed = ", ".join(known)
    return Fault(field, f"{printable(name)!r} is not known{hint} (known: {listed})")
