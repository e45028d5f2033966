"""What nobody should trust: files broken, huge by their header, falsely or oddly named, and numbers that are none. Only tables."""

from __future__ import annotations

import io
import os
import struct
import zlib
from typing import Any

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo


def chunk(name: bytes, data: bytes) -> bytes:
    """A chunk of a PNG file with its checksum."""
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def png(width: int, height: int, *chunks: bytes) -> bytes:
    """A grey PNG that claims a size, whatever its chunks hold."""
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) + b"".join(chunks)


def saved(image: Any, format: str, **more: Any) -> bytes:
    file = io.BytesIO()
    image.save(file, format, **more)
    return file.getvalue()


def svg(body: str, size: str = 'width="40mm" height="30mm" viewBox="0 0 40 30"') -> bytes:
    return f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" {size}>{body}</svg>'.encode()


RAMP = Image.fromarray(np.tile(np.linspace(0, 255, 40).astype(np.uint8), (30, 1)))
GOOD = saved(RAMP, "PNG")
NOISE = Image.fromarray(np.random.default_rng(1).integers(0, 256, (80, 90), dtype=np.uint8))
JPEG, TIFF, WEBP, GIF = saved(NOISE, "JPEG"), saved(NOISE, "TIFF"), saved(NOISE, "WEBP", lossless=True), saved(NOISE, "GIF")
JP2 = saved(NOISE, "JPEG2000")
PACKED = saved(NOISE, "TIFF", compression="tiff_lzw")
BOMB_JPEG = JPEG.replace(struct.pack(">HH", 80, 90), struct.pack(">HH", 65535, 65535), 1)
BOMB_GIF = GIF[:6] + struct.pack("<HH", 65535, 65535) + GIF[10:]
TEXTS = PngInfo()
TEXTS.add_text("Comment", "x" * 100_000_000, zip=True)  # 100 MB of text in 100 kB of file
BOX = '<path d="M5 5H35V25H5Z"/>'
DOT = '<path d="M30 15C30 25 10 25 10 15C10 5 30 5 30 15Z"/>'
ENTITY = b'<!DOCTYPE svg [<!ENTITY a "M30 15C30 25 10 25 10 15C10 5 30 5 30 15Z">]>'
LAUGHS = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10}">' for i in range(1, 10))
LAUGHS = f'<!DOCTYPE svg [<!ENTITY l0 "ha">{LAUGHS}]>'.encode()
USES = "".join(f'<g id="u{i}">' + f'<use xlink:href="#u{i - 1}"/>' * 10 + "</g>" for i in range(1, 10))

