#!/usr/bin/env python3
"""Writes tests/flip_values.inc: what the published FLIP says of the pairs of tests/test_flip.c.

    python3 -m venv /tmp/flip && /tmp/flip/bin/pip install flip-evaluator
    /tmp/flip/bin/python tests/flip_values.py > tests/flip_values.inc

The pictures are made of whole numbers, here and in test_flip.c by the same formulas. 8-bit pairs have
sRGB values / 255; the others are linear, value / 64 * 2^(hash % 8)."""
import flip_evaluator
import numpy

WIDTHS = [64, 97, 300, 31, 5, 128]
HEIGHTS = [48, 80, 70, 133, 7, 1]
PATTERNS = ["GRADIENT", "CHECKER", "NOISE", "DISC", "STRIPES"]
CHANGES = ["BRIGHTER", "NOISY", "SHIFTED", "COARSE", "SWAPPED", "DARK_SPOT"]
PPD = [67.020643276582255, 30, 100]


def mixed(x, y, c, seed):
    h = (x * 73856093 ^ y * 19349663 ^ c * 83492791 ^ seed * 2654435761) & 0xFFFFFFFF
    h ^= h >> 13
    h = h * 0x5BD1E995 & 0xFFFFFFFF
    return h ^ h >> 15


def pattern(kind, seed, w, h, x, y, c):
    if kind == "GRADIENT":
        return (x * 255 // w + y * 255 // h * (c + 1) // 3) % 256
    if kind == "CHECKER":
        return 210 - 30 * c if (x // 6 + y // 6) % 2 else 25 + 20 * c
    if kind == "NOISE":
        return mixed(x, y, c, seed) % 256
    if kind == "DISC":
        dx, dy = 2 * x - w, 2 * y - h
        return [230, 120, 40][c] if dx * dx + dy * dy < w * h // 2 else [20, 60, 110][c]
    return 255 if (x + 2 * y + c) % (3 + seed % 5) == 0 else 40


def changed(change, kind, seed, w, h, x, y, c):
    if change == "SHIFTED":
        return pattern(kind, seed, w, h, max(x - 2, 0), y, c)
    if change == "SWAPPED":
        return pattern(kind, seed, w, h, x, y, (c + 1) % 3)
    value = pattern(kind, seed, w, h, x, y, c)
    if change == "BRIGHTER":
        return min(value + 24, 255)
    if change == "NOISY":
        return min(max(value + mixed(x, y, c, seed + 99) % 41 - 20, 0), 255)
    if change == "COARSE":
        return value // 64 * 64
    return value // 4 if w // 3 <= x < w // 2 and h // 3 <= y < (h + 1) // 2 else value


def picture(of, w, h, hdr, seed):
    out = numpy.zeros((h, w, 3), numpy.float32)
    for y in range(h):
        for x in range(w):
            stops = mixed(x // 8, y // 8, 7, seed) % 8
            for c in range(3):
                out[y, x, c] = of(x, y, c) / 64 * 2**stops if hdr else of(x, y, c) / 255
    return out


print("/* Made by tests/flip_values.py, with flip-evaluator 1.7: pattern, change, seed, width, height, HDR,\n"
      " * pixels per degree, mean, and the values at three pixels. */\n/* clang-format off */")
for i in range(28):
    hdr = i >= 22
    kind, change, seed = PATTERNS[i % 5], CHANGES[(i % 5 + i // 5) % 6], i
    w, h, ppd = WIDTHS[i % 6], HEIGHTS[i % 6], PPD[i % 7 // 3]
    a = picture(lambda x, y, c: pattern(kind, seed, w, h, x, y, c), w, h, hdr, seed)
    b = picture(lambda x, y, c: changed(change, kind, seed, w, h, x, y, c), w, h, hdr, seed)
    error, mean, _ = flip_evaluator.evaluate(a, b, "HDR" if hdr else "LDR", applyMagma=False, parameters={"ppd": ppd})
    at = ", ".join(f"{error[y, x, 0]:.6f}" for x, y in [(w // 2, h // 2), (w // 3, h // 3), (w - 1, h // 5)])
    print(f"{{{kind}, {change}, {seed}, {w}, {h}, {str(hdr).lower()}, {ppd!r}, {mean:.7f}, {{{at}}}}},")
