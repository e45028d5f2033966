"""The search behind every route: a start by shortest links, made shorter by turning stretches about and moving short ones.

A stroke s has two ports, 2 s and 2 s + 1; a dot's lie in one place. A route is a ring of strokes, each named by
the port at which it is entered, so that the other, port ^ 1, is left: `ring` (n,), and `place` (n,) where each stroke is.
Ports without a place, NaN, are as near to all others as can be: they hold the loose ends of a line.
Source: J. L. Bentley, Fast Algorithms for Geometric Traveling Salesman Problems, ORSA Journal on Computing 4(4), 1992.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from crowquill.kernel import compiled
from crowquill.paths import Array, Index
from crowquill.route.crossings import crosses
from crowquill.route.near import nearest

SEGMENT = 3  # strokes that are moved together at most
REACH = 50_000  # strokes turned about at a time at most; all there are up to 100 000. More took a million dots from 4 s to 12 s, for 0.4 %


def shortest(ports: Array, near: Index) -> tuple[Index, Index]:
    """A short ring through all strokes, and where each is in it; ports (2 n, 2) mm, and near as of `near.neighbours_of`."""
    ring = _linked(ports, near)
    place = np.empty(len(ring), np.int64)
    place[ring >> 1] = np.arange(len(ring))
    improve(ports, near, ring, place, ring >> 1)
    return ring, place


def improve(ports: Array, near: Index, ring: Index, place: Index, strokes: Index) -> None:
    """Makes the ring shorter about these strokes, and wherever that makes a change, until nothing near is to be gained."""
    extent = float(np.ptp(ports[~np.isnan(ports[:, 0])], axis=0).max(initial=0.0)) if len(ports) else 0.0
    if len(ring) > 3:
        _improve(ports, near, ring, place, strokes, 1e-12 * extent)


def _linked(ports: Array, near: Index) -> Index:
    """A ring by shortest links: the shortest between loose ends is made again and again, until all strokes hang together."""
    n = len(ports) // 2
    link, root = np.full(2 * n, -1, np.int64), np.arange(n)
    dot = np.zeros(2 * n, bool)
    dot[::2] = (ports[::2] == ports[1::2]).all(axis=1)
    a, b = np.repeat(np.arange(2 * n), 5), near[:, :5].ravel()
    while True:
        a, b = a[b >= 0], b[b >= 0]
        length = np.hypot(*(ports[a] - ports[b]).T)
        order = np.argsort(length, kind="stable")
        _link(a[order], b[order], dot, link, root)
        loose = (link < 0) & ~np.isnan(ports[:, 0])
        loose[1::2] &= ~(dot[::2] & loose[::2])  # a dot without any link is one loose end, which takes two
        ends = np.flatnonzero(loose)
        if len(np.unique(_roots(root, ends >> 1))) < 2:
            return _followed(link)
        near = nearest(ports[ends], ends, 6)
        a, b = np.repeat(ends, 6), near.ravel()


@compiled
def _root(root: Index, s: int) -> int:
    while root[s] != s:
        root[s] = root[root[s]]
        s = root[s]
    return s


@compiled
def _roots(root: Index, strokes: Index) -> Index:
    found = np.empty(len(strokes), np.int64)
    for i in range(len(strokes)):
        found[i] = _root(root, strokes[i])
    return found


@compiled
def _link(a: Index, b: Index, dot: npt.NDArray[np.bool_], link: Index, root: Index) -> None:
    """Links ports a[i] and b[i], in this order, where both are loose and no ring is closed; root joins strokes that hang together."""
    for i in range(len(a)):
        p, q = a[i], b[i]
        if link[p] >= 0 and dot[p & ~1]:
            p ^= 1
        if link[q] >= 0 and dot[q & ~1]:
            q ^= 1
        if link[p] >= 0 or link[q] >= 0:
            continue
        r, s = _root(root, p >> 1), _root(root, q >> 1)
        if r != s:
            link[p], link[q] = q, p
            root[max(r, s)] = min(r, s)


@compiled
def _followed(link: Index) -> Index:
    """The strokes of a chain from one end to the other, then those that hang alone: a ring of them all."""
    n = len(link) // 2
    ring, seen, count = np.empty(n, np.int64), np.zeros(n, np.bool_), 0
    for most in (1, 0):  # links of the end to begin from
        for p in range(2 * n):
            if seen[p >> 1] or link[p] >= 0 or (link[p ^ 1] >= 0) != (most == 1):
                continue
            now = p
            while now >= 0:
                ring[count] = now
                seen[now >> 1] = True
                count += 1
                now = link[now ^ 1]
    return ring


@compiled
def length_between(ports: Array, a: int, b: int) -> float:
    """The way from port to port, mm; none to or from a port without a place."""
    d = np.sqrt((ports[a, 0] - ports[b, 0]) ** 2 + (ports[a, 1] - ports[b, 1]) ** 2)
    return d if d >= 0 else 0.0


@compiled
def linked_to(ring: Index, place: Index, a: int) -> int:
    """The port that the pen goes to from port a, or comes from."""
    p = place[a >> 1]
    if ring[p] == a:
        return int(ring[p - 1 if p > 0 else len(ring) - 1] ^ 1)
    return int(ring[p + 1 if p + 1 < len(ring) else 0])


@compiled
def swap(ring: Index, place: Index, a: int, b: int, c: int, d: int) -> None:
    """Links a to c and b to d in place of a to b and c to d, turning the shorter stretch about; a and c are both left or both entered."""
    if ring[place[a >> 1]] == a:
        a, b, c, d = b, a, d, c
    n = len(ring)
    i, j = place[b >> 1], place[c >> 1]
    count = (j - i) % n + 1
    if 2 * count > n:
        i, j, count = place[d >> 1], place[a >> 1], n - count
    for _ in range((count + 1) // 2):
        p, q = ring[i] ^ 1, ring[j] ^ 1
        ring[i], ring[j] = q, p
        place[q >> 1], place[p >> 1] = i, j
        i = i + 1 if i + 1 < n else 0
        j = j - 1 if j > 0 else n - 1


@compiled
def move(ring: Index, place: Index, a: int, b: int, c: int, d: int, e: int, f: int) -> None:
    """Puts the stretch from port c to port e, which hung between d and f, between a and b: links a to c, e to b, d to f."""
    entered = ring[place[a >> 1]] == a
    if entered == (ring[place[c >> 1]] == c):
        swap(ring, place, a, b, c, d)
        swap(ring, place, e, f, b, d)
    else:
        swap(ring, place, a, b, e, f)
        swap(ring, place, a, e, c, d)
        swap(ring, place, e, d, b, f)


@compiled
def _between(place: Index, n: int, a: int, b: int) -> int:
    """How many strokes lie from one to the other, the shorter way round."""
    way = abs(place[a >> 1] - place[b >> 1])
    return int(min(way, n - way))


def undone(ports: Array, ring: Index, place: Index, links: Index) -> Index:
    """Parts links of dots that cross or touch, rows (a, b, c, d) of a linked to b and c to d; returns the strokes at links that changed.

    Those that cross are parted whatever it gains, which may be less than floats can tell; those that touch, where it gains.
    """
    touched = np.zeros(len(ring), np.bool_)
    least = 1e-12 * float(np.nanmax(np.abs(ports), initial=0.0))
    if len(links):
        _undo(ports, ring, place, links, touched, least)
    return np.flatnonzero(touched)


@compiled
def _undo(ports: Array, ring: Index, place: Index, links: Index, touched: npt.NDArray[np.bool_], least: float) -> None:
    for a, b, c, d in links:
        if linked_to(ring, place, a) != b or linked_to(ring, place, c) != d:
            continue
        if (ring[place[a >> 1]] == a) != (ring[place[c >> 1]] == c):  # an earlier change has turned one of them about
            c, d = d, c
        gain = length_between(ports, a, b) + length_between(ports, c, d) - length_between(ports, a, c) - length_between(ports, b, d)
        if gain > least or crosses(ports[a], ports[b], ports[c], ports[d]):
            swap(ring, place, a, b, c, d)
            touched[a >> 1] = touched[b >> 1] = touched[c >> 1] = touched[d >> 1] = True
            continue
        for p, q, r, s in ((a, b, c, d), (a, b, d, c), (c, d, a, b), (c, d, b, a)):  # the dot r, if that lies on pq, goes between them
            if r >> 1 == p >> 1 or r >> 1 == q >> 1:
                continue
            t = linked_to(ring, place, r ^ 1)
            gain = length_between(ports, p, q) + length_between(ports, s, r) + length_between(ports, r ^ 1, t)
            gain -= length_between(ports, p, r) + length_between(ports, r ^ 1, q) + length_between(ports, s, t)
            if gain > least:
                move(ring, place, p, q, r, s, r ^ 1, t)
                touched[p >> 1] = touched[q >> 1] = touched[r >> 1] = touched[s >> 1] = touched[t >> 1] = True
                break


@compiled
def _improve(ports: Array, near: Index, ring: Index, place: Index, strokes: Index, least: float) -> None:
    """Strokes wait in a queue to be looked at; each change puts the strokes at its links back. Changes gain more than `least` mm."""
    n = len(ring)
    queue, waits = np.empty(n, np.int64), np.zeros(n, np.bool_)
    head, held = 0, 0
    for s in strokes:
        if not waits[s]:
            queue[held] = s
            waits[s] = True
            held += 1
    touched = np.empty(6, np.int64)
    while held:
        s = queue[head]
        head = head + 1 if head + 1 < n else 0
        held -= 1
        waits[s] = False
        while True:
            count = _changed(ports, near, ring, place, 2 * s, touched, least)
            if not count:
                count = _changed(ports, near, ring, place, 2 * s + 1, touched, least)
            if not count:
                break
            for k in range(count):
                t = touched[k] >> 1
                if not waits[t] and t != s:
                    queue[(head + held) % n] = t
                    waits[t] = True
                    held += 1


@compiled
def _changed(ports: Array, near: Index, ring: Index, place: Index, a: int, touched: Index, least: float) -> int:
    """Makes the best change that gives port a a nearer link, if any; returns how many ports it touched."""
    n = len(ring)
    b = linked_to(ring, place, a)
    ab = length_between(ports, a, b)
    best, kind = least, 0
    bc = bd = be = bf = -1
    for near_c in near[a]:
        if near_c < 0:
            break
        ac = length_between(ports, a, near_c)
        if ab - ac <= best and ab - ac <= least:
            break
        if near_c >> 1 == a >> 1:
            continue
        twin = ports[near_c, 0] == ports[near_c ^ 1, 0] and ports[near_c, 1] == ports[near_c ^ 1, 1]
        for side in range(2 if twin else 1):
            c = near_c ^ side
            d = linked_to(ring, place, c)
            if c == b or d == a:
                continue
            cd = length_between(ports, c, d)
            gain = ab - ac + cd
            if (ring[place[a >> 1]] == a) == (ring[place[c >> 1]] == c):
                won = gain - length_between(ports, b, d)
                if won > best and _between(place, n, a, c) <= REACH:
                    best, kind, bc, bd = won, 1, c, d
            if gain <= best or _between(place, n, a, c) > REACH:
                continue
            e = c ^ 1
            for _ in range(SEGMENT):  # the stretch from c away from d, between a and b
                if e >> 1 == a >> 1 or e >> 1 == b >> 1:
                    break
                f = linked_to(ring, place, e)
                won = gain + length_between(ports, e, f) - length_between(ports, e, b) - length_between(ports, d, f)
                if won > best:
                    best, kind, bc, bd, be, bf = won, 2, c, d, e, f
                e = f ^ 1
            e = a ^ 1
            for _ in range(SEGMENT):  # the stretch from a away from b, between c and d
                if e >> 1 == c >> 1 or e >> 1 == d >> 1:
                    break
                f = linked_to(ring, place, e)
                won = gain + length_between(ports, e, f) - length_between(ports, e, d) - length_between(ports, b, f)
                if won > best:
                    best, kind, bc, bd, be, bf = won, 3, c, d, e, f
                e = f ^ 1
    if kind == 0:
        return 0
    touched[0], touched[1], touched[2], touched[3], touched[4], touched[5] = a, b, bc, bd, be, bf
    if kind == 1:
        swap(ring, place, a, b, bc, bd)
        return 4
    if kind == 2:
        move(ring, place, a, b, bc, bd, be, bf)
    else:
        move(ring, place, bc, bd, a, b, be, bf)
    return 6
