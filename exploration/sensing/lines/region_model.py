"""What taxels read over a face whose outline is made of straight lines and circles, in closed form.

With S the blurred indicator of the face (a Gaussian of covariance V = spread^2 + pitch^2/12 along each axis) and
q(p) = d0 + g . p the depth of its plane, the Gaussian's own derivative gives the sloped face exactly,

    depth(p) = q(p) S(p) + g . V grad S(p)        (our derivation: (s - p) G(s - p) = V grad G).

S is multilinear in its half-planes: any union and intersection of up to three is a sum of blurred half-planes
Phi(t_i) and wedges Phi2(t_i, t_j) (`normal_pair`).  Of three, one of the eight regions that their lines could
bound is empty; which one, the linear relation between their normals tells, and it gives the triple from the pairs.
Discs (`blurred_disc`) are added, if they are bosses, or taken away, if they are holes in the face.

Unknowns: d0, gx, gy; (angle, offset) a line; (x, y, radius) a disc.  Derivatives are exact; discs see the blur
along their normal, which is exact where it is the same along both axes.
"""

from math import cos, sin, sqrt

import numba
import numpy as np

from exploration.sensing.lines.blurred_disc import CELLS, REACH, covered, rim, tabulate
from exploration.sensing.lines.normal_pair import FAR, NODES, both, chance, density, prepare
from primitives.arrays import Floats

_PLUS = np.array([[0, 1], [0, 2], [1, 2]])


@numba.njit(cache=True, error_model="numpy")
def without_triple(terms: Floats, normals: Floats, offsets: Floats) -> Floats:
    """Coefficients (8,) of the subsets of three half-planes n . p > o, the whole set replaced by its subsets.

    Subset u has bit i set for half-plane i.
    """
    out = terms.copy()
    if terms[7] == 0.0:
        return out
    relation = np.empty(3)
    total = 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        relation[i] = normals[j, 0] * normals[k, 1] - normals[j, 1] * normals[k, 0]
        total -= relation[i] * offsets[i]
    minus = 0
    for i in range(3):
        if total * relation[i] > 0.0:
            minus |= 1 << i
    out[7] = 0.0
    sign = 1.0
    for i in range(3):
        if minus >> i & 1:
            sign = -sign
    for u in range(7):
        if u | minus == 7:
            shared = u & minus
            odd = (shared & 1) + (shared >> 1 & 1) + (shared >> 2 & 1)
            out[u] -= terms[7] * sign * (-1.0 if odd % 2 else 1.0)
    return out