# name of the file: its bytes, and the story of it
PICTURES: dict[str, tuple[bytes, str]] = {
    "empty.png": (b"", "a download that never began"),
    "cut.png": (saved(NOISE, "PNG")[:4000], "a download that broke off"),
    "cut.jpg": (JPEG[: len(JPEG) // 2], "a card pulled out too soon"),
    "cut.tif": (TIFF[: len(TIFF) // 2], "half a scan"),
    "cut.webp": (WEBP[: len(WEBP) // 2], "half a picture off the web"),
    "cut.gif": (GIF[: len(GIF) // 2], "half a cartoon"),
    "box.jp2": (JP2[:15] + b"\x01" + JP2[16:], "a box of 7 million TB by its own word"),
    "packed.tif": (PACKED[:200] + bytes(200) + PACKED[400:], "a packed scan with a hole in it"),
    "head.png": (GOOD[:8], "a signature alone"),
    "crc.png": (GOOD[:29] + bytes(4) + GOOD[33:], "a header whose checksum is wrong"),
    "short.png": (png(40, 30, chunk(b"IDAT", zlib.compress(bytes(20))), chunk(b"IEND", b"")), "fewer pixels than it says"),
    "rubbish.png": (png(40, 30, chunk(b"IDAT", b"rubbish"), chunk(b"IEND", b"")), "data that do not inflate"),
    "noidat.png": (png(40, 30, chunk(b"IEND", b"")), "a PNG without pixels in it"),
    "comment.png": (saved(RAMP, "PNG", pnginfo=TEXTS), "a comment that inflates to 100 MB"),
    "letter.png": (b"Dear Sir, please find attached...\n" * 20, "a letter with the wrong suffix"),
    "page.jpg": (b"<!DOCTYPE html><html><body>404 Not Found</body></html>", "an error page saved as the picture"),
    "book.pdf": (b"%PDF-1.7\n1 0 obj<</Type/Catalog>>endobj\ntrailer<</Root 1 0 R>>\n%%EOF", "a PDF"),
    "drawing.svg": (svg(BOX), "a drawing in place of a picture"),
    "run.eps": (b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n(ran.txt) (w) file closefile\n%%EOF", "PostScript, a program"),
    "run.png": (b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n(ran.txt) (w) file closefile\n%%EOF", "and under a false name"),
    "icon.ico": (saved(RAMP, "ICO"), "an icon, a format that is not on the list"),
    "targa.tga": (saved(RAMP, "TGA"), "so is this"),
    "archive.zip": (b"PK\x03\x04" + bytes(60), "an archive"),
    "random.jpg": (np.random.default_rng(0).bytes(5000), "noise"),
    "none.png": (png(0, 30, chunk(b"IEND", b"")), "no pixel wide"),
    "none.pgm": (b"P5 0 0 255\n", "no pixel at all"),
    "none.bmp": (saved(RAMP, "BMP")[:18] + struct.pack("<ii", 0, 30) + saved(RAMP, "BMP")[26:], "no pixel wide, and a palette"),
    "bomb.png": (png(60000, 60000, chunk(b"IDAT", zlib.compress(bytes(1000)))), "3.6 thousand million pixels by its header"),
    "bomb.jpg": (BOMB_JPEG, "the largest JPEG there can be, by its header"),
    "bomb.gif": (BOMB_GIF, "the largest GIF, by its header"),
    "bomb.bmp": (saved(RAMP, "BMP")[:18] + struct.pack("<ii", 1 << 20, 1 << 20) + saved(RAMP, "BMP")[26:], "a BMP of 10^12 pixels"),
    "bomb.pgm": (b"P5 2000000 2000000 255\n123", "a header of 22 bytes that asks for 4 TB"),
    "big.png": (png(15000, 15000, chunk(b"IDAT", zlib.compress(bytes(1000)))), "just over the limit, and honest up to there"),
    "line\nbreak.png": (b"", "a name in two lines"),
    "\x1b[31mred\x1b[0m.png": (b"", "a name that paints the terminal"),
    "evil\u202egnp.exe": (b"", "a name that reads backwards"),
    "tab\tbell\a.png": (b"", "a name that rings"),
    os.fsdecode(b"latin\xe9\xff.png"): (b"", "a name that is not UTF-8"),
    "separator\u2028.png": (b"", "a name with Unicode's own end of line"),
    "n" * 251 + ".png": (b"", "the longest name a folder takes"),
}
SVGS: dict[str, tuple[bytes, str]] = {
    "empty.svg": (b"", "an empty file"),
    "broken.svg": (b"<svg><path", "XML that breaks off"),
    "words.svg": (b"a circle, please", "words"),
    "page.html": (b"<html><body/></html>", "sound XML, and no SVG"),
    "entities.svg": (ENTITY + svg('<path d="&a;"/>'), "an outline by way of an entity"),
    "wide.svg": ((ENTITY + svg('<path d="&a;"/>')).decode().encode("utf-16"), "the same in sixteen bits"),
    "laughs.svg": (LAUGHS + svg(f"<desc>&l9;</desc>{DOT}"), "ten entities that would be a thousand million words"),
    "outside.svg": (b'<!DOCTYPE svg [<!ENTITY a SYSTEM "good.png">]>' + svg(f"<desc>&a;</desc>{DOT}"), "another file of ours"),
    "deep.svg": (svg("<g>" * 5000 + "</g>" * 5000), "groups five thousand deep"),
    "nothing.svg": (svg(""), "a page with nothing on it"),
    "script.svg": (svg("<script>alert(1)</script>"), "a script alone"),
    "open.svg": (svg('<path d="M5 5L35 5L35 25" fill="none"/>'), "an outline that is open"),
    "flat.svg": (svg('<path d="M5 5L35 5L5 5Z"/>'), "an outline without area"),
    "number.svg": (svg('<path d="M5 5L1e999 5L35 25Z"/>'), "a number too large to be one"),
    "nonsense.svg": (svg('<path d="M5 5 five,six Z"/>'), "data that are not numbers"),
}
CANVASES = SVGS | {
    "pixels.svg": (GOOD, "a picture under a false name"),
    "nosize.svg": (svg(BOX, 'width="0" height="0"'), "a page of no size"),
    "percent.svg": (svg(BOX, 'width="wide" height="abc"'), "a size in words"),
    "half.svg": (svg('<circle cx="20" cy="15" r="half"/>'), "a radius in words"),
    "minus.svg": (svg('<circle cx="20" cy="15" r="-5"/>'), "a negative radius"),
    "turned.svg": (svg(f'<g transform="rotate(nan)">{BOX}</g>'), "a turn by nothing that is a number"),
    "away.svg": (svg('<path d="M500 5H535V25H505Z"/>'), "an outline off the page"),
    "huge.svg": (svg('<path d="M5 5C999999999999999999 5 35 5 35 25Z"/>'), "a curve longer than the solar system"),
    "itself.svg": (svg(f'<g id="a">{BOX}<use xlink:href="#a"/></g>'), "a group that contains itself"),
    "uses.svg": (svg(f'<g id="u0">{BOX}</g>{USES}'), "ten of ten of ten, nine times over"),
}
LIBRARIES = SVGS | {
    "letters.svg": (svg('<text x="1" y="1">...</text>'), "dots that are full stops"),
    "picture.svg": (svg('<image width="9" height="9" xlink:href="good.png"/>'), "dots that are in a picture"),
    "thin.svg": (svg('<path d="M0 0C1 1 2 2 3 3C2 2 1 1 0 0Z"/>'), "a dot without area"),
    "hair.svg": (svg('<path d="M0 0C30 .001 60 .001 100 0C60 -.001 30 -.001 0 0Z"/>'), "a dot 100 mm long and a thousandth wide"),
    "vast.svg": (svg('<path d="M0 0C1e150 1 2 2e150 3e150 3C2 -2e150 1 -1e150 0 0Z"/>'), "a dot whose area is beyond all numbers"),
    "twice.svg": (svg('<path d="M1 0C1 1 0 1 0 0C0 -1 1 -1 1 0ZM3 3C4 4 2 4 3 3Z"/>'), "two outlines in one path"),
    "notes.svg": (svg(f"<metadata><library>{{not JSON</library></metadata>{DOT}"), "notes that are not JSON"),
    "list.svg": (svg(f"<metadata><library>[1, 2]</library></metadata>{DOT}"), "notes that are a list"),
    "nest.svg": (svg(f"<metadata><library>{'[' * 100_000}</library></metadata>{DOT}"), "notes a hundred thousand deep"),
    "named.svg": (svg(f'<path id="{"i" * 5000}" d="M0 0Z"/>'), "a bad path with a name of 5000 letters"),
}

# what is typed behind `stipple good.png out.svg` on a small paper, and the story; the line must name the option typed last, or
# hold the words that come third
OPTIONS: list[tuple[str, ...]] = [
    ("--paper a99", "a paper there is not"),
    ("--paper ''", "no paper"),
    ("--paper 0x100mm", "a paper that is a line"),
    ("--paper -10x10mm", "a negative paper"),
    ("--paper nanxnanmm", "a paper of no number"),
    ("--paper 100x50", "a paper without a unit"),
    ("--paper 100x50px", "a paper in pixels"),
    ("--paper 999999x10mm", "a paper of a kilometre", "999999"),
    (f"--paper {'9' * 5000}mm", "a paper in five thousand digits"),
    ("--orientation sideways", "an orientation there is not"),
    ("--fit squash", "a fit there is not"),
    ("--tone sepia", "a tone there is not"),
    ("--start middle", "a start there is not"),
    ("--white-rule never", "a white rule there is not"),
    ("--glyphs nib-99", "a library there is not", "nib-99"),
    ("--glyphs ''", "no library", "glyph"),
    ("--glyphs ../nib-03", "a library by a path without a suffix", "../nib-03"),
    ("--pen 0mm", "a pen of no width"),
    ("--pen -0.3mm", "a negative pen"),
    ("--pen nanmm", "a pen that is not a number"),
    ("--pen inf", "a pen without end"),
    ("--pen 0.3", "a pen without a unit"),
    ("--pen 0.3px", "a pen in pixels"),
    ("--pen 0,3mm", "a pen with a decimal comma"),
    ("--pen 1e-1mm", "a pen in powers of ten"),
    ("--pen ''", "a pen of nothing"),
    ("--pen 999999999mm", "a pen of a thousand kilometres"),
    ("--pen 51mm", "a pen over the largest"),
    ("--pen 45mm", "a pen wider than the canvas"),
    ("--dots 0", "no dot asked for"),
    ("--dots -1", "less than none"),
    ("--dots 1.5", "one dot and a half"),
    ("--dots nan", "dots that are no number"),
    ("--dots 1e3", "dots in powers of ten"),
    (f"--dots {10**30}", "more dots than atoms in the ink"),
    (f"--dots {'9' * 5000}", "a number that Python itself refuses to read"),
    ("--dots 1000 --max-dots 999", "more dots than allowed"),
    ("--pen 0.01mm --max-dots 1000", "a pen too fine for the dots allowed"),
    ("--max-dots 0", "no dots allowed"),
    ("--max-dots -1", "less than none allowed"),
    ("--max-dots lots", "a word for a number"),
    ("--iterations -1", "steps back"),
    ("--iterations 1.5", "one step and a half"),
    ("--iterations 100001", "more steps than anybody waits for"),
    ("--until -1", "to stop before the start"),
    ("--until 2", "to stop at two spacings"),
    ("--until nan", "to stop at no number"),
    ("--step 0", "not to move"),
    ("--step 2", "to move so far that nothing falls"),
    ("--step nan", "to move by no number"),
    ("--exponent -1", "dots away from the ink"),
    ("--exponent 5", "an exponent too large"),
    ("--exponent inf", "an exponent without end"),
    ("--white -0.1", "whiter than white"),
    ("--white 1.1", "blacker than black"),
    ("--white nan", "white that is no number"),
    ("--min-gap -1mm", "a negative gap"),
    ("--min-gap 0.1", "a gap without a unit"),
    ("--min-gap 101mm", "a gap wider than the paper"),
    ("--seed -1", "a negative seed"),
    ("--seed 1.5", "half a seed"),
    ("--seed x", "a letter for a seed"),
    ("--gamma 0", "all coverage becomes one"),
    ("--gamma -1", "a negative power"),
    ("--gamma nan", "a power that is no number"),
    ("--gamma 11", "a power too large"),
    ("--black-point -1", "blacker than black"),
    ("--black-point 1", "white called black"),
    ("--black-point nan", "no number called black"),
    ("--white-point 0", "black called white"),
    ("--white-point 2", "whiter than white"),
    ("--white-point inf", "white without end"),
    ("--white-point 0.3 --black-point 0.7", "the two points the wrong way round"),
    ("--local-contrast -1", "negative contrast"),
    ("--local-contrast 2", "more than all of it"),
    ("--local-contrast nan", "contrast that is no number"),
    ("--crop 0,0,1", "three numbers for four"),
    ("--crop a,b,c,d", "letters for numbers"),
    ("--crop 0,0,0,0", "a cut of nothing"),
    ("--crop 0,0,2,1", "a cut wider than the picture"),
    ("--crop -0.1,0,1,1", "a cut to the left of the picture"),
    ("--crop nan,0,1,1", "a cut from no number"),
    ("--crop 0,0,1,inf", "a cut without end"),
    ("--max-pixels 100", "a picture over the limit that is asked for"),
    ("--max-pixels 0", "no pixel allowed"),
    ("--max-pixels -5", "less than none allowed"),
    ("--max-pixels 1.5", "half a pixel allowed"),
    ("--margin -1mm", "a negative margin"),
    ("--margin 15", "a margin without a unit"),
    ("--margin 20mm", "a margin that eats the paper to the last"),
    ("--margin 9999mm", "a margin wider than the paper"),
    ("--width 0mm", "a drawing of no width"),
    ("--width -5mm", "a negative width"),
    ("--width 5px", "a width in pixels"),
    ("--width 1000mm", "a drawing wider than the paper", "does not fit"),
    ("--height 0mm", "a drawing of no height"),
    ("--height -5mm", "a negative height"),
    ("--height 31mm", "a drawing higher than its room by a millimetre", "does not fit"),
    ("--fit stretch --height 10mm --width 200mm", "a drawing stretched over the paper's edge", "does not fit"),
    ("--margin 2mm --check-bar", "no room for a bar"),
    ("--paper 14x14mm --check-bar", "a bar longer than the paper from the margin on"),
    ("--report .", "a report over a folder", "folder"),
    ("--report out.svg", "a report over the drawing", "out.svg"),
    ("--report good.png", "a report over the picture", "good.png"),
    ("--report nowhere/report.json", "a report in a folder that is not there", "nowhere"),
    ("--pne 0.3mm", "an option misspelt"),
    ("--dot 5", "an option cut short"),
    ("--pen", "an option without its value"),
    ("--no-such-thing", "an option there is not"),
    ("--quiet=yes", "a switch with a value"),
    ("-p 0.3mm", "a letter that is no option"),
]

# what a recipe holds, what the line must say of it, and the story
RECIPES: list[tuple[str, str, str]] = [
    ("", "style", "an empty file"),
    ("seed = 1", "style", "no style"),
    ("style = 'stipple'\nseed", "TOML", "half a line"),
    ("style = 'stipple'\n" + "a." * 5000 + "b = 1", "r.toml", "a key nested five thousand deep"),
    ("style = 'stipple'\nx = " + "[" * 5000, "r.toml", "a list five thousand deep"),
    ("style = 'stiple'", "stipple", "a style misspelt"),
    ("style = 5", "style", "a number for a style"),
    ("style = 'stipple'\nschema = 2", "newer", "a recipe of the years to come"),
    ("style = 'stipple'\nschema = 'one'", "schema", "a word for a schema"),
    ("style = 'stipple'\nschema = 0", "schema", "a recipe from before there were any"),
    (f"style = 'stipple'\nseed = {'9' * 5000}", "r.toml", "a seed of five thousand digits"),
    ("style = 'stipple'\n[sources.picture]\nname = '..'", "bare name", "the folder above for a picture"),
    ("style = 'stipple'\nschema = true", "schema", "yes for a schema"),
    ("style = 'stipple'\nversion = 1", "version", "a number for a version"),
    ("style = 'stipple'\nseeds = 1", "seed", "a key misspelt"),
    ("style = 'stipple'\nseed = -1", "seed", "a negative seed"),
    ("style = 'stipple'\nseed = 1.5", "seed", "half a seed"),
    ("style = 'stipple'\nseed = true", "seed", "yes for a seed"),
    ("style = 'stipple'\nknobs = 5", "knobs", "a number for a table"),
    ("style = 'stipple'\nsources = []", "sources", "a list for a table"),
    ("style = 'stipple'\n[knobs]\npne = 0.3", "did you mean pen?", "a knob misspelt"),
    ("style = 'stipple'\n[knobs]\npen = 'wide'", "pen", "a word for a width"),
    ("style = 'stipple'\n[knobs]\npen = 0", "pen", "a pen of no width"),
    ("style = 'stipple'\n[knobs]\npen = true", "pen", "yes for a width"),
    ("style = 'stipple'\n[knobs]\npen = nan", "pen", "a width that is no number"),
    ("style = 'stipple'\n[knobs]\ndots = 1.5", "dots", "one dot and a half"),
    ("style = 'stipple'\n[knobs]\nstart = 'middle'", "start", "a start there is not"),
    ("style = 'stipple'\n[knobs]\nstart = 3", "start", "a number for a name"),
    ("style = 'stipple'\n[knobs]\nglyphs = 3", "glyphs", "a number for a library"),
    ("style = 'stipple'\n[knobs]\nglyphs = '../dots.svg'", "bare name", "a library in another folder"),
    ("style = 'stipple'\n[tone]\ncanvas = '/etc/passwd.svg'", "bare name", "a canvas out of the system's own files"),
    ("style = 'stipple'\n[paper]\ncheck_bar = 1", "check_bar", "a number for yes"),
    ("style = 'stipple'\n[paper]\nwidht = 100", "did you mean width?", "a setting of the paper misspelt"),
    ("style = 'stipple'\n[tone]\ncrop = [0, 0, 1]", "crop", "three numbers for four"),
    ("style = 'stipple'\n[tone]\ngama = 1", "did you mean gamma?", "a setting of the tone misspelt"),
    ("style = 'stipple'\n[files]\nembde = true", "did you mean embed?", "a setting of the files misspelt"),
    ("style = 'stipple'\n[files]\nembed = 'yes'", "embed", "a word for yes"),
    ("style = 'stipple'\n[sources.picture]\nname = '../good.png'", "bare name", "a picture in another folder"),
    ("style = 'stipple'\n[sources.picture]\nname = 5", "picture", "a number for a name"),
    ("style = 'stipple'\n[sources.picture]\nname = 'good.png'\nsha256 = 'abc'", "sha256", "a hash cut short"),
    ("style = 'stipple'\n[sources.picture]\nname = 'good.png'\nsha265 = 'abc'", "did you mean sha256?", "a hash misspelt"),
    ("style = 'stipple'\n[sources.glyphs]\nname = 'dots.svg'", "glyphs", "a source that no setting names"),
]
