"""What may be said about a picture, as the options of `halfline render`."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeAlias

from halfline._native import picture_size

Vector: TypeAlias = Sequence[float]
"""Three numbers."""

Color: TypeAlias = str | Sequence[float]
"""sRGB: "#rrggbb", or red, green and blue in 0..1."""

# Keyword arguments that are not options of the same name.
_SIZE = ("width", "height")
_OPTIONAL_VALUES = ("camera_orthographic", "ground")


def options_of(settings: Mapping[str, Any]) -> list[str]:
    """The options that keyword arguments of `Scene.render` mean; those that are None mean nothing.

    Raises:
        TypeError: For an argument of a type that it cannot have.
        ValueError: For one that makes no sense, naming it and what was expected.
    """
    options = ["--resolution", f"{settings['width']},{settings['height']}"]
    for name, value in settings.items():
        if name not in _SIZE and value is not None:
            options += _option(name, value)
    try:
        picture_size(options)
    except ValueError as error:
        raise ValueError(_renamed(str(error))) from None
    return options


def _option(name: str, value: Any) -> Iterator[str]:
    option = "--" + name.replace("_", "-")
    if name == "lights":
        if isinstance(value, str) or not all(isinstance(light, str) for light in value):
            raise TypeError("lights: expected strings, as --light of the command has them")
        for light in value:
            yield from ("--light", light)
    elif name == "background":
        if isinstance(value, str) and value in ("studio", "none"):
            if value == "none":
                yield "--no-background"
        else:
            yield f"--background-color={_text(name, value)}"
    elif name in _OPTIONAL_VALUES and isinstance(value, bool):
        if value:
            yield option
    else:
        yield f"{option}={_text(name, value)}"


def _text(name: str, value: Any) -> str:
    """A value as the command line has it; numbers keep every digit."""
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        raise TypeError(f"{name}: expected no bool")
    try:
        numbers = [_number(value)] if not hasattr(value, "__len__") else [*map(_number, value)]
    except (TypeError, ValueError):
        kind = type(value).__name__
        raise TypeError(f"{name}: expected text, a number or three numbers, found {kind}") from None
    return ",".join(numbers)


def _number(value: Any) -> str:
    return repr(int(value)) if hasattr(value, "__index__") else repr(float(value))


def _renamed(message: str) -> str:
    """The line that the command would say, with the names of arguments instead of options."""
    message = message.replace("--no-background", "background").replace("--light ", "--lights ")
    message = message.replace("--background-color <COLOR>", "background")
    message = message.replace("--resolution <W,H>", "width, height")
    return re.sub(r"--([a-z]+(?:-[a-z]+)*)(?: <[^>]*>)?", lambda m: m[1].replace("-", "_"), message)