@numba.njit(cache=True, error_model="numpy")
def evaluate(
    x: Floats,
    y: Floats,
    variance: Floats,
    p: Floats,
    sides: Floats,
    terms: Floats,
    signs: Floats,
    model: Floats,
) -> None:
    """Fill `model` (1 + len(p), rows, columns) with the depth and its derivatives to `p`.

    `sides` (n,) are the lines' material sides, `terms` (8,) the outline's coefficients over subsets of lines,
    `signs` (m,) +1 for a boss and -1 for a hole.
    """
    n, m = len(sides), len(signs)
    vx, vy = variance[0], variance[1]
    normals, turned = np.empty((3, 2)), np.empty((3, 2))
    width, growth, shift = np.empty(3), np.empty(3), np.empty(3)
    for i in range(n):
        ca, sa = cos(p[3 + 2 * i]), sin(p[3 + 2 * i])
        width[i] = sqrt(vx * sa * sa + vy * ca * ca)
        growth[i] = sa * ca * (vx - vy) / width[i] ** 2
        s = sides[i] / width[i]
        normals[i, 0], normals[i, 1] = -s * sa, s * ca
        turned[i, 0] = -s * ca - normals[i, 0] * growth[i]
        turned[i, 1] = -s * sa - normals[i, 1] * growth[i]
        shift[i] = s * p[4 + 2 * i]
    reduced = without_triple(terms, normals, shift) if n == 3 else terms
    single = np.array([reduced[1], reduced[2], reduced[4]])
    pairs = np.array([reduced[3], reduced[5], reduced[6]])
    c, nodes = np.zeros(3), np.empty((3, NODES, 3))
    for e in range(3):
        i, j = _PLUS[e, 0], _PLUS[e, 1]
        if j < n:
            c[e] = normals[i, 0] * vx * normals[j, 0] + normals[i, 1] * vy * normals[j, 1]
            c[e] = min(1.0, max(-1.0, c[e]))
            prepare(c[e], nodes[e])
    mean_width = sqrt(0.5 * (vx + vy))
    tables = np.empty((m, CELLS + 1, 2))
    first, step = np.empty(m), np.empty(m)
    for k in range(m):
        radius = p[5 + 2 * n + 3 * k]
        first[k], step[k] = tabulate(radius / mean_width, tables[k])
    d0, gx, gy = p[0], p[1], p[2]
    ux, uy = gx * vx, gy * vy
    t, f, phi = np.zeros(3), np.zeros(3), np.zeros(3)
    s1, sc = np.zeros(3), np.zeros(3)
    s2, s1c = np.zeros((3, 3)), np.zeros((3, 3))
    for row in range(len(y)):
        py = y[row]
        for column in range(len(x)):
            px = x[column]
            q = d0 + gx * px + gy * py
            total, grad_x, grad_y = reduced[0], 0.0, 0.0
            for i in range(n):
                t[i] = normals[i, 0] * px + normals[i, 1] * py - shift[i]
                near = abs(t[i]) < FAR
                f[i] = chance(t[i])
                phi[i] = density(t[i]) if near else 0.0
                total += single[i] * f[i]
                s1[i] = single[i] * phi[i]
                for j in range(n):
                    s2[i, j] = 0.0
                s2[i, i] = -t[i] * s1[i]
            for e in range(3):
                sc[e] = 0.0
                i, j = _PLUS[e, 0], _PLUS[e, 1]
                if j >= n or pairs[e] == 0.0:
                    continue
                r2 = max(1e-12, 1.0 - c[e] * c[e])
                r = sqrt(r2)
                total += pairs[e] * both(t[i], t[j], f[i], f[j], c[e], nodes[e])
                if phi[i] == 0.0 and phi[j] == 0.0:
                    continue
                a = phi[i] * chance((t[j] - c[e] * t[i]) / r)
                b = phi[j] * chance((t[i] - c[e] * t[j]) / r)
                d = (
                    0.15915494309189535
                    / r
                    * np.exp(-0.5 * (t[i] ** 2 + t[j] ** 2 - 2 * c[e] * t[i] * t[j]) / r2)
                )
                s1[i] += pairs[e] * a
                s1[j] += pairs[e] * b
                s2[i, i] -= pairs[e] * (t[i] * a + c[e] * d)
                s2[j, j] -= pairs[e] * (t[j] * b + c[e] * d)
                s2[i, j] += pairs[e] * d
                s2[j, i] += pairs[e] * d
                sc[e] = pairs[e] * d
                s1c[e, 0] = -sc[e] * (t[i] - c[e] * t[j]) / r2
                s1c[e, 1] = -sc[e] * (t[j] - c[e] * t[i]) / r2
            for i in range(n):
                grad_x += s1[i] * normals[i, 0]
                grad_y += s1[i] * normals[i, 1]
            for i in range(n):
                slope = s1[i] * q
                for j in range(n):
                    slope += s2[i, j] * (ux * normals[j, 0] + uy * normals[j, 1])
                by_angle = turned[i, 0] * px + turned[i, 1] * py + shift[i] * growth[i]
                change = slope * by_angle + s1[i] * (ux * turned[i, 0] + uy * turned[i, 1])
                for e in range(3):
                    if sc[e] == 0.0 or (i != _PLUS[e, 0] and i != _PLUS[e, 1]):
                        continue
                    a, b = _PLUS[e, 0], _PLUS[e, 1]
                    other = b if i == a else a
                    dc = turned[i, 0] * vx * normals[other, 0] + turned[i, 1] * vy * normals[other, 1]
                    along = s1c[e, 0] * (ux * normals[a, 0] + uy * normals[a, 1])
                    along += s1c[e, 1] * (ux * normals[b, 0] + uy * normals[b, 1])
                    change += dc * (q * sc[e] + along)
                model[4 + 2 * i, row, column] = change
                model[5 + 2 * i, row, column] = -sides[i] / width[i] * slope
            for k in range(m):
                at = 3 + 2 * n + 3 * k
                dx, dy = px - p[at], py - p[at + 1]
                radius = p[at + 2]
                distance = sqrt(dx * dx + dy * dy)
                if distance > 1e-9:
                    rx, ry = dx / distance, dy / distance
                else:
                    rx, ry = 1.0, 0.0
                w = sqrt(vx * rx * rx + vy * ry * ry)
                b = radius / mean_width
                a = b + (distance - radius) / w
                for o in range(3):
                    model[1 + at + o, row, column] = 0.0
                if a >= b + REACH:
                    continue
                if a <= b - REACH:
                    total += signs[k]
                    continue
                a = max(a, 0.0)
                g0, g1, ratio = rim(a, b)
                sign = signs[k]
                total += sign * covered(tables[k], first[k], step[k], a)
                fa, fab, faa = -g1, b * g1 - a * g0, a * g1 - b * g0 + ratio
                grad_x += sign * fa * rx / w
                grad_y += sign * fa * ry / w
                radial, across = ux * rx + uy * ry, -ux * ry + uy * rx
                inward = sign * (q * fa + radial * faa / w) / w
                sideways = sign * ratio * across / (w * w)
                model[1 + at, row, column] = -inward * rx - sideways * ry
                model[2 + at, row, column] = -inward * ry + sideways * rx
                outward = sign * (q * (fa + g0) + radial * (faa + fab) / w)
                model[3 + at, row, column] = outward / mean_width - sign * (q * fa + radial * faa / w) / w
            model[0, row, column] = q * total + ux * grad_x + uy * grad_y
            model[1, row, column] = total
            model[2, row, column] = px * total + vx * grad_x
            model[3, row, column] = py * total + vy * grad_y
