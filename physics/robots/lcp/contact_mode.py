"""The four modes of a constraint, and what holds in each.

    OPEN         no impulse; it does not close
    STICK        no normal velocity and, with friction, no slip; the impulse is inside the cone
    SLIDE_AHEAD  no normal velocity, slip towards +, `pt = -mu pn`
    SLIDE_BACK   no normal velocity, slip towards -, `pt = +mu pn`

A constraint without friction is OPEN or STICK.
"""

OPEN, STICK, SLIDE_AHEAD, SLIDE_BACK = 0, 1, 2, 3
