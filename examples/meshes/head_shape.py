"""The shape of the head: skull, face, neck and shoulders, all in metres. Rows of curves are (x, y, z, radius)."""

from __future__ import annotations

import math

import numpy as np
from sculpt import CUT, Sculpture, both_sides

LID = [(0.0155, -0.0218), (0.0230, -0.0250), (0.0315, -0.0265), (0.0405, -0.0248), (0.0480, -0.0205)]
FOLD = [(0.0180, -0.0170), (0.0235, -0.0122), (0.0320, -0.0100), (0.0405, -0.0118), (0.0480, -0.0168)]
MOUTH = [(0, -0.0880), (0.005, -0.0872), (0.014, -0.0881), (0.0250, -0.0894)]

EAR = np.array([0.0690, -0.0285, -0.0060])  # the ear's canal, from which its parts are measured in millimetres ...
FLARE, LEAN = math.radians(20), math.radians(12)
BACK = np.array([math.sin(FLARE), 0, -math.cos(FLARE)])
UP = math.cos(LEAN) * np.array([0, 1, 0]) + math.sin(LEAN) * BACK
BACK = math.cos(LEAN) * BACK - math.sin(LEAN) * np.array([0, 1, 0])
OUT = np.cross(BACK, UP)  # ... along these axes


def head() -> Sculpture:
    """The head, with both halves alike but for the order in which parts run into each other."""
    s = Sculpture()
    skull(s)
    neck(s)
    torso(s)
    face(s)
    eyes(s)
    nose(s)
    lips(s)
    ears(s)
    s.keep_above(-0.45, 0.03)
    return s


def skull(s: Sculpture) -> None:
    """Cranium, occiput and forehead."""
    s.ball((0, 0.012, -0.004), (0.0745, 0.0840, 0.0930), 0)
    s.ball((0, 0.020, -0.030), (0.0765, 0.0660, 0.0660), 0.03)
    s.ball((0, 0.036, 0.030), (0.0560, 0.0480, 0.0570), 0.03)


def neck(s: Sculpture) -> None:
    """The neck with its muscles from ear to breastbone, the larynx, and the slope to the shoulders."""
    s.tube([(0, -0.040, -0.024, 0.044), (0, -0.110, -0.022, 0.044), (0, -0.170, -0.029, 0.045),
            (0, -0.230, -0.043, 0.055)], 0.030)  # fmt: skip
    s.tube([(0.056, -0.045, -0.026, 0.010), (0.037, -0.125, -0.010, 0.010), (0.022, -0.182, 0.003, 0.009),
            (0.010, -0.228, 0.010, 0.007)], 0.022, mirror=True)  # fmt: skip
    s.ball((0, -0.162, 0.006), (0.010, 0.016, 0.008), 0.014)
    s.tube([(0.018, -0.050, -0.046, 0.018), (0.021, -0.115, -0.048, 0.020), (0.030, -0.168, -0.057, 0.022),
            (0.060, -0.212, -0.060, 0.028), (0.112, -0.248, -0.050, 0.028), (0.155, -0.270, -0.042, 0.026)],
           0.035, mirror=True)  # fmt: skip


def torso(s: Sculpture) -> None:
    """Collar bones, shoulders with the beginning of the arms, and the chest."""
    s.tube([(0.013, -0.238, 0.008, 0.008), (0.055, -0.243, 0.013, 0.008), (0.100, -0.249, -0.003, 0.008),
            (0.148, -0.258, -0.030, 0.009)], 0.034, mirror=True)  # fmt: skip
    s.ball((0.060, -0.252, -0.012), (0.065, 0.020, 0.022), 0.040, mirror=True, turn=(0, 14, -4))  # behind them
    s.tube([(0, -0.295, -0.035, 0.060), (0.09, -0.290, -0.038, 0.046), (0.150, -0.302, -0.037, 0.046),
            (0.170, -0.370, -0.036, 0.046), (0.180, -0.500, -0.035, 0.043)], 0.040, mirror=True)  # fmt: skip
    s.ball((0, -0.395, -0.026), (0.150, 0.160, 0.096), 0.060)


def face(s: Sculpture) -> None:
    """What is below the forehead, but for eyes, nose and lips."""
    s.ball((0, -0.040, 0.026), (0.0615, 0.0600, 0.0580), 0.030)  # the mask
    s.ball((0, -0.078, 0.036), (0.0440, 0.0530, 0.0500), 0.030)
    s.ball((0.043, -0.043, 0.048), (0.0190, 0.0180, 0.0190), 0.030, mirror=True)  # cheekbones
    s.tube([(0.053, -0.037, 0.032, 0.010), (0.060, -0.033, 0.008, 0.008), (0.060, -0.030, -0.012, 0.009)],
           0.032, mirror=True)  # their arches  # fmt: skip
    s.tube([(0.056, -0.045, -0.006, 0.010), (0.0455, -0.080, 0.008, 0.009), (0.030, -0.107, 0.042, 0.009),
            (0.010, -0.119, 0.072, 0.010)], 0.030, mirror=True)  # jaw  # fmt: skip
    s.ball((0, -0.083, 0.0655), (0.0290, 0.0280, 0.0300), 0.028)  # what the teeth hold forward
    s.ball((0, -0.1165, 0.0775), (0.0150, 0.0140, 0.0165), 0.020)  # chin
    s.ball((0.046, -0.070, 0.016), (0.0130, 0.0250, 0.0220), 0.030, mirror=True)  # muscles of the jaw
    s.tube([(0, 0.002, 0.080, 0.008), (0.016, 0.003, 0.078, 0.010), (0.032, 0.005, 0.070, 0.009),
            (0.045, 0.000, 0.056, 0.008)], 0.026, mirror=True)  # brow ridge  # fmt: skip


