"""A web service that draws. Run it with `python examples/service.py 8000`, where crowquill[editor] is installed, then

    curl --data-binary @photo.jpg 'http://127.0.0.1:8000/stipple.pdf?pen=0.3mm&paper=a5' > plate.pdf

Large pictures are refused while they come in. Two drawings are at work, twenty wait; one whose client is gone is given up.
"""

import asyncio
import sys
import threading
from concurrent.futures import CancelledError, ThreadPoolExecutor
from functools import partial

import uvicorn
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route

from crowquill import kernel
from crowquill.service import LimitError, Limits, drawing, read

LIMITS = Limits(pixels=16_000_000, dots=50_000, seconds=20)
BYTES, SECONDS = 10_000_000, 30  # of a picture, and for it to come in
AT_WORK, WAITING = 2, 20
TYPES = {"pdf": "application/pdf", "svg": "image/svg+xml", "png": "image/png", "tiff": "image/tiff"}

kernel.share(AT_WORK)  # each takes its share of the cores
admitted, at_work = asyncio.Semaphore(AT_WORK + WAITING), ThreadPoolExecutor(AT_WORK)


async def picture(request: Request) -> bytes:
    """The body, as long as it is no larger than it may be."""
    data = bytearray()
    async for part in request.stream():
        data += part
        if len(data) > BYTES:
            raise HTTPException(413, f"the picture is larger than {BYTES} bytes; send a smaller one", {"Connection": "close"})
    return bytes(data)


async def gone(request: Request, said: threading.Event) -> None:
    """Says when the client is gone."""
    while (await request.receive())["type"] != "http.disconnect":
        pass
    said.set()


async def draw(request: Request) -> Response:
    """POST /STYLE.FORMAT?option=value, with a picture as its body."""
    style, _, kind = request.path_params["name"].rpartition(".")
    if kind not in TYPES:
        raise HTTPException(404, f"there are {', '.join(TYPES)}")
    if admitted.locked():
        raise HTTPException(503, "too many are waiting; come again", {"Retry-After": "10"})
    async with admitted:
        options, cancelled = read(style, request.query_params), threading.Event()
        data = await asyncio.wait_for(picture(request), SECONDS)
        watch = asyncio.create_task(gone(request, cancelled))
        try:
            work = partial(drawing, data, style, kind, options, limits=LIMITS, cancelled=cancelled.is_set)
            made = await asyncio.get_running_loop().run_in_executor(at_work, work)
        finally:
            cancelled.set()
            watch.cancel()
    return Response(made, media_type=TYPES[kind])


def answer(code: int, _: Request, error: Exception) -> Response:
    """What is said of a drawing that was refused."""
    return PlainTextResponse(str(error), code)


CODES = {LimitError: 413, ValueError: 400, TimeoutError: 408, CancelledError: 499, ClientDisconnect: 499}
app = Starlette(routes=[Route("/{name}", draw, methods=["POST"])], exception_handlers={k: partial(answer, v) for k, v in CODES.items()})

if __name__ == "__main__":
    uvicorn.run(app, host="127.0.0.1", port=int(sys.argv[1]), log_level="warning")
