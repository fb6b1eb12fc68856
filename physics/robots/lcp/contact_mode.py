"""The four modes in which a constraint can be, and what each leaves of it.

    OPEN         no impulse; it does not close
    STICK        no normal velocity and, with friction, no slip; the impulse is inside the cone
    SLIDE_AHEAD  no normal velocity, slip towards +, `pt = -mu pn`
    SLIDE_BACK   no normal velocity, slip towards -, `pt = +mu pn`

A constraint without friction is OPEN or STICK.
"""

OPEN, STICK, SLIDE_AHEAD, SLIDE_BACK = 0, 1, 2, 3