def eyes(s: Sculpture) -> None:
    """Sockets, the lids over the balls, their fold, and the line where they meet."""
    s.ball((0.0320, -0.0190, 0.0860), (0.0190, 0.0125, 0.0125), 0.024, op=CUT, mirror=True, turn=(0, 22, 0))
    s.ball((0.0318, -0.0185, 0.0640), (0.0165, 0.0130, 0.0135), 0.011, mirror=True, turn=(0, 16, 0))
    s.crease([(*p, 0, 0.0022) for p in FOLD], 0.0007, mirror=True, drape=True)
    s.crease([(x, y + 0.0022, 0, 0.0018) for x, y in LID], -0.0006, mirror=True, drape=True)
    s.crease([(*p, 0, 0.0014) for p in LID], 0.0016, mirror=True, drape=True)


def nose(s: Sculpture) -> None:
    """Bridge and flanks, tip, the bridge under it, wings and nostrils."""
    s.ball((0, -0.0420, 0.0800), (0.0145, 0.0270, 0.0140), 0.016, turn=(-14, 0, 0))
    s.tube([(0, 0, 0.0800, 0.0080), (0, -0.014, 0.0805, 0.0070), (0, -0.034, 0.0925, 0.0070),
            (0, -0.0500, 0.1020, 0.0075)], 0.012)  # fmt: skip
    s.ball((0, -0.0540, 0.1045), (0.0085, 0.0080, 0.0095), 0.009)
    s.tube([(0, -0.0585, 0.1050, 0.0038), (0, -0.0645, 0.0955, 0.0040)], 0.006)
    s.ball((0.0105, -0.0588, 0.0935), (0.0058, 0.0060, 0.0090), 0.009, mirror=True, turn=(8, 14, 0))
    s.ball((0.0066, -0.0655, 0.0965), (0.0030, 0.0036, 0.0052), 0.004, op=CUT, mirror=True, turn=(0, 22, 0))


def lips(s: Sculpture) -> None:
    """Philtrum, the hollow above the chin, both lips, the line between them and its ends."""
    s.ball((0, -0.0735, 0.0870), (0.0170, 0.0100, 0.0100), 0.014)
    s.crease([(0, -0.069, 0, 0.0034), (0, -0.077, 0, 0.0040)], 0.0008, drape=True)
    s.ball((0, -0.1065, 0.0985), (0.0180, 0.0060, 0.0060), 0.010, op=CUT)
    upper = [(0, -0.0836, -0.0024, 0.0044), (0.005, -0.0827, -0.0022, 0.0046), (0.014, -0.0849, -0.0022, 0.0037),
             (0.0235, -0.0882, -0.0018, 0.0020)]  # fmt: skip
    lower = [(0, -0.0926, -0.0027, 0.0052), (0.012, -0.0919, -0.0027, 0.0043), (0.0225, -0.0892, -0.0018, 0.0020)]
    s.tube(both_sides(upper), 0.005, drape=True)
    s.tube(both_sides(lower), 0.005, drape=True)
    s.crease(both_sides([(*p, 0, 0.0015) for p in MOUTH]), 0.0020, drape=True)
    s.crease([(0.0255, -0.0896, 0, 0.004), (0.0275, -0.0898, 0, 0.004)], 0.0009, mirror=True, drape=True)


def ears(s: Sculpture) -> None:
    """An ear on each side: a hollowed shell, its rim, the ridge within, the canal and the flap before it."""

    def at(back: float, up: float, out: float, *radius: float) -> tuple[float, ...]:
        place = EAR + (back * BACK + up * UP + out * OUT) / 1000
        return (*place.tolist(), *(r / 1000 for r in radius))

    turn = np.column_stack([OUT, UP, -BACK])
    with s.group((*at(13, -2, 2), 0.052), 0.006, mirror=True) as e:
        e.ball(at(13, 3, -0.5), (0.0075, 0.0280, 0.0175), 0.004, turn=turn)
        e.ball(at(6, -24, 0), (0.0045, 0.0110, 0.0100), 0.008, turn=turn)  # lobe
        e.ball(at(13, 5, 8.5), (0.0070, 0.0225, 0.0130), 0.003, op=CUT, turn=turn)
        e.tube([at(6, 22, 1, 2), at(13, 15, 1.6, 2.6), at(18.5, 4, 2.4, 3), at(17, -7, 3, 2.8), at(11, -15, 3.5, 2.6),
                at(5, -17, 3.5, 2)], 0.004)  # fmt: skip
        e.tube([at(5, 0, 1, 1.5), at(-2, 6, 3, 2.2), at(-3, 16, 4, 2.4), at(3, 26.5, 5, 2.6), at(14, 30, 5, 2.6),
                at(25, 24, 4.5, 2.5), at(30, 10, 4, 2.3), at(27.5, -5, 4, 2.2), at(20, -17, 3.5, 2.2),
                at(12, -25, 2.5, 2.4)], 0.004)  # fmt: skip
        e.ball(at(8, -4, 4), (0.0075, 0.0105, 0.0085), 0.003, op=CUT, turn=turn)
        e.ball(at(-1.5, -5, 2.5), (0.0030, 0.0060, 0.0036), 0.004, turn=turn)
