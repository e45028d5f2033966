"""The hub: pages that show a drawing, their requests, and the one thread in which it is changed."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, TypeVar

from starlette.websockets import WebSocketDisconnect

from crowquill.editor import telling
from crowquill.editor.pages import Page
from crowquill.editor.requests import Halted, Request, read, told
from crowquill.editor.session import Session
from crowquill.sheet import Step

RETRY = 2.0  # s between trials to write what waits
OPEN = 1000  # requests of a page that are not answered yet
Found = TypeVar("Found")


@dataclass
class _Play:
    """An operation under way, once or several times."""

    page: Page
    n: Any
    op: str
    params: Mapping[str, Any]
    seed: int | None
    group: int
    times: int
    done: int = 0
    paused: bool = False
    ended: str = ""  # stop or cancel, once it was asked for
    facts: Mapping[str, float] = field(default_factory=dict)


class Hub:
    """All pages of one drawing. Runs in one event loop; the drawing changes in a thread of its own, a request at a time."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.revision = 0
        self.ready = False
        self.pages: set[Page] = set()
        self._queue: asyncio.Queue[tuple[Page, Request] | None] = asyncio.Queue()
        self._thread = ThreadPoolExecutor(1, "drawing")
        self._play: _Play | None = None
        self._working: _Play | None = None
        self._groups: dict[tuple[int, int], int] = {}
        self._group = 0
        self._unsaved = 0
        self._closing = False

    @property
    def busy(self) -> telling.Json | None:
        """What is under way."""
        play = self._working or self._play
        return {"n": play.n, "op": play.op, "paused": play.paused} if play else None

    async def run(self) -> None:
        """Does again what the log holds, then carries out requests, for ever."""
        saver = asyncio.create_task(self._save())
        try:
            await self._recover()
            while True:
                if self._play and (self._play.ended or not self._play.paused) and self._queue.empty():
                    await self._step(self._play)
                    continue
                if wanted := await self._queue.get():
                    page, request = wanted
                    await self._answer(page, request)
        finally:
            saver.cancel()

    async def close(self, text: str) -> None:
        """Tells all pages that the server ends, and waits for the work under way to give up."""
        self._closing = True
        for page in list(self.pages):
            with contextlib.suppress(Exception):
                await page.socket.send_text(json.dumps({"say": "closed", "text": text}))
                await page.socket.close(1001)
        await asyncio.to_thread(self._thread.shutdown, cancel_futures=True)

    async def serve(self, page: Page) -> None:
        """Serves a page until it goes."""
        self.pages.add(page)
        self._tell_tabs()
        follower = asyncio.create_task(page.follow(self))
        page.wake()
        listener = asyncio.create_task(self._listen(page))
        try:
            await asyncio.wait({follower, listener}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in (follower, listener):
                task.cancel()
            for task in (follower, listener):
                with contextlib.suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError, OSError):
                    await task
            self.pages.discard(page)
            self._tell_tabs()

    async def _listen(self, page: Page) -> None:
        while True:
            message = await page.socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            n = None
            try:
                request = read(message.get("text"))
                n = request["n"]
                if page.open >= OPEN:
                    raise ValueError(f"{OPEN} requests are waiting; send no more before they are answered")
                self._take(page, request)
            except ValueError as error:
                n = getattr(error, "n", n)
                page.say({"say": "error", "n": n, "text": str(error)})

    def _take(self, page: Page, request: Request) -> None:
        """Does at once what must be, and puts all else in the queue."""
        do = request["do"]
        if do not in ("pause", "resume", "stop", "cancel"):
            page.open += 1
            self._queue.put_nowait((page, request))
            return
        play = self._working or self._play
        if play is None:
            raise ValueError("nothing is under way")
        if do in ("pause", "resume"):
            play.paused = do == "pause"
        else:
            play.ended = do
        self._queue.put_nowait(None)  # whoever waits there sees that there is something to do
        self.revision += 1
        page.say({"say": "done", "n": request["n"], "facts": {}, "notes": []})
        self._publish()

    async def _answer(self, page: Page, request: Request) -> None:
        """Carries out a request and says what came of it."""
        try:
            found = await getattr(self, f"_{request['do']}")(page, request)
        except Exception as error:
            self._failed(page, request["n"], error)
        else:
            if found is not None:
                page.open -= 1
                page.say({"say": "done", "n": request["n"], "notes": [], **found})

    def _failed(self, page: Page, n: Any, error: Exception) -> None:
        page.open -= 1
        page.say({"say": "error", "n": n, "text": told(error)})

    async def _apply(self, page: Page, request: Request) -> telling.Json | None:
        times = request["times"]
        if not 0 <= times <= 10**9:
            raise ValueError(f"times is {times}; it takes 0, until it is stopped, or more")
        play = _Play(page, request["n"], request["op"], request["params"], request["seed"], self._grouped(page, request["group"]), times)
        if times == 1:
            await self._once(play)
            return {"facts": telling.finite(play.facts), "notes": list(self.session.drawing.notes)}
        if self._play:
            raise ValueError(f"{self._play.op} is under way; stop it first")
        self._play = play
        return None

    async def _once(self, play: _Play) -> bool:
        """One operation; whether it changed anything."""
        seed = play.seed if play.seed is None else play.seed + play.done
        self._working, watch = play, self._watch(play)
        try:
            changed = await self._work(lambda: self.session.apply(play.op, play.params, seed, play.group, watch))
        finally:
            self._working = None
        play.done += 1
        play.facts = self.session.drawing.facts
        if changed:
            self.revision += 1
            self._publish()
        return changed

    def _watch(self, play: _Play) -> Callable[[Step], None]:
        """Says the steps of work within one operation to all pages, and ends it where that is asked for; called in its thread."""
        loop = asyncio.get_running_loop()

        def watch(now: Step) -> None:
            if play.ended or self._closing:
                raise Halted("it was stopped before it was done; nothing was changed")
            message = telling.step(play.n, now.done, now.total, now.stage, now.facts)
            loop.call_soon_threadsafe(self._tell, message)

        return watch

    async def _step(self, play: _Play) -> None:
        """A step of what is played, or its end."""
        if play.ended or (play.times and play.done >= play.times):
            await self._end(play)
            return
        try:
            changed = await self._once(play)
        except Halted:
            return
        except Exception as error:
            self._play = None
            self._failed(play.page, play.n, error)
            self.revision += 1
            self._publish()
            return
        self._tell(telling.step(play.n, play.done, play.times, play.op, play.facts))
        if not changed:
            await self._end(play, "nothing changes any more")

    async def _end(self, play: _Play, *notes: str) -> None:
        self._play = None
        if play.ended == "cancel":
            while self.session.history.at and self.session.history.entries[self.session.history.at - 1].group == play.group:
                await self._work(self.session.undo)
        self.revision += 1
        stopped = {"stopped": True} if play.ended else {}
        play.page.open -= 1
        play.page.say(
            {"say": "done", "n": play.n, "facts": telling.finite({**play.facts, "steps": play.done}), "notes": list(notes), **stopped}
        )
        self._publish()

    async def _undo(self, _page: Page, request: Request) -> telling.Json:
        return await self._go(self.session.undo, request["count"])

    async def _redo(self, _page: Page, request: Request) -> telling.Json:
        return await self._go(self.session.redo, request["count"])

    async def _go(self, way: Callable[[int], int], count: int) -> telling.Json:
        if not 1 <= count <= 10**6:
            raise ValueError(f"count is {count}; it takes 1 or more")
        if self._play:
            self._play.ended = "stop"
            await self._end(self._play)
        entries = await self._work(lambda: way(count))
        self.revision += 1
        self._publish()
        return {"facts": {"entries": entries}}

    async def _show(self, page: Page, request: Request) -> telling.Json:
        if request["what"] not in telling.SHOWN:
            raise ValueError(f"no {request['what']!r} to show; there are {', '.join(telling.SHOWN)}")
        revision, drawing = self.revision, self.session.drawing
        frame = await self._work(lambda: telling.overlay(drawing, request["what"], request["layer"], revision))
        await page.socket.send_bytes(frame)
        return {"facts": {}}

    async def _export(self, _page: Page, request: Request) -> telling.Json:
        names = await self._work(lambda: self.session.export(request["files"], request["options"]))
        return {"facts": {"files": names}}

    async def _check(self, _page: Page, request: Request) -> telling.Json:
        return {"facts": await self._work(lambda: self.session.checked(request["file"]))}

    async def _files(self, _page: Page, _request: Request) -> telling.Json:
        return {"facts": {"files": await self._work(self.session.files)}}

    async def _open(self, _page: Page, request: Request) -> telling.Json:
        if self._play:
            raise ValueError(f"{self._play.op} is under way; stop it first")
        path = self.session.within(request["file"])
        if path != self.session.file:
            if self.session.journal.waiting:
                raise ValueError("edits are not on the disk yet; free some space first")
            new = await self._work(lambda: Session(path))
            old, self.session, self.ready = self.session, new, False
            await self._work(old.close)
            await self._recover()
        return {"facts": {}}

    async def _refresh(self, page: Page, _request: Request) -> telling.Json:
        page.shown, page.revision = None, -1
        return {"facts": {}}

    async def _recover(self) -> None:
        """Does again what the session's log holds."""
        loop = asyncio.get_running_loop()

        def watch(done: int, total: int) -> None:
            if self._closing:
                raise Halted
            loop.call_soon_threadsafe(self._tell, telling.step(None, done, total, "recover", {}))

        try:
            await self._work(lambda: self.session.recovered(watch))
        except Exception as error:
            self._tell({"say": "error", "n": None, "text": told(error)})
            raise
        self._group = self.session.history.next_group
        self._groups.clear()
        self.ready = True
        self.revision += 1
        self._publish()

    def _grouped(self, page: Page, group: int | None) -> int:
        """The log's number for a page's group; without one, a new number."""
        key = (id(page), group) if group is not None else None
        if key is None or key not in self._groups:
            self._group += 1
        if key is not None:
            return self._groups.setdefault(key, self._group)
        return self._group

    async def _work(self, function: Callable[[], Found]) -> Found:
        found = await asyncio.get_running_loop().run_in_executor(self._thread, function)
        self._tell_saved()
        return found

    async def _save(self) -> None:
        """Tries again and again to write what waits."""
        while True:
            await asyncio.sleep(RETRY)
            if self.session.journal.waiting:
                await self._work(self.session.journal.append)

    def _tell_saved(self) -> None:
        waiting = self.session.journal.waiting
        if waiting != self._unsaved:
            self._unsaved = waiting
            text = (
                f"edits are not written down ({self.session.journal.error}); free some space" if waiting else "all edits are written down"
            )
            self._tell({"say": "saved", "ok": not waiting, "waiting": waiting, "text": text})

    def _tell_tabs(self) -> None:
        self._tell({"say": "tabs", "count": len(self.pages)})

    def _tell(self, message: telling.Json) -> None:
        for page in self.pages:
            page.say(message)

    def _publish(self) -> None:
        for page in self.pages:
            page.wake()
