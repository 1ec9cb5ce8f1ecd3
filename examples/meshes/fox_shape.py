"""The shape of the fox under its fur, in metres; it sits on the ground, y = 0. Rows of curves are (x, y, z, radius)."""

from __future__ import annotations

from sculpt import CUT, Sculpture, both_sides

NOSE = (0, 0.3395, 0.1800)
EYE = (0.0285, 0.3690, 0.1065)
TAIL = [(0, 0.060, -0.100, 0.026), (0.045, 0.046, -0.148, 0.030), (0.110, 0.040, -0.160, 0.034),
        (0.158, 0.040, -0.105, 0.037), (0.168, 0.038, -0.025, 0.036), (0.150, 0.034, 0.050, 0.029),
        (0.122, 0.028, 0.100, 0.017), (0.104, 0.024, 0.124, 0.008)]  # fmt: skip
EAR = [(0.036, 0.400, 0.052, 0.0270), (0.050, 0.440, 0.047, 0.0190), (0.0605, 0.474, 0.043, 0.0060)]
MOUTH = [(0, 0.3290, 0.1745), (0.0060, 0.3255, 0.1680), (0.0140, 0.3270, 0.1480), (0.0230, 0.3310, 0.1250)]


def fox() -> Sculpture:
    """The whole animal, its tail laid round its right side."""
    s = Sculpture()
    body(s)
    legs(s)
    s.tube(TAIL, 0.020)
    skull(s)
    muzzle(s)
    features(s)
    s.keep_above(0.001, 0.006)
    return s


def body(s: Sculpture) -> None:
    """Rump, trunk, chest and neck."""
    s.ball((0, 0.088, -0.055), (0.078, 0.086, 0.082), 0)
    s.tube([(0, 0.110, -0.050, 0.076), (0, 0.185, -0.012, 0.066), (0, 0.250, 0.022, 0.054), (0, 0.305, 0.040, 0.044),
            (0, 0.345, 0.052, 0.042)], 0.050)  # fmt: skip
    s.ball((0, 0.205, 0.042), (0.050, 0.066, 0.042), 0.040)


def legs(s: Sculpture) -> None:
    """Thighs and hind feet, fore legs and paws, with lines between the toes."""
    s.ball((0.060, 0.072, -0.018), (0.034, 0.062, 0.068), 0.030, turn=(-18, 0, 0), mirror=True)
    s.tube([(0.074, 0.030, -0.030, 0.020), (0.078, 0.017, 0.010, 0.0165), (0.078, 0.0155, 0.050, 0.0155)],
           0.020, mirror=True)  # fmt: skip
    s.ball((0.078, 0.0165, 0.062), (0.0195, 0.0165, 0.0260), 0.012, mirror=True)
    s.tube([(0.034, 0.205, 0.040, 0.030), (0.037, 0.130, 0.062, 0.0200), (0.036, 0.070, 0.072, 0.0158),
            (0.035, 0.022, 0.076, 0.0150)], 0.025, mirror=True)  # fmt: skip
    s.ball((0.035, 0.0170, 0.088), (0.0200, 0.0170, 0.0250), 0.012, mirror=True)
    for x, front in ((0.035, 0.113), (0.078, 0.088)):
        for side in (-0.0068, 0.0068):
            s.crease([(x + side, 0.0020, front, 0.0030), (x + 1.1 * side, 0.0200, front - 0.004, 0.0032),
                      (x + 1.1 * side, 0.0330, front - 0.018, 0.0026)], 0.0030, mirror=True)  # fmt: skip


def skull(s: Sculpture) -> None:
    """Head with wide cheeks, and ears that are hollow in front."""
    s.ball((0, 0.368, 0.062), (0.0600, 0.0500, 0.0560), 0.030)
    s.ball((0.034, 0.344, 0.072), (0.0330, 0.0260, 0.0330), 0.030, mirror=True, turn=(0, 0, -20))
    with s.group((0.049, 0.435, 0.048, 0.070), 0.014, mirror=True) as ear:
        ear.tube(EAR, 0.004)
        ear.tube([(0.037, 0.404, 0.076, 0.0140), (0.0490, 0.436, 0.0670, 0.0110), (0.0570, 0.458, 0.0585, 0.0050)],
                 0.010, op=CUT)  # fmt: skip


def muzzle(s: Sculpture) -> None:
    """A pointed muzzle, the bridge of the nose, the lower jaw and the line of the mouth."""
    s.tube([(0, 0.350, 0.100, 0.0330), (0, 0.342, 0.140, 0.0205), (0, 0.3365, 0.170, 0.0125)], 0.026)
    s.tube([(0, 0.376, 0.102, 0.0150), (0, 0.354, 0.140, 0.0105), (0, 0.3435, 0.172, 0.0075)], 0.014)
    s.ball((0.0075, 0.3350, 0.1660), (0.0085, 0.0075, 0.0095), 0.008, mirror=True)
    s.tube([(0, 0.326, 0.105, 0.0180), (0, 0.3225, 0.140, 0.0100), (0, 0.3225, 0.162, 0.0065)], 0.012)
    s.crease(both_sides([(x, y, z, 0.0030) for x, y, z in MOUTH]), 0.0022)


def features(s: Sculpture) -> None:
    """The tip of the nose with its nostrils; eyes in slanting lids."""
    s.ball(NOSE, (0.0100, 0.0075, 0.0075), 0.003)
    s.ball((0.0050, 0.3390, 0.1870), (0.0020, 0.0022, 0.0030), 0.002, op=CUT, mirror=True)
    s.ball((EYE[0], EYE[1], EYE[2] + 0.015), (0.0140, 0.0095, 0.0090), 0.010, op=CUT, mirror=True, turn=(0, 25, 18))
    s.ball(EYE, (0.0108, 0.0108, 0.0108), 0.002, mirror=True)
    with s.group((EYE[0], EYE[1], EYE[2], 0.022), 0.004, mirror=True) as lids:  # upper lids
        lids.ball(EYE, 0.0128, 0)
        lids.ball((EYE[0] + 0.002, EYE[1] - 0.0156, EYE[2] + 0.012), (0.034, 0.0215, 0.034), 0.002, op=CUT,
                  turn=(0, 0, 14))  # fmt: skip
