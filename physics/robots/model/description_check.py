"""Description check: finds all mistakes in a robot's description at once."""

from collections.abc import Iterator

from physics.robots.model.description import Link, Robot


def mistakes(robot: Robot) -> list[str]:
    """All mistakes that prevent the simulation of a robot."""
    found = [mistake for link in robot.links for mistake in _in_link(link)]
    found += _in_tree(robot)
    if not robot.total_mass > 0.0:
        found.append(f"total_mass must be above 0 kg, not {robot.total_mass}")
    if not robot.friction >= 0.0:
        found.append(f"friction must be at least 0, not {robot.friction}")
    return found


def _in_tree(robot: Robot) -> Iterator[str]:
    """Mistakes in the tree of links."""
    if not robot.links or robot.links[0].parent is not None:
        yield "the first link must be the root, whose parent is None"
    known: set[str] = set()
    for index, link in enumerate(robot.links):
        if link.name in known:
            yield f"two links are called {link.name!r}"
        if index and link.parent not in known:
            before = ", ".join(map(repr, known))
            yield f"the parent of {link.name!r} must be one of {before}, not {link.parent!r}"
        known.add(link.name)


def _in_link(link: Link) -> Iterator[str]:
    """Mistakes in one link."""
    if not link.capsules:
        yield f"{link.name!r} has no capsule, so it has no mass"
    for capsule in link.capsules:
        if not (capsule.radius > 0.0 and capsule.half_length >= 0.0):
            yield f"the capsule {capsule.name!r} needs a radius above 0 and no negative length"
    if (link.joint is None) != (link.parent is None):
        yield f"{link.name!r} must have a joint if and only if it has a parent"
    if link.joint is not None and not link.joint.lower < link.joint.upper:
        yield f"the stops of {link.name!r} must be lower < upper"
    if link.joint is not None and abs(link.joint.axis) != 1.0:
        yield f"the axis of {link.name!r} must be 1 or -1, not {link.joint.axis}"
