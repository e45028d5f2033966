"""History: what was done, what could be done again, and any state between, kept or made anew."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from crowquill.editor.drawing import Drawing
from crowquill.editor.log import Entry
from crowquill.editor.states import States

Perform = Callable[[Drawing, Entry], Drawing]
ROOM = 512 * 2**20  # bytes of states that are kept; others are made anew from the one before


class History:
    """Entries with the drawing that each gives; `at` of them are done."""

    def __init__(
        self, begun: Drawing, entries: Sequence[Entry], at: int, perform: Perform, room: int = ROOM, states: States | None = None
    ) -> None:
        """The history of a drawing that begins so; `perform` gives what an entry makes of a drawing. `states` are kept elsewhere."""
        self._perform = perform
        self._states = states
        self.entries = list(entries)
        self.at = at
        self._kept: dict[int, Drawing] = {0: begun}
        self._room, self._held = room, 0

    def run(self) -> Iterator[int]:
        """Makes the drawing that is done, entry by entry; the number of each."""
        for k in range(self._nearest(self.at) + 1, self.at + 1):
            self._state(k)
            yield k

    def drawing(self) -> Drawing:
        """The drawing as it is."""
        return self._state(self.at)

    def push(self, entry: Entry, made: Drawing) -> None:
        """Adds an entry that gave a drawing; what was undone is gone."""
        for k in range(self.at + 1, len(self.entries) + 1):
            self._kept.pop(k, None)
        del self.entries[self.at :]
        self.entries.append(entry)
        self.at += 1
        self._keep(self.at, made)

    def back(self, groups: int) -> int:
        """How many entries are done when so many groups, or all there are, are undone."""
        at = self.at
        for _ in range(min(groups, at)):
            group = self.entries[at - 1].group if at else None
            while at and self.entries[at - 1].group == group:
                at -= 1
        return at

    def ahead(self, groups: int) -> int:
        """How many entries are done when so many groups, or all there are, are done again."""
        at, end = self.at, len(self.entries)
        for _ in range(min(groups, end - at)):
            group = self.entries[at].group if at < end else None
            while at < end and self.entries[at].group == group:
                at += 1
        return at

    def go(self, at: int) -> int:
        """Goes to where so many entries are done, and gives how many lie between; stays where that drawing cannot be made."""
        self._state(at)
        was, self.at = self.at, at
        return abs(at - was)

    @property
    def last_group(self) -> int:
        """The group of the last entry that is done; 0 where none is."""
        return self.entries[self.at - 1].group if self.at else 0

    @property
    def last_number(self) -> int:
        """The greatest number of a group, 0 without any."""
        return max((entry.group for entry in self.entries), default=0)

    def names(self) -> tuple[list[str], list[str]]:
        """The operations of the groups that could be undone, the next first, and of those that could be redone; 50 of each at most."""
        back = _grouped(list(reversed(self.entries[max(0, self.at - 5000) : self.at])))
        return back[:50], _grouped(self.entries[self.at : self.at + 5000])[:50]

    def _state(self, k: int) -> Drawing:
        """The drawing after k entries, from the last before it that is kept."""
        for n in range(self._nearest(k), k):
            self._keep(n + 1, self._perform(self._kept[n], self.entries[n]))
        return self._kept[k]

    def _nearest(self, k: int) -> int:
        """The last number of entries up to k after which the drawing is kept."""
        first = max(n for n in self._kept if n <= k)
        found = self._states.last(first, k, self.entries) if self._states and first < k else None
        if found:
            self._keep(*found)
        return found[0] if found else first

    def _keep(self, k: int, drawing: Drawing) -> None:
        """Keeps a drawing; where room is short, of the others every second goes, those far from here first. The first stays."""
        before = _arrays(self._kept[k - 1]) if k - 1 in self._kept else {}
        self._kept[k] = drawing
        self._held += sum(size for array, size in _arrays(drawing).items() if array not in before)
        while self._held > self._room and len(self._kept) > 3:
            far = sorted((n for n in self._kept if n not in (0, k)), key=lambda n: -abs(n - k))
            for n in far[: max(1, len(far) // 2)][::2]:
                del self._kept[n]
            every: dict[int, int] = {}
            for one in self._kept.values():
                every |= _arrays(one)
            self._held = sum(every.values())


def _arrays(drawing: Drawing) -> dict[int, int]:
    """The bytes of each array of a drawing; many share some."""
    arrays = [drawing.tone.values, *([drawing.wish.values] if drawing.wish else [])]
    arrays += [column for layer in drawing.layers for column in layer.items.columns()]
    return {id(array): array.nbytes for array in arrays}


def _grouped(entries: Sequence[Entry]) -> list[str]:
    """The operation of the first entry of each group."""
    return [entry.op for k, entry in enumerate(entries) if not k or entry.group != entries[k - 1].group]
