"""Other people's libraries: what of an SVG file is refused, which elements are objects, and what is named because it is not read."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any
from xml.parsers import expat

from crowquill.vector import local

GROUPS = {"g", "svg", "a", "switch", "use"}
SHAPES = {"path", "rect", "circle", "ellipse", "line", "polygon", "polyline"}
CONDITIONS = {"requiredExtensions", "requiredFeatures", "systemLanguage"}
# What is not read, by the word that says so in a warning; the second lot are attributes.
UNREAD = {
    **dict.fromkeys(("text", "tspan", "textPath", "foreignObject"), "text"),
    **{"image": "pictures", "clipPath": "clips", "mask": "masks", "filter": "filters", "pattern": "patterns", "marker": "markers"},
    **dict.fromkeys(("linearGradient", "radialGradient", "meshgradient"), "gradients"),
    **dict.fromkeys(("animate", "animateTransform", "animateMotion", "set"), "animation"),
}
UNREAD_OF = {"clip-path": "clips", "mask": "masks", "filter": "filters"}
STYLES = "style sheets beyond rules for one tag, class or id"
SELECTOR = re.compile(r"\s*(?:\*|#[\w-]+|[\w-]*\.[\w-]+|[\w-]+)\s*")
LINK = re.compile(r"(?:@import\s*(?:url\(\s*)?|url\(\s*)['\"]?([^'\")\s;]+)", re.IGNORECASE)


def refuse(data: bytes, every: list[Any], name: str) -> None:
    """Raises ValueError for scripts and for links to other files: nothing is run and nothing fetched. W3C's own DOCTYPE may stay."""
    links = _before(data, name)
    for element in every:
        values = [re.sub(r"[\0-\x20]", "", value).lower() for value in element.attrib.values()]
        handled = any(key.lower().startswith("on") for key in element.attrib) or any(value.startswith("javascript:") for value in values)
        if local(element) == "script" or handled:
            raise ValueError(f"{name}: has a script; save it as plain SVG")
        hrefs = {"src"} if local(element) == "a" else {"href", "src"}  # where an <a> leads is no part of the drawing
        links += [value.strip() for key, value in element.items() if key.rsplit("}", 1)[-1] in hrefs]
        rules = [*element.attrib.values(), *([_rules(element)] if local(element) == "style" else [])]
        links += [link for rule in rules for link in LINK.findall(rule)]
    for link in links:
        if not link.startswith(("#", "data:")):
            raise ValueError(f"{name}: refers to another file ({link[:40]!r}); put what it draws into this one")


def _before(data: bytes, name: str) -> list[str]:
    """The style sheets and document types of other files that the head of a file names."""
    found: list[str] = []

    def doctype(*about: Any) -> None:
        system = str(about[1] or "")
        if system and not re.match(r"https?://www\.w3\.org/", system):
            found.append(system)

    def instruction(target: str, text: str) -> None:
        if target == "xml-stylesheet":
            found.append(next(iter(re.findall(r"href\s*=\s*['\"]([^'\"]*)", text)), target))

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler, parser.ProcessingInstructionHandler = doctype, instruction
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise ValueError(f"{name}: not sound SVG ({error}); save it again") from None
    return found


def _rules(style: Any) -> str:
    """The text of a style sheet without its comments."""
    return re.sub(r"/\*.*?(?:\*/|\Z)", " ", "".join(style.itertext()), flags=re.DOTALL)


def chosen(every: list[Any]) -> bool:
    """Leaves in each <switch> its first part without a condition, or else its first; whether any had a choice."""
    choice = False
    for element in every:
        parts = [child for child in element if local(child) in SHAPES | GROUPS] if local(element) == "switch" else []
        kept = next((part for part in parts if not CONDITIONS & set(part.attrib)), parts[0] if parts else None)
        choice |= len(parts) > 1
        for part in parts:
            if part is not kept:
                element.remove(part)
    return choice


def objects(root: Any) -> list[Any]:
    """The elements that are one object each."""
    parts = [child for child in root if local(child) in SHAPES | GROUPS]
    if len(parts) == 1 and local(parts[0]) in GROUPS - {"use"}:
        return objects(parts[0])
    layered = [any(key.endswith("groupmode") and value == "layer" for key, value in part.items()) for part in parts]
    return [one for part, layer in zip(parts, layered, strict=True) for one in (objects(part) if layer else [part])]


def standing(root: Any) -> Iterator[Any]:
    """The shapes and copies that are drawn where they stand."""
    for child in root:
        if local(child) in SHAPES | {"use"}:
            yield child
        elif local(child) in GROUPS:
            yield from standing(child)


def unread(every: list[Any]) -> list[str]:
    """The words for what a file has and is not read, in the order of the table."""
    found = {UNREAD.get(local(element)) for element in every}
    found |= {word for element in every for key, word in UNREAD_OF.items() if element.get(key, "none") != "none"}
    found |= {"gradients" for element in every if "url(#" in element.get("fill", "") + element.get("stroke", "") + element.get("style", "")}
    drawn = False
    for element in every:
        drawn |= local(element) in SHAPES  # rules hold for what comes after them
        if local(element) == "style" and (drawn or not _plain(_rules(element))):
            found.add(STYLES)
    return [word for word in dict.fromkeys([*UNREAD.values(), *UNREAD_OF.values(), STYLES]) if word in found]


def _plain(rules: str) -> bool:
    """Whether a style sheet has rules for one tag, class or id only."""
    selectors = [one for part in rules.split("{")[:-1] for one in part.rpartition("}")[2].split(",")]
    return not re.search("[@!]", rules) and all(SELECTOR.fullmatch(one) for one in selectors)


def paint(shape: Any) -> tuple[bool, bool]:
    """Whether a shape is filled, and whether it is stroked: with an opacity of 0 neither is."""
    filled, stroked = (
        str(shape.values.get(key, "none")).strip() not in ("none", "transparent")
        and _alpha(shape, key) > 0
        and min(_opacity(shape, f"{key}-opacity"), _opacity(shape, "opacity")) > 0
        for key in ("fill", "stroke")
    )
    return filled, stroked and not re.fullmatch(r"(0+\.?0*|\.0+)[a-z%]*", str(shape.values.get("stroke-width", 1)).strip())


def _opacity(shape: Any, key: str) -> float:
    """An opacity of a shape, 1 where it has none that can be read."""
    found = re.fullmatch(r"\s*(\d*\.?\d+)(%?)\s*", str(shape.values.get(key, "1")))
    return float(found[1]) / (100 if found[2] else 1) if found else 1.0


def _alpha(shape: Any, key: str) -> int:
    """The opacity of a shape's colour, 0 to 255, and that where it has no colour that can be read."""
    alpha = getattr(getattr(shape, key), "alpha", None)
    return 255 if alpha is None else int(alpha)


def unheeded(shape: Any, closed: bool) -> set[str]:
    """The words for what a shape asks for and a black pen does not give."""
    (filled, stroked), words = paint(shape), set()
    if closed and filled:
        words |= {"strokes around areas"} if stroked else set()
        words |= {"white fills"} if (shape.fill.red, shape.fill.green, shape.fill.blue) == (255, 255, 255) else set()
    else:
        words |= {"stroke widths"} if "stroke-width" in shape.values else set()
        words |= {"dashes"} if str(shape.values.get("stroke-dasharray", "none")).strip() != "none" else set()
    keys = ("opacity", "fill-opacity", "stroke-opacity")
    clear = any(0 < _opacity(shape, key) < 1 for key in keys) or any(0 < _alpha(shape, key) < 255 for key in ("fill", "stroke"))
    return words | ({"opacity"} if clear else set())
