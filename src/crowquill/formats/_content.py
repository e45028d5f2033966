"""A page's operators, packed as they come: of a million outlines there are 250 MB, and 90 MB packed."""

from __future__ import annotations

import hashlib
import io
import tempfile
import zlib
from collections.abc import Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self, cast

import pikepdf

LEVEL = 4  # 9 takes four times as long for 5 % less
HELD = 1 << 25  # bytes packed in memory; more go to a file
WAITING = 3  # pieces that are made while others are packed


class Content:
    """Takes operators, and puts them, deflated, into a PDF of one page, in place of its own. They are never held as a whole.

    Pieces are packed beside the making of the next ones, in their order.

    page    the bytes of the PDF
    beside  the file that is written at last; in its folder much is kept until then, without a name
    """

    def __init__(self, page: bytes, beside: BinaryIO) -> None:
        named = getattr(beside, "name", None)
        folder = str(Path(named).parent) if isinstance(named, str) else None
        self._packer, self._digest = zlib.compressobj(LEVEL), hashlib.md5(usedforsecurity=False)
        self._waiting: list[Future[int]] = []
        self._pool = ThreadPoolExecutor(1)
        self._file = tempfile.SpooledTemporaryFile(HELD, dir=folder)  # noqa: SIM115
        with pikepdf.open(io.BytesIO(page)) as pdf:
            self._own, self._length = pdf.pages[0].Contents.objgen[0], int(pdf.trailer["/Size"])
        self._trailer, self._table = page[page.rindex(b"trailer") :].split(b">>\nstartxref\n")
        self._file.write(page)
        self._places = [self._file.tell()]
        self._file.write(f"{self._own} 0 obj\n<< /Length {self._length} 0 R /Filter /FlateDecode >>\nstream\n".encode("ascii"))
        self._begin = self._file.tell()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._pool.shutdown(cancel_futures=True)
        self._file.close()

    def append(self, operators: str) -> None:
        """Adds operators, which begin on a line of their own."""
        self.extend([[operators]])

    def extend(self, every: Iterable[Iterable[str]]) -> None:
        """Adds several, each in pieces."""
        for pieces in every:
            for k, piece in enumerate(pieces):
                self._waiting.append(self._pool.submit(self._pack, piece if k else f"\n{piece}"))
                if len(self._waiting) > WAITING:
                    self._waiting.pop(0).result()

    def _pack(self, piece: str) -> int:
        data = piece.encode("latin-1")
        self._digest.update(data)
        return self._file.write(self._packer.compress(data))

    @property
    def digest(self) -> bytes:
        """The MD5 of all that was added, once the PDF is whole."""
        return self._digest.digest()

    def whole(self) -> BinaryIO:
        """The PDF as an open file. Nothing can be added any more.

        The stream follows behind the PDF as what was changed in it later. Given to the library as bytes it would be held three times.
        """
        self.append(" \n")
        while self._waiting:
            self._waiting.pop(0).result()
        file = self._file
        file.write(self._packer.flush())
        length = file.tell() - self._begin
        file.write(b"\nendstream\nendobj\n")
        self._places.append(file.tell())
        file.write(f"{self._length} 0 obj\n{length}\nendobj\n".encode("ascii"))
        table, numbers = file.tell(), (self._own, self._length)
        entries = (f"{number} 1\n{place:010} 00000 n \n" for number, place in zip(numbers, self._places, strict=True))
        file.write(b"xref\n" + "".join(entries).encode("ascii"))
        file.write(self._trailer.replace(f"/Size {self._length}".encode("ascii"), f"/Size {self._length + 1}".encode("ascii")))
        file.write(b"/Prev " + self._table.split()[0] + f"\n>>\nstartxref\n{table}\n%%EOF\n".encode("ascii"))
        file.seek(0)
        return cast(BinaryIO, file)
