"""Playing: operations under way, once or many times, which may be paused, stopped or cancelled between two steps."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from crowquill.editor import telling
from crowquill.editor.requests import Halted
from crowquill.editor.session import Session
from crowquill.sheet import Step

REST = 0.05  # s between looks at whether a pause is over


class Ground(Protocol):
    """Where operations are played: a session that changes in a thread, and pages that are told."""

    session: Session

    def work(self, function: Callable[[], bool]) -> Awaitable[bool]:
        """What a function gives that is called in the session's thread."""

    async def write(self) -> None:
        """Writes down what waits."""

    def tell(self, message: telling.Json) -> None:
        """Says something to all pages."""

    def changed(self) -> None:
        """Has all pages catch up."""


@dataclass
class Play:
    """An operation under way: `times` of it, or without end for 0; `answer` takes what came of it, `refuse` why nothing did."""

    n: int
    op: str
    params: Mapping[str, Any]
    seed: int | None
    group: int
    times: int
    answer: Callable[[telling.Json], None]
    refuse: Callable[[Exception], None]
    done: int = 0
    paused: bool = False
    ended: str = ""  # stop or cancel, once that was asked for
    long: bool = False  # it has steps of its own
    facts: Mapping[str, float] = field(default_factory=dict)


class Player:
    """Plays one operation many times, and others once in between."""

    def __init__(self, ground: Ground) -> None:
        self._ground = ground
        self._played: Play | None = None
        self._once: Play | None = None

    @property
    def under_way(self) -> Play | None:
        """What is under way, a single one before what is played."""
        return self._once if self.long else self._played or self._once

    @property
    def long(self) -> bool:
        """Whether a single operation is under way that has steps of its own."""
        return bool(self._once and self._once.long)

    @property
    def busy(self) -> telling.Json | None:
        """What is under way, as pages are told."""
        play = self.under_way
        return {"n": play.n, "op": play.op, "paused": play.paused, "single": play.times == 1} if play else None

    @property
    def goes_on(self) -> bool:
        """Whether there is a step to be made."""
        return self._played is not None and (bool(self._played.ended) or not self._played.paused)

    def check_idle(self) -> None:
        """Raises ValueError where something is played."""
        if self._played:
            raise ValueError(f"{self._played.op} is under way; stop it first")

    def order(self, what: str) -> None:
        """Pauses, resumes, stops or cancels what is under way. Raises ValueError where there is nothing."""
        play = self.under_way
        if play is None:
            raise ValueError("nothing is under way")
        if what in ("pause", "resume"):
            play.paused = what == "pause"
        else:
            play.ended = what
        self._ground.changed()

    def end_all(self) -> None:
        """Has all that is under way end soon."""
        for play in (self._played, self._once):
            if play:
                play.ended = play.ended or "stop"

    def drop(self) -> None:
        """Gives up what is played."""
        self._played = None

    async def begin(self, play: Play) -> None:
        """Plays an operation: at once where it is a single one, else step by step from now on."""
        if play.times != 1:
            self.check_idle()
            self._played = play
            self._ground.changed()
            return
        with contextlib.suppress(Halted):
            await self._apply(play)
        self._answer(play)

    async def step(self) -> None:
        """The next step of what is played, or its end."""
        play = self._played
        if play is None:
            return
        if play.ended or (play.times and play.done >= play.times):
            await self.end()
            return
        try:
            changed = await self._apply(play)
        except Halted:
            return
        except Exception as error:
            self._played = None
            self._ground.changed()
            play.refuse(error)
            return
        self._ground.tell(telling.step(play.n, play.done, play.times, play.op, play.facts))
        if not changed:
            await self.end("nothing changes any more")

    async def end(self, *notes: str) -> None:
        """Ends what is played; what was cancelled is undone, as far as nothing else came after it."""
        play, self._played = self._played, None
        if play is None:
            return
        session = self._ground.session
        if play.ended == "cancel" and session.history.last_group == play.group:
            await self._ground.work(lambda: bool(session.undo()))
            await self._ground.write()
        play.facts = {**play.facts, "steps": play.done}
        self._answer(play, *notes)

    def _answer(self, play: Play, *notes: str) -> None:
        self._ground.changed()
        said = [*(self._ground.session.drawing.notes if play.done else ()), *notes]
        play.answer({"facts": telling.finite(play.facts), "notes": said, **({"stopped": True} if play.ended else {})})

    async def _apply(self, play: Play) -> bool:
        """One operation; whether it changed anything."""
        seed = play.seed if play.seed is None else play.seed + play.done
        session, watch = self._ground.session, self._watch(play)
        self._once = play
        try:
            changed = await self._ground.work(lambda: session.apply(play.op, play.params, seed, play.group, watch))
        finally:
            self._once = None
            if play.long:
                self._ground.changed()
        play.done += 1
        play.facts = session.drawing.facts
        if changed:
            self._ground.changed()
            await self._ground.write()
        return changed

    def _watch(self, play: Play) -> Callable[[Step], None]:
        """Tells the steps of work within one operation, and ends it where that is asked for; called in the session's thread."""
        loop = asyncio.get_running_loop()

        def told(now: Step) -> None:
            if not play.long:
                play.long = True
                self._ground.changed()
            self._ground.tell(telling.step(play.n, now.done, now.total, now.stage, now.facts))

        def watch(now: Step) -> None:
            loop.call_soon_threadsafe(told, now)
            while play.paused and not play.ended:
                time.sleep(REST)
            if play.ended:
                raise Halted("it was stopped before it was done; nothing was changed")

        return watch
