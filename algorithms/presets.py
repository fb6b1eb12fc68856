"""Presets: the settings the evaluation uses, per algorithm and task, and what chose them.

A submission that names no setting gets these; the settings that it names replace them. On a task of
your own, a hybrid has weights that hurt on none of the tasks here (`Weights.usual`).

ddpg, sac and their hybrids: the best cell, by the area under the normalised curve, of the search in
`service/paper/tuning.py`, over seeds that no evaluation uses. results/tuning.csv has every cell,
with what it reached and its sweep. ddpg and sac have the first choice of the settings, and their
hybrids take those. sac with a learned temperature has settings of its own (`FORMS`). The searches
are shorter than the evaluation.

Weight decay keeps the critic from what CartPole, the swing-up, Acrobot and above all the cheetah
need. The cheetah also gains from an update a step, which was found by hand. Matching the gradient
in the state helps where it is small and smooth (CartPole, MountainCar), and costs where it is large
or jumps (the swing-up, Pendulum's wrapped angle, the die's bounces). MassPoint's weights were tried
by hand, 12,000 timesteps, seeds 100 to 107: area -4.0 for (0, 0), -4.7 for (1, 0), -4.8 for
(0.1, 0.1), -11.1 for (1, 1), -22.9 for (0, 1).

The usual weights, area under the normalised curve, hybrid minus baseline, 8 seeds, presets of the
baseline, after the unit of Q was mended: of hybrid-ddpg (1, 0) Pendulum +.078, MountainCar +.001,
Acrobot -.026, CartPole +.007, RollingDie +.043, the swing-up +.094; of the cosine (.01, .01) +.004,
+.008, +.069, +.036, +.047, +.099; of hybrid-sac (.1, .1) Pendulum +.024 (10,000 timesteps),
CartPole +.005 (16,000), MountainCar +.013 (10,000), the swing-up +.021 (20,000); of (1, 0) +.009,
.000, -.008, +.022; of (.1, 0) +.024, -.006, -.006, -.001.

hybrid-ddpg-robust and hybrid-td3 have one pair of weights for all tasks, (1, .1);
results/trials.csv has what was tried of it. td3 has its authors' settings until its search
has come to an end.

gd and mpc, tuning seeds 100 to 103: normalised return. For gd the area under the curve and the
mean of the last ten measurements, 40,000 timesteps or until the plateau, one episode an update
(four were no better):

    rate               0.0001       0.0003       0.001        0.003        0.01
    CartPole                        .919 1.000   .962 1.000   .975 1.000
    CartPoleSwingUp    .033 .107    .177 .295    .210 .256    .113 .129    .021 -.000
    Pendulum                        .074 .103    .108 .123    .070 .034    .009 -.076
    MountainCar                                  .612 .698    .665 .722    .693 .730
    RollingDie         .027 .012   -.040 -.113   .021 -.030   .009 .046
    HalfCheetah                     .113 .212    .209 .300    .078 .080
    MassPoint (12,000)                           .840 .906    .896 .907

For mpc what the episode earned, by horizon and iterations an action, and the thousands of
timesteps it took. One iteration an action is enough but on the cheetah, where plans get stuck; the
differences there are of the size of those between seeds (0.18 to 0.38). A longer horizon than
needed is worse where the task is to swing up or to run.

    CartPoleSwingUp   50, 1: .009    60, 1: .899 (292)   75, 1: .899 (350)    75, 3: .903 (578)
                      100, 1: .884 (439)   100, 5: .904 (771)   100, 3: .901 (642), 16 seeds
    Pendulum          15, 1: .899 (30)     30, 1: .901 (51)    50, 1: .834    100, 1: .627
    CartPole          50, 1: 1.000 (83)    50, 5: 1.000 (87)
    MountainCar       50, 1: .721 (27)     100, 1: .747 (17)   200, 1: .748 (32)
    MassPoint         25, 1: .899 (8)      60, 1: .902 (34)
    RollingDie        50, 1: .405 (69)     100, 1: .512 (106)  100, 20: .507 (995)
    HalfCheetah       20, 1: .184 (42)     30, 2: .238 (123)   30, 3: .280 (179)
                      20, 5: .157 (204)    30, 6: .268 (331)   30, 12: .322 (560)
                      40, 1: .191 (80)     50, 10: .242 (817)  30, 30: .283 (862)

The swing-up's horizon has a margin over the trials: at 75 all seeds from 100 to 115 swing up, but
two of those from 0 to 15 hang still.

Their timesteps are more than an episode can take, so that it is always planned to its end.

shac and ppo, tuning seeds 100 to 103, timesteps as those of ddpg: mean of return_mean over the run,
and over its last tenth. Few environments and short windows make many updates of few timesteps;
shac's own defaults, 64 times 32 steps at 0.002, make ten updates in Pendulum's 20,000. For shac
environments, window, rate of the actor; `+` a critic's rate of 0.005 and a noise of 1:

    shac               4, 32, .01     4, 32, .002    8, 16, .005    16, 32, .01    16, 32, .005 +
    CartPole           194 200        196 200        198 200        188 200        190 200
    CartPoleSwingUp     21 7           15 7           45 108         86 117        113 152
    Pendulum         -1013 -772     -1060 -1004    -1066 -734     -1217 -1026    -1218 -1156
    MountainCar       -133 -106      -120 -105      -122 -107      -139 -117      -139 -113
    Acrobot           -171 -89        -88 -83        -84 -80        -96 -87       -100 -93
    RollingDie        -481 -438      -516 -473      -503 -489      -467 -428      -463 -385
    HalfCheetah        154 207        150 222        336 477         43 129
    MassPoint         -3.7 -3.7      -4.2 -3.7      -3.8 -3.7      -4.8 -3.7

and 8, 16, .005 + on RollingDie -444 -396, on the swing-up 11 20, on Pendulum -1108 -710.

    ppo                8, 256, .0003  4, 128, .001
    CartPole           188 200        197 200
    CartPoleSwingUp    295 398        276 352
    Pendulum         -1155 -1048     -646 -314
    MountainCar       -234 -116      -143 -103
    Acrobot           -241 -98       -163 -125
    RollingDie        -486 -442      -483 -457
    HalfCheetah        577 835        581 689
    MassPoint          -20 -7        -6.7 -3.8

But for the columns with `+`, these trials set the unit of values after a fit, not before it. The
presets again, as the code is, in the same order of tasks: shac 198, 113, -1030, -119, -86, -444,
336, -3.7; ppo 197, 277, -553, -144, -206, -491, 578, -6.7.

On the swing-up shac learns to swing up in some runs only: where the cart leaves the track, the task
ends and what is lost has no gradient. Pendulum it solves in 100,000 timesteps or so (4, 32, .01:
-150 in all of three runs).

Those of Hopper and Walker2d are the cheetah's, and for mpc a plan of 0.5 s; those of BallWall are
the die's: nothing was searched for there yet.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from algorithms import catalogue
from physics.parameter import name_of

NO_WEIGHTS = (0.0, 0.0)
SMALLEST_WEIGHT, LARGEST_WEIGHT = 1e-30, 1e30
"""Of weights other than 0: beyond, they are 0 or infinite in float32."""
USUAL_TIMESTEPS = 40_000


@dataclass(frozen=True)
class Preset:
    """The settings of one algorithm on one task.

    Attributes:
        weights: (w1, w2), of the action and state gradient terms.
        timesteps: environment steps of a run.
        config: settings other than the algorithm's defaults.
    """

    weights: tuple[float, float] = NO_WEIGHTS
    timesteps: int = USUAL_TIMESTEPS
    config: Mapping[str, Any] = field(default_factory=dict)


def planned(horizon: int, timesteps: int, iterations: int = 1) -> Preset:
    """A preset of mpc."""
    return Preset(timesteps=timesteps, config={"horizon": horizon, "iterations": iterations})


TIMESTEPS = {
    "MassPoint": 12_000,
    "CartPole": 60_000,
    "CartPoleSwingUp": 160_000,
    "Pendulum": 20_000,
    "MountainCar": 40_000,
    "Acrobot": 80_000,
    "RollingDie": 60_000,
    "HalfCheetah": 200_000,
    "Hopper": 200_000,
    "Walker2d": 200_000,
    "BallWall": 60_000,
}
"""Of the learners with a value function: enough for ddpg to converge."""

SETTINGS: Mapping[str, Mapping[str, Mapping[str, Any]]] = {
    "ddpg": {
        "MassPoint": {"noise": 0.2, "critic_decay": 0.01},
        "CartPole": {"noise": 0.2, "critic_decay": 0.0},
        "CartPoleSwingUp": {"noise": 0.4, "critic_decay": 0.0},
        "Pendulum": {"noise": 0.6, "critic_decay": 0.01},
        "MountainCar": {"noise": 0.6, "critic_decay": 0.01},
        "Acrobot": {"noise": 0.4, "critic_decay": 0.0},
        "RollingDie": {"noise": 0.4, "critic_decay": 0.01},
        "HalfCheetah": {"noise": 0.2, "critic_decay": 0.0, "cycle_updates": 100},
        "Hopper": {"noise": 0.2, "critic_decay": 0.0, "cycle_updates": 100},
        "Walker2d": {"noise": 0.2, "critic_decay": 0.0, "cycle_updates": 100},
        "BallWall": {"noise": 0.4, "critic_decay": 0.01},
    },
    "td3": {},
    "shac": {
        "CartPoleSwingUp": {
            "environments": 16,
            "actor_rate": 0.005,
            "critic_rate": 0.005,
            "noise": 1.0,
        },
        "Pendulum": {"environments": 4, "actor_rate": 0.01},
        "RollingDie": {
            "environments": 8,
            "window": 16,
            "actor_rate": 0.005,
            "critic_rate": 0.005,
            "noise": 1.0,
        },
        "MassPoint": {"environments": 4, "actor_rate": 0.01},
    },
    "ppo": {"CartPoleSwingUp": {}, "HalfCheetah": {}},
    "sac": {
        "CartPole": {"reward_scale": 3.0},
        "CartPoleSwingUp": {"reward_scale": 10.0},
        "Pendulum": {"reward_scale": 3.0},
        "MountainCar": {"reward_scale": 10.0},
        "RollingDie": {"reward_scale": 10.0},
    },
}


@dataclass(frozen=True)
class Form:
    """A form of a learner: what states it, and the settings chosen for it.

    Attributes:
        name: as tables show it.
        stated: the settings that make a run one of this form.
        chosen: by task, in place of those of `SETTINGS`; the defaults on any other task.
    """

    name: str
    stated: Mapping[str, Any]
    chosen: Mapping[str, Mapping[str, Any]]


FORMS: Mapping[str, tuple[Form, ...]] = {
    "sac": (Form("learned temperature", {"temperature": "learned"}, {}),),
}
"""Of a learner and of its hybrids."""

USUAL_SETTINGS: Mapping[str, Mapping[str, Any]] = {
    "shac": {"environments": 8, "window": 16, "actor_rate": 0.005},
    "ppo": {"environments": 4, "window": 128, "rate": 0.001},
}
"""On a task that none were chosen for; of other learners, the defaults."""


@dataclass(frozen=True)
class Weights:
    """The weights (w1, w2) of a hybrid, whose other settings are those of what it extends.

    Attributes:
        usual: on a task that none were chosen for.
        chosen: by task.
    """

    usual: tuple[float, float]
    chosen: Mapping[str, tuple[float, float]]


WEIGHTS: Mapping[str, Weights] = {
    "hybrid-ddpg": Weights(
        (1.0, 0.0),
        {
            "MassPoint": (1.0, 0.0),
            "CartPole": (1.0, 1.0),
            "CartPoleSwingUp": (1.0, 0.0),
            "Pendulum": (1.0, 0.01),
            "MountainCar": (0.1, 1.0),
            "Acrobot": (1.0, 0.01),
            "RollingDie": (1.0, 0.0),
            "HalfCheetah": (0.0, 0.01),
        },
    ),
    "hybrid-ddpg-cosine": Weights(
        (0.01, 0.01),
        {
            "CartPole": (0.0, 0.01),
            "CartPoleSwingUp": (0.01, 0.0),
            "Pendulum": (0.01, 0.0),
            "MountainCar": (0.1, 0.1),
            "Acrobot": (1.0, 1.0),
            "RollingDie": (0.01, 0.0),
            "HalfCheetah": (0.0, 0.01),
        },
    ),
    "hybrid-ddpg-robust": Weights((1.0, 0.1), {}),
    "hybrid-td3": Weights((1.0, 0.1), {}),
    "hybrid-sac": Weights(
        (0.1, 0.1),
        {
            "CartPole": (1.0, 1.0),
            "CartPoleSwingUp": (0.1, 0.0),
            "Pendulum": (0.01, 0.01),
            "MountainCar": (1.0, 1.0),
            "RollingDie": (1.0, 0.0),
        },
    ),
}

ALONE: Mapping[tuple[str, str], Preset] = {
    ("gd", "MassPoint"): Preset(timesteps=12_000, config={"rate": 0.003}),
    ("gd", "CartPole"): Preset(config={"rate": 0.003}),
    ("gd", "CartPoleSwingUp"): Preset(config={"rate": 0.0003}),
    ("gd", "Pendulum"): Preset(config={"rate": 0.001}),
    ("gd", "MountainCar"): Preset(config={"rate": 0.01}),
    ("gd", "RollingDie"): Preset(config={"rate": 0.001}),
    ("gd", "HalfCheetah"): Preset(config={"rate": 0.001}),
    ("gd", "Hopper"): Preset(config={"rate": 0.001}),
    ("gd", "Walker2d"): Preset(config={"rate": 0.001}),
    ("gd", "BallWall"): Preset(config={"rate": 0.001}),
    ("mpc", "MassPoint"): planned(horizon=60, timesteps=120_000),
    ("mpc", "CartPole"): planned(horizon=50, timesteps=100_000),
    ("mpc", "CartPoleSwingUp"): planned(horizon=100, iterations=3, timesteps=1_488_000),
    ("mpc", "Pendulum"): planned(horizon=30, timesteps=64_000),
    ("mpc", "MountainCar"): planned(horizon=100, timesteps=168_000),
    ("mpc", "RollingDie"): planned(horizon=100, timesteps=112_000),
    ("mpc", "HalfCheetah"): planned(horizon=30, iterations=12, timesteps=736_000),
    ("mpc", "Hopper"): planned(horizon=60, timesteps=1_600_000),
    ("mpc", "Walker2d"): planned(horizon=60, timesteps=1_600_000),
    ("mpc", "BallWall"): planned(horizon=60, timesteps=112_000),
}


def preset(algorithm: str, environment: str) -> Preset:
    """The preset of an algorithm on a task, also on one that nothing was chosen for.

    Values of the task's parameters, as in `Pendulum(gravity=9.81)`, are of no account. A hybrid
    matches gradients on every task. It has its baseline's timesteps there, and its settings where
    it has none of its own.
    """
    environment = name_of(environment)
    if (algorithm, environment) in ALONE:
        return ALONE[algorithm, environment]
    matched = WEIGHTS.get(algorithm)
    owner = algorithm if algorithm in SETTINGS else catalogue.baseline(algorithm)
    if owner not in SETTINGS:
        return Preset()
    return Preset(
        weights=matched.chosen.get(environment, matched.usual) if matched else NO_WEIGHTS,
        timesteps=TIMESTEPS.get(environment, USUAL_TIMESTEPS),
        config=SETTINGS[owner].get(environment, USUAL_SETTINGS.get(owner, {})),
    )


def form(algorithm: str, config: Mapping[str, Any]) -> Form | None:
    """The form that settings state; None for the algorithm's own."""
    forms = FORMS.get(catalogue.baseline(algorithm) or algorithm, ())
    return next((one for one in forms if one.stated.items() <= config.items()), None)


def completed(algorithm: str, environment: str, config: Mapping[str, Any]) -> dict[str, Any]:
    """The settings of a run: those of the preset, or of the form given, replaced by those given."""
    stated = form(algorithm, config)
    if stated is None:
        return {**preset(algorithm, environment).config, **config}
    return {**stated.chosen.get(name_of(environment), {}), **config}
