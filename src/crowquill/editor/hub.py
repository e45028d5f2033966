"""The hub: pages that show a drawing, their requests, and the one thread in which it is changed."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from starlette.websockets import WebSocketDisconnect

from crowquill.editor import telling
from crowquill.editor.pages import Page
from crowquill.editor.playing import Play, Player
from crowquill.editor.requests import Request, read, told
from crowquill.editor.session import Session

RETRY = 2.0  # s between trials to write what waits
OPEN = 1000  # requests of a page that are not answered yet
AT_ONCE = ("pause", "resume", "stop", "cancel")
READING = ("show", "export", "check", "files", "refresh")  # change nothing of the drawing
Found = TypeVar("Found")


class Hub:
    """All pages of one drawing. Runs in one event loop; the drawing changes in a thread of its own, a request at a time."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.revision = 1
        self.pages: set[Page] = set()
        self.player = Player(self)
        self._queue: asyncio.Queue[tuple[Page, Request] | None] = asyncio.Queue()
        self._thread = ThreadPoolExecutor(1, "drawing")
        self._group = session.history.last_number
        self._unsaved = 0
        self._beside = ThreadPoolExecutor(1, "reading")
        self._keeper = ThreadPoolExecutor(1, "states")  # one after the other, as each says which are of what was undone
        self._tasks: set[asyncio.Task[None]] = set()
        self._lacking = False

    @property
    def busy(self) -> telling.Json | None:
        """What is under way."""
        return self.player.busy

    async def run(self) -> None:
        """Carries out requests, and between them steps of what is played, for ever."""
        saver = asyncio.create_task(self._save())
        try:
            while True:
                if self.player.goes_on and self._queue.empty():
                    try:
                        await self.player.step()
                    except Exception as error:  # a fault of ours must not end all other work
                        self.player.drop()
                        self.tell({"say": "error", "n": None, "text": told(error)})
                elif wanted := await self._queue.get():
                    page, request = wanted
                    page.changes -= request["do"] not in READING
                    await self._carry_out(page, request)
        finally:
            for task in (saver, *self._tasks):
                task.cancel()

    async def close(self, text: str) -> None:
        """Tells all pages that the server ends, and waits for the work under way to give up."""
        self.player.end_all()
        for page in list(self.pages):
            with contextlib.suppress(Exception):
                await page.socket.send_text(json.dumps({"say": "closed", "text": text}))
                await page.socket.close(1001)
        await asyncio.to_thread(self._thread.shutdown, cancel_futures=True)
        await asyncio.to_thread(self._beside.shutdown, cancel_futures=True)
        await asyncio.to_thread(self._keeper.shutdown)

    async def serve(self, page: Page) -> None:
        """Serves a page until it goes. What is played ends with the last page."""
        self.pages.add(page)
        self._tell_tabs()
        if self._unsaved:
            page.say(telling.saved(self.session.journal))
        tasks = {asyncio.create_task(page.follow(self)), asyncio.create_task(self._listen(page))}
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self.pages.discard(page)
            for task in tasks:
                task.cancel()
                with contextlib.suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError, OSError):
                    await task
            self._tell_tabs()
            if not self.pages and self.player.busy:
                self.player.end_all()
                self._queue.put_nowait(None)

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
                page.say({"say": "error", "n": getattr(error, "n", n), "text": str(error)})

    def _take(self, page: Page, request: Request) -> None:
        """Does at once what must be, unless what it is meant for still waits itself, and puts all else in the queue.

        What only reads is not kept waiting by a long operation, unless a change of the same page waits that it might be about.
        """
        page.open += 1
        if request["do"] in READING and self.player.long and not page.changes:
            task = asyncio.create_task(self._carry_out(page, request))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)
            return
        if request["do"] not in AT_ONCE or (not self.player.busy and not self._queue.empty()):
            page.changes += request["do"] not in READING
            self._queue.put_nowait((page, request))
            return
        try:
            self.player.order(request["do"])
        except ValueError as error:
            page.refuse(request["n"], error)
            return
        page.answer(request["n"], {"facts": {}})
        self._queue.put_nowait(None)  # whoever waits there sees that there is something to do

    async def _carry_out(self, page: Page, request: Request) -> None:
        """Carries out a request and says what came of it."""
        try:
            found = self._order(request) if request["do"] in AT_ONCE else await getattr(self, f"_{request['do']}")(page, request)
        except Exception as error:
            page.refuse(request["n"], error)
        else:
            if found is not None:
                page.answer(request["n"], {"facts": found})

    def _order(self, request: Request) -> telling.Json:
        self.player.order(request["do"])
        return {}

    async def _apply(self, page: Page, request: Request) -> None:
        n, times = request["n"], request["times"]
        if not 0 <= times <= 10**9:
            raise ValueError(f"times is {times}; it takes 0, until it is stopped, or more")
        group = self._grouped(page, request["group"])
        values = (request["op"], request["params"], request["seed"], group, times)
        await self.player.begin(Play(n, *values, answer=lambda found: page.answer(n, found), refuse=lambda error: page.refuse(n, error)))

    async def _undo(self, _page: Page, request: Request) -> telling.Json:
        return await self._go(self.session.undo, request["count"])

    async def _redo(self, _page: Page, request: Request) -> telling.Json:
        return await self._go(self.session.redo, request["count"])

    async def _go(self, way: Callable[[int], int], count: int) -> telling.Json:
        if not 1 <= count <= 10**6:
            raise ValueError(f"count is {count}; it takes 1 or more")
        self.player.end_all()
        await self.player.end()
        entries = await self.work(lambda: way(count))
        self.changed()
        await self.write()
        return {"entries": entries}

    async def _show(self, page: Page, request: Request) -> telling.Json:
        if request["what"] not in telling.SHOWN:
            raise ValueError(f"no {request['what']!r} to show; there are {', '.join(telling.SHOWN)}")
        revision, drawing = self.revision, self.session.drawing
        page.say(await self.read(lambda: telling.overlay(drawing, request["what"], request["layer"], revision)))
        return {}

    async def _export(self, _page: Page, request: Request) -> telling.Json:
        return {"files": await self.read(lambda: self.session.export(request["files"], request["options"], overwrite=request["overwrite"]))}

    async def _check(self, _page: Page, request: Request) -> telling.Json:
        return await self.read(lambda: self.session.checked(request["file"]))

    async def _files(self, _page: Page, _request: Request) -> telling.Json:
        return {"files": await self.read(self.session.files)}

    async def _open(self, _page: Page, request: Request) -> telling.Json:
        self.player.check_idle()
        path = self.session.within(request["file"])
        if path == self.session.file:
            return {}
        if self.session.journal.waiting:
            raise ValueError("edits are not on the disk yet; free some space first")
        loop = asyncio.get_running_loop()

        def watch(done: int, total: int) -> None:
            loop.call_soon_threadsafe(self.tell, telling.step(request["n"], done, total, "recover", {}))

        old, self.session = self.session, await self.work(lambda: Session(path, watch=watch))
        await self.work(old.close)
        self._group = self.session.history.last_number
        for page in self.pages:
            page.groups.clear()
        self.changed()
        return {}

    async def _refresh(self, page: Page, _request: Request) -> telling.Json:
        page.forget()
        return {}

    def _grouped(self, page: Page, group: int | None) -> int:
        """The log's number for a page's group; without one, a new number."""
        if group not in page.groups or group is None:
            self._group += 1
        return self._group if group is None else page.groups.setdefault(group, self._group)

    async def work(self, function: Callable[[], Found]) -> Found:
        """What a function gives that is called in the session's thread."""
        return await asyncio.get_running_loop().run_in_executor(self._thread, function)

    async def read(self, function: Callable[[], Found]) -> Found:
        """What a function gives that changes nothing, called in a thread beside the session's."""
        return await asyncio.get_running_loop().run_in_executor(self._beside, function)

    async def write(self) -> None:
        """Writes down what waits, and tells when that does not go, or goes again."""
        session = self.session
        journal, keep = session.journal, await self.work(session.write)
        if keep:
            asyncio.get_running_loop().run_in_executor(self._keeper, self._kept, keep, asyncio.get_running_loop())
        if journal.waiting != self._unsaved:
            self._unsaved = journal.waiting
            self.tell(telling.saved(journal))

    def _kept(self, keep: Callable[[], str], loop: asyncio.AbstractEventLoop) -> None:
        """Keeps a state, in a thread beside; where that fails it is said, once until it goes again."""
        why = keep()
        if why and not self._lacking:
            text = f"the state could not be kept beside the log ({why}): opening it again takes longer; nothing is lost"
            loop.call_soon_threadsafe(self.tell, {"say": "error", "n": None, "text": text})
        self._lacking = bool(why)

    async def _save(self) -> None:
        """Tries again and again to write what waits."""
        while True:
            await asyncio.sleep(RETRY)
            if self.session.journal.waiting:
                await self.write()

    def tell(self, message: telling.Json) -> None:
        """Says something to all pages."""
        for page in self.pages:
            page.say(message)

    def changed(self) -> None:
        """Has all pages catch up."""
        self.revision += 1
        for page in self.pages:
            page.wake()

    def _tell_tabs(self) -> None:
        self.tell({"say": "tabs", "count": len(self.pages)})
